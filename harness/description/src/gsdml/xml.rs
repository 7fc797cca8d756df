//! The XML tree for reading a GSDML: elements by their local names, numbers, lists of ranges, texts by id.
//!
//! An error in a single attribute is noted as a remark and reading continues.

use super::model::DataType;
use roxmltree::{Document, Node};
use rustc_hash::FxHashMap;
use std::cell::RefCell;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// Upper limit of the ranges in a list.
const MOST_RANGES: usize = 4096;

/// A file that is being read.
pub(super) struct GsdmlDocument<'d> {
    document: &'d Document<'d>,
    remarks: RefCell<Vec<String>>,
    texts: FxHashMap<&'d str, &'d str>,
    /// The texts in the other languages.
    translations: FxHashMap<&'d str, Vec<&'d str>>,
    values: FxHashMap<&'d str, Node<'d, 'd>>,
}

/// The child elements with this name, in any namespace.
pub(super) fn children<'d>(node: Node<'d, 'd>, name: &'static str) -> impl Iterator<Item = Node<'d, 'd>> {
    node.children().filter(move |child| child.is_element() && child.tag_name().name() == name)
}

/// The first child element with this name.
pub(super) fn child<'d>(node: Node<'d, 'd>, name: &'static str) -> Option<Node<'d, 'd>> {
    children(node, name).next()
}

/// The elements at the end of a path of names.
pub(super) fn below<'d>(node: Node<'d, 'd>, path: &[&'static str]) -> Vec<Node<'d, 'd>> {
    path.iter().fold(vec![node], |nodes, name| nodes.into_iter().flat_map(|node| children(node, name)).collect())
}

/// The attribute `Value` of the first child element with this name; empty if there is none.
pub(super) fn value(node: Node<'_, '_>, name: &'static str) -> String {
    let found = node.children().find(|child| child.tag_name().name() == name);
    found.and_then(|child| child.attribute("Value")).unwrap_or_default().trim().to_owned()
}

/// A number in a GSDML: decimal, or hexadecimal after `0x`.
pub(super) fn numeral<T: TryFrom<i128>>(text: &str) -> Option<T> {
    let text = text.trim();
    let number = match text.strip_prefix("0x").or_else(|| text.strip_prefix("0X")) {
        Some(digits) if digits.starts_with(['+', '-']) => None,
        Some(digits) => i128::from_str_radix(digits, 16).ok(),
        None => i128::from_str(text).ok(),
    };
    T::try_from(number?).ok()
}

impl<'d> GsdmlDocument<'d> {
    /// Indexes the texts and value items of the document.
    pub(super) fn new(document: &'d Document<'d>) -> GsdmlDocument<'d> {
        let mut page = GsdmlDocument {
            document,
            remarks: RefCell::default(),
            texts: FxHashMap::default(),
            translations: FxHashMap::default(),
            values: FxHashMap::default(),
        };
        for node in document.root().descendants().filter(Node::is_element) {
            match node.tag_name().name() {
                "PrimaryLanguage" => {
                    for text in children(node, "Text") {
                        if let (Some(id), Some(value)) = (text.attribute("TextId"), text.attribute("Value")) {
                            page.texts.insert(id, value);
                        }
                    }
                }
                "Language" => {
                    for text in children(node, "Text") {
                        if let (Some(id), Some(value)) = (text.attribute("TextId"), text.attribute("Value")) {
                            page.translations.entry(id).or_default().push(value);
                        }
                    }
                }
                "ValueItem" => {
                    if let Some(id) = node.attribute("ID") {
                        page.values.insert(id, node);
                    }
                }
                _ => {}
            }
        }
        page
    }

    /// Line and column of an element.
    pub(super) fn place(&self, node: Node<'_, '_>) -> (u32, u32) {
        let at = self.document.text_pos_at(node.range().start);
        (at.row, at.col)
    }

    /// Notes an error in an element.
    pub(super) fn remark(&self, node: Node<'_, '_>, what: &str) {
        let (line, column) = self.place(node);
        let name = node.tag_name().name();
        self.remarks.borrow_mut().push(format!("line {line}, column {column}: {name}: {what}"));
    }

    /// All remarks, in the order of the file.
    pub(super) fn remarks(self) -> Vec<String> {
        self.remarks.into_inner()
    }

    /// A number in an attribute; an unreadable one is noted and counts as missing.
    pub(super) fn number<T: TryFrom<i128>>(&self, node: Node<'_, '_>, name: &str) -> Option<T> {
        let text = node.attribute(name)?;
        let number = numeral(text);
        if number.is_none() {
            self.remark(node, &format!("`{name}=\"{text}\"` is not a valid number here; it is ignored"));
        }
        number
    }

    /// The ident number in a required attribute; if it is missing, this is noted.
    pub(super) fn ident(&self, node: Node<'_, '_>, name: &str) -> Option<u32> {
        if node.attribute(name).is_none() {
            self.remark(node, &format!("`{name}` is missing; the element is ignored"));
        }
        self.number(node, name)
    }

    /// A flag; `None` if it is missing.
    pub(super) fn flag(&self, node: Node<'_, '_>, name: &str) -> Option<bool> {
        match node.attribute(name).map(str::trim)? {
            "true" | "1" => Some(true),
            "false" | "0" => Some(false),
            other => {
                self.remark(node, &format!("`{name}=\"{other}\"` is neither true nor false; it is ignored"));
                None
            }
        }
    }

    /// Numbers and ranges (`1 3..5`) in an attribute; unreadable ones are noted and ignored.
    pub(super) fn ranges<T>(&self, node: Node<'_, '_>, name: &str) -> Vec<RangeInclusive<T>>
    where
        T: TryFrom<i128> + PartialOrd + Copy,
    {
        let mut ranges = Vec::new();
        for part in node.attribute(name).unwrap_or_default().split_whitespace() {
            let (low, high) = part.split_once("..").unwrap_or((part, part));
            match (numeral::<T>(low), numeral::<T>(high)) {
                (Some(low), Some(high)) if low <= high && ranges.len() < MOST_RANGES => ranges.push(low..=high),
                _ => self.remark(node, &format!("`{part}` in `{name}` is not a valid range here; it is ignored")),
            }
        }
        ranges
    }

    /// The text with the id in `TextId`; the id itself if there is no such text.
    pub(super) fn text(&self, node: Node<'_, '_>) -> String {
        let Some(id) = node.attribute("TextId") else { return String::new() };
        match self.texts.get(id) {
            Some(text) => text.trim().to_owned(),
            None => {
                self.remark(node, &format!("there is no text `{id}` in the primary language"));
                id.to_owned()
            }
        }
    }

    /// The same text in the other languages of the file.
    pub(super) fn translations(&self, node: Node<'_, '_>) -> Vec<String> {
        let known = node.attribute("TextId").and_then(|id| self.translations.get(id));
        known.map_or_else(Vec::new, |texts| texts.iter().map(|text| text.trim().to_owned()).collect())
    }

    /// The name of an element: its child `Name`, else its own `TextId`.
    pub(super) fn name(&self, node: Node<'d, 'd>) -> String {
        self.text(child(node, "Name").unwrap_or(node))
    }

    /// The names for numbers in a value item.
    pub(super) fn words(&self, node: Node<'_, '_>) -> Vec<(i128, String)> {
        if let Some(id) = node.attribute("ValueItemTarget").filter(|id| !self.values.contains_key(id)) {
            self.remark(node, &format!("there is no value item `{id}`"));
        }
        let assigned = self.assignments(node).into_iter();
        assigned.filter_map(|node| Some((self.number(node, "Content")?, self.text(node)))).collect()
    }

    /// The names for numbers in a value item in the other languages.
    pub(super) fn translated_words(&self, node: Node<'_, '_>) -> Vec<(i128, String)> {
        let each = self.assignments(node).into_iter().flat_map(|node| {
            let number = node.attribute("Content").and_then(numeral::<i128>);
            self.translations(node).into_iter().filter_map(move |text| Some((number?, text)))
        });
        each.collect()
    }

    /// The elements of the value item of an element that give a number its text.
    fn assignments(&self, node: Node<'_, '_>) -> Vec<Node<'d, 'd>> {
        let item = node.attribute("ValueItemTarget").and_then(|id| self.values.get(id));
        item.map_or_else(Vec::new, |item| below(*item, &["Assignments", "Assign"]))
    }

    /// Bytes as `0x00,0x01`; an unreadable one is noted and ends them.
    pub(super) fn octets(&self, node: Node<'_, '_>, name: &str) -> Vec<u8> {
        let mut octets = Vec::new();
        for part in node.attribute(name).unwrap_or_default().split(',').filter(|part| !part.trim().is_empty()) {
            match numeral::<u8>(part) {
                Some(octet) => octets.push(octet),
                None => {
                    self.remark(
                        node,
                        &format!("`{part}` in `{name}` is not a byte; it and the following ones are ignored"),
                    );
                    break;
                }
            }
        }
        octets
    }
}

/// A data type, and its number of bytes if its name or `Length` gives it.
pub(super) fn data_type(name: &str, length: Option<u16>) -> (DataType, Option<u16>) {
    let whole = |octets, signed| (DataType::Whole { octets, signed }, Some(octets));
    let other = |octets| (DataType::Other(name.to_owned()), octets);
    match name {
        "Bit" | "Boolean" => (DataType::Bit, Some(1)),
        "BitArea" => (DataType::BitArea, None),
        "Unsigned8" => whole(1, false),
        "Unsigned16" => whole(2, false),
        "Unsigned32" => whole(4, false),
        "Unsigned64" => whole(8, false),
        "Integer8" => whole(1, true),
        "Integer16" => whole(2, true),
        "Integer32" => whole(4, true),
        "Integer64" => whole(8, true),
        "Float32" => (DataType::Float(4), Some(4)),
        "Float64" => (DataType::Float(8), Some(8)),
        "OctetString" | "VisibleString" | "UnicodeString8" | "61131_STRING" | "61131_WSTRING" => {
            (DataType::Octets, length)
        }
        "N2" | "V2" | "L2" | "R2" | "T2" | "D2" | "E2" | "X2" | "Unsigned8+Unsigned8" | "Unipolar2.16" => {
            other(Some(2))
        }
        "N4" | "T4" | "C4" | "X4" | "F_MessageTrailer4Byte" => other(Some(4)),
        "TimeOfDay without date indication" | "TimeDifference without date indication" => other(Some(4)),
        "Float32+Unsigned8" | "Float32+Status8" | "F_MessageTrailer5Byte" => other(Some(5)),
        "TimeOfDay with date indication" | "TimeDifference with date indication" => other(Some(6)),
        "Date" => other(Some(7)),
        "NetworkTime" | "NetworkTimeDifference" | "TimeStampDifferenceShort" => other(Some(8)),
        "TimeStamp" | "TimeStampDifference" => other(Some(12)),
        _ => other(length),
    }
}
