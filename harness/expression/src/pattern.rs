//! Byte patterns with wildcards.

use super::ExprError;
use serde::{Deserialize, Serialize};
use std::fmt;

/// A pattern of bytes, written `80 00 .. *`: `..` matches any byte and `*` any number of bytes.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct BytePattern {
    items: Vec<Item>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
enum Item {
    Octet(u8),
    AnyOctet,
    AnyRest,
}

impl BytePattern {
    /// Parses `text`: two capital hexadecimal digits for each byte, separated by one space; an empty text has no bytes.
    pub(super) fn parse(text: &str) -> Result<BytePattern, ExprError> {
        let mut items = Vec::new();
        let mut at = 0;
        for word in text.split(' ').filter(|_| !text.is_empty()) {
            let span = at..at + word.len();
            at = span.end + 1;
            let item = match word {
                ".." => Item::AnyOctet,
                "*" if items.last() == Some(&Item::AnyRest) => {
                    return Err(ExprError::new(span, "the second `*` in a row has no effect").help("remove it"));
                }
                "*" => Item::AnyRest,
                "" => return Err(ExprError::new(span, "one space too many").help("write one space between two bytes")),
                _ => Item::Octet(octet(word).ok_or_else(|| {
                    ExprError::new(span, format!("`{word}` is not a byte"))
                        .help("write each byte as two capital hexadecimal digits, separated by one space: \"80 0A\"")
                })?),
            };
            items.push(item);
        }
        Ok(BytePattern { items })
    }

    /// The bytes, if the pattern has no wildcard.
    pub fn exact(&self) -> Option<Vec<u8>> {
        let octet = |item: &Item| match item {
            Item::Octet(octet) => Some(*octet),
            Item::AnyOctet | Item::AnyRest => None,
        };
        self.items.iter().map(octet).collect()
    }

    /// Each byte, `None` for a `..`; `None` for the whole if the pattern has a `*`.
    pub fn places(&self) -> Option<Vec<Option<u8>>> {
        let place = |item: &Item| match item {
            Item::Octet(octet) => Some(Some(*octet)),
            Item::AnyOctet => Some(None),
            Item::AnyRest => None,
        };
        self.items.iter().map(place).collect()
    }

    /// Whether `octets` match the pattern.
    pub fn matches(&self, octets: &[u8]) -> bool {
        let (mut item, mut octet) = (0, 0);
        // Position of the last `*`, and the first byte that it has not matched yet.
        let mut rest: Option<(usize, usize)> = None;
        loop {
            let fits = match (self.items.get(item), octets.get(octet)) {
                (None, None) => return true,
                (Some(Item::AnyRest), _) => {
                    rest = Some((item, octet));
                    item += 1;
                    continue;
                }
                (Some(Item::AnyOctet), Some(_)) => true,
                (Some(Item::Octet(expected)), Some(observed)) => expected == observed,
                (None, Some(_)) | (Some(_), None) => false,
            };
            match rest {
                _ if fits => (item, octet) = (item + 1, octet + 1),
                Some((star, swallowed)) if swallowed < octets.len() => {
                    rest = Some((star, swallowed + 1));
                    (item, octet) = (star + 1, swallowed + 1);
                }
                _ => return false,
            }
        }
    }
}

fn octet(word: &str) -> Option<u8> {
    let capital = word.len() == 2 && word.bytes().all(|digit| matches!(digit, b'0'..=b'9' | b'A'..=b'F'));
    u8::from_str_radix(word, 16).ok().filter(|_| capital)
}

/// Formats the pattern as a suite writes it.
impl fmt::Display for BytePattern {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, item) in self.items.iter().enumerate() {
            f.write_str(if index == 0 { "" } else { " " })?;
            match item {
                Item::Octet(octet) => write!(f, "{octet:02X}")?,
                Item::AnyOctet => f.write_str("..")?,
                Item::AnyRest => f.write_str("*")?,
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    #[rstest]
    #[case("", &[], true)]
    #[case("", &[1], false)]
    #[case("80 00", &[0x80, 0x00], true)]
    #[case("80 00", &[0x80], false)]
    #[case("80 00", &[0x80, 0x00, 0x00], false)]
    #[case(".. 82", &[0x17, 0x82], true)]
    #[case(".. 82", &[0x82], false)]
    #[case("*", &[], true)]
    #[case("80 *", &[0x80], true)]
    #[case("80 *", &[0x80, 1, 2], true)]
    #[case("80 *", &[0x81, 1, 2], false)]
    #[case("* 81 40 36", &[1, 2, 0x81, 0x40, 0x36], true)]
    #[case("* 81 40 36", &[0x81, 0x40, 0x81, 0x40, 0x36], true)]
    #[case("* 81 40 36", &[0x81, 0x40, 0x36, 0], false)]
    #[case("01 * 02 * 03", &[1, 2, 2, 9, 3], true)]
    #[case("01 * 02 * 03", &[1, 9, 3], false)]
    #[case("* ..", &[], false)]
    fn wildcards_match_anything(#[case] pattern: &str, #[case] octets: &[u8], #[case] matches: bool) {
        let pattern = BytePattern::parse(pattern).expect("a pattern");
        assert_eq!(pattern.matches(octets), matches, "{pattern}");
    }

    #[rstest]
    #[case("80  00", 3)]
    #[case(" 80", 0)]
    #[case("80 ", 3)]
    #[case("80 0a", 3)]
    #[case("8000", 0)]
    #[case("80 0", 3)]
    #[case("+1", 0)]
    #[case("0é", 0)]
    #[case("* *", 2)]
    #[case("...", 0)]
    fn other_texts_are_refused_with_their_position(#[case] pattern: &str, #[case] at: usize) {
        assert_eq!(BytePattern::parse(pattern).expect_err("no pattern").span.start, at);
    }
}
