//! The hooks of an AMT58, with which a deviation can change what it does.
//!
//! The encoder itself has no deviations. Without the feature `deviations` no hook is called.

use super::encoder::Amt58;
use super::leds::{Leds, Situation};
use super::node_number::NodeNumber;
use super::scaling::SentScaling;
use super::set_prm::EncoderParameters;
use alloc::vec::Vec;
use device_stack::profibus::DiagnosisBits;
use encoder_profile::encoder::{Hardware, Measuring, Shaft, Velocity};
use station::Time;

/// Read-only view of the encoder, for deviations.
#[derive(Debug)]
pub struct Amt58View<'a> {
    /// The time of the call.
    pub now: Time,
    /// The resolution of the sensor.
    pub hardware: Hardware,
    /// The simulated shaft.
    pub shaft: &'a Shaft,
    /// The parameters in force.
    pub parameters: &'a EncoderParameters,
    /// The measuring task, which calculates positions.
    pub measuring: &'a Measuring,
    /// The velocity measurement.
    pub velocity: &'a Velocity,
    /// The preset offset, with its sign.
    pub offset: i64,
    /// Whether the memory could not be read at power-up.
    pub is_unreadable: bool,
    /// Whether the shaft is in the red zone.
    pub is_in_zone: bool,
}

/// A decision of the encoder with its data; each comment describes `true`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Amt58Check<'a> {
    /// The memory can be read at power-up.
    Memory,
    /// The supply, in millivolts, suffices for the encoder to work.
    Supply(u64),
    /// The line is terminated with the RT switches in these positions.
    Terminated([u32; 2]),
    /// The number of user bytes in Set_Prm is right for these parameters.
    UserOctets(&'a [u8]),
    /// These operating parameters turn scaling on.
    Scales(u8),
    /// These operating parameters select the extended diagnosis.
    IsExtended(u8),
    /// These operating parameters add the velocity to the inputs.
    HasVelocity(u8),
    /// The active scaling is possible.
    Scaling(SentScaling),
    /// The velocity unit with this code exists.
    Unit(u8),
    /// A preset is made now, after this number of consecutive cycles with bit 31 of the outputs.
    PresetCycles(u32),
    /// The preset value is within the range of positions.
    PresetValue(u64),
    /// The LEDs show the red zone.
    RedZone,
}

/// Why the preset offset is set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NewOffset {
    /// A preset is made.
    Preset,
    /// Set_Prm was accepted. It leaves the offset as it is.
    SetPrm,
}

/// The hooks of an AMT58. The default implementations change nothing.
#[allow(unused_variables, reason = "the names say what a hook is given")]
pub trait Amt58Hooks {
    /// Returns the decision to use, given the check and the decision of the manual.
    fn check(&mut self, view: &Amt58View<'_>, check: Amt58Check<'_>, verdict: bool) -> bool {
        verdict
    }

    /// Returns the resolution of the sensor, as read at power-up.
    fn sensor(&mut self, hardware: Hardware) -> Hardware {
        hardware
    }

    /// Returns the position of the shaft in hardware steps, over any number of revolutions.
    fn place(&mut self, place: i64) -> i64 {
        place
    }

    /// Returns the station address at the start of the slave.
    fn address(&mut self, of: &NodeNumber, address: u8) -> u8 {
        address
    }

    /// Returns the outputs of a cycle as they arrive, 0 where they are cleared or missing.
    fn outputs(&mut self, view: &Amt58View<'_>, outputs: u32) -> u32 {
        outputs
    }

    /// Changes the inputs before they are sent.
    fn inputs(&mut self, view: &Amt58View<'_>, inputs: &mut [u8]) {}

    /// Changes the extended diagnosis (the bytes after the first six) and the bits of the first six bytes that belong to it.
    fn diagnosis(&mut self, view: &Amt58View<'_>, octets: &mut Vec<u8>, bits: DiagnosisBits) -> DiagnosisBits {
        bits
    }

    /// Returns what the LEDs show.
    fn leds(&mut self, view: &Amt58View<'_>, of: &Situation, leds: Leds) -> Leds {
        leds
    }

    /// Returns the offset to write to the memory; `None` leaves the memory as it is.
    fn store(&mut self, view: &Amt58View<'_>, offset: Option<i64>) -> Option<i64> {
        offset
    }

    /// Returns the offset that is read from the memory at power-up.
    fn load(&mut self, view: &Amt58View<'_>, offset: i64) -> i64 {
        offset
    }

    /// Called at power-down.
    fn power_down(&mut self, view: &Amt58View<'_>) {}

    /// Returns the parameters that come into force, given the user bytes of Set_Prm; `view` has the previous ones.
    fn parameters(&mut self, view: &Amt58View<'_>, user: &[u8], parameters: EncoderParameters) -> EncoderParameters {
        parameters
    }

    /// Returns the preset offset that comes into force; `view` has the previous one.
    fn offset(&mut self, view: &Amt58View<'_>, cause: NewOffset, offset: i64) -> i64 {
        offset
    }
}

impl Amt58 {
    /// Returns `verdict`, unless a deviation changes it.
    pub(super) fn check(&self, now: Time, check: Amt58Check<'_>, verdict: bool) -> bool {
        self.hooks.apply(verdict, |hooks, verdict| hooks.check(&self.view(now), check, verdict))
    }

    /// Returns the view for the hooks.
    pub(super) fn view(&self, now: Time) -> Amt58View<'_> {
        Amt58View {
            now,
            hardware: self.ram.hardware,
            shaft: &self.shaft,
            parameters: &self.ram.parameters,
            measuring: &self.ram.measuring,
            velocity: &self.ram.velocity,
            offset: self.ram.offset,
            is_unreadable: self.ram.is_unreadable,
            is_in_zone: self.is_in_zone(now),
        }
    }
}
