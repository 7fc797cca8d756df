//! The position as the mean of the last samples. Manual, 3.6.13.
//!
//! The interval is not printed. The mean is that of places over all revolutions, so that it is right over the range end.

use super::knobs::Rules;
use alloc::collections::VecDeque;
use core::time::Duration;
use station::Time;

/// From sample to sample; invented.
const INTERVAL: Duration = Duration::from_micros(250);
/// The most samples that make a position.
const MOST: usize = 8;
/// By how many steps a sensor with noise is beside the place.
const NOISE: i64 = 4;

/// The samples before the present one.
#[derive(Clone, Debug, Default)]
pub struct Samples {
    last: Option<Time>,
    places: VecDeque<i64>,
}

impl Samples {
    /// Begins anew: what was seen before does not count.
    pub fn restart(&mut self) {
        *self = Samples::default();
    }

    /// Where the sensor sees the shaft at `now`: the mean of `count` samples, of which the present one is the last.
    pub fn place(
        &mut self,
        now: Time,
        count: usize,
        shaft: impl Fn(Time) -> i64,
        has_noise: bool,
        rules: &Rules,
    ) -> i64 {
        let seen = |at: Time| shaft(at) + if has_noise { scatter(at, rules) } else { 0 };
        self.take(now, &seen);
        let earlier = self.places.iter().rev().take(count.saturating_sub(1));
        let mut all = [seen(now); MOST + 1];
        let count = all.iter_mut().zip(earlier).map(|(place, earlier)| *place = *earlier).count();
        (rules.mean)(&all[..=count])
    }

    fn take(&mut self, now: Time, seen: &impl Fn(Time) -> i64) {
        let mut next = match self.last {
            Some(last) if now.since(last) <= INTERVAL * MOST as u32 => last + INTERVAL,
            // After a long time only the last samples count.
            Some(last) => {
                let interval = INTERVAL.as_nanos() as u64;
                let passed = (now.as_nanos() - last.as_nanos()) / interval;
                last + Duration::from_nanos(interval * (passed - MOST as u64).max(1))
            }
            None => now,
        };
        while next <= now {
            self.places.push_back(seen(next));
            self.last = Some(next);
            next += INTERVAL;
        }
        self.places.drain(..self.places.len().saturating_sub(MOST));
    }
}

/// The mean, rounded to the nearest.
pub fn mean(places: &[i64]) -> i64 {
    let count = places.len().max(1);
    // Nearly always the sum is short, and dividing long numbers is slow.
    let short = places.iter().try_fold(count as i64 / 2, |sum, place| sum.checked_add(*place));
    short.map_or_else(|| long_mean(places, count as i128), |sum| sum.div_euclid(count as i64))
}

fn long_mean(places: &[i64], count: i128) -> i64 {
    let sum: i128 = places.iter().copied().map(i128::from).sum();
    (sum + count / 2).div_euclid(count) as i64
}

/// By how much a sensor with noise is beside the place.
pub fn scatter(at: Time, rules: &Rules) -> i64 {
    (rules.noise)(noise(at))
}

/// A number of steps that looks like chance and is the same at the same time.
fn noise(at: Time) -> i64 {
    let mixed = at.as_nanos().wrapping_mul(0x9E37_79B9_7F4A_7C15);
    ((mixed >> 40) % (2 * NOISE as u64 + 1)) as i64 - NOISE
}
