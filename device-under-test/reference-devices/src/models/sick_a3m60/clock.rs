//! Isochronous operation: the clock of the bus, and the position at it. Manual, 3.3.3 and 3.6.7.
//!
//! How far a clock may deviate and how often it may be missing is not printed. Readings: three clocks in time are a
//! synchronization, and end what was wrong with the clock; two in a row out of time are a deviating clock; none for more than
//! three cycles is a missing one, none for sixteen from the beginning on. What is in time is counted from the clock with which
//! the encoder synchronized, until the clock is missing.

use super::hooks::{A3m60Check, Hooks};
use core::time::Duration;
use station::Time;

/// Clocks in time that are a synchronization.
const SYNCHRONIZES: u32 = 3;
/// Clocks out of time that are an error.
const DEVIATES: u32 = 2;
/// Cycles without a clock that are an error.
const MISSES: u32 = 3;
/// Cycles after which the first clock is missing, and clocks that are out of step for so long are an error.
const BEGINS: u32 = 16;
/// What a clock may deviate beside the window of the master.
const TOLERANCE: Duration = Duration::from_micros(50);

/// What isochronous operation goes by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Times {
    /// From one clock to the next.
    pub cycle: Duration,
    /// Half the window in which a clock is in time.
    pub window: Duration,
    /// Whether the encoder makes the clock itself.
    pub is_simulated: bool,
}

/// What is wrong with the clock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wrong {
    /// There is none.
    pub is_missing: bool,
    /// It comes at the wrong time.
    pub is_deviating: bool,
}

/// Follows the clock.
#[derive(Clone, Copy, Debug, Default)]
pub struct Clock {
    times: Option<Times>,
    since: Time,
    last: Option<Time>,
    /// A clock that was in time.
    base: Option<Time>,
    right: u32,
    off: u32,
    is_synchronized: bool,
    wrong: Wrong,
    /// Where the shaft was at the last clock.
    place: Option<i64>,
}

impl Clock {
    /// Begins with a connection; without times it is not isochronous.
    pub fn begin(&mut self, now: Time, times: Option<Times>) {
        *self = Clock { times, since: now, ..Clock::default() };
    }

    /// The times in force; none without isochronous operation.
    pub fn times(&self) -> Option<Times> {
        self.times
    }

    /// Whether the encoder is in step with the clock.
    pub fn is_synchronized(&self) -> bool {
        self.is_synchronized
    }

    /// What is wrong with the clock.
    pub fn wrong(&self) -> Wrong {
        self.wrong
    }

    /// Where the shaft was at the last clock, while there is one.
    pub fn place(&self) -> Option<i64> {
        self.place
    }

    /// The shaft was put at `place`.
    pub fn put(&mut self, place: i64) {
        self.place = self.place.map(|_| place);
    }

    /// A clock has come, with the shaft at `place`.
    pub fn tick(&mut self, now: Time, place: i64, hooks: &Hooks) {
        let Some(times) = self.times.filter(|times| !times.is_simulated) else { return };
        (self.last, self.place) = (Some(now), Some(place));
        let Some(base) = self.base else {
            self.base = Some(now);
            return;
        };
        let is_in_time = self.deviation(now.since(base), times.cycle) <= times.window + TOLERANCE;
        if is_in_time {
            (self.base, self.right, self.off) = (Some(now), self.right + 1, 0);
            if hooks.check(A3m60Check::Synchronizes(self.wrong), self.right >= SYNCHRONIZES) {
                (self.is_synchronized, self.wrong) = (true, Wrong::default());
            }
            return;
        }
        (self.right, self.off) = (0, self.off + 1);
        let searches = !self.is_synchronized && !self.wrong.is_deviating;
        if searches {
            self.base = Some(now);
        }
        if self.off >= if searches { BEGINS } else { DEVIATES } {
            (self.is_synchronized, self.wrong.is_deviating) = (false, true);
        }
    }

    /// By how much the time since a clock differs from whole cycles; from none at all it differs by all of it.
    fn deviation(&self, passed: Duration, cycle: Duration) -> Duration {
        let (passed, cycle) = (passed.as_nanos(), cycle.as_nanos().max(1));
        let rest = passed % cycle;
        let off = if passed < cycle / 2 { cycle } else { rest.min(cycle - rest) };
        Duration::from_nanos(off as u64)
    }

    /// The time has come to `now`, with the shaft where `place` says.
    pub fn advance(&mut self, now: Time, place: impl Fn(Time) -> i64, hooks: &Hooks) {
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
            (self.base, self.right, self.off, self.place) = (None, 0, 0, None);
        }
    }
}
