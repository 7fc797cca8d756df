//! Turns frames into observations: connections, cyclic data, requests and answers.
//!
//! It works on virtual wires, live benches and captures: pass each frame to [`Tracker::frame`]. It sends no frames and does not
//! depend on suites or verdicts.

mod alarms;
mod anatomy;
mod ar;
mod bus_tracker;
mod calls;
mod connect;
mod copies;
mod counts;
mod describe;
mod dp;
mod dp_services;
mod profibus_fields;
mod profibus_text;
mod requests;
mod responses;
mod services;
mod stations;
mod tracker;
mod traffic;

pub use anatomy::{FramePart, anatomy};
pub use ar::{
    Address, AdoptedConnection, ArId, ArStage, CyclicStream, DiagnosisFrame, ObservedAr, Party, Role, SlaveStartData,
    StartRecord, SubmodulePlacement,
};
pub use bus_tracker::{BusTracker, link_type};
pub use counts::{FrameCounts, RpcKind};
pub use describe::describe;
pub use dp::{DpCounts, DpTracker};
pub use profibus_fields::{DpField, DpFieldKind, DpFieldValue, ProfibusFields, dissector, fields};
pub use profibus_text::ProfibusWords;
pub use tracker::{Stray, Tracker};
pub use traffic::{CallPart, PollFault, PollPart, Traffic};

use wire::ethernet::Mac;
use wire::lldp::Lldp;
use wire::profibus::global_control::GlobalControl;
use wire::profinet::alarm::{AlarmNotification, AlarmPriority};
use wire::profinet::dcp::Dcp;
use wire::profinet::rt::ApduStatus;
use wire::profinet::status::PnioStatus;

/// The direction of a frame of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FrameDirection {
    /// From the controller to the device: outputs.
    ToDevice,
    /// From the device to the controller: inputs.
    ToController,
}

/// The status of a cyclic frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CyclicStatus {
    /// PROFINET: cycle counter, data status, transfer status.
    Apdu(ApduStatus),
    /// PROFIBUS: priority of the answer.
    Fdl {
        /// Whether the answer had high priority, which requests reading the diagnosis.
        diagnosis_pending: bool,
    },
}

/// Observations on PROFIBUS only; stations are given by their addresses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dp<'a> {
    /// A slave sent its diagnosis.
    Diagnosis {
        master: u8,
        station: u8,
        /// The data of Slave_Diag.
        octets: &'a [u8],
        /// Offset of the data in the frame, in bytes.
        at: usize,
    },
    /// A slave acknowledged Set_Prm.
    Parameters {
        master: u8,
        station: u8,
        /// The data of Set_Prm.
        octets: &'a [u8],
    },
    /// A slave acknowledged Chk_Cfg.
    Configuration {
        master: u8,
        station: u8,
        /// The data of Chk_Cfg.
        octets: &'a [u8],
    },
    /// A slave acknowledged Set_Slave_Address.
    AddressGiven {
        master: u8,
        /// The old address of the slave.
        station: u8,
        /// The new address of the slave.
        address: u8,
        /// The ident number in the request.
        ident: u16,
    },
    /// Global_Control, which has no answer.
    Control {
        master: u8,
        /// Destination; 127: all stations.
        station: u8,
        control: GlobalControl,
    },
    /// A slave left data exchange or refused to enter it.
    Left {
        /// How the slave indicated it.
        why: Leaving,
    },
}

/// How a slave indicates that it is not in data exchange.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Leaving {
    /// It answers Data_Exchange with "no service" (RS).
    NoService,
    /// By its diagnosis.
    Diagnosis,
}

/// The meaning of a frame. Most frames give one observation.
#[derive(Clone, Debug)]
pub enum Observation<'a> {
    /// A cyclic frame of a known connection.
    Cyclic {
        ar: ArId,
        direction: FrameDirection,
        /// The data area with the agreed length.
        data: &'a [u8],
        /// Offset of the data area in the frame, in bytes.
        at: usize,
        status: CyclicStatus,
    },
    /// The device accepted a connection.
    Connected {
        /// The connection, whose layout is known from now on.
        ar: ArId,
    },
    /// The device refused a connection.
    ConnectRefused { ar: ArId, status: PnioStatus },
    /// A record was written or read, with the answer of the device.
    Record {
        /// The connection; `None` for an implicit read.
        ar: Option<ArId>,
        /// Whether it was a write.
        written: bool,
        /// API, slot, subslot, index.
        target: (u32, u16, u16, u16),
        /// The data written or read.
        data: &'a [u8],
        status: PnioStatus,
    },
    /// The controller wants to write a record; until the answer is there, the device may have taken it or not. A repetition is reported
    /// again.
    RecordRequested {
        ar: ArId,
        /// API, slot, subslot and index.
        target: (u32, u16, u16, u16),
    },
    /// The device accepted PrmEnd.
    ParameterEnd { ar: ArId },
    /// The device sent ApplicationReady.
    ApplicationReady { ar: ArId },
    /// The device sent ApplicationReady for a submodule that was plugged or released; `alarm` is the SequenceNumber of that alarm.
    PlugReady { ar: ArId, alarm: u16 },
    /// An alarm, with the priority of its frame ID; repetitions are not reported.
    Alarm { ar: ArId, priority: AlarmPriority, notification: &'a AlarmNotification },
    /// An alarm was acknowledged by the application of the receiver.
    AlarmAcknowledged {
        ar: ArId,
        /// The answer.
        status: PnioStatus,
    },
    /// The connection was aborted by an ERR-RTA.
    Aborted {
        ar: ArId,
        /// The direction of the ERR-RTA, which gives its sender.
        direction: FrameDirection,
        status: PnioStatus,
    },
    /// A call was refused that has no own observation for it, or it failed in RPC.
    CallFailed {
        /// The connection, if the call names one.
        ar: Option<ArId>,
        service: &'static str,
        /// The PNIO status or RPC status, in words.
        why: &'a str,
    },
    /// The connection was released; reported at the request, since data are invalid from then on.
    Released { ar: ArId },
    /// No cyclic frame of this direction for longer than the watchdog time; the connection has ended.
    Starved {
        ar: ArId,
        /// The direction without frames.
        direction: FrameDirection,
    },
    /// A DCP frame.
    Dcp { source: Mac, destination: Mac, pdu: &'a Dcp },
    /// An LLDP frame.
    Lldp { source: Mac, pdu: &'a Lldp },
    /// An observation on PROFIBUS only.
    Dp {
        /// The connection, if it belongs to one.
        ar: Option<ArId>,
        event: Dp<'a>,
    },
    /// Protocol-level traffic: requests, answers, acknowledgements, tokens, repetitions.
    Traffic(Traffic<'a>),
    /// Frames are missing or out of order, so earlier values are not continued.
    ///
    /// Only recordings have gaps; a gap is not a fault of the device.
    Gap {
        /// The connection whose frames are missing; `None` if any frame may be missing.
        ar: Option<ArId>,
    },
    /// An unreadable frame.
    Unreadable {
        /// The error with layer and offset.
        why: &'a str,
    },
}

impl Observation<'_> {
    /// The connection, if known.
    pub fn ar(&self) -> Option<ArId> {
        match self {
            Observation::Cyclic { ar, .. }
            | Observation::Connected { ar }
            | Observation::ConnectRefused { ar, .. }
            | Observation::ParameterEnd { ar }
            | Observation::RecordRequested { ar, .. }
            | Observation::ApplicationReady { ar }
            | Observation::PlugReady { ar, .. }
            | Observation::Alarm { ar, .. }
            | Observation::AlarmAcknowledged { ar, .. }
            | Observation::Aborted { ar, .. }
            | Observation::Released { ar }
            | Observation::Starved { ar, .. } => Some(*ar),
            Observation::Record { ar, .. } | Observation::CallFailed { ar, .. } | Observation::Dp { ar, .. } => *ar,
            Observation::Traffic(traffic) => traffic.ar(),
            Observation::Gap { ar } => *ar,
            Observation::Dcp { .. } | Observation::Lldp { .. } | Observation::Unreadable { .. } => None,
        }
    }
}
