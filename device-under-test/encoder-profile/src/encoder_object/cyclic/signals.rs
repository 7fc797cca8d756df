//! Signals out: what the encoder shows in a frame, apart from ZSW2_ENC.

use crate::encoder_object::{Live, Model};
use crate::profidrive::checks::Check;
use crate::profidrive::sensor::Xist2;
use crate::profidrive::telegram::{self, Image, Signal};

/// Bit 13 of G1_ZSW.
const POSITION: u16 = 0x2000;

impl<M: Model> Live<'_, M> {
    /// The signals as they are, apart from ZSW2_ENC.
    pub(super) fn image(&mut self) -> Image {
        let now = self.image_now();
        if !self.ram.sensor.is_frozen() {
            self.ram.frozen = None;
            return now;
        }
        frozen(*self.ram.frozen.get_or_insert(now), now)
    }

    fn image_now(&self) -> Image {
        let (ram, deviations) = (&*self.ram, self.deviations);
        let settings = ram.measuring.settings;
        let acting = |signal| {
            deviations.telegram.apply(settings, |steps, settings| steps.acts_on(signal, &self.hardware, settings))
        };
        let usual = ram.measuring.positions();
        let shown = |signal| {
            let acts = signal != Signal::G1Xist1 || ram.user.preset_acts_on_xist1;
            let with_offset = deviations.checks.check(Check::PresetActsOn(signal, ram.user), acts);
            let [plain, limited] = match deviations.telegram.is_any() {
                true => ram.measuring.under(acting(signal)).positions(),
                false => usual,
            };
            if with_offset { limited } else { plain }
        };
        let position = shown(Signal::G1Xist2);
        let of_velocity = acting(Signal::NistB);
        let is_measured = !ram.sensor.is_zeroed() && !ram.velocity_is_off;
        let is_measured = deviations.checks.check(Check::VelocityIsMeasured(ram.user), is_measured);
        let plain_position = shown(Signal::Position);
        let [single_turn, multi_turn] = telegram::parts(shown(Signal::SingleTurn), &acting(Signal::SingleTurn).scaling);
        let status = Image {
            g1_zsw: ram.sensor.g1_zsw(),
            velocity: if is_measured { ram.velocity.value(&of_velocity.scaling, of_velocity.direction) } else { 0 },
            good: true,
            g1_xist2: match ram.sensor.xist2() {
                Xist2::Nothing => 0,
                Xist2::Position => position as u32,
                Xist2::Error(code) => code.into(),
            },
            position,
            offset: ram.measuring.offset,
            plain_position: plain_position as u32,
            single_turn,
            multi_turn,
            is_transferred: ram.sensor.is_transferred(),
            request: ram.sensor.request(),
            ..Image::default()
        };
        // XAC77, 16.3: parking makes the positions 0.
        if ram.sensor.is_zeroed() {
            return status;
        }
        Image {
            g1_xist1: shown(Signal::G1Xist1) as u32,
            shift: self.variant.shift,
            g1_xist3: shown(Signal::G1Xist3),
            ..status
        }
    }
}

/// The signals while parking fixes the positions, from those at its begin; an error is shown all the same.
fn frozen(kept: Image, now: Image) -> Image {
    let shows_position = now.g1_zsw & POSITION != 0;
    Image {
        g1_xist1: kept.g1_xist1,
        g1_xist2: if shows_position { kept.position as u32 } else { now.g1_xist2 },
        g1_xist3: kept.g1_xist3,
        plain_position: kept.plain_position,
        single_turn: kept.single_turn,
        multi_turn: kept.multi_turn,
        ..now
    }
}
