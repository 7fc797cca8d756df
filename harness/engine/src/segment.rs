//! A segment: the wire with our controllers on it, the device under test, and the stand that holds it.
//!
//! The engine drives every kind of wire through [`Segment`]; it must not know which one it is.

use super::ours::Ours;
use super::reborn::Reborn;
use deviations::ReferenceDevice;
use station::{Duration, Outbox, Refusal, Stand, StandAction, Station, Time};
use virtual_wire::{Seen, Step, Violation, VirtualBus, VirtualWire};
use wire::profibus::fdl::{BaudRate, BitTimes};

/// A frame that was seen, as the engine takes it in.
pub type Tap<'a> = &'a mut dyn FnMut(Time, &[u8]);

/// The wire with our controllers on it, the device under test, and the stand that holds it.
pub trait Segment {
    /// What the clock shows.
    fn now(&self) -> Time;

    /// Lets the next thing happen, not later than `until`; false if nothing was left to do until then.
    ///
    /// `tap` sees every frame once, in the order of time.
    fn step(&mut self, ours: &mut Ours, until: Time, tap: Tap<'_>) -> bool;

    /// What holds the device.
    fn stand(&mut self) -> &mut dyn Stand;

    /// Whether the device was given a frame or time, or the stand did something, since this was asked last; where nobody
    /// knows, it was.
    fn take_touch(&mut self) -> bool {
        true
    }

    /// Whether it is a model: no time passes but ours, nothing else is on the wire, and a suite's mistake is an error.
    fn is_model(&self) -> bool;

    /// What the wire itself objects to: frames that no wire carries.
    fn objections(&self) -> Vec<String> {
        Vec::new()
    }

    /// What the device sent when it might not: too early, too late, over others (PROFIBUS).
    fn out_of_turn(&self) -> Vec<String> {
        Vec::new()
    }

    /// Why something was not sent that the device was to get, if that was so.
    fn withheld(&self) -> Option<String> {
        None
    }

    /// What happened to the line since the trial began, where it broke.
    fn broken_line(&self) -> Option<String> {
        None
    }

    /// What makes everything that was seen worthless, although the line is there.
    fn spoilt(&self) -> Option<String> {
        None
    }

    /// Looks once more whether the line is as it should be.
    fn look_at_line(&mut self) {}

    /// Whether somebody wants the run to end.
    fn is_interrupted(&self) -> bool {
        false
    }

    /// By how much we were late ourselves at worst since the trial began.
    fn lateness(&self) -> Duration {
        Duration::ZERO
    }

    /// How long after its request an answer came at worst since the trial began, where the link cannot tell a slow device from its
    /// own delay (PROFIBUS).
    fn latest_answer(&self) -> Duration {
        Duration::ZERO
    }
}

/// What carries the frames of a virtual segment.
enum Medium {
    /// PROFINET; a frame counts from its arrival.
    Wire(VirtualWire),
    /// PROFIBUS; a frame counts from its first start bit, as in captures.
    Bus(VirtualBus),
}

/// A reference device, or nobody, on a virtual wire.
pub struct VirtualSegment<D> {
    medium: Medium,
    device: D,
}

/// A station with a stand: what a virtual segment has besides our controllers.
pub trait DeviceOnStand {
    /// The station.
    fn station(&mut self) -> &mut dyn Station;
    /// What holds it.
    fn stand(&mut self) -> &mut dyn Stand;
    /// Whether it was given a frame or time, or the stand did something, since this was asked last; where nobody knows, it was.
    fn take_touch(&mut self) -> bool {
        true
    }
}

impl<D: DeviceOnStand + ?Sized> DeviceOnStand for Box<D> {
    fn station(&mut self) -> &mut dyn Station {
        (**self).station()
    }

    fn stand(&mut self) -> &mut dyn Stand {
        (**self).stand()
    }

    fn take_touch(&mut self) -> bool {
        (**self).take_touch()
    }
}

impl<D: DeviceOnStand> VirtualSegment<D> {
    /// A segment of PROFINET with `device` and our controllers.
    pub fn new(device: D) -> VirtualSegment<D> {
        VirtualSegment { medium: Medium::Wire(VirtualWire::new()), device }
    }

    /// A segment of PROFIBUS at `baud` with `device` and our masters, which wait for answers for the time `slot`.
    pub fn bus(device: D, baud: BaudRate, slot: BitTimes) -> VirtualSegment<D> {
        VirtualSegment { medium: Medium::Bus(VirtualBus::new(baud, slot)), device }
    }
}

impl<D: DeviceOnStand> Segment for VirtualSegment<D> {
    fn now(&self) -> Time {
        match &self.medium {
            Medium::Wire(wire) => wire.now(),
            Medium::Bus(bus) => bus.now(),
        }
    }

    fn step(&mut self, ours: &mut Ours, until: Time, tap: Tap<'_>) -> bool {
        let VirtualSegment { medium, device } = self;
        let worked = ours.with_device(device.station(), |stations| match medium {
            Medium::Wire(wire) => wire.step(stations, until, &mut |seen: Seen<'_>| tap(seen.time, seen.frame)),
            Medium::Bus(bus) => bus.step(stations, until, &mut |seen: Seen<'_>| tap(seen.begin, seen.frame)),
        });
        worked == Step::Worked
    }

    fn stand(&mut self) -> &mut dyn Stand {
        self.device.stand()
    }

    fn take_touch(&mut self) -> bool {
        self.device.take_touch()
    }

    fn is_model(&self) -> bool {
        true
    }

    fn objections(&self) -> Vec<String> {
        let violations = match &self.medium {
            Medium::Wire(wire) => wire.violations(),
            Medium::Bus(bus) => bus.violations(),
        };
        violations.iter().map(ToString::to_string).collect()
    }

    fn out_of_turn(&self) -> Vec<String> {
        match &self.medium {
            Medium::Wire(_) => Vec::new(),
            Medium::Bus(bus) => {
                bus.violations().iter().filter(|of| is_of_device(of)).map(ToString::to_string).collect()
            }
        }
    }
}

/// Whether a violation is one of the device, which stands at the second port.
fn is_of_device(violation: &Violation) -> bool {
    const DEVICE: usize = 1;
    match violation {
        Violation::Collision { port, other, .. } => *port == DEVICE || *other == DEVICE,
        Violation::TooShort { port, .. }
        | Violation::TooLong { port, .. }
        | Violation::NoFrame { port, .. }
        | Violation::NoSilence { port, .. }
        | Violation::TooEarly { port, .. }
        | Violation::TooLate { port, .. }
        | Violation::Congested { port, .. }
        | Violation::Livelock { port, .. } => *port == DEVICE,
    }
}

/// Makes a reference device as delivered.
pub type Deliver<'a> = Box<dyn Fn() -> Result<Box<dyn ReferenceDevice>, String> + 'a>;

/// A reference device is its own stand, but for the exchange of itself.
pub struct Model<'a> {
    device: Reborn,
    deliver: Deliver<'a>,
}

impl<'a> Model<'a> {
    /// `device`, and how it is made as delivered.
    pub fn new(device: Box<dyn ReferenceDevice>, deliver: Deliver<'a>) -> Model<'a> {
        Model { device: Reborn::new(device), deliver }
    }
}

impl DeviceOnStand for Model<'_> {
    fn station(&mut self) -> &mut dyn Station {
        &mut self.device
    }

    fn stand(&mut self) -> &mut dyn Stand {
        self
    }

    fn take_touch(&mut self) -> bool {
        self.device.take_touch()
    }
}

impl Station for Model<'_> {
    fn receive(&mut self, now: Time, frame: &[u8], out: &mut Outbox) {
        self.device.receive(now, frame, out);
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        self.device.wake(now, out);
    }

    fn deadline(&self) -> Option<Time> {
        self.device.deadline()
    }
}

impl Stand for Model<'_> {
    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Result<Time, Refusal> {
        if *action != StandAction::Deliver {
            return self.device.act(now, action);
        }
        self.device.exchange(now, (self.deliver)().map_err(Refusal::Broken)?);
        Ok(now)
    }

    fn led(&mut self, now: Time, name: &str) -> Option<&'static str> {
        self.device.led(now, name)
    }

    fn counter(&mut self, now: Time, name: &str) -> Option<u64> {
        self.device.counter(now, name)
    }
}

/// Somebody who is no encoder at all, without a stand: for the battery of devices that must never pass.
pub struct Stranger<S>(pub S, pub NoStand);

/// A stand that can do nothing.
pub struct NoStand;

impl<S: Station> DeviceOnStand for Stranger<S> {
    fn station(&mut self) -> &mut dyn Station {
        &mut self.0
    }

    fn stand(&mut self) -> &mut dyn Stand {
        &mut self.1
    }
}

impl Stand for NoStand {
    fn act(&mut self, _: Time, _: &StandAction<'_>) -> Result<Time, Refusal> {
        Err(Refusal::CannotDo("nobody holds this device".into()))
    }

    fn led(&mut self, _: Time, _: &str) -> Option<&'static str> {
        None
    }

    fn counter(&mut self, _: Time, _: &str) -> Option<u64> {
        None
    }
}
