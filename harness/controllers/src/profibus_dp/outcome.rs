//! Outcomes of requests, and ends of connections.
//!
//! The master reports how its own requests ended; observers read from the frames what the slave did.

use crate::words::words;
use alloc::boxed::Box;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt;
use core::time::Duration;
use plain_text::hex;
use wire::profibus::diag::SlaveDiag;
use wire::profibus::dpv1::Refusal;
use wire::profibus::fdl::{AnswerFunction, StationType};

/// The outcome of a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Outcome of Connect.
    StartUp(Box<StartUp>),
    /// Outcome of any DP-V0 or data link service.
    Answer(Answer),
    /// Outcome of Read or Write.
    Record(RecordOutcome),
    /// Outcome of a base mode request.
    Parameter(ParameterOutcome),
    /// Outcome of Release or Abort.
    Ended(Ended),
    /// A frame was sent; no answer is awaited.
    Sent,
    /// A damaged frame was sent, with these bytes.
    Broken(Vec<u8>),
    /// The request cannot be carried out now; the sentence says why.
    Impossible(&'static str),
}

/// How the data link answered a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Answer {
    /// A short acknowledgement (SC).
    Short,
    /// A frame with function code: data, or an acknowledgement that may be negative.
    Frame {
        /// The function code.
        function: AnswerFunction,
        /// The type of the station.
        station: StationType,
        /// The data; may be empty.
        data: Vec<u8>,
    },
    /// No station answered, in all attempts.
    None,
    /// The frame that arrived does not answer the request; the sentence says why.
    Unfit(String),
}

impl Answer {
    /// Whether the request was accepted: a short acknowledgement, OK, or data.
    pub fn is_positive(&self) -> bool {
        match self {
            Answer::Short => true,
            Answer::Frame { function, .. } => matches!(
                *function,
                AnswerFunction::OK | AnswerFunction::DATA_LOW | AnswerFunction::DATA_HIGH | AnswerFunction::NO_DATA
            ),
            Answer::None | Answer::Unfit(_) => false,
        }
    }

    /// The function code with which the slave refused the request, such as RS for an inactive access point.
    pub fn refused(&self) -> Option<AnswerFunction> {
        match self {
            Answer::Frame { function, .. } if !self.is_positive() => Some(*function),
            _ => None,
        }
    }

    /// The data of a positive answer; a short acknowledgement has none.
    pub fn data(&self) -> Option<&[u8]> {
        match self {
            Answer::Short => Some(&[]),
            Answer::Frame { data, .. } if self.is_positive() => Some(data),
            _ => None,
        }
    }

    /// The data as diagnosis; `None` if there are too few bytes.
    pub fn diagnosis(&self) -> Option<SlaveDiag> {
        match self {
            Answer::Frame { .. } => SlaveDiag::parse(self.data()?).ok(),
            _ => None,
        }
    }

    /// Whether no station answered.
    pub fn is_none(&self) -> bool {
        *self == Answer::None
    }
}

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Answer::Short => f.write_str("short acknowledgement"),
            Answer::Frame { function, data, .. } => {
                match function.word() {
                    Some(word) => f.write_str(word)?,
                    None => write!(f, "function {:#04x}", function.0)?,
                }
                if data.is_empty() { Ok(()) } else { write!(f, ": {}", hex(data)) }
            }
            Answer::None => f.write_str("no answer"),
            Answer::Unfit(why) => write!(f, "the answer does not fit: {why}"),
        }
    }
}

/// Why an acyclic DP-V1 service returned no answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AcyclicError {
    /// The data link did not accept the request, or a poll.
    Link(Answer),
    /// The slave was polled for this time and never had an answer ready.
    Timeout(Duration),
    /// The answer does not match the request; the sentence says how.
    Unfit(String),
}

impl fmt::Display for AcyclicError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            AcyclicError::Link(answer) => answer.fmt(f),
            AcyclicError::Timeout(time) => write!(f, "no answer was ready within {time:?}"),
            AcyclicError::Unfit(why) => write!(f, "the answer does not fit: {why}"),
        }
    }
}

/// The outcome of a record access.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RecordOutcome {
    /// Written, or read with this data.
    Accepted {
        /// The record; empty after a write.
        data: Vec<u8>,
    },
    /// The slave refused.
    Refused(Refusal),
    /// The service returned no answer.
    Failed(AcyclicError),
}

/// The outcome of a base mode request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ParameterOutcome {
    /// The bytes of the response; its reference matches the request.
    Answer(Vec<u8>),
    /// The response has another reference than the request.
    OtherReference {
        /// The reference of the request.
        sent: u8,
        /// The bytes of the response.
        answer: Vec<u8>,
    },
    /// The slave refused the write of the request.
    WriteRefused(Refusal),
    /// The slave refused the read of the response, for another reason than "not ready".
    ReadRefused(Refusal),
    /// The slave never had a response ready. Its last refusal, `None` if it returned empty records, and the time.
    NotReady(Option<Refusal>, Duration),
    /// A service returned no answer.
    Failed(AcyclicError),
}

/// A start-up with the answer of each service that was reached.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StartUp {
    /// First answer to Slave_Diag, before everything else.
    pub diagnosis_before: Option<Answer>,
    /// Answer to Set_Prm.
    pub set_prm: Option<Answer>,
    /// Answer to Chk_Cfg.
    pub chk_cfg: Option<Answer>,
    /// Last answer to Slave_Diag after these services.
    pub diagnosis_after: Option<Answer>,
    /// The first valid answer to Data_Exchange, or the last invalid one.
    pub first_data: Option<Answer>,
    /// Whether data are exchanged.
    pub standing: bool,
    /// Where and why the start-up failed.
    pub failed: Option<Failure>,
}

words! {
    /// The stages of a start-up in their order.
    pub enum Stage {
        Token "token" "The master gets the token.",
        Diagnosis "diagnosis" "The master searches for the slave.",
        SetPrm "set_prm" "The slave receives its parameters.",
        CheckConfiguration "chk_cfg" "The slave checks its configuration.",
        Ready "ready" "The slave becomes ready.",
        Exchange "exchange" "The first valid data arrive.",
    }
}

/// Where and why a start-up ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Failure {
    /// The failed stage.
    pub stage: Stage,
    /// The reason.
    pub why: FailureReason,
}

/// Why a start-up ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FailureReason {
    /// The master never received the token.
    NoToken(Duration),
    /// The answer was negative or invalid.
    Answer(Answer),
    /// According to the diagnosis, the slave rejects the parameters or the configuration.
    Diagnosis(SlaveDiag),
    /// The slave did not become ready in this time.
    NotReady(Duration),
    /// The request was interrupted.
    Aborted,
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.stage, self.why)
    }
}

impl fmt::Display for FailureReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            FailureReason::NoToken(time) => write!(f, "the token did not come within {time:?}"),
            FailureReason::Answer(answer) => answer.fmt(f),
            FailureReason::Diagnosis(diagnosis) => {
                write!(
                    f,
                    "the diagnosis is {:02X} {:02X} {:02X}",
                    diagnosis.status_1.0, diagnosis.status_2.0, diagnosis.status_3.0
                )
            }
            FailureReason::NotReady(time) => write!(f, "the slave was not ready within {time:?}"),
            FailureReason::Aborted => f.write_str("it was interrupted"),
        }
    }
}

/// The state of the connection as the master knows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ConnectionState {
    /// No connection.
    None,
    /// A start-up is running.
    Starting(Stage),
    /// Data are exchanged.
    Exchange,
    /// Release was sent; its answer is pending.
    Releasing,
}

impl fmt::Display for ConnectionState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ConnectionState::None => f.write_str("none"),
            ConnectionState::Starting(stage) => write!(f, "starting: {stage}"),
            ConnectionState::Exchange => f.write_str("data"),
            ConnectionState::Releasing => f.write_str("releasing"),
        }
    }
}

/// The outcome of Release or Abort; the connection has ended in any case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ended {
    /// A Set_Prm with Unlock was sent; the answer of the slave.
    Released(Answer),
    /// The exchange was stopped.
    Aborted,
    /// There was no connection.
    NoConnection,
}

/// Why a connection ended without a request of the caller.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ConnectionEnd {
    /// The answer to Data_Exchange had no data, or data of another length.
    Answer(Answer),
    /// According to the diagnosis, the slave needs new parameters, or belongs to another master.
    Diagnosis(SlaveDiag),
}

impl fmt::Display for ConnectionEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ConnectionEnd::Answer(answer) => write!(f, "Data_Exchange: {answer}"),
            ConnectionEnd::Diagnosis(diagnosis) => write!(
                f,
                "Slave_Diag: {:02X} {:02X} {:02X}, master {}",
                diagnosis.status_1.0, diagnosis.status_2.0, diagnosis.status_3.0, diagnosis.master
            ),
        }
    }
}
