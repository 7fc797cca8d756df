//! The records of chapter 9.

use super::*;
use device_stack::profinet::RecordRefusal::{InvalidIndex, WriteLength};
use rstest::rstest;

// The printed example, with the twelfth zero that the table requires, and the status that it results in.
#[test]
fn status_of_the_printed_example() {
    let mut example = record(0x2A, 0x2000, 0x8000);
    example[18] = 3;
    let mut bench = SendixBench::connected(MULTITURN, 0, &example);
    let read = [0x000B_0101, 0x2A, 0, 0x21, 0, 7, 0x401, 0xFFFF_FFFF, 0, 0x2000, 0x8000, 3];
    assert_eq!(bench.status(), read);
}

// Ratios are powers of two unless preset control is off (bit 2); 4096 revolutions at most, one for singleturn.
#[rstest]
#[case(MULTITURN, 0x2A, 8192, 8192 * 4096, true)]
#[case(MULTITURN, 0x2A, 8192, 8192 * 8192, false)]
#[case(MULTITURN, 0x2A, 8192, 2048, true)]
#[case(MULTITURN, 0x2A, 1, 1, true)]
#[case(MULTITURN, 0x2A, 0, 8192, false)]
#[case(MULTITURN, 0x2A, 8192, 0, false)]
#[case(MULTITURN, 0x2A, 65537, 65537, false)]
#[case(MULTITURN, 0x2A, 8192, 24576, false)]
#[case(MULTITURN, 0x2A, 100, 5000, false)]
#[case(MULTITURN, 0x2E, 100, 5000, true)]
#[case(MULTITURN, 0x2A, 1 << 32 | 8192, 8192, false)]
#[case(SINGLETURN, 0x2A, 65536, 65536, true)]
#[case(SINGLETURN, 0x2A, 8192, 16384, false)]
fn scaling_limits(
    #[case] variant: usize,
    #[case] bits: u8,
    #[case] units: u64,
    #[case] range: u64,
    #[case] is_valid: bool,
) {
    let mut bench = SendixBench::connected(variant, 0, &record(bits, units, range));
    let frame = bench.run_frames();
    assert_eq!((frame.g1_zsw, frame.xist2), if is_valid { (0x2000, 0) } else { (0x8000, 0x1002) });
}

// A start without a record is reported, and a record in data exchange is in force at once.
#[test]
fn record_in_data_exchange_is_in_force_at_once() {
    let mut bench = SendixBench::alone(MULTITURN, 32768);
    bench.connect(None).expect("no record is written");
    let frame = bench.run_frames();
    assert_eq!((frame.g1_zsw, frame.xist2, frame.zsw2_enc & 0x0FFF), (0x8000, 0x1002, 0x0200));
    let now = bench.now;
    assert_eq!(bench.encoder.write_record(now, access(0xBF00), &standard()), Ok(()));
    assert_eq!(bench.run_frames().xist2, 4096);
    assert_eq!(bench.encoder.write_record(now, access(0xBF00), &record(0x2A, 4096, 4096)), Ok(()));
    assert_eq!((bench.run_frames().xist2, bench.status()[9]), (2048, 4096));
}

#[test]
fn refused_records() {
    let mut bench = SendixBench::connected(MULTITURN, 0, &standard());
    let now = bench.now;
    for octets in [30, 32] {
        let record = alloc::vec![0x2A; octets];
        assert_eq!(bench.encoder.write_record(now, access(0xBF00), &record), Err(WriteLength));
    }
    let at_subslot_2 = RecordAccess { subslot: 2, ..access(0xBF00) };
    assert_eq!(bench.encoder.read_record(now, at_subslot_2, &mut Vec::new()), Err(InvalidIndex));
    assert_eq!(bench.encoder.read_record(now, access(0xBF01), &mut Vec::new()), Err(InvalidIndex));
}

// Above 9000 rpm, in both directions, as long as the cause is present; several warnings are shown together.
#[test]
fn warnings_follow_their_cause() {
    let mut bench = SendixBench::connected(MULTITURN, 0, &standard());
    for (rpm, warnings) in [(9000.0, 0), (9001.0, 1), (-9001.0, 1), (-9000.0, 0), (0.0, 0)] {
        bench.act(StandAction::ShaftSpeed(rpm));
        bench.run_frames();
        assert_eq!(bench.status()[4], warnings, "{rpm}");
    }
    bench.fault("temperature", true);
    let frame = bench.fault("led_current", true);
    assert_eq!((bench.status()[4], frame.g1_zsw, frame.zsw2_enc & 8), (6, 0x2000, 0));
}
