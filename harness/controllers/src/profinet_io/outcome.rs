//! Outcomes of requests, and ends of ARs.
//!
//! The controller reports how its own requests ended; observers read from the frames what the device did.

use super::http::PageOutcome;
use super::ping::PingReply;
use super::raw::RawAnswer;
use super::state::{ArStartUpStage, Wait};
use alloc::boxed::Box;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt;
use wire::ethernet::Mac;
use wire::profinet::blocks::module_diff::ModuleDiffBlock;
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::dcp::{BlockError, Dcp, DcpBlock, DcpValue, Element, ServiceId, ServiceType};
use wire::profinet::rpc::{EndpointEntry, RejectStatus};
use wire::profinet::status::PnioStatus;
use wire::snmp::SnmpMessage;

/// The outcome of a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ControllerOutcome {
    /// Outcome of Identify: the stations in the order of their answers.
    Stations(Vec<IdentifiedStation>),
    /// Outcome of DCP Get, Set, Signal or reset.
    Dcp(DcpOutcome),
    /// Outcome of RawDcp: the answer as it came.
    DcpAnswer(Dcp),
    /// Outcome of RawCall: the first answer, or none.
    Called(Result<RawAnswer, Wait>),
    /// Outcome of Snmp: the first response, or none.
    Snmp(Result<SnmpMessage, Wait>),
    /// Outcome of Ping: the first reply, or none.
    Ping(Result<PingReply, Wait>),
    /// Outcome of Connect.
    StartUp(Box<ArStartUpResult>),
    /// Outcome of Write, Read or ReadImplicit.
    Record(IoRecordOutcome),
    /// Outcome of WriteMultiple: one outcome for each record.
    Records(Vec<IoRecordOutcome>),
    /// Outcome of a base mode request.
    Parameter(IoParameterOutcome),
    /// Outcome of an endpoint mapper lookup: the registered entries, or why they are unknown.
    Endpoints(Result<Vec<EndpointEntry>, CallError>),
    /// Outcome of Release or Abort.
    Ended(ArReleaseOutcome),
    /// Outcome of a web page request.
    Page(PageOutcome),
    /// Outcome of an ARP request: the stations that have the address, in the order of their answers.
    Owners(Vec<Mac>),
    /// A frame was sent; no answer is awaited.
    Sent,
    /// A damaged frame was sent, with these bytes.
    Broken(Vec<u8>),
    /// The request cannot be carried out now; the sentence says why.
    Impossible(&'static str),
}

/// A station as it describes itself over DCP.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IdentifiedStation {
    /// Source address of its answer.
    pub mac: Mac,
    /// Name of station; empty if it has none.
    pub name: Vec<u8>,
    /// IP parameters; zeros if it has none.
    pub ip: IpParameter,
    /// Vendor ID and device ID.
    pub id: Option<(u16, u16)>,
    /// Device type, as the vendor names it.
    pub station_type: Vec<u8>,
    /// Role: bit 0 IO device, 1 IO controller, 2 IO multidevice, 3 supervisor.
    pub role: Option<u8>,
    /// All blocks of the answer, in its order.
    pub blocks: Vec<DcpBlock>,
}

impl IdentifiedStation {
    /// Reads the answer `dcp` from `mac`.
    pub fn of(mac: Mac, dcp: &Dcp) -> IdentifiedStation {
        let mut station = IdentifiedStation {
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
                DcpValue::NameOfStation(name) => station.name.clone_from(name),
                DcpValue::IpParameter(ip) | DcpValue::FullIpSuite(ip, _) => station.ip = *ip,
                DcpValue::DeviceId { vendor_id, device_id } => station.id = Some((*vendor_id, *device_id)),
                DcpValue::Vendor(name) => station.station_type.clone_from(name),
                DcpValue::DeviceRole { role, .. } => station.role = Some(*role),
                _ => {}
            }
        }
        station
    }
}

/// The outcome of a DCP request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DcpOutcome {
    /// All values were set.
    Accepted,
    /// The requested values; refused elements are included as [`DcpValue::Response`].
    Values(Vec<DcpBlock>),
    /// These elements were refused; there is at least one.
    Refused(Vec<(Element, BlockError)>),
    /// The device does not support the service.
    NotSupported,
    /// No answer.
    NoAnswer(Wait),
}

impl DcpOutcome {
    /// The outcome in an answer to Get or Set.
    pub fn of(dcp: &Dcp) -> DcpOutcome {
        if dcp.service_type == ServiceType::NOT_SUPPORTED {
            return DcpOutcome::NotSupported;
        }
        if dcp.service_id == ServiceId::GET {
            return DcpOutcome::Values(dcp.blocks().to_vec());
        }
        let refused: Vec<_> = dcp
            .blocks()
            .iter()
            .filter_map(|block| match block.value {
                DcpValue::Response { element, error } if error != BlockError::OK => Some((element, error)),
                _ => None,
            })
            .collect();
        if refused.is_empty() { DcpOutcome::Accepted } else { DcpOutcome::Refused(refused) }
    }
}

/// Why an RPC call has no usable answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum CallError {
    /// The server did not begin the operation.
    Rejected(RejectStatus),
    /// The server began the operation and it failed.
    Faulted(RejectStatus),
    /// No answer.
    NoAnswer(Wait),
    /// The answer does not match the request; the sentence says how.
    Unfit(String),
    /// The AR ended while the answer was awaited, or there was none.
    ArEnded,
}

/// The outcome of a record access.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum IoRecordOutcome {
    /// Written, or read with this data.
    Accepted {
        /// The record; empty after a write.
        data: Vec<u8>,
    },
    /// The device refused.
    Refused(PnioStatus),
    /// The call returned no answer.
    Failed(CallError),
}

impl IoRecordOutcome {
    /// Whether the record was written or read.
    pub fn is_accepted(&self) -> bool {
        matches!(self, IoRecordOutcome::Accepted { .. })
    }
}

/// The outcome of a base mode request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum IoParameterOutcome {
    /// The bytes of the response; its reference matches the request.
    Answer(Vec<u8>),
    /// The response has another reference than the request.
    OtherReference {
        /// The reference of the request.
        sent: u8,
        /// The bytes of the response.
        answer: Vec<u8>,
    },
    /// The device refused the write of the request.
    WriteRefused(PnioStatus),
    /// The device refused the read of the response, for another reason than "not ready".
    ReadRefused(PnioStatus),
    /// The device never had a response ready. Its last status (OK if it returned an empty record), and the time.
    NotReady(PnioStatus, Wait),
    /// A call returned no answer.
    Failed(CallError),
}

/// The outcome of Connect itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ConnectOutcome {
    /// The device opened the AR.
    Accepted,
    /// The device refused.
    Refused(PnioStatus),
    /// The call returned no usable answer.
    Failed(CallError),
}

/// The outcome of a control call: PrmEnd or Release.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ControlOutcome {
    /// The device answered Done.
    Accepted,
    /// The device refused.
    Refused(PnioStatus),
    /// The call returned no usable answer.
    Failed(CallError),
}

/// A start-up with the outcome of each stage that was reached, in order.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ArStartUpResult {
    /// The device that was found.
    pub identify: Option<IdentifiedStation>,
    /// Whether its address was set: `None` if that stage was not reached, false if it had the address already.
    pub address_set: Option<bool>,
    /// The addresses at which the device was called.
    pub partner: Option<super::Partner>,
    /// Outcome of Connect.
    pub connect: Option<ConnectOutcome>,
    /// How often Connect was repeated because the device had no free AR.
    pub connect_repeats: u8,
    /// Outcomes of the records that were sent.
    pub records: Vec<IoRecordOutcome>,
    /// Outcome of PrmEnd.
    pub parameter_end: Option<ControlOutcome>,
    /// Whether ApplicationReady arrived; `None` if it was not awaited.
    pub application_ready: Option<bool>,
    /// Whether a valid sample arrived: DataValid set, IOPS of every proper input submodule good. `None` if it was not awaited.
    pub first_data: Option<bool>,
    /// The ModuleDiffBlock of the Connect response or of ApplicationReady.
    pub module_diff: Option<ModuleDiffBlock>,
    /// Whether the AR is established.
    pub standing: bool,
    /// Where and why the start-up failed.
    pub failed: Option<ArStartUpFailure>,
}

/// Where and why a start-up ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ArStartUpFailure {
    /// The failed stage.
    pub stage: ArStartUpStage,
    /// The reason.
    pub why: ArFailureReason,
}

/// Why a start-up ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ArFailureReason {
    /// A wait timed out.
    Waited(Wait),
    /// The device refused.
    Refused(PnioStatus),
    /// The device refused its address, or cannot set it.
    AddressRefused(BlockError),
    /// A value is out of range and was not sent.
    Limit(super::LimitError),
    /// A call returned no usable answer.
    Call(CallError),
    /// More than one station has the name.
    SameName(Vec<Mac>),
    /// Another station has the address intended for the device.
    SameAddress(Mac),
    /// The AR ended.
    Ended(ArEnd),
}

impl fmt::Display for ArStartUpFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.stage, self.why)
    }
}

impl fmt::Display for ArFailureReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ArFailureReason::Waited(wait) => wait.fmt(f),
            ArFailureReason::Refused(status) => write!(f, "refused: {status}"),
            ArFailureReason::AddressRefused(error) => {
                write!(f, "the device refused its address: {} ({})", error.word().unwrap_or("unknown"), error.0)
            }
            ArFailureReason::Limit(limit) => limit.fmt(f),
            ArFailureReason::Call(error) => error.fmt(f),
            ArFailureReason::SameName(stations) => {
                f.write_str("more than one station has the name:")?;
                stations.iter().try_for_each(|mac| write!(f, " {mac}"))
            }
            ArFailureReason::SameAddress(mac) => write!(f, "station {mac} already has the address"),
            ArFailureReason::Ended(end) => end.fmt(f),
        }
    }
}

impl fmt::Display for DcpOutcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            DcpOutcome::Accepted => f.write_str("accepted"),
            DcpOutcome::Values(_) => f.write_str("values"),
            DcpOutcome::Refused(elements) => {
                f.write_str("refused:")?;
                elements.iter().enumerate().try_for_each(|(at, (element, error))| {
                    let separator = if at == 0 { "" } else { "," };
                    let (element, word) = (element.word().unwrap_or("unknown"), error.word().unwrap_or("unknown"));
                    write!(f, "{separator} {element} {word} ({})", error.0)
                })
            }
            DcpOutcome::NotSupported => f.write_str("the device does not support the service"),
            DcpOutcome::NoAnswer(wait) => write!(f, "{wait}"),
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

/// The outcome of Release or Abort; the AR has ended in any case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ArReleaseOutcome {
    /// Release was sent; the answer of the device.
    Released(ControlOutcome),
    /// An ERR-RTA was sent.
    Aborted,
    /// There was no AR.
    NoAr,
}

/// Why an AR ended without a request of the caller.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ArEnd {
    /// The device sent an ERR-RTA.
    Aborted(PnioStatus),
    /// No cyclic frame arrived for the data hold time.
    Watchdog(Wait),
    /// The device did not acknowledge the controller's AlarmAck.
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
