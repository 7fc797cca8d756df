//! How the master gets at the medium: what it has and what it waits for.

use super::message::Message;
use station::Time;
use wire::profibus::fdl::FrameCount;

/// The state of the medium access (IEC 61158-4-3, FDL master state machine).
#[derive(Debug)]
pub(super) enum Access {
    /// Not in the ring: it listens who is.
    Listening,
    /// In the ring; somebody else has the token.
    Waiting,
    /// It has the token, and nothing is under way.
    Holding(Hold),
    /// It has sent a request and waits for the answer.
    Asking(Transfer, Hold),
    /// It has sent the token and waits until the other uses it.
    Passing { to: u8, tries: u8, until: Time },
}

/// What was done since the token came.
#[derive(Clone, Copy, Debug)]
pub(super) struct Hold {
    pub since: Time,
    /// Whether anything was sent.
    pub has_worked: bool,
    /// Whether a message of a request was sent; the next waits for the next token.
    pub has_asked: bool,
    /// The address that is still to be asked for a master.
    pub gap: Option<u8>,
}

/// A request on the bus.
#[derive(Debug)]
pub(super) struct Transfer {
    pub message: Message,
    pub purpose: Purpose,
    pub count: FrameCount,
    /// How often it may still be repeated.
    pub retries: u8,
    /// When it is repeated or given up.
    pub until: Time,
    /// What came instead of an answer.
    pub unfit: Option<super::outcome::Answer>,
}

/// Who wants the answer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Purpose {
    /// The cycle.
    Exchange,
    /// The diagnosis that the slave wants to be read.
    Diagnosis,
    /// What the master was asked to do.
    Job,
    /// The search for masters.
    Gap,
    /// Nobody any more.
    Nobody,
}

/// What is to be done with the token; of two that are due, the first in this order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Action {
    Clock,
    Exchange,
    Diagnosis,
    Job,
    Gap(u8),
    Pass,
}
