//! What fails beyond the requirements that a bug breaks.

use engine::{BenchError, DutKind, DutSpec, RunOptions, Selection, run};
use results::outcome::{CaseKind, CaseResult, Covered, DeviceRun, RunResult};
use results::verdict::Verdict;
use std::collections::{BTreeMap, BTreeSet};
use std::slice;
use suite::model::{Bug, Level, Manual};

/// The requirements that fail with one bug, in any variant.
#[derive(Debug)]
pub struct BugEffect<'a> {
    /// The bug.
    pub bug: &'a Bug,
    /// The requirements that fail although the bug does not break them, each with the failures of its cases.
    pub beyond: BTreeMap<usize, Vec<ForeignFailure>>,
    /// The requirements that the bug breaks and that do not fail.
    pub missed: BTreeSet<usize>,
    /// Number of failed trials, and of those that could be judged.
    pub trials: (usize, usize),
    /// How the report groups the failures, for each variant in which a requirement fails that the bug breaks.
    pub causes: Vec<CauseOfBug>,
}

/// Whether the first group of a report has a requirement that the bug breaks.
#[derive(Clone, Debug)]
pub struct CauseOfBug {
    /// Number of groups.
    pub groups: usize,
    /// Number of results in the first group, and of all failures.
    pub size: (usize, usize),
    /// Whether a requirement that the bug breaks fails in the first group.
    pub is_first: bool,
    /// Whether it fails in the case that the report begins with.
    pub begins: bool,
    /// The case that the report begins with, and what the group has in common.
    pub text: String,
}

/// A case or rule that fails a requirement that the bug does not break.
#[derive(Clone, Debug)]
pub struct ForeignFailure {
    /// The case or rule.
    pub case: String,
    /// The step that failed, with its position.
    pub step: String,
}

impl<'a> BugEffect<'a> {
    /// Runs every case of the manual itself with this bug; those of suites that the manual uses too are proven where they stand.
    ///
    /// # Errors
    ///
    /// If the reference device cannot be built.
    pub fn of(manual: &'a Manual, bug: &'a Bug, threads: usize) -> Result<BugEffect<'a>, BenchError> {
        let dut = |variant: &suite::model::SuiteVariant| DutSpec {
            manual: manual.device.name.clone(),
            variant: variant.name.clone(),
            kind: DutKind::Model { deviations: vec![bug.name.clone()] },
        };
        let duts = manual.variants.iter().map(dut).collect();
        let options = RunOptions { duts, threads, selection: Selection::own(), ..RunOptions::default() };
        let result = run(slice::from_ref(manual), &options, &|_, _, _| {})?;
        Ok(BugEffect::from_run(bug, &result))
    }

    fn from_run(bug: &'a Bug, result: &RunResult) -> BugEffect<'a> {
        let mut beyond: BTreeMap<usize, Vec<ForeignFailure>> = BTreeMap::new();
        let mut missed: BTreeSet<usize> = bug.breaks.iter().copied().collect();
        for case in result.runs.iter().flat_map(|run| &run.cases) {
            for covered in case.covers.iter().filter(|covered| covered.verdict == Verdict::Fail) {
                missed.remove(&covered.requirement);
                if !bug.breaks.contains(&covered.requirement) {
                    beyond.entry(covered.requirement).or_default().push(foreign(case, &covered.id));
                }
            }
        }
        let trials = || result.runs.iter().flat_map(|run| &run.cases).filter(|case| case.kind == CaseKind::Trial);
        let count = |verdict| trials().filter(|case| case.verdict == verdict).count();
        let failed = count(Verdict::Fail);
        let causes = result.runs.iter().filter_map(|run| cause(bug, run)).collect();
        BugEffect { bug, beyond, missed, trials: (failed, failed + count(Verdict::Pass)), causes }
    }

    /// Whether everything that the bug breaks is below `must`.
    pub fn breaks_no_must(&self, manual: &Manual) -> bool {
        self.bug.breaks.iter().all(|&of| level(manual, of) != Level::Must)
    }

    /// The `must` requirements among those that fail although the bug does not break them.
    pub fn musts<'b>(&'b self, manual: &'b Manual) -> impl Iterator<Item = usize> + 'b {
        self.beyond.keys().copied().filter(|&of| level(manual, of) == Level::Must)
    }

    /// Whether it is a bug of the whole telegram: more than a quarter of the trials that can be judged fail with it. A device that
    /// accepts no connection leaves few of them.
    pub fn is_of_whole_telegram(&self) -> bool {
        let (failed, judged) = self.trials;
        failed * 4 > judged
    }
}

fn cause(bug: &Bug, run: &DeviceRun) -> Option<CauseOfBug> {
    let first = run.causes.first()?;
    let breaks = |case: &&CaseResult| {
        let is_broken = |of: &&Covered| of.verdict == Verdict::Fail && bug.breaks.contains(&of.requirement);
        case.covers.iter().any(|of| is_broken(&of))
    };
    if !run.cases.iter().any(|case| breaks(&case)) {
        return None;
    }
    let find = |id: &String| run.cases.iter().find(|case| case.id == *id);
    Some(CauseOfBug {
        groups: run.causes.len(),
        size: (first.cases.len(), run.causes.iter().map(|cause| cause.cases.len()).sum()),
        is_first: first.cases.iter().filter_map(find).any(|case| breaks(&case)),
        begins: first.cases.first().and_then(find).is_some_and(|case| breaks(&case)),
        text: format!("{}: {}", first.cases.first().cloned().unwrap_or_default(), first.common.join(", ")),
    })
}

fn level(manual: &Manual, of: usize) -> Level {
    manual.requirements.get(of).map_or(Level::Must, |of| of.level)
}

/// The failure of a case that counts for a requirement.
fn foreign(case: &CaseResult, requirement: &str) -> ForeignFailure {
    let counts =
        |failure: &&results::outcome::CaseFailure| failure.requirements.iter().any(|(id, _, _)| id == requirement);
    let failure = case.failures.iter().find(counts).or(case.failures.first());
    let step = failure.map(|failure| {
        format!("{}:{}: {}: {}", failure.at.file.display(), failure.at.line, failure.step, failure.what)
    });
    ForeignFailure { case: case.id.clone(), step: step.unwrap_or_default() }
}

/// The value below which this share of the sorted numbers lies, in percent.
pub fn percentile(numbers: &[usize], percent: usize) -> usize {
    let mut sorted = numbers.to_vec();
    sorted.sort_unstable();
    let at = (sorted.len() * percent).div_ceil(100).max(1) - 1;
    sorted.get(at).copied().unwrap_or_default()
}
