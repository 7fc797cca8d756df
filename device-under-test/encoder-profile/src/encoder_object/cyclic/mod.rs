//! The cyclic exchange: one cycle from the control words to the signals of its frame.

mod outputs;
mod signals;

use super::memory::Source;
use super::{Live, Model};
use crate::behaviour::ByPlc;
use crate::profidrive::life_sign::Given;
use crate::profidrive::sensor::Request;
use crate::profidrive::telegram::{Before, Image};
use core::time::Duration;

/// Bit 10 of STW2_ENC.
const CONTROL_BY_PLC: u16 = 0x0400;

impl<M: Model> Live<'_, M> {
    /// Carries out one cycle and settles the signals of its frame.
    pub fn cycle(&mut self) {
        let taken = self.ram.outputs.words;
        let outputs @ [stw2_enc, g1_stw] = taken.unwrap_or_default();
        let trigger = self.ram.outputs.preset.unwrap_or(0);
        let outputs_before = self.ram.before.truth.outputs;
        let is_set = stw2_enc & CONTROL_BY_PLC != 0;
        match taken {
            None => self.ram.good_since = None,
            Some(_) if self.ram.good_since.is_none() => {
                self.ram.good_since = Some(self.now);
                self.ram.had_control = self.ram.last_control;
            }
            Some(_) => {}
        }
        if taken.is_some() {
            self.ram.last_control = is_set;
        }
        let is_fresh = self.ram.good_since.is_some_and(|since| self.now < since + Duration::from_secs(1));
        let by_plc = ByPlc {
            was_set: is_fresh && self.ram.had_control,
            compatible: self.ram.user.compatible,
            before: outputs_before[0] & CONTROL_BY_PLC != 0,
            now: is_set,
        };
        let control = &self.behaviour.control;
        let is_valid = taken.is_some() && (control.is_valid)(by_plc);
        let mut request = match is_valid {
            true => Request::of(g1_stw),
            false => (control.when_void)(self.ram.sensor.request()),
        };
        self.ram.stays_parked &= !request.park;
        request.park |= self.ram.stays_parked;
        if let Some(mode) = self.ram.sensor.cycle(request, self.shaft.is_moving(self.now)) {
            self.preset(Source::Parameter(mode));
        }
        let offset = self.ram.measuring.offset;
        self.ram.measuring.offset = self.ram.sensor.released(offset, self.ram.offset_before_preset);
        self.ram.sensor.hear(taken.is_some());
        if !is_valid && !self.behaviour.control.takes_held {
            let held = Request::of(g1_stw);
            let acknowledge = held.acknowledge && !self.behaviour.control.takes_held_acknowledgement;
            self.ram.sensor.see(Request { acknowledge, ..held });
        }
        if (self.behaviour.memory.stores_in_frame)(request) {
            let offset = *self.store.offset.stored();
            self.store.offset.replace(offset);
        }
        self.hold();
        self.look_for_errors();
        let (rules, sensor) = (&self.behaviour.life_sign, &self.ram.sensor);
        let counts = (rules.counts_while_parked || !sensor.is_parked())
            && (rules.counts_with_error || sensor.errors().is_empty())
            && (rules.counts_during_preset || self.ram.next_preset.is_none());
        let gives = M::gives_sign_of_life(self);
        if !gives {
            self.ram.sign_of_life = Given::default();
        }
        let sign_of_life = if gives { self.ram.sign_of_life.advance(self.now, counts, rules) } else { 0 };
        let faults = self.fault_bits();
        let bit = |n: u32, set: bool| u16::from(set) << n;
        let zsw2_enc = u16::from(sign_of_life) << 12
            | bit(9, (control.is_requested)(by_plc))
            | bit(3, (control.fault_present)(faults));
        let is_held_up = self.now < self.ram.held_up_until;
        let signals = if is_held_up { self.ram.before.sent } else { self.image() };
        let image = M::shown(self, Image { zsw2_enc, outputs, trigger, ..signals });
        let before = &self.ram.before;
        let sent = self.behaviour.hooks.apply(image, |hooks, image| hooks.image(before, image));
        self.ram.before = Before { truth: image, sent };
    }
}
