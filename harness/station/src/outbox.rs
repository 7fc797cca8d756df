//! Where a station puts the frames that it sends.

use alloc::vec::Vec;

/// The frames that a station sends in answer to one input, in order.
///
/// One buffer holds them all and is reused, so that sending a cyclic frame allocates nothing.
#[derive(Debug, Default)]
pub struct Outbox {
    octets: Vec<u8>,
    ends: Vec<usize>,
}

impl Outbox {
    /// An empty outbox.
    pub fn new() -> Outbox {
        Outbox::default()
    }

    /// Sends `frame`, complete from the first octet of the destination address, without checksum sequence.
    #[inline]
    pub fn push(&mut self, frame: &[u8]) {
        self.octets.extend_from_slice(frame);
        self.ends.push(self.octets.len());
    }

    /// Sends the frame that `write` appends to the buffer it is given; whatever stood there before is left alone.
    #[inline]
    pub fn push_with(&mut self, write: impl FnOnce(&mut Vec<u8>)) {
        let start = self.octets.len();
        write(&mut self.octets);
        debug_assert!(self.octets.len() >= start, "a frame is appended, nothing is taken away");
        self.ends.push(self.octets.len());
    }

    /// The frames in the order they were sent.
    #[inline]
    pub fn frames(&self) -> impl Iterator<Item = &[u8]> {
        let mut start = 0;
        self.ends.iter().map(move |&end| {
            let frame = &self.octets[start..end];
            start = end;
            frame
        })
    }

    /// Whether nothing was sent.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Forgets the frames and keeps the memory.
    #[inline]
    pub fn clear(&mut self) {
        self.octets.clear();
        self.ends.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_come_back_in_order_and_whole() {
        let mut out = Outbox::new();
        out.push(&[1, 2]);
        out.push_with(|buffer| buffer.extend_from_slice(&[3]));
        out.push(&[]);
        let frames: Vec<&[u8]> = out.frames().collect();
        assert_eq!(frames, [&[1u8, 2][..], &[3], &[]]);
        out.clear();
        assert!(out.is_empty() && out.frames().next().is_none());
    }
}
