//! History functions.

use super::{HistoryState, ObservedValues, Program, Value, condition};
use rstest::rstest;

const T: Option<bool> = Some(true);
const F: Option<bool> = Some(false);
const U: Option<bool> = None;

/// Runs a condition over observations: first evaluated, then advanced.
fn run(text: &str, trace: impl IntoIterator<Item = ObservedValues>) -> Vec<Option<bool>> {
    let program = condition(text).unwrap_or_else(|error| panic!("{text}: {error}"));
    let mut state = HistoryState::default();
    trace.into_iter().map(|observed| step(&program, &observed, &mut state)).collect()
}

fn step(program: &Program, observed: &ObservedValues, state: &mut HistoryState) -> Option<bool> {
    let truth = program.truth(observed, state);
    assert_eq!(truth, program.truth(observed, state), "evaluating twice changes nothing");
    state.advance(program, observed);
    truth
}

fn bits(bits: &str) -> Vec<ObservedValues> {
    let observed = |bit| match bit {
        '0' | '1' => ObservedValues::now(&[("a", Value::Bit(bit == '1'))]),
        _ => ObservedValues::now(&[]),
    };
    bits.chars().map(observed).collect()
}

/// A sample of the sign of life; `None`: an observation in which it is unknown.
fn life(number: Option<i64>) -> ObservedValues {
    number.map_or_else(
        || ObservedValues::now(&[]),
        |number| ObservedValues::now(&[("ZSW2_ENC.sign_of_life", Value::whole(number))]),
    )
}

#[rstest]
#[case("rises(a)", "0110100", &[F, T, F, F, T, F, F])]
#[case("falls(a)", "0110100", &[U, F, F, T, F, T, F])]
#[case("rises(a)", "1?101", &[U, F, U, F, T])]
#[case("falls(a)", "1?001", &[F, U, U, F, F])]
#[case("rises(a)", "?01", &[U, F, T])]
#[case("not rises(a)", "01", &[T, F])]
#[case("rises(not a)", "110", &[F, F, T])]
#[case("changes(a)", "0110?00", &[U, T, F, T, U, U, F])]
#[case("prev(a)", "0110?01", &[U, F, T, T, U, U, F])]
#[case("rises(a) or a", "111", &[T, T, T])]
fn the_previous_frame_must_be_known(#[case] text: &str, #[case] trace: &str, #[case] expected: &[Option<bool>]) {
    assert_eq!(run(text, bits(trace)), expected);
}

#[test]
fn at_the_first_frame_only_false_is_known() {
    assert_eq!(run("rises(a)", bits("0")), [F]);
    assert_eq!(run("rises(a)", bits("1")), [U]);
    assert_eq!(run("falls(a)", bits("1")), [F]);
    assert_eq!(run("falls(a)", bits("0")), [U]);
}

#[test]
fn prev_stays_between_two_images_and_changes_is_true_once() {
    let trace =
        || [life(Some(4)), life(Some(5)), life(Some(5)).stale(), life(Some(5)).stale(), life(Some(6)), life(Some(6))];
    assert_eq!(run("prev(ZSW2_ENC.sign_of_life) == 4", trace()), [U, T, T, T, F, F]);
    assert_eq!(run("prev(ZSW2_ENC.sign_of_life) == 5", trace()), [U, F, F, F, T, F]);
    assert_eq!(run("changes(ZSW2_ENC.sign_of_life)", trace()), [U, T, F, F, T, F]);
    assert_eq!(run("(ZSW2_ENC.sign_of_life - prev(ZSW2_ENC.sign_of_life)) mod 15 == 1", trace()), [U, T, T, T, T, F]);
}

#[test]
fn a_value_known_before_the_first_fresh_frame_is_the_previous_value() {
    let trace = || [life(Some(4)).stale(), life(Some(5))];
    assert_eq!(run("changes(ZSW2_ENC.sign_of_life)", trace()), [U, T]);
    assert_eq!(run("prev(ZSW2_ENC.sign_of_life) == 4", trace()), [U, T]);
}

#[test]
fn the_sign_of_life_counts_one_to_fifteen() {
    let when = "changes(ZSW2_ENC.sign_of_life) and prev(ZSW2_ENC.sign_of_life) != 0";
    let then = "ZSW2_ENC.sign_of_life == prev(ZSW2_ENC.sign_of_life) mod 15 + 1";
    let trace = || [0, 1, 14, 15, 1, 0].map(|number| life(Some(number)));
    assert_eq!(run(when, trace()), [U, F, T, T, T, T]);
    assert_eq!(run(then, trace()), [U, T, F, T, T, F]);
}

#[test]
fn a_gap_leaves_no_last_value() {
    let trace = || [life(Some(4)), life(None), life(Some(6)), life(Some(7))];
    assert_eq!(run("changes(ZSW2_ENC.sign_of_life)", trace()), [U, U, U, T]);
    assert_eq!(run("prev(ZSW2_ENC.sign_of_life) == 6", trace()), [U, U, U, T]);
}

#[test]
fn since_measures_from_the_last_earlier_time() {
    let trace = |bits_at: &[(char, u64)]| -> Vec<ObservedValues> {
        bits_at
            .iter()
            .flat_map(|&(bit, at)| bits(&bit.to_string()).into_iter().map(move |observed| observed.at(at)))
            .collect()
    };
    let observed = [('0', 10), ('1', 20), ('0', 30), ('1', 50), ('1', 60)];
    assert_eq!(run("since(a) == 10ns", trace(&observed)), [U, U, T, F, T]);
    assert_eq!(run("since(a) == 30ns", trace(&observed)), [U, U, F, T, F]);
    // After an unknown value the time of the last `true` is uncertain.
    let gap = [('1', 10), ('?', 20), ('0', 30), ('1', 40), ('0', 50)];
    assert_eq!(run("since(a) == 10ns", trace(&gap)), [U, T, U, U, T]);
    // What was false throughout was last true before that.
    let never = [('0', 10), ('0', 20), ('0', 30), ('?', 40), ('0', 50), ('0', 60), ('1', 70)];
    assert_eq!(run("since(a) <= 20ns", trace(&never)), [U, U, F, F, U, U, F]);
    assert_eq!(run("20ns <= since(a)", trace(&never)), [U, U, T, T, U, U, T]);
    assert_eq!(run("since(a) == 20ns", trace(&never)), [U; 7]);
}

#[test]
fn history_functions_can_be_nested() {
    let stamp = |number: i64, at: u64| ObservedValues::now(&[("time_stamp", Value::whole(number))]).at(at);
    let second = 1_000_000_000;
    let trace =
        [stamp(7, 0), stamp(8, second), stamp(8, second + 5), stamp(9, 2 * second), stamp(10, 2 * second + second / 2)];
    let text = "since(changes(time_stamp)) == 1s +/- 2%";
    assert_eq!(run(text, trace), [U, U, F, T, F]);
    let rule = "time_stamp == (prev(time_stamp) + 1) mod 65536 and since(changes(time_stamp)) == 1s +/- 2%";
    let trace = [stamp(65534, 0), stamp(65535, second), stamp(0, 2 * second)];
    assert_eq!(run(rule, trace), [U, U, T]);
    assert_eq!(run("rises(changes(a))", bits("00110")), [U, F, T, F, T]);
}

#[test]
fn noise_of_a_position_at_rest_is_not_a_change() {
    let at = |at: i64| ObservedValues::now(&[("position", Value::place(at, Some(8000)))]).noise(1);
    assert_eq!(run("changes(position)", [at(0), at(7999), at(1), at(1)]), [U, F, T, F]);
}

#[test]
fn forget_clears_the_state() {
    let program = condition("changes(a) and since(a) < 1s").expect("a condition");
    let mut state = HistoryState::default();
    let trace = bits("010");
    for observed in &trace {
        state.advance(&program, observed);
    }
    assert!(program.truth(&trace[1], &state).is_some());
    state.forget();
    assert_eq!(program.truth(&trace[1], &state), U);
}

#[test]
fn a_state_of_another_program_is_replaced_not_trusted() {
    let (one, other) = (condition("rises(a)").expect("one"), condition("changes(a) and prev(a)").expect("other"));
    let mut state = HistoryState::default();
    state.advance(&one, &bits("1")[0]);
    state.advance(&other, &bits("1")[0]);
    assert_eq!(other.truth(&bits("0")[0], &state), T);
}
