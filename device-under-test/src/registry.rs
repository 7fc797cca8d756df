//! Which manuals there are, and the devices built from them.

use crate::application::StationData;
use crate::behaviour::Behaviour;
use crate::bugs::{self, Bug, Table};
use crate::models::MANUALS;
use alloc::boxed::Box;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use core::fmt;
use wire::profibus::fdl::BaudRate;

/// A device under test: a station on the wire, with the hands that hold it.
pub trait ReferenceDevice: station::Station + station::Stand {}

impl<T: station::Station + station::Stand> ReferenceDevice for T {}

/// A manual that a reference device was written from.
pub struct Manual {
    /// Its name: that of its folder under `suites`.
    pub name: &'static str,
    /// Its title.
    pub title: &'static str,
    /// The variants that it describes.
    pub variants: &'static [&'static str],
    /// The bugs that its devices can be told to have, by the seam at which they are switched on.
    pub bugs: &'static [Table],
    /// How its devices behave without any bug: the profile, and what is right in this manual where it says otherwise.
    pub healthy: fn() -> Behaviour,
    /// The bus that its devices speak.
    pub bus: Bus,
}

/// The bus that the devices of a manual speak, and how they are built for it.
#[derive(Clone, Copy, Debug)]
pub enum Bus {
    /// PROFINET IO.
    Profinet(Profinet),
    /// PROFIBUS DP.
    Profibus(Profibus),
}

/// The devices of a manual on PROFINET IO.
#[derive(Clone, Copy, Debug)]
pub struct Profinet {
    /// The first three octets of the MAC addresses, if the manual prints them.
    pub oui: Option<[u8; 3]>,
    /// The name and the addresses with which a variant is delivered.
    pub delivered: fn(&str) -> StationData,
    /// Builds a device of a variant; `None` if there is no such variant.
    pub build: BuildProfinet,
}

/// Builds a device from its variant, its behaviour, its MAC address, the place of its shaft and its station.
pub type BuildProfinet = fn(&str, Behaviour, [u8; 6], u64, StationData) -> Option<Box<dyn ReferenceDevice>>;

/// The devices of a manual on PROFIBUS DP.
#[derive(Clone, Copy, Debug)]
pub struct Profibus {
    /// The station address with which a device is delivered.
    pub delivered: u8,
    /// Builds a device of a variant; `None` if there is no such variant.
    pub build: BuildProfibus,
}

/// Builds a device from its variant, its behaviour, the place of its shaft and its line.
pub type BuildProfibus = fn(&str, Behaviour, u64, Line) -> Option<Box<dyn ReferenceDevice>>;

/// Where a device stands on a PROFIBUS.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Line {
    /// Its station address, as switches or memory have it.
    pub address: u8,
    /// The rate of the bus, which a slave finds by itself.
    pub baud: BaudRate,
}

impl Default for Line {
    /// Address 3 at 1.5 Mbit/s.
    fn default() -> Line {
        Line { address: 3, baud: BaudRate(1_500_000) }
    }
}

impl fmt::Debug for Manual {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Manual").field(&self.name).finish()
    }
}

/// Two are the same if they are one; there is nothing else to compare.
impl PartialEq for Manual {
    fn eq(&self, other: &Manual) -> bool {
        core::ptr::eq(self, other)
    }
}

impl Eq for Manual {}

impl Manual {
    /// The bugs that its devices can be told to have.
    pub fn bugs(&self) -> impl Iterator<Item = &'static Bug> + Clone {
        self.bugs.iter().flat_map(Table::bugs)
    }

    /// The MAC address of a device of this manual, with the last three octets of `mac`.
    pub fn mac(&self, mac: [u8; 6]) -> [u8; 6] {
        let [a, b, c, d, e, f] = mac;
        let oui = match self.bus {
            Bus::Profinet(profinet) => profinet.oui,
            Bus::Profibus(_) => None,
        };
        let [a, b, c] = oui.unwrap_or([a, b, c]);
        [a, b, c, d, e, f]
    }
}

/// Every manual that there is a reference device for.
pub fn manuals() -> &'static [&'static Manual] {
    MANUALS
}

/// Every manual that there is a reference device for, and `own` behind them.
pub fn manuals_with(own: &[&'static Manual]) -> Vec<&'static Manual> {
    MANUALS.iter().chain(own).copied().collect()
}

/// What a reference device is given when it is built.
#[derive(Clone, Debug)]
pub struct Setup<'a> {
    /// Its MAC address.
    pub mac: [u8; 6],
    /// The bugs that it has.
    pub bugs: &'a [&'a str],
    /// Where its shaft stands, in hardware steps from the physical zero.
    pub shaft: u64,
    /// Its stored station name; empty if it has none.
    pub station_name: &'a str,
    /// Its stored IP address; zero if it has none.
    pub ip: [u8; 4],
    /// Its stored subnet mask.
    pub mask: [u8; 4],
    /// Its stored gateway.
    pub gateway: [u8; 4],
    /// Where it stands, if it is a device for PROFIBUS.
    pub line: Line,
}

/// A device of nobody in particular: no bugs, no name, no addresses of its own.
impl Default for Setup<'_> {
    fn default() -> Self {
        Setup {
            mac: [2, 0, 0, 0, 1, 0],
            bugs: &[],
            shaft: 0,
            station_name: "",
            ip: [0; 4],
            mask: [0; 4],
            gateway: [0; 4],
            line: Line::default(),
        }
    }
}

/// Why a device could not be built.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BuildError {
    /// There is no such manual.
    #[error("there is no reference device for the manual {0}")]
    UnknownManual(String),
    /// The manual has no such variant.
    #[error("the manual {manual} has no variant {variant}")]
    UnknownVariant {
        /// The manual.
        manual: &'static str,
        /// The variant that was asked for.
        variant: String,
    },
    /// The devices of the manual have no such bug.
    #[error("the devices of {manual} have no bug {bug}")]
    UnknownBug {
        /// The manual.
        manual: &'static str,
        /// The bug that was asked for.
        bug: String,
    },
}

/// The manual of this name.
pub fn manual(name: &str) -> Result<&'static Manual, BuildError> {
    let found = manuals().iter().find(|manual| manual.name == name);
    found.copied().ok_or_else(|| BuildError::UnknownManual(name.to_string()))
}

/// The bugs that no manual lists, because only the manner of another controller shows them; every device can be told to have them.
pub fn bugs_of_the_field() -> impl Iterator<Item = &'static Bug> + Clone {
    Table::Only(
        bugs::stack::BUGS,
        &[
            "advanced-start-refused",
            "little-endian-refused",
            "block-order-fixed",
            "unknown-block-refused",
            "phase-not-1-refused",
            "reduction-of-512-refused",
            "output-frame-id-not-taken",
            "tag-needed",
            "write-multiple-first-only",
        ],
    )
    .bugs()
}

/// The behaviour of a device of `manual` that has these bugs and no others.
pub fn behaviour(manual: &Manual, bugs: &[&str]) -> Result<Behaviour, BuildError> {
    let mut behaviour = (manual.healthy)();
    for name in bugs {
        let bug = manual.bugs().chain(bugs_of_the_field()).find(|bug| bug.name == *name);
        let bug = bug.ok_or_else(|| BuildError::UnknownBug { manual: manual.name, bug: name.to_string() })?;
        (bug.apply)(&mut behaviour);
    }
    Ok(behaviour)
}

/// A device of this manual and variant, with power and plugged in.
pub fn build(name: &str, variant: &str, setup: &Setup<'_>) -> Result<Box<dyn ReferenceDevice>, BuildError> {
    build_manual(manual(name)?, variant, setup)
}

/// A device of this variant of `manual`, which need not be one of [`manuals`], with power and plugged in.
pub fn build_manual(
    manual: &'static Manual,
    variant: &str,
    setup: &Setup<'_>,
) -> Result<Box<dyn ReferenceDevice>, BuildError> {
    let Setup { station_name, ip, mask, gateway, line, .. } = *setup;
    with_station(manual, variant, setup, StationData { name: Vec::from(station_name), ip, mask, gateway }, line)
}

/// The same, but with the name and the addresses of delivery in place of those of `setup`.
pub fn build_delivered(
    manual: &'static Manual,
    variant: &str,
    setup: &Setup<'_>,
) -> Result<Box<dyn ReferenceDevice>, BuildError> {
    let (station, line) = match manual.bus {
        Bus::Profinet(profinet) => ((profinet.delivered)(variant), setup.line),
        Bus::Profibus(profibus) => (StationData::default(), Line { address: profibus.delivered, ..setup.line }),
    };
    with_station(manual, variant, setup, station, line)
}

fn with_station(
    manual: &'static Manual,
    variant: &str,
    setup: &Setup<'_>,
    station: StationData,
    line: Line,
) -> Result<Box<dyn ReferenceDevice>, BuildError> {
    let unknown = || BuildError::UnknownVariant { manual: manual.name, variant: variant.to_string() };
    let behaviour = behaviour(manual, setup.bugs)?;
    let built = match manual.bus {
        Bus::Profinet(profinet) => (profinet.build)(variant, behaviour, setup.mac, setup.shaft, station),
        Bus::Profibus(profibus) => (profibus.build)(variant, behaviour, setup.shaft, line),
    };
    built.ok_or_else(unknown)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;
    use station::{StandAction, Time};

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

    #[test]
    fn every_variant_and_bugs_can_be_built() {
        for manual in manuals() {
            for variant in manual.variants {
                build(manual.name, variant, &SETUP).map(|_| ()).expect("all names are known");
                for bug in manual.bugs() {
                    let setup = Setup { bugs: &[bug.name], ..SETUP };
                    build(manual.name, variant, &setup).map(|_| ()).expect("all names are known");
                }
            }
        }
    }

    #[test]
    fn names_of_bugs_are_unique_and_sentences_are_sentences() {
        for manual in manuals() {
            for (n, bug) in manual.bugs().enumerate() {
                assert!(manual.bugs().take(n).all(|other| other.name != bug.name), "{}", bug.name);
                let is_plain = |octet: u8| octet.is_ascii_lowercase() || octet.is_ascii_digit() || octet == b'-';
                assert!(bug.name.bytes().all(is_plain), "{}", bug.name);
                assert!(bug.sentence.ends_with('.') && bug.sentence.starts_with(|c: char| c.is_ascii_uppercase()));
            }
        }
    }

    #[test]
    fn the_stand_reaches_the_encoder() {
        let mut device =
            build("lika-xac77-profinet", "xac7718", &SETUP).map_err(|error| error.to_string()).expect("known");
        let act = |device: &mut dyn ReferenceDevice, action| device.act(Time::ZERO, &action);
        assert_eq!(act(&mut *device, StandAction::Fault("memory", true)), Ok(Time::ZERO));
        let turned = act(&mut *device, StandAction::TurnRevolutions { revolutions: 1.0, rpm: 60.0 });
        assert_eq!(turned, Ok(Time::from_nanos(1_000_000_000)));
        for impossible in
            [StandAction::Fault("light", true), StandAction::Button("preset", true), StandAction::Switch("a", 1)]
        {
            assert!(matches!(act(&mut *device, impossible), Err(station::Refusal::CannotDo(_))));
        }
        assert_eq!(device.counter(Time::ZERO, "nvm_writes"), Some(0));
        assert_eq!(device.led(Time::ZERO, "status"), None);
    }

    /// 10 B9 FE: manual of the XAC77, 7.3.
    #[rstest]
    #[case("lika-xac77-profinet", [0x10, 0xB9, 0xFE, 0, 1, 2])]
    #[case("profinet-io", [2, 0, 0, 0, 1, 2])]
    fn addresses_begin_as_the_manual_says(#[case] name: &str, #[case] mac: [u8; 6]) {
        assert_eq!(manual(name).expect("it is known").mac([2, 0, 0, 0, 1, 2]), mac);
    }

    #[rstest]
    #[case("xac7717", &[], "the manual lika-xac77-profinet has no variant xac7717")]
    #[case("xac7718", &["p922-always-81", "none"], "the devices of lika-xac77-profinet have no bug none")]
    fn unknown_names(#[case] variant: &str, #[case] bugs: &[&str], #[case] message: &str) {
        let error =
            build("lika-xac77-profinet", variant, &Setup { bugs, ..SETUP }).map(|_| ()).expect_err("an unknown name");
        assert_eq!(error.to_string(), message);
        assert!(manual("lika").is_err());
    }
}
