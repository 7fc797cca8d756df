//! Replay blames no station for what a capture cannot prove, and reports what it does show: hand-made frames of partly captured
//! connections, stations with several devices, repeated connections, and station names.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::common::handmade::{CONTROLLER, CYCLE, ConnectionFrames, DEVICE};
use encspec::replay::{CaptureBlame, CaptureFinding, CaptureReport, FindingSeverity, capture};
use rstest::rstest;
use station::Duration;
use std::fs;
use wire::ethernet::Mac;
use wire::profinet::dcp::{BlockInfo, BlockQualifier, Dcp, DcpBlock, DcpValue};
use wire::profinet::diagnosis::{
    AlarmItem, ChannelChange, ChannelDiagnosis, ChannelErrorType, ChannelProperties, DiagnosisData, ExtChannelDiagnosis,
};
use wire::profinet::rpc::{Opnum, Uuid};
use wire::profinet::status::{AbortReason, CmrpcError, ErrorCode, ErrorSource, PnioStatus};

const OTHER: Mac = Mac([2, 0, 0, 0, 1, 1]);
const DCP_MULTICAST: Mac = Mac([0x01, 0x0E, 0xCF, 0, 0, 0]);
const OUT_OF_ARS: PnioStatus =
    PnioStatus::found(ErrorCode::CONNECT_RESPONSE, ErrorSource::CMRPC, CmrpcError::OUT_OF_AR_RESOURCES.0);

fn report(line: &ConnectionFrames) -> CaptureReport {
    capture("made", &line.capture()[..], &[]).expect("a capture")
}

/// The findings with this id that follow from no other.
fn found(line: &ConnectionFrames, id: &str) -> Vec<CaptureFinding> {
    report(line).findings.into_iter().filter(|finding| finding.id == id).collect()
}

/// The only finding with this id, whether it follows from another one or not.
#[track_caller]
fn one(line: &ConnectionFrames, id: &str) -> CaptureFinding {
    let all: Vec<CaptureFinding> =
        report(line).findings.into_iter().flat_map(|of| of.consequences.clone().into_iter().chain([of])).collect();
    let found: Vec<&CaptureFinding> = all.iter().filter(|finding| finding.id == id).collect();
    let [finding] = found[..] else { panic!("one finding {id}: {all:#?}") };
    finding.clone()
}

/// A start-up up to the response to the end of parameters.
fn parameterised() -> ConnectionFrames {
    let mut line = ConnectionFrames::new();
    line.connect_request();
    line.connect_response();
    line.end_parameters();
    line
}

/// `cycles` cycles in which only one side is captured.
fn alone(line: &mut ConnectionFrames, by_device: bool, cycles: usize) {
    for _ in 0..cycles {
        line.cyclic(by_device, &[]);
        line.pass(CYCLE);
    }
}

#[test]
fn a_missing_application_ready_is_not_blamed_if_it_could_not_be_captured() {
    // Released, and no cyclic frame of the device was captured although it had accepted the connection.
    let mut line = parameterised();
    line.pass(Duration::from_millis(200)).release();
    let finding = one(&line, "PN-START-INCOMPLETE");
    assert_eq!((finding.blame, finding.severity), (CaptureBlame::Capture, FindingSeverity::Info), "{}", finding.text);

    // All frames of the device were captured: the controller released too early.
    let mut line = parameterised();
    line.exchange(100).release();
    assert_eq!(one(&line, "PN-START-INCOMPLETE").blame, CaptureBlame::Controller);

    // The capture lost some of the device's frames.
    let mut line = parameterised();
    line.exchange(50);
    line.counter[1] = line.counter[1].wrapping_add(64);
    alone(&mut line, false, 1);
    line.exchange(50).release();
    assert_eq!(one(&line, "PN-START-INCOMPLETE").blame, CaptureBlame::Capture);
}

#[test]
fn a_stuck_start_up_is_blamed_on_the_device_only_if_its_frames_are_captured() {
    let mut line = parameterised();
    line.exchange(15_500);
    let finding = one(&line, "PN-START-INCOMPLETE");
    assert_eq!((finding.blame, finding.severity), (CaptureBlame::Device, FindingSeverity::Warning), "{}", finding.text);

    // Only frames of the controller were captured, and it would not keep sending without a device.
    let mut line = parameterised();
    alone(&mut line, false, 15_500);
    let finding = one(&line, "PN-START-INCOMPLETE");
    assert_eq!((finding.blame, finding.severity), (CaptureBlame::Capture, FindingSeverity::Info), "{}", finding.text);

    // No controller waits this long.
    let mut line = parameterised();
    line.exchange(160_000);
    assert_eq!(found(&line, "PN-START-INCOMPLETE"), []);
}

#[test]
fn the_abort_reason_of_the_controller_is_used() {
    for cycles in [0, 3_000] {
        let mut line = parameterised();
        line.exchange(cycles).pass(if cycles == 0 { Duration::from_secs(20) } else { Duration::ZERO });
        line.abort(false, PnioStatus::abort(AbortReason::APPLICATION_READY_TIMEOUT));
        let finding = one(&line, "PN-START-INCOMPLETE");
        assert_eq!(
            (finding.blame, finding.severity),
            (CaptureBlame::Device, FindingSeverity::Error),
            "{}",
            finding.text
        );
    }
    // Another abort reason, and no frame of the device was captured.
    let mut line = parameterised();
    line.pass(Duration::from_secs(20)).abort(false, PnioStatus::abort(AbortReason::INSTANCE_CLOSED));
    let finding = one(&line, "PN-START-INCOMPLETE");
    assert_eq!((finding.blame, finding.severity), (CaptureBlame::Capture, FindingSeverity::Info), "{}", finding.text);
}

#[test]
fn a_device_that_stops_sending_in_the_start_up_may_have_lost_its_cable() {
    let mut line = parameterised();
    line.exchange(20);
    alone(&mut line, false, 10);
    let finding = one(&line, "PN-START-INCOMPLETE");
    assert_eq!(
        (finding.blame, finding.severity),
        (CaptureBlame::Undecided, FindingSeverity::Warning),
        "{}",
        finding.text
    );
}

#[test]
fn a_connection_to_another_device_of_a_station_does_not_end_the_first() {
    let mut line = parameterised();
    let first = (line.ids, line.ar, line.activity, line.sequence);
    (line.ids, line.ar, line.activity) = ((0xFF00, 0x80E0), Uuid([8; 16]), 21);
    line.pass(Duration::from_millis(60)).start();
    (line.ids, line.ar, line.activity, line.sequence) = first;
    line.ready();
    assert_eq!(report(&line).findings, []);
}

#[test]
fn a_connect_to_another_device_of_a_station_cancels_no_call() {
    let mut line = ConnectionFrames::new();
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
fn repeated_connections_are_reported() {
    let again = |released: bool, closed: bool| {
        let mut line = ConnectionFrames::new();
        for round in 1..=5 {
            (line.ar, line.activity) = (Uuid([round; 16]), 10 * round);
            line.start();
            line.pass(Duration::from_secs(33));
            if released {
                line.release();
            }
            if closed {
                line.abort(true, PnioStatus::abort(AbortReason::RELEASE_RECEIVED));
            }
        }
        line
    };
    let finding = one(&again(false, false), "PN-START-AGAIN");
    assert_eq!((finding.severity, finding.blame), (FindingSeverity::Warning, CaptureBlame::Network));
    assert!(finding.text.contains("4 times"), "{}", finding.text);
    assert_eq!(report(&again(true, false)).findings, []);
    assert_eq!(found(&again(true, true), "PN-START-AGAIN"), [], "an ERR-RTA after the Release breaks no connection");
}

#[test]
fn a_refusal_names_the_unreleased_connection() {
    let mut line = ConnectionFrames::new();
    line.start();
    (line.ar, line.activity) = (Uuid([8; 16]), 21);
    line.pass(Duration::from_secs(10)).connect_request();
    line.response(0, Opnum::CONNECT, OUT_OF_ARS, &[]);
    let finding = one(&line, "PN-START-REFUSED");
    assert!(finding.text.contains("requested in frame 1 was not released"), "{}", finding.text);
    assert!(finding.cause.is_some_and(|cause| cause.contains("still")));
}

#[test]
fn an_abort_after_a_release_that_is_not_in_the_capture_is_undecided() {
    let mut line = ConnectionFrames::new();
    line.start().exchange(20);
    line.abort(true, PnioStatus::abort(AbortReason::RELEASE_RECEIVED));
    let finding = one(&line, "PN-ABORT");
    let expected = (FindingSeverity::Warning, CaptureBlame::Undecided);
    assert_eq!((finding.severity, finding.blame), expected, "{}", finding.text);
    assert!(finding.text.contains("no Release of the controller is in the capture"), "{}", finding.text);
}

#[test]
fn an_answer_missing_in_the_capture_is_not_reported_as_never_sent() {
    let mut line = ConnectionFrames::new();
    line.connect_request();
    let events = report(&line).events;
    let [event] = &events[..] else { panic!("one event: {events:#?}") };
    assert!(event.text.contains("the capture has no answer"), "{}", event.text);
    assert!(!event.text.contains("No station"), "{}", event.text);
}

fn dcp(line: &mut ConnectionFrames, source: Mac, destination: Mac, pdu: &Dcp) -> usize {
    let mut frame = Vec::new();
    pdu.write_frame(destination, source, &mut frame);
    line.push(frame)
}

fn search(line: &mut ConnectionFrames, xid: u32, name: &[u8]) -> usize {
    dcp(line, CONTROLLER, DCP_MULTICAST, &Dcp::identify(xid, 1, vec![DcpValue::NameOfStation(name.to_vec())]))
}

/// A station answers an Identify of the controller with its name.
fn identified(line: &mut ConnectionFrames, xid: u32, station: Mac, name: &[u8]) -> usize {
    let response = Dcp::identify(xid, 1, vec![DcpValue::AllSelector])
        .response(vec![DcpBlock { word: Some(BlockInfo(0).0), value: DcpValue::NameOfStation(name.to_vec()) }]);
    dcp(line, station, CONTROLLER, &response)
}

#[test]
fn an_unanswered_name_is_mentioned_if_other_names_were_answered() {
    let searched = |others: bool, given: bool| {
        let mut line = ConnectionFrames::new();
        if others {
            search(&mut line, 1, b"enc-1");
            identified(&mut line, 1, DEVICE, b"enc-1");
        }
        search(&mut line, 2, b"enc-9");
        line.pass(Duration::from_secs(4));
        if given {
            // The search was a check whether the name is free before it is set.
            let word = Some(BlockQualifier::PERMANENT.0);
            let set = Dcp::set(7, vec![DcpBlock { word, value: DcpValue::NameOfStation(b"enc-9".to_vec()) }]);
            dcp(&mut line, CONTROLLER, DEVICE, &set);
        }
        line.cyclic(true, &[]);
        line
    };
    let finding = one(&searched(true, false), "PN-NAME-UNKNOWN");
    assert_eq!((finding.frame, finding.severity), (3, FindingSeverity::Info));
    assert!(finding.text.contains("once") && finding.text.contains("enc-9"), "{}", finding.text);
    assert_eq!(found(&searched(false, false), "PN-NAME-UNKNOWN"), []);
    assert_eq!(found(&searched(true, true), "PN-NAME-UNKNOWN"), []);
}

#[test]
fn a_duplicate_name_is_reported_with_both_frames() {
    let mut line = ConnectionFrames::new();
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
fn an_invalid_station_name_is_reported(#[case] name: &[u8], #[case] is_right: bool) {
    let mut line = ConnectionFrames::new();
    let frame = identified(&mut line, 1, DEVICE, name);
    identified(&mut line, 2, DEVICE, name);
    if is_right {
        assert_eq!(report(&line).findings, []);
        return;
    }
    let finding = one(&line, "PN-NAME-INVALID");
    assert_eq!(
        (finding.frame, finding.severity, finding.blame),
        (frame as u64, FindingSeverity::Warning, CaptureBlame::Controller)
    );
}

#[test]
fn a_name_padded_with_zeros_is_shortened() {
    let mut line = ConnectionFrames::new();
    identified(&mut line, 1, DEVICE, &[b"enc-1".to_vec(), vec![0; 200]].concat());
    let text = one(&line, "PN-NAME-INVALID").text;
    assert!(text.contains("'enc-1\\x00..'") && text.len() < 150, "{text}");
}

#[test]
fn a_diagnosis_in_a_record_is_reported() {
    let properties = ChannelProperties(0x0800);
    assert_eq!(properties.change(), ChannelChange::Appears);
    let entry = |error: u16| {
        let channel = ChannelDiagnosis { channel: 0x8000, properties, error_type: ChannelErrorType(error) };
        ExtChannelDiagnosis { channel, ext_error_type: 0x8000, add_value: 0 }
    };
    for (error, blame) in [(0x8001, CaptureBlame::Network), (0x0006, CaptureBlame::Device)] {
        let mut record = Vec::new();
        let (api, item) = (Some(0), AlarmItem::ExtChannel(vec![entry(error)]));
        DiagnosisData { api, slot: 0, subslot: 0x8001, channel: 0x8000, properties, item }.write(&mut record);
        let mut line = ConnectionFrames::new();
        let first = line.read(0x800C, Ok(&record), true);
        line.read(0x800C, Ok(&record), true);
        let finding = one(&line, "PN-ALARM-DIAGNOSIS");
        assert_eq!((finding.frame, finding.severity, finding.blame), (first as u64, FindingSeverity::Warning, blame));
        assert!(finding.text.contains("subslot 0x8001") && finding.text.contains("0x800C"), "{}", finding.text);
        assert_eq!(report(&line).findings.len(), 1);
        // A diagnosis record without entries, and a record that is no diagnosis record.
        let mut line = ConnectionFrames::new();
        line.read(0x800C, Ok(&[]), true);
        line.read(0xAFF0, Ok(&record), true);
        assert_eq!(report(&line).findings, []);
    }
}

#[test]
fn a_capture_without_profinet_is_an_error() {
    let of = |ether_type: [u8; 2]| {
        let mut line = ConnectionFrames::new();
        for _ in 0..5 {
            line.push([&DEVICE.0[..], &CONTROLLER.0, &ether_type, &[0; 46]].concat());
        }
        line
    };
    let finding = one(&of([0x86, 0xDD]), "PN-CAPTURE-NOTHING");
    assert_eq!((finding.severity, finding.blame), (FindingSeverity::Error, CaptureBlame::Capture));
    assert_eq!(found(&of([0x88, 0x92]), "PN-CAPTURE-NOTHING"), []);
}

/// Frame numbers are tshark's.
#[rstest]
#[case("record-reads.pcapng", &[("PN-ALARM-DIAGNOSIS", CaptureBlame::Network, 6), ("PN-ALARM-DIAGNOSIS", CaptureBlame::Network, 12)])]
#[case("odd-station-name.pcap", &[("PN-NAME-INVALID", CaptureBlame::Controller, 2)])]
#[case("one-ar-life.pcapng", &[("PN-START-MODULES", CaptureBlame::Controller, 2), ("PN-START-INCOMPLETE", CaptureBlame::Capture, 9)])]
fn third_party_captures(#[case] name: &str, #[case] expected: &[(&str, CaptureBlame, u64)]) {
    let Some(path) = testing::shared(&format!("captures/profinet/{name}")) else { return };
    let report = capture(name, &fs::read(path).unwrap()[..], &[]).unwrap();
    let findings: Vec<_> =
        report.findings.iter().map(|finding| (finding.id.as_str(), finding.blame, finding.frame)).collect();
    assert_eq!(findings, expected, "{:#?}", report.findings);
}
