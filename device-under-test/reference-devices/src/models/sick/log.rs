//! The service log: power-ups, operating time, highest speed, turns forward and in reverse, time of motion.
//!
//! A [`ShaftRecorder`] samples the shaft and returns what has changed since the last sample; each [`Log`] of a model adds it.
//! Interpretation: a turn counts when it begins and with each full revolution.

use super::hooks::{SickCheck, SickDeviations};
use core::time::Duration;
use station::Time;

/// The counters of a service log.
#[derive(Clone, Copy, Debug, Default)]
pub struct Log {
    /// The number of power-ups.
    pub power_ups: u32,
    /// The time with power.
    pub operating: Duration,
    /// The highest speed in revolutions per minute.
    pub highest_speed: u32,
    /// Turns forward.
    pub forward: u32,
    /// Turns in reverse.
    pub reverse: u32,
    /// Changes of direction.
    pub direction_changes: u32,
    /// The time in motion.
    pub motion: Duration,
}

impl Log {
    /// Creates the log of an encoder at its first power-up.
    pub fn new() -> Log {
        Log { power_ups: 1, ..Log::default() }
    }

    /// Counts a power-up.
    pub fn power_up(&mut self, hooks: &SickDeviations) {
        self.power_ups += 1;
        hooks.seams.notify(|hooks| hooks.log_loaded(self));
    }

    /// Adds the changes of one sample.
    pub fn add(&mut self, news: &LogChanges, hooks: &SickDeviations) {
        self.operating += news.passed;
        let speed = u32::try_from(news.rpm.unsigned_abs()).unwrap_or(u32::MAX);
        if hooks.check(SickCheck::HighestSpeed(news.rpm), speed > self.highest_speed) {
            self.highest_speed = speed;
        }
        if news.is_motion {
            self.motion += news.passed;
        }
        let [forward, reverse] = news.turns;
        self.forward = self.forward.wrapping_add(forward);
        self.reverse = self.reverse.wrapping_add(reverse);
        self.direction_changes += u32::from(news.is_reversed);
    }
}

/// The context in which a log is read.
#[derive(Clone, Copy, Debug)]
pub struct LogReading {
    /// The parameter number: P1002 or P1003.
    pub number: u16,
    /// The present speed in revolutions per minute.
    pub rpm: i64,
    /// The operating time.
    pub operating: Duration,
}

/// One sample of the shaft.
#[derive(Clone, Copy, Debug)]
pub struct ShaftSample {
    /// The time of the sample.
    pub now: Time,
    /// The speed in revolutions per minute, rounded.
    pub rpm: i64,
    /// The direction of rotation as a sign, 0 at rest.
    pub sense: i64,
    /// The shaft position in hardware steps, over all revolutions.
    pub place: i64,
    /// Hardware steps per revolution.
    pub steps_per_revolution: u64,
    /// The lowest speed that counts as motion, in whole revolutions per minute.
    pub slowest: u64,
}

/// The changes since the last sample.
#[derive(Clone, Copy, Debug)]
pub struct LogChanges {
    passed: Duration,
    rpm: i64,
    is_motion: bool,
    turns: [u32; 2],
    is_reversed: bool,
}

/// Samples the shaft for service logs.
#[derive(Clone, Copy, Debug)]
pub struct ShaftRecorder {
    last: Time,
    place: Option<i64>,
    /// The direction of the present motion, 0 at rest, and of the last one.
    motion: i64,
    last_motion: i64,
    /// Hardware steps since the present motion began, or since its last full revolution.
    way: u64,
}

impl Default for ShaftRecorder {
    fn default() -> ShaftRecorder {
        ShaftRecorder { last: Time::ZERO, place: None, motion: 0, last_motion: 0, way: 0 }
    }
}

impl ShaftRecorder {
    /// Restarts at power-up.
    pub fn power_up(&mut self, now: Time) {
        (self.last, self.place, self.motion) = (now, None, 0);
    }

    /// Returns the changes since the last sample.
    pub fn sample(&mut self, look: &ShaftSample, hooks: &SickDeviations) -> LogChanges {
        let rpm = look.rpm.unsigned_abs();
        let passed = look.now.since(self.last);
        self.last = look.now;
        let (turns, is_reversed) = self.turns(look, hooks);
        let is_motion = hooks.check(SickCheck::Motion(rpm), rpm >= look.slowest);
        LogChanges { passed, rpm: look.rpm, is_motion, turns, is_reversed }
    }

    fn turns(&mut self, look: &ShaftSample, hooks: &SickDeviations) -> ([u32; 2], bool) {
        let gone = look.place.wrapping_sub(self.place.replace(look.place).unwrap_or(look.place)).unsigned_abs();
        let before = core::mem::replace(&mut self.motion, look.sense);
        if look.sense == 0 {
            return ([0; 2], false);
        }
        let begins = look.sense != before;
        let turns = if look.sense == before {
            self.way = self.way.wrapping_add(gone);
            let turns = self.way / look.steps_per_revolution;
            self.way %= look.steps_per_revolution;
            turns as u32
        } else {
            self.way = 0;
            1
        };
        let turns = hooks.seams.apply(turns, |hooks, turns| hooks.turns(begins, turns));
        let last = core::mem::replace(&mut self.last_motion, look.sense);
        let change = SickCheck::DirectionChange { before, last, now: look.sense };
        let is_reversed = hooks.check(change, last == -look.sense);
        (if look.sense > 0 { [turns, 0] } else { [0, turns] }, is_reversed)
    }
}
