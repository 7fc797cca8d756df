//! A reference device that can be exchanged while the clock of the wire goes on.

use deviations::ReferenceDevice;
use station::{Outbox, Refusal, Stand, StandAction, Station, Time};
use std::cell::Cell;

/// A reference device with a clock of its own, which begins with its life.
pub struct Reborn {
    device: Box<dyn ReferenceDevice>,
    born: Time,
    /// Whether it was given a frame or time, or the stand did something, since somebody asked last.
    was_touched: bool,
    /// Its deadline, where it was asked since it was touched last: until then it stays the same.
    due: Cell<Option<Option<Time>>>,
}

impl Reborn {
    /// `device` from the beginning of the wire's clock on.
    pub fn new(device: Box<dyn ReferenceDevice>) -> Reborn {
        Reborn { device, born: Time::ZERO, was_touched: true, due: Cell::default() }
    }

    /// Puts `device` into the place of the one before; its life begins at `now`.
    pub fn exchange(&mut self, now: Time, device: Box<dyn ReferenceDevice>) {
        (self.device, self.born) = (device, now);
        self.touch();
    }

    /// Whether it was given a frame or time, or the stand did something, since this was asked last.
    pub fn take_touch(&mut self) -> bool {
        std::mem::take(&mut self.was_touched)
    }

    fn touch(&mut self) {
        self.was_touched = true;
        self.due.take();
    }

    /// What its own clock shows when that of the wire shows `now`.
    fn own(&self, now: Time) -> Time {
        Time::from_nanos(now.nanos_since(self.born))
    }

    /// What the clock of the wire shows when its own shows `own`.
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
    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Result<Time, Refusal> {
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
