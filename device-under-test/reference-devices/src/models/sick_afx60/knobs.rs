//! Where bugs can be put into what is these encoders' own.

use super::limits::Speeds;
pub use super::start::Fields;
use crate::models::sick::{self, settings};
use core::time::Duration;
use encoder_profile::encoder::{Hardware, Unit};

/// The own part of a behaviour.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// Whether limits of temperature and supply that are beyond theirs are clipped.
    pub clips_limits: bool,
    /// Whether limits of the speed change places where the lower one is above the upper one.
    pub exchanges_speed_limits: bool,
    /// The velocity unit of a number in P1005; none leaves it as it is.
    pub unit: fn(u16) -> Option<Unit>,
    /// Whether the mode of P1005 acts.
    pub mode_acts: bool,
    /// Whether the speed is above its limit.
    pub is_too_fast: fn(&Speeds) -> bool,
    /// Whether the speed is below its limit.
    pub is_too_slow: fn(&Speeds) -> bool,
    /// Whether a speed below its limit is a warning of the frequency.
    pub tells_low_frequency: bool,
    /// Whether a temperature is outside of its limits.
    pub temperature_is_outside: fn(f64, [f64; 2]) -> bool,
    /// Whether a supply in millivolts is below its limits, or above.
    pub voltage_is_outside: fn(u64, [u64; 2]) -> [bool; 2],
    /// Whether the encoder starts anew when the supply is back.
    pub restarts: bool,
    /// Whether a connection begins with an error of the position.
    pub begins_with_error: bool,
    /// Whether faults stay in P65001 until the next connection.
    pub faults_stay: bool,
    /// Whether a preset takes a value, from the range of positions.
    pub takes_preset: fn(u64, u64, &Hardware) -> bool,
    /// Whether a preset value beyond the range is told when it is written.
    pub warns_at_the_write: bool,
    /// Whether a preset value that is written while a preset is requested is taken at once.
    pub presets_while_requested: bool,
    /// Whether the switches ask for the reset.
    pub asks_for_reset: fn([u32; 3]) -> bool,
    /// How long the button is held for the reset, from how long it should be.
    pub reset_takes: fn(Duration) -> Duration,
    /// Whether the reset by hand does not wait for the supply to come again.
    pub resets_at_once: bool,
    /// Whether a reset leaves P1006 and P1007 as they are.
    pub reset_keeps_limits: bool,
    /// Whether a reset clears the service log.
    pub reset_clears_log: bool,
    /// What the start-up makes of P65000: whether it transmits a value, whether one is stored, and the value.
    pub start_preset: fn(bool, bool, u32) -> Option<u32>,
    /// Whether a value that the start-up brings is a preset at once.
    pub start_presets: bool,
    /// Whether P65000 takes nothing while the start-up transmits its value.
    pub start_locks: bool,
    /// Whether P971 saves P1006 and P1007.
    pub saves_limits: bool,
    /// Whether the save mode auto save acts.
    pub saves_by_itself: bool,
    /// Whether P65000 survives without power.
    pub stores_preset_value: bool,
    /// Whether a save that is interrupted has stored P65000 and not the rest.
    pub save_is_torn: bool,
    /// Whether a save during a save leaves 0 in memory.
    pub second_save_spoils: bool,
    /// Whether P1003 is reset.
    pub resets_log: bool,
    /// Whether a reset of P1003 resets P1002 too.
    pub resets_both_logs: bool,
    /// The words of the sensor status that are shown, from the right ones and the faults in P65001.
    pub words: fn([u16; 3], u64) -> [u16; 3],
    /// The counters that are shown.
    pub counters: fn([u16; 16]) -> [u16; 16],
    /// A counter of P1004, from what it would be and its highest value.
    pub counted: fn(u16, u16) -> u16,
    /// Whether P980 can be written.
    pub list_is_writable: bool,
    /// Whether the round axis can be switched on without there being one, and then breaks the position.
    pub breaks_without_axis: bool,
    /// Whether the record of a start acts.
    pub takes_start_record: bool,
    /// The record of a start, as it is understood.
    pub understands: fn(Fields) -> Fields,
    /// Whether the record of a start is right, from whether it should be.
    pub judges_start_record: fn(bool, &Fields) -> bool,
}

/// All that a model of it reads: what the encoders of SICK share, and its own.
#[derive(Clone, Copy, Debug, Default)]
pub struct Knobs {
    /// What the encoders of SICK share.
    pub sick: sick::knobs::Rules,
    /// Its own.
    pub own: Rules,
}

impl Default for Rules {
    fn default() -> Rules {
        Rules {
            clips_limits: false,
            exchanges_speed_limits: false,
            unit: settings::unit,
            mode_acts: true,
            is_too_fast: |speeds| speeds.rpm.abs() > speeds.highest,
            is_too_slow: |speeds| speeds.rpm.abs() < speeds.lowest,
            tells_low_frequency: false,
            temperature_is_outside: |celsius, [lower, upper]| celsius < lower || celsius > upper,
            voltage_is_outside: |millivolts, [lower, upper]| [millivolts < lower, millivolts > upper],
            restarts: true,
            begins_with_error: false,
            faults_stay: false,
            takes_preset: |value, range, _| value < range,
            warns_at_the_write: false,
            presets_while_requested: false,
            asks_for_reset: |switches| switches == [8; 3],
            reset_takes: |right| right,
            resets_at_once: false,
            reset_keeps_limits: false,
            reset_clears_log: false,
            start_preset: |transmits, _, value| transmits.then_some(value),
            start_presets: false,
            start_locks: false,
            saves_limits: true,
            saves_by_itself: true,
            stores_preset_value: true,
            save_is_torn: false,
            second_save_spoils: false,
            resets_log: true,
            resets_both_logs: false,
            words: |right, _| right,
            counters: |right| right,
            counted: u16::min,
            list_is_writable: false,
            breaks_without_axis: false,
            takes_start_record: true,
            understands: |fields| fields,
            judges_start_record: |right, _| right,
        }
    }
}
