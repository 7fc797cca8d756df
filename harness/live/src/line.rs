//! The line to a live device with the fence before it: Ethernet frames, or a PROFIBUS at a serial line.
//!
//! This room must not know what is sent, nor why.

use super::fence::Fence;
use super::guard::Guard;
use super::held_back::HeldBack;
use link::{Lateness, LinkError, SerialBus, Wire};
use station::Time;

/// The line to a live device, with what holds our frames back that nobody consented to.
#[derive(Debug)]
pub enum Line {
    /// Ethernet frames.
    Wire(Box<Wire>, Guard),
    /// PROFIBUS.
    Bus(Box<SerialBus>, Fence),
}

impl Line {
    /// What its clock shows.
    pub fn now(&self) -> Time {
        match self {
            Line::Wire(wire, _) => wire.now(),
            Line::Bus(bus, _) => bus.now(),
        }
    }

    /// Sets the clock to zero, throws away what came before, and forgets how punctual we were.
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

    /// How punctual our stations were woken.
    pub fn lateness(&self) -> &Lateness {
        match self {
            Line::Wire(wire, _) => wire.lateness(),
            Line::Bus(bus, _) => bus.lateness(),
        }
    }

    /// Lets the next thing happen without a station of ours, not later than `until`; fails where the line is gone.
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

    /// Tries to get a line back that is gone, until its clock shows `until`; fails where it is still gone then.
    pub fn recover(&mut self, until: Time) -> Result<(), LinkError> {
        match self {
            Line::Wire(wire, _) => wire.recover(until),
            Line::Bus(bus, _) => bus.recover(until),
        }
    }

    /// What was held back.
    pub fn held_back(&self) -> &HeldBack {
        match self {
            Line::Wire(_, guard) => guard.held_back(),
            Line::Bus(_, fence) => fence.held_back(),
        }
    }

    /// Forgets what was held back.
    pub fn forget_held_back(&mut self) {
        match self {
            Line::Wire(_, guard) => guard.forget_held_back(),
            Line::Bus(_, fence) => fence.forget_held_back(),
        }
    }
}
