//! The clock of a live wire.

use std::time::Instant;

use station::{Duration, Time};

/// The monotonic clock of the machine, counted in nanoseconds from a start.
///
/// Changes of the date do not move it. Copies show the same time.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    start: Instant,
}

impl Clock {
    /// A clock that shows [`Time::ZERO`] now.
    pub fn start() -> Clock {
        Clock { start: Instant::now() }
    }

    /// What it shows.
    pub fn now(&self) -> Time {
        self.at(Instant::now())
    }

    /// What it shows at `instant`; before its start it shows [`Time::ZERO`].
    pub fn at(&self, instant: Instant) -> Time {
        Time::ZERO + instant.saturating_duration_since(self.start)
    }

    /// A clock that shows [`Time::ZERO`] when this one shows `zero`.
    pub fn started_at(&self, zero: Time) -> Clock {
        Clock { start: self.start + zero.since(Time::ZERO) }
    }

    /// How long it is from now to `until`; zero where that has gone by.
    pub fn remaining(&self, until: Time) -> Duration {
        until.since(self.now())
    }
}
