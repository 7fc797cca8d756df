//! What single parameters say.

use crate::encoder::PresetMode;
use wire::profidrive::Format;

/// Values of single parameters.
#[derive(Clone, Copy, Debug)]
pub struct Values {
    /// How many elements a parameter has, from its number and the right count.
    pub elements: fn(u16, usize) -> usize,
    /// The format of a parameter, from its number and the right one.
    pub format: fn(u16, Format) -> Format,
    /// Whether a value starts a save when it is written to P971; none if it is refused.
    pub saves: fn(u64) -> Option<bool>,
    /// What P65000 becomes when it is written.
    pub preset_value: fn(u32) -> u32,
    /// The value of a preset that G1_STW asks for, from P65000 and the word that asks for one without a handshake.
    pub preset_from: fn(u32, Option<u32>) -> u32,
    /// P65000 after it was written, from whether that is in the start-up, what it was and what was written.
    pub takes_preset_value: fn(bool, u32, u32) -> u32,
    /// Whether P65000 takes a value, from the range of positions.
    pub preset_value_fits: fn(u32, u64) -> bool,
    /// The units by which a preset sets or shifts, from P65000 and the range of positions.
    pub preset_units: fn(PresetMode, u32, u64) -> u64,
    /// Whether writing P65000 carries out a preset.
    pub preset_value_presets: bool,
}

impl Default for Values {
    fn default() -> Values {
        Values {
            elements: |_, right| right,
            format: |_, right| right,
            saves: |value| (value <= 1).then_some(value == 1),
            preset_value: |value| value,
            preset_from: |parameter, _| parameter,
            takes_preset_value: |_, _, written| written,
            preset_value_fits: |_, _| true,
            preset_units,
            preset_value_presets: false,
        }
    }
}

/// An absolute preset takes the value as it is, a relative one shifts by it as a signed number.
pub fn preset_units(mode: PresetMode, value: u32, range: u64) -> u64 {
    match mode {
        PresetMode::Absolute => value.into(),
        PresetMode::Relative => i64::from(value as i32).rem_euclid(range.max(1) as i64) as u64,
    }
}
