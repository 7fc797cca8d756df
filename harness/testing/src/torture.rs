//! Hard trials that every parser must survive.
//!
//! This room must not know what the octets mean: a parser is a closure that may refuse, but must not panic.

use std::panic::{AssertUnwindSafe, catch_unwind};

/// Gives `parse` every prefix of `octets`, then `octets` with each bit flipped, then with each octet set to 0x00, 0x7f and 0xff.
///
/// What `parse` does with its result is its own affair; the octets at which it panicked are named in the failure.
///
/// # Panics
///
/// If `parse` does.
pub fn every_prefix_and_flip(octets: &[u8], parse: impl Fn(&[u8])) {
    let attempt = |trial: &[u8], what: &str, at: usize| {
        let outcome = catch_unwind(AssertUnwindSafe(|| parse(trial)));
        assert!(outcome.is_ok(), "the parser panicked: {what} {at}, octets {trial:02x?}");
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
            attempt(&damaged, "overwritten octet", at);
        }
        damaged[at] = octets[at];
    }
}

#[test]
#[should_panic(expected = "prefix of length 2")]
fn a_parser_that_panics_on_a_prefix_is_found() {
    every_prefix_and_flip(&[1, 2, 3], |octets| assert_ne!(octets.len(), 2));
}

#[test]
#[should_panic(expected = "flipped bit 9")]
fn a_parser_that_panics_on_a_flipped_bit_is_found() {
    every_prefix_and_flip(&[0, 0], |octets| assert_ne!(octets.get(1), Some(&2)));
}
