//! Values of names and results of expressions.

use super::{BytePattern, Number, Type};
use plain_text::hex;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::num::NonZeroU64;
use std::sync::Arc;

/// A value.
///
/// Its [`Type`] defines the meaning. A word is stored as its number, so that a number without a word can be stored too.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Value {
    /// Not received or not computable: neither true nor false, equal to nothing.
    Unknown,
    /// A bit, or the result of a condition.
    Bit(bool),
    Number(Number),
    /// A position on a circle.
    Place(CircularPosition),
    /// A duration in nanoseconds.
    Time(Number),
    /// A number of bus cycles.
    Cycles(Number),
    /// A word, by its number.
    Word(i64),
    Text(Arc<str>),
    /// Bytes.
    Bytes(Arc<[u8]>),
    /// Bytes with wildcards; only the expected side of a check can have this value.
    Pattern(Arc<BytePattern>),
    /// An IPv4 address, most significant byte first.
    Address([u8; 4]),
    /// A set of words by their numbers, in ascending order; created by [`Value::set`].
    Set(Arc<[i64]>),
}

/// A position on a circle as received; it may lie outside the circle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct CircularPosition {
    /// Steps from zero.
    pub at: i128,
    /// The number of steps of the circle; `None` while the parameters that define it are unknown.
    pub range: Option<NonZeroU64>,
    /// Whether it is a code that the device shows in place of a position, so that noise of the shaft does not change it.
    pub is_code: bool,
}

impl CircularPosition {
    /// The number of steps of the circle, if it is known.
    pub fn steps(self) -> Option<i128> {
        self.range.map(|range| i128::from(range.get()))
    }

    /// The number of steps of the circle, if it is known and the position lies inside (0 to one less).
    pub fn circle(self) -> Option<i128> {
        self.steps().filter(|steps| (0..*steps).contains(&self.at))
    }

    /// The position `by` steps further; `None` if this position does not lie on a known circle.
    pub fn moved(self, by: i128) -> Option<CircularPosition> {
        let steps = self.circle()?;
        Some(CircularPosition { at: (self.at + by.rem_euclid(steps)) % steps, ..self })
    }

    /// The shorter distance from `from` to this position in steps; `None` unless both lie on the same known circle.
    ///
    /// Range: above -R/2 up to R/2 for a circle of R steps; half a circle is always positive.
    pub fn distance_from(self, from: CircularPosition) -> Option<i128> {
        let steps = self.circle()?;
        if from.circle()? != steps {
            return None;
        }
        let ahead = (self.at - from.at).rem_euclid(steps);
        Some(if ahead > steps / 2 { ahead - steps } else { ahead })
    }
}

impl Value {
    /// Makes a whole number.
    pub fn whole(value: impl Into<i128>) -> Value {
        Value::Number(Number::whole(value.into()))
    }

    /// Makes the position `at` on a circle of `range` steps; a range below 1 or above 2^64 - 1 counts as unknown.
    pub fn place(at: impl Into<i128>, range: Option<i128>) -> Value {
        let range = range.and_then(|range| u64::try_from(range).ok()).and_then(NonZeroU64::new);
        Value::Place(CircularPosition { at: at.into(), range, is_code: false })
    }

    /// Makes a code of a position, see [`CircularPosition::is_code`].
    pub fn as_code(self) -> Value {
        match self {
            Value::Place(place) => Value::Place(CircularPosition { is_code: true, ..place }),
            other => other,
        }
    }

    /// Makes a duration of `nanos` nanoseconds.
    pub fn nanos(nanos: impl Into<i128>) -> Value {
        Value::Time(Number::whole(nanos.into()))
    }

    /// Makes a text.
    pub fn text(text: impl Into<Arc<str>>) -> Value {
        Value::Text(text.into())
    }

    /// Makes a byte string.
    pub fn bytes(bytes: impl Into<Arc<[u8]>>) -> Value {
        Value::Bytes(bytes.into())
    }

    /// Makes a set of words from their numbers in any order; repeated words are kept.
    pub fn set(words: impl IntoIterator<Item = i64>) -> Value {
        let mut words: Vec<i64> = words.into_iter().collect();
        words.sort_unstable();
        Value::Set(words.into())
    }

    /// Whether the value is unknown.
    pub fn is_unknown(&self) -> bool {
        matches!(self, Value::Unknown)
    }

    /// The value of a bit; `None` if the value is unknown or not a bit.
    pub fn truth(&self) -> Option<bool> {
        match self {
            Value::Bit(bit) => Some(*bit),
            _ => None,
        }
    }

    /// The whole number that represents a number, bit, word or position on the wire.
    pub fn as_whole(&self) -> Option<i128> {
        match self {
            Value::Number(number) => number.as_whole(),
            Value::Bit(bit) => Some(i128::from(*bit)),
            Value::Word(word) => Some(i128::from(*word)),
            Value::Place(place) => Some(place.at),
            _ => None,
        }
    }

    pub(super) fn from_truth(truth: Option<bool>) -> Value {
        truth.map_or(Value::Unknown, Value::Bit)
    }
}

/// Formats a value of a known type as a suite writes it.
pub struct FormattedValue<'a>(pub &'a Value, pub &'a Type);

impl fmt::Display for FormattedValue<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let FormattedValue(value, ty) = self;
        let word = |number: &i64| match ty {
            Type::Word(table) | Type::Set(table) => table.word(*number).map(str::to_owned),
            _ => None,
        };
        let word = |number: &i64| word(number).unwrap_or_else(|| number.to_string());
        match value {
            Value::Unknown => f.write_str("unknown"),
            Value::Bit(bit) => write!(f, "{}", u8::from(*bit)),
            Value::Number(number) => write!(f, "{number}"),
            Value::Place(place) => write!(f, "{}", place.at),
            Value::Time(nanos) => show_time(*nanos, f),
            Value::Cycles(cycles) => write!(f, "{cycles} cycles"),
            Value::Word(number) => f.write_str(&word(number)),
            Value::Text(text) => write!(f, "'{text}'"),
            Value::Bytes(bytes) => f.write_str(&hex(bytes)),
            Value::Pattern(pattern) => write!(f, "{pattern}"),
            Value::Address([a, b, c, d]) => write!(f, "{a}.{b}.{c}.{d}"),
            Value::Set(words) => write!(f, "[{}]", words.iter().map(word).collect::<Vec<_>>().join(", ")),
        }
    }
}

/// Writes a duration in the largest unit that gives a whole number, so `200ms` stays `200ms`; a minute is written in seconds.
fn show_time(nanos: Number, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    let units = [("s", 1_000_000_000), ("ms", 1_000_000), ("us", 1_000)];
    let whole = |(unit, size)| Some((unit, nanos.divided_by(Number::whole(size)).filter(|amount| amount.is_whole())?));
    match units.into_iter().find_map(whole) {
        _ if nanos == Number::ZERO => f.write_str("0"),
        Some((unit, amount)) => write!(f, "{amount}{unit}"),
        None => write!(f, "{nanos}ns"),
    }
}
