//! Golden frames: bytes built by third-party tools, in `harness/wire/tests/golden`.

use crate::workspace;

/// Bytes from hexadecimal digits; whitespace is ignored.
///
/// # Panics
///
/// If there is any other character, or an odd number of digits.
pub fn hex(digits: &str) -> Vec<u8> {
    let digits: Vec<u8> = digits.bytes().filter(|octet| !octet.is_ascii_whitespace()).collect();
    assert!(digits.len().is_multiple_of(2), "an odd number of hexadecimal digits");
    let octet = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).expect("ASCII"), 16).expect("hexadecimal");
    digits.chunks(2).map(octet).collect()
}

/// The frames of a golden file, each with its name: one `name hex` a line; lines that start with `#` are comments.
///
/// # Panics
///
/// If the file does not exist, or a line has another form.
pub fn golden(file: &str) -> Vec<(String, Vec<u8>)> {
    let path = workspace().join("harness/wire/tests/golden").join(file);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    text.lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| line.split_once(' ').expect("a line is a name and hexadecimal digits"))
        .map(|(name, digits)| (name.to_owned(), hex(digits)))
        .collect()
}

#[test]
fn hex_digits_become_bytes() {
    assert_eq!(hex("00 0eCF\nff"), [0x00, 0x0E, 0xCF, 0xFF]);
}

#[test]
#[should_panic(expected = "an odd number of hexadecimal digits")]
fn an_odd_number_of_digits_panics() {
    hex("00 0");
}
