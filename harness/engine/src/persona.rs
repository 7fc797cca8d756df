//! The effects of a persona on judging: longer deadlines, and what cannot be judged with it.
//!
//! Cases are written for the cycle of connections without a persona. In a slower cycle a value arrives later, so deadlines are
//! extended by some cycles. If the extension is more than half of the deadline, or a time is too short for two frames, nothing can
//! be said about the device: the trial is not applicable, and never passes.

use super::scan::each_step_of;
use expression::{Program, Value};
use judge::violation::RuleViolation;
use station::Duration;
use suite::device::{DeviceDescription, NameId, NameKind};
use suite::model::{
    BlockObservation, ConnectionStart, Deadline, HoldTime, Manual, RuleBody, StartDeviation, SuiteRule, SuiteVariant,
    TimeSpan, Trial, TrialStep, Verb,
};
use suite::persona::{ExpectedSubmodules, Persona};
use virtual_wire::Trace;
use wire::ethernet::{EtherType, FrameHeader, Mac};
use wire::profinet::rt::FrameId;

/// Cycles from setting an output to observing its effect: to the device, through it, and back.
const ROUND_TRIP: u32 = 3;
/// Frames that a time has to contain at least before its condition can be judged.
const SAMPLES: u32 = 2;

/// By how much a persona extends deadlines: a round trip at its cycle instead of the usual one.
pub fn slack(persona: &Persona, device: &DeviceDescription) -> Duration {
    let cycle = persona.cycle.map_or(device.timing.cycle, |cycle| cycle.time());
    cycle.saturating_sub(device.timing.cycle) * ROUND_TRIP
}

/// Why a trial cannot be judged with a persona; `None` if it can.
pub fn unfit_trial(persona: &Persona, manual: &Manual, variant: &SuiteVariant, trial: &Trial) -> Option<String> {
    if let Some(why) = other_bus(persona, &manual.device) {
        return Some(why);
    }
    let mut look = PersonaCheck::new(persona, &manual.device, Some(variant), trial.start());
    let mut why = trial.start().and_then(|start| look.start(start));
    each_step_of(trial, &mut |step| {
        let found = look.step(step);
        if why.is_none() {
            why = found.map(|why| format!("{why} (line {})", step.at.line));
        }
    });
    why.map(|why| format!("persona {}: {why}", persona.name))
}

/// Why a rule cannot be judged with a persona; `None` if it can.
pub fn unfit_rule(persona: &Persona, device: &DeviceDescription, rule: &SuiteRule) -> Option<String> {
    if let Some(why) = other_bus(persona, device) {
        return Some(why);
    }
    let look = PersonaCheck::new(persona, device, None, None);
    look.rule(&rule.body).map(|why| format!("persona {}: {why}", persona.name))
}

/// Personas are controllers on PROFINET; there are none for PROFIBUS masters.
fn other_bus(persona: &Persona, device: &DeviceDescription) -> Option<String> {
    let name = &persona.name;
    (device.profibus().is_some()).then(|| format!("persona {name}: it applies to PROFINET only"))
}

/// Whether a rule was broken only because no cyclic frame of the device at `mac` came from the premise to the deadline. With a long
/// watchdog a device that is gone causes this, and it says nothing about one that is present.
pub fn is_without_frames(violation: &RuleViolation, trace: &Trace, mac: Mac) -> bool {
    let Some(trigger) = violation.trigger else { return false };
    let is_input = |number: u64| {
        let Some((header, payload)) =
            usize::try_from(number).ok().and_then(|at| FrameHeader::parse(trace.get(at)?.octets).ok())
        else {
            return false;
        };
        let is_cyclic = || FrameId::peek(payload).is_ok_and(FrameId::is_cyclic);
        header.source == mac && header.ether_type == EtherType::PROFINET && is_cyclic()
    };
    !(trigger.frame + 1..=violation.tick.frame).any(is_input)
}

/// The properties of the present connection while the steps of a trial are checked.
struct PersonaCheck<'a> {
    persona: &'a Persona,
    device: &'a DeviceDescription,
    /// The trial's variant, for its names; `None` for a rule.
    variant: Option<&'a SuiteVariant>,
    /// The cycle, if it is the persona's and slower than the usual one.
    slow: Option<Duration>,
}

impl<'a> PersonaCheck<'a> {
    fn new(
        persona: &'a Persona,
        device: &'a DeviceDescription,
        variant: Option<&'a SuiteVariant>,
        start: Option<&ConnectionStart>,
    ) -> PersonaCheck<'a> {
        let mut look = PersonaCheck { persona, device, variant, slow: None };
        look.slow = look.slow(start);
        look
    }

    fn slow(&self, start: Option<&ConnectionStart>) -> Option<Duration> {
        let own = start.is_none_or(|start| start.cycle.is_none());
        self.persona.cycle.map(|cycle| cycle.time()).filter(|cycle| own && *cycle > self.device.timing.cycle)
    }

    /// A start-up with a watchdog shorter than two cycles of the persona, or with an access point that the persona does not expect.
    fn start(&mut self, start: &ConnectionStart) -> Option<String> {
        self.slow = self.slow(Some(start));
        let of_access_point = |instead: &StartDeviation| matches!(instead, StartDeviation::AccessPointIdent(_));
        if self.persona.expects == ExpectedSubmodules::Module && start.instead.iter().any(of_access_point) {
            return Some("it expects no access point, so it cannot expect another one".to_owned());
        }
        let (slow, watchdog) = (self.slow?, start.watchdog?);
        (watchdog < slow * SAMPLES).then(|| format!("a watchdog of {watchdog:?} is too short for a cycle of {slow:?}"))
    }

    fn step(&mut self, step: &TrialStep) -> Option<String> {
        match &step.verb {
            Verb::Connect { start, .. } => self.start(start),
            Verb::Expect { within, hold, .. } => self.deadline(within).or_else(|| self.held(hold)),
            Verb::Wait(span) => self.time(span, "a pause"),
            Verb::Block { observe, .. } => observe.iter().find_map(|observation| match observation {
                BlockObservation::Rule { body, .. } => self.rule(body),
                BlockObservation::Count { condition, .. } => self.frame_by_frame(condition.names()),
                BlockObservation::Sequence { names, .. } => self.frame_by_frame(names.iter().flat_map(Program::names)),
            }),
            _ => None,
        }
    }

    /// A condition that is counted or followed frame by frame: with a slower cycle there are fewer frames.
    fn frame_by_frame(&self, mut names: impl Iterator<Item = NameId>) -> Option<String> {
        let slow = self.slow?;
        let kind = |name: NameId| self.variant?.names.get(name.0 as usize);
        let is_seen_in_frames = |name: NameId| !matches!(kind(name), Some(NameKind::Event(_)));
        names
            .any(is_seen_in_frames)
            .then(|| format!("counts and sequences of frames do not apply with a cycle of {slow:?}"))
    }

    fn rule(&self, body: &RuleBody) -> Option<String> {
        match body {
            RuleBody::Always(_) => None,
            RuleBody::When { within, hold, .. } => self.deadline(within).or_else(|| self.held(hold)),
        }
    }

    fn deadline(&self, within: &Deadline) -> Option<String> {
        let (slow, deadline) = (self.slow?, time(&within.limit)?);
        let more = slack(self.persona, self.device);
        (deadline < more * 2).then(|| format!("a deadline of {deadline:?} cannot be judged with a cycle of {slow:?}"))
    }

    fn held(&self, hold: &HoldTime) -> Option<String> {
        match hold {
            HoldTime::For(span) => self.time(span, "a time"),
            HoldTime::None | HoldTime::Until(_) => None,
        }
    }

    fn time(&self, span: &TimeSpan, what: &str) -> Option<String> {
        let (slow, time) = (self.slow?, time(span)?);
        (time < slow * SAMPLES).then(|| format!("{what} of {time:?} is too short for a cycle of {slow:?}"))
    }
}

/// The constant time of a span; `None` for cycles, computed times, and zero.
fn time(span: &TimeSpan) -> Option<Duration> {
    let time = match span {
        TimeSpan::Time(time) => *time,
        TimeSpan::Cycles(_) => return None,
        TimeSpan::Computed(program) => match program.constant()? {
            Value::Time(nanos) => Duration::try_from_secs_f64(nanos.to_f64() / 1e9).ok()?,
            _ => return None,
        },
    };
    (!time.is_zero()).then_some(time)
}
