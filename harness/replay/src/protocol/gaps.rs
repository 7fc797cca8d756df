//! Gaps in cyclic frames, and which of them coincide with gaps of other senders.

use super::advice::{PAUSED, advised};
use super::coverage::CapturePosition;
use super::table::{CAPTURE_GAP, CYCLE_LOST};
use super::text::span;
use crate::finding::{CaptureBlame, CaptureFinding, FindingSeverity};
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

/// What the findings on the gaps of a stream say.
pub(super) struct GapReport<'r> {
    /// The sender.
    pub who: &'r str,
    /// The frames that were captured of it.
    pub frames: u64,
    /// What stands behind the frame of the longest gap.
    pub more: &'r str,
    /// With whose gaps those of the capture coincide.
    pub others: &'static str,
    /// What follows from a gap that no other has, and who is to blame for it.
    pub alone: (&'static str, CaptureBlame),
}

/// The gaps of a stream by what lost the frames.
struct SplitGaps {
    /// Those of the capture.
    by_capture: GapList,
    /// How many of these coincide with gaps of others.
    coinciding: usize,
    /// Those that only other streams of the same station have.
    of_station: GapList,
    /// Those that no other stream has.
    alone: GapList,
}

/// The gaps of a stream.
#[derive(Clone, Debug, Default)]
pub(super) struct GapList {
    gaps: Vec<FrameGap>,
    /// Gaps that were forgotten last. Another stream may have the same one, and lose it a little later.
    forgotten: Vec<FrameGap>,
    /// How many there are, remembered or not, and how many frames are missing in them.
    count: u64,
    missing: u64,
}

impl From<Vec<FrameGap>> for GapList {
    fn from(gaps: Vec<FrameGap>) -> GapList {
        let missing = gaps.iter().map(|gap| gap.missing).sum();
        GapList { count: gaps.len() as u64, missing, gaps, forgotten: Vec::new() }
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
        let (gaps, forgotten) = self.gaps.drain(..).partition(|gap| gap.to.frame > reported);
        *self = GapList { forgotten, ..GapList::from(gaps) };
    }

    pub fn is_empty(&self) -> bool {
        self.gaps.is_empty()
    }

    /// Whether a gap of another stream may coincide with one of these, or with one that was just forgotten.
    pub fn is_comparable(&self) -> bool {
        !self.gaps.is_empty() || !self.forgotten.is_empty()
    }

    fn longest(&self) -> Option<&FrameGap> {
        self.gaps.iter().max_by_key(|gap| gap.length())
    }

    /// How bad it is if these frames were lost on the network: a frame or two may be.
    fn severity(&self) -> FindingSeverity {
        if self.missing > 2 { FindingSeverity::Warning } else { FindingSeverity::Info }
    }

    /// How many gaps there are.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Reports these gaps; those that coincide with a gap of `others` are gaps of the capture. `own` are the gaps of the other streams of
    /// this station.
    pub fn findings<'g>(
        &self,
        others: impl Iterator<Item = &'g GapList> + Clone,
        own: impl Iterator<Item = &'g GapList> + Clone,
        report: &GapReport<'_>,
    ) -> impl Iterator<Item = CaptureFinding> {
        let SplitGaps { by_capture, coinciding, of_station, alone } = self.split(others, own);
        let sent = report.frames + self.missing;
        let of_capture = by_capture.longest().map(|longest| {
            let text = format!(
                "{}; {coinciding} of these gaps coincide with gaps of other {}: the capture lost the frames",
                by_capture.text(longest, sent, report),
                report.others
            );
            CAPTURE_GAP.finding(FindingSeverity::Info, CaptureBlame::Capture, longest.to.frame, text)
        });
        let (whether, blame) = report.alone;
        let of_stream = alone.longest().map(|longest| {
            let text = format!("{}; {whether}", alone.text(longest, sent, report));
            CYCLE_LOST.finding(alone.severity(), blame, longest.to.frame, text)
        });
        let of_sender = of_station.longest().map(|longest| {
            let text = format!(
                "{}; only other streams of this station have gaps then: it paused, or its frames were lost on the way",
                of_station.text(longest, sent, report)
            );
            let finding = CYCLE_LOST.finding(of_station.severity(), CaptureBlame::Undecided, longest.to.frame, text);
            advised(finding, PAUSED)
        });
        of_capture.into_iter().chain(of_sender).chain(of_stream)
    }

    /// Separates the gaps that coincide with a gap of `others` from those that do not. If most do, all were lost by the capture: a
    /// recorder that does not keep up also loses single frames. Gaps that are not remembered count as the others.
    fn split<'g>(
        &self,
        others: impl Iterator<Item = &'g GapList> + Clone,
        own: impl Iterator<Item = &'g GapList> + Clone,
    ) -> SplitGaps {
        let (shared, rest) = self.partition(others);
        let coinciding = shared.gaps.len();
        if coinciding * 2 > self.gaps.len() {
            let none = GapList::default;
            return SplitGaps { by_capture: self.clone(), coinciding, of_station: none(), alone: none() };
        }
        let (of_station, alone) = rest.partition(own);
        SplitGaps { by_capture: shared, coinciding, of_station, alone }
    }

    /// The gaps that coincide with one of `others`, and the rest, to which those that are not remembered belong.
    fn partition<'g>(&self, others: impl Iterator<Item = &'g GapList> + Clone) -> (GapList, GapList) {
        let known = |of: &'g GapList| of.gaps.iter().chain(&of.forgotten);
        let is_shared = |gap: &&FrameGap| others.clone().flat_map(known).any(|other| gap.meets(other));
        let (shared, rest): (Vec<FrameGap>, Vec<FrameGap>) = self.gaps.iter().partition(is_shared);
        let shared = GapList::from(shared);
        let (count, missing) = (self.count - shared.count, self.missing - shared.missing);
        (shared, GapList { count, missing, ..rest.into() })
    }

    /// What is missing of the frames that were sent.
    fn text(&self, longest: &FrameGap, sent: u64, GapReport { who, more, .. }: &GapReport<'_>) -> String {
        format!(
            "{} of {sent} cyclic frames of {who} are missing in {} gaps; the longest gap lasts {} (frame {}{more})",
            self.missing,
            self.count,
            span(longest.length()),
            longest.to.frame,
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use station::Time;

    fn gap(from: u64, to: u64) -> FrameGap {
        let at = |frame: u64| CapturePosition { frame, time: Time::from_nanos(frame * 1_000), piece: 0 };
        FrameGap { from: at(from), to: at(to), missing: 3 }
    }

    fn of(gaps: &[FrameGap]) -> GapList {
        let mut list = GapList::default();
        for gap in gaps {
            list.add(*gap);
        }
        list
    }

    /// A watch forgets what is reported, of one stream a frame before the other.
    #[test]
    fn a_gap_that_is_forgotten_is_still_compared() {
        let (mut one, mut other) = (of(&[gap(10, 20)]), of(&[gap(11, 21)]));
        one.forget(20);
        other.forget(20);
        assert!(one.is_empty() && one.is_comparable() && !other.is_empty());
        let split = other.split([&one].into_iter(), [].into_iter());
        assert_eq!((split.by_capture.count(), split.coinciding, split.alone.count()), (1, 1, 0));
        one.forget(30);
        assert!(!one.is_comparable());
        assert_eq!(other.split([&one].into_iter(), [].into_iter()).alone.count(), 1);
    }

    /// A gap of the capture, one of all streams of the station, and two of this stream.
    #[test]
    fn each_gap_is_compared_for_itself() {
        let (other, own) = (of(&[gap(10, 20)]), of(&[gap(10, 20), gap(30, 40)]));
        let split =
            of(&[gap(10, 20), gap(30, 40), gap(50, 60), gap(70, 80)]).split([&other].into_iter(), [&own].into_iter());
        assert_eq!((split.by_capture.count(), split.of_station.count(), split.alone.count()), (1, 1, 2));
    }

    #[test]
    fn gaps_that_are_not_remembered_count_as_those_of_one_stream() {
        let many: Vec<FrameGap> = (0..2 * MOST_GAPS as u64).map(|at| gap(at * 10, at * 10 + 2)).collect();
        let split = of(&many).split([&of(&[gap(0, 3)])].into_iter(), [].into_iter());
        assert_eq!((split.by_capture.count(), split.by_capture.missing), (1, 3));
        assert_eq!((split.alone.count(), split.alone.missing), (511, 3 * 511));
    }
}
