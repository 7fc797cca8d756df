//! Fuzzing: no text makes the compiler or the evaluation panic.

use super::{Allow, ExpectedValue, HistoryState, ObservedValues, Program, TestNames, Type, Value, condition, ty};
use std::fmt::Write as _;

const TEXTS: [&str; 8] = [
    "ZSW2_ENC.sign_of_life != 0 and (ZSW2_ENC.sign_of_life - prev(ZSW2_ENC.sign_of_life)) mod 15 == floor(cycle / 1ms) mod 15",
    "time_stamp == (prev(time_stamp) + 1) mod 65536 and since(changes(time_stamp)) == 1s +/- 2%",
    "if class_4 == enabled and (scaling == enabled or round_axis == enabled) then total_range else hardware_range",
    r#"station.name in ["a" * 63 + "." + "b", name] or io.inputs == "80 .. *" or station.ip == "10.0.0.1""#,
    "abs(position - prev(position)) <= 1 or position == 0x1000 +/- 40 or not (led.encoder == green_flashing)",
    "min(NIST_B, 3) << 2 >> 1 - -4 in [1, 2.5, 3 cycles, 007]",
    "\u{e4}nderung \u{b1} 5 && \u{1f600} == '",
    "position +/- 1%",
];

/// Compiles the text in every mode, evaluates what compiles, and checks the spans of errors.
fn torture(text: &str, names: &TestNames) {
    let expected = [Type::WHOLE, ty("position"), ty("class_4"), Type::Time, Type::Text, Type::Bytes];
    let mut errors = Vec::new();
    let known = ObservedValues::now(&[
        ("a", Value::Bit(true)),
        ("position", Value::place(7, Some(8))),
        ("before", Value::place(9, Some(8))),
        ("NIST_B", Value::whole(i64::MIN)),
        ("P65000", Value::whole(u64::MAX)),
        ("class_4", Value::Word(1)),
        ("cycle", Value::nanos(i64::MAX)),
        ("station.name", Value::text("x")),
        ("io.inputs", Value::bytes([1, 2])),
    ]);
    let unknown = ObservedValues::now(&[]);
    let mut run = |compiled: Result<Program, super::ExprError>| match compiled {
        Err(error) => errors.push(error),
        Ok(program) => {
            let mut state = HistoryState::default();
            for env in [&known, &unknown, &known] {
                program.eval(env, &state);
                program.truth(env, &state);
                program.explain(env, &state);
                state.advance(&program, env);
            }
        }
    };
    for allow in [Allow::TRACE, Allow::DEVICE, Allow::VALUE] {
        run(Program::condition(text, names, allow));
        run(Program::value(text, None, names, allow));
        for expected in &expected {
            run(Program::value(text, Some(expected), names, allow));
            run(ExpectedValue::compile(text, expected, names, allow).map(|target| {
                target.holds(&Value::place(1, Some(8)), &known, &HistoryState::default());
                target.tolerance(&known, &HistoryState::default());
                target.center().clone()
            }));
        }
    }
    for error in errors {
        assert!(text.get(error.span.clone()).is_some(), "{text:?}: {error:?} points nowhere");
        assert!(error.help.is_some(), "{text:?}: {error:?} has no help");
    }
}

#[test]
fn every_prefix_is_a_program_or_an_error() {
    let names = TestNames::new();
    for text in TEXTS {
        for (end, _) in text.char_indices() {
            torture(&text[..end], &names);
        }
        torture(text, &names);
    }
}

#[test]
fn every_text_without_one_character_is_a_program_or_an_error() {
    let names = TestNames::new();
    for text in TEXTS {
        for (at, letter) in text.char_indices() {
            torture(&format!("{}{}", &text[..at], &text[at + letter.len_utf8()..]), &names);
        }
    }
}

/// A random number generator with a fixed seed (xorshift), so failures are reproducible.
struct Dice(u64);

impl Dice {
    fn roll(&mut self, sides: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        usize::try_from(self.0 % sides as u64).expect("small")
    }
}

#[test]
fn random_tokens_never_panic() {
    const TOKENS: [&str; 56] = [
        "a",
        "NIST_B",
        "P65000",
        "position",
        "before",
        "G1_XIST1",
        "class_4",
        "enabled",
        "cycle",
        "station.name",
        "unit",
        "shift",
        "io.inputs",
        "power",
        "nowhere",
        "1",
        "0",
        "3",
        "0x1F",
        "2.5",
        "340282366920938463463374607431768211455",
        "170141183460469231731687303715884105727",
        "200ms",
        "5 cycles",
        "\"80 *\"",
        "\"x\"",
        "+",
        "-",
        "*",
        "/",
        "mod",
        "<<",
        ">>",
        "==",
        "!=",
        "<",
        "<=",
        ">",
        ">=",
        "+/-",
        "%",
        "(",
        ")",
        "[",
        "]",
        ",",
        "in",
        "not",
        "and",
        "or",
        "if",
        "then",
        "else",
        "prev(",
        "rises(",
        "abs(",
    ];
    let names = TestNames::new();
    let mut dice = Dice(0x9E37_79B9_7F4A_7C15);
    let mut compiled = 0;
    for _ in 0..4_000 {
        let mut text = String::new();
        for _ in 0..=dice.roll(9) {
            let _ = write!(text, "{} ", TOKENS[dice.roll(TOKENS.len())]);
        }
        torture(&text, &names);
        compiled += usize::from(Program::value(&text, None, &names, Allow::TRACE).is_ok());
    }
    assert!(compiled > 50, "only {compiled} of the texts were programs");
}

#[test]
fn random_pairs_of_values_never_panic() {
    const VALUES: [&str; 16] = [
        "a",
        "NIST_B",
        "P65000",
        "position",
        "before",
        "class_4",
        "cycle",
        "station.name",
        "io.inputs",
        "0",
        "5",
        "2.5",
        "1s",
        "5 cycles",
        "\"x\"",
        "170141183460469231731687303715884105727",
    ];
    const SIGNS: [&str; 13] = ["+", "-", "*", "/", "mod", "<<", ">>", "==", "!=", "<", ">=", "== 3 +/-", "== 3 % +/-"];
    let names = TestNames::new();
    for left in VALUES {
        for sign in SIGNS {
            for right in VALUES {
                torture(&format!("{left} {sign} {right}"), &names);
            }
        }
    }
}

#[test]
fn depth_is_bounded() {
    let nested = |depth: usize| format!("{}a{}", "(".repeat(depth), ")".repeat(depth));
    assert!(condition(&nested(60)).is_ok());
    let deep = [
        nested(65),
        nested(1500),
        format!("{}a{}", "prev(".repeat(700), ")".repeat(700)),
        format!("NIST_B == {}", vec!["1"; 100].join("+")),
        format!("NIST_B == {}NIST_B{}", "abs(".repeat(100), ")".repeat(100)),
        "(".repeat(4000),
        format!("{}a", "not (".repeat(800)),
    ];
    for text in deep {
        let error = condition(&text).expect_err("too deep");
        assert!(error.message.contains("nested deeper") || error.message.contains("too long"), "{error}");
    }
    assert!(condition(&vec!["a"; 500].join(" or ")).is_ok(), "a flat row of conditions is not deep");
    assert!(condition(&"a ".repeat(5000)).expect_err("too long").message.contains("too long"));
}
