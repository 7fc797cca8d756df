//! Judges frames as they arrive, for as long as one likes, with the walk, the rules and the checks of a capture.
//!
//! What a check decides at the end of a capture is asked of a copy of its state, twice a second: a finding that stands in two
//! evaluations is reported. What was reported and is over is forgotten, so that memory does not grow with the number of frames.

use super::checks::FrameChecks;
use super::finding::{CaptureFinding, FindingSeverity};
use super::protocol::SettledFrames;
use super::protocol::table::{
    CALL_UNANSWERED, CAPTURE_GAP, CYCLE_COUNTER, CYCLE_LOST, CYCLE_SILENT, NOTHING, START_UNANSWERED,
};
use super::read::order::OrderedFrame;
use super::read::reassembly::LostDatagram;
use super::report::ConnectionReport;
use super::walk::{CaptureVisitor, TrackedCapture};
use judge::observe::{ArId, Observation, ObservedAr};
use station::{Duration, Time};
use std::collections::{BTreeMap, VecDeque};
use suite::device::Bus;
use suite::model::Manual;
use virtual_wire::capture::{CapturedPacket, LinkType};

/// How often findings are looked for.
const PACE: Duration = Duration::from_millis(500);
/// A finding that is decided at the end of a capture has to stand in so many evaluations.
const EVALUATIONS: u32 = 2;
/// The same for a call without an answer, which may still come: 5 s.
const EVALUATIONS_OF_CALLS: u32 = 10;
/// What ended so long ago was reported.
const REPORTED: Duration = Duration::from_secs(5);
/// What was last seen so long ago is of no interest any more.
const OLD: Duration = Duration::from_secs(600);
/// A connection that ended so long ago is forgotten.
const ENDED: Duration = Duration::from_secs(30);
/// The longest time for which nothing is forgotten because a finding is about to be decided.
const MOST_WAITS: u32 = 40;
/// The time of a frame is remembered after so many frames, or after this time.
const BETWEEN_FRAMES: u64 = 128;
const BETWEEN_TIMES: Duration = Duration::from_millis(10);
/// Without a frame for this time, the time goes on without one.
const SILENCE: Duration = Duration::from_millis(500);
/// Frames of the last moment may still wait in the kernel.
const IN_FLIGHT: Duration = Duration::from_millis(200);

/// Receives each observation of a frame: the bus, its connections, the time.
pub type ObservationSink<'s> = &'s mut dyn FnMut(Bus, &[ObservedAr], Time, &Observation<'_>);

/// A finding when it was decided.
#[derive(Clone, Debug)]
pub struct LiveFinding {
    /// The finding; its frame counts from the begin of the watch.
    pub finding: CaptureFinding,
    /// The time of its frame, since 1970.
    pub time: Time,
    /// Its connection.
    pub connection: Option<ConnectionReport>,
}

/// Judges frames as they arrive.
pub struct LiveReplay<'a> {
    walked: TrackedCapture<'a>,
    checks: FrameChecks<'a>,
    /// Whether frames are missing before the next one.
    is_interrupted: bool,
    first: Option<Time>,
    last: (u64, Time),
    evaluated: Option<Time>,
    /// Frame numbers with their times, the oldest first.
    times: VecDeque<(u64, Time)>,
    /// Findings that have to stand for a while: in how many evaluations they did.
    pending: BTreeMap<FindingKey, u32>,
    waits: u32,
    /// The findings that stand, and when they were found last.
    standing: BTreeMap<FindingKey, (FindingSeverity, Time)>,
    /// Since when connections have ended.
    ended: BTreeMap<(bool, ArId), Time>,
}

/// What tells a finding from others: id, blame, connection, byte, and the frame or, where that changes, the stations in its text.
type FindingKey = (String, &'static str, Option<(bool, usize)>, Option<usize>, String);

/// The visitor of one frame.
struct LiveVisitor<'v, 'a, 's> {
    checks: &'v mut FrameChecks<'a>,
    sink: ObservationSink<'s>,
}

impl CaptureVisitor for LiveVisitor<'_, '_, '_> {
    fn begin(&mut self, bus: Bus, next: &OrderedFrame<'_>) {
        self.checks.begin(bus, next);
    }

    #[inline]
    fn observe(&mut self, bus: Bus, ars: &[ObservedAr], next: &OrderedFrame<'_>, observation: &Observation<'_>) {
        (self.sink)(bus, ars, next.time, observation);
        self.checks.observe(bus, ars, next, observation);
    }

    fn frame_done(&mut self, bus: Bus, ars: &[ObservedAr]) {
        self.checks.frame_done(bus, ars);
    }

    fn gap(&mut self, bus: Bus, ars: &[ObservedAr], next: &OrderedFrame<'_>, observation: &Observation<'_>) {
        self.checks.gap(bus, ars, next, observation);
    }

    fn lost(&mut self, ars: &[ObservedAr], datagram: &LostDatagram) {
        self.checks.lost(ars, datagram);
    }

    fn hole(&mut self) {
        self.checks.hole();
    }

    fn other_link(&mut self, next: &OrderedFrame<'_>) {
        self.checks.other_link(next);
    }
}

impl<'a> LiveReplay<'a> {
    /// Nothing received yet; `manuals` give the rules.
    pub fn new(manuals: &'a [Manual]) -> LiveReplay<'a> {
        LiveReplay {
            walked: TrackedCapture::new(manuals),
            checks: FrameChecks::new(manuals),
            is_interrupted: false,
            first: None,
            last: (0, Time::ZERO),
            evaluated: None,
            times: VecDeque::new(),
            pending: BTreeMap::new(),
            waits: 0,
            standing: BTreeMap::new(),
            ended: BTreeMap::new(),
        }
    }

    /// Takes in a frame, whose numbers count from 1; passes its observations to `sink`, or those of the frame before it.
    pub fn frame(&mut self, packet: &CapturedPacket<'_>, sink: ObservationSink<'_>) {
        let number = packet.number as u64;
        self.first.get_or_insert(packet.time);
        self.last = (number, packet.time);
        let is_later = |(_, time): &(u64, Time)| packet.time >= *time + BETWEEN_TIMES || packet.time < *time;
        if number.is_multiple_of(BETWEEN_FRAMES) || self.times.back().is_none_or(is_later) {
            self.times.push_back(self.last);
        }
        let after_damage = std::mem::take(&mut self.is_interrupted);
        self.walked.packet(packet, after_damage, &mut LiveVisitor { checks: &mut self.checks, sink });
    }

    /// Notes the time of a frame that is not judged; nothing is measured across it.
    pub fn skip(&mut self, number: u64, time: Time) {
        self.last = (number, time);
        self.interrupt();
    }

    /// Frames were lost before the next one: nothing is measured across them.
    pub fn interrupt(&mut self) {
        self.is_interrupted = true;
    }

    /// The connections on a bus.
    pub fn connections(&self, bus: Bus) -> &[ObservedAr] {
        if bus.is_profibus() { self.walked.slaves.ars() } else { self.walked.tracker.ars() }
    }

    /// Whether [`evaluate`](Self::evaluate) is due.
    pub fn is_due(&self, now: Time) -> bool {
        self.evaluated.is_none_or(|evaluated| now >= evaluated + PACE || now < evaluated)
    }

    /// The findings that were decided since the last call. `now` is the time of the source, which has no frame that is older.
    pub fn evaluate(&mut self, now: Time, sink: ObservationSink<'_>) -> Vec<LiveFinding> {
        self.evaluated = Some(now);
        self.pass_time(now, sink);
        let (mut found, mut is_pending) = (Vec::new(), false);
        let LiveReplay { walked, checks, pending, standing, .. } = self;
        let mut direct = checks.protocol.take_findings();
        direct.extend(checks.rules.take_findings());
        let (open, _) = checks.protocol.clone().end(&walked.tracker, &walked.slaves);
        let mut seen: BTreeMap<FindingKey, u32> = BTreeMap::new();
        for (is_direct, finding) in
            direct.into_iter().map(|finding| (true, finding)).chain(open.into_iter().map(|finding| (false, finding)))
        {
            if finding.id == NOTHING.id {
                continue;
            }
            let key = key(&finding);
            let severity = finding.severity;
            let known = standing.get_mut(&key).map(|(worst, last)| {
                *last = now;
                *worst
            });
            if known.is_some_and(|known| known >= severity) && !seen.contains_key(&key) {
                continue;
            }
            let times = match seen.get(&key) {
                Some(times) => *times,
                None => pending.get(&key).copied().unwrap_or(0) + 1,
            };
            seen.insert(key.clone(), times);
            if !is_direct && times < evaluations(&finding) {
                is_pending = true;
                continue;
            }
            standing.insert(key, (severity, now));
            found.push(finding);
        }
        seen.retain(|key, _| !standing.contains_key(key));
        *pending = seen;
        standing.retain(|_, (_, last)| now.since(*last) < REPORTED);
        found.sort_by_key(|finding| finding.frame);
        fold_gaps(&mut found);
        let found = found.into_iter().map(|finding| self.complete(finding)).collect();
        self.waits = if is_pending { self.waits + 1 } else { 0 };
        if !is_pending || self.waits > MOST_WAITS {
            self.waits = 0;
            self.forget(now);
        }
        found
    }

    /// All findings that are left, at the end of the watch.
    pub fn end(mut self, sink: ObservationSink<'_>) -> Vec<LiveFinding> {
        let now = self.last.1.max(self.evaluated.unwrap_or_default());
        let mut found = self.evaluate(now, sink);
        self.pending.values_mut().for_each(|times| *times = EVALUATIONS);
        found.extend(self.evaluate(now, sink));
        found
    }

    /// Passes on the frame that waits for the next one; where none comes for a while, time goes on without it.
    fn pass_time(&mut self, now: Time, sink: ObservationSink<'_>) {
        let mut visitor = LiveVisitor { checks: &mut self.checks, sink };
        self.walked.flush(&mut visitor);
        if self.last.0 == 0 || now.since(self.last.1) < SILENCE {
            return;
        }
        let time = now - IN_FLIGHT;
        visitor.checks.protocol.time(time);
        let next = OrderedFrame {
            number: self.last.0,
            time,
            link: LinkType::ETHERNET,
            octets: &[],
            cut: None,
            interrupted: false,
        };
        self.walked
            .tracker
            .time(time, &mut |ars, observation| visitor.observe(Bus::Profinet, ars, &next, &observation));
    }

    /// Adds what the report of a capture adds.
    fn complete(&mut self, mut finding: CaptureFinding) -> LiveFinding {
        let ars = if finding.bus.is_profibus() { self.walked.slaves.ars() } else { self.walked.tracker.ars() };
        self.checks.contexts.complete(&mut finding, ars);
        let time = finding.context.at.as_ref().map(|at| at.time);
        self.walked.layouts.mark(&mut finding);
        let first = self.first.unwrap_or_default();
        let time = match time {
            Some(seconds) if seconds >= 0.0 => first + Duration::from_secs_f64(seconds),
            _ => self.time_of(finding.frame),
        };
        let ars = self.connections(finding.bus);
        let connection = finding.ar.and_then(|ar| ars.get(ar)).map(ConnectionReport::from);
        LiveFinding { finding, time, connection }
    }

    /// About when a frame was received.
    fn time_of(&self, frame: u64) -> Time {
        let after = self.times.partition_point(|(number, _)| *number <= frame);
        let before = after.checked_sub(1).and_then(|before| self.times.get(before));
        before.map_or(self.first.unwrap_or_default(), |(_, time)| *time)
    }

    /// The last frame that was received this long before.
    fn frame_before(&self, now: Time, before: Duration) -> u64 {
        let limit = Time::from_nanos(now.as_nanos().saturating_sub(before.as_nanos() as u64));
        let after = self.times.partition_point(|(_, time)| *time <= limit);
        after.checked_sub(1).and_then(|before| self.times.get(before)).map_or(0, |(number, _)| *number)
    }

    /// Forgets what was reported and is over.
    fn forget(&mut self, now: Time) {
        self.times.push_back((self.last.0, self.last.1.max(now - IN_FLIGHT)));
        let (reported, old) = (self.frame_before(now, REPORTED), self.frame_before(now, OLD));
        while self.times.get(1).is_some_and(|(number, _)| *number <= old) {
            self.times.pop_front();
        }
        for bus in [Bus::Profinet, Bus::Profibus] {
            let forgotten = self.forgotten(bus, now);
            let settled = SettledFrames { reported, old, forgotten: &forgotten };
            let LiveReplay { walked, checks, .. } = self;
            match bus {
                Bus::Profinet => checks.protocol.forget(settled, &walked.tracker),
                Bus::Profibus => checks.protocol.forget_slaves(settled, &walked.slaves),
            }
            checks.rules.forget(bus, &forgotten);
            if bus == Bus::Profinet {
                walked.layouts.forget(&forgotten);
            }
            for ar in forgotten {
                match bus {
                    Bus::Profinet => walked.tracker.forget(ar),
                    Bus::Profibus => walked.slaves.forget(ar),
                }
            }
        }
        self.walked.tracker.forget_strays(|stray| stray.first_frame <= old);
        self.checks.contexts.forget(reported);
    }

    /// The connections on a bus that ended long ago.
    fn forgotten(&mut self, bus: Bus, now: Time) -> Vec<ArId> {
        let ars = if bus.is_profibus() { self.walked.slaves.ars() } else { self.walked.tracker.ars() };
        let mut forgotten = Vec::new();
        for (index, ar) in ars.iter().enumerate() {
            let key = (bus.is_profibus(), ArId(index as u32));
            if ar.stage.stands() {
                self.ended.remove(&key);
            } else if now.since(*self.ended.entry(key).or_insert(now)) >= ENDED {
                forgotten.push(key.1);
                self.ended.insert(key, now);
            }
        }
        forgotten
    }
}

/// Makes one finding of the gaps that the capture has in several streams at the same time.
fn fold_gaps(found: &mut Vec<CaptureFinding>) {
    let is_gap = |finding: &CaptureFinding| finding.id == CAPTURE_GAP.id && finding.severity == FindingSeverity::Info;
    let others = found.iter().filter(|finding| is_gap(finding)).count().saturating_sub(1);
    if others == 0 {
        return;
    }
    let mut is_first = true;
    found.retain(|finding| !is_gap(finding) || std::mem::take(&mut is_first));
    if let Some(first) = found.iter_mut().find(|finding| is_gap(finding)) {
        first.text += &format!("; so it is in {others} more streams");
    }
}

/// In how many evaluations a finding that is decided at the end of a capture has to stand.
fn evaluations(finding: &CaptureFinding) -> u32 {
    if [CALL_UNANSWERED.id, START_UNANSWERED.id].contains(&finding.id.as_str()) {
        EVALUATIONS_OF_CALLS
    } else {
        EVALUATIONS
    }
}

fn key(finding: &CaptureFinding) -> FindingKey {
    let is_rule = !finding.requirements.is_empty() || finding.id.contains('/');
    let changes = [CYCLE_LOST.id, CAPTURE_GAP.id, CYCLE_COUNTER.id, CYCLE_SILENT.id].contains(&finding.id.as_str());
    let subject = match (is_rule, changes, finding.ar) {
        (true, ..) | (_, true, Some(_)) => String::new(),
        (_, true, None) => addresses(&finding.text),
        _ => finding.frame.to_string(),
    };
    let ar = finding.ar.map(|ar| (finding.bus.is_profibus(), ar));
    (finding.id.clone(), finding.blame.word(), ar, finding.octet.filter(|_| !is_rule), subject)
}

/// The MAC addresses in a text.
fn addresses(text: &str) -> String {
    let words = text.split(|of: char| !of.is_ascii_hexdigit() && of != ':');
    words.filter(|word| word.len() == 17 && word.matches(':').count() == 5).collect::<Vec<_>>().join(" ")
}
