//! What a trial needs of a bench: abilities of the stand, consents, what the device is said to have, time.
//!
//! It is read off the steps, so that it is known before anything is sent. This room must not know what a bench has.

mod scan;

use crate::model::{Manual, Step, Trial, Variant};
use std::fmt;
use std::time::Duration;
use wire::profibus::fdl::BaudRate;

/// From this much waiting on, a trial runs on a live bench only with the ability `clock` or if asked for with `--long`.
pub const LONG: Duration = Duration::from_secs(60);

/// One thing that a trial needs of the bench.
#[derive(Clone, Debug, PartialEq)]
pub enum Need {
    /// The stand can do this.
    Stand(Ability),
    /// Whoever owns the device agrees to this.
    Consent(Consent),
    /// The device is said to have this.
    Claim(Claim),
    /// It is known where this web page is and what it looks like, which the manual does not print.
    Page(String),
    /// No switch stands between us and the device: LLDP goes no further than to the next port.
    DirectCable,
    /// The trial takes long.
    Long {
        /// How long it waits in all.
        waits: Duration,
        /// How much of it no clock of the stand shortens, since a connection stands or the shaft turns.
        really: Duration,
    },
    /// The bus keeps times that are counted in bits, as a clock that all slaves follow.
    BitTiming,
    /// The bus runs at this rate.
    Rate(BaudRate),
    /// No bench can serve it: it does something that belongs on a virtual wire only, in words.
    Virtual(&'static str),
}

/// Something that a stand does or shows.
#[derive(Clone, Debug, PartialEq)]
pub enum Ability {
    /// Connects and cuts the supply.
    Power,
    /// Plugs and pulls the cable of the bus.
    Link,
    /// The shaft moves, no matter how far and how fast.
    Moves,
    /// The shaft is turned by a way that is known.
    Turn {
        /// The shortest way in hardware steps that is turned; none where the ways are given in revolutions.
        shortest: Option<f64>,
    },
    /// The shaft is brought to a raw place that is known.
    Place,
    /// The shaft turns steadily.
    Speed {
        /// The lowest speed that is not 0, in revolutions per minute; none where it is computed.
        slowest: Option<f64>,
    },
    /// The shaft gets faster and slower evenly.
    Acceleration,
    /// Brings the device into the state in which it was delivered.
    Delivery,
    /// Sets the supply voltage.
    Voltage,
    /// Sets the temperature of the device.
    Temperature,
    /// Makes a condition of the encoder present, by its name in `device.yaml`.
    Fault(String),
    /// Presses a button.
    Button(String),
    /// Turns a coding switch.
    Switch(String),
    /// Looks at an LED.
    Led(String),
    /// Reads a counter.
    Counter(String),
}

/// What may be done to a device only if the bench file says so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Consent {
    /// It is reset to factory settings.
    FactoryReset,
    /// Its station name is changed.
    SetName,
    /// Its address is changed.
    SetIp,
    /// Its station address is changed over the bus.
    SetAddress,
    /// Its memory is written so many times, at most.
    NvmWrite(u32),
    /// Its position is preset.
    PositionReference,
    /// It is told to wait for another firmware.
    Firmware,
}

/// What a device is said to have.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Claim {
    /// This module (telegram), by its name in `device.yaml`.
    Module(String),
    /// This record or parameter, by its name in `device.yaml`.
    Name(String),
}

/// Everything that a trial needs of the bench, each thing once.
///
/// What only checks with requirements of their own ask of the stand is left out: [`of_step`] says it for each of them.
pub fn needs(manual: &Manual, variant: &Variant, trial: &Trial) -> Vec<Need> {
    scan::trial(manual, variant, trial)
}

/// What a single step needs of the bench, for checks that are judged for themselves.
pub fn of_step(manual: &Manual, variant: &Variant, step: &Step) -> Vec<Need> {
    scan::step(manual, variant, step)
}

/// In the words of the bench file.
impl fmt::Display for Consent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Consent::FactoryReset => f.write_str("factory_reset"),
            Consent::SetName => f.write_str("set_name"),
            Consent::SetIp => f.write_str("set_ip"),
            Consent::SetAddress => f.write_str("set_address"),
            Consent::NvmWrite(writes) => write!(f, "nvm_write ({writes})"),
            Consent::PositionReference => f.write_str("position_reference"),
            Consent::Firmware => f.write_str("firmware"),
        }
    }
}

/// The name that `set`, `expect` and the hooks of a bench file use.
impl fmt::Display for Ability {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Ability::Power => f.write_str("power"),
            Ability::Link => f.write_str("link"),
            Ability::Delivery => f.write_str("device"),
            Ability::Moves | Ability::Turn { .. } => f.write_str("turn"),
            Ability::Place => f.write_str("shaft.counts"),
            Ability::Speed { .. } => f.write_str("shaft.speed"),
            Ability::Acceleration => f.write_str("shaft.acceleration"),
            Ability::Voltage => f.write_str("supply.voltage"),
            Ability::Temperature => f.write_str("supply.temperature"),
            Ability::Fault(name) => write!(f, "fault.{name}"),
            Ability::Button(name) => write!(f, "button.{name}"),
            Ability::Switch(name) => write!(f, "switch.{name}"),
            Ability::Led(name) => write!(f, "led.{name}"),
            Ability::Counter(name) => write!(f, "counter.{name}"),
        }
    }
}
