//! The frames in a stream of QEMU, which arrive in pieces of any size: the first byte says how large.
#![no_main]

use link::StreamFrames;

/// The frames up to the end or to an invalid length, when the bytes arrive in pieces.
fn frames(octets: &[u8], piece: usize) -> (Vec<Vec<u8>>, bool) {
    let (mut stream, mut frames, mut frame) = (StreamFrames::default(), Vec::new(), Vec::new());
    for piece in octets.chunks(piece) {
        stream.push(piece);
        loop {
            match stream.next(&mut frame) {
                Ok(true) => frames.push(frame.clone()),
                Ok(false) => break,
                Err(_) => return (frames, true),
            }
        }
    }
    (frames, false)
}

libfuzzer_sys::fuzz_target!(|data: &[u8]| {
    let Some((piece, octets)) = data.split_first() else { return };
    assert_eq!(frames(octets, usize::from(*piece).max(1)), frames(octets, octets.len().max(1)));
});
