//! The telegrams of the encoder profile: which signals they carry, and how a signal becomes octets.

use super::sensor::Request;
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
}

/// A telegram; all of them take the control words STW2_ENC and G1_STW from the controller.
#[derive(Debug, PartialEq, Eq)]
pub struct Telegram {
    /// Its number, as P922 gives it.
    pub number: u16,
    /// Signals from the encoder, in order.
    pub inputs: &'static [Signal],
    /// Octets from the encoder.
    pub input_octets: u16,
}

/// Octets from the controller: STW2_ENC and G1_STW.
pub const OUTPUT_OCTETS: u16 = 4;

use Signal::{G1Xist1, G1Xist2, G1Xist3, G1Zsw, NistA, NistB, Zsw2Enc};

/// The standard telegrams; 81 is the default. Source: XAC77 manual, 9.1.
pub static STANDARD: [Telegram; 4] = [
    Telegram { number: 81, inputs: &[Zsw2Enc, G1Zsw, G1Xist1, G1Xist2], input_octets: 12 },
    Telegram { number: 82, inputs: &[Zsw2Enc, G1Zsw, G1Xist1, G1Xist2, NistA], input_octets: 14 },
    Telegram { number: 83, inputs: &[Zsw2Enc, G1Zsw, G1Xist1, G1Xist2, NistB], input_octets: 16 },
    Telegram { number: 84, inputs: &[Zsw2Enc, G1Zsw, G1Xist3, G1Xist2, NistB], input_octets: 20 },
];

/// The values of all signals at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Image {
    /// ZSW2_ENC.
    pub zsw2_enc: u16,
    /// G1_ZSW.
    pub g1_zsw: u16,
    /// G1_XIST1.
    pub g1_xist1: u32,
    /// G1_XIST2.
    pub g1_xist2: u32,
    /// G1_XIST3.
    pub g1_xist3: u64,
    /// The velocity in the unit in force.
    pub velocity: i64,
    /// Whether the inputs are good.
    pub good: bool,
    /// The position with offset, whether or not it is shown anywhere.
    pub position: u64,
    /// The requests that were answered.
    pub request: Request,
    /// STW2_ENC and G1_STW as they were taken, valid or not; 0 without any.
    pub outputs: [u16; 2],
}

/// The cycle before.
#[derive(Clone, Copy, Debug, Default)]
pub struct Before {
    /// What was the case.
    pub truth: Image,
    /// What was sent.
    pub sent: Image,
}

/// Where bugs can be put into the telegrams.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// STW2_ENC and G1_STW, from the two words received.
    pub control_words: fn(&Telegram, [u16; 2]) -> [u16; 2],
    /// Octets from the encoder.
    pub input_octets: fn(&Telegram) -> u16,
    /// The order of the signals of a telegram.
    pub order: fn(&Telegram) -> &'static [Signal],
    /// What is sent, from the cycle before and what is the case now.
    pub emit: fn(&Before, Image) -> Image,
    /// Appends a signal of a telegram.
    pub put: fn(&Telegram, Signal, &Image, &mut Vec<u8>),
}

impl Default for Rules {
    fn default() -> Rules {
        Rules {
            control_words: |_, words| words,
            input_octets: |telegram| telegram.input_octets,
            order: |telegram| telegram.inputs,
            emit: |_, image| image,
            put: |_, signal, image, out| put(signal, image, out),
        }
    }
}

/// Appends a signal, most significant octet first.
pub fn put(signal: Signal, image: &Image, out: &mut Vec<u8>) {
    match signal {
        Zsw2Enc => out.put_u16(image.zsw2_enc),
        G1Zsw => out.put_u16(image.g1_zsw),
        G1Xist1 => out.put_u32(image.g1_xist1),
        G1Xist2 => out.put_u32(image.g1_xist2),
        G1Xist3 => out.put(&image.g1_xist3.to_be_bytes()),
        NistA => out.put(&(image.velocity.clamp(i16::MIN.into(), i16::MAX.into()) as i16).to_be_bytes()),
        NistB => out.put(&(image.velocity.clamp(i32::MIN.into(), i32::MAX.into()) as i32).to_be_bytes()),
    }
}

/// Reads the control words and writes the signals of a telegram.
#[derive(Clone, Debug)]
pub struct Emitter {
    before: Before,
    rules: Rules,
}

impl Emitter {
    /// An emitter that has sent nothing yet.
    pub fn new(rules: Rules) -> Emitter {
        Emitter { before: Before::default(), rules }
    }

    /// The last cycle.
    pub fn before(&self) -> Before {
        self.before
    }

    /// STW2_ENC and G1_STW in the outputs of the controller; none if the length is another one.
    pub fn control_words(&self, telegram: &Telegram, outputs: &[u8]) -> Option<[u16; 2]> {
        let &[a, b, c, d] = outputs else { return None };
        Some((self.rules.control_words)(telegram, [u16::from_be_bytes([a, b]), u16::from_be_bytes([c, d])]))
    }

    /// Fills in the inputs of `telegram` and says whether they are good.
    pub fn emit(&mut self, telegram: &Telegram, image: Image, inputs: &mut [u8]) -> bool {
        let sent = (self.rules.emit)(&self.before, image);
        self.before = Before { truth: image, sent };
        let mut octets = Vec::with_capacity(inputs.len());
        for signal in (self.rules.order)(telegram) {
            (self.rules.put)(telegram, *signal, &sent, &mut octets);
        }
        octets.resize(inputs.len(), 0);
        inputs.copy_from_slice(&octets);
        sent.good
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
        g1_xist2: 0x1002,
        g1_xist3: 0x0012_3456_789A_BCDE,
        velocity: -60,
        good: true,
        position: 0,
        request: Request { relative: false, home: false, absolute: false, park: false, acknowledge: false },
        outputs: [0; 2],
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
    fn control_words(#[case] outputs: &[u8], #[case] words: Option<[u16; 2]>) {
        assert_eq!(Emitter::new(Rules::default()).control_words(&STANDARD[0], outputs), words);
    }
}
