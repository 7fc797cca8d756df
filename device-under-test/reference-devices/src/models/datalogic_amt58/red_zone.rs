//! The red zone: the positions before the physical zero where the number of revolutions is no power of two (manual, 6.9).

use encoder_profile::encoder::{Hardware, Scaling};

/// Returns the units of all revolutions, and how many of them at the end are less than a whole range: the red zone.
pub fn zone(scaling: &Scaling, hardware: &Hardware) -> (u128, u128) {
    let all = scaling.units(hardware, hardware.range());
    (all, scaling.within_range(all).into())
}

/// Returns whether a shaft position, counted in the direction of the code sequence, is in the red zone of this scaling.
pub fn is_inside(scaling: &Scaling, hardware: &Hardware, place: u64) -> bool {
    let (all, zone) = zone(scaling, hardware);
    zone > 0 && scaling.units(hardware, place) >= all - zone
}
