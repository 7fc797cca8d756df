//! The user parameters of the encoder profile in a record of a GSDML, and the other records of its start-up.
//!
//! Source: encoder profile 3.162, user parameter data in record 0xBF00.

use super::model::{DataType, GsdmlRecord, ItemAccess, RecordItem};
use super::parameters::parameter;
use crate::start_parameters::{DescribedParameter, ParameterDoubt, find};
use crate::value_texts::{Meaning, meaning};
use plain_text::hex;
use std::fmt::Write;
use suite::device::{Origin, RecordField};

/// Index of the record with the user parameters.
const INDEX: u32 = 0xBF00;

/// Whether a record has the user parameters of the profile.
pub(super) fn is_it(record: &GsdmlRecord) -> bool {
    record.index == INDEX
}

/// A user parameter of the profile.
struct ProfileParameter {
    name: &'static str,
    /// Its names in descriptions.
    called: &'static [&'static str],
    octet: usize,
    octets: usize,
    bit: Option<u32>,
    /// Its words, by the table of `device.yaml`.
    words: Option<(&'static str, &'static [(&'static str, i128)])>,
    /// The word that the suite uses unless a case says another one.
    usual: Option<&'static str>,
}

const SWITCH: (&str, &[(&str, i128)]) = ("switch", &[("disabled", 0), ("enabled", 1)]);
const INVERTED: (&str, &[(&str, i128)]) = ("inverted_switch", &[("enabled", 0), ("disabled", 1)]);
const DIRECTION: (&str, &[(&str, i128)]) = ("direction", &[("clockwise", 0), ("counterclockwise", 1)]);
const UNITS: (&str, &[(&str, i128)]) =
    ("speed_unit", &[("steps_per_second", 0), ("steps_per_100ms", 1), ("steps_per_10ms", 2), ("rpm", 3)]);

const fn bit(
    name: &'static str,
    called: &'static [&'static str],
    bit: u32,
    words: (&'static str, &'static [(&'static str, i128)]),
    usual: &'static str,
) -> ProfileParameter {
    ProfileParameter { name, called, octet: 0, octets: 1, bit: Some(bit), words: Some(words), usual: Some(usual) }
}

const fn number(name: &'static str, called: &'static [&'static str], octet: usize, octets: usize) -> ProfileParameter {
    ProfileParameter { name, called, octet, octets, bit: None, words: None, usual: None }
}

/// Index of the steps per revolution in [`PARAMETERS`].
const STEPS: usize = 6;
/// Index of the total range in [`PARAMETERS`].
const RANGE: usize = 7;

const PARAMETERS: [ProfileParameter; 10] = [
    bit("code_sequence", &["Code sequence", "Counting direction", "Rotational direction"], 0, DIRECTION, "clockwise"),
    bit("class_4", &["Class 4 functionality", "Class 4"], 1, SWITCH, "enabled"),
    bit("g1_xist1_preset_control", &["G1_XIST1 preset control", "Preset affects XIST1"], 2, INVERTED, "enabled"),
    bit("scaling", &["Scaling function control", "Scaling function"], 3, SWITCH, "disabled"),
    // Some encoders refuse another value than their own.
    ProfileParameter {
        usual: None,
        ..bit("alarm_channel", &["Alarm channel control", "Alarm channel"], 4, SWITCH, "")
    },
    bit("compatibility", &["Compatibility mode", "Compatibility mode V3.1"], 5, INVERTED, "disabled"),
    number("units_per_revolution", &["Measuring units per revolution", "Measuring units / revolution"], 1, 8),
    number("total_range", &["Total measuring range", "Total measuring range in measuring units"], 9, 8),
    number(
        "life_sign_failures",
        &[
            "Tolerated failures of the controller sign of life",
            "Maximum master sign-of-life failures",
            "Tolerated sign-of-life faults",
        ],
        17,
        1,
    ),
    ProfileParameter {
        name: "speed_unit",
        called: &["Unit of the velocity", "Velocity measuring units", "Velocity measuring unit"],
        octet: 18,
        octets: 1,
        bit: None,
        words: Some(UNITS),
        usual: Some("steps_per_second"),
    },
];

impl ProfileParameter {
    /// The same as a field of a record.
    fn field(&self) -> RecordField {
        let words = self.words.map_or(&[][..], |(_, words)| words);
        RecordField {
            name: self.name.to_owned(),
            octet: self.octet,
            octets: self.octets,
            bits: self.bit.map(|bit| (bit, 1)),
            words: words.iter().map(|(word, number)| ((*word).to_owned(), *number)).collect(),
            table: None,
            default: Vec::new(),
            range: (None, None),
            text: false,
            called: self.called.iter().map(|name| (*name).to_owned()).collect(),
            origin: Origin::Manual,
            absent: None,
            settable: None,
        }
    }
}

/// A user parameter of the profile as the GSDML has it.
struct DescribedUserParameter {
    of: &'static ProfileParameter,
    /// Its item and the place of it; `None` if the record does not have it.
    item: Option<(RecordItem, DescribedParameter)>,
    /// Its words where the texts of the GSDML say other numbers than the profile.
    words: Option<Vec<(String, i128)>>,
}

/// All user parameters of the profile.
pub(super) struct UserParameters(Vec<DescribedUserParameter>);

impl UserParameters {
    /// Finds the parameters in a record by what they mean, and those without a known name by the place that the profile gives them.
    pub(super) fn of(record: Option<&GsdmlRecord>) -> UserParameters {
        let items = record.map_or(&[][..], |record| &record.items);
        let described: Vec<DescribedParameter> = items.iter().map(parameter).collect();
        let fields: Vec<RecordField> = PARAMETERS.iter().map(ProfileParameter::field).collect();
        let matches = find(&fields, &described, &[]);
        let taken: Vec<usize> = matches.iter().filter_map(|of| of.described).collect();
        let found = PARAMETERS.iter().zip(&fields).zip(&matches).map(|((of, field), found)| {
            let at_place = || {
                let is_there = |known: &DescribedParameter| {
                    (known.octet, known.bits.map(|bits| bits.0)) == (of.octet, of.bit)
                        && known.width() == field.bits.map_or(of.octets as u32 * 8, |(_, width)| width)
                };
                described.iter().enumerate().position(|(index, known)| !taken.contains(&index) && is_there(known))
            };
            let at = found.described.or_else(at_place);
            let words = match &found.doubt {
                Some(ParameterDoubt::OtherMeaning { .. }) => at.and_then(|at| own_words(&described[at], &field.words)),
                _ => None,
            };
            DescribedUserParameter { of, item: at.map(|at| (items[at].clone(), described[at].clone())), words }
        });
        UserParameters(found.collect())
    }

    /// Steps per revolution and range of the hardware: the highest numbers that the GSDML allows.
    pub(super) fn highest(&self) -> (i128, i128) {
        let highest = |index: usize| self.0.get(index)?.settable().map(|(_, highest)| highest);
        let steps = highest(STEPS).unwrap_or(8192);
        (steps, highest(RANGE).unwrap_or(steps))
    }

    /// The tables of words.
    pub(super) fn words(&self) -> String {
        let mut text = "words:\n  preset_mode: { absolute: 0, relative: 1 }\n".to_owned();
        for (name, words) in [SWITCH, INVERTED, DIRECTION, UNITS] {
            let words: Vec<String> = words.iter().map(|(word, number)| format!("{word}: {number}")).collect();
            // Writing into a String cannot fail.
            let _ = writeln!(text, "  {name}: {{ {} }}", words.join(", "));
        }
        for of in &self.0 {
            let Some(words) = &of.words else { continue };
            let words: Vec<String> = words.iter().map(|(word, number)| format!("{word}: {number}")).collect();
            let _ = writeln!(text, "  words_of_{}: {{ {} }}", of.of.name, words.join(", "));
        }
        text
    }

    /// The record with its fields.
    pub(super) fn record(&self, record: Option<&GsdmlRecord>, (steps, range): (i128, i128)) -> String {
        let (octets, template) = record.map_or((31, String::new()), |of| (of.octets, hex(&of.default)));
        let template = if template.is_empty() { String::new() } else { format!("    template: \"{template}\"\n") };
        let mut text = format!(
            "  bf00:\n    index: 0x{INDEX:X}\n    at: parameter_access_point\n    octets: {octets}\n    start: true\n{template}    \
             fields:\n"
        );
        for (index, of) in self.0.iter().enumerate() {
            let wished = match index {
                STEPS => steps.to_string(),
                RANGE => range.to_string(),
                _ => of.usual(),
            };
            let _ = writeln!(text, "      {}: {{ {} }}", of.of.name, of.field(&wished));
        }
        text
    }
}

/// The words of a parameter whose texts stand for other numbers than in the profile.
fn own_words(described: &DescribedParameter, words: &[(String, i128)]) -> Option<Vec<(String, i128)>> {
    let word = |(number, texts): &(i128, Vec<String>)| {
        texts.iter().find_map(|text| match meaning(text, words) {
            Meaning::One(word) => Some((word, *number)),
            Meaning::Unknown => None,
        })
    };
    let own: Vec<(String, i128)> = described.words.iter().filter_map(word).collect();
    (own.len() == words.len()).then_some(own)
}

impl DescribedUserParameter {
    /// The lowest and the highest number that users can set.
    fn settable(&self) -> Option<(i128, i128)> {
        let (item, place) = self.item.as_ref()?;
        match (item.access, item.default) {
            (ItemAccess::Changeable, _) | (_, None) => place.range,
            (_, Some(only)) => Some((only, only)),
        }
    }

    /// The words in use.
    fn words(&self) -> Vec<(String, i128)> {
        let of_profile = self.of.words.iter().flat_map(|(_, words)| *words);
        let of_profile = || of_profile.map(|(word, number)| ((*word).to_owned(), *number)).collect();
        self.words.clone().unwrap_or_else(of_profile)
    }

    /// The value that the suite uses by default: the usual one, or that of the GSDML where it does not allow the usual one.
    fn usual(&self) -> String {
        let words = self.words();
        let word_of = |number: i128| words.iter().find(|(_, known)| *known == number).map(|(word, _)| word.clone());
        let default = self.item.as_ref().and_then(|(item, _)| item.default);
        let Some(usual) = self.of.usual else {
            let number = default.unwrap_or(i128::from(self.of.words.is_none()));
            return word_of(number).unwrap_or_else(|| number.to_string());
        };
        let number = words.iter().find(|(word, _)| word == usual).map(|(_, number)| *number);
        let allows = |number: i128| self.settable().is_none_or(|(low, high)| (low..=high).contains(&number));
        match (number, default) {
            (Some(number), _) if allows(number) => usual.to_owned(),
            (_, Some(default)) => word_of(default).unwrap_or_else(|| usual.to_owned()),
            _ => usual.to_owned(),
        }
    }

    /// Its keys in `device.yaml`.
    fn field(&self, default: &str) -> String {
        let mut keys = Vec::new();
        let place = self.item.as_ref().map(|(_, place)| place);
        let (octet, octets) = place.map_or((self.of.octet, self.of.octets), |of| (of.octet, of.octets.max(1)));
        let bits = place.map_or(self.of.bit.map(|bit| (bit, 1)), |of| of.bits);
        keys.push(match octets {
            1 => format!("octet: {octet}"),
            _ => format!("octets: [{octet}, {}]", octet + octets - 1),
        });
        match bits {
            Some((low, 1)) => keys.push(format!("bit: {low}")),
            Some((low, width)) => keys.push(format!("bits: [{low}, {}]", low + width - 1)),
            None => {}
        }
        match (&self.words, self.of.words) {
            (Some(_), _) => keys.push(format!("words: words_of_{}", self.of.name)),
            (None, Some((table, _))) => keys.push(format!("words: {table}")),
            (None, None) => {}
        }
        keys.push(format!("default: {default}"));
        match (&self.item, self.settable()) {
            (None, _) => keys.push("absent: \"its GSDML has no parameter with this meaning\"".to_owned()),
            (Some(_), Some((low, high))) if low >= 0 => keys.push(format!("settable: [{low}, {high}]")),
            _ => {}
        }
        keys.join(", ")
    }
}

/// Another record of the start-up: its bytes as the GSDML has them, and its numbers by their places.
pub(super) fn of_the_vendor(index: usize, record: &GsdmlRecord, default: &str) -> String {
    let mut text = format!(
        "  vendor_record_{index}:\n    index: 0x{:X}\n    at: parameter_access_point\n    octets: {}\n    start: true\n    \
         from_source: description\n    template: \"{default}\"\n",
        record.index, record.octets
    );
    let mut fields = String::new();
    for (number, item) in record.items.iter().enumerate() {
        let place = parameter(item);
        let is_number = matches!(item.kind, DataType::Whole { .. } | DataType::Bit | DataType::BitArea);
        let Some(default) = item.default.filter(|default| is_number && *default >= 0) else { continue };
        let at = match place.octets {
            0 | 1 => format!("octet: {}", place.octet),
            octets => format!("octets: [{}, {}]", place.octet, place.octet + octets - 1),
        };
        let bits = match place.bits {
            Some((low, width)) if place.octets <= 1 => format!(", bits: [{low}, {}]", low + width - 1),
            Some(_) => continue,
            None => String::new(),
        };
        // Writing into a String cannot fail.
        let _ = writeln!(fields, "      vendor_{index}_{number}: {{ {at}{bits}, default: {default} }}");
    }
    text.push_str(&if fields.is_empty() { "    fields: {}\n".to_owned() } else { format!("    fields:\n{fields}") });
    text
}

/// The record I&M0 as read, with the block header in front: IEC 61158-6-10.
pub(super) const IM0: &str = "  im0:
    index: 0xAFF0
    at: parameter_access_point
    octets: 60
    fields:
      vendor_id: { octets: [6, 7] }
";
