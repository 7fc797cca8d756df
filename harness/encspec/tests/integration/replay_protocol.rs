//! Protocol checks on hand-made PROFINET frames: each check finds its fault, and has no finding for correct frames, also if the
//! capture starts in the middle, shows one side only, or has every frame twice.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::common::handmade::{self, CONTROLLER, CYCLE, ConnectionFrames, DEVICE, WATCHDOG};
use encspec::replay::{CaptureBlame, CaptureFinding, FindingSeverity, capture};
use rstest::rstest;
use station::Duration;
use std::fs;
use std::net::Ipv4Addr;
use wire::datagram::arp::Arp;
use wire::ethernet::Mac;
use wire::lldp::{Lldp, Tlv};
use wire::profinet::alarm::{RtaBody, RtaKind};
use wire::profinet::dcp::{BlockInfo, BlockQualifier, Dcp, DcpBlock, DcpValue};
use wire::profinet::rpc::Opnum;
use wire::profinet::rt::{ApduStatus, CyclicFrame, DataStatus, FrameId};
use wire::profinet::status::{AbortReason, CmrpcError, ErrorCode, ErrorSource, PnioStatus, RecordError};

const THIRD_PARTY: Mac = Mac([2, 0, 0, 0, 0, 9]);
const OTHER: Mac = Mac([2, 0, 0, 0, 1, 1]);

fn findings(line: &ConnectionFrames) -> Vec<CaptureFinding> {
    capture("made", &line.capture()[..], &[]).expect("a capture").findings
}

/// The consequences of the only finding with this id.
#[track_caller]
fn consequences_of(line: &ConnectionFrames, id: &str) -> Vec<CaptureFinding> {
    let all = findings(line);
    let [finding] = &all[..] else { panic!("one finding {id}: {all:#?}") };
    assert_eq!(finding.id, id, "{}", finding.text);
    finding.consequences.clone()
}

/// The ids of the findings with their frames.
fn ids_and_frames(line: &ConnectionFrames) -> Vec<(String, u64)> {
    findings(line).into_iter().map(|finding| (finding.id, finding.frame)).collect()
}

fn started() -> ConnectionFrames {
    let mut line = ConnectionFrames::new();
    line.start().exchange(20);
    line
}

#[track_caller]
fn only(line: &ConnectionFrames, id: &str, frame: usize) -> CaptureFinding {
    let all = findings(line);
    let [finding] = &all[..] else { panic!("one finding {id}: {all:#?}") };
    assert_eq!((finding.id.as_str(), finding.frame), (id, frame as u64), "{}", finding.text);
    assert!(finding.cause.is_some() && finding.next.is_some() && finding.context.at.is_some());
    finding.clone()
}

#[test]
fn a_connection_in_order_has_no_findings() {
    let mut line = started();
    line.write(&[(1, 2, 0xBF00, &[1, 2, 3])], false, &[PnioStatus::OK]);
    line.read(0xAFF0, Ok(&[1]), false);
    let alarm = line.alarm(0);
    assert!(alarm > 0);
    acknowledge(&mut line, 0);
    line.exchange(20).release();
    assert_eq!(ids_and_frames(&line), []);
}

/// The ACK of the transport, then the alarm acknowledgement of the application and the ACK of the device.
fn acknowledge(line: &mut ConnectionFrames, sequence: u16) {
    line.rta(false, RtaKind::ACK, 0xFFFF, RtaBody::Octets(Vec::new()));
    let notification = match &handmade::alarm(sequence) {
        RtaBody::Notification(notification) => notification.acknowledgement(PnioStatus::OK),
        _ => unreachable!(),
    };
    line.rta(false, RtaKind::DATA, 0, RtaBody::Acknowledgement(notification));
    line.rta(true, RtaKind::ACK, 0xFFFF, RtaBody::Octets(Vec::new()));
}

const OUT_OF_ARS: PnioStatus =
    PnioStatus::found(ErrorCode::CONNECT_RESPONSE, ErrorSource::CMRPC, CmrpcError::OUT_OF_AR_RESOURCES.0);

#[test]
fn repeated_refusals_are_reported_once_with_their_meaning() {
    let mut line = ConnectionFrames::new();
    let mut first = 0;
    for _ in 0..3 {
        line.connect_request();
        let frame = line.response(0, Opnum::CONNECT, OUT_OF_ARS, &[]);
        first = if first == 0 { frame } else { first };
        line.activity += 2;
    }
    let finding = only(&line, "PN-START-REFUSED", first);
    assert!(finding.text.contains("a further AR") && finding.text.contains("3 times"), "{}", finding.text);
    assert_eq!((finding.severity, finding.blame), (FindingSeverity::Error, CaptureBlame::Controller));
}

#[test]
fn an_unanswered_connect_is_reported_if_answers_are_captured() {
    let mut line = ConnectionFrames::new();
    line.read(0xAFF0, Ok(&[1]), true);
    let request = line.connect_request();
    line.pass(Duration::from_secs(10)).activity += 4;
    line.read(0xAFF0, Ok(&[1]), true);
    assert_eq!(ids_and_frames(&line), [], "a controller that does not repeat its request got the answer");

    let mut line = ConnectionFrames::new();
    line.read(0xAFF0, Ok(&[1]), true);
    assert_eq!(request, line.connect_request());
    line.again(Duration::from_millis(500));
    line.pass(Duration::from_secs(10)).activity += 4;
    line.read(0xAFF0, Ok(&[1]), true);
    assert_eq!(only(&line, "PN-START-UNANSWERED", request).blame, CaptureBlame::Network);
}

#[test]
fn answers_of_a_side_that_was_never_captured_are_not_missed() {
    let mut line = ConnectionFrames::new();
    let request = line.connect_request();
    line.pass(Duration::from_secs(3)).again(Duration::ZERO);
    line.pass(Duration::from_secs(10)).again(Duration::ZERO);
    let finding = only(&line, "PN-CAPTURE-ONE-SIDED", request);
    assert_eq!((finding.severity, finding.blame), (FindingSeverity::Info, CaptureBlame::Capture));
}

#[test]
fn an_incomplete_start_up_names_the_missing_step() {
    let mut line = ConnectionFrames::new();
    line.connect_request();
    line.connect_response();
    line.end_parameters();
    line.pass(Duration::from_secs(20));
    line.abort(false, PnioStatus::abort(AbortReason::APPLICATION_READY_TIMEOUT));
    let all = findings(&line);
    let finding = all.iter().find(|finding| finding.id == "PN-START-INCOMPLETE").unwrap();
    assert_eq!((finding.blame, finding.expected.as_deref()), (CaptureBlame::Device, Some("ApplicationReady")));
    let followed = &finding.consequences[..];
    assert!(matches!(followed, [of] if of.id == "PN-ABORT" && of.blame == CaptureBlame::Device), "{all:#?}");
}

#[test]
fn a_slow_start_up_and_a_wrong_order_are_reported() {
    let mut line = ConnectionFrames::new();
    line.connect_request();
    line.connect_response();
    line.end_parameters();
    let ready = line.pass(Duration::from_secs(8)).ready();
    let finding = only(&line, "PN-START-SLOW", ready);
    assert_eq!((finding.blame, finding.severity), (CaptureBlame::Device, FindingSeverity::Info));

    let mut line = ConnectionFrames::new();
    line.connect_request();
    line.connect_response();
    let ready = line.ready();
    line.pass(Duration::from_millis(5)).end_parameters();
    assert_eq!(ids_and_frames(&line), [("PN-START-ORDER".to_owned(), ready as u64)]);
}

#[test]
fn an_unanswered_call_is_reported() {
    let mut line = started();
    let request = line.request(0, Opnum::READ, &read_blocks());
    for _ in 0..2 {
        line.pass(Duration::from_micros(100)).again(Duration::from_millis(2));
    }
    line.exchange(2);
    let finding = only(&line, "PN-CALL-UNANSWERED", request);
    assert!(finding.text.contains("Read") && finding.text.contains("repeated 2 times"), "{}", finding.text);
}

fn read_blocks() -> Vec<u8> {
    use wire::profinet::blocks::record::{ReadRequest, RecordHeader};
    let header =
        RecordHeader { ar_uuid: handmade::AR, slot_number: 1, subslot_number: 2, index: 1, ..Default::default() };
    let mut blocks = Vec::new();
    ReadRequest { header, ..Default::default() }.write(&mut blocks);
    blocks
}

#[test]
fn refused_records_are_reported_with_their_meaning() {
    let refused = PnioStatus::record(ErrorCode::WRITE_RESPONSE, RecordError::WRITE_LENGTH_ERROR);
    let mut line = ConnectionFrames::new();
    line.connect_request();
    line.connect_response();
    let frame = line.write(&[(1, 2, 0xBF00, &[1, 2, 3])], false, &[refused]);
    line.end_parameters();
    line.ready();
    line.exchange(20);
    let finding = only(&line, "PN-RECORD-REFUSED", frame);
    assert!(finding.text.contains("0xBF00") && finding.text.contains("length"), "{}", finding.text);
    assert_eq!(finding.severity, FindingSeverity::Warning);
}

/// A connection in which frames of one side or of both sides are missing.
fn with_a_gap(by_device: bool, both: bool, cycles: u16) -> ConnectionFrames {
    let mut line = started();
    for _ in 0..cycles {
        if !both {
            line.cyclic(!by_device, &[]);
        } else {
            line.counter[usize::from(!by_device)] = line.counter[usize::from(!by_device)].wrapping_add(64);
        }
        line.counter[usize::from(by_device)] = line.counter[usize::from(by_device)].wrapping_add(64);
        line.pass(CYCLE);
    }
    line.exchange(20);
    line
}

#[rstest]
#[case::of_one_side(true, false, 2, "PN-CYCLE-LOST", CaptureBlame::Network)]
#[case::of_the_controller(false, false, 2, "PN-CYCLE-LOST", CaptureBlame::Network)]
#[case::of_both_is_the_capture(true, true, 2, "PN-CAPTURE-GAP", CaptureBlame::Capture)]
fn missing_frames_are_blamed_on_the_network_or_the_capture(
    #[case] by_device: bool,
    #[case] both: bool,
    #[case] cycles: u16,
    #[case] id: &str,
    #[case] blame: CaptureBlame,
) {
    let all = findings(&with_a_gap(by_device, both, cycles));
    assert!(!all.is_empty() && all.iter().all(|finding| finding.id == id && finding.blame == blame), "{all:#?}");
}

/// A gap that both directions have, and one that only the device has: each is blamed for itself.
#[test]
fn a_gap_of_the_capture_does_not_make_another_gap_worse() {
    let mut line = with_a_gap(true, true, 2);
    line.counter[1] = line.counter[1].wrapping_add(64);
    line.cyclic(false, &[]);
    line.pass(CYCLE).exchange(20);
    let all = findings(&line);
    let found: Vec<_> = all.iter().map(|finding| (finding.id.as_str(), finding.severity, finding.blame)).collect();
    let by_capture = ("PN-CAPTURE-GAP", FindingSeverity::Info, CaptureBlame::Capture);
    let on_the_network = ("PN-CYCLE-LOST", FindingSeverity::Info, CaptureBlame::Network);
    assert_eq!(found, [by_capture, by_capture, on_the_network], "{all:#?}");
    assert!(all[2].text.starts_with("1 of "), "{}", all[2].text);
}

/// A connection, and beside it a stream without a Connect, whose frames begin with these addresses. Frames of it and of one side of the
/// connection are missing at the same time.
fn beside_a_stream(by_device: bool, addresses: &[u8]) -> Vec<CaptureFinding> {
    let mut line = started();
    for cycle in 0..80u16 {
        line.cyclic(!by_device, &[]);
        if (40..42).contains(&cycle) {
            let counter = &mut line.counter[usize::from(by_device)];
            *counter = counter.wrapping_add(64);
        } else {
            line.cyclic(by_device, &[]);
            let mut other = handmade::cyclic(by_device, cycle.wrapping_mul(64), &[]);
            other[..addresses.len()].copy_from_slice(addresses);
            line.push(other);
        }
        line.pass(CYCLE);
    }
    findings(&line)
}

#[test]
fn gaps_of_a_connection_and_of_a_stream_without_a_connect_are_compared() {
    let all = beside_a_stream(true, &[2, 0, 0, 0, 0xAA, 1, 2, 0, 0, 0, 0xAA, 2]);
    let is_of_capture = |finding: &CaptureFinding| finding.id == "PN-CAPTURE-GAP";
    assert!(all.len() == 2 && all.iter().all(is_of_capture), "{all:#?}");
}

/// A controller pauses toward two devices; what they send goes on.
#[test]
fn a_controller_that_pauses_is_no_gap_of_the_capture() {
    let all = beside_a_stream(false, &[2, 0, 0, 0, 0xAA, 1]);
    let found: Vec<_> = all.iter().map(|finding| (finding.id.as_str(), finding.blame)).collect();
    assert_eq!(found, [("PN-CYCLE-LOST", CaptureBlame::Undecided); 2], "{all:#?}");
    assert!(all[0].text.contains("only other streams of this station have gaps then"), "{}", all[0].text);
}

#[test]
fn a_silent_device_is_distinguished_from_a_gap_in_the_capture() {
    let mut line = started();
    for _ in 0..10 {
        line.cyclic(false, &[]);
        line.pass(CYCLE);
    }
    line.abort(false, PnioStatus::abort(AbortReason::CONSUMER_TIMEOUT));
    let all = findings(&line);
    let silent = all.iter().find(|finding| finding.id == "PN-CYCLE-SILENT").unwrap_or_else(|| panic!("{all:#?}"));
    assert_eq!((silent.blame, silent.severity), (CaptureBlame::Undecided, FindingSeverity::Error));
    let followed = &silent.consequences[..];
    assert!(matches!(followed, [of] if of.id == "PN-ABORT" && of.blame == CaptureBlame::Undecided), "{all:#?}");

    // Both directions pause for a second, and their counters go on with the time.
    let mut line = started();
    line.counter = line.counter.map(|counter| counter.wrapping_add(500 * 64));
    line.pass(Duration::from_secs(1)).exchange(20);
    let all = findings(&line);
    assert!(all.iter().all(|finding| finding.blame == CaptureBlame::Capture), "{all:#?}");
    assert!(all.iter().any(|finding| finding.id == "PN-CAPTURE-GAP" && finding.severity == FindingSeverity::Warning));
}

/// The capture lacks the frames of both sides for a while. Those after it have the agreed length, though they are not judged.
#[test]
fn frames_after_a_gap_are_not_unacceptable() {
    let mut line = started();
    line.counter = line.counter.map(|counter| counter.wrapping_add(10 * 64));
    line.pass(CYCLE * 10).exchange(5);
    line.abort(false, PnioStatus::abort(AbortReason::CONSUMER_TIMEOUT));
    let all = findings(&line);
    let flat: Vec<&CaptureFinding> = all.iter().flat_map(|of| [of].into_iter().chain(&of.consequences)).collect();
    let abort = flat.iter().find(|finding| finding.id == "PN-ABORT").unwrap_or_else(|| panic!("{all:#?}"));
    assert!(abort.text.contains("come again after a silence"), "{}", abort.text);
    assert!(flat.iter().all(|finding| finding.blame != CaptureBlame::Device), "{all:#?}");
}

#[test]
fn a_one_sided_capture_has_one_finding() {
    let mut line = ConnectionFrames::new();
    line.start();
    let first = line.cyclic(false, &[]);
    for _ in 0..20 {
        line.pass(CYCLE).cyclic(false, &[]);
    }
    assert_eq!(only(&line, "PN-CAPTURE-ONE-SIDED", first).severity, FindingSeverity::Info);
}

#[test]
fn a_stuck_cycle_counter_is_blamed_on_the_sender() {
    let mut line = ConnectionFrames::new();
    line.start();
    let mut frames = Vec::new();
    for _ in 0..10 {
        line.cyclic(false, &[]);
        frames.push(line.push(handmade::cyclic(true, 640, &[])));
        line.pass(CYCLE);
    }
    assert_eq!(only(&line, "PN-CYCLE-COUNTER", frames[1]).blame, CaptureBlame::Device);
}

/// A cyclic frame of the device with another data status or other data.
fn frame_with(line: &mut ConnectionFrames, status: DataStatus, data: &[u8]) -> usize {
    line.counter[1] = line.counter[1].wrapping_add(64);
    let whole = handmade::cyclic(true, line.counter[1], data);
    let (head, payload) = whole.split_at(18);
    let mut area = CyclicFrame::parse(payload, 40).unwrap().data.to_vec();
    area[..data.len()].copy_from_slice(data);
    let status = ApduStatus { cycle_counter: line.counter[1], data_status: status, transfer_status: 0 };
    let mut frame = head.to_vec();
    CyclicFrame { frame_id: FrameId(handmade::FRAME_ID), data: &area, status, padding: &[] }.write(&mut frame);
    line.push(frame)
}

#[rstest]
#[case::stop(0x25, &[0x80], "PN-STATUS-STOP", 4)]
#[case::problem(0x15, &[0x80], "PN-STATUS-PROBLEM", 5)]
#[case::invalid(0x31, &[0x80], "PN-STATUS-INVALID", 2)]
#[case::bad_provider(0x35, &[0x80, 1, 2, 3, 4, 0x00], "PN-STATUS-BAD-PROVIDER", 7)]
#[case::bad_consumer(0x35, &[0x80, 1, 2, 3, 4, 0x80, 0x00], "PN-STATUS-BAD-CONSUMER", 7)]
fn the_status_of_the_data_is_reported(#[case] status: u8, #[case] data: &[u8], #[case] id: &str, #[case] bit: u8) {
    let mut line = started();
    let frame = frame_with(&mut line, DataStatus(status), data);
    line.cyclic(false, &[]);
    line.pass(CYCLE);
    let mut alone = ConnectionFrames {
        frames: line.frames.clone(),
        now: line.now,
        counter: line.counter,
        ..ConnectionFrames::new()
    };
    let odd = [("PN-CAPTURE-ODD-FRAME".to_owned(), frame as u64)];
    assert_eq!(ids_and_frames(alone.exchange(20)), odd, "a single frame may be damaged");
    frame_with(&mut line, DataStatus(status), data);
    line.cyclic(false, &[]);
    line.pass(CYCLE).exchange(20);
    let finding = only(&line, id, frame);
    let blame = if id == "PN-STATUS-PROBLEM" { CaptureBlame::Undecided } else { CaptureBlame::Device };
    assert_eq!((finding.blame, finding.severity, finding.bit), (blame, FindingSeverity::Warning, Some(bit)));
    // 14 bytes of Ethernet header, 4 of the tag, 2 of the frame id.
    let expected = match id {
        "PN-STATUS-BAD-PROVIDER" => 20 + 5,
        "PN-STATUS-BAD-CONSUMER" => 20 + 6,
        _ => 20 + 40 + 2,
    };
    assert_eq!(finding.octet, Some(expected));
}

#[test]
fn a_normal_end_is_only_information() {
    let mut line = started();
    line.release();
    let frame = line.abort(true, PnioStatus::abort(AbortReason::RELEASE_RECEIVED));
    assert_eq!(only(&line, "PN-ABORT", frame).severity, FindingSeverity::Info);
}

#[test]
fn an_unacknowledged_alarm_is_reported() {
    let mut line = started();
    let alarm = line.alarm(0);
    let frame = line.frames.last().unwrap().1.clone();
    for _ in 0..3 {
        line.exchange(50).push(frame.clone());
    }
    line.exchange(1_500);
    let all = findings(&line);
    let finding =
        all.iter().find(|finding| finding.id == "PN-ALARM-UNACKNOWLEDGED").unwrap_or_else(|| panic!("{all:#?}"));
    assert_eq!((finding.frame, finding.blame), (alarm as u64, CaptureBlame::Controller));
}

/// The frame ID of low alarms is 0xFE01 and that of high ones 0xFC01 (IEC 61158-6-10).
#[test]
fn an_alarm_of_two_priorities_is_reported() {
    let mut line = started();
    let alarm = line.alarm(0);
    let frame = &mut line.frames.last_mut().expect("the alarm").1;
    let at = frame.windows(2).position(|id| id == [0xFE, 0x01]).expect("its frame ID");
    frame[at] = 0xFC;
    line.exchange(10);
    let finding = only(&line, "PN-ALARM-PRIORITY", alarm);
    assert_eq!((finding.severity, finding.blame), (FindingSeverity::Warning, CaptureBlame::Device));
    assert!(
        finding.text.contains("sends 1 alarm with the frame ID of high and the block of low priority"),
        "{}",
        finding.text
    );
}

fn dcp(line: &mut ConnectionFrames, source: Mac, destination: Mac, pdu: &Dcp) -> usize {
    let mut frame = Vec::new();
    pdu.write_frame(destination, source, &mut frame);
    line.push(frame)
}

/// A station answers an Identify of the controller with its name.
fn identified(line: &mut ConnectionFrames, xid: u32, station: Mac, name: &[u8]) -> usize {
    let response = Dcp::identify(xid, 1, vec![DcpValue::AllSelector])
        .response(vec![DcpBlock { word: Some(BlockInfo(0).0), value: DcpValue::NameOfStation(name.to_vec()) }]);
    dcp(line, station, CONTROLLER, &response)
}

#[test]
fn a_duplicate_name_is_reported_but_not_a_replaced_device() {
    let mut line = ConnectionFrames::new();
    identified(&mut line, 1, DEVICE, b"enc-1");
    let second = identified(&mut line, 1, OTHER, b"enc-1");
    assert_eq!(only(&line, "PN-NAME-DUPLICATE", second).blame, CaptureBlame::Network);

    let mut line = ConnectionFrames::new();
    identified(&mut line, 1, DEVICE, b"enc-1");
    line.pass(Duration::from_secs(60));
    identified(&mut line, 2, OTHER, b"enc-1");
    assert_eq!(ids_and_frames(&line), []);
    identified(&mut line, 3, DEVICE, b"enc-2");
    assert_eq!(ids_and_frames(&line), []);
}

#[test]
fn a_duplicate_ip_address_is_reported() {
    let ip = Ipv4Addr::new(192, 168, 0, 10);
    let mut line = ConnectionFrames::new();
    for (mac, pause) in [(DEVICE, 0), (OTHER, 1)] {
        let request = Arp::request(CONTROLLER, Ipv4Addr::new(192, 168, 0, 1), ip);
        let mut frame = Vec::new();
        request.reply(mac).write_frame(&mut frame);
        line.pass(Duration::from_millis(pause)).push(frame);
    }
    assert_eq!(only(&line, "PN-ADDRESS-DUPLICATE", 2).severity, FindingSeverity::Error);
}

#[test]
fn an_unknown_name_is_reported_if_answers_are_captured() {
    let mut line = ConnectionFrames::new();
    let search = |line: &mut ConnectionFrames, xid| {
        let pdu = Dcp::identify(xid, 1, vec![DcpValue::NameOfStation(b"enc-9".to_vec())]);
        let frame = dcp(line, CONTROLLER, Mac([0x01, 0x0E, 0xCF, 0, 0, 0]), &pdu);
        line.pass(Duration::from_secs(4));
        frame
    };
    let first = search(&mut line, 1);
    search(&mut line, 2);
    line.alarm(0);
    assert_eq!(ids_and_frames(&line), [("PN-NAME-UNKNOWN".to_owned(), first as u64)]);

    let mut line = ConnectionFrames::new();
    let first = search(&mut line, 1);
    search(&mut line, 2);
    search(&mut line, 3);
    line.pass(Duration::from_secs(4)).cyclic(false, &[]);
    assert_eq!(ids_and_frames(&line), [("PN-CAPTURE-ONE-SIDED".to_owned(), first as u64)]);
}

#[rstest]
#[case::name(DcpValue::NameOfStation(b"other".to_vec()), THIRD_PARTY, "PN-SET-RUNNING")]
#[case::reset(DcpValue::ResetToFactory, THIRD_PARTY, "PN-RESET-RUNNING")]
#[case::by_its_own_controller(DcpValue::NameOfStation(b"other".to_vec()), CONTROLLER, "")]
fn a_third_party_that_changes_a_connected_station_is_reported(
    #[case] value: DcpValue,
    #[case] by: Mac,
    #[case] id: &str,
) {
    let mut line = started();
    let word = Some(BlockQualifier::PERMANENT.0 | 4);
    let frame = dcp(&mut line, by, DEVICE, &Dcp::set(7, vec![DcpBlock { word, value: value.clone() }]));
    line.exchange(5);
    match id {
        "" => assert_eq!(ids_and_frames(&line), []),
        id => assert_eq!(only(&line, id, frame).blame, CaptureBlame::Network),
    }
    // The following abort names the third party.
    if !id.is_empty() {
        line.abort(true, PnioStatus::abort(AbortReason::STATION_NAME_CHANGED));
        let followed = consequences_of(&line, id);
        assert!(matches!(&followed[..], [of] if of.id == "PN-ABORT" && of.text.contains(&THIRD_PARTY.to_string())));
    }
}

#[test]
fn a_lost_neighbour_is_reported() {
    let announced = |line: &mut ConnectionFrames, port: Mac, name: &str| {
        let tlvs = vec![
            Tlv::ChassisId { subtype: 7, id: name.into() },
            Tlv::PortId { subtype: 7, id: b"port-001".to_vec() },
            Tlv::TimeToLive(20),
        ];
        let mut frame = Vec::new();
        Lldp { tlvs }.write_frame(port, &mut frame);
        line.push(frame)
    };
    let mut line = ConnectionFrames::new();
    let mut last = 0;
    for round in 0..20 {
        if round < 5 {
            last = announced(&mut line, DEVICE, "enc-1");
        }
        announced(&mut line, CONTROLLER, "controller-1");
        line.pass(Duration::from_secs(5));
    }
    let text = only(&line, "PN-TOPOLOGY-CHANGED", last).text;
    assert!(text.contains("enc-1") && text.contains("no longer announced"), "{text}");
}

/// Every frame twice, as from a mirror port, and each side alone: there are no additional findings.
#[test]
fn mirrored_and_one_sided_captures_have_no_additional_findings() {
    let mut line = started();
    line.write(&[(1, 2, 0xBF00, &[1, 2, 3])], false, &[PnioStatus::OK]);
    line.alarm(0);
    acknowledge(&mut line, 0);
    line.exchange(20).release();
    line.pass(Duration::from_secs(20)).read(0xAFF0, Ok(&[1]), true);
    assert_eq!(ids_and_frames(&line), []);

    let mut doubled = ConnectionFrames::new();
    for (time, frame) in &line.frames {
        doubled.frames.push((*time, frame.clone()));
        doubled.frames.push((*time + Duration::from_micros(2), frame.clone()));
    }
    assert_eq!(ids_and_frames(&doubled), []);

    for of_device in [true, false] {
        let mut half = ConnectionFrames::new();
        let source = if of_device { DEVICE } else { CONTROLLER };
        half.frames = line.frames.iter().filter(|(_, frame)| frame[6..12] == source.0).cloned().collect();
        let all = findings(&half);
        assert!(
            all.iter()
                .all(|finding| finding.blame == CaptureBlame::Capture && finding.severity == FindingSeverity::Info),
            "{all:#?}"
        );
    }
    for from in 1..line.frames.len() {
        let mut late = ConnectionFrames::new();
        late.frames = line.frames[from..].to_vec();
        let all = findings(&late);
        assert!(all.iter().all(|finding| finding.severity == FindingSeverity::Info), "from frame {from}: {all:#?}");
    }
}

#[test]
fn the_watchdog_time_comes_from_the_connect() {
    let mut line = started();
    line.pass(WATCHDOG - CYCLE).exchange(5);
    let all = findings(&line);
    assert!(all.iter().all(|finding| finding.id != "PN-CYCLE-SILENT"), "{all:#?}");
}

/// Id, severity and frame of the findings in third-party captures. Frame numbers are tshark's.
#[rstest]
#[case("duplicate-station-name.pcap", &[("PN-NAME-DUPLICATE", FindingSeverity::Error, 19)])]
#[case("one-ar-life.pcapng", &[("PN-START-MODULES", FindingSeverity::Warning, 2), ("PN-START-INCOMPLETE", FindingSeverity::Info, 9)])]
#[case("office-noise-versamax.pcap", &[("PN-START-MODULES", FindingSeverity::Warning, 18), ("PN-START-INCOMPLETE", FindingSeverity::Info, 27),
    ("PN-CAPTURE-ONE-SIDED", FindingSeverity::Info, 58), ("PN-NAME-UNKNOWN", FindingSeverity::Info, 467), ("PN-NAME-UNKNOWN", FindingSeverity::Info, 469),
    ("PN-START-MODULES", FindingSeverity::Warning, 489), ("PN-ABORT", FindingSeverity::Info, 584)])]
#[case("record-reads.pcapng", &[("PN-ALARM-DIAGNOSIS", FindingSeverity::Warning, 6),
    ("PN-ALARM-DIAGNOSIS", FindingSeverity::Warning, 12)])]
#[case("implicit-reads-ns.pcapng", &[])]
#[case("odd-station-name.pcap", &[("PN-NAME-INVALID", FindingSeverity::Warning, 2)])]
#[case("dcp-name-ip-reset.pcap", &[])]
#[case("zero-timestamps.pcap", &[])]
fn third_party_captures(#[case] name: &str, #[case] expected: &[(&str, FindingSeverity, u64)]) {
    let Some(path) = testing::shared(&format!("captures/profinet/{name}")) else { return };
    let report = capture(name, &fs::read(path).unwrap()[..], &[]).unwrap();
    let findings: Vec<_> =
        report.findings.iter().map(|finding| (finding.id.as_str(), finding.severity, finding.frame)).collect();
    assert_eq!(findings, expected, "{:#?}", report.findings);
}

/// The 40 bytes of data of an XAC77 frame with telegram 81 in the usual layout: IOPS of access point and parameter access point, the
/// data, and its status bytes.
fn frame_of_telegram_81(data: &[u8]) -> Vec<u8> {
    let mut octets = vec![0x80, 0x80];
    octets.extend(data);
    octets.extend([0x80, 0x80]);
    octets.resize(40, 0);
    octets
}

/// ZSW2_ENC, G1_ZSW, G1_XIST1, G1_XIST2.
fn inputs_of_telegram_81(g1_zsw: u16) -> Vec<u8> {
    let mut data = vec![0, 0];
    data.extend(g1_zsw.to_be_bytes());
    data.extend([0, 0, 0, 77, 0, 0, 0, 77]);
    frame_of_telegram_81(&data)
}

/// A capture that starts during data exchange; `ids` are vendor and device ID that the device reports by DCP.
fn running(ids: Option<(u16, u16)>) -> ConnectionFrames {
    let mut line = ConnectionFrames::new();
    if let Some((vendor_id, device_id)) = ids {
        let response = Dcp::identify(1, 1, vec![DcpValue::AllSelector]).response(vec![DcpBlock {
            word: Some(BlockInfo(0).0),
            value: DcpValue::DeviceId { vendor_id, device_id },
        }]);
        dcp(&mut line, DEVICE, CONTROLLER, &response);
    }
    for _ in 0..40 {
        line.cyclic(false, &frame_of_telegram_81(&[0; 4]));
        line.cyclic(true, &inputs_of_telegram_81(0x2000));
        line.pass(CYCLE);
    }
    line
}

#[rstest]
#[case::by_its_dcp_answer(Some((0x0239, 0x0001)), None, true)]
#[case::unknown_device(None, None, false)]
#[case::named_by_the_user(None, Some("lika-xac77-profinet"), true)]
#[case::another_device(Some((0x0239, 0x0002)), Some("lika-xac77-profinet"), false)]
fn without_a_connect_the_layout_is_guessed_and_marked(
    #[case] ids: Option<(u16, u16)>,
    #[case] manual: Option<&str>,
    #[case] guessed: bool,
) {
    let manuals = encspec::suite_yaml::load(&encspec::suites::sources(), manual).expect("the shipped suites load");
    let mut line = running(ids);
    let fine = capture("fine", &line.capture()[..], &manuals).unwrap();
    assert_eq!(fine.findings, []);
    let layout = fine.ars.first().and_then(|ar| ar.layout.as_deref());
    assert_eq!(layout.is_some_and(|layout| layout.contains("lika-xac77-profinet")), guessed, "{layout:?}");

    // Bit 13 (position transmitted) together with bit 15 (sensor error).
    let frame = line.cyclic(true, &inputs_of_telegram_81(0xA000)) as u64;
    let broken = capture("broken", &line.capture()[..], &manuals).unwrap();
    let finding = broken.findings.iter().find(|finding| finding.id.contains("XAC77-SIG-036"));
    assert_eq!(finding.is_some(), guessed, "{:#?}", broken.findings);
    if let Some(finding) = finding {
        assert_eq!((finding.frame, finding.severity), (frame, FindingSeverity::Warning));
        assert!(finding.text.contains("guessed"), "{}", finding.text);
    }
}

/// The device says only at the end which one it is: the file is read again, and its manual holds from the first frame on.
#[test]
fn an_identity_at_the_end_holds_for_the_whole_capture() {
    let manuals = encspec::suite_yaml::load(&encspec::suites::sources(), None).expect("the shipped suites load");
    let mut line = running(None);
    let frame = line.cyclic(true, &inputs_of_telegram_81(0xA000)) as u64;
    let identity = DcpValue::DeviceId { vendor_id: 0x0239, device_id: 0x0001 };
    let block = DcpBlock { word: Some(BlockInfo(0).0), value: identity };
    let response = Dcp::identify(1, 1, vec![DcpValue::AllSelector]).response(vec![block]);
    dcp(&mut line, DEVICE, CONTROLLER, &response);
    let folder = testing::Folder::new("late-identity");
    let file = folder.write("late.pcapng", line.capture());
    let report = encspec::replay::files(&[file.to_string_lossy().into_owned()], &manuals).unwrap().captures.remove(0);
    let finding = report.findings.iter().find(|finding| finding.id.contains("XAC77-SIG-036"));
    assert_eq!(finding.map(|finding| finding.frame), Some(frame), "{:#?}", report.findings);
    let page = encspec::replay::chapter(1, &report, &line.capture()[..], &manuals).unwrap();
    assert_eq!(page.timelines.len(), 1);
}

/// The HTML page uses the guessed layout of the report: the connection has a timeline with signals.
#[test]
fn a_guessed_layout_is_on_the_page_as_well() {
    let manual = Some("lika-xac77-profinet");
    let manuals = encspec::suite_yaml::load(&encspec::suites::sources(), manual).expect("the shipped suites load");
    let mut line = running(Some((0x0239, 0x0001)));
    line.cyclic(true, &inputs_of_telegram_81(0xA000));
    let octets = line.capture();
    let report = capture("broken", &octets[..], &manuals).unwrap();
    let chapter = encspec::replay::chapter(1, &report, &octets[..], &manuals).unwrap();

    let [timeline] = &chapter.timelines[..] else { panic!("one timeline: {:#?}", chapter.timelines) };
    assert!(timeline.lanes.iter().any(|lane| lane.name.starts_with("G1_ZSW.")), "{:#?}", timeline.lanes);
    assert!(timeline.marks.iter().any(|mark| mark.text.contains("XAC77-SIG-036")), "{:#?}", timeline.marks);
    let entry = chapter.entries.iter().find(|entry| entry.head.contains("XAC77-SIG-036")).unwrap();
    let packet = entry.packet.as_ref().unwrap();
    assert!(packet.parts.iter().any(|part| part.name == "G1_ZSW"), "{:#?}", packet.parts);
}
