//! The first difference between what two devices did in the same sequence.
//!
//! Both have the same steps, so that they are compared step by step: the answers, then each value that the device sends by itself, by
//! the time since the step began, and its events.

use crate::sequence_log::SequenceLog;
use engine::step_log::{LoggedChange, LoggedStep, Observed, ObservedName, StepLog};
use expression::Value;
use judge::answer::ReceivedReply;
use station::Duration;
use std::collections::BTreeMap;
use suite::model::AnswerPart;

/// Two times that are not farther apart are the same: a part of the shortest cycle.
const SAME_TIME: Duration = Duration::from_micros(250);

/// The kind of a difference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum LogDifferenceKind {
    /// A part of an answer, or a value that was read.
    Answer,
    /// A value that the device sends by itself.
    Value,
    /// An alarm, an abort or an announcement.
    Event,
    /// The time at which a value changes.
    Time,
    /// A device that is silent, answers what was not asked, or sends what cannot be read.
    Protocol,
    /// A rule of the manual that breaks.
    Rule,
}

impl LogDifferenceKind {
    /// Whether it is wrong whatever the device is, so that no reference device is needed to say so.
    pub fn is_error(self) -> bool {
        matches!(self, LogDifferenceKind::Protocol | LogDifferenceKind::Rule)
    }

    /// The word in reports.
    pub fn word(self) -> &'static str {
        match self {
            LogDifferenceKind::Answer => "answer",
            LogDifferenceKind::Value => "value",
            LogDifferenceKind::Event => "event",
            LogDifferenceKind::Time => "time",
            LogDifferenceKind::Protocol => "protocol",
            LogDifferenceKind::Rule => "rule",
        }
    }
}

/// What differs.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum DifferenceName {
    /// A part of an answer.
    Part(AnswerKey),
    /// A name that was read.
    Read(String),
    /// A value that the device sends by itself.
    Sent(ObservedName),
    /// The names of an event, without their values.
    Event(String),
    /// A protocol error by its kind.
    Protocol(&'static str),
    /// A rule by its id.
    Rule(String),
}

/// A part of an answer, in an order.
#[derive(Clone, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct AnswerKey(pub String);

/// The first difference of two logs.
#[derive(Clone, Debug, PartialEq)]
pub struct LogDifference {
    pub kind: LogDifferenceKind,
    pub name: DifferenceName,
    /// The index of the step.
    pub step: usize,
    /// The first of the steps that were compared together: of a live device, those since values were last at rest.
    pub first_step: usize,
    /// The time since the step began.
    pub after: Duration,
}

impl LogDifference {
    /// A difference of one step, which was compared alone.
    fn of_step(step: usize, kind: LogDifferenceKind, name: DifferenceName, after: Duration) -> LogDifference {
        LogDifference { kind, name, step, first_step: step, after }
    }

    /// The kind and the name, by which differences count as the same.
    pub fn target(&self) -> (LogDifferenceKind, DifferenceName) {
        (self.kind, self.name.clone())
    }

    /// Whether it comes later than another one.
    pub fn is_later(&self, than: &LogDifference) -> bool {
        (self.step, self.after) > (than.step, than.after)
    }
}

/// The first difference between the reference device and another one; `None` if they did the same.
pub fn first(reference: &SequenceLog, other: &SequenceLog) -> Option<LogDifference> {
    first_of_steps(&reference.log, &other.log).or_else(|| protocol_error_or_rule(reference, other))
}

/// The first error of the protocol, or rule that breaks, which the reference device does not have.
pub(crate) fn protocol_error_or_rule(reference: &SequenceLog, other: &SequenceLog) -> Option<LogDifference> {
    protocol_error(&reference.log, &other.log).or_else(|| {
        let is_new = |id: &String| reference.broken.iter().all(|of| of.id != *id);
        let rule = other.broken.iter().find(|of| is_new(&of.id))?;
        Some(at_end(&other.log, LogDifferenceKind::Rule, DifferenceName::Rule(rule.id.clone())))
    })
}

/// What differs after the last step.
fn at_end(log: &StepLog, kind: LogDifferenceKind, name: DifferenceName) -> LogDifference {
    LogDifference::of_step(log.steps.len().saturating_sub(1), kind, name, Duration::MAX)
}

fn first_of_steps(reference: &StepLog, other: &StepLog) -> Option<LogDifference> {
    let mut standing = Standing::default();
    for (step, (one, two)) in reference.steps.iter().zip(&other.steps).enumerate() {
        let length = one.ended.since(one.began);
        let answer =
            answers(one, two).map(|name| LogDifference::of_step(step, LogDifferenceKind::Answer, name, length));
        let change = changes(step, &one.changes, &two.changes, &mut standing);
        if let Some(found) = earlier(answer, change) {
            return Some(found);
        }
    }
    None
}

fn protocol_error(reference: &StepLog, other: &StepLog) -> Option<LogDifference> {
    let known = |errors: &StepLog, kind: &str| errors.protocol_errors.iter().any(|of| of.kind == kind);
    let new = other.protocol_errors.iter().find(|of| !known(reference, of.kind));
    let kind = new.or_else(|| reference.protocol_errors.iter().find(|of| !known(other, of.kind)))?.kind;
    Some(at_end(reference, LogDifferenceKind::Protocol, DifferenceName::Protocol(kind)))
}

/// A difference of values says more than one of time, and an answer more than a value.
fn earlier(answer: Option<LogDifference>, change: Option<LogDifference>) -> Option<LogDifference> {
    match (answer, change) {
        (Some(answer), Some(change)) if change.kind != LogDifferenceKind::Time && change.after < answer.after => {
            Some(change)
        }
        (answer, change) => answer.or(change),
    }
}

fn answers(one: &LoggedStep, two: &LoggedStep) -> Option<DifferenceName> {
    let value =
        |step: &LoggedStep, name: &String| step.reads.iter().find(|(of, _)| of == name).map(|(_, value)| value.clone());
    let names = one.reads.iter().chain(&two.reads).map(|(name, _)| name);
    if let Some(name) = names.into_iter().find(|name| value(one, name) != value(two, name)) {
        return Some(DifferenceName::Read(name.clone()));
    }
    let parts = one.answers.iter().chain(&two.answers).map(|(part, _)| part);
    let reply = |step: &LoggedStep, part: &AnswerPart| {
        step.answers.iter().find(|(of, _)| of == part).map(|(_, reply)| shown(reply))
    };
    let part = parts.into_iter().find(|part| reply(one, part) != reply(two, part));
    let part = part.map(|part| DifferenceName::Part(AnswerKey(format!("{part:?}"))));
    part.or_else(|| {
        (one.error.is_some() != two.error.is_some()).then(|| DifferenceName::Part(AnswerKey("Error".to_owned())))
    })
}

/// A reply without what depends on the time that it took.
pub fn shown(reply: &ReceivedReply) -> String {
    match reply {
        ReceivedReply::Silent(_) => "no answer".to_owned(),
        reply => format!("{reply:?}"),
    }
}

/// The last value of each name on both sides.
#[derive(Default)]
struct Standing(BTreeMap<ObservedName, [Option<u64>; 2]>);

fn changes(step: usize, one: &[LoggedChange], two: &[LoggedChange], standing: &mut Standing) -> Option<LogDifference> {
    let mut found: Option<LogDifference> = None;
    let mut add = |kind, name, after| {
        let new = LogDifference::of_step(step, kind, name, after);
        let rank = |of: &LogDifference| (of.kind == LogDifferenceKind::Time, of.after, of.name.clone());
        if found.as_ref().is_none_or(|known| rank(&new) < rank(known)) {
            found = Some(new);
        }
    };
    let values = |side: &[LoggedChange]| {
        let mut by_name: BTreeMap<ObservedName, Vec<(Duration, Option<u64>)>> = BTreeMap::new();
        for change in side {
            if let Observed::Value(name, value) = change.what {
                by_name.entry(name).or_default().push((change.after, value));
            }
        }
        by_name
    };
    let (first, second) = (values(one), values(two));
    let none = Vec::new();
    let mut names: Vec<&ObservedName> = first.keys().chain(second.keys()).collect();
    names.sort_unstable();
    names.dedup();
    for name in names {
        let (a, b) = (first.get(name).unwrap_or(&none), second.get(name).unwrap_or(&none));
        let last = standing.0.entry(*name).or_default();
        last[0] = a.last().map_or(last[0], |(_, value)| *value);
        last[1] = b.last().map_or(last[1], |(_, value)| *value);
        let pairs = a.iter().zip(b);
        let value = pairs.clone().find(|((_, a), (_, b))| a != b).map(|((after, _), (other, _))| *after.min(other));
        let more = a.len().max(b.len()) > a.len().min(b.len());
        let extra = more.then(|| a.get(b.len()).or_else(|| b.get(a.len())).map(|(after, _)| *after)).flatten();
        if let Some(after) = value.or(extra) {
            add(LogDifferenceKind::Value, DifferenceName::Sent(*name), after);
        } else if let Some(((after, _), (other, _))) = pairs.clone().find(|((a, _), (b, _))| a.abs_diff(*b) > SAME_TIME)
        {
            add(LogDifferenceKind::Time, DifferenceName::Sent(*name), *after.min(other));
        }
    }
    let (a, b) = (events(one), events(two));
    let longest = a.len().max(b.len());
    for index in 0..longest {
        let (x, y) = (a.get(index), b.get(index));
        if x.map(|(_, said)| said) != y.map(|(_, said)| said) {
            let (after, said) = x.or(y).copied().unwrap_or_default();
            add(LogDifferenceKind::Event, DifferenceName::Event(event_kind(said).to_owned()), after);
            break;
        }
    }
    found
}

/// The events of a step, each with the time since the step began.
fn events(changes: &[LoggedChange]) -> Vec<(Duration, &[(String, Value)])> {
    let mut list = Vec::new();
    for change in changes {
        if let Observed::Event(said) = &change.what {
            list.push((change.after, said.as_slice()));
        }
    }
    list
}

/// The kind of an event by the first name in it.
pub(crate) fn event_kind(said: &[(String, Value)]) -> &'static str {
    let first = said.first().and_then(|(name, _)| name.split('.').next());
    ["abort", "lldp", "hello"].into_iter().find(|kind| Some(*kind) == first).unwrap_or("alarm")
}

/// The protocol errors of a device that the reference device does not have, as sentences.
pub fn protocol_errors(reference: &StepLog, other: &StepLog) -> Vec<String> {
    let known = |kind: &str| reference.protocol_errors.iter().any(|of| of.kind == kind);
    other.protocol_errors.iter().filter(|of| !known(of.kind)).map(|of| of.what.clone()).collect()
}
