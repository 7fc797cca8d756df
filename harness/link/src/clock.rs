//! The clock of a live wire.

use std::time::Instant;

use station::{Duration, Time};

/// The monotonic clock of the host, in nanoseconds from a start.
///
/// Changes of the system date do not affect it. Copies show the same time.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    start: Instant,
}

impl Clock {
    /// Starts a clock: it shows [`Time::ZERO`] now.
    pub fn start() -> Clock {
        Clock { start: Instant::now() }
    }

    /// The present time of the clock.
    pub fn now(&self) -> Time {
        self.at(Instant::now())
    }

    /// The time of the clock at `instant`; [`Time::ZERO`] if that is before its start.
    pub fn at(&self, instant: Instant) -> Time {
        Time::ZERO + instant.saturating_duration_since(self.start)
    }

    /// A clock that starts when this one shows `zero`.
    pub fn started_at(&self, zero: Time) -> Clock {
        Clock { start: self.start + zero.since(Time::ZERO) }
    }

    /// The time from now to `until`; zero if `until` has passed.
    pub fn remaining(&self, until: Time) -> Duration {
        until.since(self.now())
    }
}
