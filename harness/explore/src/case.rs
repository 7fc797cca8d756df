//! A difference as a case: the steps of the shortest sequence with the answers of the reference device as the right ones, and one check
//! of what differs.
//!
//! A check can be written in several forms; the first that passes on the reference device and fails on the other one is taken.

use crate::difference::{DifferenceName, LogDifference, LogDifferenceKind};
use crate::literal;
use crate::step::SequenceStep;
use compare::action::{ControllerAction, mapping, span};
use compare::write_case::CaseLine;
use engine::step_log::{LoggedStep, Observed, ObservedName, StepLog};
use expression::Value;
use judge::answer::ReceivedReply;
use std::time::Duration;
use suite::device::DeviceDescription;
use suite::model::AnswerPart;
use suite::words;

/// How long a value is checked, in the order tried.
const HOLDS: [Duration; 3] = [Duration::from_millis(40), Duration::from_millis(8), Duration::from_millis(200)];

/// What a case is made of.
pub struct CaseParts<'a> {
    pub device: &'a DeviceDescription,
    pub variant: usize,
    pub steps: &'a [SequenceStep],
    /// What the reference device did, and the other one.
    pub reference: &'a StepLog,
    pub other: &'a StepLog,
    pub difference: &'a LogDifference,
    /// What the reference device does after the last step.
    pub after: Option<&'a LoggedStep>,
}

impl CaseParts<'_> {
    /// The forms of the case, each as its steps.
    pub fn forms(&self) -> Vec<Vec<CaseLine>> {
        let place = self.difference.step.min(self.steps.len().saturating_sub(1));
        let mut before: Vec<CaseLine> = Vec::new();
        for index in 0..place {
            before.extend(self.unchecked(index));
        }
        let Some(step) = self.steps.get(place) else { return Vec::new() };
        let (one, two) = (self.reference.steps.get(place), self.other.steps.get(place));
        let (Some(one), Some(two)) = (one, two) else { return Vec::new() };
        let own = self.unchecked(place);
        let mut forms: Vec<Vec<CaseLine>> = Vec::new();
        match (&self.difference.kind, &self.difference.name) {
            (LogDifferenceKind::Answer, DifferenceName::Read(name)) => forms.extend(self.read(step, one, name)),
            (LogDifferenceKind::Answer, _) => forms.extend(self.answered(step, one)),
            (_, DifferenceName::Sent(name)) => forms.extend(self.sent(*name, one, two, &own)),
            (LogDifferenceKind::Event, _) => forms.extend(self.event(one, &own)),
            _ => {}
        }
        // What the reference device sends later is expected as well, or the case would fail on it.
        let later: Vec<CaseLine> = self.after.map(|log| self.events(log)).unwrap_or_default();
        let alarms = later.into_iter().filter(|line| line.verb.contains("alarm")).collect::<Vec<_>>();
        let whole = |form: Vec<CaseLine>| before.iter().cloned().chain(form).chain(alarms.iter().cloned()).collect();
        forms.into_iter().map(whole).collect()
    }

    /// A step that is not checked: whatever the reference device answers is right, and its events are expected.
    fn unchecked(&self, index: usize) -> Vec<CaseLine> {
        let (Some(step), Some(log)) = (self.steps.get(index), self.reference.steps.get(index)) else {
            return Vec::new();
        };
        let mut lines = vec![self.plain(step, log)];
        lines.extend(self.events(log));
        lines
    }

    fn plain(&self, step: &SequenceStep, log: &LoggedStep) -> CaseLine {
        let mut line = step.line(&|_| false);
        let whole = reply(log, &AnswerPart::Whole);
        match &step.action {
            ControllerAction::Connect(_) => {
                let connected =
                    matches!(reply(log, &AnswerPart::Connection), Some(ReceivedReply::Value(value)) if is_data(value));
                line = line.with(format!("answer: {{ connection: {} }}", if connected { "data" } else { "none" }));
            }
            ControllerAction::Read(names) => line.verb = format!("read: {}", mapping(&self.expected(names, log, None))),
            ControllerAction::Write(_) | ControllerAction::Send { answered: true, .. } => match whole {
                Some(ReceivedReply::Accepted) | None if log.answers.iter().all(|(_, of)| is_accepted(of)) => {}
                Some(ReceivedReply::Silent(_)) => line = line.with("answer: none"),
                _ => line = line.with("answer: any"),
            },
            _ => {}
        }
        line
    }

    /// The alarms and the end of a connection on the reference device, which no other step may expect.
    fn events(&self, log: &LoggedStep) -> Vec<CaseLine> {
        let mut lines = Vec::new();
        for change in &log.changes {
            if let Observed::Event(said) = &change.what
                && let Some(condition) = self.event_condition(said)
                && condition.contains("alarm")
            {
                lines.push(CaseLine::new(format!("expect: {condition}")).with("within: 1s"));
            }
        }
        let connections: Vec<bool> = log
            .changes
            .iter()
            .filter_map(|change| match change.what {
                Observed::Value(ObservedName::Connection, value) => Some(value == Some(1)),
                _ => None,
            })
            .collect();
        // The first value of all is `none`.
        let began = self.reference.steps.first().is_some_and(|first| std::ptr::eq(first, log));
        if connections.last() == Some(&false) && !(began && connections.len() == 1) {
            lines.push(CaseLine::new("expect: { connection: none }").with("within: 2s"));
        }
        lines
    }

    fn event_condition(&self, said: &[(String, Value)]) -> Option<String> {
        let errors =
            self.device.codes.iter().find(|(table, _)| table == "channel_error").map(|(_, words)| words.as_slice());
        let entry = |(name, value): &(String, Value)| {
            let table: Vec<(String, i128)> = match name.as_str() {
                "alarm.error" => errors
                    .unwrap_or_default()
                    .iter()
                    .map(|(word, number)| (word.clone(), i128::from(*number)))
                    .collect(),
                "alarm.change" => builtin(words::ALARM_CHANGE, value),
                "alarm.severity" => builtin(words::ALARM_SEVERITY, value),
                "alarm.slot" | "alarm.subslot" | "lldp.name" | "lldp.port" | "lldp.ttl" => Vec::new(),
                _ => return None,
            };
            Some((name.clone(), literal::of_value(value, &table)?))
        };
        let entries: Vec<(String, String)> = said.iter().filter_map(entry).collect();
        (!entries.is_empty()).then(|| mapping(&entries))
    }

    /// What a read has to find: the value of `checked`, and of the others anything, or their refusal.
    fn expected(&self, names: &[String], log: &LoggedStep, checked: Option<&str>) -> Vec<(String, String)> {
        let refused = |part: &AnswerPart| match reply(log, part) {
            Some(ReceivedReply::Refused(_)) => Some("{ refused: any }".to_owned()),
            _ => None,
        };
        let whole = refused(&AnswerPart::Whole);
        names
            .iter()
            .map(|name| {
                let of_part = self.part_of(name).and_then(|part| refused(&part));
                let value = log.reads.iter().find(|(known, _)| known == name).map(|(_, value)| value);
                let value = value.filter(|_| checked == Some(name.as_str()));
                let exact = value.and_then(|value| literal::of_value(value, &self.words_of(name)));
                (name.clone(), exact.or(of_part).or_else(|| whole.clone()).unwrap_or_else(|| "any".to_owned()))
            })
            .collect()
    }

    fn part_of(&self, name: &str) -> Option<AnswerPart> {
        let (number, element) =
            name.strip_prefix('P')?.split_once('.').map_or((name.strip_prefix('P')?, None), |(n, e)| (n, Some(e)));
        let number: u16 = number.parse().ok()?;
        let of = self.device.parameters.iter().find(|of| of.number == number)?;
        let subindex =
            element.and_then(|element| of.elements.iter().find(|(known, _)| known == element)).map_or(0, |(_, at)| *at);
        Some(AnswerPart::Parameter(number, subindex))
    }

    /// The words of a field of a record.
    fn words_of(&self, name: &str) -> Vec<(String, i128)> {
        let field = name.split_once('.').and_then(|(record, field)| {
            let record = self.device.records.iter().find(|of| of.name == record)?;
            record.fields.iter().find(|of| of.name == field)
        });
        field.map_or_else(Vec::new, |field| field.words.clone())
    }

    fn read(&self, step: &SequenceStep, log: &LoggedStep, name: &str) -> Vec<Vec<CaseLine>> {
        let ControllerAction::Read(names) = &step.action else { return Vec::new() };
        let mut line = self.plain(step, log);
        line.verb = format!("read: {}", mapping(&self.expected(names, log, Some(name))));
        vec![vec![line]]
    }

    /// A request whose answer differs: as a whole, by its parts, and as bytes.
    fn answered(&self, step: &SequenceStep, log: &LoggedStep) -> Vec<Vec<CaseLine>> {
        let base = step.line(&|_| false);
        let base =
            CaseLine { modifiers: base.modifiers.into_iter().filter(|of| !of.starts_with("answer")).collect(), ..base };
        let mut answers: Vec<String> = Vec::new();
        let DifferenceName::Part(key) = &self.difference.name else { return Vec::new() };
        let differs = log.answers.iter().find(|(part, _)| format!("{part:?}") == key.0);
        let exact = |part: &AnswerPart| reply(log, part).and_then(|reply| literal::of_reply(self.device, reply));
        if let ControllerAction::Read(names) = &step.action {
            let exact_refusal = |name: &String| {
                let own = self.part_of(name).and_then(|part| exact(&part)).or_else(|| exact(&AnswerPart::Whole));
                let value = own.filter(|text| text.starts_with("{ refused")).or_else(|| {
                    let value = log.reads.iter().find(|(known, _)| known == name).map(|(_, value)| value)?;
                    literal::of_value(value, &self.words_of(name))
                });
                (name.clone(), value.unwrap_or_else(|| "any".to_owned()))
            };
            let entries: Vec<(String, String)> = names.iter().map(exact_refusal).collect();
            let mut forms = vec![vec![CaseLine { verb: format!("read: {}", mapping(&entries)), ..base.clone() }]];
            if let Some(bytes) = exact(&AnswerPart::Bytes) {
                let check = CaseLine::new(format!("expect: {{ answer.bytes: {bytes} }}"));
                forms.push(vec![self.plain(step, log), check]);
            }
            return forms;
        }
        let part = |name: &str, text: String| format!("{{ {name}: {text} }}");
        let name_of = |part: &AnswerPart| literal::part_name(self.device, part);
        if let Some((of, reply)) = differs {
            let right = match (of, reply) {
                (AnswerPart::Connection, ReceivedReply::Value(value)) => {
                    Some(if is_data(value) { "data" } else { "none" }.to_owned())
                }
                (AnswerPart::ModuleDiff(_), ReceivedReply::Value(Value::Text(text))) => Some(text.to_string()),
                _ => literal::of_reply(self.device, reply),
            };
            answers.extend(right.clone().zip(name_of(of)).map(|(text, name)| part(&name, text)));
            answers.extend(right.filter(|_| *of == AnswerPart::Whole));
        }
        answers.extend(exact(&AnswerPart::Whole));
        answers.extend(exact(&AnswerPart::Bytes).map(|text| part("bytes", text)));
        if log.answers.is_empty() {
            answers.push("none".to_owned());
        }
        if let Some(connected) = reply(log, &AnswerPart::Connection) {
            let word = matches!(connected, ReceivedReply::Value(value) if is_data(value));
            answers.push(part("connection", if word { "data" } else { "none" }.to_owned()));
        }
        answers.push("accepted".to_owned());
        answers.dedup();
        let mut forms: Vec<Vec<CaseLine>> =
            answers.into_iter().map(|answer| vec![base.clone().with(format!("answer: {answer}"))]).collect();
        forms.push(vec![base]);
        forms
    }

    /// A value that the device sends: as it stands after the step, and in the order of its values during it.
    fn sent(&self, name: ObservedName, one: &LoggedStep, two: &LoggedStep, own: &[CaseLine]) -> Vec<Vec<CaseLine>> {
        let last = |log: &StepLog, step: &LoggedStep| {
            let of = |step: &LoggedStep| {
                step.changes.iter().rev().find_map(|change| match change.what {
                    Observed::Value(known, value) if known == name => Some(value),
                    _ => None,
                })
            };
            let before = || log.steps.iter().take(self.difference.step).rev().find_map(of).flatten();
            of(step).unwrap_or_else(before)
        };
        let mut forms = Vec::new();
        let (right, wrong) = (last(self.reference, one), last(self.other, two));
        let checked = |after: Duration| -> Vec<Vec<CaseLine>> {
            let named = literal::of_sent(self.device, self.variant, name, right, wrong);
            let Some((path, text)) = named else { return Vec::new() };
            let condition = format!("expect: {{ {path}: {text} }}");
            let mut list: Vec<Vec<CaseLine>> = HOLDS
                .iter()
                .map(|hold| {
                    let line = CaseLine::new(&condition);
                    let line = if after.is_zero() {
                        line.with("within: 0")
                    } else {
                        line.with(format!("within: {}", span(after)))
                    };
                    own.iter().cloned().chain([line.with(format!("for: {}", span(*hold)))]).collect()
                })
                .collect();
            list.push(
                own.iter()
                    .cloned()
                    .chain([CaseLine::new(&condition).with(format!("within: {}", span(after)))])
                    .collect(),
            );
            list
        };
        if right != wrong {
            forms.extend(checked(Duration::ZERO));
            forms.extend(checked(Duration::from_millis(20)));
            forms.extend(checked(Duration::from_millis(200)));
        }
        forms.extend(self.in_order(name, own));
        forms
    }

    /// The values of a name during the step, in order.
    fn in_order(&self, name: ObservedName, own: &[CaseLine]) -> Option<Vec<CaseLine>> {
        let values = |log: &StepLog| -> Vec<Option<u64>> {
            let of = |step: &LoggedStep| -> Vec<Option<u64>> {
                let values = step.changes.iter().filter_map(|change| match change.what {
                    Observed::Value(known, value) if known == name => Some(value),
                    _ => None,
                });
                values.collect()
            };
            let before = log.steps.iter().take(self.difference.step).flat_map(of).last().flatten();
            let own = log.steps.get(self.difference.step).map(of).unwrap_or_default();
            std::iter::once(before).chain(own).collect()
        };
        let (right, wrong) = (values(self.reference), values(self.other));
        let differ = right.iter().zip(&wrong).find(|(a, b)| a != b).map(|(a, b)| (*a, *b));
        let (a, b) = differ.or_else(|| {
            let more = if right.len() > wrong.len() { &right } else { &wrong };
            let at = right.len().min(wrong.len());
            Some((*more.get(at)?, *more.get(at.checked_sub(1)?)?))
        })?;
        let (path, _) = literal::of_sent(self.device, self.variant, name, a.or(b), b.or(a))?;
        let mut listed: Vec<String> = Vec::new();
        for value in &right {
            let (_, text) = literal::of_sent(self.device, self.variant, name, *value, Some((*value)? ^ (a? ^ b?)))?;
            if listed.last() != Some(&text) {
                listed.push(text);
            }
        }
        let listed: Vec<String> = listed.into_iter().map(|text| format!("[{text}]")).collect();
        let mut inner = String::new();
        for line in own {
            inner.push_str(&format!("\n          - {}", line.verb));
            for modifier in &line.modifiers {
                inner.push_str(&format!("\n            {modifier}"));
            }
        }
        let block = CaseLine::new(format!("steps:{inner}"));
        if let [only] = listed.as_slice() {
            let value = only.trim_matches(['[', ']']);
            return Some(vec![block.with(format!("observe:\n          - always: {path} == {value}"))]);
        }
        Some(vec![
            block.with(format!("observe:\n          - sequence: [{path}]\n            is: [{}]", listed.join(", "))),
        ])
    }

    fn event(&self, one: &LoggedStep, own: &[CaseLine]) -> Vec<Vec<CaseLine>> {
        let said = one.changes.iter().filter_map(|change| match &change.what {
            Observed::Event(said) => Some(said),
            Observed::Value(..) => None,
        });
        let mut forms: Vec<Vec<CaseLine>> = Vec::new();
        let mut all: Vec<CaseLine> = own.iter().take(1).cloned().collect();
        for said in said {
            if let Some(condition) = self.event_condition(said) {
                all.push(CaseLine::new(format!("expect: {condition}")).with("within: 1s"));
            }
        }
        forms.push(all);
        // An event that the reference device does not have fails the case by itself.
        let quiet = CaseLine::new("expect: { connection: data }").with("for: 200ms");
        forms.push(own.iter().cloned().chain([quiet]).collect());
        forms
    }
}

fn builtin(table: words::WordList, value: &Value) -> Vec<(String, i128)> {
    let Value::Word(number) = value else { return Vec::new() };
    words::word(table, *number).map(|word| (word.to_owned(), i128::from(*number))).into_iter().collect()
}

fn reply<'l>(log: &'l LoggedStep, part: &AnswerPart) -> Option<&'l ReceivedReply> {
    log.answers.iter().find(|(known, _)| known == part).map(|(_, reply)| reply)
}

fn is_accepted(reply: &ReceivedReply) -> bool {
    matches!(reply, ReceivedReply::Accepted | ReceivedReply::Value(_))
}

fn is_data(value: &Value) -> bool {
    matches!(value, Value::Text(text) if &**text == "data") || matches!(value, Value::Word(1))
}
