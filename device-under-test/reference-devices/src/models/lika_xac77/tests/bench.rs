//! An XAC77 with a controller whose sign of life counts.

use alloc::string::String;
use alloc::vec::Vec;
use core::time::Duration;
use device_stack::profinet::{ArKey, IoApplication, PluggableSubmodule, RecordAccess, RecordRefusal};
use encoder_profile::encoder_object::{EncoderObject, EncoderSpecimen};
use reference_devices::deviations::DeviceDeviations;
use reference_devices::models::lika_xac77::{FACTS, Xac77State};
use station::{StandAction, Time};
use wire::http;
use wire::profidrive::{ParameterAddress, ParameterFormat, ParameterRequest, ParameterResponse, ParameterValue};

pub const AR: ArKey = ArKey(1);
pub const CYCLE: Duration = Duration::from_millis(2);
pub const CONTROL: u16 = 0x0400;

pub const HOME: u16 = 0x1000;
pub const RELATIVE: u16 = 0x0800;
pub const ABSOLUTE: u16 = 0x2000;
pub const PARK: u16 = 0x4000;
pub const ACKNOWLEDGE: u16 = 0x8000;

/// The signals of one frame from the encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Xac77Frame {
    pub zsw2_enc: u16,
    pub g1_zsw: u16,
    pub xist1: u32,
    pub xist2: u32,
}

/// An encoder with a controller whose sign of life counts.
pub struct Xac77Bench {
    pub encoder: EncoderObject<Xac77State>,
    pub now: Time,
    pub telegram: PluggableSubmodule,
    pub sign_of_life: u8,
    pub stw2_enc: u16,
    pub g1_stw: u16,
    /// Whether the last inputs were good.
    pub good: bool,
}

pub const SINGLETURN: usize = 0;
pub const MULTITURN: usize = 1;

impl Xac77Bench {
    /// An encoder without a connection, conforming unless `deviations` are given, with its shaft at `shaft`.
    pub fn alone(variant: usize, deviations: Option<&DeviceDeviations>, shaft: u64) -> Xac77Bench {
        let none = DeviceDeviations::default();
        let deviations = deviations.unwrap_or(&none);
        let mac = [2, 0, 0, 0, 1, 0];
        let piece = EncoderSpecimen { mac, shaft, ..EncoderSpecimen::default() };
        let variant = &FACTS.variants[variant];
        let encoder = EncoderObject::new(
            &FACTS,
            Xac77State::new(deviations.web.clone()),
            variant,
            deviations.encoder.clone(),
            piece,
        );
        let telegram = encoder.plugs()[2];
        Xac77Bench { encoder, now: Time::ZERO, telegram, sign_of_life: 1, stw2_enc: CONTROL, g1_stw: 0, good: false }
    }

    /// A multiturn encoder with telegram 81, default parameters and its shaft at `shaft`.
    pub fn connected(deviations: Option<&DeviceDeviations>, shaft: u64) -> Xac77Bench {
        let mut bench = Xac77Bench::alone(MULTITURN, deviations, shaft);
        let written = bench.connect(81, &record(0x22, 65536, 1 << 30));
        assert!(written.is_ok() || deviations.is_some(), "the default record is right: {written:?}");
        bench
    }

    pub fn connect(&mut self, telegram: u32, record: &[u8]) -> Result<(), RecordRefusal> {
        self.telegram = *self.encoder.plugs().iter().find(|plug| plug.submodule_ident == telegram).expect("a telegram");
        self.encoder.started(self.now, AR, &[self.telegram]);
        let written = self.encoder.write_record(self.now, access(0xBF00), record);
        self.now = self.encoder.parameter_end(self.now, AR);
        self.sign_of_life = 1;
        self.frame();
        written
    }

    /// Sends a frame and returns the bytes of the next one from the encoder.
    pub fn octets(&mut self) -> Vec<u8> {
        self.now += CYCLE;
        let stw2_enc = self.stw2_enc | u16::from(self.sign_of_life) << 12;
        let [a, b] = stw2_enc.to_be_bytes();
        let [c, d] = self.g1_stw.to_be_bytes();
        self.encoder.outputs(self.now, 1, 2, Some(&[a, b, c, d]));
        if self.sign_of_life != 0 {
            self.sign_of_life = self.sign_of_life % 15 + 1;
        }
        let mut inputs = alloc::vec![0xAA; self.telegram.input_octets.into()];
        self.encoder.frame(self.now);
        self.good = self.encoder.inputs(self.now, 1, 2, &mut inputs);
        inputs
    }

    /// Like `octets`, parsed as telegram 81.
    pub fn frame(&mut self) -> Xac77Frame {
        let octets = self.octets();
        let word = |at: usize| u16::from_be_bytes([octets[at], octets[at + 1]]);
        let double = |at: usize| u32::from(word(at)) << 16 | u32::from(word(at + 2));
        Xac77Frame { zsw2_enc: word(0), g1_zsw: word(2), xist1: double(4), xist2: double(8) }
    }

    /// Sets G1_STW and exchanges frames for 100 ms, until all pending actions of the encoder are done.
    pub fn set_g1_stw(&mut self, g1_stw: u16) -> Xac77Frame {
        self.g1_stw = g1_stw;
        (0..50).map(|_| self.frame()).last().expect("frames")
    }

    pub fn wait(&mut self, millis: u64) {
        self.now += Duration::from_millis(millis);
        self.encoder.advance(self.now);
    }

    pub fn act(&mut self, action: StandAction<'_>) {
        self.now = self.encoder.act(self.now, &action).expect("the stand supports the action");
    }

    pub fn fault(&mut self, name: &str, present: bool) {
        self.act(StandAction::Fault(name, present));
    }

    /// Makes a preset with its whole handshake.
    pub fn preset(&mut self, value: u32, mode: u16) -> Xac77Frame {
        self.write(65000, value.into()).expect("P65000 is written");
        self.set_g1_stw(mode | HOME);
        self.set_g1_stw(0)
    }

    pub fn power_cycle(&mut self) {
        self.encoder.power_down(self.now);
        self.wait(1000);
        self.encoder.power_up(self.now);
    }

    /// Sends a request and reads its response.
    ///
    /// # Errors
    ///
    /// The error code of the record access, or that of a state conflict if the response cannot be parsed.
    pub fn request(&mut self, request: &ParameterRequest) -> Result<ParameterResponse, u16> {
        let code = |refusal: RecordRefusal| u16::from(refusal.code1());
        let (mut octets, mut answer) = (Vec::new(), Vec::new());
        request.write(&mut octets);
        self.encoder.write_record(self.now, access(0xB02E), &octets).map_err(code)?;
        self.encoder.read_record(self.now, access(0xB02E), &mut answer).map_err(code)?;
        ParameterResponse::parse(&answer).map_err(|_| code(RecordRefusal::StateConflict))
    }

    /// Reads elements of a parameter.
    ///
    /// # Errors
    ///
    /// The error number of the parameter, or the error code of the record access.
    pub fn read(&mut self, number: u16, subindex: u16, count: u8) -> Result<Vec<u64>, u16> {
        let request =
            ParameterRequest::read_values(7, 1, [ParameterAddress::elements(number, subindex, count)].to_vec());
        let response = self.request(&request)?;
        match response.values.first().map(|value| (value.error(), value.to_numbers())) {
            Some((Some(error), _)) => Err(error.number.0),
            Some((None, numbers)) => Ok(numbers.unwrap_or_default()),
            None => Ok(Vec::new()),
        }
    }

    pub fn value(&mut self, number: u16, subindex: u16) -> u64 {
        self.read(number, subindex, 1).expect("a value")[0]
    }

    pub fn write(&mut self, number: u16, value: u64) -> Result<(), u16> {
        let format = if number == 971 { ParameterFormat::WORD } else { ParameterFormat::DOUBLE_WORD };
        let value = ParameterValue::numbers(format, &[value]);
        let request = ParameterRequest::change_values(7, 1, [(ParameterAddress::value(number, 0), value)].to_vec());
        let response = self.request(&request)?;
        response.values.first().and_then(ParameterValue::error).map_or(Ok(()), |error| Err(error.number.0))
    }

    /// The diagnoses that appeared (`true`) and disappeared since the last call.
    pub fn diagnoses(&mut self) -> Vec<(bool, u16)> {
        core::iter::from_fn(|| self.encoder.next_diagnosis()).map(|c| (c.appears, c.diagnosis.error_type)).collect()
    }

    pub fn page(&mut self, path: &str) -> (u16, String) {
        let response = self.encoder.page(self.now, &http::HttpRequest::get(path));
        (response.status, String::from_utf8(response.body).expect("a text"))
    }

    pub fn send(&mut self, path: &str, field: &str, text: &str) -> String {
        let response = self.encoder.page(self.now, &http::HttpRequest::post(path, &[(field, text)]));
        assert_eq!(response.status, 200);
        String::from_utf8(response.body).expect("a text")
    }

    pub fn enter(&mut self, value: &str) -> String {
        self.send("/preset.htm", "value", value)
    }
}

pub fn access(index: u16) -> RecordAccess {
    RecordAccess { ar: Some(AR), api: 0x3D00, slot: 1, subslot: 1, index }
}

/// A record 0xBF00 with one tolerated failure and steps per second.
pub fn record(bits: u8, units: u64, range: u64) -> Vec<u8> {
    let mut record = alloc::vec![bits];
    record.extend(units.to_be_bytes());
    record.extend(range.to_be_bytes());
    record.extend([1, 0]);
    record.resize(31, 0);
    record
}
