//! Turns the shaft of a model as it turned in a capture, so that the model has the recorded positions.
//!
//! The positions in a revolution depend on scaling and direction. Therefore they are not computed from a manual: the stand turns the
//! shaft of the model, and its position values show them. The real direction of the shaft is not in a capture, since the sign depends
//! on the direction set in the device; a device that counts in the wrong direction is found if two names contradict each other. This
//! module must not know devices.

use super::action::ControllerAction;
use super::compare::ConversationClock;
use super::conversation::{Conversation, ValueTrack};
use super::drive::{CannotDrive, ScriptBench};
use super::motion::{ConnectionMotion, MOST_LEGS, ShaftLeg, spans};
use super::shaft_position::{self, set_shaft};
use super::timed_script::TimedScript;
use engine::DutSpec;
use station::{Duration, Time};
use std::fmt;

/// How often the speeds are corrected.
const TRIES: usize = 6;
/// For how many cycles the shaft is turned to measure how the position advances.
const CYCLES: u32 = 500;
/// The part of a revolution in each of these cycles.
const PART: f64 = 0.02;

/// How a shaft is turned during a script.
#[derive(Clone, Debug)]
pub struct ShaftMotion {
    /// The name of the position that was followed.
    pub name: String,
    /// When the shaft turned, by the time of the capture.
    pub turned: Vec<(Time, Time)>,
    legs: Vec<ShaftLeg>,
    gain: f64,
    circle: Option<f64>,
    put: i128,
}

/// Measures a turning shaft: steps per second at one revolution per minute, and the position range if it wrapped.
fn gain(
    bench: &ScriptBench<'_>,
    model: &DutSpec,
    mut script: Vec<ControllerAction>,
    name: &str,
    cycle: Duration,
) -> Result<Option<(f64, Option<f64>)>, CannotDrive> {
    let rpm = PART / cycle.as_secs_f64() * 60.0;
    script.push(speed(rpm));
    script.push(ControllerAction::Wait(cycle * CYCLES));
    let conversation = bench.drive(&script, model)?;
    let Some(track) = conversation.tracks.get(name) else { return Ok(None) };
    let points: Vec<(Time, f64)> = numbers(track).collect();
    let mut ways: Vec<f64> = points.windows(2).map(|pair| pair[1].1 - pair[0].1).collect();
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return Ok(None) };
    if ways.len() < 8 {
        return Ok(None);
    }
    let all = ways.clone();
    ways.sort_by(f64::total_cmp);
    let usual = ways.get(ways.len() / 2).copied().unwrap_or_default();
    let wraps: Vec<f64> =
        all.iter().filter(|way| (**way - usual).abs() > 2.0 * usual.abs() + 2.0).map(|way| usual - way).collect();
    let circle = (!wraps.is_empty()).then(|| (wraps.iter().sum::<f64>() / wraps.len() as f64).round());
    let gone = last.1 - first.1 + circle.unwrap_or_default() * wraps.len() as f64;
    let seconds = last.0.since(first.0).as_secs_f64();
    // A revolution has a whole number of steps.
    let steps = (gone / seconds * 60.0 / rpm).round();
    Ok((steps != 0.0 && seconds > 0.0).then_some((steps / 60.0, circle.map(f64::abs))))
}

fn numbers(track: &ValueTrack) -> impl Iterator<Item = (Time, f64)> {
    track.changes.iter().filter_map(|change| Some((change.at, change.value.as_ref()?.number? as f64)))
}

impl ShaftMotion {
    /// The movement of the shaft by the position `name`; `place` is its first raw position, and `steps` are those of the controller. `None`
    /// if it did not turn, an error in words if the movement cannot be found.
    pub fn of(
        bench: &ScriptBench<'_>,
        model: &DutSpec,
        recorded: &Conversation,
        (name, place): (&str, i128),
        steps: &[ControllerAction],
    ) -> Result<Result<Option<ShaftMotion>, String>, CannotDrive> {
        let changes = recorded.tracks.get(name).map_or(0, |track| numbers(track).count());
        if changes < 2 {
            return Ok(Ok(None));
        }
        let cycle = recorded.cycle_or_usual();
        let connect = steps.iter().position(|ask| matches!(ask, ControllerAction::Connect(_))).unwrap_or_default();
        let mut begin = vec![set_shaft(place)];
        begin.extend(steps.iter().take(connect + 1).cloned());
        let Some((gain, circle)) = gain(bench, model, begin, name, cycle)? else {
            return Ok(Err(format!("{name} of the model does not follow its shaft")));
        };
        let spans = spans(recorded, name, cycle, gain);
        let legs = joined(recorded, &spans);
        if legs.iter().all(|leg| leg.rpm == 0.0) {
            return Ok(Ok(None));
        }
        if legs.len() > MOST_LEGS {
            return Ok(Err(format!("{name} moves too irregularly to be followed")));
        }
        let mut turned: Vec<(Time, Time)> = Vec::new();
        for (index, leg) in legs.iter().enumerate().filter(|(_, leg)| leg.rpm != 0.0) {
            let end = legs.get(index + 1).map_or(recorded.end, |next| next.at);
            match turned.last_mut().filter(|last| last.1 >= leg.at) {
                Some(last) => last.1 = end,
                None => turned.push((leg.at, end)),
            }
        }
        Ok(Ok(Some(ShaftMotion { name: name.to_owned(), turned, legs, gain, circle, put: place })))
    }

    /// The steps, with the shaft ahead by `ahead` nanoseconds of the capture.
    pub fn script(&self, timed: &TimedScript, ahead: i64) -> Vec<ControllerAction> {
        let mut timed = timed.clone();
        let begin = self.legs.first().map_or(0, |leg| leg.at.as_nanos());
        for (place, leg) in self.legs.iter().enumerate() {
            // However early a leg is, it follows the first one.
            let at = leg.at.as_nanos().saturating_add_signed(-ahead).max(begin + 1);
            timed.insert(Time::from_nanos(if place == 0 { begin } else { at }), speed(leg.rpm));
        }
        let mut script = timed.script();
        script.insert(0, set_shaft(self.put));
        script
    }

    /// The number of positions after which the position value wraps, if it wrapped.
    pub fn circle(&self) -> Option<i128> {
        self.circle.map(|circle| circle as i128)
    }

    /// Sets the first raw position of the shaft.
    pub fn put(&mut self, put: i128) {
        self.put = put;
    }

    /// The first speed.
    pub fn first(&self) -> ControllerAction {
        speed(self.legs.first().map_or(0.0, |leg| leg.rpm))
    }

    /// Corrects the speeds by the result of a run; returns whether there was something to correct.
    pub fn correct(&mut self, recorded: &Conversation, run: &Conversation) -> bool {
        let clock = ConversationClock::between(recorded, run);
        let (Some(track), Some(observed)) = (recorded.tracks.get(&self.name), run.tracks.get(&self.name)) else {
            return false;
        };
        // Steps by which the corrected legs before now go further.
        let mut fixed = 0.0;
        let mut corrected = false;
        for place in 0..self.legs.len() {
            let (Some(leg), next) = (self.legs.get(place).copied(), self.legs.get(place + 1).copied()) else { break };
            let end = next.map_or(recorded.end, |next| next.at);
            let length = end.since(leg.at).as_secs_f64();
            if leg.rpm == 0.0 || length <= 0.0 {
                continue;
            }
            // After a movement the position at rest shows exactly how far it went.
            let after = self.legs.get(place + 2).map_or(recorded.end, |of| of.at);
            let stands = next.is_some_and(|next| next.rpm == 0.0);
            let at = if stands { end + after.since(end) / 2 } else { end };
            let (Some(expected), Some(got)) =
                (at_time(track, at), clock.there(at).and_then(|at| at_time(observed, at)))
            else {
                continue;
            };
            let mut left = expected - got;
            if let Some(circle) = self.circle {
                left -= (left / circle).round() * circle;
            }
            let allowed = if stands { 0.0 } else { (leg.rpm * self.gain).abs() * 0.000_2 + 1.0 };
            let change = left - fixed;
            // A jump was not caused by turning.
            let before = place.checked_sub(1).and_then(|before| self.legs.get(before)).map_or(0.0, |leg| leg.rpm.abs());
            let possible = (leg.rpm.abs().max(before) * self.gain * length).abs() + 4.0;
            if change.abs() > allowed && change.abs() < possible {
                let by = change / (self.gain * length);
                if let Some(leg) = self.legs.get_mut(place) {
                    leg.rpm += by;
                }
                fixed = left;
                corrected = true;
            }
        }
        corrected
    }
}

/// The movement of the shaft after its first position, for the report.
impl fmt::Display for ShaftMotion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, legs) = (&self.name, self.legs.iter().filter(|leg| leg.rpm != 0.0).count());
        let fastest = self.legs.iter().map(|leg| leg.rpm.abs()).fold(0.0, f64::max);
        write!(
            f,
            "; turned with {name} at {legs} constant speeds, up to {fastest:.3} rpm, so a position may differ by one step and by its change \
     within the time tolerance; the real direction of the shaft is not in a capture"
        )
    }
}

/// The number of a track at an instant.
fn at_time(track: &ValueTrack, time: Time) -> Option<f64> {
    track.at(time)?.value.as_ref()?.number.map(|number| number as f64)
}

fn speed(rpm: f64) -> ControllerAction {
    ControllerAction::Set(vec![("shaft.speed".to_owned(), number(rpm))])
}

/// A number in the suite language.
fn number(value: f64) -> String {
    let text = format!("{value:.6}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// The legs of all connections in order; between two connections the speed is the mean of those before and after.
fn joined(recorded: &Conversation, spans: &[ConnectionMotion]) -> Vec<ShaftLeg> {
    let mut legs: Vec<ShaftLeg> = Vec::new();
    let mut end = None;
    for span in spans {
        let first = span.legs.first().map_or(0.0, |leg| leg.rpm);
        match (end, legs.last().map_or(0.0, |leg| leg.rpm)) {
            (None, _) => {
                let connect = recorded.actions.iter().find(|asked| matches!(asked.ask, ControllerAction::Connect(_)));
                let at = connect.map_or(span.seen.0, |asked| asked.at);
                legs.push(ShaftLeg { at, rpm: first });
                legs.extend(span.legs.iter().skip(1));
            }
            (Some(end), last) => {
                if last != first {
                    legs.push(ShaftLeg { at: end, rpm: f64::midpoint(last, first) });
                    legs.push(ShaftLeg { at: span.seen.0, rpm: first });
                }
                legs.extend(span.legs.iter().skip(1));
            }
        }
        end = Some(span.seen.1);
    }
    legs.dedup_by(|next, leg| next.rpm == leg.rpm);
    legs
}

/// Adapts the movement and the timing to the capture until the corrections end.
pub fn adapt(
    bench: &ScriptBench<'_>,
    model: &DutSpec,
    recorded: &Conversation,
    turning: &mut ShaftMotion,
    timed: &mut TimedScript,
) -> Result<(), CannotDrive> {
    for _ in 0..TRIES {
        let run = bench.drive(&turning.script(timed, 0), model)?;
        timed.learn(recorded, &run);
        let run = bench.drive(&turning.script(timed, 0), model)?;
        if !turning.correct(recorded, &run) {
            break;
        }
    }
    Ok(())
}

/// The state of a shaft during a capture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ShaftState {
    /// It was at rest; this sets its position.
    At(ControllerAction),
    /// It turned.
    Turns,
    /// Its position is unknown.
    Unknown,
}

/// Whether a shaft was at rest all the time, and its position; `steps` are those of the controller.
pub fn shaft_state(
    bench: &ScriptBench<'_>,
    reference: &DutSpec,
    recorded: &Conversation,
    steps: &[ControllerAction],
) -> Result<ShaftState, CannotDrive> {
    let Some((name, place)) = shaft_position::shaft(bench, reference, recorded, steps, None)?.put else {
        return Ok(ShaftState::Unknown);
    };
    Ok(match ShaftMotion::of(bench, reference, recorded, (&name, place), steps)? {
        Ok(None) => ShaftState::At(set_shaft(place)),
        Ok(Some(_)) => ShaftState::Turns,
        Err(_) => ShaftState::Unknown,
    })
}
