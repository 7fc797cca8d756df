//! Scaling: from hardware steps to units of the user.

/// The resolution of the sensor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hardware {
    /// Steps per revolution, at least 1.
    pub steps_per_revolution: u64,
    /// Revolutions, 1 for a singleturn encoder.
    pub revolutions: u64,
}

impl Hardware {
    /// Steps over all revolutions.
    #[inline]
    pub const fn range(&self) -> u64 {
        self.steps_per_revolution * self.revolutions
    }

    /// The sensor reading for a shaft position, in hardware steps. The shaft position is unbounded; the reading wraps
    /// at the end of the revolutions of the sensor.
    #[inline]
    pub fn sense(&self, place: i64) -> u64 {
        let range = self.range();
        match i64::try_from(range) {
            Ok(range) if (0..range).contains(&place) => place as u64,
            Ok(range) => place.rem_euclid(range) as u64,
            Err(_) => i128::from(place).rem_euclid(range as i128) as u64,
        }
    }
}

/// The direction in which the position increases, viewed from the shaft end (code sequence).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CountingDirection {
    /// The position increases clockwise.
    Clockwise,
    /// The position increases counter-clockwise.
    Counterclockwise,
}

/// Units per revolution, and the range after which the position restarts at 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scaling {
    /// Units per revolution.
    pub units_per_revolution: u64,
    /// Total measuring range in units; positions run from 0 to `range` - 1.
    pub range: u64,
}

impl Scaling {
    /// One unit per hardware step.
    pub const fn hardware(hardware: &Hardware) -> Scaling {
        Scaling { units_per_revolution: hardware.steps_per_revolution, range: hardware.range() }
    }

    /// The position for a sensor reading, counted from the physical zero.
    ///
    /// The conversion is stateless and rounds down, so that errors do not accumulate. If the hardware range is no
    /// multiple of the scaled range, the last range before the physical zero is incomplete: the *red zone*.
    pub fn position(&self, hardware: &Hardware, place: u64) -> u64 {
        self.within_range(self.units(hardware, place))
    }

    /// `units` modulo the range.
    pub fn within_range(&self, units: u128) -> u64 {
        let range = self.range.max(1);
        // Nearly always the number is small, and a division of 128 bits is slow.
        match u64::try_from(units) {
            Ok(units) if units < range => units,
            Ok(units) => units % range,
            Err(_) => (units % u128::from(range)) as u64,
        }
    }

    /// The units from the physical zero to a sensor reading, rounded down.
    #[inline]
    pub fn units(&self, hardware: &Hardware, place: u64) -> u128 {
        let (units, steps) = (self.units_per_revolution, hardware.steps_per_revolution);
        if units == steps {
            return place.into();
        }
        match place.checked_mul(units) {
            Some(product) => (product / steps).into(),
            None => u128::from(place) * u128::from(units) / u128::from(steps),
        }
    }
}

/// How positions are counted in the *red zone*: the incomplete last range before the physical zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RedZone {
    /// The positions start with 0; those at the end of the range are missing (manual of the XAC77, 11.5).
    FromZero,
    /// The positions end with the last one of the range; those at the beginning are missing (manual of the AMT58,
    /// 6.9).
    ToTheEnd,
}

impl RedZone {
    /// The position for a sensor reading.
    pub fn position(self, scaling: &Scaling, hardware: &Hardware, place: u64) -> u64 {
        match self {
            RedZone::FromZero => scaling.position(hardware, place),
            RedZone::ToTheEnd => {
                let (units, all) = (scaling.units(hardware, place), scaling.units(hardware, hardware.range()));
                let zone = u128::from(scaling.within_range(all));
                if units >= all - zone {
                    (u128::from(scaling.range.max(1)) + units).saturating_sub(all) as u64
                } else {
                    scaling.within_range(units)
                }
            }
        }
    }
}

/// A gear between the encoder and a round axis, whose position is output.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Gear {
    /// Revolutions of the encoder, at least 1.
    pub nominator: u64,
    /// Revolutions of the axis for these, at least 1.
    pub divisor: u64,
    /// Units per revolution of the axis, at least 1; positions run from 0 to `range` - 1.
    pub range: u64,
}

impl Gear {
    /// The position of the axis for a shaft position over any number of revolutions, in units, rounded down.
    ///
    /// Errors do not accumulate and the position does not jump, even if the revolutions of the encoder are no whole
    /// number of revolutions of the axis.
    pub fn position(&self, hardware: &Hardware, place: i128) -> u64 {
        if let Some((above, below)) = self.short(hardware, place) {
            return above.div_euclid(below.max(1)).rem_euclid((self.range as i64).max(1)) as u64;
        }
        let above = place * i128::from(self.range) * i128::from(self.divisor);
        let below = i128::from(self.nominator) * i128::from(hardware.steps_per_revolution);
        above.div_euclid(below.max(1)).rem_euclid(i128::from(self.range.max(1))) as u64
    }

    /// Numerator and denominator of the position, if both fit into 64 bits: a division of 128 bits is slow.
    fn short(&self, hardware: &Hardware, place: i128) -> Option<(i64, i64)> {
        let short = |number: u64| i64::try_from(number).ok();
        let above = i64::try_from(place).ok()?.checked_mul(short(self.range)?)?.checked_mul(short(self.divisor)?)?;
        let below = short(self.nominator)?.checked_mul(short(hardware.steps_per_revolution)?)?;
        Some((above, below))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    const MULTITURN: Hardware = Hardware { steps_per_revolution: 65536, revolutions: 16384 };
    const SINGLETURN: Hardware = Hardware { steps_per_revolution: 262_144, revolutions: 1 };

    fn scaling(units_per_revolution: u64, range: u64) -> Scaling {
        Scaling { units_per_revolution, range }
    }

    // The example of the XAC77 manual, 11.5: 65536 x 6748 = 442236928, red zone of 189267968 positions.
    #[rstest]
    #[case(0, 0)]
    #[case(442_236_927, 442_236_927)]
    #[case(442_236_928, 0)]
    #[case(884_473_855, 442_236_927)]
    #[case(884_473_856, 0)]
    #[case(1_073_741_823, 189_267_967)]
    fn red_zone_of_the_example_of_the_manual(#[case] place: u64, #[case] position: u64) {
        assert_eq!(scaling(65536, 442_236_928).position(&MULTITURN, place), position);
    }

    #[rstest]
    #[case::hardware(scaling(65536, 1 << 30), 65536, 65536)]
    #[case::coarse(scaling(4096, 1 << 24), 65536, 4096)]
    #[case::coarse_range_ends(scaling(4096, 1 << 24), 65536 * 4096, 0)]
    #[case::no_power_of_two(scaling(3600, 3600 * 4096), 65536 / 2, 1800)]
    #[case::rounded_down(scaling(1, 16384), 65535, 0)]
    #[case::range_below_a_revolution(scaling(4096, 1024), 65536 / 4, 0)]
    fn multiturn(#[case] scaling: Scaling, #[case] place: u64, #[case] position: u64) {
        assert_eq!(scaling.position(&MULTITURN, place), position);
    }

    #[rstest]
    #[case(3600, 3600, 131_072, 1800)]
    #[case(1000, 1000, 262_143, 999)]
    #[case(3600, 3600, 262_143, 3599)]
    fn singleturn(#[case] units: u64, #[case] range: u64, #[case] place: u64, #[case] position: u64) {
        assert_eq!(scaling(units, range).position(&SINGLETURN, place), position);
    }

    #[rstest]
    #[case(-1, 262_143)]
    #[case(262_144, 0)]
    #[case(262_145 * -262_144, 0)]
    fn a_singleturn_sensor_wraps_at_one_revolution(#[case] place: i64, #[case] reading: u64) {
        assert_eq!(SINGLETURN.sense(place), reading);
    }

    /// AMT58 manual, 6.9: 3 x 4096 of the 16384 revolutions are a range, and the last 4096 are the red zone.
    #[rstest]
    #[case::end_of_the_range(0x2FFF_FFFF, 0x2FFF_FFFF)]
    #[case::begin_of_the_zone(0x3000_0000, 0x2000_0000)]
    #[case::last_step(0x3FFF_FFFF, 0x2FFF_FFFF)]
    fn a_red_zone_to_the_end(#[case] place: u64, #[case] position: u64) {
        assert_eq!(RedZone::ToTheEnd.position(&scaling(65536, 0x3000_0000), &MULTITURN, place), position);
    }

    /// AFS60/AFM60 manual, 3.2.2: a table of 3600 units that turns once while the encoder turns 12.5 times (25 : 2).
    #[rstest]
    #[case::start(0, 0)]
    #[case::half_a_table(25 * 262_144 / 4, 1800)]
    #[case::last_unit(25 * 262_144 / 2 - 1, 3599)]
    #[case::one_table(25 * 262_144 / 2, 0)]
    #[case::one_step_back(-1, 3599)]
    #[case::beyond_all_revolutions(4096 * 262_144, 2448)]
    fn a_round_axis(#[case] place: i128, #[case] position: u64) {
        let hardware = Hardware { steps_per_revolution: 262_144, revolutions: 4096 };
        let gear = Gear { nominator: 25, divisor: 2, range: 3600 };
        assert_eq!(gear.position(&hardware, place), position);
    }
}
