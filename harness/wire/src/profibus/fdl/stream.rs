//! Frames out of a stream of octets whose gaps in time were lost, as a serial port hands it over.
//!
//! In step, a frame begins where the one before ended. Once an octet does not fit, only a frame with a right checksum brings
//! the stream back in step: a token or a short acknowledgement could stand anywhere in the data of a damaged frame.

use super::{Frame, Start};
use crate::error::WireError;
use alloc::vec::Vec;

/// What a stream yields next.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Piece {
    /// The octets of one frame, which [`Frame::parse`] reads.
    Frame(Vec<u8>),
    /// Octets that are no frame.
    Damaged {
        /// The octets, all up to where the next frame begins or the silence came.
        octets: Vec<u8>,
        /// Why they are no frame, counted from the first of them.
        why: WireError,
    },
}

/// Takes octets as they come and hands out frames; it holds no more than was pushed and not yet handed out.
#[derive(Clone, Debug, Default)]
pub struct Splitter {
    octets: Vec<u8>,
    /// Octets at the beginning that belong to no frame, and why.
    damaged: Option<(usize, WireError)>,
}

impl Splitter {
    /// A splitter in step: the next octet begins a frame.
    pub fn new() -> Splitter {
        Splitter::default()
    }

    /// Takes octets.
    pub fn push(&mut self, octets: &[u8]) {
        self.octets.extend_from_slice(octets);
    }

    /// Whether octets wait for others to follow.
    pub fn is_waiting(&self) -> bool {
        !self.octets.is_empty()
    }

    /// The next piece that is complete; none until more octets are pushed.
    pub fn next_piece(&mut self) -> Option<Piece> {
        self.piece(false)
    }

    /// Says that the wire was silent, so that what waits is over and the next octet begins a frame; gives the next piece.
    ///
    /// To be called again until it gives none.
    pub fn silence(&mut self) -> Option<Piece> {
        self.piece(true)
    }

    /// The next piece; `is_over` says that no octets will follow those that are there.
    fn piece(&mut self, is_over: bool) -> Option<Piece> {
        loop {
            let rest = self.octets.get(self.damaged.map_or(0, |(count, _)| count)..).unwrap_or_default();
            let Some(first) = rest.first() else {
                return self.damaged.filter(|_| is_over).map(|(count, why)| self.damage(count, why));
            };
            let is_checked = !matches!(Start(*first), Start::SD4 | Start::SC);
            let found = match Frame::length(rest).map(|length| length.unwrap_or(usize::MAX)) {
                Ok(length) if length > rest.len() && !is_over => return None,
                Ok(length) => Frame::parse(rest.get(..length).unwrap_or(rest)).map(|_| length),
                Err(why) => Err(why),
            };
            match (found, self.damaged) {
                (Ok(length), None) => return Some(Piece::Frame(self.take(length))),
                (Ok(_), Some((count, why))) if is_checked => return Some(self.damage(count, why)),
                (_, Some((count, why))) => self.damaged = Some((count + 1, why)),
                (Err(why), None) => self.damaged = Some((1, why)),
            }
        }
    }

    fn damage(&mut self, count: usize, why: WireError) -> Piece {
        self.damaged = None;
        Piece::Damaged { octets: self.take(count), why }
    }

    fn take(&mut self, count: usize) -> Vec<u8> {
        let rest = self.octets.split_off(count.min(self.octets.len()));
        core::mem::replace(&mut self.octets, rest)
    }
}
