//! What every reader and writer of a format has to stand.

use encspec_wire::Result;
use testing::every_prefix_and_flip;

/// What `write` appends; it is shown that what stood before it is left alone.
pub fn written(write: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let junk = [0xa5; 7];
    let mut out = junk.to_vec();
    write(&mut out);
    assert_eq!(out[..junk.len()], junk, "the writer touched what stood before it");
    out.split_off(junk.len())
}

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
