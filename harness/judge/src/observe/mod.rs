//! From frames to observations: which connections there are, what their cyclic frames carry, what was asked and answered.
//!
//! The same for a virtual wire, a live bench and a capture: whoever sees frames hands them to [`Tracker::frame`] and is told
//! what each one means. This room must not know suites, names or verdicts, and it sends nothing.

mod alarms;
mod anatomy;
mod answers;
mod ar;
mod calls;
mod connect;
mod counts;
mod describe;
mod dp;
mod either;
mod profibus;
mod repeated;
mod requests;
mod services;
mod stations;
mod tracker;
mod traffic;

pub use anatomy::{Part, anatomy};
pub use ar::{Address, Ar, ArId, DiagnosisTold, Met, Party, Placed, Role, SlaveTold, Stage, StartRecord, Stream};
pub use counts::{Counts, RpcKind};
pub use describe::describe;
pub use dp::{DpCounts, DpTracker};
pub use either::{BusTracker, link_type};
pub use profibus::ProfibusWords;
pub use tracker::{Stray, Tracker};
pub use traffic::{CallPart, PollPart, Traffic};

use wire::ethernet::Mac;
use wire::lldp::Lldp;
use wire::profibus::global_control::GlobalControl;
use wire::profinet::alarm::{AlarmNotification, AlarmPriority};
use wire::profinet::dcp::Dcp;
use wire::profinet::rt::ApduStatus;
use wire::profinet::status::PnioStatus;

/// Which way a frame of a connection goes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Direction {
    /// From the controller to the device: outputs.
    ToDevice,
    /// From the device to the controller: inputs.
    ToController,
}

/// What stands beside the data of a cyclic frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CyclicStatus {
    /// PROFINET: cycle counter, data status, transfer status.
    Apdu(ApduStatus),
    /// PROFIBUS: whether an answer had high priority, so that a diagnosis is to be fetched.
    Fdl {
        /// Whether it had.
        diagnosis_pending: bool,
    },
}

/// What there is on PROFIBUS only; stations are told by their addresses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dp<'a> {
    /// A slave told its diagnosis.
    Diagnosis {
        /// Who asked.
        master: u8,
        /// Who answered.
        station: u8,
        /// The data of Slave_Diag.
        octets: &'a [u8],
        /// Where they begin in the frame, in octets.
        at: usize,
    },
    /// The data link of a slave took Set_Prm.
    Parameters {
        /// Who sent it.
        master: u8,
        /// Who took it.
        station: u8,
        /// The data of Set_Prm.
        octets: &'a [u8],
    },
    /// The data link of a slave took Chk_Cfg.
    Configuration {
        /// Who sent it.
        master: u8,
        /// Who took it.
        station: u8,
        /// The data of Chk_Cfg.
        octets: &'a [u8],
    },
    /// The data link of a slave took Set_Slave_Address.
    AddressGiven {
        /// Who gives it.
        master: u8,
        /// The address of the slave until now.
        station: u8,
        /// The new one.
        address: u8,
        /// The ident number that the slave has to have.
        ident: u16,
    },
    /// Global_Control, which nobody answers.
    Control {
        /// Who sends it.
        master: u8,
        /// To whom; 127 means all.
        station: u8,
        /// What is commanded.
        control: GlobalControl,
    },
    /// A slave ended a connection by itself, or did not let it come about.
    Left {
        /// What showed it.
        why: Leaving,
    },
}

/// What shows that a slave is in no data exchange any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Leaving {
    /// It answers Data_Exchange with "no service".
    NoService,
    /// Its diagnosis says so.
    Diagnosis,
}

/// What a frame means. One frame may mean several things, and most mean one.
#[derive(Clone, Debug)]
pub enum Observation<'a> {
    /// A cyclic frame of a known connection.
    Cyclic {
        /// The connection.
        ar: ArId,
        /// Which way.
        direction: Direction,
        /// The data area, as long as the Connect agreed.
        data: &'a [u8],
        /// Where the data area begins in the frame, in octets.
        at: usize,
        /// What stands beside the data.
        status: CyclicStatus,
    },
    /// The device accepted a connection.
    Connected {
        /// The connection; its layout is known from here on.
        ar: ArId,
    },
    /// The device refused a connection.
    ConnectRefused {
        /// The connection that was not made.
        ar: ArId,
        /// Why.
        status: PnioStatus,
    },
    /// A record was written or read, with the device's answer.
    Record {
        /// The connection; `None` for an implicit read.
        ar: Option<ArId>,
        /// Whether it was written.
        written: bool,
        /// API, slot, subslot, index.
        target: (u32, u16, u16, u16),
        /// What was written, or what the answer brought.
        data: &'a [u8],
        /// The answer.
        status: PnioStatus,
    },
    /// The device took the end of the parameters.
    ParameterEnd {
        /// The connection.
        ar: ArId,
    },
    /// The device said that it is ready.
    ApplicationReady {
        /// The connection.
        ar: ArId,
    },
    /// An alarm, seen for the first time (repetitions are not shown again).
    Alarm {
        /// The connection.
        ar: ArId,
        /// High or low.
        priority: AlarmPriority,
        /// What it says.
        notification: &'a AlarmNotification,
    },
    /// An alarm was acknowledged by the application of the other side.
    AlarmAcknowledged {
        /// The connection.
        ar: ArId,
        /// The answer.
        status: PnioStatus,
    },
    /// The connection was ended with an ERR-RTA.
    Aborted {
        /// The connection.
        ar: ArId,
        /// Who sent it.
        direction: Direction,
        /// Why.
        status: PnioStatus,
    },
    /// A call was refused that has no observation of its own for that, or it failed in RPC before PROFINET could answer.
    CallFailed {
        /// The connection, where the call names one.
        ar: Option<ArId>,
        /// What was asked for.
        service: &'static str,
        /// The PNIO status or the status of RPC, in words.
        why: &'a str,
    },
    /// The connection was released: seen in the request, since its data mean nothing from then on.
    Released {
        /// The connection.
        ar: ArId,
    },
    /// No cyclic frame of this direction came for longer than the watchdog; the connection counts as ended.
    Starved {
        /// The connection.
        ar: ArId,
        /// The direction that fell silent.
        direction: Direction,
    },
    /// A DCP frame.
    Dcp {
        /// From.
        source: Mac,
        /// To.
        destination: Mac,
        /// What it says.
        pdu: &'a Dcp,
    },
    /// An LLDP frame.
    Lldp {
        /// From.
        source: Mac,
        /// What it says.
        pdu: &'a Lldp,
    },
    /// What there is on PROFIBUS only.
    Dp {
        /// The connection, where it belongs to one.
        ar: Option<ArId>,
        /// What was seen.
        event: Dp<'a>,
    },
    /// What goes to and fro beneath the meaning: requests and their answers, acknowledgements, tokens, repetitions.
    Traffic(Traffic<'a>),
    /// Frames are missing, or came in another order than they were sent: what was remembered is not simply continued.
    ///
    /// Only what somebody else recorded can have such a place; nothing about a device follows from it.
    Gap {
        /// The connection whose frames are missing; `None` where anything may be missing.
        ar: Option<ArId>,
    },
    /// A frame that could not be read.
    Unreadable {
        /// Which part, at which octet, and why.
        why: &'a str,
    },
}

impl Observation<'_> {
    /// The connection that it belongs to.
    pub fn ar(&self) -> Option<ArId> {
        match self {
            Observation::Cyclic { ar, .. }
            | Observation::Connected { ar }
            | Observation::ConnectRefused { ar, .. }
            | Observation::ParameterEnd { ar }
            | Observation::ApplicationReady { ar }
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
