//! Signals out: what the encoder shows in a frame, apart from ZSW2_ENC.

use crate::encoder_object::{Live, Model};
use crate::profidrive::sensor::Xist2;
use crate::profidrive::telegram::{Image, Parts, Signal};

impl<M: Model> Live<'_, M> {
    /// The signals as they are, apart from ZSW2_ENC.
    pub(super) fn image(&mut self) -> Image {
        let now = self.image_now();
        if !self.ram.sensor.is_frozen() {
            self.ram.frozen = None;
            return now;
        }
        let kept = *self.ram.frozen.get_or_insert(now);
        (self.behaviour.sensor.freezes)(kept, now)
    }

    fn image_now(&self) -> Image {
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
