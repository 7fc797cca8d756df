//! The line to a live device with its frame filter: Ethernet frames, or PROFIBUS on a serial line.
//!
//! This module must not know what is sent, nor why.

use super::fence::Fence;
use super::frame_limits::FrameLimits;
use super::guard::Guard;
use super::withheld::WithheldFrames;
use link::{Lateness, LinkError, SerialBus, Wire};
use station::{Duration, Time};

/// The line to a live device, with the filter that withholds frames without consent.
#[derive(Debug)]
pub enum DeviceLine {
    /// Ethernet frames.
    Wire(Box<Wire>, Guard),
    /// PROFIBUS.
    Bus(Box<SerialBus>, Fence),
}

impl DeviceLine {
    /// The current time of its clock.
    pub fn now(&self) -> Time {
        match self {
            DeviceLine::Wire(wire, _) => wire.now(),
            DeviceLine::Bus(bus, _) => bus.now(),
        }
    }

    /// Sets the clock to zero, discards received frames, and resets the lateness statistics.
    pub fn restart(&mut self) {
        match self {
            DeviceLine::Wire(wire, _) => {
                wire.restart();
                wire.reset_lateness();
            }
            DeviceLine::Bus(bus, _) => {
                bus.restart();
                bus.reset_lateness();
            }
        }
    }

    /// How late the harness's stations were woken.
    pub fn lateness(&self) -> &Lateness {
        match self {
            DeviceLine::Wire(wire, _) => wire.lateness(),
            DeviceLine::Bus(bus, _) => bus.lateness(),
        }
    }

    /// How long programs of this host waited for a processor since the restart, if the device is one of them.
    pub fn shortage(&self) -> Option<Duration> {
        match self {
            DeviceLine::Wire(wire, _) => wire.shortage(),
            DeviceLine::Bus(bus, _) => bus.shortage(),
        }
    }

    /// Runs the next event without a station of the harness, not later than `until`; fails if the line is lost.
    pub fn step_alone(&mut self, until: Time) -> Result<(), LinkError> {
        match self {
            DeviceLine::Wire(wire, guard) => {
                wire.step(&mut [], until, &mut |frame| guard.allows(frame), &mut |_, _| {}).map(|_| ())
            }
            DeviceLine::Bus(bus, fence) => {
                bus.step(&mut [], until, &mut |frame| fence.allows(frame), &mut |_| {}).map(|_| ())
            }
        }
    }

    /// Tries to reopen a lost line until its clock reaches `until`; fails if it is still lost then.
    pub fn recover(&mut self, until: Time) -> Result<(), LinkError> {
        match self {
            DeviceLine::Wire(wire, _) => wire.recover(until),
            DeviceLine::Bus(bus, _) => bus.recover(until),
        }
    }

    /// The limits for drawn sequences, through which every frame then passes.
    pub fn limits_mut(&mut self) -> &mut Option<Box<FrameLimits>> {
        match self {
            DeviceLine::Wire(_, guard) => guard.limits_mut(),
            DeviceLine::Bus(_, fence) => fence.limits_mut(),
        }
    }

    /// The withheld frames.
    pub fn withheld_frames(&self) -> &WithheldFrames {
        match self {
            DeviceLine::Wire(_, guard) => guard.withheld_frames(),
            DeviceLine::Bus(_, fence) => fence.withheld_frames(),
        }
    }

    /// Forgets the withheld frames.
    pub fn forget_withheld(&mut self) {
        match self {
            DeviceLine::Wire(_, guard) => guard.forget_withheld(),
            DeviceLine::Bus(_, fence) => fence.forget_withheld(),
        }
    }
}
