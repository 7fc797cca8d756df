//! The AMT58 against its manual, through its slave.

mod bench;
#[path = "../../../../../device-stack/src/profibus/tests/bench.rs"]
#[allow(dead_code, reason = "the tests of the slave use the rest")]
mod slave;

use self::bench::{AmtBench, HM, HS, act, bench_with, parameters};
use self::slave::{ObservedAnswer, RS};
use core::time::Duration;
use rstest::rstest;
use station::StandAction;
use std::vec::Vec;

const NOTHING: [u8; 4] = [0; 4];

fn bench(variant: &str, shaft: u64) -> AmtBench {
    bench_with(variant, shaft, None)
}

fn start(bench: &mut AmtBench, operating: u8, units: u32, range: u32) {
    start_with(bench, &parameters(operating, units, range, 0));
}

fn start_with(bench: &mut AmtBench, parameters: &[u8]) {
    assert_eq!(bench.set_prm(parameters), ObservedAnswer::Taken);
    let cfg = if parameters[10] & 0x82 == 0x82 { [0xD3, 0xE1] } else { [0xD1, 0xE1] };
    assert_eq!(bench.chk_cfg(&cfg), ObservedAnswer::Taken);
    assert_eq!(bench.diagnosis()[..2], [0x00, 0x0C]);
}

/// Manual, 6.6: the table of the preset, three cycles.
#[test]
fn a_preset_takes_three_cycles() {
    let mut bench = bench(HM, 0x55000);
    start(&mut bench, 0x0A, 65_536, 1 << 30);
    let answers: Vec<_> = (0..4).map(|_| bench.exchange(&[0x80, 0, 0x10, 0])).collect();
    assert_eq!(answers, [[0, 5, 0x50, 0], [0, 5, 0x50, 0], [0, 0, 0x10, 0], [0, 0, 0x10, 0]]);
    assert_eq!(bench.exchange(&[0, 0, 0x10, 0]), [0, 0, 0x10, 0]);
    act(&mut bench, StandAction::Power(false));
    act(&mut bench, StandAction::Power(true));
    bench.wait(Duration::from_secs(1));
    start(&mut bench, 0x0A, 65_536, 1 << 30);
    assert_eq!(bench.exchange(&NOTHING), [0, 0, 0x10, 0]);
}

#[test]
fn fewer_cycles_make_no_preset_and_a_retry_is_not_a_cycle() {
    let mut bench = bench(HM, 0x55000);
    start(&mut bench, 0, 0, 0);
    for trigger in [0x80, 0x80, 0, 0x80, 0x80, 0] {
        assert_eq!(bench.exchange(&[trigger, 0, 0x10, 0]), [0, 5, 0x50, 0]);
    }
    bench.exchange(&[0x80, 0, 0x10, 0]);
    for _ in 0..5 {
        assert_eq!(bench.repeat(None, &[0x80, 0, 0x10, 0]), ObservedAnswer::Data(8, [0, 5, 0x50, 0].into()));
    }
}

/// Manual, 6.4.3: 2048 steps in each of 1024 turns.
#[rstest]
#[case(0x10000, [0, 0, 8, 0])]
#[case(1023 * 65_536 + 65_535, [0, 0x1F, 0xFF, 0xFF])]
#[case(1024 * 65_536, [0; 4])]
fn scaled_positions(#[case] place: u64, #[case] position: [u8; 4]) {
    let mut bench = bench(HM, place);
    start(&mut bench, 0x0A, 2048, 0x20_0000);
    assert_eq!(bench.exchange(&NOTHING), position);
}

/// Manual, 6.9: 50000 counts, 8000 revolutions, 384 turns of red zone (total resolution 400000000).
#[rstest]
#[case(16_000 * 65_536 - 1, 399_999_999, "green")]
#[case(16_000 * 65_536, 380_800_000, "green_flashing")]
#[case(16_384 * 65_536 - 1, 399_999_999, "green_flashing")]
#[case(8_000 * 65_536, 0, "green")]
#[case(0, 0, "green")]
fn red_zone_of_positions_and_led(#[case] place: u64, #[case] position: u32, #[case] green: &str) {
    let mut bench = bench(HM, place);
    start(&mut bench, 0x0A, 50_000, 400_000_000);
    assert_eq!(bench.exchange(&NOTHING), position.to_be_bytes());
    assert_eq!(bench.device.led(bench.now, "power"), Some(green));
    assert_eq!(bench.device.led(bench.now, "fault"), Some("dark"));
}

/// Manual, 6.4.2 and 6.4.3: too large values are limited to the hardware, impossible ones are refused.
#[rstest]
#[case::more_revolutions(HM, 360, 33_554_432, None)]
#[case::less_than_one(HM, 8192, 360, None)]
#[case::default_list(HM, 16_384, 1 << 30, None)]
#[case::none(HM, 0, 100, None)]
#[case::too_many_counts(HM, 65_537, 1 << 30, Some([0, 1, 0, 0, 0x40, 0, 0, 0]))]
#[case::too_large(HM, 65_536, u32::MAX, Some([0, 1, 0, 0, 0x40, 0, 0, 0]))]
#[case::singleturn(HS, 262_145, 262_144, Some([0, 4, 0, 0, 0, 4, 0, 0]))]
#[case::two_turns_of_one(HS, 2048, 4096, None)]
fn scaling_limits(#[case] variant: &str, #[case] units: u32, #[case] range: u32, #[case] programmed: Option<[u8; 8]>) {
    let mut bench = bench(variant, 0);
    bench.set_prm(&parameters(0x4A, units, range, 0));
    let leds = |bench: &mut AmtBench| ["fault", "power"].map(|led| bench.device.led(bench.now, led));
    match programmed {
        Some(programmed) => assert_eq!(bench.diagnosis()[39..47], programmed),
        None => {
            assert_eq!(bench.diagnosis()[..2], [0x42, 0x05]);
            assert_eq!(leds(&mut bench), [Some("red"), Some("green_flashing")]);
            start(&mut bench, 0, 0, 0);
            assert_eq!(leds(&mut bench), [Some("dark"), Some("green")]);
        }
    }
}

/// Manual, 5.2: the dump of the extended diagnosis.
#[test]
fn extended_diagnosis_matches_the_printed_dump() {
    let mut bench = bench(HS, 77);
    start_with(&mut bench, &parameters(0xCA, 262_144, 262_144, 1));
    let mut dump = Vec::from([0, 0x0C, 0, 2, 0x16, 0x55, 0x39, 0, 0xCA, 0, 0, 4, 0, 0, 0, 1]);
    dump.resize(63, 0);
    dump[23..27].copy_from_slice(&[1, 1, 0, 2]);
    (dump[40], dump[44]) = (4, 4);
    assert_eq!(bench.diagnosis(), dump);
    start_with(&mut bench, &parameters(0x8A, 262_144, 262_144, 1));
    dump.truncate(16);
    (dump[6], dump[8]) = (0x0A, 0x8A);
    assert_eq!(bench.diagnosis(), dump);
}

#[test]
fn diagnosis_has_the_offset_with_its_sign() {
    let mut bench = bench(HM, 0x55000);
    start(&mut bench, 0x4A, 65_536, 1 << 30);
    for _ in 0..3 {
        bench.exchange(&[0x80, 0, 0x10, 0]);
    }
    assert_eq!(bench.diagnosis()[31..35], [0xFF, 0xFA, 0xC0, 0]);
}

/// Manual, 6.5: the identifiers of each class.
#[rstest]
#[case(0x00, [0xD1, 0xE1], 4)]
#[case(0x02, [0xD1, 0xE1], 4)]
#[case(0x82, [0xD3, 0xE1], 8)]
#[case::velocity_needs_class_2(0x80, [0xD1, 0xE1], 4)]
fn configuration_of_each_class(#[case] operating: u8, #[case] expected: [u8; 2], #[case] octets: usize) {
    let mut bench = bench(HS, 0);
    for cfg in [[0xD1, 0xE1], [0xD3, 0xE1], [0xE1, 0xD1], [0x51, 0x61], [0xD1, 0xE0]] {
        bench.set_prm(&parameters(operating, 0, 0, 0));
        assert_eq!(bench.ask(Some((59, 62)), &[]), ObservedAnswer::Data(8, expected.into()));
        bench.chk_cfg(&cfg);
        assert_eq!(bench.diagnosis()[0] & 0x04 == 0, cfg == expected);
        if cfg == expected {
            assert_eq!(bench.exchange(&NOTHING).len(), octets);
        } else {
            assert_eq!(bench.ask(None, &NOTHING), RS);
        }
    }
}

#[rstest]
#[case(0x8A, 0, 1500.0, 0x5DC)]
#[case(0x8B, 0, 1500.0, -0x5DC)]
#[case(0x8A, 1, 60.0, 2048)]
#[case(0x82, 1, 60.0, 65_536)]
fn velocities(#[case] operating: u8, #[case] unit: u8, #[case] rpm: f64, #[case] expected: i32) {
    let mut bench = bench(HM, 0);
    start_with(&mut bench, &parameters(operating, 2048, 0x20_0000, unit));
    act(&mut bench, StandAction::ShaftSpeed(rpm));
    bench.wait(Duration::from_millis(500));
    let inputs = bench.exchange(&NOTHING);
    let velocity = i32::from_be_bytes(inputs[4..].try_into().expect("8 input bytes"));
    assert!((velocity - expected).abs() * 100 <= expected.abs(), "{velocity}");
}

/// Manual, 4.8 and 6.8.
#[test]
fn address_by_switches_and_by_set_slave_address() {
    let mut bench = bench(HM, 0);
    act(&mut bench, StandAction::Switch("address", 126));
    assert_eq!(bench.ask(Some((55, 62)), &[9, 0x16, 0x55, 0]), RS);
    let cycle = |bench: &mut AmtBench, slave: u8| {
        act(bench, StandAction::Power(false));
        act(bench, StandAction::Power(true));
        bench.wait(Duration::from_secs(1));
        (bench.slave, bench.count) = (slave, wire::profibus::fdl::FrameCount::First);
    };
    cycle(&mut bench, 126);
    assert_eq!(bench.ask(Some((55, 62)), &[9, 0x16, 0x55, 0xFF]), ObservedAnswer::Taken);
    cycle(&mut bench, 9);
    assert_eq!(bench.ask(Some((55, 62)), &[10, 0x16, 0x55, 0]), ObservedAnswer::Taken);
    act(&mut bench, StandAction::Switch("address", 25));
    cycle(&mut bench, 25);
    bench.diagnosis();
    act(&mut bench, StandAction::Switch("address", 127));
    cycle(&mut bench, 127);
    assert_eq!(bench.ask(Some((60, 62)), &[]), ObservedAnswer::Silence);
}

/// Manual, 4.9.
#[test]
fn leds_of_each_event() {
    let mut bench = bench(HM, 0);
    let leds = |bench: &mut AmtBench| {
        ["fault", "power"].map(|led| bench.device.led(bench.now, led).expect("the encoder has both LEDs"))
    };
    assert_eq!(leds(&mut bench), ["red_flashing", "green"]);
    start(&mut bench, 0, 0, 0);
    assert_eq!(leds(&mut bench), ["dark", "green"]);
    bench.wait(Duration::from_millis(1100));
    assert_eq!(leds(&mut bench), ["red", "dark"]);
    act(&mut bench, StandAction::Power(false));
    assert_eq!(leds(&mut bench), ["dark", "dark"]);
    act(&mut bench, StandAction::Fault("flash", true));
    act(&mut bench, StandAction::Power(true));
    bench.wait(Duration::from_secs(1));
    assert_eq!(leds(&mut bench), ["red_flashing", "green_flashing"]);
}
