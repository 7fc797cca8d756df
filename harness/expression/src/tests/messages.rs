//! Error messages: span, message and help.

use super::{Allow, ExprError, HistoryState, ObservedValues, Program, TestNames, Value, condition, target, ty, value};
use rstest::rstest;

fn check(text: &str, error: ExprError, at: &str, message: &str) {
    let shown = error.to_string();
    assert!(shown.contains(message), "{text}: {shown}");
    assert_eq!(&text[error.span.clone()], at, "{text}: {shown}");
    assert!(error.help.is_some(), "{text}: {shown}");
}

#[rstest]
#[case("G1_ZSW.parkd", "G1_ZSW.parkd", "did you mean `G1_ZSW.parked`?")]
#[case("a and nowhere_at_all", "nowhere_at_all", "declare it in `device.yaml`")]
#[case("a == true", "true", "write 1 for a bit")]
#[case("class_4 == enabld", "enabld", "`enabld` is not a word of `switch`: did you mean `enabled`?")]
#[case("class_4 == sideways", "sideways", "write one of `disabled`, `enabled`")]
#[case("class_4 == 1", "class_4 == 1", "write one of `disabled`, `enabled`")]
#[case("class_4 < enabled", "class_4 < enabled", "has no order")]
#[case("clas_4 == enabled", "clas_4", "did you mean `class_4`?")]
#[case(
    "class_4 == g1_xist1_preset_control",
    "class_4 == g1_xist1_preset_control",
    "cannot compare a word of `switch` with a word"
)]
#[case("class_4", "class_4", "compare it with `==` and one of `disabled`, `enabled`")]
#[case("NIST_B", "NIST_B", "expected a condition, found a whole number")]
#[case("a and 1", "1", "expected a condition")]
#[case("position", "position", "expected a condition, found a position")]
#[case("station.name", "station.name", "compare it with `==`")]
#[case("unit", "unit", "is the word `rpm`")]
#[case("NIST_B == unit", "unit", "is the word `rpm`")]
#[case("power == 1", "power", "`power` can only be set: check `connection`")]
#[case("NIST_B == P65000 / 2", "P65000 / 2", "use `floor` or `round`")]
#[case("NIST_B == P65000 + 0.5", "P65000 + 0.5", "use `floor` or `round`")]
#[case("NIST_B == max(P65000, 0.5)", "max(P65000, 0.5)", "use `floor` or `round`")]
#[case("NIST_B == supply.voltage", "supply.voltage", "use `floor` or `round`")]
#[case("NIST_B < 2.5", "2.5", "use `floor` or `round`")]
#[case("NIST_B in [1, 2.5]", "2.5", "use `floor` or `round`")]
#[case("position == NIST_B / 2", "position == NIST_B / 2", "use `floor` or `round`")]
#[case("position + 0.5 == 3", "position + 0.5", "a position changes by whole steps only")]
#[case("ZSW2_ENC.sign_of_life == 16", "16", "out of range (0 to 15)")]
#[case("ZSW2_ENC.sign_of_life in [1, 16]", "16", "out of range")]
#[case("position == -1", "position == -1", "-1 is not a position")]
#[case("position == G1_XIST1", "position == G1_XIST1", "different circles")]
#[case("position - G1_XIST1 == 0", "position - G1_XIST1", "different circles")]
#[case("position + before == 0", "position + before", "two positions cannot be added")]
#[case("5 - position == 0", "5 - position", "cannot be subtracted from a number")]
#[case("abs(position) == 0", "position", "a position has no magnitude")]
#[case("-position == 0", "position", "a position has no magnitude")]
#[case("floor(position) == 0", "position", "a position has no magnitude")]
#[case("position == 5 +/- 1%", "1", "a position has no percentage")]
#[case("position == 5 +/- 0.5", "0.5", "the tolerance must be a whole number")]
#[case("NIST_B == 5 +/- 1s", "1s", "the tolerance must be a number")]
#[case("NIST_B == 5 +/- -1", "-1", "a tolerance cannot be negative")]
#[case("cycle == 2ms +/- 1", "1", "the tolerance must be a duration")]
#[case("a == b +/- 1", "1", "a bit has no tolerance")]
#[case("NIST_B < 5 +/- 1", "+/-", "a tolerance is allowed after `==` and `!=` only")]
#[case("a + b == 1", "a + b", "a bit is a condition")]
#[case("a == 2", "2", "2 is not a bit")]
#[case("a < b", "a < b", "has no order")]
#[case("class_4 + 1 == 2", "class_4 + 1", "words can only be compared")]
#[case("cycle == 2", "cycle == 2", "cannot compare a duration with a whole number")]
#[case("cycle == 2 cycles", "cycle == 2 cycles", "a number of cycles is not a duration")]
#[case("cycle + 2 cycles == 0", "cycle + 2 cycles", "a number of cycles is not a duration")]
#[case("station.name == 5", "station.name == 5", "cannot compare a text with a whole number")]
#[case("station.name == enc", "enc", "write a text in double quotes")]
#[case("station.name + 5 == \"x\"", "station.name + 5", "cannot combine")]
#[case("io.inputs == \"8000\"", "\"8000\"", "two capital hexadecimal digits")]
#[case("station.ip == \"192.168.0\"", "\"192.168.0\"", "write four decimal numbers")]
#[case("station.ip == 192.168.0.10", "192.168.0.10", "write an address in quotes")]
#[case("NIST_B == 1 / 0", "0", "division by zero")]
#[case("NIST_B mod 0 == 1", "0", "division by zero")]
#[case("NIST_B << 200 == 1", "200", "0 to 127 bits")]
#[case("NIST_B << -1 == 1", "-1", "0 to 127 bits")]
#[case("NIST_B << cycle == 1", "NIST_B << cycle", "cannot combine")]
#[case("2.5 << 1 == 5", "2.5 << 1", "only whole numbers can be shifted")]
#[case(
    "NIST_B == 170141183460469231731687303715884105727 * 2",
    "170141183460469231731687303715884105727 * 2",
    "cannot be computed"
)]
#[case("rises(NIST_B)", "NIST_B", "expected a condition")]
#[case("rises(a, b)", "rises(a, b)", "takes one value")]
#[case("changes(5)", "5", "this value is constant")]
#[case("prev(1 == 1)", "1 == 1", "this value is constant")]
#[case("min(1) == 1", "min(1)", "give at least two")]
#[case("min(1, 1s) == 1", "min(1, 1s)", "give values of the same type")]
#[case("rise(a)", "rise", "did you mean `rises`?")]
#[case("sqrt(NIST_B) == 1", "sqrt", "the functions are")]
#[case("floor(cycle) == 1", "cycle", "divide it by a duration")]
#[case("abs(a) == 1", "a", "use a number or a duration")]
#[case("number(NIST_B) == 1", "NIST_B", "is not an address")]
#[case("number(station.name) == 1", "station.name", "is not an address")]
#[case("NIST_B == station.ip", "NIST_B == station.ip", "cannot compare a whole number with an address")]
fn names_and_types(#[case] text: &str, #[case] at: &str, #[case] message: &str) {
    check(text, condition(text).expect_err(text), at, message);
}

#[rstest]
#[case("", "", "write an expression")]
#[case("   ", "", "write an expression")]
#[case("a and", "", "expected a value")]
#[case("and a", "and", "unexpected `and`")]
#[case("a b", "b", "write an operator, `and` or `or` before it")]
#[case("(a", "", "expected `)`")]
#[case("a)", ")", "remove it, or add the opening bracket")]
#[case("a or (b", "", "expected `)`")]
#[case("NIST_B in 5", "5", "expected `[`")]
#[case("NIST_B in [1, 2", "", "expected `]`")]
#[case("NIST_B in []", "]", "expected a value")]
#[case("NIST_B == 1 == 2", "==", "comparisons cannot be chained")]
#[case("1 < NIST_B < 3", "<", "join two comparisons with `and`")]
#[case("not not a", "not", "remove both")]
#[case("a == not b", "not", "put the negated condition in parentheses")]
#[case("NIST_B == --5", "-", "one `-` is enough")]
#[case("NIST_B == +5", "+", "write a number")]
#[case("a && b", "&&", "write `and`")]
#[case("a || b", "||", "write `or`")]
#[case("!a", "!", "write `not`")]
#[case("NIST_B = 5", "=", "write `==` to compare")]
#[case("NIST_B == 5 \u{b1} 1", "\u{b1}", "write `+/-`")]
#[case("NIST_B % 5 == 1", "%", "write `mod`")]
#[case("NIST_B == 5%", "%", "write `mod`")]
#[case("NIST_B == 5 +/- 1 +/- 1", "+/-", "write one tolerance")]
#[case("station.name == 'x'", "'", "double quotes")]
#[case("station.name == \"x", "\"x", "close it")]
#[case("NIST_B == 1_000", "1_000", "without `_`")]
#[case("NIST_B == 010", "010", "leading zero")]
#[case("NIST_B == 5sec", "5sec", "`sec` is not a unit")]
#[case("NIST_B == 200 ms", "ms", "write an operator, `and` or `or` before it")]
#[case("NIST_B == 5cycles", "5cycles", "write `5 cycles`")]
#[case("G1_ZSW. == 5", "G1_ZSW.", "dots separate the parts")]
#[case("G1_ZSW.12 == 5", "G1_ZSW.12", "each part of a name begins with a letter")]
#[case("a @ b", "@", "unexpected character `@`")]
#[case("if a then b else c", "a", "write an operator, `and` or `or` before it")]
fn grammar(#[case] text: &str, #[case] at: &str, #[case] message: &str) {
    check(text, condition(text).expect_err(text), at, message);
}

#[rstest]
#[case("5 +/- 1", "1", "a tolerance has no meaning here")]
#[case("prev(NIST_B)", "prev(NIST_B)", "use it in `expect`, `observe` or a rule")]
#[case("a == b", "==", "a comparison is not a value")]
#[case("if a then 1 else 2", "a", "write an operator, `and` or `or` before it")]
fn values(#[case] text: &str, #[case] at: &str, #[case] message: &str) {
    check(text, value(text).expect_err(text), at, message);
}

#[rstest]
#[case("if a then 1", "", "expected `else`")]
#[case("if a 1 else 2", "1", "expected `then`")]
#[case("if NIST_B then 1 else 2", "NIST_B", "expected a condition")]
#[case("if a then 1 else 1s", "1s", "give both the same type")]
#[case("1 + if a then 1 else 2", "if", "`if` is allowed at the start of an expression only")]
#[case("if rises(a) then 1 else 2", "rises(a)", "needs earlier values, which do not exist here")]
fn derived(#[case] text: &str, #[case] at: &str, #[case] message: &str) {
    check(text, Program::value(text, None, &TestNames::new(), Allow::DEVICE).expect_err(text), at, message);
}

#[rstest]
#[case("NIST_B", "2.5", "2.5", "use `floor` or `round`")]
#[case("NIST_B", "P65000 / 2", "P65000 / 2", "use `floor` or `round`")]
#[case("NIST_B", "0x80000000", "0x80000000", "out of range")]
#[case("NIST_B", "a", "a", "expected a whole number, found a bit")]
#[case("NIST_B", "\"x\"", "\"x\"", "cannot compare a whole number with a text")]
#[case("class_4", "enabld", "enabld", "did you mean `enabled`?")]
#[case("class_4", "1", "1", "write one of `disabled`, `enabled`")]
#[case("position", "G1_XIST1", "G1_XIST1", "different circles")]
#[case("alarm", "2", "2", "2 is not a bit")]
#[case("station.ip", "\"10.0.0\"", "\"10.0.0\"", "write four decimal numbers")]
fn right_sides(#[case] name: &str, #[case] text: &str, #[case] at: &str, #[case] message: &str) {
    check(text, target(text, name).expect_err(text), at, message);
}

#[test]
fn wildcards_cannot_be_written() {
    let error = Program::value("\"80 *\"", Some(&ty("io.inputs")), &TestNames::new(), Allow::VALUE).expect_err("open");
    check("\"80 *\"", error, "\"80 *\"", "allowed in checks only");
}

#[test]
fn a_failure_is_explained_part_by_part() {
    let text = "not (a and b) and position == before + 3 * shift +/- 1 and class_4 == enabled and prev(NIST_B) < 5";
    let program = condition(text).expect("a condition");
    let observed = ObservedValues::now(&[
        ("a", Value::Bit(true)),
        ("position", Value::place(0x1234, Some(8000))),
        ("before", Value::place(7000, Some(8000))),
        ("class_4", Value::Word(1)),
    ]);
    let shown: Vec<String> = program
        .explain(&observed, &HistoryState::default())
        .into_iter()
        .map(|part| {
            let operands: Vec<_> =
                part.operands.iter().map(|operand| format!("{} = {}", operand.text, operand.value)).collect();
            format!("{} is {:?}: {}", part.text, part.truth, operands.join(", "))
        })
        .collect();
    assert_eq!(
        shown,
        [
            "not (a and b) is None: a = 1, b = unknown",
            "position == before + 3 * shift +/- 1 is Some(false): position = 4660 (0x1234), before = 7000 (0x1B58), \
             before + 3 * shift = 2000 (0x7D0)",
            "class_4 == enabled is Some(true): class_4 = enabled",
            "prev(NIST_B) < 5 is None: prev(NIST_B) = unknown, NIST_B = unknown",
        ]
    );
}
