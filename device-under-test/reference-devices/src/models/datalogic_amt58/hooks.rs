//! The hooks of an AMT58: the seams, checks and steps at which a deviation may change what it does.
//!
//! The encoder itself is plain. Without the feature `deviations` no hook is ever called.

use super::encoder::Amt58;
use super::leds::{Leds, Situation};
use super::node_number::NodeNumber;
use super::scaling::SentScaling;
use super::set_prm::EncoderParameters;
use alloc::vec::Vec;
use device_stack::profibus::DiagnosisBits;
use encoder_profile::encoder::{Hardware, Measuring, Shaft, Velocity};
use station::Time;

/// The encoder, for a deviation to read.
#[derive(Debug)]
pub struct View<'a> {
    /// Now.
    pub now: Time,
    /// The hardware.
    pub hardware: Hardware,
    /// The shaft.
    pub shaft: &'a Shaft,
    /// The parameters in force.
    pub parameters: &'a EncoderParameters,
    /// The measuring task.
    pub measuring: &'a Measuring,
    /// The velocity.
    pub velocity: &'a Velocity,
    /// The offset of all presets.
    pub offset: i64,
    /// Whether the memory could not be read at power-up.
    pub is_unreadable: bool,
    /// Whether the shaft is in the red zone.
    pub is_in_zone: bool,
}

/// A decision of the encoder, with what it is about; the comment says what `true` means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Check<'a> {
    /// The memory can be read at power-up.
    Memory,
    /// Set_Prm has as many user octets as these parameters need.
    UserOctets(&'a [u8]),
    /// These operating parameters turn scaling on.
    Scales(u8),
    /// These operating parameters select the extended diagnosis.
    IsExtended(u8),
    /// These operating parameters add the velocity to the inputs.
    HasVelocity(u8),
    /// The scaling, which acts, is possible.
    Scaling(SentScaling),
    /// There is a unit of the velocity with this code.
    Unit(u8),
    /// Bit 31 of the outputs has been set in so many cycles in a row that a preset is made now.
    PresetCycles(u32),
    /// The value of a preset is within the range of positions.
    PresetValue(u64),
    /// The LEDs show the red zone.
    RedZone,
}

/// Why the offset of presets is set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NewOffset {
    /// A preset is made.
    Preset,
    /// Set_Prm was taken, which leaves the offset as it is.
    SetPrm,
}

/// The hooks of an AMT58; each default changes nothing.
#[allow(unused_variables, reason = "the names say what a hook is given")]
pub trait Amt58Hooks {
    /// The decision that counts, from what it is about and the decision of the manual.
    fn check(&mut self, view: &View<'_>, check: Check<'_>, verdict: bool) -> bool {
        verdict
    }

    /// What the sensor distinguishes, as it is read at power-up.
    fn sensor(&mut self, hardware: Hardware) -> Hardware {
        hardware
    }

    /// The place of the shaft in hardware steps, over any number of revolutions.
    fn place(&mut self, place: i64) -> i64 {
        place
    }

    /// The address that the slave takes when it starts.
    fn address(&mut self, of: &NodeNumber, address: u8) -> u8 {
        address
    }

    /// The outputs of a cycle as they arrive, 0 where they are cleared or missing.
    fn outputs(&mut self, view: &View<'_>, outputs: u32) -> u32 {
        outputs
    }

    /// Changes the inputs before they are sent.
    fn inputs(&mut self, view: &View<'_>, inputs: &mut [u8]) {}

    /// Changes the octets behind the six of the diagnosis, and the bits in the six that belong to them.
    fn diagnosis(&mut self, view: &View<'_>, octets: &mut Vec<u8>, bits: DiagnosisBits) -> DiagnosisBits {
        bits
    }

    /// What the LEDs show.
    fn leds(&mut self, view: &View<'_>, of: &Situation, leds: Leds) -> Leds {
        leds
    }

    /// The offset that is written to the memory; none leaves the memory as it is.
    fn store(&mut self, view: &View<'_>, offset: Option<i64>) -> Option<i64> {
        offset
    }

    /// The offset that is read from the memory at power-up.
    fn load(&mut self, view: &View<'_>, offset: i64) -> i64 {
        offset
    }

    /// The supply has gone.
    fn power_down(&mut self, view: &View<'_>) {}

    /// Step: the parameters that come into force, from the user octets of Set_Prm; `view` has those before.
    fn parameters(&mut self, view: &View<'_>, user: &[u8], parameters: EncoderParameters) -> EncoderParameters {
        parameters
    }

    /// Step: the offset of presets that comes into force; `view` has the one before.
    fn offset(&mut self, view: &View<'_>, cause: NewOffset, offset: i64) -> i64 {
        offset
    }
}

impl Amt58 {
    /// The decision that counts.
    pub(super) fn check(&self, now: Time, check: Check<'_>, verdict: bool) -> bool {
        self.hooks.apply(verdict, |hooks, verdict| hooks.check(&self.view(now), check, verdict))
    }

    /// The encoder as it is now.
    pub(super) fn view(&self, now: Time) -> View<'_> {
        View {
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
