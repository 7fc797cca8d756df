//! Calls: those never answered, those answered late, and those refused, with the reason.

use super::advice::{Advice, advised, of_refusal};
use super::coverage::{CaptureCoverage, CapturePosition, FindingList, SettledFrames};
use super::table::{CALL_FAILED, CALL_SLOW, CALL_UNANSWERED, CAPTURE_GAP, ONE_SIDED, RECORD_REFUSED, START_UNANSWERED};
use super::text::{device, of, span, status, times};
use crate::finding::{CaptureBlame, FindingSeverity};
use judge::observe::{ArId, ArStage, CallPart, Observation, ObservedAr, Role, Traffic};
use rustc_hash::FxHashMap;
use station::Duration;
use std::collections::BTreeMap;
use wire::ethernet::Mac;
use wire::profinet::status::PnioStatus;

/// What a call means that a station does not answer although it goes on with its cyclic frames.
const STILL_ALIVE: Option<Advice> = Some((
    "The station goes on with its cyclic frames: its acyclic services hang or are busy, or call or answer were lost.",
    "Look whether it answers other calls afterwards; if none, report it to its maker with this capture.",
));
/// A call that is not answered within this time, while the capture goes on, counts as unanswered.
const PATIENCE: Duration = Duration::from_secs(5);
/// An answer later than this is reported as slow.
const LATE: Duration = Duration::from_secs(2);
/// Upper limit of the remembered calls and refusals.
const MOST: usize = 4_096;

#[derive(Clone, Copy, Debug)]
struct PendingCall {
    ar: Option<ArId>,
    service: &'static str,
    source: Mac,
    destination: Mac,
    first: CapturePosition,
    last: CapturePosition,
    again: u32,
    working: bool,
}

/// Something that happened several times: how often, in which first and which last frame.
#[derive(Clone, Copy, Debug)]
struct Occurrences {
    count: u64,
    first: u64,
    last: u64,
}

impl Occurrences {
    fn note<K: Ord>(map: &mut BTreeMap<K, Occurrences>, key: K, frame: u64) {
        if map.len() < MOST || map.contains_key(&key) {
            let often = map.entry(key).or_insert(Occurrences { count: 0, first: frame, last: frame });
            (often.count, often.last) = (often.count + 1, frame);
        }
    }
}

/// A refused record: connection, whether it was a write, slot, subslot and index, PNIO status.
type RecordRefused = (Option<ArId>, bool, (u16, u16, u16), u32);

/// The calls of a capture.
#[derive(Clone, Debug, Default)]
pub(super) struct CallCheck {
    pending: FxHashMap<u64, PendingCall>,
    given_up: Vec<PendingCall>,
    /// Pairs with frames missing from the capture: the connection went on although the answer to its Connect is not captured.
    lossy: BTreeMap<(Mac, Mac), (u64, Option<ArId>)>,
    slow: BTreeMap<(Mac, Mac, &'static str), (Occurrences, Duration, u32)>,
    failed: BTreeMap<(Option<ArId>, &'static str, String), Occurrences>,
    records: BTreeMap<RecordRefused, (Occurrences, bool)>,
}

impl CallCheck {
    pub fn observe(
        &mut self,
        now: CapturePosition,
        ars: &[ObservedAr],
        observation: &Observation<'_>,
        findings: &mut FindingList,
    ) {
        match observation {
            Observation::Traffic(Traffic::Call { ar, number, service, part, source, destination }) => match part {
                CallPart::Asked => {
                    let (ar, source, destination) = (*ar, *source, *destination);
                    let (first, last) = (now, now);
                    let call = PendingCall { ar, service, source, destination, first, last, again: 0, working: false };
                    let is_access = ar.and_then(|ar| of(ars, ar)).is_some_and(|ar| ar.role == Role::Access);
                    if *service == "Connect" && is_access {
                        // It ends nothing of the data exchange.
                    } else if *service == "Connect" {
                        self.give_up(now, ars, ar, source, destination);
                    } else if let Some(ar) = ar.filter(|ar| of(ars, *ar).is_some_and(|ar| ar.stage == ArStage::Asked)) {
                        self.went_on(now, ar);
                    }
                    if self.pending.len() < MOST {
                        self.pending.insert(*number, call);
                    }
                }
                CallPart::Again => {
                    if let Some(call) = self.pending.get_mut(number) {
                        if call.again == 0 {
                            findings.note(call.first.frame);
                        }
                        (call.last, call.again) = (now, call.again + 1);
                    }
                }
                CallPart::Working => {
                    if let Some(call) = self.pending.get_mut(number) {
                        call.working = true;
                    }
                }
                CallPart::Answered => {
                    match self.pending.remove(number) {
                        Some(call) => self.answered(now, &call),
                        // Its frames were captured in another order.
                        None if *service == "Connect" => {
                            self.lossy.remove(&(*destination, *source));
                        }
                        None => {}
                    }
                }
            },
            Observation::Record { ar, written, target: (_, slot, subslot, index), status, .. } if !status.is_ok() => {
                let key = (*ar, *written, (*slot, *subslot, *index), u32::from(*status));
                if !self.records.contains_key(&key) {
                    findings.note(now.frame);
                }
                let in_start = ar.and_then(|ar| of(ars, ar)).is_some_and(|ar| ar.stage == ArStage::Connected);
                if self.records.len() < MOST || self.records.contains_key(&key) {
                    let first = Occurrences { count: 0, first: now.frame, last: now.frame };
                    let (often, starts) = self.records.entry(key).or_insert((first, in_start));
                    (often.count, often.last) = (often.count + 1, now.frame);
                    *starts |= in_start;
                }
            }
            Observation::CallFailed { ar, service, why } => {
                let key = (*ar, *service, (*why).to_owned());
                if !self.failed.contains_key(&key) {
                    findings.note(now.frame);
                }
                Occurrences::note(&mut self.failed, key, now.frame);
            }
            // An unreadable frame may have been an answer.
            Observation::Unreadable { .. } => self.pending.clear(),
            _ => {}
        }
    }

    /// A new Connect to the same device shows that the controller has given up the earlier calls.
    fn give_up(&mut self, now: CapturePosition, ars: &[ObservedAr], ar: Option<ArId>, source: Mac, destination: Mac) {
        let given_up = &mut self.given_up;
        let ids = |ar: Option<ArId>| ar.and_then(|ar| of(ars, ar)).and_then(|ar| ar.device.ids);
        self.pending.retain(|_, call| {
            let is =
                (call.source, call.destination) == (source, destination) && !call.working && ids(call.ar) == ids(ar);
            let waited = now.since(call.first).is_some() && call.again > 0;
            if is && waited && given_up.len() < MOST {
                given_up.push(*call);
            }
            !is
        });
    }

    /// A call that needs an accepted connection shows that the answer to its Connect exists and was not captured.
    fn went_on(&mut self, now: CapturePosition, ar: ArId) {
        let (pending, lossy) = (&mut self.pending, &mut self.lossy);
        pending.retain(|_, call| {
            let is = call.service == "Connect" && call.ar == Some(ar);
            if is && lossy.len() < MOST {
                lossy.insert((call.source, call.destination), (now.frame, Some(ar)));
            }
            !is
        });
    }

    fn answered(&mut self, now: CapturePosition, call: &PendingCall) {
        let Some(took) = now.since(call.first) else { return };
        if took < LATE && call.again == 0 {
            return;
        }
        let key = (call.source, call.destination, call.service);
        if self.slow.len() < MOST || self.slow.contains_key(&key) {
            let first = Occurrences { count: 0, first: now.frame, last: now.frame };
            let (often, most, again) = self.slow.entry(key).or_insert((first, Duration::ZERO, 0));
            (often.count, often.last) = (often.count + 1, now.frame);
            (*most, *again) = ((*most).max(took), (*again).max(call.again));
        }
    }

    pub fn end(mut self, sight: &CaptureCoverage, ars: &[ObservedAr], findings: &mut FindingList) {
        let late = |call: &PendingCall| {
            let waited = sight.now.since(call.last).is_some_and(|waited| waited >= PATIENCE);
            !call.working && (waited || call.again >= 2 && sight.now.piece == call.last.piece)
        };
        let mut unanswered: Vec<PendingCall> = std::mem::take(&mut self.pending).into_values().filter(late).collect();
        unanswered.append(&mut self.given_up);
        unanswered.sort_by_key(|call| call.first.frame);
        let mut pairs: BTreeMap<(Mac, Mac, &'static str, bool), (PendingCall, Occurrences)> = BTreeMap::new();
        for call in unanswered {
            let shown = sight.shows(call.destination, call.source);
            let service = if shown { call.service } else { "" };
            let first = Occurrences { count: 0, first: call.first.frame, last: call.first.frame };
            let of = pairs.entry((call.source, call.destination, service, shown)).or_insert((call, first));
            (of.1.count, of.1.last) = (of.1.count + 1, call.last.frame);
            of.0.again = of.0.again.max(call.again);
        }
        for ((source, destination), (frame, ar)) in &self.lossy {
            let text = format!(
                "the connection of {source} and {destination} goes on, but the answer to its Connect is not in the capture or \
     not in order: the capture does not show all frames of this pair, so missing answers are not reported"
            );
            findings.add(one(CAPTURE_GAP.finding(FindingSeverity::Info, CaptureBlame::Capture, *frame, text), *ar));
        }
        for ((source, destination, _, shown), (call, often)) in pairs {
            let pair = [(source, destination), (destination, source)];
            // A station that misses an answer repeats its call. Without a repetition the answer came and the capture has lost it.
            if pair.iter().any(|pair| self.lossy.contains_key(pair)) || shown && call.again == 0 {
                continue;
            }
            let times = times(often.count, often.last);
            if !shown {
                let text = format!(
                    "{source} calls {destination} ({}){times}, but the capture has no frame from {destination} to {source}: \
     whether it answers is not known",
                    call.service
                );
                findings.add(one(
                    ONE_SIDED.finding(FindingSeverity::Info, CaptureBlame::Capture, often.first, text),
                    call.ar,
                ));
                continue;
            }
            let again = match call.again {
                0 => String::new(),
                again => format!(", repeated {again} times"),
            };
            let check = if call.service == "Connect" { START_UNANSWERED } else { CALL_UNANSWERED };
            let blame = match call.service {
                "ApplicationReady" => CaptureBlame::Controller,
                "Connect" => CaptureBlame::Network,
                _ => CaptureBlame::Device,
            };
            let text = format!("{destination} does not answer {} from {source}{again}{times}", call.service);
            let finding = check.finding(FindingSeverity::Error, blame, often.first, text).expected("an answer");
            // A station that goes on with its cyclic frames was neither off nor disconnected.
            let is_alive = ars.iter().any(|ar| {
                let own = match destination {
                    mac if ar.device.mac() == mac => &ar.inputs,
                    mac if ar.controller.mac() == mac => &ar.outputs,
                    _ => return false,
                };
                own.last.is_some_and(|last| last > call.last.time)
            });
            let finding = if is_alive { advised(finding, STILL_ALIVE) } else { finding };
            findings.add(one(finding, call.ar));
        }
        for ((source, destination, service), (often, most, again)) in self.slow {
            let repeated = if again > 0 { format!(", after up to {again} repetitions") } else { String::new() };
            let text = format!(
                "{destination} answers {service} from {source} only after {}{repeated}{}",
                span(most),
                times(often.count, often.last)
            );
            findings.add(CALL_SLOW.finding(FindingSeverity::Info, CaptureBlame::Network, often.first, text));
        }
        for ((ar, service, why), often) in self.failed {
            let at_controller = service == "ApplicationReady";
            let by = if at_controller { "the controller".to_owned() } else { device(ars, ar) };
            let text = format!("{service} failed at {by}: {why}{}", times(often.count, often.last));
            // PROFINET refuses a wrong request, which is the controller's fault; an RPC fault or reject comes from the other side's stack.
            let of_rpc = why.starts_with("fault") || why.starts_with("reject");
            let blame = if of_rpc && !at_controller { CaptureBlame::Device } else { CaptureBlame::Controller };
            findings
                .add(one(CALL_FAILED.finding(FindingSeverity::Warning, blame, often.first, text).observed(why), ar));
        }
        refused_records(self.records, ars, findings);
    }
}

/// Reports the refused records: those of one write request together, and so those that were read and refused for one reason.
fn refused_records(
    records: BTreeMap<RecordRefused, (Occurrences, bool)>,
    ars: &[ObservedAr],
    findings: &mut FindingList,
) {
    let mut requests: BTreeMap<_, Vec<_>> = BTreeMap::new();
    for ((ar, written, place, code), (often, starts)) in records {
        let request = if written { (often.first, often.count, 0) } else { (0, 0, code) };
        requests.entry((ar, written, request)).or_default().push((place, code, often, starts));
    }
    for ((ar, written, _), mut records) in requests {
        records.sort_by_key(|(_, _, often, _)| often.first);
        let Some((first_place, code, first, _)) = records.first().copied() else { continue };
        let verb = if written { "write" } else { "read" };
        let why = status(&PnioStatus::from(code));
        let record = |(slot, subslot, index): (u16, u16, u16)| {
            format!("record 0x{index:04X} of slot {slot} subslot 0x{subslot:04X}")
        };
        let last = records.iter().map(|(_, _, often, _)| often.last).max().unwrap_or(first.last);
        let what = match records.len() {
            1 => format!("{}: {why}{}", record(first_place), times(first.count, last)),
            several if written => format!("{several} records of one request{}", times(first.count, last)),
            several => format!("{several} records: {why}; last in frame {last}"),
        };
        let text = format!("{} refuses to {verb} {what}", device(ars, ar));
        let line = |(place, code, ..): &((u16, u16, u16), u32, Occurrences, bool)| {
            format!("{}: {}", record(*place), status(&PnioStatus::from(*code)))
        };
        let details = if records.len() > 1 { records.iter().map(line).collect() } else { Vec::new() };
        let starts = records.iter().any(|(.., starts)| *starts);
        let severity = if written && starts { FindingSeverity::Warning } else { FindingSeverity::Info };
        let finding = RECORD_REFUSED.finding(severity, CaptureBlame::Controller, first.first, text);
        let finding = advised(finding, of_refusal(&PnioStatus::from(code), false));
        findings.add(one(finding.details(details).observed(why), ar));
    }
}

fn one(finding: crate::finding::CaptureFinding, ar: Option<ArId>) -> crate::finding::CaptureFinding {
    match ar {
        Some(ar) => finding.ar(ar),
        None => finding,
    }
}

impl CallCheck {
    /// Forgets what a watch that never ends need not remember.
    pub fn forget(&mut self, settled: SettledFrames<'_>) {
        let keeps = |ar: Option<ArId>| ar.is_none_or(|ar| settled.keeps(ar));
        self.pending.retain(|_, call| call.last.frame > settled.old && keeps(call.ar));
        self.given_up.retain(|call| call.last.frame > settled.reported && keeps(call.ar));
        self.lossy.retain(|_, (frame, ar)| *frame > settled.old && keeps(*ar));
        self.slow.retain(|_, (often, ..)| often.last > settled.reported);
        self.failed.retain(|key, often| often.last > settled.reported && keeps(key.0));
        self.records.retain(|key, (often, _)| often.last > settled.reported && keeps(key.0));
    }
}
