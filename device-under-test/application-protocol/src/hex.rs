//! Bytes as text of hexadecimal digits, without spaces.

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::fmt;

/// Bytes that are written as two hexadecimal digits each: `0400FF`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct HexText(pub Vec<u8>);

const DIGITS: &[u8; 16] = b"0123456789ABCDEF";

impl From<&[u8]> for HexText {
    fn from(octets: &[u8]) -> HexText {
        HexText(octets.to_vec())
    }
}

impl fmt::Display for HexText {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let digit = |nibble: u8| char::from(DIGITS[usize::from(nibble & 0xF)]);
        let text: String = self.0.iter().flat_map(|octet| [digit(octet >> 4), digit(*octet)]).collect();
        f.write_str(&text)
    }
}

impl Serialize for HexText {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for HexText {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<HexText, D::Error> {
        deserializer.deserialize_str(HexVisitor)
    }
}

struct HexVisitor;

impl serde::de::Visitor<'_> for HexVisitor {
    type Value = HexText;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("bytes as hexadecimal digits without spaces, for instance \"0400FF\"")
    }

    fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<HexText, E> {
        let digit = |octet: u8| char::from(octet).to_digit(16).map(|digit| digit as u8);
        let pair = |pair: &[u8]| match pair {
            [high, low] => Some(digit(*high)? << 4 | digit(*low)?),
            _ => None,
        };
        let octets: Option<Vec<u8>> = text.as_bytes().chunks(2).map(pair).collect();
        octets.map(HexText).ok_or_else(|| E::invalid_value(serde::de::Unexpected::Str(text), &self))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_read_as_they_are_written() {
        let text = serde_json::to_string(&HexText(vec![0x04, 0x00, 0xFF])).expect("text");
        assert_eq!(text, "\"0400FF\"");
        assert_eq!(serde_json::from_str::<HexText>("\"0400fF\"").expect("bytes"), HexText(vec![4, 0, 255]));
        for wrong in ["\"040\"", "\"0x04\"", "\"04 00\"", "\"+1\""] {
            assert!(serde_json::from_str::<HexText>(wrong).is_err(), "{wrong}");
        }
    }
}
