//! A DP encoder of the encoder profile 3.062 (classes 1 and 2), which follows no manual.
//!
//! It is an AMT58 with another ident number and sensor: that manual adds to the profile only the velocity, the choice of the diagnosis and
//! the byte for the unit.

use super::datalogic_amt58::Amt58;
use super::datalogic_amt58::hooks::Amt58Hooks;
use device_stack::Attached;
use encoder_profile::deviations::EncoderDeviations;
use encoder_profile::encoder::Hardware;

/// The ident number; invented.
const IDENT: u16 = 0xFEEC;
/// The sensor; invented.
const SENSOR: Hardware = Hardware { steps_per_revolution: 16_384, revolutions: 4096 };

/// Creates an encoder with its shaft at `shaft` and its switches at `address`.
pub fn new(deviations: EncoderDeviations, hooks: Attached<dyn Amt58Hooks>, shaft: u64, address: u8) -> Amt58 {
    Amt58::new(IDENT, SENSOR, deviations, hooks, shaft, address)
}
