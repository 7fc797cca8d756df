//! A segment: the wire with the stations of the harness, the device under test, and its stand.
//!
//! The engine drives every kind of wire through [`Segment`]; it must not know which one it is.

use super::exchangeable_device::ExchangeableDevice;
use super::outcome::Disturbance;
use super::stations::HarnessStations;
use deviations::ReferenceDevice;
use station::{Duration, Outbox, Stand, StandAction, StandRefusal, Station, Time};
use virtual_wire::{TappedFrame, VirtualBus, VirtualStep, VirtualWire, WireViolation};
use wire::profibus::fdl::{BaudRate, BitTimes};

/// A callback for every frame on the wire, with its time.
pub type FrameTap<'a> = &'a mut dyn FnMut(Time, &[u8]);

/// The wire with the stations of the harness, the device under test, and its stand.
pub trait Segment {
    /// The time of the wire's clock.
    fn now(&self) -> Time;

    /// Processes the next event, not later than `until`; returns false if there is none until then.
    ///
    /// `tap` receives every frame once, in order of time.
    fn step(&mut self, ours: &mut HarnessStations, until: Time, tap: FrameTap<'_>) -> bool;

    /// The stand of the device.
    fn stand(&mut self) -> &mut dyn Stand;

    /// Whether the device received a frame or time, or the stand acted on it, since the last call; `true` if that is not known.
    fn take_touch(&mut self) -> bool {
        true
    }

    /// Whether the device is a model, so that a suite which does not fit it is an error.
    fn is_model(&self) -> bool;

    /// Whether time is simulated and no other station is on the wire.
    fn is_virtual(&self) -> bool {
        self.is_model()
    }

    /// Errors of the wire itself: frames that no wire can carry.
    fn objections(&self) -> Vec<String> {
        Vec::new()
    }

    /// Frames that the device sent when it must not: too early, too late, or during other frames (PROFIBUS).
    fn out_of_turn(&self) -> Vec<String> {
        Vec::new()
    }

    /// Why a frame for the device was not sent, if that happened.
    fn withheld(&self) -> Option<String> {
        None
    }

    /// What happened to the line since the trial began, if it broke.
    fn broken_line(&self) -> Option<String> {
        None
    }

    /// Why all observations of the trial are worthless although the line is up.
    fn invalidated(&self) -> Option<Disturbance> {
        None
    }

    /// Checks the line once more.
    fn check_line(&mut self) {}

    /// Whether the user has requested the end of the run.
    fn is_interrupted(&self) -> bool {
        false
    }

    /// The longest delay of the harness itself since the trial began.
    fn lateness(&self) -> Duration {
        Duration::ZERO
    }

    /// How long programs of this host waited for a processor since the trial began, if the device is one of them and may have been late
    /// for it.
    fn shortage(&self) -> Option<Duration> {
        None
    }

    /// Whether a request was given up without an answer that may still arrive (PROFIBUS on a live line).
    fn lacks_answer(&self) -> bool {
        false
    }

    /// The longest time from a request to its answer since the trial began, if the link cannot tell a slow device from its own delay
    /// (PROFIBUS).
    fn latest_answer(&self) -> Duration {
        Duration::ZERO
    }
}

/// The wire or bus of a virtual segment.
enum VirtualMedium {
    /// PROFINET; a frame has the time of its arrival.
    Wire(VirtualWire),
    /// PROFIBUS; a frame has the time of its first start bit, as in captures.
    Bus(VirtualBus),
}

/// A reference device, or a peer that is no device, on a virtual wire.
pub struct VirtualSegment<D> {
    medium: VirtualMedium,
    device: D,
}

/// A station with a stand: the device of a virtual segment.
pub trait DeviceOnStand {
    fn station(&mut self) -> &mut dyn Station;
    fn stand(&mut self) -> &mut dyn Stand;
    /// Whether it received a frame or time, or the stand acted on it, since the last call; `true` if that is not known.
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
    /// A PROFINET segment with `device` and the harness's controllers.
    pub fn new(device: D) -> VirtualSegment<D> {
        VirtualSegment { medium: VirtualMedium::Wire(VirtualWire::new()), device }
    }

    /// A PROFIBUS segment at `baud` with `device` and the harness's masters, which wait for answers for the slot time `slot`. A
    /// trial fails when the device answers before min TSDR, or after `max_tsdr` if its GSD is known, else after the slot time.
    pub fn bus(device: D, baud: BaudRate, slot: BitTimes, max_tsdr: Option<BitTimes>) -> VirtualSegment<D> {
        let bus = VirtualBus::new(baud, slot).with_max_tsdr(max_tsdr);
        VirtualSegment { medium: VirtualMedium::Bus(bus), device }
    }
}

impl<D: DeviceOnStand> Segment for VirtualSegment<D> {
    fn now(&self) -> Time {
        match &self.medium {
            VirtualMedium::Wire(wire) => wire.now(),
            VirtualMedium::Bus(bus) => bus.now(),
        }
    }

    fn step(&mut self, ours: &mut HarnessStations, until: Time, tap: FrameTap<'_>) -> bool {
        let VirtualSegment { medium, device } = self;
        let worked = ours.with_device(device.station(), |stations| match medium {
            VirtualMedium::Wire(wire) => {
                wire.step(stations, until, &mut |seen: TappedFrame<'_>| tap(seen.time, seen.frame))
            }
            VirtualMedium::Bus(bus) => {
                bus.step(stations, until, &mut |seen: TappedFrame<'_>| tap(seen.begin, seen.frame))
            }
        });
        worked == VirtualStep::Worked
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
            VirtualMedium::Wire(wire) => wire.violations(),
            VirtualMedium::Bus(bus) => bus.violations(),
        };
        violations.iter().map(ToString::to_string).collect()
    }

    fn out_of_turn(&self) -> Vec<String> {
        match &self.medium {
            VirtualMedium::Wire(_) => Vec::new(),
            VirtualMedium::Bus(bus) => {
                bus.violations().iter().filter(|of| is_of_device(of)).map(ToString::to_string).collect()
            }
        }
    }
}

/// Whether the device, which is at the second port, caused a violation.
fn is_of_device(violation: &WireViolation) -> bool {
    const DEVICE: usize = 1;
    match violation {
        WireViolation::Collision { port, other, .. } => *port == DEVICE || *other == DEVICE,
        WireViolation::TooShort { port, .. }
        | WireViolation::TooLong { port, .. }
        | WireViolation::NoFrame { port, .. }
        | WireViolation::NoSilence { port, .. }
        | WireViolation::TooEarly { port, .. }
        | WireViolation::AfterMaxTsdr { port, .. }
        | WireViolation::TooLate { port, .. }
        | WireViolation::Congested { port, .. }
        | WireViolation::Livelock { port, .. } => *port == DEVICE,
    }
}

/// Builds a reference device in factory state.
pub type FactoryBuild<'a> = Box<dyn Fn() -> Result<Box<dyn ReferenceDevice>, String> + 'a>;

/// A reference device; it is its own stand, except for its own exchange.
pub struct ModelOnStand<'a> {
    device: ExchangeableDevice,
    deliver: FactoryBuild<'a>,
}

impl<'a> ModelOnStand<'a> {
    /// `device`, and how to build it in factory state.
    pub fn new(device: Box<dyn ReferenceDevice>, deliver: FactoryBuild<'a>) -> ModelOnStand<'a> {
        ModelOnStand { device: ExchangeableDevice::new(device), deliver }
    }
}

impl DeviceOnStand for ModelOnStand<'_> {
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

impl Station for ModelOnStand<'_> {
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

impl Stand for ModelOnStand<'_> {
    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Result<Time, StandRefusal> {
        if *action != StandAction::RestoreFactoryState {
            return self.device.act(now, action);
        }
        self.device.exchange(now, (self.deliver)().map_err(StandRefusal::Broken)?);
        Ok(now)
    }

    fn led(&mut self, now: Time, name: &str) -> Option<&'static str> {
        self.device.led(now, name)
    }

    fn counter(&mut self, now: Time, name: &str) -> Option<u64> {
        self.device.counter(now, name)
    }
}

/// A peer that is not an encoder, without a stand.
pub struct PeerWithoutStand<S>(pub S, pub NoStand);

/// A stand that can do nothing.
pub struct NoStand;

impl<S: Station> DeviceOnStand for PeerWithoutStand<S> {
    fn station(&mut self) -> &mut dyn Station {
        &mut self.0
    }

    fn stand(&mut self) -> &mut dyn Stand {
        &mut self.1
    }
}

impl Stand for NoStand {
    fn act(&mut self, _: Time, _: &StandAction<'_>) -> Result<Time, StandRefusal> {
        Err(StandRefusal::CannotDo("this device has no stand".into()))
    }

    fn led(&mut self, _: Time, _: &str) -> Option<&'static str> {
        None
    }

    fn counter(&mut self, _: Time, _: &str) -> Option<u64> {
        None
    }
}
