//! The times of the frames that findings name.

use super::super::clock::CaptureClock;
use rustc_hash::FxHashMap;
use station::Time;

/// Upper limit of the frames whose time is remembered exactly.
const MOST: usize = 100_000;
/// Upper limit of the sampled frames; then every second one is dropped.
const MOST_SAMPLES: usize = 16_384;

/// The times of the noted frames, and of every n-th frame for the others.
#[derive(Debug, Default)]
pub(crate) struct FrameTimes {
    pub clock: CaptureClock,
    noted: FxHashMap<u64, Time>,
    samples: Vec<(u64, Time)>,
    /// Every frame whose number has none of these bits is sampled.
    mask: u64,
}

impl FrameTimes {
    /// Takes in a frame.
    #[inline]
    pub fn take(&mut self, number: u64, time: Time) {
        self.clock.take(time);
        if number & self.mask == 0 {
            self.sample(number, time);
        }
    }

    #[cold]
    fn sample(&mut self, number: u64, time: Time) {
        self.samples.push((number, time));
        if self.samples.len() >= MOST_SAMPLES {
            self.mask = self.mask << 1 | 1;
            let mask = self.mask;
            self.samples.retain(|(number, _)| number & mask == 0);
        }
    }

    /// Remembers the time of a frame.
    pub fn note(&mut self, number: u64, time: Time) {
        if self.noted.len() < MOST {
            self.noted.insert(number, time);
        }
    }

    /// The time of a frame; of one that was not noted the time of the last sampled frame before it.
    pub fn of(&self, number: u64) -> Option<Time> {
        self.noted.get(&number).copied().or_else(|| {
            let after = self.samples.partition_point(|(of, _)| *of <= number);
            Some(self.samples.get(after.checked_sub(1)?)?.1)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noted_frames_have_their_time_and_others_about_theirs() {
        let mut times = FrameTimes::default();
        for number in 1..=100_000 {
            times.take(number, Time::from_nanos(number * 10));
            if number == 50_001 {
                times.note(number, Time::from_nanos(number * 10));
            }
        }
        assert_eq!(times.of(50_001), Some(Time::from_nanos(500_010)));
        let about = times.of(70_003).map_or(0, Time::as_nanos);
        assert!(about <= 700_030 && about + 200 > 700_030, "{about}");
        assert!(times.samples.len() < MOST_SAMPLES);
    }
}
