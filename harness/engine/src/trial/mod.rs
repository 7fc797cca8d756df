//! A trial from begin to end: proof of life, start, `given`, `steps`, `finally`, clean-up; and its verdict.
//!
//! A step is a verb that acts ([`verbs`], [`settings`], [`access`]) or one that checks ([`checks`]). A step that fails gives a
//! [`step_error`], from which [`failure`] makes the text for the report. What depends on the bus goes through [`driver`]. [`probe`]
//! reads a live device before the first trial, [`mod@variant`] what shows its variant. This module must not know which buses there are, nor how a verdict is used.

pub mod access;
mod checks;
pub mod driver;
pub mod failure;
mod offered;
pub mod probe;
mod settings;
pub mod slave;
pub mod step_error;
mod unjudged;
mod variant;
mod verbs;

use crate::environment::TrialEnvironment;
use crate::outcome::{Disturbance, Stall};
use crate::outputs;
use crate::world::TrialWorld;
use controllers::profinet_io::IdentifiedStation;
use driver::BusDriver;
use expression::NameId;
use judge::image::ConnectionImage;
use judge::slow::SlowReaction;
use judge::view::{BenchAddresses, StationNumbers};
use results::outcome::{CaseFailure, FailureCause};
use results::verdict::Verdict;
use slave::SlaveAddresses;
use station::{Duration, Time};
use std::net::Ipv4Addr;
use step_error::{BoxedStepError, StepError, StepResult, ended};
use suite::device::{EventName, NameKind, StandName};
use suite::model::{Deadline, FailureSubject, HoldTime, Trial, TrialStep, Verb};
use wire::ethernet::Mac;
use wire::profinet::dcp::block::IpParameter;

/// Good samples that prove that a device works.
const LIVING_SAMPLES: u64 = 3;
/// How many watchdog times the first good samples may take.
const START_WATCHDOGS: u32 = 5;
/// A wait for cycles gives up after this many cycle times for each awaited cycle, plus [`SPARE_CYCLES`].
const CYCLE_TIMES: u64 = 4;
/// Cycle times added to each wait for cycles, for start-up of the exchange and lost frames.
const SPARE_CYCLES: u64 = 100;

/// The longest wait for an end that may never come.
const LONGEST_HOLD: Duration = Duration::from_secs(600);
/// How long a live line may hold an answer back before its absence is the device's.
const LATE_ANSWER: Duration = Duration::from_millis(500);

/// The longest wait for `count` cycles of the time `cycle`.
pub fn cycle_limit(cycle: Duration, count: u64) -> Duration {
    let cycles = count.saturating_mul(CYCLE_TIMES).saturating_add(SPARE_CYCLES);
    cycle.saturating_mul(u32::try_from(cycles).unwrap_or(u32::MAX))
}

/// A check with its own requirements.
pub struct StepCheck {
    pub covers: Vec<usize>,
    pub verdict: Verdict,
    pub failure: Option<CaseFailure>,
}

/// The parts of a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TrialPhase {
    /// The start and `given`.
    Before,
    /// The steps of the test.
    Test,
    /// `finally` and the clean-up.
    After,
}

/// A running trial.
pub struct RunningTrial<'a> {
    /// The bus of the device.
    pub driver: &'static dyn BusDriver,
    /// The segment and all observations.
    pub world: TrialWorld<'a>,
    pub trial: &'a Trial,
    /// The addresses of the device and of the harness's stations.
    pub environment: &'a TrialEnvironment,
    /// The MAC address of the device.
    pub mac: Mac,
    /// The identity that the device reported (PROFINET).
    pub identity: Option<IdentifiedStation>,
    /// The addresses of a slave, and the ident number that it reported (PROFIBUS).
    pub slave: SlaveAddresses,
    /// Whether the trial may have changed the station name.
    pub renamed: bool,
    /// Whether connections leave the device the IP address that it has.
    pub keeps_address: bool,
    /// The last IP parameters that the device was given.
    pub station_ip: IpParameter,
    /// The last IP address that the device had.
    pub last_ip: Ipv4Addr,
    /// The module in use.
    pub module: Option<usize>,
    /// Whether cyclic frames are paused.
    pub paused: bool,
    /// The reference of the last parameter request.
    pub reference: u8,
    /// The data at the last sample before the last action.
    pub before_action: Option<ConnectionImage>,
    /// Whether the trial has done something that may end the present connection, or now requests its end.
    pub may_end: bool,
    /// Whether a reading of the manual is being tried: its steps begin no action.
    pub in_reading: bool,
    /// Whether deadlines of ours are as strict as others, since another reading may hold in time.
    pub is_strict: bool,
    /// Which part of the trial runs.
    pub phase: TrialPhase,
    /// The results of checks with their own requirements.
    pub checked: Vec<StepCheck>,
    /// The readings that the device follows: step and reading.
    pub readings: Vec<(String, String)>,
    /// Readings that are faults and that the device follows: reading and sentence.
    pub findings: Vec<(String, String)>,
    /// The requirements that the failure which ended the trial is about, if the step says so.
    pub failed_about: FailureSubject,
    /// The requirements that passed steps are about.
    pub passed_about: Vec<usize>,
    /// How many checks were judged.
    pub checks: u64,
    /// Steps that were not reached, for the report.
    pub not_reached: Vec<String>,
    /// The extra time for deadlines on a live bench.
    pub slack: Duration,
    /// Stand names that were set and have to be restored.
    pub stand_settings: Vec<StandName>,
    /// The acceleration of the shaft in revolutions per minute each second; 0 means at once.
    pub acceleration: f64,
    /// What came later than a limit of ours: the step, the limit, and how slow it was.
    pub slow: Vec<(&'a TrialStep, &'a Deadline, SlowReaction)>,
    /// Remarks that do not change the verdict.
    pub notes: Vec<String>,
}

/// A silence of this many times the longest delay here is the device's own.
const EXPLAINED_SILENCE: u32 = 20;
/// The shortest silence that nothing here explains: a host that is very busy may keep a simulated device from answering for less.
const LEAST_SILENCE: Duration = Duration::from_secs(3);
/// How many frames at least have to call in vain.
const FEWEST_CALLS: u32 = 10;

impl<'a> RunningTrial<'a> {
    /// A trial that has not begun, on the bus of `driver`.
    pub fn new(
        driver: &'static dyn BusDriver,
        mut world: TrialWorld<'a>,
        trial: &'a Trial,
        environment: &'a TrialEnvironment,
    ) -> RunningTrial<'a> {
        let notebook = world.scene.notebook_mut();
        notebook.bench = Some(BenchAddresses {
            controller: environment.controllers[0].1,
            device: environment.ip.address,
            mask: environment.ip.mask,
            free: environment.free_ip,
            stations: StationNumbers {
                device: environment.line.station,
                master: environment.line.masters[0],
                second: environment.line.masters[1],
                free: environment.line.free,
            },
        });
        notebook.noise = environment.noise;
        notebook.slack = environment.slack;
        if let Some(sent) = world.stations.outputs_mut() {
            outputs::declare(&world.manual.device, sent);
        }
        RunningTrial {
            driver,
            mac: environment.mac.unwrap_or_default(),
            identity: None,
            slave: SlaveAddresses::new(environment.line.station),
            renamed: false,
            keeps_address: false,
            station_ip: environment.ip,
            last_ip: environment.ip.address,
            module: None,
            paused: false,
            reference: 0,
            before_action: None,
            may_end: false,
            in_reading: false,
            is_strict: false,
            phase: TrialPhase::Before,
            checked: Vec::new(),
            readings: Vec::new(),
            findings: Vec::new(),
            failed_about: FailureSubject::Unsaid,
            passed_about: Vec::new(),
            checks: 0,
            not_reached: Vec::new(),
            slack: environment.slack,
            stand_settings: Vec::new(),
            acceleration: 0.0,
            slow: Vec::new(),
            notes: Vec::new(),
            world,
            trial,
            environment,
        }
    }

    /// The kind of a name.
    pub fn kind(&self, name: NameId) -> Option<&'a NameKind> {
        self.world.variant.names.get(name.0 as usize)
    }

    /// The index of the variant among those of the device.
    pub fn variant_number(&self) -> usize {
        let name = &self.world.variant.name;
        self.world.manual.device.variants.iter().position(|known| known == name).unwrap_or_default()
    }

    /// Runs the trial; returns the failure that decided it, if there is one.
    pub fn run(&mut self) -> Option<(Verdict, CaseFailure)> {
        let trial = self.trial;
        if let Err(trouble) = self.check_identity() {
            // Whatever station this is, or none: it is left alone.
            let verdict = trouble.verdict.unwrap_or(Verdict::Inconclusive);
            return Some((verdict, failure::failure(self, None, trouble, &[])));
        }
        if let Err(trouble) = self.check_hello() {
            // Nothing was done, so there is nothing to put back.
            return Some((Verdict::NotApplicable, failure::failure(self, None, trouble, &[])));
        }
        let decided = self.test().err().map(|(trouble, step)| {
            let verdict = trouble.verdict.unwrap_or(Verdict::Fail);
            let about = self.failed_about.clone();
            (verdict, failure::failure(self, step, trouble, about.requirements()))
        });
        let decided = decided.map(|decided| self.excuse_disturbed(decided));
        self.wait_for_late_rules();
        (self.phase, self.world.closing) = (TrialPhase::After, true);
        let finally = self.steps(&trial.how().finally).map_err(|(trouble, step)| (trouble, Some(step)));
        let cleaned = self.clean_up().map_err(|trouble| (trouble, None));
        let cleaned = finally.and(cleaned);
        // A trial that turned out not to be applicable says nothing, but a device that no longer answers does.
        let decided = decided.filter(|(verdict, _)| *verdict != Verdict::NotApplicable || cleaned.is_ok());
        let decided = decided.or_else(|| {
            let (trouble, step) = cleaned.err()?;
            Some((Verdict::Inconclusive, failure::failure(self, step, trouble.before_the_test(), &[])))
        });
        decided.or_else(|| self.unexpected()).or_else(|| self.disturbed_failure())
    }

    /// Waits for what a rule requires and is past a limit of ours; the end of the connection would leave it undecided.
    fn wait_for_late_rules(&mut self) {
        let late = |world: &TrialWorld<'_>| {
            let is_connected = world.lost.is_none() && world.stations.is_connected(0);
            is_connected && world.judges.rules.is_late(world.now())
        };
        if late(&self.world) {
            let until = self.world.now() + LONGEST_HOLD;
            self.world.run(until, |world| !late(world));
        }
    }

    /// Makes a trial without failure inconclusive if the line broke, or if frames were lost or never sent: their missing answers prove
    /// nothing.
    fn disturbed_failure(&mut self) -> Option<(Verdict, CaseFailure)> {
        self.world.segment.check_line();
        let why = self.world.stop_reason().or_else(|| self.world.segment.withheld())?;
        Some((Verdict::Inconclusive, failure::failure(self, None, ended(&why), &[])))
    }

    /// Why the trial says nothing about the device: the line, the end of the run, or a stall.
    pub fn disturbance(&self) -> Option<Disturbance> {
        let held_back =
            || self.world.segment.objections().into_iter().next().filter(|_| !self.world.segment.is_virtual());
        self.world.stop().or_else(|| held_back().map(Disturbance::lasting)).or_else(|| self.stall())
    }

    /// What was later than the extra time for deadlines.
    fn stall(&self) -> Option<Disturbance> {
        let (late, slack) = (self.world.segment.lateness(), self.slack);
        if late > slack {
            let why = format!("the harness was {late:?} late, more than the allowed {slack:?}");
            return Some(Disturbance::of_harness(why));
        }
        if let Some(waited) = self.world.segment.shortage() {
            let passed = self.world.now().since(Time::ZERO);
            return Some(Disturbance::of_harness(format!(
                "this host, on which the device runs too, was overloaded: programs waited {waited:?} of {passed:?} for a processor, \
                 and encspec has no real-time scheduling"
            )));
        }
        let answer = self.world.segment.latest_answer();
        (answer > slack).then(|| {
            Disturbance::of_link(format!(
                "an answer came {answer:?} after its request, more than the allowed {slack:?}, and this link cannot tell a slow \
                 device from a slow line"
            ))
        })
    }

    /// Whether the device has been silent for so long, while it was called, that nothing that was late here explains it.
    fn is_silent_beyond_stalls(&self) -> bool {
        let segment = &self.world.segment;
        let late = segment.lateness().max(segment.latest_answer());
        let explained = late.max(segment.shortage().unwrap_or_default()) * EXPLAINED_SILENCE;
        let (mut calls, now) = (0, self.world.now());
        for frame in self.world.trace.iter().rev() {
            if self.driver.is_from_device(self, frame.octets) {
                let silence = now.since(frame.time);
                return calls >= FEWEST_CALLS && silence > explained.max(LEAST_SILENCE);
            }
            calls += 1;
        }
        false
    }

    /// Makes a failure inconclusive if the line broke, the run was interrupted or the harness was late. If a precondition failed, this
    /// reason is added.
    ///
    /// An answer that is missing may still be on its way on a live line; a failure is decided only after a wait for it.
    fn excuse_disturbed(&mut self, decided: (Verdict, CaseFailure)) -> (Verdict, CaseFailure) {
        let (verdict, mut failure) = decided;
        if !matches!(verdict, Verdict::Fail | Verdict::Inconclusive) {
            return (verdict, failure);
        }
        if self.world.segment.lacks_answer() {
            let until = self.world.now() + LATE_ANSWER;
            self.world.run(until, |world| !world.segment.lacks_answer());
        }
        let disturbance = self.disturbance().filter(|of| of.stall.is_none() || !self.is_silent_beyond_stalls());
        match disturbance {
            Some(Disturbance { why, stall }) if verdict == Verdict::Fail => {
                failure.what = format!("No verdict, because {why}. Observed: {}", failure.what);
                failure.blame = match stall {
                    Some(Stall::Harness) => FailureCause::Harness,
                    Some(Stall::Link) | None => FailureCause::Environment,
                };
                (Verdict::Inconclusive, failure)
            }
            Some(Disturbance { why, .. }) if !failure.what.contains(&why) => {
                failure.what = format!("{} In addition, {why}.", failure.what);
                (verdict, failure)
            }
            _ => (verdict, failure),
        }
    }

    fn test(&mut self) -> Result<(), (BoxedStepError, Option<&'a TrialStep>)> {
        let trial = self.trial;
        if let Some(start) = trial.start() {
            self.start(start).map_err(|trouble| (trouble.before_the_test(), None))?;
        }
        self.steps(&trial.how().given).map_err(|(trouble, step)| {
            // A step that says what it is about judges the device wherever it stands.
            let judges = self.failed_about != FailureSubject::Unsaid;
            (if judges { trouble } else { trouble.before_the_test() }, Some(step))
        })?;
        self.phase = TrialPhase::Test;
        let tested = self.steps(&trial.how().steps).map_err(|(trouble, step)| (trouble, Some(step)));
        self.phase = TrialPhase::After;
        tested
    }

    /// Checks that the device answers with the identity that the bench claims; otherwise the trial is inconclusive.
    fn check_identity(&mut self) -> StepResult {
        self.world.note("identify the device");
        self.driver.check_identity(self)
    }

    /// How long the device may be absent after a restart.
    pub fn patience(&self) -> Duration {
        let timing = &self.world.manual.device.timing;
        timing.power_up().max(timing.start())
    }

    fn start(&mut self, start: &'a suite::model::ConnectionStart) -> StepResult {
        self.world.note("start");
        self.connect(start, None, false, None)?;
        let until = self.world.now() + self.world.watchdog * START_WATCHDOGS;
        let lives = self.world.run(until, |world| world.samples >= LIVING_SAMPLES || world.lost.is_some());
        if lives && self.world.lost.is_none() {
            return Ok(());
        }
        let what = "The device sends no good data although the connection is established.";
        Err(StepError::other(FailureCause::Device, Verdict::Inconclusive, what))
    }

    /// Restores the bench, and checks that the device still answers: a device that stopped after the last check proves nothing.
    fn clean_up(&mut self) -> StepResult {
        self.world.note("clean-up");
        if self.paused {
            self.pause(false);
            self.paused = false;
        }
        self.driver.undo_settings(self);
        if !self.world.segment.is_virtual() {
            self.outputs_to_zero();
        }
        let is_read_at_power_on = |name: &StandName| matches!(name, StandName::Switch(_) | StandName::Fault(_));
        let has_read = self.stand_settings.contains(&StandName::Delivery)
            || self.stand_settings.contains(&StandName::Power) && self.stand_settings.iter().any(is_read_at_power_on);
        // `and` evaluates its argument in any case: every part is done, and the first failure counts.
        let outcome = self.disconnect(true);
        let outcome = outcome.and(self.disconnect(false));
        let outcome = outcome.and(self.restore_stand());
        let outcome = outcome.and(self.driver.check_presence(self));
        outcome.and(self.driver.restore_station(self, has_read))
    }

    /// Sets all outputs to 0 at the end, since the device may drive a machine.
    fn outputs_to_zero(&mut self) {
        if let Some(sent) = self.world.stations.outputs_mut() {
            sent.reset();
        }
        if self.world.stations.exchanges(0) {
            // If this fails the connection is gone, and the device sets its outputs to zero by itself.
            let _ = self.cycles(2);
        }
    }

    /// The firmware that the device reports in I&M0, for the report and the ledger of known failures.
    pub fn firmware(&mut self) -> Option<String> {
        if !self.driver.names_firmware() {
            return None;
        }
        self.check_identity().ok()?;
        self.start(self.trial.start()?).ok()?;
        self.driver.firmware(self)
    }

    /// Fails a trial on a model with an unexpected alarm or an unreadable frame; on a live bench, where other things may happen, an
    /// unexpected alarm is a remark.
    fn unexpected(&mut self) -> Option<(Verdict, CaseFailure)> {
        self.world.act();
        if !self.world.segment.is_virtual() {
            let alarms = self.world.unexpected.iter();
            self.notes.extend(alarms.map(|(what, frame)| format!("no step expects {what} (frame {frame})")));
            // Frames of other stations do not count; on PROFIBUS bytes that are no frame have made the trial inconclusive already.
            let trace = &self.world.trace;
            let from_device =
                |number: u64| trace.get(number as usize).is_some_and(|of| self.driver.is_from_device(self, of.octets));
            let unreadable = self.world.unreadable.iter().find(|(_, frame)| from_device(*frame)).cloned();
            let trouble = match unreadable {
                Some((why, frame)) => {
                    StepError::device(format!("A frame cannot be read: {why}."), Vec::new()).at(frame)
                }
                None => self.trouble_of_answers()?,
            };
            let failure = failure::failure(self, None, trouble, &[]);
            return Some(self.excuse_disturbed((Verdict::Fail, failure)));
        }
        if let Some(trouble) = self.trouble_of_answers() {
            return Some((Verdict::Fail, failure::failure(self, None, trouble, &[])));
        }
        if let Some(what) = self.world.segment.out_of_turn().into_iter().next() {
            let trouble = StepError::device(format!("The device sent out of turn: {what}."), Vec::new());
            return Some((Verdict::Fail, failure::failure(self, None, trouble, &[])));
        }
        let (what, frame) = match (self.world.unexpected.first(), self.world.unreadable.first()) {
            (Some((what, frame)), _) => (format!("The device sent {what}, which no step expects."), *frame),
            (_, Some((why, frame))) => (format!("A frame cannot be read: {why}."), *frame),
            _ => return None,
        };
        let failure = failure::failure(self, None, StepError::device(what, Vec::new()).at(frame), &[]);
        Some((Verdict::Fail, failure))
    }

    /// What is wrong with frames of the device that no step judges.
    fn trouble_of_answers(&self) -> Option<BoxedStepError> {
        let misfit =
            self.driver.misfit(self).map(|why| format!("An answer does not fit the request before it: {why}."));
        let wrong = || self.driver.misconduct(self).map(|why| format!("The device sends what it must not: {why}."));
        Some(StepError::device(misfit.or_else(wrong)?, Vec::new()))
    }

    /// Runs the steps in order; the first that fails ends them, except for checks with their own requirements.
    pub fn steps(&mut self, steps: &'a [TrialStep]) -> Result<(), (BoxedStepError, &'a TrialStep)> {
        for (index, step) in steps.iter().enumerate() {
            let outcome = self.step(step).and_then(|()| {
                let is_requested = self.expects_end(&steps[index + 1..]);
                self.may_end |= is_requested && self.world.lost.is_some();
                self.lost_connection().map_or(Ok(()), |lost| Err((lost, step)))
            });
            if let Err(trouble) = outcome {
                self.not_reached.extend(steps.iter().skip(index + 1).map(|step| step.text.clone()));
                return Err(trouble);
            }
        }
        Ok(())
    }

    fn step(&mut self, step: &'a TrialStep) -> Result<(), (BoxedStepError, &'a TrialStep)> {
        self.world.note(&format!("line {}: {}", step.at.line, step.text));
        if let Some(why) = self.missing_need(step) {
            let what = format!("The check is not applicable: {why}.");
            let trouble = StepError::other(FailureCause::Environment, Verdict::NotApplicable, what);
            let failure = failure::failure(self, Some(step), trouble, &step.covers);
            let covers = step.covers.clone();
            self.checked.push(StepCheck { covers, verdict: Verdict::NotApplicable, failure: Some(failure) });
            return Ok(());
        }
        let may_end = self.may_end;
        self.may_end |= self.expects_end(std::slice::from_ref(step));
        let outcome = self.verb(step);
        let lost = if outcome.is_err() { self.lost_connection() } else { None };
        // The request of a step for the end of the connection ends with the step; what the step did may still end the connection.
        if self.world.lost.is_none() && !may_end && self.expects_end(std::slice::from_ref(step)) {
            self.may_end = false;
        }
        let outcome = match (outcome, lost) {
            (Err((trouble, step)), Some(lost)) if trouble.verdict == Some(Verdict::Inconclusive) => {
                let mut lost = lost;
                lost.parts.clone_from(&trouble.parts);
                Err((lost, step))
            }
            (outcome, _) => outcome,
        };
        let outcome = outcome.map_err(|(trouble, at)| (offered::excused(step, trouble), at));
        self.note_about(step, outcome.as_ref().err().map(|(trouble, _)| trouble));
        if step.covers.is_empty() || (self.phase != TrialPhase::Test && outcome.is_err()) {
            return outcome;
        }
        let outcome = match outcome {
            Err((trouble, at)) if !step.apart.is_empty() && tells_names_apart(step, &trouble) => {
                return self.judge_apart(step, *trouble, at);
            }
            outcome => outcome,
        };
        let (verdict, failure) = match outcome {
            Ok(()) => (Verdict::Pass, None),
            Err((trouble, at)) => {
                let verdict = trouble.verdict.unwrap_or(Verdict::Fail);
                let failure = failure::failure(self, Some(at), trouble, &step.covers);
                let (verdict, failure) = self.excuse_disturbed((verdict, failure));
                (verdict, Some(failure))
            }
        };
        self.checked.push(StepCheck { covers: step.covers.clone(), verdict, failure });
        Ok(())
    }

    /// Takes in what a step is about, if it says so. The innermost step counts, and the case counts more than the procedure that it runs.
    fn note_about(&mut self, step: &'a TrialStep, trouble: Option<&BoxedStepError>) {
        if self.phase == TrialPhase::After {
            return;
        }
        let Some(trouble) = trouble else {
            self.passed_about.extend(step.about.of_case());
            return;
        };
        // Before the test only what was compared judges the device; a lost connection does not.
        if !trouble.is_of_device() || (self.phase != TrialPhase::Test && !trouble.has_observed()) {
            return;
        }
        match (&self.failed_about, &step.about) {
            (_, FailureSubject::Unsaid)
            | (FailureSubject::OfProcedure(_), FailureSubject::OfProcedure(_))
            | (FailureSubject::Case | FailureSubject::OfCase(_), _) => {}
            (FailureSubject::Unsaid | FailureSubject::OfProcedure(_), about) => self.failed_about.clone_from(about),
        }
    }

    /// Judges the names of a failed check each for its own requirements. Names without any count for the trial.
    fn judge_apart(
        &mut self,
        step: &'a TrialStep,
        trouble: StepError,
        at: &'a TrialStep,
    ) -> Result<(), (BoxedStepError, &'a TrialStep)> {
        // A name that was right when the check failed may have been wrong before, while it had to stay right.
        let right = match &step.verb {
            Verb::Expect { hold: HoldTime::For(_) | HoldTime::Until(_), .. } => Verdict::NotRun,
            _ => Verdict::Pass,
        };
        let mut rest = trouble.parts.clone();
        for (index, covers) in step.apart.iter().rev() {
            let Some(part) = (*index < rest.len()).then(|| rest.remove(*index)) else { continue };
            let (verdict, failure) = if part.held {
                (right, None)
            } else {
                let own = Box::new(StepError { parts: vec![part], ..trouble.clone() });
                let failure = failure::failure(self, Some(at), own, covers);
                let (verdict, failure) = self.excuse_disturbed((Verdict::Fail, failure));
                (verdict, Some(failure))
            };
            self.checked.push(StepCheck { covers: covers.clone(), verdict, failure });
        }
        if rest.iter().all(|part| part.held) {
            return Ok(());
        }
        Err((Box::new(StepError { parts: rest, ..trouble }), at))
    }

    /// Why a live bench cannot run a check with its own requirements.
    fn missing_need(&self, step: &TrialStep) -> Option<String> {
        let bench = self.environment.bench.as_ref().filter(|_| !step.covers.is_empty())?;
        let needs = crate::needs::of_step(self.world.manual, self.world.variant, step);
        crate::needs::missing(&needs, bench, true, u32::MAX)
    }

    /// Whether the next check in `steps`, before another connection, expects the end of the present one.
    fn expects_end(&self, steps: &[TrialStep]) -> bool {
        let is_end = |name: &NameId| {
            let kind = self.kind(*name);
            matches!(kind, Some(NameKind::Connection | NameKind::Event(EventName::Abort | EventName::AbortCode)))
        };
        for step in steps {
            match &step.verb {
                Verb::Connect { .. } | Verb::Disconnect { .. } => return false,
                Verb::Expect { .. } | Verb::Block { .. } | Verb::Either(_) => {
                    return crate::scan::names(std::slice::from_ref(step)).iter().any(is_end);
                }
                _ => {}
            }
        }
        false
    }

    /// The trouble if the device ended the connection and nothing in the trial expects it.
    fn lost_connection(&mut self) -> Option<BoxedStepError> {
        let lost = self.world.lost?;
        if self.may_end {
            return None;
        }
        self.world.lost = None;
        Some(StepError::device(failure::lost(&lost), Vec::new()).at(lost.tick.frame))
    }
}

/// Whether a failed check shows which of its names were right.
fn tells_names_apart(step: &TrialStep, trouble: &StepError) -> bool {
    let names = match &step.verb {
        Verb::Read { access, .. } => access.items.len(),
        Verb::Expect { condition, .. } => condition.parts.len(),
        _ => 0,
    };
    trouble.is_of_device() && trouble.parts.len() == names && trouble.parts.iter().any(|part| !part.held)
}
