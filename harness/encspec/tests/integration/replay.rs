//! Replay of third-party captures: every expected number comes from tshark or Zeek, or was counted by hand.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::common::handmade::{self, ConnectionFrames, DEVICE};
use encspec::observe::Tracker;
use encspec::replay::{
    CaptureEvent, CaptureReport, EventKind, FindingSeverity, ReplayReport, capture, files, fits_manual, judge_rules,
    text,
};
use encspec::suite::model::Manual;
use encspec::suite_yaml::load;
use encspec::verdict::Verdict;
use rstest::rstest;
use station::Duration;
use std::collections::BTreeMap;
use std::fs;
use virtual_wire::CaptureReader;
use virtual_wire::capture::CaptureItem;
use wire::profinet::status::{AbortReason, PnioStatus};

/// The bytes of a third-party capture. Without the capture the test is reported as skipped.
fn octets(name: &str) -> Option<Vec<u8>> {
    testing::shared(&format!("captures/{name}")).map(|path| fs::read(path).expect("a readable file"))
}

fn replay(octets: &[u8]) -> CaptureReport {
    capture("a capture", octets, &[]).expect("a capture")
}

fn kinds(report: &CaptureReport, kind: EventKind) -> usize {
    report.events.iter().filter(|event| event.kind == kind).count()
}

/// tshark -r F -Y 'dcerpc.pkt_type == 0 && dcerpc.opnum == 0' and the like; cyclic frames by
/// `-Y 'pn_rt.frame_id == 0xc002'`; starved and lost frames by hand from `-e pn_rt.cycle_counter`, which increases by 256.
#[test]
fn the_office_capture_has_three_connections() {
    let Some(octets) = octets("profinet/office-noise-versamax.pcap") else { return };
    let report = replay(&octets);
    assert_eq!((report.frames, report.damage.len()), (1_635, 0));
    assert!(report.findings.iter().all(|finding| finding.severity != FindingSeverity::Error), "{:#?}", report.findings);
    let frames: Vec<_> = report
        .ars
        .iter()
        .map(|ar| (ar.connect_frame, ar.parameter_end_frame, ar.application_ready_frame, ar.release_frame))
        .collect();
    assert_eq!(
        frames,
        [
            (Some(1), Some(9), Some(13), None),
            (Some(17), Some(23), None, Some(27)),
            (Some(485), Some(522), Some(529), Some(583)),
        ]
    );
    let [plc, _, versamax] = &report.ars[..] else { panic!("three") };
    assert_eq!(plc.ar_uuid, "09f1a530-c75f-6d47-b67f-8073439deaad");
    assert_eq!(
        (plc.controller.mac.as_deref().unwrap_or_default(), plc.controller.station.as_deref()),
        ("00:1c:06:0b:26:ed", Some("plcxbkontr74b7"))
    );
    assert_eq!((plc.device.vendor_id, plc.device.device_id), (Some(0x014D), Some(0x0101)));
    assert_eq!((versamax.device.vendor_id, versamax.device.device_id), (Some(0x015A), Some(0x0003)));
    assert_eq!(versamax.device.station.as_deref(), Some("versamax-pns11"));
    assert_eq!(versamax.abort.map(|abort| (abort.frame, abort.code)), Some((584, 0xCF81_FD0F)));
    assert_eq!((versamax.rt_in.frames, versamax.rt_out.frames), (46, 56));
    assert_eq!((versamax.rt_in.lost, versamax.rt_out.lost), (0, 0));
    // Frames 492 at 59.364245 and 493 at 59.381494.
    assert_eq!(versamax.rt_in.max_gap_ns, 17_249_000);
    assert_eq!((kinds(&report, EventKind::Connect), kinds(&report, EventKind::Unreadable)), (3, 0));
}

/// tshark -r F -Y 'dcerpc.opnum == 0 && dcerpc.pkt_type == 2' -T fields -e pn_io.error_code: 79 of 0x00, 83 of 0xdb.
#[test]
fn many_devices_make_80_connections_and_refuse_83() {
    let Some(octets) = octets("profinet/merged-many-devices.pcapng") else { return };
    let report = replay(&octets);
    assert_eq!((report.frames, report.damage.len()), (960, 0));
    assert_eq!(kinds(&report, EventKind::ConnectRefused), 83);
    let refused = report.events.iter().find(|event| event.kind == EventKind::ConnectRefused).unwrap();
    assert!(refused.text.contains("db 81 40 04"), "{}", refused.text);
    assert_eq!(kinds(&report, EventKind::Unreadable), 0);
    assert_eq!(report.ars.iter().filter(|ar| ar.connect_frame.is_some()).count(), 164);
}

/// Counts of RPC PDUs by Zeek: column 11 is the packet type, column 32 the operation.
#[rstest]
#[case("office-noise-versamax", "pcap")]
#[case("one-ar-life", "pcapng")]
#[case("record-reads", "pcapng")]
fn rpc_pdus_are_counted_as_zeek_counts_them(#[case] name: &str, #[case] extension: &str) {
    let Some(octets) = octets(&format!("profinet/{name}.{extension}")) else { return };
    let Some(log) = testing::shared(&format!("captures/profinet/{name}.rpc-pdus.log")) else { return };
    let log = fs::read_to_string(log).expect("a readable file");
    let mut zeek: BTreeMap<(String, String), u64> = BTreeMap::new();
    for line in log.lines().filter(|line| !line.starts_with('#')) {
        let columns: Vec<&str> = line.split('\t').collect();
        *zeek.entry((columns[10].to_lowercase(), columns[31].to_lowercase().replace(' ', "_"))).or_default() += 1;
    }
    let tracker = tracked(&octets);
    let ours = tracker.counts().rpc.iter().map(|(kind, count)| {
        assert!(!kind.endpoint_mapper);
        ((kind.packet_type.word().unwrap().to_owned(), kind.opnum.word().unwrap().to_owned()), *count)
    });
    assert_eq!(ours.collect::<BTreeMap<_, _>>(), zeek);
    assert!(zeek.values().sum::<u64>() >= 10, "the log has too few lines");
}

/// tshark --disable-protocol wg -r F -Y dcerpc -T fields -e dcerpc.pkt_type -e dcerpc.opnum | sort | uniq -c
#[rstest]
#[case("merged-many-devices.pcapng", &[(0, 0, 164), (0, 1, 3), (0, 2, 6), (0, 3, 153), (0, 4, 146), (0, 5, 3), (1, 0, 1),
    (2, 0, 162), (2, 1, 3), (2, 2, 6), (2, 3, 151), (2, 4, 144), (2, 5, 3), (5, 0, 1), (9, 3, 4)])]
#[case("implicit-reads-ns.pcapng", &[(0, 5, 4), (2, 5, 4)])]
#[case("zero-timestamps.pcap", &[(0, 0, 1)])]
#[case("dcp-name-ip-reset.pcap", &[])]
fn rpc_pdus_are_counted_as_tshark_counts_them(#[case] name: &str, #[case] tshark: &[(u8, u16, u64)]) {
    let Some(octets) = octets(&format!("profinet/{name}")) else { return };
    let tracker = tracked(&octets);
    let ours: Vec<_> =
        tracker.counts().rpc.iter().map(|(kind, count)| (kind.packet_type.0, kind.opnum.0, *count)).collect();
    assert_eq!(ours, tshark);
}

fn tracked(octets: &[u8]) -> Tracker {
    let mut reader = CaptureReader::new(octets).expect("a capture");
    let mut tracker = Tracker::new();
    while let Some(item) = reader.next() {
        if let CaptureItem::Packet(packet) = item {
            tracker.frame(packet.number as u64, packet.time, packet.captured, &mut |_, _| {});
        }
    }
    tracker
}

/// The events agree with tshark's Info column for these frames.
#[rstest]
#[case("dcp-name-ip-reset.pcap", &[(7, EventKind::DcpReset, "communication"), (17, EventKind::DcpSet, "192.168.0.10"),
    (23, EventKind::Rename, "'et200sp'")])]
#[case("odd-station-name.pcap", &[(3, EventKind::Rename, r"'%n%n%n \x00")])]
#[case("zero-timestamps.pcap", &[(3, EventKind::DcpSet, "192.168.1.25"), (7, EventKind::ConnectUnanswered, "'controller'")])]
#[case("record-reads.pcapng", &[])]
#[case("implicit-reads-ns.pcapng", &[])]
#[case("one-ar-life.pcapng", &[(2, EventKind::Connect, "7 submodules"), (6, EventKind::ParameterEnd, ""),
    (9, EventKind::Release, "")])]
fn events_are_reported(#[case] name: &str, #[case] expected: &[(u64, EventKind, &str)]) {
    let Some(octets) = octets(&format!("profinet/{name}")) else { return };
    let report = replay(&octets);
    let events: Vec<_> = report.events.iter().map(|event| (event.frame, event.kind)).collect();
    assert_eq!(events, expected.iter().map(|(frame, kind, _)| (*frame, *kind)).collect::<Vec<_>>());
    for (event, (.., words)) in report.events.iter().zip(expected) {
        assert!(event.text.contains(words), "{}", event.text);
        assert!(event.text.chars().all(|letter| !letter.is_control()));
    }
    assert!(report.findings.iter().all(|finding| finding.severity != FindingSeverity::Error), "{:#?}", report.findings);
}

#[test]
fn two_stations_with_one_name_are_a_finding() {
    let Some(octets) = octets("profinet/duplicate-station-name.pcap") else { return };
    let report = replay(&octets);
    let [finding] = &report.findings[..] else { panic!("one finding: {:?}", report.findings) };
    // Frame 18 is the answer of ac:64:17:21:35:cf, frame 19 that of 00:0e:35:cd:60:dc to the same question.
    assert_eq!(
        (finding.id.as_str(), finding.severity, finding.frame),
        ("PN-NAME-DUPLICATE", FindingSeverity::Error, 19)
    );
    assert!(finding.text.contains("'et200sp'"));
}

/// Frame counts by `capinfos -c`; damage as described in the README of the folder.
#[rstest]
#[case("damaged/cut-mid-record.pcap", 900, 1, 3, 0)]
#[case("damaged/header-only.pcap", 0, 1, 0, 0)]
#[case("damaged/captured-length-huge.pcap", 28, 1, 0, 0)]
#[case("damaged/block-trailer-mismatch.pcapng", 18, 1, 2, 0)]
#[case("damaged/sliced-48.pcap", 28, 0, 0, 10)]
#[case("containers/big-endian-nanoseconds.pcap", 28, 0, 0, 0)]
#[case("containers/be-advanced_test100.pcapng", 5, 0, 0, 0)]
#[case("containers/le-advanced_test102.pcapng", 5, 0, 0, 0)]
#[case("containers/be-difficult_test202.pcapng", 8, 0, 0, 0)]
fn all_readable_frames_of_damaged_captures_are_read(
    #[case] name: &str,
    #[case] frames: u64,
    #[case] damage: usize,
    #[case] ars: usize,
    #[case] unreadable: usize,
) {
    let Some(octets) = octets(name) else { return };
    let report = replay(&octets);
    assert_eq!((report.frames, report.damage.len(), report.ars.len()), (frames, damage, ars));
    assert_eq!(kinds(&report, EventKind::Unreadable), unreadable);
}

/// Events that depend only on the frames before `up_to`. The others need the whole capture or the time of the next frame.
fn at_once(report: &CaptureReport, up_to: u64) -> Vec<&CaptureEvent> {
    let late = [EventKind::ConnectUnanswered, EventKind::Unassigned];
    report.events.iter().filter(|event| event.frame < up_to && !late.contains(&event.kind)).collect()
}

#[test]
fn damage_does_not_change_events_before_it() {
    let mut line = ConnectionFrames::new();
    line.start().exchange(3);
    line.write(&[(1, 2, 0xBF00, &[1, 2, 3])], true, &[PnioStatus::OK]);
    line.abort(true, PnioStatus::abort(AbortReason::CONSUMER_TIMEOUT));
    let shared = ["profinet/one-ar-life.pcapng", "profinet/odd-station-name.pcap", "damaged/bit-rot.pcap"];
    let captures = shared.into_iter().filter_map(octets).chain([line.capture()]);
    for octets in captures {
        let whole = replay(&octets);
        let mut frames_before = vec![0; octets.len() + 1];
        virtual_wire::damage::every_prefix(&octets, |prefix| {
            let Ok(report) = capture("a capture", prefix, &[]) else { return };
            frames_before[prefix.len()] = report.frames;
            assert_eq!(at_once(&report, report.frames), at_once(&whole, report.frames));
        });
        virtual_wire::damage::every_flipped_bit(&octets, |index, flipped| {
            let Ok(report) = capture("a capture", flipped, &[]) else { return };
            let before = frames_before[index];
            assert_eq!(at_once(&report, before), at_once(&whole, before));
            assert!(!text(&ReplayReport { captures: vec![report] }).is_empty());
        });
    }
}

/// ZSW2_ENC, G1_ZSW, G1_XIST1, G1_XIST2 after the IOPS of the two submodules without data.
fn inputs(g1_zsw: u16, position: u32) -> Vec<u8> {
    let mut data = vec![0x80, 0x80, 0, 0];
    data.extend(g1_zsw.to_be_bytes());
    data.extend(position.to_be_bytes());
    data.extend(position.to_be_bytes());
    data
}

const RULE: &str = "rules/position-or-error-never-both";

fn manual() -> Vec<Manual> {
    load(&suites::sources(), Some("lika-xac77-profinet")).expect("a suite without mistakes")
}

#[test]
fn a_broken_rule_is_a_finding_with_its_requirement_and_frame() {
    let manuals = manual();
    let mut line = ConnectionFrames::to_xac77();
    line.start();
    for _ in 0..5 {
        line.cyclic(true, &inputs(0x2000, 77));
        line.pass(handmade::CYCLE);
    }
    let fine = capture("fine", &line.capture()[..], &manuals).expect("a capture");
    let of =
        |report: &CaptureReport| report.rules.iter().find(|rule| rule.id.ends_with(RULE)).cloned().expect("the rule");
    assert_eq!((of(&fine).verdict, of(&fine).premises, fine.findings), ("pass", 5, vec![]));

    // Bit 13 (position transmitted) together with bit 15 (sensor error).
    let number = line.cyclic(true, &inputs(0xA000, 77)) as u64;
    let alone = capture("alone", &line.capture()[..], &manuals).expect("a capture");
    assert_eq!(of(&alone).verdict, "inconclusive", "a single frame may be damaged in the capture");
    line.pass(handmade::CYCLE).cyclic(true, &inputs(0xA000, 77));
    let broken = capture("broken", &line.capture()[..], &manuals).expect("a capture");
    assert_eq!(of(&broken).verdict, "fail");
    let finding = broken.findings.iter().find(|finding| finding.id == "XAC77-SIG-036").expect("the finding");
    assert_eq!((finding.frame, finding.severity), (number, FindingSeverity::Error));

    for variant in 0..manuals[0].variants.len() {
        let outcomes = judge_rules(line.iter(), &manuals[0], variant, |ar| fits_manual(&manuals[0], ar));
        let rules = &manuals[0].variants[variant].rules;
        let outcome = outcomes.iter().find(|outcome| rules[outcome.rule].id == RULE).expect("the rule");
        assert_eq!(outcome.verdict(), Verdict::Fail);
        assert_eq!(outcome.violation.as_ref().map(|violation| violation.tick.frame), Some(number));
    }
}

/// Bit 12 of G1_ZSW rises, and the capture ends before the rule is decided.
#[test]
fn an_undecided_rule_is_inconclusive() {
    let mut line = ConnectionFrames::to_xac77();
    line.start();
    // Long enough after the start for a request before to have been answered.
    for g1_zsw in [0x2000; 600].into_iter().chain([0x3000]) {
        // Two IOCS, STW2_ENC with Control by PLC, G1_STW with the preset request, IOPS and IOCS.
        line.pass(handmade::CYCLE).cyclic(false, &[0x80, 0x80, 0x04, 0, 0x10, 0, 0x80, 0x80]);
        line.cyclic(true, &inputs(g1_zsw, 77));
    }
    let report = capture("cut short", &line.capture()[..], &manual()).expect("a capture");
    let of = |id: &str| report.rules.iter().find(|rule| rule.id.ends_with(id)).cloned().expect("the rule");
    let stays = of("rules/acknowledgement-stays-with-request");
    assert_eq!((stays.verdict, stays.premises, stays.undecided), ("inconclusive", 0, 1));
    let reason = "its premise occurred once, but the frames ended or were missing before it was decided";
    assert_eq!(stays.reason.as_deref(), Some(reason));
    assert_eq!(of("rules/error-waits-for-acknowledgement").verdict, "not-run", "there was no error");
}

#[test]
fn another_device_is_not_judged() {
    let mut line = ConnectionFrames::to_xac77();
    line.ids.1 = 2;
    line.start().cyclic(true, &inputs(0xA000, 77));
    let report = capture("another", &line.capture()[..], &manual()).expect("a capture");
    assert_eq!((report.rules, report.findings), (vec![], vec![]));
}

#[test]
fn rules_are_not_judged_after_a_watchdog_timeout() {
    let mut line = ConnectionFrames::to_xac77();
    line.start().cyclic(true, &inputs(0x2000, 77));
    line.pass(Duration::from_secs(1)).cyclic(true, &inputs(0xA000, 77));
    let report = capture("silence", &line.capture()[..], &manual()).expect("a capture");
    let by_rules = report.findings.iter().filter(|finding| !finding.requirements.is_empty()).count();
    assert_eq!((kinds(&report, EventKind::Starved), by_rules), (1, 0));
}

#[test]
fn the_json_keys_are_stable() {
    let mut line = ConnectionFrames::new();
    line.start().exchange(2);
    line.abort(true, PnioStatus::abort(AbortReason::CONSUMER_TIMEOUT));
    let captures = vec![capture("field.pcapng", &line.capture()[..], &[]).expect("a capture")];
    let json = serde_json::to_value(ReplayReport { captures }).expect("plain data");
    let capture = &json["captures"][0];
    assert_eq!((&capture["file"], &capture["frames"]), (&"field.pcapng".into(), &11.into()));
    assert_eq!(capture["damage"], serde_json::json!([]));
    let ar = &capture["ars"][0];
    assert_eq!(ar["ar_uuid"], "07070707-0707-0707-0707-070707070707");
    assert_eq!(ar["controller"], serde_json::json!({ "mac": "02:00:00:00:00:01", "station": "controller-1" }));
    let device = serde_json::json!({ "mac": DEVICE.to_string(), "station": null, "vendor_id": 0x1234, "device_id": 5 });
    assert_eq!(ar["device"], device);
    let frames =
        ["connect_frame", "parameter_end_frame", "application_ready_frame", "release_frame"].map(|key| &ar[key]);
    assert_eq!(frames, [&1.into(), &3.into(), &5.into(), &serde_json::Value::Null]);
    assert_eq!(ar["abort"], serde_json::json!({ "frame": 11, "code": 0xCF81_FD05_u32 }));
    assert_eq!(ar["rt_in"], serde_json::json!({ "frames": 2, "lost": 0, "max_gap_ns": 2_000_000 }));
    assert_eq!(ar["rt_out"]["frames"], 2);
    let event = &capture["events"][0];
    assert_eq!((&event["frame"], &event["time"], &event["kind"]), (&2.into(), &0.000_01.into(), &"connect".into()));
    assert!(event["text"].is_string() && capture["findings"].is_array() && capture["rules"].is_array());
}

#[rstest]
#[case::empty(&[], "is empty, a capture begins with a header")]
#[case::packed(&[0x1F, 0x8B, 8, 0], "cannot be read: the compressed file is damaged at or before byte 4: it ends too soon")]
#[case::text(b"hello", "is neither pcap nor pcapng: it begins with 68 65 6C 6C")]
fn an_invalid_capture_is_refused(#[case] octets: &[u8], #[case] why: &str) {
    assert_eq!(capture("a file", octets, &[]).unwrap_err().to_string(), why);
}

#[rstest]
#[case::a_pdf("notes.pdf", Some(&b"%PDF-1.4"[..]), "save it as pcapng")]
#[case::nothing_was_recorded("empty.pcapng", Some(&b""[..]), "before its first packet")]
#[case::a_folder("captures", None, "give the names of the capture files")]
fn a_file_that_is_no_capture_is_reported_with_a_hint(
    #[case] name: &str,
    #[case] octets: Option<&[u8]>,
    #[case] hint: &str,
) {
    let folder = testing::Folder::new("no-captures");
    let path = folder.join(name);
    match octets {
        Some(octets) => {
            fs::write(&path, octets).unwrap();
        }
        None => fs::create_dir_all(&path).unwrap(),
    }
    let error = files(&[path.to_string_lossy().into_owned()], &[]).unwrap_err().to_string();
    assert!(error.contains(name) && error.contains(hint), "{error}");
}
