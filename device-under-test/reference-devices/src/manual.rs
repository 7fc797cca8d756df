//! What a manual is here: its name, its variants, its facts, and how one of its devices is built.

use crate::deviations::DeviceDeviations;
use alloc::boxed::Box;
use core::fmt;
use device_stack::profinet::{IoDevice, StationData};
use encoder_profile::encoder_object::{EncoderModel, EncoderObject, EncoderSpecimen};
use encoder_profile::facts::ManualFacts;
use wire::ethernet::Mac;
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
    /// What it says of its encoders, where they are of the encoder profile.
    pub facts: Option<&'static ManualFacts>,
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

/// Builds a device from its variant, its deviations and the data of this piece.
pub type BuildProfinet = fn(&str, &DeviceDeviations, EncoderSpecimen) -> Option<Box<dyn ReferenceDevice>>;

/// The devices of a manual on PROFIBUS DP.
#[derive(Clone, Copy, Debug)]
pub struct Profibus {
    /// The station address with which a device is delivered.
    pub delivered: u8,
    /// Builds a device of a variant; `None` if there is no such variant.
    pub build: BuildProfibus,
}

/// Builds a device from its variant, its deviations, the place of its shaft and its line.
pub type BuildProfibus = fn(&str, &DeviceDeviations, u64, Line) -> Option<Box<dyn ReferenceDevice>>;

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

impl Manual {
    /// A device of a variant with these deviations, with power and plugged in; `None` if there is no such variant.
    pub fn build(
        &self,
        variant: &str,
        deviations: &DeviceDeviations,
        piece: EncoderSpecimen,
        line: Line,
    ) -> Option<Box<dyn ReferenceDevice>> {
        match self.bus {
            Bus::Profinet(profinet) => (profinet.build)(variant, deviations, piece),
            Bus::Profibus(profibus) => (profibus.build)(variant, deviations, piece.shaft, line),
        }
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

/// An encoder of the encoder profile behind its PROFINET stack; `None` if `facts` have no variant of this name.
pub fn encoder<M: EncoderModel + 'static>(
    facts: &'static ManualFacts,
    model: M,
    variant: &str,
    deviations: &DeviceDeviations,
    piece: EncoderSpecimen,
) -> Option<Box<dyn ReferenceDevice>> {
    let variant = facts.variants.iter().find(|known| known.name == variant)?;
    let mac = Mac(piece.mac);
    let encoder = EncoderObject::new(facts, model, variant, deviations.encoder.clone(), piece);
    Some(Box::new(IoDevice::new(encoder, mac, deviations.stack.clone())))
}
