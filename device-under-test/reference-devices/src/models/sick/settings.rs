//! Settings and their limits: elements of a parameter, the scaling, the velocity unit.

use super::hooks::{SickCheck, SickDeviations};
use alloc::vec::Vec;
use core::ops::RangeInclusive;
use encoder_profile::encoder::{Hardware, VelocityUnit};
use encoder_profile::profidrive::user_parameters::UserParameterData;
use wire::profidrive::ErrorNumber;

/// The settings of a parameter before a write.
#[derive(Debug)]
pub struct SettingWrite<'a> {
    /// The number of the parameter.
    pub number: u16,
    /// The elements of the parameter.
    pub elements: Vec<i64>,
    /// The resolution of the encoder.
    pub hardware: &'a Hardware,
}

impl SettingWrite<'_> {
    /// Returns the settings after writing `values` from `subindex` on.
    ///
    /// # Errors
    ///
    /// The error number of the first value beyond the limits of its element; then no value is written.
    pub fn written(
        self,
        subindex: u16,
        values: impl Iterator<Item = i64>,
        limits: impl Fn(usize) -> (RangeInclusive<i64>, ErrorNumber),
        hooks: &SickDeviations,
    ) -> Result<Vec<i64>, ErrorNumber> {
        let SettingWrite { number, elements: before, hardware } = self;
        let mut written = before.clone();
        for (at, value) in (usize::from(subindex)..).zip(values) {
            let (range, refusal) = limits(at);
            if !hooks.check(SickCheck::Setting((number, at), value), range.contains(&value)) {
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

/// Returns the elements that a write from `subindex` on changes, with their values.
pub fn elements(subindex: u16, values: &[u64]) -> Vec<(usize, u64)> {
    (usize::from(subindex)..).zip(values.iter().copied()).collect()
}

/// Returns whether the hardware can serve a scaling: 1 to all steps per revolution, and a range of 2^n revolutions, at most those of
/// the hardware.
pub fn serves(user: &UserParameterData, hardware: &Hardware) -> bool {
    let (units, range) = (user.units_per_revolution, user.range);
    (1..=hardware.steps_per_revolution).contains(&units)
        && range.is_multiple_of(units)
        && (range / units).is_power_of_two()
        && range / units <= hardware.revolutions
}

/// The velocity units by number. The last one is not in the profile.
pub const VELOCITY_UNITS: &[VelocityUnit] = &[
    VelocityUnit::PerSecond,
    VelocityUnit::Per100Milliseconds,
    VelocityUnit::Per10Milliseconds,
    VelocityUnit::Rpm,
    VelocityUnit::RevolutionsPerSecond,
];

/// Returns the velocity unit with this number.
pub fn unit(number: u16) -> Option<VelocityUnit> {
    VELOCITY_UNITS.get(usize::from(number)).copied()
}
