//! Deviations at the calculation steps of positions, presets and velocity.

use alloc::rc::Rc;
use core::cell::Cell;
use encoder_profile::encoder::measuring::{MeasuringSteps, OffsetSum, PositionBasis, PresetBasis, Sampled};
use encoder_profile::encoder::velocity::{MeasuredWay, Sampling, VelocitySteps, VelocityUnit};
use encoder_profile::encoder::{Gear, Hardware, Measuring, MeasuringSettings, PresetMode, Scaling};

hooks! { Positions: MeasuringSteps
    /// Is called when the sensor has been sampled.
    sampled(measuring: &Measuring, how: Sampled);
    /// Changes the range at whose end positions wrap.
    range(scaling: &Scaling, hardware: &Hardware) -> u64;
    /// Changes the position without offset.
    position(reading: &PositionBasis) -> u64;
    /// Changes the position including the offset.
    shifted(sum: &OffsetSum) -> u64;
    /// Changes the offset that results from a preset.
    preset(preset: &PresetBasis) -> u64;
}

hooks! { Speeds: VelocitySteps
    /// Changes how velocity is sampled.
    sampling(unit: VelocityUnit) -> Sampling;
    /// Changes the velocity of a measured movement.
    velocity(way: &MeasuredWay) -> i64;
}

impl Positions {
    /// Changes how positions without a gear are calculated, given the shaft position in hardware steps.
    pub fn scale(&mut self, mut scale: impl FnMut(&Scaling, &Hardware, u64) -> u64 + 'static) {
        self.position(move |at, right| match at.settings.gear {
            Some(_) => right,
            None => scale(&at.scaling, &at.hardware, at.place),
        });
    }

    /// Changes how positions with a gear are calculated, given the shaft position over all laps.
    pub fn gear(&mut self, mut gear: impl FnMut(&Gear, &Hardware, i128) -> u64 + 'static) {
        self.position(move |at, right| match &at.settings.gear {
            Some(of) => gear(of, &at.hardware, at.unwrapped),
            None => right,
        });
    }

    /// Changes how the offset is added, given the position, the offset and the range.
    pub fn shift(&mut self, mut shift: impl FnMut(u64, u64, u64) -> u64 + 'static) {
        self.shifted(move |sum, right| {
            let within =
                |position: u64| sum.saturates_at.map_or(position, |range| position.min(range.saturating_sub(1)));
            if sum.offset_acts { within(shift(sum.position, sum.offset, sum.range)) } else { right }
        });
    }

    /// Changes the offset that results from an absolute preset.
    pub fn absolute(&mut self, mut offset: impl FnMut(&PresetBasis) -> u64 + 'static) {
        self.preset(move |preset, right| if preset.mode == PresetMode::Absolute { offset(preset) } else { right });
    }

    /// Changes the offset that results from a relative preset.
    pub fn relative(&mut self, mut offset: impl FnMut(&PresetBasis) -> u64 + 'static) {
        self.preset(move |preset, right| if preset.mode == PresetMode::Relative { offset(preset) } else { right });
    }

    /// Adds a slip to the position: `count` returns it in units after each movement of the shaft.
    pub fn slip(&mut self, count: impl FnMut(&ShaftStep) -> i64 + 'static) -> Slip {
        let slip = Slip::default();
        self.add(SlipHook { before: None, slip: slip.clone(), count });
        slip
    }
}

/// By how many units the position is ahead of the one that follows from the shaft.
#[derive(Clone, Debug, Default)]
pub struct Slip(Rc<Cell<i64>>);

impl Slip {
    /// The slip in units.
    pub fn get(&self) -> i64 {
        self.0.get()
    }
}

/// The movement of the shaft from one sample to the next; positions are counted in the direction in force.
#[derive(Clone, Copy, Debug)]
pub struct ShaftStep {
    /// The previous shaft position and the settings then in force; `None` at the first sample.
    pub before: Option<(u64, MeasuringSettings)>,
    /// The shaft position now, in hardware steps.
    pub now: u64,
    /// The settings in force now.
    pub settings: MeasuringSettings,
    /// The offset of all presets so far.
    pub offset: u64,
    /// The slip so far.
    pub slip: i64,
    /// The resolution of the sensor.
    pub hardware: Hardware,
}

impl ShaftStep {
    /// The signed distance from the previous shaft position in hardware steps, taking the shorter direction.
    pub fn movement(&self) -> i64 {
        let range = self.hardware.range() as i64;
        let way = self.before.map_or(0, |(before, _)| self.now as i64 - before as i64) + range / 2;
        way.rem_euclid(range) - range / 2
    }

    /// 1 if the movement crosses the physical zero forward, -1 backward, 0 if it does not cross it.
    pub fn crossing(&self) -> i64 {
        let Some((before, _)) = self.before else { return 0 };
        (before as i64 + self.movement()).div_euclid(self.hardware.range() as i64)
    }

    /// The units in the whole range of the hardware.
    pub fn units(&self) -> i64 {
        self.settings.scaling.units(&self.hardware, self.hardware.range()) as i64
    }
}

/// Adds a slip to positions without a gear.
struct SlipHook<F> {
    /// The shaft position and the settings at the last sample.
    before: Option<(u64, MeasuringSettings)>,
    slip: Slip,
    count: F,
}

impl<F: FnMut(&ShaftStep) -> i64> MeasuringSteps for SlipHook<F> {
    fn sampled(&mut self, measuring: &Measuring, how: Sampled) {
        let Measuring { settings, offset, hardware, place, .. } = *measuring;
        let before = self.before.replace((place, settings)).filter(|_| how == Sampled::Turned);
        let slip = if how == Sampled::Turned { self.slip.get() } else { 0 };
        let before = before.map(|(place, settings)| (measuring.in_direction(place), settings));
        let step = ShaftStep { before, now: measuring.in_direction(place), settings, offset, slip, hardware };
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
        let step = ShaftStep { before, now, settings, offset: 0, slip: 0, hardware: MULTITURN };
        assert_eq!((step.movement(), step.crossing(), step.units()), (way, crossing, 1 << 30));
    }

    #[test]
    fn steps_follow_the_counting_direction_and_the_previous_settings() {
        let mut positions = Positions::default();
        let slip = positions.slip(|step| match step.before {
            Some((_, before)) if before != step.settings => 1_000_000,
            _ => step.slip + step.movement(),
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
