//! Compares two values: exactly, around a circle, within a tolerance; the result is three-valued.

use super::{CircularPosition, Number, Value};
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;

/// The operators that compare the order of two values.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum OrderOperator {
    /// `<`
    Less,
    /// `<=`
    LessEqual,
    /// `>`
    Greater,
    /// `>=`
    GreaterEqual,
}

/// Whether `observed` is equal to `expected`; `None` if either is unknown or their types cannot be compared.
///
/// `tolerance` is a number, a number of steps, or nanoseconds. `noise` is the bench's `position_noise`, 0 for values that do
/// not depend on positions; it widens comparisons with and without a tolerance, but not those of a
/// [code](CircularPosition::is_code). Both are measured around the circle if both positions lie on it; a position outside its circle is
/// compared as received and without tolerance.
pub fn equal(observed: &Value, expected: &Value, tolerance: Option<Number>, noise: u32) -> Option<bool> {
    let noise = if is_code(observed) || is_code(expected) { 0 } else { noise };
    match (observed, expected) {
        (Value::Unknown, _) | (_, Value::Unknown) => None,
        (Value::Number(a), Value::Number(b)) => near(*a, *b, tolerance, noise),
        (Value::Bit(a), Value::Bit(b)) => Some(a == b),
        (Value::Bit(bit), Value::Number(number)) | (Value::Number(number), Value::Bit(bit)) => {
            Some(number.as_whole() == Some(i128::from(*bit)))
        }
        (Value::Place(a), Value::Place(b)) => same_place(*a, b.at, a.steps().or(b.steps()), tolerance, noise),
        (Value::Place(place), Value::Number(number)) | (Value::Number(number), Value::Place(place)) => {
            number.as_whole().map_or(Some(false), |at| same_place(*place, at, place.steps(), tolerance, noise))
        }
        (Value::Time(a), Value::Time(b)) | (Value::Cycles(a), Value::Cycles(b)) => near(*a, *b, tolerance, 0),
        (Value::Word(a), Value::Word(b)) => Some(a == b),
        (Value::Text(a), Value::Text(b)) => Some(a == b),
        (Value::Bytes(a), Value::Bytes(b)) => Some(a == b),
        (Value::Bytes(octets), Value::Pattern(pattern)) | (Value::Pattern(pattern), Value::Bytes(octets)) => {
            Some(pattern.matches(octets))
        }
        (Value::Address(a), Value::Address(b)) => Some(a == b),
        (Value::Set(a), Value::Set(b)) => Some(a == b),
        _ => None,
    }
}

/// Whether `left` and `right` are in this order; `None` if either is unknown or they have no order.
///
/// A position on its circle counts as every position up to `noise` steps around it, a [code](CircularPosition::is_code) as itself only,
/// so noise never turns true into false. On an unknown circle noise may lead through 0, so that what it does not make true stays open.
pub fn order(sign: OrderOperator, left: &Value, right: &Value, noise: u32) -> Option<bool> {
    let noise = if is_code(left) || is_code(right) { 0 } else { noise };
    if noise > 0 && (is_on_unknown_circle(left) || is_on_unknown_circle(right)) {
        let straight = |value: &Value| {
            if is_on_unknown_circle(value) { value.as_whole().map(Value::whole) } else { Some(value.clone()) }
        };
        return order(sign, &straight(left)?, &straight(right)?, noise).filter(|holds| *holds);
    }
    let (low, high) = match (left, right) {
        (Value::Time(a), Value::Time(b)) | (Value::Cycles(a), Value::Cycles(b)) => return Some(sign.holds(a.cmp(b))),
        // Noise is applied once: to the left side if possible, else to the right side.
        (Value::Number(_), Value::Place(_)) => (reach(left, 0)?, reach(right, noise)?),
        _ => (reach(left, noise)?, reach(right, 0)?),
    };
    Some(match sign {
        OrderOperator::Less | OrderOperator::LessEqual => sign.holds(low.0.cmp(&high.1)),
        OrderOperator::Greater | OrderOperator::GreaterEqual => sign.holds(low.1.cmp(&high.0)),
    })
}

impl OrderOperator {
    /// Whether operands in this order satisfy the operator.
    pub(super) fn holds(self, order: Ordering) -> bool {
        match self {
            OrderOperator::Less => order == Ordering::Less,
            OrderOperator::LessEqual => order != Ordering::Greater,
            OrderOperator::Greater => order == Ordering::Greater,
            OrderOperator::GreaterEqual => order != Ordering::Less,
        }
    }
}

fn near(a: Number, b: Number, tolerance: Option<Number>, noise: u32) -> Option<bool> {
    match (tolerance, noise) {
        (None, 0) => Some(a == b),
        _ => Some(a.minus(b)?.abs() <= width(tolerance, noise)?),
    }
}

fn same_place(
    place: CircularPosition,
    at: i128,
    steps: Option<i128>,
    tolerance: Option<Number>,
    noise: u32,
) -> Option<bool> {
    if tolerance.is_none() && (noise == 0 || place.at == at) {
        return Some(place.at == at);
    }
    let width = width(tolerance, noise)?;
    let Some(steps) = steps else {
        // However many steps the circle has, the other way around leads through 0.
        let apart = Number::whole((place.at - at).abs());
        return if apart <= width { Some(true) } else { (Number::whole(place.at.min(at)) >= width).then_some(false) };
    };
    let circle = 0..steps;
    if !circle.contains(&place.at) || !circle.contains(&at) {
        return Some(false);
    }
    let ahead = (place.at - at).rem_euclid(steps);
    Some(Number::whole(ahead.min(steps - ahead)) <= width)
}

fn width(tolerance: Option<Number>, noise: u32) -> Option<Number> {
    tolerance.unwrap_or(Number::ZERO).plus(Number::whole(noise.into()))
}

fn is_code(value: &Value) -> bool {
    matches!(value, Value::Place(CircularPosition { is_code: true, .. }))
}

fn is_on_unknown_circle(value: &Value) -> bool {
    matches!(value, Value::Place(place) if place.range.is_none())
}

/// The smallest and the largest number that `value` may represent.
fn reach(value: &Value, noise: u32) -> Option<(Number, Number)> {
    let noise = i128::from(noise);
    match value {
        Value::Number(number) => Some((number.minus(Number::whole(noise))?, number.plus(Number::whole(noise))?)),
        Value::Place(place) => {
            let (low, high) = match (place.steps(), place.circle()) {
                _ if noise == 0 => (place.at, place.at),
                (None, _) => return None,
                (Some(_), None) => (place.at, place.at),
                (_, Some(steps)) if place.at < noise || place.at + noise >= steps => (0, steps - 1),
                (_, Some(_)) => (place.at - noise, place.at + noise),
            };
            Some((Number::whole(low), Number::whole(high)))
        }
        _ => None,
    }
}
