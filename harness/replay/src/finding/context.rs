//! The frames around a finding. The last frames are kept as bytes in a ring of fixed size and described in words only where a
//! finding needs them.
//!
//! This module must not know what is wrong, only where.

use super::super::clock::{CaptureClock, wall_clock};
use super::CaptureFinding;
use super::times::FrameTimes;
use judge::observe::{ArId, ObservedAr, ProfibusWords, describe};
use plain_text::printable;
use serde::Serialize;
use station::Time;
use std::collections::{BTreeMap, VecDeque};
use suite::device::Bus;
use wire::ethernet::{FrameHeader, Mac};
use wire::profibus::fdl::FdlFrame;

/// Frames of the same connection before and after the frame of the finding.
const AROUND: usize = 4;
/// Bytes of the ring of frames; it holds tens of thousands of cyclic frames.
const ROOM: usize = 1 << 20;
/// Upper limit of the frames searched for those of the same connection, in either direction.
const MOST_LOOKED_THROUGH: usize = 4_096;
/// Upper limit of the findings whose frames are kept.
const MOST_FINDINGS: usize = 1_000;

/// The frames of the same connection around a finding.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FindingContext {
    /// The frames before it, the oldest first; the frame that triggered it comes first if it is further away.
    pub before: Vec<ContextFrame>,
    /// Its own frame; `None` if that was not kept.
    pub at: Option<ContextFrame>,
    /// The frames after it.
    pub after: Vec<ContextFrame>,
}

/// A frame of the capture in words.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ContextFrame {
    /// The number of the packet, from 1.
    pub frame: u64,
    /// Seconds since the first frame of the same recording; negative where the clock stepped back.
    pub time: f64,
    /// Its time in the calendar, RFC 3339 in UTC, if the clock of the recorder was set.
    pub wall_clock: Option<String>,
    /// Its contents as `encspec dissect` shows them, escaped; several lines on PROFIBUS.
    pub text: String,
}

/// The last frames of a capture, and the frames around the findings so far.
#[derive(Debug, Default)]
pub(crate) struct ContextCollector {
    ring: FrameRing,
    pub times: FrameTimes,
    wanted: BTreeMap<u64, PendingContext>,
    /// The findings that still wait for frames after them.
    open: Vec<u64>,
}

/// The frames around one finding.
#[derive(Debug)]
struct PendingContext {
    ar: Option<ArId>,
    ends: FrameEnds,
    context: FindingContext,
    words: ProfibusWords,
    /// The stations of the frame before, for an answer without addresses.
    before: FrameEnds,
    patience: usize,
}

impl ContextCollector {
    /// Remembers a frame, before it is checked.
    pub fn keep(&mut self, bus: Bus, number: u64, time: Time, octets: &[u8]) {
        self.times.take(number, time);
        self.ring.push(bus, number, time, octets);
    }

    /// Whether findings wait for frames after them.
    pub fn is_waiting(&self) -> bool {
        !self.open.is_empty()
    }

    /// Adds the last frame to the earlier findings that wait for it.
    pub fn fill(&mut self, ars: &[ObservedAr]) {
        let Some(entry) = self.ring.entries.back().copied() else { return };
        let ContextCollector { ring, times, wanted, open } = self;
        open.retain(|number| {
            let Some(of) = wanted.get_mut(number).filter(|_| *number < entry.number) else { return true };
            let octets = ring.octets(&entry);
            let ends = FrameEnds::of(entry.bus, octets, of.before);
            let lines = (entry.bus.is_profibus()).then(|| of.words.lines(octets));
            if of.ends.meet(ends) {
                let text = lines.map_or_else(|| describe(octets, ars), |lines| lines.join("\n"));
                of.context.after.push(context_frame(&times.clock, &entry, &text));
            }
            of.before = ends;
            of.patience -= 1;
            of.context.after.len() < AROUND && of.patience > 0
        });
    }

    /// Keeps the frames around the frame of a finding; `trigger` is the frame that triggered it.
    pub fn collect(&mut self, frame: u64, trigger: Option<u64>, ar: Option<ArId>, ars: &[ObservedAr]) {
        if let Some(known) = self.wanted.get_mut(&frame) {
            known.ar = known.ar.or(ar);
            return;
        }
        let Some(at) = self.ring.find(frame) else { return };
        if let Some(entry) = self.ring.entries.get(at) {
            self.times.note(frame, entry.time);
        }
        if self.wanted.len() >= MOST_FINDINGS {
            return;
        }
        let ends_at = |index: usize| self.ring.ends(index);
        let ends = ends_at(at);
        let mut chosen: Vec<usize> = (at.saturating_sub(MOST_LOOKED_THROUGH)..at)
            .rev()
            .filter(|&index| ends.meet(ends_at(index)))
            .take(AROUND)
            .collect();
        let began = trigger.and_then(|trigger| self.ring.find(trigger)).filter(|began| *began < at);
        chosen.extend(began.filter(|began| !chosen.contains(began)));
        chosen.sort_unstable();
        let mut words = ProfibusWords::default();
        let mut context = FindingContext::default();
        // To describe an answer the request before it has to be known.
        let from = chosen.first().copied().unwrap_or(at).saturating_sub(1);
        for index in from..=at {
            let Some(entry) = self.ring.entries.get(index) else { continue };
            let octets = self.ring.octets(entry);
            let lines = (entry.bus.is_profibus()).then(|| words.lines(octets));
            if index == at || chosen.contains(&index) {
                let text = lines.map_or_else(|| describe(octets, ars), |lines| lines.join("\n"));
                let described = context_frame(&self.times.clock, entry, &text);
                if index == at { context.at = Some(described) } else { context.before.push(described) }
            }
        }
        let later: Vec<RingEntry> = self.ring.entries.iter().skip(at + 1).copied().collect();
        let mut wanted = PendingContext { ar, ends, context, words, before: ends, patience: MOST_LOOKED_THROUGH };
        // The finding may have come later than its frame.
        for entry in later.iter().take(MOST_LOOKED_THROUGH) {
            let octets = self.ring.octets(entry);
            let ends = FrameEnds::of(entry.bus, octets, wanted.before);
            let lines = (entry.bus.is_profibus()).then(|| wanted.words.lines(octets));
            if wanted.context.after.len() < AROUND && wanted.ends.meet(ends) {
                let text = lines.map_or_else(|| describe(octets, ars), |lines| lines.join("\n"));
                wanted.context.after.push(context_frame(&self.times.clock, entry, &text));
            }
            wanted.before = ends;
        }
        if wanted.context.after.len() < AROUND {
            self.open.push(frame);
        }
        self.wanted.insert(frame, wanted);
    }

    /// Adds the frames around a finding, its connection and its time, as far as they are known; `ars` are those of its bus.
    pub fn complete(&mut self, finding: &mut CaptureFinding, ars: &[ObservedAr]) {
        self.collect(finding.frame, None, None, ars);
        if let Some((context, ar)) = self.of(finding.frame) {
            finding.context = context.clone();
            finding.ar = finding.ar.or(ar.map(|ar| ar.0 as usize));
        }
        if let Some(time) = self.times.of(finding.frame) {
            (finding.time, finding.wall_clock) = (Some(self.times.clock.seconds(time)), wall_clock(time));
        }
    }

    /// Forgets the findings up to a frame.
    pub fn forget(&mut self, reported: u64) {
        self.wanted.retain(|frame, _| *frame > reported);
        self.open.retain(|frame| *frame > reported);
    }

    /// The frames around a frame and its connection, as far as they were kept.
    pub fn of(&self, frame: u64) -> Option<(&FindingContext, Option<ArId>)> {
        self.wanted.get(&frame).map(|of| (&of.context, of.ar))
    }
}

fn context_frame(clock: &CaptureClock, entry: &RingEntry, text: &str) -> ContextFrame {
    let text = text.lines().map(printable).collect::<Vec<_>>().join("\n");
    let (time, wall_clock) = (clock.seconds(entry.time), wall_clock(entry.time));
    ContextFrame { frame: entry.number, time, wall_clock, text }
}

/// The stations between which a frame goes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum FrameEnds {
    /// Not known.
    #[default]
    Unknown,
    /// Two Ethernet stations; the second may be a group address.
    Macs(Mac, Mac),
    /// Two PROFIBUS stations.
    Stations(u8, u8),
    /// The PROFIBUS token.
    Token,
}

impl FrameEnds {
    fn of(bus: Bus, octets: &[u8], before: FrameEnds) -> FrameEnds {
        match bus {
            Bus::Profinet => FrameHeader::parse(octets)
                .map_or(FrameEnds::Unknown, |(header, _)| FrameEnds::Macs(header.source, header.destination)),
            Bus::Profibus => match FdlFrame::parse(octets) {
                Ok(FdlFrame::Data(frame)) => FrameEnds::Stations(frame.sa, frame.da),
                Ok(FdlFrame::ShortAcknowledgement) => before,
                Ok(FdlFrame::Token { .. }) => FrameEnds::Token,
                Err(_) => FrameEnds::Unknown,
            },
        }
    }

    /// Whether two frames belong to the same conversation.
    fn meet(self, other: FrameEnds) -> bool {
        match (self, other) {
            (FrameEnds::Macs(one, two), FrameEnds::Macs(three, four)) => {
                if two.is_group() || four.is_group() {
                    one == three || !two.is_group() && two == three || !four.is_group() && one == four
                } else {
                    (one, two) == (three, four) || (one, two) == (four, three)
                }
            }
            (FrameEnds::Stations(one, two), FrameEnds::Stations(three, four)) => {
                (one, two) == (three, four) || (one, two) == (four, three)
            }
            (FrameEnds::Token, FrameEnds::Token) => true,
            _ => false,
        }
    }
}

/// A frame in the ring.
#[derive(Clone, Copy, Debug)]
struct RingEntry {
    number: u64,
    time: Time,
    start: u32,
    length: u32,
    bus: Bus,
}

/// The last frames, the oldest first; the bytes of a frame are contiguous.
#[derive(Debug, Default)]
struct FrameRing {
    octets: Vec<u8>,
    entries: VecDeque<RingEntry>,
    head: usize,
}

impl FrameRing {
    fn push(&mut self, bus: Bus, number: u64, time: Time, octets: &[u8]) {
        let Some(octets) = octets.get(..octets.len().min(ROOM)) else { return };
        let needed = self.head + octets.len();
        if needed > self.octets.len() && self.octets.len() < ROOM {
            // A short capture needs little memory.
            self.octets.resize((self.octets.len() * 2).max(needed).min(ROOM), 0);
        }
        if needed > self.octets.len() {
            // The frames after the head are the oldest.
            while self.entries.front().is_some_and(|first| first.start as usize >= self.head) {
                self.entries.pop_front();
            }
            self.head = 0;
        }
        let end = self.head + octets.len();
        let meets = |first: &RingEntry| (self.head..end.max(self.head + 1)).contains(&(first.start as usize));
        while self.entries.front().is_some_and(meets) {
            self.entries.pop_front();
        }
        if let Some(space) = self.octets.get_mut(self.head..end) {
            space.copy_from_slice(octets);
        }
        let (start, length) = (self.head as u32, octets.len() as u32);
        self.entries.push_back(RingEntry { number, time, start, length, bus });
        self.head = end;
    }

    fn find(&self, number: u64) -> Option<usize> {
        self.entries.binary_search_by_key(&number, |entry| entry.number).ok()
    }

    fn octets(&self, entry: &RingEntry) -> &[u8] {
        let start = entry.start as usize;
        self.octets.get(start..start + entry.length as usize).unwrap_or_default()
    }

    /// The stations of the frame at `index`; an answer without addresses has those of the frame before it.
    fn ends(&self, index: usize) -> FrameEnds {
        let of = |index: usize, before: FrameEnds| {
            self.entries
                .get(index)
                .map_or(FrameEnds::Unknown, |entry| FrameEnds::of(entry.bus, self.octets(entry), before))
        };
        of(index, index.checked_sub(1).map_or(FrameEnds::Unknown, |before| of(before, FrameEnds::Unknown)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(from: u8, to: u8, fill: u8) -> Vec<u8> {
        [&[2, 0, 0, 0, 0, to][..], &[2, 0, 0, 0, 0, from], &[0x12, 0x34], &[fill; 40]].concat()
    }

    #[test]
    fn the_frames_of_the_same_pair_are_kept_before_and_after() {
        let mut around = ContextCollector::default();
        for number in 1..=40_u64 {
            let of_others = number.is_multiple_of(2);
            let (from, to) = if of_others { (7, 8) } else { (1, 2) };
            around.keep(Bus::Profinet, number, Time::from_nanos(number), &frame(from, to, 0));
            around.fill(&[]);
            if number == 21 {
                around.collect(19, Some(3), None, &[]);
            }
        }
        let (context, _) = around.of(19).expect("frames are kept for frame 19");
        let numbers = |frames: &[ContextFrame]| frames.iter().map(|frame| frame.frame).collect::<Vec<_>>();
        assert_eq!(numbers(&context.before), [3, 11, 13, 15, 17]);
        assert_eq!(context.at.as_ref().map(|frame| frame.frame), Some(19));
        assert_eq!(numbers(&context.after), [21, 23, 25, 27]);
        assert!(!around.is_waiting());
    }

    #[test]
    fn the_ring_keeps_the_last_frames_complete_at_any_length() {
        let mut ring = FrameRing::default();
        for number in 1..=60_000_u64 {
            let length = (number * 37 % 1_500) as usize;
            ring.push(Bus::Profinet, number, Time::ZERO, &vec![number as u8; length]);
        }
        assert!(ring.entries.len() > 1_000 && ring.entries.back().map(|entry| entry.number) == Some(60_000));
        for entry in &ring.entries {
            let length = (entry.number * 37 % 1_500) as usize;
            assert_eq!(ring.octets(entry), vec![entry.number as u8; length], "frame {}", entry.number);
        }
    }
}
