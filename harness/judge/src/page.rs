//! The visible text of web pages, without tags and entities, and the values on them.
//!
//! Pages of a device are not trusted: the shown text is bounded, and control characters are replaced.

use expression::Value;
use suite::device::{PageForm, PageValue};

/// Maximum number of characters of a page in a report.
const SHOWN: usize = 200;
/// HTML entities and their characters.
const ENTITIES: [(&str, char); 6] =
    [("amp;", '&'), ("lt;", '<'), ("gt;", '>'), ("quot;", '"'), ("#39;", '\''), ("nbsp;", ' ')];

/// The visible text of a page; tags and white space become one space.
pub fn text(page: &str) -> String {
    let mut text = String::new();
    let mut rest = page;
    while let Some(next) = rest.chars().next() {
        let (shown, length) = match next {
            '<' => (' ', rest.find('>').map_or(rest.len(), |end| end + 1)),
            '&' => {
                let entity = ENTITIES.iter().find(|(name, _)| rest[1..].starts_with(name));
                entity.map_or(('&', 1), |(name, shown)| (*shown, name.len() + 1))
            }
            other if other.is_whitespace() => (' ', other.len_utf8()),
            other if other.is_control() => (char::REPLACEMENT_CHARACTER, other.len_utf8()),
            other => (other, other.len_utf8()),
        };
        if shown != ' ' || !(text.is_empty() || text.ends_with(' ')) {
            text.push(shown);
        }
        rest = &rest[length..];
    }
    text.trim_end().to_owned()
}

/// Whether a page contains a text, in its source or in its visible text, ignoring case.
pub fn has(page: &Value, expected: &str) -> bool {
    let Value::Text(page) = page else { return false };
    let expected = expected.to_ascii_lowercase();
    page.to_ascii_lowercase().contains(&expected) || text(page).to_ascii_lowercase().contains(&expected)
}

/// Whether a readable page contains none of these texts. False for an empty page and for UTF-16, which would lack every text.
pub fn lacks(page: &Value, unwanted: &[String]) -> bool {
    let Value::Text(source) = page else { return false };
    let is_readable = !source.contains('\0') && !text(source).is_empty();
    is_readable && !unwanted.iter().any(|text| has(page, text))
}

/// The first characters of a page, for a report.
pub fn shortened(page: &str) -> String {
    let text = text(page);
    match text.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{} ...", text[..end].escape_debug()),
        None => text.escape_debug().to_string(),
    }
}

/// The value after a text on a page; unknown if the text is missing or the value does not have the expected format.
pub fn value(page: &str, of: &PageValue) -> Value {
    let text = text(page);
    let Some((_, rest)) = text.split_once(&of.label) else { return Value::Unknown };
    let word = rest.trim_start_matches([' ', ':', '=']).split(' ').next().unwrap_or_default();
    let number = match of.form {
        PageForm::Text if word.is_empty() => return Value::Unknown,
        PageForm::Text => return Value::text(word),
        PageForm::Decimal => word.parse::<i64>(),
        PageForm::Hexadecimal => i64::from_str_radix(word.strip_prefix("0x").unwrap_or(word), 16),
    };
    match (number, &of.table) {
        (Err(_), _) => Value::Unknown,
        (Ok(number), Some(_)) => Value::Word(number),
        (Ok(number), None) => Value::whole(number),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = "<html><body><h1>Position</h1>\r\n<table><tr><td>Current&nbsp;position</td>\n<td>\t4711</td></tr>\
        <tr><td>Value (hex)</td><td>1F</td><td>A &lt; B</td></tr></table>\u{7}<a href=\"http://www.example.com/\">x</a>";

    fn value_behind(behind: &str, form: PageForm) -> Value {
        let of = PageValue { name: String::new(), label: behind.into(), form, steps: false, table: None };
        value(PAGE, &of)
    }

    #[test]
    fn visible_text_has_no_tags_and_no_control_characters() {
        assert_eq!(text(PAGE), "Position Current position 4711 Value (hex) 1F A < B \u{fffd} x");
        assert_eq!(text("open <tag that never ends"), "open");
        assert_eq!(text("&unknown; & &"), "&unknown; & &");
    }

    #[test]
    fn a_value_follows_its_text() {
        assert_eq!(value_behind("Current position", PageForm::Decimal), Value::whole(4711));
        assert_eq!(value_behind("Value (hex)", PageForm::Hexadecimal), Value::whole(0x1F));
        assert_eq!(value_behind("Value (hex)", PageForm::Decimal), Value::Unknown);
        assert_eq!(value_behind("A", PageForm::Text), Value::text("<"));
        assert_eq!(value_behind("Nowhere", PageForm::Text), Value::Unknown);
    }

    #[test]
    fn texts_are_also_found_in_the_source() {
        let page = Value::text(PAGE);
        assert!(has(&page, "WWW.example.com") && has(&page, "current position 4711"));
        assert!(!has(&page, "www.example.org") && !has(&Value::Unknown, "x"));
    }

    #[test]
    fn only_a_readable_page_can_lack_a_text() {
        let unwanted = ["password".to_owned()];
        assert!(lacks(&Value::text(PAGE), &unwanted));
        assert!(!lacks(&Value::text("<p>Password</p>"), &unwanted));
        let utf_16: String = "<p>Password</p>".chars().flat_map(|letter| [letter, '\0']).collect();
        for nothing in ["", " \r\n", "<html></html>", utf_16.as_str(), "\u{1f}\u{fffd}\u{8}\0"] {
            assert!(!lacks(&Value::text(nothing), &unwanted), "{nothing:?}");
        }
        assert!(!lacks(&Value::Unknown, &unwanted) && !lacks(&Value::whole(404_u16), &unwanted));
    }

    #[test]
    fn a_long_page_is_cut() {
        let shown = shortened(&"\u{1b}ab".repeat(1000));
        assert!(shown.chars().count() < SHOWN * 2 && shown.ends_with(" ...") && !shown.contains('\u{1b}'));
    }
}
