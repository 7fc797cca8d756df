//! Acyclic requests: content, deviations from the correct request, expected answer.
//!

use super::condition::Matcher;
use crate::device::{AnswerPart, NameId};
use expression::Program;
use serde::{Deserialize, Serialize};
use wire::ethernet::Mac;

/// An acyclic access: all of its items go into one request.
#[derive(Debug, Deserialize, Serialize)]
pub struct AcyclicAccess {
    /// The service that carries it.
    pub via: AccessChannel,
    /// The items that are read or written, in the order written.
    pub items: Vec<AccessItem>,
    /// Deviations from the correct request.
    pub instead: Vec<RequestDeviation>,
    /// Expected answer to a write; `None`: accepted.
    pub answer: Option<AnswerMatcher>,
    /// Whether the second controller acts.
    pub second: bool,
    /// Station address of the request, if it is not that of the device (PROFIBUS).
    pub to: Option<Program>,
}

/// The service that carries an access.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum AccessChannel {
    /// Base mode parameter access through the parameter access point.
    Parameters,
    /// One record (index into `device.records`).
    Record(usize),
    /// DCP; on PROFIBUS FDL status and Slave_Diag.
    Station,
    /// Slave_Diag.
    Diagnosis,
    /// Get_Cfg.
    Configuration,
    Pages,
    /// The stand: LED or counter.
    Stand,
}

/// One name in an access.
#[derive(Debug, Deserialize, Serialize)]
pub struct AccessItem {
    pub name: NameId,
    /// Read: the expected value. Write: the value to write ([`Matcher::Equal`]).
    pub value: Matcher,
}

/// One deviation from the correct request.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum RequestDeviation {
    /// Parameter request: reference.
    Reference(u8),
    /// Parameter request: request identifier.
    Request(u8),
    /// Parameter request: DO-ID (axis).
    DoId(u8),
    /// Parameter request: number of parameters.
    Count(u8),
    /// Parameter request: attribute.
    Attribute(u8),
    /// Parameter request: number of elements.
    Elements(u8),
    /// Parameter request: subindex.
    Subindex(u16),
    /// Parameter request: format code.
    Format(u8),
    /// Parameter request: number of values.
    Values(u8),
    /// Length in bytes; the request is cut or padded with zeros.
    Length(usize),
    /// The whole request.
    Bytes(Vec<u8>),
    /// Slot of the record or of the record that carries a parameter request.
    Slot(u16),
    /// Subslot of that record.
    Subslot(u16),
    /// API of that record.
    Api(u32),
    /// Index of that record; on PROFIBUS of the data set that carries a parameter request.
    Index(u16),
    /// Station: the bytes of the value.
    StationValue(Vec<u8>),
    /// Station: the block qualifier.
    Qualifier(u16),
    /// Station: another destination of the request; on a virtual wire only.
    Destination(#[serde(with = "crate::encoding::mac")] Mac),
}

/// The station that a DCP Identify searches for.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum IdentifyTarget {
    /// The station that a word stands for.
    Who(SoughtStation),
    /// The station with this name.
    Name(String),
    /// The station with this alias: port and name of its neighbour.
    Alias(String),
    /// Stations that have what these filters say.
    Filters {
        /// The filters as bytes.
        octets: Vec<u8>,
        /// ResponseDelayFactor.
        delay: u16,
        /// How long the answer may take.
        wait: station::Duration,
    },
}

/// The stations that a word stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum SoughtStation {
    /// Every station.
    All,
    /// The station with the name that the bench assigns to the device.
    OwnName,
    /// Stations with the vendor ID and device ID of the device.
    OwnId,
    /// The same with another vendor ID.
    OtherVendor,
    /// The same with another device ID.
    OtherDevice,
    /// Stations with the type of the device.
    OwnType,
    /// Stations with another type.
    OtherType,
    /// Stations with the IDs of the device and another type.
    OwnIdOtherType,
}

/// One service of `send`.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub enum AcyclicService {
    /// DCP reset.
    DcpReset {
        /// Suboption of the control option: 5 or 6.
        suboption: u8,
        /// The block qualifier.
        qualifier: u16,
    },
    /// DCP signal: the device flashes an LED.
    DcpSignal,
    /// DCP identify.
    DcpIdentify(IdentifyTarget),
    /// Reads a record by slot, subslot and index.
    RecordRead {
        at: RecordPlace,
        /// Requested length in bytes.
        length: u32,
        /// Whether it is read without a connection (ReadImplicit).
        implicit: bool,
    },
    /// Writes a record by slot, subslot and index.
    RecordWrite { at: RecordPlace, bytes: Vec<u8> },
    /// Writes several records in one call.
    RecordsWrite(Vec<(RecordPlace, Vec<u8>)>),
    /// DCP Get with these elements as bytes.
    DcpGet { elements: Vec<u8> },
    /// DCP Set with these blocks as bytes.
    DcpSet { blocks: Vec<u8> },
    /// An RPC PDU.
    Rpc(RpcService),
    /// An SNMP request.
    Snmp(SnmpService),
    /// An ICMP echo request.
    Ping(PingService),
    /// Frames for others and for all, one after the other.
    Load {
        /// The word for their kind.
        kind: String,
        /// How many there are.
        count: u32,
        /// The time from one to the next.
        gap: station::Duration,
    },
    /// Sends an LLDP frame.
    Lldp { chassis: String, port: String },
    /// Sends an ARP request; the device has to answer.
    Arp {
        /// The address; `None`: the address last assigned to the device.
        ip: Option<Program>,
        /// Whether it is an ARP probe, which has no sender address.
        probe: bool,
    },
    /// Aborts the current connection with an ERR-RTA.
    Abort,
    /// A damaged frame that the controller can send, by its name.
    Broken(String),
    /// A service of PROFIBUS.
    Dp(DpService),
    /// Requests a web page.
    HttpGet {
        /// Index into `device.pages`.
        page: usize,
    },
    /// Submits the form of a web page.
    HttpPost {
        /// Index into `device.pages`.
        page: usize,
        /// Field (index into the fields of the page) and value.
        fields: Vec<(usize, String)>,
    },
}

/// The place of a record that is accessed by its numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct RecordPlace {
    /// The API; `None`: that of the submodule.
    pub api: Option<u32>,
    pub slot: u16,
    pub subslot: u16,
    pub index: u16,
}

/// An RPC PDU, sent once.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct RpcService {
    /// The kind of the PDU.
    pub packet: u8,
    /// The interface, as a UUID in canonical order.
    pub interface: [u8; 16],
    /// The version of the interface.
    pub interface_version: u32,
    /// The object, as a UUID in canonical order; `None`: that of the device.
    pub object: Option<[u8; 16]>,
    /// The operation.
    pub opnum: u16,
    /// Whether the PDU belongs to the activity of the last one.
    pub same_activity: bool,
    /// The sequence number within the activity.
    pub sequence: u32,
    /// The boot time of the server that the client claims to know.
    pub server_boot: u32,
    /// Whether header and NDR are little-endian.
    pub little_endian: bool,
    /// The body, or the blocks for which an NDR header is made.
    pub body: Vec<u8>,
    /// Whether `body` is the whole body.
    pub is_whole_body: bool,
    /// Bytes of the body in each fragment.
    pub fragment: Option<usize>,
    /// The fragments that are sent, in this order.
    pub sent: Option<Vec<usize>>,
    /// How each datagram is sent in IP fragments; `None` for whole datagrams.
    pub ip_fragments: Option<IpFragments>,
}

/// An ICMP echo request, sent once.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct PingService {
    /// The address that is asked; `None` for that of the device.
    pub ip: Option<Program>,
    /// The number of bytes of data.
    pub length: usize,
    /// Whether its checksum is wrong.
    pub is_damaged: bool,
    /// How it is sent.
    pub ip_fragments: IpFragments,
}

/// How a packet is sent in IP fragments.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct IpFragments {
    /// Bytes of payload in each fragment.
    pub octets: Option<usize>,
    /// The fragments that are sent, in this order.
    pub sent: Option<Vec<usize>>,
}

/// An SNMP request, sent once.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct SnmpService {
    /// The payload of the datagram.
    pub octets: Vec<u8>,
    /// Whether it is a message that gets its own request ID, and not sent as it is.
    pub is_message: bool,
}

/// The alarm that an Alarm_Ack names, each part a byte.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct AlarmToAcknowledge {
    pub slot: Program,
    pub alarm_type: Program,
    pub specifier: Program,
}

/// A service of PROFIBUS, sent once and unchanged.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub enum DpService {
    /// Set_Slave_Address.
    SetSlaveAddress {
        new: Program,
        ident: u16,
        /// No_Add_Chg: forbids further changes.
        lock: u8,
        /// Length in bytes to which the data are cut or padded with zeros.
        length: Option<usize>,
    },
    /// Global_Control, which has no answer; without `to` it is sent to all stations.
    GlobalControl {
        /// Control_Command.
        command: u8,
        /// Group_Select; 0: all groups.
        groups: u8,
    },
    /// Request FDL Status.
    FdlStatus,
    /// Slave_Diag.
    SlaveDiag,
    /// Get_Cfg.
    GetCfg,
    /// Set_Prm with exactly these bytes.
    SetPrm(Vec<u8>),
    /// Chk_Cfg with these bytes; `None`: the identifiers of the module in use.
    ChkCfg(Option<Vec<u8>>),
    /// One Data_Exchange with these outputs; `None`: as many zeros as the module in use has outputs.
    DataExchange(Option<Vec<u8>>),
    /// A request with data and an answer to any access point.
    AccessPoint {
        /// The access point of the slave.
        sap: u8,
        /// The access point of the master.
        source: u8,
        bytes: Vec<u8>,
    },
    /// RD_Inp.
    ReadInputs,
    /// RD_Outp.
    ReadOutputs,
    /// DS_Read over MS1.
    Read {
        slot: u8,
        index: u8,
        /// Requested length in bytes.
        length: u8,
    },
    /// DS_Write over MS1.
    Write { slot: u8, index: u8, bytes: Vec<u8> },
    /// Alarm_Ack over MS1, to access point 50 where `own_access_point`, else to 51.
    AlarmAck { own_access_point: bool, alarm: Box<AlarmToAcknowledge> },
    /// CALL of I&M`number`, over MS1 or MS2.
    ImRead { slot: u8, number: u8, class_2: bool },
    /// Initiate: opens the MS2 connection of the master.
    Ms2Initiate {
        /// Send_Timeout in 10 ms.
        send_timeout: u16,
        features: [u8; 2],
        profile_features: [u8; 2],
        profile: u16,
        /// S_Type and S_Addr.
        source: (u8, Vec<u8>),
        /// D_Type and D_Addr.
        destination: (u8, Vec<u8>),
    },
    /// DS_Read over MS2.
    Ms2Read {
        slot: u8,
        index: u8,
        /// Requested length in bytes.
        length: u8,
    },
    /// DS_Write over MS2.
    Ms2Write { slot: u8, index: u8, bytes: Vec<u8> },
    /// Abort: closes the MS2 connection.
    Ms2Abort { subnet: u8, reason: u8 },
}

/// The expected answer.
#[derive(Debug, Deserialize, Serialize)]
#[allow(clippy::large_enum_variant, reason = "there are few of them, and they live as long as the suite")]
pub enum AnswerMatcher {
    /// A positive response.
    Accepted,
    /// No answer.
    None,
    /// Any answer.
    Any,
    /// A negative response with one of these codes; empty: any code.
    Refused(Vec<Code>),
    /// One of these has to hold.
    OneOf(Vec<AnswerMatcher>),
    /// Each of these parts has to hold.
    Parts(Vec<(AnswerPart, AnswerMatcher)>),
    /// The part has this value (`bytes`, `connection`, `module_diff.x`, `diag.x`, `status`).
    Is(Matcher),
}

/// An error code by its word in a code table, with its numbers.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Code {
    /// PROFIdrive error number.
    Parameter(u16, String),
    /// PNIO status: ErrorDecode and ErrorCode1 (ErrorCode2 if the word specifies it).
    Pnio {
        decode: u8,
        code1: u8,
        /// ErrorCode2, if it is checked.
        code2: Option<u8>,
        word: String,
    },
    /// DCP block error.
    Dcp(u8, String),
    /// The function code of an FDL answer without the requested data.
    Fdl(u8, String),
    /// A negative response of DP-V1.
    Dpv1 { code1: u8, word: String },
    /// Instance and reason of an Abort by which the slave ends an MS2 connection.
    Abort(u8, String),
}
