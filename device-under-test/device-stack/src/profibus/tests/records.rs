//! DP-V1 records: acknowledged, polled, refused.

use super::bench::{ObservedAnswer, RS};
use super::toy::{CFG, PRM, bench};
use crate::Attached;
use core::time::Duration;

/// Longer than the slave needs to process a record, 2 ms.
const RECORD_WAIT: Duration = Duration::from_millis(5);

#[test]
fn a_class_1_master_writes_and_reads() {
    let mut bench = bench(Attached::NONE);
    bench.set_prm(&PRM);
    bench.chk_cfg(&CFG);
    let ms1 = Some((51, 51));
    let mut exchange = |request: &[u8]| {
        assert_eq!(bench.ask(ms1, request), ObservedAnswer::Taken);
        bench.wait(RECORD_WAIT);
        match bench.ask(ms1, &[]) {
            ObservedAnswer::Data(8, octets) => octets,
            other => panic!("{other:?}"),
        }
    };
    assert_eq!(exchange(&[0x5F, 1, 47, 2, 0xAA, 0xBB]), [0x5F, 1, 47, 2]);
    assert_eq!(exchange(&[0x5E, 1, 47, 240]), [0x5E, 1, 47, 2, 0xAA, 0xBB]);
    assert_eq!(exchange(&[0x5E, 1, 47, 1]), [0x5E, 1, 47, 1, 0xAA]);
    assert_eq!(exchange(&[0x5E, 1, 48, 1]), [0xDE, 0x80, 0xB0, 0]);
    assert_eq!(exchange(&[0x5F, 1, 48, 0]), [0xDF, 0x80, 0xB6, 0]);
}

/// IEC 61158-6-3, MSAC1_Alarm_Ack: the response repeats slot, type and specifier; it may come from access point 50 or 51.
#[test]
fn a_class_1_master_acknowledges_an_alarm() {
    let mut bench = bench(Attached::NONE);
    bench.set_prm(&PRM);
    bench.chk_cfg(&CFG);
    for sap in [50, 51] {
        let mut exchange = |request: &[u8]| {
            assert_eq!(bench.ask(Some((sap, 51)), request), ObservedAnswer::Taken);
            bench.wait(RECORD_WAIT);
            bench.ask(Some((sap, 51)), &[])
        };
        assert_eq!(exchange(&[0x5C, 1, 2, 0x19]), ObservedAnswer::Data(8, [0x5C, 1, 2, 0x19].into()));
        assert_eq!(exchange(&[0x5C, 1, 2, 0x11]), ObservedAnswer::Data(8, [0xDC, 0x80, 0xB5, 0].into()));
    }
    assert_eq!(bench.ask(Some((50, 51)), &[0x5E, 1, 47, 1]), RS, "records are at access point 51");
}

#[test]
fn one_request_is_accepted_at_a_time_and_none_without_dpv1() {
    let mut bench = bench(Attached::NONE);
    bench.set_prm(&PRM);
    bench.chk_cfg(&CFG);
    let ms1 = Some((51, 51));
    assert_eq!(bench.ask(ms1, &[0x5E, 1, 47, 1]), ObservedAnswer::Taken);
    assert_eq!(bench.ask(ms1, &[0x5E, 1, 47, 1]), ObservedAnswer::Data(2, [].into()));
    let mut prm = PRM;
    prm[7] = 0;
    bench.set_prm(&prm);
    bench.chk_cfg(&CFG);
    assert_eq!(bench.ask(ms1, &[]), RS);
}

#[test]
fn a_class_2_master_opens_a_connection_which_times_out() {
    let mut bench = bench(Attached::NONE);
    let initiate = [0x57, 0, 0, 0, 0, 100, 1, 0, 0, 0, 0, 0, 0, 2, 0, 2, 0, 0, 0, 0];
    assert_eq!(bench.ask(Some((0, 50)), &[]), RS);
    assert_eq!(bench.ask(Some((49, 50)), &initiate), ObservedAnswer::Taken);
    assert_eq!(bench.ask(Some((49, 50)), &[]), ObservedAnswer::Data(8, [0x56, 0, 0, 100].into()));
    bench.wait(RECORD_WAIT);
    let ObservedAnswer::Data(8, granted) = bench.ask(Some((0, 50)), &[]) else { panic!("no answer") };
    assert_eq!(granted[..4], [0x57, 240, 1, 0]);
    assert_eq!(bench.ask(Some((49, 50)), &initiate), ObservedAnswer::Data(2, [].into()), "there is one connection");
    assert_eq!(bench.ask(Some((0, 50)), &[0x5E, 1, 47, 9]), ObservedAnswer::Taken);
    bench.wait(RECORD_WAIT);
    assert_eq!(bench.ask(Some((0, 50)), &[]), ObservedAnswer::Data(8, [0x5E, 1, 47, 3, 1, 2, 3].into()));
    bench.wait(Duration::from_secs(3));
    assert_eq!(bench.ask(Some((0, 50)), &[]), RS);
}
