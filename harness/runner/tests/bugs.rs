//! Every case can fail: each case and each rule is run with each bug that it says it catches.

use encspec::engine::{DutKind, DutSpec, RunOptions, run, run_trial};
use encspec::suite::model::{Manual, Variant};
use encspec::suite::{Sources, load};
use encspec::verdict::Verdict;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

fn manuals() -> Vec<Manual> {
    load(&Sources::embedded(), None).unwrap_or_else(|errors| panic!("the shipped suites load:\n{errors}"))
}

fn dut(manual: &Manual, variant: &Variant, bug: &str) -> DutSpec {
    let (manual, variant) = (manual.device.name.clone(), variant.name.clone());
    DutSpec { manual, variant, kind: DutKind::Model { bugs: vec![bug.to_owned()] } }
}

/// Does `work` for every item on two threads and gives what it found, sorted.
fn every<T: Sync>(items: &[T], work: impl Fn(&T) -> Option<String> + Sync) -> Vec<String> {
    let (next, found) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                while let Some(item) = items.get(next.fetch_add(1, Ordering::Relaxed)) {
                    if let Some(text) = work(item) {
                        found.lock().expect("no thread panicked").push(text);
                    }
                }
            });
        }
    });
    let mut found = found.into_inner().expect("no thread panicked");
    found.sort();
    found
}

/// The id of a trial without its row.
fn case_of(trial: &str) -> &str {
    trial.split('[').next().unwrap_or(trial)
}

#[test]
fn both_tellings_list_the_same_bugs() {
    for manual in manuals() {
        let offered = reference_devices::manual(&manual.device.name).expect("a reference device for every suite");
        let offered: BTreeSet<&str> = offered.bugs().map(|bug| bug.name).collect();
        let listed: BTreeSet<&str> = manual.bugs.iter().map(|bug| bug.name.as_str()).collect();
        assert_eq!(listed, offered, "bugs.yaml and the reference device of {}", manual.device.name);
        assert!(listed.len() >= 25);
    }
}

#[test]
fn every_case_catches_a_bug_and_every_bug_is_caught() {
    for manual in manuals() {
        let variants = || manual.variants.iter();
        let blind: BTreeSet<&str> = variants()
            .flat_map(|variant| &variant.trials)
            .filter(|trial| trial.catches.is_empty())
            .map(|trial| case_of(&trial.id))
            .collect();
        assert!(blind.is_empty(), "no bug shows that these cases can fail: {blind:?}");
        let rules: BTreeMap<&str, bool> = variants()
            .flat_map(|variant| &variant.rules)
            .map(|rule| (rule.id.as_str(), rule.catches.is_empty()))
            .collect();
        assert!(rules.values().all(|is_blind| !is_blind), "no bug shows that each of these rules can fail: {rules:?}");
        let by_cases = variants().flat_map(|variant| &variant.trials).flat_map(|trial| &trial.catches);
        let by_rules = variants().flat_map(|variant| &variant.rules).flat_map(|rule| &rule.catches);
        let caught: BTreeSet<&str> = by_cases.chain(by_rules).map(String::as_str).collect();
        let free: Vec<&str> =
            manual.bugs.iter().map(|bug| bug.name.as_str()).filter(|name| !caught.contains(name)).collect();
        assert!(free.is_empty(), "nothing catches {free:?}");
    }
}

#[test]
fn without_a_bug_every_case_passes_and_every_rule_is_decided() {
    let manuals = manuals();
    for manual in &manuals {
        for variant in &manual.variants {
            let name = (manual.device.name.clone(), variant.name.clone());
            let healthy = DutSpec { manual: name.0, variant: name.1, kind: DutKind::Model { bugs: Vec::new() } };
            let options = RunOptions { duts: vec![healthy], ..RunOptions::default() };
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

#[test]
fn each_case_fails_with_each_bug_that_it_catches() {
    let manuals = manuals();
    let mut pairs: Vec<(&Manual, &str, &str)> = Vec::new();
    for manual in &manuals {
        let mut seen = BTreeMap::new();
        for trial in manual.variants.iter().flat_map(|variant| &variant.trials) {
            for bug in &trial.catches {
                seen.entry((case_of(&trial.id), bug.as_str())).or_insert(());
            }
        }
        pairs.extend(seen.into_keys().map(|(case, bug)| (manual, case, bug)));
    }
    assert!(pairs.len() >= 60, "only {} pairs of case and bug", pairs.len());
    let survived = every(&pairs, |&(manual, case, bug)| {
        let mut verdicts = Vec::new();
        for variant in &manual.variants {
            for trial in variant.trials.iter().filter(|trial| case_of(&trial.id) == case) {
                let result = run_trial(manual, variant, &dut(manual, variant, bug), trial, &RunOptions::default());
                let result = result.unwrap_or_else(|error| panic!("{case} with {bug}: {error}")).case;
                if result.verdict == Verdict::Fail {
                    return None;
                }
                verdicts.push(format!("{} {}: {}", variant.name, result.verdict, result.reason.unwrap_or_default()));
            }
        }
        verdicts.dedup();
        Some(format!("{case} does not fail with {bug}: {}", verdicts.join("; ")))
    });
    assert!(survived.is_empty(), "{} of {} pairs:\n{}", survived.len(), pairs.len(), survived.join("\n"));
}

#[test]
fn each_rule_fails_with_each_bug_that_it_catches() {
    let manuals = manuals();
    let mut pairs: Vec<(&Manual, &str, &str)> = Vec::new();
    for manual in &manuals {
        let mut seen = BTreeSet::new();
        for rule in manual.variants.iter().flat_map(|variant| &variant.rules) {
            seen.extend(rule.catches.iter().map(|bug| (rule.id.as_str(), bug.as_str())));
        }
        pairs.extend(seen.into_iter().map(|(rule, bug)| (manual, rule, bug)));
    }
    let survived = every(&pairs, |&(manual, rule, bug)| {
        let fails = manual.variants.iter().any(|variant| {
            let options = RunOptions {
                duts: vec![dut(manual, variant, bug)],
                filter: Some(rule.to_owned()),
                exact: true,
                threads: 1,
                ..RunOptions::default()
            };
            let result = run(std::slice::from_ref(manual), &options, &|_, _, _| {}).expect("a model can be run");
            result.runs.iter().flat_map(|run| &run.cases).any(|case| case.verdict == Verdict::Fail)
        });
        (!fails).then(|| format!("the rule {rule} is not broken by {bug}"))
    });
    assert!(survived.is_empty(), "{} of {} pairs:\n{}", survived.len(), pairs.len(), survived.join("\n"));
}
