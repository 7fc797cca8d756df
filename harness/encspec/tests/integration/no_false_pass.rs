//! Regression tests for false passes: small suites that a faulty device, or no device, could once pass, run against the reference
//! device with a bug.

use encspec::engine::{DutKind, DutSpec, RunOptions, run};
use encspec::result::CaseResult;
use encspec::suite::model::Manual;
use encspec::suite_yaml::load;
use encspec::verdict::Verdict;
use rstest::rstest;

const DEVICE: &str = "lika-xac77-profinet";

fn suite(cases: &str) -> Result<Vec<Manual>, String> {
    let text = format!("suite: tried\ndefaults: {{ start: {{ module: telegram_81 }} }}\ncases:\n{cases}");
    let sources = suites::sources().with(&format!("{DEVICE}/tried.yaml"), text);
    load(&sources, Some(DEVICE)).map_err(|errors| errors.to_string())
}

/// Runs a case with these steps against the reference device, with a bug unless `bug` is empty.
fn tried(steps: &str, bug: &str) -> CaseResult {
    let case = format!(
        "  - id: it\n    why: It is tried.\n    covers: [XAC77-PRE-002]\n    catches: [preset-adds-instead-of-assigns]\n{steps}"
    );
    let manuals = suite(&case).unwrap_or_else(|errors| panic!("{errors}"));
    let results = results(&manuals, "tried/it", bug);
    results.into_iter().find(|case| case.id.ends_with("tried/it")).expect("the case")
}

fn results(manuals: &[Manual], filter: &str, bug: &str) -> Vec<CaseResult> {
    let bugs = if bug.is_empty() { Vec::new() } else { vec![bug.to_owned()] };
    let dut =
        DutSpec { manual: DEVICE.to_owned(), variant: "xac7718".to_owned(), kind: DutKind::Model { deviations: bugs } };
    let options = RunOptions { duts: vec![dut], selection: filter.into(), threads: 1, ..RunOptions::default() };
    let result = run(manuals, &options, &|_, _, _| {}).expect("a model can be run");
    result.runs.into_iter().flat_map(|run| run.cases).collect()
}

#[rstest]
#[case::an_answer_with_another_reference_is_no_refusal(
    "    steps:\n      - write: { P65000: 5 }\n      - write: { P65000: 6 }\n        answer: { refused: any }\n",
    "reference-always-one"
)]
#[case::nor_any_other_answer(
    "    steps:\n      - write: { P65000: 5 }\n      - write: { P65000: 6 }\n        answer: any\n",
    "reference-always-one"
)]
#[case::a_refused_connect_says_nothing_of_modules(
    "    start: none\n    steps:\n      - connect: { module: telegram_81, instead: { output_length: 6 } }\n        answer: { module_diff.telegram_81: proper }\n      - connect: { module: telegram_81 }\n      - expect: { io.input_status: good }\n",
    ""
)]
fn an_invalid_answer_is_no_answer(#[case] steps: &str, #[case] bug: &str) {
    assert_eq!(tried(steps, bug).verdict, Verdict::Fail);
}

#[rstest]
#[case::no_answer_to_lldp("      - send: { lldp: { chassis: 'a', port: 'b' } }\n")]
#[case::no_answer_to_an_abort("      - send: { abort: {} }\n")]
fn a_service_without_an_answer_is_no_check(#[case] steps: &str) {
    let case = format!(
        "  - id: it\n    why: It is tried.\n    covers: [XAC77-PRE-002]\n    catches: [preset-adds-instead-of-assigns]\n    steps:\n{steps}"
    );
    let errors = suite(&case).map(|_| ()).expect_err("a case without a check is a load error");
    assert!(errors.contains("tried.yaml"), "{errors}");
}

/// An expectation that already held before is idle, whatever else it names.
#[test]
fn one_more_name_does_not_excuse_an_idle_expectation() {
    let steps = "    steps:\n      - set: { G1_STW.acknowledge_error: 1 }\n      - expect: { G1_ZSW.sensor_error: 0, connection: data }\n";
    let result = tried(steps, "");
    assert_eq!(result.verdict, Verdict::Error, "{:?}", result.reason);
}

/// A rule that a selected case breaks is reported even if the filter does not match the rule.
#[test]
fn a_filter_does_not_hide_a_broken_rule() {
    let manuals = load(&suites::sources(), Some(DEVICE)).unwrap_or_else(|errors| panic!("{errors}"));
    let results = results(&manuals, "position/one-step", "xist2-one-frame-late");
    let broken = results.iter().any(|case| case.id.contains("/rules/") && case.verdict == Verdict::Fail);
    assert!(broken, "{:?}", results.iter().map(|case| (&case.id, case.verdict)).collect::<Vec<_>>());
}

/// A failure in `given` says nothing about the device, with `covers` or without.
#[test]
fn a_check_in_given_is_never_a_failure() {
    let steps = "    given:\n      - expect: { G1_ZSW.parked: 1 }\n        covers: [XAC77-PRK-002]\n    steps:\n      - set: { STW2_ENC.control_by_plc: 1, G1_STW.park: 1 }\n      - expect: { G1_ZSW.parked: 1 }\n";
    assert_eq!(tried(steps, "").verdict, Verdict::Inconclusive);
}

/// A reading that fails does not consume the event that it expected.
#[test]
fn a_reading_that_fails_consumes_no_event() {
    let steps = "    start: { alarm_channel: enabled }\n    given:\n      - set: { STW2_ENC.control_by_plc: 1 }\n    steps:\n      - set: { fault.memory: present }\n      - either:\n          parks_too:\n            - expect: { alarm.change: appears }\n              within: 1s\n            - expect: { G1_ZSW.parked: 1 }\n          only_tells:\n            - expect: { alarm.change: appears }\n              within: 1s\n      - expect: { G1_ZSW.sensor_error: 1 }\n        for: 20ms\n";
    let result = tried(steps, "");
    assert_eq!(result.verdict, Verdict::Pass, "{:?}", result.reason);
    assert_eq!(result.readings.len(), 1);
}
