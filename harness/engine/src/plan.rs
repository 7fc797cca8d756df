//! Selects the trials for each device, and runs them on several threads.
//!
//! Models need no real time, so their trials are shared by all threads. This module must not know what a trial does.

use super::described::described;
use super::dut::DutSpec;
use super::likely_reading::likely_reading;
use super::live::TrialExclusion;
use super::live_run;
use super::one_trial::run_admitted;
use super::options::{RunOptions, RunProgress};
use super::outcome::TrialOutcome;
use results::verdict::Verdict;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use suite::model::{Manual, SuiteRule, SuiteVariant, Trial};
use virtual_wire::Trace;

/// The trials to be run on one device.
pub(super) struct DevicePlan<'a> {
    pub manual: &'a Manual,
    /// The manual with another description of the device, if its variations have one.
    described: Option<Manual>,
    pub variant: &'a SuiteVariant,
    pub dut: &'a DutSpec,
    pub trials: Vec<&'a Trial>,
    /// Whether all trials are run for the rules: then those that are not selected are not reported.
    pub for_rules: bool,
}

impl<'a> DevicePlan<'a> {
    /// Selects the trials of a device by `options`.
    pub fn new(
        manual: &'a Manual,
        variant: &'a SuiteVariant,
        dut: &'a DutSpec,
        options: &RunOptions,
    ) -> DevicePlan<'a> {
        let selection = &options.selection;
        let is_selected = |rule: &SuiteRule| selection.rule(manual, variant, rule);
        let all = variant.trials.iter();
        let mut trials: Vec<&Trial> = all.clone().filter(|trial| selection.trial(manual, variant, trial)).collect();
        let names_only_rules = trials.is_empty() && variant.rules.iter().any(is_selected);
        let for_rules = names_only_rules || selection.has_broken_rule(manual, variant);
        if for_rules {
            trials = all.collect();
        }
        if let Some(part) = options.part {
            trials = trials.into_iter().enumerate().filter(|(at, _)| part.has(*at)).map(|(_, trial)| trial).collect();
        }
        DevicePlan { manual, described: described(manual, dut), variant, dut, trials, for_rules }
    }

    /// The manual with the description of this device.
    pub fn described(&self) -> &Manual {
        self.described.as_ref().unwrap_or(self.manual)
    }

    /// The name of the device for the progress.
    pub fn label(&self) -> String {
        format!("{}/{}", self.dut.manual, self.dut.variant)
    }

    /// Runs one of the trials; its frames are not kept.
    fn run(&self, trial: &Trial, options: &RunOptions) -> Result<TrialOutcome, String> {
        let mut outcome = run_admitted(self.described(), self.variant, self.dut, trial, options)?;
        outcome.trace = Trace::new();
        outcome.likely_reading = likely_reading(self.manual, self.variant, self.dut, trial, (&outcome, options));
        if outcome.case.verdict != Verdict::Pass {
            outcome.case.notes.extend(outcome.likely_reading.clone());
        }
        Ok(outcome)
    }

    /// Runs all trials of several plans in parallel; the outcomes are in the order of the plans and their trials.
    pub fn run_together(
        plans: &[&DevicePlan<'_>],
        options: &RunOptions,
        progress: RunProgress<'_>,
    ) -> Vec<Vec<Result<TrialOutcome, String>>> {
        let jobs: Vec<(usize, &Trial)> = plans
            .iter()
            .enumerate()
            .flat_map(|(index, plan)| plan.trials.iter().map(move |trial| (index, *trial)))
            .collect();
        let labels: Vec<String> = plans.iter().map(|plan| plan.label()).collect();
        let said = |at: usize, done| progress(&labels[jobs[at].0], done, jobs.len());
        let mut outcomes = all(&jobs, options.threads, &said, &|(index, trial)| plans[index].run(trial, options));
        let mut of_plans: Vec<_> =
            plans.iter().rev().map(|plan| outcomes.split_off(outcomes.len() - plan.trials.len())).collect();
        of_plans.reverse();
        of_plans
    }

    /// The outcomes of the trials if none of them runs.
    pub fn not_judged(&self, why: &str) -> Vec<Result<TrialOutcome, String>> {
        let not_run = |trial: &&Trial| {
            let excluded = TrialExclusion::NotRun(why.to_owned());
            Ok(live_run::not_run(self.described(), self.variant, trial, excluded))
        };
        self.trials.iter().map(not_run).collect()
    }

    /// Runs the trials one after the other.
    pub fn run_alone(&self, options: &RunOptions, progress: RunProgress<'_>) -> Vec<Result<TrialOutcome, String>> {
        let (label, count) = (self.label(), self.trials.len());
        all(&self.trials, 1, &|_, done| progress(&label, done, count), &|trial| self.run(trial, options))
    }
}

/// Does `work` for each item on some threads; a single one is the calling thread. The results have the order of the items.
/// `progress` receives the index of the finished item, and how many are finished.
fn all<T: Copy + Sync, R: Send>(
    items: &[T],
    threads: usize,
    progress: &(dyn Fn(usize, usize) + Sync),
    work: &(dyn Fn(T) -> R + Sync),
) -> Vec<R> {
    let threads = match threads {
        0 => thread::available_parallelism().map_or(1, usize::from),
        threads => threads,
    };
    if threads == 1 {
        let one = |(at, item): (usize, &T)| {
            let result = work(*item);
            progress(at, at + 1);
            result
        };
        return items.iter().enumerate().map(one).collect();
    }
    let next = AtomicUsize::new(0);
    let done = AtomicUsize::new(0);
    let results = Mutex::new(Vec::with_capacity(items.len()));
    thread::scope(|scope| {
        for _ in 0..threads.min(items.len()) {
            scope.spawn(|| {
                loop {
                    let index = next.fetch_add(1, Ordering::Relaxed);
                    let Some(item) = items.get(index) else { break };
                    let result = work(*item);
                    results.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).push((index, result));
                    progress(index, done.fetch_add(1, Ordering::Relaxed) + 1);
                }
            });
        }
    });
    let mut results = results.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    results.sort_by_key(|(index, _)| *index);
    results.into_iter().map(|(_, result)| result).collect()
}
