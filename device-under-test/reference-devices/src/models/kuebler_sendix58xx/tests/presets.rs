//! Presets, with and without a handshake: chapters 7 and 8.

use super::*;
use rstest::rstest;

// 80 00 12 34 sets the position to 4660, in all signals at once; too large values are limited (8.1).
#[rstest]
#[case(MULTITURN, 8192, 8192, 0x1234, 0x1234)]
#[case(SINGLETURN, 8192, 8192, 0x1234, 0x1234)]
#[case(MULTITURN, 8192, 8192, 0x2000, 0x1FFF)]
#[case(MULTITURN, 65536, 1 << 28, 0x0FFF_FFFF, 0x0FFF_FFFF)]
#[case(SINGLETURN, 65536, 65536, 0x1_0000, 0xFFFF)]
fn preset_by_trigger(
    #[case] variant: usize,
    #[case] units: u64,
    #[case] range: u64,
    #[case] value: u32,
    #[case] position: u32,
) {
    let mut bench = SendixBench::connected(variant, 777, &record(0x2A, units, range));
    let frame = bench.preset(TRIGGER | value);
    assert_eq!((frame.position, frame.xist1, frame.xist2), (position, position, position));
    assert_eq!(bench.preset(TRIGGER | 5).position, position, "another value while the trigger is set");
    assert_eq!(bench.preset(6).position, position, "the trigger is cleared");
}

// At most 40 ms, during which the position is frozen although the shaft turns.
#[test]
fn position_is_frozen_during_a_preset() {
    let mut bench = SendixBench::connected(MULTITURN, 0, &standard());
    bench.act(StandAction::ShaftSpeed(60.0));
    let before = bench.run_frames().position;
    bench.preset = Some(TRIGGER | 0x1000);
    let positions: Vec<u32> = (0..22).map(|_| bench.frame().position).collect();
    let begins = positions[0];
    assert!(begins - before < 50);
    let after = positions.iter().position(|position| *position != begins).expect("the preset is carried out");
    assert!(after <= 20, "after {after} frames");
    assert!((0x1000..0x1200).contains(&positions[after]), "{:X}", positions[after]);
}

#[rstest]
#[case::absolute(HOME, 0x1234, 0x1234)]
#[case::relative(SHIFT, 0x0100, 0x0600)]
#[case::backward(SHIFT, 0xFFFF_FF00, 0x0400)]
#[case::below_0(SHIFT, 0xFFFF_F000, 0x1500)]
fn preset_by_request(#[case] words: u32, #[case] value: u32, #[case] position: u32) {
    let mut bench = SendixBench::connected(MULTITURN, 0x0500 * 8, &standard());
    assert_eq!(bench.write(value), Ok(()));
    assert_eq!(bench.run_frames().position, 0x0500, "writing alone moves nothing");
    let frame = bench.words(words);
    assert_eq!((frame.xist2, frame.g1_zsw), (position, 0x3000));
    assert_eq!((bench.words(CONTROL).g1_zsw, bench.words(words).xist2 == position), (0x2000, words == HOME));
}

// 360 units do not divide 2^32: from 300, -100 gives 200 and -300 more gives 260.
#[test]
fn relative_preset_by_a_signed_value_in_any_range() {
    let mut bench = SendixBench::connected(SINGLETURN, 0, &record(0x2A, 360, 360));
    for (words, value, position) in [(HOME, 300, 300), (SHIFT, -100, 200), (SHIFT, -300, 260), (SHIFT, 359, 259)] {
        assert_eq!(bench.write(value as u32), Ok(()));
        assert_eq!(bench.words(words).xist2, position);
        bench.words(CONTROL);
    }
}

#[rstest]
#[case(8191, Ok(()))]
#[case(-8191, Ok(()))]
#[case(8192, Err(2))]
#[case(-8192, Err(2))]
#[case(i32::MAX, Err(2))]
fn limits_of_the_preset_value(#[case] value: i32, #[case] written: Result<(), u16>) {
    let mut bench = SendixBench::connected(MULTITURN, 0, &standard());
    assert_eq!(bench.write(value as u32), written);
}

// With class 4 off both kinds of preset are blocked and not answered.
#[test]
fn no_presets_without_class_4() {
    let mut bench = SendixBench::connected(MULTITURN, 0, &record(0x28, 8192, 8192));
    bench.write(0x1234).expect("P65000 is written");
    let frame = bench.words(HOME);
    assert_eq!((frame.position, frame.g1_zsw), (0, 0x2000));
    assert_eq!(bench.preset(TRIGGER | 0x1234).position, 0);
}

// 8.9: outputs are 0 with a bad status and between connections. A trigger held across that triggers again.
#[test]
fn cleared_outputs_release_the_trigger() {
    let mut bench = SendixBench::connected(MULTITURN, 0, &standard());
    bench.preset(TRIGGER | 0x1234);
    bench.act(StandAction::TurnRevolutions { revolutions: 1.0 / 32.0, rpm: 60.0 });
    assert_eq!(bench.run_frames().position, 0x1334);
    bench.preset = None;
    assert_eq!(bench.run_frames().position, 0x1334, "the trigger is cleared");
    assert_eq!(bench.preset(TRIGGER | 0x1234).position, 0x1234);
    bench.act(StandAction::TurnRevolutions { revolutions: 1.0 / 32.0, rpm: 60.0 });
    bench.disconnect();
    bench.connect(Some(&standard())).expect("the record is accepted");
    assert_eq!(bench.run_frames().position, 0x1234);
}

// The offset survives power-off and factory reset: 8.1, 10.
#[test]
fn offset_survives_power_off_and_factory_reset() {
    let mut bench = SendixBench::connected(MULTITURN, 0, &standard());
    bench.preset(TRIGGER | 0x1234);
    bench.preset(0);
    let offset = bench.status()[8];
    bench.disconnect();
    bench.encoder.power_down(bench.now);
    bench.encoder.power_up(bench.now);
    assert!(bench.encoder.factory_reset(bench.now, device_stack::profinet::ResetScope::Factory));
    bench.connect(Some(&standard())).expect("the record is accepted");
    assert_eq!((bench.run_frames().position, bench.status()[8]), (0x1234, offset));
}
