//! The AFS60 and AFM60 as applications, driven like by a stack. Expected values are printed in the manual or follow from the
//! printed ratio.

use super::{Afx60State, FACTS, delivered};
use ::station::{StandAction, Time};
use alloc::vec::Vec;
use core::time::Duration;
use device_stack::profinet::{
    ArKey, IoApplication, PluggableSubmodule, RecordAccess, RecordRefusal, ResetScope, StackStatus, StationData,
};
use encoder_profile::deviations::EncoderDeviations;
use encoder_profile::encoder_object::{EncoderObject, EncoderSpecimen};
use rstest::rstest;
use wire::profidrive::{ParameterAddress, ParameterFormat, ParameterRequest, ParameterResponse, ParameterValue};

const AR: ArKey = ArKey(1);
const CONTROL: u16 = 0x0400;
const HOME: u16 = 0x1000;
const ABSOLUTE: u16 = 0x2000;
const ACKNOWLEDGE: u16 = 0x8000;
const AFS60: usize = 0;
const AFM60: usize = 1;

struct Afx60Bench {
    encoder: EncoderObject<Afx60State>,
    now: Time,
    telegram: PluggableSubmodule,
    words: [u16; 2],
}

impl Afx60Bench {
    fn alone(variant: usize, shaft: u64) -> Afx60Bench {
        let (facts, mac) = (&FACTS.variants[variant], [2, 0, 0, 0, 1, 0]);
        let piece = EncoderSpecimen { mac, shaft, station: delivered(facts.name) };
        let state = Afx60State::new(mac, Default::default(), Default::default());
        let encoder = EncoderObject::new(&FACTS, state, facts, EncoderDeviations::default(), piece);
        let telegram = *encoder.plugs().iter().find(|plug| plug.submodule_ident == 81).expect("telegram 81");
        Afx60Bench { encoder, now: Time::ZERO, telegram, words: [CONTROL, 0] }
    }

    fn connect(&mut self, record: &[u8], vendor: Option<&[u8]>) {
        self.encoder.started(self.now, AR, &[self.telegram]);
        self.encoder.write_record(self.now, access(0xBF00), record).expect("31 octets");
        if let Some(vendor) = vendor {
            self.encoder.write_record(self.now, access(0x1000), vendor).expect("17 octets");
        }
        self.now = self.encoder.parameter_end(self.now, AR);
        self.frame();
    }

    fn connected(variant: usize, bits: u8, shaft: u64) -> Afx60Bench {
        let mut bench = Afx60Bench::alone(variant, shaft);
        let range = FACTS.variants[variant].hardware.range();
        bench.connect(&record(bits, 1 << 18, range), None);
        bench
    }

    /// The bytes of the next frame: ZSW2_ENC, G1_ZSW, G1_XIST1, G1_XIST2.
    fn frame(&mut self) -> [u8; 12] {
        self.now += Duration::from_millis(2);
        let [[a, b], [c, d]] = self.words.map(u16::to_be_bytes);
        self.encoder.outputs(self.now, 1, 2, Some(&[a, b, c, d]));
        self.encoder.frame(self.now);
        let mut inputs = [0; 12];
        assert!(self.encoder.inputs(self.now, 1, 2, &mut inputs));
        inputs
    }

    /// Sets G1_STW, exchanges frames for 120 ms and returns G1_ZSW, G1_XIST1 and G1_XIST2.
    fn set(&mut self, g1_stw: u16) -> (u16, u32, u32) {
        self.words[1] = g1_stw;
        let octets = (0..60).map(|_| self.frame()).last().expect("frames");
        let double = |at: usize| u32::from_be_bytes([octets[at], octets[at + 1], octets[at + 2], octets[at + 3]]);
        (u16::from_be_bytes([octets[2], octets[3]]), double(4), double(8))
    }

    fn position(&mut self) -> u32 {
        self.set(ABSOLUTE).2
    }

    fn act(&mut self, action: StandAction<'_>) {
        self.now = self.encoder.act(self.now, &action).expect("the stand supports the action");
    }

    fn wait(&mut self, millis: u64) {
        self.now += Duration::from_millis(millis);
        self.encoder.advance(self.now);
    }

    fn power_cycle(&mut self) {
        self.encoder.power_down(self.now);
        self.wait(1000);
        self.encoder.power_up(self.now);
    }

    fn request(&mut self, request: &ParameterRequest) -> ParameterResponse {
        let (mut octets, mut answer) = (Vec::new(), Vec::new());
        request.write(&mut octets);
        self.encoder.write_record(self.now, access(0xB02E), &octets).expect("a request");
        self.encoder.read_record(self.now, access(0xB02E), &mut answer).expect("a response");
        ParameterResponse::parse(&answer).expect("a whole response")
    }

    fn read(&mut self, number: u16, subindex: u16) -> u64 {
        let address = ParameterAddress::elements(number, subindex, 1);
        let response = self.request(&ParameterRequest::read_values(7, 5, [address].to_vec()));
        response.values[0].to_numbers().expect("a value")[0]
    }

    fn write(&mut self, number: u16, subindex: u16, value: u64) -> Result<(), u16> {
        let format =
            if let 1009 | 65000 | 1003 = number { ParameterFormat::DOUBLE_WORD } else { ParameterFormat::WORD };
        let value = ParameterValue::numbers(format, &[value]);
        let address = ParameterAddress::elements(number, subindex, 1);
        let response = self.request(&ParameterRequest::change_values(7, 5, [(address, value)].to_vec()));
        response.values.first().and_then(ParameterValue::error).map_or(Ok(()), |error| Err(error.number.0))
    }

    fn encoder_led(&mut self) -> &'static str {
        let status = StackStatus { has_supply: true, is_linked: true, ..StackStatus::default() };
        self.encoder.led(self.now, "encoder", &status).expect("the LED of the encoder")
    }
}

fn access(index: u16) -> RecordAccess {
    RecordAccess { ar: Some(AR), api: 0x3D00, slot: 1, subslot: 1, index }
}

fn record(bits: u8, units: u64, range: u64) -> Vec<u8> {
    let mut record = Vec::from([bits]);
    record.extend(units.to_be_bytes());
    record.extend(range.to_be_bytes());
    record.extend([1, 3]);
    record.resize(31, 0);
    record
}

/// The vendor record: save mode, transmit, round axis, 2 ms, 10 measurements, 125/10, 600.
fn vendor(save_mode: u8, transmits: u8, axis: u8) -> Vec<u8> {
    Vec::from([save_mode, transmits, axis, 2, 10, 0, 0, 0, 125, 0, 0, 0, 10, 0, 0, 2, 0x58])
}

// Figure 15: 721287 and four times that; a shift by 14 bits on the AFS60, from signal 11.
#[rstest]
#[case(AFM60, 721_287, 2_885_148)]
#[case(AFM60, (1 << 30) - 1, 0xFFFF_FFFC)]
#[case(AFS60, 1, 0x4000)]
fn xist1_is_shifted_by_the_shift_factor(#[case] variant: usize, #[case] place: u64, #[case] xist1: u32) {
    assert_eq!(Afx60Bench::connected(variant, 0x36, place).set(ABSOLUTE), (ABSOLUTE, xist1, place as u32));
}

// Figures 18 and 19: 600 is first shown in G1_XIST1 only, times four. Table 45: values from the range on are invalid.
#[test]
fn presets_set_xist1_and_invalid_values_are_reported() {
    let mut bench = Afx60Bench::connected(AFM60, 0x32, 5000);
    bench.write(65000, 0, 600).expect("P65000 is written");
    assert_eq!(bench.set(HOME), (HOME, 2400, 0));
    assert_eq!(bench.set(ABSOLUTE), (ABSOLUTE, 2400, 600));
    assert_eq!((bench.read(1001, 1), bench.read(1001, 2)), (0, 0x5000));
    bench.write(65000, 0, 1 << 30).expect("P65000 is written");
    assert_eq!(bench.set(HOME), (0, 2400, 0));
    assert_eq!((bench.read(1001, 1), bench.read(1001, 2), bench.encoder_led()), (0x10, 0x4000, "orange"));
    bench.power_cycle();
    assert_eq!(bench.read(65001, 8), (1 << 30) + 600 - 5000);
}

// 3.6.7 and 3.6.8: 2^n revolutions, one on the AFS60. Table 45: an invalid scaling is a warning.
#[rstest]
#[case(AFM60, 8179, 261_728, 0)]
#[case(AFM60, 1, 4096, 0)]
#[case(AFM60, 1000, 9000, 2)]
#[case(AFM60, 1000, 8_192_000, 2)]
#[case(AFM60, 262_145, 262_145, 2)]
#[case(AFM60, 0, 0, 2)]
#[case(AFS60, 1000, 1000, 0)]
#[case(AFS60, 1000, 2000, 2)]
fn scalings(#[case] variant: usize, #[case] units: u64, #[case] range: u64, #[case] status: u64) {
    let mut bench = Afx60Bench::alone(variant, 0);
    bench.connect(&record(0x3E, units, range), None);
    assert_eq!((bench.read(1001, 1), bench.set(0).0), (status, 0));
    assert_eq!(bench.encoder_led(), if status == 0 { "green" } else { "orange" });
}

// 3.2.2: 9000 steps in 12.5 revolutions; one revolution is 720 steps.
#[test]
fn round_axis_continues_beyond_all_revolutions_and_without_power() {
    let mut bench = Afx60Bench::alone(AFM60, 4095 * 262_144);
    bench.connect(&record(0x3E, 1000, 9000), Some(&vendor(1, 0, 2)));
    assert_eq!((bench.read(1001, 1), bench.read(1009, 9), bench.read(65001, 10)), (0, 720, 9000));
    assert_eq!(bench.position(), 5400);
    bench.act(StandAction::TurnRevolutions { revolutions: 1.0, rpm: 600.0 });
    assert_eq!(bench.position(), 6120);
    bench.encoder.power_down(bench.now);
    bench.act(StandAction::TurnRevolutions { revolutions: 0.5, rpm: 600.0 });
    bench.encoder.power_up(bench.now);
    bench.connect(&record(0x3E, 1000, 9000), Some(&vendor(1, 0, 2)));
    assert_eq!((bench.position(), bench.read(1009, 4)), (6480, 6120));
}

// Tables 44, 47 and 53; the encoder restarts when the supply returns from below its limit.
#[test]
fn supply_beyond_its_limits() {
    let mut bench = Afx60Bench::connected(AFM60, 0x36, 7);
    bench.write(1007, 1, 25_000).expect("a limit");
    bench.act(StandAction::SupplyVoltage(25.1));
    assert_eq!((bench.set(ABSOLUTE).0, bench.set(ABSOLUTE).2), (ACKNOWLEDGE, 0x1004));
    assert_eq!((bench.read(1000, 0), bench.read(65001, 2), bench.encoder_led()), (8, 4, "red_green"));
    bench.act(StandAction::SupplyVoltage(25.0));
    assert_eq!((bench.read(1000, 0), bench.set(ABSOLUTE).2), (0, 0x1004));
    bench.set(ABSOLUTE | ACKNOWLEDGE);
    assert_eq!((bench.position(), bench.read(65001, 2)), (7, 0));
    bench.act(StandAction::SupplyVoltage(8.9));
    assert_eq!(bench.set(0), (ACKNOWLEDGE, 28, 0x1003));
    assert!(bench.encoder.is_alive());
    bench.act(StandAction::SupplyVoltage(9.0));
    assert!(!bench.encoder.is_alive());
}

// Table 34: the permitted values of settings, and the PROFIdrive error for others.
#[rstest]
#[case(1005, 3, 200, Ok(()))]
#[case(1005, 3, 201, Err(2))]
#[case(1005, 1, 5, Err(0x14))]
#[case(1006, 0, 0xFFD8, Ok(()))]
#[case(1006, 0, 0xFFD7, Err(2))]
#[case(1007, 1, 30_001, Err(2))]
#[case(1009, 0, 3, Err(0x14))]
#[case(1009, 2, 0, Err(2))]
#[case(1009, 6, 1, Err(1))]
#[case(1002, 0, 5, Err(1))]
#[case(1003, 0, 5, Err(6))]
fn permitted_values_of_settings(
    #[case] number: u16,
    #[case] subindex: u16,
    #[case] value: u64,
    #[case] written: Result<(), u16>,
) {
    let mut bench = Afx60Bench::connected(AFM60, 0x36, 0);
    assert_eq!(bench.write(number, subindex, value), written);
    assert_eq!(bench.read(number, subindex) == value, written.is_ok());
}

// 3.6.10: P1006, P1007 and P65000 are saved by P971 or with each change.
#[rstest]
#[case::by_p971(1, false, 0)]
#[case::by_p971_when_it_was_written(1, true, 0x1234)]
#[case::by_itself(0, false, 0x1234)]
fn save_modes(#[case] mode: u8, #[case] saves: bool, #[case] stored: u64) {
    let mut bench = Afx60Bench::alone(AFM60, 0);
    bench.connect(&record(0x36, 1 << 18, 1 << 30), Some(&vendor(mode, 0, 1)));
    bench.write(65000, 0, 0x1234).expect("P65000 is written");
    bench.write(1006, 1, 60).expect("a limit");
    if saves {
        bench.write(971, 0, 1).expect("a save");
        assert_eq!(bench.read(1001, 2), 0x4001);
    }
    bench.wait(1000);
    assert_eq!(bench.read(1001, 2), if saves { 0x4002 } else { 0x4000 });
    bench.power_cycle();
    assert_eq!((bench.read(65000, 0), bench.read(1006, 1) == 60), (stored, stored != 0));
}

// Table 34: power-ups, turns and changes of direction, in both logs until the relative one is reset.
#[test]
fn service_logs_count_and_the_relative_one_is_reset() {
    let mut bench = Afx60Bench::connected(AFM60, 0x36, 0);
    for rpm in [600.0, -600.0, 0.0] {
        bench.act(StandAction::ShaftSpeed(rpm));
        bench.set(0);
    }
    bench.act(StandAction::Temperature(-10.0));
    let log = |bench: &mut Afx60Bench, number| [0, 5, 12].map(|at| bench.read(number, at));
    assert_eq!(log(&mut bench, 1002), [1, 1, 0xFFFF_FFF6]);
    assert!(bench.read(1002, 3) > 0 && bench.read(1002, 4) > 0);
    bench.write(1003, 0, 0).expect("a reset");
    assert_eq!((log(&mut bench, 1002), log(&mut bench, 1003)), ([1, 1, 0xFFFF_FFF6], [0, 0, 0xFFFF_FFF6]));
    bench.power_cycle();
    assert_eq!((bench.read(1002, 0), bench.read(1003, 0)), (2, 1));
    bench.act(StandAction::Fault("main_unit", true));
    assert_eq!((bench.read(1000, 0), bench.read(1004, 7), bench.read(65001, 2)), (0x80, 1, 0x21));
}

// 5.5: switches at 888 and button for 5 s, then power off and on; this clears the factory name.
#[rstest]
#[case(8, 5000, true)]
#[case(8, 4999, false)]
#[case(7, 5000, false)]
fn reset_by_hand(#[case] ones: u32, #[case] millis: u64, #[case] is_reset: bool) {
    let mut bench = Afx60Bench::connected(AFM60, 0x36, 0);
    bench.write(1006, 1, 60).expect("a limit");
    bench.write(971, 0, 1).expect("a save");
    for (name, place) in [("hundreds", 8), ("tens", 8), ("ones", ones)] {
        bench.act(StandAction::Switch(name, place));
    }
    bench.act(StandAction::Button("preset", true));
    bench.wait(millis);
    bench.act(StandAction::Button("preset", false));
    assert_eq!(bench.encoder_led(), if is_reset { "green_flashing" } else { "green" });
    assert_eq!(bench.encoder.stored_station().name, b"afm60a");
    bench.power_cycle();
    assert_eq!((bench.encoder.stored_station().name.is_empty(), bench.read(1006, 1) != 60), (is_reset, is_reset));
    assert_eq!(bench.read(1002, 0), 2);
}

// 3.6.2 and 3.6.11: the button needs class 4; the start transmits its value optionally.
#[rstest]
#[case(0x36, 1, 600)]
#[case(0x36, 0, 0)]
#[case(0x34, 1, 5000)]
fn button_makes_a_preset(#[case] bits: u8, #[case] transmits: u8, #[case] position: u32) {
    let mut bench = Afx60Bench::alone(AFM60, 5000);
    bench.connect(&record(bits, 1 << 18, 1 << 30), Some(&vendor(1, transmits, 1)));
    bench.act(StandAction::Button("preset", true));
    bench.act(StandAction::Button("preset", false));
    assert_eq!(bench.position(), position);
}

#[test]
fn vendor_record_is_refused_after_the_start() {
    let mut bench = Afx60Bench::connected(AFM60, 0x36, 0);
    let late = bench.encoder.write_record(bench.now, access(0x1000), &vendor(1, 0, 1));
    assert_eq!(late, Err(RecordRefusal::StateConflict));
    let short = bench.encoder.write_record(bench.now, access(0x1000), &[0; 16]);
    assert_eq!(short, Err(RecordRefusal::WriteLength));
    assert!(bench.encoder.factory_reset(bench.now, ResetScope::Communication));
    assert_eq!(bench.encoder.stored_station(), StationData::default());
}
