//! A reference device that can be exchanged while the clock of the wire runs on.

use deviations::ReferenceDevice;
use station::{Outbox, Stand, StandAction, StandRefusal, Station, Time};
use std::cell::Cell;

/// A reference device with its own clock, which starts when the device is put on the wire.
pub struct Reborn {
    device: Box<dyn ReferenceDevice>,
    born: Time,
    /// Whether the device received a frame or time, or the stand acted on it, since the last query.
    was_touched: bool,
    /// Its deadline since it was last touched; it does not change until then.
    due: Cell<Option<Option<Time>>>,
}

impl Reborn {
    /// Puts `device` on the wire at time zero.
    pub fn new(device: Box<dyn ReferenceDevice>) -> Reborn {
        Reborn { device, born: Time::ZERO, was_touched: true, due: Cell::default() }
    }

    /// Replaces the device by `device`, whose clock starts at `now`.
    pub fn exchange(&mut self, now: Time, device: Box<dyn ReferenceDevice>) {
        (self.device, self.born) = (device, now);
        self.touch();
    }

    /// Whether the device received a frame or time, or the stand acted on it, since the last call.
    pub fn take_touch(&mut self) -> bool {
        std::mem::take(&mut self.was_touched)
    }

    fn touch(&mut self) {
        self.was_touched = true;
        self.due.take();
    }

    /// The time of the device's own clock at the time `now` of the wire.
    fn own(&self, now: Time) -> Time {
        Time::from_nanos(now.nanos_since(self.born))
    }

    /// The time of the wire at the time `own` of the device's clock.
    fn wires(&self, own: Time) -> Time {
        self.born.after_nanos(own.as_nanos())
    }
}

impl Station for Reborn {
    fn receive(&mut self, now: Time, frame: &[u8], out: &mut Outbox) {
        self.touch();
        self.device.receive(self.own(now), frame, out);
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        self.touch();
        self.device.wake(self.own(now), out);
    }

    fn deadline(&self) -> Option<Time> {
        let due = self.due.get().unwrap_or_else(|| self.device.deadline().map(|due| self.wires(due)));
        self.due.set(Some(due));
        due
    }
}

impl Stand for Reborn {
    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Result<Time, StandRefusal> {
        self.touch();
        self.device.act(self.own(now), action).map(|done| self.wires(done))
    }

    fn led(&mut self, now: Time, name: &str) -> Option<&'static str> {
        self.device.led(self.own(now), name)
    }

    fn counter(&mut self, now: Time, name: &str) -> Option<u64> {
        self.touch();
        self.device.counter(self.own(now), name)
    }
}
