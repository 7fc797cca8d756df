//! The hooks of what the encoders of SICK share: the seams at which a deviation may change settings, service log, round axis and
//! button, and the checks that it may flip.
//!
//! The encoders themselves are plain. Without the feature `deviations` no hook is ever called.

use super::axis::CountedLaps;
use super::log::{Log, LogReading};
use core::time::Duration;
use device_stack::Attached;
use encoder_profile::encoder::{Gear, Hardware};
use encoder_profile::profidrive::user_parameters::UserParameterData;

/// A decision, with what it is about; the comment says what `true` means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Check {
    /// A setting takes a value: parameter and subindex, and the value.
    Setting((u16, usize), i64),
    /// The round axis is in force and gives the position.
    RoundAxis,
    /// A round axis can have this range, with these units per revolution in the user parameters.
    RoundAxisRange {
        /// The range.
        range: u64,
        /// The units per revolution.
        units_per_revolution: u64,
    },
    /// The log counts a speed in revolutions per minute as motion.
    Motion(u64),
    /// A speed in revolutions per minute is the highest one of the log so far; negative in reverse.
    HighestSpeed(i64),
    /// The direction has changed, from the sense of the motion before (0 at rest), the last one that was none, and that of now.
    DirectionChange {
        /// Before.
        before: i64,
        /// The last one that was no rest.
        last: i64,
        /// Now.
        now: i64,
    },
    /// The button was held for so long and is let go: that is a preset.
    ButtonPresets(Duration),
}

/// The hooks; each default changes nothing.
#[allow(unused_variables, reason = "the names say what a hook is given")]
pub trait SickHooks {
    /// The decision that counts, from what it is about and the decision of the manual.
    fn check(&mut self, check: Check, verdict: bool) -> bool {
        verdict
    }

    /// Changes what the settings of a parameter become, from what they were.
    fn settings(&mut self, number: u16, hardware: &Hardware, before: &[i64], written: &mut [i64]) {}

    /// The value of a preset by the button.
    fn button(&mut self, value: u32) -> u32 {
        value
    }

    /// Changes the service log that comes from memory at power-up.
    fn log_loaded(&mut self, log: &mut Log) {}

    /// The elements of a service log that is read.
    fn log(&mut self, reading: &LogReading, right: [u64; 13]) -> [u64; 13] {
        right
    }

    /// The laps that come from memory at power-up, where the encoder stands `now`.
    fn laps_loaded(&mut self, now: u64, laps: CountedLaps) -> CountedLaps {
        laps
    }
}

/// The steps of the round axis.
#[allow(unused_variables, reason = "the names say what a step is given")]
pub trait SickSteps {
    /// The gear by which the round axis counts positions, from the one that is set.
    fn gear(&mut self, user: &UserParameterData, hardware: &Hardware, gear: Gear) -> Gear {
        gear
    }
}

/// The handles of the deviations of what is shared.
#[derive(Clone, Debug, Default)]
pub struct Hooks {
    /// At the seams and checks.
    pub seams: Attached<dyn SickHooks>,
    /// At the steps.
    pub steps: Attached<dyn SickSteps>,
}

impl Hooks {
    /// The decision that counts: `verdict`, unless a deviation flips it.
    pub fn check(&self, check: Check, verdict: bool) -> bool {
        self.seams.apply(verdict, |hooks, verdict| hooks.check(check, verdict))
    }
}
