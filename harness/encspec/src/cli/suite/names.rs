//! FreshNames for a suite, made of the names in a vendor's description.

use plain_text::printable;
use std::collections::BTreeSet;
use suite_yaml::device_yaml::RESERVED;

/// Words of expressions and of checks, which no name may be.
const WORDS: [&str; 32] = [
    "and",
    "or",
    "not",
    "in",
    "mod",
    "if",
    "then",
    "else",
    "rises",
    "falls",
    "changes",
    "prev",
    "since",
    "abs",
    "min",
    "max",
    "floor",
    "round",
    "any",
    "none",
    "held",
    "counting",
    "refused",
    "from",
    "to",
    "start",
    "module",
    "watchdog",
    "baud",
    "isochronous",
    "instead",
    "row",
];
/// Words that YAML readers take for something else.
const YAML_WORDS: [&str; 7] = ["on", "off", "yes", "no", "true", "false", "null"];
/// The longest name.
const LONGEST: usize = 40;

/// The names that are in use, each of them once.
#[derive(Debug, Default)]
pub(super) struct FreshNames(BTreeSet<String>);

impl FreshNames {
    /// A name like `text` that is not in use yet; `other` where nothing of the text can be in a name.
    pub fn new_name(&mut self, text: &str, other: &str) -> String {
        let name = slug(text, other);
        let is_free = |name: &str| !self.0.contains(name) && !RESERVED.contains(&name) && !WORDS.contains(&name);
        let mut numbered = (2..).map(|number| format!("{name}_{number}"));
        let name = if is_free(&name) { name.clone() } else { numbered.find(|name| is_free(name)).unwrap_or_default() };
        self.0.insert(name.clone());
        name
    }
}

/// The letters and digits of a text in lower case, other characters as `_`; it begins with a letter.
pub(super) fn slug(text: &str, other: &str) -> String {
    let mut slug = String::new();
    for letter in text.chars().take(LONGEST * 2) {
        match letter {
            letter if letter.is_ascii_alphanumeric() => slug.push(letter.to_ascii_lowercase()),
            _ if !slug.is_empty() && !slug.ends_with('_') => slug.push('_'),
            _ => {}
        }
    }
    slug.truncate(LONGEST);
    let slug = slug.trim_end_matches('_');
    let is_parameter = slug.strip_prefix('p').is_some_and(|rest| rest.bytes().all(|octet| octet.is_ascii_digit()));
    match slug {
        "" => other.to_owned(),
        slug if is_yaml_word(slug) => format!("is_{slug}"),
        slug if is_parameter || slug.starts_with(|letter: char| letter.is_ascii_digit()) => format!("{other}_{slug}"),
        slug => slug.to_owned(),
    }
}

/// Whether YAML readers take a text for something else.
pub(super) fn is_yaml_word(text: &str) -> bool {
    YAML_WORDS.contains(&text.to_ascii_lowercase().as_str())
}

/// The name of a folder for a device.
pub(super) fn folder_name(text: &str, bus: &str) -> String {
    format!("{}-{bus}", slug(text, "my_device").replace('_', "-"))
}

/// A text of a description as a YAML scalar in quotes.
pub(super) fn quoted(text: &str) -> String {
    let text: String = printable(text).trim_start_matches('=').chars().take(100).collect();
    format!("\"{}\"", text.replace('\\', "\\\\").replace('"', "\\\""))
}

/// A text of a description in a comment of one line.
pub(super) fn comment(text: &str) -> String {
    printable(text).chars().take(100).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    #[rstest]
    #[case("Telegram 81", "telegram_81")]
    #[case("  G1_XIST1 (position)", "g1_xist1_position")]
    #[case("16 bytes", "word_16_bytes")]
    #[case("P922", "word_p922")]
    #[case("On", "is_on")]
    #[case("\u{4f4d}\u{7f6e}", "word")]
    #[case("", "word")]
    fn a_name_has_letters_digits_and_underscores(#[case] text: &str, #[case] name: &str) {
        assert_eq!(slug(text, "word"), name);
    }

    #[test]
    fn no_name_is_used_twice_or_reserved() {
        let mut names = FreshNames::default();
        assert_eq!(names.new_name("Speed", "field"), "speed");
        assert_eq!(names.new_name("speed", "field"), "speed_2");
        assert_eq!(names.new_name("Power", "field"), "power_2");
        assert_eq!(names.new_name("not", "field"), "not_2");
    }

    #[test]
    fn a_text_stays_in_its_quotes() {
        assert_eq!(quoted("a \"b\" \\ c"), r#""a \"b\" \\ c""#);
        assert!(!comment("a\nb").contains('\n'));
    }
}
