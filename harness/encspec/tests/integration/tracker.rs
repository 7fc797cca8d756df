//! The PROFINET tracker with hand-made frames, for what real captures rarely show.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::common::handmade::{self, CYCLE, ConnectionFrames, DEVICE, FRAME_ID, WATCHDOG};
use encspec::observe::{
    ArId, ArStage, FrameDirection, Observation, ObservedAr, Role, SubmodulePlacement, Tracker, describe,
};
use rstest::rstest;
use station::{Duration, Time};
use wire::octets::ByteOrder;
use wire::profinet::alarm::{RtaBody, RtaKind};
use wire::profinet::blocks::connect::ArType;
use wire::profinet::rpc::{Opnum, RejectStatus};
use wire::profinet::status::{AbortReason, CmrpcError, ErrorCode, ErrorSource, PnioStatus, RecordError};

const MIRROR: Duration = Duration::from_micros(2);
const BUSY: PnioStatus = PnioStatus::record(ErrorCode::WRITE_RESPONSE, RecordError::RESOURCE_BUSY);

/// Frame number and kind of each observation. Consecutive cyclic observations are counted.
fn observed(line: &ConnectionFrames) -> (Tracker, Vec<String>) {
    let mut tracker = Tracker::new();
    let mut list: Vec<String> = Vec::new();
    let mut cyclic = 0;
    for (number, time, octets) in line.iter() {
        tracker.frame(number, time, octets, &mut |ars, observation| {
            match observation {
                Observation::Cyclic { .. } => {
                    cyclic += 1;
                    return;
                }
                Observation::Traffic(_) | Observation::RecordRequested { .. } => return,
                _ => {}
            }
            if cyclic > 0 {
                list.push(format!("cyclic x{cyclic}"));
                cyclic = 0;
            }
            list.push(format!("{number} {}", word(ars, &observation)));
        });
    }
    if cyclic > 0 {
        list.push(format!("cyclic x{cyclic}"));
    }
    (tracker, list)
}

fn word(ars: &[ObservedAr], observation: &Observation<'_>) -> String {
    if let Some(ArId(ar)) = observation.ar() {
        assert!((ar as usize) < ars.len());
    }
    match observation {
        Observation::Cyclic { .. } => "cyclic".into(),
        Observation::Connected { .. } => "connected".into(),
        Observation::ConnectRefused { status, .. } => format!("refused {:08x}", u32::from(*status)),
        Observation::Record { ar, written, target: (_, slot, subslot, index), data, status } => {
            let verb = if *written { "write" } else { "read" };
            let by = if ar.is_some() { "" } else { " implicit" };
            format!("{verb}{by} {slot}/{subslot} {index:04x} {data:02x?} {:08x}", u32::from(*status))
        }
        Observation::RecordRequested { .. } => "record requested".into(),
        Observation::ParameterEnd { .. } => "parameter end".into(),
        Observation::ApplicationReady { .. } => "ready".into(),
        Observation::PlugReady { .. } => "plug ready".into(),
        Observation::Alarm { notification, .. } => format!("alarm {}", notification.specifier.sequence_number()),
        Observation::AlarmAcknowledged { .. } => "alarm acknowledged".into(),
        Observation::Aborted { direction, status, .. } => format!("aborted {direction:?} {:08x}", u32::from(*status)),
        Observation::CallFailed { service, why, .. } => format!("{service} failed: {why}"),
        Observation::Released { .. } => "released".into(),
        Observation::Starved { direction, .. } => format!("starved {direction:?}"),
        Observation::Dcp { .. } => "dcp".into(),
        Observation::Lldp { .. } => "lldp".into(),
        Observation::Dp { .. } => "PROFIBUS".into(),
        Observation::Traffic(_) => "traffic".into(),
        Observation::Gap { .. } => "gap".into(),
        Observation::Unreadable { why } => format!("unreadable {why}"),
    }
}

#[rstest]
#[case(ByteOrder::Big, 1_400)]
#[case(ByteOrder::Little, 1_400)]
#[case::fragments(ByteOrder::Big, 64)]
#[case::fragments(ByteOrder::Little, 104)]
fn a_connection_is_observed_from_connect_to_release(#[case] order: ByteOrder, #[case] most_fragment: usize) {
    let mut line = ConnectionFrames { order, most_fragment, ..ConnectionFrames::new() };
    line.connect_request();
    let connected = line.connect_response();
    let written = line.write(&[(1, 2, 0xBF00, &[1, 2, 3]), (0, 1, 0x7F, &[4])], true, &[PnioStatus::OK, BUSY]);
    let parameters = line.end_parameters();
    let ready = line.ready();
    line.exchange(5);
    let read = line.read(0xAFF0, Ok(&[9, 8]), false);
    let refused = line.read(0xB02E, Err(BUSY), false);
    let released = line.release();
    let (tracker, list) = observed(&line);
    // The request of ApplicationReady counts, and it may be fragmented too.
    let expected = [
        format!("{connected} connected"),
        format!("{written} write 1/2 bf00 [01, 02, 03] 00000000"),
        format!("{written} write 0/1 007f [04] df80c200"),
        format!("{parameters} parameter end"),
        format!("{ready} ready"),
        "cyclic x10".into(),
        format!("{read} read 1/2 aff0 [09, 08] 00000000"),
        format!("{refused} read 1/2 b02e [] df80c200"),
        format!("{released} released"),
    ];
    assert_eq!(list, expected);
    let [ar] = tracker.ars() else { panic!("one connection") };
    assert_eq!((ar.stage, ar.role), (ArStage::Released, Role::Exchange));
    assert_eq!(ar.application_ready_frame, Some(ready as u64));
    assert_eq!(ar.release_frame, Some(released as u64));
    assert_eq!(ar.controller.station.as_deref(), Some("controller-1"));
    assert_eq!(ar.controller.ids, Some((0xFEED, 1)));
    assert_eq!((ar.device.mac(), ar.device.ids), (DEVICE, Some((0x1234, 5))));
    assert_eq!(ar.start_records.iter().map(|record| record.accepted).collect::<Vec<_>>(), [true, false]);
    for stream in [&ar.inputs, &ar.outputs] {
        assert_eq!((stream.frame_id, stream.data_length), (FRAME_ID, 40));
        assert_eq!((stream.cycle, stream.watchdog), (CYCLE, WATCHDOG));
        assert_eq!((stream.frames, stream.lost, stream.max_gap_ns), (5, 0, 2_000_000));
    }
    assert_eq!(tracker.counts().unreadable, 0);
}

#[test]
fn each_submodule_has_the_offsets_of_its_data() {
    let mut line = ConnectionFrames::new();
    line.start();
    let (tracker, _) = observed(&line);
    let [dap, both, input] = &tracker.ars()[0].submodules[..] else { panic!("three submodules") };
    // Counted by hand. Inputs: 0 IOPS of the DAP, 1-4 data, 5 IOPS, 6 IOCS, 7-18 data, 19 IOPS.
    // Outputs: 0 IOCS of the DAP, 1-4 data, 5 IOPS, 6 IOCS, 7 IOCS.
    let nothing = SubmodulePlacement {
        input: None,
        input_status: None,
        input_consumer: None,
        output: None,
        output_status: None,
        output_consumer: None,
        ..dap.clone()
    };
    assert_eq!(*dap, SubmodulePlacement { input_status: Some(0), input_consumer: Some(0), ..nothing });
    assert_eq!((both.api, both.slot, both.subslot, both.module_ident, both.submodule_ident), (0x3D00, 1, 2, 5, 81));
    assert_eq!((both.input.clone(), both.input_status, both.input_consumer), (Some(1..5), Some(5), Some(6)));
    assert_eq!((both.output.clone(), both.output_status, both.output_consumer), (Some(1..5), Some(5), Some(6)));
    assert_eq!((input.input.clone(), input.input_status, input.input_consumer), (Some(7..19), Some(19), Some(7)));
    assert_eq!((input.output.clone(), input.output_status, input.output_consumer), (None, None, None));
}

#[test]
fn frames_doubled_by_a_mirror_port_change_nothing() {
    let mut line = ConnectionFrames::new();
    line.start().exchange(5);
    line.alarm(0xFFFF);
    line.release();
    let (once, list_once) = observed(&line);
    let mut doubled = ConnectionFrames::new();
    for (time, frame) in &line.frames {
        doubled.frames.push((*time, frame.clone()));
        doubled.frames.push((*time + MIRROR, frame.clone()));
    }
    let (twice, list_twice) = observed(&doubled);
    let renumbered: Vec<String> = list_once
        .iter()
        .map(|text| match text.split_once(' ') {
            Some((number, rest)) => {
                number.parse::<u64>().map_or(text.clone(), |number| format!("{} {rest}", 2 * number - 1))
            }
            None => text.clone(),
        })
        .collect();
    assert_eq!(list_twice, renumbered);
    assert_eq!(twice.counts().repeated, line.frames.len() as u64);
    assert_eq!(twice.ars()[0].inputs.frames, once.ars()[0].inputs.frames);
    assert_eq!(twice.ars()[0].inputs.lost, 0);
    // Every PDU is still counted by its type.
    assert_eq!(twice.counts().rpc.values().sum::<u64>(), 2 * once.counts().rpc.values().sum::<u64>());
}

#[rstest]
#[case::while_it_waits(Duration::from_secs(2), false)]
#[case::after_the_answer(Duration::from_secs(2), true)]
fn a_repeated_request_is_one_request(#[case] after: Duration, #[case] answered: bool) {
    let mut line = ConnectionFrames::new();
    line.connect_request();
    if !answered {
        line.again(after);
    }
    let request = line.frames[0].1.clone();
    let connected = line.connect_response();
    if answered {
        let response = line.frames.last().unwrap().1.clone();
        line.pass(after).push(request);
        line.push(response);
    }
    let (tracker, list) = observed(&line);
    assert_eq!(list, [format!("{connected} connected")]);
    assert_eq!(tracker.ars().len(), 1);
}

#[test]
fn the_same_numbers_after_a_release_are_a_new_connection() {
    let mut line = ConnectionFrames::new();
    line.start().exchange(3);
    line.release();
    let life: Vec<_> = line.frames.clone();
    let later = Duration::from_secs(5);
    line.frames.extend(life.iter().map(|(time, frame)| (*time + later, frame.clone())));
    let (tracker, list) = observed(&line);
    let half = list.len() / 2;
    assert_eq!(list.iter().filter(|text| text.ends_with("connected")).count(), 2);
    assert_eq!(list[half..].len(), half);
    assert_eq!(tracker.ars().iter().map(|ar| ar.inputs.frames).collect::<Vec<_>>(), [3, 3]);
}

#[test]
fn lost_frames_and_the_longest_gap_are_counted() {
    let mut line = ConnectionFrames::new();
    line.start().exchange(4);
    line.counter[1] += 2 * 64;
    line.pass(CYCLE).pass(CYCLE).cyclic(true, &[]);
    let (tracker, _) = observed(&line);
    let ar = &tracker.ars()[0];
    assert_eq!((ar.inputs.frames, ar.inputs.lost), (5, 2));
    assert_eq!(ar.inputs.max_gap_ns, 5_990_000);
    assert_eq!((ar.outputs.frames, ar.outputs.lost), (4, 0));
}

#[test]
fn a_stuck_cycle_counter_is_not_taken_for_mirrored_frames() {
    let mut line = ConnectionFrames::new();
    line.start();
    for _ in 0..5 {
        let frame = handmade::cyclic(true, 77, &[]);
        line.push(frame);
        line.pass(CYCLE);
    }
    let (tracker, _) = observed(&line);
    assert_eq!((tracker.ars()[0].inputs.frames, tracker.ars()[0].inputs.lost), (5, 0));
}

// The last frame is at 0; the watchdog time is 6 ms, and a frame may be late by one cycle.
#[rstest]
#[case::in_time(Duration::from_micros(7_900), None)]
#[case::too_late(Duration::from_micros(8_100), Some("starved ToController"))]
fn a_watchdog_timeout_is_observed_with_the_next_frame(#[case] after: Duration, #[case] starved: Option<&str>) {
    let mut line = ConnectionFrames::new();
    line.start().cyclic(true, &[]);
    let last = line.frames.last().unwrap().0;
    line.now = last + after;
    let number = line.cyclic(false, &[]);
    let (tracker, list) = observed(&line);
    let last = list.iter().rev().find(|text| !text.starts_with("cyclic")).unwrap();
    match starved {
        Some(starved) => assert_eq!(*last, format!("{number} {starved}")),
        None => assert!(last.ends_with("ready")),
    }
    assert_eq!(tracker.ars()[0].stage == ArStage::Starved, starved.is_some());
}

#[test]
fn a_watchdog_timeout_is_observed_without_a_frame() {
    let mut line = ConnectionFrames::new();
    line.start().exchange(1);
    let (mut tracker, _) = observed(&line);
    let mut starved = Vec::new();
    let mut sink = |_: &[ObservedAr], observation: Observation<'_>| {
        if let Observation::Starved { direction, .. } = observation {
            starved.push(direction);
        }
    };
    tracker.time(line.now, &mut sink);
    tracker.time(line.now + Duration::from_secs(1), &mut sink);
    tracker.time(line.now + Duration::from_secs(2), &mut sink);
    assert_eq!(starved, [FrameDirection::ToDevice]);
}

#[test]
fn cyclic_frames_after_a_watchdog_timeout_are_only_counted() {
    let mut line = ConnectionFrames::new();
    line.start().exchange(2);
    line.pass(Duration::from_millis(50)).exchange(2);
    let (tracker, list) = observed(&line);
    assert_eq!(list.last().map(String::as_str), Some("11 starved ToDevice"));
    assert_eq!(tracker.ars()[0].outputs.frames, 4);
}

#[test]
fn cyclic_frames_before_the_answer_belong_to_the_connection() {
    let mut line = ConnectionFrames::new();
    line.connect_request();
    let first = line.cyclic(true, &[]);
    line.connect_response();
    line.exchange(3);
    let (tracker, list) = observed(&line);
    assert_eq!(list, ["3 connected", "cyclic x6"]);
    let inputs = &tracker.ars()[0].inputs;
    assert_eq!((inputs.frames, inputs.first_frame), (4, Some(first as u64)));
    assert_eq!(tracker.strays(), []);
}

#[test]
fn a_capture_that_starts_in_the_middle_is_tracked() {
    let mut line = ConnectionFrames::new();
    line.start().exchange(3);
    line.read(0xAFF0, Ok(&[1]), false);
    line.alarm(0);
    line.abort(true, PnioStatus::abort(AbortReason::CONSUMER_TIMEOUT));
    line.frames.drain(..6);
    let (tracker, list) = observed(&line);
    assert_eq!(list, ["8 read 1/2 aff0 [01] 00000000", "9 alarm 0", "10 aborted ToController cf81fd05"]);
    let [ar] = tracker.ars() else { panic!("one connection") };
    assert_eq!((ar.connect_frame, ar.stage), (None, ArStage::Aborted));
    assert_eq!(ar.abort, Some((10, 0xCF81_FD05)));
    assert_eq!(ar.device.ids, Some((0x1234, 5)));
    let strays: Vec<_> = tracker.strays().iter().map(|stray| (stray.source, stray.frames)).collect();
    assert_eq!(strays, [(handmade::CONTROLLER, 3), (DEVICE, 3)]);
}

#[test]
fn repeated_alarms_are_observed_once() {
    let mut line = ConnectionFrames::new();
    line.start();
    let first = line.alarm(0xFFFF);
    line.again(Duration::from_millis(100));
    let second = line.alarm(0);
    line.rta(false, RtaKind::ACK, 0, RtaBody::Octets(Vec::new()));
    let (_, list) = observed(&line);
    assert_eq!(list[list.len() - 2..], [format!("{first} alarm 2047"), format!("{second} alarm 0")]);
}

#[rstest]
#[case(true, "aborted ToController cf81fd05")]
#[case(false, "aborted ToDevice cf81fd05")]
fn an_abort_has_a_direction(#[case] by_device: bool, #[case] expected: &str) {
    let mut line = ConnectionFrames::new();
    line.start().exchange(1);
    let number = line.abort(by_device, PnioStatus::abort(AbortReason::CONSUMER_TIMEOUT));
    line.again(Duration::from_millis(5));
    line.exchange(1);
    let (tracker, list) = observed(&line);
    assert_eq!(*list.last().unwrap(), format!("{number} {expected}"));
    assert_eq!(tracker.ars()[0].stage, ArStage::Aborted);
    assert_eq!(tracker.ars()[0].abort, Some((number as u64, 0xCF81_FD05)));
}

#[test]
fn an_abort_between_release_and_its_response_is_recorded() {
    let mut line = ConnectionFrames::new();
    line.start();
    let released = line.release();
    line.frames.pop();
    let aborted = line.abort(true, PnioStatus::abort(AbortReason(15)));
    let (tracker, _) = observed(&line);
    let ar = &tracker.ars()[0];
    assert_eq!((ar.stage, ar.release_frame), (ArStage::Released, Some(released as u64)));
    assert_eq!(ar.abort, Some((aborted as u64, 0xCF81_FD0F)));
}

#[test]
fn refusals_are_observed_with_their_status() {
    let mut line = ConnectionFrames::new();
    line.connect_request();
    let no_resources =
        PnioStatus::found(ErrorCode::CONNECT_RESPONSE, ErrorSource::CMRPC, CmrpcError::OUT_OF_AR_RESOURCES.0);
    let refused = line.response(0, Opnum::CONNECT, no_resources, &[]);
    line.connect_request();
    let rejected = line.reject(0, Opnum::CONNECT, RejectStatus::SERVER_TOO_BUSY.0);
    let (tracker, list) = observed(&line);
    let busy = "Connect failed: reject: nca_server_too_busy (0x1c010014)";
    assert_eq!(list, [format!("{refused} refused db814004"), format!("{rejected} {busy}")]);
    assert_eq!(tracker.ars().iter().map(|ar| ar.stage).collect::<Vec<_>>(), [ArStage::Refused; 2]);
}

#[test]
fn device_access_and_implicit_reads_have_no_cyclic_data() {
    let mut line = ConnectionFrames::new();
    let blocks = line.connect_blocks(ArType::IOSAR).to_vec();
    line.request(0, Opnum::CONNECT, &blocks);
    line.connect_response();
    let read = line.read(0xF821, Ok(&[3]), true);
    let (tracker, list) = observed(&line);
    assert_eq!(list, ["2 connected".to_owned(), format!("{read} read implicit 1/2 f821 [03] 00000000")]);
    assert_eq!((tracker.ars()[0].role, tracker.ars()[0].submodules.len()), (Role::Access, 0));
}

#[test]
fn unreadable_frames_are_observed_with_the_offset() {
    let mut line = ConnectionFrames::new();
    line.start();
    let mut short = handmade::cyclic(true, 1, &[]);
    short.truncate(50);
    line.push(short);
    line.push(vec![0xFF; 13]);
    let mut frame = line.frames[0].1.clone();
    frame[42] = 9;
    line.push(frame);
    let (tracker, list) = observed(&line);
    // 14 bytes of header and 4 of tag, then the frame id; the RPC version follows Ethernet, IPv4 and UDP.
    assert_eq!(
        list[list.len() - 2..],
        [
            "7 unreadable PROFINET RT: byte 20: expected 40 bytes, 30 left",
            "9 unreadable RPC header: byte 42: rpc_vers is 0x9, expected 4"
        ]
    );
    assert_eq!(tracker.counts().unreadable, 2);
}

#[test]
fn damaged_frames_do_not_panic() {
    let mut line = ConnectionFrames::new();
    line.start().exchange(2);
    line.write(&[(1, 2, 0xBF00, &[1, 2, 3])], true, &[PnioStatus::OK]);
    line.alarm(0);
    line.release();
    for (index, (time, frame)) in line.frames.iter().enumerate() {
        let mut tracker = Tracker::new();
        let mut feed = |number: usize, time: Time, octets: &[u8]| {
            tracker.frame(number as u64, time, octets, &mut |ars, observation| {
                assert!(!word(ars, &observation).is_empty())
            });
            assert!(!describe(octets, tracker.ars()).contains('\n'));
        };
        line.frames[..index].iter().for_each(|(time, frame)| feed(1, *time, frame));
        virtual_wire::damage::every_prefix(frame, |octets| feed(index, *time, octets));
        virtual_wire::damage::every_flipped_bit(frame, |_, octets| feed(index, *time, octets));
    }
}

#[test]
fn frames_are_described() {
    let mut line = ConnectionFrames::new();
    line.start();
    line.cyclic(false, &[0x80, 4, 0, 0x20, 0, 0x80, 0x80]);
    line.write(&[(1, 2, 0xBF00, &[0; 31])], false, &[BUSY]);
    line.alarm(0);
    line.abort(false, PnioStatus::abort(AbortReason::CONSUMER_TIMEOUT));
    line.release();
    let (tracker, _) = observed(&line);
    let lines: Vec<String> = line.iter().map(|(_, _, octets)| describe(octets, tracker.ars())).collect();
    assert_eq!(
        lines,
        [
            "RPC Connect request from 'controller-1' 07070707-0707-0707-0707-070707070707",
            "RPC Connect response",
            "PNIO Control end of parameters",
            "PNIO Control response end of parameters",
            "PNIO Control ApplicationReady",
            "PNIO Control response ApplicationReady",
            "RT out 0x8000 cycle 64 04 00 20 00 | 80 80 80 80",
            "PNIO Write 0xBF00 of slot 1 subslot 0x0002 (31 bytes)",
            "PNIO Write response write_response: resource_busy (df 80 c2 00)",
            "alarm low diagnosis slot 1 subslot 0x0002, sequence 0x0000, acknowledges 0xfffe",
            "alarm low ERR-RTA rta_error: consumer_timeout (cf 81 fd 05)",
            "RPC Release request",
            "RPC Release response",
        ]
    );
}
