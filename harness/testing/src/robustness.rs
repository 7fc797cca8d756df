//! Robustness tests for parsers.
//!
//! A parser is a closure that may reject its input but must not panic. What the bytes mean does not matter here.

use std::panic::{AssertUnwindSafe, catch_unwind};

/// Calls `parse` with every prefix of `octets`, with each bit flipped, and with each byte set to 0x00, 0x7f and 0xff.
///
/// Results are ignored. A panic is reported with the bytes that caused it.
///
/// # Panics
///
/// If `parse` panics.
pub fn every_prefix_and_flip(octets: &[u8], parse: impl Fn(&[u8])) {
    let attempt = |trial: &[u8], what: &str, at: usize| {
        let outcome = catch_unwind(AssertUnwindSafe(|| parse(trial)));
        assert!(outcome.is_ok(), "the parser panicked: {what} {at}, bytes {trial:02x?}");
    };
    for length in 0..=octets.len() {
        attempt(&octets[..length], "prefix of length", length);
    }
    let mut damaged = Vec::from(octets);
    for at in 0..octets.len() {
        for bit in 0..8 {
            damaged[at] = octets[at] ^ (1 << bit);
            attempt(&damaged, "flipped bit", at * 8 + bit);
        }
        for value in [0x00, 0x7f, 0xff] {
            damaged[at] = value;
            attempt(&damaged, "overwritten byte", at);
        }
        damaged[at] = octets[at];
    }
}

#[test]
#[should_panic(expected = "prefix of length 2")]
fn a_panic_on_a_prefix_is_reported() {
    every_prefix_and_flip(&[1, 2, 3], |octets| assert_ne!(octets.len(), 2));
}

#[test]
#[should_panic(expected = "flipped bit 9")]
fn a_panic_on_a_flipped_bit_is_reported() {
    every_prefix_and_flip(&[0, 0], |octets| assert_ne!(octets.get(1), Some(&2)));
}
