//! Which requirement fails: that of the step that failed, of the name that was wrong, or of the whole case. Each case here runs against
//! the conforming reference device and expects something wrong of it.

use encspec::engine::{DutKind, DutSpec, RunOptions, TrialOutcome, run_trial};
use encspec::suite_yaml::load;
use encspec::verdict::Verdict::{self, Fail, Inconclusive, NotRun, Pass};
use rstest::rstest;

const MANUAL: &str = "lika-xac77-profinet";
const RIGHT: &str = "expect: { G1_ZSW: 0 }\n        for: 10ms\n";
const WRONG: &str = "expect: { G1_ZSW.parked: 1 }\n        for: 10ms\n";
const ABOUT_FIRST: &str = "        about: [XAC77-PRK-001]\n";
const ABOUT_SECOND: &str = "        about: [XAC77-PRK-002]\n";
const ABOUT_OTHER: &str = "        about: [XAC77-PRE-010]\n";

/// Runs a case that covers two requirements, with these steps before the test and in it.
fn run(given: &[String], steps: &[String]) -> TrialOutcome {
    let lines = |list: &[String]| list.iter().map(|step| format!("      - {step}")).collect::<String>();
    let given = if given.is_empty() { String::new() } else { format!("    given:\n{}", lines(given)) };
    let topic = format!(
        "suite: tried\ndefaults: {{ start: {{ module: telegram_81 }} }}\ncases:\n  - id: tried\n    why: Tries a meaning.\n    \
         covers: [XAC77-PRK-001, XAC77-PRK-002]\n{given}    steps:\n{}",
        lines(steps)
    );
    let sources = suites::sources().with(&format!("{MANUAL}/tried.yaml"), topic);
    let manuals = load(&sources, Some(MANUAL)).unwrap_or_else(|errors| panic!("the suite loads:\n{errors}"));
    let (manual, variant) = (&manuals[0], &manuals[0].variants[0]);
    let trial = variant.trials.iter().find(|trial| trial.id.ends_with("tried/tried")).expect("the trial is there");
    let kind = DutKind::Model { deviations: Vec::new() };
    let dut = DutSpec { manual: manual.device.name.clone(), variant: variant.name.clone(), kind };
    run_trial(manual, variant, &dut, trial, &RunOptions::default()).expect("a model can be run")
}

fn verdicts(outcome: &TrialOutcome) -> Vec<(&str, Verdict)> {
    let mut list: Vec<(&str, Verdict)> =
        outcome.case.covers.iter().map(|of| (of.id.trim_start_matches("XAC77-"), of.verdict)).collect();
    list.sort_unstable();
    list
}

#[rstest]
#[case::a_step_without_more_fails_what_the_case_covers(&[WRONG], &[("PRK-001", Fail), ("PRK-002", Fail)])]
#[case::a_step_about_another_requirement_fails_that(
    &[WRONG, ABOUT_OTHER], &[("PRE-010", Fail), ("PRK-001", NotRun), ("PRK-002", NotRun)])]
#[case::a_passed_step_judges_what_it_is_about(&[RIGHT, ABOUT_FIRST, WRONG], &[("PRK-001", Pass), ("PRK-002", Fail)])]
#[case::the_step_that_failed_decides(
    &[RIGHT, ABOUT_FIRST, WRONG, ABOUT_SECOND], &[("PRK-001", Pass), ("PRK-002", Fail)])]
#[case::what_was_not_reached_was_not_judged(
    &[WRONG, ABOUT_FIRST, RIGHT, ABOUT_SECOND], &[("PRK-001", Fail), ("PRK-002", NotRun)])]
#[case::a_failed_case_always_fails_a_requirement(
    &[RIGHT, ABOUT_FIRST, RIGHT, ABOUT_SECOND, WRONG], &[("PRK-001", Fail), ("PRK-002", Fail)])]
fn a_failed_step(#[case] parts: &[&str], #[case] expected: &[(&str, Verdict)]) {
    let outcome = run(&[], &steps(parts));
    assert_eq!(outcome.case.verdict, Fail, "{:?}", outcome.case.reason);
    assert_eq!(verdicts(&outcome), expected);
}

/// Steps and what they are about, joined.
fn steps(parts: &[&str]) -> Vec<String> {
    let mut list: Vec<String> = Vec::new();
    for part in parts {
        match list.last_mut().filter(|_| part.trim_start().starts_with("about")) {
            Some(last) => last.push_str(part),
            None => list.push((*part).to_owned()),
        }
    }
    list
}

#[test]
fn before_the_test_a_step_judges_the_device_only_if_it_says_what_it_is_about() {
    let outcome = run(&steps(&[WRONG]), &steps(&[RIGHT]));
    assert_eq!(outcome.case.verdict, Inconclusive);
    assert_eq!(verdicts(&outcome), [("PRK-001", Inconclusive), ("PRK-002", Inconclusive)]);
    let failure = &outcome.case.failures[0];
    assert!(failure.before_test && failure.place.is_some());
    let begin =
        "Before the test, in `given`, step `expect: { G1_ZSW.parked: 1 }, for: 10ms`: It did not become true within ";
    assert!(failure.what.starts_with(begin), "{}", failure.what);
    assert!(failure.what.ends_with(". G1_ZSW.parked: 1: expected 1, observed 0."), "{}", failure.what);
    let outcome = run(&steps(&[WRONG, ABOUT_OTHER]), &steps(&[RIGHT]));
    assert_eq!(outcome.case.verdict, Fail);
    assert_eq!(verdicts(&outcome), [("PRE-010", Fail), ("PRK-001", NotRun), ("PRK-002", NotRun)]);
    let lost = ["set: { link: down }\n", "wait: 2s\n", RIGHT, ABOUT_OTHER];
    let outcome = run(&steps(&lost), &steps(&[RIGHT]));
    assert_eq!(outcome.case.verdict, Inconclusive, "{:?}", outcome.case.reason);
}

#[test]
fn each_name_of_a_check_fails_its_own_requirement() {
    let read = "read: { P922: 81, P964.manufacturer: 1, P65000: 0 }\n        \
                covers: { P922: [XAC77-PAR-001], P964.manufacturer: [XAC77-PAR-003] }\n";
    let outcome = run(&[], &[read.to_owned(), RIGHT.to_owned()]);
    assert_eq!(outcome.case.verdict, Fail);
    assert_eq!(
        verdicts(&outcome),
        [("PAR-001", Pass), ("PAR-003", Fail), ("PRK-001", Pass), ("PRK-002", Pass)],
        "P65000 is right, so that the case goes on"
    );
    assert_eq!(outcome.case.failures.len(), 1);
    assert_eq!(outcome.case.failures[0].parts.len(), 1);
    let outcome = run(&[], &[read.replace("P65000: 0", "P65000: 7"), RIGHT.to_owned()]);
    assert_eq!(
        verdicts(&outcome),
        [("PAR-001", Pass), ("PAR-003", Fail), ("PRK-001", Fail), ("PRK-002", Fail)],
        "a name without requirements counts for the case"
    );
}
