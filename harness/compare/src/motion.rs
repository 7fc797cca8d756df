//! The movement of a shaft, as far as recorded positions show it: legs of constant speed, one after the other without jumps.
//!
//! A leg is as long as one constant speed explains all recorded positions. A jump further than a shaft can turn, or together with an
//! action of the controller, is no movement: the counter wrapped, a preset was executed, or the device is wrong. This module must not
//! know devices, nor how the shaft is turned again.

use super::action::ControllerAction;
use super::conversation::Conversation;
use station::{Duration, Time};

/// A shaft with more legs is not turned again.
pub const MOST_LEGS: usize = 400;
/// The assumed maximum speed of a shaft, in revolutions per minute.
pub const FASTEST: f64 = 12_000.0;
/// For how many cycles the position has to stay before the shaft counts as at rest.
const STANDS: u32 = 4;
/// A jump of the position within this time after an action of the controller may be an effect of it.
const REACTION: Duration = Duration::from_millis(250);
/// A change without another one within this time is not caused by a slowly turning shaft.
const ALONE: Duration = Duration::from_millis(100);
/// Steps by which a position may jump at any speed.
const FEW: f64 = 8.0;

/// A part of the movement with constant speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShaftLeg {
    /// The begin.
    pub at: Time,
    /// The speed in revolutions per minute; of all speeds that fit the positions it is the one with the fewest digits.
    pub rpm: f64,
}

/// The legs during one connection.
#[derive(Clone, Debug, PartialEq)]
pub struct ConnectionMotion {
    /// The first and the last sample.
    pub seen: (Time, Time),
    /// The legs, of which the first begins with the first sample.
    pub legs: Vec<ShaftLeg>,
}

/// The movement in each connection by the position `name`, which advances by `gain` steps per second at one revolution per minute.
pub fn spans(conversation: &Conversation, name: &str, cycle: Duration, gain: f64) -> Vec<ConnectionMotion> {
    let Some(track) = conversation.tracks.get(name) else { return Vec::new() };
    let asked = |at: Time| {
        let changing = conversation
            .actions
            .iter()
            .filter(|asked| !matches!(asked.ask, ControllerAction::Read(_) | ControllerAction::Wait(_)));
        changing.into_iter().any(|asked| asked.at <= at + cycle && at.since(asked.done) <= REACTION)
    };
    let mut spans = Vec::new();
    let mut points: Vec<(Time, f64)> = Vec::new();
    for change in &track.changes {
        match change.value.as_ref().and_then(|value| value.number) {
            Some(number) => points.push((change.at, number as f64)),
            None => spans.extend(span(&std::mem::take(&mut points), change.at, cycle, gain, &asked)),
        }
    }
    spans.extend(span(&points, conversation.end, cycle, gain, &asked));
    spans
}

/// A time, and the lowest and highest position that a line may have there.
type PositionGate = (Time, f64, f64);

fn span(
    points: &[(Time, f64)],
    end: Time,
    cycle: Duration,
    gain: f64,
    asked: &dyn Fn(Time) -> bool,
) -> Option<ConnectionMotion> {
    let first = points.first()?;
    let gates = gates(points, end, cycle, gain.abs() * FASTEST, asked);
    let mut legs: Vec<ShaftLeg> = Vec::new();
    let mut begin = (first.0, first.1 + 0.5);
    let (mut lowest, mut highest) = (f64::NEG_INFINITY, f64::INFINITY);
    let mut last = begin.0;
    for (at, low, high) in gates {
        let seconds = |since: Time| at.since(since).as_secs_f64();
        if seconds(begin.0) <= 0.0 {
            continue;
        }
        let to = |place: f64, from: (Time, f64)| (place - from.1) / seconds(from.0);
        let (lower, higher) = (lowest.max(to(low, begin)), highest.min(to(high, begin)));
        if lower > higher {
            let leg = ShaftLeg { at: begin.0, rpm: speed(lowest, highest, gain) };
            begin = (last, begin.1 + leg.rpm * gain * last.since(begin.0).as_secs_f64());
            legs.push(leg);
            (lowest, highest) = (to(low, begin), to(high, begin));
        } else {
            (lowest, highest) = (lower, higher);
        }
        last = at;
    }
    if lowest.is_finite() && highest.is_finite() {
        legs.push(ShaftLeg { at: begin.0, rpm: speed(lowest, highest, gain) });
    }
    Some(ConnectionMotion { seen: (first.0, end), legs })
}

/// The positions without jumps; while the position changes every few cycles it is known to a part of its change, at rest exactly.
fn gates(
    points: &[(Time, f64)],
    end: Time,
    cycle: Duration,
    fastest: f64,
    asked: &dyn Fn(Time) -> bool,
) -> Vec<PositionGate> {
    let gap = |place: usize| {
        let (one, other) = (points.get(place.checked_sub(1)?)?, points.get(place)?);
        Some((other.0.since(one.0), other.1 - one.1))
    };
    let is_long = |place: usize| gap(place).is_none_or(|(time, _)| time >= cycle * STANDS);
    // Steps per second up to a position; after a rest the shaft may have begun to turn only now.
    let rate = |place: usize| {
        let (time, way) = gap(place)?;
        let time = if is_long(place) { cycle } else { time };
        (!time.is_zero()).then(|| way / time.as_secs_f64())
    };
    // Whether the position stays for long before and after.
    let is_alone = |place: usize| {
        let long = |place: usize| gap(place).is_none_or(|(time, _)| time > ALONE);
        long(place) && long(place + 1)
    };
    let (mut jumped, mut was_jump) = (0.0, false);
    let mut gates = Vec::new();
    for (place, &(at, position)) in points.iter().enumerate() {
        let mut change = 0.0_f64;
        if let Some((time, way)) = gap(place) {
            let seconds = if is_long(place) { cycle } else { time }.as_secs_f64();
            let before = place.checked_sub(1).filter(|_| !is_long(place) && !was_jump).and_then(rate);
            let after = rate(place + 1).filter(|_| !is_long(place + 1));
            let expected = [before, after].into_iter().flatten().map(|rate| rate * seconds);
            let nearest = expected.min_by(|one, other| (way - one).abs().total_cmp(&(way - other).abs()));
            let is_jump = match nearest {
                Some(near) => (way - near).abs() > 2.0 * near.abs() + FEW,
                None => way.abs() > fastest * seconds || (asked(at) && (way.abs() > FEW || is_alone(place))),
            };
            was_jump = is_jump;
            if is_jump {
                jumped += way - nearest.unwrap_or(0.0);
                change = nearest.unwrap_or(0.0);
            } else {
                change = way;
            }
        }
        let until = points.get(place + 1).map_or(end, |next| next.0);
        let stays = until.since(at) > cycle * STANDS;
        let slack = (change.abs() * 0.25).max(0.5);
        let slack = if stays { 0.0 } else { slack };
        let line = position - jumped;
        gates.push((at, line - slack, line + 1.0 + slack));
        // It stays until the last sample before the next change.
        if until.since(at) > cycle + cycle / 2 {
            let last = Time::from_nanos(until.as_nanos().saturating_sub(cycle.as_nanos() as u64));
            if stays {
                gates.push((at + cycle, line, line + 1.0));
            }
            gates.push((last, line - slack, line + 1.0 + slack));
        }
    }
    gates
}

/// The speed between two slopes with the fewest digits.
fn speed(low: f64, high: f64, gain: f64) -> f64 {
    let (one, other) = (low / gain, high / gain);
    roundest(one.min(other), one.max(other))
}

/// The number with the fewest digits between two.
fn roundest(low: f64, high: f64) -> f64 {
    if low <= 0.0 && high >= 0.0 {
        return 0.0;
    }
    let (sign, low, high) = if high < 0.0 { (-1.0, -high, -low) } else { (1.0, low, high) };
    let scales = [1000.0, 100.0, 10.0, 1.0, 0.1, 0.01, 0.001, 0.0001, 0.000_01, 0.000_001];
    let found = scales.iter().map(|scale| (low / scale).ceil() * scale).find(|round| *round <= high);
    sign * found.unwrap_or_else(|| f64::midpoint(low, high))
}
