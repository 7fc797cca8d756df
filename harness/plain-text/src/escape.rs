//! Text that a device, a capture or a file chose, made harmless to show.

use alloc::{
    format,
    string::{String, ToString},
};

/// From this length on, in octets, a text of a station is cut.
const LONGEST_TEXT: usize = 240;
/// So many zeros at the end of a text are shown as one.
const MANY_ZEROS: usize = 4;

/// Whether a character could steer a terminal or turn the direction of writing.
pub fn steers(c: char) -> bool {
    c.is_control() || matches!(c, '\u{200E}' | '\u{200F}' | '\u{202A}'..='\u{202E}' | '\u{2066}'..='\u{2069}')
}

/// The text with every character escaped that could steer a terminal or turn the direction of writing.
pub fn printable(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    for c in text.chars() {
        if steers(c) { shown.extend(c.escape_default()) } else { shown.push(c) }
    }
    shown
}

/// A text that a station chose, safe to show: what is not printable ASCII is escaped, it ends after 240 octets, and of four or
/// more zeros at its end one is shown.
pub fn escaped(octets: &[u8]) -> String {
    let text = octets.len() - octets.iter().rev().take_while(|octet| **octet == 0).count();
    if octets.len() - text >= MANY_ZEROS && text < LONGEST_TEXT {
        return format!("{}..", octets.get(..=text).unwrap_or_default().escape_ascii());
    }
    match octets.get(..LONGEST_TEXT) {
        Some(begin) if octets.len() > LONGEST_TEXT => format!("{}..", begin.escape_ascii()),
        _ => octets.escape_ascii().to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::{escaped, printable};
    use alloc::format;

    #[test]
    fn nothing_steers_a_terminal() {
        assert_eq!(printable("a\u{1b}[31m\u{202e}b\u{e9}"), "a\\u{1b}[31m\\u{202e}b\u{e9}");
        assert_eq!(escaped(b"a\x1b[31m\xe9"), "a\\x1b[31m\\xe9");
    }

    #[test]
    fn long_texts_are_cut_and_zeros_at_the_end_are_shown_once() {
        assert_eq!(escaped(&[b'a'; 241]), format!("{}..", "a".repeat(240)));
        assert_eq!(escaped(b"abc\0\0\0\0"), "abc\\x00..");
        assert_eq!(escaped(b"abc\0\0\0"), "abc\\x00\\x00\\x00");
    }
}
