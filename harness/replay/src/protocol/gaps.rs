//! Gaps in cyclic frames, and which of them coincide with gaps of other senders.

use super::coverage::CapturePosition;
use super::text::span;
use crate::finding::FindingSeverity;
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

/// The gaps of a stream by what lost the frames.
pub(super) struct SplitGaps {
    /// Those of the capture.
    pub by_capture: GapList,
    /// How many of these coincide with gaps of others.
    pub coinciding: usize,
    /// Those that no other stream has.
    pub alone: GapList,
}

/// The gaps of a stream.
#[derive(Clone, Debug, Default)]
pub(super) struct GapList {
    gaps: Vec<FrameGap>,
    /// How many there are, remembered or not, and how many frames are missing in them.
    count: u64,
    missing: u64,
}

impl From<Vec<FrameGap>> for GapList {
    fn from(gaps: Vec<FrameGap>) -> GapList {
        GapList { count: gaps.len() as u64, missing: gaps.iter().map(|gap| gap.missing).sum(), gaps }
    }
}

impl GapList {
    /// Adds a gap; returns whether it is remembered and longer than all before it.
    pub fn add(&mut self, gap: FrameGap) -> bool {
        (self.count, self.missing) = (self.count + 1, self.missing + gap.missing);
        let is_remembered = self.gaps.len() < MOST_GAPS;
        let is_longest = self.gaps.iter().all(|known| known.length() < gap.length());
        if is_remembered {
            self.gaps.push(gap);
        }
        is_remembered && is_longest
    }

    /// Forgets the gaps up to a frame.
    pub fn forget(&mut self, reported: u64) {
        let mut gaps = std::mem::take(&mut self.gaps);
        gaps.retain(|gap| gap.to.frame > reported);
        *self = gaps.into();
    }

    pub fn is_empty(&self) -> bool {
        self.gaps.is_empty()
    }

    pub fn longest(&self) -> Option<&FrameGap> {
        self.gaps.iter().max_by_key(|gap| gap.length())
    }

    /// How bad it is if these frames were lost on the network: a frame or two may be.
    pub fn severity(&self) -> FindingSeverity {
        if self.missing > 2 { FindingSeverity::Warning } else { FindingSeverity::Info }
    }

    /// How many gaps there are.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// How many frames are missing.
    pub fn missing(&self) -> u64 {
        self.missing
    }

    /// Tells the gaps that coincide with a gap of `others` from those that do not. If most do, all were lost by the capture: a recorder
    /// that does not keep up also loses single frames.
    pub fn split<'g>(&self, others: impl Iterator<Item = &'g GapList> + Clone) -> SplitGaps {
        let is_shared = |gap: &&FrameGap| others.clone().flat_map(|of| &of.gaps).any(|other| gap.meets(other));
        let (shared, alone): (Vec<FrameGap>, Vec<FrameGap>) = self.gaps.iter().partition(is_shared);
        let coinciding = shared.len();
        match coinciding {
            0 => SplitGaps { by_capture: GapList::default(), coinciding, alone: self.clone() },
            _ if coinciding * 2 > self.gaps.len() => {
                SplitGaps { by_capture: self.clone(), coinciding, alone: GapList::default() }
            }
            _ => SplitGaps { by_capture: shared.into(), coinciding, alone: alone.into() },
        }
    }

    /// What is missing of the frames that `who` has `sent`; `more` stands behind the frame of the longest gap.
    pub fn text(&self, longest: &FrameGap, sent: u64, who: &str, more: &str) -> String {
        format!(
            "{} of {sent} cyclic frames of {who} are missing in {} gaps; the longest gap lasts {} (frame {}{more})",
            self.missing,
            self.count,
            span(longest.length()),
            longest.to.frame,
        )
    }
}
