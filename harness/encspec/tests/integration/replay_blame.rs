//! What a capture cannot prove is held against nobody, and what it does show is not passed over: hand-made frames of connections
//! that the capture shows in part, of stations with several devices, of connections that are made again and again, of names.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::common::made::{CONTROLLER, CYCLE, DEVICE, Line};
use encspec::replay::{Blame, CaptureReport, Finding, Severity, capture};
use rstest::rstest;
use station::Duration;
use std::fs;
use wire::ethernet::Mac;
use wire::profinet::dcp::{Block, BlockInfo, BlockQualifier, Dcp, Value};
use wire::profinet::diagnosis::{
    AlarmItem, Change, ChannelDiagnosis, ChannelErrorType, ChannelProperties, DiagnosisData, ExtChannelDiagnosis,
};
use wire::profinet::rpc::{Opnum, Uuid};
use wire::profinet::status::{AbortReason, CmrpcError, ErrorCode, Finder, PnioStatus};

const OTHER: Mac = Mac([2, 0, 0, 0, 1, 1]);
const EVERYBODY: Mac = Mac([0x01, 0x0E, 0xCF, 0, 0, 0]);
const OUT_OF_ARS: PnioStatus =
    PnioStatus::found(ErrorCode::CONNECT_RESPONSE, Finder::CMRPC, CmrpcError::OUT_OF_AR_RESOURCES.0);

fn report(line: &Line) -> CaptureReport {
    capture("made", &line.capture()[..], &[]).expect("a capture")
}

fn found(line: &Line, id: &str) -> Vec<Finding> {
    report(line).findings.into_iter().filter(|finding| finding.id == id).collect()
}

#[track_caller]
fn one(line: &Line, id: &str) -> Finding {
    let all = found(line, id);
    let [finding] = &all[..] else { panic!("one finding {id}: {:#?}", report(line).findings) };
    finding.clone()
}

/// Up to the answer to the end of the parameters.
fn parameterised() -> Line {
    let mut line = Line::new();
    line.connect_request();
    line.connect_response();
    line.end_parameters();
    line
}

/// So many cycles in which only one side is seen.
fn alone(line: &mut Line, by_device: bool, cycles: usize) {
    for _ in 0..cycles {
        line.cyclic(by_device, &[]);
        line.pass(CYCLE);
    }
}

#[test]
fn an_application_ready_that_nobody_could_have_seen_is_missed_by_nobody() {
    // Released behind it, and not one cyclic frame of the device although it had accepted the connection.
    let mut line = parameterised();
    line.pass(Duration::from_millis(200)).release();
    let finding = one(&line, "PN-START-INCOMPLETE");
    assert_eq!((finding.blame, finding.severity), (Blame::Capture, Severity::Info), "{}", finding.text);

    // Its frames are there all the time: then it was the controller that ended it early.
    let mut line = parameterised();
    line.exchange(100).release();
    assert_eq!(one(&line, "PN-START-INCOMPLETE").blame, Blame::Controller);

    // The capture has lost some of them.
    let mut line = parameterised();
    line.exchange(50);
    line.counter[1] = line.counter[1].wrapping_add(64);
    alone(&mut line, false, 1);
    line.exchange(50).release();
    assert_eq!(one(&line, "PN-START-INCOMPLETE").blame, Blame::Capture);
}

#[test]
fn a_start_up_that_stands_still_is_held_against_a_device_only_while_it_is_seen() {
    let mut line = parameterised();
    line.exchange(15_500);
    let finding = one(&line, "PN-START-INCOMPLETE");
    assert_eq!((finding.blame, finding.severity), (Blame::Device, Severity::Warning), "{}", finding.text);

    // Only the frames of the controller are there, and it would not go on sending to nobody.
    let mut line = parameterised();
    alone(&mut line, false, 15_500);
    let finding = one(&line, "PN-START-INCOMPLETE");
    assert_eq!((finding.blame, finding.severity), (Blame::Capture, Severity::Info), "{}", finding.text);

    // No controller waits for so long.
    let mut line = parameterised();
    line.exchange(160_000);
    assert_eq!(found(&line, "PN-START-INCOMPLETE"), []);
}

#[test]
fn a_controller_that_says_what_it_missed_is_believed() {
    for cycles in [0, 3_000] {
        let mut line = parameterised();
        line.exchange(cycles).pass(if cycles == 0 { Duration::from_secs(20) } else { Duration::ZERO });
        line.abort(false, PnioStatus::abort(AbortReason::APPLICATION_READY_TIMEOUT));
        let finding = one(&line, "PN-START-INCOMPLETE");
        assert_eq!((finding.blame, finding.severity), (Blame::Device, Severity::Error), "{}", finding.text);
    }
    // It says something else, and nothing of the device was seen.
    let mut line = parameterised();
    line.pass(Duration::from_secs(20)).abort(false, PnioStatus::abort(AbortReason::INSTANCE_CLOSED));
    let finding = one(&line, "PN-START-INCOMPLETE");
    assert_eq!((finding.blame, finding.severity), (Blame::Capture, Severity::Info), "{}", finding.text);
}

#[test]
fn a_device_that_falls_silent_in_its_start_up_may_have_lost_its_cable() {
    let mut line = parameterised();
    line.exchange(20);
    alone(&mut line, false, 10);
    let finding = one(&line, "PN-START-INCOMPLETE");
    assert_eq!((finding.blame, finding.severity), (Blame::Network, Severity::Warning), "{}", finding.text);
}

#[test]
fn a_connection_to_another_device_of_the_same_station_ends_nothing() {
    let mut line = parameterised();
    let first = (line.ids, line.ar, line.activity, line.sequence);
    (line.ids, line.ar, line.activity) = ((0xFF00, 0x80E0), Uuid([8; 16]), 21);
    line.pass(Duration::from_millis(60)).start();
    (line.ids, line.ar, line.activity, line.sequence) = first;
    line.ready();
    assert_eq!(report(&line).findings, []);
}

#[test]
fn a_connect_to_another_device_of_the_same_station_gives_up_no_call() {
    let mut line = Line::new();
    line.connect_request();
    line.again(Duration::from_millis(500));
    let first = (line.ids, line.ar, line.activity, line.sequence);
    (line.ids, line.ar, line.activity) = ((0xFF00, 0x80E0), Uuid([8; 16]), 21);
    line.start();
    (line.ids, line.ar, line.activity, line.sequence) = first;
    line.connect_response();
    line.end_parameters();
    line.ready();
    assert_eq!(found(&line, "PN-START-UNANSWERED"), []);
}

#[test]
fn a_connection_that_is_made_anew_again_and_again_is_told() {
    let again = |released: bool| {
        let mut line = Line::new();
        for round in 1..=5 {
            (line.ar, line.activity) = (Uuid([round; 16]), 10 * round);
            line.start();
            line.pass(Duration::from_secs(33));
            if released {
                line.release();
            }
        }
        line
    };
    let finding = one(&again(false), "PN-START-AGAIN");
    assert_eq!((finding.severity, finding.blame), (Severity::Warning, Blame::Network));
    assert!(finding.text.contains("4 times"), "{}", finding.text);
    assert_eq!(report(&again(true)).findings, []);
}

#[test]
fn a_refusal_names_the_connection_that_was_not_released() {
    let mut line = Line::new();
    line.start();
    (line.ar, line.activity) = (Uuid([8; 16]), 21);
    line.pass(Duration::from_secs(10)).connect_request();
    line.response(0, Opnum::CONNECT, OUT_OF_ARS, &[]);
    let finding = one(&line, "PN-START-REFUSED");
    assert!(finding.text.contains("requested in frame 1 was not released"), "{}", finding.text);
    assert!(finding.cause.is_some_and(|cause| cause.contains("still")));
}

#[test]
fn a_device_that_received_a_release_was_released() {
    let mut line = Line::new();
    line.start().exchange(20);
    line.abort(true, PnioStatus::abort(AbortReason::RELEASE_RECEIVED));
    let finding = one(&line, "PN-ABORT");
    assert_eq!((finding.severity, finding.blame), (Severity::Info, Blame::Capture), "{}", finding.text);
}

#[test]
fn an_answer_that_is_not_in_the_capture_is_not_said_to_be_missing() {
    let mut line = Line::new();
    line.connect_request();
    let events = report(&line).events;
    let [event] = &events[..] else { panic!("one event: {events:#?}") };
    assert!(event.text.contains("the capture has no answer"), "{}", event.text);
    assert!(!event.text.contains("nobody"), "{}", event.text);
}

fn dcp(line: &mut Line, source: Mac, destination: Mac, pdu: &Dcp) -> usize {
    let mut frame = Vec::new();
    pdu.write_frame(destination, source, &mut frame);
    line.push(frame)
}

fn search(line: &mut Line, xid: u32, name: &[u8]) -> usize {
    dcp(line, CONTROLLER, EVERYBODY, &Dcp::identify(xid, 1, vec![Value::NameOfStation(name.to_vec())]))
}

/// A station answers an Identify of the controller with its name.
fn identified(line: &mut Line, xid: u32, station: Mac, name: &[u8]) -> usize {
    let response = Dcp::identify(xid, 1, vec![Value::AllSelector])
        .response(vec![Block { word: Some(BlockInfo(0).0), value: Value::NameOfStation(name.to_vec()) }]);
    dcp(line, station, CONTROLLER, &response)
}

#[test]
fn a_name_that_was_asked_for_once_is_mentioned_where_others_were_answered() {
    let asked = |others: bool, given: bool| {
        let mut line = Line::new();
        if others {
            search(&mut line, 1, b"enc-1");
            identified(&mut line, 1, DEVICE, b"enc-1");
        }
        search(&mut line, 2, b"enc-9");
        line.pass(Duration::from_secs(4));
        if given {
            // Whether the name was free was asked before it was given.
            let word = Some(BlockQualifier::PERMANENT.0);
            let set = Dcp::set(7, vec![Block { word, value: Value::NameOfStation(b"enc-9".to_vec()) }]);
            dcp(&mut line, CONTROLLER, DEVICE, &set);
        }
        line.cyclic(true, &[]);
        line
    };
    let finding = one(&asked(true, false), "PN-NAME-UNKNOWN");
    assert_eq!((finding.frame, finding.severity), (3, Severity::Info));
    assert!(finding.text.contains("once") && finding.text.contains("enc-9"), "{}", finding.text);
    assert_eq!(found(&asked(false, false), "PN-NAME-UNKNOWN"), []);
    assert_eq!(found(&asked(true, true), "PN-NAME-UNKNOWN"), []);
}

#[test]
fn of_two_stations_with_one_name_both_frames_are_named() {
    let mut line = Line::new();
    let first = identified(&mut line, 1, DEVICE, b"enc-1");
    let second = identified(&mut line, 1, OTHER, b"enc-1");
    let text = one(&line, "PN-NAME-DUPLICATE").text;
    for (mac, frame) in [(DEVICE, first), (OTHER, second)] {
        assert!(text.contains(&format!("{mac} (frame {frame})")), "{text}");
    }
}

#[rstest]
#[case(b"enc-1", true)]
#[case(b"enc-1.line-2.plant", true)]
#[case(b"plcxb1.profinet-schnittstellexb15ee1", true)]
#[case(b"Enc_1", false)]
#[case(b"%n%n%n ", false)]
#[case(b"enc 1", false)]
#[case(b"-enc", false)]
#[case(b"enc-.a", false)]
#[case(b"enc..a", false)]
#[case(b"192.168.0.1", false)]
#[case(b"port-001", false)]
#[case(b"port-001-00002", false)]
#[case(b"portal-1", true)]
#[case(b"enc-1\0\0", false)]
fn a_name_that_no_controller_can_find_is_told(#[case] name: &[u8], #[case] is_right: bool) {
    let mut line = Line::new();
    let frame = identified(&mut line, 1, DEVICE, name);
    identified(&mut line, 2, DEVICE, name);
    if is_right {
        assert_eq!(report(&line).findings, []);
        return;
    }
    let finding = one(&line, "PN-NAME-INVALID");
    assert_eq!((finding.frame, finding.severity, finding.blame), (frame as u64, Severity::Warning, Blame::Controller));
}

#[test]
fn a_name_that_is_filled_up_with_zeros_stays_readable() {
    let mut line = Line::new();
    identified(&mut line, 1, DEVICE, &[b"enc-1".to_vec(), vec![0; 200]].concat());
    let text = one(&line, "PN-NAME-INVALID").text;
    assert!(text.contains("'enc-1\\x00..'") && text.len() < 150, "{text}");
}

#[test]
fn a_diagnosis_that_is_read_from_a_record_is_told() {
    let properties = ChannelProperties(0x0800);
    assert_eq!(properties.change(), Change::Appears);
    let entry = |error: u16| {
        let channel = ChannelDiagnosis { channel: 0x8000, properties, error_type: ChannelErrorType(error) };
        ExtChannelDiagnosis { channel, ext_error_type: 0x8000, add_value: 0 }
    };
    for (error, blame) in [(0x8001, Blame::Network), (0x0006, Blame::Device)] {
        let mut record = Vec::new();
        let (api, item) = (Some(0), AlarmItem::ExtChannel(vec![entry(error)]));
        DiagnosisData { api, slot: 0, subslot: 0x8001, channel: 0x8000, properties, item }.write(&mut record);
        let mut line = Line::new();
        let first = line.read(0x800C, Ok(&record), true);
        line.read(0x800C, Ok(&record), true);
        let finding = one(&line, "PN-ALARM-DIAGNOSIS");
        assert_eq!((finding.frame, finding.severity, finding.blame), (first as u64, Severity::Warning, blame));
        assert!(finding.text.contains("subslot 0x8001") && finding.text.contains("0x800C"), "{}", finding.text);
        assert_eq!(report(&line).findings.len(), 1);
        // A record without a diagnosis, and one that is not a record of diagnoses.
        let mut line = Line::new();
        line.read(0x800C, Ok(&[]), true);
        line.read(0xAFF0, Ok(&record), true);
        assert_eq!(report(&line).findings, []);
    }
}

#[test]
fn a_capture_of_something_else_is_no_good_capture() {
    let of = |ether_type: [u8; 2]| {
        let mut line = Line::new();
        for _ in 0..5 {
            line.push([&DEVICE.0[..], &CONTROLLER.0, &ether_type, &[0; 46]].concat());
        }
        line
    };
    let finding = one(&of([0x86, 0xDD]), "PN-CAPTURE-NOTHING");
    assert_eq!((finding.severity, finding.blame), (Severity::Error, Blame::Capture), "it must not end well");
    assert_eq!(found(&of([0x88, 0x92]), "PN-CAPTURE-NOTHING"), []);
}

/// The frames are those that tshark shows.
#[rstest]
#[case("record-reads.pcapng", &[("PN-ALARM-DIAGNOSIS", Blame::Network, 6), ("PN-ALARM-DIAGNOSIS", Blame::Network, 6), ("PN-ALARM-DIAGNOSIS", Blame::Network, 12)])]
#[case("odd-station-name.pcap", &[("PN-NAME-INVALID", Blame::Controller, 2)])]
#[case("one-ar-life.pcapng", &[("PN-START-MODULES", Blame::Controller, 2), ("PN-START-INCOMPLETE", Blame::Capture, 9)])]
fn captures_of_strangers(#[case] name: &str, #[case] expected: &[(&str, Blame, u64)]) {
    let Some(path) = testing::shared(&format!("captures/profinet/{name}")) else { return };
    let report = capture(name, &fs::read(path).unwrap()[..], &[]).unwrap();
    let told: Vec<_> =
        report.findings.iter().map(|finding| (finding.id.as_str(), finding.blame, finding.frame)).collect();
    assert_eq!(told, expected, "{:#?}", report.findings);
}
