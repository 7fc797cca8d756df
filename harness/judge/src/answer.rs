//! Answers to requests or parts of requests, and the comparison of negative responses with codes of a suite.

use super::format::plain;
use super::page;
use expression::Value;
use std::fmt;
use suite::model::Code;
use wire::profibus::dpv1::{Dpv1AbortReason, Dpv1ErrorDecode, RecordError};
use wire::profibus::fdl::AnswerFunction;
use wire::profidrive::ErrorNumber;
use wire::profinet::dcp::BlockError;
use wire::profinet::status::PnioStatus;

/// A negative response with the error code of the device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NegativeResponse {
    /// A PROFIdrive error number.
    Parameter(u16),
    /// A PNIO status.
    Pnio(PnioStatus),
    /// A DCP block error.
    Dcp(u8),
    /// DCP: the service is not supported.
    NotSupported,
    /// An HTTP status other than success.
    Http(u16),
    /// FDL: the slave does not serve the SAP; the function code of its answer.
    Fdl(u8),
    /// A negative response of DP-V1.
    Dpv1 { decode: u8, code1: u8, code2: u8 },
    /// The slave has aborted its MS2 connection: instance and reason.
    Abort(u8),
}

/// The answer to a request or a part of a request.
#[derive(Clone, Debug, PartialEq)]
pub enum ReceivedReply {
    /// A positive response.
    Accepted,
    /// A negative response.
    Refused(NegativeResponse),
    /// An invalid response: wrong reference, unreadable or of the wrong type. No suite expects it.
    Wrong(String),
    /// No answer; the description of the timeout.
    Silent(String),
    /// A value (bytes, a word, a number).
    Value(Value),
}

impl NegativeResponse {
    /// Whether the response has this code of a suite.
    pub fn is(&self, code: &Code) -> bool {
        match (self, code) {
            (NegativeResponse::Parameter(observed), Code::Parameter(expected, _)) => observed == expected,
            (NegativeResponse::Dcp(observed), Code::Dcp(expected, _)) => observed == expected,
            (NegativeResponse::Fdl(observed), Code::Fdl(expected, _)) => observed == expected,
            (NegativeResponse::Abort(observed), Code::Abort(expected, _)) => observed == expected,
            (NegativeResponse::Dpv1 { code1: observed, decode, .. }, Code::Dpv1 { code1, .. }) => {
                observed == code1 && *decode == Dpv1ErrorDecode::DPV1.0
            }
            (NegativeResponse::Pnio(observed), Code::Pnio { decode, code1, code2, .. }) => {
                observed.error_decode.0 == *decode
                    && observed.error_code1 == *code1
                    && code2.is_none_or(|code2| observed.error_code2 == code2)
            }
            _ => false,
        }
    }
}

impl fmt::Display for NegativeResponse {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            NegativeResponse::Parameter(number) => match ErrorNumber(*number).word() {
                Some(word) => write!(f, "error number 0x{number:02X} ({word})"),
                None => write!(f, "error number 0x{number:02X}"),
            },
            NegativeResponse::Pnio(status) => write!(f, "PNIO status {status}"),
            NegativeResponse::Dcp(error) => match BlockError(*error).word() {
                Some(word) => write!(f, "DCP block error {error} ({word})"),
                None => write!(f, "DCP block error {error}"),
            },
            NegativeResponse::NotSupported => f.write_str("the service is not supported"),
            NegativeResponse::Http(status) => write!(f, "HTTP status {status}"),
            NegativeResponse::Fdl(function) => match AnswerFunction(*function).word() {
                Some(word) => write!(f, "FDL answer {function:#04X} ({word})"),
                None => write!(f, "FDL answer {function:#04X}"),
            },
            NegativeResponse::Abort(reason) => match Dpv1AbortReason(*reason).word() {
                Some(word) => write!(f, "Abort {reason:#04X} ({word})"),
                None => write!(f, "Abort {reason:#04X}"),
            },
            NegativeResponse::Dpv1 { decode, code1, code2 } => {
                write!(f, "DP-V1 error {decode:02X} {code1:02X} {code2:02X}")?;
                match RecordError(*code1).word().filter(|_| *decode == Dpv1ErrorDecode::DPV1.0) {
                    Some(word) => write!(f, " ({word})"),
                    None => Ok(()),
                }
            }
        }
    }
}

impl fmt::Display for ReceivedReply {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            ReceivedReply::Accepted => f.write_str("accepted"),
            ReceivedReply::Refused(refusal) => write!(f, "refused: {refusal}"),
            ReceivedReply::Wrong(why) => write!(f, "invalid answer: {why}"),
            ReceivedReply::Silent(wait) => write!(f, "no answer ({wait})"),
            ReceivedReply::Value(Value::Text(text)) => write!(f, "'{}'", page::shortened(text)),
            ReceivedReply::Value(value) => write!(f, "{}", plain(value)),
        }
    }
}

/// Formats the codes of a `refused`.
pub fn refused(codes: &[Code]) -> String {
    let word = |code: &Code| match code {
        Code::Parameter(number, word) => format!("{word} (0x{number:02X})"),
        Code::Pnio { word, .. } => word.clone(),
        Code::Dcp(number, word) | Code::Fdl(number, word) | Code::Abort(number, word) => format!("{word} ({number})"),
        Code::Dpv1 { code1, word } => format!("{word} (0x{code1:02X})"),
    };
    match codes {
        [] => "refused".into(),
        codes => format!("refused: {}", codes.iter().map(word).collect::<Vec<_>>().join(" or ")),
    }
}

/// Whether a reply is a negative response with one of these codes, or with any code if the list is empty.
pub fn refuses(reply: &ReceivedReply, codes: &[Code]) -> bool {
    match reply {
        ReceivedReply::Refused(refusal) => codes.is_empty() || codes.iter().any(|code| refusal.is(code)),
        ReceivedReply::Accepted | ReceivedReply::Wrong(_) | ReceivedReply::Silent(_) | ReceivedReply::Value(_) => false,
    }
}
