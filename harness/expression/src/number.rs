//! Exact rational numbers. Nothing is rounded and nothing wraps.

use serde::{Deserialize, Serialize};
use std::cmp::Ordering;
use std::fmt;

/// An exact number.
///
/// Range: numerator and denominator below 2^127 in magnitude, always in lowest terms. Operations that leave this range return
/// `None`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize)]
pub struct Number {
    over: i128,
    under: i128,
}

impl Number {
    /// Zero.
    pub const ZERO: Number = Number { over: 0, under: 1 };

    /// The quotient `over / under` in lowest terms, or `None` if `under` is 0 or a part leaves the range.
    pub fn new(over: i128, under: i128) -> Option<Number> {
        if under == 0 || over == i128::MIN || under == i128::MIN {
            return None;
        }
        let divisor = gcd(over.unsigned_abs(), under.unsigned_abs()) as i128;
        let divisor = if under < 0 { -divisor } else { divisor };
        Some(Number { over: over / divisor, under: under / divisor })
    }

    /// The whole number `value`; `i128::MIN`, which cannot be negated, becomes `-i128::MAX`.
    pub const fn whole(value: i128) -> Number {
        Number { over: if value == i128::MIN { -i128::MAX } else { value }, under: 1 }
    }

    /// Its value if it has no fraction.
    pub const fn as_whole(self) -> Option<i128> {
        if self.under == 1 { Some(self.over) } else { None }
    }

    /// The nearest floating-point number, for values that the stand sets.
    pub fn to_f64(self) -> f64 {
        self.over as f64 / self.under as f64
    }

    /// Whether it has no fraction.
    pub const fn is_whole(self) -> bool {
        self.under == 1
    }

    /// Whether it is below zero.
    pub const fn is_negative(self) -> bool {
        self.over < 0
    }

    /// The sum; `None` if out of range.
    pub fn plus(self, rhs: Number) -> Option<Number> {
        if self.under == 1 && rhs.under == 1 {
            return in_range(self.over.checked_add(rhs.over)?);
        }
        let left = self.over.checked_mul(rhs.under)?;
        let right = rhs.over.checked_mul(self.under)?;
        Number::new(left.checked_add(right)?, self.under.checked_mul(rhs.under)?)
    }

    /// The difference; `None` if out of range.
    pub fn minus(self, rhs: Number) -> Option<Number> {
        self.plus(rhs.negated())
    }

    /// The product; `None` if out of range.
    pub fn times(self, rhs: Number) -> Option<Number> {
        if self.under == 1 && rhs.under == 1 {
            return in_range(self.over.checked_mul(rhs.over)?);
        }
        // Reducing crosswise first avoids an overflow where the product itself is in range.
        let a = Number::new(self.over, rhs.under)?;
        let b = Number::new(rhs.over, self.under)?;
        Number::new(a.over.checked_mul(b.over)?, a.under.checked_mul(b.under)?)
    }

    /// The exact quotient; `None` if `rhs` is 0 or the result is out of range.
    pub fn divided_by(self, rhs: Number) -> Option<Number> {
        self.times(Number::new(rhs.under, rhs.over)?)
    }

    /// The remainder of a division by `rhs`: from 0 up to, not including, the magnitude of `rhs`.
    ///
    /// `None` if `rhs` is 0 or the result is out of range.
    pub fn modulo(self, rhs: Number) -> Option<Number> {
        if self.under == 1 && rhs.under == 1 {
            return Some(Number::whole(self.over.checked_rem_euclid(rhs.over)?));
        }
        let rhs = rhs.abs();
        self.minus(rhs.times(self.divided_by(rhs)?.floor())?)
    }

    /// `self` times 2 to the power `by`; `None` if `self` has a fraction, `by` is not 0 to 127, or the result is out of range.
    pub fn shifted_left(self, by: Number) -> Option<Number> {
        self.as_whole()?;
        self.times(Number::whole(1i128.checked_shl(shift(by)?).filter(|&power| power > 0)?))
    }

    /// `self` divided by 2 to the power `by`, rounded down; `None` as in [`Number::shifted_left`].
    pub fn shifted_right(self, by: Number) -> Option<Number> {
        Some(Number::whole(self.as_whole()?.checked_shr(shift(by)?)?))
    }

    /// The negated value.
    pub const fn negated(self) -> Number {
        Number { over: -self.over, under: self.under }
    }

    /// The absolute value.
    pub const fn abs(self) -> Number {
        Number { over: self.over.abs(), under: self.under }
    }

    /// The largest whole number that is not above it.
    pub const fn floor(self) -> Number {
        Number { over: self.over.div_euclid(self.under), under: 1 }
    }

    /// The nearest whole number; halves are rounded away from zero.
    pub fn round(self) -> Number {
        let down = self.abs().floor();
        let rest = self.abs().over % self.under;
        // `rest >= under / 2`, written so that nothing overflows.
        let up = if rest >= self.under - rest && rest != 0 { 1 } else { 0 };
        let magnitude = Number { over: down.over.saturating_add(up), under: 1 };
        if self.is_negative() { magnitude.negated() } else { magnitude }
    }
}

/// The nanoseconds of `time`, saturated at `u64::MAX`.
pub(super) fn nanos(time: std::time::Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

/// A whole number without computing common divisors: most numbers are whole, and division is slow.
fn in_range(over: i128) -> Option<Number> {
    (over != i128::MIN).then_some(Number { over, under: 1 })
}

fn shift(by: Number) -> Option<u32> {
    by.as_whole().and_then(|by| u32::try_from(by).ok()).filter(|&by| by < 128)
}

fn gcd(mut a: u128, mut b: u128) -> u128 {
    if b == 1 {
        return 1;
    }
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

impl Ord for Number {
    fn cmp(&self, rhs: &Number) -> Ordering {
        if self.under == rhs.under {
            return self.over.cmp(&rhs.over);
        }
        if let (Some(left), Some(right)) = (self.over.checked_mul(rhs.under), rhs.over.checked_mul(self.under)) {
            return left.cmp(&right);
        }
        // Too large to multiply: compare the whole parts, then invert the fractions and compare those.
        let (mut left, mut right, mut turned) = (*self, *rhs, false);
        loop {
            let order = left.floor().over.cmp(&right.floor().over);
            let rests = (left.over.rem_euclid(left.under), right.over.rem_euclid(right.under));
            let order = match (order, rests) {
                (Ordering::Equal, (0, 0)) => Ordering::Equal,
                (Ordering::Equal, (0, _)) => Ordering::Less,
                (Ordering::Equal, (_, 0)) => Ordering::Greater,
                (Ordering::Equal, (l, r)) => {
                    left = Number { over: left.under, under: l };
                    right = Number { over: right.under, under: r };
                    turned = !turned;
                    continue;
                }
                (order, _) => order,
            };
            return if turned { order.reverse() } else { order };
        }
    }
}

impl PartialOrd for Number {
    fn partial_cmp(&self, rhs: &Number) -> Option<Ordering> {
        Some(self.cmp(rhs))
    }
}

/// Decimal if nine fractional digits are exact (`11.25`), else as a quotient (`1/3`).
impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const PLACES: u32 = 9;
        let scaled = self.abs().times(Number::whole(10i128.pow(PLACES))).and_then(Number::as_whole);
        match scaled {
            _ if self.is_whole() => write!(f, "{}", self.over),
            Some(scaled) => {
                let (before, after) = (scaled / 10i128.pow(PLACES), scaled % 10i128.pow(PLACES));
                let after = format!("{after:0width$}", width = PLACES as usize);
                let sign = if self.is_negative() { "-" } else { "" };
                write!(f, "{sign}{before}.{}", after.trim_end_matches('0'))
            }
            None => write!(f, "{}/{}", self.over, self.under),
        }
    }
}

impl From<i128> for Number {
    fn from(value: i128) -> Number {
        Number::whole(value)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    fn n(over: i128, under: i128) -> Number {
        Number::new(over, under).expect("a number of the test")
    }

    #[rstest]
    #[case(n(7, 1), n(15, 1), n(7, 1))]
    #[case(n(-1, 1), n(15, 1), n(14, 1))]
    #[case(n(-1, 1), n(-15, 1), n(14, 1))]
    #[case(n(-15, 1), n(15, 1), n(0, 1))]
    #[case(n(-1, 2), n(1, 3), n(1, 6))]
    #[case(n(5, 2), n(1, 1), n(1, 2))]
    fn modulo_is_never_negative(#[case] left: Number, #[case] right: Number, #[case] rest: Number) {
        assert_eq!(left.modulo(right), Some(rest));
    }

    #[rstest]
    #[case(n(5, 2), 2, 3)]
    #[case(n(-5, 2), -3, -3)]
    #[case(n(7, 3), 2, 2)]
    #[case(n(8, 3), 2, 3)]
    #[case(n(-1, 3), -1, 0)]
    #[case(n(4, 1), 4, 4)]
    fn floor_rounds_down_and_round_to_the_nearest(#[case] of: Number, #[case] floor: i128, #[case] round: i128) {
        assert_eq!(of.floor(), Number::whole(floor));
        assert_eq!(of.round(), Number::whole(round));
    }

    #[test]
    fn results_out_of_range_are_none() {
        let most = Number::whole(i128::MAX);
        assert_eq!(most.plus(n(1, 1)), None);
        assert_eq!(most.negated().minus(n(1, 1)), None);
        assert_eq!(most.times(n(2, 1)), None);
        assert_eq!(n(1, i128::MAX).plus(n(1, 2)), None);
        assert_eq!(n(1, 1).divided_by(Number::ZERO), None);
        assert_eq!(n(1, 1).modulo(Number::ZERO), None);
        assert_eq!(n(1, 1).shifted_left(n(127, 1)), None);
        assert_eq!(n(1, 1).shifted_left(n(126, 1)), Some(Number::whole(1 << 126)));
        assert_eq!(n(1, 1).shifted_left(n(-1, 1)), None);
        assert_eq!(n(-5, 1).shifted_right(n(1, 1)), Some(n(-3, 1)));
        assert_eq!(n(1, 2).shifted_right(n(1, 1)), None);
        assert_eq!(Number::new(i128::MIN, 1), None);
        assert_eq!(most.times(n(1, i128::MAX)), Some(n(1, 1)));
    }

    #[rstest]
    #[case(n(1, 3), n(1, 2), Ordering::Less)]
    #[case(n(-1, 3), n(-1, 2), Ordering::Greater)]
    #[case(n(i128::MAX, 2), n(i128::MAX, 3), Ordering::Greater)]
    #[case(n(i128::MAX - 1, i128::MAX), n(i128::MAX - 2, i128::MAX - 1), Ordering::Greater)]
    #[case(n(2, i128::MAX), n(2, i128::MAX - 2), Ordering::Less)]
    #[case(n(-2, i128::MAX), n(-2, i128::MAX - 2), Ordering::Greater)]
    fn order_is_exact_even_where_products_overflow(#[case] a: Number, #[case] b: Number, #[case] order: Ordering) {
        assert_eq!(a.cmp(&b), order);
        assert_eq!(b.cmp(&a), order.reverse());
    }

    #[rstest]
    #[case(n(-45, 4), "-11.25")]
    #[case(n(1, 3), "1/3")]
    #[case(n(-12, 1), "-12")]
    #[case(n(-1, 2), "-0.5")]
    #[case(n(1, 1_000_000_000), "0.000000001")]
    fn shown_as_a_decimal_if_that_is_exact(#[case] number: Number, #[case] shown: &str) {
        assert_eq!(number.to_string(), shown);
    }
}
