//! The outputs of a controller: their changes, and the signs of life that count by themselves.

use super::parts::{CyclicName, carried};
use judge::image::ConnectionImage;
use judge::observe::FrameDirection;
use station::Time;

/// A sign of life that has not counted for this many frames is constant.
const STANDS_STILL: u32 = 20;
/// How many runs of equal numbers give the usual length of a run.
const LEARNT: usize = 3;

/// Names that were set, with their values.
type SetNames = Vec<(String, String)>;

/// The last outputs.
#[derive(Debug)]
pub(super) struct OutputTracker {
    parts: Vec<CyclicName>,
    last: Vec<i128>,
    counters: Vec<SignOfLifeRuns>,
}

/// A field that counts by itself.
#[derive(Clone, Debug, Default)]
struct SignOfLifeRuns {
    last: Option<i128>,
    /// Since when it has this number.
    since: Time,
    /// Frames with this number so far.
    run: u32,
    /// The lengths of the last runs.
    runs: Vec<u32>,
    /// Whether it was reported as held.
    held: bool,
}

impl OutputTracker {
    /// All outputs 0 and all signs of life counting, as at the begin of a trial.
    pub fn new(parts: Vec<CyclicName>) -> OutputTracker {
        OutputTracker { last: vec![0; parts.len()], counters: vec![SignOfLifeRuns::default(); parts.len()], parts }
    }

    /// Takes in a frame of outputs; returns what was set with it, and what was set earlier, as only this frame shows: since when, or `None`
    /// for what stood still from the first frame on.
    pub fn frame(&mut self, image: &ConnectionImage, now: Time) -> (SetNames, Vec<(Option<Time>, SetNames)>) {
        let OutputTracker { parts, last, counters } = self;
        let (mut set, mut earlier) = (Vec::new(), Vec::new());
        for (index, part) in carried(parts, image, FrameDirection::ToDevice) {
            let Some(number) = part.number(image) else { continue };
            if part.counts.is_some() {
                let counter = &mut counters[index];
                let (never, stands) = (counter.runs.is_empty() && !counter.held, counter.last == Some(number));
                if !stands {
                    counter.since = now;
                }
                let Some(value) = counter.frame(part, number) else { continue };
                let changed = (part.path.clone(), value);
                if stands {
                    earlier.push(((!never).then_some(counter.since), vec![changed]));
                } else {
                    set.push(changed);
                }
            } else if last[index] != number {
                last[index] = number;
                set.push((part.path.clone(), part.value(number).text));
            }
        }
        (set, earlier)
    }

    /// Whether a sign of life that has begun does not advance by one in this frame, which has not been taken in yet.
    pub fn is_sign_of_life_wrong(&self, image: &ConnectionImage) -> bool {
        carried(&self.parts, image, FrameDirection::ToDevice).any(|(index, part)| {
            let last = self.counters[index].last.filter(|last| *last != 0);
            part.counts.is_some() && last.is_some_and(|last| part.next(last) != part.number(image))
        })
    }
}

impl SignOfLifeRuns {
    fn frame(&mut self, part: &CyclicName, number: i128) -> Option<String> {
        let Some(last) = self.last.replace(number) else {
            self.run = 1;
            return None;
        };
        if last == number {
            self.run += 1;
            let usual = self.usual();
            if self.held || self.run <= usual.unwrap_or(STANDS_STILL) {
                return None;
            }
            self.held = true;
            return Some(if usual.is_some() { "held".to_owned() } else { part.value(number).text });
        }
        if !self.held {
            self.runs.push(self.run);
            if self.runs.len() > LEARNT {
                self.runs.remove(0);
            }
        }
        self.run = 1;
        // The first number that counts follows the 0 of outputs that were not sent yet.
        if part.next(last) == Some(number) || last == 0 {
            let was_held = std::mem::take(&mut self.held);
            return was_held.then(|| "counting".to_owned());
        }
        self.held = true;
        Some(part.value(number).text)
    }

    /// The usual number of frames with the same number, if known.
    fn usual(&self) -> Option<u32> {
        self.runs.iter().copied().max().filter(|_| self.runs.len() >= LEARNT)
    }
}
