//! The types of names and expressions.

use super::{Circle, WordTable};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::sync::Arc;

/// The type of a name or an expression.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Type {
    Number(NumberType),
    /// A bit or the result of a condition; it can be used as a condition without a comparison.
    Bit,
    /// A position on a circle, in steps from its zero.
    Place(Circle),
    Time,
    /// A number of bus cycles, which is not a duration.
    Cycles,
    Text,
    /// Bytes.
    Bytes,
    /// An IPv4 address.
    Address,
    /// A word of a table.
    Word(#[serde(with = "super::pool::table")] Arc<WordTable>),
    /// Words of a table in any order; a word may occur more than once.
    Set(#[serde(with = "super::pool::table")] Arc<WordTable>),
}

/// Properties of a number that are known at compile time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct NumberType {
    /// It has no fraction; a value with a fraction needs `floor` or `round` before it is compared with this number.
    pub whole: bool,
    /// It was computed from positions, so comparisons with it get the bench's `position_noise`.
    pub steps: bool,
    /// The smallest and the largest value that the name can hold; a literal outside this range is an error.
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
        let limits =
            if signed { (-(1i128 << (width - 1)), (1i128 << (width - 1)) - 1) } else { (0, (1i128 << width) - 1) };
        Type::Number(NumberType { limits: Some(limits), ..NumberType::WHOLE })
    }

    /// Whether a comparison with a value of this type gets the bench's `position_noise`.
    pub(super) fn is_noisy(&self) -> bool {
        matches!(self, Type::Place(_) | Type::Number(NumberType { steps: true, .. }))
    }
}

/// The name of the type in messages, with its article: `a whole number`, `a word of switch`.
impl fmt::Display for Type {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Type::Number(NumberType { whole: true, .. }) => "a whole number",
            Type::Number(_) => "a number with a fraction",
            Type::Bit => "a bit",
            Type::Place(_) => "a position",
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
