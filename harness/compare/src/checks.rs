//! A difference as a check: the steps of a script with the values of the reference device as expected ones.
//!
//! A check can be written in several forms; another module tries which one works. This module must not run anything.

use super::action::{ControllerAction, mapping, span};
use super::compare::{Difference, DifferenceKind};
use super::conversation::{AnsweredAction, Conversation};
use super::write_case::CaseLine;
use station::{Duration, Time};

/// By how many cycles a device may be later than the reference device.
const SLACK: u32 = 3;
/// How many cycles are checked if nothing else gives a time.
const LOOKED_AT: u32 = 20;

/// The forms in which a difference can be written.
#[derive(Debug, Default)]
pub struct DifferenceChecks {
    /// Each form is the steps of a case.
    pub ways: Vec<Vec<CaseLine>>,
}

/// The forms for a difference between the reference device and another one after a script.
pub fn forms(
    script: &[ControllerAction],
    reference: &Conversation,
    other: &Conversation,
    difference: &Difference,
) -> DifferenceChecks {
    let conversation = action_indices(script, reference);
    let lines: Vec<CaseLine> = script
        .iter()
        .zip(&conversation)
        .map(|(ask, place)| plain(ask, place.and_then(|place| reference.actions.get(place))))
        .collect();
    let at = difference.step.and_then(|step| conversation.iter().position(|place| *place == Some(step)));
    let before = || conversation.iter().rposition(|place| place.is_some_and(|place| Some(place) <= difference.step));
    let at = at.or_else(before).unwrap_or(script.len().saturating_sub(1));
    let asked = conversation.get(at).copied().flatten().and_then(|place| reference.actions.get(place));
    let mut checks = DifferenceChecks::default();
    let mut way = |place: usize, checked: Option<CaseLine>, more: Vec<CaseLine>| {
        let mut steps = lines.clone();
        if let (Some(line), Some(known)) = (checked, steps.get_mut(place)) {
            *known = line;
        }
        let after = (place + 1).min(steps.len());
        steps.splice(after..after, more);
        checks.ways.push(steps);
    };
    match difference.kind {
        DifferenceKind::Answer | DifferenceKind::Step => {
            let Some(ask) = script.get(at) else { return checks };
            for (line, more) in answered(ask, asked, difference) {
                way(at, Some(line), more);
            }
        }
        DifferenceKind::Input => {
            // A form after the step itself and one at the end, since inputs are also valid there.
            for place in [at, script.len().saturating_sub(1)] {
                let since = conversation.get(place).copied().flatten().and_then(|place| reference.actions.get(place));
                let since = since.or(asked).map_or(Time::ZERO, |asked| asked.done);
                for line in value_checks(reference, other, difference, since) {
                    way(place, None, vec![line]);
                }
            }
        }
        DifferenceKind::Event => {
            let cycle = reference.cycle_or_usual();
            let line = match &difference.first {
                Some(event) => CaseLine::new(format!("expect: {event}")).with("within: 1s"),
                None => CaseLine::new("expect: { connection: data }")
                    .with(format!("for: {}", span(millis(cycle * LOOKED_AT)))),
            };
            way(at, None, vec![line]);
            if difference.first.is_none() {
                way(at, None, vec![CaseLine::new("expect: { connection: data }").with("for: 1s")]);
            }
        }
    }
    checks
}

/// For each step of the script its index in the conversation.
fn action_indices(script: &[ControllerAction], conversation: &Conversation) -> Vec<Option<usize>> {
    let mut next = 0;
    let mut places = Vec::new();
    for ask in script {
        let found = conversation.actions.iter().skip(next).position(|asked| asked.ask == *ask).map(|skip| next + skip);
        if let Some(found) = found {
            next = found + 1;
        }
        places.push(found);
    }
    places
}

/// A step that is not checked: its answer is that of the reference device.
fn plain(ask: &ControllerAction, asked: Option<&AnsweredAction>) -> CaseLine {
    let line = CaseLine::new(ask.yaml());
    let Some(asked) = asked else { return line };
    let said = |name: &str| asked.answer.iter().find(|(known, _)| known == name).map(|(_, value)| value.text.as_str());
    match ask {
        ControllerAction::Connect(_) if said("connection") != Some("data") => line.with("answer: { connection: none }"),
        ControllerAction::Read(names) => {
            let expected: Vec<(String, String)> = names
                .iter()
                .map(|name| {
                    let refused = said(name).or(said("answer")).filter(|text| text.starts_with("{ refused"));
                    (name.clone(), refused.unwrap_or("any").to_owned())
                })
                .collect();
            CaseLine::new(format!("read: {}", mapping(&expected)))
        }
        ControllerAction::Write(_) | ControllerAction::Send { .. } => {
            let refused = asked.answer.iter().find(|(_, value)| value.text.starts_with("{ refused"));
            match refused {
                Some((_, value)) => line.with(format!("answer: {value}")),
                None => line,
            }
        }
        _ => line,
    }
}

/// A step with the answer of the reference device as the expected one.
fn answered(
    ask: &ControllerAction,
    asked: Option<&AnsweredAction>,
    difference: &Difference,
) -> Vec<(CaseLine, Vec<CaseLine>)> {
    let line = CaseLine::new(ask.yaml());
    let name = &difference.name;
    let right = difference.first.as_ref().map(|value| value.text.as_str());
    let octets = |right: &str| right.trim_matches('"').to_owned();
    let mut ways = Vec::new();
    match ask {
        ControllerAction::Read(names) if names.contains(name) => {
            let value = right.unwrap_or("any").to_owned();
            ways.push((CaseLine::new(format!("read: {}", mapping(&[(name.clone(), value)]))), Vec::new()));
        }
        ControllerAction::Read(names) => {
            let first = names.first().cloned().unwrap_or_default();
            match (name.as_str(), right) {
                ("bytes", Some(right)) => {
                    let check = CaseLine::new(format!("expect: {{ answer.bytes: \".. {}\" }}", octets(right)));
                    ways.push((plain(ask, asked), vec![check]));
                    let check = CaseLine::new(format!("expect: {{ answer.bytes: {right} }}"));
                    ways.push((plain(ask, asked), vec![check]));
                }
                (_, Some(right)) if right.starts_with('{') => {
                    ways.push((CaseLine::new(format!("read: {}", mapping(&[(first, right.to_owned())]))), Vec::new()));
                }
                _ => ways.push((plain(ask, asked), Vec::new())),
            }
        }
        ControllerAction::Write(entries) => {
            ways.push((plain(ask, asked), Vec::new()));
            let right = right.filter(|_| entries.iter().any(|(known, _)| known == name));
            if let Some(right) = right {
                ways.push((line.clone().with(format!("answer: {{ {name}: {right} }}")), Vec::new()));
            }
            ways.push((line.with("answer: accepted"), Vec::new()));
        }
        ControllerAction::Connect(_) => {
            let right = right.unwrap_or("none");
            let settled = if name == "connection" { "" } else { ", connection: data" };
            ways.push((line.clone().with(format!("answer: {{ {name}: {right}{settled} }}")), Vec::new()));
            ways.push((line.clone().with(format!("answer: {{ {name}: {right} }}")), Vec::new()));
            ways.push((line, Vec::new()));
        }
        ControllerAction::Send { .. } => match (name.as_str(), right) {
            ("bytes", Some(right)) => {
                ways.push((line.with(format!("answer: {{ bytes: {right} }}")), Vec::new()));
            }
            (_, Some(right)) if right == "accepted" || right.starts_with('{') => {
                ways.push((line.with(format!("answer: {right}")), Vec::new()));
            }
            _ => ways.push((line.with("answer: accepted"), Vec::new())),
        },
        ControllerAction::Disconnect
        | ControllerAction::Set(_)
        | ControllerAction::Turn { .. }
        | ControllerAction::Wait(_) => {}
    }
    ways
}

/// A name that has the value of the reference device, for as long as it has it there.
fn value_checks(reference: &Conversation, other: &Conversation, difference: &Difference, since: Time) -> Vec<CaseLine> {
    let name = &difference.name;
    let cycle = reference.cycle.unwrap_or_else(|| other.cycle_or_usual());
    let Some(track) = reference.tracks.get(name) else { return Vec::new() };
    let Some(change) = track.at(difference.at) else { return Vec::new() };
    let Some(value) = &change.value else { return Vec::new() };
    let after = track.changes.iter().find(|other| other.at > change.at).map(|other| other.at);
    let begin = change.at.max(since);
    let within = millis(begin.since(since) + cycle * SLACK);
    let left = after.unwrap_or(reference.end).since(begin);
    let condition = format!("expect: {{ {name}: {} }}", value.text);
    let observed = difference.at.since(begin) + cycle * LOOKED_AT;
    let holds = [observed, cycle * LOOKED_AT, left / 2];
    let mut lines: Vec<CaseLine> = Vec::new();
    for hold in holds {
        let hold = if after.is_some() { hold.min(left.saturating_sub(cycle)) } else { hold };
        if hold >= cycle {
            let line = CaseLine::new(&condition)
                .with(format!("within: {}", span(within)))
                .with(format!("for: {}", span(millis(hold))));
            if !lines.contains(&line) {
                lines.push(line);
            }
        }
    }
    lines.push(CaseLine::new(condition).with(format!("within: {}", span(within))));
    lines
}

/// A duration in whole milliseconds, at least one.
fn millis(duration: Duration) -> Duration {
    Duration::from_millis((duration.as_micros().div_ceil(1000) as u64).max(1))
}
