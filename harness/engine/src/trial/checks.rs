//! The verbs that check: `expect`, blocks with observations, and readings of the manual.

use super::step_error::{BoxedStepError, StepError, StepResult};
use super::verbs::LocatedStepResult;
use super::{LONGEST_HOLD, RunningTrial, StepCheck};
use crate::block::BlockWatch;
use crate::expect::{Expectation, uses_events};
use judge::answer::ReceivedReply;
use judge::view::NameView;
use judge::window::WindowOutcome as Decision;
use judge::wire_position::decisive;
use results::outcome::{FailureCause, JudgedPart};
use results::verdict::Verdict;
use station::{Duration, Time};
use std::mem;
use suite::device::NameKind;
use suite::model::{AnswerPart, Condition, Deadline, HoldTime, ManualReading, TrialStep, Verb};

/// A step that waits for a sample of a dead connection gives up after this time.
pub const NO_SAMPLE: Duration = Duration::from_millis(500);
/// The time between two queries of the stand, if nothing expected comes with the cyclic frames.
const LOOK: Duration = Duration::from_millis(10);
/// How long a hold may last without a query of the stand, since a query takes time on a live bench.
const NO_LOOK: Duration = Duration::from_secs(1);

/// A reading that holds, and what did not hold in those before.
type HeldReading<'a> = (&'a ManualReading, Vec<JudgedPart>);
/// The trouble that weighs most among readings that do not hold, and what did not hold.
type FailedReadings = (Option<BoxedStepError>, Vec<JudgedPart>);

impl<'a> RunningTrial<'a> {
    /// Opens the window of an expectation and waits until it is decided.
    pub fn expect(
        &mut self,
        step: &'a TrialStep,
        condition: &'a Condition,
        within: &'a Deadline,
        hold: &'a HoldTime,
    ) -> StepResult {
        let by_itself = self.comes_by_itself(condition);
        if matches!(hold, HoldTime::None) {
            self.reject_already_true(condition)?;
        }
        self.checks += 1;
        if matches!(hold, HoldTime::None)
            && uses_events(condition, &self.world.view())
            && self.take_earlier_event(condition)
        {
            return Ok(());
        }
        let began = self.world.now();
        let looks = self.needs_stand_queries(condition);
        let (slack, watchdog) = (self.slack, self.without_sample(looks));
        let expectation = Expectation::open(condition, within, hold, (began, slack, watchdog), &self.world.view());
        self.world.judges.expecting = Some(expectation);
        if !by_itself {
            self.world.evaluate_now();
        }
        self.until_decided(began, looks, by_itself);
        let Some(expectation) = self.world.judges.expecting.take() else { return Ok(()) };
        self.note_slow(step, within, expectation.slow());
        decision(&expectation, &self.world.view())
    }

    /// Runs until the present expectation is decided.
    ///
    /// With `looks` the stand is queried, and each query is a sample.
    ///
    /// What comes with the frames of a connection that has ended is not waited for beyond its limit.
    fn until_decided(&mut self, began: Time, looks: bool, by_itself: bool) {
        let mut next = began + LOOK;
        loop {
            let now = self.world.now();
            let hopeless = by_itself && !self.world.stations.is_connected(0);
            let longest = now.since(began) > LONGEST_HOLD || self.world.stop_reason().is_some();
            let Some(expecting) = &mut self.world.judges.expecting else { return };
            if expecting.outcome() != Decision::Open {
                return;
            }
            if hopeless && expecting.is_past_limit(now) {
                expecting.be_strict();
            }
            let until = expecting.wake().unwrap_or(now + NO_SAMPLE + self.world.watchdog);
            if looks && now >= next {
                next = now + LOOK;
                self.world.evaluate_stand();
                continue;
            }
            let until = if looks { until.min(next) } else { until };
            let quiet = self.world.last_sample.map_or(began, |tick| tick.time.max(began));
            if longest || (expecting.wake().is_none() && now.since(quiet) > NO_SAMPLE + self.world.watchdog) {
                expecting.end_undecided();
                return;
            }
            self.world.run(until.max(now + Duration::from_nanos(1)), |world| {
                world.judges.expecting.as_ref().is_none_or(|expecting| expecting.outcome() != Decision::Open)
            });
        }
    }

    /// Whether only a query of the stand can decide: the condition uses LEDs and nothing that comes by itself.
    fn needs_stand_queries(&self, condition: &Condition) -> bool {
        let mut leds = false;
        let mut events = false;
        condition.each_name(&mut |name| {
            leds |= matches!(self.kind(name), Some(NameKind::Led(_)));
            events |= matches!(self.kind(name), Some(NameKind::Event(_)));
        });
        leds && !events && !self.comes_by_itself(condition)
    }

    /// How long a hold may last without a sample.
    fn without_sample(&self, looks: bool) -> Duration {
        let frames = self.world.watchdog * 2;
        if looks { frames.max(NO_LOOK) } else { frames }
    }

    /// Whether the condition has a name that comes with the cyclic frames, so that there is a sample to wait for.
    fn comes_by_itself(&self, condition: &Condition) -> bool {
        let mut any = false;
        condition.each_name(&mut |name| {
            any |= self.kind(name).is_some_and(|kind| kind.observability().comes_by_itself);
        });
        any
    }

    /// Whether the condition has a name without a value at the last sample: acyclic names and LEDs.
    fn uses_acyclic_names(&self, condition: &Condition) -> bool {
        let mut any = false;
        condition.each_name(&mut |name| {
            any |= self.kind(name).is_some_and(|kind| kind.observability().is_beyond_samples);
        });
        any
    }

    /// Rejects an expectation that was true before the last action: it cannot tell a device that reacts from one that does not.
    fn reject_already_true(&self, condition: &'a Condition) -> StepResult {
        if !self.comes_by_itself(condition) || self.uses_acyclic_names(condition) {
            return Ok(());
        }
        let (Some(image), Some(last)) = (&self.before_action, self.world.last_sample) else { return Ok(()) };
        let view = judge::view::NameView { image, ..self.world.view_at(last) };
        if image.stands() && Expectation::holds_at(condition, &view) && !uses_events(condition, &view) {
            let what = "The expectation was already true before the last action, so it proves nothing; use `for`.";
            return Err(if !self.world.segment.is_model() {
                let what = "The expectation was already true before the last action, so it proves nothing: the device does this by \
                            itself, or an earlier trial left it so.";
                StepError::other(FailureCause::Undecided, Verdict::Inconclusive, what)
            } else if self.environment.deviates {
                // On a conforming device it would not have been true before.
                StepError::device("It was already true before the last action.", Vec::new())
            } else {
                StepError::other(FailureCause::Suite, Verdict::Error, what)
            });
        }
        Ok(())
    }

    /// Searches for an event since the last action.
    fn take_earlier_event(&mut self, condition: &Condition) -> bool {
        let view = self.world.view();
        let found = self.world.events.iter().position(|event| {
            let view = judge::view::NameView { image: &event.image, tick: event.tick, ..view };
            !event.used && Expectation::holds_at(condition, &view)
        });
        if let Some(index) = found {
            self.world.events[index].used = true;
            self.world.expected_event = Some(index);
        }
        found.is_some()
    }

    /// Runs a block of steps `times` times, each time with its observations.
    pub fn block(
        &mut self,
        step: &'a TrialStep,
        steps: &'a [TrialStep],
        times: u32,
        observe: &'a [suite::model::BlockObservation],
    ) -> LocatedStepResult<'a> {
        for repetition in 0..times {
            if !observe.is_empty() {
                let mut watch = BlockWatch::begin(observe, self.world.watchdog * 2);
                watch.begin_with(&self.world.view());
                self.world.judges.blocks.push(watch);
            }
            let outcome = self.steps(steps);
            if observe.is_empty() {
                outcome?;
                continue;
            }
            if outcome.is_ok() {
                if let Some(block) = self.world.judges.blocks.last_mut() {
                    block.close();
                }
                let until = self.world.now() + LONGEST_HOLD;
                self.world.run(until, |world| {
                    world.lost.is_some() || world.judges.blocks.last().is_none_or(|block| !block.is_waiting())
                });
            }
            let watch = self.world.judges.blocks.pop();
            outcome?;
            let broken = watch.map(|watch| watch.end(&self.world.view())).unwrap_or_default();
            self.checks += observe.len() as u64;
            if let Some(first) = broken.into_iter().next() {
                let what = match times {
                    1 => first.what,
                    _ => format!("{} (repetition {} of {times})", first.what, repetition + 1),
                };
                let mut trouble = if first.undecided {
                    StepError::other(FailureCause::Environment, Verdict::Inconclusive, what)
                } else {
                    StepError::device(what, first.parts)
                };
                trouble.step = Some((first.text, first.at));
                trouble.frame = first.place.map(|(tick, _)| tick.frame);
                trouble.place = first.place.and_then(|(_, place)| place);
                return Err((trouble, step));
            }
        }
        Ok(())
    }

    /// Tries the readings of the manual in order and takes the first that holds; one that holds in time comes before a slow one. A
    /// reading that is a fault is taken only if no right one before it holds, however slow.
    pub fn either(&mut self, step: &'a TrialStep, readings: &'a [ManualReading]) -> LocatedStepResult<'a> {
        let answers = mem::take(&mut self.world.scene.notebook_mut().answers);
        self.world.record_from_here();
        (self.in_reading, self.is_strict) = (true, true);
        let in_time = self.first_that_holds(readings.iter(), &answers);
        self.is_strict = false;
        let found = match in_time {
            Ok((reading, parts)) if reading.finding.is_some() => {
                let before = readings.iter().take_while(|other| !std::ptr::eq(*other, reading));
                let right = before.filter(|other| other.finding.is_none() && is_patient(other));
                self.first_that_holds(right, &answers).or(Ok((reading, parts)))
            }
            Err(_) if readings.iter().any(is_patient) => self.first_that_holds(readings.iter(), &answers),
            found => found,
        };
        self.in_reading = false;
        self.world.stop_recording();
        match found {
            Ok((reading, parts)) => {
                self.readings.push((step.text.clone(), reading.name.clone()));
                let Some(finding) = &reading.finding else { return Ok(()) };
                self.findings.push((reading.name.clone(), finding.clone()));
                Err((StepError::device(finding.clone(), parts), step))
            }
            Err((last, parts)) => {
                let mut trouble = StepError::device("The device follows none of the readings of the manual.", parts);
                trouble.verdict = last.as_ref().and_then(|trouble| trouble.verdict);
                trouble.frame = last.and_then(|trouble| trouble.frame);
                Err((trouble, step))
            }
        }
    }

    /// The first of these readings that holds, with what did not hold before; or the trouble that weighs most, if none holds.
    fn first_that_holds(
        &mut self,
        readings: impl Iterator<Item = &'a ManualReading>,
        answers: &[(AnswerPart, ReceivedReply)],
    ) -> Result<HeldReading<'a>, FailedReadings> {
        let mut parts = Vec::new();
        let mut last: Option<BoxedStepError> = None;
        for reading in readings {
            self.world.scene.notebook_mut().answers = answers.to_vec();
            let used: Vec<bool> = self.world.events.iter().map(|event| event.used).collect();
            let slow = self.slow.len();
            match self.reading(&reading.steps) {
                Ok(()) => return Ok((reading, parts)),
                Err(trouble) => {
                    for part in &trouble.parts {
                        parts.push(JudgedPart { text: format!("{}: {}", reading.name, part.text), ..part.clone() });
                    }
                    // Each reading is judged as if it were the only one: events that it used are available to the next one.
                    let before = used.into_iter().chain(std::iter::repeat(false));
                    self.world.events.iter_mut().zip(before).for_each(|(event, used)| event.used = used);
                    self.slow.truncate(slow);
                    // A reading that the device did not follow weighs more than one that could not be judged.
                    if last.as_ref().is_none_or(|last| last.verdict.is_some()) {
                        last = Some(trouble);
                    }
                }
            }
        }
        Err((last, parts))
    }

    /// Judges a reading as if it were the only one: its expectations apply to everything since the begin of the step.
    fn reading(&mut self, steps: &'a [TrialStep]) -> StepResult {
        for step in steps {
            match &step.verb {
                Verb::Expect { condition, within, hold } => {
                    self.checks += 1;
                    let for_event = matches!(hold, HoldTime::None) && uses_events(condition, &self.world.view());
                    if for_event && self.take_earlier_event(condition) {
                        continue;
                    }
                    let began = self.world.recording_began();
                    let looks = self.needs_stand_queries(condition);
                    let (slack, watchdog) = (self.slack, self.without_sample(looks));
                    let mut expectation =
                        Expectation::open(condition, within, hold, (began, slack, watchdog), &self.world.view());
                    if self.is_strict {
                        expectation.be_strict();
                    }
                    if !for_event {
                        self.world.replay_recording(&mut expectation);
                    }
                    self.world.judges.expecting = Some(expectation);
                    if !self.comes_by_itself(condition) {
                        self.world.evaluate_now();
                    }
                    self.until_decided(began, looks, self.comes_by_itself(condition));
                    if let Some(expectation) = self.world.judges.expecting.take() {
                        decision(&expectation, &self.world.view())?;
                        self.note_slow(step, within, expectation.slow());
                    }
                }
                _ => self.verb(step).map_err(|(trouble, _)| trouble)?,
            }
        }
        for step in steps.iter().filter(|step| !step.covers.is_empty()) {
            self.checked.push(StepCheck { covers: step.covers.clone(), verdict: Verdict::Pass, failure: None });
        }
        Ok(())
    }
}

/// Whether a reading has a deadline of ours.
fn is_patient(reading: &ManualReading) -> bool {
    reading.steps.iter().any(|step| match &step.verb {
        Verb::Expect { within, .. } | Verb::Read { within: Some(within), .. } => within.ours.is_some(),
        _ => false,
    })
}

/// The result of an expectation.
fn decision(expectation: &Expectation<'_>, view: &NameView<'_>) -> StepResult {
    let instant = expectation.instant();
    let parts = instant.map_or_else(Vec::new, |instant| instant.parts.clone());
    let what = match expectation.outcome() {
        Decision::Held => return Ok(()),
        Decision::Starved(_) => {
            let what = "No samples arrived while the condition had to stay true.";
            let mut trouble = StepError::other(FailureCause::Environment, Verdict::Inconclusive, what);
            trouble.parts = parts;
            return Err(trouble);
        }
        Decision::Relapsed(_) => "It became true but did not stay true.".to_owned(),
        Decision::Late(_) => match expectation.allowed() {
            None => "It was not true at the next sample.".to_owned(),
            Some(allowed) => format!("It did not become true within {allowed}."),
        },
        Decision::Open | Decision::Undecided => {
            format!("It could not be decided within {}.", expectation.allowed().unwrap_or_else(|| "0ns".to_owned()))
        }
    };
    let mut trouble = StepError::device(what, parts);
    if let Some(instant) = instant {
        trouble.frame = Some(instant.tick.frame);
        trouble.place = decisive(&instant.places, &trouble.parts, view);
    }
    Err(trouble)
}
