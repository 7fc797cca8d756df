//! The language on each bus: the tables of names, settings, services and codes that are not the same on both.
//!
//! The readers of the language take what they need from the dialect of the device and do not ask which bus it is.

use super::access::{self, PLACE_ON_PROFINET, ServiceEntry};
use super::codes::{self, Tables};
use super::device::{Bus, PerBus};
use super::names::{self, Sentences};
use super::{profibus, start};

/// What is said otherwise on one bus than on the other.
pub(super) struct Dialect {
    /// Names that every device has on this bus alone.
    pub names: Sentences,
    /// The keys of `start` and `connect` besides start parameters.
    pub settings: Sentences,
    /// The services of `send`.
    pub services: &'static [ServiceEntry],
    /// Keys of `instead` in a parameter request that only the other bus has.
    pub no_place: &'static [&'static str],
    /// Keys of `instead` in a parameter request that only this bus has.
    pub other_place: Sentences,
    /// The codes of the answers to a service, each table with its name in messages.
    pub codes: fn(codes::Service) -> Tables,
    /// What the bus is called.
    pub bus: &'static str,
    /// What a bench file says for a link to the bus.
    pub links: &'static str,
}

static DIALECTS: PerBus<Dialect> = PerBus {
    profinet: Dialect {
        names: names::ON_PROFINET,
        settings: start::SETTINGS,
        services: access::SERVICES,
        no_place: &[],
        other_place: &[],
        codes: codes::on_profinet,
        bus: "PROFINET",
        links: "`nic:INTERFACE` or `socket:ADDRESS`",
    },
    profibus: Dialect {
        names: names::ON_PROFIBUS,
        settings: profibus::SETTINGS,
        services: profibus::SERVICES,
        no_place: PLACE_ON_PROFINET,
        other_place: profibus::INSTEAD_PARAMETERS,
        codes: codes::on_profibus,
        bus: "PROFIBUS",
        links: "`serial:TTY`",
    },
};

/// The dialect of a bus.
pub(super) fn of(bus: Bus) -> &'static Dialect {
    DIALECTS.of(bus)
}

/// The dialects of both.
pub(super) fn both() -> &'static PerBus<Dialect> {
    &DIALECTS
}

/// The dialect of the other bus.
pub(super) fn other_than(bus: Bus) -> &'static Dialect {
    if bus.is_profibus() { &DIALECTS.profinet } else { &DIALECTS.profibus }
}

/// What a bench file says for a link to a bus.
pub fn links(bus: Bus) -> &'static str {
    of(bus).links
}
