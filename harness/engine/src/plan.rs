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
        let work = StoppableWork {
            run: &|(index, trial): (usize, &Trial)| plans[index].run(trial, options),
            stops: &|(index, _), outcome| plans[index].stops(outcome, options),
            skip: &|(index, trial)| Ok(plans[index].not_judged_trial(trial, STOPPED)),
        };
        let mut outcomes = all(&jobs, options.threads, &said, &work);
        let mut of_plans: Vec<_> =
            plans.iter().rev().map(|plan| outcomes.split_off(outcomes.len() - plan.trials.len())).collect();
        of_plans.reverse();
        of_plans
    }

    /// The outcomes of the trials if none of them runs.
    pub fn not_judged(&self, why: &str) -> Vec<Result<TrialOutcome, String>> {
        self.trials.iter().map(|trial| Ok(self.not_judged_trial(trial, why))).collect()
    }

    fn not_judged_trial(&self, trial: &Trial, why: &str) -> TrialOutcome {
        live_run::not_run(self.described(), self.variant, trial, TrialExclusion::NotRun(why.to_owned()))
    }

    /// Whether an outcome ends the run.
    pub fn stops(&self, outcome: &Result<TrialOutcome, String>, options: &RunOptions) -> bool {
        let Some(stops) = &options.fail_fast else { return false };
        outcome.as_ref().map_or(true, |outcome| (stops.0)(self.dut, &outcome.case))
    }

    /// Runs the trials one after the other.
    pub fn run_alone(&self, options: &RunOptions, progress: RunProgress<'_>) -> Vec<Result<TrialOutcome, String>> {
        let (label, count) = (self.label(), self.trials.len());
        let work = StoppableWork {
            run: &|trial: &Trial| self.run(trial, options),
            stops: &|_, outcome| self.stops(outcome, options),
            skip: &|trial| Ok(self.not_judged_trial(trial, STOPPED)),
        };
        all(&self.trials, 1, &|_, done| progress(&label, done, count), &work)
    }
}

/// Why a trial was not run after one that ended the run.
pub(super) const STOPPED: &str = "not run: an earlier result is red, and --fail-fast ends the run there";

/// Work on items that ends at the first result that stops it.
struct StoppableWork<'a, T, R> {
    run: &'a (dyn Fn(T) -> R + Sync),
    /// Whether the result of an item ends the work.
    stops: &'a (dyn Fn(T, &R) -> bool + Sync),
    /// The result of an item after that.
    skip: &'a (dyn Fn(T) -> R + Sync),
}

/// Does `work` for each item on some threads; a single one is the calling thread. The results have the order of the items, and all
/// after the first one that stops are skipped, on whatever thread they are. `progress` receives the index of the finished item, and
/// how many are finished.
fn all<T: Copy + Sync, R: Send>(
    items: &[T],
    threads: usize,
    progress: &(dyn Fn(usize, usize) + Sync),
    work: &StoppableWork<'_, T, R>,
) -> Vec<R> {
    let last = AtomicUsize::new(usize::MAX);
    let one = |at: usize, item: T| {
        if at > last.load(Ordering::Relaxed) {
            return (work.skip)(item);
        }
        let result = (work.run)(item);
        if (work.stops)(item, &result) {
            last.fetch_min(at, Ordering::Relaxed);
        }
        result
    };
    let threads = match threads {
        0 => thread::available_parallelism().map_or(1, usize::from),
        threads => threads,
    };
    if threads == 1 {
        let each = |(at, item): (usize, &T)| {
            let result = one(at, *item);
            progress(at, at + 1);
            result
        };
        return items.iter().enumerate().map(each).collect();
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
                    let result = one(index, *item);
                    results.lock().unwrap_or_else(|poisoned| poisoned.into_inner()).push((index, result));
                    progress(index, done.fetch_add(1, Ordering::Relaxed) + 1);
                }
            });
        }
    });
    let mut results = results.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    results.sort_by_key(|(index, _)| *index);
    // Another thread may have run an item before the stop was known.
    let last = last.load(Ordering::Relaxed);
    let kept = |(at, result): (usize, R)| if at > last { (work.skip)(items[at]) } else { result };
    results.into_iter().map(kept).collect()
}
