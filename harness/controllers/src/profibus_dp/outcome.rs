//! What became of a request, and of the connection.
//!
//! The master acts and reports how its own requests went; what the slave did is read from the frames by others.

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

/// What became of a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Connect.
    StartUp(Box<StartUp>),
    /// Any service of DP-V0 or of the data link.
    Answer(Answer),
    /// Read or Write.
    Record(RecordOutcome),
    /// A request of the base mode.
    Parameter(ParameterOutcome),
    /// Release or Abort.
    Ended(Ended),
    /// A frame was sent; nothing is waited for.
    Sent,
    /// A damaged frame was sent: these are its octets.
    Broken(Vec<u8>),
    /// What was asked for cannot be done now; the sentence says why.
    Impossible(&'static str),
}

/// How the data link answered a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Answer {
    /// A short acknowledgement.
    Short,
    /// A frame with function code: data, or an acknowledgement that may be negative.
    Frame {
        /// What it says.
        function: AnswerFunction,
        /// The type of the station.
        station: StationType,
        /// The data; empty where there are none.
        data: Vec<u8>,
    },
    /// Nobody answered, however often it was asked.
    None,
    /// What came is no answer to the request; the sentence says in what.
    Unfit(String),
}

impl Answer {
    /// Whether the request was taken: a short acknowledgement, OK, or data.
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

    /// The function with which the slave refused the request, such as RS for an access point that is not active.
    pub fn refused(&self) -> Option<AnswerFunction> {
        match self {
            Answer::Frame { function, .. } if !self.is_positive() => Some(*function),
            _ => None,
        }
    }

    /// The data of a positive answer; those of a short acknowledgement are empty.
    pub fn data(&self) -> Option<&[u8]> {
        match self {
            Answer::Short => Some(&[]),
            Answer::Frame { data, .. } if self.is_positive() => Some(data),
            _ => None,
        }
    }

    /// The data as diagnosis; none if there are none or they are too short.
    pub fn diagnosis(&self) -> Option<SlaveDiag> {
        match self {
            Answer::Frame { .. } => SlaveDiag::parse(self.data()?).ok(),
            _ => None,
        }
    }

    /// Whether nobody answered.
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

/// Why an acyclic service of DP-V1 brought no answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AcyclicError {
    /// The data link did not take the request, or a poll.
    Link(Answer),
    /// The slave was polled so long and never had an answer.
    Timeout(Duration),
    /// An answer came that does not fit the request; the sentence says in what.
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

/// How it went with a record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RecordOutcome {
    /// Written, or read with this data.
    Accepted {
        /// The record; empty after writing.
        data: Vec<u8>,
    },
    /// The slave refused.
    Refused(Refusal),
    /// The service brought no answer.
    Failed(AcyclicError),
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
    WriteRefused(Refusal),
    /// Reading the response was refused, otherwise than by "not yet".
    ReadRefused(Refusal),
    /// The slave never had an answer ready; this was its last refusal, none if it gave empty records.
    NotReady(Option<Refusal>, Duration),
    /// A service brought no answer.
    Failed(AcyclicError),
}

/// A start-up with the answer of each service that was reached.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct StartUp {
    /// Slave_Diag before everything else: the first answer.
    pub diagnosis_before: Option<Answer>,
    /// Set_Prm.
    pub set_prm: Option<Answer>,
    /// Chk_Cfg.
    pub chk_cfg: Option<Answer>,
    /// Slave_Diag behind them: the last answer.
    pub diagnosis_after: Option<Answer>,
    /// The first answer of Data_Exchange that is good, or the last one that is not.
    pub first_data: Option<Answer>,
    /// Whether data are exchanged.
    pub standing: bool,
    /// Where the start-up ended otherwise, and why.
    pub failed: Option<Failure>,
}

words! {
    /// The stages of a start-up in their order.
    pub enum Stage {
        Token "token" "The master gets the token.",
        Diagnosis "diagnosis" "The slave is looked for.",
        SetPrm "set_prm" "The slave gets its parameters.",
        CheckConfiguration "chk_cfg" "The slave checks its configuration.",
        Ready "ready" "The slave becomes ready.",
        Exchange "exchange" "The first good data come.",
    }
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
    /// The master never got the token.
    NoToken(Duration),
    /// The answer was not a good one.
    Answer(Answer),
    /// The diagnosis says that the slave does not take the parameters or the configuration.
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

/// What a master sees of its connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ConnectionState {
    /// There is none.
    None,
    /// One is started up.
    Starting(Stage),
    /// Data are exchanged.
    Exchange,
    /// The slave is given free; its answer has not come yet.
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

/// How Release or Abort went; the connection is gone in any case.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ended {
    /// A Set_Prm with Unlock was sent; the answer of the slave.
    Released(Answer),
    /// The exchange was stopped.
    Aborted,
    /// There was no connection.
    NoConnection,
}

/// Why a connection ended that we did not ask to end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ConnectionEnd {
    /// Data_Exchange was answered otherwise than with data, or with data of another length.
    Answer(Answer),
    /// The diagnosis says that the slave wants new parameters, or belongs to another master.
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
