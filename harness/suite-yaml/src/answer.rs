//! Which answer is right: of a request as a whole, of its parts, and as an expectation of the last one.

use super::device_yaml::plain;
use super::dialect::Service;
use super::error::{Mistake, Read};
use super::frame::StepScope;
use super::keys::WordChoices;
use super::names::Verbs;
use super::yaml::Node;
use expression::{Type, Value};
use suite::device::{AnswerPart, DiagnosisName, NameKind};
use suite::model::{AnswerMatcher, Code, Matcher};

/// What ModuleDiff can say of a submodule.
pub(super) static MODULE_STATES: WordChoices<&str> = WordChoices(&[
    ("proper", "proper"),
    ("substitute", "substitute"),
    ("wrong", "wrong"),
    ("missing", "missing"),
    ("locked", "locked"),
]);
/// What a connection is after its start-up.
pub(super) static CONNECTIONS: WordChoices<&str> = WordChoices(&[("none", "none"), ("data", "data")]);

/// An answer as a whole.
#[derive(Clone, Copy, Debug)]
pub(super) enum WholeAnswer {
    Accepted,
    None,
    Any,
}

/// The words for an answer as a whole.
pub(super) static ANSWERS: WordChoices<WholeAnswer> =
    WordChoices(&[("accepted", WholeAnswer::Accepted), ("none", WholeAnswer::None), ("any", WholeAnswer::Any)]);

/// The kind of request, which decides the parts that an answer has.
#[derive(Clone, Copy, Debug)]
pub(super) enum RequestKind<'a> {
    /// Parameters, by number and subindex in the order written.
    Parameters(&'a [(u16, u16)]),
    /// A record, DCP, or a service: no parts.
    Whole(Service),
    /// A start-up.
    Connect,
    /// A web page.
    Web,
}

impl RequestKind<'_> {
    fn service(self) -> Service {
        match self {
            RequestKind::Parameters(_) => Service::Parameters,
            RequestKind::Whole(service) => service,
            RequestKind::Connect => Service::Connect,
            RequestKind::Web => Service::Last,
        }
    }
}

impl StepScope<'_, '_> {
    /// The value of `answer`.
    pub(super) fn answer(&self, node: &Node, asked: RequestKind<'_>) -> Read<AnswerMatcher> {
        if let Some(items) = node.sequence() {
            if items.len() < 2 {
                return Err(node.wrong("a list of answers has two or more of which one must hold"));
            }
            return items.iter().map(|item| self.answer(item, asked)).collect::<Read<_>>().map(AnswerMatcher::OneOf);
        }
        let Some(entries) = node.mapping() else {
            return Ok(match ANSWERS.find(node, "answer")? {
                WholeAnswer::Accepted => AnswerMatcher::Accepted,
                WholeAnswer::None => AnswerMatcher::None,
                WholeAnswer::Any => AnswerMatcher::Any,
            });
        };
        if let Some(refused) = node.get("refused") {
            if entries.len() > 1 {
                return Err(node.wrong("`refused` stands alone"));
            }
            return Ok(AnswerMatcher::Refused(self.refused(refused, asked.service())?));
        }
        if entries.is_empty() {
            return Err(node.wrong("an empty answer"));
        }
        entries.iter().map(|(key, value)| self.part(key, value, asked)).collect::<Read<_>>().map(AnswerMatcher::Parts)
    }

    fn part(&self, key: &Node, value: &Node, asked: RequestKind<'_>) -> Read<(AnswerPart, AnswerMatcher)> {
        let name = key.text("a part of the answer")?;
        let device = self.names.device();
        let bytes = || Ok((AnswerPart::Bytes, AnswerMatcher::Is(self.matcher(value, &Type::Bytes, None)?)));
        match asked {
            RequestKind::Web => match name {
                "status" => {
                    Ok((AnswerPart::Status, AnswerMatcher::Is(self.matcher(value, &Type::whole(16, false), None)?)))
                }
                "contains" => Ok((AnswerPart::Contains, AnswerMatcher::Is(Matcher::Contains(self.texts(value)?)))),
                "lacks" => Ok((AnswerPart::Lacks, AnswerMatcher::Is(Matcher::Lacks(self.texts(value)?)))),
                _ => Err(Mistake::unknown(key.spot, "part of a web answer", name, ["status", "contains", "lacks"])),
            },
            RequestKind::Parameters(_) | RequestKind::Whole(_) if name == "bytes" => bytes(),
            RequestKind::Parameters(written) => {
                let found = self.names.for_verb(key, name, Verbs::WRITE, "answer")?;
                match found.kind {
                    NameKind::Parameter { number, subindex, .. } if written.contains(&(number, subindex)) => Ok((
                        AnswerPart::Parameter(number, subindex),
                        self.answer(value, RequestKind::Whole(Service::Parameters))?,
                    )),
                    _ => Err(key.wrong(format!("`{name}` is not in this request"))),
                }
            }
            RequestKind::Whole(_) => Err(Mistake::unknown(key.spot, "part of this answer", name, ["bytes", "refused"])),
            RequestKind::Connect if device.profibus().is_some() => self.slave_stage(key, value, name),
            RequestKind::Connect => {
                let record = device.records.iter().position(|record| record.start && record.name == name);
                let part = match (name, record) {
                    (_, Some(record)) => {
                        self.names.mark("record", name);
                        return Ok((
                            AnswerPart::Record(record),
                            self.answer(value, RequestKind::Whole(Service::Record))?,
                        ));
                    }
                    ("connect", _) => AnswerPart::Connect,
                    ("parameter_end", _) => AnswerPart::ParameterEnd,
                    ("application_ready", _) => AnswerPart::ApplicationReady,
                    ("connection", _) => {
                        return Ok((AnswerPart::Connection, AnswerMatcher::Is(states(value, &CONNECTIONS)?)));
                    }
                    _ => return self.module_diff(key, name, value),
                };
                Ok((part, self.answer(value, RequestKind::Whole(Service::Connect))?))
            }
        }
    }

    /// A stage of a start-up on PROFIBUS.
    fn slave_stage(&self, key: &Node, value: &Node, name: &str) -> Read<(AnswerPart, AnswerMatcher)> {
        let asked = RequestKind::Whole(Service::Dp);
        match name {
            "set_prm" => Ok((AnswerPart::SetPrm, self.answer(value, asked)?)),
            "chk_cfg" => Ok((AnswerPart::ChkCfg, self.answer(value, asked)?)),
            "connection" => Ok((AnswerPart::Connection, AnswerMatcher::Is(states(value, &CONNECTIONS)?))),
            _ if name.starts_with("diag.") => {
                let found = self.names.for_verb(key, name, Verbs::EXPECT, "answer")?;
                match found.kind {
                    NameKind::Diagnosis(part) => {
                        Ok((AnswerPart::Diagnosis(part), AnswerMatcher::Is(self.matcher(value, &found.ty, None)?)))
                    }
                    _ => Err(key.wrong(format!("`{name}` is no part of a start-up"))),
                }
            }
            _ => {
                let diagnosis = DiagnosisName::words().map(|(word, _)| format!("diag.{word}"));
                let known: Vec<String> =
                    ["set_prm", "chk_cfg", "connection"].map(str::to_owned).into_iter().chain(diagnosis).collect();
                Err(Mistake::unknown(key.spot, "stage of a start-up", name, known.iter().map(String::as_str)))
            }
        }
    }

    fn module_diff(&self, key: &Node, name: &str, value: &Node) -> Read<(AnswerPart, AnswerMatcher)> {
        let device = self.names.device();
        let Some(submodule) = name.strip_prefix("module_diff.") else {
            let stages = ["connect", "parameter_end", "application_ready", "connection", "module_diff"];
            let records = device.records.iter().filter(|record| record.start).map(|record| record.name.as_str());
            return Err(Mistake::unknown(
                key.spot,
                "stage of a start-up",
                name,
                stages.into_iter().chain(records).collect::<Vec<_>>(),
            ));
        };
        match device.submodules.iter().position(|known| known.name == submodule) {
            Some(index) => {
                self.names.mark("submodule", submodule);
                Ok((AnswerPart::ModuleDiff(index), AnswerMatcher::Is(states(value, &MODULE_STATES)?)))
            }
            None => Err(Mistake::unknown(
                key.spot,
                "submodule",
                submodule,
                device.submodules.iter().map(|known| known.name.as_str()),
            )),
        }
    }

    /// A text, or several.
    fn texts(&self, node: &Node) -> Read<Vec<String>> {
        let one = |node: &Node| match self.literal(node, &Type::Text)? {
            Value::Text(text) if !text.trim().is_empty() => Ok(text.to_string()),
            _ => Err(node.wrong("an empty text is in every page")),
        };
        match node.sequence() {
            Some([]) => Err(node.wrong("an empty list of texts")),
            Some(items) => items.iter().map(one).collect(),
            None => Ok(vec![one(node)?]),
        }
    }

    /// What the last answer, or a part of it, has to be in an expectation.
    pub(super) fn answer_part(&self, node: &Node, part: &AnswerPart) -> Read<Matcher> {
        let service = match part {
            AnswerPart::Bytes => return self.matcher(node, &Type::Bytes, None),
            AnswerPart::Status => return self.matcher(node, &Type::whole(16, false), None),
            AnswerPart::Number => return self.matcher(node, &Type::whole(32, false), None),
            AnswerPart::Contains => return self.texts(node).map(Matcher::Contains),
            AnswerPart::Lacks => return self.texts(node).map(Matcher::Lacks),
            AnswerPart::Text => return self.matcher(node, &Type::Text, None),
            AnswerPart::Parameter(..) => Service::Parameters,
            AnswerPart::Record(_) => Service::Record,
            AnswerPart::Connect => Service::Connect,
            AnswerPart::SetPrm | AnswerPart::ChkCfg => Service::Dp,
            _ => Service::Last,
        };
        if let Some(refused) = node.get("refused") {
            return Ok(Matcher::Refused(self.refused(refused, service)?));
        }
        match ANSWERS.find(node, "answer")? {
            WholeAnswer::Accepted => Ok(Matcher::Accepted),
            WholeAnswer::Any => Ok(Matcher::Any),
            WholeAnswer::None => {
                Err(node.wrong("a last answer that was none cannot be read").help("write `accepted` or `any`"))
            }
        }
    }
}

/// One of the words, or `{ in: [...] }`, or `{ not: ... }`.
fn states(node: &Node, words: &WordChoices<&'static str>) -> Read<Matcher> {
    let one = |node: &Node| Ok(Matcher::Word(words.find(node, "state")?.to_owned()));
    match node.mapping() {
        None => one(node),
        Some([(key, value)]) => match plain(key, "a matcher")? {
            "in" => value.items("in")?.iter().map(one).collect::<Read<_>>().map(Matcher::In),
            "not" => Ok(Matcher::Not(Box::new(one(value)?))),
            other => Err(Mistake::unknown(key.spot, "matcher", other, ["in", "not"])),
        },
        Some(_) => Err(node.wrong("a matcher is one of `in` and `not`")),
    }
}

/// Whether an answer may be an acceptance.
pub(super) fn may_accept(answer: &AnswerMatcher) -> bool {
    match answer {
        AnswerMatcher::Accepted | AnswerMatcher::Any => true,
        AnswerMatcher::None | AnswerMatcher::Refused(_) => false,
        AnswerMatcher::OneOf(list) => list.iter().any(may_accept),
        AnswerMatcher::Parts(parts) => parts.iter().all(|(_, answer)| may_accept(answer)),
        AnswerMatcher::Is(_) => true,
    }
}

/// Whether a device that is dead or absent gives this answer.
pub(super) fn dead_gives(answer: &AnswerMatcher) -> bool {
    match answer {
        AnswerMatcher::None => true,
        AnswerMatcher::Accepted | AnswerMatcher::Any | AnswerMatcher::Refused(_) => false,
        AnswerMatcher::OneOf(list) => list.iter().any(dead_gives),
        AnswerMatcher::Parts(parts) => parts.iter().all(|(_, answer)| dead_gives(answer)),
        AnswerMatcher::Is(Matcher::Word(word)) => word == "none",
        AnswerMatcher::Is(_) => false,
    }
}

/// Whether only these codes can refuse: the ones that say that a parameter or element does not exist.
pub(super) fn only(codes: &[Code], words: &[&str]) -> bool {
    !codes.is_empty()
        && codes.iter().all(|code| matches!(code, Code::Parameter(_, word) if words.contains(&word.as_str())))
}
