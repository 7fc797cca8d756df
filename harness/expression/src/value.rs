//! Values: what a name was seen to hold, and what an expression comes to.

use super::{BytePattern, Number, Type};
use plain_text::hex;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::num::NonZeroU64;
use std::sync::Arc;

/// A value.
///
/// Its [`Type`] says what it means: a word is kept as its number, so that a number without a word is kept too.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Value {
    /// Not seen, or not to be computed: neither true nor false, equal to nothing.
    Unknown,
    /// A bit, or the outcome of a condition.
    Bit(bool),
    /// A number.
    Number(Number),
    /// A place on a circle.
    Place(Place),
    /// A duration in nanoseconds.
    Time(Number),
    /// A number of bus cycles.
    Cycles(Number),
    /// A word, by its number.
    Word(i64),
    /// A text.
    Text(Arc<str>),
    /// Octets.
    Bytes(Arc<[u8]>),
    /// Octets of which some may be anything; only the wanted side of a check has it.
    Pattern(Arc<BytePattern>),
    /// An IPv4 address, as it is written.
    Address([u8; 4]),
    /// A set of words, by their numbers, in ascending order; made by [`Value::set`].
    Set(Arc<[i64]>),
}

/// A place on a circle, kept as it came: it may lie beyond the circle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct Place {
    /// Steps from zero.
    pub at: i128,
    /// The number of steps of the circle, or `None` while the parameters that make it are unknown.
    pub range: Option<NonZeroU64>,
}

impl Place {
    /// The steps of the circle if they are known.
    pub fn steps(self) -> Option<i128> {
        self.range.map(|range| i128::from(range.get()))
    }

    /// The steps of the circle if they are known and the place lies on it, from 0 to one less.
    pub fn circle(self) -> Option<i128> {
        self.steps().filter(|steps| (0..*steps).contains(&self.at))
    }

    /// The place `by` steps on, or `None` if this one does not lie on a known circle.
    pub fn moved(self, by: i128) -> Option<Place> {
        let steps = self.circle()?;
        Some(Place { at: (self.at + by.rem_euclid(steps)) % steps, range: self.range })
    }

    /// The shorter way from `from` to this place, or `None` unless both lie on the same known circle.
    ///
    /// Range: above -R/2 up to R/2, so that half a circle is always positive.
    pub fn way_from(self, from: Place) -> Option<i128> {
        let steps = self.circle()?;
        if from.circle()? != steps {
            return None;
        }
        let ahead = (self.at - from.at).rem_euclid(steps);
        Some(if ahead > steps / 2 { ahead - steps } else { ahead })
    }
}

impl Value {
    /// The whole number `value`.
    pub fn whole(value: impl Into<i128>) -> Value {
        Value::Number(Number::whole(value.into()))
    }

    /// The place `at` steps on a circle of `range` steps; a range below 1 or above 2^64 - 1 counts as unknown.
    pub fn place(at: impl Into<i128>, range: Option<i128>) -> Value {
        let range = range.and_then(|range| u64::try_from(range).ok()).and_then(NonZeroU64::new);
        Value::Place(Place { at: at.into(), range })
    }

    /// The duration of `nanos` nanoseconds.
    pub fn nanos(nanos: impl Into<i128>) -> Value {
        Value::Time(Number::whole(nanos.into()))
    }

    /// The text `text`.
    pub fn text(text: impl Into<Arc<str>>) -> Value {
        Value::Text(text.into())
    }

    /// The octets `bytes`.
    pub fn bytes(bytes: impl Into<Arc<[u8]>>) -> Value {
        Value::Bytes(bytes.into())
    }

    /// The set of these words, by their numbers; the order is free, how often a word comes is kept.
    pub fn set(words: impl IntoIterator<Item = i64>) -> Value {
        let mut words: Vec<i64> = words.into_iter().collect();
        words.sort_unstable();
        Value::Set(words.into())
    }

    /// Whether there is no value.
    pub fn is_unknown(&self) -> bool {
        matches!(self, Value::Unknown)
    }

    /// True, false, or `None` if it is unknown or no bit.
    pub fn truth(&self) -> Option<bool> {
        match self {
            Value::Bit(bit) => Some(*bit),
            _ => None,
        }
    }

    /// The whole number that a wire carries for it: a number, a bit, a word or a place.
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

/// A value of a known type, shown as a suite would write it.
pub struct Shown<'a>(pub &'a Value, pub &'a Type);

impl fmt::Display for Shown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Shown(value, ty) = self;
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

/// In the largest unit that leaves a whole number, so `200ms` stays `200ms`; a minute is shown in seconds.
fn show_time(nanos: Number, f: &mut fmt::Formatter<'_>) -> fmt::Result {
    let units = [("s", 1_000_000_000), ("ms", 1_000_000), ("us", 1_000)];
    let whole = |(unit, size)| Some((unit, nanos.divided_by(Number::whole(size)).filter(|amount| amount.is_whole())?));
    match units.into_iter().find_map(whole) {
        _ if nanos == Number::ZERO => f.write_str("0"),
        Some((unit, amount)) => write!(f, "{amount}{unit}"),
        None => write!(f, "{nanos}ns"),
    }
}
