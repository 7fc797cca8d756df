//! Isochronous operation: the clock of the bus, and the position at it. Manual, 3.3.3 and 3.6.7.
//!
//! The manual does not print by how much a clock may deviate and for how long it may be missing. Interpretation: three clocks in
//! time synchronize the encoder and end clock errors. Two consecutive clocks out of time are a deviating clock. No clock for more
//! than three cycles is a missing clock, at the start no clock for sixteen cycles. Whether a clock is in time is measured from the
//! clock with which the encoder synchronized, until the clock is missing.

use super::hooks::{A3m60Check, A3m60Deviations};
use core::time::Duration;
use station::Time;

/// Number of clocks in time that synchronize the encoder.
const SYNCHRONIZES: u32 = 3;
/// Number of consecutive clocks out of time that are an error.
const DEVIATES: u32 = 2;
/// Number of cycles without a clock that are an error.
const MISSES: u32 = 3;
/// Number of cycles without any clock, or of clocks out of time, that are an error before the first synchronization.
const BEGINS: u32 = 16;
/// Permitted deviation of a clock, in addition to the window of the master; invented.
const TOLERANCE: Duration = Duration::from_micros(50);

/// The times of isochronous operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IsochronousTimes {
    /// The cycle time.
    pub cycle: Duration,
    /// Half the time window in which a clock is in time.
    pub window: Duration,
    /// Whether the encoder simulates the clock.
    pub is_simulated: bool,
}

/// The errors of the clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ClockErrors {
    /// No clock is received.
    pub is_missing: bool,
    /// The clock arrives at the wrong time.
    pub is_deviating: bool,
}

/// Synchronizes with the clock of the bus.
#[derive(Clone, Copy, Debug, Default)]
pub struct BusClock {
    times: Option<IsochronousTimes>,
    since: Time,
    last: Option<Time>,
    /// The last clock that was in time.
    base: Option<Time>,
    in_time: u32,
    out_of_time: u32,
    is_synchronized: bool,
    wrong: ClockErrors,
    /// The shaft position at the last clock.
    place: Option<i64>,
}

impl BusClock {
    /// Restarts with a connection; without times the operation is not isochronous.
    pub fn begin(&mut self, now: Time, times: Option<IsochronousTimes>) {
        *self = BusClock { times, since: now, ..BusClock::default() };
    }

    /// Returns the times in force; `None` without isochronous operation.
    pub fn times(&self) -> Option<IsochronousTimes> {
        self.times
    }

    /// Returns whether the encoder is synchronized with the clock.
    pub fn is_synchronized(&self) -> bool {
        self.is_synchronized
    }

    /// Returns the errors of the clock.
    pub fn wrong(&self) -> ClockErrors {
        self.wrong
    }

    /// Returns the shaft position at the last clock; `None` while there is no clock.
    pub fn place(&self) -> Option<i64> {
        self.place
    }

    /// Notes that the stand has moved the shaft to `place`.
    pub fn put(&mut self, place: i64) {
        self.place = self.place.map(|_| place);
    }

    /// Processes a clock, with the shaft at `place`.
    pub fn tick(&mut self, now: Time, place: i64, hooks: &A3m60Deviations) {
        let Some(times) = self.times.filter(|times| !times.is_simulated) else { return };
        (self.last, self.place) = (Some(now), Some(place));
        let Some(base) = self.base else {
            self.base = Some(now);
            return;
        };
        let is_in_time = self.deviation(now.since(base), times.cycle) <= times.window + TOLERANCE;
        if is_in_time {
            (self.base, self.in_time, self.out_of_time) = (Some(now), self.in_time + 1, 0);
            if hooks.check(A3m60Check::Synchronizes(self.wrong), self.in_time >= SYNCHRONIZES) {
                (self.is_synchronized, self.wrong) = (true, ClockErrors::default());
            }
            return;
        }
        (self.in_time, self.out_of_time) = (0, self.out_of_time + 1);
        let searches = !self.is_synchronized && !self.wrong.is_deviating;
        if searches {
            self.base = Some(now);
        }
        if self.out_of_time >= if searches { BEGINS } else { DEVIATES } {
            (self.is_synchronized, self.wrong.is_deviating) = (false, true);
        }
    }

    /// Returns by how much the time since a clock differs from whole cycles. A time below half a cycle differs by a whole cycle.
    fn deviation(&self, passed: Duration, cycle: Duration) -> Duration {
        let (passed, cycle) = (passed.as_nanos(), cycle.as_nanos().max(1));
        let rest = passed % cycle;
        let off = if passed < cycle / 2 { cycle } else { rest.min(cycle - rest) };
        Duration::from_nanos(off as u64)
    }

    /// Advances to `now`; `place` returns the shaft position at a time.
    pub fn advance(&mut self, now: Time, place: impl Fn(Time) -> i64, hooks: &A3m60Deviations) {
        let Some(times) = self.times else { return };
        if times.is_simulated {
            let cycles = now.since(self.since).as_nanos() / times.cycle.as_nanos().max(1);
            let last = self.since + times.cycle * cycles as u32;
            if self.last.is_none_or(|before| before < last) {
                (self.last, self.place) = (Some(last), Some(place(last)));
            }
            self.is_synchronized = cycles >= SYNCHRONIZES.into();
            return;
        }
        let (from, cycles) = self.last.map_or((self.since, BEGINS), |last| (last, MISSES));
        let is_late = now > from + times.cycle * cycles + times.window + TOLERANCE;
        if hooks.check(A3m60Check::ClockMissing, is_late) {
            (self.is_synchronized, self.wrong.is_missing) = (false, true);
            (self.base, self.in_time, self.out_of_time, self.place) = (None, 0, 0, None);
        }
    }
}
