//! The language on each bus: the tables of names, settings, services and codes that are not the same on both.
//!
//! The readers of the language take what they need from the dialect of the device and do not ask which bus it is.

mod codes;
mod profibus;
pub(crate) mod profinet;

pub(super) use codes::Service;

use super::keys::KeySet;
use super::request_keys::{connect_request, parameter_request, slave_request, station_request};
use codes::Tables;
use suite::device::{Bus, PerBus};

/// Names, each with what it is.
pub(super) type Sentences = &'static [(&'static str, &'static str)];

/// A service of `send`: its fields, in a set of its name, and one sentence.
pub(super) type ServiceEntry = (&'static KeySet, &'static str);

/// What is said otherwise on one bus than on the other.
pub(super) struct Dialect {
    /// Names that every device has on this bus alone.
    pub names: Sentences,
    /// The keys of `start` and `connect` other than start parameters.
    pub settings: &'static KeySet,
    /// The services of `send`.
    pub services: &'static [ServiceEntry],
    /// What can be changed in a parameter request.
    pub parameter_request: &'static KeySet,
    /// What can be changed in a request to the station; none where nothing can.
    pub station_request: Option<&'static KeySet>,
    /// What can be changed in a start-up.
    pub start_request: &'static KeySet,
    /// The codes of the answers to a service, each table with its name in messages.
    pub codes: fn(Service) -> Tables,
    /// What the bus is called.
    pub bus: &'static str,
    /// What a bench file says for a link to the bus.
    pub links: &'static str,
}

impl Dialect {
    /// Names that every device on this bus has, with what each is.
    pub(super) fn built_in_names(&self) -> impl Iterator<Item = &'static (&'static str, &'static str)> + use<> {
        ON_BOTH.iter().chain(self.names)
    }
}

/// Names that every device has, with what each is.
const ON_BOTH: Sentences = &[
    ("io.input_length", "bytes of input data"),
    ("io.cyclic", "whether we send cyclic frames: running, paused"),
    ("connection", "data or none: the state of the connection in our controller"),
    ("shaft.speed", "revolutions per minute, clockwise positive"),
    (
        "shaft.acceleration",
        "by how many revolutions per minute each second speeds are reached from now on; 0, as each trial begins: at once",
    ),
    ("shaft.counts", "the raw place in hardware steps"),
    ("power", "up, down"),
    ("link", "up, down"),
    ("supply.voltage", "in volts"),
    ("supply.temperature", "in degrees Celsius"),
    ("answer", "the last answer"),
    ("answer.bytes", "the bytes of the last response"),
    ("bench.address", "the controller's address"),
    ("cycle", "the time between two cyclic frames"),
    ("elapsed", "the time between this cyclic frame and the one before it of the same direction, as observed"),
];

static DIALECTS: PerBus<Dialect> = PerBus {
    profinet: Dialect {
        names: profinet::NAMES,
        settings: &profinet::connection::KEYS,
        services: profinet::SERVICES,
        parameter_request: &parameter_request::KEYS,
        station_request: Some(&station_request::KEYS),
        start_request: &connect_request::KEYS,
        codes: codes::on_profinet,
        bus: "PROFINET",
        links: "`nic:INTERFACE` or `socket:ADDRESS`",
    },
    profibus: Dialect {
        names: profibus::NAMES,
        settings: &profibus::slave_connection::KEYS,
        services: profibus::SERVICES,
        parameter_request: &profibus::PARAMETER_REQUEST,
        station_request: None,
        start_request: &slave_request::KEYS,
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
