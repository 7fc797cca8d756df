//! An `expect` step: its condition with its window, fed with every frame and event.

use expression::NameId;
use judge::condition::ConditionState;
use judge::rule::{deadline, stay};
use judge::slow::{self, SlowReaction};
use judge::tracked_inputs::TrackedInputs;
use judge::view::NameView;
use judge::window::{Stay, TimeWindow, WindowOutcome};
use judge::wire_position::{WirePosition, place_of};
use judge::{JudgeTick, Truth};
use results::outcome::JudgedPart;
use station::{Duration, Time};
use suite::device::NameKind;
use suite::model::{Condition, Deadline, HoldTime};

/// The state at the instant that decided an expectation.
#[derive(Clone, Debug)]
pub struct DecisiveInstant {
    /// Time and frame.
    pub tick: JudgeTick,
    /// The parts of the condition with their values.
    pub parts: Vec<JudgedPart>,
    /// The position of each name of the condition in the frame.
    pub places: Vec<(NameId, Option<WirePosition>)>,
}

impl DecisiveInstant {
    /// Moves the same parts to another frame.
    fn again(&mut self, view: &NameView<'_>) {
        self.tick = view.tick;
        self.places.iter_mut().for_each(|(name, place)| *place = place_of(*name, view));
    }
}

/// The evaluation of an `expect` step.
pub struct Expectation<'a> {
    condition: &'a Condition,
    hold: &'a HoldTime,
    memory: ConditionState,
    end: ConditionState,
    within: &'a Deadline,
    window: TimeWindow,
    opened: JudgeTick,
    limit: Duration,
    patient: Option<Duration>,
    slack: Duration,
    events: bool,
    steady: TrackedInputs<EvaluatedConditions>,
    latest: Option<DecisiveInstant>,
    decisive: Option<DecisiveInstant>,
}

/// The truth of its conditions, as far as evaluated.
#[derive(Clone, Copy, Debug, Default)]
struct EvaluatedConditions {
    truth: Option<Truth>,
    end: Option<Truth>,
}

impl<'a> Expectation<'a> {
    /// Opens the window of an `expect` at `opened`; `view` is the state before the first frame.
    ///
    /// It is undecided from the begin if its length is unknown.
    pub fn open(
        condition: &'a Condition,
        within: &'a Deadline,
        hold: &'a HoldTime,
        (opened, slack, watchdog): (Time, Duration, Duration),
        view: &NameView<'_>,
    ) -> Expectation<'a> {
        let (length, held) = (deadline(within, view), stay(hold, view));
        let known = length.is_some() && held.is_some();
        let (limit, patient) = length.unwrap_or_default();
        let window = TimeWindow::open(opened, limit, slack, held.unwrap_or(Stay::No), watchdog);
        let window = window.patient(patient.unwrap_or(limit), slack);
        let mut expectation = Expectation {
            condition,
            hold,
            memory: ConditionState::default(),
            end: ConditionState::default(),
            within,
            window,
            opened: JudgeTick { time: opened, ..view.tick },
            limit,
            patient,
            slack,
            events: uses_events(condition, view),
            steady: TrackedInputs::default(),
            latest: None,
            decisive: None,
        };
        if !known {
            expectation.latest = Some(expectation.snapshot(view));
            expectation.window.cut();
        }
        expectation.begin_with(view);
        expectation
    }

    /// Remembers the state before the first frame, so that a change in that frame counts as a change.
    pub fn begin_with(&mut self, view: &NameView<'_>) {
        self.memory.forget();
        self.end.forget();
        self.steady.forget();
        self.advance(view);
    }

    /// Advances the memory to the next observation; returns whether it changed.
    fn advance(&mut self, view: &NameView<'_>) -> bool {
        let mut changed = self.memory.advance(self.condition, view);
        if let HoldTime::Until(end) = self.hold {
            changed |= self.end.advance(end, view);
        }
        changed
    }

    /// Whether its condition uses an event, which may have come before the step began.
    pub fn uses_events(&self) -> bool {
        self.events
    }

    /// The result so far.
    pub fn outcome(&self) -> WindowOutcome {
        self.window.outcome()
    }

    /// Gives up what is past its limit: it is not waited any longer.
    pub fn be_strict(&mut self) {
        self.window.be_strict();
        self.patient = None;
    }

    /// Whether it is past its limit, which is ours, and only its patience lasts.
    pub fn is_past_limit(&self, now: Time) -> bool {
        self.patient.is_some() && now > self.opened.time + self.limit + self.slack
    }

    /// How long it may take, in words; `None`: the very next sample decides.
    pub fn allowed(&self) -> Option<String> {
        match (self.patient, &self.within.ours) {
            (Some(patient), Some(ours)) if patient > self.limit => {
                Some(slow::waited(self.limit + self.slack, patient + self.slack, ours))
            }
            _ if (self.limit + self.slack).is_zero() => None,
            _ => Some(format!("{:?}", self.limit + self.slack)),
        }
    }

    /// How slow it was, if it came later than a limit of ours.
    pub fn slow(&self) -> Option<SlowReaction> {
        let took = self.window.slow().filter(|_| self.window.outcome() == WindowOutcome::Held)?;
        Some(SlowReaction { took, limit: self.limit, trigger: self.opened, times: 1 })
    }

    /// The instant that decided, or the last one checked.
    pub fn instant(&self) -> Option<&DecisiveInstant> {
        self.decisive.as_ref().or(self.latest.as_ref())
    }

    /// The next time at which it may be decided by time alone.
    pub fn wake(&self) -> Option<Time> {
        self.window.wake()
    }

    /// Ends it undecided: no more frames come.
    pub fn end_undecided(&mut self) {
        self.window.cut();
    }

    /// Takes in a frame or an event; returns whether it satisfied the expectation.
    pub fn tick(&mut self, view: &NameView<'_>) -> bool {
        if self.window.outcome() != WindowOutcome::Open {
            return false;
        }
        let before = self.steady.known(&(self.condition, self.hold), view);
        let mut known = before.unwrap_or_default();
        let mut satisfied = false;
        if view.tick.kind.is_judged() {
            let truth = *known.truth.get_or_insert_with(|| self.memory.truth(self.condition, view));
            let end = match self.hold {
                HoldTime::Until(end) if self.window.needs_end() => {
                    *known.end.get_or_insert_with(|| self.end.truth(end, view))
                }
                HoldTime::Until(_) | HoldTime::None | HoldTime::For(_) => Truth::False,
            };
            let outcome = self.window.tick(view.tick, truth, end);
            satisfied = outcome == WindowOutcome::Held;
            if truth != Truth::True {
                match (outcome, &mut self.latest) {
                    (WindowOutcome::Relapsed(_) | WindowOutcome::Late(_) | WindowOutcome::Undecided, _) => {
                        self.decisive = Some(self.snapshot(view));
                    }
                    // Only the frame has changed.
                    (_, Some(latest)) if before.is_some() => latest.again(view),
                    (WindowOutcome::Open | WindowOutcome::Held | WindowOutcome::Starved(_), _) => {
                        self.latest = Some(self.snapshot(view))
                    }
                }
            }
        }
        let moved = before.is_none() && self.advance(view);
        self.steady.keep(view, known, moved);
        satisfied
    }

    /// Advances the time without a frame.
    pub fn time(&mut self, view: &NameView<'_>, now: Time) {
        if self.window.outcome() == WindowOutcome::Open
            && self.window.time(now) != WindowOutcome::Open
            && self.latest.is_none()
        {
            self.latest = Some(self.snapshot(view));
        }
    }

    /// Whether the condition holds at `view`, without memory of earlier values.
    pub fn holds_at(condition: &Condition, view: &NameView<'_>) -> bool {
        ConditionState::default().truth(condition, view) == Truth::True
    }

    fn snapshot(&self, view: &NameView<'_>) -> DecisiveInstant {
        let mut names = Vec::new();
        self.condition.each_name(&mut |name| names.push(name));
        let places = names.into_iter().map(|name| (name, place_of(name, view))).collect();
        DecisiveInstant { tick: view.tick, parts: self.memory.parts(self.condition, view), places }
    }
}

/// Whether a condition uses an event.
pub fn uses_events(condition: &Condition, view: &NameView<'_>) -> bool {
    let mut found = false;
    condition.each_name(&mut |name| {
        found |= matches!(view.variant.names.get(name.0 as usize), Some(NameKind::Event(_)));
    });
    found
}
