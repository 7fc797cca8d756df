//! Presets, the preset value, and writing them to memory.

use super::powered::PendingPreset;
use super::{EncoderModel, PoweredEncoder};
use crate::encoder::PresetMode;
use crate::encoder::memory::WriteOutcome;
use crate::encoder_object::hooks::{MemoryWrite, WorkingPreset};
use crate::facts::FaultEffect;
use crate::profidrive::checks::EncoderCheck;

/// The source of the value of a preset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PresetSource {
    /// P65000; the preset is requested by G1_STW and acknowledged by G1_ZSW.
    Parameter(PresetMode),
    /// The word with the trigger; the preset is not acknowledged.
    Value(PresetMode, u32),
}

impl<M: EncoderModel> PoweredEncoder<'_, M> {
    /// Completes the writes that are due.
    pub(super) fn settle(&mut self) {
        let is_faulty = self.faults.have(FaultEffect::NoMemory, self.facts);
        let outcome = self.store.offset.settle(self.now, is_faulty);
        let checks = &self.deviations.checks;
        let is_due = outcome.is_some() || !self.facts.preset_waits_for_memory;
        if let Some(next) = self.ram.next_preset.take_if(|_| checks.check(EncoderCheck::PresetTakesEffect, is_due)) {
            let is_carried_out = checks.check(EncoderCheck::PresetIsCarriedOut, outcome != Some(WriteOutcome::Failed));
            if is_carried_out {
                self.ram.measuring.offset = next.offset;
            }
            if next.is_answered {
                self.ram.sensor.preset_done(is_carried_out);
            }
        }
        if let Some(outcome) = self.store.preset_value.settle(self.now, is_faulty) {
            self.ram.is_saving = outcome == WriteOutcome::Failed;
        }
    }

    /// Lets deviations change offset and preset value in working memory.
    pub(super) fn apply_preset_hooks(&mut self) {
        let held = WorkingPreset { offset: self.ram.measuring.offset, preset_value: self.ram.preset_value };
        let held = self.deviations.hooks.apply(held, |hooks, held| hooks.working_preset(&self.view(), held));
        (self.ram.measuring.offset, self.ram.preset_value) = (held.offset, held.preset_value);
    }

    /// Number of positions, in units.
    pub fn positions(&self) -> u64 {
        let measuring = &self.ram.measuring;
        measuring.settings.saturates_at.unwrap_or(measuring.range())
    }

    /// Sets P65000.
    pub fn set_preset_value(&mut self, value: u32) {
        self.ram.preset_value = value;
    }

    /// The position, or the shift, that this preset value results in, in units.
    fn units(&self, mode: PresetMode, value: u32) -> u64 {
        let units = self.facts.preset_values.units(mode, value, self.positions());
        self.deviations.hooks.apply(units, |hooks, units| hooks.preset_units(&self.view(), mode, units))
    }

    /// Starts to save P65000, as P971 requests.
    pub fn save(&mut self) {
        let (value, takes) = (self.ram.preset_value, self.facts.timing.save);
        self.ram.is_saving |= self.write_to_memory(MemoryWrite::PresetValue { value, takes });
    }

    /// Starts to write to memory. Returns `false` if a deviation drops the write.
    pub fn write_to_memory(&mut self, write: MemoryWrite) -> bool {
        let write = self.deviations.hooks.apply(Some(write), |hooks, write| hooks.store(&self.view(), write));
        match write {
            Some(MemoryWrite::Offset { offset, takes }) => self.store.offset.write(self.now, offset, takes),
            Some(MemoryWrite::PresetValue { value, takes }) => self.store.preset_value.write(self.now, value, takes),
            None => return false,
        }
        true
    }

    /// Starts a preset: computes the offset now. The offset takes effect when it is stored.
    pub fn preset(&mut self, source: PresetSource) {
        let by_request = matches!(source, PresetSource::Parameter(_));
        let is_permitted = self.ram.user.presets_act(&self.deviations.checks);
        let has_error = !self.ram.sensor.errors().is_empty();
        let check = EncoderCheck::CarriesOutPreset { by_request, has_error };
        if !self.deviations.checks.check(check, is_permitted) {
            return self.refuse_preset(by_request, self.facts.sensor.answers_blocked_preset);
        }
        let (mode, value) = match source {
            PresetSource::Parameter(mode) => (mode, self.units(mode, self.ram.preset_value)),
            PresetSource::Value(mode, value) => (mode, value.into()),
        };
        if !M::takes_preset(self, mode, value) {
            return self.refuse_preset(by_request, false);
        }
        let offset = self.ram.measuring.preset(mode, value);
        if self.write_to_memory(MemoryWrite::Offset { offset, takes: self.facts.timing.preset }) {
            // A new preset replaces a pending one and also acknowledges it.
            let is_answered = by_request || self.ram.next_preset.is_some_and(|next| next.is_answered);
            self.ram.next_preset = Some(PendingPreset { offset, is_answered });
            self.settle();
        }
    }

    /// Ends a preset that is not carried out; acknowledges it if `is_acknowledged`.
    fn refuse_preset(&mut self, by_request: bool, is_acknowledged: bool) {
        if by_request {
            self.ram.sensor.preset_done(is_acknowledged);
        }
    }
}
