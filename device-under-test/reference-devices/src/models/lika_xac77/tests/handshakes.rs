//! Cyclic handshakes: Control by PLC, preset, parking, class 4, velocity.

use super::*;
use rstest::rstest;

// Manual, 16.1: bit 9 follows bit 10, and without bit 10 the control word is not valid; with compatibility mode neither.
#[rstest]
#[case::v41_with_control(0x22, CONTROL, 0x0200, 0x2000)]
#[case::v41_without(0x22, 0, 0x0000, 0x0000)]
#[case::v31_with_control(0x02, CONTROL, 0x0000, 0x2000)]
#[case::v31_without(0x02, 0, 0x0000, 0x2000)]
fn control_by_plc(#[case] bits: u8, #[case] control: u16, #[case] requested: u16, #[case] status: u16) {
    let mut bench = Xac77Bench::connected(None, 77);
    bench.connect(81, &record(bits, 65536, 1 << 30)).expect("the record is right");
    bench.stw2_enc = control | 0x0BFF;
    let frame = bench.set_g1_stw(ABSOLUTE | 0x07FF);
    assert_eq!((frame.zsw2_enc & 0x0FFF, frame.g1_zsw), (requested, status));
    assert_eq!((frame.xist1, frame.xist2), (77, if status == 0 { 0 } else { 77 }));
}

#[test]
fn sign_of_life_continues_during_parking_and_errors() {
    let mut bench = Xac77Bench::connected(None, 0);
    let mut last = bench.frame().zsw2_enc >> 12;
    for frame in 0..200 {
        match frame {
            50 => bench.g1_stw = PARK,
            100 => bench.fault("memory", true),
            120 => bench.g1_stw = 0,
            _ => {}
        }
        let sign = bench.frame().zsw2_enc >> 12;
        assert_eq!(sign, last % 15 + 1);
        last = sign;
    }
}

// Manual, 16.2: request, shifted position with bit 12 in one frame, release.
#[test]
fn preset_handshake() {
    let mut bench = Xac77Bench::connected(None, 5000);
    bench.write(65000, 0x0001_2345).expect("P65000 is written");
    assert_eq!((bench.set_g1_stw(0).xist1, bench.value(65001, 8)), (5000, 0));
    bench.g1_stw = HOME;
    let frames: Vec<(u16, u32)> = (0..50).map(|_| bench.frame()).map(|frame| (frame.g1_zsw, frame.xist1)).collect();
    let done = frames.iter().position(|frame| frame.0 == HOME).expect("it is acknowledged");
    assert!(frames[..done].iter().all(|frame| *frame == (0, 5000)));
    assert!(frames[done..].iter().all(|frame| *frame == (HOME, 0x0001_2345)));
    assert_eq!(bench.value(65001, 8), 0x0001_2345 - 5000);
    bench.act(StandAction::Turn { steps: 1000.0, rpm: 60.0 });
    assert_eq!(bench.frame().xist1, 0x0001_2345 + 1000);
    assert_eq!(bench.set_g1_stw(0).g1_zsw, 0);
}

// Manual, p. 88: 5000 becomes 6000, and so on.
#[test]
fn relative_presets() {
    let mut bench = Xac77Bench::connected(None, 5000);
    assert_eq!(bench.set_g1_stw(RELATIVE).xist1, 5000);
    for expected in [6000, 7000, 8000] {
        assert_eq!(bench.preset(1000, RELATIVE).xist1, expected);
    }
    assert_eq!(bench.value(65001, 8), 3000);
}

// Manual, 11.4, class 4 functionality and G1_XIST1 preset control.
#[rstest]
#[case::enabled(0x22, 0x1000, 0x1000)]
#[case::not_on_xist1(0x26, 100, 0x1000)]
#[case::class_3(0x20, 100, 100)]
#[case::class_3_not_on_xist1(0x24, 100, 100)]
fn what_a_preset_acts_on(#[case] bits: u8, #[case] xist1: u32, #[case] others: u32) {
    for telegram in [81, 84] {
        let mut bench = Xac77Bench::connected(None, 100);
        bench.connect(telegram, &record(bits, 65536, 1 << 30)).expect("the record is right");
        bench.write(65000, 0x1000).expect("P65000 is written");
        assert_eq!(bench.set_g1_stw(HOME | ABSOLUTE).g1_zsw, 0x3000);
        bench.g1_stw = ABSOLUTE;
        let octets = bench.octets();
        let at = |n: usize| u32::from_be_bytes([octets[n], octets[n + 1], octets[n + 2], octets[n + 3]]);
        let expected = if telegram == 81 { (xist1, others) } else { (0, others) };
        assert_eq!((at(4), at(8)), expected);
    }
}

#[test]
fn requests_end_without_control_by_plc_and_start_with_it() {
    let mut bench = Xac77Bench::connected(None, 100);
    bench.write(65000, 7).expect("P65000 is written");
    bench.stw2_enc = 0;
    let frame = bench.set_g1_stw(HOME | ABSOLUTE);
    assert_eq!((frame.g1_zsw, frame.xist1, frame.xist2), (0, 100, 0));
    bench.stw2_enc = CONTROL;
    assert_eq!(bench.set_g1_stw(HOME | ABSOLUTE).g1_zsw, 0x3000);
    assert_eq!(bench.frame().xist2, 7);
    bench.set_g1_stw(PARK);
    bench.stw2_enc = 0;
    let frame = bench.set_g1_stw(PARK);
    assert_eq!((frame.g1_zsw, frame.xist1), (0, 7));
}

// Manual, 16.3, in one frame each way.
#[test]
fn parking_hides_positions_in_one_frame() {
    let mut bench = Xac77Bench::connected(None, 0x1234);
    assert_eq!(bench.set_g1_stw(ABSOLUTE).g1_zsw, ABSOLUTE);
    bench.g1_stw = ABSOLUTE | PARK;
    for _ in 0..10 {
        let frame = bench.frame();
        assert_eq!((frame.g1_zsw, frame.xist1, frame.xist2), (PARK, 0, 0));
    }
    bench.act(StandAction::Turn { steps: 16.0, rpm: 600.0 });
    bench.g1_stw = ABSOLUTE;
    let frame = bench.frame();
    assert_eq!((frame.g1_zsw, frame.xist1, frame.xist2), (ABSOLUTE, 0x1244, 0x1244));
}

#[test]
fn preset_request_while_parked_has_no_effect() {
    let mut bench = Xac77Bench::connected(None, 500);
    bench.write(65000, 7).expect("P65000 is written");
    bench.set_g1_stw(PARK);
    assert_eq!(bench.set_g1_stw(PARK | HOME).g1_zsw, PARK);
    assert_eq!((bench.set_g1_stw(HOME).g1_zsw, bench.frame().xist1), (0, 500));
    bench.set_g1_stw(0);
    assert_eq!((bench.set_g1_stw(HOME).g1_zsw, bench.frame().xist1), (HOME, 7));
    assert_eq!(bench.set_g1_stw(PARK | HOME).g1_zsw, PARK);
}

#[test]
fn parking_is_refused_while_the_shaft_turns() {
    let mut bench = Xac77Bench::connected(None, 0);
    bench.act(StandAction::ShaftSpeed(60.0));
    let frame = bench.set_g1_stw(PARK);
    assert_eq!((frame.g1_zsw, frame.xist2), (0x8000, 0x0003));
    assert_ne!(frame.xist1, bench.frame().xist1);
}

// Catalogue CFG-017, CFG-018, SPD-014: the velocity has the sign of the change of position.
#[rstest]
#[case::clockwise(0x22, 1000, 6553)]
#[case::counterclockwise(0x23, -1000, -6553)]
#[case::class_3(0x21, 1000, 6553)]
fn direction(#[case] bits: u8, #[case] change: i64, #[case] velocity: i32) {
    let mut bench = Xac77Bench::connected(None, 1 << 20);
    let mut octets = record(bits, 65536, 1 << 30);
    octets[18] = 1;
    bench.connect(83, &octets).expect("the record is right");
    let position = |octets: &[u8]| i64::from(u32::from_be_bytes([octets[4], octets[5], octets[6], octets[7]]));
    let before = position(&bench.octets());
    bench.act(StandAction::Turn { steps: 1000.0, rpm: 60.0 });
    assert_eq!(position(&bench.octets()) - before, change);
    bench.act(StandAction::ShaftSpeed(60.0));
    bench.wait(1000);
    let octets = bench.octets();
    let observed = i32::from_be_bytes([octets[12], octets[13], octets[14], octets[15]]);
    assert!((observed - velocity).abs() <= 1, "{observed}");
}

#[test]
fn neither_preset_nor_zero_crossing_shows_in_the_velocity() {
    let mut bench = Xac77Bench::alone(SINGLETURN, None, 262_143);
    bench.connect(83, &record(0x22, 262_144, 262_144)).expect("the default record");
    bench.preset(0x20000, 0);
    bench.wait(200);
    assert_eq!(&bench.octets()[12..], &[0; 4]);
    bench.act(StandAction::ShaftSpeed(60.0));
    bench.wait(500);
    let speeds: Vec<i32> = (0..1000)
        .map(|_| bench.octets())
        .map(|octets| i32::from_be_bytes([octets[12], octets[13], octets[14], octets[15]]))
        .collect();
    assert!(speeds.iter().all(|speed| (262_140..=262_150).contains(speed)));
}
