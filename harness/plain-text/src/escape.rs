//! Escapes text that comes from a device, a capture or a file, so that it is safe on a terminal.

use alloc::{
    format,
    string::{String, ToString},
};

/// The longest text of a station that is printed whole, in bytes; the rest is cut off.
const LONGEST_TEXT: usize = 240;
/// From this many zero bytes at the end of a text on, only one of them is printed.
const MANY_ZEROS: usize = 4;

/// Whether a character could control a terminal or change the writing direction (Unicode bidirectional controls).
pub fn steers(c: char) -> bool {
    c.is_control() || matches!(c, '\u{200E}' | '\u{200F}' | '\u{202A}'..='\u{202E}' | '\u{2066}'..='\u{2069}')
}

/// Escapes every character of the text for which [`steers`] is true.
pub fn printable(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if steers(c) { out.extend(c.escape_default()) } else { out.push(c) }
    }
    out
}

/// Escapes the text of a station for output: escapes every byte that is not printable ASCII, cuts the text after 240 bytes, and
/// prints four or more zeros at its end as one zero.
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
    fn control_characters_are_escaped() {
        assert_eq!(printable("a\u{1b}[31m\u{202e}b\u{e9}"), "a\\u{1b}[31m\\u{202e}b\u{e9}");
        assert_eq!(escaped(b"a\x1b[31m\xe9"), "a\\x1b[31m\\xe9");
    }

    #[test]
    fn long_texts_are_cut_and_trailing_zeros_are_printed_once() {
        assert_eq!(escaped(&[b'a'; 241]), format!("{}..", "a".repeat(240)));
        assert_eq!(escaped(b"abc\0\0\0\0"), "abc\\x00..");
        assert_eq!(escaped(b"abc\0\0\0"), "abc\\x00\\x00\\x00");
    }
}
