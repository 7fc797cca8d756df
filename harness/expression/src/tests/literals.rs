//! Literals of each type.

use super::super::{DurationLiteral, Number, NumberType, address, bytes, duration, literal, number};
use super::{Type, Value, WordTable, ty};
use rstest::rstest;
use std::time::Duration;

#[rstest]
#[case("4096", 4096, 1)]
#[case("0", 0, 1)]
#[case("0x1F", 31, 1)]
#[case("0x00012345", 0x12345, 1)]
#[case("0xdead", 0xDEAD, 1)]
#[case("-12", -12, 1)]
#[case("-0x54000", -0x54000, 1)]
#[case("11.25", 45, 4)]
#[case("-2.5", -5, 2)]
#[case("0.5", 1, 2)]
fn numbers(#[case] text: &str, #[case] over: i128, #[case] under: i128) {
    assert_eq!(number(text), Ok(Number::new(over, under).expect("a number")));
}

#[rstest]
#[case("", "is not a number")]
#[case("-", "is not a number")]
#[case("1_000", "`_`")]
#[case("0x1_F", "`_`")]
#[case("007", "leading zero")]
#[case("00", "leading zero")]
#[case("-01", "leading zero")]
#[case("0o17", "is not a number")]
#[case("0b1", "is not a number")]
#[case("0X1F", "is not a number")]
#[case("0x", "hexadecimal")]
#[case("0xG", "hexadecimal")]
#[case("1.", "after the dot")]
#[case(".5", "is not a number")]
#[case("1.2.3", "more than one dot")]
#[case("1e3", "is not a number")]
#[case("12a", "is not a number")]
#[case("+5", "is not a number")]
#[case("--5", "is not a number")]
#[case(" 5", "is not a number")]
#[case("170141183460469231731687303715884105728", "too large")]
#[case("0x80000000000000000000000000000000", "too large")]
#[case("0.0000000000000000000000000000000000000001", "too large")]
fn no_numbers(#[case] text: &str, #[case] message: &str) {
    let error = number(text).expect_err("no number");
    assert!(error.message.contains(message), "{error}");
    assert!(error.help.is_some());
    assert!(text.get(error.span.clone()).is_some(), "{error:?}");
}

#[rstest]
#[case("0", DurationLiteral::Time(Duration::ZERO))]
#[case("0ms", DurationLiteral::Time(Duration::ZERO))]
#[case("83ns", DurationLiteral::Time(Duration::from_nanos(83)))]
#[case("31.25us", DurationLiteral::Time(Duration::from_nanos(31_250)))]
#[case("200ms", DurationLiteral::Time(Duration::from_millis(200)))]
#[case("2s", DurationLiteral::Time(Duration::from_secs(2)))]
#[case("5min", DurationLiteral::Time(Duration::from_secs(300)))]
#[case("50 cycles", DurationLiteral::Cycles(50))]
#[case("1 cycles", DurationLiteral::Cycles(1))]
fn durations(#[case] text: &str, #[case] span: DurationLiteral) {
    assert_eq!(duration(text), Ok(span));
}

#[rstest]
#[case("")]
#[case("5")]
#[case("200 ms")]
#[case("-2s")]
#[case("2 s")]
#[case("2sec")]
#[case("2S")]
#[case("1h")]
#[case("50cycles")]
#[case("50 cycle")]
#[case("2.5 cycles")]
#[case("-1 cycles")]
#[case("0.1ns")]
#[case("99999999999999min")]
#[case("cycles")]
#[case(" cycles")]
fn no_durations(#[case] text: &str) {
    let error = duration(text).expect_err("no duration");
    assert!(error.help.is_some(), "{error}");
}

#[rstest]
#[case("192.168.0.10", Some([192, 168, 0, 10]))]
#[case("0.0.0.0", Some([0; 4]))]
#[case("192.168.0", None)]
#[case("192.168.0.256", None)]
#[case("192.168.0.010", None)]
#[case("", None)]
fn addresses(#[case] text: &str, #[case] octets: Option<[u8; 4]>) {
    assert_eq!(address(text).ok(), octets);
}

#[test]
fn wildcards_are_allowed_in_checks_only() {
    assert_eq!(bytes("80 00 12"), Ok(vec![0x80, 0, 0x12]));
    assert_eq!(bytes(""), Ok(vec![]));
    assert!(bytes("80 ..").is_err());
    assert!(bytes("*").is_err());
    assert!(matches!(literal("80 ..", &Type::Bytes), Ok(Value::Pattern(_))));
    assert_eq!(literal("80 00", &Type::Bytes), Ok(Value::bytes([0x80, 0])));
}

#[rstest]
#[case("15", "ZSW2_ENC.sign_of_life", Some(Value::whole(15)))]
#[case("16", "ZSW2_ENC.sign_of_life", None)]
#[case("-1", "ZSW2_ENC.sign_of_life", None)]
#[case("0x7FFFFFFF", "NIST_B", Some(Value::whole(0x7FFF_FFFF)))]
#[case("0x80000000", "NIST_B", None)]
#[case("-2147483648", "NIST_B", Some(Value::whole(-2_147_483_648i64)))]
#[case("-2147483649", "NIST_B", None)]
#[case("1.5", "NIST_B", None)]
#[case("1.5", "supply.voltage", Some(Value::Number(Number::new(3, 2).expect("a number"))))]
#[case("8050", "position", Some(Value::whole(8050)))]
#[case("-1", "position", None)]
#[case("1.5", "position", None)]
#[case("0", "alarm", Some(Value::Bit(false)))]
#[case("1", "alarm", Some(Value::Bit(true)))]
#[case("2", "alarm", None)]
#[case("true", "alarm", None)]
#[case("enabled", "class_4", Some(Value::Word(1)))]
#[case("enabled", "g1_xist1_preset_control", Some(Value::Word(0)))]
#[case("on", "class_4", None)]
#[case("1", "class_4", None)]
#[case("2s", "cycle", Some(Value::nanos(2_000_000_000)))]
#[case("2 cycles", "cycle", None)]
#[case("enc-1", "station.name", Some(Value::text("enc-1")))]
#[case("=enc-1", "station.name", None)]
#[case("192.168.0.10", "station.ip", Some(Value::Address([192, 168, 0, 10])))]
fn a_literal_is_read_in_the_type_of_its_name(#[case] text: &str, #[case] name: &str, #[case] value: Option<Value>) {
    match (literal(text, &ty(name)), value) {
        (Ok(read), Some(value)) => assert_eq!(read, value),
        (Err(error), None) => assert!(error.help.is_some() || error.message.contains("out of range"), "{error}"),
        (read, value) => panic!("{text} for {name} is {read:?}, not {value:?}"),
    }
}

#[test]
fn an_unknown_word_gets_a_suggestion() {
    let error = literal("enabld", &ty("class_4")).expect_err("no word");
    assert_eq!(error.to_string(), "`enabld` is not a word of `switch`: did you mean `enabled`?");
    let error = literal("sideways", &ty("class_4")).expect_err("no word");
    assert_eq!(error.to_string(), "`sideways` is not a word of `switch`: write one of `disabled`, `enabled`");
}

#[test]
fn tables_of_words_keep_numbers_without_a_word() {
    let table = WordTable::new("switch", [("disabled", 0), ("enabled", 1)]);
    assert_eq!((table.number("enabled"), table.word(0), table.word(7)), (Some(1), Some("disabled"), None));
    assert_eq!(WordTable::plain("led", ["dark", "red"]).number("red"), Some(1));
}

#[test]
fn widths_give_limits() {
    let limits = |ty| match ty {
        Type::Number(NumberType { limits, .. }) => limits,
        _ => None,
    };
    assert_eq!(limits(Type::whole(4, false)), Some((0, 15)));
    assert_eq!(limits(Type::whole(16, true)), Some((-32768, 32767)));
    assert_eq!(limits(Type::whole(64, false)), Some((0, 18_446_744_073_709_551_615)));
    assert_eq!(limits(Type::whole(0, false)), Some((0, 1)));
}
