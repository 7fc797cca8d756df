//! Presets, the preset value and their way into memory.

use super::{Live, OFFSET_WRITE, SAVE, Save};
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
        match self.store.preset_value.settle(self.now, self.faults.memory) {
            Some(Outcome::Written) if self.behaviour.memory.ends_save => self.ram.save = Save::Done,
            Some(Outcome::Written) => self.ram.save = Save::Running,
            Some(Outcome::Failed) => self.ram.save = Save::Failed,
            None => {}
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
        self.store.preset_value.write(self.now, self.ram.preset_value, SAVE);
        self.ram.save = Save::Running;
    }

    /// Begins a preset: the offset is computed now and takes effect when it is stored.
    pub(super) fn preset(&mut self, mode: PresetMode) {
        if !(self.behaviour.user_parameters.presets)(&self.ram.user) {
            self.ram.sensor.preset_done(true);
            return;
        }
        let rules = &self.behaviour.memory;
        let value = match rules.presets_stored_value {
            true => *self.store.preset_value.stored(),
            false => self.ram.preset_value,
        };
        let offset = self.ram.measuring.preset(mode, value.into());
        if rules.stores_offset {
            self.store.offset.write(self.now, offset, OFFSET_WRITE);
        }
        if rules.stores_offset && rules.waits_for_store {
            self.ram.next_offset = Some(offset);
        } else {
            self.ram.measuring.offset = offset;
            self.ram.sensor.preset_done(true);
        }
    }
}
