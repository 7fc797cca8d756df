//! Timing statistics of a wire, in histograms of constant size.

use station::{Duration, Time};

/// Buckets per power of two; a value read from the histogram is too large by at most 1/32.
const STEPS: usize = 32;
const STEP_BITS: u32 = STEPS.trailing_zeros();
/// Buckets for all 64-bit numbers of nanoseconds.
const BUCKETS: usize = (64 - STEP_BITS as usize + 1) * STEPS;

/// A histogram of durations, with an error of at most 3 %.
#[derive(Clone, Debug)]
pub struct Histogram {
    counts: Box<[u64]>,
    total: u64,
    max: u64,
}

impl Default for Histogram {
    fn default() -> Histogram {
        Histogram { counts: vec![0; BUCKETS].into_boxed_slice(), total: 0, max: 0 }
    }
}

impl Histogram {
    /// Counts one sample.
    pub fn record(&mut self, sample: Duration) {
        let nanos = u64::try_from(sample.as_nanos()).unwrap_or(u64::MAX);
        self.counts[bucket(nanos)] += 1;
        self.total += 1;
        self.max = self.max.max(nanos);
    }

    /// Counts all samples of another histogram, too.
    pub fn add(&mut self, other: &Histogram) {
        self.counts.iter_mut().zip(&other.counts).for_each(|(count, more)| *count += more);
        self.total += other.total;
        self.max = self.max.max(other.max);
    }

    /// The number of samples.
    pub fn count(&self) -> u64 {
        self.total
    }

    /// The largest sample; exact.
    pub fn max(&self) -> Duration {
        Duration::from_nanos(self.max)
    }

    /// The duration that the share `quantile` (from 0 to 1) of all samples did not exceed; zero without samples.
    pub fn quantile(&self, quantile: f64) -> Duration {
        let rank = ((self.total as f64 * quantile).ceil() as u64).clamp(1, self.total.max(1));
        let mut sum = 0;
        for (bucket, count) in self.counts.iter().enumerate() {
            sum += count;
            if sum >= rank {
                return Duration::from_nanos(largest_in(bucket).min(self.max));
            }
        }
        self.max()
    }

    /// The median.
    pub fn p50(&self) -> Duration {
        self.quantile(0.5)
    }

    /// The 99 % quantile.
    pub fn p99(&self) -> Duration {
        self.quantile(0.99)
    }

    /// The 99.9 % quantile.
    pub fn p999(&self) -> Duration {
        self.quantile(0.999)
    }

    /// Removes all samples and keeps the allocated memory.
    pub fn reset(&mut self) {
        self.counts.fill(0);
        self.total = 0;
        self.max = 0;
    }
}

/// The bucket of `nanos`: one for each number below `2 * STEPS`, above that [`STEPS`] for each power of two.
fn bucket(nanos: u64) -> usize {
    let shift = (u64::BITS - nanos.leading_zeros()).saturating_sub(STEP_BITS + 1);
    (shift as usize) * STEPS + (nanos >> shift) as usize
}

/// The largest number that falls into `bucket`.
fn largest_in(bucket: usize) -> u64 {
    if bucket < 2 * STEPS {
        return bucket as u64;
    }
    let shift = (bucket / STEPS - 1) as u32;
    let head = (bucket % STEPS + STEPS) as u64;
    ((head << shift) - 1).wrapping_add(1 << shift)
}

/// How late the stations of a wire were woken, and the intervals at which they sent.
#[derive(Clone, Debug, Default)]
pub struct Lateness {
    wakes: Histogram,
    gaps: Histogram,
    last_sent: Vec<Option<Time>>,
    /// The longest time by which a deadline was over when a frame was delivered.
    overdue: Duration,
}

impl Lateness {
    /// The time from the deadline of a station to its wake.
    pub fn wakes(&self) -> &Histogram {
        &self.wakes
    }

    /// The time between two consecutive wakes in which the same station sent.
    pub fn gaps(&self) -> &Histogram {
        &self.gaps
    }

    /// The longest time by which a station was or will be woken late, as far as it is known.
    pub fn longest(&self) -> Duration {
        self.wakes.max().max(self.overdue)
    }

    /// Removes all samples.
    pub fn reset(&mut self) {
        self.overdue = Duration::ZERO;
        self.wakes.reset();
        self.gaps.reset();
        self.last_sent.fill(None);
    }

    pub(crate) fn woken(&mut self, deadline: Time, now: Time) {
        self.wakes.record(now.since(deadline));
    }

    /// Notes a deadline that may be over at `now`.
    pub(crate) fn overdue(&mut self, deadline: Time, now: Time) {
        self.overdue = self.overdue.max(now.since(deadline));
    }

    pub(crate) fn sent(&mut self, station: usize, now: Time) {
        if self.last_sent.len() <= station {
            self.last_sent.resize(station + 1, None);
        }
        if let Some(before) = self.last_sent[station].replace(now) {
            self.gaps.record(now.since(before));
        }
    }

    /// Handles a restart of the clock: no gap spans it; the samples stay.
    pub(crate) fn clock_restarts(&mut self) {
        self.last_sent.fill(None);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bucket_of_each_duration_is_right_to_three_percent() {
        let mut before = 0;
        let edges = (0..64).flat_map(|bit| [(1_u64 << bit) - 1, 1 << bit, (1 << bit) + 1, (1 << bit) / 3 * 4]);
        let mut samples: Vec<u64> = edges.chain([u64::MAX]).collect();
        samples.sort_unstable();
        for nanos in samples {
            let bucket = bucket(nanos);
            assert!(bucket >= before && bucket < BUCKETS, "{nanos} is in bucket {bucket}");
            let most = largest_in(bucket);
            assert!(most >= nanos && (most - nanos) as f64 <= nanos as f64 * 0.032, "{nanos} is read as {most}");
            assert_eq!(self::bucket(most), bucket);
            assert!(most == u64::MAX || self::bucket(most + 1) == bucket + 1);
            before = bucket;
        }
    }

    #[test]
    fn quantiles_are_those_of_the_samples() {
        let mut histogram = Histogram::default();
        assert_eq!((histogram.count(), histogram.p50(), histogram.max()), (0, Duration::ZERO, Duration::ZERO));
        for micros in 1..=1000 {
            histogram.record(Duration::from_micros(micros));
        }
        let close = |observed: Duration, expected: u64| {
            let expected = Duration::from_micros(expected);
            assert!(
                observed >= expected && observed <= expected + expected / 31,
                "expected {expected:?}, observed {observed:?}"
            );
        };
        close(histogram.p50(), 500);
        close(histogram.p99(), 990);
        close(histogram.p999(), 999);
        close(histogram.quantile(0.0), 1);
        assert_eq!(histogram.quantile(1.0), Duration::from_millis(1), "the maximum is exact");
        histogram.record(Duration::MAX);
        assert_eq!(histogram.max(), Duration::from_nanos(u64::MAX));
        histogram.reset();
        assert_eq!((histogram.count(), histogram.p999()), (0, Duration::ZERO));
    }

    #[test]
    fn gaps_are_counted_for_each_station_and_not_across_a_restart() {
        let mut lateness = Lateness::default();
        let at = |millis| Time::ZERO + Duration::from_millis(millis);
        lateness.sent(1, at(1));
        lateness.sent(0, at(2));
        lateness.sent(1, at(11));
        assert_eq!((lateness.gaps().count(), lateness.gaps().max()), (1, Duration::from_millis(10)));
        lateness.clock_restarts();
        lateness.sent(1, at(0));
        assert_eq!(lateness.gaps().count(), 1);
    }
}
