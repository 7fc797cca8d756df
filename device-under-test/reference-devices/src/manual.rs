//! A manual: its name, its variants, its facts, and how one of its devices is built.

use crate::deviations::DeviceDeviations;
use alloc::boxed::Box;
use core::fmt;
use device_stack::profinet::{IoDevice, StationData};
use encoder_profile::encoder_object::{EncoderModel, EncoderObject, EncoderSpecimen};
use encoder_profile::facts::ManualFacts;
use wire::ethernet::Mac;
use wire::profibus::fdl::BaudRate;

/// A device under test: a station on the wire, with the stand that controls it.
pub trait ReferenceDevice: station::Station + station::Stand {}

impl<T: station::Station + station::Stand> ReferenceDevice for T {}

/// A manual that has a reference device.
pub struct DeviceManual {
    /// The name of its folder under `suites`.
    pub name: &'static str,
    /// The name of the product, for people.
    pub title: &'static str,
    /// The names of the variants that it describes.
    pub variants: &'static [&'static str],
    /// The facts about its encoders, if they follow the encoder profile.
    pub facts: Option<&'static ManualFacts>,
    /// The bus of its devices.
    pub bus: ManualBus,
}

/// The bus of the devices of a manual, and how the devices are built.
#[derive(Clone, Copy, Debug)]
pub enum ManualBus {
    /// PROFINET IO.
    Profinet(Profinet),
    /// PROFIBUS DP.
    Profibus(Profibus),
}

/// The devices of a manual on PROFINET IO.
#[derive(Clone, Copy, Debug)]
pub struct Profinet {
    /// The first three bytes of the MAC addresses, if the manual prints them.
    pub oui: Option<[u8; 3]>,
    /// Returns the factory name and IP addresses of a variant.
    pub factory_station: fn(&str) -> StationData,
    /// Builds a device of a variant; `None` if the variant does not exist.
    pub build: BuildProfinet,
}

/// Builds a device from its variant, its deviations and its individual data.
pub type BuildProfinet = fn(&str, &DeviceDeviations, EncoderSpecimen) -> Option<Box<dyn ReferenceDevice>>;

/// The devices of a manual on PROFIBUS DP.
#[derive(Clone, Copy, Debug)]
pub struct Profibus {
    /// The factory station address.
    pub factory_address: u8,
    /// Builds a device of a variant; `None` if the variant does not exist.
    pub build: BuildProfibus,
}

/// Builds a device from its variant, its deviations, the position of its shaft and its station address and baud rate.
pub type BuildProfibus = fn(&str, &DeviceDeviations, u64, Line) -> Option<Box<dyn ReferenceDevice>>;

/// Station address and baud rate of a device on PROFIBUS.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Line {
    /// The station address, as set by switches or memory.
    pub address: u8,
    /// The baud rate of the bus. A real slave detects it.
    pub baud: BaudRate,
}

impl Default for Line {
    /// Address 3 at 1.5 Mbit/s.
    fn default() -> Line {
        Line { address: 3, baud: BaudRate(1_500_000) }
    }
}

impl fmt::Debug for DeviceManual {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Manual").field(&self.name).finish()
    }
}

impl DeviceManual {
    /// Builds a device of a variant with these deviations, with power on and the cable plugged in; `None` if the variant does not
    /// exist.
    pub fn build(
        &self,
        variant: &str,
        deviations: &DeviceDeviations,
        piece: EncoderSpecimen,
        line: Line,
    ) -> Option<Box<dyn ReferenceDevice>> {
        match self.bus {
            ManualBus::Profinet(profinet) => (profinet.build)(variant, deviations, piece),
            ManualBus::Profibus(profibus) => (profibus.build)(variant, deviations, piece.shaft, line),
        }
    }

    /// Returns the MAC address of a device of this manual, with the last three bytes of `mac`.
    pub fn mac(&self, mac: [u8; 6]) -> [u8; 6] {
        let [a, b, c, d, e, f] = mac;
        let oui = match self.bus {
            ManualBus::Profinet(profinet) => profinet.oui,
            ManualBus::Profibus(_) => None,
        };
        let [a, b, c] = oui.unwrap_or([a, b, c]);
        [a, b, c, d, e, f]
    }
}

/// Builds an encoder of the encoder profile with a PROFINET stack; `None` if `facts` have no variant of this name.
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
