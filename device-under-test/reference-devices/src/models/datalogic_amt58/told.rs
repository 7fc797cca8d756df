//! What the encoder tells: its inputs, and the octets behind the six of the diagnosis (manual, 6.6 and 6.7).

use super::knobs::Told;
use super::program::Program;
use alloc::vec::Vec;
use encoder_profile::encoder::Hardware;

/// What the inputs are put together from.
#[derive(Clone, Copy, Debug)]
pub struct Shown<'a> {
    /// The position.
    pub position: u32,
    /// The velocity.
    pub velocity: i32,
    /// The inputs before.
    pub before: [u8; 8],
    /// The inputs before, if nothing were wrong.
    pub truth_before: (u32, i32),
    /// The outputs of this cycle and of the one before.
    pub outputs: [u32; 2],
    /// The program in force.
    pub program: &'a Program,
    /// The hardware.
    pub hardware: &'a Hardware,
    /// The place of the shaft, counted over any number of revolutions.
    pub endless: i64,
    /// The place that the sensor sees, counted in the direction in force.
    pub place: u64,
    /// Whether a preset was made since the inputs before.
    pub is_preset: bool,
    /// How many inputs there were since power-up.
    pub count: u32,
    /// The offset of all presets.
    pub offset: i64,
}

/// Position and velocity, most significant octet first.
pub fn inputs(shown: &Shown<'_>, octets: &mut [u8]) {
    let mut all = shown.position.to_be_bytes().to_vec();
    all.extend_from_slice(&shown.velocity.to_be_bytes());
    put(octets, &all);
}

/// Puts as many octets as there is room for.
pub fn put(octets: &mut [u8], all: &[u8]) {
    octets.fill(0);
    for (octet, told) in octets.iter_mut().zip(all) {
        *octet = *told;
    }
}

const VERSION_OF_PROFILE: [u8; 2] = [1, 1];
const VERSION_OF_SOFTWARE: [u8; 2] = [0, 2];

/// Octets 6 to 15, or 6 to 62 if the diagnosis is extended.
pub fn diagnosis(told: &Told<'_>, shown_offset: i64, out: &mut Vec<u8>) {
    let Told { program, hardware, .. } = *told;
    let word = |number: u64| (number as u32).to_be_bytes();
    let begin = out.len();
    out.extend_from_slice(&[0, 0, program.operating, u8::from(hardware.revolutions > 1)]);
    out.extend_from_slice(&word(hardware.steps_per_revolution));
    out.extend_from_slice(&(hardware.revolutions as u16).to_be_bytes());
    if program.is_extended {
        // Additional alarms, supported alarms, warnings, supported warnings.
        out.extend_from_slice(&[0; 7]);
        out.extend_from_slice(&VERSION_OF_PROFILE);
        out.extend_from_slice(&VERSION_OF_SOFTWARE);
        // The operating time is not counted.
        out.extend_from_slice(&[0; 4]);
        out.extend_from_slice(&(shown_offset as i32).to_be_bytes());
        // Offset of the maker.
        out.extend_from_slice(&[0; 4]);
        out.extend_from_slice(&word(program.scaling.units_per_revolution));
        out.extend_from_slice(&word(program.scaling.range));
        // Serial number, reserved.
        out.extend_from_slice(&[0; 16]);
    }
    let length = out.len() - begin;
    if let Some(header) = out.get_mut(begin) {
        *header = length as u8;
    }
}
