//! The steps of positions, presets and velocity, as the rows of the tables use them.

use alloc::rc::Rc;
use core::cell::Cell;
use encoder_profile::encoder::measuring::{MeasuringSteps, OffsetSum, PositionBasis, PresetBasis, Sampled};
use encoder_profile::encoder::velocity::{MeasuredWay, Sampling, VelocitySteps, VelocityUnit};
use encoder_profile::encoder::{Gear, Hardware, Measuring, MeasuringSettings, PresetMode, Scaling};

hooks! { Positions: MeasuringSteps
    /// Notes that the sensor was sampled.
    sampled(measuring: &Measuring, how: Sampled);
    /// Changes the range that positions go round.
    range(scaling: &Scaling, hardware: &Hardware) -> u64;
    /// Changes the position without offset.
    position(reading: &PositionBasis) -> u64;
    /// Changes the position with offset.
    shifted(sum: &OffsetSum) -> u64;
    /// Changes the offset that a preset gives.
    preset(preset: &PresetBasis) -> u64;
}

hooks! { Speeds: VelocitySteps
    /// Changes when velocity is measured.
    sampling(unit: VelocityUnit) -> Sampling;
    /// Changes the velocity of a measured way.
    velocity(way: &MeasuredWay) -> i64;
}

impl Positions {
    /// Counts positions without a gear otherwise, from the place in hardware steps.
    pub fn scale(&mut self, mut scale: impl FnMut(&Scaling, &Hardware, u64) -> u64 + 'static) {
        self.position(move |at, right| match at.settings.gear {
            Some(_) => right,
            None => scale(&at.scaling, &at.hardware, at.place),
        });
    }

    /// Counts positions with a gear otherwise, from the place over all laps.
    pub fn gear(&mut self, mut gear: impl FnMut(&Gear, &Hardware, i128) -> u64 + 'static) {
        self.position(move |at, right| match &at.settings.gear {
            Some(of) => gear(of, &at.hardware, at.unwrapped),
            None => right,
        });
    }

    /// Adds an offset that acts otherwise, from the position, the offset and the range.
    pub fn shift(&mut self, mut shift: impl FnMut(u64, u64, u64) -> u64 + 'static) {
        self.shifted(move |sum, right| {
            let within =
                |position: u64| sum.saturates_at.map_or(position, |range| position.min(range.saturating_sub(1)));
            if sum.offset_acts { within(shift(sum.position, sum.offset, sum.range)) } else { right }
        });
    }

    /// Changes the offset that an absolute preset gives.
    pub fn absolute(&mut self, mut offset: impl FnMut(&PresetBasis) -> u64 + 'static) {
        self.preset(move |preset, right| if preset.mode == PresetMode::Absolute { offset(preset) } else { right });
    }

    /// Changes the offset that a relative preset gives.
    pub fn relative(&mut self, mut offset: impl FnMut(&PresetBasis) -> u64 + 'static) {
        self.preset(move |preset, right| if preset.mode == PresetMode::Relative { offset(preset) } else { right });
    }

    /// Lets the position run ahead of what the place says by as many units as `count` makes of each step of the shaft.
    pub fn slip(&mut self, count: impl FnMut(&Step) -> i64 + 'static) -> Slip {
        let slip = Slip::default();
        self.add(Slipping { before: None, slip: slip.clone(), count });
        slip
    }
}

/// By how many units the position is ahead of what the place says.
#[derive(Clone, Debug, Default)]
pub struct Slip(Rc<Cell<i64>>);

impl Slip {
    /// The units.
    pub fn get(&self) -> i64 {
        self.0.get()
    }
}

/// How the encoder came from one sample of the sensor to the next; places are counted in the direction in force.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// The place before and the settings in force then; none at the first sample.
    pub before: Option<(u64, MeasuringSettings)>,
    /// The place now.
    pub now: u64,
    /// The settings in force now.
    pub settings: MeasuringSettings,
    /// The offset of all presets so far.
    pub offset: u64,
    /// The slip so far.
    pub slip: i64,
    /// What the sensor can tell apart.
    pub hardware: Hardware,
}

impl Step {
    /// The hardware steps from the place before to the place now, the shorter way round.
    pub fn way(&self) -> i64 {
        let range = self.hardware.range() as i64;
        let way = self.before.map_or(0, |(before, _)| self.now as i64 - before as i64) + range / 2;
        way.rem_euclid(range) - range / 2
    }

    /// 1 if the way leads over the physical zero forward, -1 backward, 0 if it does not.
    pub fn crossing(&self) -> i64 {
        let Some((before, _)) = self.before else { return 0 };
        (before as i64 + self.way()).div_euclid(self.hardware.range() as i64)
    }

    /// The units that the hardware counts from physical zero to physical zero.
    pub fn units(&self) -> i64 {
        self.settings.scaling.units(&self.hardware, self.hardware.range()) as i64
    }
}

/// A position that is ahead of what the place says.
struct Slipping<F> {
    /// The place and the settings at the last sample.
    before: Option<(u64, MeasuringSettings)>,
    slip: Slip,
    count: F,
}

impl<F: FnMut(&Step) -> i64> MeasuringSteps for Slipping<F> {
    fn sampled(&mut self, measuring: &Measuring, how: Sampled) {
        let Measuring { settings, offset, hardware, place, .. } = *measuring;
        let before = self.before.replace((place, settings)).filter(|_| how == Sampled::Turned);
        let slip = if how == Sampled::Turned { self.slip.get() } else { 0 };
        let before = before.map(|(place, settings)| (measuring.in_direction(place), settings));
        let step = Step { before, now: measuring.in_direction(place), settings, offset, slip, hardware };
        self.slip.0.set(if how == Sampled::Put { 0 } else { (self.count)(&step) });
    }

    fn position(&mut self, reading: &PositionBasis, position: u64) -> u64 {
        match (reading.settings.gear, self.slip.get()) {
            (Some(_), _) | (None, 0) => position,
            (None, slip) => {
                let range = i128::from(reading.scaling.range.max(1));
                (i128::from(position) + i128::from(slip)).rem_euclid(range) as u64
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;
    use core::cell::RefCell;
    use device_stack::Attached;
    use encoder_profile::encoder::CountingDirection;
    use rstest::rstest;

    const MULTITURN: Hardware = Hardware { steps_per_revolution: 65536, revolutions: 16384 };

    #[rstest]
    #[case::first(None, 5, 0, 0)]
    #[case::forward(Some(5), 15, 10, 0)]
    #[case::backward(Some(15), 5, -10, 0)]
    #[case::over_zero(Some((1 << 30) - 3), 4, 7, 1)]
    #[case::back_over_zero(Some(4), (1 << 30) - 3, -7, -1)]
    #[case::to_zero(Some((1 << 30) - 1), 0, 1, 1)]
    #[case::from_zero(Some(0), (1 << 30) - 1, -1, -1)]
    fn steps(#[case] before: Option<u64>, #[case] now: u64, #[case] way: i64, #[case] crossing: i64) {
        let settings = MeasuringSettings::hardware(&MULTITURN);
        let before = before.map(|before| (before, settings));
        let step = Step { before, now, settings, offset: 0, slip: 0, hardware: MULTITURN };
        assert_eq!((step.way(), step.crossing(), step.units()), (way, crossing, 1 << 30));
    }

    #[test]
    fn steps_are_counted_in_the_direction_and_know_the_settings_before() {
        let mut positions = Positions::default();
        let slip = positions.slip(|step| match step.before {
            Some((_, before)) if before != step.settings => 1_000_000,
            _ => step.slip + step.way(),
        });
        let mut measuring = Measuring::new(MULTITURN, 100, Attached::new(Rc::new(RefCell::new(positions))));
        let slips: Vec<i64> = [(100, 1), (103, 1), (101, 2), (99, 2)]
            .map(|(place, units_per_revolution)| {
                let scaling = Scaling { units_per_revolution, range: 16384 };
                measuring.settings = MeasuringSettings::scaled(CountingDirection::Counterclockwise, scaling, true);
                measuring.sample(place);
                slip.get()
            })
            .into();
        assert_eq!(slips, [0, -3, 1_000_000, 1_000_002]);
        measuring.jump(5);
        assert_eq!(slip.get(), 0);
        measuring.sample(5);
        assert_eq!(slip.get(), 0);
    }
}
