//! Runs sequences on devices, and written cases.

use crate::step::SequenceStep;
use compare::write_case::{TOPIC, WrittenCase};
use engine::step_log::{ProtocolError, StepLog};
use engine::{BenchError, DutSpec, RunOptions, TrialOutcome, run_trial};
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
    /// The manual has nothing to explore.
    #[error("{0}")]
    Nothing(String),
}

/// What a device did in a sequence.
#[derive(Clone, Debug)]
pub struct SequenceLog {
    pub log: StepLog,
    /// Number of frames.
    pub frames: usize,
}

/// A rule that broke in a sequence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BrokenRule {
    pub id: String,
    pub what: String,
    /// The requirements that it covers.
    pub covers: Vec<String>,
}

/// Sequences that are loaded and can be run on any device of the manual.
pub struct LoadedSequences {
    manual: Manual,
}

/// A manual whose devices are explored.
pub struct ExploreBench<'m> {
    manual: &'m Manual,
    variant: usize,
    checker: Checker,
    sources: Sources,
    /// A requirement that applies: the loader takes no case without one.
    requirement: String,
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
        Ok(ExploreBench { manual, variant, checker, sources: sources.clone(), requirement })
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
        let mut out = format!("suite: {TOPIC}\ncases:\n");
        for (number, steps) in sequences.iter().enumerate() {
            let _ = writeln!(
                out,
                "  - id: sequence-{number}\n    why: A sequence.\n    covers: [{}]\n    variants: [{}]\n    start: none\n    steps:",
                self.requirement,
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
        self.load_text(&self.topic(sequences))
    }

    fn load_text(&self, text: &str) -> Result<LoadedSequences, CannotExplore> {
        let path = format!("{}/{TOPIC}.yaml", self.manual.device.name);
        let manual = self.checker.alone(&path, text).map_err(CannotExplore::NotUnderstood)?;
        Ok(LoadedSequences { manual })
    }

    /// Runs the sequence with this number on a device.
    pub fn run(&self, loaded: &LoadedSequences, number: usize, dut: &DutSpec) -> Result<SequenceLog, CannotExplore> {
        let nothing = || CannotExplore::Nothing(format!("the sequence does not apply to {}", self.variant()));
        let variant = loaded.manual.variants.get(self.variant).ok_or_else(nothing)?;
        let trial = variant.trials.get(number).ok_or_else(nothing)?;
        let options = RunOptions { unjudged: true, ..RunOptions::default() };
        let outcome = run_trial(&loaded.manual, variant, dut, trial, &options)?;
        let frames = outcome.trace.len();
        let silent = |why: String| {
            let error =
                ProtocolError { kind: "silence", what: format!("The device does not show its identity: {why}") };
            let mut log = StepLog::default();
            log.protocol_errors.push(error);
            log
        };
        let log = match outcome.log {
            Some(log) => *log,
            None => silent(outcome.case.reason.unwrap_or_default()),
        };
        Ok(SequenceLog { log, frames })
    }

    /// Loads and runs one sequence.
    pub fn drive(&self, steps: &[SequenceStep], dut: &DutSpec) -> Result<SequenceLog, CannotExplore> {
        self.run(&self.load(&[steps.to_vec()])?, 0, dut)
    }

    /// The rules of the manual that break in a sequence.
    pub fn broken_rules(&self, steps: &[SequenceStep], dut: &DutSpec) -> Result<Vec<BrokenRule>, CannotExplore> {
        let name = &self.manual.device.name;
        let sources = self.sources.clone().with(&format!("{name}/{TOPIC}.yaml"), self.topic(&[steps.to_vec()]));
        let mut loaded = suite_yaml::load(&sources, Some(name)).map_err(CannotExplore::NotUnderstood)?;
        let manual = loaded.pop().ok_or_else(|| CannotExplore::Nothing(format!("there is no suite for {name}")))?;
        let nothing = || CannotExplore::Nothing(format!("the sequence does not apply to {}", self.variant()));
        let variant = manual.variants.get(self.variant).ok_or_else(nothing)?;
        let own = format!("{TOPIC}/");
        let trial = variant.trials.iter().find(|trial| trial.id.starts_with(&own)).ok_or_else(nothing)?;
        let options = RunOptions { unjudged: true, ..RunOptions::default() };
        let outcome = run_trial(&manual, variant, dut, trial, &options)?;
        let broken = variant.rules.iter().zip(&outcome.rules).filter_map(|(rule, result)| {
            let (_, failure) = result.broken.as_ref()?;
            let covers = rule.covers.iter().filter_map(|index| Some(manual.requirements.get(*index)?.id.clone()));
            Some(BrokenRule { id: rule.id.clone(), what: failure.what.clone(), covers: covers.collect() })
        });
        Ok(broken.collect())
    }

    /// Runs a written case.
    pub fn judge(
        &self,
        case: &WrittenCase,
        dut: &DutSpec,
        evidence: Option<&Path>,
    ) -> Result<TrialOutcome, CannotExplore> {
        let loaded = self.load_text(&case.yaml())?;
        let nothing = || CannotExplore::Nothing(format!("the case does not apply to {}", self.variant()));
        let variant = loaded.manual.variants.get(self.variant).ok_or_else(nothing)?;
        let trial = variant.trials.first().ok_or_else(nothing)?;
        let options = RunOptions { evidence: evidence.map(Path::to_owned), ..RunOptions::default() };
        Ok(run_trial(&loaded.manual, variant, dut, trial, &options)?)
    }
}
