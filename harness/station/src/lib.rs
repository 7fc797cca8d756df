//! The trait of a station on a wire, and of the stand of a device under test.
//!
//! A [`Station`] takes a frame or a deadline and the time `now`; it returns frames and its next deadline. It does no I/O and
//! has no clock, so the same station runs on a virtual wire, on a network interface and on a socket. A [`Stand`] controls the
//! power, the shaft and the buttons of a device under test.
//!
//! This crate must not know what the frames mean: no protocol, no device, no file, no socket.
#![no_std]

extern crate alloc;

mod outbox;
mod parity;
mod stand;
mod time;

use alloc::boxed::Box;
pub use core::time::Duration;
pub use outbox::Outbox;
pub use parity::Parity;
pub use stand::{Stand, StandAction, StandRefusal};
pub use time::Time;

/// A station on a wire: a state machine that turns frames and deadlines into frames.
///
/// The caller gives one input, takes all outputs from the outbox, and only then gives the next input.
pub trait Station {
    /// Receives one frame at `now` and puts its answers into `out`.
    ///
    /// The caller passes every frame of the segment, also those for other stations; the station filters by address.
    fn receive(&mut self, now: Time, frame: &[u8], out: &mut Outbox);

    /// Does what is due at `now` and puts the frames that it sends into `out`.
    ///
    /// It may be called early or late; the station does only what is due at `now`.
    fn wake(&mut self, now: Time, out: &mut Outbox);

    /// Reports that another station starts to send at `now`, on a wire where this can be detected.
    ///
    /// Only a station that waits for an answer on a bus needs it; [`Station::receive`] follows when the frame has ended.
    fn carrier(&mut self, now: Time) {
        let _ = now;
    }

    /// The next time at which [`Station::wake`] has something to do, or `None` while the station only waits for frames.
    fn deadline(&self) -> Option<Time>;
}

impl<S: Station + ?Sized> Station for Box<S> {
    fn receive(&mut self, now: Time, frame: &[u8], out: &mut Outbox) {
        (**self).receive(now, frame, out);
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        (**self).wake(now, out);
    }

    fn carrier(&mut self, now: Time) {
        (**self).carrier(now);
    }

    fn deadline(&self) -> Option<Time> {
        (**self).deadline()
    }
}
