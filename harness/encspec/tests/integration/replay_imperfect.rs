//! Imperfect captures as they come from plants: mirrored, one-sided, started late, with clock jumps and missing tags. None of this may
//! cause a wrong verdict: a conforming device has no findings, and a device with a bug has no additional ones.

use crate::built_in::manuals;
use crate::common::handmade::ConnectionFrames;
use crate::recordings::{TrialRecording, against_devices, record, some};
use encspec::replay::{CaptureReport, capture};
use encspec::suite::model::Manual;
use rstest::rstest;
use station::{Duration, Time};
use std::collections::BTreeSet;
use std::sync::LazyLock;
use virtual_wire::PcapngWriter;
use virtual_wire::capture::LinkType;
use wire::octets::ByteOrder;

/// Recordings of conforming devices, three of each manual.
static CONFORMING: LazyLock<Vec<TrialRecording>> =
    LazyLock::new(|| manuals().iter().flat_map(|manual| some(manual, 3)).collect());

/// Recordings of bugs that a rule shows, at most three of each manual.
static BUGGY: LazyLock<Vec<TrialRecording>> = LazyLock::new(|| manuals().iter().flat_map(buggy).collect());

fn buggy(manual: &Manual) -> Vec<TrialRecording> {
    let variant = &manual.variants[0];
    let of_rules = variant.rules.iter().flat_map(|rule| rule.catches.first());
    let recordings = of_rules.filter_map(|bug| {
        let trial = variant.trials.iter().find(|trial| trial.catches.contains(bug))?;
        Some(record(manual, trial, &[bug.as_str()])).filter(|recording| recording.frames.len() < 2_000)
    });
    recordings.filter(|recording| !ids(&recording.replayed(manuals())).is_empty()).take(3).collect()
}

fn ids(report: &CaptureReport) -> BTreeSet<String> {
    against_devices(report).into_iter().map(|finding| finding.id.clone()).collect()
}

type CapturedFrames = Vec<(Time, Vec<u8>)>;

fn later(time: Time, micros: u64) -> Time {
    time + Duration::from_micros(micros)
}

fn untagged(frame: &mut Vec<u8>) {
    if frame.get(12..14).is_some_and(|of| of == [0x81, 0x00]) {
        frame.drain(12..16);
    }
}

/// Whether the controller of the harness sends the frame. Its address is the same in all recordings.
fn is_from_controller(frame: &[u8]) -> bool {
    frame.get(6..12).is_some_and(|of| of == [2, 0, 0, 0, 0, 1])
}

fn mirrored(frames: &mut CapturedFrames) {
    *frames =
        frames.iter().flat_map(|(time, frame)| [(*time, frame.clone()), (later(*time, 3), frame.clone())]).collect();
}

fn mirrored_without_tags(frames: &mut CapturedFrames) {
    mirrored(frames);
    frames.iter_mut().skip(1).step_by(2).for_each(|(_, frame)| untagged(frame));
}

fn tags_come_and_go(frames: &mut CapturedFrames) {
    frames.iter_mut().step_by(3).for_each(|(_, frame)| untagged(frame));
}

fn from_the_device_only(frames: &mut CapturedFrames) {
    frames.retain(|(_, frame)| !is_from_controller(frame));
}

fn from_the_controller_only(frames: &mut CapturedFrames) {
    frames.retain(|(_, frame)| is_from_controller(frame));
}

fn started_in_the_middle(frames: &mut CapturedFrames) {
    frames.drain(..frames.len() / 2);
}

fn started_after_the_connect(frames: &mut CapturedFrames) {
    frames.drain(..frames.len().min(12));
}

fn clock_set_back(frames: &mut CapturedFrames) {
    let middle = frames.len() / 2;
    let by = Duration::from_secs(10);
    for (time, _) in &mut frames[..middle] {
        *time += by;
    }
}

fn without_a_clock(frames: &mut CapturedFrames) {
    frames.iter_mut().for_each(|(time, _)| *time = Time::ZERO);
}

/// Every RPC request and response is captured twice.
fn retransmitted(frames: &mut CapturedFrames) {
    let is_call = |frame: &[u8]| frame.get(12..14).is_some_and(|of| of == [8, 0]);
    let again = |(time, frame): &(Time, Vec<u8>)| {
        let copy = is_call(frame).then(|| (later(*time, 4), frame.clone()));
        [Some((*time, frame.clone())), copy].into_iter().flatten()
    };
    *frames = frames.iter().flat_map(again).collect();
    frames.sort_by_key(|(time, _)| *time);
}

/// Changes that lose no information: the findings stay the same.
#[rstest]
#[case::mirrored(mirrored)]
#[case::mirrored_without_tags(mirrored_without_tags)]
#[case::tags_come_and_go(tags_come_and_go)]
#[case::retransmitted(retransmitted)]
fn duplicates_do_not_change_the_findings(#[case] change: fn(&mut CapturedFrames)) {
    let is_ethernet = |recording: &&TrialRecording| recording.link == LinkType::ETHERNET;
    for recording in CONFORMING.iter().chain(BUGGY.iter()).filter(is_ethernet) {
        let before = ids(&recording.replayed(manuals()));
        let after = recording.changed(change).replayed(manuals());
        assert_eq!(ids(&after), before, "{}: {:#?}", recording.name, against_devices(&after));
    }
}

/// Changes that lose information: findings may disappear, but none appear.
#[rstest]
#[case::from_the_device_only(from_the_device_only)]
#[case::from_the_controller_only(from_the_controller_only)]
#[case::started_in_the_middle(started_in_the_middle)]
#[case::started_after_the_connect(started_after_the_connect)]
#[case::clock_set_back(clock_set_back)]
#[case::without_a_clock(without_a_clock)]
fn missing_information_is_not_blamed_on_a_device(#[case] change: fn(&mut CapturedFrames)) {
    for recording in CONFORMING.iter().chain(BUGGY.iter()) {
        let before = ids(&recording.replayed(manuals()));
        let after = recording.changed(change).replayed(manuals());
        assert!(ids(&after).is_subset(&before), "{}: {:#?}", recording.name, against_devices(&after));
    }
}

#[test]
fn there_are_enough_recordings() {
    assert!(CONFORMING.len() >= 10 && BUGGY.len() >= 6, "{} without and {} with bugs", CONFORMING.len(), BUGGY.len());
}

fn replace(frame: &mut [u8], from: &[u8], to: &[u8]) {
    for at in 0..=frame.len().saturating_sub(from.len()) {
        if frame.get(at..at + from.len()) == Some(from) {
            frame[at..at + from.len()].copy_from_slice(to);
        }
    }
}

/// Two devices, each with its controller, on one wire, and a PROFIBUS with another clock in the same file.
#[test]
fn several_connections_in_one_file_are_kept_apart() {
    let ethernet: Vec<&TrialRecording> =
        CONFORMING.iter().chain(BUGGY.iter()).filter(|recording| recording.link == LinkType::ETHERNET).collect();
    let bus = BUGGY.iter().chain(CONFORMING.iter()).find(|recording| recording.link == LinkType::PROFIBUS);
    let bus = bus.expect("a recording of a bus");
    let mut with_findings = 0;
    for pair in ethernet.windows(2) {
        let second = pair[1].changed(|frames| {
            for (_, frame) in frames {
                // Another controller and another device: only the third byte of their addresses differs.
                let ends: Vec<[u8; 6]> =
                    [0, 6].iter().filter_map(|&at| frame.get(at..at + 6)?.try_into().ok()).collect();
                for end in ends.into_iter().filter(|end| end[0] & 1 == 0) {
                    let mut other = end;
                    other[2] ^= 0x40;
                    replace(frame, &end, &other);
                }
            }
        });
        let mut all: Vec<(u32, Time, &[u8])> = Vec::new();
        for (interface, recording) in [(0, pair[0]), (0, &second), (1, bus)] {
            all.extend(recording.frames.iter().map(|(time, frame)| (interface, *time, &frame[..])));
        }
        all.sort_by_key(|(_, time, _)| *time);
        let mut writer = PcapngWriter::new(Vec::new(), "made by a test").expect("a vector takes all");
        let wires = [
            writer.interface("wire", LinkType::ETHERNET).expect("a vector takes all"),
            writer.interface("bus", LinkType::PROFIBUS).expect("a vector takes all"),
        ];
        for (interface, time, frame) in all {
            writer.packet(wires[interface as usize], time, frame, None).expect("a vector takes all");
        }
        let file = writer.finish().expect("a vector takes all");
        let together = ids(&capture("together", &file[..], manuals()).expect("a capture"));
        let apart: BTreeSet<String> =
            [pair[0], pair[1], bus].iter().flat_map(|recording| ids(&recording.replayed(manuals()))).collect();
        assert!(together.is_subset(&apart), "{} beside {}: {together:?}", pair[0].name, pair[1].name);
        with_findings += usize::from(!together.is_empty());
    }
    assert!(with_findings > 0, "there was no finding in any of the files");
}

/// Parameters and layout are read in both byte orders, with and without RPC fragments.
#[rstest]
fn calls_mean_the_same_in_both_byte_orders_and_in_fragments(
    #[values(ByteOrder::Little, ByteOrder::Big)] order: ByteOrder,
    #[values(1_400, 100)] most_fragment: usize,
) {
    let mut line = ConnectionFrames { order, most_fragment, ..ConnectionFrames::new() };
    line.start().exchange(5);
    let report = capture("made", &line.capture()[..], manuals()).expect("a capture");
    let [ar] = &report.ars[..] else { panic!("one connection: {:?}", report.ars) };
    assert_eq!((ar.stage, ar.rt_in.frames, ar.rt_out.frames, ar.rt_in.lost), ("ready", 5, 5, 0));
    assert!(against_devices(&report).is_empty(), "{:#?}", against_devices(&report));
}

/// A network tap has one interface for each direction; the frames of the file are not strictly ordered by time.
#[test]
fn frames_of_a_tap_are_sorted_by_time() {
    for recording in CONFORMING.iter().chain(BUGGY.iter()).filter(|recording| recording.link == LinkType::ETHERNET) {
        let before = ids(&recording.replayed(manuals()));
        let mut frames: Vec<(usize, Time, &[u8])> = recording
            .frames
            .iter()
            .map(|(time, frame)| (usize::from(is_from_controller(frame)), *time, &frame[..]))
            .collect();
        // Each interface writes its frames in blocks of half a millisecond.
        frames.sort_by_key(|(interface, time, _)| (time.as_nanos() / 500_000, *interface, *time));
        let mut writer = PcapngWriter::new(Vec::new(), "made by a test").expect("a vector takes all");
        let taps = ["to", "from"].map(|name| writer.interface(name, LinkType::ETHERNET).expect("a vector takes all"));
        for (interface, time, frame) in frames {
            writer.packet(taps[interface], time, frame, None).expect("a vector takes all");
        }
        let file = writer.finish().expect("a vector takes all");
        let report = capture("tap", &file[..], manuals()).expect("a capture");
        assert!(ids(&report).is_subset(&before), "{}: {:#?}", recording.name, against_devices(&report));
    }
}
