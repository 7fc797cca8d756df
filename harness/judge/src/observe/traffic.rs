//! Protocol-level traffic: requests, answers, repetitions, token passing.
//!
//! Verdicts about a device do not use it; the replay uses it to find errors on the wire.

use super::{ArId, FrameDirection};
use wire::ethernet::Mac;
use wire::profibus::sap::SapService;
use wire::profinet::alarm::{AlarmPriority, RtaKind};
use wire::profinet::blocks::module_diff::ModuleDiffBlock;

/// A step of the traffic.
#[derive(Clone, Copy, Debug)]
pub enum Traffic<'a> {
    /// A step of a PROFINET call; copies by mirror ports are not reported.
    Call {
        /// The connection, if the call names one.
        ar: Option<ArId>,
        /// Number of the call, the same for request, repetitions and response.
        number: u64,
        service: &'static str,
        part: CallPart,
        source: Mac,
        destination: Mac,
    },
    /// DATA, ACK or NACK on an alarm channel, repetitions included.
    Rta {
        ar: ArId,
        direction: FrameDirection,
        /// The priority of the frame ID.
        priority: AlarmPriority,
        /// The priority of the block; `None` if there is none.
        of_block: Option<AlarmPriority>,
        kind: RtaKind,
        /// SendSeqNum.
        sequence: u16,
        /// AckSeqNum.
        acknowledges: u16,
        /// Whether it repeats the previous DATA.
        again: bool,
    },
    /// A cyclic frame whose connection establishment is not in the trace.
    Stray {
        source: Mac,
        destination: Mac,
        frame_id: u16,
        counter: u16,
        /// The data area, including padding.
        data: &'a [u8],
        /// Everything after the FrameID, to the end of the frame.
        octets: &'a [u8],
        /// The offset of these bytes in the frame.
        at: usize,
    },
    /// The answer to a call lacks what belongs in it, or cannot be read.
    AnswerMalformed {
        ar: Option<ArId>,
        service: &'static str,
        source: Mac,
        destination: Mac,
        /// Whether a checksum shows that the answer was captured as it was sent.
        is_proven: bool,
        /// What is wrong with it.
        why: &'a str,
    },
    /// An answer on PROFIBUS that does not fit its request or the configuration.
    PollFault { ar: Option<ArId>, master: u8, station: u8, service: SapService, fault: PollFault },
    /// A device reported other modules than the controller expects.
    ModulesDiffer { ar: ArId, diff: &'a ModuleDiffBlock },
    /// The token was passed from one master to another, or to itself.
    Token { from: u8, to: u8 },
    /// A step of a request on PROFIBUS.
    Poll { master: u8, station: u8, service: SapService, part: PollPart },
}

/// A step of a call.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CallPart {
    /// The request was sent.
    Asked,
    /// The request was repeated, or the caller sent a ping.
    Again,
    /// The server sent "working".
    Working,
    /// It was answered, positively or negatively.
    Answered,
}

/// A step of a request on PROFIBUS.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PollPart {
    /// It was sent.
    Asked,
    /// It was repeated: frame count bit, bytes and receiver are those of the previous request.
    Again,
    /// It was answered.
    Answered,
    /// The next request or the token was sent instead of an answer.
    Unanswered,
}

/// What is wrong with an answer on PROFIBUS.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PollFault {
    /// The inputs have another length than the acknowledged configuration, in bytes.
    InputLength { expected: usize, observed: usize },
    /// The diagnosis is shorter than its six fixed bytes.
    ShortDiagnosis { octets: usize },
    /// The answer of an acyclic service (DP-V1) cannot be read.
    Unreadable { octets: usize },
    /// The answer names another access point of the slave than the request.
    OtherAccessPoint { requested: Option<u8>, answered: Option<u8> },
    /// The answer goes to another station than the one that requested it.
    OtherReceiver { receiver: u8 },
}

impl Traffic<'_> {
    /// The connection, if known.
    pub fn ar(&self) -> Option<ArId> {
        match self {
            Traffic::Call { ar, .. } | Traffic::AnswerMalformed { ar, .. } | Traffic::PollFault { ar, .. } => *ar,
            Traffic::Rta { ar, .. } | Traffic::ModulesDiffer { ar, .. } => Some(*ar),
            Traffic::Stray { .. } | Traffic::Token { .. } | Traffic::Poll { .. } => None,
        }
    }
}
