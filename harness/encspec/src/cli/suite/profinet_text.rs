//! The text of the `device.yaml` of a device on PROFINET.

use super::fields::{NamedField, NewStartField, named};
use super::names::{comment, quoted};
use super::profinet::{NewModule, NewSubmodule, Writer};
use description::gsdml::{AccessPoint, DataItem, DataType, Gsdml, GsdmlRecord, ItemAccess, RecordItem};
use std::fmt::Write as _;

impl Writer<'_> {
    pub fn text(
        &mut self,
        gsdml: &Gsdml,
        point: &AccessPoint,
        variant: &str,
        network: &[(u16, u32)],
        folder: &str,
        has_im1: bool,
    ) -> String {
        let (records, tables) = self.records();
        let mut out = String::new();
        // Writing into a String cannot fail.
        let _ = writeln!(
            out,
            "# {} {}, as its GSDML describes it (written by `encspec suite init`). `Decide` marks what a person has to decide.\n\
             device: {folder}\nbus: profinet\ntitle: {}\nidentity:\n  vendor_id: {{ value: 0x{:04X}, from_source: description }}\n  \
             device_id: {{ value: 0x{:04X}, from_source: description }}",
            comment(&gsdml.vendor),
            comment(&point.info.name),
            quoted(&format!("{} {}", gsdml.vendor, point.info.name)),
            gsdml.vendor_id,
            gsdml.device_id,
        );
        let _ = writeln!(
            out,
            "  # Decide: no GSDML has the type of station that DCP shows; write it as the device reports it.\n  \
             station_type: {{ value: {}, from_source: invented }}",
            quoted(&point.info.name)
        );
        let others: Vec<String> =
            gsdml.access_points.iter().filter(|of| of.id != point.id).map(|of| of.id.clone()).collect();
        if !others.is_empty() {
            let _ = writeln!(
                out,
                "# Decide: the GSDML has other access points ({}); `--access-point ID` writes a suite for one of them.",
                comment(&others.join(", "))
            );
        }
        let _ = writeln!(out, "variants: [{variant}]");
        out.push_str(TIMES);
        let _ = writeln!(out, "constants:\n  vendor: 0x{:04X}", gsdml.vendor_id);
        if !tables.is_empty() {
            let _ = writeln!(out, "words:\n{tables}");
        }
        let _ = write!(out, "\n{SIGNALS}{}", self.signals.text());
        if !network.is_empty() {
            let list: Vec<String> =
                network.iter().map(|(subslot, ident)| format!("0x{subslot:04X}: 0x{ident:08X}")).collect();
            let _ = writeln!(out, "\nnetwork: {{ {} }}   # the interface and the ports", list.join(", "));
        }
        if point.has_snmp() {
            out.push_str("\nsnmp: true\n");
        }
        if point.has_hello() {
            out.push_str("\nhello: true\n");
        }
        out.push_str("\nsubmodules:\n");
        self.submodules.iter().for_each(|of| out.push_str(&submodule(of)));
        out.push_str("\n# Decide: each is what one connection consists of.\nmodules:\n");
        for NewModule { name, ident, submodules } in &self.modules {
            let names: Vec<&str> =
                submodules.iter().filter_map(|&at| self.submodules.get(at)).map(|of| of.name.as_str()).collect();
            let names = if names.is_empty() { "dap".to_owned() } else { names.join(", ") };
            let _ =
                writeln!(out, "  {name}: {{ ident: 0x{ident:X}, submodules: [{names}], from_source: description }}");
        }
        let _ = write!(out, "\nrecords:\n{records}{}", IM0);
        if has_im1 {
            out.push_str(IM1);
        }
        if self.submodules.iter().any(|of| of.of.api == 0x3D00) {
            out.push_str(PARAMETERS);
        }
        out.push_str(if has_im1 { CHANGES_IM1 } else { CHANGES });
        out
    }

    /// The records that are written at start-up, and the tables of their words.
    fn records(&mut self) -> (String, String) {
        let (mut out, mut tables) = (String::new(), String::new());
        for index in 0..self.submodules.len() {
            let of = self.submodules[index].of;
            let mut records: Vec<&GsdmlRecord> = of.records.iter().filter(|record| record.octets > 0).collect();
            records.sort_by_key(|record| record.transfer_sequence);
            for record in records {
                let name = self.names.new_name(&format!("record_{:04x}", record.index), "record");
                let defaults = [record.default.clone()];
                let fields: Vec<NewStartField> = record.items.iter().map(start_field).collect();
                let fields = named(&fields, &defaults, &mut self.names);
                let with: Vec<&str> = self
                    .modules
                    .iter()
                    .filter(|module| module.submodules.contains(&index))
                    .map(|module| module.name.as_str())
                    .collect();
                let is_in_all = with.len() == self.modules.len() || self.submodules[index].slot == 0;
                // Writing into a String cannot fail.
                let _ = writeln!(
                    out,
                    "  {name}:                       # {}\n    index: 0x{:04X}\n    at: {}\n    octets: {}\n    start: true",
                    comment(&record.name),
                    record.index,
                    self.submodules[index].name,
                    record.octets
                );
                if !is_in_all {
                    let _ = writeln!(out, "    with: [{}]", with.join(", "));
                }
                out.push_str("    fields:\n");
                let fields = if fields.is_empty() {
                    named(&[NewStartField::unused()], &defaults, &mut self.names)
                } else {
                    fields
                };
                for field in &fields {
                    let _ = writeln!(out, "      {}", field.line(&record.default));
                }
                for table in fields.iter().filter_map(NamedField::table) {
                    let _ = writeln!(tables, "  {table}");
                }
            }
        }
        (out, tables)
    }
}

fn start_field(item: &RecordItem) -> NewStartField {
    let kind = &item.kind;
    let octets = match (item.bits, kind) {
        (Some(bits), _) => usize::try_from((bits.low + bits.width).div_ceil(8)).unwrap_or(1),
        (None, DataType::Whole { octets, .. } | DataType::Float(octets)) => usize::from(*octets),
        (None, _) => item.octets,
    };
    let bits = item.bits.map(|bits| (bits.low, bits.width)).filter(|(low, width)| low + width <= 8);
    let is_fixed = item.access != ItemAccess::Changeable;
    let range = match item.allowed.as_slice() {
        [only] if !is_fixed && *only.start() >= 0 => Some((*only.start(), *only.end())),
        _ => None,
    };
    NewStartField { called: item.name.clone(), octet: item.octet, octets, bits, range, words: item.words.clone() }
}

fn submodule(of: &NewSubmodule<'_>) -> String {
    let mut parts = vec![format!("slot: {}", of.slot), format!("subslot: 0x{:X}", of.subslot)];
    if of.of.api > 0 {
        parts.push(format!("api: 0x{:X}", of.of.api));
    }
    parts.push(format!("ident: 0x{:X}", of.of.ident));
    parts.extend(of.module_ident.map(|ident| format!("module_ident: 0x{ident:X}")));
    let sum = |items: &[DataItem]| items.iter().filter_map(|item| item.octets).map(u32::from).sum::<u32>();
    let (output, input) = (sum(&of.of.outputs), sum(&of.of.inputs));
    if output + input > 0 {
        parts.push(format!("octets: {{ out: {output}, in: {input} }}"));
    }
    for (key, list) in [("outputs", &of.outputs), ("inputs", &of.inputs)] {
        if !list.is_empty() {
            parts.push(format!("{key}: [{}]", list.join(", ")));
        }
    }
    format!("  {}:\n    {}\n    from_source: description\n", of.name, parts.join("\n    "))
}

const TIMES: &str = "\
# Decide: how soon the device has to react, to be ready after power-on, and to have stored what it keeps. Without a manual these are ours.
timing: { reaction: 200ms, start: 10s, power_up: 10s, save: 5s }
";

const SIGNALS: &str = "\
# Decide: which of these are positions (`position_in: RANGE`), which have a sign, and what their bits mean. Then `roles: { position: [..] }`
# opens the common suites about positions.
";

const IM0: &str =
    "  im0:                                       # with the block header in front, as in the read response
    index: 0xAFF0
    at: dap
    octets: 60
    fields:
      block_type:    { octets: [0, 1] }
      block_length:  { octets: [2, 3] }
      block_version: { octets: [4, 5] }
      vendor_id:     { octets: [6, 7] }
";

const IM1: &str = "  im1:
    index: 0xAFF1
    at: dap
    octets: 60
    fields:
      block_type:    { octets: [0, 1], default: 0x0021 }
      block_length:  { octets: [2, 3], default: 0x0038 }
      block_version: { octets: [4, 5], default: 0x0100 }
";

const PARAMETERS: &str = "
# Decide: a submodule has the API of PROFIdrive (0x3D00). If the device has parameters, name the submodule that gives access to them,
# and the parameters of its manual; `parameter-access` and `parameter-requests` are the common suites about them.
# parameter_access: { at: SUBMODULE }
# parameters:
#   P922: { type: u16, access: read }
";

const CHANGES: &str = "
# Decide: what changes the device for good, so that a run on a live device needs a consent for it.
# changes: { position_reference: [SIGNAL.FIELD], nvm_write: [SIGNAL.FIELD] }
";

const CHANGES_IM1: &str = "
# Decide: what else changes the device for good, so that a run on a live device needs a consent for it.
changes: { nvm_write: [im1] }
";
