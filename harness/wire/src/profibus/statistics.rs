//! What a master measured on its bus, in bit times: answer times, retries and the rotation of the token.
//!
//! Plain data that can be combined, for instance over all trials of a run; this module must not know how it was measured.

use super::fdl::BitTimes;
use alloc::vec::Vec;

/// The least, the mean and the greatest of a number of durations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct BitTimeRange {
    count: u64,
    least: u64,
    most: u64,
    sum: u64,
}

impl BitTimeRange {
    /// Adds one duration.
    #[inline]
    pub fn add(&mut self, BitTimes(bits): BitTimes) {
        self.merge(BitTimeRange { count: 1, least: bits, most: bits, sum: bits });
    }

    /// Adds the durations of `other`.
    #[inline]
    pub fn merge(&mut self, other: BitTimeRange) {
        if other.count == 0 {
            return;
        }
        self.least = if self.count == 0 { other.least } else { self.least.min(other.least) };
        self.most = self.most.max(other.most);
        self.count += other.count;
        self.sum = self.sum.saturating_add(other.sum);
    }

    /// A range of `count` durations with these limits and this sum, all in bit times, as a report has it.
    pub fn from_parts(count: u64, [least, most, sum]: [u64; 3]) -> BitTimeRange {
        if count == 0 { BitTimeRange::default() } else { BitTimeRange { count, least, most, sum } }
    }

    /// The sum of the durations.
    pub fn sum(&self) -> BitTimes {
        BitTimes(self.sum)
    }

    /// The number of durations.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The least duration, the mean rounded to whole bits, and the greatest; `None` without any.
    pub fn least_mean_most(&self) -> Option<[BitTimes; 3]> {
        let mean = self.sum.saturating_add(self.count / 2).checked_div(self.count)?;
        Some([self.least, mean, self.most].map(BitTimes))
    }
}

/// How one station answered the requests of the master; polls for new masters do not count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StationStatistics {
    /// The station address.
    pub station: u8,
    /// The times from the end of a request to the beginning of its answer (TSDR).
    pub answers: BitTimeRange,
    /// How many of the answers came after max TSDR.
    pub late: u64,
    /// How many requests were repeated, counting each repetition.
    pub retries: u64,
    /// How many requests had no valid answer after all retries.
    pub unanswered: u64,
}

impl StationStatistics {
    fn new(station: u8) -> StationStatistics {
        StationStatistics { station, answers: BitTimeRange::default(), late: 0, retries: 0, unanswered: 0 }
    }
}

/// What a master measured on its bus.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct BusStatistics {
    stations: Vec<StationStatistics>,
    /// The times from one token receipt to the next (TRR).
    pub rotation: BitTimeRange,
    /// The limits of the answer times in the measurements, min TSDR and max TSDR; both 0 before the first answer.
    pub tsdr: (BitTimes, BitTimes),
}

impl BusStatistics {
    /// The measurements of these stations, as a report has them.
    pub fn from_parts(
        mut stations: Vec<StationStatistics>,
        rotation: BitTimeRange,
        tsdr: (BitTimes, BitTimes),
    ) -> BusStatistics {
        stations.sort_by_key(|of| of.station);
        BusStatistics { stations, rotation, tsdr }
    }

    /// The stations that were asked, by their addresses.
    pub fn stations(&self) -> &[StationStatistics] {
        &self.stations
    }

    /// Records that `station` answered after `time`, where the `limits` are min TSDR and max TSDR.
    pub fn answered(&mut self, station: u8, time: BitTimes, limits: (BitTimes, BitTimes)) {
        let of = self.station(station);
        of.answers.add(time);
        of.late += u64::from(time > limits.1);
        self.tsdr = Self::widest(self.tsdr, limits);
    }

    /// Records that a request to `station` was repeated.
    pub fn repeated(&mut self, station: u8) {
        self.station(station).retries += 1;
    }

    /// Records that `station` did not answer a request, all retries included.
    pub fn unanswered(&mut self, station: u8) {
        self.station(station).unanswered += 1;
    }

    /// Adds what another master, or the same one at another time, measured. Of differing limits the widest remain.
    pub fn merge(&mut self, other: &BusStatistics) {
        for theirs in &other.stations {
            let own = self.station(theirs.station);
            own.answers.merge(theirs.answers);
            own.late += theirs.late;
            own.retries += theirs.retries;
            own.unanswered += theirs.unanswered;
        }
        self.rotation.merge(other.rotation);
        self.tsdr = Self::widest(self.tsdr, other.tsdr);
    }

    fn widest(one: (BitTimes, BitTimes), other: (BitTimes, BitTimes)) -> (BitTimes, BitTimes) {
        match (one, other) {
            ((_, BitTimes(0)), other) => other,
            (one, (_, BitTimes(0))) => one,
            (one, other) => (one.0.min(other.0), one.1.max(other.1)),
        }
    }

    fn station(&mut self, station: u8) -> &mut StationStatistics {
        let at = self.stations.binary_search_by_key(&station, |of| of.station).unwrap_or_else(|at| {
            self.stations.insert(at, StationStatistics::new(station));
            at
        });
        &mut self.stations[at]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: (BitTimes, BitTimes) = (BitTimes(11), BitTimes(60));

    #[test]
    fn a_range_has_the_least_the_mean_and_the_greatest() {
        let mut range = BitTimeRange::default();
        assert_eq!(range.least_mean_most(), None);
        [20, 11, 12].into_iter().for_each(|bits| range.add(BitTimes(bits)));
        // 43 / 3 is 14.3.
        assert_eq!(range.least_mean_most(), Some([BitTimes(11), BitTimes(14), BitTimes(20)]));
        range.merge(BitTimeRange::default());
        assert_eq!(range.count(), 3);
    }

    #[test]
    fn measurements_of_two_masters_are_combined_by_station() {
        let (mut one, mut other) = (BusStatistics::default(), BusStatistics::default());
        one.answered(3, BitTimes(60), LIMITS);
        other.answered(3, BitTimes(61), LIMITS);
        other.repeated(9);
        other.unanswered(9);
        other.rotation.add(BitTimes(500));
        one.merge(&other);
        assert_eq!(one.stations().iter().map(|of| of.station).collect::<Vec<_>>(), [3, 9]);
        let [three, nine] = one.stations() else { panic!("{one:?}") };
        assert_eq!((three.answers.count(), three.late, three.retries), (2, 1, 0));
        assert_eq!((nine.answers.count(), nine.retries, nine.unanswered), (0, 1, 1));
        assert_eq!((one.rotation.count(), one.tsdr), (1, LIMITS));
    }

    #[test]
    fn of_two_baud_rates_the_widest_limits_remain() {
        let mut of = BusStatistics::default();
        of.answered(3, BitTimes(30), LIMITS);
        of.answered(3, BitTimes(700), (BitTimes(11), BitTimes(800)));
        assert_eq!((of.tsdr, of.stations()[0].late), ((BitTimes(11), BitTimes(800)), 0));
    }
}
