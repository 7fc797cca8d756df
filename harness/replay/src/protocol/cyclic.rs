//! Cyclic frames: which are missing, by the wire or by the capture; who fell silent; whose cycle counter does not count.

use super::sight::{Now, Sight, Told};
use super::table::{CAPTURE_GAP, CYCLE_COUNTER, CYCLE_LOST, CYCLE_SILENT, ONE_SIDED};
use super::words::{of, sender, span};
use crate::finding::{Blame, Severity};
use judge::observe::{Ar, ArId, CyclicStatus, Direction, Observation, Role, Stage};
use station::{Duration, Time};

/// Gaps of one direction whose times are remembered.
const MOST_GAPS: usize = 256;
/// A side that goes on for so many watchdogs has not missed anything.
const UNHEEDED: u32 = 4;
/// Other streams whose gaps are compared with those of one.
const MOST_COMPARED: usize = 64;
/// Silences that are remembered.
const MOST_SILENCES: usize = 1_024;
/// So many frames of one direction show that the other one should have been seen too.
const ENOUGH: u64 = 10;
/// A counter that goes wrong so often does so on purpose.
const OFTEN: u64 = 3;

/// The frames of one direction of one connection.
#[derive(Clone, Debug, Default)]
struct Flow {
    last: Option<(Now, u16)>,
    /// What the tracker has counted as missing.
    lost: u64,
    gaps: Vec<Gap>,
    places: u64,
    /// Missing frames in gaps that do not last as long as the counter says.
    jumps: (u64, u64),
    still: (u64, u64),
}

/// A place where frames are missing.
#[derive(Clone, Copy, Debug)]
struct Gap {
    from: Time,
    to: Time,
    frame: u64,
    missing: u64,
}

/// A direction that fell silent.
#[derive(Clone, Copy, Debug)]
struct Silence {
    ar: ArId,
    direction: Direction,
    now: Now,
    /// The last frame of the silent direction and of the other one.
    last: (Option<Time>, Option<Time>),
    /// How many frames there were of both.
    frames: (u64, u64),
}

/// The cyclic frames of a capture.
#[derive(Debug, Default)]
pub(super) struct Flows {
    flows: Vec<[Flow; 2]>,
    silences: Vec<Silence>,
}

const fn other(direction: Direction) -> Direction {
    match direction {
        Direction::ToController => Direction::ToDevice,
        Direction::ToDevice => Direction::ToController,
    }
}

impl Flows {
    #[inline]
    pub fn observe(&mut self, now: Now, ars: &[Ar], observation: &Observation<'_>, told: &mut Told) {
        match observation {
            Observation::Cyclic { ar: id, direction, status: CyclicStatus::Apdu(status), .. } => {
                let index = id.0 as usize;
                if self.flows.len() <= index {
                    self.flows.resize(index + 1, <[Flow; 2]>::default());
                }
                let Some(ar) = ars.get(index) else { return };
                let stream = ar.stream(*direction);
                let flow = &mut self.flows[index][*direction as usize];
                let (before, lost) = (flow.last.replace((now, status.cycle_counter)), flow.lost);
                flow.lost = stream.lost;
                let Some((before, counter)) = before else { return };
                if stream.lost != lost {
                    if flow.gap(before, now, stream.lost - lost, stream.cycle) {
                        told.note(now.frame);
                    }
                } else if counter == status.cycle_counter {
                    flow.still = (flow.still.0 + 1, if flow.still.0 == 0 { now.frame } else { flow.still.1 });
                }
            }
            Observation::Starved { ar: id, direction } => {
                let Some(ar) = of(ars, *id).filter(|_| self.silences.len() < MOST_SILENCES) else { return };
                let (silent, loud) = (ar.stream(*direction), ar.stream(other(*direction)));
                let (last, frames) = ((silent.last, loud.last), (silent.frames, loud.frames));
                told.note(now.frame);
                self.silences.push(Silence { ar: *id, direction: *direction, now, last, frames });
            }
            _ => {}
        }
    }

    pub fn end(self, sight: &Sight, ars: &[Ar], told: &mut Told) {
        for silence in &self.silences {
            silent(silence, ars, told);
        }
        for (index, flows) in self.flows.iter().enumerate() {
            let id = ArId(index as u32);
            let Some(ar) = of(ars, id) else { continue };
            for direction in [Direction::ToController, Direction::ToDevice] {
                let flow = &flows[direction as usize];
                self.lost(ar, id, direction, flow, told);
                counter(ar, id, direction, flow, told);
            }
        }
        for (index, ar) in ars.iter().enumerate().filter(|(_, ar)| ar.role == Role::Exchange) {
            one_sided(ar, ArId(index as u32), sight, told);
        }
    }

    /// The missing frames of one direction.
    fn lost(&self, ar: &Ar, id: ArId, direction: Direction, flow: &Flow, told: &mut Told) {
        let Some(longest) = flow.gaps.iter().max_by_key(|gap| gap.to.since(gap.from)) else { return };
        let missing: u64 = flow.gaps.iter().map(|gap| gap.missing).sum();
        let stream = ar.stream(direction);
        // Two senders do not lose frames at the same time; a recorder that does not keep up loses those of everybody.
        let own = (id.0 as usize, direction as usize);
        let each = self.flows.iter().enumerate();
        let each =
            each.flat_map(|(index, flows)| flows.iter().enumerate().map(move |(way, flow)| ((index, way), flow)));
        let others: Vec<&Flow> = each
            .filter(|(place, flow)| *place != own && !flow.gaps.is_empty())
            .map(|(_, flow)| flow)
            .take(MOST_COMPARED)
            .collect();
        let meets = |flow: &&Flow, gap: &Gap| flow.gaps.iter().any(|of| of.from < gap.to && gap.from < of.to);
        let elsewhere = |gap: &&Gap| others.iter().any(|flow| meets(flow, gap));
        let shared = flow.gaps.iter().filter(elsewhere).count();
        let by_capture = shared * 2 > flow.gaps.len();
        let what = format!(
            "{missing} of {} cyclic frames of {} are missing in {} places, the longest gap lasts {} (frame {}, cycle {})",
            stream.frames + missing,
            sender(ar, direction),
            flow.places,
            span(longest.to.since(longest.from)),
            longest.frame,
            span(stream.cycle),
        );
        let finding = if by_capture {
            let text =
                format!("{what}; other streams have gaps at the same time ({shared} of them): the capture lost them");
            CAPTURE_GAP.finding(Severity::Info, Blame::Capture, longest.frame, text)
        } else {
            let severity = if missing > 2 { Severity::Warning } else { Severity::Info };
            let whether = "nothing else is missing then, so that they were lost on the way, or by a mirror port";
            CYCLE_LOST.finding(severity, Blame::Network, longest.frame, format!("{what}; {whether}"))
        };
        told.add(finding.ar(id));
    }
}

impl Flow {
    /// Whether it is the longest so far.
    #[cold]
    fn gap(&mut self, before: Now, now: Now, missing: u64, cycle: Duration) -> bool {
        // Where the clock goes back or frames of the file are damaged nothing is known.
        let Some(lasted) = now.since(before) else { return false };
        if lasted < cycle * 2 - cycle / 2 && !lasted.is_zero() {
            self.jumps = (self.jumps.0 + 1, if self.jumps.0 == 0 { now.frame } else { self.jumps.1 });
        }
        self.places += 1;
        let longest = self.gaps.iter().all(|gap| gap.to.since(gap.from) < lasted) && self.gaps.len() < MOST_GAPS;
        if self.gaps.len() < MOST_GAPS {
            self.gaps.push(Gap { from: before.time, to: now.time, frame: now.frame, missing });
        }
        longest
    }
}

/// A counter that jumps without time going by, or stands still.
fn counter(ar: &Ar, id: ArId, direction: Direction, flow: &Flow, told: &mut Told) {
    let who = sender(ar, direction);
    let blame = match direction {
        Direction::ToController => Blame::Device,
        Direction::ToDevice => Blame::Controller,
    };
    let frames = ar.stream(direction).frames;
    if flow.still.0 >= OFTEN && flow.still.0 * 2 > frames {
        let text = format!("the cycle counter of {who} stands still in {} of {frames} frames", flow.still.0);
        told.add(CYCLE_COUNTER.finding(Severity::Warning, blame, flow.still.1, text).ar(id));
    }
    if flow.jumps.0 >= OFTEN && flow.jumps.0 * 2 > flow.places && flow.jumps.0 * 2 > frames {
        let text = format!(
            "the cycle counter of {who} goes on by more than one cycle in {} of {frames} frames, although they come in time",
            flow.jumps.0
        );
        told.add(CYCLE_COUNTER.finding(Severity::Warning, blame, flow.jumps.1, text).ar(id));
    }
}

/// A direction fell silent: by its sender, or by the capture.
fn silent(silence: &Silence, ars: &[Ar], told: &mut Told) {
    let Some(ar) = of(ars, silence.ar) else { return };
    let (id, direction, frame) = (silence.ar, silence.direction, silence.now.frame);
    let (stream, loud) = (ar.stream(direction), ar.stream(other(direction)));
    let Some(last) = silence.last.0 else { return };
    let after = silence.last.1.map_or(Duration::ZERO, |loud| loud.since(last));
    let resumed = (stream.frames > silence.frames.0, loud.frames > silence.frames.1);
    let who = sender(ar, direction);
    let limit = span(stream.watchdog);
    // The other side went on for a while: it waited for frames that did not come.
    let waited = after + stream.cycle >= stream.watchdog / 2;
    let ended = ar.abort.is_some();
    // Who misses frames for longer than the watchdog ends the connection; who goes on and on has received them.
    let unheeded = loud.last.is_some_and(|loud| loud.since(last) > stream.watchdog * UNHEEDED);
    if resumed == (true, true) && !waited {
        let text = format!(
            "no frame of {who} and of the other side for longer than the watchdog of {limit}, and then both go on as if nothing \
             had been: the capture has a gap, and is not judged behind it"
        );
        told.add(CAPTURE_GAP.finding(Severity::Warning, Blame::Capture, frame, text).ar(id));
    } else if (resumed.0 || unheeded) && !ended {
        let text = format!(
            "no frame of {who} for longer than the watchdog of {limit}, and the other side goes on nevertheless: the capture lost \
             them, or the other side does not watch"
        );
        told.add(CAPTURE_GAP.finding(Severity::Warning, Blame::Capture, frame, text).ar(id));
    } else if waited || ended || resumed.1 {
        // Whether a device lost its supply, its cable or its mind looks the same; that a controller stops is its own doing.
        let (severity, blame) = match (direction, ended) {
            (_, false) => (Severity::Warning, Blame::Network),
            (Direction::ToController, true) => (Severity::Error, Blame::Network),
            (Direction::ToDevice, true) => (Severity::Error, Blame::Controller),
        };
        let text = format!(
            "{who} sent its last cyclic frame {} before this one, watchdog {limit}, while the other side went on for {}",
            span(silence.now.time.since(last)),
            span(after)
        );
        told.add(CYCLE_SILENT.finding(severity, blame, frame, text).ar(id));
    } else {
        let text = format!(
            "both sides of the connection of {who} fell silent at the same time, without a Release or an ERR-RTA: the link was \
             interrupted, or the capture ended for them"
        );
        told.add(CAPTURE_GAP.finding(Severity::Warning, Blame::Capture, frame, text).ar(id));
    }
}

/// A connection of which one direction was never seen.
fn one_sided(ar: &Ar, id: ArId, sight: &Sight, told: &mut Told) {
    let ready = ar.application_ready_frame.or(ar.connect_frame.is_none().then_some(1));
    let (inputs, outputs) = (&ar.inputs, &ar.outputs);
    let (missing, seen) = match (inputs.frames, outputs.frames) {
        (0, 1..) => (Direction::ToController, outputs),
        (1.., 0) => (Direction::ToDevice, inputs),
        _ => return,
    };
    if seen.frames < ENOUGH || ready.is_none() || ar.stage == Stage::Refused || ar.abort.is_some() {
        return;
    }
    let (source, destination) = match missing {
        Direction::ToController => (ar.device.mac(), ar.controller.mac()),
        Direction::ToDevice => (ar.controller.mac(), ar.device.mac()),
    };
    let also = if sight.shows(source, destination) { "" } else { ", nor any other frame that way" };
    let text = format!("no cyclic frame of {} is in the capture{also}", sender(ar, missing));
    told.add(ONE_SIDED.finding(Severity::Info, Blame::Capture, seen.first_frame.unwrap_or(1), text).ar(id));
}
