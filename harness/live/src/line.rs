//! The line to a live device with its frame filter: Ethernet frames, or PROFIBUS on a serial line.
//!
//! This module must not know what is sent, nor why.

use super::fence::Fence;
use super::guard::Guard;
use super::held_back::HeldBack;
use link::{Lateness, LinkError, SerialBus, Wire};
use station::Time;

/// The line to a live device, with the filter that withholds frames without consent.
#[derive(Debug)]
pub enum Line {
    /// Ethernet frames.
    Wire(Box<Wire>, Guard),
    /// PROFIBUS.
    Bus(Box<SerialBus>, Fence),
}

impl Line {
    /// The current time of its clock.
    pub fn now(&self) -> Time {
        match self {
            Line::Wire(wire, _) => wire.now(),
            Line::Bus(bus, _) => bus.now(),
        }
    }

    /// Sets the clock to zero, discards received frames, and resets the lateness statistics.
    pub fn restart(&mut self) {
        match self {
            Line::Wire(wire, _) => {
                wire.restart();
                wire.reset_lateness();
            }
            Line::Bus(bus, _) => {
                bus.restart();
                bus.reset_lateness();
            }
        }
    }

    /// How late the harness's stations were woken.
    pub fn lateness(&self) -> &Lateness {
        match self {
            Line::Wire(wire, _) => wire.lateness(),
            Line::Bus(bus, _) => bus.lateness(),
        }
    }

    /// Runs the next event without a station of the harness, not later than `until`; fails if the line is lost.
    pub fn step_alone(&mut self, until: Time) -> Result<(), LinkError> {
        match self {
            Line::Wire(wire, guard) => {
                wire.step(&mut [], until, &mut |frame| guard.allows(frame), &mut |_, _| {}).map(|_| ())
            }
            Line::Bus(bus, fence) => {
                bus.step(&mut [], until, &mut |frame| fence.allows(frame), &mut |_| {}).map(|_| ())
            }
        }
    }

    /// Tries to reopen a lost line until its clock reaches `until`; fails if it is still lost then.
    pub fn recover(&mut self, until: Time) -> Result<(), LinkError> {
        match self {
            Line::Wire(wire, _) => wire.recover(until),
            Line::Bus(bus, _) => bus.recover(until),
        }
    }

    /// The withheld frames.
    pub fn held_back(&self) -> &HeldBack {
        match self {
            Line::Wire(_, guard) => guard.held_back(),
            Line::Bus(_, fence) => fence.held_back(),
        }
    }

    /// Forgets the withheld frames.
    pub fn forget_held_back(&mut self) {
        match self {
            Line::Wire(_, guard) => guard.forget_held_back(),
            Line::Bus(_, fence) => fence.forget_held_back(),
        }
    }
}
