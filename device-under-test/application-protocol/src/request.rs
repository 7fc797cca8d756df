//! What the harness sends: one message per line.

use crate::hex::HexText;
use serde::{Deserialize, Serialize};
use std::net::Ipv4Addr;

/// The bus that a program is tested on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ApplicationBus {
    /// PROFINET IO.
    Profinet,
    /// PROFIBUS DP.
    Profibus,
}

/// A message to a program. `now` is the time in nanoseconds since the start of the trial; it never goes backwards.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "message", rename_all = "snake_case", deny_unknown_fields)]
pub enum ApplicationRequest {
    /// The first message: the program describes itself.
    Hello {
        /// The version of the messages.
        version: u32,
        /// The bus.
        bus: ApplicationBus,
    },
    /// A new trial begins with a device in factory state, which has had power for long.
    Reset {
        /// The position of the shaft in hardware steps from the physical zero.
        shaft: u64,
    },
    /// The supply is switched on.
    PowerUp {
        /// The time.
        now: u64,
    },
    /// The supply fails.
    PowerDown {
        /// The time.
        now: u64,
    },
    /// The time of the last answer's `deadline` has come.
    Advance {
        /// The time.
        now: u64,
    },
    /// A connection with cyclic data begins (PROFINET).
    Connect {
        /// The time.
        now: u64,
        /// The number of the connection.
        connection: u32,
        /// The submodules that were connected.
        submodules: Vec<SubmodulePlace>,
    },
    /// All parameters of a connection were sent (PROFINET).
    ParameterEnd {
        /// The time.
        now: u64,
        /// The number of the connection.
        connection: u32,
    },
    /// A connection has ended.
    Disconnect {
        /// The time.
        now: u64,
        /// The number of the connection; on PROFIBUS 0 for the class 1 master, else the access point of the class 2 master.
        connection: u32,
    },
    /// Outputs have arrived, or a frame with inputs is about to be sent (PROFINET).
    Cycle {
        /// The time.
        now: u64,
        /// The outputs that have arrived since the last message, oldest first.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        outputs: Vec<RequestedOutputs>,
        /// Whether the answer has to contain the inputs.
        inputs: bool,
    },
    /// Checks the user parameters of Set_Prm and applies them if they are valid (PROFIBUS).
    SetPrm {
        /// The time.
        now: u64,
        /// User_Prm_Data with the three bytes of DP-V1.
        data: HexText,
    },
    /// Checks the identifiers of Chk_Cfg (PROFIBUS).
    ChkCfg {
        /// The time.
        now: u64,
        /// The identifiers.
        data: HexText,
    },
    /// Data exchange begins (PROFIBUS).
    ExchangeBegins {
        /// The time.
        now: u64,
    },
    /// Data exchange ends (PROFIBUS).
    ExchangeEnds {
        /// The time.
        now: u64,
        /// Why.
        reason: EndWord,
    },
    /// Outputs have arrived, or inputs are about to be sent (PROFIBUS).
    DataExchange {
        /// The time.
        now: u64,
        /// New outputs; `null` if they are cleared or missing, absent if there are none since the last message.
        #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "present")]
        outputs: Option<Option<HexText>>,
        /// Whether the answer has to contain the inputs.
        inputs: bool,
    },
    /// The master sent a Global_Control to the slave or to the group of the bus clock (PROFIBUS).
    Clock {
        /// The time.
        now: u64,
    },
    /// Asks for the blocks of the diagnosis (PROFIBUS).
    Diagnosis {
        /// The time.
        now: u64,
    },
    /// Reads a record.
    ReadRecord {
        /// The time.
        now: u64,
        /// The connection, as in [`ApplicationRequest::Disconnect`]; on PROFINET 0 without a connection.
        connection: u32,
        /// The slot.
        slot: u16,
        /// The subslot (PROFINET).
        #[serde(default, skip_serializing_if = "Option::is_none")]
        subslot: Option<u16>,
        /// The index.
        index: u16,
    },
    /// Writes a record.
    WriteRecord {
        /// The time.
        now: u64,
        /// The connection, as in [`ApplicationRequest::ReadRecord`].
        connection: u32,
        /// The slot.
        slot: u16,
        /// The subslot (PROFINET).
        #[serde(default, skip_serializing_if = "Option::is_none")]
        subslot: Option<u16>,
        /// The index.
        index: u16,
        /// The data.
        data: HexText,
    },
    /// Resets stored data to factory state (PROFINET).
    FactoryReset {
        /// The time.
        now: u64,
        /// Which data.
        scope: ScopeWord,
    },
    /// Name and addresses of the station, which the stack keeps; only for programs that ask for them (PROFINET).
    Station {
        /// The time.
        now: u64,
        /// Name of station; empty without a name.
        name: String,
        /// IP address, 0.0.0.0 without an address.
        ip: Ipv4Addr,
        /// Subnet mask.
        mask: Ipv4Addr,
        /// Standard gateway.
        gateway: Ipv4Addr,
        /// MAC address.
        mac: HexText,
    },
    /// Does something to the device, as a stand would.
    Act {
        /// The time.
        now: u64,
        /// The name, as in `stand` of a bench file.
        name: String,
        /// The value.
        value: StandValue,
        /// The unit of a distance: `counts` or `revolutions`.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        unit: Option<String>,
        /// The speed of a movement in revolutions per minute.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        rpm: Option<f64>,
        /// The acceleration in revolutions per minute per second.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        acceleration: Option<f64>,
    },
    /// Asks what an LED shows.
    Led {
        /// The time.
        now: u64,
        /// The name of the LED.
        name: String,
        /// What holds of the stack, as words.
        stack: Vec<String>,
    },
    /// Asks for the value of a counter.
    Counter {
        /// The time.
        now: u64,
        /// The name of the counter.
        name: String,
    },
}

impl ApplicationRequest {
    /// The words of all messages, in the order of their description.
    pub const WORDS: [&'static str; 23] = [
        "hello",
        "reset",
        "power_up",
        "power_down",
        "advance",
        "connect",
        "parameter_end",
        "disconnect",
        "cycle",
        "set_prm",
        "chk_cfg",
        "exchange_begins",
        "exchange_ends",
        "data_exchange",
        "clock",
        "diagnosis",
        "read_record",
        "write_record",
        "factory_reset",
        "station",
        "act",
        "led",
        "counter",
    ];

    /// The word of this message.
    pub fn word(&self) -> &'static str {
        match self {
            ApplicationRequest::Hello { .. } => "hello",
            ApplicationRequest::Reset { .. } => "reset",
            ApplicationRequest::PowerUp { .. } => "power_up",
            ApplicationRequest::PowerDown { .. } => "power_down",
            ApplicationRequest::Advance { .. } => "advance",
            ApplicationRequest::Connect { .. } => "connect",
            ApplicationRequest::ParameterEnd { .. } => "parameter_end",
            ApplicationRequest::Disconnect { .. } => "disconnect",
            ApplicationRequest::Cycle { .. } => "cycle",
            ApplicationRequest::SetPrm { .. } => "set_prm",
            ApplicationRequest::ChkCfg { .. } => "chk_cfg",
            ApplicationRequest::ExchangeBegins { .. } => "exchange_begins",
            ApplicationRequest::ExchangeEnds { .. } => "exchange_ends",
            ApplicationRequest::DataExchange { .. } => "data_exchange",
            ApplicationRequest::Clock { .. } => "clock",
            ApplicationRequest::Diagnosis { .. } => "diagnosis",
            ApplicationRequest::ReadRecord { .. } => "read_record",
            ApplicationRequest::WriteRecord { .. } => "write_record",
            ApplicationRequest::FactoryReset { .. } => "factory_reset",
            ApplicationRequest::Station { .. } => "station",
            ApplicationRequest::Act { .. } => "act",
            ApplicationRequest::Led { .. } => "led",
            ApplicationRequest::Counter { .. } => "counter",
        }
    }
}

/// Reads a value that may be null, where an absent value means something else.
fn present<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<Option<Option<HexText>>, D::Error> {
    Option::deserialize(deserializer).map(Some)
}

/// A connected submodule.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SubmodulePlace {
    /// Slot.
    pub slot: u16,
    /// Subslot.
    pub subslot: u16,
    /// Ident number of the module.
    pub module_ident: u32,
    /// Ident number of the submodule.
    pub submodule_ident: u32,
}

/// The outputs of a submodule.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RequestedOutputs {
    /// The time of their arrival.
    pub at: u64,
    /// Slot.
    pub slot: u16,
    /// Subslot.
    pub subslot: u16,
    /// The data; `null` if they have become bad or missing.
    pub data: Option<HexText>,
}

/// Why data exchange ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum EndWord {
    /// The watchdog expired.
    Watchdog,
    /// The master unlocked the slave.
    Unlocked,
    /// The master sent new parameters.
    Parameters,
    /// Parameters, configuration or outputs were wrong.
    Fault,
}

/// Which stored data are reset.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ScopeWord {
    /// All data (FactoryReset, suboption 5).
    Factory,
    /// Mode 1: data of the application.
    ApplicationData,
    /// Mode 2: name and addresses.
    Communication,
    /// Mode 3: data of engineering.
    Engineering,
    /// Mode 4: all data.
    AllData,
    /// Mode 8: the device as a whole.
    Device,
    /// Mode 9: the factory firmware image.
    FactoryImage,
    /// A mode that the standard does not define.
    Other,
}

/// The value of an action.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum StandValue {
    /// Whether a fault is present or a button is pressed.
    Flag(bool),
    /// A whole number: a position or the position of a switch.
    Whole(u64),
    /// A speed, a distance, a voltage or a temperature.
    Number(f64),
}
