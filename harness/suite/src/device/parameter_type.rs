//! The type of a parameter's elements, by its word in `device.yaml`.

use serde::{Deserialize, Serialize};

/// Format octets of PROFIdrive; a name of its own, since the derived reader takes a slice for a part of what it reads.
pub type Formats = &'static [u8];

/// The type of a parameter's elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize)]
pub struct ParameterType {
    /// Width in bits: 8, 16, 32 or 64.
    pub width: u32,
    /// Whether it is a two's complement.
    pub signed: bool,
    /// Whether the elements are octets of a text.
    pub text: bool,
    /// For octets and texts, which are one value: how many octets there are, 0 where the manual does not say.
    pub octets: Option<usize>,
    /// The format octets that PROFIdrive has for it: the one to write with first.
    #[serde(with = "formats")]
    pub formats: Formats,
}

/// Every type: its word, its width, whether it is a two's complement, whether it is a text, and its formats. The form by size is
/// written first, as controllers do.
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
    /// The type of this word, `bytes` for any other; `octets` as the manual says it.
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
