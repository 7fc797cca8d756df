//! The hooks of the parts that the SICK encoders share, with which a deviation can change settings, service log, round axis, button
//! and checks.
//!
//! The encoders themselves have no deviations. Without the feature `deviations` no hook is called.

use super::axis::CountedLaps;
use super::log::{Log, LogReading};
use core::time::Duration;
use device_stack::Attached;
use encoder_profile::encoder::{Gear, Hardware};
use encoder_profile::profidrive::user_parameters::UserParameterData;

/// A decision with its data; each comment describes `true`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SickCheck {
    /// A setting accepts a value: parameter and subindex, and the value.
    Setting((u16, usize), i64),
    /// The round axis is in force and gives the position.
    RoundAxis,
    /// A round axis can have this range, with the units per revolution of the user parameters.
    RoundAxisRange {
        /// The total range in units.
        range: u64,
        /// The units per revolution.
        units_per_revolution: u64,
    },
    /// The log counts a speed in revolutions per minute as motion.
    Motion(u64),
    /// A speed in revolutions per minute is the highest one of the log so far; negative in reverse.
    HighestSpeed(i64),
    /// The direction of rotation has changed. The directions are signs, 0 at rest.
    DirectionChange {
        /// The direction before.
        before: i64,
        /// The direction of the last motion.
        last: i64,
        /// The direction now.
        now: i64,
    },
    /// Releasing the button after this time makes a preset.
    ButtonPresets(Duration),
}

/// The hooks. The default implementations change nothing.
#[allow(unused_variables, reason = "the names say what a hook is given")]
pub trait SickHooks {
    /// Returns the decision to use, given the check and the decision of the manual.
    fn check(&mut self, check: SickCheck, verdict: bool) -> bool {
        verdict
    }

    /// Changes the settings that a parameter write results in, given the previous settings.
    fn settings(&mut self, number: u16, hardware: &Hardware, before: &[i64], written: &mut [i64]) {}

    /// Returns the value of a preset by the button.
    fn button(&mut self, value: u32) -> u32 {
        value
    }

    /// Changes the service log that is restored at power-up.
    fn log_loaded(&mut self, log: &mut Log) {}

    /// Returns how many turns the log counts, of which one begins if `begins`.
    fn turns(&mut self, begins: bool, right: u32) -> u32 {
        right
    }

    /// Returns the elements of the service log as they are read.
    fn log(&mut self, reading: &LogReading, right: [u64; 13]) -> [u64; 13] {
        right
    }

    /// Returns the laps that are restored at power-up, with the shaft at `now`.
    fn laps_loaded(&mut self, now: u64, laps: CountedLaps) -> CountedLaps {
        laps
    }
}

/// The calculation steps of the round axis.
#[allow(unused_variables, reason = "the names say what a step is given")]
pub trait SickSteps {
    /// Returns the gear by which the round axis counts positions, given the configured one.
    fn gear(&mut self, user: &UserParameterData, hardware: &Hardware, gear: Gear) -> Gear {
        gear
    }
}

/// The deviations attached to the shared parts.
#[derive(Clone, Debug, Default)]
pub struct SickDeviations {
    /// At the checks and values.
    pub seams: Attached<dyn SickHooks>,
    /// At the calculation steps.
    pub steps: Attached<dyn SickSteps>,
}

impl SickDeviations {
    /// Returns `verdict`, unless a deviation changes it.
    pub fn check(&self, check: SickCheck, verdict: bool) -> bool {
        self.seams.apply(verdict, |hooks, verdict| hooks.check(check, verdict))
    }
}
