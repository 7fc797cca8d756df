//! The preset: bit 31 of the outputs starts it, bits 0 to 30 are its value (manual, 6.6).

use super::encoder::Amt58;
use super::hooks::{Amt58Check, NewOffset};
use encoder_profile::encoder::PresetMode;
use station::Time;

/// The bit that starts a preset.
pub const TRIGGER: u32 = 0x8000_0000;
/// The bits of the preset value.
pub const VALUE: u32 = 0x7FFF_FFFF;
/// In how many consecutive cycles the bit has to be set, as in the example of 6.6.
pub const CYCLES: u32 = 3;

impl Amt58 {
    /// Processes the outputs of a cycle: each time that bit 31 is set for three cycles, one preset is made.
    pub(super) fn take_outputs(&mut self, now: Time, octets: [u8; 4]) {
        let outputs = u32::from_be_bytes(octets);
        let outputs = self.hooks.apply(outputs, |hooks, outputs| hooks.outputs(&self.view(now), outputs));
        let before = self.ram.preset_cycles;
        let cycles = if outputs & TRIGGER == 0 { 0 } else { before.saturating_add(1) };
        self.ram.preset_cycles = cycles;
        if self.check(now, Amt58Check::PresetCycles(cycles), cycles == CYCLES) {
            self.preset(now, (outputs & VALUE).into());
        }
    }

    /// Sets the current position to `value`, if that is less than the total resolution in force, and stores the offset at once.
    fn preset(&mut self, now: Time, value: u64) {
        self.sample(now);
        let measuring = &self.ram.measuring;
        if !self.check(now, Amt58Check::PresetValue(value), value < measuring.range()) {
            return;
        }
        let offset = measuring.preset(PresetMode::Absolute, value) as i64;
        // The diagnosis shows the offset with its sign (6.7), positions only need it within the range.
        let is_back = value < measuring.position();
        let offset = if is_back { offset - measuring.range() as i64 } else { offset };
        let offset = self.hooks.apply(offset, |hooks, offset| hooks.offset(&self.view(now), NewOffset::Preset, offset));
        self.use_offset(offset);
        let stored = self.hooks.apply(Some(offset), |hooks, stored| hooks.store(&self.view(now), stored));
        if let Some(offset) = stored {
            self.stored_offset.replace(offset);
        }
    }

    /// Adds this offset to all positions from now on.
    pub(super) fn use_offset(&mut self, offset: i64) {
        let measuring = &mut self.ram.measuring;
        let range = i64::try_from(measuring.range().max(1)).unwrap_or(i64::MAX);
        measuring.offset = offset.rem_euclid(range) as u64;
        self.ram.offset = offset;
    }
}
