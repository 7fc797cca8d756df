//! Finds the start parameters of a manual in a vendor's description by what they mean: name, size, range, and the texts of their values.
//!
//! A place proves nothing: where two parameters changed places, the device would be configured wrongly and then accused. So a parameter
//! that cannot be found by its meaning is reported with the reason, and a person decides (`start_parameters` in a bench file).

use crate::value_texts::{Meaning, meaning, plain_words};
use std::fmt;
use suite::device::RecordField;

/// A start parameter of a description.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DescribedParameter {
    /// Its name, in each language of the file; the primary language comes first.
    pub names: Vec<String>,
    /// The offset of its first byte.
    pub octet: usize,
    /// The number of bytes in which its bits lie.
    pub octets: usize,
    /// The lowest bit and the number of bits; `None` for whole bytes.
    pub bits: Option<(u32, u32)>,
    /// The lowest and the highest allowed number, if limited.
    pub range: Option<(i128, i128)>,
    /// Its numbers, each with its text in each language.
    pub words: Vec<(i128, Vec<String>)>,
}

impl DescribedParameter {
    /// The name in the primary language.
    pub fn name(&self) -> &str {
        self.names.first().map_or("", String::as_str)
    }

    /// The place of a field of the manual.
    pub(crate) fn at(field: &RecordField) -> DescribedParameter {
        DescribedParameter {
            octet: field.octet,
            octets: field.octets,
            bits: field.bits,
            ..DescribedParameter::default()
        }
    }

    /// Its place in words.
    pub(crate) fn place(&self) -> String {
        match (self.bits, self.octets) {
            (Some((low, 1)), _) => format!("byte {}, bit {low}", self.octet),
            (Some((low, width)), _) => format!("byte {}, bits {low} to {}", self.octet, low + width - 1),
            (None, 0 | 1) => format!("byte {}", self.octet),
            (None, octets) => format!("bytes {} to {}", self.octet, self.octet + octets - 1),
        }
    }

    /// The number of bits.
    pub(crate) fn width(&self) -> u32 {
        self.bits.map_or(self.octets as u32 * 8, |(_, width)| width)
    }
}

/// Why a parameter of the manual is not taken from a description.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ParameterDoubt {
    /// No parameter has a name that means it.
    NotFound,
    /// Several parameters could be it; their names.
    Several(Vec<String>),
    /// It has another number of bits.
    Width { manual: u32, described: u32 },
    /// A text stands for another number than in the manual.
    OtherMeaning { number: i128, text: String, manual: i128 },
    /// None of its texts is known.
    UnknownTexts(Vec<String>),
    /// Its range is another, which may mean another unit.
    OtherRange { manual: (i128, i128), described: (i128, i128) },
}

impl fmt::Display for ParameterDoubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ParameterDoubt::NotFound => f.write_str("no parameter has a name that means it"),
            ParameterDoubt::Several(names) => write!(f, "several parameters may be it: {}", quoted(names)),
            ParameterDoubt::Width { manual, described } => {
                write!(f, "it has {described} bits, and {manual} in the manual")
            }
            ParameterDoubt::OtherMeaning { number, text, manual } => {
                write!(f, "`{}` is {number}, and {manual} in the manual", text.escape_debug())
            }
            ParameterDoubt::UnknownTexts(texts) => write!(f, "the texts of its values are unknown: {}", quoted(texts)),
            ParameterDoubt::OtherRange { manual: (low, high), described: (first, last) } => {
                write!(f, "it allows {first} to {last}, and {low} to {high} in the manual; check the unit")
            }
        }
    }
}

fn quoted(texts: &[String]) -> String {
    texts.iter().map(|text| format!("`{}`", text.escape_debug())).collect::<Vec<_>>().join(", ")
}

/// A parameter of the manual, and what was found for it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParameterMatch {
    /// The index of the manual's field.
    pub field: usize,
    /// The index of the parameter of the description, if one was found, even in doubt.
    pub described: Option<usize>,
    /// Why it is not used.
    pub doubt: Option<ParameterDoubt>,
}

/// Finds each field of a record of the manual among the parameters of a description; no parameter is used twice.
///
/// `confirmed` has pairs of a field and a name in the description on which a person decided. A name decides which parameter it is, also
/// one whose range or texts are unknown, but not that a known text stands for another number than in the manual.
pub fn find(
    fields: &[RecordField],
    described: &[DescribedParameter],
    confirmed: &[(String, String)],
) -> Vec<ParameterMatch> {
    let mut found: Vec<Option<usize>> = vec![None; fields.len()];
    let mut is_confirmed = vec![false; fields.len()];
    for (index, field) in fields.iter().enumerate() {
        let said = confirmed.iter().find(|(name, _)| *name == field.name);
        let at = said.and_then(|(_, said)| described.iter().position(|of| of.names.contains(said)));
        (found[index], is_confirmed[index]) = (at, at.is_some());
    }
    // The same name first, then names that contain all words; what is found leaves fewer candidates for the rest.
    for names in [NameMatch::Same, NameMatch::Contained] {
        loop {
            let before = found.clone();
            for (index, field) in fields.iter().enumerate() {
                if found[index].is_none()
                    && let [only] = candidates(field, described, &found, names)[..]
                {
                    found[index] = Some(only);
                }
            }
            if before == found {
                break;
            }
        }
    }
    let matched = fields.iter().enumerate().map(|(index, field)| {
        let at = found[index];
        let doubt = match at {
            Some(at) => doubt(field, &described[at], is_confirmed[index]),
            None => Some(not_found(field, described, &found)),
        };
        ParameterMatch { field: index, described: at, doubt }
    });
    matched.collect()
}

/// How a name of the manual has to fit a name of the description.
#[derive(Clone, Copy, PartialEq, Eq)]
enum NameMatch {
    /// Word for word.
    Same,
    /// All words of the manual's name, and none that turns the meaning.
    Contained,
}

/// The indices of the free parameters whose name fits.
fn candidates(
    field: &RecordField,
    described: &[DescribedParameter],
    taken: &[Option<usize>],
    how: NameMatch,
) -> Vec<usize> {
    let own: Vec<Vec<String>> = [&field.name].into_iter().chain(&field.called).map(|name| plain_words(name)).collect();
    let fits = |name: &String| {
        let words = plain_words(name);
        own.iter().any(|own| match how {
            NameMatch::Same => *own == words,
            NameMatch::Contained => {
                own.iter().all(|word| words.contains(word))
                    && words.iter().all(|word| own.contains(word) || !TURNS.contains(&word.as_str()))
            }
        })
    };
    let free = (0..described.len()).filter(|at| !taken.contains(&Some(*at)));
    free.filter(|at| described[*at].names.iter().any(fits)).collect()
}

/// Words that turn the meaning of a name, or give it a unit.
const TURNS: [&str; 26] = [
    "not",
    "no",
    "non",
    "inverse",
    "inverted",
    "invert",
    "negated",
    "disable",
    "disabled",
    "off",
    "without",
    "nicht",
    "invertiert",
    "s",
    "ms",
    "us",
    "\u{b5}s",
    "ns",
    "min",
    "seconds",
    "milliseconds",
    "microseconds",
    "bits",
    "percent",
    "deg",
    "degrees",
];

fn not_found(field: &RecordField, described: &[DescribedParameter], taken: &[Option<usize>]) -> ParameterDoubt {
    let names = |found: Vec<usize>| found.into_iter().map(|at| described[at].name().to_owned()).collect::<Vec<_>>();
    let several = names(candidates(field, described, taken, NameMatch::Contained));
    if several.is_empty() { ParameterDoubt::NotFound } else { ParameterDoubt::Several(several) }
}

/// Why a parameter with the right name is not the one of the manual.
fn doubt(field: &RecordField, described: &DescribedParameter, is_confirmed: bool) -> Option<ParameterDoubt> {
    let width = DescribedParameter::at(field).width();
    if described.width() != width {
        return Some(ParameterDoubt::Width { manual: width, described: described.width() });
    }
    let mut known = 0;
    for (number, texts) in described.words.iter().filter(|_| !field.words.is_empty()) {
        for text in texts {
            let Meaning::One(word) = meaning(text, &field.words) else { continue };
            known += 1;
            let manual = field.words.iter().find(|(name, _)| *name == word).map_or(*number, |(_, number)| *number);
            if manual != *number {
                return Some(ParameterDoubt::OtherMeaning { number: *number, text: text.clone(), manual });
            }
        }
    }
    if is_confirmed {
        return None;
    }
    if known == 0 && !field.words.is_empty() && !described.words.is_empty() {
        let texts = described.words.iter().filter_map(|(_, texts)| texts.first().cloned());
        return Some(ParameterDoubt::UnknownTexts(texts.collect()));
    }
    match (field.range, described.range) {
        ((Some(low), Some(high)), Some(range)) if field.words.is_empty() && range != (low, high) => {
            Some(ParameterDoubt::OtherRange { manual: (low, high), described: range })
        }
        _ => None,
    }
}
