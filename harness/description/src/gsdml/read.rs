//! Reads a GSDML file into [`Gsdml`]. Unknown elements and attributes are ignored; an error in a part of it becomes a remark.

use super::model::{AccessPoint, Gsdml, GsdmlModule, GsdmlSubmodule, ModuleInfo, PluggableItem, SubmoduleKind};
use super::xml::{GsdmlDocument, below, child, children, numeral, value};
use encoding_rs::Encoding;
use roxmltree::{Document, Node, ParsingOptions};
use std::ops::RangeInclusive;

/// The bytes in which an XML declaration ends.
const LONGEST_DECLARATION: usize = 512;
/// Upper limit of the elements and attributes of a file.
const MOST_NODES: u32 = 4_000_000;

/// Why a file cannot be read as a GSDML, with the position.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("line {line}, column {column}: {message}")]
pub struct GsdmlError {
    /// Line, from 1.
    pub line: u32,
    /// Column, from 1.
    pub column: u32,
    /// What is wrong and what to do.
    pub message: String,
}

/// Reads the bytes of a GSDML file in the encoding of its byte order mark or XML declaration; UTF-8 without either.
///
/// # Errors
///
/// Those of [`read`], an unknown encoding, and bytes that are not text in their encoding, with their position.
pub fn read_octets(octets: &[u8]) -> Result<Gsdml, GsdmlError> {
    let encoding = match Encoding::for_bom(octets) {
        Some((encoding, _)) => encoding,
        None => declared_encoding(octets)?,
    };
    let (text, _, is_damaged) = encoding.decode(octets);
    if !is_damaged {
        return read(&text);
    }
    let good = text.split(char::REPLACEMENT_CHARACTER).next().unwrap_or_default();
    let line = good.matches('\n').count() as u32 + 1;
    let column = good.rsplit('\n').next().unwrap_or_default().chars().count() as u32 + 1;
    let name = encoding.name();
    let message = format!("not {name}: correct the encoding in the first line of the file, or save it as UTF-8");
    Err(GsdmlError { line, column, message })
}

/// The encoding in the XML declaration, which is readable as ASCII; UTF-8 if there is none.
fn declared_encoding(octets: &[u8]) -> Result<&'static Encoding, GsdmlError> {
    let head = String::from_utf8_lossy(octets.get(..octets.len().min(LONGEST_DECLARATION)).unwrap_or_default());
    let declaration = head.trim_start().strip_prefix("<?xml").and_then(|rest| rest.split("?>").next());
    let named = declaration.and_then(|text| text.split_once("encoding")?.1.split(['"', '\'']).nth(1));
    let Some(name) = named else { return Ok(encoding_rs::UTF_8) };
    let unknown = || {
        let message = format!("the encoding `{}` is unknown; save the file as UTF-8", name.escape_debug());
        GsdmlError { line: 1, column: 1, message }
    };
    // A file that says UTF-16 and is readable as ASCII is not in UTF-16.
    let encoding = Encoding::for_label(name.trim().as_bytes()).ok_or_else(unknown)?;
    Ok(if encoding.is_ascii_compatible() { encoding } else { encoding_rs::UTF_8 })
}

/// Reads the text of a GSDML file.
///
/// # Errors
///
/// The text is not well-formed XML, or it has no identity of the device or no access point; with the position.
pub fn read(text: &str) -> Result<Gsdml, GsdmlError> {
    let options = ParsingOptions { nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|error| malformed(text, &error))?;
    let page = GsdmlDocument::new(&document);
    let root = document.root_element();
    let missing = |node: Node<'_, '_>, what: &str| {
        let (line, column) = page.place(node);
        GsdmlError { line, column, message: format!("{what}; check that this is the vendor's GSDML file") }
    };
    let body = child(root, "ProfileBody").ok_or_else(|| missing(root, "`ProfileBody` is missing"))?;
    let identity = child(body, "DeviceIdentity").ok_or_else(|| missing(body, "`DeviceIdentity` is missing"))?;
    let id = |name: &str| {
        let number = identity.attribute(name).and_then(numeral::<u16>);
        number.ok_or_else(|| missing(identity, &format!("`{name}` is not a 16-bit number")))
    };
    let family = below(body, &["DeviceFunction", "Family"]).first().copied();
    let family_word = |name| family.and_then(|node| node.attribute(name)).unwrap_or_default().to_owned();
    let mut gsdml = Gsdml {
        version: version(root),
        vendor_id: id("VendorID")?,
        device_id: id("DeviceID")?,
        vendor: value(identity, "VendorName"),
        family: (family_word("MainFamily"), family_word("ProductFamily")),
        ..Gsdml::default()
    };
    let process = child(body, "ApplicationProcess").ok_or_else(|| missing(body, "`ApplicationProcess` is missing"))?;
    let subs = ["SubmoduleItem", "PortSubmoduleItem"].map(|name| below(process, &["SubmoduleList", name])).concat();
    let subs: Vec<Node<'_, '_>> = in_order(subs);
    gsdml.submodules = subs.iter().filter_map(|node| submodule(&page, *node, SubmoduleKind::Pluggable)).collect();
    let modules = below(process, &["ModuleList", "ModuleItem"]);
    gsdml.modules = modules.iter().filter_map(|node| module(&page, *node, &gsdml.submodules)).collect();
    let points = below(process, &["DeviceAccessPointList", "DeviceAccessPointItem"]);
    gsdml.access_points = points.iter().filter_map(|node| access_point(&page, *node, &gsdml)).collect();
    if gsdml.access_points.is_empty() {
        return Err(missing(process, "there is no device access point with an ident number"));
    }
    gsdml.remarks = page.remarks();
    Ok(gsdml)
}

fn malformed(text: &str, error: &roxmltree::Error) -> GsdmlError {
    use roxmltree::Error as Xml;
    let at = error.pos();
    let (mut line, mut column) = (at.row, at.col);
    if matches!(error, Xml::UnclosedRootNode | Xml::UnexpectedEndOfStream | Xml::NoRootNode) {
        line = text.lines().count().max(1) as u32;
        column = text.lines().last().unwrap_or_default().chars().count() as u32 + 1;
    }
    let said = error.to_string();
    let said = said.strip_suffix(&format!(" at {at}")).unwrap_or(&said);
    GsdmlError { line, column, message: format!("not well-formed XML: {said}; use the vendor's original file") }
}

/// The version of the schema, from the location of the schema.
fn version(root: Node<'_, '_>) -> String {
    let named = root.attributes().find(|of| of.name() == "schemaLocation").map_or("", |of| of.value());
    let Some((_, after)) = named.rsplit_once("-V") else { return String::new() };
    after.chars().take_while(|c| c.is_ascii_digit() || *c == '.').collect::<String>().trim_matches('.').to_owned()
}

fn in_order<'d>(mut nodes: Vec<Node<'d, 'd>>) -> Vec<Node<'d, 'd>> {
    nodes.sort_by_key(|node| node.range().start);
    nodes
}

fn id(node: Node<'_, '_>) -> String {
    node.attribute("ID").unwrap_or_default().to_owned()
}

fn info<'d>(page: &GsdmlDocument<'d>, node: Node<'d, 'd>) -> ModuleInfo {
    let Some(info) = child(node, "ModuleInfo") else {
        return ModuleInfo { name: page.text(node), ..ModuleInfo::default() };
    };
    ModuleInfo {
        name: page.name(info),
        order_number: value(info, "OrderNumber"),
        hardware: value(info, "HardwareRelease"),
        software: value(info, "SoftwareRelease"),
    }
}

fn submodule<'d>(page: &GsdmlDocument<'d>, node: Node<'d, 'd>, kind: SubmoduleKind) -> Option<GsdmlSubmodule> {
    let one = |subslot: u16| vec![subslot..=subslot];
    let numbered = |default: u16| one(page.number(node, "SubslotNumber").unwrap_or(default));
    let subslots = match kind {
        SubmoduleKind::Virtual if node.attribute("FixedInSubslots").is_none() => one(1),
        SubmoduleKind::Virtual => page.ranges(node, "FixedInSubslots"),
        SubmoduleKind::Interface => numbered(0x8000),
        SubmoduleKind::Port => numbered(0x8001),
        SubmoduleKind::Pluggable => Vec::new(),
    };
    let (inputs, outputs) = super::data::cyclic(page, node);
    Some(GsdmlSubmodule {
        id: id(node),
        kind,
        info: info(page, node),
        ident: page.ident(node, "SubmoduleIdentNumber")?,
        api: page.number(node, "API").unwrap_or_default(),
        subslots,
        inputs,
        outputs,
        records: super::data::records(page, node),
        writable_im: page.ranges::<u16>(node, "Writeable_IM_Records").into_iter().flatten().take(16).collect(),
        failsafe: page.flag(node, "PROFIsafeSupported").unwrap_or_default(),
    })
}

/// The built-in submodules of a module.
fn built_in<'d>(page: &GsdmlDocument<'d>, node: Node<'d, 'd>) -> Vec<GsdmlSubmodule> {
    const LISTS: [(&str, &str, SubmoduleKind); 3] = [
        ("VirtualSubmoduleList", "VirtualSubmoduleItem", SubmoduleKind::Virtual),
        ("SystemDefinedSubmoduleList", "InterfaceSubmoduleItem", SubmoduleKind::Interface),
        ("SystemDefinedSubmoduleList", "PortSubmoduleItem", SubmoduleKind::Port),
    ];
    let of_list = |(list, item, kind)| below(node, &[list, item]).into_iter().map(move |node| (node, kind));
    LISTS.into_iter().flat_map(of_list).filter_map(|(node, kind)| submodule(page, node, kind)).collect()
}

/// The modules or submodules to which the `item` elements of `list` refer, with their slots (`Slots`) or subslots (`Subslots`).
fn offered<'d>(
    page: &GsdmlDocument<'d>,
    node: Node<'d, 'd>,
    (list, item, target): (&'static str, &'static str, &str),
    kind: &str,
    known: &dyn Fn(&str) -> Option<usize>,
    all: &[RangeInclusive<u16>],
) -> Vec<PluggableItem> {
    let mut offers = Vec::new();
    for node in below(node, &[list, item]) {
        let Some(index) = node.attribute(target).and_then(known) else {
            page.remark(node, &format!("`{target}` names nothing in this file; the element is ignored"));
            continue;
        };
        let read = |how: &str| page.ranges::<u16>(node, &format!("{how}In{kind}"));
        let (fixed, used) = (read("Fixed"), read("Used"));
        let mut places = read("Allowed");
        places.extend(fixed.iter().chain(&used).cloned());
        if places.is_empty() {
            places = all.to_vec();
        }
        offers.push(PluggableItem { index, places, fixed, used });
    }
    offers
}

fn pluggable<'d>(page: &GsdmlDocument<'d>, node: Node<'d, 'd>, submodules: &[GsdmlSubmodule]) -> Vec<PluggableItem> {
    let known = |id: &str| submodules.iter().position(|of| of.id == id);
    let all = page.ranges(node, "PhysicalSubslots");
    offered(page, node, ("UseableSubmodules", "SubmoduleItemRef", "SubmoduleItemTarget"), "Subslots", &known, &all)
}

fn module<'d>(page: &GsdmlDocument<'d>, node: Node<'d, 'd>, submodules: &[GsdmlSubmodule]) -> Option<GsdmlModule> {
    Some(GsdmlModule {
        id: id(node),
        info: info(page, node),
        ident: page.ident(node, "ModuleIdentNumber")?,
        submodules: built_in(page, node),
        pluggable: pluggable(page, node, submodules),
    })
}

fn access_point<'d>(page: &GsdmlDocument<'d>, node: Node<'d, 'd>, gsdml: &Gsdml) -> Option<AccessPoint> {
    let slots = page.ranges(node, "PhysicalSlots");
    let known = |id: &str| gsdml.modules.iter().position(|of| of.id == id);
    let fixed = page.ranges::<u16>(node, "FixedInSlots");
    let lengths = child(node, "IOConfigData");
    let length = |name: &str| lengths.and_then(|node| page.number(node, name)).unwrap_or_default();
    Some(AccessPoint {
        id: id(node),
        info: info(page, node),
        ident: page.ident(node, "ModuleIdentNumber")?,
        slot: fixed.first().map_or(0, |range| *range.start()),
        submodules: built_in(page, node),
        modules: offered(page, node, ("UseableModules", "ModuleItemRef", "ModuleItemTarget"), "Slots", &known, &slots),
        pluggable: pluggable(page, node, &gsdml.submodules),
        slots,
        min_device_interval: page.number(node, "MinDeviceInterval").unwrap_or_default(),
        max_input: length("MaxInputLength"),
        max_output: length("MaxOutputLength"),
        features: features(node),
    })
}

/// Attributes that have their own fields or say nothing about the device.
const KEPT_ELSEWHERE: [&str; 10] = [
    "ID",
    "TextId",
    "ModuleIdentNumber",
    "FixedInSlots",
    "PhysicalSlots",
    "MinDeviceInterval",
    "MaxInputLength",
    "MaxOutputLength",
    "SubmoduleIdentNumber",
    "SubslotNumber",
];

/// All attributes of an access point, its interface and its connections, known or not.
fn features(node: Node<'_, '_>) -> Vec<(String, String)> {
    let mut nodes = vec![node];
    let named = |node: &Node<'_, '_>, names: &[&str]| node.is_element() && names.contains(&node.tag_name().name());
    nodes.extend(
        node.children().filter(|node| named(node, &["CertificationInfo", "IOConfigData", "ApplicationRelations"])),
    );
    for list in children(node, "SystemDefinedSubmoduleList") {
        nodes.extend(children(list, "InterfaceSubmoduleItem").flat_map(|node| {
            let inside = node.descendants().skip(1).filter(Node::is_element);
            std::iter::once(node).chain(inside.filter(|node| {
                node.tag_name().name().ends_with("Properties") || node.tag_name().name() == "ApplicationRelations"
            }))
        }));
    }
    let attributes = nodes.iter().flat_map(|node| node.attributes());
    attributes
        .filter(|of| !KEPT_ELSEWHERE.contains(&of.name()))
        .map(|of| (of.name().to_owned(), of.value().trim().to_owned()))
        .collect()
}
