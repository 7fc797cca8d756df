//! The captures in `captures/`: third-party tools with a served reference device and with each other.
//!
//! Frame numbers and counts are tshark's: `-Y 'dcerpc.pkt_type == 0 && dcerpc.opnum == 0'` for Connect and so on,
//! `-Y pn_rt.cycle_counter` for cyclic frames, `-Y pn_io.alarm_type` for alarms.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use encspec::replay::{CaptureReport, EventKind, FindingSeverity, capture};
use encspec::suite::model::Manual;
use encspec::suite_yaml::load;
use rstest::rstest;
use std::fs;
use std::path::PathBuf;

fn folder() -> PathBuf {
    testing::workspace().join("captures")
}

fn lika() -> Vec<Manual> {
    load(&suites::sources(), Some("lika-xac77-profinet")).expect("a suite without mistakes")
}

fn replay(name: &str, manuals: &[Manual]) -> CaptureReport {
    let octets = fs::read(folder().join(name)).expect("a capture of this repository");
    capture(name, &octets[..], manuals).expect("a capture")
}

fn kinds(report: &CaptureReport, kind: EventKind) -> usize {
    report.events.iter().filter(|event| event.kind == kind).count()
}

type StartUpFrames = (Option<u64>, Option<u64>, Option<u64>, Option<u64>);

/// Connect, end of parameters, application ready and release of each connection.
fn frames(report: &CaptureReport) -> Vec<StartUpFrames> {
    let of = |ar: &encspec::replay::ConnectionReport| {
        (ar.connect_frame, ar.parameter_end_frame, ar.application_ready_frame, ar.release_frame)
    };
    report.ars.iter().map(of).collect()
}

fn errors(report: &CaptureReport) -> Vec<&str> {
    let errors = report.findings.iter().filter(|finding| finding.severity == FindingSeverity::Error);
    errors.map(|finding| finding.text.as_str()).collect()
}

fn broken(report: &CaptureReport) -> Vec<&str> {
    report.rules.iter().filter(|rule| rule.verdict == "fail").map(|rule| rule.id.as_str()).collect()
}

#[rstest]
#[case("scapy-big-endian.pcap", (Some(9), Some(15), Some(17), Some(168)))]
#[case("scapy-little-endian.pcap", (Some(7), Some(14), Some(17), Some(168)))]
fn scapy_speaks_either_byte_order(#[case] name: &str, #[case] expected: StartUpFrames) {
    let report = replay(name, &lika());
    assert_eq!((report.frames, report.damage.len(), frames(&report)), (185, 0, vec![expected]));
    let ar = &report.ars[0];
    assert_eq!(ar.controller.station.as_deref(), Some("scapy"));
    assert_eq!((ar.device.vendor_id, ar.device.device_id), (Some(0x0239), Some(0x0001)));
    assert_eq!((ar.rt_in.frames, ar.rt_out.frames, ar.rt_in.lost, ar.rt_out.lost), (61, 77, 0, 0));
    assert_eq!((kinds(&report, EventKind::Alarm), kinds(&report, EventKind::ReadRefused)), (2, 1));
    assert_eq!((kinds(&report, EventKind::DcpSet), kinds(&report, EventKind::Unreadable)), (1, 0));
    assert_eq!((broken(&report), errors(&report)), (vec![], vec![]));
    let preset = report.rules.iter().find(|rule| rule.id.ends_with("rules/preset-is-acknowledged")).unwrap();
    assert_eq!((preset.verdict, preset.premises), ("pass", 1));
}

#[test]
fn profinet_py_reads_records_and_exchanges_data() {
    let report = replay("profinet-py.pcap", &lika());
    assert_eq!((report.frames, report.damage.len()), (192, 0));
    let access = [(Some(10), None, None, Some(16)), (Some(20), None, None, Some(40))];
    // profinet-py releases a connection that it never established.
    let never_made = (None, None, None, Some(44));
    assert_eq!(frames(&report), [access[0], access[1], never_made, (Some(46), Some(51), Some(53), Some(190))]);
    let exchange = report.ars.last().unwrap();
    assert_eq!((exchange.rt_in.frames, exchange.rt_out.frames), (67, 64));
    assert_eq!((kinds(&report, EventKind::ReadRefused), kinds(&report, EventKind::WriteRefused)), (1, 1));
    assert_eq!((kinds(&report, EventKind::Alarm), kinds(&report, EventKind::Unreadable)), (1, 0));
    assert_eq!((broken(&report), errors(&report)), (vec![], vec![]));
}

#[test]
fn two_third_party_tools_are_understood() {
    let report = replay("profinet-py-and-pnio.pcap", &[]);
    assert_eq!((report.frames, report.damage.len()), (151, 0));
    let made: Vec<_> = frames(&report).into_iter().filter(|frames| frames.2.is_some()).collect();
    assert_eq!(made, [(Some(9), Some(11), Some(13), Some(149))]);
    let exchange = report.ars.last().unwrap();
    assert_eq!((exchange.device.vendor_id, exchange.device.device_id), (Some(0xFFFF), Some(0x0001)));
    assert_eq!(
        (exchange.rt_in.frames, exchange.rt_out.frames, exchange.rt_in.lost, exchange.rt_out.lost),
        (64, 64, 0, 0)
    );
    let refused = report.events.iter().find(|event| event.kind == EventKind::ConnectRefused).unwrap();
    assert!(refused.text.contains("db 81 04 00"), "{}", refused.text);
    assert_eq!((kinds(&report, EventKind::Alarm), kinds(&report, EventKind::Unreadable)), (1, 0));
}

#[test]
fn a_dcp_client_sets_and_resets_a_station() {
    let report = replay("pnio-dcp.pcap", &lika());
    assert_eq!((report.frames, report.ars.len(), kinds(&report, EventKind::Unreadable)), (58, 0, 0));
    let kinds = |kind| kinds(&report, kind);
    assert_eq!((kinds(EventKind::Rename), kinds(EventKind::DcpRefused), kinds(EventKind::DcpSet)), (6, 2, 3));
    assert_eq!((kinds(EventKind::DcpSignal), kinds(EventKind::DcpReset)), (1, 2));
}

#[test]
fn each_capture_has_a_note() {
    let notes = fs::read_to_string(folder().join("README.md")).unwrap();
    for entry in fs::read_dir(folder()).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let has_section = notes.lines().any(|line| line.starts_with("## ") && line.contains(&name));
        assert!(name == "README.md" || has_section, "captures/README.md has no section for {name}");
    }
}
