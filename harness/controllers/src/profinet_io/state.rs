//! The states of an AR and the waits of the controller, as tables that can be printed.

use crate::words::words;
use core::fmt;
use core::time::Duration;

words! {
    /// The stages of a start-up in their order.
    pub enum Stage {
        Check "check" "The values of the connection are compared with their limits.",
        Identify "identify" "The device is looked for.",
        Address "address" "The device gets its address.",
        Resolve "resolve" "The address is resolved by ARP.",
        Connect "connect" "The AR is opened.",
        Records "records" "The start-up records are written.",
        ParameterEnd "parameter_end" "The end of parametrization is told.",
        ApplicationReady "application_ready" "The device tells that its application is ready.",
        FirstData "first_data" "The first good data come.",
    }
}

/// What our controller sees of its AR.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ArState {
    /// There is none.
    None,
    /// One is started up.
    Starting(Stage),
    /// One stands.
    Data,
    /// One is released; the answer has not come yet.
    Releasing,
}

impl fmt::Display for ArState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ArState::None => f.write_str("none"),
            ArState::Starting(stage) => write!(f, "starting: {stage}"),
            ArState::Data => f.write_str("data"),
            ArState::Releasing => f.write_str("releasing"),
        }
    }
}

words! {
    /// What the controller can wait for in vain.
    pub enum Waiting {
        Identify "identify" "an answer to DCP Identify",
        StationGet "station_get" "an answer to DCP Get",
        StationSet "station_set" "an answer to DCP Set",
        Arp "arp" "an ARP reply",
        Connect "connect" "the answer to Connect",
        Write "write" "the answer to Write",
        Read "read" "the answer to Read",
        ReadImplicit "read_implicit" "the answer to ReadImplicit",
        ParameterEnd "parameter_end" "the answer to PrmEnd",
        ApplicationReady "application_ready" "ApplicationReady",
        FirstData "first_data" "the first good cyclic data",
        Data "data" "the next cyclic frame",
        AlarmAcknowledged "alarm_acknowledged" "the acknowledgement of our AlarmAck",
        ParameterAnswer "parameter_answer" "the answer to the parameter request",
        Release "release" "the answer to Release",
        Lookup "lookup" "the answer of the endpoint mapper",
        Page "page" "the answer of the web server",
    }
}

/// A wait that ran out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Wait {
    /// What was waited for.
    pub what: Waiting,
    /// How long, from the first time it was asked for.
    pub time: Duration,
}

impl fmt::Display for Wait {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} did not come within {:?}", self.what.sentence(), self.time)
    }
}
