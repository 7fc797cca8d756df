//! The identifiers of the configuration, and the inputs (manual, 6.5 and 6.6).

use super::encoder::Amt58;
use super::set_prm::EncoderParameters;
use station::Time;
use wire::profibus::cfg::{Identifier, IoLengths, io_lengths};

/// 4 input bytes and 4 output bytes: Class 1 and Class 2 (6.5).
pub const POSITION: [u8; 2] = [0xD1, 0xE1];
/// 8 input bytes and 4 output bytes: Class 2 with velocity (6.5).
pub const POSITION_AND_VELOCITY: [u8; 2] = [0xD3, 0xE1];

impl EncoderParameters {
    /// Returns the configuration identifiers of the class.
    pub fn identifiers(&self) -> [u8; 2] {
        if self.has_velocity { POSITION_AND_VELOCITY } else { POSITION }
    }
}

/// Sums the input and output lengths of configuration identifiers; 0 if they cannot be parsed.
pub fn lengths(identifiers: &[u8]) -> IoLengths {
    Identifier::parse_all(identifiers).map(|all| io_lengths(&all)).unwrap_or_default()
}

impl Amt58 {
    /// Writes the inputs: the position, followed by the velocity if there is space for it (6.6).
    pub(super) fn write_inputs(&mut self, now: Time, data: &mut [u8]) {
        self.sample(now);
        let ram = &self.ram;
        let position = ram.measuring.shifted() as u32;
        let velocity = ram.velocity.value(&ram.parameters.scaling, ram.parameters.direction) as i32;
        let octets = [position.to_be_bytes(), velocity.to_be_bytes()];
        data.fill(0);
        for (octet, value) in data.iter_mut().zip(octets.as_flattened()) {
            *octet = *value;
        }
        self.hooks.notify(|hooks| hooks.inputs(&self.view(now), data));
    }
}
