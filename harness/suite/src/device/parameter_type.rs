//! Parameter types as named in `device.yaml`.

use serde::{Deserialize, Serialize};

/// PROFIdrive format codes. The alias keeps serde's derive from treating the slice as borrowed from the input.
pub type Formats = &'static [u8];

/// The type of the elements of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize)]
pub struct ParameterType {
    /// Width in bits: 8, 16, 32 or 64.
    pub width: u32,
    /// Whether it is in two's complement.
    pub signed: bool,
    /// Whether the elements are characters of a text.
    pub text: bool,
    /// For byte strings and texts, which are one value: length in bytes, 0 if the manual does not print it.
    pub octets: Option<usize>,
    /// PROFIdrive format codes; the first one is used for writing.
    #[serde(with = "formats")]
    pub formats: Formats,
}

/// Every type: name, width, signed, text, formats. The first format is the one by size, which controllers use for writing.
const TYPES: [(&str, u32, bool, bool, Formats); 10] = [
    ("u8", 8, false, false, &[0x41, 0x05]),
    ("u16", 16, false, false, &[0x42, 0x06]),
    ("u32", 32, false, false, &[0x43, 0x07]),
    ("u64", 64, false, false, &[0x38]),
    ("i8", 8, true, false, &[0x41, 0x02]),
    ("i16", 16, true, false, &[0x42, 0x03]),
    ("i32", 32, true, false, &[0x43, 0x04]),
    ("i64", 64, true, false, &[0x37]),
    ("text", 8, false, true, &[0x41, 0x09]),
    BYTES,
];
const BYTES: (&str, u32, bool, bool, Formats) = ("bytes", 8, false, false, &[0x41, 0x0A]);

impl ParameterType {
    /// The type with this name, `bytes` for any other name; `octets` is the length in the manual.
    pub fn of_word(word: &str, octets: Option<usize>) -> ParameterType {
        let found = TYPES.into_iter().find(|(known, ..)| *known == word);
        let (_, width, signed, text, formats) = found.unwrap_or(BYTES);
        let octets = octets.or(if word == "text" || word == "bytes" { Some(0) } else { None });
        ParameterType { width, signed, text, octets, formats }
    }
}

/// The formats of a type, for `#[serde(with)]`.
mod formats {
    use super::{Formats, TYPES};
    use serde::{Deserialize, Deserializer, Serialize, Serializer, de};

    pub(super) fn serialize<S: Serializer>(formats: &Formats, to: S) -> Result<S::Ok, S::Error> {
        formats.serialize(to)
    }

    pub(super) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Formats, D::Error> {
        let read = Vec::<u8>::deserialize(from)?;
        let found = TYPES.into_iter().map(|(.., formats)| formats).find(|formats| *formats == read);
        found.ok_or_else(|| de::Error::custom("formats of no type"))
    }
}
