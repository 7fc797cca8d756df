//! The requests to a master.

use super::connection::SlaveConfig;
use crate::words::words;
use alloc::boxed::Box;
use alloc::vec::Vec;
use core::fmt;
use wire::profibus::address::SetSlaveAddress;
use wire::profibus::call::FunctionIndex;
use wire::profibus::diag::Specifier;
use wire::profibus::dpv1::{Dpv1AbortReason, Endpoint, InitiateFeatures, Subnet};
use wire::profibus::global_control::GlobalControl;

/// A request to a master; it accepts one at a time.
///
/// `to` is the address of a slave. Bytes are sent as they are, valid or not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MasterRequest {
    /// The whole start-up of a slave. Returns [`MasterOutcome::StartUp`](super::MasterOutcome::StartUp).
    Connect(Box<SlaveConfig>),
    /// Ends the exchange and releases the slave by a Set_Prm with Unlock. Returns [`MasterOutcome::Ended`](super::MasterOutcome::Ended).
    Release,
    /// Ends the exchange without a frame; accepted at any time. Returns [`MasterOutcome::Ended`](super::MasterOutcome::Ended).
    Abort,
    /// Slave_Diag. Returns [`MasterOutcome::Answer`](super::MasterOutcome::Answer).
    Diagnosis {
        /// Address of the slave.
        to: u8,
    },
    /// Get_Cfg. Returns [`MasterOutcome::Answer`](super::MasterOutcome::Answer).
    Configuration {
        /// Address of the slave.
        to: u8,
    },
    /// RD_Inp. Returns [`MasterOutcome::Answer`](super::MasterOutcome::Answer).
    ReadInputs {
        /// Address of the slave.
        to: u8,
    },
    /// RD_Outp. Returns [`MasterOutcome::Answer`](super::MasterOutcome::Answer).
    ReadOutputs {
        /// Address of the slave.
        to: u8,
    },
    /// Set_Slave_Address. Returns [`MasterOutcome::Answer`](super::MasterOutcome::Answer).
    SetSlaveAddress {
        /// Address of the slave, usually 126.
        to: u8,
        /// The new address and the other fields.
        set: SetSlaveAddress,
    },
    /// Global_Control; Clear and Operate become the mode of the master. Returns [`MasterOutcome::Sent`](super::MasterOutcome::Sent).
    GlobalControl {
        /// The destination: 127 for all stations.
        to: u8,
        /// The command.
        control: GlobalControl,
    },
    /// FDL status. Returns [`MasterOutcome::Answer`](super::MasterOutcome::Answer).
    FdlStatus {
        /// Address of the station.
        to: u8,
    },
    /// Set_Prm on its own. Returns [`MasterOutcome::Answer`](super::MasterOutcome::Answer).
    SetPrm {
        /// Address of the slave.
        to: u8,
        /// The bytes from the station status on.
        octets: Vec<u8>,
    },
    /// Chk_Cfg on its own. Returns [`MasterOutcome::Answer`](super::MasterOutcome::Answer).
    CheckConfiguration {
        /// Address of the slave.
        to: u8,
        /// The configuration identifiers.
        octets: Vec<u8>,
    },
    /// One Data_Exchange in addition to the cycle. Returns [`MasterOutcome::Answer`](super::MasterOutcome::Answer).
    DataExchange {
        /// Address of the slave.
        to: u8,
        /// The outputs.
        octets: Vec<u8>,
    },
    /// DS_Read over MS1. Returns [`MasterOutcome::Record`](super::MasterOutcome::Record).
    Read {
        /// Address of the slave.
        to: u8,
        /// The slot.
        slot: u8,
        /// The index.
        index: u8,
        /// Maximum length, up to 240 bytes.
        length: u8,
    },
    /// DS_Write over MS1. Returns [`MasterOutcome::Record`](super::MasterOutcome::Record).
    Write {
        /// Address of the slave.
        to: u8,
        /// The slot.
        slot: u8,
        /// The index.
        index: u8,
        /// The record, up to 240 bytes.
        data: Vec<u8>,
    },
    /// Alarm_Ack over MS1. Returns [`MasterOutcome::Record`](super::MasterOutcome::Record).
    AcknowledgeAlarm {
        /// Address of the slave.
        to: u8,
        /// Whether it goes to the access point that only acknowledges alarms (50), not to that of records (51).
        own_access_point: bool,
        /// The slot of the alarm.
        slot: u8,
        /// The type of the alarm, 0 to 126.
        alarm_type: u8,
        /// The specifier of the alarm.
        specifier: Specifier,
    },
    /// CALL over MS1: reads a function behind index 255, such as I&M0. Returns [`MasterOutcome::Record`](super::MasterOutcome::Record).
    Call {
        /// Address of the slave.
        to: u8,
        /// The slot.
        slot: u8,
        /// The function.
        index: FunctionIndex,
    },
    /// A PROFIdrive base mode request: written to data set 47, then the response is read until it is ready. Returns
    /// [`MasterOutcome::Parameter`](super::MasterOutcome::Parameter).
    Parameter {
        /// Address of the slave.
        to: u8,
        /// The slot.
        slot: u8,
        /// The bytes of the request, valid or not.
        request: Vec<u8>,
    },
    /// A service of a class 2 master; the connection stands until Abort, and the master keeps it alive by Idle. Returns
    /// [`MasterOutcome::Ms2`](super::MasterOutcome::Ms2).
    Ms2 {
        /// Address of the slave.
        to: u8,
        /// The service.
        service: Ms2Service,
    },
    /// Any data link request, with or without an answer. Returns [`MasterOutcome::Answer`](super::MasterOutcome::Answer).
    Service {
        /// Address of the station.
        to: u8,
        /// The access point at the slave; `None`: the default one.
        dsap: Option<u8>,
        /// The access point at the master; `None`: the default one.
        ssap: Option<u8>,
        /// The data.
        octets: Vec<u8>,
    },
    /// A request with one answer or a record access, each frame of which is sent again `times` times with the same frame count bit
    /// after it was answered. Returns [`MasterOutcome::Repeated`](super::MasterOutcome::Repeated).
    ///
    /// To a station that this master has not addressed before, a Slave_Diag is sent ahead.
    Repeated {
        /// The request.
        request: Box<MasterRequest>,
        /// How often each frame is sent again.
        times: u8,
    },
    /// Sends bytes as they are. Returns [`MasterOutcome::Sent`](super::MasterOutcome::Sent).
    Raw(Vec<u8>),
    /// Sends a frame damaged on purpose once, and awaits an answer for the slot time. Returns
    /// [`MasterOutcome::Broken`](super::MasterOutcome::Broken).
    Broken {
        /// Address of the station.
        to: u8,
        /// The kind of damage.
        broken: DamagedDpFrame,
    },
}

/// A service on the connection of a class 2 master (MS2).
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ms2Service {
    /// Opens the connection; a master has one.
    Initiate(Ms2Parameters),
    /// Reads a record.
    Read {
        /// The slot.
        slot: u8,
        /// The index.
        index: u8,
        /// Maximum length, up to 240 bytes.
        length: u8,
    },
    /// Writes a record.
    Write {
        /// The slot.
        slot: u8,
        /// The index.
        index: u8,
        /// The record, up to 240 bytes.
        data: Vec<u8>,
    },
    /// CALL: reads a function behind index 255, such as I&M0.
    Call {
        /// The slot.
        slot: u8,
        /// The function.
        index: FunctionIndex,
    },
    /// Closes the connection.
    Abort {
        /// The origin of the abort.
        subnet: Subnet,
        /// Instance and reason.
        reason: Dpv1AbortReason,
    },
}

/// What a class 2 master says of itself in Initiate.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ms2Parameters {
    /// Send_Timeout in 10 ms: the maximum time without a PDU on the connection.
    pub send_timeout: u16,
    /// Features, profile and the additional addresses (S_Type, S_Addr, D_Type, D_Addr).
    pub abilities: InitiateFeatures,
}

impl Default for Ms2Parameters {
    /// A Send_Timeout of 1 s, reading and writing, no profile, and the API 0 of both stations.
    fn default() -> Ms2Parameters {
        let api_0 = || Endpoint { kind: 0, address: Vec::from([0, 0]) };
        let (source, destination) = (api_0(), api_0());
        let (features, profile_features) = ([1, 0], [0, 0]);
        let abilities = InitiateFeatures { features, profile_features, profile: 0, source, destination };
        Ms2Parameters { send_timeout: 100, abilities }
    }
}

/// The master has not finished the previous request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MasterBusy;

impl fmt::Display for MasterBusy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("the master is busy with another request")
    }
}

words! {
    /// A frame damaged on purpose.
    pub enum DamagedDpFrame {
        Checksum "checksum" "A Slave_Diag request whose checksum is wrong.",
        EndDelimiter "end_delimiter" "A Slave_Diag request whose end delimiter is wrong.",
        LengthRepeated "length_repeated" "A Slave_Diag request whose two lengths differ.",
        LengthBeyond "length_beyond" "A Slave_Diag request that announces more bytes than it has.",
        StartDelimiter "start_delimiter" "A Slave_Diag request with a start delimiter that does not exist.",
        Truncated "truncated" "A Slave_Diag request that ends in its middle.",
        UnknownFunction "unknown_function" "A request with a reserved function code.",
        UnknownAccessPoint "unknown_access_point" "A request to an access point that no slave has.",
        SetPrmShort "set_prm_short" "A Set_Prm of three bytes.",
        Noise "noise" "Bytes that are no frame.",
    }
}

impl DamagedDpFrame {
    /// The damaged frame with this word.
    pub fn by_word(word: &str) -> Option<DamagedDpFrame> {
        DamagedDpFrame::TABLE.iter().find(|entry| entry.1 == word).map(|entry| entry.0)
    }
}

/// Every damaged frame that the master can send: its word and its sentence.
pub fn broken_frames() -> impl Iterator<Item = (&'static str, &'static str)> {
    DamagedDpFrame::TABLE.iter().map(|&(_, word, sentence)| (word, sentence))
}
