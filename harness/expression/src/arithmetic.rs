//! Types and values of arithmetic operators and functions.

use super::ast::Binary;
use super::types::NumberType;
use super::{Number, Type, Value};
use serde::{Deserialize, Serialize};

/// The functions that use one observation only, and the unary minus.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub(super) enum ArithmeticFunction {
    Negate,
    Abs,
    Min,
    Max,
    Floor,
    Round,
    Number,
}

/// Maximum length of a computed text in bytes.
const MAX_TEXT: usize = 65_536;

/// The type of `left sign right`, or an error message and its help.
pub(super) fn binary_type(sign: Binary, left: &Type, right: &Type) -> Result<Type, (String, &'static str)> {
    use Binary::{Add, Div, Mod, Mul, Shl, Shr, Sub};
    let whole = |ty: &Type| matches!(ty, Type::Number(NumberType { whole: true, .. }) | Type::Place(_));
    let steps = left.is_noisy() || right.is_noisy();
    let number = |whole| Ok(Type::Number(NumberType { whole, steps, limits: None }));
    match (sign, left, right) {
        (Add | Sub | Mul | Mod, Type::Number(a), Type::Number(b)) => number(a.whole && b.whole),
        (Div, Type::Number(_), Type::Number(_)) => number(false),
        (Add | Sub, Type::Place(circle), Type::Number(by)) | (Add, Type::Number(by), Type::Place(circle)) => {
            if by.whole {
                Ok(Type::Place(*circle))
            } else {
                Err(("a position changes by whole steps only".to_owned(), "use `floor` or `round` on the number"))
            }
        }
        (Sub, Type::Place(a), Type::Place(b)) if a == b => number(true),
        (Sub, Type::Place(_), Type::Place(_)) => Err((
            "these positions lie on different circles".to_owned(),
            "shift or multiply one of them first, so that it is a number",
        )),
        (Add, Type::Place(_), Type::Place(_)) => {
            Err(("two positions cannot be added".to_owned(), "add a number to a position, or subtract two positions"))
        }
        (Sub, Type::Number(_), Type::Place(_)) => Err((
            "a position cannot be subtracted from a number".to_owned(),
            "write position - number (a position) or position - position (the distance between them)",
        )),
        (Shl | Shr, a, b) if whole(a) && whole(b) && !matches!(b, Type::Place(_)) => number(true),
        (Shl | Shr, Type::Number(_) | Type::Place(_), Type::Number(_)) => {
            Err(("only whole numbers can be shifted".to_owned(), "use `floor` or `round` on the number"))
        }
        (Mul | Mod, Type::Place(_), Type::Number(by)) | (Mul, Type::Number(by), Type::Place(_)) => number(by.whole),
        (Div, Type::Place(_), Type::Number(_)) => number(false),
        (Add | Sub | Mod, Type::Time, Type::Time) => Ok(Type::Time),
        (Add | Sub | Mod, Type::Cycles, Type::Cycles) => Ok(Type::Cycles),
        (Div, Type::Time, Type::Time) | (Div, Type::Cycles, Type::Cycles) => number(false),
        (Mul | Div, Type::Time, Type::Number(_)) | (Mul, Type::Number(_), Type::Time) => Ok(Type::Time),
        (Mul | Div, Type::Cycles, Type::Number(_)) | (Mul, Type::Number(_), Type::Cycles) => Ok(Type::Cycles),
        (Add, Type::Text, Type::Text) => Ok(Type::Text),
        (Mul, Type::Text, Type::Number(times)) if times.whole => Ok(Type::Text),
        (_, Type::Bit, _) | (_, _, Type::Bit) => Err((
            format!("cannot calculate with {left} and {right}"),
            "a bit is a condition: use `and`, `or`, `not` or `==`",
        )),
        (_, Type::Word(_), _) | (_, _, Type::Word(_)) => Err((
            format!("cannot calculate with {left} and {right}"),
            "words can only be compared with `==`, `!=` and `in`",
        )),
        (_, Type::Time, Type::Cycles) | (_, Type::Cycles, Type::Time) => {
            Err(("a number of cycles is not a duration".to_owned(), "multiply a number by the duration `cycle`"))
        }
        _ => Err((
            format!("cannot combine {left} and {right} with this operator"),
            "use two numbers, two durations, a position and a number, or texts with `+` and `*`",
        )),
    }
}

/// The value of `left sign right`; unknown if an operand is unknown or the result cannot be computed.
pub(super) fn binary_value(sign: Binary, left: &Value, right: &Value) -> Value {
    use Binary::{Add, Div, Mod, Mul, Sub};
    let place = |place: Option<super::CircularPosition>| place.map_or(Value::Unknown, Value::Place);
    match (sign, left, right) {
        (_, Value::Number(a), Value::Number(b)) => some(numbers(sign, *a, *b), Value::Number),
        (Add, Value::Place(a), Value::Number(b)) | (Add, Value::Number(b), Value::Place(a)) => {
            place(b.as_whole().and_then(|by| a.moved(by)))
        }
        (Sub, Value::Place(a), Value::Number(b)) => place(b.negated().as_whole().and_then(|by| a.moved(by))),
        (Sub, Value::Place(a), Value::Place(b)) => a.distance_from(*b).map_or(Value::Unknown, Value::whole),
        (_, Value::Place(a), Value::Number(b)) => some(numbers(sign, Number::whole(a.at), *b), Value::Number),
        (Mul, Value::Number(a), Value::Place(b)) => some(a.times(Number::whole(b.at)), Value::Number),
        (Div, Value::Time(a), Value::Time(b)) | (Div, Value::Cycles(a), Value::Cycles(b)) => {
            some(a.divided_by(*b), Value::Number)
        }
        (Add | Sub | Mod, Value::Time(a), Value::Time(b)) => some(numbers(sign, *a, *b), Value::Time),
        (Add | Sub | Mod, Value::Cycles(a), Value::Cycles(b)) => some(numbers(sign, *a, *b), Value::Cycles),
        (Mul | Div, Value::Time(a), Value::Number(b)) => some(numbers(sign, *a, *b), Value::Time),
        (Mul | Div, Value::Cycles(a), Value::Number(b)) => some(numbers(sign, *a, *b), Value::Cycles),
        (Mul, Value::Number(a), Value::Time(b)) => some(a.times(*b), Value::Time),
        (Mul, Value::Number(a), Value::Cycles(b)) => some(a.times(*b), Value::Cycles),
        (Add, Value::Text(a), Value::Text(b)) if a.len() + b.len() <= MAX_TEXT => Value::text(format!("{a}{b}")),
        (Mul, Value::Text(text), Value::Number(times)) => repeated(text, *times),
        _ => Value::Unknown,
    }
}

/// The type of a function call, or an error message and its help.
pub(super) fn function_type(function: ArithmeticFunction, argument: &Type) -> Result<Type, (String, &'static str)> {
    match (function, argument) {
        (ArithmeticFunction::Number, Type::Address) => Ok(Type::WHOLE),
        (ArithmeticFunction::Number, _) => Err((
            format!("{argument} is not an address"),
            "`number` converts an address to a number, first byte most significant",
        )),
        (ArithmeticFunction::Floor | ArithmeticFunction::Round, Type::Number(kind)) => {
            Ok(Type::Number(NumberType { whole: true, limits: None, ..*kind }))
        }
        (ArithmeticFunction::Floor | ArithmeticFunction::Round, Type::Time | Type::Cycles) => Err((
            format!("{argument} has no fraction to remove"),
            "divide it by a duration first: `floor(cycle / 1ms)`",
        )),
        (ArithmeticFunction::Floor | ArithmeticFunction::Round, _) | (_, Type::Place(_))
            if matches!(argument, Type::Place(_)) =>
        {
            Err((
                "a position has no magnitude".to_owned(),
                "use the distance of two positions, `position - before`, or a remainder, `position mod 4096`",
            ))
        }
        (_, Type::Number(kind)) => Ok(Type::Number(NumberType { limits: None, ..*kind })),
        (_, Type::Time | Type::Cycles) => Ok(argument.clone()),
        _ => Err((format!("{argument} is not a number"), "use a number or a duration here")),
    }
}

/// The value of a function call; unknown if an argument is unknown.
pub(super) fn function_value(function: ArithmeticFunction, arguments: &mut dyn Iterator<Item = Value>) -> Value {
    let Some(first) = arguments.next() else { return Value::Unknown };
    let each = |compute: fn(Number) -> Number| match &first {
        Value::Number(number) => Value::Number(compute(*number)),
        Value::Time(nanos) => Value::Time(compute(*nanos)),
        Value::Cycles(cycles) => Value::Cycles(compute(*cycles)),
        _ => Value::Unknown,
    };
    match function {
        ArithmeticFunction::Negate => each(Number::negated),
        ArithmeticFunction::Abs => each(Number::abs),
        ArithmeticFunction::Floor => each(Number::floor),
        ArithmeticFunction::Round => each(Number::round),
        ArithmeticFunction::Number => match first {
            Value::Address(octets) => Value::whole(u32::from_be_bytes(octets)),
            _ => Value::Unknown,
        },
        ArithmeticFunction::Min => arguments.fold(first, |best, next| picked(best, next, Number::min)),
        ArithmeticFunction::Max => arguments.fold(first, |best, next| picked(best, next, Number::max)),
    }
}

fn picked(best: Value, next: Value, pick: fn(Number, Number) -> Number) -> Value {
    match (best, next) {
        (Value::Number(a), Value::Number(b)) => Value::Number(pick(a, b)),
        (Value::Time(a), Value::Time(b)) => Value::Time(pick(a, b)),
        (Value::Cycles(a), Value::Cycles(b)) => Value::Cycles(pick(a, b)),
        _ => Value::Unknown,
    }
}

fn numbers(sign: Binary, a: Number, b: Number) -> Option<Number> {
    match sign {
        Binary::Add => a.plus(b),
        Binary::Sub => a.minus(b),
        Binary::Mul => a.times(b),
        Binary::Div => a.divided_by(b),
        Binary::Mod => a.modulo(b),
        Binary::Shl => a.shifted_left(b),
        Binary::Shr => a.shifted_right(b),
    }
}

fn some(number: Option<Number>, value: fn(Number) -> Value) -> Value {
    number.map_or(Value::Unknown, value)
}

fn repeated(text: &str, times: Number) -> Value {
    let times = times.as_whole().and_then(|times| usize::try_from(times).ok());
    let fits = times.filter(|times| times.checked_mul(text.len()).is_some_and(|length| length <= MAX_TEXT));
    fits.map_or(Value::Unknown, |times| Value::text(text.repeat(times)))
}
