//! Gaps in cyclic frames, and which of them coincide with gaps of other senders.

use super::coverage::CapturePosition;
use super::text::span;
use station::Duration;

/// Upper limit of the gaps of one stream whose times are remembered.
const MOST_GAPS: usize = 256;
/// A counter that is wrong this often is wrong on purpose.
pub(super) const OFTEN: u64 = 3;

/// A position in a stream where frames are missing.
#[derive(Clone, Copy, Debug)]
pub(super) struct FrameGap {
    /// The frame before it.
    pub from: CapturePosition,
    /// The frame after it.
    pub to: CapturePosition,
    pub missing: u64,
}

impl FrameGap {
    pub fn length(&self) -> Duration {
        self.to.time.since(self.from.time)
    }

    fn meets(&self, other: &FrameGap) -> bool {
        other.from.time < self.to.time && self.from.time < other.to.time
    }
}

/// The gaps of a stream.
#[derive(Clone, Debug, Default)]
pub(super) struct GapList {
    gaps: Vec<FrameGap>,
    /// How many there are, remembered or not.
    count: u64,
}

impl GapList {
    /// Adds a gap; returns whether it is remembered and longer than all before it.
    pub fn add(&mut self, gap: FrameGap) -> bool {
        self.count += 1;
        let is_remembered = self.gaps.len() < MOST_GAPS;
        let is_longest = self.gaps.iter().all(|known| known.length() < gap.length());
        if is_remembered {
            self.gaps.push(gap);
        }
        is_remembered && is_longest
    }

    /// Forgets the gaps up to a frame.
    pub fn forget(&mut self, reported: u64) {
        self.gaps.retain(|gap| gap.to.frame > reported);
        self.count = self.gaps.len() as u64;
    }

    pub fn is_empty(&self) -> bool {
        self.gaps.is_empty()
    }

    pub fn longest(&self) -> Option<&FrameGap> {
        self.gaps.iter().max_by_key(|gap| gap.length())
    }

    /// How many gaps there are.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The number of missing frames in the gaps that are remembered.
    pub fn missing(&self) -> u64 {
        self.gaps.iter().map(|gap| gap.missing).sum()
    }

    /// How many coincide with a gap of `others`, if those are most of them: then the capture lost the frames.
    pub fn lost_by_capture<'g>(&self, others: impl Iterator<Item = &'g GapList> + Clone) -> Option<usize> {
        let is_shared = |gap: &&FrameGap| others.clone().flat_map(|of| &of.gaps).any(|other| gap.meets(other));
        let shared = self.gaps.iter().filter(is_shared).count();
        (shared * 2 > self.gaps.len()).then_some(shared)
    }

    /// What is missing of `frames` that were captured of `who`; `more` stands behind the frame of the longest gap.
    pub fn text(&self, longest: &FrameGap, (missing, frames): (u64, u64), who: &str, more: &str) -> String {
        format!(
            "{missing} of {} cyclic frames of {who} are missing in {} gaps; the longest gap lasts {} (frame {}{more})",
            frames + missing,
            self.count,
            span(longest.length()),
            longest.to.frame,
        )
    }
}
