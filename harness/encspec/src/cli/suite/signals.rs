//! Signals of the cyclic data, made of the items of a description.

use super::names::{FreshNames, comment};
use std::fmt::Write as _;

/// How the bytes of an item are a value.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum ItemForm {
    #[default]
    Number,
    Float,
    Text,
}

/// What an item of the cyclic data is.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct CyclicItem {
    /// Its name in the description.
    pub called: String,
    /// The number of its bytes.
    pub octets: u16,
    pub signed: bool,
    pub form: ItemForm,
    /// Its named bits, 0 is the lowest.
    pub bits: Vec<(u16, String)>,
    /// What a person has to know of it.
    pub remark: Option<String>,
}

/// A signal of the suite.
#[derive(Clone, Debug, PartialEq, Eq)]
struct NewSignal {
    name: String,
    is_output: bool,
    item: CyclicItem,
}

/// The signals of a device; modules with the same items share them.
#[derive(Debug, Default)]
pub(super) struct Signals(Vec<NewSignal>);

impl Signals {
    /// The names of the signals for items in their order.
    pub fn of(&mut self, items: &[CyclicItem], is_output: bool, names: &mut FreshNames) -> Vec<String> {
        let mut list: Vec<String> = Vec::new();
        for item in items.iter().flat_map(|item| parts(item, is_output)) {
            let is_same =
                |known: &&NewSignal| known.is_output == is_output && known.item == item && !list.contains(&known.name);
            let name = match self.0.iter().find(is_same) {
                Some(known) => known.name.clone(),
                None => {
                    let name = names.new_name(&item.called, if is_output { "output" } else { "input" });
                    self.0.push(NewSignal { name: name.clone(), is_output, item });
                    name
                }
            };
            list.push(name);
        }
        list
    }

    /// `signals` of a device.yaml.
    pub fn text(&self) -> String {
        if self.0.is_empty() {
            return "signals: {}\n".to_owned();
        }
        let mut out = "signals:\n".to_owned();
        for NewSignal { name, is_output, item } in &self.0 {
            let from = if *is_output { "controller" } else { "device" };
            let signed = if item.signed { ", signed: true" } else { "" };
            let fields = fields(item);
            let fields = if fields.is_empty() { fields } else { format!(", fields: {{ {fields} }}") };
            let remark = item.remark.as_ref().map_or_else(String::new, |remark| format!("   # {}", comment(remark)));
            // Writing into a String cannot fail.
            let size = match item.form {
                ItemForm::Number => format!("width: {}", item.octets * 8),
                ItemForm::Float => format!("width: {}, float: true", item.octets * 8),
                ItemForm::Text => format!("text: {}", item.octets),
            };
            let _ = writeln!(out, "  {name}: {{ from: {from}, {size}{signed}{fields} }}{remark}");
        }
        out
    }
}

/// The item, or its bytes as numbers of 1, 2, 4 or 8 bytes where a suite has no signal for it: texts of the controller and what is longer.
fn parts(item: &CyclicItem, is_output: bool) -> Vec<CyclicItem> {
    let is_whole = match item.form {
        ItemForm::Number | ItemForm::Float => [1, 2, 4, 8].contains(&item.octets),
        ItemForm::Text => !is_output && (1..=255).contains(&item.octets),
    };
    if is_whole {
        return vec![item.clone()];
    }
    let mut left = item.octets;
    let mut parts = Vec::new();
    while left > 0 {
        let octets = [8, 4, 2, 1].into_iter().find(|octets| *octets <= left).unwrap_or(1);
        let called = format!("{} part {}", item.called, parts.len() + 1);
        let remark = Some(format!("a part of the {} bytes of `{}`", item.octets, item.called));
        parts.push(CyclicItem { called, octets, signed: false, form: ItemForm::Number, bits: Vec::new(), remark });
        left -= octets;
    }
    parts
}

fn fields(item: &CyclicItem) -> String {
    let mut names = FreshNames::default();
    let mut seen: Vec<u16> = Vec::new();
    let mut list: Vec<String> = Vec::new();
    for (bit, called) in &item.bits {
        if *bit < item.octets * 8 && !seen.contains(bit) {
            seen.push(*bit);
            list.push(format!("{}: {bit}", names.new_name(called, "bit")));
        }
    }
    list.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_of_any_length_become_numbers_and_are_shared() {
        let of = |called: &str, octets, bits: &[(u16, &str)]| CyclicItem {
            called: called.to_owned(),
            octets,
            signed: false,
            form: ItemForm::Number,
            bits: bits.iter().map(|(bit, name)| (*bit, (*name).to_owned())).collect(),
            remark: None,
        };
        let (mut signals, mut names) = (Signals::default(), FreshNames::default());
        let status = of("Status word", 2, &[(15, "Error"), (15, "again"), (99, "beyond")]);
        let first = signals.of(&[status.clone(), of("Data", 7, &[])], false, &mut names);
        assert_eq!(first, ["status_word", "data_part_1", "data_part_2", "data_part_3"]);
        assert_eq!(signals.of(&[status.clone(), status], false, &mut names), ["status_word", "status_word_2"]);
        let lines = signals.text();
        assert!(
            lines.starts_with("signals:\n  status_word: { from: device, width: 16, fields: { error: 15 } }\n"),
            "{lines}"
        );
        assert!(
            lines.contains("  data_part_1: { from: device, width: 32 }   # a part of the 7 bytes of `Data`\n"),
            "{lines}"
        );
        assert!(lines.contains("  data_part_3: { from: device, width: 8 }"), "{lines}");
    }
}
