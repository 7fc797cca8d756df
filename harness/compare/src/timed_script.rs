//! A script with the timing of a capture, and with movements of the shaft in between.
//!
//! The steps of the harness take other times than those of the recorded controller. From a run it is learnt how much later each step
//! is, and the waits of the next run are shortened by that. This module must not know devices.

use super::action::ControllerAction;
use super::compare::pair;
use super::conversation::{AnsweredAction, Conversation};
use super::drive::TAIL;
use super::script::{LONGEST, SHORTEST};
use station::{Duration, Time};

/// How the names begin that the stand serves.
const STAND_NAMES: [&str; 4] = ["shaft.", "fault.", "button.", "supply."];

/// A step of a script with its times in the capture.
#[derive(Clone, Debug)]
pub struct TimedStep {
    pub ask: ControllerAction,
    /// When it began.
    pub at: Time,
    /// When it was answered.
    pub done: Time,
    /// By how much it begins too late, in nanoseconds.
    late: i64,
    /// By how much it takes longer than in the capture, in nanoseconds.
    longer: i64,
}

/// All steps, in order of time.
#[derive(Clone, Debug)]
pub struct TimedScript {
    items: Vec<TimedStep>,
    /// The time of the last frame.
    end: Time,
    /// Whether the delays of the harness's steps have been learnt.
    learnt: bool,
}

impl TimedScript {
    /// The actions of the controller with their timing.
    pub fn new(conversation: &Conversation) -> TimedScript {
        let item = |asked: &AnsweredAction| TimedStep {
            ask: asked.ask.clone(),
            at: asked.at,
            done: asked.done,
            late: 0,
            longer: 0,
        };
        TimedScript { items: conversation.actions.iter().map(item).collect(), end: conversation.end, learnt: false }
    }

    /// Inserts a step of the stand; one that falls into the time of a request follows it, one that falls into a start-up precedes it.
    pub fn insert(&mut self, at: Time, ask: ControllerAction) {
        let within = self.items.iter().position(|item| item.at < at && at < item.done);
        let (place, at) = match within.and_then(|place| Some((place, self.items.get(place)?))) {
            Some((place, item)) if matches!(item.ask, ControllerAction::Connect(_)) => (place, item.at),
            Some((place, item)) => (place + 1, item.done),
            None => (self.items.partition_point(|item| item.at < at), at),
        };
        self.items.insert(place, TimedStep { ask, at, done: at, late: 0, longer: 0 });
    }

    /// The steps with the waits between them.
    pub fn script(&self) -> Vec<ControllerAction> {
        let mut script = Vec::new();
        let mut last: Option<&TimedStep> = None;
        // Nanoseconds that could not be compensated yet.
        let mut debt = 0_i64;
        for item in &self.items {
            let waited = last.map_or(Duration::ZERO, |last| item.at.since(last.done)).min(LONGEST);
            let left = i64::try_from(waited.as_nanos()).unwrap_or(i64::MAX).saturating_sub(item.late + debt);
            debt = item.longer + if last.is_some() { left.min(0).saturating_neg() } else { 0 };
            let wait = Duration::from_nanos(u64::try_from(left).unwrap_or_default());
            let exact = self.learnt || is_stand(&item.ask);
            if wait >= SHORTEST || (exact && wait >= Duration::from_micros(1)) {
                script.push(ControllerAction::Wait(Duration::from_micros(wait.as_micros() as u64)));
            }
            script.push(item.ask.clone());
            last = Some(item);
        }
        // Effects of the last step may be late.
        let rest = last.map_or(Duration::ZERO, |last| self.end.since(last.done)).min(LONGEST);
        if rest > TAIL {
            script.push(ControllerAction::Wait(Duration::from_millis((rest - TAIL).as_millis() as u64)));
        }
        script
    }

    /// Learns from a run how much later each step was than in the capture, counted from the first answer on.
    pub fn learn(&mut self, conversation: &Conversation, run: &Conversation) {
        let (pairs, _) = pair(&conversation.actions, &run.actions);
        let Some(&(first, other)) = pairs.first() else { return };
        let (Some(begin), Some(there)) = (conversation.actions.get(first), run.actions.get(other)) else { return };
        let (begin, there) = (begin.done, there.done);
        self.learnt = true;
        let mut before = 0_i64;
        // The items of the controller in order; those of the stand are between them.
        for (own, item) in self.items.iter_mut().filter(|item| !is_stand(&item.ask)).enumerate() {
            let paired = pairs.iter().find(|(one, _)| *one == own);
            let Some(asked) = paired.and_then(|&(_, other)| run.actions.get(other)) else { continue };
            // The observations of a connection begin with its first sample.
            let (planned, came, longer) = match item.ask {
                ControllerAction::Connect(_) => (item.done, asked.done, 0),
                _ => (item.at, asked.at, signed(asked.done, asked.at) - signed(item.done, item.at)),
            };
            if planned <= begin {
                continue;
            }
            let late = signed(came, there).saturating_sub(signed(planned, begin));
            item.late = item.late.saturating_add(late - before);
            // The time that it takes longer is compensated after it from now on.
            before = late + longer - item.longer;
            item.longer = longer;
        }
    }
}

/// Whether a step belongs to the stand and not to the controller.
fn is_stand(ask: &ControllerAction) -> bool {
    let of_stand = |name: &str| name == "power" || STAND_NAMES.iter().any(|begin| name.starts_with(begin));
    matches!(ask, ControllerAction::Set(of) if of.iter().all(|(name, _)| of_stand(name)))
}

/// Nanoseconds from `since` to `at`.
fn signed(at: Time, since: Time) -> i64 {
    let nanos = |time: Time| i64::try_from(time.as_nanos()).unwrap_or(i64::MAX);
    nanos(at).saturating_sub(nanos(since))
}
