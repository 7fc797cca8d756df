//! Evaluates rules on connections or over a block of steps.

use super::condition::ConditionState;
use super::evidence::{self, Blip, Evidence, Suspicion, SuspicionState};
use super::image::CurrentEvent;
use super::slow::SlowReaction;
use super::tracked_inputs::{self, TrackedInputs};
use super::view::{NameView, Reads};
use super::violation::RuleViolation;
use super::window::{Stay, TimeWindow, WindowOutcome};
use super::wire_position::{WirePosition, decisive, is_input, place_of};
use super::{JudgeTick, TickKind, Truth};
use expression::{HistoryState, NameId, Value};
use results::outcome::{DecisionCounts, JudgedPart};
use station::{Duration, Time};
use suite::model::{Condition, Deadline, HoldTime, RuleBody, TimeSpan};

/// Open windows with the same future outcome, and the tick that opened the first one.
#[derive(Debug)]
struct OpenWindows {
    window: TimeWindow,
    limit: Duration,
    trigger: JudgeTick,
    count: u64,
    /// Number of samples in the window.
    samples: u64,
}

/// A rule and its state over consecutive connections.
#[derive(Debug)]
pub struct RuleWatch<'a> {
    body: &'a RuleBody,
    premise: HistoryState,
    condition: ConditionState,
    end: ConditionState,
    open: Vec<OpenWindows>,
    closed: bool,
    last: Option<JudgeTick>,
    decided: DecisionCounts,
    slow: Option<SlowReaction>,
    violation: Option<Box<RuleViolation>>,
    watchdog: Duration,
    steady: TrackedInputs<RuleResults>,
    /// What its programs read.
    reads: Reads,
    /// Whether the condition uses history functions.
    looks_back: bool,
    /// Set for recordings, in which one frame does not prove a violation.
    suspicion: Option<Box<Suspicion>>,
    /// Whether only the current frame shows a violation.
    is_in_doubt: bool,
    /// Whether there is a new violation or suspected violation.
    pub(super) has_new_violation: bool,
}

/// Results of the programs of a rule, as far as evaluated.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RuleResults {
    /// The condition of `always` or `then`.
    truth: Option<Truth>,
    premise: Option<Option<bool>>,
    end: Option<Truth>,
}

impl<'a> RuleWatch<'a> {
    /// A rule in its initial state; a hold without samples for longer than `watchdog` is undecided.
    pub fn new(body: &'a RuleBody, watchdog: Duration) -> RuleWatch<'a> {
        let (RuleBody::Always(condition) | RuleBody::When { then: condition, .. }) = body;
        RuleWatch {
            body,
            premise: HistoryState::default(),
            condition: ConditionState::default(),
            end: ConditionState::default(),
            open: Vec::new(),
            closed: false,
            last: None,
            decided: DecisionCounts::default(),
            slow: None,
            violation: None,
            watchdog,
            steady: TrackedInputs::default(),
            reads: Reads::default(),
            looks_back: evidence::uses_history(condition),
            suspicion: None,
            is_in_doubt: false,
            has_new_violation: false,
        }
    }

    /// Switches to a recording: violations shown by a single frame are kept separate.
    #[must_use]
    pub fn recorded(self) -> RuleWatch<'a> {
        RuleWatch { suspicion: Some(Box::default()), ..self }
    }

    /// Returns to the initial state: the rule was violated, and is judged again.
    pub(super) fn begin_afresh(&mut self) {
        let fresh = RuleWatch::new(self.body, self.watchdog);
        let is_recorded = self.suspicion.is_some();
        *self = RuleWatch { decided: self.decided, ..if is_recorded { fresh.recorded() } else { fresh } };
    }

    /// How often the rule was decided.
    pub fn decided(&self) -> DecisionCounts {
        self.decided
    }

    /// What came later than the limit of the rule, which is ours, but not too late.
    pub fn slow(&self) -> Option<SlowReaction> {
        self.slow
    }

    /// The first violation.
    pub fn violation(&self) -> Option<&RuleViolation> {
        self.violation.as_deref()
    }

    /// The first violation shown by one frame only, if no violation is proven.
    pub fn unconfirmed(&self) -> Option<&RuleViolation> {
        self.suspicion.as_ref().and_then(|suspicion| suspicion.alone()).filter(|_| self.violation.is_none())
    }

    /// Whether windows are open.
    pub fn is_waiting(&self) -> bool {
        self.violation.is_none() && !self.open.is_empty()
    }

    /// Whether a window is past its limit, which is ours, and not decided yet.
    pub fn is_late(&self, now: Time) -> bool {
        self.violation.is_none() && self.open.iter().any(|open| open.window.is_late(now))
    }

    /// Stores the values before the first frame, so that a change in that frame is detected.
    pub fn begin_with(&mut self, view: &NameView<'_>) {
        self.advance(view);
        self.steady.forget();
    }

    /// Whether the next frame of this kind gives the same result if it changes no input of the rule.
    pub(super) fn is_idle(&self, place: usize) -> bool {
        if self.violation.is_some() {
            return true;
        }
        let waits = self.is_waiting() || self.suspicion.as_ref().is_some_and(|suspicion| suspicion.is_open());
        match (waits, self.steady.stored(place), self.body) {
            (true, ..) => false,
            // Frames to the device are not judged.
            (_, None, RuleBody::Always(_)) => place == tracked_inputs::OUTPUT && !self.looks_back,
            (_, None, RuleBody::When { .. }) => false,
            (_, Some(known), RuleBody::Always(_)) => {
                place == tracked_inputs::OUTPUT || matches!(known.truth, Some(Truth::True | Truth::Unknown))
            }
            (_, Some(known), RuleBody::When { .. }) => matches!(known.premise, Some(None | Some(false))),
        }
    }

    /// Whether an evaluation at this frame would give the stored result and leave the state unchanged.
    pub(super) fn matches_stored(&self, place: usize, view: &NameView<'_>) -> bool {
        let Some(kept) = self.steady.stored(place).filter(|_| self.violation.is_none()) else { return true };
        let (RuleBody::Always(condition) | RuleBody::When { then: condition, .. }) = self.body;
        let is_true_as_kept = kept.truth.is_none_or(|truth| truth == self.condition.truth(condition, view));
        let begins_as_kept = match self.body {
            RuleBody::Always(_) => true,
            RuleBody::When { premise, .. } => {
                let remembered = !self.premise.clone().advance(premise, view);
                remembered && kept.premise.is_none_or(|begins| begins == premise.truth(view, &self.premise))
            }
        };
        is_true_as_kept && begins_as_kept && !self.condition.clone().advance(condition, view)
    }

    /// Counts frames of a kind with the stored result, which were not evaluated.
    pub(super) fn count(&mut self, place: usize, frames: u64) {
        if self.violation.is_some() {
            return;
        }
        self.decided.checked += frames;
        if let (RuleBody::Always(_), false, Some(known)) =
            (self.body, place == tracked_inputs::OUTPUT, self.steady.stored(place))
        {
            match known.truth {
                Some(Truth::True) => self.decided.premises += frames,
                Some(Truth::Unknown) => self.decided.undecided += frames,
                Some(Truth::False) | None => {}
            }
        }
    }

    /// The inputs of the rule on the current connection.
    pub(super) fn steady(&mut self) -> &mut TrackedInputs<RuleResults> {
        &mut self.steady
    }

    /// Stops judging: premises open no windows and `always` is not judged; open windows continue.
    pub fn close(&mut self) {
        self.closed = true;
    }

    /// Evaluates the rule at a frame or event; returns whether it applied to the event of this tick.
    pub fn tick(&mut self, view: &NameView<'_>) -> bool {
        if self.violation.is_some() || self.closed && self.open.is_empty() {
            return false;
        }
        if self.suspicion.as_ref().is_some_and(|suspicion| suspicion.is_open()) && self.is_confirmed(view) {
            return false;
        }
        self.decided.checked += 1;
        let before = self.steady.known(self.body, view);
        let mut known = before.unwrap_or_default();
        let mut reads = std::mem::take(&mut self.reads);
        let noted = NameView { reads: Some(&reads), ..*view };
        let speaks = self.judge(&noted, &mut known);
        // With unchanged inputs and states the states stay unchanged.
        let moved = before.is_none() && self.advance(&noted);
        self.steady.keep(view, known, moved);
        self.steady.record_reads(&mut reads);
        reads.clear();
        self.reads = reads;
        if std::mem::take(&mut self.is_in_doubt) {
            self.forget();
        }
        self.last = Some(view.tick);
        speaks
    }

    fn judge(&mut self, view: &NameView<'_>, known: &mut RuleResults) -> bool {
        match self.body {
            RuleBody::Always(condition) => {
                if !view.tick.kind.is_judged() {
                    return false;
                }
                let truth = *known.truth.get_or_insert_with(|| self.condition.truth(condition, view));
                match truth {
                    Truth::True => self.decided.premises += 1,
                    Truth::Unknown => self.decided.undecided += 1,
                    Truth::False => {
                        self.decided.premises += 1;
                        let parts = self.condition.parts(condition, view);
                        let is_unique = evidence::uses_events(condition, view) || self.looks_back;
                        let evidence = if is_unique { Evidence::Once } else { Evidence::Frame };
                        self.break_with("the condition does not hold", view, (view.tick, None), parts, evidence);
                    }
                }
                truth != Truth::Unknown && names_happening(condition, view)
            }
            RuleBody::When { premise, then, within, hold } => {
                let mut speaks = false;
                if !self.closed {
                    let begins = *known.premise.get_or_insert_with(|| premise.truth(view, &self.premise));
                    if begins == Some(true) {
                        speaks = premise.names().any(|name| view.is_happening(name));
                        self.open_window(within, hold, view);
                    }
                }
                if !self.open.is_empty() {
                    speaks |= self.look(view, then, hold, known) == Truth::True && names_happening(then, view);
                }
                speaks
            }
        }
    }

    /// Moves on to the next observation; returns whether a state has changed.
    fn advance(&mut self, view: &NameView<'_>) -> bool {
        let (RuleBody::Always(condition) | RuleBody::When { then: condition, .. }) = self.body;
        let mut changed = self.condition.advance(condition, view);
        if let RuleBody::When { premise, hold, .. } = self.body {
            changed |= self.premise.advance(premise, view);
            if let HoldTime::Until(end) = hold {
                changed |= self.end.advance(end, view);
            }
        }
        changed
    }

    /// Opens the window of a premise; with unknown length the premise is undecided.
    fn open_window(&mut self, within: &Deadline, hold: &HoldTime, view: &NameView<'_>) {
        let slack = view.notebook.slack;
        let (Some((limit, patient)), Some(stay)) = (deadline(within, view), stay(hold, view)) else {
            self.decided.undecided += 1;
            return;
        };
        let window = TimeWindow::open(view.tick.time, limit, slack, stay, self.watchdog);
        let window = window.patient(patient.unwrap_or(limit), slack).of_rule();
        let window = if view.tick.kind == TickKind::Event { window.by_event() } else { window };
        self.open.push(OpenWindows { window, limit, trigger: view.tick, count: 1, samples: 0 });
    }

    fn look(&mut self, view: &NameView<'_>, then: &Condition, hold: &HoldTime, known: &mut RuleResults) -> Truth {
        let truth = *known.truth.get_or_insert_with(|| self.condition.truth(then, view));
        let end = match hold {
            HoldTime::Until(end) => *known.end.get_or_insert_with(|| self.end.truth(end, view)),
            HoldTime::None | HoldTime::For(_) => Truth::False,
        };
        let is_sample = matches!(view.tick.kind, TickKind::Sample | TickKind::BadSample);
        for open in &mut self.open {
            open.samples += u64::from(is_sample);
            open.window.tick(view.tick, truth, end);
        }
        self.settle(then, view, view.tick);
        // A premise that stays true opens a window at every frame; equivalent windows are merged.
        self.open.dedup_by(|later, earlier| {
            let like = later.window.is_like(&earlier.window);
            earlier.count += if like { later.count } else { 0 };
            like
        });
        truth
    }

    /// Removes decided windows; the first failed one becomes the violation.
    fn settle(&mut self, then: &Condition, view: &NameView<'_>, tick: JudgeTick) {
        let mut broken = None;
        let (decided, slow) = (&mut self.decided, &mut self.slow);
        self.open.retain(|OpenWindows { window, limit, trigger, count, samples }| {
            match window.outcome() {
                WindowOutcome::Open => return true,
                WindowOutcome::Held => {
                    decided.premises += count;
                    if let Some(took) = window.slow() {
                        let late = SlowReaction { took, limit: *limit, trigger: *trigger, times: *count };
                        *slow = SlowReaction::of_both(*slow, Some(late));
                    }
                }
                WindowOutcome::Undecided | WindowOutcome::Starved(_) => decided.undecided += count,
                WindowOutcome::Late(at) => {
                    decided.premises += count;
                    let how = "the condition did not become true in time";
                    broken.get_or_insert((how, at.unwrap_or(tick), *trigger, *samples));
                }
                WindowOutcome::Relapsed(at) => {
                    decided.premises += count;
                    broken.get_or_insert(("the condition did not stay true", at, *trigger, 1));
                }
            }
            false
        });
        if let Some((how, at, trigger, samples)) = broken {
            let parts = self.condition.parts(then, view);
            let evidence = if trigger.kind == TickKind::Event || evidence::uses_events(then, view) {
                Evidence::Once
            } else if samples > 1 {
                Evidence::Frames
            } else if self.looks_back {
                Evidence::Once
            } else {
                Evidence::Frame
            };
            self.break_with(how, view, (at, Some(trigger)), parts, evidence);
        }
    }

    /// Advances time without a frame.
    pub fn time(&mut self, view: &NameView<'_>, now: Time) {
        if self.open.is_empty() {
            return;
        }
        for open in &mut self.open {
            open.window.time(now);
        }
        if let (RuleBody::When { then, .. }, Some(last)) = (self.body, self.last) {
            self.settle(then, view, last);
        }
    }

    /// Whether this frame confirms a violation shown by an earlier frame.
    fn is_confirmed(&mut self, view: &NameView<'_>) -> bool {
        let (RuleBody::Always(condition) | RuleBody::When { then: condition, .. }) = self.body;
        let Some(suspicion) = self.suspicion.as_mut().filter(|_| view.tick.kind == TickKind::Sample) else {
            return false;
        };
        let verdict = suspicion.confirm(view.image, || self.condition.truth(condition, view));
        self.take(verdict)
    }

    /// Revokes windows and violations that are based on a frame whose bits the next frame changed back.
    pub(super) fn take_back(&mut self, blip: &Blip<'_>) {
        if !self.steady.uses_bits(blip.direction, blip.bits) {
            return;
        }
        let (open, undecided) = (&mut self.open, &mut self.decided.undecided);
        open.retain(|open| {
            let rests = open.trigger.frame >= blip.frame;
            *undecided += if rests { open.count } else { 0 };
            !rests
        });
        if let Some(suspicion) = &mut self.suspicion {
            let verdict = suspicion.give_up(blip.frame);
            self.take(verdict);
        }
        self.forget();
    }

    fn take(&mut self, verdict: SuspicionState) -> bool {
        match verdict {
            SuspicionState::Proven(violation) => {
                self.violation = Some(violation);
                self.has_new_violation = true;
            }
            SuspicionState::Alone => {
                self.has_new_violation = true;
                self.decided.premises = self.decided.premises.saturating_sub(1);
                self.decided.undecided += 1;
            }
            SuspicionState::Open => {}
        }
        self.violation.is_some()
    }

    fn forget(&mut self) {
        self.premise.forget();
        self.condition.forget();
        self.end.forget();
        self.steady.forget();
    }

    /// Ends open windows and clears the states, at the end of a connection or trace or at a gap.
    pub fn cut(&mut self) {
        self.decided.undecided += self.open.iter().map(|open| open.count).sum::<u64>();
        self.open.clear();
        if let Some(suspicion) = &mut self.suspicion {
            let verdict = suspicion.give_up(0);
            self.take(verdict);
        }
        self.forget();
    }

    fn break_with(
        &mut self,
        how: &str,
        view: &NameView<'_>,
        (tick, trigger): (JudgeTick, Option<JudgeTick>),
        parts: Vec<JudgedPart>,
        evidence: Evidence,
    ) {
        let (mut names, mut premises) = (Vec::new(), Vec::new());
        let (RuleBody::Always(condition) | RuleBody::When { then: condition, .. }) = self.body;
        condition.each_name(&mut |name| names.push(name));
        if let RuleBody::When { premise, .. } = self.body {
            premises.extend(premise.names());
        }
        // Prefer a name of the condition, then of the premise, in the frame at which the violation was detected. An `always`
        // may be violated by a value that was received before the first judged frame.
        let of = |names: &[NameId], anywhere: bool| {
            let places = names.iter().map(|name| (*name, place_of(*name, view)));
            let meant = |place: Option<WirePosition>| place.is_some_and(|(frame, ..)| anywhere || frame == tick.frame);
            let meant: Vec<_> = places.filter(|(_, place)| meant(*place)).collect();
            decisive(&meant, &parts, view)
        };
        let held_before = || of(&names, true).filter(|_| matches!(self.body, RuleBody::Always(_)));
        // A missed deadline is detected at a later frame, in which the value is at the same offset.
        let inputs: Vec<NameId> = names.iter().copied().filter(|name| is_input(*name, view)).collect();
        let at_a_sample = matches!(tick.kind, TickKind::Sample | TickKind::BadSample);
        let later = || of(&inputs, true).filter(|_| at_a_sample).map(|(_, octet, bit)| (tick.frame, octet, bit));
        let place = of(&names, false).or_else(|| of(&premises, false)).or_else(held_before).or_else(later);
        let violation = RuleViolation { tick, trigger, how: how.to_owned(), parts, names, place };
        match &mut self.suspicion {
            None => {
                self.violation = Some(Box::new(violation));
                self.has_new_violation = true;
            }
            Some(suspicion) => {
                let verdict = suspicion.add(violation, evidence, view.image);
                if !self.take(verdict) {
                    // History functions must not compare the next frame with this one.
                    self.is_in_doubt = true;
                }
            }
        }
    }
}

/// Whether a condition uses the event at the instant of `view`.
fn names_happening(condition: &Condition, view: &NameView<'_>) -> bool {
    if view.image.happening == CurrentEvent::Nothing {
        return false;
    }
    let mut found = false;
    condition.each_name(&mut |name| found |= view.is_happening(name));
    found
}

/// The limit of a deadline, and if it is ours, up to when it is only noted; `None` if unknown.
pub fn deadline(deadline: &Deadline, view: &NameView<'_>) -> Option<(Duration, Option<Duration>)> {
    let limit = length(&deadline.limit, view)?;
    match &deadline.ours {
        None => Some((limit, None)),
        Some(ours) => Some((limit, Some(length(&ours.patient, view)?))),
    }
}

/// The duration of a span, with the current cycle and values; `None` if unknown.
pub fn length(span: &TimeSpan, view: &NameView<'_>) -> Option<Duration> {
    match span {
        TimeSpan::Time(time) => Some(*time),
        TimeSpan::Cycles(cycles) => Some(view.image.cycle()? * u32::try_from(*cycles).unwrap_or(u32::MAX)),
        TimeSpan::Computed(program) => match program.eval(view, &HistoryState::default()) {
            Value::Time(nanos) => u64::try_from(nanos.as_whole()?).ok().map(Duration::from_nanos),
            Value::Cycles(cycles) => Some(view.image.cycle()? * u32::try_from(cycles.as_whole()?).ok()?),
            _ => None,
        },
    }
}

/// A hold with its duration; `None` if unknown.
pub fn stay(hold: &HoldTime, view: &NameView<'_>) -> Option<Stay> {
    Some(match hold {
        HoldTime::None => Stay::No,
        HoldTime::For(span) => Stay::For(length(span, view)?),
        HoldTime::Until(_) => Stay::Until,
    })
}
