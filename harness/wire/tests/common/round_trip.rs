//! What every reader and writer of a format has to stand, with the hard trials beside it.

use super::torture::every_prefix_and_flip;
use encspec_wire::Result;

/// Tries `parse`, and shows that what `write` makes of a result is read as the same again.
pub fn try_hard<T: PartialEq>(octets: &[u8], parse: fn(&[u8]) -> Result<T>, write: fn(&T, &mut Vec<u8>)) {
    assert!(parse(octets).is_ok(), "the undamaged octets are read: {octets:02x?}");
    every_prefix_and_flip(octets, |octets| {
        if let Ok(read) = parse(octets) {
            let mut out = Vec::new();
            write(&read, &mut out);
            assert!(parse(&out).ok() == Some(read), "read otherwise the second time: {out:02x?}");
        }
    });
}
