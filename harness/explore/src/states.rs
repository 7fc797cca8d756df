//! Which states of the reference device the sequences reach, and which pairs of transitions.
//!
//! A state is what a controller can tell: the connection, the bits and words of the inputs without measured values, a pending
//! diagnosis, and whether the last request was refused.

use crate::step::SequenceStep;
use compare::action::ControllerAction;
use engine::step_log::{Observed, ObservedName, StepLog};
use judge::answer::ReceivedReply;
use std::collections::{BTreeMap, BTreeSet};
use std::hash::{DefaultHasher, Hash, Hasher};
use suite::device::{DeviceDescription, SignalSender};

/// The states and transitions that were reached.
#[derive(Debug, Default)]
pub struct StateCoverage {
    states: BTreeSet<u64>,
    pairs: BTreeSet<[u64; 3]>,
    /// The values of each bit or word of the inputs that were seen.
    seen: BTreeMap<(usize, usize), BTreeSet<u64>>,
    /// The kinds of steps, each with how often it was accepted and refused.
    verbs: BTreeMap<String, [u64; 2]>,
}

/// What was never reached, by name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NeverReached {
    /// The name with the value.
    pub name: String,
    pub why: String,
}

impl StateCoverage {
    /// Takes in a sequence on the reference device; returns how many pairs of transitions are new.
    pub fn take(&mut self, device: &DeviceDescription, steps: &[SequenceStep], log: &StepLog) -> usize {
        let mut standing: BTreeMap<ObservedName, Option<u64>> = BTreeMap::new();
        let (mut state, mut last, mut new) = (0_u64, 0_u64, 0);
        for (step, logged) in steps.iter().zip(&log.steps) {
            for change in &logged.changes {
                if let Observed::Value(name, value) = change.what {
                    standing.insert(name, value);
                }
            }
            let refused = logged.answers.iter().any(|(_, reply)| matches!(reply, ReceivedReply::Refused(_)));
            let entry = self.verbs.entry(verb(&step.action)).or_default();
            entry[usize::from(refused)] += 1;
            let mut hasher = DefaultHasher::new();
            refused.hash(&mut hasher);
            for (name, value) in &standing {
                match (name, value) {
                    (ObservedName::Signal(signal), Some(value)) => {
                        self.signal(device, *signal, *value).hash(&mut hasher)
                    }
                    (ObservedName::Led(_) | ObservedName::InputLength, _) => {}
                    (name, value) => (name, value).hash(&mut hasher),
                }
            }
            let next = hasher.finish();
            let mut hasher = DefaultHasher::new();
            verb(&step.action).hash(&mut hasher);
            let way = hasher.finish();
            self.states.insert(next);
            new += usize::from(self.pairs.insert([last, state ^ way.rotate_left(7), next]));
            (last, state) = (state, next);
        }
        new
    }

    /// The bits and words of a signal that are no measured value.
    fn signal(&mut self, device: &DeviceDescription, index: usize, value: u64) -> Vec<u64> {
        let Some(signal) = device.signals.get(index) else { return Vec::new() };
        let fields = signal.fields.iter().enumerate().filter(|(_, field)| field.counts.is_none() && field.width <= 8);
        let mut values = Vec::new();
        for (number, field) in fields {
            let part = (value >> field.low) & ((1 << field.width) - 1);
            self.seen.entry((index, number)).or_default().insert(part);
            values.push(part);
        }
        values
    }

    /// How many states were reached.
    pub fn states(&self) -> usize {
        self.states.len()
    }

    /// How many pairs of transitions were taken.
    pub fn pairs(&self) -> usize {
        self.pairs.len()
    }

    /// How many values of the bits and words of the inputs were reached, of how many.
    pub fn values(&self, device: &DeviceDescription) -> (usize, usize) {
        let all: usize = named(device).map(|(.., values)| values.len()).sum();
        (all - self.never(device).len(), all)
    }

    /// The values of the inputs that no sequence reached.
    pub fn never(&self, device: &DeviceDescription) -> Vec<NeverReached> {
        let none = BTreeSet::new();
        let mut list = Vec::new();
        for (signal, field, name, values) in named(device) {
            let seen = self.seen.get(&(signal, field)).unwrap_or(&none);
            let why = if seen.is_empty() {
                "no connection had a module with this signal"
            } else {
                "no step brought the reference device there"
            };
            let missing = values.into_iter().filter(|(number, _)| !seen.contains(number));
            list.extend(missing.map(|(_, word)| NeverReached { name: format!("{name}: {word}"), why: why.to_owned() }));
        }
        list
    }

    /// The kinds of steps, each with how often it was accepted and refused.
    pub fn verbs(&self) -> impl Iterator<Item = (&str, [u64; 2])> {
        self.verbs.iter().map(|(verb, counts)| (verb.as_str(), *counts))
    }
}

/// The bits and words of the inputs: signal, field, name, and the values that it can have with their words.
fn named(device: &DeviceDescription) -> impl Iterator<Item = (usize, usize, String, Vec<(u64, String)>)> {
    let signals = device.signals.iter().enumerate().filter(|(_, signal)| signal.from == SignalSender::Device);
    signals.flat_map(|(index, signal)| {
        let fields = signal.fields.iter().enumerate().filter(|(_, field)| field.counts.is_none());
        fields.filter_map(move |(number, field)| {
            let words =
                field.words.iter().filter_map(|(word, number)| Some((u64::try_from(*number).ok()?, word.clone())));
            let values: Vec<(u64, String)> = match field.width {
                1 if field.words.is_empty() => vec![(0, "0".to_owned()), (1, "1".to_owned())],
                _ => words.collect(),
            };
            let name = format!("{}.{}", signal.name, field.name);
            (!values.is_empty()).then_some((index, number, name, values))
        })
    })
}

fn verb(action: &ControllerAction) -> String {
    match action {
        ControllerAction::Connect(_) => "connect".to_owned(),
        ControllerAction::Disconnect => "disconnect".to_owned(),
        ControllerAction::Set(entries) => {
            let names: Vec<&str> = entries.iter().map(|(name, _)| name.as_str()).collect();
            format!("set {}", names.join(" "))
        }
        ControllerAction::Read(_) => "read".to_owned(),
        ControllerAction::Write(_) => "write".to_owned(),
        ControllerAction::Send { service, .. } => format!("send {service}"),
        ControllerAction::Turn { .. } => "turn".to_owned(),
        ControllerAction::Wait(_) => "wait".to_owned(),
    }
}
