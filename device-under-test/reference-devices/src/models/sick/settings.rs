//! Settings and their limits: elements of a parameter, the scaling, the unit of the velocity.

use alloc::vec::Vec;
use encoder_profile::encoder::{Hardware, Unit};
use encoder_profile::profidrive::user_parameters::UserParameters;

/// The elements that are written from `subindex` on, and their values.
pub fn elements(subindex: u16, values: &[u64]) -> Vec<(usize, u64)> {
    (usize::from(subindex)..).zip(values.iter().copied()).collect()
}

/// Whether the hardware can serve a scaling: 1 to all steps a revolution, and a range of 2^n revolutions, as far as the
/// hardware tells them apart.
pub fn serves(user: &UserParameters, hardware: &Hardware) -> bool {
    let (units, range) = (user.units_per_revolution, user.range);
    (1..=hardware.steps_per_revolution).contains(&units)
        && range.is_multiple_of(units)
        && (range / units).is_power_of_two()
        && range / units <= hardware.revolutions
}

/// The velocity units by their numbers, of which there is one more than the profile has.
pub const VELOCITY_UNITS: &[Unit] =
    &[Unit::PerSecond, Unit::Per100Milliseconds, Unit::Per10Milliseconds, Unit::Rpm, Unit::RevolutionsPerSecond];

/// The velocity unit of a number.
pub fn unit(number: u16) -> Option<Unit> {
    VELOCITY_UNITS.get(usize::from(number)).copied()
}
