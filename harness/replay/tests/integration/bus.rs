//! Wrong answers on PROFIBUS, each with a counterpart in order that has no finding.

use crate::handmade::bus::{BusFrames, GOOD, MASTER, SLAVE};
use encspec_replay::{CaptureBlame, CaptureFinding, FindingSeverity, capture};
use station::Duration;
use wire::profibus::fdl::{AnswerFunction, DataFrame, Extension, FdlFrame, FunctionCode, StationType};

fn findings(bus: &BusFrames) -> Vec<CaptureFinding> {
    capture("made", &bus.capture()[..], &[]).expect("a capture").findings
}

#[track_caller]
fn only(bus: &BusFrames, id: &str) -> CaptureFinding {
    let all = findings(bus);
    let [finding] = &all[..] else { panic!("one finding {id}: {all:#?}") };
    assert_eq!(finding.id, id, "{}", finding.text);
    finding.clone()
}

fn started() -> BusFrames {
    let mut bus = BusFrames::default();
    bus.token();
    bus.start();
    bus.exchange(10);
    bus
}

#[test]
fn inputs_of_another_length_than_configured() {
    let mut bus = started();
    for number in 0..3 {
        bus.ask(None, &[0, 0, 1, number]);
        bus.answer(AnswerFunction::DATA_LOW, None, &[1, 2, 3, 4, number]);
    }
    bus.exchange(5);
    let finding = only(&bus, "DP-INPUT-LENGTH");
    assert_eq!((finding.blame, finding.severity), (CaptureBlame::Device, FindingSeverity::Error));
    assert!(finding.text.contains("5 bytes") && finding.text.contains("has 4"), "{}", finding.text);
}

#[test]
fn a_diagnosis_without_its_fixed_bit() {
    let mut bus = started();
    for _ in 0..3 {
        bus.diagnosis(&[GOOD[0], GOOD[1] & !0x04, GOOD[2], GOOD[3], GOOD[4], GOOD[5]]);
        bus.exchange(3);
    }
    let finding = only(&bus, "DP-DIAGNOSIS-FIXED-BIT");
    assert_eq!((finding.blame, finding.bit), (CaptureBlame::Device, Some(2)));
    assert!(finding.octet.is_some());
}

/// The data of Set_Slave_Address: new address, ident number, and that it may be changed again.
const TO_TEN: [u8; 4] = [10, 0x16, 0x55, 0];

#[test]
fn an_address_that_was_acknowledged_and_ignored() {
    let mut bus = BusFrames::default();
    bus.acknowledged(55, &TO_TEN);
    for _ in 0..4 {
        bus.diagnosis(&[0x02, 0x05, 0x00, 0xFF, 0x16, 0x55]);
    }
    let finding = only(&bus, "DP-ADDRESS-IGNORED");
    assert_eq!((finding.frame, finding.blame), (2, CaptureBlame::Undecided));
    assert!(finding.text.contains("address 10"), "{}", finding.text);

    // The request names another type of device, which the slave rightly does not obey.
    let mut bus = BusFrames::default();
    bus.acknowledged(55, &[10, 0x99, 0x99, 0]);
    for _ in 0..4 {
        bus.diagnosis(&[0x02, 0x05, 0x00, 0xFF, 0x16, 0x55]);
    }
    assert_eq!(only(&bus, "DP-ADDRESS-IGNORED").blame, CaptureBlame::Controller);

    // Nothing more is heard of the old address.
    let mut bus = BusFrames::default();
    bus.acknowledged(55, &TO_TEN);
    assert_eq!(findings(&bus), []);
}

/// An answer of the slave from an access point, to a station and one of its access points.
fn answer_from(bus: &mut BusFrames, sap: Option<u8>, (receiver, to): (u8, Option<u8>), data: &[u8]) {
    let extension = |number: Option<u8>| number.map_or(Extension::NONE, Extension::sap);
    let fc = FunctionCode::answer(AnswerFunction::DATA_LOW, StationType::SLAVE);
    bus.send(&FdlFrame::Data(DataFrame::new((receiver, extension(to)), (SLAVE, extension(sap)), fc, data)));
}

#[test]
fn answers_from_another_access_point_and_to_others() {
    let mut bus = started();
    for _ in 0..3 {
        bus.ask(Some(60), &[]);
        answer_from(&mut bus, Some(59), (MASTER, Some(62)), &GOOD);
        bus.exchange(2);
    }
    let finding = only(&bus, "DP-ANSWER-WRONG");
    assert_eq!(finding.blame, CaptureBlame::Device);
    assert!(finding.text.contains("SAP 59 instead of SAP 60"), "{}", finding.text);

    let mut bus = started();
    for number in 0..3 {
        bus.ask(None, &[0, 0, 1, number]);
        answer_from(&mut bus, None, (7, None), &[1, 2, 3, number]);
        bus.exchange(2);
    }
    let all = findings(&bus);
    let finding = all.iter().find(|of| of.id == "DP-ANSWER-WRONG").unwrap_or_else(|| panic!("{all:#?}"));
    assert!(finding.text.contains("to station 7"), "{}", finding.text);
}

/// High priority asks the master to read a diagnosis; the slave does not leave the data exchange by it.
#[test]
fn an_answer_of_high_priority_is_not_the_end_of_the_data_exchange() {
    let mut bus = started();
    for number in 0..3 {
        bus.ask(None, &[0, 0, 1, number]);
        bus.answer(AnswerFunction::DATA_HIGH, None, &[1, 2, 3, number]);
        bus.diagnosis(&GOOD);
        bus.exchange(3);
    }
    assert_eq!(findings(&bus), []);
    // Also a diagnosis may be answered so.
    bus.ask(Some(60), &[]);
    bus.answer(AnswerFunction::DATA_HIGH, Some(60), &GOOD);
    bus.exchange(3);
    assert_eq!(findings(&bus), []);
}

#[test]
fn a_token_twice_explains_what_it_disturbs() {
    let mut bus = started();
    bus.send(&FdlFrame::Token { da: 3, sa: MASTER });
    bus.exchange(2);
    bus.send(&FdlFrame::Token { da: 3, sa: 3 });
    assert_eq!(only(&bus, "DP-TOKEN-TWICE").blame, CaptureBlame::Controller);
}

/// A slave in data exchange that is given another address falls silent at its old one: one cause.
#[test]
fn another_address_explains_the_silence() {
    let mut bus = started();
    bus.acknowledged(55, &TO_TEN);
    for number in 0..8 {
        bus.ask(None, &[0, 0, 1, number]);
        bus.pause = Duration::from_millis(20);
    }
    let finding = only(&bus, "DP-ADDRESS-GIVEN");
    let followed: Vec<&str> = finding.consequences.iter().map(|of| of.id.as_str()).collect();
    assert_eq!((followed, finding.blame), (vec!["DP-SLAVE-SILENT"], CaptureBlame::Network));
}

/// Read of a record by MS1: slot 1, index 2, up to 8 bytes.
const READ: [u8; 4] = [0x5E, 1, 2, 8];

#[test]
fn an_acyclic_answer_that_cannot_be_read() {
    let asked = |answer: &[u8]| {
        let mut bus = started();
        for _ in 0..2 {
            bus.ask_from(Some(51), 51, &READ);
            bus.answer_to(Some(51), 51, answer);
            bus.exchange(2);
        }
        bus
    };
    let finding = only(&asked(&[0x5E]), "DP-ANSWER-WRONG");
    assert!(finding.text.contains("1 bytes that cannot be read"), "{}", finding.text);
    assert_eq!(findings(&asked(&[0x5E, 1, 2, 2, 7, 7])), []);
}
