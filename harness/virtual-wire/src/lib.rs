//! What connects stations: the virtual wires with their clock, traces, damage, capture files.
//!
//! The same frames travel here whichever wire they came from: [`VirtualWire`] and [`VirtualBus`] move them between stations
//! of one process on a clock that jumps, [`CaptureReader`] takes them out of a capture file, [`Trace`] keeps them.
//!
//! This room must not know what a frame means and opens nothing itself: no socket, no serial line, and a capture is
//! whatever `std::io::Read` the caller hands in. The one codec it has is that of the frames of PROFIBUS, whose
//! timing depends on which of them is a request.

mod bus;
pub mod capture;
pub mod damage;
pub mod null;
pub mod record;
mod trace;
mod violation;
mod wakes;
mod wire;

pub use bus::VirtualBus;
pub use capture::{CaptureReader, PcapngWriter};
pub use trace::{Frame, Trace};
pub use violation::Violation;
pub use wire::{Seen, Step, VirtualWire};
