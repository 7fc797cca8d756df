//! When two values are equal and which comes first: exact, around a circle, within a tolerance, three-valued.

use super::{Number, Place, Value};
use serde::{Deserialize, Serialize};
use std::cmp::Ordering;

/// The signs that ask for an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Order {
    /// `<`
    Less,
    /// `<=`
    LessEqual,
    /// `>`
    Greater,
    /// `>=`
    GreaterEqual,
}

/// Whether `seen` is equal to `wanted`; `None` if either is unknown, or if the two are no values of one kind.
///
/// `tolerance` is a number, a number of steps, or nanoseconds. `noise` is the bench's `position_noise`, 0 for values that
/// have nothing to do with places; it widens a comparison that has a tolerance and one that has none. Both are measured
/// around the circle once the two places are proved to lie on it; a place beyond its circle is compared as it came and
/// within no tolerance.
pub fn equal(seen: &Value, wanted: &Value, tolerance: Option<Number>, noise: u32) -> Option<bool> {
    match (seen, wanted) {
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

/// Whether `left` and `right` are in this order; `None` if either is unknown, or if the two have no order.
///
/// A place on its circle counts as every place up to `noise` steps around it, so that noise never turns true into false.
pub fn order(sign: Order, left: &Value, right: &Value, noise: u32) -> Option<bool> {
    let (low, high) = match (left, right) {
        (Value::Time(a), Value::Time(b)) | (Value::Cycles(a), Value::Cycles(b)) => return Some(sign.holds(a.cmp(b))),
        // The noise is given once: to the left side if it can take it, else to the right.
        (Value::Number(_), Value::Place(_)) => (reach(left, 0)?, reach(right, noise)?),
        _ => (reach(left, noise)?, reach(right, 0)?),
    };
    Some(match sign {
        Order::Less | Order::LessEqual => sign.holds(low.0.cmp(&high.1)),
        Order::Greater | Order::GreaterEqual => sign.holds(low.1.cmp(&high.0)),
    })
}

impl Order {
    /// Whether two sides that stand in this order do as the sign says.
    pub(super) fn holds(self, order: Ordering) -> bool {
        match self {
            Order::Less => order == Ordering::Less,
            Order::LessEqual => order != Ordering::Greater,
            Order::Greater => order == Ordering::Greater,
            Order::GreaterEqual => order != Ordering::Less,
        }
    }
}

fn near(a: Number, b: Number, tolerance: Option<Number>, noise: u32) -> Option<bool> {
    match (tolerance, noise) {
        (None, 0) => Some(a == b),
        _ => Some(a.minus(b)?.abs() <= width(tolerance, noise)?),
    }
}

fn same_place(place: Place, at: i128, steps: Option<i128>, tolerance: Option<Number>, noise: u32) -> Option<bool> {
    if tolerance.is_none() && (noise == 0 || place.at == at) {
        return Some(place.at == at);
    }
    let steps = steps?;
    let circle = 0..steps;
    if !circle.contains(&place.at) || !circle.contains(&at) {
        return Some(false);
    }
    let ahead = (place.at - at).rem_euclid(steps);
    Some(Number::whole(ahead.min(steps - ahead)) <= width(tolerance, noise)?)
}

fn width(tolerance: Option<Number>, noise: u32) -> Option<Number> {
    tolerance.unwrap_or(Number::ZERO).plus(Number::whole(noise.into()))
}

/// The smallest and the largest number that `value` may stand for.
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
