//! Positions on a circle.

use super::super::OrderOperator;
use super::super::{equal, order};
use super::{HistoryState, ObservedValues, Value, computed, condition, target, truth};
use rstest::rstest;

const T: Option<bool> = Some(true);
const F: Option<bool> = Some(false);
const U: Option<bool> = None;

fn place(at: i64) -> Value {
    Value::place(at, Some(8000))
}

#[rstest]
#[case("before + 3 * 1000", 7000, place(2000))]
#[case("before + 3 * 4095", 100, place(4385))]
#[case("before - 200", 100, place(7900))]
#[case("500 + before", 7900, place(400))]
#[case("before + 8000000000000", 5, place(5))]
#[case("before + -16000", 5, place(5))]
#[case("before + 1", 8050, Value::Unknown)]
fn a_position_plus_a_number_is_a_position(#[case] text: &str, #[case] before: i64, #[case] expected: Value) {
    assert_eq!(computed(text, &[("before", place(before))]), expected);
}

#[rstest]
#[case(10, 5, Value::whole(5))]
#[case(5, 10, Value::whole(-5))]
#[case(5, 7995, Value::whole(10))]
#[case(7995, 5, Value::whole(-10))]
#[case(4000, 0, Value::whole(4000))]
#[case(0, 4000, Value::whole(4000))]
#[case(4001, 0, Value::whole(-3999))]
#[case(3999, 0, Value::whole(3999))]
#[case(8050, 0, Value::Unknown)]
#[case(0, 8050, Value::Unknown)]
fn two_positions_give_the_shorter_distance(#[case] position: i64, #[case] before: i64, #[case] expected: Value) {
    let observed = [("position", place(position)), ("before", place(before))];
    assert_eq!(computed("position - before", &observed), expected);
}

#[test]
fn a_circle_with_an_odd_number_of_steps_has_no_half() {
    let way = |to: i64, from: i64| {
        computed(
            "position - before",
            &[("position", Value::place(to, Some(7))), ("before", Value::place(from, Some(7)))],
        )
    };
    assert_eq!(way(3, 0), Value::whole(3));
    assert_eq!(way(4, 0), Value::whole(-3));
}

#[rstest]
#[case("position == 50", 8050, F)]
#[case("position == 8050", 8050, T)]
#[case("position == 50", 50, T)]
#[case("position != 50", 8050, T)]
#[case("position == before", 50, T)]
#[case("position == 50 +/- 2", 8050, F)]
#[case("position == 8050 +/- 2", 8050, F)]
#[case("position == 8001 +/- 2", 0, F)]
#[case("position == 0 +/- 2", 7998, T)]
#[case("position == 0 +/- 2", 7997, F)]
#[case("position == 7999 +/- 2", 1, T)]
#[case("position == 7999 +/- 2", 2, F)]
#[case("0 == position +/- 2", 7999, T)]
#[case("position == before + 7949 +/- 1", 0, T)]
#[case("position != 0 +/- 2", 7998, F)]
#[case("position in [1, 2, 50]", 50, T)]
#[case("position < 8000", 7999, T)]
#[case("position < 8000", 8000, F)]
#[case("position >= 8000", 8000, T)]
#[case("position mod 4096 == 1", 4097, T)]
#[case("position << 2 == 200", 50, T)]
#[case("MT_POS * 4000 + ST_POS == position +/- 1", 7998, T)]
#[case("MT_POS * 4000 + ST_POS == position +/- 1", 8000, F)]
fn a_position_is_compared_as_received(#[case] text: &str, #[case] position: i64, #[case] expected: Option<bool>) {
    let observed = [
        ("position", place(position)),
        ("before", place(50)),
        ("MT_POS", Value::whole(1)),
        ("ST_POS", Value::whole(3999)),
    ];
    assert_eq!(truth(text, &observed), expected);
}

#[rstest]
#[case("position == 50", T)]
#[case("position == 50 +/- 1", T)]
#[case("position == 60 +/- 1", F)]
#[case("position == 0 +/- 1", U)]
#[case("position == before + 1", U)]
#[case("position - before == 0", U)]
#[case("position < 100", T)]
fn without_a_range_what_no_number_of_steps_changes_is_known(#[case] text: &str, #[case] expected: Option<bool>) {
    let observed = [("position", Value::place(50, None)), ("before", Value::place(50, None))];
    assert_eq!(truth(text, &observed), expected);
}

#[test]
fn positions_with_different_ranges_have_no_distance() {
    let observed = [("position", place(10)), ("before", Value::place(10, Some(4096)))];
    assert_eq!(computed("position - before", &observed), Value::Unknown);
    assert_eq!(truth("position == before", &observed), T);
}

#[rstest]
#[case("position == 0", 7997, F)]
#[case("position == 0", 7998, T)]
#[case("position == 0", 2, T)]
#[case("position != 0", 2, F)]
#[case("position != 0", 3, T)]
#[case("position == 0 +/- 1", 3, T)]
#[case("position == 0 +/- 1", 4, F)]
#[case("position == 8050", 8050, T)]
#[case("position == 50", 8050, F)]
#[case("position in [0, 100]", 102, T)]
#[case("position in [0, 100]", 103, F)]
#[case("52 in [position, 3]", 50, T)]
#[case("position < 8000", 7999, T)]
#[case("position < 8000", 8000, F)]
#[case("position < 8000", 8001, F)]
#[case("position <= 100", 102, T)]
#[case("position <= 100", 103, F)]
#[case("position <= 100", 7998, T)]
#[case("position >= 100", 98, T)]
#[case("position >= 100", 97, F)]
#[case("100 >= position", 102, T)]
#[case("100 >= position", 7999, T)]
#[case("8000 >= position", 8001, F)]
#[case("100 < position", 99, T)]
#[case("100 < position", 98, F)]
#[case("abs(position - before) <= 8", 60, T)]
#[case("abs(position - before) <= 8", 61, F)]
#[case("position - before == 8", 60, T)]
#[case("position - before == 8", 61, F)]
#[case("ST_POS == 5", 0, F)]
#[case("ST_POS < 7", 0, F)]
fn every_comparison_of_a_position_gets_the_noise(
    #[case] text: &str,
    #[case] position: i64,
    #[case] expected: Option<bool>,
) {
    let observed = [("position", place(position)), ("before", place(50)), ("ST_POS", Value::whole(7))];
    let program = condition(text).unwrap_or_else(|error| panic!("{text}: {error}"));
    assert_eq!(program.truth(&ObservedValues::now(&observed).noise(2), &HistoryState::default()), expected);
}

/// Where G1_XIST2 shows an error code, the shaft does not move it.
#[rstest]
#[case("position == 0x1001", F)]
#[case("position != 0x1001", T)]
#[case("position == 0x1002", T)]
#[case("position == 0x1001 +/- 1", T)]
#[case("position in [0, 0x1001, 0x1003]", F)]
#[case("position == before", F)]
#[case("before == position", F)]
#[case("position >= 0x1003", F)]
#[case("position > 0x1002", F)]
#[case("0x1001 >= position", F)]
#[case("0x1002 >= position", T)]
fn noise_does_not_change_a_code(#[case] text: &str, #[case] expected: Option<bool>) {
    for range in [Some(8000), None] {
        let observed = [("position", Value::place(0x1002, range).as_code()), ("before", Value::place(0x1001, range))];
        let program = condition(text).unwrap_or_else(|error| panic!("{text}: {error}"));
        let noisy = ObservedValues::now(&observed).noise(2);
        assert_eq!(program.truth(&noisy, &HistoryState::default()), expected, "{range:?}");
    }
}

/// The range is that of parameters that were not sent.
#[rstest]
#[case("position == 100", 102, T)]
#[case("position == 100", 103, F)]
#[case("position == 100 +/- 1", 103, T)]
#[case("position == 100 +/- 1", 104, F)]
#[case("position == 1", 5000, U)]
#[case("position != 100", 103, T)]
#[case("position >= 100", 98, T)]
#[case("position >= 100", 97, U)]
#[case("position <= 100", 102, T)]
#[case("position <= 100", 103, U)]
#[case("100 <= position", 98, T)]
fn noise_on_an_unknown_circle_decides_what_no_number_of_steps_changes(
    #[case] text: &str,
    #[case] position: i64,
    #[case] expected: Option<bool>,
) {
    let program = condition(text).unwrap_or_else(|error| panic!("{text}: {error}"));
    let observed = ObservedValues::now(&[("position", Value::place(position, None))]).noise(2);
    assert_eq!(program.truth(&observed, &HistoryState::default()), expected);
}

#[test]
fn a_right_side_gets_the_noise_and_stays_on_its_circle() {
    let target = target("before + 7950 +/- 1", "position").expect("a right side");
    let env = ObservedValues::now(&[("before", place(50))]);
    let holds = |at, env: &ObservedValues| target.holds(&place(at), env, &HistoryState::default());
    assert_eq!((holds(0, &env), holds(7999, &env), holds(7998, &env)), (T, T, F));
    let noisy = env.noise(1);
    assert_eq!((holds(7998, &noisy), holds(7997, &noisy)), (T, F));
    assert_eq!(target.tolerance(&noisy, &HistoryState::default()), Some(Value::whole(1)));
    assert_eq!(target.center().eval(&noisy, &HistoryState::default()), place(0));
}

#[test]
fn values_of_different_types_are_unknown_and_have_no_order() {
    assert_eq!(equal(&Value::Word(1), &Value::whole(1), None, 0), U);
    assert_eq!(equal(&Value::Unknown, &Value::Unknown, None, 0), U);
    assert_eq!(order(OrderOperator::Less, &Value::Bit(false), &Value::Bit(true), 0), U);
    assert_eq!(order(OrderOperator::Less, &Value::whole(1), &Value::Unknown, 0), U);
}

#[test]
fn an_invalid_range_counts_as_unknown() {
    for range in [Some(0), Some(-5), Some(1 << 64), None] {
        let Value::Place(place) = Value::place(0, range) else { panic!("no place") };
        assert_eq!(place.steps(), None);
    }
    assert_eq!(computed("before + 1", &[("before", Value::place(u64::MAX - 1, Some(i128::from(u64::MAX))))]), {
        Value::place(0, Some(i128::from(u64::MAX)))
    });
}
