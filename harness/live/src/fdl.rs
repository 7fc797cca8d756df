//! PROFIBUS frames in the bytes of a serial line.

use link::{Framing, LinePiece};
use wire::profibus::fdl::{self, Splitter};

/// Splits bytes into frames of the data link (FDL).
#[derive(Debug, Default)]
pub struct FdlFrames(Splitter);

impl Framing for FdlFrames {
    fn push(&mut self, octets: &[u8]) {
        self.0.push(octets);
    }

    fn next_piece(&mut self) -> Option<LinePiece> {
        self.0.next_piece().map(piece)
    }

    fn silence(&mut self) -> Option<LinePiece> {
        self.0.silence().map(piece)
    }

    fn is_waiting(&self) -> bool {
        self.0.is_waiting()
    }
}

fn piece(found: fdl::FdlPiece) -> LinePiece {
    match found {
        fdl::FdlPiece::Frame(octets) => LinePiece { octets, is_frame: true },
        fdl::FdlPiece::Damaged { octets, .. } => LinePiece { octets, is_frame: false },
    }
}
