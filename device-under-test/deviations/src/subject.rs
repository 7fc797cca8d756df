//! A manual with the deviations that its devices can have, and devices built from both.

use crate::variations::{self, DescriptionChange};
use alloc::boxed::Box;
use alloc::string::{String, ToString};
use alloc::vec;
use alloc::vec::Vec;
use bugs::tables;
use core::fmt;
use deviation_hooks::seams::Deviations;
use deviation_hooks::{Deviation, DeviationKind};
use device_stack::profinet::StationData;
use encoder_profile::encoder_object::EncoderSpecimen;
use reference_devices::deviations::DeviceDeviations;
use reference_devices::{DeviceManual, Line, ManualBus, ReferenceDevice};

/// A manual that has a reference device, with the deviations that its devices can have.
pub struct Subject {
    /// The manual that the devices follow.
    pub manual: &'static DeviceManual,
}

impl fmt::Debug for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Subject").field(&self.manual.name).finish()
    }
}

/// Compares by identity, since each manual has exactly one subject.
impl PartialEq for Subject {
    fn eq(&self, other: &Subject) -> bool {
        core::ptr::eq(self, other)
    }
}

impl Eq for Subject {}

impl Subject {
    /// Returns the deviations that the devices can have.
    pub fn deviations(&self) -> impl Iterator<Item = &'static Deviation> + Clone {
        let groups = tables::GROUPS.iter().chain(variations::GROUPS).copied().flatten();
        let possible = groups.filter(|group| group.needs.iter().all(|need| need.is_met_by(self.manual)));
        possible.flat_map(|group| group.deviations)
    }

    /// Returns the deviations that are bugs.
    pub fn bugs(&self) -> impl Iterator<Item = &'static Deviation> + Clone {
        self.deviations().filter(|deviation| deviation.kind == DeviationKind::Bug)
    }

    /// Returns the deviations that the manual permits.
    pub fn permitted(&self) -> impl Iterator<Item = &'static Deviation> + Clone {
        self.deviations().filter(|deviation| deviation.kind != DeviationKind::Bug)
    }

    /// Attaches the named deviations (`random:SEED` is a [random combination](Subject::random_variations)), bugs after variations; a
    /// device is built with the result.
    ///
    /// # Errors
    ///
    /// [`BuildError::UnknownBug`] if the devices cannot have one of them.
    pub fn attached(&self, names: &[&str]) -> Result<DeviceDeviations, BuildError> {
        let mut deviations = Deviations::default();
        let mut named = Vec::new();
        for name in names {
            let bug = self.bugs().chain(persona_bugs()).find(|known| known.name == *name);
            let known = bug.map(|bug| vec![bug]).or_else(|| self.variations_of(name));
            let unknown = || BuildError::UnknownBug { manual: self.manual.name, bug: name.to_string() };
            for of in known.ok_or_else(unknown)? {
                // A random combination may have what is also named.
                if !named.iter().any(|before: &&Deviation| before.name == of.name) {
                    named.push(of);
                }
            }
        }
        named.sort_by_key(|deviation| deviation.kind == DeviationKind::Bug);
        named.iter().for_each(|deviation| (deviation.attach)(&mut deviations));
        let varied = named.iter().map(|deviation| deviation.name);
        deviations.start_layout = variations::start_layout(self.manual.name, names.iter().copied(), varied);
        Ok(deviations.attached())
    }

    /// Returns by how many steps two positions of a shaft at rest may differ with the named deviations.
    pub fn position_noise<'a>(&self, names: impl Iterator<Item = &'a str>) -> u32 {
        let varied: Vec<&Deviation> = names.filter_map(|name| self.variations_of(name)).flatten().collect();
        let noise = variations::POSITION_NOISE.iter();
        noise.filter(|(noisy, _)| varied.iter().any(|known| known.name == *noisy)).map(|(_, steps)| steps).sum()
    }

    /// Returns what the named deviations change in the description of the device.
    pub fn description_changes<'a>(&self, names: impl Iterator<Item = &'a str>) -> Vec<DescriptionChange> {
        let names: Vec<&str> = names.collect();
        let varied: Vec<&Deviation> = names.iter().filter_map(|name| self.variations_of(name)).flatten().collect();
        let changes = variations::CHANGES.iter();
        let changes = changes.filter(|(of, _)| varied.iter().any(|known| known.name == *of));
        let varied = varied.iter().map(|known| known.name);
        let layout = variations::start_layout(self.manual.name, names.iter().copied(), varied);
        let layout = layout.map(|(_, layout)| DescriptionChange::StartParameters(layout));
        changes.map(|(_, change)| change.clone()).chain(layout).collect()
    }

    /// Builds a device of this variant, with power on and the cable plugged in.
    pub fn build(&self, variant: &str, setup: &Setup<'_>) -> Result<Box<dyn ReferenceDevice>, BuildError> {
        let Setup { station_name, ip, mask, gateway, line, .. } = *setup;
        self.with_station(variant, setup, StationData { name: Vec::from(station_name), ip, mask, gateway }, line)
    }

    /// Like [`build`](Subject::build), but with the factory name and addresses instead of those of `setup`.
    pub fn build_in_factory_state(
        &self,
        variant: &str,
        setup: &Setup<'_>,
    ) -> Result<Box<dyn ReferenceDevice>, BuildError> {
        let (station, line) = match self.manual.bus {
            ManualBus::Profinet(profinet) => ((profinet.factory_station)(variant), setup.line),
            ManualBus::Profibus(profibus) => {
                (StationData::default(), Line { address: profibus.factory_address, ..setup.line })
            }
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

/// The individual data of a reference device.
#[derive(Clone, Debug)]
pub struct Setup<'a> {
    /// The MAC address.
    pub mac: [u8; 6],
    /// The names of its bugs.
    pub bugs: &'a [&'a str],
    /// The position of the shaft in hardware steps from the physical zero.
    pub shaft: u64,
    /// The stored station name; empty if there is none.
    pub station_name: &'a str,
    /// The stored IP address; 0.0.0.0 if there is none.
    pub ip: [u8; 4],
    /// The stored subnet mask.
    pub mask: [u8; 4],
    /// The stored gateway address.
    pub gateway: [u8; 4],
    /// Station address and baud rate of a PROFIBUS device.
    pub line: Line,
}

/// No bugs, no name and no IP addresses.
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
    /// No reference device follows this manual.
    #[error("there is no reference device for the manual {0}")]
    UnknownManual(String),
    /// The manual does not describe this variant.
    #[error("the manual {manual} has no variant {variant}")]
    UnknownVariant {
        /// The manual.
        manual: &'static str,
        /// The requested variant.
        variant: String,
    },
    /// The devices of the manual cannot have this bug.
    #[error("the devices of {manual} have no bug or variation {bug}")]
    UnknownBug {
        /// The manual.
        manual: &'static str,
        /// The requested bug.
        bug: String,
    },
}

/// Returns the bugs that no manual lists because only personas of real controllers find them; every device can have them.
pub fn persona_bugs() -> impl Iterator<Item = &'static Deviation> + Clone {
    tables::persona_bugs::BUGS.iter()
}
