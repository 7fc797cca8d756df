//! Presets, the preset value and their way into memory.

use super::live::NextPreset;
use super::{Live, Model};
use crate::checks::Check;
use crate::encoder::PresetMode;
use crate::encoder::memory::Outcome;
use crate::facts::Effect;
use crate::hooks::Held;

/// Where the value of a preset comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// From P65000; G1_STW asked for the preset and G1_ZSW answers.
    Parameter(PresetMode),
    /// From the controller together with the request; nothing answers.
    Value(PresetMode, u32),
}

impl<M: Model> Live<'_, M> {
    /// Ends the writes that are done.
    pub(super) fn settle(&mut self) {
        let is_faulty = self.faults.have(Effect::NoMemory, self.facts);
        if let Some(outcome) = self.store.offset.settle(self.now, is_faulty) {
            let carried_out = outcome == Outcome::Written || !self.behaviour.memory.heeds_failure;
            if let Some(next) = self.ram.next_preset.take() {
                if carried_out {
                    self.ram.measuring.offset = next.offset;
                }
                if next.is_answered {
                    self.ram.sensor.preset_done(carried_out);
                }
            }
        }
        if let Some(outcome) = self.store.preset_value.settle(self.now, is_faulty) {
            self.ram.is_saving = (self.behaviour.memory.stays_after_save)(outcome);
            if self.behaviour.memory.save_restores_offset {
                self.store.offset.replace(self.ram.offset_at_power_up);
            }
        }
    }

    /// Lets deviations change what the working memory holds of a preset.
    pub(super) fn hold(&mut self) {
        let held = Held { offset: self.ram.measuring.offset, preset_value: self.ram.preset_value };
        let held = self.behaviour.hooks.apply(held, |hooks, held| hooks.held(&self.view(), held));
        (self.ram.measuring.offset, self.ram.preset_value) = (held.offset, held.preset_value);
    }

    /// How many positions there are, in units.
    pub fn positions(&self) -> u64 {
        let measuring = &self.ram.measuring;
        measuring.settings.saturates_at.unwrap_or(measuring.range())
    }

    /// Gives P65000 a value.
    pub fn set_preset_value(&mut self, value: u32) {
        self.ram.preset_value = value;
        if self.behaviour.memory.stores_every_write {
            self.store.preset_value.replace(value);
        }
    }

    /// The units by which a preset with this preset value sets or shifts the position.
    fn units(&self, mode: PresetMode, value: u32) -> u64 {
        let units = self.facts.preset_values.units(mode, value, self.positions());
        self.behaviour.hooks.apply(units, |hooks, units| hooks.preset_units(&self.view(), mode, units))
    }

    /// Begins to save P65000.
    pub fn save(&mut self) {
        let is_running = self.store.preset_value.deadline().is_some();
        if (self.behaviour.memory.begins_save)(self.ram.saves, is_running) {
            self.store.preset_value.write(self.now, self.ram.preset_value, self.facts.timing.save);
            self.ram.is_saving = true;
        }
        self.ram.saves += 1;
    }

    /// Begins a preset: the offset is computed now and takes effect when it is stored.
    pub fn preset(&mut self, source: Source) {
        let is_answered = matches!(source, Source::Parameter(_));
        let permitted = (self.behaviour.memory.heeds)(self.ram.last_preset, is_answered)
            && self.ram.user.presets_act(&self.behaviour.checks);
        let has_error = !self.ram.sensor.errors().is_empty();
        let check = Check::CarriesOutPreset { by_request: is_answered, has_error };
        if !self.behaviour.checks.check(check, permitted) {
            if is_answered {
                self.ram.sensor.preset_done(self.facts.sensor.answers_blocked_preset);
            }
            return;
        }
        self.ram.last_preset = Some(is_answered);
        let rules = &self.behaviour.memory;
        let (mode, value) = match source {
            Source::Parameter(mode) if rules.presets_stored_value => (mode, *self.store.preset_value.stored()),
            Source::Parameter(mode) => (mode, self.ram.preset_value),
            Source::Value(mode, value) => (mode, value),
        };
        let value = match source {
            Source::Parameter(_) => self.units(mode, value),
            Source::Value(..) => value.into(),
        };
        if !M::takes_preset(self, mode, value) {
            if is_answered {
                self.ram.sensor.preset_done(false);
            }
            return;
        }
        let rules = &self.behaviour.memory;
        let offset = self.ram.measuring.preset(mode, value);
        let offset = match self.ram.next_preset {
            Some(other) => (rules.preset_during_preset)(other.offset, offset, self.ram.measuring.position()),
            None => offset,
        };
        if rules.uses_up_preset_value {
            self.ram.preset_value = 0;
        }
        let stores = (rules.stores_offset)(mode);
        if stores {
            self.store.offset.write(self.now, offset, (rules.preset_takes)(self.facts.timing.preset));
        }
        if stores && rules.waits_for_store {
            // A preset that begins before another one is carried out takes its place, and its answer upon itself.
            let is_answered = is_answered || self.ram.next_preset.is_some_and(|next| next.is_answered);
            self.ram.next_preset = Some(NextPreset { offset, is_answered });
        } else {
            self.ram.measuring.offset = offset;
            if is_answered {
                self.ram.sensor.preset_done(true);
            }
        }
    }
}
