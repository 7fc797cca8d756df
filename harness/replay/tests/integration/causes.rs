//! One cause is one finding: what follows from it is listed under it, and blames no other party.

use crate::handmade::{CYCLE, ConnectionFrames, DEVICE};
use encspec_replay::{CaptureBlame, CaptureFinding, FindingSeverity, capture};
use rstest::rstest;
use station::Duration;
use wire::ethernet::Mac;
use wire::profinet::dcp::{BlockQualifier, Dcp, DcpBlock, DcpValue};
use wire::profinet::rpc::Uuid;
use wire::profinet::status::{AbortReason, ErrorCode, PnioStatus, RecordError};

const THIRD_PARTY: Mac = Mac([2, 0, 0, 0, 0, 9]);

fn findings(line: &ConnectionFrames) -> Vec<CaptureFinding> {
    capture("made", &line.capture()[..], &[]).expect("a capture").findings
}

#[track_caller]
fn only(line: &ConnectionFrames, id: &str, consequences: &[&str]) -> CaptureFinding {
    let all = findings(line);
    let [finding] = &all[..] else { panic!("one finding {id}: {all:#?}") };
    let followed: Vec<&str> = finding.consequences.iter().map(|of| of.id.as_str()).collect();
    assert_eq!((finding.id.as_str(), &followed[..]), (id, consequences), "{finding:#?}");
    assert!(finding.consequences.iter().all(|of| of.blame == finding.blame), "{finding:#?}");
    finding.clone()
}

fn set(line: &mut ConnectionFrames, by: Mac, value: DcpValue) -> usize {
    let word = Some(BlockQualifier::PERMANENT.0 | 4);
    let mut frame = Vec::new();
    Dcp::set(7, vec![DcpBlock { word, value }]).write_frame(DEVICE, by, &mut frame);
    line.push(frame)
}

#[rstest]
#[case::rename(DcpValue::NameOfStation(b"other".to_vec()), AbortReason::STATION_NAME_CHANGED, "PN-SET-RUNNING")]
#[case::reset(DcpValue::ResetToFactory, AbortReason::RESET_TO_FACTORY, "PN-RESET-RUNNING")]
fn a_third_party_explains_the_abort_behind_it(#[case] value: DcpValue, #[case] reason: AbortReason, #[case] id: &str) {
    let mut line = ConnectionFrames::new();
    line.start().exchange(20);
    let frame = set(&mut line, THIRD_PARTY, value.clone());
    line.exchange(2);
    line.abort(true, PnioStatus::abort(reason));
    let finding = only(&line, id, &["PN-ABORT"]);
    assert_eq!((finding.frame, finding.severity), (frame as u64, FindingSeverity::Error));
    assert_eq!(finding.blame, CaptureBlame::Network);

    // An abort long after it has another cause.
    let mut line = ConnectionFrames::new();
    line.start().exchange(20);
    set(&mut line, THIRD_PARTY, value);
    line.exchange(35_000);
    line.abort(true, PnioStatus::abort(AbortReason::OUT_OF_MEMORY));
    assert_eq!(findings(&line).len(), 2);
}

#[test]
fn a_rename_explains_the_refused_write_and_the_incomplete_start() {
    let refused = PnioStatus::record(ErrorCode::WRITE_RESPONSE, RecordError::STATE_CONFLICT);
    let mut line = ConnectionFrames::new();
    line.connect_request();
    line.connect_response();
    line.exchange(3);
    set(&mut line, THIRD_PARTY, DcpValue::NameOfStation(b"other".to_vec()));
    line.write(&[(1, 2, 0xBF00, &[1, 2, 3])], false, &[refused]);
    line.exchange(3);
    line.abort(true, PnioStatus::abort(AbortReason::STATION_NAME_CHANGED));
    let finding = only(&line, "PN-SET-RUNNING", &["PN-RECORD-REFUSED", "PN-ABORT", "PN-START-INCOMPLETE"]);
    assert!(finding.text.contains(&THIRD_PARTY.to_string()), "{}", finding.text);
}

#[test]
fn a_silence_explains_the_abort_of_the_other_side() {
    let mut line = ConnectionFrames::new();
    line.start().exchange(20);
    for _ in 0..10 {
        line.cyclic(false, &[]);
        line.pass(CYCLE);
    }
    line.abort(false, PnioStatus::abort(AbortReason::CONSUMER_TIMEOUT));
    assert_eq!(only(&line, "PN-CYCLE-SILENT", &["PN-ABORT"]).severity, FindingSeverity::Error);
}

#[test]
fn a_missing_step_explains_the_abort_that_names_it() {
    let mut line = ConnectionFrames::new();
    line.connect_request();
    line.connect_response();
    line.end_parameters();
    line.pass(Duration::from_secs(20));
    line.abort(false, PnioStatus::abort(AbortReason::APPLICATION_READY_TIMEOUT));
    assert_eq!(only(&line, "PN-START-INCOMPLETE", &["PN-ABORT"]).blame, CaptureBlame::Device);
}

#[test]
fn an_abort_explains_the_incomplete_start() {
    let mut line = ConnectionFrames::new();
    line.connect_request();
    line.connect_response();
    line.exchange(3);
    line.abort(true, PnioStatus::abort(AbortReason::OUT_OF_MEMORY));
    assert_eq!(only(&line, "PN-ABORT", &["PN-START-INCOMPLETE"]).blame, CaptureBlame::Device);
}

#[test]
fn a_refused_record_explains_that_the_controller_gives_up() {
    let refused = PnioStatus::record(ErrorCode::WRITE_RESPONSE, RecordError::WRITE_LENGTH_ERROR);
    let mut line = ConnectionFrames::new();
    line.connect_request();
    line.connect_response();
    line.write(&[(1, 2, 0xBF00, &[1, 2, 3])], false, &[refused]);
    line.exchange(3).release();
    let finding = only(&line, "PN-RECORD-REFUSED", &["PN-START-INCOMPLETE"]);
    assert_eq!(finding.blame, CaptureBlame::Controller);
}

/// The device comes back and is lost again: one finding with a count, and the unsteady line under it.
#[test]
fn repeated_breaks_are_one_finding() {
    let mut line = ConnectionFrames::new();
    for round in 1..=4 {
        (line.ar, line.activity) = (Uuid([round; 16]), 10 * round);
        line.start().exchange(20);
        line.abort(true, PnioStatus::abort(AbortReason::LINK_DOWN));
        line.pass(Duration::from_millis(500));
    }
    let all = findings(&line);
    assert!(all.len() <= 2, "{all:#?}");
    assert_eq!(all.iter().map(|of| of.count).sum::<u64>(), 4);
    let again = all.iter().flat_map(|of| &of.consequences).filter(|of| of.id == "PN-START-AGAIN").count();
    assert_eq!(again, 1, "{all:#?}");
}

/// More breaks than are listed one by one are still one finding, which says how many there are.
#[test]
fn very_many_breaks_are_one_finding() {
    let mut line = ConnectionFrames::new();
    for round in 1..=120 {
        (line.ar, line.activity) = (Uuid([round; 16]), 2 * round);
        line.start().exchange(5);
        line.abort(true, PnioStatus::abort(AbortReason::LINK_DOWN));
        line.pass(Duration::from_millis(500));
    }
    let finding = only(&line, "PN-ABORT", &["PN-START-AGAIN"]);
    assert_eq!(finding.count, 100);
    assert!(finding.text.contains("and 20 more findings of this check"), "{}", finding.text);
}

/// The reset of one device does not explain what happens to another one.
#[test]
fn a_third_party_explains_nothing_of_others() {
    let mut line = ConnectionFrames::new();
    line.start().exchange(20);
    let mut frame = Vec::new();
    let other = Mac([2, 0, 0, 0, 1, 1]);
    let block = DcpBlock { word: Some(BlockQualifier::PERMANENT.0), value: DcpValue::ResetToFactory };
    Dcp::set(7, vec![block]).write_frame(other, THIRD_PARTY, &mut frame);
    line.push(frame);
    line.exchange(2);
    line.abort(true, PnioStatus::abort(AbortReason::OUT_OF_MEMORY));
    only(&line, "PN-ABORT", &[]);
}
