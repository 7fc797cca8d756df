//! Every case can fail: each bug makes the cases and rules fail that list it under `catches`, and the requirements that it breaks.

use crate::built_in::{self, manuals};
use crate::on_two_threads::every;
use encspec::engine::scan::check_covers;
use encspec::engine::{DutKind, DutSpec, RunOptions, run, run_trial};
use encspec::suite::model::{Bug, Manual, SuiteRule, SuiteVariant, Trial};
use encspec::verdict::Verdict;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicUsize, Ordering};

#[test]
fn the_reference_device_has_every_bug_that_the_suite_lists() {
    for manual in manuals() {
        let offered = deviations::subject(&manual.device.name).expect("a reference device for every suite");
        let offered: BTreeSet<&str> = offered.bugs().map(|bug| bug.name).collect();
        let listed: BTreeSet<&str> = manual.bugs.iter().map(|bug| bug.name.as_str()).collect();
        let unknown: Vec<&&str> = listed.difference(&offered).collect();
        assert!(unknown.is_empty(), "the reference device of {} has no such bugs: {unknown:?}", manual.device.name);
        assert!(listed.len() >= 25);
    }
}

/// Bugs that no suite lists, since they need frames that the controllers of the harness never send. Unit tests of `deviations` show
/// them.
const SHOWN_BY_UNIT_TESTS: [&str; 2] = ["answers-too-late", "clear-zeroes-inputs"];

#[test]
fn each_bug_of_a_reference_device_is_listed_by_a_suite() {
    let listed: BTreeSet<&str> =
        manuals().iter().flat_map(|manual| &manual.bugs).map(|bug| bug.name.as_str()).collect();
    let offered: BTreeSet<&str> =
        deviations::subjects().iter().flat_map(|subject| subject.bugs()).map(|bug| bug.name).collect();
    let unlisted: Vec<&str> = offered.difference(&listed).copied().collect();
    let known = BTreeSet::from(SHOWN_BY_UNIT_TESTS);
    assert_eq!(unlisted.into_iter().collect::<BTreeSet<&str>>(), known);
}

#[test]
fn an_answer_before_min_tsdr_or_after_max_tsdr_fails_every_trial_with_an_answer() {
    for manual in manuals().iter().filter(|manual| manual.device.profibus().is_some()) {
        let variant = &manual.variants[0];
        for (bug, why) in [("answers-too-early", "min TSDR is 11"), ("answers-after-max-tsdr", "max TSDR is 150")] {
            // At other baud rates 155 bits may be permitted.
            let is_usual =
                |trial: &&Trial| trial.start().is_some_and(|start| start.baud.is_none() && start.isochronous.is_none());
            let trial = variant.trials.iter().find(is_usual).expect("a trial with a usual start");
            let dut = built_in::model(manual, variant, &[bug]);
            let case =
                run_trial(manual, variant, &dut, trial, &RunOptions::default()).expect("a model can be run").case;
            assert_eq!(case.verdict, Verdict::Fail, "{}", case.id);
            let reason = case.reason.unwrap_or_default();
            assert!(reason.contains("out of turn") && reason.contains(why), "{}: {reason}", case.id);
        }
    }
}

#[test]
fn every_case_catches_a_bug_and_every_bug_is_caught() {
    for manual in manuals() {
        let variants = || manual.variants.iter();
        let trials = || variants().flat_map(|variant| &variant.trials).filter(|trial| manual.is_own(trial));
        let catching: BTreeSet<&str> =
            trials().filter(|trial| !trial.catches.is_empty()).map(|trial| trial.case()).collect();
        let blind: BTreeSet<&str> =
            trials().map(|trial| trial.case()).filter(|case| !catching.contains(case)).collect();
        assert!(blind.is_empty(), "no bug makes these cases fail: {blind:?}");
        let rules: BTreeMap<&str, bool> = variants()
            .flat_map(|variant| &variant.rules)
            .map(|rule| (rule.id.as_str(), rule.catches.is_empty()))
            .collect();
        assert!(rules.values().all(|is_blind| !is_blind), "no bug makes some of these rules fail: {rules:?}");
        let by_cases = variants().flat_map(|variant| &variant.trials).flat_map(|trial| &trial.catches);
        let by_rules = variants().flat_map(|variant| &variant.rules).flat_map(|rule| &rule.catches);
        let caught: BTreeSet<&str> = by_cases.chain(by_rules).map(String::as_str).collect();
        let uncaught: Vec<&str> =
            manual.bugs.iter().map(|bug| bug.name.as_str()).filter(|name| !caught.contains(name)).collect();
        assert!(uncaught.is_empty(), "no case or rule catches {uncaught:?}");
    }
}

#[test]
fn without_a_bug_every_case_passes_and_every_rule_is_decided() {
    let manuals = manuals();
    for manual in manuals {
        for variant in &manual.variants {
            let name = (manual.device.name.clone(), variant.name.clone());
            let conforming =
                DutSpec { manual: name.0, variant: name.1, kind: DutKind::Model { deviations: Vec::new() } };
            let options = RunOptions { duts: vec![conforming], ..RunOptions::default() };
            let result = run(std::slice::from_ref(manual), &options, &|_, _, _| {}).expect("a model can be run");
            let cases = result.runs.iter().flat_map(|run| &run.cases);
            let others: Vec<String> = cases
                .filter(|case| case.verdict != Verdict::Pass)
                .map(|case| format!("{} {}", case.verdict, case.id))
                .collect();
            assert!(others.is_empty(), "{}: {others:#?}", variant.name);
        }
    }
}

/// Each bug makes every row and rule fail that lists it under `catches`, in at least one variant, and every requirement that it breaks.
///
/// For each bug the trials that catch it run first; they usually fail all requirements that it breaks. What is still open is tested
/// with the other trials that cover it, and what only a rule can show with all trials.
#[test]
fn each_bug_shows_in_each_case_and_each_requirement_that_names_it() {
    let manuals = manuals();
    let bugs: Vec<(&Manual, &Bug)> =
        manuals.iter().flat_map(|manual| manual.bugs.iter().map(move |bug| (manual, bug))).collect();
    let pairs = AtomicUsize::new(0);
    let survived = every(&bugs, |&(manual, bug)| {
        let mut open = OpenEffects::of(manual, bug);
        pairs.fetch_add(open.len(), Ordering::Relaxed);
        open.run_all();
        let survivors = open.survivors();
        (!survivors.is_empty()).then(|| survivors.join("\n"))
    });
    let pairs = pairs.into_inner();
    assert!(pairs >= 60, "only {pairs} pairs");
    assert!(survived.is_empty(), "{} of {pairs} pairs:\n{}", survived.join("\n").lines().count(), survived.join("\n"));
}

/// The effects of a bug that no trial has shown yet.
struct OpenEffects<'a> {
    manual: &'a Manual,
    bug: &'a Bug,
    /// The trials, each a row of a case, that list the bug under `catches` and have not failed.
    trials: BTreeSet<&'a str>,
    /// The rules that list the bug under `catches` and have not been broken.
    rules: BTreeSet<&'a str>,
    /// The requirements that the bug breaks and that have not failed.
    breaks: BTreeSet<usize>,
    /// The trials that ran, with their results.
    ran: BTreeMap<(&'a str, &'a str), BugTrialResult>,
}

/// The result of a trial, as a whole and for each requirement that it covers.
struct BugTrialResult {
    verdict: Verdict,
    reason: String,
    covers: Vec<(usize, Verdict)>,
}

impl<'a> OpenEffects<'a> {
    fn of(manual: &'a Manual, bug: &'a Bug) -> OpenEffects<'a> {
        let catches = |catches: &[String]| catches.contains(&bug.name);
        let trials = manual.variants.iter().flat_map(|variant| &variant.trials);
        let rules = manual.variants.iter().flat_map(|variant| &variant.rules);
        OpenEffects {
            manual,
            bug,
            trials: trials.filter(|of| catches(&of.catches)).map(|of| of.id.as_str()).collect(),
            rules: rules.filter(|of| catches(&of.catches)).map(|of| of.id.as_str()).collect(),
            breaks: bug.breaks.iter().copied().collect(),
            ran: BTreeMap::new(),
        }
    }

    fn len(&self) -> usize {
        self.trials.len() + self.rules.len() + self.breaks.len()
    }

    fn run_all(&mut self) {
        let catching = |open: &OpenEffects, _: &SuiteVariant, trial: &Trial| {
            open.trials.contains(trial.id.as_str()) && trial.catches.contains(&open.bug.name)
        };
        let covering = |open: &OpenEffects, _: &SuiteVariant, trial: &Trial| {
            let checks = check_covers(trial);
            trial.covers.iter().chain(&checks).any(|of| open.breaks.contains(of))
        };
        let ruling = |open: &OpenEffects, variant: &SuiteVariant, _: &Trial| {
            let is_open = |rule: &SuiteRule| open.rules.contains(rule.id.as_str()) || open.is_broken(&rule.covers);
            variant.rules.iter().any(is_open)
        };
        self.run_those(catching);
        self.run_those(covering);
        self.run_those(ruling);
    }

    fn is_broken(&self, covers: &[usize]) -> bool {
        covers.iter().any(|of| self.breaks.contains(of))
    }

    /// Runs the trials that may show an open effect.
    fn run_those(&mut self, may_show: impl Fn(&OpenEffects, &SuiteVariant, &Trial) -> bool) {
        let manual = self.manual;
        for variant in &manual.variants {
            for trial in &variant.trials {
                let has_run = self.ran.contains_key(&(variant.name.as_str(), trial.id.as_str()));
                if !has_run && manual.is_own(trial) && may_show(self, variant, trial) {
                    self.run(variant, trial);
                }
            }
        }
    }

    fn run(&mut self, variant: &'a SuiteVariant, trial: &'a Trial) {
        let dut = built_in::model(self.manual, variant, &[&self.bug.name]);
        let outcome = run_trial(self.manual, variant, &dut, trial, &RunOptions::default());
        let outcome = match outcome {
            Ok(outcome) => outcome,
            Err(error) => {
                let ran = BugTrialResult { verdict: Verdict::Error, reason: error.to_string(), covers: Vec::new() };
                self.ran.insert((&variant.name, &trial.id), ran);
                return;
            }
        };
        let case = outcome.case;
        if case.verdict == Verdict::Fail {
            self.trials.remove(trial.id.as_str());
        }
        let covers: Vec<(usize, Verdict)> = case.covers.iter().map(|of| (of.requirement, of.verdict)).collect();
        for (requirement, _) in covers.iter().filter(|(_, verdict)| *verdict == Verdict::Fail) {
            self.breaks.remove(requirement);
        }
        for (rule, _) in variant.rules.iter().zip(&outcome.rules).filter(|(_, outcome)| outcome.broken.is_some()) {
            self.rules.remove(rule.id.as_str());
            rule.covers.iter().for_each(|requirement| {
                self.breaks.remove(requirement);
            });
        }
        let ran = BugTrialResult { verdict: case.verdict, reason: case.reason.unwrap_or_default(), covers };
        self.ran.insert((&variant.name, &trial.id), ran);
    }

    /// One line for each effect that is still open, with the results of the trials.
    fn survivors(&self) -> Vec<String> {
        let name = &self.bug.name;
        let results = |select: &dyn Fn(&str, &BugTrialResult) -> Option<Verdict>| {
            let mut results: Vec<String> = self
                .ran
                .iter()
                .filter_map(|((variant, trial), ran)| {
                    let verdict = select(trial, ran)?;
                    Some(format!("{variant} {trial} {verdict} {}", ran.reason).trim_end().to_owned())
                })
                .collect();
            let all = results.len();
            results.truncate(LISTED);
            let more = if all > LISTED { format!("; and {} more", all - LISTED) } else { String::new() };
            if results.is_empty() { "nothing covers it".to_owned() } else { results.join("; ") + &more }
        };
        let trials = self.trials.iter().map(|id| {
            let results = results(&|trial, ran| (trial == *id).then_some(ran.verdict));
            format!("{name}: {id} does not fail: {results}")
        });
        let rules = self.rules.iter().map(|rule| format!("{name}: the rule {rule} is not broken"));
        let breaks = self.breaks.iter().map(|&requirement| {
            let results =
                results(&|_, ran| ran.covers.iter().find(|(of, _)| *of == requirement).map(|(_, verdict)| *verdict));
            format!("{name}: {} does not fail: {results}", self.manual.requirements[requirement].id)
        });
        trials.chain(rules).chain(breaks).collect()
    }
}

/// The number of trials that are listed for one open effect.
const LISTED: usize = 4;
