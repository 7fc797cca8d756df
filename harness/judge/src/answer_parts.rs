//! Compares the answer to a request with the expected answer, part by part.

use super::Truth;
use super::answer::{Reply, refused, refuses};
use super::condition;
use super::view::View;
use results::outcome::PartSeen;
use suite::model::{Answer, AnswerPart, Matcher};

/// Compares replies with the expected answer; returns expected and observed value of each part.
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
    let seen = match (answer, reply) {
        (Answer::Is(matcher), Some(Reply::Value(value))) => condition::named_octets(matcher, value),
        _ => None,
    };
    let seen = seen.unwrap_or_else(|| reply.map_or_else(|| "nothing".to_owned(), Reply::to_string));
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

/// The name of a part of an answer as suites write it.
fn part_name(part: &AnswerPart, view: &View<'_>) -> String {
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
