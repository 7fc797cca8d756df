//! Which cyclic frames a receiver accepts: right length and addresses (the tracker sees to that), TransferStatus 0, valid data, and a
//! cycle counter that advances by 1 to 61440 (IEC 61158-6-10, consumer protocol machine).

use super::coverage::{CapturePosition, SettledFrames};
use judge::observe::{ArId, FrameDirection};
use station::Duration;
use std::collections::BTreeSet;
use wire::profinet::rt::ApduStatus;

/// The largest advance of the cycle counter that a receiver takes for a new frame.
const MOST_STEPS: u16 = 61_440;
/// A pause this long is remembered; no watchdog is shorter than three cycles of 31.25 us.
const PAUSE: Duration = Duration::from_micros(94);

/// The frames of one direction that its receiver accepts.
#[derive(Clone, Copy, Debug, Default)]
struct AcceptedDirection {
    last: Option<(CapturePosition, u16)>,
    /// The frame since which none was accepted, and why.
    refused: Option<(u64, &'static str)>,
    /// The last long pauses between two accepted frames, and when they ended: the longest of late.
    pause: Option<(Duration, CapturePosition)>,
}

/// The accepted frames of all connections.
#[derive(Clone, Debug, Default)]
pub(super) struct AcceptedFrames {
    directions: Vec<[AcceptedDirection; 2]>,
    /// The connections with a silence longer than their watchdog: of later frames it is not known whether they were accepted.
    starved: BTreeSet<ArId>,
}

impl AcceptedFrames {
    /// Takes in a frame of a connection.
    #[inline]
    pub fn take(&mut self, now: CapturePosition, ArId(index): ArId, direction: FrameDirection, status: &ApduStatus) {
        let index = index as usize;
        if self.directions.len() <= index {
            self.directions.resize(index + 1, <[AcceptedDirection; 2]>::default());
        }
        self.directions[index][direction as usize].take(now, status);
    }

    /// Notes that a direction of a connection was silent for longer than its watchdog.
    pub fn starve(&mut self, ar: ArId) {
        self.starved.insert(ar);
    }

    /// Whether a direction of a connection was silent for longer than its watchdog.
    pub fn is_starved(&self, ar: ArId) -> bool {
        self.starved.contains(&ar)
    }

    /// Forgets the frames of connections whose ids later ones may get.
    pub fn forget(&mut self, settled: SettledFrames<'_>) {
        self.starved.retain(|ar| settled.keeps(*ar));
        for (index, directions) in self.directions.iter_mut().enumerate() {
            if !settled.keeps(ArId(index as u32)) {
                *directions = <[AcceptedDirection; 2]>::default();
            }
        }
    }

    fn of(&self, ArId(index): ArId, direction: FrameDirection) -> Option<&AcceptedDirection> {
        self.directions.get(index as usize).map(|of| &of[direction as usize])
    }

    /// The last accepted frame.
    pub fn last(&self, ar: ArId, direction: FrameDirection) -> Option<CapturePosition> {
        self.of(ar, direction)?.last.map(|(last, _)| last)
    }

    /// The frame since which none was accepted, and why; `None` while frames are accepted.
    pub fn unacceptable(&self, ar: ArId, direction: FrameDirection) -> Option<(u64, &'static str)> {
        self.of(ar, direction)?.refused
    }

    /// A pause longer than `limit` between accepted frames that ended within that time before `now`.
    pub fn pause_before(
        &self,
        ar: ArId,
        direction: FrameDirection,
        now: CapturePosition,
        limit: Duration,
    ) -> Option<Duration> {
        let (pause, ended) = self.of(ar, direction)?.pause?;
        let is_near = now.since(ended).is_some_and(|since| since <= limit * 2);
        (is_near && pause > limit).then_some(pause)
    }
}

impl AcceptedDirection {
    #[inline]
    fn take(&mut self, now: CapturePosition, status: &ApduStatus) {
        match self.why_not(status) {
            None => {
                if let Some((last, _)) = self.last
                    && let Some(pause) = now.since(last)
                    && pause > PAUSE
                {
                    // A later pause replaces a longer one that is long over.
                    let is_over = |(longest, ended): (Duration, CapturePosition)| {
                        now.since(ended).is_none_or(|since| since > longest * 2)
                    };
                    if self.pause.is_none_or(|(longest, ended)| pause >= longest || is_over((longest, ended))) {
                        self.pause = Some((pause, now));
                    }
                }
                self.last = Some((now, status.cycle_counter));
                self.refused = None;
            }
            Some(why) => {
                self.refused.get_or_insert((now.frame, why));
            }
        }
    }

    #[inline]
    fn why_not(&self, status: &ApduStatus) -> Option<&'static str> {
        if status.transfer_status != 0 {
            return Some("TransferStatus is not 0");
        }
        if !status.data_status.is_valid() {
            return Some("DataStatus says that the data are invalid");
        }
        match self.last {
            Some((_, last)) => match status.cycle_counter.wrapping_sub(last) {
                1..=MOST_STEPS => None,
                _ => Some("the cycle counter does not advance"),
            },
            None => None,
        }
    }
}
