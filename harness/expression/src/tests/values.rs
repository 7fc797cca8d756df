//! Values: exact, typed arithmetic without implicit conversion.

use super::super::{FormattedValue, Number};
use super::ty as named;
use super::{Allow, HistoryState, ObservedValues, Program, TestNames, Type, Value, computed, value};
use rstest::rstest;

fn fraction(over: i128, under: i128) -> Value {
    Value::Number(Number::new(over, under).expect("a number"))
}

#[rstest]
#[case("1 + 2 * 3", Value::whole(7))]
#[case("(1 + 2) * 3", Value::whole(9))]
#[case("10 - 3 - 2", Value::whole(5))]
#[case("100 / 10 / 5", Value::whole(2))]
#[case("1 << 2 + 1", Value::whole(5))]
#[case("2 * 3 << 1", Value::whole(12))]
#[case("1 << 2 << 1", Value::whole(8))]
#[case("-5 mod 15", Value::whole(10))]
#[case("-(7) + 2", Value::whole(-5))]
#[case("3 - -2", Value::whole(5))]
#[case("1 / 3 * 3", Value::whole(1))]
#[case("1 / 3", fraction(1, 3))]
#[case("0.1 + 0.2", fraction(3, 10))]
#[case("7 mod -15", Value::whole(7))]
#[case("-9 >> 1", Value::whole(-5))]
#[case("floor(7 / 2)", Value::whole(3))]
#[case("floor(-7 / 2)", Value::whole(-4))]
#[case("round(7 / 2)", Value::whole(4))]
#[case("round(-7 / 2)", Value::whole(-4))]
#[case("round(10 / 3)", Value::whole(3))]
#[case("abs(-3)", Value::whole(3))]
#[case("min(3, 1, 2)", Value::whole(1))]
#[case("max(3, 1, 7 / 2)", fraction(7, 2))]
#[case("200ms + 2s", Value::nanos(2_200_000_000i64))]
#[case("3 * 2ms", Value::nanos(6_000_000))]
#[case("2ms * 3 / 4", Value::nanos(1_500_000))]
#[case("10ms / 4ms", fraction(5, 2))]
#[case("7ms mod 2ms", Value::nanos(1_000_000))]
#[case("-2us", Value::nanos(-2_000))]
#[case("max(1s, 300ms)", Value::nanos(1_000_000_000))]
#[case("2 * 50 cycles + 1 cycles", Value::Cycles(Number::whole(101)))]
#[case("2*50  cycles", Value::Cycles(Number::whole(100)))]
#[case(r#""a" * 3 + "." + "b""#, Value::text("aaa.b"))]
#[case(r#""" + "a" * 0"#, Value::text(""))]
#[case("shift * 3", Value::whole(3000))]
#[case("1+2-3", Value::whole(0))]
fn constants(#[case] text: &str, #[case] expected: Value) {
    let program = value(text).unwrap_or_else(|error| panic!("{text}: {error}"));
    assert_eq!(program.constant(), Some(&expected));
}

#[rstest]
#[case("NIST_B / 3", fraction(10, 3))]
#[case("floor(NIST_B / 3) * 3", Value::whole(9))]
#[case("NIST_B << 4", Value::whole(160))]
#[case("NIST_B mod 4", Value::whole(2))]
#[case("NIST_B / (NIST_B - 10)", Value::Unknown)]
#[case("NIST_B mod (NIST_B - 10)", Value::Unknown)]
#[case("1 << NIST_B * 20", Value::Unknown)]
#[case("NIST_B << 126", Value::Unknown)]
#[case("NIST_B >> (0 - NIST_B)", Value::Unknown)]
#[case("floor(cycle / 1ms)", Value::whole(2))]
#[case("cycle * NIST_B", Value::nanos(25_000_000))]
#[case(r#""ab" * NIST_B"#, Value::text("abababababababababab"))]
#[case(r#""ab" * (NIST_B << 20)"#, Value::Unknown)]
#[case(r#""ab" * (0 - NIST_B)"#, Value::Unknown)]
#[case("min(NIST_B, P65000)", Value::Unknown)]
#[case("abs(0 - NIST_B)", Value::whole(10))]
#[case("number(station.ip)", Value::whole(0xC0A8_14C3_u32))]
#[case("number(station.ip) mod 256", Value::whole(195))]
fn computed_from_received_values(#[case] text: &str, #[case] expected: Value) {
    let ip = Value::Address([192, 168, 20, 195]);
    let observed = [("NIST_B", Value::whole(10)), ("cycle", Value::nanos(2_500_000)), ("station.ip", ip)];
    assert_eq!(computed(text, &observed), expected);
}

#[rstest]
#[case(Some(1), Some(1), Value::whole(4096))]
#[case(Some(1), Some(0), Value::whole(8192))]
#[case(Some(0), None, Value::whole(8192))]
#[case(Some(1), None, Value::Unknown)]
fn a_choice_needs_a_known_condition(
    #[case] class_4: Option<i64>,
    #[case] scaling: Option<i64>,
    #[case] expected: Value,
) {
    let text = "if class_4 == enabled and scaling == enabled then total_range else hardware_range";
    let program = Program::value(text, None, &TestNames::new(), Allow::DEVICE).expect("a choice");
    let mut observed = vec![("total_range", Value::whole(4096)), ("hardware_range", Value::whole(8192))];
    observed.extend(class_4.map(|word| ("class_4", Value::Word(word))));
    observed.extend(scaling.map(|word| ("scaling", Value::Word(word))));
    assert_eq!(program.eval(&ObservedValues::now(&observed), &HistoryState::default()), expected);
}

#[rstest]
#[case("enabled", "class_4", Value::Word(1))]
#[case("enabled", "g1_xist1_preset_control", Value::Word(0))]
#[case("unit", "speed_unit", Value::Word(3))]
#[case("1", "alarm", Value::Bit(true))]
#[case("0", "cycle", Value::nanos(0))]
#[case("floor(7 / 2) * 2ms", "cycle", Value::nanos(6_000_000))]
#[case("\"80 00\"", "io.inputs", Value::bytes([0x80, 0]))]
#[case("\"10.0.0.1\"", "station.ip", Value::Address([10, 0, 0, 1]))]
#[case("4096 / 2", "P65000", Value::whole(2048))]
fn a_value_is_parsed_in_the_type_of_its_name(#[case] text: &str, #[case] name: &str, #[case] expected: Value) {
    let program = Program::value(text, Some(&named(name)), &TestNames::new(), Allow::VALUE);
    assert_eq!(program.expect("a value").constant(), Some(&expected));
}

#[rstest]
#[case(Value::whole(4096), Type::WHOLE, "4096")]
#[case(Value::nanos(200_000_000), Type::Time, "200ms")]
#[case(Value::nanos(0), Type::Time, "0")]
#[case(Value::nanos(1_500_000_000), Type::Time, "1500ms")]
#[case(Value::nanos(83), Type::Time, "83ns")]
#[case(Value::Cycles(Number::whole(50)), Type::Cycles, "50 cycles")]
#[case(Value::Word(1), named("class_4"), "enabled")]
#[case(Value::Word(7), named("class_4"), "7")]
#[case(Value::set([0x900A, 0x9000]), named("diag.errors"), "[memory, position]")]
#[case(Value::Bit(true), Type::Bit, "1")]
#[case(Value::bytes([0x80, 0x0A]), Type::Bytes, "80 0A")]
#[case(Value::Address([192, 168, 0, 10]), Type::Address, "192.168.0.10")]
#[case(Value::text("enc-1"), Type::Text, "'enc-1'")]
#[case(Value::place(5, Some(8)), named("position"), "5")]
#[case(Value::Unknown, Type::Bit, "unknown")]
fn formatted_as_a_suite_writes_it(#[case] value: Value, #[case] ty: Type, #[case] text: &str) {
    assert_eq!(FormattedValue(&value, &ty).to_string(), text);
}

#[test]
fn a_value_is_small_enough_to_be_passed_around() {
    assert!(size_of::<Value>() <= 48, "{}", size_of::<Value>());
}
