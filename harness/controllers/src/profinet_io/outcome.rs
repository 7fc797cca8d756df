//! What became of a request, and of the AR.
//!
//! The controller acts and reports how its own requests went; what the device did is read from the frames by others.

use super::http::PageOutcome;
use super::state::{Stage, Wait};
use alloc::boxed::Box;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt;
use wire::ethernet::Mac;
use wire::profinet::blocks::module_diff::ModuleDiffBlock;
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::dcp::{Block, BlockError, Dcp, Element, Value};
use wire::profinet::rpc::{Entry, RejectStatus};
use wire::profinet::status::PnioStatus;

/// What became of a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Identify: the stations in the order of their answers.
    Stations(Vec<StationSeen>),
    /// DCP Get, Set, Signal or reset.
    Dcp(DcpOutcome),
    /// Connect.
    StartUp(Box<StartUp>),
    /// Write, Read or ReadImplicit.
    Record(RecordOutcome),
    /// Write multiple: one outcome for each record.
    Records(Vec<RecordOutcome>),
    /// A request of the base mode.
    Parameter(ParameterOutcome),
    /// Endpoint mapper: what is registered, or why it is not known.
    Endpoints(Result<Vec<Entry>, CallError>),
    /// Release or abort.
    Ended(Ended),
    /// A web page was asked for.
    Page(PageOutcome),
    /// ARP: the stations that have the address, in the order of their answers.
    Owners(Vec<Mac>),
    /// A frame was sent; nothing is waited for.
    Sent,
    /// A damaged frame was sent: these are its octets.
    Broken(Vec<u8>),
    /// What was asked for cannot be done now; the sentence says why.
    Impossible(&'static str),
}

/// A station as it tells of itself over DCP.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StationSeen {
    /// The source of its answer.
    pub mac: Mac,
    /// Its name; empty when it has none.
    pub name: Vec<u8>,
    /// Its address; zeros when it has none.
    pub ip: IpParameter,
    /// Its vendor and device number.
    pub id: Option<(u16, u16)>,
    /// Its type, in the words of its vendor.
    pub station_type: Vec<u8>,
    /// Its role: bit 0 IO device, 1 IO controller, 2 IO multidevice, 3 supervisor.
    pub role: Option<u8>,
    /// Everything it told, in its order.
    pub blocks: Vec<Block>,
}

impl StationSeen {
    /// What the answer `dcp` from `mac` tells.
    pub fn of(mac: Mac, dcp: &Dcp) -> StationSeen {
        let mut seen = StationSeen {
            mac,
            name: Vec::new(),
            ip: IpParameter::NONE,
            id: None,
            station_type: Vec::new(),
            role: None,
            blocks: dcp.blocks().to_vec(),
        };
        for block in dcp.blocks() {
            match &block.value {
                Value::NameOfStation(name) => seen.name.clone_from(name),
                Value::IpParameter(ip) | Value::FullIpSuite(ip, _) => seen.ip = *ip,
                Value::DeviceId { vendor_id, device_id } => seen.id = Some((*vendor_id, *device_id)),
                Value::Vendor(name) => seen.station_type.clone_from(name),
                Value::DeviceRole { role, .. } => seen.role = Some(*role),
                _ => {}
            }
        }
        seen
    }
}

/// How it went with DCP.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DcpOutcome {
    /// Everything was set.
    Accepted,
    /// The values that were asked for; refused elements stand among them as [`Value::Response`].
    Values(Vec<Block>),
    /// These elements were refused; there is at least one.
    Refused(Vec<(Element, BlockError)>),
    /// The device does not support the service.
    NotSupported,
    /// No answer came.
    NoAnswer(Wait),
}

/// Why an RPC call brought no answer that can be used.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CallError {
    /// The server did not begin the operation.
    Rejected(RejectStatus),
    /// The server began the operation and it failed.
    Faulted(RejectStatus),
    /// No answer came.
    NoAnswer(Wait),
    /// An answer came that does not fit the request; the sentence says in what.
    Unfit(String),
    /// The AR ended while the answer was awaited, or there was none.
    ArEnded,
}

/// How it went with a record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RecordOutcome {
    /// Written, or read with this data.
    Accepted {
        /// The record; empty after writing.
        data: Vec<u8>,
    },
    /// The device refused.
    Refused(PnioStatus),
    /// The call brought no answer.
    Failed(CallError),
}

impl RecordOutcome {
    /// Whether the record was written or read.
    pub fn is_accepted(&self) -> bool {
        matches!(self, RecordOutcome::Accepted { .. })
    }
}

/// How it went with a request of the base mode.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ParameterOutcome {
    /// The octets of the response; its reference is that of the request.
    Answer(Vec<u8>),
    /// The response has another reference than the request.
    OtherReference {
        /// The reference of the request.
        sent: u8,
        /// The octets of the response.
        answer: Vec<u8>,
    },
    /// Writing the request was refused.
    WriteRefused(PnioStatus),
    /// Reading the response was refused, otherwise than by "not yet".
    ReadRefused(PnioStatus),
    /// The device never had an answer ready; this was its last status, success with an empty record if it is OK.
    NotReady(PnioStatus, Wait),
    /// A call brought no answer.
    Failed(CallError),
}

/// How Connect itself went.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ConnectOutcome {
    /// The device opened the AR.
    Accepted,
    /// The device refused.
    Refused(PnioStatus),
    /// The call brought no answer that can be used.
    Failed(CallError),
}

/// How a control call, PrmEnd or Release, went.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ControlOutcome {
    /// Done.
    Accepted,
    /// The device refused.
    Refused(PnioStatus),
    /// The call brought no answer that can be used.
    Failed(CallError),
}

/// A start-up with the outcome of each stage that was reached, in their order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StartUp {
    /// The device that was found.
    pub identify: Option<StationSeen>,
    /// Whether its address was set: `None` if that stage was not reached, false if it had it already.
    pub address_set: Option<bool>,
    /// The addresses with which the device was called.
    pub partner: Option<super::Partner>,
    /// How Connect went.
    pub connect: Option<ConnectOutcome>,
    /// How often Connect was sent again because the device had no AR left.
    pub connect_repeats: u8,
    /// How each record went that was sent.
    pub records: Vec<RecordOutcome>,
    /// How PrmEnd went.
    pub parameter_end: Option<ControlOutcome>,
    /// Whether ApplicationReady came: `None` if it was not waited for.
    pub application_ready: Option<bool>,
    /// Whether a good sample came: data valid, every proper input submodule good. `None` if it was not waited for.
    pub first_data: Option<bool>,
    /// How the plugged modules differ, from the Connect response or from ApplicationReady.
    pub module_diff: Option<ModuleDiffBlock>,
    /// Whether the AR stands.
    pub standing: bool,
    /// Where the start-up ended otherwise, and why.
    pub failed: Option<Failure>,
}

/// Where and why a start-up ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// The stage.
    pub stage: Stage,
    /// Why.
    pub why: FailureReason,
}

/// Why a start-up ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FailureReason {
    /// A wait ran out.
    Waited(Wait),
    /// The device refused.
    Refused(PnioStatus),
    /// The device refused its address, or has no means to set it.
    AddressRefused(BlockError),
    /// A value is beyond its limit and was not sent.
    Limit(super::LimitError),
    /// A call brought no answer that can be used.
    Call(CallError),
    /// More than one station has the name.
    SameName(Vec<Mac>),
    /// Another station has the address that the device is to get.
    SameAddress(Mac),
    /// The AR ended.
    Ended(ArEnd),
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.stage, self.why)
    }
}

impl fmt::Display for FailureReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FailureReason::Waited(wait) => wait.fmt(f),
            FailureReason::Refused(status) => write!(f, "refused: {status}"),
            FailureReason::AddressRefused(error) => {
                write!(f, "the device refused its address: {} ({})", error.word().unwrap_or("unknown"), error.0)
            }
            FailureReason::Limit(limit) => limit.fmt(f),
            FailureReason::Call(error) => error.fmt(f),
            FailureReason::SameName(stations) => {
                f.write_str("more than one station has the name:")?;
                stations.iter().try_for_each(|mac| write!(f, " {mac}"))
            }
            FailureReason::SameAddress(mac) => write!(f, "station {mac} already has the address"),
            FailureReason::Ended(end) => end.fmt(f),
        }
    }
}

impl fmt::Display for CallError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            CallError::Rejected(status) => write!(f, "RPC reject: {} ({:#010x})", word(*status), status.0),
            CallError::Faulted(status) => write!(f, "RPC fault: {} ({:#010x})", word(*status), status.0),
            CallError::NoAnswer(wait) => wait.fmt(f),
            CallError::Unfit(why) => write!(f, "the answer does not fit: {why}"),
            CallError::ArEnded => f.write_str("there is no AR"),
        }
    }
}

fn word(status: RejectStatus) -> &'static str {
    status.word().unwrap_or("unknown")
}

/// How Release or an abort went; the AR is gone in any case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ended {
    /// Release, with the answer of the device.
    Released(ControlOutcome),
    /// An ERR-RTA was sent.
    Aborted,
    /// There was no AR.
    NoAr,
}

/// Why an AR ended that we did not ask to end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ArEnd {
    /// The device sent an ERR-RTA.
    Aborted(PnioStatus),
    /// No cyclic frame came for the data hold time.
    Watchdog(Wait),
    /// The device did not acknowledge our alarm acknowledgement.
    AlarmUnacknowledged(Wait),
}

impl fmt::Display for ArEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ArEnd::Aborted(status) => write!(f, "the device aborted the AR: {status}"),
            ArEnd::Watchdog(wait) | ArEnd::AlarmUnacknowledged(wait) => wait.fmt(f),
        }
    }
}
