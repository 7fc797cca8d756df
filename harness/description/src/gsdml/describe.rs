//! The description of an encoder without a manual, made of its GSDML: the parts of `device.yaml` that differ between encoders of the
//! PROFIdrive encoder profile.
//!
//! The modules with the standard telegrams are found by their numbers and lengths, the user parameters by what they mean. Source:
//! encoder profile for PROFIBUS and PROFINET, 3.162, for telegrams and user parameters.

use super::encoder_record::{self, UserParameters};
use super::matching::lengths;
use super::model::{AccessPoint, Gsdml, GsdmlModule, GsdmlRecord, GsdmlSubmodule, SubmoduleKind};
use super::names::same_numbers;
use plain_text::hex;
use std::fmt::Write;
use std::ops::RangeInclusive;

/// The API of PROFIdrive.
const API: u32 = 0x3D00;

/// A standard telegram of the encoder profile.
struct StandardTelegram {
    number: u16,
    /// Bytes from the controller and from the encoder.
    octets: (u16, u16),
    outputs: &'static str,
    inputs: &'static str,
}

const TELEGRAMS: [StandardTelegram; 6] = [
    telegram(81, (4, 12), "STW2_ENC, G1_STW", "ZSW2_ENC, G1_ZSW, G1_XIST1, G1_XIST2"),
    telegram(82, (4, 14), "STW2_ENC, G1_STW", "ZSW2_ENC, G1_ZSW, G1_XIST1, G1_XIST2, NIST_A"),
    telegram(83, (4, 16), "STW2_ENC, G1_STW", "ZSW2_ENC, G1_ZSW, G1_XIST1, G1_XIST2, NIST_B"),
    telegram(84, (4, 20), "STW2_ENC, G1_STW", "ZSW2_ENC, G1_ZSW, G1_XIST3, G1_XIST2, NIST_B"),
    telegram(86, (6, 10), "STW2_ENC, G1_XIST_PRESET_B", "ZSW2_ENC, G1_XIST1, NIST_B"),
    telegram(88, (10, 14), "STW2_ENC, G1_XIST_PRESET_C", "ZSW2_ENC, G1_XIST3, NIST_B"),
];

const fn telegram(number: u16, octets: (u16, u16), outputs: &'static str, inputs: &'static str) -> StandardTelegram {
    StandardTelegram { number, octets, outputs, inputs }
}

/// What P979, the sensor format, says of an encoder; a GSDML does not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SensorFormat {
    /// By how many bits G1_XIST1 is shifted to the left.
    pub shift: u32,
    /// Steps per revolution; 0 if unknown.
    pub steps: u32,
    /// Revolutions of the range; 0 if unknown.
    pub revolutions: u32,
}

impl SensorFormat {
    /// Steps per revolution and range of the hardware; where P979 does not say them, the highest numbers that the GSDML allows.
    fn hardware(self, (steps, range): (i128, i128)) -> (i128, i128) {
        match self {
            SensorFormat { steps: 0, .. } => (steps, range),
            SensorFormat { steps, revolutions, .. } => {
                (steps.into(), i128::from(steps) * i128::from(revolutions.max(1)))
            }
        }
    }
}

/// An encoder as its GSDML describes it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DescribedEncoder {
    /// Sections of `device.yaml`: the key, and the text with its key.
    sections: Vec<(&'static str, String)>,
    /// The standard telegrams that it has.
    pub telegrams: Vec<u16>,
}

/// Why a GSDML describes no encoder of the profile.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DescribeEncoderError {
    /// No module has a standard telegram in the API of PROFIdrive.
    #[error("no module of the GSDML has one of the standard telegrams 81, 82, 83, 84, 86 or 88 in API 0x3D00")]
    NoTelegram,
    /// The presets of the suite are beyond the range.
    #[error("the encoder has {0} positions, and the suite needs at least {LEAST_RANGE}")]
    SmallRange(i128),
}

/// The presets of the suite are below this number.
const LEAST_RANGE: i128 = 8192;

/// A telegram in its module.
struct FoundTelegram<'g> {
    telegram: &'static StandardTelegram,
    module: &'g GsdmlModule,
    slot: u16,
    subslot: u16,
    submodule: &'g GsdmlSubmodule,
    /// All other submodules that the module always has, with their subslots.
    others: Vec<(u16, &'g GsdmlSubmodule)>,
}

impl<'g> FoundTelegram<'g> {
    /// The submodule that parameters and user parameters go to, with its subslot.
    fn access_point(&self) -> (u16, &'g GsdmlSubmodule) {
        let own = (self.subslot, self.submodule);
        let all = || self.others.iter().copied().chain([own]).filter(|(_, of)| of.api == API);
        let user_parameters = |(_, of): &(u16, &GsdmlSubmodule)| of.records.iter().any(encoder_record::is_it);
        let empty = |(_, of): &(u16, &GsdmlSubmodule)| of.inputs.is_empty() && of.outputs.is_empty();
        all().find(user_parameters).or_else(|| all().find(empty)).unwrap_or(own)
    }

    /// What has to be the same for two telegrams of one description.
    fn place_of_parameters(&self) -> (u16, u16, u32, u32) {
        let (subslot, of) = self.access_point();
        (self.slot, subslot, of.ident, of.api)
    }
}

/// Describes an encoder by its GSDML and what its P979 says.
pub fn describe(gsdml: &Gsdml, format: SensorFormat) -> Result<DescribedEncoder, DescribeEncoderError> {
    let of_point = |point: &'_ AccessPoint| TELEGRAMS.iter().any(|telegram| find(gsdml, point, telegram).is_some());
    let point = gsdml.access_points.iter().find(|point| of_point(point)).ok_or(DescribeEncoderError::NoTelegram)?;
    let mut found: Vec<FoundTelegram<'_>> =
        TELEGRAMS.iter().filter_map(|telegram| find(gsdml, point, telegram)).collect();
    let place = found.first().map(FoundTelegram::place_of_parameters);
    found.retain(|of| Some(of.place_of_parameters()) == place);
    let first = found.first().ok_or(DescribeEncoderError::NoTelegram)?;
    let (_, access_point) = first.access_point();
    let record = access_point.records.iter().find(|record| encoder_record::is_it(record));
    let parameters = UserParameters::of(record);
    let hardware = format.hardware(parameters.highest());
    if hardware.1 < LEAST_RANGE {
        return Err(DescribeEncoderError::SmallRange(hardware.1));
    }
    let sections = vec![
        ("title", format!("title: \"{}\"\n", plain(&point.info.name))),
        ("identity", identity(gsdml, point)),
        ("constants", constants(gsdml, hardware)),
        ("words", parameters.words()),
        ("network", network(point)),
        ("submodules", submodules(point, &found)),
        ("modules", modules(&found)),
        ("records", records(record, &parameters, hardware, access_point)),
        ("  G1_XIST1", position(format.shift)),
    ];
    Ok(DescribedEncoder { sections, telegrams: found.iter().map(|of| of.telegram.number).collect() })
}

impl DescribedEncoder {
    /// The `device.yaml` of the encoder: `base`, that of the suite for any encoder, with the sections of this one.
    pub fn text(&self, base: &str) -> String {
        let mut text = String::new();
        // The indentation of the key whose section is replaced, while its lines are skipped.
        let mut skipped: Option<usize> = None;
        for line in base.split_inclusive('\n') {
            let indent = line.len() - line.trim_start_matches(' ').len();
            if skipped.is_some_and(|of| indent > of) {
                continue;
            }
            skipped = None;
            let key = line.split(':').next().unwrap_or_default();
            match self.sections.iter().find(|(known, _)| *known == key) {
                Some((_, own)) => {
                    text.push_str(own);
                    skipped = Some(indent);
                }
                None => text.push_str(line),
            }
        }
        text
    }
}

/// The module with a telegram that has the fewest other submodules.
fn find<'g>(
    gsdml: &'g Gsdml,
    point: &'g AccessPoint,
    telegram: &'static StandardTelegram,
) -> Option<FoundTelegram<'g>> {
    let in_modules = point.modules.iter().filter_map(|item| {
        let module = gsdml.modules.get(item.index)?;
        let slot = first_of(&[&item.fixed, &item.used, &item.places])?;
        let pluggable = module.pluggable.iter().filter_map(|of| {
            let submodule = gsdml.submodules.get(of.index)?;
            Some((first_of(&[&of.fixed, &of.used, &of.places])?, submodule, !of.fixed.is_empty()))
        });
        let built_in = module.submodules.iter().filter_map(|of| Some((first_of(&[&of.subslots])?, of, true)));
        let all: Vec<(u16, &GsdmlSubmodule, bool)> = built_in.chain(pluggable).collect();
        let (subslot, submodule, _) = *all.iter().find(|(_, of, _)| is_telegram(of, module, telegram))?;
        let others = all.iter().filter(|(_, of, always)| *always && !std::ptr::eq(*of, submodule));
        let others = others.map(|(subslot, of, _)| (*subslot, *of)).collect();
        Some(FoundTelegram { telegram, module, slot, subslot, submodule, others })
    });
    in_modules.min_by_key(|found| found.others.len())
}

fn first_of(places: &[&Vec<RangeInclusive<u16>>]) -> Option<u16> {
    places.iter().find_map(|ranges| ranges.first()).map(|range| *range.start())
}

/// Whether a submodule has this telegram: its lengths, and its number in a name of it or of its module.
fn is_telegram(submodule: &GsdmlSubmodule, module: &GsdmlModule, telegram: &StandardTelegram) -> bool {
    let name = telegram.number.to_string();
    let own = [submodule.id.as_str(), submodule.info.name.as_str()];
    let of_module = [module.id.as_str(), module.info.name.as_str()];
    let is_numbered =
        same_numbers(&name, &own) || submodule.ident == u32::from(telegram.number) || same_numbers(&name, &of_module);
    submodule.api == API && lengths(submodule) == (Some(telegram.octets.1), Some(telegram.octets.0)) && is_numbered
}

fn identity(gsdml: &Gsdml, point: &AccessPoint) -> String {
    format!(
        "identity:\n  vendor_id: 0x{:04X}\n  device_id: {{ value: 0x{:04X}, from_source: description }}\n  station_type: {{ value: \"{}\", from_source: invented }}\n",
        gsdml.vendor_id,
        gsdml.device_id,
        plain(&point.info.name)
    )
}

fn constants(gsdml: &Gsdml, (steps, range): (i128, i128)) -> String {
    format!("constants:\n  vendor: 0x{:04X}\n  hardware_steps: {steps}\n  hardware_range: {range}\n", gsdml.vendor_id)
}

fn network(point: &AccessPoint) -> String {
    let of_network = |of: &&GsdmlSubmodule| matches!(of.kind, SubmoduleKind::Interface | SubmoduleKind::Port);
    let entry = |of: &GsdmlSubmodule| Some(format!("0x{:04X}: 0x{:08X}", first_of(&[&of.subslots])?, of.ident));
    let entries: Vec<String> = point.submodules.iter().filter(of_network).filter_map(entry).collect();
    format!("network: {{ {} }}\n", entries.join(", "))
}

/// The name of a submodule that is neither a telegram nor the access point of the parameters.
fn other_name(subslot: u16, of: &GsdmlSubmodule) -> String {
    format!("other_{subslot}_{:x}", of.ident)
}

fn submodules(point: &AccessPoint, found: &[FoundTelegram<'_>]) -> String {
    let mut text = "submodules:\n".to_owned();
    let built_in = point.submodules.iter().filter(|of| of.kind == SubmoduleKind::Virtual);
    for (index, of) in built_in.enumerate() {
        let name = if index == 0 { "dap".to_owned() } else { format!("dap_{index}") };
        let subslot = first_of(&[&of.subslots]).unwrap_or(1);
        // Writing into a String cannot fail.
        let _ = writeln!(
            text,
            "  {name}: {{ slot: {}, subslot: {subslot}, api: 0x{:X}, ident: 0x{:X}, module_ident: 0x{:X}, \
             from_source: description }}",
            point.slot, of.api, of.ident, point.ident
        );
    }
    let Some(first) = found.first() else { return text };
    let (parameter_subslot, parameter_point) = first.access_point();
    if !found.iter().any(|of| of.subslot == parameter_subslot) {
        let _ = writeln!(
            text,
            "  parameter_access_point: {{ slot: {}, subslot: {parameter_subslot}, api: 0x{API:X}, ident: 0x{:X}, \
             from_source: description }}",
            first.slot, parameter_point.ident
        );
    }
    let mut named: Vec<String> = Vec::new();
    for (subslot, of) in found.iter().flat_map(|of| &of.others) {
        let name = other_name(*subslot, of);
        if *subslot == parameter_subslot || named.contains(&name) {
            continue;
        }
        let (inputs, outputs) = lengths(of);
        let _ = writeln!(
            text,
            "  {name}: {{ slot: {}, subslot: {subslot}, api: 0x{:X}, ident: 0x{:X}, octets: {{ out: {}, in: {} }}, \
             from_source: description }}",
            first.slot,
            of.api,
            of.ident,
            outputs.unwrap_or_default(),
            inputs.unwrap_or_default()
        );
        named.push(name);
    }
    for telegram in &TELEGRAMS {
        let own = found.iter().find(|of| of.telegram.number == telegram.number);
        let (slot, subslot, ident, source) = match own {
            Some(of) => (of.slot, of.subslot, of.submodule.ident, "description"),
            None => (first.slot, first.subslot, u32::from(telegram.number), "invented"),
        };
        let StandardTelegram { number, octets: (out, inward), outputs, inputs } = telegram;
        let _ = writeln!(
            text,
            "  telegram_{number}: {{ slot: {slot}, subslot: {subslot}, api: 0x{API:X}, ident: 0x{ident:X}, octets: {{ out: {out}, \
             in: {inward} }}, outputs: [{outputs}], inputs: [{inputs}], from_source: {source} }}"
        );
    }
    text
}

fn modules(found: &[FoundTelegram<'_>]) -> String {
    let mut text = "modules:\n".to_owned();
    let Some(first) = found.first() else { return text };
    let (parameter_subslot, _) = first.access_point();
    for telegram in &TELEGRAMS {
        let own = found.iter().find(|of| of.telegram.number == telegram.number);
        let of = own.unwrap_or(first);
        let others = of.others.iter().map(|(subslot, of)| match *subslot == parameter_subslot {
            true => "parameter_access_point".to_owned(),
            false => other_name(*subslot, of),
        });
        let number = telegram.number;
        let list: Vec<String> = others.chain([format!("telegram_{number}")]).collect();
        let (ident, rest) = match own {
            Some(of) => (of.module.ident, "from_source: description".to_owned()),
            None => (0, format!("from_source: invented, absent: \"its GSDML has no telegram {number}\"")),
        };
        let list = list.join(", ");
        let _ = writeln!(text, "  telegram_{number}: {{ ident: 0x{ident:X}, submodules: [{list}], {rest} }}");
    }
    text
}

fn records(
    record: Option<&GsdmlRecord>,
    parameters: &UserParameters,
    hardware: (i128, i128),
    at: &GsdmlSubmodule,
) -> String {
    let mut text = "records:\n".to_owned();
    text.push_str(&parameters.record(record, hardware));
    let others = at.records.iter().filter(|of| !record.is_some_and(|record| std::ptr::eq(*of, record)));
    for (index, of) in others.enumerate() {
        text.push_str(&encoder_record::of_the_vendor(index, of, &hex(&of.default)));
    }
    text.push_str(encoder_record::IM0);
    text
}

fn position(shift: u32) -> String {
    let shift = if shift == 0 { String::new() } else { format!("shift: {shift}, ") };
    format!("  G1_XIST1: {{ from: device, width: 32, {shift}position_in: position_range }}\n")
}

/// A name of a vendor without what YAML would read as something else.
fn plain(name: &str) -> String {
    let is_plain = |letter: &char| (letter.is_ascii_graphic() || *letter == ' ') && !"\"\\".contains(*letter);
    name.chars().filter(is_plain).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const BASE: &str = "device: profidrive-encoder\ntitle: any\nsignals:\n  A: { width: 16,\n       more: 1 }\n  \
        G1_XIST1: { from: device }\n  G1_XIST2: { from: device }\nmodules:\n  old: { ident: 1 }\n# a remark\nroles: { x: [y] }\n";

    #[test]
    fn sections_replace_those_of_the_suite() {
        let described = DescribedEncoder {
            sections: vec![
                ("title", "title: \"E\"\n".into()),
                ("modules", "modules:\n  new: { ident: 2 }\n".into()),
                ("  G1_XIST1", position(14)),
            ],
            telegrams: vec![81],
        };
        assert_eq!(
            described.text(BASE),
            "device: profidrive-encoder\ntitle: \"E\"\nsignals:\n  A: { width: 16,\n       more: 1 }\n  \
             G1_XIST1: { from: device, width: 32, shift: 14, position_in: position_range }\n  G1_XIST2: { from: device }\n\
             modules:\n  new: { ident: 2 }\n# a remark\nroles: { x: [y] }\n"
        );
    }

    #[test]
    fn a_device_without_a_telegram_is_no_encoder() {
        assert_eq!(describe(&Gsdml::default(), SensorFormat::default()), Err(DescribeEncoderError::NoTelegram));
    }
}
