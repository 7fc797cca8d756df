//! Answers: what came back for a request, and whether that is the answer that is right.

use super::Truth;
use super::condition;
use super::view::View;
use expression::Value;
use results::outcome::PartSeen;
use std::fmt;
use suite::model::{Answer, AnswerPart, Code, Matcher};
use wire::profibus::dpv1::{ErrorDecode, RecordError};
use wire::profibus::fdl::AnswerFunction;
use wire::profidrive::ErrorNumber;
use wire::profinet::dcp::BlockError;
use wire::profinet::status::PnioStatus;

/// Why a request was refused, with the device's own number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// A PROFIdrive error number.
    Parameter(u16),
    /// A PNIO status.
    Pnio(PnioStatus),
    /// A DCP block error.
    Dcp(u8),
    /// DCP says that it does not know the service.
    NotSupported,
    /// A status of HTTP that is no success.
    Http(u16),
    /// The data link of a slave does not serve the access point: the function code of its answer.
    Fdl(u8),
    /// A negative response of DP-V1.
    Dpv1 {
        /// Error_Decode.
        decode: u8,
        /// Error_Code_1.
        code1: u8,
        /// Error_Code_2.
        code2: u8,
    },
}

/// What came back for a request, or for a part of one.
#[derive(Clone, Debug, PartialEq)]
pub enum Reply {
    /// It was carried out.
    Accepted,
    /// It was refused.
    Refused(Refusal),
    /// Something came that is no answer to it: another reference, an unreadable one, a wrong kind. No suite asks for that.
    Wrong(String),
    /// Nobody answered; which wait ran out.
    Silent(String),
    /// A value came (octets, a word, a number).
    Value(Value),
}

impl Refusal {
    /// Whether it is the refusal that the word of a suite stands for.
    pub fn is(&self, code: &Code) -> bool {
        match (self, code) {
            (Refusal::Parameter(seen), Code::Parameter(wanted, _)) => seen == wanted,
            (Refusal::Dcp(seen), Code::Dcp(wanted, _)) => seen == wanted,
            (Refusal::Fdl(seen), Code::Fdl(wanted, _)) => seen == wanted,
            (Refusal::Dpv1 { code1: seen, decode, .. }, Code::Dpv1 { code1, .. }) => {
                seen == code1 && *decode == ErrorDecode::DPV1.0
            }
            (Refusal::Pnio(seen), Code::Pnio { decode, code1, code2, .. }) => {
                seen.error_decode.0 == *decode
                    && seen.error_code1 == *code1
                    && code2.is_none_or(|code2| seen.error_code2 == code2)
            }
            _ => false,
        }
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Refusal::Parameter(number) => match ErrorNumber(*number).word() {
                Some(word) => write!(f, "error number 0x{number:02X} ({word})"),
                None => write!(f, "error number 0x{number:02X}"),
            },
            Refusal::Pnio(status) => write!(f, "PNIO status {status}"),
            Refusal::Dcp(error) => match BlockError(*error).word() {
                Some(word) => write!(f, "DCP block error {error} ({word})"),
                None => write!(f, "DCP block error {error}"),
            },
            Refusal::NotSupported => f.write_str("the service is not supported"),
            Refusal::Http(status) => write!(f, "HTTP status {status}"),
            Refusal::Fdl(function) => match AnswerFunction(*function).word() {
                Some(word) => write!(f, "FDL answer {function:#04X} ({word})"),
                None => write!(f, "FDL answer {function:#04X}"),
            },
            Refusal::Dpv1 { decode, code1, code2 } => {
                write!(f, "DP-V1 error {decode:02X} {code1:02X} {code2:02X}")?;
                match RecordError(*code1).word().filter(|_| *decode == ErrorDecode::DPV1.0) {
                    Some(word) => write!(f, " ({word})"),
                    None => Ok(()),
                }
            }
        }
    }
}

impl fmt::Display for Reply {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Reply::Accepted => f.write_str("accepted"),
            Reply::Refused(refusal) => write!(f, "refused: {refusal}"),
            Reply::Wrong(why) => write!(f, "no proper answer: {why}"),
            Reply::Silent(wait) => write!(f, "no answer ({wait})"),
            Reply::Value(Value::Text(text)) => write!(f, "'{}'", super::page::shortened(text)),
            Reply::Value(value) => write!(f, "{}", super::view::plain(value)),
        }
    }
}

/// The codes of a `refused`, in words.
pub fn refused(codes: &[Code]) -> String {
    let word = |code: &Code| match code {
        Code::Parameter(number, word) => format!("{word} (0x{number:02X})"),
        Code::Pnio { word, .. } => word.clone(),
        Code::Dcp(number, word) | Code::Fdl(number, word) => format!("{word} ({number})"),
        Code::Dpv1 { code1, word } => format!("{word} (0x{code1:02X})"),
    };
    match codes {
        [] => "refused".into(),
        codes => format!("refused: {}", codes.iter().map(word).collect::<Vec<_>>().join(" or ")),
    }
}

/// Whether a reply refuses with one of these codes; with any where there are none.
pub fn refuses(reply: &Reply, codes: &[Code]) -> bool {
    match reply {
        Reply::Refused(refusal) => codes.is_empty() || codes.iter().any(|code| refusal.is(code)),
        Reply::Accepted | Reply::Wrong(_) | Reply::Silent(_) | Reply::Value(_) => false,
    }
}

/// Whether the replies are those that the suite calls right, and which part is wanted and seen.
pub fn judge(answer: &Answer, replies: &[(AnswerPart, Reply)], view: &View<'_>) -> Vec<PartSeen> {
    let mut parts = Vec::new();
    judge_part(answer, &AnswerPart::Whole, replies, view, &mut parts);
    parts
}

fn judge_part(
    answer: &Answer,
    part: &AnswerPart,
    replies: &[(AnswerPart, Reply)],
    view: &View<'_>,
    parts: &mut Vec<PartSeen>,
) {
    let reply = replies.iter().find(|(known, _)| known == part).map(|(_, reply)| reply);
    let seen = reply.map_or_else(|| "nothing".to_owned(), Reply::to_string);
    let mut add = |wanted: String, held: bool| {
        parts.push(PartSeen { text: part_name(part, view), wanted, seen: seen.clone(), held });
    };
    match answer {
        Answer::Accepted => add("accepted".into(), matches!(reply, Some(Reply::Accepted))),
        Answer::None => add("no answer".into(), matches!(reply, None | Some(Reply::Silent(_)))),
        Answer::Any => add("any answer".into(), matches!(reply, Some(Reply::Accepted | Reply::Refused(_)))),
        Answer::Refused(codes) => add(refused(codes), reply.is_some_and(|reply| refuses(reply, codes))),
        Answer::Is(matcher) => {
            let held = match (reply, matcher) {
                (Some(Reply::Value(value)), matcher) => condition::matches(matcher, value, view) == Truth::True,
                (Some(reply), Matcher::Refused(codes)) => refuses(reply, codes),
                (Some(Reply::Accepted), Matcher::Accepted) => true,
                _ => false,
            };
            add(condition::wanted_text(matcher, view), held);
        }
        Answer::Parts(list) => {
            for (part, answer) in list {
                judge_part(answer, part, replies, view, parts);
            }
        }
        Answer::OneOf(list) => {
            let mut all = Vec::new();
            for answer in list {
                let mut tried = Vec::new();
                judge_part(answer, part, replies, view, &mut tried);
                if tried.iter().all(|part| part.held) {
                    parts.extend(tried);
                    return;
                }
                all.extend(tried);
            }
            parts.extend(all);
        }
    }
}

/// A part of an answer as suites write it.
pub fn part_name(part: &AnswerPart, view: &View<'_>) -> String {
    let record = |index: &usize| view.device.records.get(*index).map_or("?", |record| &record.name);
    let submodule = |index: &usize| view.device.submodules.get(*index).map_or("?", |submodule| &submodule.name);
    match part {
        AnswerPart::Whole => "answer".into(),
        AnswerPart::Parameter(number, 0) => format!("answer.P{number}"),
        AnswerPart::Parameter(number, subindex) => format!("answer.P{number}.{subindex}"),
        AnswerPart::Bytes => "answer.bytes".into(),
        AnswerPart::Connect => "answer.connect".into(),
        AnswerPart::Record(index) => format!("answer.{}", record(index)),
        AnswerPart::ModuleDiff(index) => format!("answer.module_diff.{}", submodule(index)),
        AnswerPart::SetPrm => "answer.set_prm".into(),
        AnswerPart::ChkCfg => "answer.chk_cfg".into(),
        AnswerPart::Diagnosis(name) => format!("answer.diag.{}", view.device.diagnosis_name(*name)),
        AnswerPart::ParameterEnd => "answer.parameter_end".into(),
        AnswerPart::ApplicationReady => "answer.application_ready".into(),
        AnswerPart::Connection => "answer.connection".into(),
        AnswerPart::Status => "answer.status".into(),
        AnswerPart::Contains => "answer.contains".into(),
        AnswerPart::Lacks => "answer.lacks".into(),
        AnswerPart::Text => "answer.text".into(),
    }
}
