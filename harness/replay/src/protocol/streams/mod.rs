//! Cyclic frames of connections whose Connect is not in the capture: status, cycle counter and silence, which need no layout.
//!
//! A stream is a pair of MAC addresses and a FrameID. Who is controller and who is device is known only if the capture shows a call or
//! DCP of them; otherwise they are two stations, and neither is blamed.

mod identity;
mod report;
mod status_place;

use super::coverage::{CaptureCoverage, CapturePosition, FindingList, SettledFrames};
use super::gaps::{FrameGap, GapList};
use crate::report::StreamCoverage;
use identity::StationIdentities;
use judge::observe::{Observation, ObservedAr, Traffic};
use rustc_hash::FxHashMap;
use station::Duration;
use status_place::{COUNTER_UNIT_NS, FEWEST, MOST, SampledFrame, StatusPlace, counter_at, place};
use std::collections::BTreeMap;
use wire::ethernet::Mac;
use wire::profinet::rt::DataStatus;

/// Upper limit of the streams that are judged.
const MOST_STREAMS: usize = 1_024;
/// The longest watchdog of PROFINET (IEC 61158-6-10): the one agreed in the Connect is not known.
const WATCHDOG: Duration = Duration::from_millis(1_920);

/// Source, destination and FrameID.
type StreamName = (Mac, Mac, u16);

/// The streams without a Connect.
#[derive(Clone, Debug, Default)]
pub(super) struct WatchedStreams {
    numbers: FxHashMap<StreamName, usize>,
    streams: Vec<WatchedStream>,
    /// The last call or alarm of each station: it has ended the connection, or established another one.
    calls: FxHashMap<Mac, CapturePosition>,
    identities: StationIdentities,
}

#[derive(Clone, Debug)]
struct WatchedStream {
    name: StreamName,
    frames: u64,
    /// The frames before those whose counters are compared.
    frames_before: u64,
    first: CapturePosition,
    last: CapturePosition,
    /// The longest time between two frames without a hole of the capture, and the frame after it.
    longest: (Duration, u64),
    reading: Reading,
    counter: CounterWatch,
    /// STOP, problem, invalid.
    states: [StreamStatus; 3],
    /// Frames whose status may not be evaluated: the provider is a backup, or says so.
    unevaluated: u64,
    /// Frames that are too short for the place of the status.
    unread: u64,
}

/// How far a stream can be read.
#[derive(Clone, Debug)]
enum Reading {
    Sampling(Vec<SampledFrame>),
    Located(StatusPlace),
    /// No place of the status was found.
    Unknown,
}

#[derive(Clone, Debug, Default)]
struct CounterWatch {
    last: Option<(CapturePosition, u16)>,
    gaps: GapList,
    /// Steps that are longer than the time that passed: how many, and the first frame.
    jumps: (u64, u64),
    /// The same for frames with the counter of the one before.
    still: (u64, u64),
    /// The longest pause that is no shorter than the longest watchdog, and by how much the counter advanced in it.
    pause: Option<(Duration, u16)>,
}

/// A bad status over time.
#[derive(Clone, Copy, Debug, Default)]
struct StreamStatus {
    since: Option<CapturePosition>,
    first: Option<CapturePosition>,
    /// Its place in the first bad frame.
    octet: usize,
    times: u64,
    frames: u64,
    longest: Duration,
    ended: u64,
}

impl WatchedStreams {
    /// A station sent a call, an answer to one, or an alarm.
    pub fn called(&mut self, now: CapturePosition, source: Mac) {
        if self.calls.len() < MOST_STREAMS || self.calls.contains_key(&source) {
            self.calls.insert(source, now);
        }
    }

    /// Takes in what stations say about themselves.
    pub fn identify(&mut self, observation: &Observation<'_>) {
        self.identities.observe(observation);
    }

    #[inline]
    pub fn observe(&mut self, now: CapturePosition, observation: &Observation<'_>, findings: &mut FindingList) {
        if let Observation::Traffic(Traffic::Stray { source, destination, frame_id, octets, at, .. }) = observation {
            let name = (*source, *destination, *frame_id);
            let next = self.streams.len();
            if next == MOST_STREAMS && !self.numbers.contains_key(&name) {
                return;
            }
            let number = *self.numbers.entry(name).or_insert(next);
            if number == next {
                self.streams.push(WatchedStream::new(name, now));
            }
            let called = self.calls.get(source).map_or(0, |of| of.frame);
            if let Some(stream) = self.streams.get_mut(number)
                && stream.take(now, octets, *at, called)
            {
                findings.note(now.frame);
            }
        }
    }

    /// Judges streams of few frames by those there are; to be called before all that follows.
    pub fn end_of_capture(&mut self) {
        for stream in &mut self.streams {
            stream.end_of_capture();
        }
    }

    /// The gaps of the streams, each with its sender.
    pub fn gaps(&self) -> impl Iterator<Item = (Mac, &GapList)> {
        self.streams.iter().map(|stream| (stream.name.0, &stream.counter.gaps))
    }

    /// Reports what is wrong, and what of the streams was judged; `gaps` are those of the connections.
    pub fn end(
        self,
        gaps: &[(Mac, &GapList)],
        sight: &CaptureCoverage,
        ars: &[ObservedAr],
        findings: &mut FindingList,
    ) -> Vec<StreamCoverage> {
        // Where the layout was guessed, the frames after the first ones were judged as those of a connection.
        let has_guessed_layout = |stream: &WatchedStream| {
            let of_pair = |ar: &&ObservedAr| {
                let (one, other) = (ar.controller.mac(), ar.device.mac());
                (one, other) == (stream.name.0, stream.name.1) || (other, one) == (stream.name.0, stream.name.1)
            };
            ars.iter().filter(of_pair).any(|ar| ar.connect_frame.is_none() && ar.inputs.frames + ar.outputs.frames > 0)
        };
        let judged = self.streams.iter().filter(|stream| !has_guessed_layout(stream));
        for stream in judged.clone() {
            let called = self.calls.get(&stream.name.0).map_or(0, |of| of.frame);
            report::report(stream, (&self.streams, gaps), (called, &self.identities), sight, ars, findings);
        }
        let coverage: BTreeMap<StreamName, StreamCoverage> =
            judged.map(|stream| (stream.name, report::coverage(stream, &self.identities, ars))).collect();
        coverage.into_values().collect()
    }
}

impl WatchedStream {
    fn new(name: StreamName, first: CapturePosition) -> WatchedStream {
        WatchedStream {
            name,
            frames: 0,
            frames_before: 0,
            first,
            last: first,
            longest: (Duration::ZERO, first.frame),
            reading: Reading::Sampling(Vec::with_capacity(FEWEST)),
            counter: CounterWatch::default(),
            states: [StreamStatus::default(); 3],
            unevaluated: 0,
            unread: 0,
        }
    }

    /// Takes in a frame; `called` is the frame of the sender's last call. Returns whether a finding may begin here.
    fn take(&mut self, now: CapturePosition, octets: &[u8], at: usize, called: u64) -> bool {
        self.frames += 1;
        // A station that called in between did not fall silent.
        let pause = now.since(self.last).filter(|_| called <= self.last.frame).unwrap_or_default();
        if pause > self.longest.0 {
            self.longest = (pause, now.frame);
        }
        self.last = now;
        let fell_silent = pause > WATCHDOG;
        match &mut self.reading {
            Reading::Located(place) => {
                let place = *place;
                self.judge(place, now, octets, at) || fell_silent
            }
            Reading::Unknown => fell_silent,
            Reading::Sampling(samples) => {
                // A mirror port shows a frame twice.
                if samples.last().is_none_or(|last| last.octets != octets) {
                    samples.push(SampledFrame { at: now, octets: octets.to_vec() });
                }
                let count = samples.len();
                if count >= FEWEST && (count.is_multiple_of(FEWEST)) {
                    return self.locate(count >= MOST, at) || fell_silent;
                }
                fell_silent
            }
        }
    }

    /// Looks for the place of the status in the samples, and judges them.
    fn locate(&mut self, is_last_time: bool, at: usize) -> bool {
        let Reading::Sampling(samples) = &mut self.reading else { return false };
        let Some(found) = place(samples) else {
            if is_last_time {
                self.reading = Reading::Unknown;
            }
            return false;
        };
        let samples = std::mem::take(samples);
        self.reading = Reading::Located(found);
        let noted = samples.iter().filter(|sample| self.judge(found, sample.at, &sample.octets, at)).count();
        noted > 0
    }

    /// A stream of few frames is judged by those there are.
    fn end_of_capture(&mut self) {
        if let Reading::Sampling(samples) = &self.reading {
            if samples.len() >= FEWEST {
                self.locate(true, 0);
            } else {
                self.reading = Reading::Unknown;
            }
        }
    }

    /// Judges a frame by its status; returns whether something changed.
    fn judge(&mut self, place: StatusPlace, now: CapturePosition, octets: &[u8], at: usize) -> bool {
        let (Some(counter), Some(&status)) = (counter_at(octets, place.offset), octets.get(place.offset + 2)) else {
            self.unread += 1;
            self.counter.last = None;
            return false;
        };
        let status = DataStatus(status);
        let lost = self.counter.take(now, counter, place.step);
        if status.has(DataStatus::IGNORE) || !status.has(DataStatus::PRIMARY) {
            self.unevaluated += 1;
            return lost;
        }
        let bad = [!status.is_run(), status.has_problem(), !status.is_valid()];
        let mut begins = false;
        for (watch, is_bad) in self.states.iter_mut().zip(bad) {
            begins |= watch.take(now, is_bad, at + place.offset + 2);
        }
        lost || begins
    }
}

impl CounterWatch {
    /// Takes in a counter; returns whether frames are missing before it.
    fn take(&mut self, now: CapturePosition, counter: u16, step: u16) -> bool {
        let Some((before, last)) = self.last.replace((now, counter)) else { return false };
        // Across a hole nothing is measured, and after a long pause the counter has wrapped.
        let Some(passed) = now.since(before) else { return false };
        let advanced = counter.wrapping_sub(last);
        if passed >= WATCHDOG {
            if self.pause.is_none_or(|(longest, _)| longest < passed) {
                self.pause = Some((passed, advanced));
            }
            return false;
        }
        if advanced == step {
            return false;
        }
        let frame_of = |first: (u64, u64)| (first.0 + 1, if first.0 == 0 { now.frame } else { first.1 });
        if advanced == 0 {
            self.still = frame_of(self.still);
            return false;
        }
        let cycle = Duration::from_nanos(u64::from(step) * COUNTER_UNIT_NS);
        let time_of_counter = Duration::from_nanos(u64::from(advanced) * COUNTER_UNIT_NS);
        if !advanced.is_multiple_of(step) || (!passed.is_zero() && time_of_counter > passed + cycle * 2) {
            self.jumps = frame_of(self.jumps);
            return false;
        }
        let missing = u64::from(advanced / step - 1);
        self.gaps.add(FrameGap { from: before, to: now, missing });
        true
    }
}

impl StreamStatus {
    /// Takes in a frame; returns whether the status becomes bad for the first time.
    fn take(&mut self, now: CapturePosition, is_bad: bool, octet: usize) -> bool {
        match (is_bad, self.since) {
            (true, None) => {
                self.times += 1;
                self.frames += 1;
                self.since = Some(now);
                let is_first = self.first.is_none();
                if is_first {
                    (self.first, self.octet) = (Some(now), octet);
                }
                is_first
            }
            (true, Some(since)) => {
                self.frames += 1;
                match now.since(since) {
                    Some(lasted) => self.longest = self.longest.max(lasted),
                    // Nothing is measured across a hole of the capture.
                    None => self.since = Some(now),
                }
                false
            }
            (false, Some(since)) => {
                self.longest = self.longest.max(now.since(since).unwrap_or_default());
                (self.since, self.ended) = (None, now.frame);
                false
            }
            (false, None) => false,
        }
    }
}

impl WatchedStreams {
    /// Forgets what a watch that never ends need not remember.
    pub fn forget(&mut self, settled: SettledFrames<'_>) {
        self.calls.retain(|_, called| called.frame > settled.old);
        self.streams.retain(|stream| stream.last.frame > settled.old);
        self.numbers = self.streams.iter().enumerate().map(|(number, stream)| (stream.name, number)).collect();
        for stream in &mut self.streams {
            if stream.longest.1 <= settled.reported {
                stream.longest = (Duration::ZERO, stream.last.frame);
            }
            let counter = &mut stream.counter;
            counter.gaps.forget(settled.reported);
            let is_done = |(count, first): (u64, u64)| count == 0 || first <= settled.reported;
            if is_done(counter.jumps) && is_done(counter.still) {
                (counter.jumps, counter.still) = ((0, 0), (0, 0));
                stream.frames_before = stream.frames;
            }
            for state in &mut stream.states {
                if state.since.is_none() && state.ended <= settled.reported {
                    *state = StreamStatus::default();
                }
            }
        }
    }
}
