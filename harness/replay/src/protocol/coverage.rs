//! What the capture can show: which stations it shows sending to which, and where it has holes.
//!
//! A check that reports something as missing asks here first whether the capture could have shown it.

use crate::finding::CaptureFinding;
use judge::observe::ArId;
use rustc_hash::{FxHashMap, FxHashSet};
use station::{Duration, Time};
use wire::ethernet::Mac;

/// Upper limit of the remembered pairs of stations; about others nothing is reported.
const MOST_PAIRS: usize = 65_536;
/// Upper limit of the findings of one check that are listed one by one.
const MOST_OF_A_CHECK: u64 = 100;
/// What follows the number of the findings of a check that are not listed.
pub(crate) const MORE_OF_A_CHECK: &str = " more findings of this check up to frame ";
/// A step back of the clock by more than this means that frames of two clocks follow each other.
const BACKWARDS: Duration = Duration::from_millis(5);
/// After a pause without any frame as long as this, a new recording or an interrupted one begins.
const ANOTHER: Duration = Duration::from_secs(60);

/// A position in the capture: the current frame, and the piece of the capture to which it belongs.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CapturePosition {
    /// Number of the frame, from 1.
    pub frame: u64,
    /// Its time.
    pub time: Time,
    /// Incremented at each hole; between two frames of the same piece no frame is known to be missing.
    pub piece: u32,
}

impl CapturePosition {
    /// The time since an earlier moment; `None` if there is a hole in between.
    pub fn since(&self, earlier: CapturePosition) -> Option<Duration> {
        (self.piece == earlier.piece).then(|| self.time.since(earlier.time))
    }
}

/// The senders and receivers that the capture shows.
#[derive(Clone, Debug, Default)]
pub(super) struct CaptureCoverage {
    pub now: CapturePosition,
    talks: FxHashSet<(Mac, Mac)>,
    senders: FxHashSet<Mac>,
    hearers: FxHashSet<Mac>,
    /// Whether there was a frame before.
    begun: bool,
}

impl CaptureCoverage {
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

    /// Notes a frame from `source` to `destination`; with a group address only the sender counts.
    pub fn note_frame(&mut self, source: Mac, destination: Mac) {
        if self.talks.len() < MOST_PAIRS {
            self.senders.insert(source);
            if !destination.is_group() {
                self.hearers.insert(destination);
                self.talks.insert((source, destination));
            }
        }
    }

    /// Whether the capture shows a frame from `source` to `destination`, so that it would show another one too.
    pub fn shows(&self, source: Mac, destination: Mac) -> bool {
        self.talks.contains(&(source, destination))
    }

    /// Whether the capture shows a frame to this station.
    pub fn shows_to(&self, destination: Mac) -> bool {
        self.hearers.contains(&destination)
    }

    /// Whether the capture shows a frame from this station.
    pub fn shows_from(&self, source: Mac) -> bool {
        self.senders.contains(&source)
    }
}

/// What a watch that never ends has reported and need not remember.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SettledFrames<'a> {
    /// What ended in this frame or before it was reported.
    pub reported: u64,
    /// What was last seen in this frame or before it is of no interest any more.
    pub old: u64,
    /// The connections whose ids later ones may get.
    pub forgotten: &'a [ArId],
}

impl SettledFrames<'_> {
    /// Whether a connection is not one of the forgotten ones.
    pub fn keeps(&self, ar: ArId) -> bool {
        !self.forgotten.contains(&ar)
    }
}

/// The findings so far, with an upper limit for each check.
#[derive(Clone, Debug, Default)]
pub(super) struct FindingList {
    list: Vec<CaptureFinding>,
    /// Frames whose neighbouring frames are still to be collected.
    news: Vec<u64>,
    seen: FxHashMap<String, (u64, u64, usize)>,
}

impl FindingList {
    /// Notes a frame that may turn out to have a finding.
    pub fn note(&mut self, frame: u64) {
        self.news.push(frame);
    }

    /// The frames that were noted since the last call.
    pub fn noted_frames(&mut self) -> impl Iterator<Item = u64> {
        self.news.drain(..)
    }

    /// Adds a finding.
    pub fn add(&mut self, finding: CaptureFinding) {
        let (seen, last, place) = self.seen.entry(finding.id.clone()).or_default();
        *seen += 1;
        *last = (*last).max(finding.frame);
        if *seen <= MOST_OF_A_CHECK {
            *place = self.list.len();
            self.news.push(finding.frame);
            self.list.push(finding);
        }
    }

    /// Whether there is no finding.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// The findings since the last call, which do not wait for the end.
    pub fn take(&mut self) -> Vec<CaptureFinding> {
        self.seen.clear();
        std::mem::take(&mut self.list)
    }

    /// All findings; the last one of a check says how many more there are.
    pub fn end(mut self) -> Vec<CaptureFinding> {
        for (seen, last, place) in self.seen.into_values().filter(|(seen, ..)| *seen > MOST_OF_A_CHECK) {
            if let Some(finding) = self.list.get_mut(place) {
                finding.text += &format!(" (and {}{MORE_OF_A_CHECK}{last})", seen - MOST_OF_A_CHECK);
            }
        }
        self.list
    }
}
