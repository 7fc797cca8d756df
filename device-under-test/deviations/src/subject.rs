//! A manual with the deviations that its devices can have, and the devices built from both.

use crate::seams::Deviations;
use crate::tables::{self, Deviation, Kind};
use alloc::boxed::Box;
use alloc::string::{String, ToString};
use alloc::vec::Vec;
use core::fmt;
use device_stack::profinet::StationData;
use encoder_profile::encoder_object::EncoderSpecimen;
use reference_devices::deviations::DeviceDeviations;
use reference_devices::{Bus, Line, Manual, ReferenceDevice};

/// A manual that a reference device was written from, with the deviations that its devices can have.
pub struct Subject {
    /// The manual.
    pub manual: &'static Manual,
}

impl fmt::Debug for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Subject").field(&self.manual.name).finish()
    }
}

/// Two are the same if they are one; there is nothing else to compare.
impl PartialEq for Subject {
    fn eq(&self, other: &Subject) -> bool {
        core::ptr::eq(self, other)
    }
}

impl Eq for Subject {}

impl Subject {
    /// The deviations that its devices can have.
    pub fn deviations(&self) -> impl Iterator<Item = &'static Deviation> + Clone {
        tables::of(self.manual)
    }

    /// Those of them that are bugs.
    pub fn bugs(&self) -> impl Iterator<Item = &'static Deviation> + Clone {
        self.deviations().filter(|deviation| deviation.kind == Kind::Bug)
    }

    /// Those of them that the manual permits.
    pub fn permitted(&self) -> impl Iterator<Item = &'static Deviation> + Clone {
        self.deviations().filter(|deviation| deviation.kind != Kind::Bug)
    }

    /// What a device is built with that has these deviations and no others.
    pub fn attached(&self, names: &[&str]) -> Result<DeviceDeviations, BuildError> {
        let mut deviations = Deviations::default();
        for name in names {
            let bug = self.deviations().chain(bugs_of_the_field()).find(|known| known.name == *name);
            let bug = bug.ok_or_else(|| BuildError::UnknownBug { manual: self.manual.name, bug: name.to_string() })?;
            (bug.attach)(&mut deviations);
        }
        Ok(deviations.attached())
    }

    /// A device of this variant, with power and plugged in.
    pub fn build(&self, variant: &str, setup: &Setup<'_>) -> Result<Box<dyn ReferenceDevice>, BuildError> {
        let Setup { station_name, ip, mask, gateway, line, .. } = *setup;
        self.with_station(variant, setup, StationData { name: Vec::from(station_name), ip, mask, gateway }, line)
    }

    /// The same, but with the name and the addresses of delivery in place of those of `setup`.
    pub fn build_delivered(&self, variant: &str, setup: &Setup<'_>) -> Result<Box<dyn ReferenceDevice>, BuildError> {
        let (station, line) = match self.manual.bus {
            Bus::Profinet(profinet) => ((profinet.delivered)(variant), setup.line),
            Bus::Profibus(profibus) => (StationData::default(), Line { address: profibus.delivered, ..setup.line }),
        };
        self.with_station(variant, setup, station, line)
    }

    fn with_station(
        &self,
        variant: &str,
        setup: &Setup<'_>,
        station: StationData,
        line: Line,
    ) -> Result<Box<dyn ReferenceDevice>, BuildError> {
        let deviations = self.attached(setup.bugs)?;
        let piece = EncoderSpecimen { mac: setup.mac, shaft: setup.shaft, station };
        let built = self.manual.build(variant, &deviations, piece, line);
        built.ok_or_else(|| BuildError::UnknownVariant { manual: self.manual.name, variant: variant.to_string() })
    }
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

/// The bugs that no manual lists, because only the persona of another controller shows them; every device can have them.
pub fn bugs_of_the_field() -> impl Iterator<Item = &'static Deviation> + Clone {
    tables::field::BUGS.iter()
}
