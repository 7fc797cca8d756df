//! The frames in the bytes of a stream, as QEMU's `-netdev stream` writes them: the length in four bytes, big-endian, then the frame.

use thiserror::Error;

/// The size of the length field in front of each frame, in bytes.
const HEAD: usize = 4;
/// The longest frame that QEMU sends (its `NET_BUFSIZE`), in bytes.
const LONGEST_FRAME: usize = 4096 + 65536;

/// A length that no frame has. Nothing behind it can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("it sent an invalid frame length, {0} bytes")]
pub struct BadFrameLength(pub usize);

/// Bytes of a stream, in pieces of any size, and the frames in them.
#[derive(Debug, Default)]
pub struct StreamFrames {
    octets: Vec<u8>,
    /// How many bytes have been returned as frames.
    taken: usize,
}

impl StreamFrames {
    /// Appends bytes that have arrived.
    pub fn push(&mut self, octets: &[u8]) {
        self.octets.drain(..self.taken);
        self.taken = 0;
        self.octets.extend_from_slice(octets);
    }

    /// Moves the next complete frame to `into`; returns false if there is none yet. Empty frames are skipped.
    ///
    /// # Errors
    ///
    /// A length is larger than the longest frame of QEMU.
    pub fn next(&mut self, into: &mut Vec<u8>) -> Result<bool, BadFrameLength> {
        loop {
            let Some((head, rest)) = self.octets[self.taken..].split_first_chunk::<HEAD>() else { return Ok(false) };
            let length = u32::from_be_bytes(*head) as usize;
            if length > LONGEST_FRAME {
                return Err(BadFrameLength(length));
            }
            let Some(frame) = rest.get(..length) else { return Ok(false) };
            self.taken += HEAD + length;
            if length > 0 {
                into.clear();
                into.extend_from_slice(frame);
                return Ok(true);
            }
        }
    }

    /// Whether bytes are left that are no complete frame.
    pub fn is_in_frame(&self) -> bool {
        self.taken < self.octets.len()
    }

    /// Forgets everything, as for a new stream.
    pub fn clear(&mut self) {
        self.octets.clear();
        self.taken = 0;
    }
}
