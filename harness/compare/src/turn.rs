//! A shaft that turned while it was captured is turned again, so that a model shows the places that were recorded.
//!
//! How far a place goes on with a revolution depends on scaling and direction, so nothing is computed from a manual: the stand turns
//! the shaft of the model, and what its telegram shows then says it. Which way a shaft really turned no place shows, since that
//! depends on the direction that the device was set to; a device that counts the wrong way is found where two names contradict each
//! other. This room must not know devices.

use super::ask::Ask;
use super::compare::Clock;
use super::drive::{Bench, CannotDrive};
use super::heard::{Conversation, Track};
use super::infer::{self, put};
use super::motion::{Leg, MOST_LEGS, Span, spans};
use super::timed::Timed;
use engine::DutSpec;
use station::{Duration, Time};
use std::fmt;

/// How often the speeds are made better.
const TRIES: usize = 6;
/// Cycles for which the shaft is turned to see how far the place goes on.
const CYCLES: u32 = 500;
/// The part of a revolution that it turns in each of these cycles.
const PART: f64 = 0.02;

/// How a shaft is turned along with a script.
#[derive(Clone, Debug)]
pub struct Turning {
    /// The place that was followed.
    pub name: String,
    /// When the shaft turned, by the clock of the capture.
    pub turned: Vec<(Time, Time)>,
    legs: Vec<Leg>,
    gain: f64,
    circle: Option<f64>,
    put: i128,
}

/// What a turning shaft shows: steps each second at one revolution per minute, and the steps of the circle where it was gone round.
fn gain(
    bench: &Bench<'_>,
    model: &DutSpec,
    mut script: Vec<Ask>,
    name: &str,
    cycle: Duration,
) -> Result<Option<(f64, Option<f64>)>, CannotDrive> {
    let rpm = PART / cycle.as_secs_f64() * 60.0;
    script.push(speed(rpm));
    script.push(Ask::Wait(cycle * CYCLES));
    let heard = bench.drive(&script, model)?;
    let Some(track) = heard.tracks.get(name) else { return Ok(None) };
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

fn numbers(track: &Track) -> impl Iterator<Item = (Time, f64)> {
    track.changes.iter().filter_map(|change| Some((change.at, change.value.as_ref()?.number? as f64)))
}

impl Turning {
    /// How the shaft turned, by the place `name`; `place` is where it stood at first, and `steps` are those of the controller.
    /// None where it did not turn, an error in words where it cannot be told how.
    pub fn of(
        bench: &Bench<'_>,
        model: &DutSpec,
        recorded: &Conversation,
        (name, place): (&str, i128),
        steps: &[Ask],
    ) -> Result<Result<Option<Turning>, String>, CannotDrive> {
        let changes = recorded.tracks.get(name).map_or(0, |track| numbers(track).count());
        if changes < 2 {
            return Ok(Ok(None));
        }
        let cycle = recorded.cycle.unwrap_or(Duration::from_millis(2));
        let connect = steps.iter().position(|ask| matches!(ask, Ask::Connect(_))).unwrap_or_default();
        let mut begin = vec![put(place)];
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
            return Ok(Err(format!("{name} moves too unsteadily to be followed")));
        }
        let mut turned: Vec<(Time, Time)> = Vec::new();
        for (index, leg) in legs.iter().enumerate().filter(|(_, leg)| leg.rpm != 0.0) {
            let end = legs.get(index + 1).map_or(recorded.end, |next| next.at);
            match turned.last_mut().filter(|last| last.1 >= leg.at) {
                Some(last) => last.1 = end,
                None => turned.push((leg.at, end)),
            }
        }
        Ok(Ok(Some(Turning { name: name.to_owned(), turned, legs, gain, circle, put: place })))
    }

    /// The steps, with the shaft ahead by `ahead` nanoseconds of the capture.
    pub fn script(&self, timed: &Timed, ahead: i64) -> Vec<Ask> {
        let mut timed = timed.clone();
        let begin = self.legs.first().map_or(0, |leg| leg.at.as_nanos());
        for (place, leg) in self.legs.iter().enumerate() {
            // However early a leg comes, it follows the first one.
            let at = leg.at.as_nanos().saturating_add_signed(-ahead).max(begin + 1);
            timed.insert(Time::from_nanos(if place == 0 { begin } else { at }), speed(leg.rpm));
        }
        let mut script = timed.script();
        script.insert(0, put(self.put));
        script
    }

    /// The steps of the circle on which the place lies, where it was gone round.
    pub fn circle(&self) -> Option<i128> {
        self.circle.map(|circle| circle as i128)
    }

    /// Where the shaft has to stand at first is known.
    pub fn put(&mut self, put: i128) {
        self.put = put;
    }

    /// The speed at first.
    pub fn first(&self) -> Ask {
        speed(self.legs.first().map_or(0.0, |leg| leg.rpm))
    }

    /// Makes the speeds better by what a run came to; whether there was something to make better.
    pub fn correct(&mut self, recorded: &Conversation, ours: &Conversation) -> bool {
        let clock = Clock::between(recorded, ours);
        let (Some(track), Some(seen)) = (recorded.tracks.get(&self.name), ours.tracks.get(&self.name)) else {
            return false;
        };
        // Steps that the legs before go further by now.
        let mut fixed = 0.0;
        let mut corrected = false;
        for place in 0..self.legs.len() {
            let (Some(leg), next) = (self.legs.get(place).copied(), self.legs.get(place + 1).copied()) else { break };
            let end = next.map_or(recorded.end, |next| next.at);
            let length = end.since(leg.at).as_secs_f64();
            if leg.rpm == 0.0 || length <= 0.0 {
                continue;
            }
            // Behind a movement the place stands still and says exactly how far it went.
            let after = self.legs.get(place + 2).map_or(recorded.end, |of| of.at);
            let stands = next.is_some_and(|next| next.rpm == 0.0);
            let at = if stands { end + after.since(end) / 2 } else { end };
            let (Some(wanted), Some(got)) = (at_time(track, at), clock.there(at).and_then(|at| at_time(seen, at)))
            else {
                continue;
            };
            let mut left = wanted - got;
            if let Some(circle) = self.circle {
                left -= (left / circle).round() * circle;
            }
            let allowed = if stands { 0.0 } else { (leg.rpm * self.gain).abs() * 0.000_2 + 1.0 };
            let change = left - fixed;
            // What jumped was not turned.
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

/// What was done with the shaft, behind where it stood at first.
impl fmt::Display for Turning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (name, legs) = (&self.name, self.legs.iter().filter(|leg| leg.rpm != 0.0).count());
        let fastest = self.legs.iter().map(|leg| leg.rpm.abs()).fold(0.0, f64::max);
        write!(
            f,
            "; turned along with {name} at {legs} steady speeds, {fastest:.3} rpm at most, so a place may differ by one step and by \
             what it goes on in the tolerance of time; which way the shaft itself turned is not in a capture"
        )
    }
}

/// The number of a track at an instant.
fn at_time(track: &Track, time: Time) -> Option<f64> {
    track.at(time)?.value.as_ref()?.number.map(|number| number as f64)
}

fn speed(rpm: f64) -> Ask {
    Ask::Set(vec![("shaft.speed".to_owned(), number(rpm))])
}

/// A number as the language reads it.
fn number(value: f64) -> String {
    let text = format!("{value:.6}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// The legs of all connections, one behind the other; nobody sees the shaft between two, where it goes on as it did on either side.
fn joined(recorded: &Conversation, spans: &[Span]) -> Vec<Leg> {
    let mut legs: Vec<Leg> = Vec::new();
    let mut seen = None;
    for span in spans {
        let first = span.legs.first().map_or(0.0, |leg| leg.rpm);
        match (seen, legs.last().map_or(0.0, |leg| leg.rpm)) {
            (None, _) => {
                let connect = recorded.asked.iter().find(|asked| matches!(asked.ask, Ask::Connect(_)));
                let at = connect.map_or(span.seen.0, |asked| asked.at);
                legs.push(Leg { at, rpm: first });
                legs.extend(span.legs.iter().skip(1));
            }
            (Some(end), last) => {
                if last != first {
                    legs.push(Leg { at: end, rpm: f64::midpoint(last, first) });
                    legs.push(Leg { at: span.seen.0, rpm: first });
                }
                legs.extend(span.legs.iter().skip(1));
            }
        }
        seen = Some(span.seen.1);
    }
    legs.dedup_by(|next, leg| next.rpm == leg.rpm);
    legs
}

/// Follows a turning shaft as well as it can be, and gives the steps with it.
pub fn follow(
    bench: &Bench<'_>,
    model: &DutSpec,
    recorded: &Conversation,
    turning: &mut Turning,
    timed: &mut Timed,
) -> Result<(), CannotDrive> {
    for _ in 0..TRIES {
        let ours = bench.drive(&turning.script(timed, 0), model)?;
        timed.learn(recorded, &ours);
        let ours = bench.drive(&turning.script(timed, 0), model)?;
        if !turning.correct(recorded, &ours) {
            break;
        }
    }
    Ok(())
}

/// What a shaft did while it was captured.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Standing {
    /// It stood, and this puts it there.
    At(Ask),
    /// It turned.
    Turns,
    /// Nobody knows where it was.
    Unknown,
}

/// Whether a shaft stood all the time, and where; `steps` are those of the controller.
pub fn standing(
    bench: &Bench<'_>,
    healthy: &DutSpec,
    recorded: &Conversation,
    steps: &[Ask],
) -> Result<Standing, CannotDrive> {
    let Some((name, place)) = infer::shaft(bench, healthy, recorded, steps, None)?.put else {
        return Ok(Standing::Unknown);
    };
    Ok(match Turning::of(bench, healthy, recorded, (&name, place), steps)? {
        Ok(None) => Standing::At(put(place)),
        Ok(Some(_)) => Standing::Turns,
        Err(_) => Standing::Unknown,
    })
}
