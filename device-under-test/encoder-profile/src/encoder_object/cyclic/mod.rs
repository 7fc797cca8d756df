//! The cyclic exchange: one cycle, from the control words to the signals of the frame.

mod outputs;
mod signals;

use super::memory::Source;
use super::{Live, Model};
use crate::profidrive::checks::Check;
use crate::profidrive::control::CONTROL_BY_PLC;
use crate::profidrive::life_sign::Given;
use crate::profidrive::sensor::Request;
use crate::profidrive::telegram::{Before, Image};

impl<M: Model> Live<'_, M> {
    /// Carries out one cycle and computes the signals of its frame.
    pub fn cycle(&mut self) {
        let words = self.ram.outputs.words;
        let outputs @ [stw2_enc, g1_stw] = words.unwrap_or_default();
        let (compatible, set) = (self.ram.user.compatible, stw2_enc & CONTROL_BY_PLC != 0);
        let (control, checks) = (&self.facts.control, &self.deviations.checks);
        let is_valid = words.is_some() && control.is_valid(compatible, set);
        let is_valid = checks.check(Check::ControlByPlc { compatible, set }, is_valid);
        let is_requested = control.is_requested(compatible, set);
        let is_requested = checks.check(Check::RequestsControl { compatible, set }, is_requested);
        self.obey(Request::of(g1_stw), is_valid);
        self.hold();
        self.look_for_errors();

        let bit = |n: u32, set: bool| u16::from(set) << n;
        let zsw2_enc = u16::from(self.sign_of_life()) << 12
            | bit(9, is_requested)
            | bit(3, self.facts.control.shows_fault && self.fault_bits() != 0);
        let trigger = self.ram.outputs.preset.unwrap_or(0);
        let signals = self.image();
        let image = M::shown(self, Image { zsw2_enc, outputs, trigger, ..signals });
        let before = &self.ram.before;
        let sent = self.deviations.hooks.apply(image, |hooks, image| hooks.image(&self.view(), before, image));
        self.ram.before = Before { truth: image, sent };
    }

    /// Carries out the requests of G1_STW, if they are valid.
    fn obey(&mut self, g1_stw: Request, is_valid: bool) {
        let request = if is_valid { g1_stw } else { Request::default() };
        if let Some(mode) = self.ram.sensor.cycle(request, self.shaft.is_moving(self.now)) {
            self.preset(Source::Parameter(mode));
        }
        if !is_valid && !self.facts.control.takes_held_preset {
            self.ram.sensor.see_void_preset(g1_stw.home);
        }
    }

    /// The sign of life in bits 12 to 15 of ZSW2_ENC; 0 if the encoder sends none.
    fn sign_of_life(&mut self) -> u8 {
        if !M::gives_sign_of_life(self) {
            self.ram.sign_of_life = Given::default();
            return 0;
        }
        self.ram.sign_of_life.advance(self.now, self.facts.sign_of_life, &self.deviations.life_sign)
    }
}
