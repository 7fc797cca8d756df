//! Errors, their acknowledgement, the sign of life of the controller, diagnoses.

use super::*;
use rstest::rstest;

#[test]
fn memory_fault_is_reported_cyclically_in_p65001_and_as_a_diagnosis() {
    let mut bench = Xac77Bench::connected(None, 42);
    bench.set_g1_stw(ABSOLUTE);
    bench.fault("memory", true);
    let frame = bench.frame();
    assert_eq!((frame.g1_zsw, frame.xist1, frame.xist2), (0x8000, 42, 0x1001));
    assert!(bench.good, "the error is delivered in good inputs");
    assert_eq!(bench.value(65001, 2), 0x20);
    assert_eq!(bench.diagnoses(), [(true, 0x9000)]);
}

// Manual, 16.4.2 and then 16.4.1: not acknowledgeable while the cause is present.
#[test]
fn error_with_its_cause_cannot_be_acknowledged() {
    let mut bench = Xac77Bench::connected(None, 42);
    bench.fault("memory", true);
    bench.set_g1_stw(ABSOLUTE);
    for _ in 0..3 {
        let mut states = [ACKNOWLEDGE, 0].map(|word| bench.set_g1_stw(ABSOLUTE | word).g1_zsw);
        assert_eq!(states, [0x8800, 0x8000]);
        states = [bench.set_g1_stw(ABSOLUTE).g1_zsw, bench.value(65001, 2) as u16];
        assert_eq!(states, [0x8000, 0x20]);
    }
    bench.fault("memory", false);
    assert_eq!((bench.set_g1_stw(ABSOLUTE).g1_zsw, bench.frame().xist2), (0x8000, 0x1001));
    assert_eq!(bench.set_g1_stw(ABSOLUTE | ACKNOWLEDGE).g1_zsw, 0x8800);
    bench.g1_stw = ABSOLUTE;
    let frames = [bench.frame(), bench.frame()];
    assert_eq!(frames.map(|frame| (frame.g1_zsw, frame.xist2)), [(0x2800, 42), (0x2000, 42)]);
    assert_eq!((bench.value(65001, 2), bench.diagnoses()), (0, alloc::vec![(true, 0x9000), (false, 0x9000)]));
}

#[test]
fn parking_clears_errors_and_checks_again_afterwards() {
    let mut bench = Xac77Bench::connected(None, 42);
    bench.fault("memory", true);
    bench.frame();
    assert_eq!((bench.set_g1_stw(PARK).g1_zsw, bench.value(65001, 2)), (PARK, 0));
    bench.fault("commissioning", true);
    assert_eq!((bench.set_g1_stw(PARK).g1_zsw, bench.frame().xist2), (PARK, 0));
    assert_eq!(bench.diagnoses(), [(true, 0x9000), (false, 0x9000)]);
    bench.fault("commissioning", false);
    assert_eq!((bench.set_g1_stw(0).g1_zsw, bench.frame().xist2), (0x8000, 0x1001));
    assert_eq!(bench.diagnoses(), [(true, 0x9000)]);
}

#[test]
fn wrong_parameters_are_reported_until_the_next_start() {
    let mut bench = Xac77Bench::alone(MULTITURN, None, 0);
    bench.connect(81, &record(0x2A, 1, 32768)).expect("it has the right length");
    let frame = bench.frame();
    assert_eq!((frame.g1_zsw, frame.xist2), (0x8000, 0x1002));
    assert_eq!((bench.value(65001, 2), bench.value(65001, 9), bench.value(65001, 10)), (0x10, 65536, 1 << 30));
    bench.set_g1_stw(ACKNOWLEDGE);
    assert_eq!(bench.set_g1_stw(0).g1_zsw, 0x8000);
    assert_eq!(bench.diagnoses(), [(true, 0x9011)]);
    bench.connect(81, &record(0x2A, 1, 16384)).expect("it has the right length");
    assert_eq!((bench.frame().g1_zsw, bench.value(65001, 2)), (0, 0));
    assert_eq!(bench.diagnoses(), [(false, 0x9011)]);
}

// Manual, 11.4: alarm channel control counts in compatibility mode only.
#[rstest]
#[case::v41(0x2A, true)]
#[case::v41_switched_on(0x3A, true)]
#[case::v31(0x0A, false)]
#[case::v31_switched_on(0x1A, true)]
fn alarm_channel(#[case] bits: u8, #[case] sent: bool) {
    let mut bench = Xac77Bench::alone(MULTITURN, None, 0);
    bench.connect(81, &record(bits, 1, 32768)).expect("it has the right length");
    assert_eq!(bench.frame().xist2, 0x1002);
    assert_eq!(bench.diagnoses().contains(&(true, 0x9011)), sent);
}

#[test]
fn of_two_faults_the_older_one_is_shown() {
    let mut bench = Xac77Bench::connected(None, 0);
    bench.fault("commissioning", true);
    bench.fault("memory", true);
    assert_eq!((bench.frame().xist2, bench.value(65001, 2)), (0x1002, 0x30));
    assert_eq!(bench.diagnoses(), [(true, 0x9011), (true, 0x9000)]);
    bench.fault("commissioning", false);
    bench.set_g1_stw(ACKNOWLEDGE);
    assert_eq!((bench.set_g1_stw(0).xist2, bench.value(65001, 2)), (0x1001, 0x20));
    assert_eq!(bench.diagnoses(), [(false, 0x9011)]);
}

// Manual, 11.4: byte 17 tolerates that many failures in compatibility mode; without it one is tolerated.
#[rstest]
#[case(0x02, 5, 5, false)]
#[case(0x02, 5, 6, true)]
#[case(0x02, 255, 255, false)]
#[case(0x02, 255, 256, true)]
#[case(0x22, 255, 1, false)]
#[case(0x22, 255, 2, true)]
fn tolerated_failures_of_the_sign_of_life(
    #[case] bits: u8,
    #[case] octet_17: u8,
    #[case] failures: usize,
    #[case] error: bool,
) {
    let mut bench = Xac77Bench::connected(None, 0);
    let mut octets = record(bits, 65536, 1 << 30);
    octets[17] = octet_17;
    bench.connect(81, &octets).expect("the record is right");
    bench.stw2_enc = 0;
    bench.set_g1_stw(0);
    for _ in 0..failures {
        bench.sign_of_life = (bench.sign_of_life + 13) % 15 + 1;
        bench.frame();
    }
    let frame = bench.frame();
    assert_eq!((frame.g1_zsw, frame.xist2), if error { (0x8000, 0x0F02) } else { (0, 0) });
    bench.stw2_enc = CONTROL;
    bench.set_g1_stw(ACKNOWLEDGE);
    assert_eq!(bench.set_g1_stw(0).g1_zsw, 0);
}

#[test]
fn controller_without_sign_of_life_is_not_monitored() {
    let mut bench = Xac77Bench::alone(MULTITURN, None, 0);
    let telegram = bench.telegram;
    bench.encoder.started(bench.now, AR, &[telegram]);
    bench.encoder.parameter_end(bench.now, AR);
    bench.sign_of_life = 0;
    assert_eq!(bench.set_g1_stw(0).g1_zsw, 0);
}
