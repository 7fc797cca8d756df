//! Golden frames: octets that the programs of strangers built, as `harness/wire/tests/golden` has them.

use crate::workspace;

/// Octets from hexadecimal digits; blanks are passed over.
///
/// # Panics
///
/// If there is anything else, or half an octet.
pub fn hex(digits: &str) -> Vec<u8> {
    let digits: Vec<u8> = digits.bytes().filter(|octet| !octet.is_ascii_whitespace()).collect();
    assert!(digits.len().is_multiple_of(2), "an odd number of hexadecimal digits");
    let octet = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).expect("ASCII"), 16).expect("hexadecimal");
    digits.chunks(2).map(octet).collect()
}

/// The frames of a golden file: its lines `name hex`, comments left out.
///
/// # Panics
///
/// If there is no such file, or a line is something else.
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
fn digits_become_octets() {
    assert_eq!(hex("00 0eCF\nff"), [0x00, 0x0E, 0xCF, 0xFF]);
}

#[test]
#[should_panic(expected = "an odd number of hexadecimal digits")]
fn half_an_octet_is_none() {
    hex("00 0");
}
