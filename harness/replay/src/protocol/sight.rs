//! What the capture can show at all: who was seen to send to whom, and where it has holes.
//!
//! Whoever claims that something did not come asks here first whether it could have been seen.

use crate::finding::Finding;
use rustc_hash::{FxHashMap, FxHashSet};
use station::{Duration, Time};
use wire::ethernet::Mac;

/// Pairs of stations that are remembered; of others nothing is claimed.
const MOST_PAIRS: usize = 65_536;
/// Findings of one check that are told one by one.
const MOST_OF_A_CHECK: u64 = 100;
/// A step back of the clock by more than this says that frames of two clocks follow each other.
const BACKWARDS: Duration = Duration::from_millis(5);
/// Where no frame at all comes for so long, what follows is another recording, or a recording that was interrupted.
const ANOTHER: Duration = Duration::from_secs(60);

/// Where the capture is: the frame that is looked at, and which piece of the capture it belongs to.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Now {
    /// Number of the frame, from 1.
    pub frame: u64,
    /// Its time.
    pub time: Time,
    /// Goes up at each hole; between two frames of the same piece nothing that is known of is missing.
    pub piece: u32,
}

impl Now {
    /// The time since an earlier moment; `None` where a hole lies in between.
    pub fn since(&self, earlier: Now) -> Option<Duration> {
        (self.piece == earlier.piece).then(|| self.time.since(earlier.time))
    }
}

/// What was seen of the stations.
#[derive(Debug, Default)]
pub(super) struct Sight {
    pub now: Now,
    talks: FxHashSet<(Mac, Mac)>,
    senders: FxHashSet<Mac>,
    hearers: FxHashSet<Mac>,
    /// Whether a frame was seen before.
    begun: bool,
}

impl Sight {
    /// A frame begins.
    pub fn frame(&mut self, frame: u64, time: Time) {
        if self.begun && (time + BACKWARDS < self.now.time || time > self.now.time + ANOTHER) {
            self.now.piece += 1;
        }
        self.begun = true;
        (self.now.frame, self.now.time) = (frame, time);
    }

    /// Frames may be missing here.
    pub fn hole(&mut self) {
        self.now.piece += 1;
    }

    /// Who sent to whom; group addresses count for the sender only.
    pub fn seen(&mut self, source: Mac, destination: Mac) {
        if self.talks.len() < MOST_PAIRS {
            self.senders.insert(source);
            if !destination.is_group() {
                self.hearers.insert(destination);
                self.talks.insert((source, destination));
            }
        }
    }

    /// Whether a frame from one to the other was seen, so that another one would have been seen too.
    pub fn shows(&self, source: Mac, destination: Mac) -> bool {
        self.talks.contains(&(source, destination))
    }

    /// Whether a frame to this station was seen.
    pub fn shows_to(&self, destination: Mac) -> bool {
        self.hearers.contains(&destination)
    }

    /// Whether a frame from this station was seen.
    pub fn shows_from(&self, source: Mac) -> bool {
        self.senders.contains(&source)
    }
}

/// The findings so far, a bounded number of each check.
#[derive(Debug, Default)]
pub(super) struct Told {
    list: Vec<Finding>,
    /// Frames whose surroundings are of interest and have not been kept yet.
    news: Vec<u64>,
    seen: FxHashMap<String, (u64, u64, usize)>,
}

impl Told {
    /// Something in this frame may turn out to be wrong.
    pub fn note(&mut self, frame: u64) {
        self.news.push(frame);
    }

    /// The frames that were noted since the last call.
    pub fn news(&mut self) -> impl Iterator<Item = u64> {
        self.news.drain(..)
    }

    /// Takes in a finding.
    pub fn add(&mut self, finding: Finding) {
        let (seen, last, place) = self.seen.entry(finding.id.clone()).or_default();
        *seen += 1;
        *last = (*last).max(finding.frame);
        if *seen <= MOST_OF_A_CHECK {
            *place = self.list.len();
            self.news.push(finding.frame);
            self.list.push(finding);
        }
    }

    /// Whether nothing was found so far.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// All findings; the last one of a check says how many more there were.
    pub fn end(mut self) -> Vec<Finding> {
        for (seen, last, place) in self.seen.into_values().filter(|(seen, ..)| *seen > MOST_OF_A_CHECK) {
            if let Some(finding) = self.list.get_mut(place) {
                finding.text +=
                    &format!(" (and {} more findings of this kind up to frame {last})", seen - MOST_OF_A_CHECK);
            }
        }
        self.list
    }
}
