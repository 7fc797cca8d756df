//! Virtual wires with a simulated clock, traces, byte damage for tests, and capture files.
//!
//! Frames have the same types whatever their source: [`VirtualWire`] and [`VirtualBus`] move them between stations of one process
//! on a simulated clock, [`CaptureReader`] reads them from a capture file, [`Trace`] stores them.
//!
//! This crate must not know what a frame means and opens nothing itself: no socket, no serial line, and a capture is any
//! `std::io::Read` of the caller. Its only codec is that of PROFIBUS frames, because their timing depends on which of them is a
//! request, and on the Set_Prm that sets the least time until an answer.
#![allow(missing_docs, reason = "used inside this workspace only")]

mod burst_role;
mod bus;
pub mod capture;
pub mod damage;
pub mod hostile;
mod min_tsdr;
pub mod null;
pub mod record;
mod trace;
mod violation;
mod wakes;
mod wire;

pub use bus::VirtualBus;
pub use capture::{CaptureReader, PcapngWriter};
pub use trace::{Trace, TraceFrame};
pub use violation::WireViolation;
pub use wire::{TappedFrame, VirtualStep, VirtualWire};
