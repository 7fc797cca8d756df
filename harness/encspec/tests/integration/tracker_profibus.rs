//! The PROFIBUS tracker with hand-made frames.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::common::handmade::bus::*;
use encspec::observe::{ArStage, CyclicStatus, Dp, DpTracker, FrameDirection, Observation};
use station::{Duration, Time};
use wire::profibus::fdl::{AnswerFunction, FdlFrame};

/// Frame number and kind of each observation.
fn observed(bus: &BusFrames) -> (DpTracker, Vec<String>) {
    observed_by(DpTracker::new(), bus)
}

fn observed_by(mut tracker: DpTracker, bus: &BusFrames) -> (DpTracker, Vec<String>) {
    let mut list = Vec::new();
    for (index, (time, octets)) in bus.frames.iter().enumerate() {
        tracker.frame(index as u64 + 1, *time, octets, &mut |_, observation| {
            if !matches!(observation, Observation::Traffic(_)) {
                list.push(format!("{} {}", index + 1, word(&observation)));
            }
        });
    }
    (tracker, list)
}

fn word(observation: &Observation<'_>) -> String {
    match observation {
        Observation::Cyclic { direction, data, status, .. } => {
            let prefix = match direction {
                FrameDirection::ToDevice => "out",
                FrameDirection::ToController => "in",
            };
            let pending = *status == CyclicStatus::Fdl { diagnosis_pending: true };
            format!("{prefix} {data:?}{}", if pending { " pending" } else { "" })
        }
        Observation::Connected { .. } => "connected".into(),
        Observation::Released { .. } => "released".into(),
        Observation::Starved { direction, .. } => format!("starved {direction:?}"),
        Observation::Record { written, target, data, status, .. } => {
            let verb = if *written { "write" } else { "read" };
            format!("{verb} {}/{} {data:?} {:08X}", target.1, target.3, u32::from(*status))
        }
        Observation::CallFailed { service, .. } => format!("{service} failed"),
        Observation::Dp { event, .. } => match event {
            Dp::Diagnosis { octets, at, .. } => format!("diagnosis of {} at {at}", octets.len()),
            Dp::Parameters { .. } => "parameters".into(),
            Dp::Configuration { .. } => "configuration".into(),
            Dp::AddressGiven { address, .. } => format!("address {address}"),
            Dp::Control { control, .. } => format!("control {:02X}", control.command.0),
            Dp::Left { why } => format!("left {why:?}"),
        },
        Observation::Unreadable { .. } => "unreadable".into(),
        other => format!("{other:?}"),
    }
}

#[test]
fn a_connection_is_observed_from_parameters_to_release() {
    let mut bus = BusFrames::default();
    bus.token();
    bus.start();
    bus.exchange(2);
    bus.ask(None, &[9, 9, 9, 9]);
    bus.answer(AnswerFunction::DATA_HIGH, None, &[1, 2, 3, 4]);
    bus.diagnosis(&GOOD);
    bus.acknowledged(61, &UNLOCK);
    let (tracker, list) = observed(&bus);
    let expected = [
        "3 diagnosis of 6 at 6",
        "5 parameters",
        "7 configuration",
        "9 diagnosis of 6 at 6",
        "11 connected",
        "11 in [1, 2, 3, 0]",
        "12 out [0, 0, 0, 1]",
        "13 in [1, 2, 3, 1]",
        "14 out [9, 9, 9, 9]",
        "15 in [1, 2, 3, 4] pending",
        "17 diagnosis of 6 at 6",
        "19 parameters",
        "19 released",
    ];
    assert_eq!(list, expected);
    let [ar] = tracker.ars() else { panic!("one connection") };
    assert_eq!((ar.stage, ar.device.ident, ar.connect_frame), (ArStage::Released, Some(0x1655), Some(4)));
    assert_eq!((ar.inputs.frames, ar.outputs.frames, ar.outputs.watchdog), (3, 3, Duration::from_millis(100)));
    let slave = ar.slave.as_deref().expect("it was parameterised");
    assert_eq!((slave.parameters.as_deref(), slave.configuration.as_deref()), (Some(&SET_PRM[..]), Some(&CHK_CFG[..])));
}

#[test]
fn a_slave_that_refuses_data_has_left_data_exchange() {
    let mut bus = BusFrames::default();
    bus.token();
    bus.start();
    bus.exchange(1);
    bus.ask(None, &[0, 0, 0, 9]);
    bus.answer(AnswerFunction::NO_SERVICE, None, &[]);
    let (tracker, list) = observed(&bus);
    assert_eq!(list[list.len() - 3..], ["11 in [1, 2, 3, 0]", "12 out [0, 0, 0, 9]", "13 left NoService"]);
    assert_eq!(tracker.ars()[0].stage, ArStage::Left);
}

#[test]
fn wrong_parameters_are_refused_by_the_diagnosis() {
    let mut bus = BusFrames::default();
    bus.acknowledged(61, &SET_PRM);
    bus.acknowledged(62, &CHK_CFG);
    bus.diagnosis(&WRONG);
    let (tracker, list) = observed(&bus);
    assert_eq!(list, ["2 parameters", "4 configuration", "6 diagnosis of 6 at 6", "6 left Diagnosis"]);
    assert_eq!(tracker.ars()[0].stage, ArStage::Refused);
}

/// IEC 61158-6-3: a slave leaves data exchange when its master sends nothing for longer than the watchdog time.
#[test]
fn a_silent_master_triggers_the_watchdog() {
    let mut bus = BusFrames::default();
    bus.start();
    bus.exchange(2);
    bus.pause = Duration::from_millis(90);
    bus.token();
    assert_eq!(observed(&bus).1.last().map(String::as_str), Some("12 in [1, 2, 3, 1]"));
    bus.pause = Duration::from_millis(30);
    bus.token();
    assert_eq!(observed(&bus).1.last().map(String::as_str), Some("14 starved ToDevice"));
}

#[test]
fn a_slave_that_misses_three_cycles_is_lost() {
    let mut bus = BusFrames::default();
    bus.start();
    bus.exchange(1);
    for number in 0..3u8 {
        bus.ask(None, &[0, 0, 0, number]);
        let count = bus.count.unwrap();
        // The master repeats the request first.
        bus.ask_with(count, None, &[0, 0, 0, number]);
        bus.token();
    }
    let (tracker, list) = observed(&bus);
    let outputs = list.iter().filter(|line| line.contains("out")).count();
    assert_eq!((outputs, list.last().map(String::as_str)), (3, Some("19 starved ToController")));
    assert_eq!((tracker.counts().repeated, tracker.ars()[0].stage), (3, ArStage::Starved));
}

/// IEC 61158-4-3: an answer that was lost on its way to the master is requested again, and is the same answer. An analyser has recorded
/// both.
#[test]
fn the_answer_to_a_repeated_request_counts_once() {
    let mut bus = BusFrames::default();
    bus.start();
    bus.exchange(2);
    let once = observed(&bus).1;
    let mut bus = BusFrames::default();
    bus.diagnosis(&NEW);
    bus.acknowledged(61, &SET_PRM);
    repeat(&mut bus);
    bus.acknowledged(62, &CHK_CFG);
    repeat(&mut bus);
    bus.diagnosis(&GOOD);
    repeat(&mut bus);
    bus.exchange(2);
    repeat(&mut bus);
    let (tracker, twice) = observed(&bus);
    let without_numbers = |list: &[String]| -> Vec<String> {
        list.iter().map(|line| line.split_once(' ').map_or("", |parts| parts.1).to_owned()).collect()
    };
    assert_eq!(without_numbers(&twice), without_numbers(&once));
    assert_eq!((tracker.counts().repeated, tracker.ars().len()), (4, 1));
}

/// Records the last request and its answer once more.
fn repeat(bus: &mut BusFrames) {
    let from = bus.frames.len() - 2;
    for octets in [bus.frames[from].1.clone(), bus.frames[from + 1].1.clone()] {
        let (time, _) = bus.frames[bus.frames.len() - 1];
        bus.frames.push((time + Duration::from_millis(1), octets));
    }
}

/// The masters of the harness give a slave up after the retries of one poll, so in their trials nothing follows.
#[test]
fn a_slave_that_misses_a_poll_of_the_harness_is_lost() {
    let mut bus = BusFrames::default();
    bus.start();
    bus.exchange(1);
    bus.ask(None, &[0; 4]);
    let count = bus.count.unwrap();
    bus.ask_with(count, None, &[0; 4]);
    bus.token();
    let (_, list) = observed_by(DpTracker::of_harness(), &bus);
    assert_eq!(list.last().map(String::as_str), Some("13 starved ToController"));
    let (_, list) = observed(&bus);
    assert!(list.iter().all(|line| !line.contains("starved")), "another master may go on: {list:?}");
}

/// A connection established before the capture is unknown until the slave reports its configuration.
#[test]
fn a_connection_established_before_the_capture_is_tracked() {
    let mut bus = BusFrames::default();
    bus.exchange(2);
    bus.ask(Some(59), &[]);
    bus.answer(AnswerFunction::DATA_LOW, Some(59), &CHK_CFG);
    bus.exchange(1);
    let (tracker, list) = observed(&bus);
    assert_eq!(list, ["8 connected", "8 in [1, 2, 3, 0]"]);
    let [ar] = tracker.ars() else { panic!("one connection") };
    assert_eq!((ar.connect_frame, ar.device.ident, ar.stage), (None, None, ArStage::Ready));
}

/// DS_Read of slot 0, index 255: the slave only acknowledges first, then refuses with "invalid index" (0xB0).
#[test]
fn a_record_is_observed_with_its_answer() {
    let mut bus = BusFrames::default();
    bus.start();
    bus.exchange(1);
    bus.ask(Some(51), &[0x5E, 0, 255, 10]);
    bus.send(&FdlFrame::ShortAcknowledgement);
    bus.ask(Some(51), &[]);
    bus.answer(AnswerFunction::DATA_LOW, Some(51), &[0xDE, 0x80, 0xB0, 0]);
    bus.ask(Some(51), &[0x5F, 0, 47, 2, 7, 8]);
    bus.answer(AnswerFunction::DATA_LOW, Some(51), &[0x5F, 0, 47, 2]);
    let (_, list) = observed(&bus);
    assert_eq!(list[list.len() - 2..], ["14 read 0/255 [] DE80B000", "16 write 0/47 [7, 8] 00000000"]);
}

/// Damaged frames do not stop the tracker.
#[test]
fn damaged_frames_do_not_panic() {
    let mut bus = BusFrames::default();
    bus.start();
    bus.exchange(3);
    let mut tracker = DpTracker::new();
    let mut number = 0;
    let mut take = |time: Time, octets: &[u8]| {
        number += 1;
        tracker.frame(number, time, octets, &mut |_, _| {});
    };
    for (time, octets) in &bus.frames {
        for length in 0..octets.len() {
            take(*time, &octets[..length]);
        }
        for bit in 0..octets.len() * 8 {
            let mut flipped = octets.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            take(*time, &flipped);
        }
        take(*time, octets);
    }
    assert!(tracker.counts().unreadable > 1_000);
}
