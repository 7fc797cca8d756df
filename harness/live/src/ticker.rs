//! A station that never sends and is woken every millisecond, to measure how late this host wakes it.

use station::{Duration, Outbox, Station, Time};

/// Interval of the wake-ups.
pub(super) const TICK: Duration = Duration::from_millis(1);

/// A station that requests a wake-up every millisecond.
pub(super) struct Ticker(pub Time);

impl Station for Ticker {
    fn receive(&mut self, _: Time, _: &[u8], _: &mut Outbox) {}

    fn wake(&mut self, now: Time, _: &mut Outbox) {
        while self.0 <= now {
            self.0 += TICK;
        }
    }

    fn deadline(&self) -> Option<Time> {
        Some(self.0)
    }
}
