//! The types of names and expressions.

use super::{Circle, WordTable};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::Arc;

/// What kind of value a name or an expression has.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Type {
    /// A number.
    Number(NumberType),
    /// A bit or the outcome of a condition; it may stand alone as a condition.
    Bit,
    /// A place on a circle, in steps from its zero.
    Place(Circle),
    /// A duration in time.
    Time,
    /// A number of bus cycles, which is no time.
    Cycles,
    /// A text.
    Text,
    /// Octets.
    Bytes,
    /// An IPv4 address.
    Address,
    /// A word of a table.
    Word(#[serde(with = "super::pool::table")] Arc<WordTable>),
    /// A set of words of a table; order is free, and a word may be in it more than once.
    Set(#[serde(with = "super::pool::table")] Arc<WordTable>),
}

/// What is known about a number before it is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct NumberType {
    /// It has no fraction; what has one goes through `floor` or `round` before it meets this number.
    pub whole: bool,
    /// It was computed from places, so a comparison with it gets the bench's `position_noise`.
    pub steps: bool,
    /// The smallest and the largest value that the name can hold; a literal outside is an error.
    pub limits: Option<(i128, i128)>,
}

impl NumberType {
    /// A whole number of any size.
    pub const WHOLE: NumberType = NumberType { whole: true, steps: false, limits: None };
    /// A number with a fraction.
    pub const FRACTION: NumberType = NumberType { whole: false, steps: false, limits: None };
}

impl Type {
    /// A whole number of any size.
    pub const WHOLE: Type = Type::Number(NumberType::WHOLE);
    /// A number with a fraction.
    pub const FRACTION: Type = Type::Number(NumberType::FRACTION);

    /// The type of a whole number that is `width` bits wide (1 to 64), two's complement if `signed`.
    pub fn whole(width: u32, signed: bool) -> Type {
        let width = width.clamp(1, 64);
        let limits = match signed {
            true => (-(1i128 << (width - 1)), (1i128 << (width - 1)) - 1),
            false => (0, (1i128 << width) - 1),
        };
        Type::Number(NumberType { limits: Some(limits), ..NumberType::WHOLE })
    }

    /// Whether a comparison with a value of this type gets the bench's `position_noise`.
    pub(super) fn is_noisy(&self) -> bool {
        matches!(self, Type::Place(_) | Type::Number(NumberType { steps: true, .. }))
    }
}

/// As it is named in messages, with its article: `a whole number`, `a word of switch`.
impl fmt::Display for Type {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Type::Number(NumberType { whole: true, .. }) => "a whole number",
            Type::Number(_) => "a number with a fraction",
            Type::Bit => "a bit",
            Type::Place(_) => "a place on a circle",
            Type::Time => "a duration",
            Type::Cycles => "a number of cycles",
            Type::Text => "a text",
            Type::Bytes => "bytes",
            Type::Address => "an address",
            Type::Word(table) => return write!(f, "a word of `{}`", table.name),
            Type::Set(table) => return write!(f, "a set of words of `{}`", table.name),
        })
    }
}
