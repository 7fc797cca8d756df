//! Starts, power cycles and saves.

use super::*;
use rstest::rstest;

#[test]
fn sensor_fault_is_an_error_only_while_not_parked() {
    let mut bench = Xac77Bench::connected(None, 42);
    bench.set_g1_stw(PARK);
    bench.fault("sensor", true);
    bench.act(StandAction::Turn { steps: 100.0, rpm: 60.0 });
    assert_eq!(bench.set_g1_stw(PARK).g1_zsw, PARK);
    bench.fault("sensor", false);
    let frame = bench.set_g1_stw(0);
    assert_eq!((frame.g1_zsw, frame.xist1, bench.value(65001, 2)), (0, 142, 0));
    bench.fault("sensor", true);
    bench.act(StandAction::Turn { steps: 100.0, rpm: 60.0 });
    let frame = bench.frame();
    assert_eq!((frame.g1_zsw, frame.xist1, frame.xist2), (0x8000, 142, 1));
}

// Catalogue NVM-015: a save into a memory that cannot be written is not confirmed, and the stored value remains.
#[test]
fn a_save_that_fails_is_not_confirmed() {
    let mut bench = Xac77Bench::connected(None, 0);
    bench.write(65000, 0x1111).expect("P65000 is written");
    bench.write(971, 1).expect("a save");
    bench.wait(1000);
    bench.write(65000, 0x2222).expect("P65000 is written");
    bench.fault("memory", true);
    bench.write(971, 1).expect("a save");
    bench.wait(1000);
    assert_eq!((bench.value(971, 0), bench.frame().xist2), (1, 0x1001));
    bench.fault("memory", false);
    bench.power_cycle();
    assert_eq!((bench.value(971, 0), bench.value(65000, 0)), (0, 0x1111));
}

// Catalogue ERR-024: a save requested during another save stores the values that are current then.
#[test]
fn the_second_of_two_saves_counts() {
    let mut bench = Xac77Bench::connected(None, 0);
    for value in [0x1111, 0x2222] {
        bench.write(65000, value).expect("P65000 is written");
        bench.write(971, 1).expect("a save");
    }
    bench.wait(1000);
    bench.power_cycle();
    assert_eq!(bench.value(65000, 0), 0x2222);
}

// Catalogue SCL-015: while scaling is off its values are not checked.
#[rstest]
#[case(0)]
#[case(u64::MAX)]
fn unused_scaling_is_not_checked(#[case] value: u64) {
    let mut bench = Xac77Bench::alone(MULTITURN, None, 42);
    bench.connect(81, &record(0x22, value, value)).expect("it has the right length");
    assert_eq!((bench.set_g1_stw(0).g1_zsw, bench.frame().xist1), (0, 42));
    assert_eq!((bench.value(65001, 9), bench.value(65001, 10)), (65536, 1 << 30));
}
