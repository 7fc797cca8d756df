//! Splits a stream of bytes without timing information, as a serial port delivers it, into frames.
//!
//! When synchronised, each frame starts at the end of the previous frame. After an invalid byte, only a frame with a correct
//! checksum synchronises the stream again: a token or a short acknowledgement could be part of the data of a damaged frame.

use super::{FdlFrame, StartDelimiter};
use crate::error::WireError;
use alloc::vec::Vec;

/// A piece of the stream.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FdlPiece {
    /// The bytes of one frame, which [`FdlFrame::parse`] accepts.
    Frame(Vec<u8>),
    /// Bytes that are not a frame.
    Damaged {
        /// The bytes up to the start of the next frame or the silence.
        octets: Vec<u8>,
        /// Why they are not a frame; its offset counts from the first of them.
        why: WireError,
    },
}

/// Splits received bytes into frames; it buffers only bytes that were pushed and not yet returned.
#[derive(Clone, Debug, Default)]
pub struct Splitter {
    octets: Vec<u8>,
    /// The number of leading bytes that belong to no frame, and why.
    damaged: Option<(usize, WireError)>,
}

impl Splitter {
    /// A synchronised splitter: the next byte starts a frame.
    pub fn new() -> Splitter {
        Splitter::default()
    }

    /// Takes received bytes.
    pub fn push(&mut self, octets: &[u8]) {
        self.octets.extend_from_slice(octets);
    }

    /// Whether the last piece is incomplete.
    pub fn is_waiting(&self) -> bool {
        !self.octets.is_empty()
    }

    /// Returns the next complete piece; `None` until more bytes are pushed.
    pub fn next_piece(&mut self) -> Option<FdlPiece> {
        self.piece(false)
    }

    /// Reports that the line was silent, which ends an incomplete piece; the next byte then starts a frame. Returns the next piece.
    ///
    /// Call it until it returns `None`.
    pub fn silence(&mut self) -> Option<FdlPiece> {
        self.piece(true)
    }

    /// Returns the next piece; `is_over` means that no bytes will follow those in the buffer.
    fn piece(&mut self, is_over: bool) -> Option<FdlPiece> {
        loop {
            let rest = self.octets.get(self.damaged.map_or(0, |(count, _)| count)..).unwrap_or_default();
            let Some(first) = rest.first() else {
                return self.damaged.filter(|_| is_over).map(|(count, why)| self.damage(count, why));
            };
            let is_checked = !matches!(StartDelimiter(*first), StartDelimiter::SD4 | StartDelimiter::SC);
            let found = match FdlFrame::length(rest).map(|length| length.unwrap_or(usize::MAX)) {
                Ok(length) if length > rest.len() && !is_over => return None,
                Ok(length) => FdlFrame::parse(rest.get(..length).unwrap_or(rest)).map(|_| length),
                Err(why) => Err(why),
            };
            match (found, self.damaged) {
                (Ok(length), None) => return Some(FdlPiece::Frame(self.take(length))),
                (Ok(_), Some((count, why))) if is_checked => return Some(self.damage(count, why)),
                (_, Some((count, why))) => self.damaged = Some((count + 1, why)),
                (Err(why), None) => self.damaged = Some((1, why)),
            }
        }
    }

    fn damage(&mut self, count: usize, why: WireError) -> FdlPiece {
        self.damaged = None;
        FdlPiece::Damaged { octets: self.take(count), why }
    }

    fn take(&mut self, count: usize) -> Vec<u8> {
        let rest = self.octets.split_off(count.min(self.octets.len()));
        core::mem::replace(&mut self.octets, rest)
    }
}
