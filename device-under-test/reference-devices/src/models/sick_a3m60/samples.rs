//! The position as the mean of the last samples. Manual, 3.6.13.
//!
//! The interval is not printed. The mean is calculated over shaft positions in all revolutions, so it is right at the end of the range.

use alloc::collections::VecDeque;
use alloc::vec::Vec;
use core::time::Duration;
use station::Time;

/// Time between samples; invented.
const INTERVAL: Duration = Duration::from_micros(250);
/// The highest number of samples per position.
const MOST: usize = 8;
/// Amplitude of the sensor noise in steps.
const NOISE: i64 = 4;

/// The last samples.
#[derive(Clone, Debug, Default)]
pub struct Samples {
    last: Option<Time>,
    /// The samples before the present one, oldest first.
    earlier: VecDeque<i64>,
    present: i64,
}

impl Samples {
    /// Restarts without earlier samples.
    pub fn restart(&mut self) {
        *self = Samples::default();
    }

    /// Takes samples up to `now`; `read` returns the reading of the sensor at a time.
    pub fn take(&mut self, now: Time, read: impl Fn(Time) -> i64) {
        let mut next = match self.last {
            Some(last) if now.since(last) <= INTERVAL * MOST as u32 => last + INTERVAL,
            // After a long time only the last samples are needed.
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

    /// Returns the last `count` samples or fewer, the present one first.
    pub fn last(&self, count: usize) -> impl Iterator<Item = i64> + Clone {
        let earlier = self.earlier.iter().rev().copied();
        core::iter::once(self.present).chain(earlier.take(count.saturating_sub(1)))
    }

    /// Returns the mean of the last `count` samples.
    pub fn mean(&self, count: usize) -> i64 {
        mean(self.last(count))
    }
}

/// The mean, rounded to the nearest step.
fn mean(places: impl Iterator<Item = i64> + Clone) -> i64 {
    let count = places.clone().count().max(1);
    // The sum nearly always fits into 64 bits, and 128-bit division is slow.
    let short = places.clone().try_fold(count as i64 / 2, i64::checked_add);
    short.map_or_else(|| long_mean(&places.collect::<Vec<_>>()), |sum| sum.div_euclid(count as i64))
}

fn long_mean(places: &[i64]) -> i64 {
    let count = places.len() as i128;
    let sum: i128 = places.iter().copied().map(i128::from).sum();
    (sum + count / 2).div_euclid(count) as i64
}

/// Returns the sensor noise at a time, in steps. It is pseudo-random but reproducible: a function of the time.
pub fn noise(at: Time) -> i64 {
    let mixed = at.as_nanos().wrapping_mul(0x9E37_79B9_7F4A_7C15);
    ((mixed >> 40) % (2 * NOISE as u64 + 1)) as i64 - NOISE
}
