//! The extended diagnosis: the bytes after the first six of Slave_Diag (manual, 6.7).

use super::set_prm::EncoderParameters;
use alloc::vec::Vec;
use encoder_profile::encoder::Hardware;

/// Bytes 23 and 24 (5.2).
const VERSION_OF_PROFILE: [u8; 2] = [1, 1];
/// Bytes 25 and 26 (5.2).
const VERSION_OF_SOFTWARE: [u8; 2] = [0, 2];

/// Writes bytes 6 to 15, or 6 to 62 if the diagnosis is extended.
pub fn write(parameters: &EncoderParameters, hardware: &Hardware, offset: i64, out: &mut Vec<u8>) {
    let word = |number: u64| (number as u32).to_be_bytes();
    let begin = out.len();
    // Header, alarms, operating status, encoder type: 1 is multiturn.
    out.extend_from_slice(&[0, 0, parameters.operating, u8::from(hardware.revolutions > 1)]);
    out.extend_from_slice(&word(hardware.steps_per_revolution));
    out.extend_from_slice(&(hardware.revolutions as u16).to_be_bytes());
    if parameters.is_extended {
        // Additional alarms, supported alarms, warnings, supported warnings.
        out.extend_from_slice(&[0; 7]);
        out.extend_from_slice(&VERSION_OF_PROFILE);
        out.extend_from_slice(&VERSION_OF_SOFTWARE);
        // The operating time is not counted.
        out.extend_from_slice(&[0; 4]);
        out.extend_from_slice(&(offset as i32).to_be_bytes());
        // Manufacturer offset value.
        out.extend_from_slice(&[0; 4]);
        out.extend_from_slice(&word(parameters.scaling.units_per_revolution));
        out.extend_from_slice(&word(parameters.scaling.range));
        // Serial number, reserved.
        out.extend_from_slice(&[0; 16]);
    }
    let length = out.len() - begin;
    if let Some(header) = out.get_mut(begin) {
        *header = length as u8;
    }
}
