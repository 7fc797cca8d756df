//! Conditions: three-valued logic, comparisons, bits as conditions.

use super::{HistoryState, Value, computed, condition, target, truth};
use rstest::rstest;

const T: Option<bool> = Some(true);
const F: Option<bool> = Some(false);
const U: Option<bool> = None;

#[rstest]
#[case(T, T, T, T)]
#[case(T, F, F, T)]
#[case(T, U, U, T)]
#[case(F, T, F, T)]
#[case(F, F, F, F)]
#[case(F, U, F, U)]
#[case(U, T, U, T)]
#[case(U, F, F, U)]
#[case(U, U, U, U)]
fn and_and_or_are_three_valued(
    #[case] a: Option<bool>,
    #[case] b: Option<bool>,
    #[case] and: Option<bool>,
    #[case] or: Option<bool>,
) {
    let observed: Vec<(&str, Value)> =
        [("a", a), ("b", b)].into_iter().filter_map(|(name, bit)| Some((name, Value::Bit(bit?)))).collect();
    assert_eq!(truth("a and b", &observed), and);
    assert_eq!(truth("a or b", &observed), or);
    assert_eq!(truth("not a", &observed), a.map(|a| !a));
    assert_eq!(truth("not (a and b)", &observed), and.map(|and| !and));
}

#[rstest]
#[case("a or b and c", &[1, 0, 0], T)]
#[case("(a or b) and c", &[1, 0, 0], F)]
#[case("not a and b", &[0, 1, 0], T)]
#[case("not (a and b)", &[1, 0, 0], T)]
#[case("not a or b", &[1, 1, 0], T)]
#[case("not a == b", &[1, 0, 0], T)]
#[case("a == 1", &[1, 0, 0], T)]
#[case("a == 0", &[1, 0, 0], F)]
#[case("a != b", &[1, 0, 0], T)]
#[case("(a and b) == (b and a)", &[1, 0, 0], T)]
#[case("a in [b, c]", &[1, 0, 1], T)]
#[case("a in [0]", &[1, 0, 1], F)]
fn operators_have_the_precedence_of_the_grammar(
    #[case] text: &str,
    #[case] bits: &[u8],
    #[case] expected: Option<bool>,
) {
    let observed: Vec<_> =
        ["a", "b", "c"].into_iter().zip(bits).map(|(name, bit)| (name, Value::Bit(*bit == 1))).collect();
    assert_eq!(truth(text, &observed), expected);
}

#[rstest]
#[case("NIST_B == 100", 100, T)]
#[case("NIST_B == 100", 101, F)]
#[case("NIST_B != 100", 101, T)]
#[case("NIST_B < 100", 100, F)]
#[case("NIST_B <= 100", 100, T)]
#[case("NIST_B > 100", 100, F)]
#[case("NIST_B >= 100", 100, T)]
#[case("NIST_B == 100 +/- 2", 98, T)]
#[case("NIST_B == 100 +/- 2", 103, F)]
#[case("NIST_B != 100 +/- 2", 98, F)]
#[case("NIST_B != 100 +/- 2", 97, T)]
#[case("NIST_B == 300 +/- 5%", 285, T)]
#[case("NIST_B == 300 +/- 5%", 284, F)]
#[case("NIST_B == 300 +/- 5%", 315, T)]
#[case("NIST_B == 300 +/- 5%", 316, F)]
#[case("NIST_B == -300 +/- 5%", -315, T)]
#[case("NIST_B == -300 +/- 5%", -316, F)]
#[case("NIST_B == 100 +/- 0.5", 100, T)]
#[case("NIST_B == 10 +/- 5%", 11, F)]
#[case("NIST_B in [1, 2, 3]", 3, T)]
#[case("NIST_B in [1, 2, 3]", 4, F)]
#[case("NIST_B mod 15 + 1 == 3", 17, T)]
fn numbers_are_compared_exactly_or_within_a_tolerance(
    #[case] text: &str,
    #[case] observed: i64,
    #[case] expected: Option<bool>,
) {
    assert_eq!(truth(text, &[("NIST_B", Value::whole(observed))]), expected);
    assert_eq!(truth(text, &[]), U, "a value that was not received is neither true nor false");
}

#[rstest]
#[case("NIST_B in [1, P65000]", U)]
#[case("NIST_B in [5, P65000]", T)]
#[case("NIST_B == 5 +/- P65000", U)]
#[case("NIST_B == P65000 or NIST_B == 5", T)]
#[case("NIST_B == P65000 and NIST_B == 6", F)]
#[case("NIST_B + P65000 == 5", U)]
#[case("not (NIST_B == P65000)", U)]
fn unknown_operands_do_not_decide(#[case] text: &str, #[case] expected: Option<bool>) {
    assert_eq!(truth(text, &[("NIST_B", Value::whole(5))]), expected);
}

#[rstest]
#[case("class_4 == enabled", 1, T)]
#[case("enabled == class_4", 1, T)]
#[case("class_4 != enabled", 1, F)]
#[case("class_4 == disabled", 1, F)]
#[case("class_4 in [enabled, disabled]", 0, T)]
#[case("class_4 == enabled", 7, F)]
fn words_are_resolved_in_the_table_of_the_other_side(
    #[case] text: &str,
    #[case] observed: i64,
    #[case] expected: Option<bool>,
) {
    assert_eq!(truth(text, &[("class_4", Value::Word(observed))]), expected);
}

#[test]
fn one_word_may_have_another_number_in_another_table() {
    let observed = [("g1_xist1_preset_control", Value::Word(0)), ("class_4", Value::Word(0))];
    assert_eq!(truth("g1_xist1_preset_control == enabled", &observed), T);
    assert_eq!(truth("class_4 == enabled", &observed), F);
}

#[test]
fn a_word_takes_precedence_over_a_name() {
    let observed = [("alarm.error", Value::Word(0x900A)), ("position", Value::place(5, Some(100)))];
    assert_eq!(truth("alarm.error == position", &observed), T);
    assert_eq!(truth("position == alarm.error", &observed), T);
    assert_eq!(truth("position == 5", &observed), T);
}

#[test]
fn a_column_may_hold_a_word() {
    assert_eq!(truth("speed_unit == unit", &[("speed_unit", Value::Word(3))]), T);
    assert_eq!(truth("speed_unit == unit", &[("speed_unit", Value::Word(0))]), F);
}

#[rstest]
#[case(r#"station.name == "enc-1""#, T)]
#[case(r#"station.name == "enc-" + "1""#, T)]
#[case(r#"station.name == "Enc-1""#, F)]
#[case(r#"station.name in ["a", name]"#, T)]
#[case(r#"station.ip == "192.168.0.10""#, T)]
#[case(r#"station.ip != "192.168.0.10""#, F)]
#[case(r#"station.ip in ["0.0.0.0", "192.168.0.10"]"#, T)]
#[case(r#"io.inputs == "80 00""#, T)]
#[case(r#"io.inputs == "80 ..""#, T)]
#[case(r#"io.inputs == "81 *""#, F)]
#[case(r#""* 00" == io.inputs"#, T)]
#[case(r#"io.inputs in ["81 *", "80 *"]"#, T)]
#[case(r#"io.inputs != "80""#, T)]
#[case("cycle == 2ms", T)]
#[case("cycle == 2000us", T)]
#[case("cycle > 0", T)]
#[case("3 cycles > 0", T)]
#[case("supply.voltage == 12", F)]
#[case("supply.voltage == 11.5", T)]
#[case("supply.voltage < 12", T)]
#[case("cycle < 0.003s", T)]
#[case("cycle == 2.1ms +/- 5%", T)]
#[case("cycle == 2.2ms +/- 100us", F)]
#[case("diag.errors == diag.errors", T)]
fn each_type_is_compared_with_its_literals(#[case] text: &str, #[case] expected: Option<bool>) {
    let observed = [
        ("station.name", Value::text("enc-1")),
        ("station.ip", Value::Address([192, 168, 0, 10])),
        ("io.inputs", Value::bytes([0x80, 0])),
        ("cycle", Value::nanos(2_000_000)),
        ("supply.voltage", computed("23 / 2", &[])),
        ("diag.errors", Value::set([2, 1])),
    ];
    assert_eq!(truth(text, &observed), expected);
}

#[test]
fn a_set_has_no_order_but_a_number_of_entries() {
    assert_eq!(Value::set([1, 2]), Value::set([2, 1]));
    assert_ne!(Value::set([1, 1]), Value::set([1]));
}

#[rstest]
#[case("NIST_B", "100", 100, T)]
#[case("NIST_B", "100 +/- 1", 102, F)]
#[case("NIST_B", "shown +/- 1%", 1515, T)]
#[case("NIST_B", "shown +/- 1%", 1516, F)]
#[case("NIST_B", "2 * P65000 +/- P65000", 15, T)]
#[case("NIST_B", "2 * P65000 +/- P65000", 16, F)]
fn a_right_side_is_a_comparison_with_the_name(
    #[case] name: &str,
    #[case] text: &str,
    #[case] observed: i64,
    #[case] expected: Option<bool>,
) {
    let target = target(text, name).expect("a right side");
    let env = super::ObservedValues::now(&[("P65000", Value::whole(5))]);
    assert_eq!(target.holds(&Value::whole(observed), &env, &HistoryState::default()), expected);
    assert_eq!(target.holds(&Value::Unknown, &env, &HistoryState::default()), U);
}

#[test]
fn a_negative_tolerance_at_run_time_gives_unknown() {
    let observed = [("NIST_B", Value::whole(5)), ("ST_POS", Value::whole(1))];
    assert_eq!(truth("NIST_B == 5 +/- (ST_POS - 2)", &observed), U);
    assert_eq!(truth("NIST_B == 5 +/- (ST_POS - 1)", &observed), T);
}

#[test]
fn constants_are_folded() {
    let constant = |text: &str| condition(text).expect("a condition").constant().cloned();
    assert_eq!(constant("1 == 1"), Some(Value::Bit(true)));
    assert_eq!(constant("a or 1 == 1"), Some(Value::Bit(true)));
    assert_eq!(constant("a and 1 == 2"), Some(Value::Bit(false)));
    assert_eq!(constant("not (3 < 2) and 4 / 2 in [2]"), Some(Value::Bit(true)));
    assert_eq!(constant("a and 1 == 1"), None);
    assert!(!condition("a and 1 == 1").expect("a condition").is_constant());
}

#[test]
fn names_are_listed_once_and_in_order() {
    let program = condition("b and rises(a) and (b or prev(NIST_B) == 1) and class_4 == enabled").expect("a condition");
    let names: Vec<_> = program.names().collect();
    assert_eq!(names.len(), 4);
    assert!(names.is_sorted());
    assert!(program.has_history());
    assert!(!condition("a").expect("a condition").has_history());
}
