//! Positions with and without offset, from sensor readings.

use super::{CountingDirection, Gear, Hardware, RedZone, Scaling};
use device_stack::Attached;

/// The settings of the user for positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MeasuringSettings {
    pub direction: CountingDirection,
    /// Units and range.
    pub scaling: Scaling,
    /// How positions are counted in the red zone.
    pub red_zone: RedZone,
    /// Whether the offset is applied.
    pub offset_acts: bool,
    /// A gear that replaces the scaling. With a gear the encoder counts its laps.
    pub gear: Option<Gear>,
    /// A range at whose end positions saturate at the last value instead of restarting at 0. Then the offset, and the
    /// sum of position and offset, wrap at all revolutions of the encoder.
    pub saturates_at: Option<u64>,
}

impl MeasuringSettings {
    /// Unscaled: clockwise, one unit per step, no offset.
    pub fn hardware(hardware: &Hardware) -> MeasuringSettings {
        MeasuringSettings::scaled(CountingDirection::Clockwise, Scaling::hardware(hardware), false)
    }

    /// Positions that increase in `direction` and wrap at the end of the range of `scaling`.
    pub const fn scaled(direction: CountingDirection, scaling: Scaling, offset_acts: bool) -> MeasuringSettings {
        MeasuringSettings {
            direction,
            scaling,
            red_zone: RedZone::FromZero,
            offset_acts,
            gear: None,
            saturates_at: None,
        }
    }

    /// The scaling with the range at which positions wrap.
    fn wrapping_scaling(&self, hardware: &Hardware) -> Scaling {
        let beyond = self.saturates_at.map(|_| self.scaling.units_per_revolution.saturating_mul(hardware.revolutions));
        let range = self.gear.map(|gear| gear.range).or(beyond).unwrap_or(self.scaling.range);
        Scaling { range, ..self.scaling }
    }
}

/// The mode of a preset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PresetMode {
    /// The position is set to the value.
    Absolute,
    /// The position is shifted by the value.
    Relative,
}

/// The input of the position without offset.
#[derive(Clone, Copy, Debug)]
pub struct PositionBasis {
    /// The settings in force.
    pub settings: MeasuringSettings,
    /// The scaling, with the range at which positions wrap.
    pub scaling: Scaling,
    pub hardware: Hardware,
    /// The sensor reading, in the counting direction in force.
    pub place: u64,
    /// The same including all laps.
    pub unwrapped: i128,
    /// The offset of all presets so far.
    pub offset: u64,
}

impl PositionBasis {
    /// The position without offset, in units.
    pub fn position(&self) -> u64 {
        match self.settings.gear {
            Some(gear) => gear.position(&self.hardware, self.unwrapped),
            None => self.settings.red_zone.position(&self.scaling, &self.hardware, self.place),
        }
    }
}

/// The input of the position with offset; all values in units.
#[derive(Clone, Copy, Debug)]
pub struct OffsetSum {
    /// The position without offset.
    pub position: u64,
    pub offset: u64,
    /// The range at which position and offset wrap.
    pub range: u64,
    /// Whether the offset is applied.
    pub offset_acts: bool,
    /// A range at whose end the position saturates.
    pub saturates_at: Option<u64>,
}

impl OffsetSum {
    /// The position with the offset, if it is applied, and saturated if required.
    pub fn position(&self) -> u64 {
        let sum = if self.offset_acts { shift(self.position, self.offset, self.range) } else { self.position };
        match self.saturates_at {
            Some(range) => sum.min(range.saturating_sub(1)),
            None => sum,
        }
    }
}

/// The input of the offset of a preset; all values in units.
#[derive(Clone, Copy, Debug)]
pub struct PresetBasis {
    pub mode: PresetMode,
    pub value: u64,
    /// The position without offset at the time of the preset.
    pub position: u64,
    /// The offset before the preset.
    pub offset: u64,
    /// The range of positions.
    pub range: u64,
    /// The scaling in force.
    pub scaling: Scaling,
    pub hardware: Hardware,
}

impl PresetBasis {
    /// The offset after the preset. An absolute preset sets the position to its value; a relative preset shifts the position
    /// by its value in the positive counting direction.
    pub fn new_offset(&self) -> u64 {
        match self.mode {
            PresetMode::Absolute => self.absolute(),
            PresetMode::Relative => shift(self.offset, self.value, self.range),
        }
    }

    fn absolute(&self) -> u64 {
        let range = self.range.max(1);
        let (value, position) = (self.value % range, self.position % range);
        if value >= position { value - position } else { value + (range - position) }
    }
}

/// The sum of a position and an offset modulo `range`.
pub fn shift(position: u64, offset: u64, range: u64) -> u64 {
    match position.checked_add(offset) {
        Some(sum) if sum < range => sum,
        Some(sum) => sum % range.max(1),
        None => ((u128::from(position) + u128::from(offset)) % u128::from(range.max(1))) as u64,
    }
}

/// How the sensor reading was obtained.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampled {
    /// The first reading since power-up.
    First,
    /// The shaft was turned.
    Turned,
    /// The stand moved the shaft at once.
    Put,
}

/// The steps of measuring whose result a deviation may change. Each default changes nothing.
#[allow(unused_variables, reason = "the names document the step")]
pub trait MeasuringSteps {
    /// The sensor was sampled.
    fn sampled(&mut self, measuring: &Measuring, how: Sampled) {}

    /// The range at which positions wrap.
    fn range(&mut self, scaling: &Scaling, hardware: &Hardware, range: u64) -> u64 {
        range
    }

    /// The position without offset.
    fn position(&mut self, reading: &PositionBasis, position: u64) -> u64 {
        position
    }

    /// The position with offset.
    fn shifted(&mut self, sum: &OffsetSum, position: u64) -> u64 {
        position
    }

    /// The offset after a preset.
    fn preset(&mut self, preset: &PresetBasis, offset: u64) -> u64 {
        offset
    }
}

/// The measuring task: computes positions from sensor readings and settings.
#[derive(Clone, Debug)]
pub struct Measuring {
    /// The settings in force.
    pub settings: MeasuringSettings,
    /// The offset that results from all presets, in units of the range in force when it was set.
    pub offset: u64,
    /// Passages of the physical zero, clockwise positive. An encoder with a gear stores it.
    pub laps: i64,
    pub hardware: Hardware,
    /// The sensor reading, clockwise.
    pub place: u64,
    is_first: bool,
    steps: Attached<dyn MeasuringSteps>,
}

impl Measuring {
    /// A measuring task with the sensor reading `place`, unscaled and without offset.
    pub fn new(hardware: Hardware, place: u64, steps: Attached<dyn MeasuringSteps>) -> Measuring {
        let settings = MeasuringSettings::hardware(&hardware);
        Measuring { settings, offset: 0, laps: 0, hardware, place, is_first: true, steps }
    }

    /// Processes a sensor reading. The shaft is assumed to have moved the shorter way since the last one.
    pub fn sample(&mut self, place: u64) {
        let is_first = core::mem::replace(&mut self.is_first, false);
        if !is_first {
            self.laps += self.crossing(place);
        }
        self.place = place;
        self.steps.notify(|steps| steps.sampled(self, if is_first { Sampled::First } else { Sampled::Turned }));
    }

    /// 1 if the shorter way to `place` passes the physical zero forward, -1 if backward, otherwise 0.
    fn crossing(&self, place: u64) -> i64 {
        let (range, half) = (self.hardware.range(), self.hardware.range() / 2);
        match (self.place.saturating_sub(place), place.saturating_sub(self.place)) {
            (back, _) if back > half => 1,
            (_, ahead) if ahead >= range - half => -1,
            _ => 0,
        }
    }

    /// Processes a sensor reading after the stand moved the shaft at once: the last reading is ignored.
    pub fn jump(&mut self, place: u64) {
        (self.place, self.is_first) = (place, false);
        self.steps.notify(|steps| steps.sampled(self, Sampled::Put));
    }

    /// Restores the last reading and the laps from before a pause. The shaft is assumed to have moved the shorter way
    /// since then.
    pub fn restore(&mut self, place: u64, laps: i64) {
        let now = self.place;
        self.jump(place);
        self.laps = laps;
        self.sample(now);
    }

    /// The same measuring task under other settings.
    pub fn with_settings(&self, settings: MeasuringSettings) -> Measuring {
        Measuring { settings, ..self.clone() }
    }

    /// The range at which positions wrap, in units.
    pub fn range(&self) -> u64 {
        let scaling = self.settings.wrapping_scaling(&self.hardware);
        self.steps.apply(scaling.range, |steps, range| steps.range(&scaling, &self.hardware, range))
    }

    /// A sensor reading, in the counting direction in force.
    pub fn in_direction(&self, place: u64) -> u64 {
        match self.settings.direction {
            CountingDirection::Clockwise => place,
            // The complement: steps backward mirror steps forward exactly, with any scaling.
            CountingDirection::Counterclockwise => self.hardware.range() - 1 - place,
        }
    }

    /// The reading including all laps, in the counting direction in force.
    fn unwrapped(&self) -> i128 {
        let place = i128::from(self.laps) * i128::from(self.hardware.range()) + i128::from(self.place);
        match self.settings.direction {
            CountingDirection::Clockwise => place,
            CountingDirection::Counterclockwise => -1 - place,
        }
    }

    /// The position without offset, in units.
    pub fn position(&self) -> u64 {
        self.position_within(self.range())
    }

    fn position_within(&self, range: u64) -> u64 {
        self.steps
            .apply(self.reading(range).position(), |steps, position| steps.position(&self.reading(range), position))
    }

    #[inline]
    fn reading(&self, range: u64) -> PositionBasis {
        let Measuring { settings, hardware, offset, .. } = *self;
        let scaling = Scaling { range, ..settings.scaling };
        PositionBasis {
            settings,
            scaling,
            hardware,
            place: self.in_direction(self.place),
            unwrapped: self.unwrapped(),
            offset,
        }
    }

    /// The position with the offset, if it is applied, in units, and saturated if required.
    pub fn shifted(&self) -> u64 {
        self.positions()[1]
    }

    /// The [position](Measuring::position) without offset and the [shifted](Measuring::shifted) position with it.
    pub fn positions(&self) -> [u64; 2] {
        let range = self.range();
        let position = self.position_within(range);
        let sum = || self.sum(position, range);
        [position, self.steps.apply(sum().position(), |steps, shifted| steps.shifted(&sum(), shifted))]
    }

    #[inline]
    fn sum(&self, position: u64, range: u64) -> OffsetSum {
        let MeasuringSettings { offset_acts, saturates_at, .. } = self.settings;
        OffsetSum { position, offset: self.offset, range, offset_acts, saturates_at }
    }

    /// The offset that a preset would result in now. Changes nothing.
    pub fn preset(&self, mode: PresetMode, value: u64) -> u64 {
        let Measuring { settings, hardware, offset, .. } = *self;
        let (range, scaling) = (self.range(), settings.scaling);
        let position = self.position_within(range);
        let preset = PresetBasis { mode, value, position, offset, range, scaling, hardware };
        self.steps.apply(preset.new_offset(), |steps, offset| steps.preset(&preset, offset))
    }
}

#[cfg(test)]
mod tests;
