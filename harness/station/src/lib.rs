//! What a party on a wire is.
//!
//! A [`Station`] is given a frame or a deadline and the time `now`; it hands back frames and names its next
//! deadline. It does no I/O and has no clock, so that the same station runs on a virtual wire, on a network
//! interface and on a socket. A [`Stand`] is what holds a device under test in its hands: power, shaft, buttons.
//!
//! This room must not know what the frames mean: no protocol, no device, no file, no socket.
#![no_std]

extern crate alloc;

mod outbox;
mod parity;
mod stand;
mod time;

pub use core::time::Duration;
pub use outbox::Outbox;
pub use parity::Parity;
pub use stand::{Refusal, Stand, StandAction};
pub use time::Time;

/// A party on a wire: a state machine that turns frames and deadlines into frames.
///
/// The caller keeps one rule: one input, then all outputs are taken from the outbox, then the next input.
pub trait Station {
    /// Takes one frame off the wire at `now`; the frames it answers with are put into `out`.
    ///
    /// Every frame on the segment is offered, also those for others: address filtering is the station's own.
    fn receive(&mut self, now: Time, frame: &[u8], out: &mut Outbox);

    /// Does what is due at `now`; the frames it sends are put into `out`.
    ///
    /// It may be called early or late; a station then does what is due and nothing else.
    fn wake(&mut self, now: Time, out: &mut Outbox);

    /// Hears that another party begins to send at `now`, where the wire lets that be noticed.
    ///
    /// Only who waits for an answer on a bus needs it; [`Station::receive`] comes when the frame has ended.
    fn carrier(&mut self, now: Time) {
        let _ = now;
    }

    /// The next time at which [`Station::wake`] has something to do, or `None` while only a frame can change that.
    fn deadline(&self) -> Option<Time>;
}
