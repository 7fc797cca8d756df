//! Start-up: Connect, parameters, end of parameters, ApplicationReady; what came late, in a wrong order, or never.

use super::sight::{Now, Sight, Told};
use super::table::{START_AGAIN, START_INCOMPLETE, START_MODULES, START_ORDER, START_REFUSED, START_SLOW};
use super::words::{of, sender, span, status, times};
use crate::observe::{Ar, ArId, CallPart, Direction, Observation, Role, Traffic};
use crate::replay::finding::{Blame, Severity};
use station::Duration;
use std::collections::BTreeMap;
use wire::ethernet::Mac;
use wire::profinet::blocks::module_diff::{IdentInfo, ModuleDiffBlock, ModuleState};
use wire::profinet::status::PnioStatus;

/// A step that takes longer than this is slow.
const SLOW: Duration = Duration::from_secs(5);
/// A start-up that stands still for so long has come to its end.
const PATIENCE: Duration = Duration::from_secs(30);
/// What comes closer together than this may have been swapped by the recorder.
const SWAPPED: Duration = Duration::from_millis(1);
/// So many connections of one pair that broke are worth knowing.
const MANY: u32 = 3;
/// So many frames of both sides are an exchange of data.
const EXCHANGE: u64 = 1_000;
/// Start-ups that are remembered.
const MOST: usize = 10_000;

/// The steps of a start-up in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Step {
    Connected,
    Parameters,
    EndAsked,
    EndAnswered,
    ReadyAsked,
    ReadyAnswered,
}

impl Step {
    const ALL: [Step; 6] =
        [Step::Connected, Step::Parameters, Step::EndAsked, Step::EndAnswered, Step::ReadyAsked, Step::ReadyAnswered];

    /// The step that follows, who owes it, and what it is.
    fn next(self) -> Option<(Blame, &'static str)> {
        match self {
            Step::Connected | Step::Parameters => Some((Blame::Controller, "the end of the parameters")),
            Step::EndAsked => Some((Blame::Device, "the answer to the end of the parameters")),
            Step::EndAnswered => Some((Blame::Device, "ApplicationReady")),
            Step::ReadyAsked => Some((Blame::Controller, "the answer to ApplicationReady")),
            Step::ReadyAnswered => None,
        }
    }

    fn word(self) -> &'static str {
        match self {
            Step::Connected => "answer to Connect",
            Step::Parameters => "last parameter written",
            Step::EndAsked => "end of parameters",
            Step::EndAnswered => "its answer",
            Step::ReadyAsked => "ApplicationReady",
            Step::ReadyAnswered => "its answer",
        }
    }
}

#[derive(Debug, Default)]
struct Start {
    asked: Now,
    steps: BTreeMap<u8, Now>,
    over: bool,
}

impl Start {
    fn at(&self, step: Step) -> Option<Now> {
        self.steps.get(&(step as u8)).copied()
    }

    /// The last step that was taken.
    fn last(&self) -> Option<(Step, Now)> {
        Step::ALL.into_iter().rev().find_map(|step| Some((step, self.at(step)?)))
    }

    /// When the controller asked for it, and how long each step took.
    fn phases(&self) -> String {
        let mut before = self.asked;
        let mut parts = Vec::new();
        for (step, now) in Step::ALL.into_iter().filter_map(|step| Some((step, self.at(step)?))) {
            let after = now.since(before).map_or_else(|| "an unknown time".to_owned(), span);
            parts.push(format!("{} after {after} (frame {})", step.word(), now.frame));
            before = now;
        }
        parts.join(", ")
    }
}

/// Refusals that are alike: the first connection, how often, the first and the last frame.
type Refusals = (ArId, u64, u64, u64);

/// The start-ups of a capture.
#[derive(Debug, Default)]
pub(super) struct Starts {
    known: BTreeMap<ArId, Start>,
    /// The refusals by controller, device and status: the first connection, how often, the last frame.
    refused: BTreeMap<(Mac, Mac, u32), Refusals>,
    /// How often a connection of a pair broke, and where first.
    broken: BTreeMap<(Mac, Mac), (u32, ArId, u64)>,
    pairs: BTreeMap<(Mac, Mac), ArId>,
}

impl Starts {
    pub fn observe(&mut self, now: Now, ars: &[Ar], observation: &Observation<'_>, told: &mut Told) {
        match observation {
            Observation::Traffic(Traffic::Call { ar: Some(id), service, part, .. }) => {
                self.call(now, ars, *id, service, *part, told);
            }
            Observation::Traffic(Traffic::ModulesDiffer { ar, diff }) => modules(now, ars, *ar, diff, told),
            Observation::ConnectRefused { ar: id, status } => {
                if let Some(ar) = of(ars, *id) {
                    let key = (ar.controller.mac(), ar.device.mac(), u32::from(*status));
                    if !self.refused.contains_key(&key) {
                        told.note(now.frame);
                    }
                    let of = self.refused.entry(key).or_insert((*id, 0, now.frame, now.frame));
                    (of.1, of.3) = (of.1 + 1, now.frame);
                }
                self.known.remove(id);
            }
            Observation::Released { ar } => self.over(now, ars, *ar, "the controller released it", None, told),
            Observation::Aborted { ar, direction, .. } => {
                let Some(known) = of(ars, *ar) else { return };
                let how = format!("{} ended it by an ERR-RTA", sender(known, *direction));
                self.broke(known, *ar, now);
                self.over(now, ars, *ar, &how, Some(*direction), told);
            }
            Observation::Starved { ar, direction } => {
                let Some(known) = of(ars, *ar) else { return };
                let how = format!("{} sent no cyclic frames for longer than the watchdog", sender(known, *direction));
                self.broke(known, *ar, now);
                self.over(now, ars, *ar, &how, Some(*direction), told);
            }
            _ => {}
        }
    }

    fn broke(&mut self, ar: &Ar, id: ArId, now: Now) {
        if ar.connect_frame.is_some() && self.broken.len() < MOST {
            self.broken.entry((ar.controller.mac(), ar.device.mac())).or_insert((0, id, now.frame)).0 += 1;
        }
    }

    fn call(&mut self, now: Now, ars: &[Ar], id: ArId, service: &str, part: CallPart, told: &mut Told) {
        let Some(ar) = of(ars, id).filter(|ar| ar.role == Role::Exchange) else { return };
        if (service, part) == ("Connect", CallPart::Asked) {
            let pair = (ar.controller.mac(), ar.device.mac());
            if let Some(before) = self.pairs.insert(pair, id) {
                self.over(now, ars, before, "the controller asked for another connection", None, told);
            }
            if self.known.len() < MOST {
                self.known.insert(id, Start { asked: now, ..Start::default() });
            }
            return;
        }
        let Some(start) = self.known.get_mut(&id).filter(|start| !start.over) else { return };
        let step = match (service, part) {
            ("Connect", CallPart::Answered) => Step::Connected,
            ("Write", CallPart::Answered) if start.at(Step::EndAsked).is_none() => Step::Parameters,
            ("end of parameters", CallPart::Asked) => Step::EndAsked,
            ("end of parameters", CallPart::Answered) => Step::EndAnswered,
            ("ApplicationReady", CallPart::Asked) => Step::ReadyAsked,
            ("ApplicationReady", CallPart::Answered) => Step::ReadyAnswered,
            _ => return,
        };
        start.steps.insert(step as u8, now);
        let early = match step {
            // A frame that is out of its place by itself was swapped by the recorder.
            Step::EndAsked if start.at(Step::ReadyAnswered).is_some() => {
                start.at(Step::ReadyAsked).map(|ready| (ready, "ApplicationReady", "the end of the parameters"))
            }
            _ => None,
        };
        if let Some((before, what, of)) = early
            && now.since(before).is_some_and(|since| since >= SWAPPED)
        {
            let text = format!(
                "{} sends {what} in frame {}, before {of} in frame {}",
                sender(ar, Direction::ToController),
                before.frame,
                now.frame
            );
            told.add(START_ORDER.finding(Severity::Error, Blame::Device, before.frame, text).ar(id));
        }
        if start.at(Step::ReadyAnswered).is_some() && start.at(Step::EndAsked).is_some() {
            start.over = true;
            slow(ar, id, start, told);
        }
    }

    /// A connection came to its end; `by` is whose frame or silence ended it.
    fn over(&mut self, now: Now, ars: &[Ar], id: ArId, how: &str, by: Option<Direction>, told: &mut Told) {
        let Some(start) = self.known.get_mut(&id).filter(|start| !start.over) else { return };
        start.over = true;
        let Some(ar) = of(ars, id) else { return };
        // Where the answer to Connect was not seen nothing of that side was.
        let Some((last, at)) = start.last().filter(|_| start.at(Step::Connected).is_some()) else { return };
        let (Some((owes, missing)), Some(waited)) = (last.next(), now.since(at)) else { return };
        // Who exchanges data has come to the end of the start-up, whether the capture shows it or not.
        if ar.inputs.frames.min(ar.outputs.frames) >= EXCHANGE {
            return;
        }
        // Who had no time to take the next step did not owe it.
        let blame = match by {
            Some(Direction::ToDevice) if waited < SLOW => Blame::Controller,
            Some(Direction::ToController) if waited < SLOW => Blame::Device,
            None if waited < SLOW => Blame::Controller,
            _ => owes,
        };
        let severity = if by.is_some() { Severity::Error } else { Severity::Info };
        let text = format!(
            "the start-up of {} by {} never came to {missing}: {how} {} after the last step; {}",
            sender(ar, Direction::ToController),
            sender(ar, Direction::ToDevice),
            span(waited),
            start.phases()
        );
        told.add(START_INCOMPLETE.finding(severity, blame, now.frame, text).ar(id).expected(missing));
    }

    pub fn end(self, sight: &Sight, ars: &[Ar], told: &mut Told) {
        for (id, start) in self.known.iter().filter(|(_, start)| !start.over) {
            let last = start.last().filter(|_| start.at(Step::Connected).is_some());
            let (Some(ar), Some((last, at))) = (of(ars, *id), last) else { continue };
            let (Some((owes, missing)), Some(waited)) = (last.next(), sight.now.since(at)) else { continue };
            if waited < PATIENCE || !ar.stage.stands() {
                continue;
            }
            let text = format!(
                "the start-up of {} by {} stands still: {missing} did not come in the {} up to the end of the capture; {}",
                sender(ar, Direction::ToController),
                sender(ar, Direction::ToDevice),
                span(waited),
                start.phases()
            );
            told.add(START_INCOMPLETE.finding(Severity::Warning, owes, at.frame, text).ar(*id).expected(missing));
        }
        for ((_, _, code), (id, count, first, last)) in self.refused {
            let Some(ar) = of(ars, id) else { continue };
            let why = status(&PnioStatus::from(code));
            let text = format!(
                "{} refuses {}: {why}{}",
                sender(ar, Direction::ToController),
                sender(ar, Direction::ToDevice),
                times(count, last)
            );
            let finding = START_REFUSED.finding(Severity::Error, Blame::Controller, first, text).ar(id);
            told.add(finding.expected("a connection").seen(why));
        }
        for (count, id, frame) in self.broken.into_values().filter(|(count, ..)| *count >= MANY) {
            let Some(ar) = of(ars, id) else { continue };
            let text = format!(
                "the connection of {} and {} broke {count} times",
                sender(ar, Direction::ToDevice),
                sender(ar, Direction::ToController)
            );
            told.add(START_AGAIN.finding(Severity::Warning, Blame::Network, frame, text).ar(id));
        }
    }
}

/// The slowest step of a start-up that was completed, where it is a slow one.
fn slow(ar: &Ar, id: ArId, start: &Start, told: &mut Told) {
    let mut before = start.asked;
    let mut slowest: Option<(Duration, Step, Now)> = None;
    for (step, now) in Step::ALL.into_iter().filter_map(|step| Some((step, start.at(step)?))) {
        let took = now.since(before).unwrap_or_default();
        if took >= SLOW && slowest.is_none_or(|(most, ..)| most < took) {
            slowest = Some((took, step, now));
        }
        before = now;
    }
    let Some((took, step, now)) = slowest else { return };
    let (blame, direction) = match step {
        Step::Parameters | Step::EndAsked | Step::ReadyAnswered => (Blame::Controller, Direction::ToDevice),
        Step::Connected | Step::EndAnswered | Step::ReadyAsked => (Blame::Device, Direction::ToController),
    };
    let text =
        format!("{} takes {} in a start-up ({}); {}", sender(ar, direction), span(took), step.word(), start.phases());
    told.add(START_SLOW.finding(Severity::Info, blame, now.frame, text).ar(id));
}

/// The modules that a device has otherwise than the controller expects.
fn modules(now: Now, ars: &[Ar], id: ArId, diff: &ModuleDiffBlock, told: &mut Told) {
    let mut places = Vec::new();
    for module in diff.apis.iter().flat_map(|api| &api.modules) {
        if matches!(module.state, ModuleState::NO_MODULE | ModuleState::WRONG_MODULE) {
            let word = module.state.word().unwrap_or_default().replace('_', " ");
            places.push(format!("slot {}: {word}, plugged is 0x{:08X}", module.slot, module.module_ident));
        }
        for of in module.submodules.iter().filter(|of| of.state.format_indicator()) {
            let info = of.state.ident_info();
            if matches!(info, IdentInfo::WRONG | IdentInfo::NO_SUBMODULE) {
                let word = info.word().unwrap_or_default().replace('_', " ");
                let plugged = format!("plugged is 0x{:08X}", of.submodule_ident);
                places.push(format!("slot {} subslot 0x{:04X}: {word}, {plugged}", module.slot, of.subslot));
            }
        }
    }
    let Some(ar) = of(ars, id).filter(|_| !places.is_empty()) else { return };
    let more = places.len().saturating_sub(8);
    places.truncate(8);
    let more = if more > 0 { format!("; and {more} more") } else { String::new() };
    let text =
        format!("{} has other modules than expected: {}{more}", sender(ar, Direction::ToController), places.join("; "));
    told.add(START_MODULES.finding(Severity::Warning, Blame::Controller, now.frame, text).ar(id));
}
