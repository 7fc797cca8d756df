//! The round axis: what its gear makes of the encoder, and its laps, which are kept without power.
//!
//! Laps are counted for one gear and begin anew with another one. They make the range offset that P1009 shows.

use super::knobs::Rules;
use encoder_profile::encoder::{Gear, Hardware, Measuring, Scaling, Settings};

/// Range offsets go on from 0 again here: above the largest one, 80000000h.
pub const RANGE_OFFSETS: u64 = 0x8000_0001;
/// The largest total resolution.
pub const LARGEST_RANGE: u64 = 1 << 30;
/// The largest nominator and divisor.
pub const LARGEST_FRACTION: u64 = 0x1_0000;

/// The laps of the encoder that the axis needs.
#[derive(Clone, Copy, Debug, Default)]
pub struct Laps {
    /// The gear that they are counted for.
    counted: Option<Gear>,
    laps: i64,
    /// Where the encoder stood last.
    place: Option<u64>,
}

impl Laps {
    /// Makes of the laps what `change` says.
    pub fn change(&mut self, change: fn(i64) -> i64) {
        self.laps = change(self.laps);
    }

    /// Counts laps from now on, if they were counted for another gear than the one in force.
    pub fn count_for(&mut self, measuring: &mut Measuring, place: u64) {
        let Some(gear) = measuring.settings.gear else { return };
        if self.counted.replace(gear) != Some(gear) {
            measuring.laps = 0;
        }
        self.keep(measuring, place);
    }

    /// Keeps the laps.
    pub fn keep(&mut self, measuring: &Measuring, place: u64) {
        (self.laps, self.place) = (measuring.laps, Some(place));
    }

    /// Goes on with the laps that were kept; a way without power is taken for the shorter one.
    pub fn recall(&self, measuring: &mut Measuring, rules: &Rules) {
        match self.place {
            Some(place) if rules.counts_way_without_power => measuring.recall(place, self.laps),
            Some(_) => measuring.laps = self.laps,
            None => {}
        }
    }
}

/// The settings with a gear.
pub fn geared(settings: Settings, gear: Gear) -> Settings {
    let units = gear.range * gear.divisor / gear.nominator.max(1);
    let scaling = Scaling { units_per_revolution: units.max(1), range: gear.range };
    Settings { scaling, gear: Some(gear), ..settings }
}

/// By how much so many laps shift the position of an axis.
pub fn range_of_laps(gear: &Gear, hardware: &Hardware, laps: i64) -> u64 {
    gear.position(hardware, i128::from(laps) * i128::from(hardware.range()))
}

/// Units per revolution of the encoder, in whole units and thousandths.
pub fn units_per_revolution(gear: &Gear) -> [u64; 2] {
    let above = gear.range * gear.divisor;
    let below = gear.nominator.max(1);
    [above / below, above % below * 1000 / below]
}
