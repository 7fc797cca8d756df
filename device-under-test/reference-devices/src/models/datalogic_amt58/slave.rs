//! What the encoder does with what the slave hands it.

use super::encoder::{Amt58, Ram};
use super::knobs::{PowerUp, Told};
use super::lights::Lamps;
use super::preset::{TRIGGER, Trigger};
use super::program::{Program, Refused, Scales};
use super::told::{self, Shown};
use alloc::vec::Vec;
use device_stack::profibus::{Application, DiagnosisBits, End, Identity, Seen};
use station::{StandAction, Time};
use wire::profibus::cfg::Sums;
use wire::profibus::prm::SetPrm;

impl Application for Amt58 {
    fn identity(&self) -> &Identity {
        &self.identity
    }

    fn power_up(&mut self, now: Time) {
        let switches = (self.address_switches, self.eighth_switch);
        self.ram = Ram::new(now, self.hardware, &self.shaft, &self.behaviour, switches);
        self.ram.is_unreadable = self.has_broken_memory && self.rules().checks_memory;
        let place = self.place(now);
        let stored = if self.ram.is_unreadable { 0 } else { *self.offset.stored() };
        let moved = place as i64 - self.place_at_power_down as i64;
        self.power_ups = self.power_ups.saturating_add(1);
        (self.ram.offset, self.ram.shift) = (self.rules().at_power_up)(&PowerUp { offset: stored, moved, place });
        self.ram.offsets = [self.ram.offset; 3];
        self.ram.place_of_preset = self.place(now);
    }

    fn power_down(&mut self, now: Time) {
        self.offset.power_down();
        self.place_at_power_down = self.place(now);
    }

    fn address(&self) -> u8 {
        (self.rules().address)(self.switches())
    }

    fn takes_address(&self) -> bool {
        !self.is_address_final && (self.rules().takes_address)(self.switches())
    }

    fn set_address(&mut self, _: Time, address: u8, is_final: bool) {
        self.address.replace((self.rules().stores_address)(address, is_final));
        self.is_address_final |= (self.rules().locks_address)(is_final);
    }

    fn parameters(&mut self, now: Time, parameters: &SetPrm) -> bool {
        self.sample(now);
        self.ram.expired = None;
        let rules = self.rules;
        let read = Program::read(&parameters.user, &self.hardware, &self.ram.program, self.first.as_ref(), &rules);
        match read {
            Ok(program) => {
                self.ram.is_invalid = false;
                self.first.get_or_insert(program);
                if rules.offset_per_class {
                    self.ram.offsets[self.ram.program.class()] = self.ram.offset;
                    self.ram.offset = self.ram.offsets[program.class()];
                }
                self.ram.is_first_preset = program.scaling != self.ram.program.scaling;
                self.ram.program = program;
                self.ram.measuring.settings = program.settings();
                self.ram.velocity.set_unit(program.unit);
                self.ram.offset = (rules.offset_at_start)(self.ram.offset);
                self.use_offset(self.place(now));
                if let Some(value) = (rules.preset_at_start)(&program) {
                    self.preset(now, value);
                }
                true
            }
            Err(refused) => {
                self.ram.is_stuck = refused == Refused::Stops;
                (self.ram.is_invalid, self.ram.was_invalid) = (true, true);
                self.ram.is_invalid_with_zone = Scales::of(&parameters.user, &self.hardware).has_zone();
                false
            }
        }
    }

    fn check_configuration(&mut self, _: Time, identifiers: &[u8]) -> Option<Sums> {
        let program = &self.ram.program;
        (self.rules().takes_configuration)(program, identifiers, program.check(identifiers))
    }

    fn configuration(&self, out: &mut Vec<u8>) {
        out.extend_from_slice((self.rules().configuration)(&self.ram.program));
    }

    fn exchange_begins(&mut self, now: Time) {
        let held = self.ram.outputs[0];
        if self.rules().keeps_outputs && held & TRIGGER != 0 && self.ram.inputs_given > 0 {
            self.sample(now);
            self.preset(now, held & !TRIGGER);
        }
        if !self.rules().outputs_before_exchange_count {
            self.ram.trigger = Trigger { presets: self.ram.trigger.presets, ..Trigger::default() };
        }
    }

    fn exchange_ends(&mut self, now: Time, end: End) {
        if end == End::Watchdog {
            self.ram.expired = Some(now);
        }
    }

    fn outputs(&mut self, now: Time, data: Option<&[u8]>) {
        let octets = data.and_then(|data| data.try_into().ok()).unwrap_or_default();
        self.take_outputs(now, octets);
    }

    fn outputs_refused(&mut self, now: Time, data: &[u8]) {
        if let Ok(octets) = data.try_into()
            && self.rules().outputs_before_exchange_count
        {
            self.take_outputs(now, octets);
        }
    }

    fn inputs(&mut self, now: Time, data: &mut [u8]) {
        self.sample(now);
        let place = self.place(now);
        let Ram { program, measuring, velocity, .. } = &self.ram;
        let position = measuring.shifted() as u32;
        let scaling = (self.rules.scaling_of_velocity)(program, &self.hardware);
        let velocity = velocity.value(&scaling, program.direction) as i32;
        let shown = Shown {
            position,
            velocity,
            before: self.ram.inputs,
            truth_before: self.ram.truth,
            outputs: self.ram.outputs,
            program,
            hardware: &self.hardware,
            endless: self.shaft.place(now),
            place: self.counted(place),
            count: self.ram.inputs_given,
            is_preset: self.ram.is_preset,
            offset: self.ram.offset,
        };
        (self.rules.inputs)(&shown, data);
        let mut inputs = [0; 8];
        told::put(&mut inputs, data);
        (self.ram.inputs, self.ram.truth) = (inputs, (position, velocity));
        self.ram.is_preset = false;
        self.ram.inputs_given = self.ram.inputs_given.saturating_add(1);
    }

    fn diagnosis(&mut self, now: Time, out: &mut Vec<u8>) -> DiagnosisBits {
        self.sample(now);
        let rules = self.rules;
        let is_in_zone = self.is_in_zone(now);
        let Ram { program, is_unreadable, offset, last_preset, trigger, .. } = &self.ram;
        let told = Told {
            program,
            hardware: &self.hardware,
            is_unreadable: *is_unreadable,
            is_in_zone,
            offset: *offset,
            last_preset: *last_preset,
            power_ups: self.power_ups,
        };
        told::diagnosis(&told, (rules.shown_offset)(*offset, trigger.presets), out);
        let mut bits = DiagnosisBits::default();
        (rules.diagnosis)(&told, out, &mut bits);
        bits
    }

    fn diagnosis_changed(&mut self) -> bool {
        false
    }

    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Option<Time> {
        self.sample(now);
        let done = match *action {
            StandAction::ShaftSpeed(rpm) => {
                self.shaft.turn(now, rpm);
                now
            }
            StandAction::ShaftRamp { rpm, acceleration } => {
                self.shaft.ramp(now, rpm, acceleration);
                now
            }
            StandAction::ShaftCounts(counts) => {
                self.shaft.put(now, (counts % self.physical.range()) as i64);
                self.ram.velocity.restart(now, &self.shaft);
                self.ram.measuring.put(self.place(now));
                now
            }
            StandAction::Turn { steps, rpm } => self.shaft.turn_by(now, steps, rpm),
            StandAction::TurnRevolutions { revolutions, rpm } => self.shaft.turn_revolutions(now, revolutions, rpm),
            StandAction::Fault("flash", present) => {
                self.has_broken_memory = present;
                now
            }
            StandAction::Switch("address", position) => {
                self.address_switches = u8::try_from(position).ok().filter(|position| *position < 128)?;
                now
            }
            StandAction::Switch("eighth", position) => {
                self.eighth_switch = position != 0;
                now
            }
            _ => return None,
        };
        self.sample(now);
        Some(done)
    }

    fn is_stuck(&self) -> bool {
        self.ram.is_stuck
    }

    fn look(&mut self, now: Time, seen: &Seen) {
        self.shown = self.lamps(now, seen);
    }

    fn led(&mut self, _: Time, name: &str, _: &Seen) -> Option<&'static str> {
        let Lamps { red, green } = self.shown;
        match name {
            "fault" => Some(red),
            "power" => Some(green),
            _ => None,
        }
    }

    fn counter(&mut self, _: Time, name: &str) -> Option<u64> {
        (name == "nvm_writes").then(|| self.offset.writes() + self.address.writes())
    }

    fn deadline(&self) -> Option<Time> {
        self.offset.deadline()
    }

    fn advance(&mut self, now: Time) {
        self.offset.settle(now, false);
    }
}
