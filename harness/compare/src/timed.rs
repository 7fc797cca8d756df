//! A script in the timing of a capture, with the shaft turned in between.
//!
//! Our own steps take other times than those of the controller of the capture did. How much later each came is seen in what was
//! heard of a run, and the waits before them are made shorter by it for the next one. This room must not know devices.

use super::ask::Ask;
use super::compare::pair;
use super::drive::TAIL;
use super::heard::{Asked, Conversation};
use super::script::{LONGEST, SHORTEST};
use station::{Duration, Time};

/// A step of a script, and when it was done in the capture.
#[derive(Clone, Debug)]
pub struct Item {
    /// What is done.
    pub ask: Ask,
    /// When it began.
    pub at: Time,
    /// When it was answered.
    pub done: Time,
    /// Nanoseconds by which it is known to begin later than it should.
    late: i64,
    /// Nanoseconds by which it is known to take longer than in the capture.
    longer: i64,
}

/// Everything that is done, in the order of time.
#[derive(Clone, Debug)]
pub struct Timed {
    items: Vec<Item>,
    /// When the last frame came.
    end: Time,
    /// Whether it is known how much later our steps come.
    learnt: bool,
}

impl Timed {
    /// What the controller did, in its timing.
    pub fn new(heard: &Conversation) -> Timed {
        let item = |asked: &Asked| Item { ask: asked.ask.clone(), at: asked.at, done: asked.done, late: 0, longer: 0 };
        Timed { items: heard.asked.iter().map(item).collect(), end: heard.end, learnt: false }
    }

    /// The same with a step of the stand more; one that falls into the time of a request follows behind it, one that falls into a
    /// start-up goes before it.
    pub fn insert(&mut self, at: Time, ask: Ask) {
        let within = self.items.iter().position(|item| item.at < at && at < item.done);
        let (place, at) = match within.and_then(|place| Some((place, self.items.get(place)?))) {
            Some((place, item)) if matches!(item.ask, Ask::Connect(_)) => (place, item.at),
            Some((place, item)) => (place + 1, item.done),
            None => (self.items.partition_point(|item| item.at < at), at),
        };
        self.items.insert(place, Item { ask, at, done: at, late: 0, longer: 0 });
    }

    /// The steps with the waits between them.
    pub fn script(&self) -> Vec<Ask> {
        let mut script = Vec::new();
        let mut last: Option<&Item> = None;
        // Nanoseconds that could not be made up for yet.
        let mut debt = 0_i64;
        for item in &self.items {
            let waited = last.map_or(Duration::ZERO, |last| item.at.since(last.done)).min(LONGEST);
            let left = i64::try_from(waited.as_nanos()).unwrap_or(i64::MAX).saturating_sub(item.late + debt);
            debt = item.longer + if last.is_some() { left.min(0).saturating_neg() } else { 0 };
            let wait = Duration::from_nanos(u64::try_from(left).unwrap_or_default());
            let exact = self.learnt || is_stand(&item.ask);
            if wait >= SHORTEST || (exact && wait >= Duration::from_micros(1)) {
                script.push(Ask::Wait(Duration::from_micros(wait.as_micros() as u64)));
            }
            script.push(item.ask.clone());
            last = Some(item);
        }
        // What came of the last step may show late.
        let rest = last.map_or(Duration::ZERO, |last| self.end.since(last.done)).min(LONGEST);
        if rest > TAIL {
            script.push(Ask::Wait(Duration::from_millis((rest - TAIL).as_millis() as u64)));
        }
        script
    }

    /// Learns from a run how much later each step came than in the capture, counted from the first answer on.
    pub fn learn(&mut self, heard: &Conversation, ours: &Conversation) {
        let (pairs, _) = pair(&heard.asked, &ours.asked);
        let Some(&(first, other)) = pairs.first() else { return };
        let (Some(begin), Some(there)) = (heard.asked.get(first), ours.asked.get(other)) else { return };
        let (begin, there) = (begin.done, there.done);
        self.learnt = true;
        let mut before = 0_i64;
        // The items of the controller in its order; those of the stand lie between them.
        for (own, item) in self.items.iter_mut().filter(|item| !is_stand(&item.ask)).enumerate() {
            let paired = pairs.iter().find(|(one, _)| *one == own);
            let Some(asked) = paired.and_then(|&(_, other)| ours.asked.get(other)) else { continue };
            // What is seen of a connection begins with its first sample.
            let (wanted, came, longer) = match item.ask {
                Ask::Connect(_) => (item.done, asked.done, 0),
                _ => (item.at, asked.at, signed(asked.done, asked.at) - signed(item.done, item.at)),
            };
            if wanted <= begin {
                continue;
            }
            let late = signed(came, there).saturating_sub(signed(wanted, begin));
            item.late = item.late.saturating_add(late - before);
            // What it takes longer is made up for behind it from now on.
            before = late + longer - item.longer;
            item.longer = longer;
        }
    }
}

/// Whether a step is one of the stand and not of the controller.
fn is_stand(ask: &Ask) -> bool {
    matches!(ask, Ask::Set(of) if of.iter().all(|(name, _)| name.starts_with("shaft.")))
}

/// Nanoseconds from `since` to `at`.
fn signed(at: Time, since: Time) -> i64 {
    let nanos = |time: Time| i64::try_from(time.as_nanos()).unwrap_or(i64::MAX);
    nanos(at).saturating_sub(nanos(since))
}
