//! The states of an AR and the waits of the controller, as tables that can be printed.

use crate::words::words;
use core::fmt;
use core::time::Duration;

words! {
    /// The stages of a start-up in their order.
    pub enum ArStartUpStage {
        Check "check" "The values of the connection are checked against their ranges.",
        Identify "identify" "The controller searches for the device.",
        Address "address" "The device receives its IP address.",
        Resolve "resolve" "The address is resolved by ARP.",
        Connect "connect" "Connect opens the AR.",
        Records "records" "The start-up records are written.",
        ParameterEnd "parameter_end" "PrmEnd reports the end of parametrization.",
        ApplicationReady "application_ready" "The device reports ApplicationReady.",
        FirstData "first_data" "The first valid data arrive.",
    }
}

/// The state of the AR as the controller knows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ArState {
    /// No AR.
    None,
    /// A start-up is running.
    Starting(ArStartUpStage),
    /// The AR is established.
    Data,
    /// Release was sent; its answer is pending.
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
    /// The events that a controller can wait for without success.
    pub enum AwaitedEvent {
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
        Call "call" "an answer to the RPC call",
        Ping "ping" "the reply to the echo request",
        Snmp "snmp" "the response to the SNMP request",
        Page "page" "the answer of the web server",
    }
}

/// A wait that timed out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Wait {
    /// The awaited event.
    pub what: AwaitedEvent,
    /// The time waited, from the first attempt.
    pub time: Duration,
}

impl fmt::Display for Wait {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} did not come within {:?}", self.what.sentence(), self.time)
    }
}
