//! The cyclic exchange: one cycle, from the control words to the signals of the frame.

mod outputs;
mod signals;

use super::memory::PresetSource;
use super::{EncoderModel, PoweredEncoder};
use crate::profidrive::checks::EncoderCheck;
use crate::profidrive::control::CONTROL_BY_PLC;
use crate::profidrive::life_sign::EncoderLifeSign;
use crate::profidrive::sensor::SensorRequest;
use crate::profidrive::telegram::{PreviousCycle, SignalImage};

impl<M: EncoderModel> PoweredEncoder<'_, M> {
    /// Carries out one cycle and computes the signals of its frame.
    pub fn cycle(&mut self) {
        let words = self.ram.outputs.words;
        let outputs @ [stw2_enc, g1_stw] = words.unwrap_or_default();
        let (compatible, set) = (self.ram.user.compatible, stw2_enc & CONTROL_BY_PLC != 0);
        let (control, checks) = (&self.facts.control, &self.deviations.checks);
        let is_valid = words.is_some() && control.is_valid(compatible, set);
        let is_valid = checks.check(EncoderCheck::ControlByPlc { compatible, set }, is_valid);
        let is_requested = control.is_requested(compatible, set);
        let is_requested = checks.check(EncoderCheck::RequestsControl { compatible, set }, is_requested);
        self.carry_out_requests(SensorRequest::of(g1_stw), is_valid);
        self.apply_preset_hooks();
        self.update_errors();

        let bit = |n: u32, set: bool| u16::from(set) << n;
        let zsw2_enc = u16::from(self.sign_of_life()) << 12
            | bit(9, is_requested)
            | bit(3, self.facts.control.shows_fault && self.fault_bits() != 0);
        let trigger = self.ram.outputs.preset.unwrap_or(0);
        let signals = self.image();
        let image = M::frame_signals(self, SignalImage { zsw2_enc, outputs, trigger, ..signals });
        let before = &self.ram.before;
        let sent = self.deviations.hooks.apply(image, |hooks, image| hooks.image(&self.view(), before, image));
        self.ram.before = PreviousCycle { unhooked: image, sent };
    }

    /// Carries out the requests of G1_STW, if they are valid.
    fn carry_out_requests(&mut self, g1_stw: SensorRequest, is_valid: bool) {
        let request = if is_valid { g1_stw } else { SensorRequest::default() };
        if let Some(mode) = self.ram.sensor.cycle(request, self.shaft.is_moving(self.now)) {
            self.preset(PresetSource::Parameter(mode));
        }
        if !is_valid && !self.facts.control.accepts_held_preset {
            self.ram.sensor.note_invalid_preset(g1_stw.home);
        }
    }

    /// The sign of life in bits 12 to 15 of ZSW2_ENC; 0 if the encoder sends none.
    fn sign_of_life(&mut self) -> u8 {
        if !M::sends_sign_of_life(self) {
            self.ram.sign_of_life = EncoderLifeSign::default();
            return 0;
        }
        self.ram.sign_of_life.advance(self.now, self.facts.sign_of_life, &self.deviations.life_sign)
    }
}
