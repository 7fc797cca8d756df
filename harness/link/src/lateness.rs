//! How punctual a wire was, counted without memory for each sample.

use station::{Duration, Time};

/// Steps in which each power of two is divided; a figure is too large by at most one in so many.
const STEPS: usize = 32;
const STEP_BITS: u32 = STEPS.trailing_zeros();
/// Every number of nanoseconds has its place.
const PLACES: usize = (64 - STEP_BITS as usize + 1) * STEPS;

/// How often which duration was seen, to 3 %.
#[derive(Clone, Debug)]
pub struct Histogram {
    counts: Box<[u64]>,
    total: u64,
    max: u64,
}

impl Default for Histogram {
    fn default() -> Histogram {
        Histogram { counts: vec![0; PLACES].into_boxed_slice(), total: 0, max: 0 }
    }
}

impl Histogram {
    /// Counts one sample.
    pub fn record(&mut self, sample: Duration) {
        let nanos = u64::try_from(sample.as_nanos()).unwrap_or(u64::MAX);
        self.counts[place(nanos)] += 1;
        self.total += 1;
        self.max = self.max.max(nanos);
    }

    /// How many samples there were.
    pub fn count(&self) -> u64 {
        self.total
    }

    /// The largest sample, exactly.
    pub fn max(&self) -> Duration {
        Duration::from_nanos(self.max)
    }

    /// The duration that the share `quantile` (from 0 to 1) of all samples did not exceed; zero without samples.
    pub fn quantile(&self, quantile: f64) -> Duration {
        let wanted = ((self.total as f64 * quantile).ceil() as u64).clamp(1, self.total.max(1));
        let mut seen = 0;
        for (place, count) in self.counts.iter().enumerate() {
            seen += count;
            if seen >= wanted {
                return Duration::from_nanos(highest(place).min(self.max));
            }
        }
        self.max()
    }

    /// What half of the samples did not exceed.
    pub fn p50(&self) -> Duration {
        self.quantile(0.5)
    }

    /// What 99 % of the samples did not exceed.
    pub fn p99(&self) -> Duration {
        self.quantile(0.99)
    }

    /// What 99.9 % of the samples did not exceed.
    pub fn p999(&self) -> Duration {
        self.quantile(0.999)
    }

    /// Forgets all samples and keeps the memory.
    pub fn reset(&mut self) {
        self.counts.fill(0);
        self.total = 0;
        self.max = 0;
    }
}

/// Small numbers have a place each; above, each power of two has [`STEPS`] places.
fn place(nanos: u64) -> usize {
    let shift = (u64::BITS - nanos.leading_zeros()).saturating_sub(STEP_BITS + 1);
    (shift as usize) * STEPS + (nanos >> shift) as usize
}

/// The largest number that has this place.
fn highest(place: usize) -> u64 {
    if place < 2 * STEPS {
        return place as u64;
    }
    let shift = (place / STEPS - 1) as u32;
    let head = (place % STEPS + STEPS) as u64;
    ((head << shift) - 1).wrapping_add(1 << shift)
}

/// How late the stations of a wire were woken, and how far apart they sent.
#[derive(Clone, Debug, Default)]
pub struct Lateness {
    wakes: Histogram,
    gaps: Histogram,
    last_sent: Vec<Option<Time>>,
}

impl Lateness {
    /// How late stations were woken: the time from a deadline to the wake.
    pub fn wakes(&self) -> &Histogram {
        &self.wakes
    }

    /// The time from one wake in which a station sent to the next wake in which the same station sent.
    pub fn gaps(&self) -> &Histogram {
        &self.gaps
    }

    /// Forgets everything.
    pub fn reset(&mut self) {
        self.wakes.reset();
        self.gaps.reset();
        self.last_sent.fill(None);
    }

    pub(crate) fn woken(&mut self, deadline: Time, now: Time) {
        self.wakes.record(now.since(deadline));
    }

    pub(crate) fn sent(&mut self, station: usize, now: Time) {
        if self.last_sent.len() <= station {
            self.last_sent.resize(station + 1, None);
        }
        if let Some(before) = self.last_sent[station].replace(now) {
            self.gaps.record(now.since(before));
        }
    }

    /// The clock starts anew, so gaps do not reach across; the samples stay.
    pub(crate) fn clock_restarts(&mut self) {
        self.last_sent.fill(None);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_duration_has_a_place_that_is_right_to_three_percent() {
        let mut before = 0;
        let edges = (0..64).flat_map(|bit| [(1_u64 << bit) - 1, 1 << bit, (1 << bit) + 1, (1 << bit) / 3 * 4]);
        let mut samples: Vec<u64> = edges.chain([u64::MAX]).collect();
        samples.sort_unstable();
        for nanos in samples {
            let place = place(nanos);
            assert!(place >= before && place < PLACES, "{nanos} has place {place}");
            let most = highest(place);
            assert!(most >= nanos && (most - nanos) as f64 <= nanos as f64 * 0.032, "{nanos} is shown as {most}");
            assert_eq!(self::place(most), place);
            assert!(most == u64::MAX || self::place(most + 1) == place + 1);
            before = place;
        }
    }

    #[test]
    fn quantiles_are_those_of_the_samples() {
        let mut histogram = Histogram::default();
        assert_eq!((histogram.count(), histogram.p50(), histogram.max()), (0, Duration::ZERO, Duration::ZERO));
        for micros in 1..=1000 {
            histogram.record(Duration::from_micros(micros));
        }
        let close = |found: Duration, wanted: u64| {
            let wanted = Duration::from_micros(wanted);
            assert!(found >= wanted && found <= wanted + wanted / 31, "{found:?} for {wanted:?}");
        };
        close(histogram.p50(), 500);
        close(histogram.p99(), 990);
        close(histogram.p999(), 999);
        close(histogram.quantile(0.0), 1);
        assert_eq!(histogram.quantile(1.0), Duration::from_millis(1), "the largest is exact");
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
