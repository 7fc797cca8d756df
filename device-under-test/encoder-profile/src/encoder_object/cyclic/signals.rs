//! The signals of a frame, except ZSW2_ENC.

use crate::encoder_object::{EncoderModel, PoweredEncoder};
use crate::profidrive::checks::EncoderCheck;
use crate::profidrive::sensor::Xist2;
use crate::profidrive::telegram::{self, InputSignal, SignalImage};

/// Bit 13 of G1_ZSW.
const POSITION: u16 = 0x2000;

impl<M: EncoderModel> PoweredEncoder<'_, M> {
    /// The current signals, except ZSW2_ENC.
    pub(super) fn image(&mut self) -> SignalImage {
        let now = self.image_now();
        if !self.ram.sensor.is_frozen() {
            self.ram.frozen = None;
            return now;
        }
        frozen(*self.ram.frozen.get_or_insert(now), now)
    }

    fn image_now(&self) -> SignalImage {
        let (ram, deviations) = (&*self.ram, self.deviations);
        let settings = ram.measuring.settings;
        let acting = |signal| {
            deviations.telegram.apply(settings, |steps, settings| steps.acts_on(signal, &self.hardware, settings))
        };
        let usual = ram.measuring.positions();
        let position_in = |signal| {
            let acts = signal != InputSignal::G1Xist1 || ram.user.preset_acts_on_xist1;
            let with_offset = deviations.checks.check(EncoderCheck::PresetActsOn(signal, ram.user), acts);
            let [without, with] = if deviations.telegram.is_any() {
                ram.measuring.with_settings(acting(signal)).positions()
            } else {
                usual
            };
            if with_offset { with } else { without }
        };
        let position = position_in(InputSignal::G1Xist2);
        let of_velocity = acting(InputSignal::NistB);
        let is_measured = !ram.sensor.is_zeroed() && !ram.velocity_is_off;
        let is_measured = deviations.checks.check(EncoderCheck::VelocityIsMeasured(ram.user), is_measured);
        let plain_position = position_in(InputSignal::Position);
        let [single_turn, multi_turn] =
            telegram::parts(position_in(InputSignal::SingleTurn), &acting(InputSignal::SingleTurn).scaling);
        let status = SignalImage {
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
            ..SignalImage::default()
        };
        // XAC77, 16.3: while parked, positions are 0.
        if ram.sensor.is_zeroed() {
            return status;
        }
        SignalImage {
            g1_xist1: position_in(InputSignal::G1Xist1) as u32,
            shift: self.variant.shift,
            g1_xist3: position_in(InputSignal::G1Xist3),
            ..status
        }
    }
}

/// The signals while parking freezes the positions at those of its begin (`at_begin`). Errors are still shown.
fn frozen(at_begin: SignalImage, now: SignalImage) -> SignalImage {
    let shows_position = now.g1_zsw & POSITION != 0;
    SignalImage {
        g1_xist1: at_begin.g1_xist1,
        g1_xist2: if shows_position { at_begin.position as u32 } else { now.g1_xist2 },
        g1_xist3: at_begin.g1_xist3,
        plain_position: at_begin.plain_position,
        single_turn: at_begin.single_turn,
        multi_turn: at_begin.multi_turn,
        ..now
    }
}
