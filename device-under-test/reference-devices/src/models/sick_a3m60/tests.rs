//! The A3M60 as the application of a slave stack, without frames.

use super::controls;
use super::hooks::A3m60Deviations;
use super::set_prm::{OCTETS, UserByteFields};
use super::{CONFIGURATIONS, Encoder, FACTS};
use crate::models::sick;
use alloc::vec::Vec;
use core::time::Duration;
use device_stack::profibus::{Dpv1Access, Dpv1Channel, SlaveApplication};
use encoder_profile::deviations::EncoderDeviations;
use rstest::rstest;
use station::{StandAction, Time};
use wire::profibus::prm::{SetPrm, StationStatus};

const MS1: Dpv1Channel = Dpv1Channel::Ms1;
const IO_04: usize = 0;
const IO_08: usize = 1;
const TELEGRAM_81: usize = 2;
const TELEGRAM_83: usize = 3;

/// The factory user bytes: class 2/4, fault codes, speed; 16384 steps, 2^31, 1 failure, rpm, 4096, 1, 8 samples.
const DELIVERED: [u8; OCTETS] = [0x02, 0x0C, 0, 0, 0x40, 0, 0x80, 0, 0, 0, 1, 3, 0, 0, 0x10, 0, 0, 0, 0, 1, 8, 0, 0, 0];

/// An encoder in data exchange, with the cycles of its master.
struct A3m60Bench {
    encoder: Encoder,
    now: Time,
    octets: usize,
}

impl A3m60Bench {
    fn with(module: usize, octets: &[u8; OCTETS], deviations: EncoderDeviations, shaft: u64) -> A3m60Bench {
        let mut encoder = Encoder::new(
            &FACTS.variants[0],
            deviations,
            sick::hooks::SickDeviations::default(),
            A3m60Deviations::default(),
            shaft,
            2,
        );
        let now = Time::from_nanos(1_000_000_000);
        assert!(encoder.parameters(now, &set_prm(octets, [0x80, 0, 0])));
        let sums = encoder.check_configuration(now, CONFIGURATIONS[module]).expect("the configuration is right");
        encoder.exchange_begins(now);
        A3m60Bench { encoder, now, octets: sums.inputs }
    }

    fn new(module: usize, octets: &[u8; OCTETS]) -> A3m60Bench {
        A3m60Bench::with(module, octets, EncoderDeviations::default(), 0)
    }

    /// One cycle of 2 ms.
    fn cycle(&mut self, outputs: &[u8]) -> Vec<u8> {
        self.now += Duration::from_millis(2);
        let mut inputs = alloc::vec![0xAA; self.octets];
        self.encoder.outputs(self.now, Some(outputs));
        self.encoder.inputs(self.now, &mut inputs);
        inputs
    }

    fn cycles(&mut self, count: usize, outputs: &[u8]) -> Vec<u8> {
        (1..count).for_each(|_| drop(self.cycle(outputs)));
        self.cycle(outputs)
    }

    fn fault(&mut self, name: &str, present: bool) {
        assert_eq!(self.encoder.act(self.now, &StandAction::Fault(name, present)), Some(self.now), "{name}");
    }

    fn blocks(&mut self) -> (Vec<u8>, bool) {
        let mut blocks = Vec::new();
        let bits = self.encoder.diagnosis(self.now, &mut blocks);
        (blocks, bits.ext_diag)
    }

    fn access(&mut self, request: &[u8]) -> Vec<u8> {
        let access = Dpv1Access { channel: MS1, slot: 0, index: 47 };
        self.encoder.write(self.now, access, request).expect("the request is accepted");
        let mut response = Vec::new();
        self.encoder.read(self.now, access, &mut response).expect("the response can be read");
        response
    }

    fn read(&mut self, number: u16, subindex: u8) -> Vec<u8> {
        let [high, low] = number.to_be_bytes();
        self.access(&[1, 1, 1, 1, 0x10, 1, high, low, 0, subindex]).split_off(6)
    }
}

fn set_prm(octets: &[u8], head: [u8; 3]) -> SetPrm {
    let status = StationStatus::LOCK_REQ;
    let user = [&head[..], octets].concat();
    SetPrm { status, wd_fact_1: 1, wd_fact_2: 1, min_tsdr: 11, ident: 0x0C0A, groups: 0, user }
}

fn changed(at: usize, octets: &[u8]) -> [u8; OCTETS] {
    let mut all = DELIVERED;
    all[at..at + octets.len()].copy_from_slice(octets);
    all
}

#[test]
fn factory_user_bytes() {
    assert_eq!(UserByteFields::parse(&DELIVERED), Some(UserByteFields::DELIVERED));
}

// Manual, table 8: position 170, preset 65535.
#[rstest]
#[case(IO_04)]
#[case(IO_08)]
fn preset_by_a_vendor_telegram(#[case] module: usize) {
    let mut bench = A3m60Bench::with(module, &DELIVERED, EncoderDeviations::default(), 170);
    let words = |octets: [u8; 4]| -> Vec<u8> {
        let unused: &[u8] = if module == IO_08 { &[0xFF; 4] } else { &[] };
        [&octets[..], unused].concat()
    };
    assert_eq!(bench.cycles(3, &words([0, 0, 0xFF, 0xFF]))[..4], [0, 0, 0, 0xAA]);
    assert_eq!(bench.cycles(2, &words([0x80, 0, 0xFF, 0xFF]))[..4], [0, 0, 0xFF, 0xFF]);
    assert_eq!(bench.cycles(2, &words([0, 0, 0xFF, 0xFF]))[..4], [0, 0, 0xFF, 0xFF]);
}

#[test]
fn first_word_is_no_edge_but_a_word_after_clear_is() {
    let mut bench = A3m60Bench::with(IO_04, &DELIVERED, EncoderDeviations::default(), 170);
    assert_eq!(bench.cycles(3, &[0x80, 0, 0x12, 0x34]), [0, 0, 0, 0xAA]);
    bench.encoder.outputs(bench.now, None);
    assert_eq!(bench.cycle(&[0x80, 0, 0x12, 0x34]), [0, 0, 0x12, 0x34]);
}

// Catalogue TLG-007, TLG-009: 1234h is 2468h in G1_XIST1; 60 rpm.
#[test]
fn profile_telegrams() {
    let mut bench = A3m60Bench::with(TELEGRAM_81, &DELIVERED, EncoderDeviations::default(), 0x1234);
    let inputs = bench.cycles(3, &[0x04, 0, 0x20, 0]);
    assert_eq!(inputs, [0x02, 0, 0x20, 0, 0, 0, 0x24, 0x68, 0, 0, 0x12, 0x34]);
    let mut bench = A3m60Bench::new(TELEGRAM_83, &DELIVERED);
    bench.encoder.act(bench.now, &StandAction::ShaftSpeed(60.0));
    assert_eq!(bench.cycles(700, &[0, 0, 0x20, 0])[12..], [0, 0, 0, 60]);
}

// Manual, 3.4.1: FFFEh is -2, and the time stamp counts seconds.
#[test]
fn speed_and_time_stamp() {
    let mut bench = A3m60Bench::new(IO_08, &DELIVERED);
    bench.encoder.act(bench.now, &StandAction::ShaftSpeed(-2.0));
    assert_eq!(bench.cycles(1600, &[0; 8])[4..], [0xFF, 0xFE, 0, 4]);
}

// Tables 34 to 37.
#[rstest]
#[case("flash", 0x8000, &[0x38], -12, 0x1001, 0x20)]
#[case("eeprom_checksum", 0x8000, &[0x38], -12, 0x1001, 0x20)]
#[case("fram", 0x4000, &[0x36], -11, 0x0008, 1)]
#[case("synchronization_large", 0x2000, &[0x36], -8, 0x0002, 1)]
#[case("synchronization_shutdown", 0x0800, &[0x36], -10, 0x0004, 1)]
#[case("synchronization_start", 0x0800, &[0x36], -8, 0x0004, 1)]
#[case("vector_length", 0x0200, &[0x36], -5, 0x0001, 1)]
#[case("vector_length_long", 0x0100, &[0x36], -5, 0x0001, 1)]
#[case("eeprom", 0x0080, &[0x36, 0x38], -4, 0x1002, 0x21)]
#[case("amplitude", 0x0040, &[0x36], -3, 0x0001, 1)]
fn each_error_is_reported_in_all_places(
    #[case] name: &str,
    #[case] status: u16,
    #[case] numbers: &[u8],
    #[case] code: i32,
    #[case] g1_xist2: u16,
    #[case] faults: u8,
) {
    let blocks: Vec<u8> = numbers.iter().flat_map(|number| [0x81, 0x40, *number]).collect();
    let alarms = changed(0, &[0x12]);
    let mut bench = A3m60Bench::new(IO_04, &alarms);
    assert_eq!(bench.blocks(), (Vec::new(), false));
    bench.fault(name, true);
    assert!(bench.encoder.diagnosis_changed() && !bench.encoder.diagnosis_changed());
    assert_eq!(bench.cycle(&[0; 4]), code.to_be_bytes());
    assert_eq!(bench.blocks(), (blocks, true));
    assert_eq!(bench.read(1000, 0), status.to_be_bytes());
    assert_eq!(bench.read(65001, 2), [0, 0, 0, faults]);
    bench.fault(name, false);
    assert_eq!((bench.cycle(&[0; 4]), bench.blocks()), (alloc::vec![0; 4], (Vec::new(), false)));
    let mut bench = A3m60Bench::new(TELEGRAM_81, &DELIVERED);
    bench.fault(name, true);
    let inputs = bench.cycle(&[4, 0, 0, 0]);
    assert_eq!((inputs[2], inputs[10..].to_vec()), (0x80, g1_xist2.to_be_bytes().to_vec()));
    assert_eq!(bench.blocks(), (Vec::new(), false));
}

#[test]
fn several_errors_have_a_common_code() {
    let mut bench = A3m60Bench::new(IO_04, &changed(0, &[0x12]));
    bench.fault("amplitude", true);
    bench.fault("eeprom_checksum", true);
    assert_eq!(bench.cycle(&[0; 4]), (-16_i32).to_be_bytes());
    assert_eq!(bench.blocks().0, [0x81, 0x40, 0x36, 0x81, 0x40, 0x38]);
    bench.fault("eeprom_checksum", false);
    assert_eq!(bench.cycle(&[0; 4]), (-3_i32).to_be_bytes());
}

// Manual, table 27, and values beyond it; table 26 and 3.6.9 to 3.6.16.
#[rstest]
#[case::plain(DELIVERED, true)]
#[case::thousand(changed(0, &[0x0A, 0x0C, 0, 0, 3, 0xE8, 0, 0, 0x1F, 0x40]), true)]
#[case::odd(changed(0, &[0x0A, 0x0C, 0, 0, 0x1F, 0xF3, 0, 3, 0xFE, 0x60]), true)]
#[case::no_power_of_two(changed(0, &[0x0A, 0x0C, 0, 0, 3, 0xE8, 0, 0, 0x23, 0x28]), false)]
#[case::not_in_force(changed(0, &[0x02, 0x0C, 0, 0, 3, 0xE8, 0, 0, 0x23, 0x28]), true)]
#[case::no_steps(changed(0, &[0x0A, 0x0C, 0, 0, 0, 0]), false)]
#[case::axis_with_factory_range(changed(0, &[0x02, 0x0D]), false)]
#[case::no_failure(changed(10, &[0]), false)]
#[case::no_unit(changed(11, &[5]), false)]
#[case::three_samples(changed(20, &[3]), false)]
fn invalid_parameters_are_refused(#[case] octets: [u8; OCTETS], #[case] is_right: bool) {
    let mut encoder = Encoder::new(
        &FACTS.variants[0],
        EncoderDeviations::default(),
        sick::hooks::SickDeviations::default(),
        A3m60Deviations::default(),
        0,
        2,
    );
    assert_eq!(encoder.parameters(Time::ZERO, &set_prm(&octets, [0x80, 0, 0])), is_right);
    for wrong in [&octets[1..], &[&octets[..], &[0]].concat()] {
        assert!(!encoder.parameters(Time::ZERO, &set_prm(wrong, [0x80, 0, 0])));
    }
}

/// N/D revolutions, the range, and the position after one revolution.
fn axis(nominator: u32, divisor: u32, range: u32) -> [u8; OCTETS] {
    let mut octets = changed(1, &[0x0D]);
    octets[6..10].copy_from_slice(&range.to_be_bytes());
    octets[12..16].copy_from_slice(&nominator.to_be_bytes());
    octets[16..20].copy_from_slice(&divisor.to_be_bytes());
    octets
}

#[rstest]
#[case(25, 10, 3600, [0, 0, 5, 0xA0])]
#[case(4, 1, 1440, [0, 0, 1, 0x68])]
#[case(1, 9, 1000, [0; 4])]
fn round_axis_position(#[case] nominator: u32, #[case] divisor: u32, #[case] range: u32, #[case] position: [u8; 4]) {
    let mut bench = A3m60Bench::new(IO_04, &axis(nominator, divisor, range));
    bench.encoder.act(bench.now, &StandAction::TurnRevolutions { revolutions: 1.0, rpm: 600.0 });
    assert_eq!(bench.cycles(100, &[0; 4]), position);
    assert_eq!(bench.read(1009, 0), [0, 0, 0, 1]);
}

// Manual, table 24: 1.555 is 1 and 555; catalogue RND-006: movements without power count.
#[test]
fn round_axis_crosses_the_physical_zero_without_power() {
    let mut bench = A3m60Bench::new(IO_04, &axis(1000, 1, 1555));
    assert_eq!((bench.read(1009, 9), bench.read(1009, 10)), (alloc::vec![0, 0, 0, 1], alloc::vec![0, 0, 2, 0x2B]));
    let end = (1_u64 << 31) - 10 * 16384;
    let mut bench = A3m60Bench::with(IO_04, &axis(3, 1, 1080), EncoderDeviations::default(), end);
    let before = u32::from_be_bytes(bench.cycle(&[0; 4]).try_into().expect("four bytes"));
    bench.encoder.power_down(bench.now);
    bench.encoder.act(bench.now, &StandAction::TurnRevolutions { revolutions: 20.0, rpm: 6000.0 });
    bench.now += Duration::from_secs(1);
    bench.encoder.power_up(bench.now);
    assert!(bench.encoder.parameters(bench.now, &set_prm(&axis(3, 1, 1080), [0x80, 0, 0])));
    bench.encoder.check_configuration(bench.now, CONFIGURATIONS[IO_04]).expect("the configuration is right");
    bench.encoder.exchange_begins(bench.now);
    let after = u32::from_be_bytes(bench.cycle(&[0; 4]).try_into().expect("four bytes"));
    assert_eq!(after, (before + 720) % 1080);
}

// Manual, table 32.
#[rstest]
#[case([1, 7], Some(17))]
#[case([0xC, 3], Some(123))]
#[case([0xC, 5], Some(125))]
#[case([0xC, 6], None)]
#[case([0, 0], None)]
fn addresses_of_the_switches(#[case] switches: [u32; 2], #[case] address: Option<u8>) {
    assert_eq!(controls::address(switches, &A3m60Deviations::default()), address);
}

#[test]
fn identification_and_status() {
    let mut bench = A3m60Bench::new(TELEGRAM_81, &DELIVERED);
    assert_eq!(bench.read(918, 0), [0, 2]);
    assert_eq!(bench.read(922, 0), [0, 81]);
    assert_eq!(bench.read(965, 0), [0x3D, 0x29]);
    assert_eq!(bench.read(975, 6), [0xC0, 0]);
    assert_eq!(bench.read(979, 5), [0, 2, 0, 0]);
    assert_eq!(bench.read(65001, 1), [0, 0, 0x0C, 2]);
    assert_eq!(bench.read(65001, 10), [0x80, 0, 0, 0]);
    assert_eq!(bench.access(&[1, 1, 1, 1, 0x10, 4, 3, 0xF0, 0, 0])[6..], [0, 0, 0, 5, 0, 200, 0, 10]);
    assert_eq!(bench.access(&[2, 2, 1, 1, 0x10, 1, 0xFD, 0xE8, 0, 0, 0x43, 1, 0, 0, 0x10, 0]), [2, 2, 1, 1]);
    assert_eq!(bench.read(65000, 0), [0, 0, 0x10, 0]);
    let inputs = bench.cycles(2, &[0, 0, 0x30, 0]);
    assert_eq!((inputs[2], inputs[8..].to_vec()), (0x30, alloc::vec![0, 0, 0x10, 0]));
    assert_eq!(bench.cycles(2, &[0, 0, 0x20, 0])[2], 0x20);
}

/// Block 04h with a cycle of 2 ms.
const TIMES: [u8; 28] = [28, 4, 0, 0, 1, 0, 0, 5, 0xDC, 0, 16, 1, 0, 0, 5, 0xDC, 0, 1, 0, 1, 0, 0, 0, 0, 0, 12, 0, 0];

// Catalogue ISO-007, ISO-010, ISO-014: signs of life, and the errors that are reported without the clock.
#[rstest]
#[case::plain(false)]
#[case::structured(true)]
fn isochronous_operation(#[case] is_structured: bool) {
    let mut encoder = Encoder::new(
        &FACTS.variants[0],
        EncoderDeviations::default(),
        sick::hooks::SickDeviations::default(),
        A3m60Deviations::default(),
        0,
        2,
    );
    let octets = changed(0, &[0x32]);
    let now = Time::from_nanos(1_000_000_000);
    let user =
        if is_structured { [&[28, 129, 0, 0], &octets[..], &TIMES].concat() } else { [&octets[..], &TIMES].concat() };
    assert!(encoder.parameters(now, &set_prm(&user, [0x80, 0, if is_structured { 0x18 } else { 0x10 }])));
    encoder.check_configuration(now, CONFIGURATIONS[TELEGRAM_81]).expect("the configuration is right");
    encoder.exchange_begins(now);
    let mut bench = A3m60Bench { encoder, now, octets: 12 };
    let mut sign = 0;
    let mut cycle = |bench: &mut A3m60Bench, has_clock: bool, counts: bool| {
        let next = bench.now + Duration::from_millis(2);
        if has_clock {
            bench.encoder.clock(next);
        }
        sign = if counts { sign % 15 + 1 } else { sign };
        bench.cycle(&[sign << 4 | 4, 0, 0xA0, 0])
    };
    let signs: Vec<u8> = (0..8).map(|_| cycle(&mut bench, true, true)[0] >> 4).collect();
    assert_eq!(signs, [0, 0, 0, 1, 2, 3, 4, 5]);
    cycle(&mut bench, true, false);
    assert_eq!(bench.read(1001, 0), [0, 0]);
    cycle(&mut bench, true, false);
    assert_eq!((bench.read(1001, 0), bench.blocks().0), (alloc::vec![0, 0x10], alloc::vec![0x81, 0x40, 0x3B]));
    (0..3).for_each(|_| drop(cycle(&mut bench, true, true)));
    assert_eq!(bench.read(1001, 0), [0, 0]);
    let last = (0..6).map(|_| cycle(&mut bench, false, true)).last().expect("six cycles");
    assert_eq!((last[0] >> 4, bench.read(1001, 0)), (0, alloc::vec![0, 0x20]));
    assert_eq!(bench.blocks().0, [0x81, 0x40, 0x3C]);
    (0..6).for_each(|_| drop(cycle(&mut bench, true, true)));
    assert_eq!(bench.blocks().0, []);
}
