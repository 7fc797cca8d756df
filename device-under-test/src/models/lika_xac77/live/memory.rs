//! Presets, the preset value and their way into memory.

use super::{Live, OFFSET_WRITE, SAVE};
use crate::encoder::PresetMode;
use crate::encoder::memory::Outcome;

impl Live<'_> {
    /// Ends the writes that are done.
    pub(super) fn settle(&mut self) {
        if let Some(outcome) = self.store.offset.settle(self.now, self.faults.memory) {
            let carried_out = outcome == Outcome::Written || !self.behaviour.memory.heeds_failure;
            if let Some(offset) = self.ram.next_offset.take() {
                if carried_out {
                    self.ram.measuring.offset = offset;
                }
                self.ram.sensor.preset_done(carried_out);
            }
        }
        if let Some(outcome) = self.store.preset_value.settle(self.now, self.faults.memory) {
            self.ram.is_saving = (self.behaviour.memory.stays_after_save)(outcome);
            if self.behaviour.memory.save_restores_offset {
                self.store.offset.replace(self.ram.offset_at_power_up);
            }
        }
    }

    /// Gives P65000 a value.
    pub fn set_preset_value(&mut self, value: u32) {
        self.ram.preset_value = value;
        if self.behaviour.memory.stores_every_write {
            self.store.preset_value.replace(value);
        }
        if self.behaviour.values.preset_value_presets {
            self.ram.measuring.offset = self.ram.measuring.preset(PresetMode::Absolute, value.into());
        }
    }

    /// Begins to save P65000.
    pub fn save(&mut self) {
        let is_running = self.store.preset_value.deadline().is_some();
        if (self.behaviour.memory.begins_save)(self.ram.saves, is_running) {
            self.store.preset_value.write(self.now, self.ram.preset_value, SAVE);
            self.ram.is_saving = true;
        }
        self.ram.saves += 1;
    }

    /// Begins a preset: the offset is computed now and takes effect when it is stored.
    pub(super) fn preset(&mut self, mode: PresetMode) {
        let heeded = self.behaviour.sensor.presets_with_errors || self.ram.sensor.errors().is_empty();
        if !heeded || !(self.behaviour.user_parameters.presets)(&self.ram.user) {
            self.ram.sensor.preset_done(true);
            return;
        }
        let rules = &self.behaviour.memory;
        let value = match rules.presets_stored_value {
            true => *self.store.preset_value.stored(),
            false => self.ram.preset_value,
        };
        let offset = self.ram.measuring.preset(mode, value.into());
        let stores = (rules.stores_offset)(mode);
        if stores {
            self.store.offset.write(self.now, offset, OFFSET_WRITE);
        }
        if stores && rules.waits_for_store {
            self.ram.next_offset = Some(offset);
        } else {
            self.ram.measuring.offset = offset;
            self.ram.sensor.preset_done(true);
        }
    }
}
