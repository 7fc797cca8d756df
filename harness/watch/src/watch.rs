//! The monitor: frames in; findings, incidents and counts out.

use crate::counts::WatchCounts;
use crate::incident::IncidentOrder;
use crate::line::{WatchLine, text_line};
use crate::ring::DiskRing;
use replay::utc;
use replay::{LiveFinding, LiveReplay};
use station::{Duration, Time};
use std::collections::{BTreeMap, VecDeque};
use suite::device::Bus;
use suite::model::Manual;
use virtual_wire::capture::{CapturedPacket, LinkType};

/// An incident begins so long before its finding.
const BEFORE: Duration = Duration::from_secs(30);
/// An incident ends so long after its last finding.
const AFTER: Duration = Duration::from_secs(10);
/// An incident with many findings ends after this time; the next finding begins another one.
const LONGEST: Duration = Duration::from_secs(120);
/// Losses are reported at once, and further ones after this time.
const LOSSES: Duration = Duration::from_secs(10);
/// If the kernel loses frames twice within this time, frames are kept and not judged until it has lost none for as long: to begin afresh
/// after each loss takes more time than the frames, and a watch that is behind would stay behind.
const SETTLES: Duration = Duration::from_millis(50);
/// Findings that the screen shows.
const MOST_RECENT: usize = 12;

/// A permanent monitor.
pub struct LiveWatch<'a> {
    replay: LiveReplay<'a>,
    counts: WatchCounts,
    ring: Option<DiskRing>,
    number: u64,
    first: Option<Time>,
    last: Time,
    open: Option<OpenIncident>,
    recent: VecDeque<String>,
    /// Frames lost by the kernel, by the ring and by this watch that were not reported yet, and when the last ones were.
    losses: [(u64, Option<Time>); 3],
    /// Whether the kernel lost frames before the next one, and the time of the last one after a loss.
    has_lost: bool,
    last_loss: Option<Time>,
    /// Whether frames are not judged, so that the watch catches up.
    is_behind: bool,
    seen_ring_losses: u64,
}

#[derive(Debug)]
struct OpenIncident {
    order: IncidentOrder,
    begun: Time,
}

impl<'a> LiveWatch<'a> {
    /// Judges by the rules of `manuals` and keeps the frames in `ring`, if there is one.
    pub fn new(manuals: &'a [Manual], ring: Option<DiskRing>) -> LiveWatch<'a> {
        LiveWatch {
            replay: LiveReplay::new(manuals),
            counts: WatchCounts::default(),
            ring,
            number: 0,
            first: None,
            last: Time::ZERO,
            open: None,
            recent: VecDeque::new(),
            losses: [(0, None); 3],
            has_lost: false,
            last_loss: None,
            is_behind: false,
            seen_ring_losses: 0,
        }
    }

    /// Takes in a frame of `original` bytes, of which `octets` were received; `time` is since 1970.
    pub fn frame(&mut self, time: Time, link: LinkType, octets: &[u8], original: u32) {
        self.number += 1;
        self.first.get_or_insert(time);
        self.last = time;
        let is_skipped = self.note_losses(time);
        let LiveWatch { replay, counts, ring, number, .. } = self;
        let bus = if link == LinkType::PROFIBUS { Bus::Profibus } else { Bus::Profinet };
        counts.frame(bus, time, original as usize);
        if let Some(ring) = ring {
            ring.frame(*number, time, link, octets, original);
        }
        if is_skipped {
            counts.not_judged += 1;
            self.losses[2].0 += 1;
            return replay.skip(*number, time);
        }
        let packet = CapturedPacket {
            number: *number as usize,
            time,
            section: 1,
            interface: 0,
            link_type: link,
            captured: octets,
            original_length: original,
            comment: None,
        };
        replay.frame(&packet, &mut |bus, ars, time, observation| counts.observe(bus, ars, time, observation));
    }

    /// Notes whether the watch is behind at this frame; returns whether it is left out, so that the watch catches up. The one that shows that
    /// it is behind still is judged.
    fn note_losses(&mut self, time: Time) -> bool {
        let was_behind = self.is_behind;
        let is_settling = self.last_loss.is_some_and(|last| time < last + SETTLES);
        if std::mem::take(&mut self.has_lost) {
            self.is_behind = is_settling;
            self.last_loss = Some(time);
        } else if was_behind && !is_settling {
            self.is_behind = false;
            self.counts.interrupt();
        }
        was_behind && self.is_behind
    }

    /// Frames were lost before the next one, and are not judged.
    pub fn lost(&mut self, frames: u64) {
        self.has_lost = true;
        self.counts.lost_by_kernel += frames;
        self.losses[0].0 += frames;
        self.replay.interrupt();
        self.counts.interrupt();
    }

    /// The source stood still, or its clock was set: nothing is measured across it.
    pub fn interrupt(&mut self) {
        self.replay.interrupt();
        self.counts.interrupt();
    }

    /// Whether [`tick`](Self::tick) has something to do.
    #[inline]
    pub fn is_due(&self, now: Time) -> bool {
        self.replay.is_due(now)
    }

    /// The time of the last frame.
    pub fn last(&self) -> Time {
        self.last
    }

    /// What happened since the last call. To be called twice a second, when no frame before `now` is left to be taken in.
    pub fn tick(&mut self, now: Time) -> Vec<WatchLine> {
        let LiveWatch { replay, counts, .. } = self;
        let found =
            replay.evaluate(now, &mut |bus, ars, time, observation| counts.observe(bus, ars, time, observation));
        self.take(found, now)
    }

    fn take(&mut self, found: Vec<LiveFinding>, now: Time) -> Vec<WatchLine> {
        let mut lines = Vec::new();
        for finding in &found {
            lines.push(self.finding(finding, now));
        }
        if self.open.as_ref().is_some_and(|open| now >= open.order.until) {
            self.save();
        }
        if let Some(ring) = &mut self.ring {
            ring.pass_on();
            self.losses[1].0 += ring.lost() - self.seen_ring_losses;
            self.seen_ring_losses = ring.lost();
            self.counts.lost_by_ring = ring.lost();
            lines.extend(ring.lines());
        }
        lines.extend(self.lost_lines(now, LOSSES));
        self.counts.incidents += lines.iter().filter(|line| matches!(line, WatchLine::Incident { .. })).count() as u64;
        for line in &lines {
            self.recent.push_back(text_line(line));
        }
        while self.recent.len() > MOST_RECENT {
            self.recent.pop_front();
        }
        lines
    }

    fn lost_lines(&mut self, now: Time, pace: Duration) -> Vec<WatchLine> {
        let mut lines = Vec::new();
        for ((frames, reported), by) in self.losses.iter_mut().zip(["kernel", "ring", "watch"]) {
            if *frames > 0 && reported.is_none_or(|reported| now >= reported + pace) {
                let frames = std::mem::take(frames);
                *reported = Some(now);
                lines.push(WatchLine::Lost { wall_clock: utc(now), blame: "capture", by, frames });
            }
        }
        lines
    }

    /// The line of a finding, which begins an incident or belongs to the present one.
    fn finding(&mut self, found: &LiveFinding, now: Time) -> WatchLine {
        self.counts.finding(&found.finding);
        let first = self.first.unwrap_or_default();
        if self.ring.is_none() {
            return WatchLine::finding(found, first, None);
        }
        if self.open.as_ref().is_some_and(|open| now >= open.begun + LONGEST) {
            self.save();
        }
        let open = self.open.get_or_insert_with(|| {
            let stamp = utc(found.time).replace(['-', ':'], "").replace('.', "-");
            let id: String =
                found.finding.id.chars().map(|of| if of.is_ascii_alphanumeric() { of } else { '-' }).take(60).collect();
            OpenIncident {
                order: IncidentOrder {
                    name: format!("incident-{stamp}-{id}.pcapng"),
                    from: found.time,
                    until: now,
                    comments: BTreeMap::new(),
                },
                begun: now,
            }
        });
        let order = &mut open.order;
        let before = Time::from_nanos(found.time.as_nanos().saturating_sub(BEFORE.as_nanos() as u64));
        order.from = order.from.min(before);
        order.until = (now + AFTER).min(open.begun + LONGEST + AFTER);
        let finding = &found.finding;
        let text = format!("{} (blame: {}): {}", finding.id, finding.blame.word(), finding.text);
        let comment = order.comments.entry(finding.frame).or_default();
        if !comment.is_empty() {
            comment.push('\n');
        }
        comment.push_str(&text);
        let name = order.name.clone();
        WatchLine::finding(found, first, Some(name))
    }

    fn save(&mut self) {
        if let (Some(open), Some(ring)) = (self.open.take(), &mut self.ring) {
            ring.save(open.order);
        }
    }

    /// Begins new files.
    pub fn rotate(&mut self) {
        if let Some(ring) = &mut self.ring {
            ring.rotate();
        }
    }

    /// Passes the frames so far to the disk.
    pub fn pass_on(&mut self) {
        if let Some(ring) = &mut self.ring {
            ring.pass_on();
        }
    }

    pub fn counts(&self) -> &WatchCounts {
        &self.counts
    }

    pub fn counts_mut(&mut self) -> &mut WatchCounts {
        &mut self.counts
    }

    /// The last lines in words, the oldest first.
    pub fn recent(&self) -> impl Iterator<Item = &str> {
        self.recent.iter().map(String::as_str)
    }

    /// Ends the watch: judges what is left and saves the incident that is open.
    pub fn end(mut self) -> (Vec<WatchLine>, WatchCounts) {
        let replay = std::mem::replace(&mut self.replay, LiveReplay::new(&[]));
        let counts = &mut self.counts;
        let found = replay.end(&mut |bus, ars, time, observation| counts.observe(bus, ars, time, observation));
        let now = self.last;
        let mut lines = self.take(found, now);
        self.save();
        if let Some(ring) = self.ring.take() {
            let left = ring.end();
            self.counts.incidents +=
                left.iter().filter(|line| matches!(line, WatchLine::Incident { .. })).count() as u64;
            lines.extend(left);
        }
        lines.extend(self.lost_lines(now, Duration::ZERO));
        let findings = self.counts.findings.values().sum();
        lines.push(WatchLine::Ended { wall_clock: utc(now), frames: self.counts.frames, findings });
        (lines, self.counts)
    }
}
