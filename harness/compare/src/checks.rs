//! A difference as a check: the steps of a script with what the healthy device shows written beside them.
//!
//! There are several ways to say the same; which one holds is tried elsewhere. This room must not run anything.

use super::ask::{Ask, mapping, span};
use super::compare::{Difference, Kind};
use super::heard::{Asked, Conversation};
use super::write_case::Line;
use station::{Duration, Time};

/// Cycles that a device may take longer than the healthy one did.
const SLACK: u32 = 3;
/// Cycles that are looked at where nothing says how long.
const LOOKED_AT: u32 = 20;

/// The ways in which a difference can be said.
#[derive(Debug, Default)]
pub struct Checks {
    /// Each of them: the steps of a case.
    pub ways: Vec<Vec<Line>>,
}

/// The ways to say a difference between the healthy device and the other one after a script.
pub fn ways(script: &[Ask], healthy: &Conversation, other: &Conversation, difference: &Difference) -> Checks {
    let heard = heard_at(script, healthy);
    let lines: Vec<Line> = script
        .iter()
        .zip(&heard)
        .map(|(ask, place)| plain(ask, place.and_then(|place| healthy.asked.get(place))))
        .collect();
    let at = difference.step.and_then(|step| heard.iter().position(|place| *place == Some(step)));
    let before = || heard.iter().rposition(|place| place.is_some_and(|place| Some(place) <= difference.step));
    let at = at.or_else(before).unwrap_or(script.len().saturating_sub(1));
    let asked = heard.get(at).copied().flatten().and_then(|place| healthy.asked.get(place));
    let mut checks = Checks::default();
    let mut way = |place: usize, checked: Option<Line>, more: Vec<Line>| {
        let mut steps = lines.clone();
        if let (Some(line), Some(known)) = (checked, steps.get_mut(place)) {
            *known = line;
        }
        let behind = (place + 1).min(steps.len());
        steps.splice(behind..behind, more);
        checks.ways.push(steps);
    };
    match difference.kind {
        Kind::Answer | Kind::Step => {
            let Some(ask) = script.get(at) else { return checks };
            for (line, more) in answered(ask, asked, difference) {
                way(at, Some(line), more);
            }
        }
        Kind::Input => {
            // Behind the step itself, and behind everything, where what comes by itself is there all the same.
            for place in [at, script.len().saturating_sub(1)] {
                let since = heard.get(place).copied().flatten().and_then(|place| healthy.asked.get(place));
                let since = since.or(asked).map_or(Time::ZERO, |asked| asked.done);
                for line in shown(healthy, other, difference, since) {
                    way(place, None, vec![line]);
                }
            }
        }
        Kind::Event => {
            let cycle = healthy.cycle.unwrap_or(Duration::from_millis(2));
            let line = match &difference.first {
                Some(event) => Line::new(format!("expect: {event}")).with("within: 1s"),
                None => {
                    Line::new("expect: { connection: data }").with(format!("for: {}", span(millis(cycle * LOOKED_AT))))
                }
            };
            way(at, None, vec![line]);
            if difference.first.is_none() {
                way(at, None, vec![Line::new("expect: { connection: data }").with("for: 1s")]);
            }
        }
    }
    checks
}

/// For each step of the script its place in what was heard.
fn heard_at(script: &[Ask], heard: &Conversation) -> Vec<Option<usize>> {
    let mut next = 0;
    let mut places = Vec::new();
    for ask in script {
        let found = heard.asked.iter().skip(next).position(|asked| asked.ask == *ask).map(|skip| next + skip);
        if let Some(found) = found {
            next = found + 1;
        }
        places.push(found);
    }
    places
}

/// A step that nobody checks: it is answered as the healthy device answers it.
fn plain(ask: &Ask, asked: Option<&Asked>) -> Line {
    let line = Line::new(ask.yaml());
    let Some(asked) = asked else { return line };
    let said = |name: &str| asked.answer.iter().find(|(known, _)| known == name).map(|(_, value)| value.text.as_str());
    match ask {
        Ask::Connect(_) if said("connection") != Some("data") => line.with("answer: { connection: none }"),
        Ask::Read(names) => {
            let wanted: Vec<(String, String)> = names
                .iter()
                .map(|name| {
                    let refused = said(name).or(said("answer")).filter(|text| text.starts_with("{ refused"));
                    (name.clone(), refused.unwrap_or("any").to_owned())
                })
                .collect();
            Line::new(format!("read: {}", mapping(&wanted)))
        }
        Ask::Write(_) | Ask::Send { .. } => {
            let refused = asked.answer.iter().find(|(_, value)| value.text.starts_with("{ refused"));
            match refused {
                Some((_, value)) => line.with(format!("answer: {value}")),
                None => line,
            }
        }
        _ => line,
    }
}

/// A step with the answer of the healthy device as the right one.
fn answered(ask: &Ask, asked: Option<&Asked>, difference: &Difference) -> Vec<(Line, Vec<Line>)> {
    let line = Line::new(ask.yaml());
    let name = &difference.name;
    let right = difference.first.as_ref().map(|value| value.text.as_str());
    let octets = |right: &str| right.trim_matches('"').to_owned();
    let mut ways = Vec::new();
    match ask {
        Ask::Read(names) if names.contains(name) => {
            let value = right.unwrap_or("any").to_owned();
            ways.push((Line::new(format!("read: {}", mapping(&[(name.clone(), value)]))), Vec::new()));
        }
        Ask::Read(names) => {
            let first = names.first().cloned().unwrap_or_default();
            match (name.as_str(), right) {
                ("bytes", Some(right)) => {
                    let looks = Line::new(format!("expect: {{ answer.bytes: \".. {}\" }}", octets(right)));
                    ways.push((plain(ask, asked), vec![looks]));
                    let looks = Line::new(format!("expect: {{ answer.bytes: {right} }}"));
                    ways.push((plain(ask, asked), vec![looks]));
                }
                (_, Some(right)) if right.starts_with('{') => {
                    ways.push((Line::new(format!("read: {}", mapping(&[(first, right.to_owned())]))), Vec::new()));
                }
                _ => ways.push((plain(ask, asked), Vec::new())),
            }
        }
        Ask::Write(entries) => {
            ways.push((plain(ask, asked), Vec::new()));
            let right = right.filter(|_| entries.iter().any(|(known, _)| known == name));
            if let Some(right) = right {
                ways.push((line.clone().with(format!("answer: {{ {name}: {right} }}")), Vec::new()));
            }
            ways.push((line.with("answer: accepted"), Vec::new()));
        }
        Ask::Connect(_) => {
            let right = right.unwrap_or("none");
            let settled = if name == "connection" { "" } else { ", connection: data" };
            ways.push((line.clone().with(format!("answer: {{ {name}: {right}{settled} }}")), Vec::new()));
            ways.push((line.clone().with(format!("answer: {{ {name}: {right} }}")), Vec::new()));
            ways.push((line, Vec::new()));
        }
        Ask::Send { .. } => match (name.as_str(), right) {
            ("bytes", Some(right)) => {
                ways.push((line.with(format!("answer: {{ bytes: {right} }}")), Vec::new()));
            }
            (_, Some(right)) if right == "accepted" || right.starts_with('{') => {
                ways.push((line.with(format!("answer: {right}")), Vec::new()));
            }
            _ => ways.push((line.with("answer: accepted"), Vec::new())),
        },
        Ask::Disconnect | Ask::Set(_) | Ask::Turn { .. } | Ask::Wait(_) => {}
    }
    ways
}

/// A name that has the value of the healthy device for as long as it has it there.
fn shown(healthy: &Conversation, other: &Conversation, difference: &Difference, since: Time) -> Vec<Line> {
    let name = &difference.name;
    let cycle = healthy.cycle.or(other.cycle).unwrap_or(Duration::from_millis(2));
    let Some(track) = healthy.tracks.get(name) else { return Vec::new() };
    let Some(change) = track.at(difference.at) else { return Vec::new() };
    let Some(value) = &change.value else { return Vec::new() };
    let behind = track.changes.iter().find(|other| other.at > change.at).map(|other| other.at);
    let begin = change.at.max(since);
    let within = millis(begin.since(since) + cycle * SLACK);
    let left = behind.unwrap_or(healthy.end).since(begin);
    let condition = format!("expect: {{ {name}: {} }}", value.text);
    let seen = difference.at.since(begin) + cycle * LOOKED_AT;
    let holds = [seen, cycle * LOOKED_AT, left / 2];
    let mut lines: Vec<Line> = Vec::new();
    for hold in holds {
        let hold = if behind.is_some() { hold.min(left.saturating_sub(cycle)) } else { hold };
        if hold >= cycle {
            let line = Line::new(&condition)
                .with(format!("within: {}", span(within)))
                .with(format!("for: {}", span(millis(hold))));
            if !lines.contains(&line) {
                lines.push(line);
            }
        }
    }
    lines.push(Line::new(condition).with(format!("within: {}", span(within))));
    lines
}

/// A duration in whole milliseconds, at least one.
fn millis(duration: Duration) -> Duration {
    Duration::from_millis((duration.as_micros().div_ceil(1000) as u64).max(1))
}
