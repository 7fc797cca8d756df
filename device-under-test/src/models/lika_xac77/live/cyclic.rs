//! The cyclic exchange: control words in, signals out.

use super::Live;
use crate::encoder::{Direction, Unit};
use crate::profidrive::life_sign::Watch;
use crate::profidrive::sensor::{Request, Xist2};
use crate::profidrive::telegram::Image;

/// Bit 10 of STW2_ENC.
const CONTROL_BY_PLC: u16 = 0x0400;

impl Live<'_> {
    /// Takes the outputs of one frame.
    pub fn take(&mut self, outputs: Option<&[u8]>) {
        self.ram.outputs = outputs.and_then(|octets| self.ram.emitter.control_words(octets));
        let Some([stw2_enc, _]) = self.ram.outputs else { return };
        let (rules, user) = (&self.behaviour.life_sign, &self.ram.user);
        let watched = rules.watches_without_control || stw2_enc & CONTROL_BY_PLC != 0;
        if watched && !self.ram.sensor.is_parked() {
            let tolerated = match user.compatible {
                true => user.life_sign_failures,
                false => (rules.tolerated_without_compatibility)(user.life_sign_failures),
            };
            self.ram.watch.take((stw2_enc >> 12) as u8, (rules.tolerated)(tolerated), rules);
        } else {
            self.ram.watch = Watch::default();
        }
        self.look_for_errors();
    }

    /// Carries out one cycle and fills in the inputs of its frame.
    pub fn cycle(&mut self, inputs: &mut [u8]) -> bool {
        let [stw2_enc, g1_stw] = self.ram.outputs.unwrap_or_default();
        let by_plc = stw2_enc & CONTROL_BY_PLC != 0;
        let (control, compatible) = (&self.behaviour.control, self.ram.user.compatible);
        let valid = self.ram.outputs.is_some() && (control.is_valid)(compatible, by_plc);
        let request = if valid { Request::of(g1_stw) } else { Request::default() };
        if let Some(mode) = self.ram.sensor.cycle(request, self.shaft.is_moving(self.now)) {
            self.preset(mode);
        }
        self.look_for_errors();
        let (rules, sensor) = (&self.behaviour.life_sign, &self.ram.sensor);
        let counts = (rules.counts_while_parked || !sensor.is_parked())
            && (rules.counts_with_error || sensor.errors().is_empty());
        if counts {
            self.ram.sign_of_life = (rules.next)(self.ram.sign_of_life);
        }
        let zsw2_enc =
            u16::from(self.ram.sign_of_life) << 12 | u16::from((control.is_requested)(compatible, by_plc)) << 9;
        let image = Image { zsw2_enc, ..self.image() };
        self.ram.emitter.emit(self.ram.telegram, image, inputs)
    }

    /// The signals as they are, apart from ZSW2_ENC.
    fn image(&self) -> Image {
        let (ram, rules) = (&*self.ram, &self.behaviour.user_parameters);
        let shown = |with_offset| if with_offset { ram.measuring.shifted() } else { ram.measuring.position() };
        let position = shown((rules.presets_xist2)(&ram.user));
        let unit = (rules.unit)(ram.user.speed_unit).unwrap_or(Unit::PerSecond);
        let scaling = (rules.scales_velocity)(ram.measuring.settings.scaling, &self.hardware);
        let velocity = ram.velocity.value(unit, &self.hardware, &scaling);
        let is_measured = !ram.sensor.is_parked() || !self.behaviour.sensor.parking_stops_velocity;
        let status = Image {
            g1_zsw: ram.sensor.g1_zsw(),
            velocity: match ram.measuring.settings.direction {
                _ if !is_measured => 0,
                Direction::Clockwise => velocity,
                Direction::Counterclockwise => -velocity,
            },
            good: true,
            position,
            request: ram.sensor.request(),
            ..Image::default()
        };
        if ram.sensor.is_parked() {
            return status;
        }
        Image {
            g1_xist1: shown(ram.user.preset_acts_on_xist1) as u32,
            g1_xist2: match ram.sensor.xist2() {
                Xist2::Nothing => 0,
                Xist2::Position => position as u32,
                Xist2::Error(code) => code.into(),
            },
            g1_xist3: position,
            ..status
        }
    }
}
