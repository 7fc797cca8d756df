//! What connects stations: the virtual wire with its clock, traces, damage, capture files.
//!
//! The same frames travel here whichever wire they came from: [`VirtualWire`] moves them between stations of one
//! process on a clock that jumps, [`CaptureReader`] takes them out of a capture file, [`Trace`] keeps them.
//!
//! This room must not know what a frame means (no codec) and opens nothing itself: no socket, no serial line,
//! and a capture is whatever `std::io::Read` the caller hands in.

pub mod capture;
pub mod damage;
pub mod null;
mod shared;
mod trace;
mod wire;

pub use capture::{CaptureReader, PcapngWriter};
pub use shared::{shared, shared_file};
pub use trace::{Frame, Trace};
pub use wire::{Seen, Step, Violation, VirtualWire};
