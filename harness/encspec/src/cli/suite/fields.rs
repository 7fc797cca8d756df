//! Start parameters: the fields of the bytes that a connection writes, with words and defaults.

use super::names::{FreshNames, is_yaml_word, slug};
use std::fmt::Write as _;

/// A parameter in the bytes that are written at start-up.
#[derive(Clone, Debug)]
pub(super) struct NewStartField {
    /// Its name in the description.
    pub called: String,
    /// Its first byte.
    pub octet: usize,
    /// How many bytes it has, 1 for bits.
    pub octets: usize,
    /// The lowest of its bits and how many they are, in one byte.
    pub bits: Option<(u32, u32)>,
    /// The lowest and the highest number that is allowed.
    pub range: Option<(i128, i128)>,
    /// Its numbers with their texts.
    pub words: Vec<(i128, String)>,
}

/// A field with its name in the suite.
#[derive(Clone, Debug)]
pub(super) struct NamedField {
    pub name: String,
    pub field: NewStartField,
    /// The words of its numbers in the suite; empty where one of its defaults has none.
    words: Vec<(i128, String)>,
}

/// The longest number in bytes.
const LONGEST: usize = 8;

/// The names of `fields`, and of what else has to be written so that all bytes are those of `defaults`: the bytes of each way to connect,
/// of which the first is the usual one.
pub(super) fn named(fields: &[NewStartField], defaults: &[Vec<u8>], names: &mut FreshNames) -> Vec<NamedField> {
    let size = defaults.iter().map(Vec::len).max().unwrap_or_default();
    let mut covered = vec![0u8; size];
    let mut list: Vec<NamedField> = Vec::new();
    let mut fields = fields.to_vec();
    fields.sort_by_key(|field| (field.octet, field.bits));
    for field in fields {
        let places = field.octet..field.octet.saturating_add(field.octets);
        let mask = field.bits.map_or(0xFF, |(low, width)| (((1u16 << width.min(8)) - 1) << low) as u8);
        let is_free = covered.get(places.clone()).is_some_and(|octets| octets.iter().all(|octet| octet & mask == 0));
        if !is_free || field.octets == 0 || field.octets > LONGEST {
            continue;
        }
        covered[places].iter_mut().for_each(|octet| *octet |= mask);
        list.push(with_words(field, defaults, names));
    }
    let is_written =
        |at: usize| defaults.iter().any(|octets| octets.get(at).is_some_and(|octet| octet & !covered[at] != 0));
    for at in (0..size).filter(|at| is_written(*at)) {
        let mut bit = 0;
        while bit < 8 {
            let width = (bit..8).take_while(|bit| covered[at] & (1 << bit) == 0).count() as u32;
            if width > 0 {
                let bits = (width < 8).then_some((bit, width));
                let called = format!("fixed_{at}");
                list.push(with_words(
                    NewStartField { called, octet: at, octets: 1, bits, range: None, words: Vec::new() },
                    defaults,
                    names,
                ));
            }
            bit += width.max(1);
        }
    }
    list.sort_by_key(|of| (of.field.octet, of.field.bits));
    list
}

fn with_words(field: NewStartField, defaults: &[Vec<u8>], names: &mut FreshNames) -> NamedField {
    let mut words: Vec<(i128, String)> = Vec::new();
    let mut used = FreshNames::default();
    for (number, text) in &field.words {
        if words.iter().all(|(known, _)| known != number) {
            words.push((*number, used.new_name(text, "word")));
        }
    }
    let has_word = |octets: &Vec<u8>| words.iter().any(|(number, _)| *number == field.number(octets));
    if !defaults.iter().all(has_word) || words.iter().any(|(number, _)| i64::try_from(*number).is_err() || *number < 0)
    {
        words.clear();
    }
    NamedField { name: names.new_name(&field.called, "parameter"), field, words }
}

impl NewStartField {
    /// The first byte, where a description names no parameter.
    pub fn unused() -> NewStartField {
        NewStartField { called: "unused".to_owned(), octet: 0, octets: 1, bits: None, range: None, words: Vec::new() }
    }

    /// Its number in these bytes, big-endian and without a sign.
    fn number(&self, octets: &[u8]) -> i128 {
        let own = octets.iter().skip(self.octet).take(self.octets);
        let number = own.fold(0i128, |number, octet| number << 8 | i128::from(*octet));
        self.bits.map_or(number, |(low, width)| number >> low & ((1i128 << width) - 1))
    }
}

impl NamedField {
    /// What it is in these bytes, as a suite writes it.
    pub fn value(&self, octets: &[u8]) -> String {
        let number = self.field.number(octets);
        let word = self.words.iter().find(|(known, _)| *known == number);
        word.map_or_else(|| number.to_string(), |(_, word)| word.clone())
    }

    /// Its line in `fields`, with the default in `octets`.
    pub fn line(&self, octets: &[u8]) -> String {
        let NewStartField { octet, octets: count, bits, range, .. } = &self.field;
        let mut line = match count {
            1 => format!("octet: {octet}"),
            _ => format!("octets: [{octet}, {}]", octet + count - 1),
        };
        // Writing into a String cannot fail.
        let _ = match bits {
            None => Ok(()),
            Some((low, 1)) => write!(line, ", bit: {low}"),
            Some((low, width)) => write!(line, ", bits: [{low}, {}]", low + width - 1),
        };
        if !self.words.is_empty() {
            let _ = write!(line, ", words: {}", self.name);
        }
        let _ = write!(line, ", default: {}", self.value(octets));
        if let Some((low, high)) = range.filter(|(low, _)| *low >= 0) {
            let _ = write!(line, ", from: {low}, to: {high}");
        }
        // A name beside the field is written without quotes; what cannot be is left to the reader of the description.
        let called = self.field.called.as_str();
        let is_plain = called.starts_with(|letter: char| letter.is_ascii_alphabetic())
            && called.chars().all(|letter| letter.is_ascii_alphanumeric() || " _-./()".contains(letter))
            && !called.ends_with(' ');
        if is_plain && slug(called, "parameter") != called && !is_yaml_word(called) {
            let _ = write!(line, ", called: [{called}]");
        }
        format!("{}: {{ {line} }}", self.name)
    }

    /// The table of its words.
    pub fn table(&self) -> Option<String> {
        let words: Vec<String> = self.words.iter().map(|(number, word)| format!("{word}: {number}")).collect();
        (!words.is_empty()).then(|| format!("{}: {{ {} }}", self.name, words.join(", ")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_written_bit_belongs_to_a_field() {
        let of = |called: &str, octet, octets, bits| NewStartField {
            called: called.to_owned(),
            octet,
            octets,
            bits,
            range: None,
            words: vec![(0, "Off".to_owned()), (1, "On".to_owned())],
        };
        let fields = [of("Range", 1, 2, None), of("Scaling", 0, 1, Some((3, 1))), of("Inside the range", 2, 1, None)];
        let octets = vec![0x8A, 0x12, 0x34, 0, 7];
        let named = named(&fields, std::slice::from_ref(&octets), &mut FreshNames::default());
        let lines: Vec<String> = named.iter().map(|of| of.line(&octets)).collect();
        let expected = [
            "fixed_0: { octet: 0, bits: [0, 2], default: 2 }",
            "scaling: { octet: 0, bit: 3, words: scaling, default: is_on, called: [Scaling] }",
            "fixed_0_2: { octet: 0, bits: [4, 7], default: 8 }",
            "range: { octets: [1, 2], default: 4660, called: [Range] }",
            "fixed_4: { octet: 4, default: 7 }",
        ];
        assert_eq!(lines, expected);
        assert_eq!(named[1].table().as_deref(), Some("scaling: { is_off: 0, is_on: 1 }"));
    }
}
