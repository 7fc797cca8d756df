//! A reference device that can be exchanged while the clock of the wire runs on.

use deviations::ReferenceDevice;
use station::{Outbox, Stand, StandAction, StandRefusal, Station, Time};
use std::cell::Cell;

/// A reference device with its own clock, which starts when the device is put on the wire.
pub struct ExchangeableDevice {
    device: Box<dyn ReferenceDevice>,
    born: Time,
    /// Whether the device received a frame or time, or the stand acted on it, since the last query.
    was_touched: bool,
    /// Its deadline since it was last touched; it does not change until then.
    due: Cell<Option<Option<Time>>>,
}

impl ExchangeableDevice {
    /// Puts `device` on the wire at time zero.
    pub fn new(device: Box<dyn ReferenceDevice>) -> ExchangeableDevice {
        ExchangeableDevice { device, born: Time::ZERO, was_touched: true, due: Cell::default() }
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
    fn device_time(&self, now: Time) -> Time {
        Time::from_nanos(now.nanos_since(self.born))
    }

    /// The time of the wire at the time `device_time` of the device's clock.
    fn wire_time(&self, own: Time) -> Time {
        self.born.after_nanos(own.as_nanos())
    }
}

impl Station for ExchangeableDevice {
    fn receive(&mut self, now: Time, frame: &[u8], out: &mut Outbox) {
        self.touch();
        self.device.receive(self.device_time(now), frame, out);
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        self.touch();
        self.device.wake(self.device_time(now), out);
    }

    fn deadline(&self) -> Option<Time> {
        let due = self.due.get().unwrap_or_else(|| self.device.deadline().map(|due| self.wire_time(due)));
        self.due.set(Some(due));
        due
    }
}

impl Stand for ExchangeableDevice {
    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Result<Time, StandRefusal> {
        self.touch();
        self.device.act(self.device_time(now), action).map(|done| self.wire_time(done))
    }

    fn led(&mut self, now: Time, name: &str) -> Option<&'static str> {
        self.device.led(self.device_time(now), name)
    }

    fn counter(&mut self, now: Time, name: &str) -> Option<u64> {
        self.touch();
        self.device.counter(self.device_time(now), name)
    }
}
