//! Acyclic requests: what is asked, how it differs from the right request, and which answer is right.
//!
//! It must not know who asks, nor by which frames.

use super::condition::Matcher;
use crate::device::{AnswerPart, NameId};
use expression::Program;
use serde::{Deserialize, Serialize};
use wire::ethernet::Mac;

/// An acyclic access: all of its items go into one request.
#[derive(Debug, Deserialize, Serialize)]
pub struct Access {
    /// Which service carries it.
    pub via: Via,
    /// What is read or written, in the order written.
    pub items: Vec<AccessItem>,
    /// What is changed against the right request.
    pub instead: Vec<Instead>,
    /// Which answer is right (writes); `None` asks for acceptance.
    pub answer: Option<Answer>,
    /// Whether the second controller acts.
    pub second: bool,
    /// The station address that is asked where it is not the device's (PROFIBUS).
    pub to: Option<Program>,
}

/// The service that carries an access.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Via {
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
    /// Web pages.
    Pages,
    /// What the second face of the bus says of the device itself: led, counter.
    Stand,
}

/// One name in an access.
#[derive(Debug, Deserialize, Serialize)]
pub struct AccessItem {
    /// The name.
    pub name: NameId,
    /// Read: what is right. Write: what is written ([`Matcher::Equal`]).
    pub value: Matcher,
}

/// One thing that a request has different from the right one.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Instead {
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
    /// Parameter request: format octet.
    Format(u8),
    /// Parameter request: number of values.
    Values(u8),
    /// Length in octets, cut or lengthened with zeros.
    Length(usize),
    /// The whole request.
    Bytes(Vec<u8>),
    /// Record, or the one that carries a parameter request: slot.
    Slot(u16),
    /// Likewise: subslot.
    Subslot(u16),
    /// Likewise: API.
    Api(u32),
    /// Record, and on PROFIBUS the data set that carries a parameter request: index.
    Index(u16),
    /// Station: the octets of the value.
    StationValue(Vec<u8>),
    /// Station: the block qualifier.
    Qualifier(u16),
    /// Station: another station that the request goes to; on a virtual wire only.
    Destination(#[serde(with = "crate::encoding::mac")] Mac),
}

/// Whom a DCP identify looks for.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Sought {
    /// Every station.
    All,
    /// The station of the name that the bench gives the device.
    OwnName,
    /// The station of this name.
    Name(String),
    /// The station at this place: the neighbour's port and name.
    Alias(String),
}

/// One service of `send`.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub enum Service {
    /// DCP reset; the mode by its word (`factory`, ...) and the suboption and qualifier that carry it.
    DcpReset {
        /// Suboption of the control option: 5 or 6.
        suboption: u8,
        /// The block qualifier.
        qualifier: u16,
    },
    /// DCP signal: the device blinks.
    DcpSignal,
    /// DCP identify.
    DcpIdentify(Sought),
    /// Reads a record by its numbers.
    RecordRead {
        /// Slot.
        slot: u16,
        /// Subslot.
        subslot: u16,
        /// Index.
        index: u16,
        /// Octets asked for.
        length: u32,
    },
    /// Writes a record by its numbers.
    RecordWrite {
        /// Slot.
        slot: u16,
        /// Subslot.
        subslot: u16,
        /// Index.
        index: u16,
        /// The data.
        bytes: Vec<u8>,
    },
    /// Announces a neighbour.
    Lldp {
        /// Chassis id.
        chassis: String,
        /// Port id.
        port: String,
    },
    /// Asks by ARP who has an address: the device has to say that it has it.
    Arp {
        /// The address; none for the one that the device was last given.
        ip: Option<Program>,
        /// Whether the question names no sender, as before an address is given.
        probe: bool,
    },
    /// Aborts the own connection with an ERR-RTA.
    Abort,
    /// One of the damaged frames that the controller can make, by its word.
    Broken(String),
    /// A service of PROFIBUS.
    Dp(DpService),
    /// A web page is asked for (index into `device.pages`).
    HttpGet {
        /// The page.
        page: usize,
    },
    /// The form of a web page is sent.
    HttpPost {
        /// The page (index into `device.pages`).
        page: usize,
        /// The fields (indices into those of the page) and what is entered.
        fields: Vec<(usize, String)>,
    },
}

/// A service of PROFIBUS, sent once and as it stands.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub enum DpService {
    /// Set_Slave_Address.
    SetSlaveAddress {
        /// The new address.
        new: Program,
        /// The ident number.
        ident: u16,
        /// The octet that forbids further changes.
        lock: u8,
        /// To how many octets the data are cut, or with zeros lengthened.
        length: Option<usize>,
    },
    /// Global_Control; without `to` to all stations, and nobody answers.
    GlobalControl {
        /// The command, with the bits that were asked for.
        command: u8,
        /// The groups that are meant; 0 for all.
        groups: u8,
    },
    /// Request FDL Status.
    FdlStatus,
    /// Slave_Diag.
    SlaveDiag,
    /// Get_Cfg.
    GetCfg,
    /// Set_Prm with these octets, all of them.
    SetPrm(Vec<u8>),
    /// Chk_Cfg with these octets.
    ChkCfg(Vec<u8>),
    /// One Data_Exchange with these outputs.
    DataExchange(Vec<u8>),
    /// RD_Inp.
    ReadInputs,
    /// RD_Outp.
    ReadOutputs,
    /// DS_Read over MS1.
    Read {
        /// Slot.
        slot: u8,
        /// Index.
        index: u8,
        /// Octets asked for.
        length: u8,
    },
    /// DS_Write over MS1.
    Write {
        /// Slot.
        slot: u8,
        /// Index.
        index: u8,
        /// The data.
        bytes: Vec<u8>,
    },
}

/// Which answer is right.
#[derive(Debug, Deserialize, Serialize)]
#[allow(clippy::large_enum_variant, reason = "there are few of them, and they live as long as the suite")]
pub enum Answer {
    /// The request is carried out.
    Accepted,
    /// Nobody answers.
    None,
    /// Whatever comes.
    Any,
    /// The request is refused with one of these codes; empty: with any.
    Refused(Vec<Code>),
    /// One of these has to hold.
    OneOf(Vec<Answer>),
    /// Each of these parts has to hold.
    Parts(Vec<(AnswerPart, Answer)>),
    /// The part has this value (`bytes`, `connection`, `module_diff.x`, `diag.x`, `status`).
    Is(Matcher),
}

/// A refusal as a word of one of the code tables, with the numbers it stands for.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Code {
    /// PROFIdrive error number.
    Parameter(u16, String),
    /// PNIO status: ErrorDecode and ErrorCode1 (ErrorCode2 where the word says so).
    Pnio {
        /// ErrorDecode.
        decode: u8,
        /// ErrorCode1.
        code1: u8,
        /// ErrorCode2, where it counts.
        code2: Option<u8>,
        /// The word.
        word: String,
    },
    /// DCP block error.
    Dcp(u8, String),
    /// A data link answer without the data asked for: the function code of the answer.
    Fdl(u8, String),
    /// A negative response of DP-V1.
    Dpv1 {
        /// Error_Code_1.
        code1: u8,
        /// The word.
        word: String,
    },
}
