//! Who is to blame, and what the frames really show: aborts, deliberate ends, silences, odd frames, damage, status, and bad answers.
//!
//! Each fault has a counterpart without it that stays quiet.

use crate::handmade::{self, CONTROLLER, CYCLE, ConnectionFrames, DEVICE, WATCHDOG};
use encspec_replay::{CaptureBlame, CaptureFinding, CaptureReport, FindingSeverity, capture};
use rstest::rstest;
use station::{Duration, Time};
use std::net::Ipv4Addr;
use virtual_wire::PcapngWriter;
use virtual_wire::capture::LinkType;
use wire::datagram::arp::Arp;
use wire::ethernet::Mac;
use wire::profinet::alarm::{AlarmType, RtaBody, RtaKind};
use wire::profinet::blocks::connect::ArType;
use wire::profinet::dcp::{BlockInfo, Dcp, DcpBlock, DcpValue};
use wire::profinet::rpc::{Opnum, Uuid};
use wire::profinet::rt::{ApduStatus, CyclicFrame, DataStatus, FrameId};
use wire::profinet::status::{AbortReason, ErrorCode, ErrorSource, PnioStatus};

const THIRD_PARTY: Mac = Mac([2, 0, 0, 0, 0, 9]);
const ADDRESS: Ipv4Addr = Ipv4Addr::new(192, 168, 0, 10);

fn replayed(line: &ConnectionFrames) -> CaptureReport {
    capture("made", &line.capture()[..], &[]).expect("a capture")
}

fn findings(line: &ConnectionFrames) -> Vec<CaptureFinding> {
    replayed(line).findings
}

#[track_caller]
fn only(line: &ConnectionFrames, id: &str) -> CaptureFinding {
    let all = findings(line);
    let [finding] = &all[..] else { panic!("one finding {id}: {all:#?}") };
    assert_eq!(finding.id, id, "{}", finding.text);
    finding.clone()
}

#[track_caller]
fn one_of(line: &ConnectionFrames, id: &str) -> CaptureFinding {
    let all = findings(line);
    let nested: Vec<&CaptureFinding> = all.iter().flat_map(|of| [of].into_iter().chain(&of.consequences)).collect();
    let found: Vec<&&CaptureFinding> = nested.iter().filter(|finding| finding.id == id).collect();
    let [finding] = &found[..] else { panic!("one finding {id}: {all:#?}") };
    (**finding).clone()
}

fn started() -> ConnectionFrames {
    let mut line = ConnectionFrames::new();
    line.start().exchange(40);
    line
}

/// A cyclic frame of the device with this status; `step` is added to its cycle counter.
fn frame_of_device(line: &mut ConnectionFrames, status: u8, transfer_status: u8, step: u16) -> usize {
    line.counter[1] = line.counter[1].wrapping_add(step);
    let whole = handmade::cyclic(true, line.counter[1], &[]);
    let (head, payload) = whole.split_at(18);
    let area = CyclicFrame::parse(payload, 40).unwrap().data.to_vec();
    let status = ApduStatus { cycle_counter: line.counter[1], data_status: DataStatus(status), transfer_status };
    let mut frame = head.to_vec();
    CyclicFrame { frame_id: FrameId(handmade::FRAME_ID), data: &area, status, padding: &[] }.write(&mut frame);
    line.push(frame)
}

/// Cycles in which the device's frames have this status and step of the counter.
fn cycles_of(line: &mut ConnectionFrames, cycles: usize, status: u8, transfer_status: u8, step: u16) {
    for _ in 0..cycles {
        line.cyclic(false, &[]);
        frame_of_device(line, status, transfer_status, step);
        line.pass(CYCLE - Duration::from_micros(20));
    }
}

const TIMEOUT: PnioStatus = PnioStatus::abort(AbortReason::CONSUMER_TIMEOUT);
const GOOD: u8 = 0x35;

#[test]
fn a_watchdog_that_expired_although_the_frames_are_there_is_undecided() {
    let mut line = started();
    line.abort(false, TIMEOUT);
    let finding = only(&line, "PN-ABORT");
    assert_eq!(
        (finding.blame, finding.severity),
        (CaptureBlame::Undecided, FindingSeverity::Error),
        "{}",
        finding.text
    );
    assert!(finding.text.contains("or the receiver, undecided"), "{}", finding.text);
    assert!(finding.next.is_some_and(|next| next.contains("port of the receiver")));
}

#[rstest]
#[case::invalid_data(0x31, 0, 64, "invalid")]
#[case::transfer_status(GOOD, 1, 64, "TransferStatus")]
#[case::counter(GOOD, 0, 0, "cycle counter")]
fn frames_that_no_receiver_accepts_are_blamed_on_their_sender(
    #[case] status: u8,
    #[case] transfer_status: u8,
    #[case] step: u16,
    #[case] why: &str,
) {
    let mut line = started();
    cycles_of(&mut line, 8, status, transfer_status, step);
    line.abort(false, TIMEOUT);
    let finding = one_of(&line, "PN-ABORT");
    assert_eq!(finding.blame, CaptureBlame::Device, "{}", finding.text);
    assert!(finding.text.contains(why), "{}", finding.text);

    // One such frame right before the abort proves nothing.
    let mut line = started();
    cycles_of(&mut line, 1, status, transfer_status, step);
    line.abort(false, TIMEOUT);
    assert_eq!(one_of(&line, "PN-ABORT").blame, CaptureBlame::Undecided);
}

#[test]
fn frames_that_are_missing_are_blamed_on_neither_side() {
    for by_device in [false, true] {
        let mut line = started();
        for _ in 0..8 {
            line.cyclic(by_device, &[]);
            line.pass(CYCLE);
        }
        line.abort(by_device, TIMEOUT);
        let finding = only(&line, "PN-CYCLE-SILENT");
        assert_eq!((finding.blame, finding.severity), (CaptureBlame::Undecided, FindingSeverity::Error));
    }
}

/// ARP that says where an address is, in a frame of `source`.
fn arp(line: &mut ConnectionFrames, source: Mac, claimed: Mac) -> usize {
    let request = Arp::request(CONTROLLER, Ipv4Addr::new(192, 168, 0, 1), ADDRESS);
    let mut frame = Vec::new();
    request.reply(claimed).write_frame(&mut frame);
    frame[6..12].copy_from_slice(&source.0);
    line.push(frame)
}

#[test]
fn forged_and_duplicate_arp_and_floods_are_named_beside_the_abort() {
    let mut line = started();
    let first = arp(&mut line, THIRD_PARTY, DEVICE);
    line.exchange(3);
    line.abort(false, TIMEOUT);
    let finding = only(&line, "PN-ADDRESS-FORGED");
    assert_eq!((finding.frame, finding.blame), (first as u64, CaptureBlame::Network));
    let [abort] = &finding.consequences[..] else { panic!("{finding:#?}") };
    assert!(abort.text.contains(&format!("{THIRD_PARTY} sends ARP in the name of {DEVICE}")), "{}", abort.text);

    let mut line = started();
    arp(&mut line, DEVICE, DEVICE);
    arp(&mut line, THIRD_PARTY, THIRD_PARTY);
    line.exchange(3);
    line.abort(false, TIMEOUT);
    assert!(one_of(&line, "PN-ABORT").text.contains("both claim the IP address"));
    one_of(&line, "PN-ADDRESS-DUPLICATE");

    let mut line = started();
    for number in 0..1_100 {
        line.push([&[0xFF; 6][..], &THIRD_PARTY.0, &[0x12, 0x34], &[0; 46]].concat());
        if number % 100 == 99 {
            line.exchange(1);
        }
    }
    line.exchange(3);
    line.abort(false, TIMEOUT);
    let finding = only(&line, "PN-NETWORK-FLOOD");
    assert!(finding.text.contains(&THIRD_PARTY.to_string()), "{}", finding.text);
    assert!(finding.consequences.iter().any(|of| of.text.contains("floods the network")), "{finding:#?}");

    // The ARP of the stations themselves, and some broadcasts, disturb no station.
    let mut line = started();
    arp(&mut line, DEVICE, DEVICE);
    for _ in 0..100 {
        line.push([&[0xFF; 6][..], &THIRD_PARTY.0, &[0x12, 0x34], &[0; 46]].concat());
    }
    assert_eq!(findings(&line), []);
}

#[test]
fn each_reason_has_its_own_advice() {
    let advice = |reason| {
        let mut line = started();
        line.abort(true, PnioStatus::abort(reason));
        let finding = only(&line, "PN-ABORT");
        (finding.cause.unwrap(), finding.next.unwrap())
    };
    let reasons = [AbortReason::OUT_OF_MEMORY, AbortReason::LINK_DOWN, AbortReason::ALARM_SEND, AbortReason::PDEV];
    let all: Vec<(String, String)> = reasons.into_iter().map(advice).collect();
    for (at, one) in all.iter().enumerate() {
        assert!(all[..at].iter().all(|other| other.0 != one.0 && other.1 != one.1), "{one:?}");
    }
    assert!(all[1].0.contains("link"), "{:?}", all[1]);
}

/// Four connections; each ends so.
fn ends(end: impl Fn(&mut ConnectionFrames)) -> Vec<CaptureFinding> {
    let mut line = ConnectionFrames::new();
    for round in 1..=4 {
        (line.ar, line.activity) = (Uuid([round; 16]), 10 * round);
        line.start().exchange(20);
        end(&mut line);
        line.pass(Duration::from_millis(500));
    }
    let all = findings(&line);
    all.into_iter().flat_map(|mut of| std::mem::take(&mut of.consequences).into_iter().chain([of])).collect()
}

#[test]
fn deliberate_ends_are_no_unsteady_line() {
    let is_unsteady = |all: &[CaptureFinding]| all.iter().any(|of| of.id == "PN-START-AGAIN");
    let released = ends(|line| {
        line.release();
        line.abort(true, PnioStatus::abort(AbortReason::RELEASE_RECEIVED));
    });
    let requested = ends(|line| {
        line.abort(false, PnioStatus::abort(AbortReason::ABORT_REQUEST));
    });
    for all in [released, requested] {
        assert!(!is_unsteady(&all), "{all:#?}");
        assert!(all.iter().all(|of| of.severity == FindingSeverity::Info), "{all:#?}");
    }
    // A device that ends the connection before any of them aborts it.
    let aborted = ends(|line| {
        line.abort(true, PnioStatus::abort(AbortReason::RELEASE_RECEIVED));
    });
    assert!(is_unsteady(&aborted), "{aborted:#?}");
    let abort = aborted.iter().find(|of| of.id == "PN-ABORT").unwrap();
    assert_eq!((abort.severity, abort.blame), (FindingSeverity::Warning, CaptureBlame::Undecided), "{}", abort.text);
}

/// A Connect for access to records beside the running connection, refused.
fn access_refused(line: &mut ConnectionFrames) -> usize {
    let own = (line.ar, line.activity);
    (line.ar, line.activity) = (Uuid([0x55; 16]), 99);
    let connect = line.connect_blocks(ArType::IOSAR);
    let mut blocks = Vec::new();
    connect.write(&mut blocks);
    line.request(0, Opnum::CONNECT, &blocks);
    let status = PnioStatus::found(ErrorCode::CONNECT_RESPONSE, ErrorSource::ALARM_CR_BLOCK, 0);
    let frame = line.response(0, Opnum::CONNECT, status, &[]);
    (line.ar, line.activity) = own;
    frame
}

#[test]
fn a_refused_access_does_not_touch_the_running_connection() {
    let mut line = started();
    let frame = access_refused(&mut line);
    line.exchange(20);
    let finding = only(&line, "PN-START-REFUSED");
    assert_eq!((finding.frame, finding.severity), (frame as u64, FindingSeverity::Warning));
    assert_eq!(finding.blame, CaptureBlame::Undecided);
    assert!(
        finding.text.contains("access to its records") && !finding.text.contains("not released"),
        "{}",
        finding.text
    );
    assert!(finding.cause.is_some_and(|cause| cause.contains("alarm channel")));
    let report = replayed(&line);
    assert_eq!((report.ars[0].stage, report.ars[0].rt_in.frames), ("ready", 60));
    // What happens to it afterwards is still judged.
    cycles_of(&mut line, 40, 0x25, 0, 64);
    one_of(&line, "PN-STATUS-STOP");
}

/// The device sends nothing for ten watchdogs; then its counter goes on by one step, or as the time did.
fn after_a_silence(continues: bool) -> CaptureFinding {
    let mut line = started();
    for _ in 0..30 {
        line.cyclic(false, &[]);
        if !continues {
            line.counter[1] = line.counter[1].wrapping_add(64);
        }
        line.pass(CYCLE);
    }
    line.exchange(20);
    let all = findings(&line);
    let found = all.iter().find(|of| ["PN-CYCLE-SILENT", "PN-CAPTURE-GAP"].contains(&of.id.as_str()));
    found.cloned().unwrap_or_else(|| panic!("{all:#?}"))
}

#[test]
fn only_a_counter_that_continues_by_one_step_proves_a_pause() {
    let paused = after_a_silence(true);
    assert_eq!((paused.id.as_str(), paused.blame), ("PN-CYCLE-SILENT", CaptureBlame::Device), "{}", paused.text);
    assert!(paused.text.contains("continues by one step"), "{}", paused.text);
    let undecided = after_a_silence(false);
    assert!(undecided.blame != CaptureBlame::Device, "{}", undecided.text);
    assert!(undecided.text.contains("went on with the time"), "{}", undecided.text);
}

#[test]
fn a_single_odd_frame_is_a_warning_about_the_capture() {
    let mut line = started();
    cycles_of(&mut line, 1, 0x21, 0, 64);
    line.exchange(20);
    let finding = only(&line, "PN-CAPTURE-ODD-FRAME");
    assert_eq!((finding.severity, finding.blame), (FindingSeverity::Warning, CaptureBlame::Capture));
    assert!(finding.text.contains("STOP") && finding.text.contains("invalid"), "{}", finding.text);
    // The last frame of a capture says nothing about how long it lasts.
    let mut line = started();
    cycles_of(&mut line, 1, 0x21, 0, 64);
    assert_eq!(findings(&line), []);
}

#[test]
fn nothing_is_measured_across_a_hole() {
    let mut line = started();
    cycles_of(&mut line, 4, 0x25, 0, 64);
    // The clock is set back: how much time passed is not known.
    line.now = Time::from_nanos(200_000_000);
    cycles_of(&mut line, 4, 0x25, 0, 64);
    line.exchange(20);
    let finding = one_of(&line, "PN-STATUS-STOP");
    assert_eq!(finding.severity, FindingSeverity::Warning, "{}", finding.text);
    assert!(finding.text.contains("longest duration 8 ms"), "{}", finding.text);

    let mut line = started();
    line.now = Time::from_nanos(200_000_000);
    line.abort(false, TIMEOUT);
    let abort = one_of(&line, "PN-ABORT");
    assert_eq!((abort.blame, abort.severity), (CaptureBlame::Capture, FindingSeverity::Warning), "{}", abort.text);
    assert!(!abort.text.contains(" earlier"), "{}", abort.text);
}

#[rstest]
#[case::stop(0x25, "PN-STATUS-STOP")]
#[case::invalid(0x31, "PN-STATUS-INVALID")]
fn what_lasts_in_a_running_machine_is_an_error(#[case] status: u8, #[case] id: &str) {
    // Three watchdogs are nine cycles.
    for (cycles, severity) in [(5, FindingSeverity::Warning), (30, FindingSeverity::Error)] {
        let mut line = started();
        cycles_of(&mut line, cycles, status, 0, 64);
        line.exchange(20);
        let finding = one_of(&line, id);
        assert_eq!((finding.severity, finding.blame), (severity, CaptureBlame::Device), "{}", finding.text);
    }
    // Ignore says that the status may not be evaluated.
    let mut line = started();
    cycles_of(&mut line, 30, 0x80 | status, 0, 64);
    line.exchange(20);
    assert_eq!(findings(&line), []);
}

#[test]
fn stop_before_application_ready_is_normal() {
    let mut line = ConnectionFrames::new();
    line.connect_request();
    line.connect_response();
    cycles_of(&mut line, 100, 0x21, 0, 64);
    line.end_parameters();
    line.ready();
    line.exchange(40);
    assert_eq!(findings(&line), []);
}

#[test]
fn a_station_problem_is_a_warning_with_the_diagnosis_to_read() {
    let mut line = started();
    cycles_of(&mut line, 30, 0x15, 0, 64);
    line.exchange(20);
    let finding = only(&line, "PN-STATUS-PROBLEM");
    assert_eq!((finding.severity, finding.blame), (FindingSeverity::Warning, CaptureBlame::Undecided));
    assert!(finding.next.is_some_and(|next| next.contains("0xF80C")));
}

#[test]
fn empty_and_malformed_answers_are_findings() {
    // The answer to a Read is empty.
    let mut line = started();
    line.read(0xAFF0, Ok(&[1]), false);
    assert_eq!(findings(&line), []);
    line.frames.pop();
    line.sequence[0] -= 1;
    let frame = line.response(0, Opnum::READ, PnioStatus::OK, &[]);
    line.exchange(5);
    let finding = one_of(&line, "PN-ANSWER-MALFORMED");
    assert_eq!((finding.frame, finding.severity), (frame as u64, FindingSeverity::Error));
    assert_eq!(finding.blame, CaptureBlame::Device, "{}", finding.text);

    // The answer to a Connect has no blocks.
    let mut line = ConnectionFrames::new();
    line.connect_request();
    line.response(0, Opnum::CONNECT, PnioStatus::OK, &[]);
    line.exchange(5);
    one_of(&line, "PN-ANSWER-MALFORMED");

    // A station answers an Identify without any block.
    let identified = |blocks: Vec<DcpBlock>| {
        let mut line = ConnectionFrames::new();
        let response = Dcp::identify(1, 1, vec![DcpValue::AllSelector]).response(blocks);
        let mut frame = Vec::new();
        response.write_frame(CONTROLLER, DEVICE, &mut frame);
        line.push(frame);
        line
    };
    assert_eq!(only(&identified(Vec::new()), "PN-ANSWER-MALFORMED").severity, FindingSeverity::Warning);
    let name = DcpBlock { word: Some(BlockInfo(0).0), value: DcpValue::NameOfStation(b"enc-1".to_vec()) };
    assert_eq!(findings(&identified(vec![name])), []);
}

#[test]
fn the_watchdog_of_the_hand_made_connection_is_three_cycles() {
    assert_eq!(WATCHDOG, CYCLE * 3);
}

/// Alarms without channels that report a fault, each with its own advice; they end when the submodule is back.
#[test]
fn alarms_that_are_faults_have_their_own_advice() {
    let alarm = |kind: AlarmType| {
        let RtaBody::Notification(mut notification) = handmade::alarm(1) else { panic!("an alarm") };
        notification.alarm_type = kind;
        RtaBody::Notification(notification)
    };
    let mut line = started();
    line.rta(true, RtaKind::DATA, 1, alarm(AlarmType::PLUG_WRONG));
    line.exchange(3);
    let wrong = only(&line, "PN-ALARM-DIAGNOSIS");
    assert_eq!(wrong.severity, FindingSeverity::Warning);
    assert!(wrong.cause.as_ref().is_some_and(|cause| cause.contains("another type")), "{wrong:#?}");
    line.rta(true, RtaKind::DATA, 2, alarm(AlarmType::PLUG));
    assert_eq!(only(&line, "PN-ALARM-DIAGNOSIS").severity, FindingSeverity::Info);

    let mut line = started();
    line.rta(true, RtaKind::DATA, 1, alarm(AlarmType::PULL));
    assert!(only(&line, "PN-ALARM-DIAGNOSIS").cause != wrong.cause);
    // A process alarm is no fault.
    let mut line = started();
    line.rta(true, RtaKind::DATA, 1, alarm(AlarmType::PROCESS));
    assert_eq!(findings(&line), []);
}

#[test]
fn a_station_that_goes_on_was_not_switched_off() {
    let unanswered = |cycles: usize| {
        let mut line = started();
        line.read(0xAFF0, Ok(&[1]), false);
        line.frames.pop();
        line.sequence[0] -= 1;
        line.again(Duration::from_millis(1));
        line.again(Duration::from_millis(1));
        line.exchange(cycles);
        one_of(&line, "PN-CALL-UNANSWERED").cause.unwrap_or_default()
    };
    assert!(unanswered(20).contains("goes on with its cyclic frames"), "{}", unanswered(20));
    assert!(!unanswered(0).contains("goes on"), "{}", unanswered(0));
}

/// What the recorder cut off is no malformed answer; the same bytes as a whole frame are one.
#[test]
fn an_answer_that_the_capture_cut_is_not_malformed() {
    let name = DcpBlock {
        word: Some(BlockInfo(0).0),
        value: DcpValue::NameOfStation(b"an-encoder-with-a-long-name-1".to_vec()),
    };
    let response = Dcp::identify(1, 1, vec![DcpValue::AllSelector]).response(vec![name]);
    let mut frame = Vec::new();
    response.write_frame(CONTROLLER, DEVICE, &mut frame);
    let captured = |original: usize| {
        let mut writer = PcapngWriter::new(Vec::new(), "made by a test").expect("a vector takes all");
        let interface = writer.interface("wire", LinkType::ETHERNET).expect("a vector takes all");
        let (time, kept) = (Time::from_nanos(1), &frame[..50]);
        writer.cut_packet(interface, time, kept, original as u32, None).expect("a vector takes all");
        let file = writer.finish().expect("a vector takes all");
        capture("made", &file[..], &[]).expect("a capture").findings.len()
    };
    assert_eq!((captured(frame.len()), captured(50)), (0, 1));
}
