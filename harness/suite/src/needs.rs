//! What a trial needs from a bench: abilities of the stand, consents, claims about the device, time.
//!
//! The needs are derived from the steps, so they are known before anything is sent.

mod scan;

use crate::model::{Manual, SuiteVariant, Trial, TrialStep};
use std::fmt;
use std::time::Duration;
use wire::profibus::fdl::BaudRate;

/// A trial that waits at least this long runs on a live bench only with the ability `clock` or the option `--long`.
pub const LONG: Duration = Duration::from_secs(60);

/// The rate up to which a kernel keeps the times of a master at a serial line.
pub const FASTEST_LINE: BaudRate = BaudRate(187_500);

/// Why a trial with bit timing does not run on a bench.
pub const CANNOT_TIME_BITS: &str = "link cannot time bits";

/// One need of a trial.
#[derive(Clone, Debug, PartialEq)]
pub enum BenchNeed {
    /// An ability of the stand.
    Stand(Ability),
    /// A consent in the bench file.
    Consent(Consent),
    /// A claim that the device has something.
    Claim(ClaimedFeature),
    /// Path and layout of a web page that the manual does not print.
    Page(String),
    /// No switch between the harness and the device, since LLDP ends at the next port.
    DirectCable,
    /// Time: the trial takes long.
    Long {
        /// Total waiting time.
        waits: Duration,
        /// Part of it that the clock of the stand cannot shorten, since a connection is established or the shaft turns.
        really: Duration,
    },
    /// A bus with bit-accurate timing, for isochronous mode.
    BitTiming,
    /// This transmission rate.
    Rate(BaudRate),
    /// A virtual wire; the reason in words.
    Virtual(&'static str),
}

impl BenchNeed {
    /// Why no live bench serves it; `None` if there may be one that does.
    pub fn never_live(&self) -> Option<String> {
        match self {
            BenchNeed::BitTiming => Some(CANNOT_TIME_BITS.to_owned()),
            BenchNeed::Rate(rate) => (*rate > FASTEST_LINE).then(|| CANNOT_TIME_BITS.to_owned()),
            BenchNeed::Virtual(what) => Some(format!("possible on a virtual wire only: {what}")),
            _ => None,
        }
    }

    /// The line of a bench file, or the option of `encspec run`, that says whether a bench serves it; `None` if no line helps.
    pub fn bench_line(&self) -> Option<String> {
        match self {
            BenchNeed::Stand(ability) => Some(format!("stand {}", ability.group())),
            BenchNeed::Consent(Consent::NvmWrite(_)) => Some("consent nvm_write".to_owned()),
            BenchNeed::Consent(consent) => Some(format!("consent {consent}")),
            BenchNeed::Claim(ClaimedFeature::Module(_)) => Some("telegrams".to_owned()),
            BenchNeed::Claim(ClaimedFeature::Name(_)) => Some("lacks".to_owned()),
            BenchNeed::Page(_) => Some("pages".to_owned()),
            BenchNeed::DirectCable => Some("direct_cable".to_owned()),
            BenchNeed::Long { .. } => Some("--long".to_owned()),
            BenchNeed::Rate(_) if self.never_live().is_none() => Some("line baud".to_owned()),
            BenchNeed::BitTiming | BenchNeed::Rate(_) | BenchNeed::Virtual(_) => None,
        }
    }
}

/// An ability of a stand.
#[derive(Clone, Debug, PartialEq)]
pub enum Ability {
    /// Switches the supply on and off.
    Power,
    /// Plugs and pulls the cable of the bus.
    Link,
    /// Moves the shaft by any angle at any speed.
    Moves,
    /// Turns the shaft by a known angle.
    Turn {
        /// The smallest angle in hardware steps; `None` if all angles are given in revolutions.
        shortest: Option<f64>,
    },
    /// Moves the shaft to a known raw position.
    Place,
    /// Turns the shaft at a constant speed.
    Speed {
        /// The lowest speed that is not 0, in revolutions per minute; `None` if it is computed.
        slowest: Option<f64>,
    },
    /// Changes the speed of the shaft with a constant acceleration.
    Acceleration,
    /// Brings the device into its factory state.
    Delivery,
    /// Sets the supply voltage.
    Voltage,
    /// Sets the temperature of the device.
    Temperature,
    /// Causes a fault, by its name in `device.yaml`.
    Fault(String),
    /// Presses a button.
    Button(String),
    /// Sets a coding switch.
    Switch(String),
    /// Reads an LED.
    Led(String),
    /// Reads a counter.
    Counter(String),
}

impl Ability {
    /// What the ability is about: all abilities that move the shaft are one, and so are all LEDs.
    fn group(&self) -> &'static str {
        match self {
            Ability::Power => "power",
            Ability::Link => "link",
            Ability::Moves | Ability::Turn { .. } | Ability::Place | Ability::Speed { .. } | Ability::Acceleration => {
                "shaft"
            }
            Ability::Delivery => "device",
            Ability::Voltage | Ability::Temperature => "supply",
            Ability::Fault(_) => "fault",
            Ability::Button(_) => "button",
            Ability::Switch(_) => "switch",
            Ability::Led(_) => "led",
            Ability::Counter(_) => "counter",
        }
    }
}

/// A lasting change that needs a consent in the bench file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Consent {
    /// Reset to factory settings.
    FactoryReset,
    /// Change of the station name.
    SetName,
    /// Change of the IP address.
    SetIp,
    /// Change of the station address over the bus (PROFIBUS).
    SetAddress,
    /// Overwriting I&M1 to I&M4, which carry the plant's tags.
    ImRecords,
    /// Locking of the station address until the device is reset.
    LockAddress,
    /// Maximum number of writes to non-volatile memory.
    NvmWrite(u32),
    /// Preset of the position.
    PositionReference,
    /// Switching the device to the mode that waits for a firmware update.
    Firmware,
    /// A supply voltage or a temperature beyond what the manual permits.
    Overstress,
    /// No other station on the network that could be disturbed.
    Alone,
}

/// A claim that the device has something.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ClaimedFeature {
    /// A module (telegram), by its name in `device.yaml`.
    Module(String),
    /// A record or parameter, by its name in `device.yaml`.
    Name(String),
}

/// The needs of a trial, without duplicates.
///
/// Abilities that are needed only by checks with `covers` are left out; [`of_step`] returns them for each check.
pub fn needs(manual: &Manual, variant: &SuiteVariant, trial: &Trial) -> Vec<BenchNeed> {
    scan::trial(manual, variant, trial)
}

/// The needs of one step, for checks that are judged separately.
pub fn of_step(manual: &Manual, variant: &SuiteVariant, step: &TrialStep) -> Vec<BenchNeed> {
    scan::step(manual, variant, step)
}

/// Formats the consent as its key in the bench file.
impl fmt::Display for Consent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Consent::FactoryReset => f.write_str("factory_reset"),
            Consent::SetName => f.write_str("set_name"),
            Consent::SetIp => f.write_str("set_ip"),
            Consent::SetAddress => f.write_str("set_address"),
            Consent::ImRecords => f.write_str("im_records"),
            Consent::LockAddress => f.write_str("lock_address"),
            Consent::NvmWrite(writes) => write!(f, "nvm_write ({writes})"),
            Consent::PositionReference => f.write_str("position_reference"),
            Consent::Firmware => f.write_str("firmware"),
            Consent::Overstress => f.write_str("overstress"),
            Consent::Alone => f.write_str("alone"),
        }
    }
}

/// Formats the ability as the name that `set`, `expect` and hooks of a bench file use.
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
