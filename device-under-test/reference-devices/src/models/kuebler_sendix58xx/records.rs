//! The records: the operating status in 0xBF00 and the preset value in 0xB02E, chapter 9.

use super::Sendix;
use alloc::vec::Vec;
use device_stack::profinet::{RecordAccess, RecordRefusal};
use encoder_profile::checks::EncoderCheck;
use encoder_profile::encoder_object::PoweredEncoder;
use encoder_profile::profidrive::parameters::ParameterStore;
use wire::profidrive::ErrorNumber;

/// Written: the user parameters. Read: the operating status.
const STATUS: u16 = 0xBF00;
const PRESET_VALUE: u16 = 65000;
const OPERATING_STATUS: u16 = 65001;

/// Reads 0xBF00: double words, most significant byte first.
pub fn read(
    live: &mut PoweredEncoder<'_, Sendix>,
    access: RecordAccess,
    out: &mut Vec<u8>,
) -> Option<Result<(), RecordRefusal>> {
    if access.index != STATUS || !live.is_at_access_point(&access) {
        return None;
    }
    let status = live.parameter(OPERATING_STATUS)?;
    out.extend(status.values.into_iter().flat_map(|word| (word as u32).to_be_bytes()));
    Some(Ok(()))
}

/// Refuses a preset value whose magnitude is not below the range that will be in force.
pub fn write(live: &mut PoweredEncoder<'_, Sendix>, number: u16, values: &[u64]) -> Option<Result<(), ErrorNumber>> {
    let value = *values.first().filter(|_| number == PRESET_VALUE)? as u32;
    let range = range(live);
    if live.deviations.checks.check(EncoderCheck::PresetValue { value, range }, fits(value, range)) {
        None
    } else {
        Some(Err(ErrorNumber::LIMIT))
    }
}

/// The range of the latest parameters of this connection.
fn range(live: &PoweredEncoder<'_, Sendix>) -> u64 {
    live.ram.staged.settings(&live.encoder()).scaling.range
}

/// Whether the magnitude of a preset value is below the range: chapter 7.
fn fits(value: u32, range: u64) -> bool {
    u64::from((value as i32).unsigned_abs()) < range
}
