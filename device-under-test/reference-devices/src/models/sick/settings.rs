//! Settings and their limits: elements of a parameter, the scaling, the unit of the velocity.

use alloc::vec::Vec;
use encoder_profile::encoder::{Scaling, Unit};
use encoder_profile::profidrive::user_parameters::{self, Asked};

/// The elements that are written from `subindex` on, and their values.
pub fn elements(subindex: u16, values: &[u64]) -> Vec<(usize, u64)> {
    (usize::from(subindex)..).zip(values.iter().copied()).collect()
}

/// Whether the hardware can serve a scaling: 1 to all steps a revolution, and a range of 2^n revolutions, as far as the
/// hardware tells them apart.
pub fn serves(asked: &Asked) -> bool {
    let Asked { scaling: Scaling { units_per_revolution: units, range }, hardware, .. } = *asked;
    (1..=hardware.steps_per_revolution).contains(&units)
        && range.is_multiple_of(units)
        && (range / units).is_power_of_two()
        && range / units <= hardware.revolutions
}

/// The velocity unit of a number, of which there is one more than the profile has.
pub fn unit(number: u16) -> Option<Unit> {
    match number {
        4 => Some(Unit::RevolutionsPerSecond),
        _ => user_parameters::unit(number.try_into().ok()?),
    }
}
