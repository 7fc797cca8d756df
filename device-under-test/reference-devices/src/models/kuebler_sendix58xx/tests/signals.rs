//! The signals: chapter 8.

use super::*;
use device_stack::profinet::StackStatus;
use rstest::rstest;

// Position 3456h with MUR 1000h and TMR 4000h: ST_POS 456h, MT_POS 3 (8.4, 8.5).
#[test]
fn parts_of_the_position() {
    let mut bench = SendixBench::connected(MULTITURN, 0x3456 * 16, &record(0x2A, 0x1000, 0x4000));
    let frame = bench.run_frames();
    assert_eq!((frame.position, frame.st_pos, frame.mt_pos, frame.separate), (0x3456, 0x456, 3, 0x2000));
}

// 1485 steps per second up and down: 05CDh and FA33h (8.1, 8.3); the 16-bit value is limited.
#[rstest]
#[case(8192, 10.876_464_843_75, 1485, 1485)]
#[case(8192, -10.876_464_843_75, -1485, -1485)]
#[case(65536, 600.0, 655_360, 32767)]
#[case(65536, -600.0, -655_360, -32768)]
fn velocities(#[case] units: u64, #[case] rpm: f64, #[case] velocity: i32, #[case] speed: i16) {
    let mut bench = SendixBench::connected(MULTITURN, 0, &record(0x2A, units, units));
    bench.act(StandAction::ShaftSpeed(rpm));
    let frame = (0..1010).map(|_| bench.frame()).last().expect("frames");
    assert_eq!((frame.velocity, frame.speed), (velocity, speed));
}

// Parking freezes the positions and nothing else; afterwards they show the true position again.
#[test]
fn parking_freezes_positions() {
    let mut bench = SendixBench::connected(MULTITURN, 0, &standard());
    assert_eq!(bench.words(PARK).g1_zsw, 0x6000);
    bench.act(StandAction::TurnRevolutions { revolutions: 0.5, rpm: 60.0 });
    let frame = bench.run_frames();
    assert_eq!((frame.xist1, frame.xist2, frame.position, frame.st_pos), (0, 0, 0, 0));
    bench.words = None;
    let frame = bench.run_frames();
    assert_eq!((frame.xist2, frame.g1_zsw), (4096, 0x2000), "bad outputs do not park");
    assert_eq!(bench.words(0x4000).g1_zsw, 0x2000, "without Control by PLC");
}

// Example 3: F2 08, 80 00, 1234h, 20h; bit 11 echoes the request, and nothing is latched.
#[rstest]
#[case("memory", 0x20, 0x20, "red_one_hertz")]
#[case("sensor", 0x01, 0x01, "red_five_hertz")]
fn errors_follow_their_cause(#[case] name: &str, #[case] code: u32, #[case] faults: u32, #[case] led: &str) {
    let mut bench = SendixBench::connected(MULTITURN, 0x1234 * 8, &standard());
    let status = StackStatus { has_supply: true, exchanges_data: true, ..StackStatus::default() };
    assert_eq!(bench.encoder.led(bench.now, "error", &status), Some("dark"));
    let frame = bench.fault(name, true);
    assert_eq!((frame.zsw2_enc & 0x0FFF, frame.g1_zsw), (0x0208, 0x8000));
    assert_eq!((frame.xist1, frame.xist2, bench.status()[2]), (0x1234, code, faults));
    assert_eq!(bench.encoder.led(bench.now, "error", &status), Some(led));
    assert_eq!(bench.words(ACKNOWLEDGE).g1_zsw, 0x8800);
    assert_eq!(bench.words(CONTROL).g1_zsw, 0x8000);
    let frame = bench.fault(name, false);
    assert_eq!((frame.g1_zsw, frame.xist2), (0x2000, 0x1234));
    assert_eq!(bench.words(ACKNOWLEDGE).g1_zsw, 0x2000);
}

// MUR 100, TMR 5000 without preset control: 60 revolutions are 6000 in G1_XIST1 and the last value in all other signals (7).
#[rstest]
#[case(60 * 65536, 6000, 4999)]
#[case(49 * 65536, 4900, 4900)]
#[case(4091 * 65536, 409_100, 4999)]
fn positions_beyond_the_range(#[case] shaft: u64, #[case] xist1: u32, #[case] xist2: u32) {
    let mut bench = SendixBench::connected(MULTITURN, shaft, &record(0x2E, 100, 5000));
    let frame = bench.run_frames();
    assert_eq!((frame.xist1, frame.xist2, frame.position), (xist1, xist2, xist2));
}

// The sign of life counts with the send clock of 1 ms, here by two per frame, and never is 0.
#[test]
fn sign_of_life() {
    let mut bench = SendixBench::connected(MULTITURN, 0, &standard());
    let signs: Vec<u16> = (0..16).map(|_| bench.frame().zsw2_enc >> 12).collect();
    assert!(signs.windows(2).all(|pair| (pair[1] + 15 - pair[0]) % 15 == 2), "{signs:?}");
    assert!(!signs.contains(&0));
}
