//! The cyclic exchange: control words in, signals out.

use super::Live;
use crate::behaviour::ByPlc;
use crate::profidrive::life_sign::Watch;
use crate::profidrive::sensor::{Request, Xist2};
use crate::profidrive::telegram::{Image, Signal};

/// Bit 10 of STW2_ENC.
const CONTROL_BY_PLC: u16 = 0x0400;

impl Live<'_> {
    /// Takes the outputs of one frame.
    pub fn take(&mut self, outputs: Option<&[u8]>) {
        self.ram.outputs = outputs.and_then(|octets| self.ram.emitter.control_words(self.ram.telegram, octets));
        let Some([stw2_enc, _]) = self.ram.outputs else { return };
        let (rules, user) = (&self.behaviour.life_sign, &self.ram.user);
        let watched = rules.watches_without_control || stw2_enc & CONTROL_BY_PLC != 0;
        if watched && !self.ram.sensor.is_parked() {
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

    /// Carries out one cycle and fills in the inputs of its frame.
    pub fn cycle(&mut self, inputs: &mut [u8]) -> bool {
        let outputs @ [stw2_enc, g1_stw] = self.ram.outputs.unwrap_or_default();
        let before = self.ram.emitter.before();
        let by_plc = ByPlc {
            compatible: self.ram.user.compatible,
            before: before.truth.outputs[0] & CONTROL_BY_PLC != 0,
            now: stw2_enc & CONTROL_BY_PLC != 0,
        };
        let control = &self.behaviour.control;
        let mut request = match self.ram.outputs.is_some() && (control.is_valid)(by_plc) {
            true => Request::of(g1_stw),
            false => (control.when_void)(self.ram.sensor.request()),
        };
        self.ram.stays_parked &= !request.park;
        request.park |= self.ram.stays_parked;
        let was_parked = self.ram.sensor.is_parked();
        if let Some(mode) = self.ram.sensor.cycle(request, self.shaft.is_moving(self.now)) {
            self.preset(mode);
        }
        if was_parked && !self.ram.sensor.is_parked() {
            self.ram.measuring.resume();
        }
        self.look_for_errors();
        let (rules, sensor) = (&self.behaviour.life_sign, &self.ram.sensor);
        let counts = (rules.counts_while_parked || !sensor.is_parked())
            && (rules.counts_with_error || sensor.errors().is_empty());
        if counts {
            self.ram.sign_of_life = (rules.next)(self.ram.sign_of_life);
        }
        let zsw2_enc = u16::from(self.ram.sign_of_life) << 12 | u16::from((control.is_requested)(by_plc)) << 9;
        let signals = if self.now < self.ram.held_up_until { before.sent } else { self.image() };
        let image = Image { zsw2_enc, outputs, ..signals };
        self.ram.emitter.emit(self.ram.telegram, image, inputs)
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
        let status = Image {
            g1_zsw: ram.sensor.g1_zsw(),
            velocity: if is_measured { ram.velocity.value(&scaling, settings.direction) } else { 0 },
            good: true,
            position,
            request: ram.sensor.request(),
            ..Image::default()
        };
        if ram.sensor.is_parked() {
            return status;
        }
        Image {
            g1_xist1: shown(Signal::G1Xist1, ram.user.preset_acts_on_xist1) as u32,
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
