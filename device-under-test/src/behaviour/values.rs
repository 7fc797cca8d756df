//! What single parameters say.

use crate::encoder::{Hardware, Measuring};
use crate::encoder_object::Facts;
use crate::profidrive::user_parameters::UserParameters;
use station::Time;
use wire::profidrive::Format;

/// What the values of parameters could be taken from.
#[derive(Debug)]
pub struct View<'a> {
    /// Now.
    pub now: Time,
    /// What the manual says.
    pub facts: &'static Facts,
    /// What the sensor tells apart.
    pub hardware: Hardware,
    /// What that of another encoder of the manual tells apart; the same if there is no other.
    pub other: Hardware,
    /// The user parameters in force.
    pub user: &'a UserParameters,
    /// The measuring task.
    pub measuring: &'a Measuring,
    /// The preset value.
    pub preset_value: u32,
    /// The offset that was in memory at power-up.
    pub offset_at_power_up: u64,
    /// The IP address before the last assignment.
    pub address_before: [u8; 4],
}

/// Values of single parameters.
#[derive(Clone, Copy, Debug)]
pub struct Values {
    /// What an element or octet says, from its parameter number and subindex and the right value.
    pub element: fn(&View<'_>, (u16, usize), u64) -> u64,
    /// How many elements a parameter has, from its number and the right count.
    pub elements: fn(u16, usize) -> usize,
    /// The format of a parameter, from its number and the right one.
    pub format: fn(u16, Format) -> Format,
    /// Whether a value starts a save when it is written to P971; none if it is refused.
    pub saves: fn(u64) -> Option<bool>,
    /// What P65000 becomes when it is written.
    pub preset_value: fn(u32) -> u32,
    /// Whether writing P65000 carries out a preset.
    pub preset_value_presets: bool,
}

impl Default for Values {
    fn default() -> Values {
        Values {
            element: |_, _, right| right,
            elements: |_, right| right,
            format: |_, right| right,
            saves: |value| (value <= 1).then_some(value == 1),
            preset_value: |value| value,
            preset_value_presets: false,
        }
    }
}
