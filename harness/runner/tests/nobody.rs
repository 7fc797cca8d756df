//! Devices that are none: whatever answers, or does not, a run against it is never green, lists everything and ends.

use encspec::cli::Suites;
use encspec::cli::run::Request;
use encspec::engine::dut::DEVICE;
use encspec::engine::{DutKind, DutSpec, Nobody, RunOptions, run_trial};
use encspec::report::{self, ExitStatus};
use encspec::result::{CaseKind, RunResult};
use encspec::suite::model::Manual;
use encspec::verdict::Verdict;
use rstest::rstest;
use std::sync::LazyLock;
use std::time::{Duration, Instant};

static MANUALS: LazyLock<Vec<Manual>> = LazyLock::new(|| Suites::default().load().expect("the shipped suites"));

/// The longest that a run against nobody may take, in a build without optimisation on a busy machine.
const PATIENCE: Duration = Duration::from_secs(120);

/// Runs everything against `nobody`, which claims to be each manual in turn.
fn run(nobody: &str) -> Vec<RunResult> {
    let run = |manual: &Manual| {
        let request = Request {
            duts: vec![format!("null:{nobody}")],
            device: Some(manual.device.name.clone()),
            ..Request::default()
        };
        let ready = request.ready(&MANUALS).map_err(|stop| stop.message).expect("a null device");
        ready.run(&MANUALS, &|_, _, _| {}).map_err(|stop| stop.message).expect("a virtual bench")
    };
    let begun = Instant::now();
    let results = MANUALS.iter().map(run).collect();
    assert!(begun.elapsed() < PATIENCE, "{nobody}: the run took {:?}", begun.elapsed());
    results
}

/// The ids of every trial and rule, and those of the report, are the same.
fn is_complete(result: &RunResult) {
    for run in &result.runs {
        let manual = MANUALS.iter().find(|manual| manual.device.name == run.dut.device).expect("a manual");
        let variant = manual.variants.iter().find(|variant| variant.name == run.dut.variant).expect("a variant");
        let trials = variant.trials.iter().map(|of| &of.id).chain(variant.rules.iter().map(|of| &of.id));
        let expected: Vec<String> = trials.map(|id| format!("{}/{id}", run.dut.device)).collect();
        let found: Vec<&String> = run.cases.iter().map(|case| &case.id).collect();
        assert_eq!(found, expected.iter().collect::<Vec<_>>());
        for case in run.cases.iter().filter(|case| case.verdict != Verdict::Pass) {
            assert!(case.reason.as_ref().is_some_and(|reason| !reason.is_empty()), "{} gives no reason", case.id);
        }
    }
}

#[rstest]
#[case::no_device("absent")]
#[case::silent("silent")]
#[case::reflector("reflector")]
#[case::random_octets("babbler")]
#[case::another_identity("wrong-identity")]
#[case::dead_from_the_start("dies-after-0")]
#[case::dead_after_its_name("dies-after-1")]
#[case::dead_before_it_can_be_asked("dies-after-2")]
#[case::dead_when_it_was_found("dies-after-3")]
fn nobody_passes(#[case] nobody: &str) {
    for result in run(nobody) {
        is_complete(&result);
        assert_eq!(report::status(&result), ExitStatus::Red);
        let passes: Vec<&str> = result
            .runs
            .iter()
            .flat_map(|run| &run.cases)
            .filter(|case| case.verdict.colour() == encspec::verdict::Colour::Green)
            .map(|case| case.id.as_str())
            .collect();
        assert_eq!(passes, [""; 0], "{nobody} passed");
    }
}

/// A run against a device that dies is red and complete, whenever it dies.
#[rstest]
#[case("dies-after-5")]
#[case("dies-after-40")]
#[case("dies-after-100")]
fn who_dies_is_never_green(#[case] nobody: &str) {
    for result in run(nobody) {
        is_complete(&result);
        assert_eq!(report::status(&result), ExitStatus::Red);
    }
}

/// A device that dies in the course of a trial does not pass it: not when its very last frame is missing, not when it dies
/// half way, not when it dies soon after the start.
#[test]
fn who_dies_in_a_trial_does_not_pass_it() {
    let mut survivors = Vec::new();
    for manual in MANUALS.iter() {
        let known = reference_devices::manual(&manual.device.name).expect("a reference device for every suite");
        let mac = known.mac(DEVICE.0.0);
        for variant in &manual.variants {
            let kind = |kind| DutSpec { manual: manual.device.name.clone(), variant: variant.name.clone(), kind };
            for trial in &variant.trials {
                let one = |kind: DutSpec| {
                    run_trial(manual, variant, &kind, trial, &RunOptions::default()).expect("a virtual bench")
                };
                let healthy = one(kind(DutKind::Model { bugs: Vec::new() }));
                assert_eq!(healthy.case.verdict, Verdict::Pass, "{} in health", trial.id);
                let sent = healthy.trace.iter().filter(|frame| frame.octets[6..12] == mac).count();
                for frames in [sent - 1, sent - 2, sent * 3 / 4, sent / 2, sent / 4] {
                    let verdict = one(kind(DutKind::Nobody(Nobody::DiesAfter(frames)))).case.verdict;
                    if !matches!(verdict, Verdict::Fail | Verdict::Inconclusive) {
                        survivors.push(format!("{}: {verdict} after {frames} of {sent} frames", trial.id));
                    }
                }
            }
        }
    }
    assert!(survivors.is_empty(), "{}:\n{}", survivors.len(), survivors.join("\n"));
}

/// What nobody does is never a finding about a device.
#[rstest]
#[case("absent")]
#[case("silent")]
#[case("wrong-identity")]
fn nobody_is_not_blamed(#[case] nobody: &str) {
    for result in run(nobody) {
        let failed = result.runs.iter().flat_map(|run| &run.cases).filter(|case| case.verdict == Verdict::Fail);
        assert_eq!(failed.map(|case| case.id.as_str()).collect::<Vec<_>>(), [""; 0]);
    }
}

/// A part of the suite is no way around it, rules alone included.
#[rstest]
#[case("preset/absolute")]
#[case("protocol-connect/")]
#[case("rules/")]
fn a_part_of_the_suite_does_not_pass_either(#[case] filter: &str) {
    let has_it = |manual: &&Manual| {
        let variants = || manual.variants.iter();
        let trials = variants().flat_map(|of| &of.trials).map(|of| &of.id);
        let rules = variants().flat_map(|of| &of.rules).map(|of| &of.id);
        trials.chain(rules).any(|id| id.contains(filter))
    };
    assert!(MANUALS.iter().any(|manual| has_it(&manual)), "no suite has anything like {filter}");
    for nobody in ["absent", "reflector", "babbler"] {
        for manual in MANUALS.iter().filter(has_it) {
            let request = Request {
                duts: vec![format!("null:{nobody}")],
                device: Some(manual.device.name.clone()),
                filter: Some(filter.to_owned()),
                ..Request::default()
            };
            let ready = request.ready(&MANUALS).map_err(|stop| stop.message).expect("a null device");
            let result = ready.run(&MANUALS, &|_, _, _| {}).map_err(|stop| stop.message).expect("a virtual bench");
            let kinds: Vec<CaseKind> = result.runs.iter().flat_map(|run| &run.cases).map(|case| case.kind).collect();
            assert!(!kinds.is_empty(), "something was selected");
            assert_eq!(report::status(&result), ExitStatus::Red, "null:{nobody} {filter}");
        }
    }
}
