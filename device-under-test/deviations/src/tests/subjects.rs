//! Devices built from a manual and bugs.

use crate::{Line, ReferenceDevice, Setup, Subject, build, subject, subjects};
use alloc::string::ToString;
use alloc::vec::Vec;
use reference_devices::manuals::MANUALS;
use rstest::rstest;
use station::{StandAction, Time};
use wire::profibus::fdl::BaudRate;

const SETUP: Setup<'_> = Setup {
    mac: [2, 0, 0, 0, 1, 0],
    bugs: &[],
    shaft: 5,
    station_name: "encoder-under-test",
    ip: [192, 168, 0, 10],
    mask: [255, 255, 255, 0],
    gateway: [0; 4],
    line: Line { address: 3, baud: BaudRate(1_500_000) },
};

fn known(name: &str) -> &'static Subject {
    subject(name).expect("the manual has a reference device")
}

#[test]
fn every_manual_with_a_device_has_a_subject() {
    let of_bugs: Vec<&str> = subjects().iter().map(|subject| subject.manual.name).collect();
    let of_devices: Vec<&str> = MANUALS.iter().map(|manual| manual.name).collect();
    assert_eq!(of_bugs, of_devices);
}

#[test]
fn every_variant_can_be_built_with_every_bug() {
    for subject in subjects() {
        for variant in subject.manual.variants {
            subject.build(variant, &SETUP).map(|_| ()).expect("all names are known");
            for bug in subject.bugs() {
                let setup = Setup { bugs: &[bug.name], ..SETUP };
                subject.build(variant, &setup).map(|_| ()).expect("all names are known");
            }
        }
    }
}

#[test]
fn bug_names_are_unique_and_sentences_end_with_a_period() {
    for subject in subjects() {
        for (n, bug) in subject.bugs().enumerate() {
            assert!(subject.bugs().take(n).all(|other| other.name != bug.name), "{}", bug.name);
            let is_plain = |octet: u8| octet.is_ascii_lowercase() || octet.is_ascii_digit() || octet == b'-';
            assert!(bug.name.bytes().all(is_plain), "{}", bug.name);
            assert!(bug.sentence.ends_with('.') && bug.sentence.starts_with(|c: char| c.is_ascii_uppercase()));
        }
    }
}

#[test]
fn stand_actions_reach_the_encoder() {
    let mut device = build("lika-xac77-profinet", "xac7718", &SETUP).map_err(|error| error.to_string()).expect("known");
    let act = |device: &mut dyn ReferenceDevice, action| device.act(Time::ZERO, &action);
    assert_eq!(act(&mut *device, StandAction::Fault("memory", true)), Ok(Time::ZERO));
    let turned = act(&mut *device, StandAction::TurnRevolutions { revolutions: 1.0, rpm: 60.0 });
    assert_eq!(turned, Ok(Time::from_nanos(1_000_000_000)));
    for impossible in
        [StandAction::Fault("light", true), StandAction::Button("preset", true), StandAction::Switch("a", 1)]
    {
        assert!(matches!(act(&mut *device, impossible), Err(station::StandRefusal::CannotDo(_))));
    }
    assert_eq!(device.counter(Time::ZERO, "nvm_writes"), Some(0));
    assert_eq!(device.led(Time::ZERO, "status"), None);
}

/// 10 B9 FE: manual of the XAC77, 7.3.
#[rstest]
#[case("lika-xac77-profinet", [0x10, 0xB9, 0xFE, 0, 1, 2])]
#[case("profinet-io", [2, 0, 0, 0, 1, 2])]
fn mac_addresses_begin_with_the_oui_of_the_manual(#[case] name: &str, #[case] mac: [u8; 6]) {
    assert_eq!(known(name).manual.mac([2, 0, 0, 0, 1, 2]), mac);
}

#[rstest]
#[case("xac7717", &[], "the manual lika-xac77-profinet has no variant xac7717")]
#[case("xac7718", &["p922-always-81", "none"], "the devices of lika-xac77-profinet have no bug or variation none")]
fn unknown_names_are_reported(#[case] variant: &str, #[case] bugs: &[&str], #[case] message: &str) {
    let error =
        known("lika-xac77-profinet").build(variant, &Setup { bugs, ..SETUP }).map(|_| ()).expect_err("an unknown name");
    assert_eq!(error.to_string(), message);
    assert!(subject("lika").is_err());
}
