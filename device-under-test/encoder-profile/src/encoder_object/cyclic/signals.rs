//! The signals of a frame, except ZSW2_ENC.

use crate::encoder_object::{Live, Model};
use crate::profidrive::checks::Check;
use crate::profidrive::sensor::Xist2;
use crate::profidrive::telegram::{self, Image, Signal};

/// Bit 13 of G1_ZSW.
const POSITION: u16 = 0x2000;

impl<M: Model> Live<'_, M> {
    /// The current signals, except ZSW2_ENC.
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
        let position_in = |signal| {
            let acts = signal != Signal::G1Xist1 || ram.user.preset_acts_on_xist1;
            let with_offset = deviations.checks.check(Check::PresetActsOn(signal, ram.user), acts);
            let [without, with] =
                if deviations.telegram.is_any() { ram.measuring.under(acting(signal)).positions() } else { usual };
            if with_offset { with } else { without }
        };
        let position = position_in(Signal::G1Xist2);
        let of_velocity = acting(Signal::NistB);
        let is_measured = !ram.sensor.is_zeroed() && !ram.velocity_is_off;
        let is_measured = deviations.checks.check(Check::VelocityIsMeasured(ram.user), is_measured);
        let plain_position = position_in(Signal::Position);
        let [single_turn, multi_turn] =
            telegram::parts(position_in(Signal::SingleTurn), &acting(Signal::SingleTurn).scaling);
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
        // XAC77, 16.3: while parked, positions are 0.
        if ram.sensor.is_zeroed() {
            return status;
        }
        Image {
            g1_xist1: position_in(Signal::G1Xist1) as u32,
            shift: self.variant.shift,
            g1_xist3: position_in(Signal::G1Xist3),
            ..status
        }
    }
}

/// The signals while parking freezes the positions at those of its begin (`at_begin`). Errors are still shown.
fn frozen(at_begin: Image, now: Image) -> Image {
    let shows_position = now.g1_zsw & POSITION != 0;
    Image {
        g1_xist1: at_begin.g1_xist1,
        g1_xist2: if shows_position { at_begin.position as u32 } else { now.g1_xist2 },
        g1_xist3: at_begin.g1_xist3,
        plain_position: at_begin.plain_position,
        single_turn: at_begin.single_turn,
        multi_turn: at_begin.multi_turn,
        ..now
    }
}
