//! The telegrams of the encoder profile: which signals they carry, and how a signal becomes octets.

use super::sensor::Request;
use crate::encoder::{Hardware, Scaling, Settings};
use alloc::vec::Vec;
use wire::octets::Append;

/// A signal from the encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
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
    /// Velocity, 16 bits, signed; stops at the limits.
    NistA,
    /// Velocity, 32 bits, signed; stops at the limits.
    NistB,
    /// The position alone, 32 bits, whatever G1_XIST2 shows.
    Position,
    /// The position within a revolution, 32 bits.
    SingleTurn,
    /// The revolutions in the position, 32 bits.
    MultiTurn,
    /// G1_ZSW once more, 16 bits, in a submodule of its own.
    SeparateG1Zsw,
    /// Seconds since power-up, 16 bits.
    TimeStamp,
}

/// A word from the controller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Control {
    /// Encoder control word 2, 16 bits.
    Stw2Enc,
    /// Sensor 1 control word, 16 bits.
    G1Stw,
    /// A preset value with its trigger, 32 bits.
    Preset,
    /// A second G1_STW, 16 bits, in a submodule of its own.
    SeparateG1Stw,
    /// Four octets without a function.
    Unused,
}

impl Control {
    /// Its octets.
    pub const fn octets(self) -> usize {
        match self {
            Control::Stw2Enc | Control::G1Stw | Control::SeparateG1Stw => 2,
            Control::Preset | Control::Unused => 4,
        }
    }
}

/// A telegram, or the part of one that stands in a submodule of its own.
#[derive(Debug, PartialEq, Eq)]
pub struct Telegram {
    /// Its number, as P922 gives it; 0 for a part that has none.
    pub number: u16,
    /// Signals from the encoder, in order.
    pub inputs: &'static [Signal],
    /// Octets from the encoder.
    pub input_octets: u16,
    /// Words from the controller, in order.
    pub outputs: &'static [Control],
    /// Octets from the controller.
    pub output_octets: u16,
}

use Control::{G1Stw, Stw2Enc};
use Signal::{
    G1Xist1, G1Xist2, G1Xist3, G1Zsw, MultiTurn, NistA, NistB, Position, SeparateG1Zsw, SingleTurn, TimeStamp, Zsw2Enc,
};

const fn standard(number: u16, inputs: &'static [Signal], input_octets: u16) -> Telegram {
    Telegram { number, inputs, input_octets, outputs: &[Stw2Enc, G1Stw], output_octets: 4 }
}

/// The standard telegrams; 81 is the default. Source: XAC77 manual, 9.1.
pub static STANDARD: [Telegram; 4] = [
    standard(81, &[Zsw2Enc, G1Zsw, G1Xist1, G1Xist2], 12),
    standard(82, &[Zsw2Enc, G1Zsw, G1Xist1, G1Xist2, NistA], 14),
    standard(83, &[Zsw2Enc, G1Zsw, G1Xist1, G1Xist2, NistB], 16),
    standard(84, &[Zsw2Enc, G1Zsw, G1Xist3, G1Xist2, NistB], 20),
];

/// What was taken from the controller in the last frame, as far as it was good.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Outputs {
    /// STW2_ENC and G1_STW.
    pub words: Option<[u16; 2]>,
    /// The preset value with its trigger.
    pub preset: Option<u32>,
    /// The G1_STW in a submodule of its own.
    pub separate: Option<u16>,
    /// Four octets without a function.
    pub unused: Option<u32>,
}

impl Outputs {
    /// Takes what arrived in one telegram; what comes with others stays as it is.
    pub fn replace(&mut self, telegram: &Telegram, arrived: Outputs) {
        for control in telegram.outputs {
            match control {
                Stw2Enc | G1Stw => self.words = arrived.words,
                Control::Preset => self.preset = arrived.preset,
                Control::SeparateG1Stw => self.separate = arrived.separate,
                Control::Unused => self.unused = arrived.unused,
            }
        }
    }
}

/// The values of all signals at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Image {
    /// ZSW2_ENC.
    pub zsw2_enc: u16,
    /// G1_ZSW.
    pub g1_zsw: u16,
    /// G1_XIST1, before it is shifted.
    pub g1_xist1: u32,
    /// By how many bits G1_XIST1 is sent shifted to the left, 0 to 31.
    pub shift: u32,
    /// G1_XIST2.
    pub g1_xist2: u32,
    /// G1_XIST3.
    pub g1_xist3: u64,
    /// The velocity in the unit in force.
    pub velocity: i64,
    /// The velocity of the window before, in the same unit.
    pub velocity_before: i64,
    /// The unit of the velocity, as the user parameters number it.
    pub speed_unit: u8,
    /// How many positions there are.
    pub positions: u64,
    /// Whether there is a submodule with the velocity alone.
    pub has_speed: bool,
    /// Whether the inputs are good.
    pub good: bool,
    /// The position with offset, whether or not it is shown anywhere.
    pub position: u64,
    /// The offset of all presets, in units.
    pub offset: u64,
    /// The offset that takes effect when the preset is carried out that is running.
    pub next_offset: Option<u64>,
    /// The position alone.
    pub plain_position: u32,
    /// The position within a revolution.
    pub single_turn: u32,
    /// The revolutions in the position.
    pub multi_turn: u32,
    /// Seconds since power-up.
    pub time_stamp: u16,
    /// Whether the position stands in G1_XIST2 where neither an error nor parking is in its way.
    pub is_transferred: bool,
    /// The requests that were answered.
    pub request: Request,
    /// STW2_ENC and G1_STW as they were taken, valid or not; 0 without any.
    pub outputs: [u16; 2],
    /// The preset value with its trigger as it was taken; 0 without one.
    pub trigger: u32,
}

/// The cycle before.
#[derive(Clone, Copy, Debug, Default)]
pub struct Before {
    /// What was the case.
    pub truth: Image,
    /// What was sent.
    pub sent: Image,
}

/// What a position is taken apart by.
#[derive(Clone, Copy, Debug)]
pub struct Parts {
    /// The position that is taken apart.
    pub position: u64,
    /// The scaling in force.
    pub scaling: Scaling,
    /// What the sensor tells apart.
    pub hardware: Hardware,
    /// Where the sensor stands, in hardware steps.
    pub place: u64,
    /// How often the shaft has gone over the physical zero, clockwise positive.
    pub laps: i64,
}

/// The position within a revolution and the revolutions in it.
pub fn parts(parts: &Parts) -> [u32; 2] {
    let units = parts.scaling.units_per_revolution.max(1);
    [parts.position % units, parts.position / units].map(|part| part as u32)
}

/// Where bugs can be put into the telegrams.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// STW2_ENC and G1_STW, from the two words received.
    pub control_words: fn(&Telegram, [u16; 2]) -> [u16; 2],
    /// STW2_ENC and G1_STW that are obeyed, from those of the telegram and the G1_STW in a submodule of its own.
    pub separate: fn([u16; 2], u16) -> [u16; 2],
    /// The preset value with its trigger that is obeyed, from the right one and the four octets without a function.
    pub trigger: fn(u32, Option<u32>) -> u32,
    /// By how many bits G1_XIST1 is shifted to the left, from the right number of them.
    pub shift: fn(&Settings, &Hardware, u32) -> u32,
    /// Whether the telegram of the first connection stays in use.
    pub stays: bool,
    /// The position within a revolution and the revolutions in it.
    pub parts: fn(&Parts) -> [u32; 2],
    /// Octets from the encoder.
    pub input_octets: fn(&Telegram) -> u16,
    /// The order of the signals of a telegram.
    pub order: fn(&Telegram) -> &'static [Signal],
    /// Whether the inputs of a submodule are good, from whether it is the last one of the frame and the right answer.
    pub is_good: fn(bool, bool) -> bool,
    /// Appends a signal of a telegram.
    pub put: fn(&Telegram, Signal, &Image, &mut Vec<u8>),
}

impl Default for Rules {
    fn default() -> Rules {
        Rules {
            control_words: |_, words| words,
            separate: |words, _| words,
            trigger: |right, _| right,
            shift: |_, _, right| right,
            stays: false,
            parts,
            input_octets: |telegram| telegram.input_octets,
            order: |telegram| telegram.inputs,
            is_good: |_, right| right,
            put: |_, signal, image, out| put(signal, image, out),
        }
    }
}

/// Appends a signal, most significant octet first.
pub fn put(signal: Signal, image: &Image, out: &mut Vec<u8>) {
    match signal {
        Zsw2Enc => out.put_u16(image.zsw2_enc),
        G1Zsw | SeparateG1Zsw => out.put_u16(image.g1_zsw),
        G1Xist1 => out.put_u32(image.g1_xist1 << image.shift),
        G1Xist2 => out.put_u32(image.g1_xist2),
        G1Xist3 => out.put(&image.g1_xist3.to_be_bytes()),
        NistA => out.put(&(image.velocity.clamp(i16::MIN.into(), i16::MAX.into()) as i16).to_be_bytes()),
        NistB => out.put(&(image.velocity.clamp(i32::MIN.into(), i32::MAX.into()) as i32).to_be_bytes()),
        Position => out.put_u32(image.plain_position),
        SingleTurn => out.put_u32(image.single_turn),
        MultiTurn => out.put_u32(image.multi_turn),
        TimeStamp => out.put_u16(image.time_stamp),
    }
}

/// Reads the control words and writes the signals of a telegram.
#[derive(Clone)]
pub struct Emitter {
    before: Before,
    rules: Rules,
    /// The octets of a telegram while it is filled in; kept so that no frame allocates.
    spare: Vec<u8>,
}

impl Emitter {
    /// An emitter that has sent nothing yet.
    pub fn new(rules: Rules) -> Emitter {
        Emitter { before: Before::default(), rules, spare: Vec::new() }
    }

    /// The last cycle.
    pub fn before(&self) -> &Before {
        &self.before
    }

    /// Takes what the controller sent to one telegram; what comes with others stays as it is.
    ///
    /// No word is taken where the octets are none, since they were bad, or of another length.
    pub fn take(&self, taken: &mut Outputs, telegram: &Telegram, octets: Option<&[u8]>) {
        let wanted = telegram.outputs.iter().map(|control| control.octets()).sum::<usize>();
        let octets = octets.filter(|octets| octets.len() == wanted);
        let mut words = [0; 2];
        let mut rest = octets.unwrap_or_default();
        for control in telegram.outputs {
            let (word, behind) = rest.split_at(control.octets().min(rest.len()));
            rest = behind;
            let number = word.iter().fold(0, |number, octet| number << 8 | u32::from(*octet));
            match control {
                Stw2Enc => words[0] = number as u16,
                G1Stw => words[1] = number as u16,
                Control::Preset => taken.preset = octets.map(|_| number),
                Control::SeparateG1Stw => taken.separate = octets.map(|_| number as u16),
                Control::Unused => taken.unused = octets.map(|_| number),
            }
        }
        if telegram.outputs.iter().any(|control| matches!(control, Stw2Enc | G1Stw)) {
            taken.words = octets.map(|_| (self.rules.control_words)(telegram, words));
        }
    }

    /// STW2_ENC and G1_STW that are obeyed; none without a good telegram that brings them.
    pub fn control_words(&self, taken: &Outputs) -> Option<[u16; 2]> {
        taken.words.map(|words| taken.separate.map_or(words, |separate| (self.rules.separate)(words, separate)))
    }

    /// The preset value with its trigger that is obeyed.
    pub fn trigger(&self, taken: &Outputs) -> Option<u32> {
        taken.preset.map(|word| (self.rules.trigger)(word, taken.unused))
    }

    /// Begins a frame: these are the signals of all its telegrams, as they are and as they are sent.
    pub fn begin(&mut self, truth: Image, sent: Image) {
        self.before = Before { truth, sent };
    }

    /// Fills in the inputs of one telegram of the frame and says whether they are good.
    pub fn fill(&mut self, telegram: &Telegram, inputs: &mut [u8]) -> bool {
        let Emitter { before: Before { sent, .. }, spare: octets, .. } = self;
        octets.clear();
        for signal in (self.rules.order)(telegram) {
            (self.rules.put)(telegram, *signal, sent, octets);
        }
        octets.resize(inputs.len(), 0);
        inputs.copy_from_slice(octets);
        sent.good
    }

    /// Begins a frame of one telegram, fills in its inputs and says whether they are good.
    pub fn emit(&mut self, telegram: &Telegram, image: Image, inputs: &mut [u8]) -> bool {
        self.begin(image, image);
        self.fill(telegram, inputs)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    const IMAGE: Image = Image {
        zsw2_enc: 0x3200,
        g1_zsw: 0x2000,
        g1_xist1: 0x0001_2345,
        shift: 0,
        g1_xist2: 0x1002,
        g1_xist3: 0x0012_3456_789A_BCDE,
        velocity: -60,
        velocity_before: -60,
        speed_unit: 0,
        positions: 1 << 28,
        has_speed: false,
        good: true,
        position: 0,
        offset: 0,
        next_offset: None,
        plain_position: 0x1234_5678,
        single_turn: 0x0678,
        multi_turn: 0x0001_2345,
        time_stamp: 0,
        is_transferred: false,
        request: Request { relative: false, home: false, absolute: false, park: false, acknowledge: false },
        outputs: [0; 2],
        trigger: 0,
    };

    // Layouts: XAC77 manual, 9.1.1 to 9.1.4.
    #[rstest]
    #[case(0, &[0x32, 0x00, 0x20, 0x00, 0x00, 0x01, 0x23, 0x45, 0x00, 0x00, 0x10, 0x02])]
    #[case(1, &[0x32, 0x00, 0x20, 0x00, 0x00, 0x01, 0x23, 0x45, 0x00, 0x00, 0x10, 0x02, 0xFF, 0xC4])]
    #[case(2, &[0x32, 0x00, 0x20, 0x00, 0x00, 0x01, 0x23, 0x45, 0x00, 0x00, 0x10, 0x02, 0xFF, 0xFF, 0xFF, 0xC4])]
    #[case(3, &[0x32, 0x00, 0x20, 0x00, 0x00, 0x12, 0x34, 0x56, 0x78, 0x9A, 0xBC, 0xDE, 0x00, 0x00, 0x10, 0x02, 0xFF,
                0xFF, 0xFF, 0xC4])]
    fn layouts(#[case] index: usize, #[case] expected: &[u8]) {
        let telegram = &STANDARD[index];
        let mut inputs = alloc::vec![0xAA; telegram.input_octets.into()];
        assert!(Emitter::new(Rules::default()).emit(telegram, IMAGE, &mut inputs));
        assert_eq!(inputs, expected);
    }

    #[rstest]
    #[case(65536, [0x7F, 0xFF], [0x00, 0x01, 0x00, 0x00])]
    #[case(-65536, [0x80, 0x00], [0xFF, 0xFF, 0x00, 0x00])]
    #[case(1 << 40, [0x7F, 0xFF], [0x7F, 0xFF, 0xFF, 0xFF])]
    #[case(6000, [0x17, 0x70], [0x00, 0x00, 0x17, 0x70])]
    fn velocities_stop_at_their_limits(#[case] velocity: i64, #[case] a: [u8; 2], #[case] b: [u8; 4]) {
        let image = Image { velocity, ..IMAGE };
        let (mut nist_a, mut nist_b) = (Vec::new(), Vec::new());
        put(NistA, &image, &mut nist_a);
        put(NistB, &image, &mut nist_b);
        assert_eq!((&nist_a[..], &nist_b[..]), (&a[..], &b[..]));
    }

    #[rstest]
    #[case(&[0x04, 0x00, 0x20, 0x00], Some([0x0400, 0x2000]))]
    #[case(&[0x04, 0x00, 0x20], None)]
    #[case(&[], None)]
    fn control_words(#[case] octets: &[u8], #[case] words: Option<[u16; 2]>) {
        let emitter = Emitter::new(Rules::default());
        let mut taken = Outputs { words: Some([1, 2]), preset: Some(3), separate: Some(4), unused: None };
        emitter.take(&mut taken, &STANDARD[0], Some(octets));
        assert_eq!(taken, Outputs { words, preset: Some(3), separate: Some(4), unused: None });
        assert_eq!(emitter.control_words(&taken), words);
        emitter.take(&mut taken, &STANDARD[0], None);
        assert_eq!(taken.words, None);
    }

    // Kübler Sendix 58xx: the position and the velocity of telegram 860 in 8 octets, a preset value with its trigger in 4;
    // the speed, the parts of the position and a second pair of sensor words in submodules of their own.
    static TELEGRAM_860: Telegram = Telegram {
        number: 860,
        inputs: &[Position, NistB],
        input_octets: 8,
        outputs: &[Control::Preset],
        output_octets: 4,
    };
    static PARTS: Telegram = Telegram {
        number: 0,
        inputs: &[NistA, SingleTurn, MultiTurn, SeparateG1Zsw],
        input_octets: 12,
        outputs: &[Control::SeparateG1Stw],
        output_octets: 2,
    };

    #[test]
    fn several_telegrams_share_a_frame() {
        let mut emitter = Emitter::new(Rules::default());
        emitter.begin(IMAGE, IMAGE);
        let (mut first, mut second) = ([0xAA; 8], [0xAA; 12]);
        assert!(emitter.fill(&TELEGRAM_860, &mut first) && emitter.fill(&PARTS, &mut second));
        assert_eq!(first, [0x12, 0x34, 0x56, 0x78, 0xFF, 0xFF, 0xFF, 0xC4]);
        assert_eq!(second, [0xFF, 0xC4, 0, 0, 0x06, 0x78, 0x00, 0x01, 0x23, 0x45, 0x20, 0x00]);
        let mut taken = Outputs::default();
        emitter.take(&mut taken, &TELEGRAM_860, Some(&[0x80, 0, 0x12, 0x34]));
        emitter.take(&mut taken, &PARTS, Some(&[0x40, 0]));
        assert_eq!(taken, Outputs { words: None, preset: Some(0x8000_1234), separate: Some(0x4000), unused: None });
        assert_eq!(emitter.control_words(&taken), None);
        emitter.take(&mut taken, &TELEGRAM_860, Some(&[0x80, 0, 0x12]));
        assert_eq!(taken, Outputs { words: None, preset: None, separate: Some(0x4000), unused: None });
    }

    // SICK AFS60/AFM60: 65536 is sent as 00 04 00 00 by 30 bits and as 40 00 00 00 by 18.
    #[rstest]
    #[case(2, [0x00, 0x04, 0x00, 0x00])]
    #[case(14, [0x40, 0x00, 0x00, 0x00])]
    fn position_1_is_shifted(#[case] shift: u32, #[case] octets: [u8; 4]) {
        let mut sent = Vec::new();
        put(G1Xist1, &Image { g1_xist1: 0x1_0000, shift, ..IMAGE }, &mut sent);
        assert_eq!(sent, octets);
    }

    // Kübler Sendix 58xx: 4096 units a revolution, place 0x3456 of a range of 0x4000 units; a range below a revolution.
    #[rstest]
    #[case(0x3456, 0x1000, [0x456, 3])]
    #[case(0x07FF, 0x1000, [0x7FF, 0])]
    fn positions_have_two_parts(#[case] position: u64, #[case] units: u64, #[case] expected: [u32; 2]) {
        let hardware = Hardware { steps_per_revolution: 1 << 16, revolutions: 1 << 12 };
        let scaling = Scaling { units_per_revolution: units, range: 0x4000 };
        assert_eq!(parts(&Parts { position, scaling, hardware, place: 0, laps: 0 }), expected);
    }
}
