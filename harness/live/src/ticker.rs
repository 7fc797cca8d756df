//! A station that never sends and is woken every millisecond: how late it is woken says how punctual this machine is.

use station::{Duration, Outbox, Station, Time};

/// How often the listener asks to be woken, to see how punctual this machine is.
pub(super) const TICK: Duration = Duration::from_millis(1);

/// Somebody who wants to be woken every millisecond.
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
