//! Settings and their limits: elements of a parameter, the scaling, the unit of the velocity.

use super::hooks::{Check, Hooks};
use alloc::vec::Vec;
use core::ops::RangeInclusive;
use encoder_profile::encoder::{Hardware, VelocityUnit};
use encoder_profile::profidrive::user_parameters::UserParameterData;
use wire::profidrive::ErrorNumber;

/// The settings of a parameter, as they are before a write.
#[derive(Debug)]
pub struct Settings<'a> {
    /// The number of the parameter.
    pub number: u16,
    /// Its elements.
    pub elements: Vec<i64>,
    /// The encoder that they are for.
    pub hardware: &'a Hardware,
}

impl Settings<'_> {
    /// What they become when `values` are written from `subindex` on; the write is refused as a whole if one of the values is
    /// beyond the limits of its element.
    pub fn written(
        self,
        subindex: u16,
        values: impl Iterator<Item = i64>,
        limits: impl Fn(usize) -> (RangeInclusive<i64>, ErrorNumber),
        hooks: &Hooks,
    ) -> Result<Vec<i64>, ErrorNumber> {
        let Settings { number, elements: before, hardware } = self;
        let mut written = before.clone();
        for (at, value) in (usize::from(subindex)..).zip(values) {
            let (range, refusal) = limits(at);
            if !hooks.check(Check::Setting((number, at), value), range.contains(&value)) {
                return Err(refusal);
            }
            if let Some(element) = written.get_mut(at) {
                *element = value;
            }
        }
        hooks.seams.notify(|hooks| hooks.settings(number, hardware, &before, &mut written));
        Ok(written)
    }
}

/// The elements that are written from `subindex` on, and their values.
pub fn elements(subindex: u16, values: &[u64]) -> Vec<(usize, u64)> {
    (usize::from(subindex)..).zip(values.iter().copied()).collect()
}

/// Whether the hardware can serve a scaling: 1 to all steps a revolution, and a range of 2^n revolutions, as far as the
/// hardware tells them apart.
pub fn serves(user: &UserParameterData, hardware: &Hardware) -> bool {
    let (units, range) = (user.units_per_revolution, user.range);
    (1..=hardware.steps_per_revolution).contains(&units)
        && range.is_multiple_of(units)
        && (range / units).is_power_of_two()
        && range / units <= hardware.revolutions
}

/// The velocity units by their numbers, of which there is one more than the profile has.
pub const VELOCITY_UNITS: &[VelocityUnit] = &[
    VelocityUnit::PerSecond,
    VelocityUnit::Per100Milliseconds,
    VelocityUnit::Per10Milliseconds,
    VelocityUnit::Rpm,
    VelocityUnit::RevolutionsPerSecond,
];

/// The velocity unit of a number.
pub fn unit(number: u16) -> Option<VelocityUnit> {
    VELOCITY_UNITS.get(usize::from(number)).copied()
}
