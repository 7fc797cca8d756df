//! Cyclic frames: those missing on the wire or in the capture, sides that fell silent, and cycle counters that count wrongly.

use super::accepted::AcceptedFrames;
use super::advice::{PAUSED, advised};
use super::coverage::{CaptureCoverage, CapturePosition, FindingList, SettledFrames};
use super::gaps::{FrameGap, GapList, GapReport, OFTEN};
use super::table::{CAPTURE_GAP, CYCLE_COUNTER, CYCLE_SILENT, ONE_SIDED};
use super::text::{of, sender, span};
use crate::finding::{CaptureBlame, FindingSeverity};
use judge::observe::{ArId, ArStage, CyclicStatus, FrameDirection, Observation, ObservedAr, Role};
use station::{Duration, Time};
use wire::ethernet::Mac;

/// A side that goes on for this many watchdog times has received the frames.
const UNHEEDED: u32 = 4;
/// Upper limit of the other streams whose gaps are compared with those of one.
const MOST_COMPARED: usize = 64;
/// Upper limit of the remembered silences.
const MOST_SILENCES: usize = 1_024;
/// After this many frames of one direction the capture would show the other one too.
const ENOUGH: u64 = 10;

/// The unit of the cycle counter in nanoseconds.
const COUNTER_UNIT_NS: u64 = 31_250;

/// The frames of one direction of one connection.
#[derive(Clone, Debug, Default)]
struct CyclicFlow {
    last: Option<(CapturePosition, u16)>,
    /// Missing frames as counted by the tracker.
    lost: u64,
    gaps: GapList,
    /// Gaps shorter than their missing cycles: how many, and the first frame.
    jumps: (u64, u64),
    /// Frames with the same cycle counter as the one before: how many, and the first frame.
    still: (u64, u64),
    /// The frames before those whose counters are compared.
    frames_before: u64,
}

/// A direction that fell silent.
#[derive(Clone, Copy, Debug)]
struct SilentDirection {
    ar: ArId,
    direction: FrameDirection,
    now: CapturePosition,
    /// The time of the last frame of the silent direction and of the other one.
    last: (Option<Time>, Option<Time>),
    /// The number of frames of both.
    frames: (u64, u64),
    /// The cycle counter of the last frame before the silence, and by how much the first one after it is further.
    counter: Option<u16>,
    advanced: Option<u16>,
}

/// The cyclic frames of a capture.
#[derive(Clone, Debug, Default)]
pub(super) struct CyclicFlows {
    /// The frames that their receivers accept.
    pub accepted: AcceptedFrames,
    /// Silences whose end is not yet in the capture.
    open: Vec<usize>,
    flows: Vec<[CyclicFlow; 2]>,
    silences: Vec<SilentDirection>,
}

const fn other(direction: FrameDirection) -> FrameDirection {
    match direction {
        FrameDirection::ToController => FrameDirection::ToDevice,
        FrameDirection::ToDevice => FrameDirection::ToController,
    }
}

impl CyclicFlows {
    #[inline]
    pub fn observe(
        &mut self,
        now: CapturePosition,
        ars: &[ObservedAr],
        observation: &Observation<'_>,
        findings: &mut FindingList,
    ) {
        match observation {
            Observation::Cyclic { ar: id, direction, status: CyclicStatus::Apdu(status), .. } => {
                let index = id.0 as usize;
                if self.flows.len() <= index {
                    self.flows.resize(index + 1, <[CyclicFlow; 2]>::default());
                }
                self.accepted.take(now, *id, *direction, status);
                let Some(ar) = ars.get(index) else { return };
                let stream = ar.stream(*direction);
                let flow = &mut self.flows[index][*direction as usize];
                let (before, lost) = (flow.last.replace((now, status.cycle_counter)), flow.lost);
                flow.lost = stream.lost;
                let Some((before, counter)) = before else { return };
                if stream.lost != lost {
                    if flow.gap(before, now, stream.lost - lost, stream.cycle) {
                        findings.note(now.frame);
                    }
                } else if counter == status.cycle_counter {
                    flow.still = (flow.still.0 + 1, if flow.still.0 == 0 { now.frame } else { flow.still.1 });
                }
            }
            // The silence may be that of the capture, but from then on no frame of the connection is observed.
            Observation::Gap { ar: Some(id) } if of(ars, *id).is_some_and(|ar| ar.stage == ArStage::Starved) => {
                self.accepted.starve(*id);
            }
            Observation::Starved { ar: id, direction } => {
                self.accepted.starve(*id);
                let Some(ar) = of(ars, *id).filter(|_| self.silences.len() < MOST_SILENCES) else { return };
                let (silent, loud) = (ar.stream(*direction), ar.stream(other(*direction)));
                let (last, frames) = ((silent.last, loud.last), (silent.frames, loud.frames));
                findings.note(now.frame);
                self.open.push(self.silences.len());
                let (ar, direction, counter) = (*id, *direction, silent.last_counter);
                self.silences.push(SilentDirection { ar, direction, now, last, frames, counter, advanced: None });
            }
            _ => {}
        }
    }

    /// Notes by how much the counter of a silent direction has advanced when its first frame after the silence comes.
    #[inline]
    pub fn frame_done(&mut self, ars: &[ObservedAr]) {
        if !self.open.is_empty() {
            self.resumed(ars);
        }
    }

    #[cold]
    fn resumed(&mut self, ars: &[ObservedAr]) {
        let silences = &mut self.silences;
        self.open.retain(|at| {
            let Some(silence) = silences.get_mut(*at) else { return false };
            let Some(stream) = of(ars, silence.ar).map(|ar| ar.stream(silence.direction)) else { return false };
            if stream.frames == silence.frames.0 {
                return true;
            }
            if let (Some(before), Some(after)) = (silence.counter, stream.last_counter) {
                silence.advanced = Some(after.wrapping_sub(before));
            }
            false
        });
    }

    /// The gaps of all directions, each with its sender.
    pub fn gaps<'g>(&'g self, ars: &'g [ObservedAr]) -> impl Iterator<Item = (Mac, &'g GapList)> + Clone {
        self.flows
            .iter()
            .zip(ars)
            .flat_map(|([outputs, inputs], ar)| [(ar.controller.mac(), &outputs.gaps), (ar.device.mac(), &inputs.gaps)])
    }

    /// Reports what is wrong; `gaps` are those of the streams without a Connect.
    pub fn end(
        &self,
        gaps: &[(Mac, &GapList)],
        sight: &CaptureCoverage,
        ars: &[ObservedAr],
        findings: &mut FindingList,
    ) {
        for silence in &self.silences {
            silent(silence, ars, findings);
        }
        for (index, flows) in self.flows.iter().enumerate() {
            let id = ArId(index as u32);
            let Some(ar) = of(ars, id) else { continue };
            for direction in [FrameDirection::ToController, FrameDirection::ToDevice] {
                let flow = &flows[direction as usize];
                self.lost(ars, (id, direction), flow, gaps, findings);
                counter(ar, id, direction, flow, findings);
            }
        }
        for (index, ar) in ars.iter().enumerate().filter(|(_, ar)| ar.role == Role::Exchange) {
            one_sided(ar, ArId(index as u32), sight, findings);
        }
    }

    /// Reports the missing frames of one direction; `gaps` are those of the streams without a Connect.
    fn lost(
        &self,
        ars: &[ObservedAr],
        (id, direction): (ArId, FrameDirection),
        flow: &CyclicFlow,
        gaps: &[(Mac, &GapList)],
        findings: &mut FindingList,
    ) {
        let Some(ar) = of(ars, id).filter(|_| !flow.gaps.is_empty()) else { return };
        let stream = ar.stream(direction);
        let own = match direction {
            FrameDirection::ToController => ar.device.mac(),
            FrameDirection::ToDevice => ar.controller.mac(),
        };
        // Two senders do not lose frames at the same time; a recorder that does not keep up loses those of all senders. A controller that
        // pauses, or its cable, loses those of all its connections.
        let all = self.gaps(ars).chain(gaps.iter().copied()).filter(|(_, gaps)| gaps.is_comparable());
        let own_or_other = |is_own: bool| {
            let of =
                all.clone().filter(move |(sender, of)| (*sender == own) == is_own && !std::ptr::eq(*of, &flow.gaps));
            of.map(|(_, gaps)| gaps).take(MOST_COMPARED)
        };
        let others: Vec<&GapList> = own_or_other(false).collect();
        let of_station: Vec<&GapList> = own_or_other(true).collect();
        let report = GapReport {
            who: &sender(ar, direction),
            frames: stream.frames,
            more: &format!(", cycle {}", span(stream.cycle)),
            others: "streams",
            alone: (
                "no other stream has a gap then, so the frames were lost on the network or by a mirror port",
                CaptureBlame::Network,
            ),
        };
        for finding in flow.gaps.findings(others.iter().copied(), of_station.iter().copied(), &report) {
            findings.add(finding.ar(id));
        }
    }
}

impl CyclicFlow {
    /// Counts a gap; returns whether it is the longest so far.
    #[cold]
    fn gap(&mut self, before: CapturePosition, now: CapturePosition, missing: u64, cycle: Duration) -> bool {
        // Where the clock steps back or frames of the file are damaged, the length of the gap is not known.
        let Some(lasted) = now.since(before) else { return false };
        if lasted < cycle * 2 - cycle / 2 && !lasted.is_zero() {
            self.jumps = (self.jumps.0 + 1, if self.jumps.0 == 0 { now.frame } else { self.jumps.1 });
        }
        self.gaps.add(FrameGap { from: before, to: now, missing })
    }
}

/// Reports a cycle counter that jumps although no time passes, or that stands still.
fn counter(ar: &ObservedAr, id: ArId, direction: FrameDirection, flow: &CyclicFlow, findings: &mut FindingList) {
    let who = sender(ar, direction);
    let blame = match direction {
        FrameDirection::ToController => CaptureBlame::Device,
        FrameDirection::ToDevice => CaptureBlame::Controller,
    };
    let frames = ar.stream(direction).frames.saturating_sub(flow.frames_before);
    if flow.still.0 >= OFTEN && flow.still.0 * 2 > frames {
        let text = format!("the cycle counter of {who} stands still in {} of {frames} frames", flow.still.0);
        findings.add(CYCLE_COUNTER.finding(FindingSeverity::Warning, blame, flow.still.1, text).ar(id));
    }
    if flow.jumps.0 >= OFTEN && flow.jumps.0 * 2 > flow.gaps.count() && flow.jumps.0 * 2 > frames {
        let text = format!(
            "the cycle counter of {who} advances by more than one cycle in {} of {frames} frames, although they are sent in time",
            flow.jumps.0
        );
        findings.add(CYCLE_COUNTER.finding(FindingSeverity::Warning, blame, flow.jumps.1, text).ar(id));
    }
}

/// Reports a direction that fell silent: by its sender, or by the capture.
fn silent(silence: &SilentDirection, ars: &[ObservedAr], findings: &mut FindingList) {
    let Some(ar) = of(ars, silence.ar) else { return };
    let (id, direction, frame) = (silence.ar, silence.direction, silence.now.frame);
    let (stream, loud) = (ar.stream(direction), ar.stream(other(direction)));
    let Some(last) = silence.last.0 else { return };
    let after = silence.last.1.map_or(Duration::ZERO, |loud| loud.since(last));
    let resumed = (stream.frames > silence.frames.0, loud.frames > silence.frames.1);
    let who = sender(ar, direction);
    let limit = span(stream.watchdog);
    // The other side went on for a while: it waited for the missing frames.
    let waited = after + stream.cycle >= stream.watchdog / 2;
    let ended = ar.abort.is_some();
    // A side that misses frames for longer than the watchdog ends the connection; a side that goes on has received them.
    let unheeded = loud.last.is_some_and(|loud| loud.since(last) > stream.watchdog * UNHEEDED);
    let step = u64::try_from(stream.cycle.as_nanos()).unwrap_or_default() / COUNTER_UNIT_NS;
    if silence.advanced.is_some_and(|advanced| step > 0 && u64::from(advanced) == step) {
        let text = format!(
            "{who} paused for longer than the watchdog of {limit}: after it its cycle counter continues by one step, so it sent no frame \
             in between"
        );
        findings.add(advised(CYCLE_SILENT.finding(FindingSeverity::Error, own(direction), frame, text), PAUSED).ar(id));
        return;
    }
    if resumed == (true, true) && !waited {
        let text = format!(
            "no frame of {who} and of the other side for longer than the watchdog of {limit}, then both go on: the capture has a \
     gap and is not judged after it"
        );
        findings.add(CAPTURE_GAP.finding(FindingSeverity::Warning, CaptureBlame::Capture, frame, text).ar(id));
    } else if (resumed.0 || unheeded) && !ended {
        let text = format!(
            "no frame of {who} for longer than the watchdog of {limit}, but the other side goes on: the capture lost the frames, or \
     the other side has no working watchdog"
        ) + counter_says(silence);
        findings.add(CAPTURE_GAP.finding(FindingSeverity::Warning, CaptureBlame::Capture, frame, text).ar(id));
    } else if waited || ended || resumed.1 {
        // Loss of power, a pulled cable and a crash cannot be distinguished.
        let severity = if ended { FindingSeverity::Error } else { FindingSeverity::Warning };
        let blame = CaptureBlame::Undecided;
        let text = format!(
            "{who} sent its last cyclic frame {} before this one (watchdog {limit}), while the other side went on for {}",
            span(silence.now.time.since(last)),
            span(after)
        ) + counter_says(silence);
        findings.add(CYCLE_SILENT.finding(severity, blame, frame, text).ar(id));
    } else {
        let text = format!(
            "both sides of the connection of {who} fell silent at the same time, without a Release or an ERR-RTA: the link was \
             interrupted, or the capture ended for them"
        );
        findings.add(CAPTURE_GAP.finding(FindingSeverity::Warning, CaptureBlame::Capture, frame, text).ar(id));
    }
}

/// What the cycle counter after a silence says.
fn counter_says(silence: &SilentDirection) -> &'static str {
    match silence.advanced {
        Some(_) => {
            "; its cycle counter then went on with the time, which it does whether frames were sent and lost or not sent"
        }
        None => "",
    }
}

/// The party that sends in a direction.
fn own(direction: FrameDirection) -> CaptureBlame {
    match direction {
        FrameDirection::ToController => CaptureBlame::Device,
        FrameDirection::ToDevice => CaptureBlame::Controller,
    }
}

/// Reports a connection with no frame of one direction in the capture.
fn one_sided(ar: &ObservedAr, id: ArId, sight: &CaptureCoverage, findings: &mut FindingList) {
    let ready = ar.application_ready_frame.or(ar.connect_frame.is_none().then_some(1));
    let (inputs, outputs) = (&ar.inputs, &ar.outputs);
    let (missing, captured) = match (inputs.frames, outputs.frames) {
        (0, 1..) => (FrameDirection::ToController, outputs),
        (1.., 0) => (FrameDirection::ToDevice, inputs),
        _ => return,
    };
    if captured.frames < ENOUGH || ready.is_none() || ar.stage == ArStage::Refused || ar.abort.is_some() {
        return;
    }
    let (source, destination) = match missing {
        FrameDirection::ToController => (ar.device.mac(), ar.controller.mac()),
        FrameDirection::ToDevice => (ar.controller.mac(), ar.device.mac()),
    };
    let also = if sight.shows(source, destination) { "" } else { ", nor any other frame in that direction" };
    let text = format!("no cyclic frame of {} is in the capture{also}", sender(ar, missing));
    findings.add(
        ONE_SIDED.finding(FindingSeverity::Info, CaptureBlame::Capture, captured.first_frame.unwrap_or(1), text).ar(id),
    );
}

/// So many frames show whether a counter stands still.
const COUNTED: u64 = 100;

impl CyclicFlows {
    /// Forgets what a watch that never ends need not remember.
    pub fn forget(&mut self, settled: SettledFrames<'_>, ars: &[ObservedAr]) {
        self.accepted.forget(settled);
        let name = |silence: &SilentDirection| (silence.ar, silence.now.frame);
        let open: Vec<(ArId, u64)> = self.open.iter().filter_map(|at| self.silences.get(*at)).map(name).collect();
        self.silences.retain(|silence| silence.now.frame > settled.reported && settled.keeps(silence.ar));
        let kept = self.silences.iter().enumerate();
        self.open = kept.filter(|(_, silence)| open.contains(&name(silence))).map(|(at, _)| at).collect();
        for (index, flows) in self.flows.iter_mut().enumerate() {
            if !settled.keeps(ArId(index as u32)) {
                *flows = <[CyclicFlow; 2]>::default();
            }
            let Some(ar) = ars.get(index) else { continue };
            for direction in [FrameDirection::ToController, FrameDirection::ToDevice] {
                let (flow, frames) = (&mut flows[direction as usize], ar.stream(direction).frames);
                flow.gaps.forget(settled.reported);
                if frames < flow.frames_before + COUNTED {
                    continue;
                }
                // A counter that is wrong now is reported once it was wrong for a while.
                let is_done = |(count, first): (u64, u64)| count == 0 || first <= settled.reported;
                if is_done(flow.jumps) && is_done(flow.still) {
                    (flow.jumps, flow.still, flow.frames_before) = ((0, 0), (0, 0), frames);
                }
            }
        }
    }
}
