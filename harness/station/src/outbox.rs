//! The buffer for the frames that a station sends.

use alloc::vec::Vec;

/// The frames that a station sends in response to one input, in order.
///
/// One buffer holds all frames and is reused, so sending a cyclic frame does not allocate.
#[derive(Debug, Default)]
pub struct Outbox {
    octets: Vec<u8>,
    ends: Vec<usize>,
}

impl Outbox {
    /// Creates an empty outbox.
    pub fn new() -> Outbox {
        Outbox::default()
    }

    /// Sends `frame`, which starts with the destination address and has no frame check sequence.
    #[inline]
    pub fn push(&mut self, frame: &[u8]) {
        self.octets.extend_from_slice(frame);
        self.ends.push(self.octets.len());
    }

    /// Sends the frame that `write` appends to the buffer; `write` must not change what the buffer holds already.
    #[inline]
    pub fn push_with(&mut self, write: impl FnOnce(&mut Vec<u8>)) {
        let start = self.octets.len();
        write(&mut self.octets);
        debug_assert!(self.octets.len() >= start, "the frame is appended to the buffer");
        self.ends.push(self.octets.len());
    }

    /// The frames in the order in which they were sent.
    #[inline]
    pub fn frames(&self) -> impl Iterator<Item = &[u8]> {
        let mut start = 0;
        self.ends.iter().map(move |&end| {
            let frame = &self.octets[start..end];
            start = end;
            frame
        })
    }

    /// Whether no frame was sent.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// Removes the frames and keeps the allocated memory.
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
