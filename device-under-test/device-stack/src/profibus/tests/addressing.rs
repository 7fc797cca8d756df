//! Addresses and service access points: which requests are answered.

use super::bench::{ObservedAnswer, RS};
use super::toy::{CFG, PRM, bench};
use crate::Attached;
use core::time::Duration;
use rstest::rstest;
use wire::profibus::fdl::FrameCount;

#[test]
fn fdl_status_is_answered_by_a_slave_after_eleven_bits() {
    let mut bench = bench(Attached::NONE);
    assert_eq!(bench.send_frame(&[0x10, 5, 2, 0x49, 0x50, 0x16]), Some([0x10, 2, 5, 0, 7, 0x16].into()));
    assert_eq!(bench.delay, Duration::from_nanos(7_334), "11 bits at 1.5 Mbit/s");
}

#[rstest]
#[case::token(&[0xDC, 2, 2])]
#[case::gap_poll(&[0x10, 6, 2, 0x49, 0x51, 0x16])]
#[case::acknowledgement(&[0xE5])]
#[case::answer(&[0x10, 5, 2, 0, 7, 0x16])]
#[case::wrong_sum(&[0x10, 5, 2, 0x49, 0x51, 0x16])]
#[case::cut(&[0x10, 5, 2, 0x49, 0x50])]
#[case::broadcast(&[0x10, 127, 2, 0x49, 0xCA, 0x16])]
fn frames_without_an_answer(#[case] frame: &[u8]) {
    let mut bench = bench(Attached::NONE);
    assert_eq!(bench.send_frame(frame), None);
}

#[rstest]
#[case::unknown(1, 62)]
#[case::no_set_ext_prm(53, 62)]
#[case::other_source(60, 61)]
#[case::records_before_exchange(51, 51)]
fn inactive_access_points_answer_rs(#[case] destination: u8, #[case] source: u8) {
    let mut bench = bench(Attached::NONE);
    assert_eq!(bench.ask(Some((destination, source)), &[]), RS);
}

#[test]
fn set_slave_address_needs_the_ident_number_and_wait_prm() {
    let mut bench = bench(Attached::NONE);
    assert_eq!(bench.ask(Some((55, 62)), &[9, 0xAB, 0xCE, 0]), ObservedAnswer::Taken);
    assert_eq!(bench.ask(Some((55, 62)), &[126, 0xAB, 0xCD, 0]), ObservedAnswer::Taken);
    assert_eq!(bench.ask(Some((55, 62)), &[9, 0xAB, 0xCD]), RS);
    bench.diagnosis();
    assert_eq!(bench.ask(Some((55, 62)), &[9, 0xAB, 0xCD, 0]), ObservedAnswer::Taken);
    assert_eq!(bench.ask(Some((60, 62)), &[]), ObservedAnswer::Silence);
    (bench.slave, bench.count) = (9, FrameCount::First);
    bench.set_prm(&PRM);
    bench.chk_cfg(&CFG);
    bench.exchange(&[1, 2]);
    assert_eq!(bench.ask(Some((55, 62)), &[7, 0xAB, 0xCD, 0]), RS);
}

/// No request makes the slave panic or send an invalid frame.
#[test]
fn damaged_requests() {
    let mut bench = bench(Attached::NONE);
    bench.set_prm(&PRM);
    bench.chk_cfg(&CFG);
    for sap in 0..64 {
        for source in [50, 51, 62] {
            for length in 0..12 {
                let octets: std::vec::Vec<u8> =
                    (0..length).map(|at| if at == 0 { 0x5E + sap % 2 } else { at }).collect();
                bench.ask(Some((sap, source)), &octets);
            }
        }
    }
}
