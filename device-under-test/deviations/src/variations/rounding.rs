//! Positions that are rounded to the nearest one, where a manual prints no rounding.

use encoder_profile::encoder::{Gear, Hardware, Scaling};

/// The scaled position nearest to a place of the shaft, in hardware steps.
pub fn nearest_position(scaling: &Scaling, hardware: &Hardware, place: u64) -> u64 {
    let (units, steps) = (u128::from(scaling.units_per_revolution), u128::from(hardware.steps_per_revolution));
    scaling.within_range((u128::from(place) * units + steps / 2) / steps)
}

/// The position of a gear nearest to a place of the shaft over all laps.
pub fn nearest_of_gear(gear: &Gear, hardware: &Hardware, place: i128) -> u64 {
    let above = place * i128::from(gear.range) * i128::from(gear.divisor);
    let below = (i128::from(gear.nominator) * i128::from(hardware.steps_per_revolution)).max(1);
    (2 * above + below).div_euclid(2 * below).rem_euclid(i128::from(gear.range.max(1))) as u64
}
