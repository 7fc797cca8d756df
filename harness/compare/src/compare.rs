//! Compares two conversations: the first difference, then all of them.
//!
//! They are aligned by the actions of the controller and not frame by frame, since each device has its own timing. A name differs
//! only if the other side does not have its value within the tolerance before or after. This module must not know how the
//! conversations were made.

use super::action::ControllerAction;
use super::conversation::{AnsweredAction, Conversation, DeviceEvent, SuiteValue, TrackChange, ValueTrack};
use super::masks::Masks;
use station::{Duration, Time};
use std::collections::BTreeSet;

/// Upper limit of the reported differences.
pub const MOST: usize = 500;
/// How many steps ahead the same step is searched for, if one side left some out.
const AHEAD: usize = 12;
/// How many tolerances an alarm may be earlier or later.
const ALARM_TOLERANCES: u32 = 10;

/// The kind of a difference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum DifferenceKind {
    /// A part of an answer.
    Answer,
    /// The value of an input.
    Input,
    /// An alarm or an abort.
    Event,
    /// A step that only one side took or answered.
    Step,
}

/// A difference between two conversations.
#[derive(Clone, Debug)]
pub struct Difference {
    pub kind: DifferenceKind,
    /// The name.
    pub name: String,
    /// The time on the first side.
    pub at: Time,
    /// The frame on the first side.
    pub frame: u64,
    /// The last step before it, on the first side.
    pub step: Option<usize>,
    /// The value on the first side; `None` for nothing.
    pub first: Option<SuiteValue>,
    /// The value on the second side; `None` for nothing.
    pub second: Option<SuiteValue>,
    /// Time and frame on the second side.
    pub there: (Time, u64),
}

/// Maps instants of one side to those of the other.
#[derive(Debug)]
pub(super) struct ConversationClock(Vec<(Time, Time)>);

impl ConversationClock {
    fn of(pairs: impl Iterator<Item = (Time, Time)>) -> ConversationClock {
        let mut anchors: Vec<(Time, Time)> = Vec::new();
        for anchor in pairs {
            if anchors.last().is_none_or(|last| last.0 <= anchor.0 && last.1 <= anchor.1) {
                anchors.push(anchor);
            }
        }
        ConversationClock(anchors)
    }

    /// The mapping from the first conversation to the second.
    pub fn between(first: &Conversation, second: &Conversation) -> ConversationClock {
        let (pairs, _) = pair(&first.actions, &second.actions);
        let both = pairs.iter().filter_map(|&(i, j)| Some((first.actions.get(i)?, second.actions.get(j)?)));
        ConversationClock::of(both.flat_map(|(a, b)| [(a.at, b.at), (a.done, b.done)]))
    }

    /// The instant on the other side; `None` before the first step that both took.
    pub fn there(&self, time: Time) -> Option<Time> {
        let after = self.0.partition_point(|(here, _)| *here <= time);
        let (here, there) = *self.0.get(after.checked_sub(1)?)?;
        let on = there + time.since(here);
        // Extra time that only one side took ends with the next step.
        Some(self.0.get(after).map_or(on, |(_, next)| on.min(*next)))
    }
}

/// The differences between two conversations, in the order of the first side, at most [`MOST`].
pub fn compare(first: &Conversation, second: &Conversation, masks: &Masks) -> Vec<Difference> {
    firsts(every(first, second, masks))
}

/// Keeps the first difference of each name in each step, at most [`MOST`].
pub fn firsts(mut found: Vec<Difference>) -> Vec<Difference> {
    let mut reported = BTreeSet::new();
    found.retain(|difference| reported.insert((difference.step, difference.kind, difference.name.clone())));
    found.truncate(MOST);
    found
}

/// All differences between two conversations, in the order of the first side.
pub fn every(first: &Conversation, second: &Conversation, masks: &Masks) -> Vec<Difference> {
    let cycle = first.cycle.or(second.cycle).unwrap_or_default();
    let tolerance = masks.tolerance(cycle);
    let (pairs, alone) = pair(&first.actions, &second.actions);
    let anchors = || {
        pairs.iter().flat_map(|&(i, j)| {
            let (a, b) = (&first.actions[i], &second.actions[j]);
            [(a.at, b.at), (a.done, b.done)]
        })
    };
    let there = ConversationClock::of(anchors());
    let here = ConversationClock::of(anchors().map(|(a, b)| (b, a)));
    let mut found = Vec::new();
    for &(i, j) in &pairs {
        answers(i, &first.actions[i], &second.actions[j], masks, &mut found);
    }
    for side in alone {
        found.extend(only_one(side, first, second, &there, &here));
    }
    let names: BTreeSet<&String> = first.tracks.keys().chain(second.tracks.keys()).collect();
    let none = ValueTrack::default();
    for name in names.into_iter().filter(|name| !masks.hides(name)) {
        let (one, other) = (first.tracks.get(name).unwrap_or(&none), second.tracks.get(name).unwrap_or(&none));
        let ends = (first.end, second.end);
        let tolerance = tolerance + masks.period(name);
        track(name, one, other, &there, ends, tolerance, (masks, true), &mut |change, seen, time| {
            found.push(difference(
                DifferenceKind::Input,
                name,
                change,
                change.value.clone(),
                seen.value.clone(),
                (time, seen.frame),
            ));
        });
        track(name, other, one, &here, (ends.1, ends.0), tolerance, (masks, false), &mut |change, seen, time| {
            let at = TrackChange { at: time, ..seen.clone() };
            let there = (change.at, change.frame);
            found.push(difference(DifferenceKind::Input, name, &at, seen.value.clone(), change.value.clone(), there));
        });
    }
    events(first, second, &there, &here, tolerance * ALARM_TOLERANCES, masks, &mut found);
    found.sort_by_key(|difference| (difference.at, difference.kind));
    for difference in &mut found {
        if difference.step.is_none() {
            let before = first.actions.iter().rposition(|asked| asked.at <= difference.at);
            difference.step = before;
        }
    }
    found
}

fn difference(
    kind: DifferenceKind,
    name: &str,
    change: &TrackChange,
    first: Option<SuiteValue>,
    second: Option<SuiteValue>,
    there: (Time, u64),
) -> Difference {
    let (at, frame) = (change.at, change.frame);
    Difference { kind, name: name.to_owned(), at, frame, step: None, first, second, there }
}

/// A step that only one side has.
pub(super) enum UnpairedAction {
    First(usize),
    Second(usize),
}

/// The steps that both sides have, and those that only one has.
pub(super) fn pair(first: &[AnsweredAction], second: &[AnsweredAction]) -> (Vec<(usize, usize)>, Vec<UnpairedAction>) {
    let (mut pairs, mut alone) = (Vec::new(), Vec::new());
    let (mut i, mut j) = (0, 0);
    while i < first.len() || j < second.len() {
        let (Some(one), Some(other)) = (first.get(i), second.get(j)) else {
            alone.extend((i..first.len()).map(UnpairedAction::First));
            alone.extend((j..second.len()).map(UnpairedAction::Second));
            break;
        };
        if one.ask == other.ask {
            pairs.push((i, j));
            (i, j) = (i + 1, j + 1);
            continue;
        }
        let ahead = |asked: &[AnsweredAction], from: usize, ask: &ControllerAction| {
            asked.iter().skip(from).take(AHEAD).position(|of| of.ask == *ask)
        };
        match (ahead(second, j, &one.ask), ahead(first, i, &other.ask)) {
            (Some(skip), back) if back.is_none_or(|back| skip <= back) => {
                alone.extend((j..j + skip).map(UnpairedAction::Second));
                j += skip;
            }
            (_, Some(skip)) => {
                alone.extend((i..i + skip).map(UnpairedAction::First));
                i += skip;
            }
            _ => {
                alone.extend([UnpairedAction::First(i), UnpairedAction::Second(j)]);
                (i, j) = (i + 1, j + 1);
            }
        }
    }
    (pairs, alone)
}

fn only_one(
    side: UnpairedAction,
    first: &Conversation,
    second: &Conversation,
    there: &ConversationClock,
    here: &ConversationClock,
) -> Option<Difference> {
    let (asked, is_first) = match side {
        UnpairedAction::First(place) => (first.actions.get(place)?, true),
        UnpairedAction::Second(place) => (second.actions.get(place)?, false),
    };
    if !asked.ask.is_answered() {
        return None;
    }
    let other = if is_first { there } else { here }.there(asked.at).unwrap_or_default();
    let answer = asked.answer.first().map_or_else(|| SuiteValue::word("answered"), |(_, value)| value.clone());
    let frame = asked.answer.first().map_or(asked.frame, |(name, _)| asked.frame_of(name));
    let (at, frame, beyond) = if is_first { (asked.at, frame, (other, 0)) } else { (other, 0, (asked.at, frame)) };
    let (one, two) = if is_first { (Some(answer), None) } else { (None, Some(answer)) };
    let step = match side {
        UnpairedAction::First(place) => Some(place),
        UnpairedAction::Second(_) => None,
    };
    Some(Difference {
        kind: DifferenceKind::Step,
        name: asked.ask.yaml(),
        at,
        frame,
        step,
        first: one,
        second: two,
        there: beyond,
    })
}

fn answers(step: usize, one: &AnsweredAction, other: &AnsweredAction, masks: &Masks, found: &mut Vec<Difference>) {
    let value = |asked: &AnsweredAction, name: &str| {
        asked.answer.iter().find(|(known, _)| known == name).map(|(_, value)| value.clone())
    };
    let mut names: Vec<&String> = Vec::new();
    for (name, _) in one.answer.iter().chain(&other.answer) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let before = found.len();
    let mut hidden = false;
    for name in names {
        let (first, second) = (value(one, name), value(other, name));
        // The bytes add nothing to a difference in a name, and contain hidden names.
        if first == second || (name == "bytes" && (found.len() > before || hidden)) {
            continue;
        }
        if masks.hides(name) {
            hidden = true;
            continue;
        }
        found.push(Difference {
            kind: DifferenceKind::Answer,
            name: name.clone(),
            at: one.done,
            frame: one.frame_of(name),
            step: Some(step),
            first,
            second,
            there: (other.done, other.frame_of(name)),
        });
    }
}

/// Reports each change of `one` whose value the other does not have within the tolerance, with the value that it has.
#[allow(clippy::too_many_arguments, reason = "both sides with their clocks")]
fn track(
    name: &str,
    one: &ValueTrack,
    other: &ValueTrack,
    clock: &ConversationClock,
    ends: (Time, Time),
    tolerance: Duration,
    (masks, is_first): (&Masks, bool),
    report: &mut dyn FnMut(&TrackChange, &TrackChange, Time),
) {
    for (place, change) in one.changes.iter().enumerate() {
        let (Some(value), Some(time)) = (&change.value, clock.there(change.at)) else { continue };
        // Changes at the end of either side may be missing on the other.
        if change.at + tolerance > ends.0 || time + tolerance > ends.1 {
            continue;
        }
        let (from, to) =
            (Time::from_nanos(time.as_nanos().saturating_sub(tolerance.as_nanos() as u64)), time + tolerance);
        let begin = other.changes.partition_point(|of| of.at <= from).saturating_sub(1);
        let recorded = if is_first { change.at } else { time };
        // A turning shaft passes all positions between two samples.
        let beyond = usize::from(one.measured && masks.turns(recorded, tolerance));
        let end = other.changes.partition_point(|of| of.at <= to) + beyond;
        let window: Vec<&TrackChange> = other.changes.iter().take(end).skip(begin).collect();
        let mut known: Vec<&TrackChange> = window.iter().filter(|of| of.value.is_some()).copied().collect();
        if window.len() > known.len() && name != "connection" {
            // Right after the begin of a connection only a value that stays counts.
            let begun = window.iter().rposition(|of| of.value.is_none()).and_then(|none| window.get(none + 1));
            let Some(until) = begun.map(|begun| begun.at + tolerance * 2) else { continue };
            let stays = one.changes.get(place + 1).map_or(ends.0, |next| next.at).since(change.at);
            if stays <= until.since(time) + tolerance || until + tolerance > ends.1 {
                continue;
            }
            known = other.at(until).filter(|of| of.value.is_some()).into_iter().collect();
        }
        if known.is_empty() {
            continue;
        }
        let noise = if one.measured || other.measured { masks.noise(recorded, tolerance) } else { 0 };
        let numbers = || known.iter().filter_map(|of| of.value.as_ref()?.number);
        let circle = masks.circle.filter(|_| noise > 0 && (one.is_place || other.is_place));
        let within = |number: i128| {
            let (low, high) = (numbers().min(), numbers().max());
            let around = |of: i128, circle: i128| {
                let way = (number - of).rem_euclid(circle.max(1));
                way.min(circle - way) <= noise
            };
            (low.is_some_and(|low| number >= low - noise) && high.is_some_and(|high| number <= high + noise))
                || circle.is_some_and(|circle| numbers().any(|of| around(of, circle)))
        };
        let fits = match value.number.filter(|_| one.measured) {
            Some(number) => within(number),
            None => known.iter().any(|of| of.value.as_ref() == Some(value)),
        };
        if !fits {
            let observed = known.iter().rev().find(|of| of.at <= time).or(known.first());
            if let Some(observed) = observed {
                report(change, observed, time);
            }
        }
    }
}

fn events(
    first: &Conversation,
    second: &Conversation,
    there: &ConversationClock,
    here: &ConversationClock,
    tolerance: Duration,
    masks: &Masks,
    found: &mut Vec<Difference>,
) {
    let shown = |event: &DeviceEvent| -> Vec<(String, SuiteValue)> {
        event.said.iter().filter(|(name, _)| !masks.hides(name)).cloned().collect()
    };
    let mut left: Vec<&DeviceEvent> = second.events.iter().collect();
    let name = |event: &DeviceEvent| event.said.first().map_or_else(String::new, |(name, _)| name.clone());
    let text = |event: &DeviceEvent| {
        let parts: Vec<(String, String)> = shown(event).into_iter().map(|(name, value)| (name, value.text)).collect();
        SuiteValue::word(super::action::mapping(&parts))
    };
    for event in &first.events {
        let Some(time) = there.there(event.at) else { continue };
        let near = |other: &&DeviceEvent| time.since(other.at).max(other.at.since(time)) <= tolerance;
        match left.iter().position(|other| shown(other) == shown(event) && near(other)) {
            Some(place) => {
                left.remove(place);
            }
            None => {
                let at = TrackChange { at: event.at, frame: event.frame, value: None };
                found.push(difference(DifferenceKind::Event, &name(event), &at, Some(text(event)), None, (time, 0)));
            }
        }
    }
    for event in left {
        let Some(time) = here.there(event.at) else { continue };
        let at = TrackChange { at: time, frame: 0, value: None };
        found.push(difference(
            DifferenceKind::Event,
            &name(event),
            &at,
            None,
            Some(text(event)),
            (event.at, event.frame),
        ));
    }
}
