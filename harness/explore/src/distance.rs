//! How far what two devices did in the same sequence is apart, as a number: the fewer and the smaller the differences, the smaller.

use crate::difference::shown;
use engine::step_log::{LoggedStep, Observed, ObservedName, StepLog};
use station::Duration;
use std::collections::BTreeMap;
use suite::device::{DeviceDescription, DeviceSignal, SignalField};

/// For each signal the bits that count from the start of the device, which say nothing here.
pub(crate) type Counters = Vec<u64>;

/// The weight of an answer or an event that only one side has.
const ANSWER: f64 = 100.0;
/// The weight of a value that only one side has.
const VALUE: f64 = 10.0;

pub(crate) fn counters(device: &DeviceDescription) -> Counters {
    let of = |signal: &DeviceSignal| {
        signal.fields.iter().filter(|field| field.counts.is_some()).map(SignalField::mask).sum()
    };
    device.signals.iter().map(of).collect()
}

pub(crate) fn distance(one: &StepLog, other: &StepLog, counters: &Counters) -> f64 {
    let steps: f64 = one.steps.iter().zip(&other.steps).map(|(one, other)| of_step(one, other, counters)).sum();
    let errors = one.protocol_errors.len().abs_diff(other.protocol_errors.len());
    steps + ANSWER * errors as f64
}

fn of_step(one: &LoggedStep, other: &LoggedStep, counters: &Counters) -> f64 {
    let mut sum = apart(one.ended.since(one.began), other.ended.since(other.began));
    let answers = |step: &LoggedStep| -> Vec<String> {
        let replies = step.answers.iter().map(|(part, reply)| format!("{part:?} {}", shown(reply)));
        replies.chain(step.reads.iter().map(|(name, value)| format!("{name} {value:?}"))).collect()
    };
    let (a, b) = (answers(one), answers(other));
    sum += ANSWER * a.iter().filter(|of| !b.contains(of)).chain(b.iter().filter(|of| !a.contains(of))).count() as f64;
    // Of two texts that differ the one with more equal letters is closer.
    let texts = a.iter().zip(&b).filter(|(a, b)| a != b);
    sum += texts
        .map(|(a, b)| {
            a.bytes().zip(b.bytes()).filter(|(a, b)| a != b).count() as f64 + a.len().abs_diff(b.len()) as f64
        })
        .sum::<f64>();
    let (a, b) = (changes(one, counters), changes(other, counters));
    let none = Vec::new();
    for name in a.keys().chain(b.keys().filter(|name| !a.contains_key(*name))) {
        let (a, b) = (a.get(name).unwrap_or(&none), b.get(name).unwrap_or(&none));
        for ((after, value), (other, second)) in a.iter().zip(b) {
            sum += if value == second { apart(*after, *other) } else { VALUE };
        }
        sum += VALUE * a.len().abs_diff(b.len()) as f64;
    }
    sum
}

/// The changes by name, events under their own.
fn changes(step: &LoggedStep, counters: &Counters) -> BTreeMap<Option<ObservedName>, Vec<(Duration, String)>> {
    let mut by_name: BTreeMap<Option<ObservedName>, Vec<(Duration, String)>> = BTreeMap::new();
    for change in &step.changes {
        let (name, text) = match &change.what {
            Observed::Value(name, value) => {
                let mask = match name {
                    ObservedName::Signal(index) => counters.get(*index).copied().unwrap_or_default(),
                    _ => 0,
                };
                (Some(*name), format!("{:?}", value.map(|value| value & !mask)))
            }
            Observed::Event(said) => (None, format!("{said:?}")),
        };
        let list = by_name.entry(name).or_default();
        if name.is_none() || list.last().is_none_or(|(_, last)| *last != text) {
            list.push((change.after, text));
        }
    }
    by_name
}

/// Two times that are twice as far apart are a little farther.
fn apart(one: Duration, other: Duration) -> f64 {
    (one.abs_diff(other).as_micros() as f64 + 1.0).ln()
}
