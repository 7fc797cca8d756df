//! What observations, rules and expectations mean where it is easy to be wrong: at the borders of a block, over what is
//! unknown, and for events. Each small suite here runs against the reference device without a bug.

use encspec::engine::{DutKind, DutSpec, RunOptions, TrialOutcome, run_trial};
use encspec::suite::{Sources, load};
use encspec::verdict::Verdict::{self, Fail, Inconclusive, Pass};
use rstest::rstest;

const MANUAL: &str = "lika-xac77-profinet";

/// Runs the case `tried` of a topic file with these keys of the case, and with these rules.
fn tried(case: &str, rules: &str) -> TrialOutcome {
    let topic = format!(
        "suite: tried\ndefaults: {{ start: {{ module: telegram_81 }} }}\ncases:\n  - id: tried\n    why: Tries a meaning.\n    \
         covers: [XAC77-PRK-001]\n{case}{rules}"
    );
    let sources = Sources::embedded().with(&format!("{MANUAL}/tried.yaml"), topic);
    let manuals = load(&sources, Some(MANUAL)).unwrap_or_else(|errors| panic!("the suite loads:\n{errors}"));
    let (manual, variant) = (&manuals[0], &manuals[0].variants[0]);
    let trial = variant.trials.iter().find(|trial| trial.id.ends_with("tried/tried")).expect("the trial is there");
    let kind = DutKind::Model { bugs: Vec::new() };
    let dut = DutSpec { manual: manual.device.name.clone(), variant: variant.name.clone(), kind };
    run_trial(manual, variant, &dut, trial, &RunOptions::default()).expect("a model can be run")
}

/// A case that is one block: its observations, and its steps.
fn block(observe: &[&str], steps: &[&str]) -> TrialOutcome {
    let lines = |list: &[&str]| list.iter().map(|line| format!("          - {line}\n")).collect::<String>();
    let given = "    given:\n      - do: preset\n        give: { preset_value: 0x1234 }\n";
    let alive = "      - read: { station.vendor_id: 0x0239 }\n";
    let (observe, steps) = (lines(observe), lines(steps));
    tried(&format!("{given}    steps:\n{alive}      - observe:\n{observe}        steps:\n{steps}"), "")
}

const PARK: &str = "set: { G1_STW.park: 1 }";
const CONNECT: &str = "connect: {}";
const PARKED: &str = "{ when: rises(G1_STW.park), then: G1_ZSW.parked, within: 100ms, for: 1s }";
const ALARM: &str = "set: { fault.memory: present }";

#[rstest]
#[case::a_change_in_the_first_frame(&["{ count: rises(G1_STW.park), is: 1 }"], &[PARK], Pass)]
#[case::a_premise_in_the_first_frame(&[PARKED], &[PARK], Pass)]
#[case::frames_after_the_last_step_are_not_counted(
    &[PARKED, "{ count: changes(ZSW2_ENC.sign_of_life), is: { to: 20 } }"], &[PARK, "wait: 10 cycles"], Pass)]
#[case::places_are_compared_as_places(
    &["{ sequence: [G1_STW.park, G1_XIST1], is: [[0, 0x1234], [1, 0x1234], [1, 0]] }"], &["wait: 10 cycles", PARK, "wait: 10 cycles"], Pass)]
#[case::other_places_are_not(
    &["{ sequence: [G1_STW.park, G1_XIST1], is: [[0, 0x1235], [1, 0x1235], [1, 0]] }"], &["wait: 10 cycles", PARK, "wait: 10 cycles"], Fail)]
#[case::a_number_that_is_not_certain(&["{ count: G1_ZSW.sensor_error, is: 0 }"], &[CONNECT], Inconclusive)]
#[case::a_number_that_is_right_anyway(&["{ count: G1_ZSW.sensor_error, is: { from: 0 } }"], &[CONNECT], Pass)]
#[case::a_number_that_is_wrong_anyway(
    &["{ count: not G1_ZSW.sensor_error, is: 3 }"], &["wait: 10 cycles", CONNECT], Fail)]
#[case::an_order_with_a_gap(&["{ sequence: [G1_ZSW.parked], is: [[0], [1]] }"], &[CONNECT], Inconclusive)]
#[case::an_order_that_is_wrong_before_the_gap(&["{ sequence: [G1_ZSW.parked], is: [[1], [0]] }"], &[CONNECT], Fail)]
#[case::what_is_broken_comes_before_what_is_not_certain(
    &["{ count: G1_ZSW.sensor_error, is: 0 }", "always: G1_ZSW.parked"], &[CONNECT], Fail)]
#[case::a_count_of_aborts_expects_no_alarm(&["{ count: abort, is: 0 }"], &[ALARM, "wait: 200ms"], Fail)]
#[case::a_count_of_alarms_does(&["{ count: alarm, is: 1 }"], &[ALARM, "wait: 200ms"], Pass)]
#[case::a_rule_about_alarms_does(
    &["{ when: alarm, then: alarm.error == memory, within: 0 }"], &[ALARM, "wait: 200ms"], Pass)]
#[case::a_rule_that_wants_an_alarm_does(
    &["{ when: rises(G1_STW.request_absolute_value), then: alarm, within: 1s }"], &["set: { G1_STW.request_absolute_value: 1 }", ALARM, "wait: 200ms"], Pass)]
fn a_block(#[case] observe: &[&str], #[case] steps: &[&str], #[case] verdict: Verdict) {
    let outcome = block(observe, steps);
    assert_eq!(outcome.case.verdict, verdict, "{:?}", outcome.case.reason);
}

#[test]
fn nothing_is_counted_where_nothing_was_seen() {
    let outcome = tried(
        "    start: none\n    steps:\n      - observe: [ { count: G1_ZSW.sensor_error, is: 0 } ]\n        steps:\n          \
         - read: { station.vendor_id: 0x0239 }\n",
        "",
    );
    assert_eq!(outcome.case.verdict, Inconclusive, "{:?}", outcome.case.reason);
}

#[test]
fn a_deadline_in_cycles_without_a_connection_is_not_the_next_sample() {
    let outcome = tried(
        "    start: none\n    steps:\n      - read: { station.vendor_id: 0x0239 }\n      - expect: { connection: none }\n        \
         within: 5 cycles\n",
        "",
    );
    assert_eq!(outcome.case.verdict, Fail, "{:?}", outcome.case.reason);
}

#[test]
fn a_premise_that_stays_true_is_counted_at_every_frame_and_costs_no_more() {
    let rules = "rules:\n  - id: level\n    why: A premise that stays true.\n    covers: [XAC77-PRK-001]\n    \
                 when: not G1_ZSW.parked\n    then: not G1_ZSW.parked\n    within: 0\n    until: G1_ZSW.parked\n";
    let case = "    given:\n      - set: { STW2_ENC.control_by_plc: 1 }\n    steps:\n      - wait: 60s\n      - set: { G1_STW.park: 1 }\n      - expect: { G1_ZSW.parked: 1 }\n";
    let began = std::time::Instant::now();
    let outcome = tried(case, rules);
    assert_eq!(outcome.case.verdict, Pass, "{:?}", outcome.case.reason);
    let decided = outcome.rules.iter().map(|rule| rule.decided).max_by_key(|decided| decided.premises);
    let decided = decided.expect("there are rules");
    assert!((59_000..61_500).contains(&decided.premises), "{decided:?}: one for each frame of a minute at 2 ms");
    assert!(began.elapsed() < std::time::Duration::from_secs(20), "it took {:?}", began.elapsed());
}
