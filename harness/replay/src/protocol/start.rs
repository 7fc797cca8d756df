//! Start-up: Connect, parameters, end of parameters, ApplicationReady; steps that came late, in a wrong order, or never.

use super::abort::is_deliberate;
use super::advice::{advised, of_refusal};
use super::coverage::{CaptureCoverage, CapturePosition, FindingList, SettledFrames};
use super::table::{START_AGAIN, START_INCOMPLETE, START_MODULES, START_ORDER, START_REFUSED, START_SLOW};
use super::text::{of, sender, span, status, times};
use crate::finding::{CaptureBlame, CaptureFinding, FindingSeverity};
use judge::observe::{ArId, CallPart, FrameDirection, Observation, ObservedAr, Role, Traffic};
use station::Duration;
use std::collections::BTreeMap;
use wire::ethernet::Mac;
use wire::profinet::blocks::module_diff::{IdentInfo, ModuleDiffBlock, ModuleState};
use wire::profinet::status::{AbortReason, PnioStatus};

/// A start-up step that takes longer than this is reported as slow.
const SLOW: Duration = Duration::from_secs(5);
/// A start-up without progress for this time counts as stopped.
const PATIENCE: Duration = Duration::from_secs(30);
/// No controller waits longer than this for ApplicationReady: one that still exchanges data has received it.
const LONGEST_WAIT: Duration = Duration::from_secs(300);
/// Frames closer together than this may have been swapped by the recorder.
const SWAPPED: Duration = Duration::from_millis(1);
/// A pair whose connection breaks this often is reported.
const MANY: u32 = 3;
/// This many frames of both sides are a data exchange.
const EXCHANGE: u64 = 1_000;
/// Upper limit of the remembered start-ups.
const MOST: usize = 10_000;

/// The steps of a start-up, in order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum StartUpStep {
    Connected,
    Parameters,
    EndAsked,
    EndAnswered,
    ReadyAsked,
    ReadyAnswered,
}

impl StartUpStep {
    const ALL: [StartUpStep; 6] = [
        StartUpStep::Connected,
        StartUpStep::Parameters,
        StartUpStep::EndAsked,
        StartUpStep::EndAnswered,
        StartUpStep::ReadyAsked,
        StartUpStep::ReadyAnswered,
    ];

    /// The step that follows: the party that has to take it, and its name.
    fn next(self) -> Option<(CaptureBlame, &'static str)> {
        match self {
            StartUpStep::Connected | StartUpStep::Parameters => {
                Some((CaptureBlame::Controller, "the end of the parameters"))
            }
            StartUpStep::EndAsked => Some((CaptureBlame::Device, "the answer to the end of the parameters")),
            StartUpStep::EndAnswered => Some((CaptureBlame::Device, "ApplicationReady")),
            StartUpStep::ReadyAsked => Some((CaptureBlame::Controller, "the answer to ApplicationReady")),
            StartUpStep::ReadyAnswered => None,
        }
    }

    fn word(self) -> &'static str {
        match self {
            StartUpStep::Connected => "answer to Connect",
            StartUpStep::Parameters => "last parameter written",
            StartUpStep::EndAsked => "end of parameters",
            StartUpStep::EndAnswered => "its answer",
            StartUpStep::ReadyAsked => "ApplicationReady",
            StartUpStep::ReadyAnswered => "its answer",
        }
    }
}

#[derive(Clone, Debug, Default)]
struct OpenStartUp {
    asked: CapturePosition,
    steps: BTreeMap<u8, CapturePosition>,
    /// For each direction the number of frames, and of missing frames, at the last step.
    seen: [(u64, u64); 2],
}

/// How a connection ended.
enum StartUpEnd {
    /// The controller released it, or requested another one; the text says which.
    Left(&'static str),
    /// The sender of the ERR-RTA, and its status.
    Aborted(FrameDirection, PnioStatus),
    /// The direction whose frames stopped.
    Silent(FrameDirection),
}

impl OpenStartUp {
    fn at(&self, step: StartUpStep) -> Option<CapturePosition> {
        self.steps.get(&(step as u8)).copied()
    }

    /// The last step taken.
    fn last(&self) -> Option<(StartUpStep, CapturePosition)> {
        StartUpStep::ALL.into_iter().rev().find_map(|step| Some((step, self.at(step)?)))
    }

    /// Whether the capture shows this direction without a hole since the last step, so that it would show another step too.
    fn shows(&self, ar: &ObservedAr, direction: FrameDirection, waited: Duration) -> bool {
        let stream = ar.stream(direction);
        let (frames, lost) = self.seen[direction as usize];
        let come = u32::try_from(stream.frames.saturating_sub(frames)).unwrap_or(u32::MAX);
        // Half of the time allows for an uneven cycle and for the time before the first frame.
        come > 0 && stream.lost == lost && !stream.unsure && stream.cycle.saturating_mul(come) >= waited / 2
    }

    /// How long each step took, from the Connect request on.
    fn phases(&self) -> String {
        let mut before = self.asked;
        let mut parts = Vec::new();
        for (step, now) in StartUpStep::ALL.into_iter().filter_map(|step| Some((step, self.at(step)?))) {
            let after = now.since(before).map_or_else(|| "an unknown time".to_owned(), span);
            parts.push(format!("{} after {after} (frame {})", step.word(), now.frame));
            before = now;
        }
        parts.join(", ")
    }
}

/// Refusals of one controller by one device with one status: the first connection, how often, the first and the last frame.
#[derive(Clone, Copy, Debug)]
struct ConnectRefusals {
    id: ArId,
    count: u64,
    first: u64,
    last: u64,
    /// The Connect frame of another connection of the pair that had not been released, and the frame that shows it.
    held: Option<(u64, u64)>,
}

/// Controller and device: one station may contain several devices, distinguished by vendor and device ID.
type DevicePair = (Mac, Mac, Option<(u16, u16)>);

fn pair(ar: &ObservedAr) -> DevicePair {
    (ar.controller.mac(), ar.device.mac(), ar.device.ids)
}

/// The start-ups of a capture.
#[derive(Clone, Debug, Default)]
pub(super) struct StartUpCheck {
    /// The start-ups that have not ended.
    known: BTreeMap<ArId, OpenStartUp>,
    /// The refusals by controller, device, status, and whether the connection was for access to records.
    refused: BTreeMap<(Mac, Mac, u32, bool), ConnectRefusals>,
    /// How often a connection of a pair broke, and the first of these.
    broken: BTreeMap<DevicePair, (u32, ArId, u64)>,
    /// How often a pair connected again although its connection had not ended, with the first and the last frame.
    renewed: BTreeMap<DevicePair, (u32, ArId, u64, u64)>,
    /// The last connection of a pair, and the last one that was accepted.
    pairs: BTreeMap<DevicePair, ArId>,
    accepted: BTreeMap<DevicePair, (ArId, CapturePosition)>,
}

impl StartUpCheck {
    pub fn observe(
        &mut self,
        now: CapturePosition,
        ars: &[ObservedAr],
        observation: &Observation<'_>,
        findings: &mut FindingList,
    ) {
        match observation {
            Observation::Traffic(Traffic::Call { ar: Some(id), service, part, .. }) => {
                self.call(now, ars, *id, service, *part, findings);
            }
            Observation::Traffic(Traffic::ModulesDiffer { ar, diff }) => modules(now, ars, *ar, diff, findings),
            Observation::ConnectRefused { ar: id, status } => {
                if let Some(ar) = of(ars, *id) {
                    let key = (ar.controller.mac(), ar.device.mac(), u32::from(*status), ar.role == Role::Access);
                    if !self.refused.contains_key(&key) {
                        findings.note(now.frame);
                    }
                    let is_access = ar.role == Role::Access;
                    let held = self
                        .accepted
                        .get(&pair(ar))
                        .filter(|_| !is_access)
                        .filter(|(_, when)| now.since(*when).is_some());
                    let held = held.and_then(|(held, _)| of(ars, *held)).filter(|held| held.stage.stands());
                    let (id, frame) = (*id, now.frame);
                    let first = ConnectRefusals { id, count: 0, first: frame, last: frame, held: None };
                    if self.refused.len() < MOST || self.refused.contains_key(&key) {
                        let alike = self.refused.entry(key).or_insert(first);
                        (alike.count, alike.last) = (alike.count + 1, now.frame);
                        alike.held = alike.held.or(held.and_then(|held| Some((held.connect_frame?, frame))));
                    }
                }
                self.known.remove(id);
            }
            Observation::Connected { ar } => self.accepted(now, ars, *ar),
            Observation::Released { ar } => {
                self.ended(now, ars, *ar, &StartUpEnd::Left("the controller released it"), findings);
            }
            Observation::Aborted { ar, direction, status } => {
                let Some(known) = of(ars, *ar) else { return };
                // After a Release an ERR-RTA only closes the alarm endpoint, and a controller may end the connection on purpose.
                if !is_deliberate(known, *direction, status) {
                    self.broke(known, *ar, now);
                }
                self.ended(now, ars, *ar, &StartUpEnd::Aborted(*direction, *status), findings);
            }
            Observation::Starved { ar, direction } => {
                let Some(known) = of(ars, *ar) else { return };
                self.broke(known, *ar, now);
                self.ended(now, ars, *ar, &StartUpEnd::Silent(*direction), findings);
            }
            _ => {}
        }
    }

    fn broke(&mut self, ar: &ObservedAr, id: ArId, now: CapturePosition) {
        if ar.connect_frame.is_some() && self.broken.len() < MOST {
            self.broken.entry(pair(ar)).or_insert((0, id, now.frame)).0 += 1;
        }
    }

    /// A device accepted a connection; if the one before is still open, the capture does not show how it ended.
    fn accepted(&mut self, now: CapturePosition, ars: &[ObservedAr], id: ArId) {
        let connected = of(ars, id).filter(|ar| ar.role == Role::Exchange && ar.connect_frame.is_some());
        let Some(ar) = connected.filter(|_| self.accepted.len() < MOST) else { return };
        let before = self.accepted.insert(pair(ar), (id, now));
        let Some((before, when)) = before.filter(|(before, _)| *before != id) else { return };
        if of(ars, before).is_some_and(|before| before.stage.stands()) && now.since(when).is_some() {
            let renewed = self.renewed.entry(pair(ar)).or_insert((0, id, now.frame, now.frame));
            (renewed.0, renewed.3) = (renewed.0 + 1, now.frame);
        }
    }

    fn call(
        &mut self,
        now: CapturePosition,
        ars: &[ObservedAr],
        id: ArId,
        service: &str,
        part: CallPart,
        findings: &mut FindingList,
    ) {
        let Some(ar) = of(ars, id).filter(|ar| ar.role == Role::Exchange) else { return };
        if (service, part) == ("Connect", CallPart::Asked) {
            if let Some(before) = self.pairs.insert(pair(ar), id) {
                self.ended(
                    now,
                    ars,
                    before,
                    &StartUpEnd::Left("the controller requested another connection"),
                    findings,
                );
            }
            if self.known.len() < MOST {
                self.known.insert(id, OpenStartUp { asked: now, ..OpenStartUp::default() });
            }
            return;
        }
        let Some(start) = self.known.get_mut(&id) else { return };
        let step = match (service, part) {
            ("Connect", CallPart::Answered) => StartUpStep::Connected,
            ("Write", CallPart::Answered) if start.at(StartUpStep::EndAsked).is_none() => StartUpStep::Parameters,
            ("end of parameters", CallPart::Asked) => StartUpStep::EndAsked,
            ("end of parameters", CallPart::Answered) => StartUpStep::EndAnswered,
            ("ApplicationReady", CallPart::Asked) => StartUpStep::ReadyAsked,
            ("ApplicationReady", CallPart::Answered) => StartUpStep::ReadyAnswered,
            _ => return,
        };
        start.steps.insert(step as u8, now);
        start.seen = [FrameDirection::ToDevice, FrameDirection::ToController].map(|direction| {
            let stream = ar.stream(direction);
            (stream.frames, stream.lost)
        });
        let early = match step {
            // A single frame out of order was swapped by the recorder.
            StartUpStep::EndAsked if start.at(StartUpStep::ReadyAnswered).is_some() => {
                start.at(StartUpStep::ReadyAsked).map(|ready| (ready, "ApplicationReady", "the end of the parameters"))
            }
            _ => None,
        };
        if let Some((before, what, of)) = early
            && now.since(before).is_some_and(|since| since >= SWAPPED)
        {
            let text = format!(
                "{} sends {what} in frame {}, before {of} in frame {}",
                sender(ar, FrameDirection::ToController),
                before.frame,
                now.frame
            );
            findings.add(START_ORDER.finding(FindingSeverity::Error, CaptureBlame::Device, before.frame, text).ar(id));
        }
        if start.at(StartUpStep::ReadyAnswered).is_some() && start.at(StartUpStep::EndAsked).is_some() {
            slow(ar, id, start, findings);
            self.known.remove(&id);
        }
    }

    /// A connection ended.
    fn ended(
        &mut self,
        now: CapturePosition,
        ars: &[ObservedAr],
        id: ArId,
        end: &StartUpEnd,
        findings: &mut FindingList,
    ) {
        let Some(start) = self.known.remove(&id) else { return };
        let Some(ar) = of(ars, id) else { return };
        // Without the answer to Connect the capture shows nothing of the device's side.
        let Some((last, at)) = start.last().filter(|_| start.at(StartUpStep::Connected).is_some()) else { return };
        let (Some((owes, missing)), Some(waited)) = (last.next(), now.since(at)) else { return };
        // The status of an ERR-RTA that names a missing step is taken as true.
        let missed = matches!(end, StartUpEnd::Aborted(_, status) if status.abort_reason().is_some_and(is_of_start));
        // Sides that exchange data have completed the start-up, whether the capture shows it or not.
        if ar.inputs.frames.min(ar.outputs.frames) >= EXCHANGE && !missed {
            return;
        }
        let (how, mut severity, mut blame) = match end {
            StartUpEnd::Left(how) => ((*how).to_owned(), FindingSeverity::Info, owes),
            StartUpEnd::Aborted(by, _) => {
                (format!("{} ended it by an ERR-RTA", sender(ar, *by)), FindingSeverity::Error, owes)
            }
            // Loss of power and a pulled cable cannot be distinguished.
            StartUpEnd::Silent(by) => {
                let how = format!("{} sent no cyclic frames for longer than the watchdog", sender(ar, *by));
                (how, FindingSeverity::Warning, CaptureBlame::Undecided)
            }
        };
        // A side that had no time for the next step is not to blame for it.
        if waited < SLOW {
            blame = match end {
                StartUpEnd::Left(_) | StartUpEnd::Aborted(FrameDirection::ToDevice, _) => CaptureBlame::Controller,
                StartUpEnd::Aborted(FrameDirection::ToController, _) => CaptureBlame::Device,
                StartUpEnd::Silent(_) => CaptureBlame::Undecided,
            };
        }
        let own = matches!(
            (owes, end),
            (CaptureBlame::Device, StartUpEnd::Aborted(FrameDirection::ToController, _))
                | (CaptureBlame::Controller, StartUpEnd::Left(_) | StartUpEnd::Aborted(FrameDirection::ToDevice, _))
        );
        let seen = missed || own || matches!(end, StartUpEnd::Silent(_)) || start.shows(ar, sends(owes), waited);
        let mut text = format!(
            "the start-up of {} by {} ended before {missing}: {how} {} after the last step; {}",
            sender(ar, FrameDirection::ToController),
            sender(ar, FrameDirection::ToDevice),
            span(waited),
            start.phases()
        );
        if !seen {
            (severity, blame) = (FindingSeverity::Info, CaptureBlame::Capture);
            text += &may_be_lost(ar, owes, missing);
        }
        findings.add(incomplete(severity, blame, now.frame, text).ar(id).expected(missing));
    }

    pub fn end(self, sight: &CaptureCoverage, ars: &[ObservedAr], findings: &mut FindingList) {
        for (id, start) in &self.known {
            let last = start.last().filter(|_| start.at(StartUpStep::Connected).is_some());
            let (Some(ar), Some((last, at))) = (of(ars, *id), last) else { continue };
            let (Some((owes, missing)), Some(waited)) = (last.next(), sight.now.since(at)) else { continue };
            let exchanges = ar.inputs.frames.min(ar.outputs.frames) >= EXCHANGE;
            if waited < PATIENCE || !ar.stage.stands() || exchanges && waited > LONGEST_WAIT {
                continue;
            }
            let mut text = format!(
                "the start-up of {} by {} stalls: {missing} is missing in the remaining {} of the capture; {}",
                sender(ar, FrameDirection::ToController),
                sender(ar, FrameDirection::ToDevice),
                span(waited),
                start.phases()
            );
            let (mut severity, mut blame) = (FindingSeverity::Warning, owes);
            if !start.shows(ar, sends(owes), waited) {
                (severity, blame) = (FindingSeverity::Info, CaptureBlame::Capture);
                text += &may_be_lost(ar, owes, missing);
            }
            findings.add(incomplete(severity, blame, at.frame, text).ar(*id).expected(missing));
        }
        for ((_, _, code, _), ConnectRefusals { id, count, first, last, held }) in self.refused {
            let Some(ar) = of(ars, id) else { continue };
            let why = status(&PnioStatus::from(code));
            let mut text = format!(
                "{} refuses the connection from {}{}: {why}{}",
                sender(ar, FrameDirection::ToController),
                sender(ar, FrameDirection::ToDevice),
                if ar.role == Role::Access { " for access to its records, which no data exchange needs" } else { "" },
                times(count, last)
            );
            if let Some((made, frame)) = held {
                text += &format!("; the connection requested in frame {made} was not released before frame {frame}");
            }
            // A connection for access to records is none of the data exchange, which goes on.
            let is_access = ar.role == Role::Access;
            let (severity, blame) = match is_access {
                true => (FindingSeverity::Warning, CaptureBlame::Undecided),
                false => (FindingSeverity::Error, CaptureBlame::Controller),
            };
            let finding = START_REFUSED.finding(severity, blame, first, text).ar(id);
            let finding = advised(finding, of_refusal(&PnioStatus::from(code), is_access));
            // What the device held before it refused for the first time explains the refusals.
            let finding = match held.filter(|(made, _)| *made < first) {
                Some((made, _)) => finding
                    .cause(format!(
                        "The device still holds the connection of frame {made}; it ends when the watchdog expires."
                    ))
                    .next("Check why the controller left that connection without a Release or an ERR-RTA."),
                None => finding,
            };
            findings.add(finding.expected("a connection").observed(why));
        }
        for (count, id, frame) in self.broken.into_values().filter(|(count, ..)| *count >= MANY) {
            let Some(ar) = of(ars, id) else { continue };
            let text = format!(
                "the connection of {} and {} broke {count} times",
                sender(ar, FrameDirection::ToDevice),
                sender(ar, FrameDirection::ToController)
            );
            findings.add(START_AGAIN.finding(FindingSeverity::Warning, CaptureBlame::Network, frame, text).ar(id));
        }
        for (count, id, first, last) in self.renewed.into_values().filter(|(count, ..)| *count >= MANY) {
            let Some(ar) = of(ars, id) else { continue };
            let text = format!(
                "{} connected again to {} {count} times (last in frame {last}), but the capture does not show how the previous \
     connection ended",
                sender(ar, FrameDirection::ToDevice),
                sender(ar, FrameDirection::ToController)
            );
            findings.add(START_AGAIN.finding(FindingSeverity::Warning, CaptureBlame::Network, first, text).ar(id));
        }
    }
}

/// Whether a reason says that a step of the start-up is missing.
fn is_of_start(reason: AbortReason) -> bool {
    [AbortReason::CMI_TIMEOUT, AbortReason::APPLICATION_READY_TIMEOUT].contains(&reason)
}

/// The direction in which a party sends.
fn sends(blame: CaptureBlame) -> FrameDirection {
    if blame == CaptureBlame::Device { FrameDirection::ToController } else { FrameDirection::ToDevice }
}

/// Says that the capture may have lost the missing step.
fn may_be_lost(ar: &ObservedAr, owes: CaptureBlame, missing: &str) -> String {
    format!(
        "; the capture does not show all frames of {} in that time, so {missing} may have been sent",
        sender(ar, sends(owes))
    )
}

fn incomplete(severity: FindingSeverity, blame: CaptureBlame, frame: u64, text: String) -> CaptureFinding {
    let finding = START_INCOMPLETE.finding(severity, blame, frame, text);
    match blame {
        CaptureBlame::Capture => finding
            .cause("The capture lost the step, or it was never sent.")
            .next("Capture again with a tap or with less load. If the connection works, nothing is wrong."),
        _ => finding,
    }
}

/// Reports the slowest step of a completed start-up, if it is a slow one.
fn slow(ar: &ObservedAr, id: ArId, start: &OpenStartUp, findings: &mut FindingList) {
    let mut before = start.asked;
    let mut slowest: Option<(Duration, StartUpStep, CapturePosition)> = None;
    for (step, now) in StartUpStep::ALL.into_iter().filter_map(|step| Some((step, start.at(step)?))) {
        let took = now.since(before).unwrap_or_default();
        if took >= SLOW && slowest.is_none_or(|(most, ..)| most < took) {
            slowest = Some((took, step, now));
        }
        before = now;
    }
    let Some((took, step, now)) = slowest else { return };
    let (blame, direction) = match step {
        StartUpStep::Parameters | StartUpStep::EndAsked | StartUpStep::ReadyAnswered => {
            (CaptureBlame::Controller, FrameDirection::ToDevice)
        }
        StartUpStep::Connected | StartUpStep::EndAnswered | StartUpStep::ReadyAsked => {
            (CaptureBlame::Device, FrameDirection::ToController)
        }
    };
    let text = format!(
        "{} takes {} for one start-up step ({}); {}",
        sender(ar, direction),
        span(took),
        step.word(),
        start.phases()
    );
    findings.add(START_SLOW.finding(FindingSeverity::Info, blame, now.frame, text).ar(id));
}

/// Reports the modules of a device that differ from those the controller expects.
fn modules(now: CapturePosition, ars: &[ObservedAr], id: ArId, diff: &ModuleDiffBlock, findings: &mut FindingList) {
    let mut places = Vec::new();
    for module in diff.apis.iter().flat_map(|api| &api.modules) {
        if matches!(module.state, ModuleState::NO_MODULE | ModuleState::WRONG_MODULE) {
            let word = module.state.word().unwrap_or_default().replace('_', " ");
            places.push(format!("slot {}: {word}, plugged: 0x{:08X}", module.slot, module.module_ident));
        }
        for of in module.submodules.iter().filter(|of| of.state.format_indicator()) {
            let info = of.state.ident_info();
            if matches!(info, IdentInfo::WRONG | IdentInfo::NO_SUBMODULE) {
                let word = info.word().unwrap_or_default().replace('_', " ");
                let plugged = format!("plugged: 0x{:08X}", of.submodule_ident);
                places.push(format!("slot {} subslot 0x{:04X}: {word}, {plugged}", module.slot, of.subslot));
            }
        }
    }
    let Some(ar) = of(ars, id).filter(|_| !places.is_empty()) else { return };
    let more = places.len().saturating_sub(8);
    places.truncate(8);
    let more = if more > 0 { format!("; and {more} more") } else { String::new() };
    let text = format!(
        "{} has other modules than the controller expects: {}{more}",
        sender(ar, FrameDirection::ToController),
        places.join("; ")
    );
    findings.add(START_MODULES.finding(FindingSeverity::Warning, CaptureBlame::Controller, now.frame, text).ar(id));
}

impl StartUpCheck {
    /// Forgets what a watch that never ends need not remember.
    pub fn forget(&mut self, settled: SettledFrames<'_>) {
        self.known.retain(|ar, _| settled.keeps(*ar));
        self.refused.retain(|_, refused| refused.last > settled.reported && settled.keeps(refused.id));
        self.broken.retain(|_, (_, ar, frame)| *frame > settled.old && settled.keeps(*ar));
        self.renewed.retain(|_, (_, ar, first, _)| *first > settled.old && settled.keeps(*ar));
        self.pairs.retain(|_, ar| settled.keeps(*ar));
        self.accepted.retain(|_, (ar, _)| settled.keeps(*ar));
    }
}
