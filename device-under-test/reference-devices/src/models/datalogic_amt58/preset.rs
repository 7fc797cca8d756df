//! The preset: bit 31 of the outputs in three cycles in a row, and bits 0 to 30 as its value (manual, 6.6).

use super::program::Program;
use encoder_profile::encoder::Hardware;

/// The bit that asks for a preset.
pub const TRIGGER: u32 = 0x8000_0000;
/// The bits of the value.
pub const VALUE: u32 = 0x7FFF_FFFF;
/// In how many cycles in a row it has to be asked for.
pub const CYCLES: u32 = 3;

/// What the outputs so far ask for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Trigger {
    /// In how many cycles in a row the bit was set.
    pub count: u32,
    /// The outputs of the cycle before.
    pub before: u32,
    /// How many presets there were since power-up.
    pub presets: u32,
}

/// What a cycle asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// Nothing.
    Nothing,
    /// A preset to this value.
    Preset(u32),
    /// The offset is to be what it was before the last preset.
    Undo,
    /// A revolution is to have so many units from now on.
    Units(u64),
}

/// A preset that is wanted.
#[derive(Clone, Copy, Debug)]
pub struct Wanted<'a> {
    /// Its value.
    pub value: u32,
    /// The range of positions.
    pub range: u64,
    /// The program in force.
    pub program: &'a Program,
    /// The hardware.
    pub hardware: &'a Hardware,
    /// Whether the shaft turns.
    pub is_moving: bool,
    /// How many presets there were since power-up.
    pub presets: u32,
}

/// What the outputs of a cycle ask for: one preset each time that the bit stands for three cycles.
pub fn order(trigger: &mut Trigger, outputs: u32) -> Order {
    ordered_after(CYCLES, trigger, outputs)
}

/// The same with another number of cycles.
pub fn ordered_after(cycles: u32, trigger: &mut Trigger, outputs: u32) -> Order {
    trigger.count = if outputs & TRIGGER == 0 { 0 } else { trigger.count.saturating_add(1) };
    match trigger.count == cycles {
        true => Order::Preset(outputs & VALUE),
        false => Order::Nothing,
    }
}

/// The value of a preset, if it is within the range of positions.
pub fn taken(wanted: &Wanted<'_>) -> Option<u64> {
    let value = u64::from(wanted.value);
    (value < wanted.range).then_some(value)
}
