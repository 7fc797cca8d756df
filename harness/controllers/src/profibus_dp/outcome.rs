//! Outcomes of requests, and ends of connections.
//!
//! The master reports how its own requests ended; observers read from the frames what the slave did.

use super::ms2_outcome::{Ms2End, Ms2Outcome};
use crate::words::words;
use alloc::boxed::Box;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt;
use core::time::Duration;
use plain_text::hex;
use wire::profibus::diag::SlaveDiag;
use wire::profibus::dpv1::Dpv1Refusal;
use wire::profibus::fdl::{AnswerFunction, StationType};

/// The outcome of a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum MasterOutcome {
    /// Outcome of Connect.
    StartUp(Box<SlaveStartUpResult>),
    /// Outcome of any DP-V0 or data link service.
    Answer(DataLinkAnswer),
    /// Outcome of Read or Write.
    Record(DpRecordOutcome),
    /// Outcome of a base mode request.
    Parameter(DpParameterOutcome),
    /// Outcome of Release or Abort.
    Ended(SlaveReleaseOutcome),
    /// A frame was sent; no answer is awaited.
    Sent,
    /// A damaged frame was sent.
    Broken {
        /// Its bytes.
        octets: Vec<u8>,
        /// What came within the slot time.
        answer: DataLinkAnswer,
    },
    /// Outcome of a request on MS2.
    Ms2(Ms2Outcome),
    /// Outcome of a repeated request.
    Repeated(Box<RepeatedAnswers>),
    /// The request cannot be carried out now; the sentence says why.
    Impossible(&'static str),
}

/// The answers to a request whose frames were sent again with the same frame count bit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RepeatedAnswers {
    /// The outcome of the request, from the first answer to each frame.
    pub outcome: MasterOutcome,
    /// Number of repetitions that got the first answer again.
    pub answered: u32,
    /// The first answer to a frame and a different one to its repetition, of the first frame with a difference.
    pub difference: Option<(DataLinkAnswer, DataLinkAnswer)>,
}

/// How the data link answered a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DataLinkAnswer {
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

impl DataLinkAnswer {
    /// Whether the request was accepted: a short acknowledgement, OK, or data.
    pub fn is_positive(&self) -> bool {
        match self {
            DataLinkAnswer::Short => true,
            DataLinkAnswer::Frame { function, .. } => matches!(
                *function,
                AnswerFunction::OK | AnswerFunction::DATA_LOW | AnswerFunction::DATA_HIGH | AnswerFunction::NO_DATA
            ),
            DataLinkAnswer::None | DataLinkAnswer::Unfit(_) => false,
        }
    }

    /// The function code with which the slave refused the request, such as RS for an inactive access point.
    pub fn refused(&self) -> Option<AnswerFunction> {
        match self {
            DataLinkAnswer::Frame { function, .. } if !self.is_positive() => Some(*function),
            _ => None,
        }
    }

    /// The data of a positive answer; a short acknowledgement has none.
    pub fn data(&self) -> Option<&[u8]> {
        match self {
            DataLinkAnswer::Short => Some(&[]),
            DataLinkAnswer::Frame { data, .. } if self.is_positive() => Some(data),
            _ => None,
        }
    }

    /// The data as diagnosis; `None` if there are too few bytes.
    pub fn diagnosis(&self) -> Option<SlaveDiag> {
        match self {
            DataLinkAnswer::Frame { .. } => SlaveDiag::parse(self.data()?).ok(),
            _ => None,
        }
    }

    /// Whether it is a frame of the station, whatever it says.
    pub fn is_frame(&self) -> bool {
        matches!(self, DataLinkAnswer::Short | DataLinkAnswer::Frame { .. })
    }

    /// Whether no station answered.
    pub fn is_none(&self) -> bool {
        *self == DataLinkAnswer::None
    }
}

impl fmt::Display for DataLinkAnswer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            DataLinkAnswer::Short => f.write_str("short acknowledgement"),
            DataLinkAnswer::Frame { function, data, .. } => {
                match function.word() {
                    Some(word) => f.write_str(word)?,
                    None => write!(f, "function {:#04x}", function.0)?,
                }
                if data.is_empty() { Ok(()) } else { write!(f, ": {}", hex(data)) }
            }
            DataLinkAnswer::None => f.write_str("no answer"),
            DataLinkAnswer::Unfit(why) => write!(f, "the answer does not fit: {why}"),
        }
    }
}

/// Why an acyclic DP-V1 service returned no answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum AcyclicError {
    /// The data link did not accept the request, or a poll.
    Link(DataLinkAnswer),
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
pub enum DpRecordOutcome {
    /// Written, or read with this data.
    Accepted {
        /// The record; empty after a write.
        data: Vec<u8>,
    },
    /// The slave refused.
    Refused(Dpv1Refusal),
    /// On MS2 the slave closed the connection instead of answering.
    Aborted(Ms2End),
    /// The service returned no answer.
    Failed(AcyclicError),
}

/// The outcome of a base mode request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DpParameterOutcome {
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
    WriteRefused(Dpv1Refusal),
    /// The slave refused the read of the response, for another reason than "not ready".
    ReadRefused(Dpv1Refusal),
    /// The slave never had a response ready. Its last refusal, `None` if it returned empty records, and the time.
    NotReady(Option<Dpv1Refusal>, Duration),
    /// A service returned no answer.
    Failed(AcyclicError),
}

/// A start-up with the answer of each service that was reached.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SlaveStartUpResult {
    /// First answer to Slave_Diag, before everything else.
    pub diagnosis_before: Option<DataLinkAnswer>,
    /// Answer to Set_Prm.
    pub set_prm: Option<DataLinkAnswer>,
    /// Answer to Chk_Cfg.
    pub chk_cfg: Option<DataLinkAnswer>,
    /// Last answer to Slave_Diag after these services.
    pub diagnosis_after: Option<DataLinkAnswer>,
    /// The first valid answer to Data_Exchange, or the last invalid one.
    pub first_data: Option<DataLinkAnswer>,
    /// Whether data are exchanged.
    pub standing: bool,
    /// Where and why the start-up failed.
    pub failed: Option<SlaveStartUpFailure>,
}

words! {
    /// The stages of a start-up in their order.
    pub enum SlaveStartUpStage {
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
pub struct SlaveStartUpFailure {
    /// The failed stage.
    pub stage: SlaveStartUpStage,
    /// The reason.
    pub why: SlaveFailureReason,
}

/// Why a start-up ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SlaveFailureReason {
    /// The master never received the token.
    NoToken(Duration),
    /// The answer was negative or invalid.
    Answer(DataLinkAnswer),
    /// According to the diagnosis, the slave rejects the parameters or the configuration.
    Diagnosis(SlaveDiag),
    /// The slave did not become ready in this time.
    NotReady(Duration),
    /// The request was interrupted.
    Aborted,
}

impl fmt::Display for SlaveStartUpFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.stage, self.why)
    }
}

impl fmt::Display for SlaveFailureReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SlaveFailureReason::NoToken(time) => write!(f, "the token did not come within {time:?}"),
            SlaveFailureReason::Answer(answer) => answer.fmt(f),
            SlaveFailureReason::Diagnosis(diagnosis) => {
                write!(
                    f,
                    "the diagnosis is {:02X} {:02X} {:02X}",
                    diagnosis.status_1.0, diagnosis.status_2.0, diagnosis.status_3.0
                )
            }
            SlaveFailureReason::NotReady(time) => write!(f, "the slave was not ready within {time:?}"),
            SlaveFailureReason::Aborted => f.write_str("it was interrupted"),
        }
    }
}

/// The state of the connection as the master knows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ConnectionState {
    /// No connection.
    None,
    /// A start-up is running.
    Starting(SlaveStartUpStage),
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
pub enum SlaveReleaseOutcome {
    /// A Set_Prm with Unlock was sent; the answer of the slave.
    Released(DataLinkAnswer),
    /// The exchange was stopped.
    Aborted,
    /// There was no connection.
    NoConnection,
}

/// Why a connection ended without a request of the caller.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum SlaveConnectionEnd {
    /// The answer to Data_Exchange had no data, or data of another length.
    Answer(DataLinkAnswer),
    /// According to the diagnosis, the slave needs new parameters, or belongs to another master.
    Diagnosis(SlaveDiag),
}

impl fmt::Display for SlaveConnectionEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            SlaveConnectionEnd::Answer(answer) => write!(f, "Data_Exchange: {answer}"),
            SlaveConnectionEnd::Diagnosis(diagnosis) => write!(
                f,
                "Slave_Diag: {:02X} {:02X} {:02X}, master {}",
                diagnosis.status_1.0, diagnosis.status_2.0, diagnosis.status_3.0, diagnosis.master
            ),
        }
    }
}
