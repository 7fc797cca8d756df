//! What goes to and fro beneath the meaning of frames: who asks, who answers, what is repeated, who has the token.
//!
//! Verdicts about a device need none of this; whoever looks for what is wrong on a wire does.

use super::{ArId, Direction};
use wire::ethernet::Mac;
use wire::profibus::sap::Service;
use wire::profinet::alarm::{AlarmPriority, RtaKind};
use wire::profinet::blocks::module_diff::ModuleDiffBlock;

/// A step of the traffic.
#[derive(Clone, Copy, Debug)]
pub enum Traffic<'a> {
    /// A call of PROFINET went on by one step; copies by mirror ports are not told.
    Call {
        /// The connection, where the call names one.
        ar: Option<ArId>,
        /// The number of the call: the same for its request, repetitions and answer.
        number: u64,
        /// What is asked for.
        service: &'static str,
        /// Which step.
        part: CallPart,
        /// Who sends the frame.
        source: Mac,
        /// Who is to receive it.
        destination: Mac,
    },
    /// DATA, ACK or NACK on an alarm channel, repetitions included.
    Rta {
        /// The connection.
        ar: ArId,
        /// Which way it goes.
        direction: Direction,
        /// High or low.
        priority: AlarmPriority,
        /// What it is for.
        kind: RtaKind,
        /// The sequence number of the sender.
        sequence: u16,
        /// The sequence number that it acknowledges.
        acknowledges: u16,
        /// Whether it is a repetition of the DATA before.
        again: bool,
    },
    /// A cyclic frame of a connection that was not seen to be made.
    Stray {
        /// Who sends it.
        source: Mac,
        /// Who is to receive it.
        destination: Mac,
        /// Its frame id.
        frame_id: u16,
        /// Its cycle counter.
        counter: u16,
        /// Its data area, padding included.
        data: &'a [u8],
    },
    /// A device told that it has other modules than the controller expects.
    ModulesDiffer {
        /// The connection.
        ar: ArId,
        /// How they differ.
        diff: &'a ModuleDiffBlock,
    },
    /// The token of a PROFIBUS went from one master to another, or to itself.
    Token {
        /// Who gives it.
        from: u8,
        /// Who takes it.
        to: u8,
    },
    /// A request on a PROFIBUS, or what became of it.
    Poll {
        /// Who asks.
        master: u8,
        /// Who is asked.
        station: u8,
        /// What for.
        service: Service,
        /// Which step.
        part: PollPart,
    },
}

/// A step of a call.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum CallPart {
    /// It was asked for.
    Asked,
    /// The request was repeated, or the caller asked what became of it.
    Again,
    /// The other side said that it is at work.
    Working,
    /// It was answered, whatever the answer says.
    Answered,
}

/// A step of a request on PROFIBUS.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PollPart {
    /// It was sent.
    Asked,
    /// It was sent again: count, octets and receiver are those of the request before.
    Again,
    /// It was answered.
    Answered,
    /// The next request or the token came instead of an answer.
    Unanswered,
}

impl Traffic<'_> {
    /// The connection that it belongs to.
    pub fn ar(&self) -> Option<ArId> {
        match self {
            Traffic::Call { ar, .. } => *ar,
            Traffic::Rta { ar, .. } | Traffic::ModulesDiffer { ar, .. } => Some(*ar),
            Traffic::Stray { .. } | Traffic::Token { .. } | Traffic::Poll { .. } => None,
        }
    }
}
