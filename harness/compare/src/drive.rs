//! Drives a device with a script: makes a trial of the script, lets the engine run it, and extracts the conversation from its trace.
//!
//! This module must not know which kind of device that is, nor how the answers are used.

use super::action::ControllerAction;
use super::conversation::Conversation;
use super::extract::{ManualVariant, extract};
use super::masks::Masks;
use super::write_case::{TOPIC, WrittenCase, unjudged};
use engine::{BenchError, DutSpec, RunOptions, TrialOutcome, run_trial};
use results::verdict::Verdict;
use std::time::Duration;
use suite::model::{Manual, RequirementClass};
use suite_yaml::{Checker, LoadErrors, Sources};

/// The wait after the last step, for its effects.
pub const TAIL: Duration = Duration::from_millis(300);
/// How often a live device is driven until no disturbance occurs.
const TRIES: usize = 5;
/// The comment of the engine on the first frame after the last step.
const CLEAN_UP: &str = "clean-up";

/// Why a script could not be driven.
#[derive(Debug, thiserror::Error)]
pub enum CannotDrive {
    /// The written steps do not load; each error has its line.
    #[error("the steps made from the capture do not load:\n{0}")]
    NotUnderstood(LoadErrors),
    /// The bench cannot be used.
    #[error(transparent)]
    Bench(#[from] BenchError),
    /// The line broke or the harness was late in each attempt.
    #[error("{0}")]
    Disturbed(String),
    /// The manual has no requirement or variant for it, or the device could not be driven.
    #[error("{0}")]
    Nothing(String),
}

/// The variant of a manual for which scripts are driven.
pub struct ScriptBench<'m> {
    manual: &'m Manual,
    variant: usize,
    checker: Checker,
    requirement: String,
}

impl<'m> ScriptBench<'m> {
    /// # Errors
    ///
    /// The manual is not in `sources`, or has no such variant.
    pub fn new(sources: &Sources, manual: &'m Manual, variant: &str) -> Result<ScriptBench<'m>, CannotDrive> {
        let name = &manual.device.name;
        let index = manual.device.variants.iter().position(|known| known == variant);
        let variant = index.ok_or_else(|| CannotDrive::Nothing(format!("{name} has no variant {variant}")))?;
        let applies = manual.requirements.iter().find(|requirement| {
            requirement.class == RequirementClass::Testable && requirement.variants.contains(&variant)
        });
        let requirement =
            applies.ok_or_else(|| CannotDrive::Nothing(format!("{name} has no requirements")))?.id.clone();
        let checker = Checker::unchecked(sources, name).map_err(CannotDrive::NotUnderstood)?;
        Ok(ScriptBench { manual, variant, checker, requirement })
    }

    pub fn manual(&self) -> &'m Manual {
        self.manual
    }

    /// The masks from a file, given by its name and text, else those of the manual.
    pub fn masks(&self, named: Option<(&str, &str)>) -> Result<Masks, CannotDrive> {
        self.checker.masks(named).map(Masks::from).map_err(CannotDrive::NotUnderstood)
    }

    /// The variant of the manual.
    pub fn manual_variant(&self) -> ManualVariant<'m> {
        ManualVariant { manual: self.manual, variant: self.variant }
    }

    /// The name of the variant.
    pub fn variant(&self) -> &'m str {
        self.manual.device.variants.get(self.variant).map_or("", String::as_str)
    }

    /// Drives a device with a script and a short wait at the end; repeats it on a live device after a disturbance.
    pub fn drive(&self, script: &[ControllerAction], dut: &DutSpec) -> Result<Conversation, CannotDrive> {
        let mut script = script.to_vec();
        script.push(ControllerAction::Wait(TAIL));
        let written = WrittenCase {
            id: "drive".to_owned(),
            why: "The controller side of a capture.".to_owned(),
            variant: self.variant().to_owned(),
            steps: unjudged(&script, &self.requirement, &|name| self.is_read_only(name)),
            ..WrittenCase::default()
        };
        let outcome = self.run_undisturbed(&written.yaml(), dut)?;
        if outcome.trace.is_empty() {
            let why = outcome.case.reason.unwrap_or_else(|| "there was no frame".to_owned());
            return Err(CannotDrive::Nothing(format!("the device could not be driven: {why}")));
        }
        let mut frames = Vec::new();
        for frame in outcome.trace.iter() {
            if frame.comment.is_some_and(|comment| comment.lines().any(|line| line == CLEAN_UP)) {
                break;
            }
            frames.push((frame.number as u64, frame.time, frame.octets));
        }
        Ok(extract(self.manual_variant(), frames.into_iter()))
    }

    /// Runs a written case, on a live device until no disturbance occurs.
    pub fn run_undisturbed(&self, yaml: &str, dut: &DutSpec) -> Result<TrialOutcome, CannotDrive> {
        let mut last = String::new();
        for _ in 0..TRIES {
            let outcome = self.run(yaml, dut)?;
            let undecided =
                (outcome.case.verdict == Verdict::Inconclusive).then(|| outcome.case.reason.clone()).flatten();
            match outcome.disturbed.as_ref().map(|of| of.why.clone()).or(undecided) {
                Some(why) if dut.live().is_some() => last = why,
                _ => return Ok(outcome),
            }
        }
        Err(CannotDrive::Disturbed(format!(
            "the device was driven {TRIES} times, each time with a disturbance; the last one: {last}"
        )))
    }

    /// Whether a name is a read-only parameter or an element of one.
    fn is_read_only(&self, name: &str) -> bool {
        let number = name.strip_prefix('P').and_then(|rest| rest.split('.').next()?.parse::<u16>().ok());
        let known = number.and_then(|number| self.manual.device.parameters.iter().find(|of| of.number == number));
        known.is_some_and(|parameter| !parameter.writable)
    }

    /// Loads a written case and runs it.
    pub fn run(&self, yaml: &str, dut: &DutSpec) -> Result<TrialOutcome, CannotDrive> {
        let path = format!("{}/{TOPIC}.yaml", self.manual.device.name);
        let mut manual = self.checker.alone(&path, yaml).map_err(CannotDrive::NotUnderstood)?;
        if let Some(live) = dut.live() {
            // The bench file and the descriptions of the device add to the manual.
            manual.device.clone_from(&live.manual().device);
        }
        let nothing = || CannotDrive::Nothing(format!("the written case does not apply to {}", self.variant()));
        let variant = manual.variants.get(self.variant).ok_or_else(nothing)?;
        let trial = variant.trials.first().ok_or_else(nothing)?;
        Ok(run_trial(&manual, variant, dut, trial, &RunOptions::default())?)
    }
}
