//! The cyclic exchange: control words in, signals out.

use super::memory::Source;
use super::{Live, Model, Phase};
use crate::behaviour::ByPlc;
use crate::profidrive::life_sign::{Given, Watch};
use crate::profidrive::mantel::Known;
use crate::profidrive::sensor::{Request, Xist2};
use crate::profidrive::telegram::{Control, Image, Parts, Signal};
use core::time::Duration;

/// Bit 15 of G1_ZSW.
const ERROR: u16 = 0x8000;
/// Bit 10 of STW2_ENC.
const CONTROL_BY_PLC: u16 = 0x0400;

impl<M: Model> Live<'_, M> {
    /// Takes the outputs of one submodule; of those that are bad or missing only what it brings is given up.
    pub fn take(&mut self, subslot: u16, outputs: Option<&[u8]>) {
        let Some(submodule) = self.ram.submodules.iter().copied().find(|one| one.subslot == subslot) else { return };
        self.ram.emitter.take(&mut self.ram.outputs, submodule.telegram, outputs);
        if submodule.telegram.outputs.contains(&Control::Preset) && matches!(self.ram.phase, Phase::Data(_)) {
            self.take_preset();
        }
        if !submodule.telegram.outputs.contains(&Control::Stw2Enc) {
            return;
        }
        let Some([stw2_enc, _]) = self.ram.emitter.control_words(&self.ram.outputs) else { return };
        let (rules, user) = (&self.behaviour.life_sign, &self.ram.user);
        let watched = rules.watches_without_control || stw2_enc & CONTROL_BY_PLC != 0;
        if (rules.is_watched)(M::watches_controller(self)) && watched && !self.ram.sensor.is_parked() {
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

    /// Looks for the trigger of a preset in what was taken.
    fn take_preset(&mut self) {
        let user_range = self.ram.user.range;
        let known =
            Known { range: self.positions().max(1), user_range, preset_value: self.ram.preset_value, before: 0 };
        let word = self.ram.emitter.trigger(&self.ram.outputs);
        if let Some(value) = self.ram.trigger.take(word, &known) {
            let g1_stw = self.ram.outputs.words.map_or(0, |[_, g1_stw]| g1_stw);
            let mode = (self.behaviour.mantel.mode)(Request::of(g1_stw).mode());
            self.preset(Source::Value(mode, value as u32));
        }
    }

    /// Carries out one cycle and settles the signals of its frame.
    pub fn cycle(&mut self) {
        let taken = self.ram.emitter.control_words(&self.ram.outputs);
        let outputs @ [stw2_enc, g1_stw] = taken.unwrap_or_default();
        let trigger = self.ram.outputs.preset.unwrap_or(0);
        let Image { position: position_before, outputs: outputs_before, .. } = self.ram.emitter.before().truth;
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
        let was_parked = self.ram.sensor.is_parked();
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
        if was_parked && !self.ram.sensor.is_parked() {
            let position = self.ram.frozen.map_or(self.ram.parked_at, |frozen| frozen.position);
            self.ram.measuring.resume(position);
        }
        if !was_parked {
            self.ram.parked_at = position_before;
        }
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
        let signals = if is_held_up { self.ram.emitter.before().sent } else { self.image() };
        let image = M::shown(self, Image { zsw2_enc, outputs, trigger, ..signals });
        let before = self.ram.emitter.before();
        let sent = self.behaviour.hooks.apply(image, |hooks, image| hooks.image(before, image));
        self.ram.emitter.begin(image, sent);
    }

    /// The signals as they are, apart from ZSW2_ENC.
    fn image(&mut self) -> Image {
        let now = self.image_now();
        if !self.ram.sensor.is_frozen() {
            self.ram.frozen = None;
            return now;
        }
        let kept = *self.ram.frozen.get_or_insert(now);
        (self.behaviour.sensor.freezes)(kept, now)
    }

    fn image_now(&self) -> Image {
        let image = self.whole_image();
        let user = &self.ram.user;
        let shows_codes = (self.behaviour.diagnosis.shows_codes)(user.compatible, user.alarm_channel);
        if shows_codes || image.g1_zsw & ERROR == 0 {
            return image;
        }
        let transfers = image.request.absolute;
        let position = if transfers { image.position as u32 } else { 0 };
        Image { g1_zsw: image.g1_zsw & !ERROR | u16::from(transfers) << 13, g1_xist2: position, ..image }
    }

    fn whole_image(&self) -> Image {
        let (ram, rules) = (&*self.ram, &self.behaviour.user_parameters);
        let settings = ram.measuring.settings;
        let acting = |signal| {
            let settings = (rules.acts_since)(signal, settings, ram.settings_at_start);
            (rules.acts_on)(signal, settings, &self.hardware)
        };
        let usual = ram.measuring.positions();
        let shown = |signal, with_offset| {
            let settings = acting(signal);
            let is_usual = settings == ram.measuring.settings;
            let [plain, limited] = if is_usual { usual } else { ram.measuring.under(settings).positions() };
            if with_offset { limited } else { plain }
        };
        let with_offset = (rules.presets_xist2)(&ram.user);
        let position = shown(Signal::G1Xist2, with_offset);
        let scaling = (rules.scales_velocity)(settings.scaling, &self.hardware, &ram.user);
        let stops = ram.sensor.is_parked() && self.behaviour.sensor.parking_stops_velocity;
        let is_measured = !stops && !ram.velocity_is_off && (rules.measures_velocity)(&ram.user);
        let plain_position = shown(Signal::Position, with_offset);
        let parts = Parts {
            position: shown(Signal::SingleTurn, with_offset),
            scaling: acting(Signal::SingleTurn).scaling,
            hardware: self.hardware,
            place: self.hardware.sense(self.shaft.place(self.now)),
            laps: ram.measuring.laps,
        };
        let [single_turn, multi_turn] = (self.behaviour.telegram.parts)(&parts);
        let status = Image {
            g1_zsw: ram.sensor.g1_zsw(),
            velocity: if is_measured { ram.velocity.value(&scaling, settings.direction) } else { 0 },
            velocity_before: ram.velocity.value_before(&scaling, settings.direction),
            speed_unit: ram.user.speed_unit,
            positions: self.positions(),
            has_speed: ram.submodules.iter().any(|one| one.telegram.inputs == [Signal::NistA]),
            good: true,
            position,
            offset: ram.measuring.offset,
            next_offset: ram.next_preset.map(|next| next.offset),
            plain_position: plain_position as u32,
            single_turn,
            multi_turn,
            is_transferred: ram.sensor.is_transferred(),
            request: ram.sensor.request(),
            ..Image::default()
        };
        if ram.sensor.is_parked() && !ram.sensor.is_frozen() {
            let g1_xist2 = match ram.sensor.xist2() {
                Xist2::Error(code) => code.into(),
                Xist2::Nothing | Xist2::Position => 0,
            };
            return Image { g1_xist2, ..status };
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
