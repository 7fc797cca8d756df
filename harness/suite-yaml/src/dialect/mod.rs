//! The language on each bus: the tables of names, settings, services and codes that are not the same on both.
//!
//! The readers of the language take what they need from the dialect of the device and do not ask which bus it is.

mod codes;
mod profibus;
mod profinet;

pub(super) use codes::Service;

use codes::Tables;
use suite::device::{Bus, PerBus};

/// Names, each with what it is.
pub(super) type Sentences = &'static [(&'static str, &'static str)];

/// A service of `send`: its word, its fields, and one sentence.
pub(super) type ServiceEntry = (&'static str, &'static [&'static str], &'static str);

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
    ("io.input_length", "octets of input data"),
    ("io.cyclic", "whether we send cyclic frames: running, paused"),
    ("connection", "data or none, as our controller sees it"),
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
    ("answer.bytes", "the octets of the last response"),
    ("bench.address", "the controller's address"),
    ("cycle", "the time between two cyclic frames"),
    ("elapsed", "the time between this cyclic frame and the one before it of the same direction, as it was seen"),
    ("timing.reaction", "the default deadline"),
    ("timing.start", "from Connect to the first good sample"),
    ("timing.power_up", "from power to an answer"),
    ("timing.save", "saving"),
];

static DIALECTS: PerBus<Dialect> = PerBus {
    profinet: Dialect {
        names: profinet::NAMES,
        settings: profinet::SETTINGS,
        services: profinet::SERVICES,
        no_place: &[],
        other_place: &[],
        codes: codes::on_profinet,
        bus: "PROFINET",
        links: "`nic:INTERFACE` or `socket:ADDRESS`",
    },
    profibus: Dialect {
        names: profibus::NAMES,
        settings: profibus::SETTINGS,
        services: profibus::SERVICES,
        no_place: profinet::PLACE,
        other_place: profibus::PLACE,
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
