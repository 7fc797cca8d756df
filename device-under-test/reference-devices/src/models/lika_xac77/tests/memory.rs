//! Non-volatile data.

use super::*;
use rstest::rstest;

#[rstest]
#[case::absolute(0, 0x1234)]
#[case::relative(RELATIVE, 5000 + 0x1234)]
fn acknowledged_preset_survives_power_off(#[case] mode: u16, #[case] position: u32) {
    let mut bench = Xac77Bench::connected(None, 5000);
    bench.write(65000, 0x1234).expect("P65000 is written");
    bench.g1_stw = mode | HOME;
    while bench.frame().g1_zsw & HOME == 0 {}
    let offset = bench.value(65001, 8);
    bench.g1_stw = 0;
    for _ in 0..2 {
        bench.power_cycle();
        bench.connect(81, &record(0x22, 65536, 1 << 30)).expect("the default record");
        assert_eq!((bench.frame().xist1, bench.value(65001, 8)), (position, offset));
        assert_eq!(bench.value(65000, 0), 0);
    }
}

#[test]
fn power_off_before_the_acknowledgement_leaves_the_old_offset() {
    let mut bench = Xac77Bench::connected(None, 5000);
    bench.preset(100, 0);
    bench.write(65000, 0x1234).expect("P65000 is written");
    bench.g1_stw = HOME;
    bench.frame();
    bench.power_cycle();
    assert_eq!(bench.value(65001, 8), (1 << 30) + 100 - 5000);
}

#[test]
fn p65000_survives_power_off_after_a_save_by_p971() {
    let mut bench = Xac77Bench::connected(None, 0);
    bench.write(65000, 0x1111).expect("P65000 is written");
    for wrong in [2, 0xFFFF] {
        assert_eq!(bench.write(971, wrong), Err(0x14));
    }
    bench.write(971, 0).expect("0 starts no save");
    assert_eq!(bench.encoder.deadline(), None);
    bench.write(971, 1).expect("a save");
    assert_eq!(bench.value(971, 0), 1);
    bench.now = bench.encoder.deadline().expect("the end of the save");
    assert_eq!(bench.value(971, 0), 0);
    bench.write(65000, 0x2222).expect("P65000 is written");
    bench.power_cycle();
    assert_eq!(bench.value(65000, 0), 0x1111);
    bench.write(65000, 0x3333).expect("P65000 is written");
    bench.write(971, 1).expect("a save");
    bench.power_cycle();
    assert_eq!((bench.value(65000, 0), bench.value(971, 0)), (0x1111, 0));
    assert_eq!(bench.encoder.counter(bench.now, "nvm_writes"), Some(1));
}

#[test]
fn p65000_is_not_written_to_memory_and_a_preset_is_once() {
    let mut bench = Xac77Bench::connected(None, 0);
    (0..100).for_each(|value| bench.write(65000, value).expect("P65000 is written"));
    assert_eq!(bench.encoder.counter(bench.now, "nvm_writes"), Some(0));
    bench.preset(5, 0);
    assert_eq!(bench.encoder.counter(bench.now, "nvm_writes"), Some(1));
}

#[test]
fn faulty_memory_stores_nothing_and_reads_as_empty() {
    let mut bench = Xac77Bench::connected(None, 5000);
    bench.preset(100, 0);
    bench.fault("memory", true);
    assert_eq!((bench.preset(7, 0).xist1, bench.value(65001, 8)), (100, (1 << 30) + 100 - 5000));
    assert_eq!(bench.set_g1_stw(HOME).g1_zsw, 0x8000);
    bench.write(971, 1).expect("a save");
    bench.wait(1000);
    assert_eq!(bench.value(971, 0), 1);
    bench.power_cycle();
    assert_eq!(bench.diagnoses(), [(true, 0x9000)]);
    assert_eq!((bench.value(65001, 2), bench.value(65001, 8)), (0x20, 0));
    bench.fault("memory", false);
    bench.power_cycle();
    assert_eq!((bench.value(65001, 2), bench.value(65001, 8)), (0, (1 << 30) + 100 - 5000));
}

// Catalogue NVM-016: an absolute encoder detects movements without power.
#[test]
fn turning_without_power_changes_the_position() {
    let mut bench = Xac77Bench::connected(None, 1000);
    bench.encoder.power_down(bench.now);
    bench.act(StandAction::TurnRevolutions { revolutions: 5.5, rpm: 600.0 });
    bench.encoder.power_up(bench.now);
    bench.connect(81, &record(0x22, 65536, 1 << 30)).expect("the default record");
    assert_eq!(bench.frame().xist1, 1000 + 360_448);
}
