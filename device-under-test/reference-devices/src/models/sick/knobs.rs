//! Where bugs can be put into what the encoders of SICK share.

use core::time::Duration;
use encoder_profile::encoder::{Gear, Hardware};
use encoder_profile::profidrive::user_parameters::UserParameters;

/// What a log is shown from.
#[derive(Clone, Copy, Debug)]
pub struct Entries {
    /// P1002 or P1003.
    pub number: u16,
    /// The present speed in revolutions per minute.
    pub rpm: i64,
    /// The operating time.
    pub operating: Duration,
    /// The voltage in millivolts.
    pub millivolts: u64,
    /// What is right.
    pub right: [u64; 13],
}

/// The shared part of a behaviour.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// Whether a setting takes a value: parameter and subindex, the value, and whether it is within its limits.
    pub takes: fn((u16, usize), i64, bool) -> bool,
    /// What a setting of P1005 or P1009 becomes, from what is written.
    pub settled: fn((u16, usize), u64, &Hardware) -> u64,
    /// Whether settings that are written are kept.
    pub keeps_settings: bool,
    /// The value of a preset by the button; none does nothing.
    pub button: fn(u32) -> Option<u32>,
    /// Whether the button needs class 4.
    pub button_needs_class_4: bool,
    /// Whether the service log survives without power.
    pub log_survives: bool,
    /// The number of power-ups, from the one before.
    pub power_ups: fn(u32) -> u32,
    /// The slowest motion in rpm, from the right one.
    pub motion: fn(u64) -> u64,
    /// Whether a turn in this sense counts forward, and in reverse.
    pub turns: fn(i64) -> [bool; 2],
    /// Whether the direction has changed, from the sense before (0 at rest), the last one that was none, and that of
    /// now.
    pub is_change: fn(i64, i64, i64) -> bool,
    /// The log that is shown.
    pub log: fn(&Entries) -> [u64; 13],
    /// Whether the outputs of P1009 can be written.
    pub outputs_are_writable: bool,
    /// Whether nominator and divisor survive without power and a reset.
    pub axis_survives: bool,
    /// The laps after power-up, from those before.
    pub laps: fn(i64) -> i64,
    /// Whether laps take in the way that was gone without power.
    pub counts_way_without_power: bool,
    /// The speed that the log takes for the highest one, from the speed in revolutions per minute.
    pub highest_speed: fn(i64) -> u64,
    /// The gear of the round axis, from the one that is set.
    pub gear: fn(Gear, &UserParameters) -> Gear,
    /// Whether the round axis acts.
    pub axis_acts: bool,
    /// Whether the range of a round axis is right at a start, from whether it should be.
    pub judges_axis: fn(bool, &UserParameters) -> bool,
}

impl Default for Rules {
    fn default() -> Rules {
        Rules {
            takes: |_, _, right| right,
            settled: |_, value, _| value,
            keeps_settings: true,
            button: Some,
            button_needs_class_4: true,
            log_survives: true,
            power_ups: |before| before + 1,
            motion: |right| right,
            turns: |sense| [sense > 0, sense < 0],
            is_change: |_, last, now| last == -now,
            log: |entries| entries.right,
            outputs_are_writable: false,
            axis_survives: false,
            laps: |laps| laps,
            counts_way_without_power: true,
            highest_speed: i64::unsigned_abs,
            gear: |gear, _| gear,
            axis_acts: true,
            judges_axis: |right, _| right,
        }
    }
}
