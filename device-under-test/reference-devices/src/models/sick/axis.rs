//! The round axis: its gear, and its laps, which are retained without power.
//!
//! Laps are counted for one gear and restart with another gear. They determine the range offset that P1009 shows.

use super::hooks::{SickCheck, SickDeviations};
use encoder_profile::encoder::{Gear, Hardware, Measuring, MeasuringSettings, Scaling};
use encoder_profile::profidrive::user_parameters::UserParameterData;

/// Range offsets wrap to 0 here, above the largest one, 80000000h.
pub const RANGE_OFFSETS: u64 = 0x8000_0001;
/// The largest total resolution.
pub const LARGEST_RANGE: u64 = 1 << 30;
/// The largest nominator and divisor.
pub const LARGEST_FRACTION: u64 = 0x1_0000;

/// The laps that are counted for a round axis.
#[derive(Clone, Copy, Debug, Default)]
pub struct Laps {
    /// The gear for which they are counted.
    gear: Option<Gear>,
    counted: Option<CountedLaps>,
}

/// Counted laps and the shaft position at that time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CountedLaps {
    /// The laps.
    pub laps: i64,
    /// The last shaft position, in hardware steps.
    pub place: u64,
}

impl Laps {
    /// Restarts the count if the laps were counted for another gear than the one in force.
    pub fn count_for(&mut self, measuring: &mut Measuring, place: u64) {
        let Some(gear) = measuring.settings.gear else { return };
        if self.gear.replace(gear) != Some(gear) {
            measuring.laps = 0;
        }
        self.store(measuring, place);
    }

    /// Stores the laps and the shaft position.
    pub fn store(&mut self, measuring: &Measuring, place: u64) {
        self.counted = Some(CountedLaps { laps: measuring.laps, place });
    }

    /// Restores the stored laps at power-up, with the shaft at `now`. A movement without power counts in the shorter direction.
    pub fn restore(&self, measuring: &mut Measuring, now: u64, hooks: &SickDeviations) {
        if let Some(counted) = self.counted {
            let counted = hooks.seams.apply(counted, |hooks, counted| hooks.laps_loaded(now, counted));
            measuring.restore(counted.place, counted.laps);
        }
    }
}

/// Returns the settings with the gear, if the round axis is in force.
pub fn geared(
    settings: MeasuringSettings,
    is_on: bool,
    gear: Gear,
    user: &UserParameterData,
    hardware: &Hardware,
    hooks: &SickDeviations,
) -> MeasuringSettings {
    if !hooks.check(SickCheck::RoundAxis, is_on) {
        return settings;
    }
    let gear = hooks.steps.apply(gear, |steps, gear| steps.gear(user, hardware, gear));
    let units = gear.range * gear.divisor / gear.nominator.max(1);
    let scaling = Scaling { units_per_revolution: units.max(1), range: gear.range };
    MeasuringSettings { scaling, gear: Some(gear), ..settings }
}

/// Returns by how many units this number of laps shifts the position of an axis.
pub fn range_of_laps(gear: &Gear, hardware: &Hardware, laps: i64) -> u64 {
    gear.position(hardware, i128::from(laps) * i128::from(hardware.range()))
}

/// Returns the units per revolution of the encoder, in whole units and thousandths.
pub fn units_per_revolution(gear: &Gear) -> [u64; 2] {
    let above = gear.range * gear.divisor;
    let below = gear.nominator.max(1);
    [above / below, above % below * 1000 / below]
}
