//! Protocol checks on hand-made PROFIBUS frames: each check finds its fault, and correct frames have no findings.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::common::handmade::bus::*;
use encspec::replay::{CaptureBlame, CaptureFinding, FindingSeverity, capture};
use rstest::rstest;
use station::Duration;
use wire::profibus::fdl::{AnswerFunction, FdlFrame};

fn findings(bus: &BusFrames) -> Vec<CaptureFinding> {
    capture("made", &bus.capture()[..], &[]).expect("a capture").findings
}

#[track_caller]
fn only(bus: &BusFrames, id: &str) -> CaptureFinding {
    let all = findings(bus);
    let [finding] = &all[..] else { panic!("one finding {id}: {all:#?}") };
    assert_eq!(finding.id, id, "{}", finding.text);
    assert!(finding.cause.is_some() && finding.next.is_some() && finding.filter.is_none());
    finding.clone()
}

fn started() -> BusFrames {
    let mut bus = BusFrames::default();
    bus.token();
    bus.start();
    bus.exchange(10);
    bus
}

#[test]
fn a_bus_in_order_has_no_findings() {
    let mut bus = started();
    bus.token();
    bus.diagnosis(&GOOD);
    bus.exchange(10);
    bus.acknowledged(61, &UNLOCK);
    assert_eq!(findings(&bus), []);
}

#[test]
fn a_capture_that_starts_late_has_no_errors() {
    let mut bus = started();
    bus.diagnosis(&GOOD);
    bus.exchange(10);
    for from in 1..bus.frames.len() {
        let late = BusFrames { frames: bus.frames[from..].to_vec(), ..BusFrames::default() };
        let all = findings(&late);
        assert!(all.iter().all(|finding| finding.severity == FindingSeverity::Info), "from frame {from}: {all:#?}");
    }
    for requests in [true, false] {
        let of_half = bus.frames.iter().enumerate().filter(|(at, _)| (at % 2 == 1) == requests);
        let half = BusFrames { frames: of_half.map(|(_, of)| of.clone()).collect(), ..BusFrames::default() };
        let all = findings(&half);
        assert!(all.iter().all(|finding| finding.severity == FindingSeverity::Info), "{all:#?}");
    }
}

#[test]
fn a_silent_slave_is_reported() {
    let mut bus = started();
    for number in 0..8 {
        bus.ask(None, &[0, 0, 1, number]);
        bus.pause = Duration::from_millis(20);
    }
    let finding = only(&bus, "DP-SLAVE-SILENT");
    assert_eq!((finding.blame, finding.severity), (CaptureBlame::Network, FindingSeverity::Error));
}

#[test]
fn single_unanswered_polls_are_blamed_on_the_line() {
    let mut bus = started();
    for number in 0..3 {
        bus.ask(None, &[0, 0, 1, number]);
        bus.exchange(3);
    }
    let finding = only(&bus, "DP-POLL-UNANSWERED");
    assert_eq!((finding.blame, finding.severity), (CaptureBlame::Network, FindingSeverity::Warning));
    assert!(finding.text.starts_with("3 of "), "{}", finding.text);
}

#[test]
fn repeated_requests_are_recognised_by_their_fcb() {
    let mut bus = started();
    for number in 0..3 {
        bus.ask(None, &[0, 0, 1, number]);
        let count = bus.count.unwrap();
        bus.ask_with(count, None, &[0, 0, 1, number]);
        bus.answer(AnswerFunction::DATA_LOW, None, &[1, 2, 3, number]);
    }
    assert_eq!(only(&bus, "DP-POLL-REPEATED").severity, FindingSeverity::Warning);
}

#[test]
fn a_slave_that_left_data_exchange_is_reported() {
    let mut bus = started();
    bus.ask(None, &[0, 0, 1, 0]);
    bus.answer(AnswerFunction::DATA_HIGH, None, &[1, 2, 3, 0]);
    bus.diagnosis(&[0x02, 0x05, 0x00, MASTER, 0x16, 0x55]);
    assert_eq!(only(&bus, "DP-SLAVE-LEFT").blame, CaptureBlame::Device);

    // Nothing had the master ask: the request with which it ended the data exchange may be missing.
    let mut bus = started();
    bus.diagnosis(&[0x02, 0x05, 0x00, MASTER, 0x16, 0x55]);
    assert_eq!(only(&bus, "DP-SLAVE-LEFT").blame, CaptureBlame::Capture);

    // SET_PRM has a watchdog of 100 ms.
    let mut bus = started();
    bus.pause = Duration::from_millis(150);
    bus.diagnosis(&NEW);
    let all = findings(&bus);
    assert!(
        all.iter().any(|finding| finding.id == "DP-SLAVE-WATCHDOG" && finding.blame == CaptureBlame::Controller),
        "{all:#?}"
    );
    assert!(all.iter().all(|finding| finding.id != "DP-SLAVE-LEFT"), "{all:#?}");
}

#[rstest]
#[case::parameters([0x42, 0x05, 0x00, 0xFF, 0x16, 0x55], "DP-PARAMETER-FAULT", "prm_fault")]
#[case::configuration([0x06, 0x05, 0x00, 0xFF, 0x16, 0x55], "DP-CONFIGURATION-FAULT", "cfg_fault")]
#[case::not_supported([0x12, 0x05, 0x00, 0xFF, 0x16, 0x55], "DP-NOT-SUPPORTED", "not_supported")]
fn start_up_faults_are_reported_by_name(#[case] diagnosis: [u8; 6], #[case] id: &str, #[case] word: &str) {
    let mut bus = BusFrames::default();
    bus.diagnosis(&NEW);
    bus.acknowledged(61, &SET_PRM);
    bus.acknowledged(62, &CHK_CFG);
    bus.diagnosis(&diagnosis);
    let finding = only(&bus, id);
    assert!(finding.text.contains(word), "{}", finding.text);
    assert_eq!((finding.frame, finding.octet), (9 - 1, Some(6)));
}

#[test]
fn a_pending_diagnosis_is_reported() {
    let report = [0x08, 0x0C, 0x00, MASTER, 0x16, 0x55, 0x02, 0x2A];
    let mut bus = started();
    bus.diagnosis(&report);
    bus.exchange(3);
    bus.diagnosis(&report);
    let finding = only(&bus, "DP-DIAGNOSIS-STANDING");
    assert_eq!((finding.severity, finding.blame), (FindingSeverity::Warning, CaptureBlame::Device));
    assert!(finding.text.contains("ext_diag") && finding.text.contains("2A"), "{}", finding.text);
    bus.diagnosis(&GOOD);
    assert_eq!(only(&bus, "DP-DIAGNOSIS-STANDING").severity, FindingSeverity::Info);
}

#[test]
fn another_master_is_reported() {
    let mut bus = started();
    bus.send(&FdlFrame::Token { da: 3, sa: MASTER });
    bus.ask_of(3, Some(61), &SET_PRM);
    bus.send(&FdlFrame::ShortAcknowledgement);
    let all = findings(&bus);
    assert!(
        all.iter().any(|finding| finding.id == "DP-OTHER-MASTER" && finding.severity == FindingSeverity::Error),
        "{all:#?}"
    );
}

#[test]
fn a_duplicate_token_and_a_lost_token_are_reported() {
    let mut bus = started();
    bus.send(&FdlFrame::Token { da: 3, sa: MASTER });
    bus.exchange(2);
    bus.send(&FdlFrame::Token { da: 3, sa: 3 });
    assert_eq!(only(&bus, "DP-TOKEN-TWICE").blame, CaptureBlame::Controller);

    // A token that is missing in the capture is no duplicate token.
    let mut bus = started();
    bus.send(&FdlFrame::Token { da: 3, sa: MASTER });
    bus.exchange(2);
    bus.token();
    let all = findings(&bus);
    assert!(all.iter().all(|finding| finding.id == "DP-TOKEN-LOST"), "{all:#?}");

    let mut bus = started();
    bus.send(&FdlFrame::Token { da: 3, sa: MASTER });
    bus.pause = Duration::from_millis(50);
    bus.token();
    bus.exchange(2);
    let finding = only(&bus, "DP-TOKEN-LOST");
    assert!(finding.text.contains("master 3"), "{}", finding.text);
}

#[test]
fn damaged_frames_are_counted() {
    let mut bus = started();
    for index in [15, 17, 19, 21, 23] {
        let octets = &mut bus.frames[index].1;
        let last = octets.len() - 2;
        octets[last] ^= 0x40;
    }
    let all = findings(&bus);
    assert!(
        all.iter().any(|finding| finding.id == "DP-FRAME-DAMAGED" && finding.text.starts_with("5 of ")),
        "{all:#?}"
    );
    assert!(all.iter().all(|finding| finding.blame == CaptureBlame::Network), "{all:#?}");
}
