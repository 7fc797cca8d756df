//! The Sendix as an application, driven like by a stack: one call per frame, two milliseconds apart.

mod presets;
mod records;
mod signals;

use super::{FACTS, Sendix};
use alloc::vec::Vec;
use core::time::Duration;
use device_stack::profinet::{ArKey, IoApplication, PluggableSubmodule, RecordAccess, RecordRefusal};
use encoder_profile::deviations::EncoderDeviations;
use encoder_profile::encoder_object::{EncoderObject, EncoderSpecimen};
use station::{StandAction, Time};
use wire::profidrive::{ParameterAddress, ParameterFormat, ParameterRequest, ParameterResponse, ParameterValue};

const AR: ArKey = ArKey(1);
const CYCLE: Duration = Duration::from_millis(2);
const SINGLETURN: usize = 0;
const MULTITURN: usize = 1;

/// Control by PLC alone, and the bits of G1_STW with it.
const CONTROL: u32 = 0x0400_0000;
const HOME: u32 = CONTROL | 0x1000;
const SHIFT: u32 = CONTROL | 0x1800;
const PARK: u32 = CONTROL | 0x4000;
const ACKNOWLEDGE: u32 = CONTROL | 0x8000;
/// Bit 31 of ManTel860.
const TRIGGER: u32 = 1 << 31;

/// The inputs of one frame of the universal module.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct SendixFrame {
    position: u32,
    velocity: i32,
    zsw2_enc: u16,
    g1_zsw: u16,
    xist1: u32,
    xist2: u32,
    speed: i16,
    st_pos: u32,
    mt_pos: u32,
    separate: u16,
}

/// An encoder with the universal module and a controller.
struct SendixBench {
    encoder: EncoderObject<Sendix>,
    now: Time,
    plugs: Vec<PluggableSubmodule>,
    /// The output word of ManTel860; `None` while its provider status is bad.
    preset: Option<u32>,
    /// STW2_ENC and G1_STW; `None` while their provider status is bad.
    words: Option<u32>,
}

impl SendixBench {
    /// An encoder without a connection, with its shaft at `shaft`.
    fn alone(variant: usize, shaft: u64) -> SendixBench {
        let piece = EncoderSpecimen { mac: [2, 0, 0, 0, 1, 0], shaft, ..EncoderSpecimen::default() };
        let variant = &FACTS.variants[variant];
        let encoder = EncoderObject::new(&FACTS, Sendix::default(), variant, EncoderDeviations::default(), piece);
        let plugs = encoder.plugs().iter().filter(|plug| plug.module_ident == 0x30).copied().collect();
        SendixBench { encoder, now: Time::ZERO, plugs, preset: Some(0), words: Some(CONTROL) }
    }

    /// An encoder in data exchange that was started with this record.
    fn connected(variant: usize, shaft: u64, record: &[u8]) -> SendixBench {
        let mut bench = SendixBench::alone(variant, shaft);
        assert_eq!(bench.connect(Some(record)), Ok(()));
        bench
    }

    fn connect(&mut self, record: Option<&[u8]>) -> Result<(), RecordRefusal> {
        self.encoder.started(self.now, AR, &self.plugs);
        let written = record.map_or(Ok(()), |record| self.encoder.write_record(self.now, access(0xBF00), record));
        self.now = self.encoder.parameter_end(self.now, AR);
        written
    }

    fn disconnect(&mut self) {
        self.encoder.ended(self.now, AR);
    }

    /// Sends a frame and returns the next one from the encoder.
    fn frame(&mut self) -> SendixFrame {
        self.now += CYCLE;
        let [preset, words] = [self.preset, self.words].map(|word| word.map(u32::to_be_bytes));
        self.encoder.outputs(self.now, 1, 2, preset.as_ref().map(|octets| &octets[..]));
        self.encoder.outputs(self.now, 1, 3, words.as_ref().map(|octets| &octets[..]));
        self.encoder.frame(self.now);
        let mut octets = Vec::new();
        for plug in self.plugs.iter().filter(|plug| plug.input_octets > 0) {
            let mut inputs = alloc::vec![0xAA; plug.input_octets.into()];
            assert!(self.encoder.inputs(self.now, 1, plug.subslot, &mut inputs));
            octets.extend(inputs);
        }
        assert_eq!(octets.len(), 32);
        let word = |at: usize| u16::from_be_bytes([octets[at], octets[at + 1]]);
        let double = |at: usize| u32::from(word(at)) << 16 | u32::from(word(at + 2));
        SendixFrame {
            position: double(0),
            velocity: double(4) as i32,
            zsw2_enc: word(8),
            g1_zsw: word(10),
            xist1: double(12),
            xist2: double(16),
            speed: word(20) as i16,
            st_pos: double(22),
            mt_pos: double(26),
            separate: word(30),
        }
    }

    /// Exchanges frames for 100 ms, until all pending actions of the encoder are done.
    fn run_frames(&mut self) -> SendixFrame {
        (0..50).map(|_| self.frame()).last().expect("frames")
    }

    /// Sets STW2_ENC and G1_STW.
    fn words(&mut self, words: u32) -> SendixFrame {
        self.words = Some(words);
        self.run_frames()
    }

    /// Sets the word of ManTel860.
    fn preset(&mut self, word: u32) -> SendixFrame {
        self.preset = Some(word);
        self.run_frames()
    }

    fn act(&mut self, action: StandAction<'_>) {
        self.now = self.encoder.act(self.now, &action).expect("the stand supports the action");
    }

    fn fault(&mut self, name: &str, present: bool) -> SendixFrame {
        self.act(StandAction::Fault(name, present));
        self.run_frames()
    }

    /// Writes P65000.
    ///
    /// # Errors
    ///
    /// The error number if the write is refused.
    fn write(&mut self, value: u32) -> Result<(), u16> {
        let value = ParameterValue::numbers(ParameterFormat::DOUBLE_WORD, &[value.into()]);
        let request =
            ParameterRequest::change_values(0xAB, 0xCD, [(ParameterAddress::value(65000, 0), value)].to_vec());
        let (mut octets, mut answer) = (Vec::new(), Vec::new());
        request.write(&mut octets);
        self.encoder.write_record(self.now, access(0xB02E), &octets).expect("the request is accepted");
        self.encoder.read_record(self.now, access(0xB02E), &mut answer).expect("the response can be read");
        let response = ParameterResponse::parse(&answer).expect("a response");
        response.values.first().and_then(ParameterValue::error).map_or(Ok(()), |error| Err(error.number.0))
    }

    /// Reads the twelve double words of 0xBF00.
    fn status(&mut self) -> Vec<u32> {
        let mut octets = Vec::new();
        self.encoder.read_record(self.now, access(0xBF00), &mut octets).expect("the status");
        octets.chunks(4).map(|word| u32::from_be_bytes(word.try_into().expect("four bytes"))).collect()
    }
}

fn access(index: u16) -> RecordAccess {
    RecordAccess { ar: Some(AR), api: 0x3D00, slot: 1, subslot: 1, index }
}

/// A record 0xBF00 with 1 in byte 17 and steps per second.
fn record(bits: u8, units: u64, range: u64) -> Vec<u8> {
    let mut record = alloc::vec![bits];
    record.extend(units.to_be_bytes());
    record.extend(range.to_be_bytes());
    record.extend([1, 0]);
    record.resize(31, 0);
    record
}

/// The standard setting: 8192 units, one revolution.
fn standard() -> Vec<u8> {
    record(0x2A, 8192, 8192)
}
