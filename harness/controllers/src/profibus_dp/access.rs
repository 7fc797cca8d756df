//! Medium access of the master: its state and what it waits for.

use super::message::DpMessage;
use super::repetition::FrameRepetition;
use station::Time;
use wire::profibus::fdl::FrameCount;

/// The state of the medium access (IEC 61158-4-3, FDL master state machine).
#[derive(Debug)]
pub(super) enum MediumAccess {
    /// Not in the ring: the master listens to find the other masters.
    Listening,
    /// In the ring; another master has the token.
    Waiting,
    /// It has the token and no request is outstanding.
    Holding(TokenHold),
    /// It has sent a request and waits for the response.
    AwaitingAnswer(PendingTransfer, TokenHold),
    /// It has passed the token and waits until the next master uses it.
    Passing { to: u8, tries: u8, until: Time },
}

/// What the master has done since it received the token.
#[derive(Clone, Copy, Debug)]
pub(super) struct TokenHold {
    /// The end of the token holding time (TTH), if there are other masters.
    pub until: Time,
    /// Whether anything was sent.
    pub has_worked: bool,
    /// Whether a message of a request was sent; the next one waits for the next token.
    pub has_sent_message: bool,
    /// Whether an address was polled for a master; only the token follows.
    pub has_polled: bool,
    /// The address still to be polled for a master.
    pub gap: Option<u8>,
}

/// A request on the bus.
#[derive(Debug)]
pub(super) struct PendingTransfer {
    pub message: DpMessage,
    pub purpose: Purpose,
    pub count: FrameCount,
    /// When its last character was sent.
    pub sent: Time,
    /// Remaining retries.
    pub retries: u8,
    /// When the request is repeated or given up.
    pub until: Time,
    /// An invalid frame that came instead of an answer.
    pub unfit: Option<super::outcome::DataLinkAnswer>,
    /// Set while the frame is sent again although it was answered.
    pub repetition: Option<FrameRepetition>,
}

/// The receiver of the answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    /// The cyclic exchange.
    Exchange,
    /// The diagnosis that the slave requested.
    Diagnosis,
    /// The request of the caller.
    Job,
    /// The search for masters (GAP update).
    Gap,
    /// No receiver any more: the answer is discarded.
    Discarded,
}

/// What to do next with the token; of two that are due, the first in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Action {
    Clock,
    Exchange,
    Diagnosis,
    Job,
    Gap(u8),
    Pass,
}
