//! Compares the answer to a request with the expected answer, part by part.

use super::Truth;
use super::answer::{ReceivedReply, refused, refuses};
use super::condition;
use super::view::NameView;
use results::outcome::JudgedPart;
use suite::model::{AnswerMatcher, AnswerPart, Matcher};

/// Compares replies with the expected answer; returns expected and observed value of each part.
pub fn judge(answer: &AnswerMatcher, replies: &[(AnswerPart, ReceivedReply)], view: &NameView<'_>) -> Vec<JudgedPart> {
    let mut parts = Vec::new();
    judge_part(answer, &AnswerPart::Whole, replies, view, &mut parts);
    parts
}

fn judge_part(
    answer: &AnswerMatcher,
    part: &AnswerPart,
    replies: &[(AnswerPart, ReceivedReply)],
    view: &NameView<'_>,
    parts: &mut Vec<JudgedPart>,
) {
    let reply = replies.iter().find(|(known, _)| known == part).map(|(_, reply)| reply);
    let seen = match (answer, reply) {
        (AnswerMatcher::Is(matcher), Some(ReceivedReply::Value(value))) => condition::named_octets(matcher, value),
        _ => None,
    };
    let seen = seen.unwrap_or_else(|| reply.map_or_else(|| "nothing".to_owned(), ReceivedReply::to_string));
    let mut add = |wanted: String, held: bool| {
        parts.push(JudgedPart { text: part_name(part, view), expected: wanted, observed: seen.clone(), held });
    };
    match answer {
        AnswerMatcher::Accepted => add("accepted".into(), matches!(reply, Some(ReceivedReply::Accepted))),
        AnswerMatcher::None => add("no answer".into(), matches!(reply, None | Some(ReceivedReply::Silent(_)))),
        AnswerMatcher::Any => {
            add("any answer".into(), matches!(reply, Some(ReceivedReply::Accepted | ReceivedReply::Refused(_))))
        }
        AnswerMatcher::Refused(codes) => add(refused(codes), reply.is_some_and(|reply| refuses(reply, codes))),
        AnswerMatcher::Is(matcher) => {
            let held = match (reply, matcher) {
                (Some(ReceivedReply::Value(value)), matcher) => condition::matches(matcher, value, view) == Truth::True,
                (Some(reply), Matcher::Refused(codes)) => refuses(reply, codes),
                (Some(ReceivedReply::Accepted), Matcher::Accepted) => true,
                _ => false,
            };
            add(condition::expected_text(matcher, view), held);
        }
        AnswerMatcher::Parts(list) => {
            for (part, answer) in list {
                judge_part(answer, part, replies, view, parts);
            }
        }
        AnswerMatcher::OneOf(list) => {
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

/// The name of a part of an answer as suites write it.
fn part_name(part: &AnswerPart, view: &NameView<'_>) -> String {
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
        AnswerPart::Number => "answer.number".into(),
    }
}
