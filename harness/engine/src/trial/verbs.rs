//! The verbs that act: set, exchange, connect, write, read, send, wait, save; those that check are in [`super::looks`].

use super::RunningTrial;
use super::access::AccessAnswer;
use super::checks::NO_SAMPLE;
use super::step_error::{BoxedStepError, StepError, StepResult, ended};
use crate::needs;
use crate::stations::HarnessStations;
use expression::{HistoryState, Program, Value};
use judge::answer::{self, ReceivedReply};
use judge::answer_parts;
use judge::condition::{self, ConditionState};
use judge::rule::length;
use judge::slow::SlowReaction;
use judge::{JudgeTick, Truth};
use results::bench_file::BenchFile;
use results::outcome::{FailureCause, JudgedPart};
use results::verdict::Verdict;
use station::{Duration, StandAction};
use std::sync::Arc;
use suite::device::{NameId, NameKind};
use suite::model::{
    AcyclicAccess, AnswerMatcher, AnswerPart, Condition, ConnectionStart, Deadline, ExchangeEntry, Matcher, TimeSpan,
    TrialStep, Verb,
};

/// The longest time for a request; all timeouts of the controllers are shorter, so a longer one is a bug in encspec.
const LONGEST_REQUEST: Duration = Duration::from_secs(120);
/// The time between two reads of a `read` with `within`.
const REPEAT: Duration = Duration::from_millis(20);

/// The result of a step, with the step (possibly one inside it) that failed.
pub type LocatedStepResult<'a> = Result<(), (BoxedStepError, &'a TrialStep)>;

impl<'a> RunningTrial<'a> {
    /// Runs a step.
    pub fn verb(&mut self, step: &'a TrialStep) -> LocatedStepResult<'a> {
        let done = match &step.verb {
            Verb::Set(settings) => self.set(settings),
            Verb::Turn(turn) => self.turn(turn),
            Verb::Exchange(entries) => self.exchange(entries),
            Verb::Connect { start, answer, second, to } => self.connect(start, answer.as_ref(), *second, to.as_ref()),
            Verb::Disconnect { second } => self.disconnect(*second),
            Verb::Write(access) => self.write(access),
            Verb::Read { access, within } => self.read(step, access, within.as_ref()),
            Verb::Send { service, answer, second, to, repeats } => {
                self.action();
                self.driver.send(self, service, answer.as_ref(), *second, to.as_ref(), *repeats)
            }
            Verb::Expect { condition, within, hold } => self.expect(step, condition, within, hold),
            Verb::Wait(span) => self.wait(span),
            Verb::Save(values) => self.save(values),
            Verb::Block { steps, times, observe } => return self.block(step, steps, *times, observe),
            Verb::Either(readings) => return self.either(step, readings),
        };
        done.map_err(|trouble| (trouble, step))
    }

    /// Starts a request of one of the harness's stations and waits for its outcome.
    pub fn request<O>(
        &mut self,
        begin: impl FnOnce(&mut HarnessStations) -> Result<(), String>,
        take: impl Fn(&mut HarnessStations) -> Option<O>,
    ) -> Result<O, BoxedStepError> {
        let now = self.world.now();
        let busy = |why: String| StepError::other(FailureCause::Harness, Verdict::Error, why);
        if let Some(why) = self.world.stop_reason().filter(|_| !self.world.closing) {
            return Err(ended(&why));
        }
        begin(&mut self.world.stations).map_err(busy)?;
        let mut outcome = None;
        self.world.run(now + LONGEST_REQUEST, |world| {
            outcome = take(&mut world.stations);
            outcome.is_some()
        });
        outcome.ok_or_else(|| match self.world.stop_reason() {
            Some(why) => ended(&why),
            None => busy("A request of the harness's station did not end.".into()),
        })
    }

    /// Begins an action: later expectations must not have been true before it.
    pub fn action(&mut self) {
        if self.in_reading {
            return;
        }
        self.before_action = self.world.last_sample.is_some().then(|| self.world.scene.follower.image.clone());
        self.world.act();
    }

    /// Waits until this many cyclic frames have been sent, the last one observed on the wire.
    pub fn cycles(&mut self, count: u64) -> StepResult {
        self.driver.cycles(self, count)
    }

    /// Establishes a connection; the trial's own one replaces the one before.
    pub fn connect(
        &mut self,
        start: &'a ConnectionStart,
        answer: Option<&'a AnswerMatcher>,
        second: bool,
        to: Option<&'a Program>,
    ) -> StepResult {
        if !second {
            self.disconnect(false)?;
        }
        self.check_offered(start)?;
        self.action();
        self.driver.connect(self, start, answer, second, to)
    }

    /// Ends the connection, if there is one.
    pub fn disconnect(&mut self, second: bool) -> StepResult {
        if !self.world.stations.is_connected(usize::from(second)) {
            return Ok(());
        }
        self.action();
        self.driver.release(self, second)
    }

    fn turn(&mut self, turn: &'a suite::model::Turn) -> StepResult {
        self.action();
        self.turn_shaft(turn)
    }

    fn exchange(&mut self, entries: &'a [ExchangeEntry]) -> StepResult {
        self.action();
        for entry in entries {
            let times = entry.times.eval(&self.world.view(), &HistoryState::default()).as_whole();
            let Some(times) = times.and_then(|times| u64::try_from(times).ok()) else {
                return Err(StepError::other(FailureCause::Suite, Verdict::Error, "The number of cycles is unknown."));
            };
            if times == 0 {
                continue;
            }
            self.apply_settings(&entry.set)?;
            match &entry.expect {
                None => self.cycles(times)?,
                Some(condition) => self.judged_cycles(condition, times)?,
            }
        }
        Ok(())
    }

    /// Waits for this many exchanges on PROFIBUS and judges the answer of each.
    fn judged_cycles(&mut self, condition: &Condition, times: u64) -> StepResult {
        for cycle in 1..=times {
            let before = self.world.last_sample;
            self.cycles(1)?;
            self.checks += 1;
            let Some(tick) = self.world.last_sample.filter(|_| self.world.last_sample != before) else {
                let what = format!("The device did not answer in cycle {cycle} of {times}.");
                return Err(StepError::device(what, Vec::new()).at(self.world.trace.len() as u64));
            };
            let view = self.world.view_at(tick);
            let memory = ConditionState::default();
            if memory.truth(condition, &view) != Truth::True {
                let what = format!("The answer of cycle {cycle} of {times} is wrong.");
                return Err(StepError::device(what, memory.parts(condition, &view)).at(tick.frame));
            }
        }
        Ok(())
    }

    /// Ends a start-up on either bus: waits for the first data of the trial's own connection, then judges `answer`. Without an `answer`
    /// there has to be a connection and nothing may be refused; `stands` has the refusal, or why there is no connection.
    pub fn started(
        &mut self,
        stands: Result<Option<String>, Option<String>>,
        answer: Option<&'a AnswerMatcher>,
        second: bool,
    ) -> StepResult {
        if !second {
            self.may_end = false;
        }
        if stands.is_ok() && !second {
            let until = self.world.now() + NO_SAMPLE;
            self.world.run(until, |world| world.samples > 0 || world.lost.is_some());
        }
        let what = match (answer, stands) {
            (Some(answer), _) => return self.judge_answer(answer),
            (None, Ok(None)) => return Ok(()),
            (None, Ok(Some(refused))) => refused,
            (None, Err(why)) => {
                format!("The connection was not established: {}.", why.as_deref().unwrap_or("it ended"))
            }
        };
        Err(StepError::device(what, Vec::new()))
    }

    pub fn judge_answer(&mut self, answer: &AnswerMatcher) -> StepResult {
        self.checks += 1;
        let parts = answer_parts::judge(answer, &self.world.scene.notebook().answers, &self.world.view());
        if parts.iter().all(|part| part.held) {
            return Ok(());
        }
        Err(StepError::device("The answer is wrong.", parts).at(self.world.trace.len() as u64))
    }

    fn write(&mut self, access: &'a AcyclicAccess) -> StepResult {
        self.action();
        let answered = self.access(access, true)?;
        self.world.scene.notebook_mut().answers = answered.replies;
        let judged = self.judge_answer(access.answer.as_ref().unwrap_or(&AnswerMatcher::Accepted));
        judged.map_err(|trouble| self.lacks_parameter(access).unwrap_or(trouble))
    }

    fn read(&mut self, step: &'a TrialStep, access: &'a AcyclicAccess, within: Option<&'a Deadline>) -> StepResult {
        self.action();
        let trigger = JudgeTick { time: self.world.now(), ..self.world.view().tick };
        let began = trigger.time;
        let limits = match within {
            Some(within) => Some((within, self.length(&within.limit)?, self.patience_of(within)?)),
            None => None,
        };
        let deadline = limits.map(|(_, limit, patient)| began + patient.unwrap_or(limit).max(limit) + self.slack);
        loop {
            let asked = self.world.now();
            let answered = self.access(access, false)?;
            let parts = self.read_parts(access, answered);
            if parts.iter().all(|part| part.held) {
                self.checks += 1;
                if let Some((within, limit, Some(_))) = limits
                    && asked > began + limit + self.slack
                {
                    let took = asked.since(began);
                    self.note_slow(step, within, Some(SlowReaction { took, limit, trigger, times: 1 }));
                }
                return Ok(());
            }
            let again = self.world.now() + REPEAT;
            if deadline.is_none_or(|deadline| again > deadline) {
                self.checks += 1;
                let what = match deadline {
                    Some(_) => "The right answer did not arrive in time.",
                    None => "The answer is wrong.",
                };
                let trouble = StepError::device(what, parts).at(self.world.trace.len() as u64);
                return Err(self.lacks_parameter(access).unwrap_or(trouble));
            }
            self.world.run(again, |_| false);
        }
    }

    /// Takes in the values that were read and compares each with the expected one.
    fn read_parts(&mut self, access: &AcyclicAccess, answered: AccessAnswer) -> Vec<JudgedPart> {
        let notebook = self.world.scene.notebook_mut();
        for (item, value) in access.items.iter().zip(&answered.values) {
            notebook.read.retain(|(name, _)| *name != item.name);
            if !value.is_unknown() {
                notebook.read.push((item.name, value.clone()));
            }
        }
        notebook.answers = answered.replies;
        let view = self.world.view();
        let replies = &self.world.scene.notebook().answers;
        let whole = replies.iter().find(|(part, _)| *part == AnswerPart::Whole).map(|(_, reply)| reply);
        let part = |(item, value): (&suite::model::AccessItem, &Value)| {
            let own = match view.variant.names.get(item.name.0 as usize) {
                Some(NameKind::Parameter { number, subindex, .. }) => {
                    let part = AnswerPart::Parameter(*number, *subindex);
                    replies.iter().find(|(of, _)| *of == part).map(|(_, reply)| reply)
                }
                _ => None,
            };
            let reply = own.or(whole);
            let (held, observed) = match (&item.value, reply) {
                (Matcher::Refused(codes), Some(reply)) => (answer::refuses(reply, codes), reply.to_string()),
                (matcher, Some(ReceivedReply::Accepted)) => {
                    let seen = condition::named_octets(matcher, value).unwrap_or_else(|| view.show(item.name, value));
                    (condition::matches(matcher, value, &view) == Truth::True, seen)
                }
                (_, reply) => (false, reply.map_or_else(|| "nothing".to_owned(), ReceivedReply::to_string)),
            };
            JudgedPart {
                text: view.name(item.name),
                expected: condition::expected_of(&item.value, item.name, &view),
                observed,
                held,
            }
        };
        access.items.iter().zip(&answered.values).map(part).collect()
    }

    /// A span as time; an unknown one is an error of the suite.
    pub fn length(&self, span: &TimeSpan) -> Result<Duration, BoxedStepError> {
        let unknown = || StepError::other(FailureCause::Suite, Verdict::Error, "The length of time is unknown.");
        length(span, &self.world.view()).ok_or_else(unknown)
    }

    /// Up to when a deadline of ours is waited for.
    fn patience_of(&self, within: &Deadline) -> Result<Option<Duration>, BoxedStepError> {
        within.ours.as_ref().filter(|_| !self.is_strict).map(|ours| self.length(&ours.patient)).transpose()
    }

    /// Keeps what was late for the report: the slowest of each step.
    pub fn note_slow(&mut self, step: &'a TrialStep, within: &'a Deadline, slow: Option<SlowReaction>) {
        let Some(slow) = slow else { return };
        match self.slow.iter_mut().find(|(known, ..)| std::ptr::eq(*known, step)) {
            Some((_, _, known)) => *known = known.and(slow),
            None => self.slow.push((step, within, slow)),
        }
    }

    fn wait(&mut self, span: &'a TimeSpan) -> StepResult {
        match span {
            TimeSpan::Cycles(cycles) => self.cycles(*cycles),
            span => {
                let length = self.length(span)?;
                if self.can_skip(length) {
                    return self.act_on_stand(&StandAction::Skip(length));
                }
                let until = self.world.now() + length;
                self.world.run(until, |_| false);
                Ok(())
            }
        }
    }

    /// Whether the stand can skip a long time for the device; during a connection the time has to pass for the harness, too.
    fn can_skip(&self, length: Duration) -> bool {
        let serves = |bench: &Arc<BenchFile>| bench.stand.serves("clock");
        length >= needs::LONG
            && self.environment.bench.as_ref().is_some_and(serves)
            && !self.world.stations.is_connected(0)
    }

    /// The value at the event that satisfied the last expectation since the last action.
    fn at_expected_event(&self, program: &expression::Program) -> Value {
        let expected = self.world.expected_event.and_then(|at| self.world.events.get(at));
        let Some(event) = expected.filter(|event| event.used) else { return Value::Unknown };
        let view = judge::view::NameView { image: &event.image, tick: event.tick, ..self.world.view() };
        program.eval(&view, &HistoryState::default())
    }

    fn save(&mut self, values: &'a [(NameId, expression::Program)]) -> StepResult {
        for (name, program) in values {
            let mut value = program.eval(&self.world.view(), &HistoryState::default());
            if value.is_unknown() && program.names().any(|name| matches!(self.kind(name), Some(NameKind::Event(_)))) {
                value = self.at_expected_event(program);
            }
            if value.is_unknown() {
                let what = format!("{} is unknown, so it cannot be saved.", program.text());
                return Err(StepError::device(what, Vec::new()));
            }
            if let Some(NameKind::Saved(index)) = self.kind(*name) {
                let saved = &mut self.world.scene.notebook_mut().saved;
                if saved.len() <= *index {
                    saved.resize(index + 1, Value::Unknown);
                }
                saved[*index] = value;
            }
        }
        Ok(())
    }
}
