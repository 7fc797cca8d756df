//! The cyclic exchange: control words in, signals out.

use super::memory::Source;
use super::{Live, Model};
use crate::behaviour::ByPlc;
use crate::profidrive::life_sign::Watch;
use crate::profidrive::sensor::{Request, Xist2};
use crate::profidrive::telegram::{Control, Image, Parts, Signal};

/// Bit 10 of STW2_ENC.
const CONTROL_BY_PLC: u16 = 0x0400;

impl<M: Model> Live<'_, M> {
    /// Takes the outputs of one submodule; of those that are bad or missing only what it brings is given up.
    pub fn take(&mut self, subslot: u16, outputs: Option<&[u8]>) {
        let Some(submodule) = self.ram.submodules.iter().find(|one| one.subslot == subslot) else { return };
        self.ram.emitter.take(&mut self.ram.outputs, submodule.telegram, outputs);
        if !submodule.telegram.outputs.contains(&Control::Stw2Enc) {
            return;
        }
        let Some([stw2_enc, _]) = self.ram.emitter.control_words(&self.ram.outputs) else { return };
        let (rules, user) = (&self.behaviour.life_sign, &self.ram.user);
        let watched = rules.watches_without_control || stw2_enc & CONTROL_BY_PLC != 0;
        if self.facts.watches_controller && watched && !self.ram.sensor.is_parked() {
            let tolerated = match user.compatible {
                true => user.life_sign_failures,
                false => (rules.tolerated_without_compatibility)(user.life_sign_failures),
            };
            self.ram.watch.take((rules.read)(stw2_enc), (rules.tolerated)(tolerated), rules);
        } else {
            self.ram.watch = Watch::default();
        }
        self.look_for_errors();
    }

    /// Carries out one cycle and settles the signals of its frame.
    pub fn cycle(&mut self) {
        let taken = self.ram.emitter.control_words(&self.ram.outputs);
        let outputs @ [stw2_enc, g1_stw] = taken.unwrap_or_default();
        let before = self.ram.emitter.before();
        let by_plc = ByPlc {
            compatible: self.ram.user.compatible,
            before: before.truth.outputs[0] & CONTROL_BY_PLC != 0,
            now: stw2_enc & CONTROL_BY_PLC != 0,
        };
        let control = &self.behaviour.control;
        let is_valid = taken.is_some() && (control.is_valid)(by_plc);
        let mut request = match is_valid {
            true => Request::of(g1_stw),
            false => (control.when_void)(self.ram.sensor.request()),
        };
        self.ram.stays_parked &= !request.park;
        request.park |= self.ram.stays_parked;
        let was_parked = self.ram.sensor.is_parked();
        if let Some(mode) = self.ram.sensor.cycle(request, self.shaft.is_moving(self.now)) {
            self.preset(Source::Parameter(mode));
        }
        if !is_valid && !self.behaviour.control.takes_held {
            self.ram.sensor.see(Request::of(g1_stw));
        }
        if was_parked && !self.ram.sensor.is_parked() {
            self.ram.measuring.resume();
        }
        self.look_for_errors();
        let (rules, sensor) = (&self.behaviour.life_sign, &self.ram.sensor);
        let counts = (rules.counts_while_parked || !sensor.is_parked())
            && (rules.counts_with_error || sensor.errors().is_empty());
        let sign_of_life = self.ram.sign_of_life.advance(self.now, counts, rules);
        let zsw2_enc = u16::from(sign_of_life) << 12 | u16::from((control.is_requested)(by_plc)) << 9;
        let signals = if self.now < self.ram.held_up_until { before.sent } else { self.image() };
        let image = Image { zsw2_enc, outputs, ..signals };
        self.ram.emitter.begin(image);
    }

    /// The signals as they are, apart from ZSW2_ENC.
    fn image(&self) -> Image {
        let (ram, rules) = (&*self.ram, &self.behaviour.user_parameters);
        let settings = ram.measuring.settings;
        let shown = |signal, with_offset| {
            let measuring = ram.measuring.under((rules.acts_on)(signal, settings, &self.hardware));
            if with_offset { measuring.shifted() } else { measuring.position() }
        };
        let with_offset = (rules.presets_xist2)(&ram.user);
        let position = shown(Signal::G1Xist2, with_offset);
        let scaling = (rules.scales_velocity)(settings.scaling, &self.hardware);
        let is_measured = !ram.sensor.is_parked() || !self.behaviour.sensor.parking_stops_velocity;
        let plain_position = shown(Signal::Position, with_offset);
        let parts = Parts {
            position: plain_position,
            scaling: settings.scaling,
            hardware: self.hardware,
            place: self.hardware.sense(self.shaft.place(self.now)),
        };
        let [single_turn, multi_turn] = (self.behaviour.telegram.parts)(&parts);
        let status = Image {
            g1_zsw: ram.sensor.g1_zsw(),
            velocity: if is_measured { ram.velocity.value(&scaling, settings.direction) } else { 0 },
            good: true,
            position,
            offset: ram.measuring.offset,
            plain_position: plain_position as u32,
            single_turn,
            multi_turn,
            request: ram.sensor.request(),
            ..Image::default()
        };
        if ram.sensor.is_parked() {
            return status;
        }
        Image {
            g1_xist1: shown(Signal::G1Xist1, ram.user.preset_acts_on_xist1) as u32,
            shift: (self.behaviour.telegram.shift)(&settings, &self.hardware, self.variant.shift),
            g1_xist2: match ram.sensor.xist2() {
                Xist2::Nothing => 0,
                Xist2::Position => position as u32,
                Xist2::Error(code) => code.into(),
            },
            g1_xist3: shown(Signal::G1Xist3, with_offset),
            ..status
        }
    }
}
