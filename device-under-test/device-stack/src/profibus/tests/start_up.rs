//! Start-up from parameters to data exchange, and back.

use super::bench::{ObservedAnswer, RS};
use super::toy::{CFG, PRM, bench};
use crate::Attached;
use crate::profibus::ExchangeEnd;
use core::time::Duration;
use rstest::rstest;
use station::{Stand, StandAction, Time};

fn changed(at: usize, byte: u8) -> [u8; 11] {
    let mut prm = PRM;
    prm[at] = byte;
    prm
}

#[test]
fn a_slave_goes_from_parameters_over_configuration_to_data() {
    let mut bench = bench(Attached::NONE);
    assert_eq!(bench.diagnosis(), [0x0A, 0x05, 0, 0xFF, 0xAB, 0xCD, 2, 0x55]);
    assert_eq!(bench.chk_cfg(&CFG), RS);
    assert_eq!(bench.ask(None, &[0, 0]), RS);
    assert_eq!(bench.set_prm(&PRM), ObservedAnswer::Taken);
    assert_eq!(bench.diagnosis()[..4], [0x0A, 0x0C, 0, 2]);
    assert_eq!(bench.ask(None, &[0, 0]), RS);
    assert_eq!(bench.chk_cfg(&CFG), ObservedAnswer::Taken);
    assert_eq!(bench.diagnosis()[..4], [0x08, 0x0C, 0, 2]);
    assert_eq!(bench.exchange(&[3, 4]), [1, 1]);
    assert_eq!(bench.device.application().outputs.as_deref(), Some(&[3, 4][..]));
    assert_eq!(bench.ask(Some((57, 62)), &[]), ObservedAnswer::Data(8, [3, 4].into()));
    assert_eq!(bench.ask(Some((56, 62)), &[]), ObservedAnswer::Data(8, [2, 2].into()));
    assert_eq!(bench.ask(Some((59, 62)), &[]), ObservedAnswer::Data(8, CFG.into()));
}

#[rstest]
#[case::ident(changed(5, 0xCE))]
#[case::no_watchdog_factor(changed(1, 0))]
#[case::of_the_application(changed(10, 8))]
fn wrong_parameters(#[case] prm: [u8; 11]) {
    let mut bench = bench(Attached::NONE);
    assert_eq!(bench.set_prm(&prm), ObservedAnswer::Taken);
    assert_eq!(bench.diagnosis()[..4], [0x4A, 0x05, 0, 0xFF]);
    assert_eq!(bench.chk_cfg(&CFG), RS);
    bench.set_prm(&PRM);
    assert_eq!(bench.diagnosis()[..2], [0x0A, 0x0C]);
}

#[test]
fn a_wrong_configuration_needs_new_parameters() {
    let mut bench = bench(Attached::NONE);
    bench.set_prm(&PRM);
    bench.chk_cfg(&[0x11]);
    assert_eq!(bench.diagnosis()[..4], [0x0E, 0x05, 0, 0xFF]);
    assert_eq!(bench.chk_cfg(&CFG), RS);
    bench.set_prm(&PRM);
    bench.chk_cfg(&CFG);
    assert_eq!(bench.diagnosis()[0], 0x08);
}

fn in_exchange() -> super::bench::SlaveBench<crate::profibus::DpDevice<super::toy::ToySlaveApplication>> {
    let mut bench = bench(Attached::NONE);
    bench.set_prm(&PRM);
    bench.chk_cfg(&CFG);
    bench.exchange(&[1, 2]);
    bench
}

#[test]
fn the_watchdog_ends_the_exchange_and_clears_the_outputs() {
    let mut bench = in_exchange();
    for _ in 0..5 {
        bench.wait(Duration::from_millis(90));
        bench.exchange(&[1, 2]);
    }
    bench.wait(Duration::from_millis(110));
    assert_eq!(bench.device.application().ends, [ExchangeEnd::Watchdog]);
    assert_eq!(bench.device.application().outputs, None);
    assert_eq!(bench.ask(None, &[1, 2]), RS);
    assert_eq!(bench.diagnosis()[..4], [0x0A, 0x05, 0, 0xFF]);
}

#[test]
fn a_watchdog_with_1_ms_base_and_without_watchdog() {
    let mut bench = bench(Attached::NONE);
    for (octets, left) in [([0x88, 0x84], true), ([0x80, 0x80], false)] {
        let mut prm = changed(0, octets[0]);
        prm[7] = octets[1];
        bench.set_prm(&prm);
        bench.chk_cfg(&CFG);
        bench.exchange(&[1, 2]);
        bench.wait(Duration::from_millis(11));
        assert_eq!(bench.diagnosis()[1] & 1 != 0, left);
    }
    bench.wait(Duration::from_secs(100));
    bench.exchange(&[1, 2]);
}

#[test]
fn another_master_can_only_read_the_diagnosis_until_the_slave_is_unlocked() {
    let mut bench = in_exchange();
    bench.master = 3;
    for (saps, data) in [(Some((61, 62)), &PRM[..]), (Some((62, 62)), &CFG), (None, &[9, 9])] {
        assert_eq!(bench.ask(saps, data), RS);
    }
    assert_eq!(bench.diagnosis()[3], 2);
    bench.master = 2;
    assert_eq!(bench.exchange(&[1, 2]).len(), 2);
    assert_eq!(bench.set_prm(&changed(0, 0x40)), ObservedAnswer::Taken);
    assert_eq!(bench.diagnosis()[..4], [0x0A, 0x05, 0, 0xFF]);
    bench.master = 3;
    bench.set_prm(&PRM);
    assert_eq!(bench.diagnosis()[3], 3);
}

#[test]
fn without_lock_req_only_min_tsdr_is_set() {
    let mut bench = in_exchange();
    let mut prm = changed(0, 0);
    prm[3] = 100;
    prm[10] = 8;
    assert_eq!(bench.set_prm(&prm), ObservedAnswer::Taken);
    assert_eq!(bench.diagnosis()[..2], [0x08, 0x0C]);
    assert_eq!(bench.delay, Duration::from_nanos(66_667), "100 bits at 1.5 Mbit/s");
    bench.exchange(&[1, 2]);
}

#[test]
fn a_repetition_is_answered_and_not_carried_out() {
    let mut bench = in_exchange();
    let first = bench.ask(None, &[5, 5]);
    assert_eq!(bench.repeat(None, &[5, 5]), first);
    assert_eq!(bench.device.application().inputs_given, 2);
    assert_ne!(bench.ask(None, &[5, 5]), first);
}

#[rstest]
#[case(&[1])]
#[case(&[1, 2, 3])]
#[case(&[])]
fn outputs_of_another_length_end_the_exchange(#[case] outputs: &[u8]) {
    let mut bench = in_exchange();
    assert_eq!(bench.ask(None, outputs), RS);
    assert_eq!(bench.diagnosis()[..2], [0x0E, 0x05]);
    assert_eq!(bench.device.application().ends, [ExchangeEnd::Fault]);
}

#[test]
fn clear_freeze_and_sync() {
    let mut bench = in_exchange();
    bench.control(0x02, 0);
    assert_eq!(bench.device.application().outputs, None);
    bench.exchange(&[1, 2]);
    assert_eq!(bench.device.application().outputs, None);
    bench.control(0x00, 1);
    bench.exchange(&[1, 2]);
    assert!(bench.device.application().outputs.is_some());

    bench.control(0x08, 1);
    let frozen = bench.exchange(&[1, 2]);
    assert_eq!(bench.exchange(&[1, 2]), frozen);
    assert_eq!(bench.diagnosis()[1], 0x1C);
    bench.control(0x04, 1);
    assert_ne!(bench.exchange(&[1, 2]), frozen);

    bench.control(0x20, 1);
    bench.exchange(&[8, 8]);
    assert_eq!(bench.device.application().outputs.as_deref(), Some(&[1, 2][..]));
    assert_eq!(bench.diagnosis()[1], 0x2C);
    bench.control(0x20, 1);
    assert_eq!(bench.device.application().outputs.as_deref(), Some(&[8, 8][..]));
    bench.exchange(&[9, 9]);
    bench.control(0x10, 2);
    assert_eq!(bench.device.application().outputs.as_deref(), Some(&[8, 8][..]), "the command addresses another group");
    bench.control(0x10, 3);
    assert_eq!(bench.device.application().outputs.as_deref(), Some(&[9, 9][..]));
    assert_eq!(bench.device.application().clocks, 7);
}

#[test]
fn a_new_diagnosis_is_announced_until_it_is_fetched() {
    let mut bench = in_exchange();
    bench.device.act(Time::ZERO, &StandAction::Fault("any", true)).expect("the toy has faults");
    let codes: std::vec::Vec<_> = (0..3)
        .map(|round| {
            if round == 2 {
                bench.diagnosis();
            }
            match bench.ask(None, &[1, 2]) {
                ObservedAnswer::Data(code, _) => code,
                other => panic!("{other:?}"),
            }
        })
        .collect();
    assert_eq!(codes, [0x08, 0x0A, 0x08], "the first frame after the change detects it");
}

#[test]
fn a_power_cycle_resets_the_slave_and_it_sends_nothing_while_booting() {
    let mut bench = in_exchange();
    bench.device.act(bench.now, &StandAction::Power(false)).expect("the stand controls power");
    assert_eq!(bench.ask(None, &[1, 2]), ObservedAnswer::Silence);
    bench.device.act(bench.now, &StandAction::Power(true)).expect("the stand controls power");
    bench.wait(Duration::from_millis(90));
    assert_eq!(bench.ask(Some((60, 62)), &[]), ObservedAnswer::Silence);
    bench.wait(Duration::from_millis(20));
    assert_eq!(bench.diagnosis()[..4], [0x0A, 0x05, 0, 0xFF]);
}
