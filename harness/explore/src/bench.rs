//! Runs sequences on devices, and written cases.

use crate::difference::{LogDifference, first};
use crate::retention::{self, RETENTION};
use crate::sequence_log::{BrokenRule, SILENCE, SequenceLog};
use crate::settled::SettledComparison;
use crate::step::SequenceStep;
use compare::action::ControllerAction;
use compare::write_case::{TOPIC, WrittenCase};
use engine::step_log::ProtocolError;
use engine::{BenchError, DutSpec, LiveDevice, RunOptions, STALL_REPEATS, TrialOutcome, run_trial};
use results::verdict::Verdict;
use std::fmt::Write as _;
use std::path::Path;
use suite::model::{Manual, RequirementClass};
use suite_yaml::{Checker, LoadErrors, Sources};

/// Why a sequence could not be run.
#[derive(Debug, thiserror::Error)]
pub enum CannotExplore {
    /// A sequence or case does not load; each error has its line.
    #[error("the steps do not load:\n{0}")]
    NotUnderstood(LoadErrors),
    /// The bench cannot be used.
    #[error(transparent)]
    Bench(#[from] BenchError),
    /// Whoever explores has stopped it.
    #[error("it was interrupted")]
    Interrupted,
    /// The manual has nothing to explore.
    #[error("{0}")]
    Nothing(String),
}

/// Sequences that are loaded and can be run on any device of the manual.
pub struct LoadedSequences {
    manual: Manual,
    steps: Vec<Vec<SequenceStep>>,
}

/// A manual whose devices are explored.
pub struct ExploreBench<'m> {
    manual: &'m Manual,
    variant: usize,
    checker: Checker,
    /// Whether to stop.
    is_stopped: fn() -> bool,
    /// A requirement that applies: the loader takes no case without one.
    requirement: String,
    /// How a live device is compared; `None` for a device in virtual time.
    settled: Option<SettledComparison>,
}

impl<'m> ExploreBench<'m> {
    /// # Errors
    ///
    /// The manual is not in `sources`, or has no such variant.
    pub fn new(sources: &Sources, manual: &'m Manual, variant: &str) -> Result<ExploreBench<'m>, CannotExplore> {
        let name = &manual.device.name;
        let index = manual.device.variants.iter().position(|known| known == variant);
        let variant = index.ok_or_else(|| CannotExplore::Nothing(format!("{name} has no variant {variant}")))?;
        let applies = manual
            .requirements
            .iter()
            .find(|of| of.class == RequirementClass::Testable && of.variants.contains(&variant));
        let nothing = || CannotExplore::Nothing(format!("{name} has no requirements"));
        let requirement = applies.ok_or_else(nothing)?.id.clone();
        let checker = Checker::unchecked(sources, name).map_err(CannotExplore::NotUnderstood)?;
        Ok(ExploreBench { manual, variant, checker, is_stopped: || false, requirement, settled: None })
    }

    /// The same, which stops before the next sequence once `is_stopped` says so.
    #[must_use]
    pub fn until(self, is_stopped: fn() -> bool) -> ExploreBench<'m> {
        ExploreBench { is_stopped, ..self }
    }

    /// The same for a live device.
    #[must_use]
    pub fn live(self) -> ExploreBench<'m> {
        ExploreBench { settled: Some(SettledComparison::new(&self.manual.device)), ..self }
    }

    /// Whether the device is a live one.
    pub fn is_live(&self) -> bool {
        self.settled.is_some()
    }

    /// From now on this is not compared.
    pub fn ignore(&mut self, found: &LogDifference) {
        if let Some(settled) = &mut self.settled {
            settled.ignore(found);
        }
    }

    /// The first difference between the reference device and another one.
    pub fn first(&self, reference: &SequenceLog, other: &SequenceLog) -> Option<LogDifference> {
        match &self.settled {
            Some(settled) => settled.first(reference, other),
            None => first(reference, other),
        }
    }

    /// How many differences there are on a live device; `None` in virtual time.
    pub(crate) fn count_settled(&self, reference: &SequenceLog, other: &SequenceLog) -> Option<usize> {
        Some(self.settled.as_ref()?.all(reference, other).len())
    }

    /// The manual with its cases and rules.
    pub fn manual(&self) -> &'m Manual {
        self.manual
    }

    /// The name of the variant.
    pub fn variant(&self) -> &'m str {
        self.manual.device.variants.get(self.variant).map_or("", String::as_str)
    }

    /// The index of the variant.
    pub fn variant_index(&self) -> usize {
        self.variant
    }

    fn is_read_only(&self, name: &str) -> bool {
        let number = name.strip_prefix('P').and_then(|rest| rest.split('.').next()?.parse::<u16>().ok());
        let known = number.and_then(|number| self.manual.device.parameters.iter().find(|of| of.number == number));
        known.is_some_and(|parameter| !parameter.writable)
    }

    /// A topic file with sequences, whose steps expect nothing.
    pub fn topic(&self, sequences: &[Vec<SequenceStep>]) -> String {
        self.topic_covering(&self.requirement, sequences)
    }

    /// The same whose cases cover this requirement.
    pub fn topic_covering(&self, requirement: &str, sequences: &[Vec<SequenceStep>]) -> String {
        let mut out = format!("suite: {TOPIC}\ncases:\n");
        for (number, steps) in sequences.iter().enumerate() {
            let _ = writeln!(
                out,
                "  - id: sequence-{number}\n    why: A sequence.\n    covers: [{}]\n    variants: [{}]\n    start: none\n    steps:",
                requirement,
                self.variant()
            );
            for step in steps {
                let line = step.line(&|name| self.is_read_only(name));
                let _ = writeln!(out, "      - {}", line.verb);
                for modifier in &line.modifiers {
                    let _ = writeln!(out, "        {modifier}");
                }
            }
            // Whether the device still answers; the loader takes no case without a check.
            let alive = if self.manual.device.profinet().is_some() { "station.name" } else { "diag.length" };
            let _ = writeln!(out, "      - read: {{ {alive}: any }}");
        }
        out
    }

    /// Loads sequences.
    pub fn load(&self, sequences: &[Vec<SequenceStep>]) -> Result<LoadedSequences, CannotExplore> {
        let manual = self.checker.with_rules(&self.topic_path(), &self.topic(sequences));
        Ok(LoadedSequences { manual: manual.map_err(CannotExplore::NotUnderstood)?, steps: sequences.to_vec() })
    }

    /// Takes out the steps that the bench of a live device cannot or may not do, and with a connection all that is done in it.
    pub fn retain_possible(&self, steps: &mut Vec<SequenceStep>, dut: &DutSpec) {
        if dut.live().is_none() || self.are_possible(std::slice::from_ref(steps), dut).is_ok_and(|are| are == [true]) {
            return;
        }
        let mut connection = Vec::new();
        let in_connection = steps.iter().map(|step| {
            if matches!(step.action, ControllerAction::Connect(_)) {
                connection = vec![step.clone()];
                return connection.clone();
            }
            [connection.as_slice(), std::slice::from_ref(step)].concat()
        });
        let single: Vec<Vec<SequenceStep>> = in_connection.collect();
        let are = self.are_possible(&single, dut).unwrap_or_else(|_| {
            let alone = |step| self.are_possible(std::slice::from_ref(step), dut).is_ok_and(|are| are == [true]);
            single.iter().map(alone).collect()
        });
        let mut are = are.into_iter();
        steps.retain(|_| are.next() == Some(true));
        // Together they may need more memory writes or time than are left.
        while !steps.is_empty() && self.are_possible(std::slice::from_ref(steps), dut).is_ok_and(|are| are != [true]) {
            steps.truncate(steps.len() * 3 / 4);
        }
    }

    /// Whether the bench of a live device permits each of the sequences. Fails if one does not load.
    fn are_possible(&self, sequences: &[Vec<SequenceStep>], dut: &DutSpec) -> Result<Vec<bool>, CannotExplore> {
        let loaded = self.load(sequences)?;
        let Some((live, variant)) = dut.live().zip(loaded.manual.variants.get(self.variant)) else {
            return Ok(vec![true; sequences.len()]);
        };
        Ok(variant.trials.iter().map(|trial| live.objection(variant, trial).is_none()).collect())
    }

    fn topic_path(&self) -> String {
        format!("{}/{TOPIC}.yaml", self.manual.device.name)
    }

    /// Runs the sequence with this number on a device.
    pub fn run(&self, loaded: &LoadedSequences, number: usize, dut: &DutSpec) -> Result<SequenceLog, CannotExplore> {
        if (self.is_stopped)() {
            return Err(CannotExplore::Interrupted);
        }
        let nothing = || CannotExplore::Nothing(format!("the sequence does not apply to {}", self.variant()));
        let manual = &loaded.manual;
        let variant = manual.variants.get(self.variant).ok_or_else(nothing)?;
        let trial = variant.trials.get(number).ok_or_else(nothing)?;
        let options = RunOptions { unjudged: true, stall_repeats: STALL_REPEATS, ..RunOptions::default() };
        let outcome = run_trial(manual, variant, dut, trial, &options)?;
        let frames = outcome.trace.len();
        let requirements = &manual.requirements;
        let broken = variant.rules.iter().zip(&outcome.rules).filter_map(|(rule, result)| {
            let (_, failure) = result.broken.as_ref()?;
            let covers = rule.covers.iter().filter_map(|index| Some(requirements.get(*index)?.id.clone()));
            Some(BrokenRule { id: rule.id.clone(), what: failure.what.clone(), covers: covers.collect() })
        });
        let broken = broken.collect();
        let is_virtual = dut.live().is_none_or(LiveDevice::is_virtual);
        let spoilt = outcome.disturbed.map(|disturbance| disturbance.why);
        let is_unsent = !is_virtual && frames == 0;
        let is_excluded = is_unsent || matches!(outcome.case.verdict, Verdict::NotApplicable | Verdict::NotRun);
        let excluded = outcome.case.reason.clone().filter(|_| is_excluded);
        let mut log = outcome.log.map(|log| *log).unwrap_or_default();
        let error = match &spoilt {
            // A virtual wire is disturbed only by the program that is the device.
            Some(why) if is_virtual => Some(("failed-program", format!("The program failed: {why}"))),
            None if log.steps.is_empty() => {
                let why = outcome.case.reason.unwrap_or_default();
                Some((SILENCE, format!("The device does not show its identity: {why}")))
            }
            Some(_) | None => None,
        };
        let steps = loaded.steps.get(number).map_or(&[][..], Vec::as_slice);
        let kept = retention::broken(&self.manual.device, steps, &log).map(|what| (RETENTION, what));
        log.protocol_errors.extend(error.into_iter().chain(kept).map(|(kind, what)| ProtocolError { kind, what }));
        Ok(SequenceLog { log, frames, broken, spoilt: excluded.or(spoilt.filter(|_| !is_virtual)) })
    }

    /// Loads and runs one sequence.
    pub fn drive(&self, steps: &[SequenceStep], dut: &DutSpec) -> Result<SequenceLog, CannotExplore> {
        self.run(&self.load(&[steps.to_vec()])?, 0, dut)
    }

    /// Runs a written case.
    pub fn judge(
        &self,
        case: &WrittenCase,
        dut: &DutSpec,
        evidence: Option<&Path>,
    ) -> Result<TrialOutcome, CannotExplore> {
        let manual = self.checker.alone(&self.topic_path(), &case.yaml()).map_err(CannotExplore::NotUnderstood)?;
        let nothing = || CannotExplore::Nothing(format!("the case does not apply to {}", self.variant()));
        let variant = manual.variants.get(self.variant).ok_or_else(nothing)?;
        let trial = variant.trials.first().ok_or_else(nothing)?;
        let options = RunOptions { evidence: evidence.map(Path::to_owned), ..RunOptions::default() };
        Ok(run_trial(&manual, variant, dut, trial, &options)?)
    }
}
