//! Outputs of the controller: control words and preset words.

use crate::encoder::PresetMode;
use crate::encoder_object::memory::PresetSource;
use crate::encoder_object::{ConnectionPhase, EncoderModel, PoweredEncoder};
use crate::profidrive::checks::EncoderCheck;
use crate::profidrive::control::CONTROL_BY_PLC;
use crate::profidrive::life_sign::{ControllerLifeSign, tolerated};
use crate::profidrive::telegram::{OutputValues, OutputWord};

impl<M: EncoderModel> PoweredEncoder<'_, M> {
    /// Processes the outputs of one submodule; `None` if they are bad or missing. Words of other submodules keep
    /// their values.
    pub fn take(&mut self, subslot: u16, outputs: Option<&[u8]>) {
        let Some(submodule) = self.ram.submodules.iter().copied().find(|one| one.subslot == subslot) else { return };
        let telegram = submodule.telegram;
        let arrived = OutputValues::read(telegram, outputs);
        let hooks = &self.deviations.hooks;
        let arrived = hooks.apply(arrived, |hooks, arrived| hooks.outputs(&self.view(), telegram, arrived));
        self.ram.outputs.replace(telegram, arrived);
        let is_preset = |word: &OutputWord| matches!(word, OutputWord::Preset | OutputWord::LongPreset);
        if submodule.telegram.outputs.iter().any(is_preset) && matches!(self.ram.phase, ConnectionPhase::Data(_)) {
            self.take_preset();
        }
        if !submodule.telegram.outputs.contains(&OutputWord::Stw2Enc) {
            return;
        }
        let Some([stw2_enc, _]) = self.ram.outputs.words else { return };
        self.watch_controller(stw2_enc);
        self.update_errors();
    }

    /// Monitors the sign of life in bits 12 to 15 of STW2_ENC, unless the encoder is parked.
    fn watch_controller(&mut self, stw2_enc: u16) {
        let parked = self.ram.sensor.is_parked();
        let check = EncoderCheck::MonitorsController { has_control: stw2_enc & CONTROL_BY_PLC != 0, parked };
        let is_watched = M::monitors_controller(self) && !parked;
        if !self.deviations.checks.check(check, is_watched) {
            self.ram.watch = ControllerLifeSign::default();
            return;
        }
        let (user, steps) = (&self.ram.user, &self.deviations.life_sign);
        let tolerated = tolerated(user).into();
        let tolerated = steps.apply(tolerated, |steps, tolerated| steps.tolerated(user, tolerated));
        self.ram.watch.take((stw2_enc >> 12) as u8, tolerated, &self.deviations.checks);
    }

    /// Carries out a preset if the preset word has its trigger.
    fn take_preset(&mut self) {
        let Some(facts) = &self.facts.preset_trigger else { return };
        let range = self.positions().max(1);
        if let Some(value) = self.ram.trigger.take(facts, self.ram.outputs.preset, range) {
            self.preset(PresetSource::Value(PresetMode::Absolute, value as u32));
        }
    }
}
