//! Helpers to check the parser and the writer of a format.

use encspec_wire::Result;
use testing::every_prefix_and_flip;

/// The bytes that `write` appends; asserts that it does not change the bytes before.
pub fn written(write: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let junk = [0xa5; 7];
    let mut out = junk.to_vec();
    write(&mut out);
    assert_eq!(out[..junk.len()], junk, "the writer changed the bytes before");
    out.split_off(junk.len())
}

/// Runs `parse` on `octets` and on damaged copies; asserts that each result is the same after `write` and another `parse`.
pub fn try_hard<T: PartialEq>(octets: &[u8], parse: fn(&[u8]) -> Result<T>, write: fn(&T, &mut Vec<u8>)) {
    assert!(parse(octets).is_ok(), "the undamaged bytes are parsed: {octets:02x?}");
    every_prefix_and_flip(octets, |octets| {
        if let Ok(read) = parse(octets) {
            let mut out = Vec::new();
            write(&read, &mut out);
            assert!(parse(&out).ok() == Some(read), "the second parse differs: {out:02x?}");
        }
    });
}
