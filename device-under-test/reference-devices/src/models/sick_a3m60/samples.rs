//! The position as the mean of the last samples. Manual, 3.6.13.
//!
//! The interval is not printed. The mean is that of places over all revolutions, so that it is right over the range end.

use alloc::collections::VecDeque;
use alloc::vec::Vec;
use core::time::Duration;
use station::Time;

/// From sample to sample; invented.
const INTERVAL: Duration = Duration::from_micros(250);
/// The most samples that make a position.
const MOST: usize = 8;
/// By how many steps a sensor with noise is beside the place.
const NOISE: i64 = 4;

/// The last samples.
#[derive(Clone, Debug, Default)]
pub struct Samples {
    last: Option<Time>,
    /// Those before the present one, oldest first.
    earlier: VecDeque<i64>,
    present: i64,
}

impl Samples {
    /// Begins anew: earlier samples do not count.
    pub fn restart(&mut self) {
        *self = Samples::default();
    }

    /// Takes samples up to `now`, of what the sensor reads at an instant.
    pub fn take(&mut self, now: Time, read: impl Fn(Time) -> i64) {
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
            self.earlier.push_back(read(next));
            self.last = Some(next);
            next += INTERVAL;
        }
        self.earlier.drain(..self.earlier.len().saturating_sub(MOST));
        self.present = read(now);
    }

    /// The last `count` samples, or as many as there are; the present one is the first.
    pub fn last(&self, count: usize) -> impl Iterator<Item = i64> + Clone {
        let earlier = self.earlier.iter().rev().copied();
        core::iter::once(self.present).chain(earlier.take(count.saturating_sub(1)))
    }

    /// The mean of the last `count` samples.
    pub fn mean(&self, count: usize) -> i64 {
        mean(self.last(count))
    }
}

/// The mean, rounded to the nearest.
fn mean(places: impl Iterator<Item = i64> + Clone) -> i64 {
    let count = places.clone().count().max(1);
    // Nearly always the sum is short, and dividing long numbers is slow.
    let short = places.clone().try_fold(count as i64 / 2, i64::checked_add);
    short.map_or_else(|| long_mean(&places.collect::<Vec<_>>()), |sum| sum.div_euclid(count as i64))
}

fn long_mean(places: &[i64]) -> i64 {
    let count = places.len() as i128;
    let sum: i128 = places.iter().copied().map(i128::from).sum();
    (sum + count / 2).div_euclid(count) as i64
}

/// By how many steps a sensor with noise is beside the place: it looks like chance and is the same at the same time.
pub fn noise(at: Time) -> i64 {
    let mixed = at.as_nanos().wrapping_mul(0x9E37_79B9_7F4A_7C15);
    ((mixed >> 40) % (2 * NOISE as u64 + 1)) as i64 - NOISE
}
