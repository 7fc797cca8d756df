//! A machine that already runs: cyclic frames of two stations that no manual knows, without the Connect.
//!
//! The frames are those of IEC 61158-6-10: FrameID, data, cycle counter in units of 31.25 us, DataStatus, TransferStatus.

use encspec_replay::{CaptureBlame, CaptureReport, FindingSeverity, annotate, capture, text};
use rstest::rstest;
use station::{Duration, Time};
use virtual_wire::capture::{CaptureItem, LinkType};
use virtual_wire::{CaptureReader, PcapngWriter};
use wire::ethernet::Mac;
use wire::lldp::{Lldp, Tlv};
use wire::profinet::dcp::{Dcp, DcpBlock, DcpValue};

const A: [u8; 6] = [2, 0, 0, 0, 0, 0x0A];
const B: [u8; 6] = [2, 0, 0, 0, 0, 0x0B];
/// Primary, data valid, run, no problem.
const GOOD: u8 = 0x35;
const STOP: u8 = 0x25;
const INVALID: u8 = 0x31;
const PROBLEM: u8 = 0x15;
/// 1 ms.
const STEP: u16 = 32;
const DATA: usize = 40;

/// A frame of the machine: by whom, in which cycle, with which status; tests change them.
#[derive(Clone, Debug)]
struct MachineFrame {
    from: [u8; 6],
    cycle: u16,
    time: Time,
    status: u8,
    transfer: u8,
    counter: u16,
    trailer: Vec<u8>,
    tag: bool,
    cut: usize,
}

impl MachineFrame {
    fn octets(&self) -> Vec<u8> {
        let to = if self.from == A { B } else { A };
        let mut octets = [to, self.from].concat();
        if self.tag {
            octets.extend([0x81, 0x00, 0xC0, 0x00]);
        }
        octets.extend([0x88, 0x92, 0x80, 0x01]);
        octets.extend([0x80; DATA]);
        octets.extend(self.counter.to_be_bytes());
        octets.extend([self.status, self.transfer]);
        octets.extend(&self.trailer);
        octets.truncate(octets.len() - self.cut);
        octets
    }
}

/// Cycles of 1 ms of both stations.
fn machine(cycles: u16) -> Vec<MachineFrame> {
    let frame = |from, cycle: u16| MachineFrame {
        from,
        cycle,
        time: Time::from_nanos(1_000_000_000 + u64::from(cycle) * 1_000_000 + if from == A { 0 } else { 400_000 }),
        status: GOOD,
        transfer: 0,
        counter: cycle.wrapping_mul(STEP),
        trailer: Vec::new(),
        tag: false,
        cut: 0,
    };
    (0..cycles).flat_map(|cycle| [frame(A, cycle), frame(B, cycle)]).collect()
}

fn replayed(frames: &[MachineFrame]) -> CaptureReport {
    capture("machine", pcapng(frames).as_slice(), &[]).expect("a capture")
}

fn pcapng(frames: &[MachineFrame]) -> Vec<u8> {
    let mut pcapng = PcapngWriter::new(Vec::new(), "by hand").expect("a Vec takes everything");
    let interface = pcapng.interface("line", LinkType::ETHERNET).expect("a Vec takes everything");
    for frame in frames {
        pcapng.packet(interface, frame.time, &frame.octets(), None).expect("a Vec takes everything");
    }
    pcapng.finish().expect("a Vec takes everything")
}

/// The findings as check, severity, blame and frame.
fn found(report: &CaptureReport) -> Vec<(&str, FindingSeverity, CaptureBlame, u64)> {
    report.findings.iter().map(|of| (of.id.as_str(), of.severity, of.blame, of.frame)).collect()
}

#[test]
fn without_a_fault_nothing_is_found_and_the_report_says_what_was_not_judged() {
    let report = replayed(&machine(300));
    assert_eq!(found(&report), []);
    let judged: Vec<(&str, u16, u64, &str)> =
        report.judged.iter().map(|of| (of.source.as_str(), of.frame_id, of.frames, of.judged)).collect();
    assert_eq!(judged, [("02:00:00:00:00:0a", 0x8001, 300, "status"), ("02:00:00:00:00:0b", 0x8001, 300, "status")]);
    let text = text(&encspec_replay::ReplayReport { captures: vec![report] });
    assert!(text.starts_with("machine: 600 frames, 0 connections, no findings in what was judged\n"), "{text}");
    assert!(text.contains("  not judged: 2 streams, 600 frames: no layout, contents not judged"), "{text}");
}

#[rstest]
#[case(STOP, "PN-STATUS-STOP", FindingSeverity::Error)]
#[case(INVALID, "PN-STATUS-INVALID", FindingSeverity::Error)]
#[case(PROBLEM, "PN-STATUS-PROBLEM", FindingSeverity::Warning)]
fn a_bad_status_of_a_whole_capture(#[case] status: u8, #[case] id: &str, #[case] severity: FindingSeverity) {
    let mut frames = machine(300);
    frames.iter_mut().filter(|frame| frame.from == B).for_each(|frame| frame.status = status);
    let report = replayed(&frames);
    assert_eq!(found(&report), [(id, severity, CaptureBlame::Undecided, 2)]);
    let next = report.findings[0].next.as_deref().unwrap_or_default();
    assert_eq!(next.contains("0xF80C"), status == PROBLEM, "{next}");
    assert!(report.findings[0].text.contains("station B (02:00:00:00:00:0b)"), "{}", report.findings[0].text);
}

#[rstest]
#[case::for_long(6_000, FindingSeverity::Error)]
#[case::for_a_moment(200, FindingSeverity::Warning)]
fn the_provider_stops(#[case] cycles: u16, #[case] severity: FindingSeverity) {
    let mut frames = machine(100 + cycles + 100);
    let stopped = |frame: &&mut MachineFrame| frame.from == A && (100..100 + cycles).contains(&frame.cycle);
    frames.iter_mut().filter(stopped).for_each(|frame| frame.status = STOP);
    assert_eq!(found(&replayed(&frames)), [("PN-STATUS-STOP", severity, CaptureBlame::Undecided, 201)]);
}

/// A status that may not be evaluated accuses no station: Ignore is set, or the provider is a backup.
#[rstest]
#[case::ignored(0x80 | STOP)]
#[case::of_a_backup(STOP & !1)]
fn a_status_that_is_not_evaluated(#[case] status: u8) {
    let mut frames = machine(300);
    frames.iter_mut().filter(|frame| frame.from == B).for_each(|frame| frame.status = status);
    let report = replayed(&frames);
    assert_eq!(found(&report), []);
    assert!(report.judged[1].why.contains("300 frames"), "{}", report.judged[1].why);
}

#[test]
fn a_single_odd_frame_is_a_warning_about_the_capture() {
    let mut frames = machine(300);
    frames[301].status = STOP;
    assert_eq!(
        found(&replayed(&frames)),
        [("PN-CAPTURE-ODD-FRAME", FindingSeverity::Warning, CaptureBlame::Capture, 302)]
    );
}

#[test]
fn missing_frames_are_counted() {
    let mut frames = machine(300);
    frames.retain(|frame| frame.from == A || !(100..140).contains(&frame.cycle));
    let report = replayed(&frames);
    assert_eq!(found(&report), [("PN-CYCLE-LOST", FindingSeverity::Warning, CaptureBlame::Undecided, 242)]);
    assert!(report.findings[0].text.starts_with("40 of 300 cyclic frames of station B"), "{}", report.findings[0].text);
}

/// What is missing of both senders at the same time was lost by the recorder.
#[test]
fn frames_missing_of_both_are_lost_by_the_capture() {
    let mut frames = machine(300);
    frames.retain(|frame| !(100..140).contains(&frame.cycle));
    let report = replayed(&frames);
    assert!(!report.findings.is_empty());
    for finding in &report.findings {
        assert_eq!((finding.id.as_str(), finding.blame), ("PN-CAPTURE-GAP", CaptureBlame::Capture), "{}", finding.text);
    }
}

#[test]
fn a_station_falls_silent() {
    let mut frames = machine(4_000);
    frames.retain(|frame| frame.from == A || frame.cycle < 1_000);
    let report = replayed(&frames);
    assert_eq!(found(&report), [("PN-CYCLE-SILENT", FindingSeverity::Error, CaptureBlame::Undecided, 2_000)]);
}

#[test]
fn a_station_pauses_and_goes_on() {
    let mut frames = machine(5_000);
    frames.retain(|frame| frame.from == A || !(1_000..4_000).contains(&frame.cycle));
    let report = replayed(&frames);
    assert_eq!(found(&report), [("PN-CYCLE-SILENT", FindingSeverity::Error, CaptureBlame::Undecided, 5_002)]);
}

/// A counter that continues by one step after the pause proves that the station sent nothing; one that goes on with the time does not.
#[test]
fn the_counter_after_a_pause() {
    let mut frames = machine(5_000);
    frames.retain(|frame| frame.from == A || !(1_000..4_000).contains(&frame.cycle));
    let text = |frames: &[MachineFrame]| replayed(frames).findings[0].text.clone();
    assert!(text(&frames).contains("went on with the time"), "{}", text(&frames));
    let late = |frame: &&mut MachineFrame| frame.from == B && frame.cycle >= 4_000;
    frames.iter_mut().filter(late).for_each(|frame| frame.counter = (frame.cycle - 3_000).wrapping_mul(STEP));
    assert!(text(&frames).contains("continues by one step"), "{}", text(&frames));
    let report = replayed(&frames);
    assert_eq!(found(&report)[0].1, FindingSeverity::Error);
}

/// The end of the recording of both is no fault of one.
#[test]
fn a_capture_that_ends_is_no_silence() {
    assert_eq!(found(&replayed(&machine(50))), []);
}

#[test]
fn a_counter_that_stands_still_has_no_place_and_nothing_is_judged() {
    let mut frames = machine(300);
    frames.iter_mut().filter(|frame| frame.from == B).for_each(|frame| frame.counter = 7);
    let report = replayed(&frames);
    assert_eq!(report.judged[1].judged, "nothing");
    let text = text(&encspec_replay::ReplayReport { captures: vec![report] });
    assert!(
        text.contains("  not judged: 1 stream, 300 frames: no layout and no place of the status, nothing judged"),
        "{text}"
    );
}

/// Zero trailers, check sequences, tags and padding move the end of a frame; they must not read as INVALID, STOP and PROBLEM.
#[rstest]
#[case::zeros(|frame: &mut MachineFrame| frame.trailer = vec![0; 4])]
#[case::a_check_sequence(|frame: &mut MachineFrame| frame.trailer = (frame.cycle as u32).wrapping_mul(0x9E37_79B9).to_be_bytes().to_vec())]
#[case::tagged(|frame: &mut MachineFrame| frame.tag = true)]
#[case::a_time_stamp_of_a_switch(|frame: &mut MachineFrame| frame.trailer = frame.time.as_nanos().to_be_bytes().to_vec())]
fn what_follows_the_status_does_not_matter(#[case] change: fn(&mut MachineFrame)) {
    let mut frames = machine(300);
    frames.iter_mut().for_each(change);
    let report = replayed(&frames);
    assert_eq!(found(&report), []);
    assert!(report.judged.iter().all(|of| of.judged == "status"), "{:?}", report.judged);
    frames.iter_mut().filter(|frame| frame.from == B).for_each(|frame| frame.status = STOP);
    assert_eq!(found(&replayed(&frames)), [("PN-STATUS-STOP", FindingSeverity::Error, CaptureBlame::Undecided, 2)]);
}

/// A snap length that cuts the status off leaves nothing to judge.
#[test]
fn frames_that_are_cut_before_their_status() {
    let mut frames = machine(300);
    frames.iter_mut().for_each(|frame| frame.cut = 3);
    let report = replayed(&frames);
    assert_eq!(found(&report), []);
    assert!(report.judged.iter().all(|of| of.judged == "nothing"), "{:?}", report.judged);
}

/// The capture for Wireshark has the same packets at the same times, and the finding where it was found.
#[test]
fn findings_become_comments_of_their_packets() {
    let mut frames = machine(300);
    frames[500].cut = 2;
    frames.iter_mut().filter(|frame| frame.from == B).for_each(|frame| frame.status = STOP);
    let file = pcapng(&frames);
    let report = capture("machine", file.as_slice(), &[]).expect("a capture");
    let mut annotated = Vec::new();
    annotate(&report, file.as_slice(), &mut annotated, None).expect("a Vec takes everything");
    let packets = |file: &[u8]| {
        let mut reader = CaptureReader::new(file).expect("a capture");
        let mut packets = Vec::new();
        while let Some(item) = reader.next() {
            let CaptureItem::Packet(packet) = item else { panic!("no damage") };
            let comment = packet.comment.as_deref().map(str::to_owned);
            packets.push((packet.time, packet.captured.to_vec(), packet.original_length, comment));
        }
        packets
    };
    let (before, after) = (packets(&file), packets(&annotated));
    assert_eq!(before.len(), 600);
    for ((time, octets, length, _), (new_time, new_octets, new_length, _)) in before.iter().zip(&after) {
        assert_eq!((time, octets, length), (new_time, new_octets, new_length));
    }
    let comments: Vec<(usize, &str)> =
        after.iter().enumerate().filter_map(|(at, packet)| Some((at + 1, packet.3.as_deref()?))).collect();
    assert_eq!(comments.len(), 1, "{comments:?}");
    assert_eq!(comments[0].0, 2);
    assert!(comments[0].1.starts_with("encspec PN-STATUS-STOP (error, blame: undecided): station B "), "{comments:?}");
}

/// The time between frames jitters; the counter does not.
#[test]
fn jitter_of_the_recorder_is_no_finding() {
    let mut frames = machine(300);
    for frame in &mut frames {
        frame.time += Duration::from_micros(u64::from(frame.cycle * 37 % 300));
    }
    assert_eq!(found(&replayed(&frames)), []);
}

/// A DCP answer and LLDP say which stations send the streams, wherever they stand in the capture.
#[test]
fn stations_are_named_by_dcp_and_lldp() {
    let frames = machine(100);
    let mut pcapng = PcapngWriter::new(Vec::new(), "by hand").expect("a Vec takes everything");
    let interface = pcapng.interface("line", LinkType::ETHERNET).expect("a Vec takes everything");
    let mut put =
        |time: Time, octets: &[u8]| pcapng.packet(interface, time, octets, None).expect("a Vec takes everything");
    for frame in &frames {
        put(frame.time, &frame.octets());
    }
    let value = DcpValue::DeviceId { vendor_id: 0x1234, device_id: 5 };
    let blocks = [DcpValue::NameOfStation(b"enc-1".to_vec()), value].map(|value| DcpBlock { word: Some(0), value });
    let mut answer = Vec::new();
    let response = Dcp::identify(1, 1, vec![DcpValue::AllSelector]).response(blocks.to_vec());
    response.write_frame(Mac(A), Mac(B), &mut answer);
    let mut announced = Vec::new();
    let tlvs = vec![
        Tlv::ChassisId { subtype: 7, id: b"plc-1".to_vec() },
        Tlv::PortId { subtype: 7, id: b"port-001".to_vec() },
        Tlv::TimeToLive(20),
        Tlv::SystemDescription(b"A controller".to_vec()),
        Tlv::ChassisMac(Mac(A)),
    ];
    Lldp { tlvs }.write_frame(Mac([2, 0, 0, 0, 0, 0x1A]), &mut announced);
    let end = frames.last().unwrap().time;
    put(end, &answer);
    put(end, &announced);
    let report =
        capture("machine", pcapng.finish().expect("a Vec takes everything").as_slice(), &[]).expect("a capture");
    let senders: Vec<Option<&str>> = report.judged.iter().map(|of| of.sender.as_deref()).collect();
    assert_eq!(senders, [Some("type 'A controller'"), Some("'enc-1', vendor 0x1234 device 0x0005")]);
    let text = text(&encspec_replay::ReplayReport { captures: vec![report] });
    assert!(
        text.contains("senders: 02:00:00:00:00:0a (type 'A controller'); 02:00:00:00:00:0b ('enc-1', vendor"),
        "{text}"
    );
}
