//! What the tracker of PROFIBUS makes of frames that were made for it.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use crate::common::made::bus::*;
use encspec::observe::{CyclicStatus, Direction, Dp, DpTracker, Observation, Stage};
use station::{Duration, Time};
use wire::profibus::fdl::{AnswerFunction, Frame};

fn told(bus: &Bus) -> (DpTracker, Vec<String>) {
    let mut tracker = DpTracker::new();
    let mut told = Vec::new();
    for (place, (time, octets)) in bus.frames.iter().enumerate() {
        tracker.frame(place as u64 + 1, *time, octets, &mut |_, observation| {
            if !matches!(observation, Observation::Traffic(_)) {
                told.push(format!("{} {}", place + 1, word(&observation)));
            }
        });
    }
    (tracker, told)
}

fn word(observation: &Observation<'_>) -> String {
    match observation {
        Observation::Cyclic { direction, data, status, .. } => {
            let way = match direction {
                Direction::ToDevice => "out",
                Direction::ToController => "in",
            };
            let pending = *status == CyclicStatus::Fdl { diagnosis_pending: true };
            format!("{way} {data:?}{}", if pending { " pending" } else { "" })
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
fn a_connection_is_told_from_parameters_to_release() {
    let mut bus = Bus::default();
    bus.token();
    bus.start();
    bus.exchange(2);
    bus.ask(None, &[9, 9, 9, 9]);
    bus.answer(AnswerFunction::DATA_HIGH, None, &[1, 2, 3, 4]);
    bus.diagnosis(&GOOD);
    bus.acknowledged(61, &UNLOCK);
    let (tracker, told) = told(&bus);
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
    assert_eq!(told, expected);
    let [ar] = tracker.ars() else { panic!("one connection") };
    assert_eq!((ar.stage, ar.device.ident, ar.connect_frame), (Stage::Released, Some(0x1655), Some(4)));
    assert_eq!((ar.inputs.frames, ar.outputs.frames, ar.outputs.watchdog), (3, 3, Duration::from_millis(100)));
    let slave = ar.slave.as_deref().expect("it was parameterised");
    assert_eq!((slave.parameters.as_deref(), slave.configuration.as_deref()), (Some(&SET_PRM[..]), Some(&CHK_CFG[..])));
}

#[test]
fn a_slave_that_refuses_data_has_left() {
    let mut bus = Bus::default();
    bus.token();
    bus.start();
    bus.exchange(1);
    bus.ask(None, &[0, 0, 0, 9]);
    bus.answer(AnswerFunction::NO_SERVICE, None, &[]);
    let (tracker, told) = told(&bus);
    assert_eq!(told[told.len() - 3..], ["11 in [1, 2, 3, 0]", "12 out [0, 0, 0, 9]", "13 left NoService"]);
    assert_eq!(tracker.ars()[0].stage, Stage::Left);
}

#[test]
fn wrong_parameters_are_refused_by_the_diagnosis() {
    let mut bus = Bus::default();
    bus.acknowledged(61, &SET_PRM);
    bus.acknowledged(62, &CHK_CFG);
    bus.diagnosis(&WRONG);
    let (tracker, told) = told(&bus);
    assert_eq!(told, ["2 parameters", "4 configuration", "6 diagnosis of 6 at 6", "6 left Diagnosis"]);
    assert_eq!(tracker.ars()[0].stage, Stage::Refused);
}

/// IEC 61158-6-3: a slave ends by itself when its master is silent for longer than the watchdog.
#[test]
fn a_silent_master_lets_the_slave_starve() {
    let mut bus = Bus::default();
    bus.start();
    bus.exchange(2);
    bus.pause = Duration::from_millis(90);
    bus.token();
    assert_eq!(told(&bus).1.last().map(String::as_str), Some("12 in [1, 2, 3, 1]"));
    bus.pause = Duration::from_millis(30);
    bus.token();
    assert_eq!(told(&bus).1.last().map(String::as_str), Some("14 starved ToDevice"));
}

#[test]
fn a_slave_that_misses_three_cycles_is_gone() {
    let mut bus = Bus::default();
    bus.start();
    bus.exchange(1);
    for number in 0..3u8 {
        bus.ask(None, &[0, 0, 0, number]);
        let count = bus.count.unwrap();
        // The master asks again before it goes on.
        bus.ask_with(count, None, &[0, 0, 0, number]);
        bus.token();
    }
    let (tracker, told) = told(&bus);
    let outputs = told.iter().filter(|told| told.contains("out")).count();
    assert_eq!((outputs, told.last().map(String::as_str)), (3, Some("19 starved ToController")));
    assert_eq!((tracker.counts().repeated, tracker.ars()[0].stage), (3, Stage::Starved));
}

/// What began before the capture is unknown until the slave tells its configuration.
#[test]
fn a_connection_that_was_made_before_is_met() {
    let mut bus = Bus::default();
    bus.exchange(2);
    bus.ask(Some(59), &[]);
    bus.answer(AnswerFunction::DATA_LOW, Some(59), &CHK_CFG);
    bus.exchange(1);
    let (tracker, told) = told(&bus);
    assert_eq!(told, ["8 connected", "8 in [1, 2, 3, 0]"]);
    let [ar] = tracker.ars() else { panic!("one connection") };
    assert_eq!((ar.connect_frame, ar.device.ident, ar.stage), (None, None, Stage::Ready));
}

/// DS_Read of slot 0, index 255: the slave only acknowledges first, then refuses with "invalid index" (0xB0).
#[test]
fn a_record_is_told_with_its_answer() {
    let mut bus = Bus::default();
    bus.start();
    bus.exchange(1);
    bus.ask(Some(51), &[0x5E, 0, 255, 10]);
    bus.send(&Frame::ShortAcknowledgement);
    bus.ask(Some(51), &[]);
    bus.answer(AnswerFunction::DATA_LOW, Some(51), &[0xDE, 0x80, 0xB0, 0]);
    bus.ask(Some(51), &[0x5F, 0, 47, 2, 7, 8]);
    bus.answer(AnswerFunction::DATA_LOW, Some(51), &[0x5F, 0, 47, 2]);
    let (_, told) = told(&bus);
    assert_eq!(told[told.len() - 2..], ["14 read 0/255 [] DE80B000", "16 write 0/47 [7, 8] 00000000"]);
}

/// Whatever is damaged, the tracker goes on.
#[test]
fn every_flipped_bit_and_every_prefix_is_survived() {
    let mut bus = Bus::default();
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
