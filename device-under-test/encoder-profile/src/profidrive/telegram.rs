//! The telegrams of the encoder profile: their signals and the encoding of signals.

use super::preset_trigger::TRIGGER;
use super::sensor::SensorRequest;
use crate::encoder::{Hardware, MeasuringSettings, Scaling};
use alloc::vec::Vec;

/// A signal from the encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InputSignal {
    /// Encoder status word 2, 16 bits.
    Zsw2Enc,
    /// Sensor 1 status word, 16 bits.
    G1Zsw,
    /// Position 1, 32 bits.
    G1Xist1,
    /// Position 2 or error code, 32 bits.
    G1Xist2,
    /// Position 3, 64 bits.
    G1Xist3,
    /// Velocity, 16 bits, signed, saturating.
    NistA,
    /// Velocity, 32 bits, signed, saturating.
    NistB,
    /// The position, 32 bits, independent of G1_XIST2.
    Position,
    /// The position within a revolution, 32 bits.
    SingleTurn,
    /// The revolutions of the position, 32 bits.
    MultiTurn,
    /// A second G1_ZSW, 16 bits, in a separate submodule.
    SeparateG1Zsw,
    /// Seconds since power-up, 16 bits.
    TimeStamp,
}

/// A word from the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OutputWord {
    /// Encoder control word 2, 16 bits.
    Stw2Enc,
    /// Sensor 1 control word, 16 bits.
    G1Stw,
    /// A preset value with its trigger, 32 bits.
    Preset,
    /// The same in 64 bits: bit 63 is the trigger.
    LongPreset,
    /// A second G1_STW, 16 bits, in a separate submodule. It is ignored.
    SeparateG1Stw,
    /// Four bytes without a function.
    Unused,
}

impl OutputWord {
    /// Its length in bytes.
    pub const fn octets(self) -> usize {
        match self {
            OutputWord::Stw2Enc | OutputWord::G1Stw | OutputWord::SeparateG1Stw => 2,
            OutputWord::Preset | OutputWord::Unused => 4,
            OutputWord::LongPreset => 8,
        }
    }
}

/// A telegram, or the part of a telegram in a separate submodule.
#[derive(Debug, PartialEq, Eq)]
pub struct Telegram {
    /// Its number in P922; 0 for a part without a number.
    pub number: u16,
    /// Signals from the encoder, in order.
    pub inputs: &'static [InputSignal],
    /// Input length in bytes.
    pub input_octets: u16,
    /// Words from the controller, in order.
    pub outputs: &'static [OutputWord],
    /// Output length in bytes.
    pub output_octets: u16,
}

use InputSignal::{
    G1Xist1, G1Xist2, G1Xist3, G1Zsw, MultiTurn, NistA, NistB, Position, SeparateG1Zsw, SingleTurn, TimeStamp, Zsw2Enc,
};
use OutputWord::{G1Stw, Stw2Enc};

const fn standard(number: u16, inputs: &'static [InputSignal], input_octets: u16) -> Telegram {
    Telegram { number, inputs, input_octets, outputs: &[Stw2Enc, G1Stw], output_octets: 4 }
}

/// The standard telegrams 81 to 84; 81 is the default (XAC77 manual, 9.1).
pub static STANDARD: [Telegram; 4] = [
    standard(81, &[Zsw2Enc, G1Zsw, G1Xist1, G1Xist2], 12),
    standard(82, &[Zsw2Enc, G1Zsw, G1Xist1, G1Xist2, NistA], 14),
    standard(83, &[Zsw2Enc, G1Zsw, G1Xist1, G1Xist2, NistB], 16),
    standard(84, &[Zsw2Enc, G1Zsw, G1Xist3, G1Xist2, NistB], 20),
];

/// The outputs of the last frame; `None` for those that were bad or missing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct OutputValues {
    /// STW2_ENC and G1_STW.
    pub words: Option<[u16; 2]>,
    /// The preset value with its trigger.
    pub preset: Option<u32>,
    /// The G1_STW in a separate submodule.
    pub separate: Option<u16>,
    /// Four bytes without a function.
    pub unused: Option<u32>,
}

impl OutputValues {
    /// Parses the outputs of one telegram. All fields are `None` if the outputs are bad (`None`) or have the wrong
    /// length.
    pub fn read(telegram: &Telegram, octets: Option<&[u8]>) -> OutputValues {
        let mut arrived = OutputValues::default();
        let length = telegram.outputs.iter().map(|control| control.octets()).sum::<usize>();
        let Some(mut rest) = octets.filter(|octets| octets.len() == length) else { return arrived };
        for control in telegram.outputs {
            let (word, remaining) = rest.split_at(control.octets());
            rest = remaining;
            let long = word.iter().fold(0, |number, octet| number << 8 | u64::from(*octet));
            let number = long as u32;
            match control {
                Stw2Enc => arrived.words.get_or_insert_default()[0] = number as u16,
                G1Stw => arrived.words.get_or_insert_default()[1] = number as u16,
                OutputWord::Preset => arrived.preset = Some(number),
                OutputWord::LongPreset => arrived.preset = Some((long >> 32) as u32 & TRIGGER | number & !TRIGGER),
                OutputWord::SeparateG1Stw => arrived.separate = Some(number as u16),
                OutputWord::Unused => arrived.unused = Some(number),
            }
        }
        arrived
    }

    /// Replaces the outputs of one telegram. Those of other telegrams keep their values.
    pub fn replace(&mut self, telegram: &Telegram, arrived: OutputValues) {
        for control in telegram.outputs {
            match control {
                Stw2Enc | G1Stw => self.words = arrived.words,
                OutputWord::Preset | OutputWord::LongPreset => self.preset = arrived.preset,
                OutputWord::SeparateG1Stw => self.separate = arrived.separate,
                OutputWord::Unused => self.unused = arrived.unused,
            }
        }
    }
}

/// The values of all signals at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SignalImage {
    /// ZSW2_ENC.
    pub zsw2_enc: u16,
    /// G1_ZSW.
    pub g1_zsw: u16,
    /// G1_XIST1 before the shift.
    pub g1_xist1: u32,
    /// Left shift of G1_XIST1 in the frame, 0 to 31 bits.
    pub shift: u32,
    /// G1_XIST2.
    pub g1_xist2: u32,
    /// G1_XIST3.
    pub g1_xist3: u64,
    /// The velocity in the unit in force.
    pub velocity: i64,
    /// Whether the inputs are good.
    pub good: bool,
    /// The position with offset, even if no signal contains it.
    pub position: u64,
    /// The offset of all presets, in units.
    pub offset: u64,
    /// The value of [`InputSignal::Position`].
    pub plain_position: u32,
    /// The position within a revolution.
    pub single_turn: u32,
    /// The revolutions of the position.
    pub multi_turn: u32,
    /// Seconds since power-up.
    pub time_stamp: u16,
    /// Whether G1_XIST2 contains the position, provided that neither an error nor parking prevents it.
    pub is_transferred: bool,
    /// The requests that were answered.
    pub request: SensorRequest,
    /// STW2_ENC and G1_STW as received, valid or not; 0 without outputs.
    pub outputs: [u16; 2],
    /// The preset word as received; 0 without one.
    pub trigger: u32,
}

/// The signals of the previous cycle.
#[derive(Clone, Copy, Debug, Default)]
pub struct PreviousCycle {
    /// The signals before the hooks.
    pub unhooked: SignalImage,
    /// The signals that were sent.
    pub sent: SignalImage,
}

/// The position within a revolution, and the number of revolutions.
pub fn parts(position: u64, scaling: &Scaling) -> [u32; 2] {
    let units = scaling.units_per_revolution.max(1);
    [position % units, position / units].map(|part| part as u32)
}

/// The steps of the telegrams that a deviation may change. Each default changes nothing.
#[allow(unused_variables, reason = "the names document the step")]
pub trait TelegramSteps {
    /// The settings that apply to a signal.
    fn acts_on(&mut self, signal: InputSignal, hardware: &Hardware, right: MeasuringSettings) -> MeasuringSettings {
        right
    }
}

impl InputSignal {
    /// Its length in bytes.
    pub const fn octets(self) -> usize {
        match self {
            Zsw2Enc | G1Zsw | SeparateG1Zsw | NistA | TimeStamp => 2,
            G1Xist1 | G1Xist2 | NistB | Position | SingleTurn | MultiTurn => 4,
            G1Xist3 => 8,
        }
    }

    /// The value of the signal. Its low bytes are sent.
    pub fn value(self, image: &SignalImage) -> u64 {
        match self {
            Zsw2Enc => image.zsw2_enc.into(),
            G1Zsw | SeparateG1Zsw => image.g1_zsw.into(),
            G1Xist1 => (image.g1_xist1 << image.shift).into(),
            G1Xist2 => image.g1_xist2.into(),
            G1Xist3 => image.g1_xist3,
            NistA => image.velocity.clamp(i16::MIN.into(), i16::MAX.into()) as u64,
            NistB => image.velocity.clamp(i32::MIN.into(), i32::MAX.into()) as u64,
            Position => image.plain_position.into(),
            SingleTurn => image.single_turn.into(),
            MultiTurn => image.multi_turn.into(),
            TimeStamp => image.time_stamp.into(),
        }
    }
}

impl Telegram {
    /// Writes the signals in order, most significant byte first. Signals beyond the end of `octets` are truncated;
    /// remaining bytes are 0.
    pub fn write(&self, image: &SignalImage, octets: &mut [u8]) {
        let mut rest = octets;
        for signal in self.inputs {
            let length = signal.octets().min(rest.len());
            let (sent, remaining) = core::mem::take(&mut rest).split_at_mut(length);
            let value = (signal.value(image) << (64 - 8 * signal.octets())).to_be_bytes();
            sent.copy_from_slice(&value[..length]);
            rest = remaining;
        }
        rest.fill(0);
    }

    /// The bytes of all signals.
    pub fn octets(&self, image: &SignalImage) -> Vec<u8> {
        let mut octets = alloc::vec![0; self.inputs.iter().map(|signal| signal.octets()).sum()];
        self.write(image, &mut octets);
        octets
    }
}

#[cfg(test)]
mod tests;
