//! The encoder: its stored and volatile data, and how it measures.

use super::hooks::{Amt58Check, Amt58Hooks};
use super::leds::{self, Leds, Situation};
use super::node_number::NodeNumber;
use super::red_zone;
use super::set_prm::EncoderParameters;
use core::time::Duration;
use device_stack::Attached;
use device_stack::profibus::{SlaveIdentity, SlaveStatus};
use encoder_profile::deviations::EncoderDeviations;
use encoder_profile::encoder::{Hardware, Measuring, NvmCell, Shaft, Velocity};
use station::Time;

/// The lowest and the highest supply voltage in millivolts (4.3 and 4.4).
pub(super) const SUPPLY: [u64; 2] = [10_000, 30_000];

/// Time from one velocity value to the next; invented.
const WINDOW: Duration = Duration::from_millis(50);

/// An AMT58, connected to its slave.
pub struct Amt58 {
    pub(super) identity: SlaveIdentity,
    pub(super) deviations: EncoderDeviations,
    pub(super) hooks: Attached<dyn Amt58Hooks>,
    pub(super) sensor: Hardware,
    pub(super) shaft: Shaft,
    /// The position of switches 1 to 7.
    pub(super) switches: u8,
    /// The positions of the two RT switches (4.6).
    pub(super) termination: [u32; 2],
    pub(super) has_broken_memory: bool,
    /// The supply voltage in volts.
    pub(super) volts: f64,
    pub(super) stored_offset: NvmCell<i64>,
    pub(super) stored_address: NvmCell<Option<u8>>,
    pub(super) ram: Amt58VolatileData,
}

/// The volatile data.
pub(super) struct Amt58VolatileData {
    /// The switches as they were at power-up.
    pub(super) switches: u8,
    pub(super) hardware: Hardware,
    pub(super) parameters: EncoderParameters,
    pub(super) measuring: Measuring,
    pub(super) velocity: Velocity,
    /// The preset offset, with its sign.
    pub(super) offset: i64,
    /// In how many consecutive cycles bit 31 of the outputs was set.
    pub(super) preset_cycles: u32,
    /// Whether the memory could not be read at power-up.
    pub(super) is_unreadable: bool,
    /// Whether the watchdog ended the last data exchange.
    pub(super) has_expired: bool,
    /// Whether the last parameters were wrong.
    pub(super) is_invalid: bool,
}

impl Amt58 {
    /// Creates an encoder with this ident number and sensor, its shaft at `shaft` and its switches at `address`.
    pub fn new(
        ident: u16,
        sensor: Hardware,
        deviations: EncoderDeviations,
        hooks: Attached<dyn Amt58Hooks>,
        shaft: u64,
        address: u8,
    ) -> Amt58 {
        let hardware = hooks.apply(sensor, |hooks, hardware| hooks.sensor(hardware));
        let shaft = Shaft::new(sensor.steps_per_revolution, shaft as i64);
        let ram = Amt58VolatileData::new(Time::ZERO, hardware, &shaft, &deviations, address);
        Amt58 {
            identity: super::identity(ident),
            deviations,
            hooks,
            sensor,
            shaft,
            switches: address,
            termination: [0; 2],
            has_broken_memory: false,
            volts: 24.0,
            stored_offset: NvmCell::new(0),
            stored_address: NvmCell::new(None),
            ram,
        }
    }

    /// Starts up: reads sensor, switches and memory.
    pub(super) fn start(&mut self, now: Time) {
        let hardware = self.hooks.apply(self.sensor, |hooks, hardware| hooks.sensor(hardware));
        self.ram = Amt58VolatileData::new(now, hardware, &self.shaft, &self.deviations, self.switches);
        self.ram.is_unreadable = !self.check(now, Amt58Check::Memory, !self.has_broken_memory);
        let stored = if self.ram.is_unreadable { 0 } else { *self.stored_offset.stored() };
        let offset = self.hooks.apply(stored, |hooks, offset| hooks.load(&self.view(now), offset));
        self.use_offset(offset);
    }

    /// The supply voltage in whole millivolts.
    pub(super) fn millivolts(&self) -> u64 {
        (self.volts * 1000.0 + 0.5).max(0.0) as u64
    }

    pub(super) fn node_number(&self) -> NodeNumber {
        NodeNumber { switches: self.ram.switches, set_by_bus: *self.stored_address.stored() }
    }

    /// The shaft position that the sensor reads, in hardware steps.
    pub(super) fn place(&self, now: Time) -> u64 {
        let place = self.hooks.apply(self.shaft.position(now), |hooks, place| hooks.place(place));
        self.ram.hardware.sense(place)
    }

    /// Measures position and velocity.
    pub(super) fn sample(&mut self, now: Time) {
        let place = self.place(now);
        self.ram.velocity.advance(now, &self.shaft);
        self.ram.measuring.sample(place);
    }

    /// Whether the shaft is in the red zone (6.9).
    pub(super) fn is_in_zone(&self, now: Time) -> bool {
        let Amt58VolatileData { hardware, parameters, measuring, .. } = &self.ram;
        let place = measuring.in_direction(self.place(now));
        parameters.scales && red_zone::is_inside(&parameters.scaling, hardware, place)
    }

    /// Returns what the LEDs show now (4.9).
    pub(super) fn leds(&self, now: Time, seen: &SlaveStatus) -> Leds {
        let situation = Situation {
            status: *seen,
            is_unreadable: self.ram.is_unreadable,
            has_expired: self.ram.has_expired,
            is_invalid: self.ram.is_invalid,
            is_in_zone: self.check(now, Amt58Check::RedZone, self.is_in_zone(now)),
        };
        let leds = leds::leds(&situation);
        self.hooks.apply(leds, |hooks, leds| hooks.leds(&self.view(now), &situation, leds))
    }
}

impl Amt58VolatileData {
    fn new(
        now: Time,
        hardware: Hardware,
        shaft: &Shaft,
        deviations: &EncoderDeviations,
        switches: u8,
    ) -> Amt58VolatileData {
        let parameters = EncoderParameters::before_set_prm(&hardware);
        let place = hardware.sense(shaft.position(now));
        let mut measuring = Measuring::new(hardware, place, deviations.measuring.clone());
        measuring.settings = parameters.settings();
        Amt58VolatileData {
            switches,
            hardware,
            parameters,
            measuring,
            velocity: Velocity::new(WINDOW, parameters.unit, hardware, now, shaft, deviations.velocity.clone()),
            offset: 0,
            preset_cycles: 0,
            is_unreadable: false,
            has_expired: false,
            is_invalid: false,
        }
    }
}
