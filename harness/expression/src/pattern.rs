//! Byte patterns with wildcards.

use super::ExprError;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::ops::Range;

/// A pattern of bytes, written `80 00 .. *`: `..` matches any byte and `*` any number of bytes.
///
/// A word with a colon names the bytes after it: `status: 80 00 code: .. *`. Names say which field a group is; they match nothing.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct BytePattern {
    items: Vec<PatternItem>,
    /// The named groups in order: the index of the first item of each, and its name.
    groups: Vec<(usize, String)>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
enum PatternItem {
    Octet(u8),
    AnyOctet,
    AnyRest,
}

impl PatternItem {
    /// The bytes, if no item is a wildcard.
    fn octets(items: &[PatternItem]) -> Option<Vec<u8>> {
        let octet = |item: &PatternItem| match item {
            PatternItem::Octet(octet) => Some(*octet),
            PatternItem::AnyOctet | PatternItem::AnyRest => None,
        };
        items.iter().map(octet).collect()
    }
}

/// A named group of bytes: its name, and how many bytes it has; none if `*` is among them.
pub type OctetGroup<'p> = (&'p str, Option<usize>);

impl BytePattern {
    /// Parses `text`: two capital hexadecimal digits for each byte, separated by one space; an empty text has no bytes.
    pub(super) fn parse(text: &str) -> Result<BytePattern, ExprError> {
        let (mut items, mut groups): (Vec<PatternItem>, Vec<(usize, String)>) = (Vec::new(), Vec::new());
        let mut at = 0;
        for word in text.split(' ').filter(|_| !text.is_empty()) {
            let span = at..at + word.len();
            at = span.end + 1;
            let item = match word {
                ".." => PatternItem::AnyOctet,
                "*" if items.last() == Some(&PatternItem::AnyRest) => {
                    return Err(ExprError::new(span, "the second `*` in a row has no effect").help("remove it"));
                }
                "*" => PatternItem::AnyRest,
                "" => return Err(ExprError::new(span, "one space too many").help("write one space between two bytes")),
                _ if word.ends_with(':') => {
                    let name = group_name(word, span.clone())?;
                    if groups.last().is_some_and(|(first, _)| *first == items.len()) {
                        return Err(ExprError::new(span, "the name before this one has no bytes").help(NAME_HELP));
                    }
                    groups.push((items.len(), name.to_owned()));
                    continue;
                }
                _ => PatternItem::Octet(octet(word).ok_or_else(|| {
                    ExprError::new(span, format!("`{word}` is not a byte"))
                        .help("write each byte as two capital hexadecimal digits, separated by one space: \"80 0A\"")
                })?),
            };
            items.push(item);
        }
        if groups.last().is_some_and(|(first, _)| *first == items.len()) {
            return Err(ExprError::new(0..text.len(), "the last name has no bytes").help(NAME_HELP));
        }
        Ok(BytePattern { items, groups })
    }

    /// The named groups in order; empty if no byte has a name.
    pub fn groups(&self) -> impl Iterator<Item = OctetGroup<'_>> {
        self.spans().map(|(name, first, end)| {
            let items = self.items.get(first..end).unwrap_or_default();
            (name, (!items.contains(&PatternItem::AnyRest)).then_some(items.len()))
        })
    }

    /// The named groups without a wildcard, in front of the first `*`: the name, the index of the first byte, and the bytes.
    pub fn fixed_groups(&self) -> impl Iterator<Item = (&str, usize, Vec<u8>)> {
        let open = self.open();
        let closed = self.spans().filter(move |(_, first, _)| *first < open);
        closed.filter_map(move |(name, first, end)| {
            Some((name, first, PatternItem::octets(self.items.get(first..end.min(open))?)?))
        })
    }

    /// The named groups in order: the name, the index of its first item, and the index behind its last one.
    fn spans(&self) -> impl Iterator<Item = (&str, usize, usize)> {
        let ends = self.groups.iter().skip(1).map(|(first, _)| *first).chain([self.items.len()]);
        self.groups.iter().zip(ends).map(|((first, name), end)| (name.as_str(), *first, end))
    }

    /// The index of the first `*`, or the number of items.
    fn open(&self) -> usize {
        self.items.iter().position(|item| *item == PatternItem::AnyRest).unwrap_or(self.items.len())
    }

    /// Whether the bytes have names.
    pub fn is_named(&self) -> bool {
        !self.groups.is_empty()
    }

    /// `octets` with the names of this pattern before its groups; what the first `*` matches is called `rest`.
    pub fn named(&self, octets: &[u8]) -> String {
        let open = self.open();
        let mut words = Vec::with_capacity(octets.len() + self.groups.len());
        for (index, octet) in octets.iter().enumerate() {
            match self.groups.iter().find(|(first, _)| *first == index && index <= open) {
                Some((_, name)) => words.push(format!("{name}:")),
                None if index == open && index > 0 => words.push("rest:".to_owned()),
                None => {}
            }
            words.push(format!("{octet:02X}"));
        }
        words.join(" ")
    }

    /// The bytes, if the pattern has no wildcard.
    pub fn exact(&self) -> Option<Vec<u8>> {
        PatternItem::octets(&self.items)
    }

    /// Each byte, `None` for a `..`; `None` for the whole if the pattern has a `*`.
    pub fn places(&self) -> Option<Vec<Option<u8>>> {
        let place = |item: &PatternItem| match item {
            PatternItem::Octet(octet) => Some(Some(*octet)),
            PatternItem::AnyOctet => Some(None),
            PatternItem::AnyRest => None,
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
                (Some(PatternItem::AnyRest), _) => {
                    rest = Some((item, octet));
                    item += 1;
                    continue;
                }
                (Some(PatternItem::AnyOctet), Some(_)) => true,
                (Some(PatternItem::Octet(expected)), Some(observed)) => expected == observed,
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

const NAME_HELP: &str = "a name stands before the bytes that it names: \"status: 80 00\"";

/// The name of a group, which begins with a letter.
fn group_name(word: &str, span: Range<usize>) -> Result<&str, ExprError> {
    let name = word.trim_end_matches(':');
    let is_name = name.starts_with(|first: char| first.is_ascii_alphabetic())
        && name.chars().all(|letter| letter.is_ascii_alphanumeric() || matches!(letter, '_' | '-' | '.'))
        && name.len() + 1 == word.len();
    is_name.then_some(name).ok_or_else(|| ExprError::new(span, format!("`{word}` names no bytes")).help(NAME_HELP))
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
            if let Some((_, name)) = self.groups.iter().find(|(first, _)| *first == index) {
                write!(f, "{name}: ")?;
            }
            match item {
                PatternItem::Octet(octet) => write!(f, "{octet:02X}")?,
                PatternItem::AnyOctet => f.write_str("..")?,
                PatternItem::AnyRest => f.write_str("*")?,
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

    #[test]
    fn a_name_stands_before_its_octets_and_matches_nothing() {
        let pattern = BytePattern::parse("status: 80 .. code: 12 *").expect("a pattern");
        assert!(pattern.matches(&[0x80, 1, 0x12, 7]) && !pattern.matches(&[0x80, 1, 0x13]));
        assert_eq!(pattern.groups().collect::<Vec<_>>(), [("status", Some(2)), ("code", None)]);
        assert_eq!(pattern.to_string(), "status: 80 .. code: 12 *");
        assert_eq!(pattern.named(&[1, 2, 3, 4]), "status: 01 02 code: 03 rest: 04");
        assert_eq!(BytePattern::parse("id: 01 02").expect("a pattern").exact(), Some(vec![1, 2]));
    }

    #[rstest]
    #[case("80 status:", 0)]
    #[case("status: code: 80", 8)]
    #[case("1st: 80", 0)]
    #[case("a:: 80", 0)]
    #[case(": 80", 0)]
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

    #[test]
    fn fixed_groups_have_no_wildcard_and_stand_before_the_rest() {
        let pattern = BytePattern::parse("status: 80 .. position: 00 01 code: 12 *").expect("a pattern");
        let fixed: Vec<_> = pattern.fixed_groups().collect();
        assert_eq!(fixed, [("position", 2, vec![0, 1]), ("code", 4, vec![0x12])]);
    }
}
