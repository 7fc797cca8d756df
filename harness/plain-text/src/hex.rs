//! Bytes in hexadecimal.

use alloc::string::String;
use core::fmt::Write as _;

/// Formats each byte as two uppercase digits, separated by spaces: `0A FF`.
pub fn hex(octets: &[u8]) -> String {
    let mut text = String::with_capacity(3 * octets.len());
    for (index, octet) in octets.iter().enumerate() {
        // Writing into a String cannot fail.
        let _ = write!(text, "{}{octet:02X}", if index == 0 { "" } else { " " });
    }
    text
}

/// Formats at most the first `most` bytes, like [`hex`].
pub fn hex_start(octets: &[u8], most: usize) -> String {
    hex(octets.get(..most).unwrap_or(octets))
}

#[cfg(test)]
mod tests {
    use super::{hex, hex_start};

    #[test]
    fn octets_have_two_capital_digits_and_a_space_between_them() {
        assert_eq!(hex(&[]), "");
        assert_eq!(hex(&[0x0A]), "0A");
        assert_eq!(hex(&[0x00, 0xFF, 0x1B]), "00 FF 1B");
    }

    #[test]
    fn the_start_may_be_longer_than_the_octets() {
        assert_eq!(hex_start(&[1, 2, 3], 2), "01 02");
        assert_eq!(hex_start(&[1, 2, 3], 9), "01 02 03");
    }
}
