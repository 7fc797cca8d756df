//! From the place that the sensor sees to positions, with and without offset.

use super::{Direction, Gear, Hardware, RedZone, Scaling};
use device_stack::Attached;

/// What the user has set about positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// In which direction positions rise.
    pub direction: Direction,
    /// Units and range.
    pub scaling: Scaling,
    /// How the last range before the physical zero is counted where it is cut short.
    pub red_zone: RedZone,
    /// Whether the offset acts.
    pub offset_acts: bool,
    /// The gear by which positions are counted instead of by the scaling; laps of the encoder are counted for it.
    pub gear: Option<Gear>,
    /// The range of a position that stands at its last value beyond it, instead of beginning anew: then the offset and the sum of
    /// position and offset go round all revolutions of the encoder.
    pub saturates_at: Option<u64>,
}

impl Settings {
    /// The plain hardware: clockwise, one unit a step, no offset.
    pub fn hardware(hardware: &Hardware) -> Settings {
        Settings::scaled(Direction::Clockwise, Scaling::hardware(hardware), false)
    }

    /// Positions that rise in `direction`, are counted by `scaling` and begin anew at the end of its range.
    pub const fn scaled(direction: Direction, scaling: Scaling, offset_acts: bool) -> Settings {
        Settings { direction, scaling, red_zone: RedZone::FromZero, offset_acts, gear: None, saturates_at: None }
    }

    /// The scaling whose range the positions go round.
    fn circle(&self, hardware: &Hardware) -> Scaling {
        let beyond = self.saturates_at.map(|_| self.scaling.units_per_revolution.saturating_mul(hardware.revolutions));
        let range = self.gear.map(|gear| gear.range).or(beyond).unwrap_or(self.scaling.range);
        Scaling { range, ..self.scaling }
    }
}

/// What a preset does with its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PresetMode {
    /// The position becomes the value.
    Absolute,
    /// The position is shifted by the value.
    Relative,
}

/// What the position without offset is computed from.
#[derive(Clone, Copy, Debug)]
pub struct Reading {
    /// The settings in force.
    pub settings: Settings,
    /// The scaling, with the range that positions go round.
    pub scaling: Scaling,
    /// What the sensor can tell apart.
    pub hardware: Hardware,
    /// The place of the sensor, counted in the direction in force.
    pub place: u64,
    /// The same over all laps.
    pub endless: i128,
    /// The offset of all presets so far.
    pub offset: u64,
}

impl Reading {
    /// The position without offset, in units.
    pub fn position(&self) -> u64 {
        match self.settings.gear {
            Some(gear) => gear.position(&self.hardware, self.endless),
            None => self.settings.red_zone.position(&self.scaling, &self.hardware, self.place),
        }
    }
}

/// What the position with offset is computed from; all in units.
#[derive(Clone, Copy, Debug)]
pub struct OffsetSum {
    /// The position without offset.
    pub position: u64,
    /// The offset.
    pub offset: u64,
    /// The range that position and offset go round.
    pub range: u64,
    /// Whether the offset acts.
    pub offset_acts: bool,
    /// The range of a position that stands at its last value beyond it.
    pub saturates_at: Option<u64>,
}

impl OffsetSum {
    /// The position with the offset as far as it acts, at the last value of its range where it is to stand there.
    pub fn position(&self) -> u64 {
        let sum = if self.offset_acts { shift(self.position, self.offset, self.range) } else { self.position };
        match self.saturates_at {
            Some(range) => sum.min(range.saturating_sub(1)),
            None => sum,
        }
    }
}

/// What the offset of a preset is computed from; all in units.
#[derive(Clone, Copy, Debug)]
pub struct PresetBasis {
    /// What it does with its value.
    pub mode: PresetMode,
    /// The value.
    pub value: u64,
    /// The position without offset at the moment of the preset.
    pub position: u64,
    /// The offset so far.
    pub offset: u64,
    /// The range of positions.
    pub range: u64,
    /// The scaling in force.
    pub scaling: Scaling,
    /// What the sensor can tell apart.
    pub hardware: Hardware,
}

impl PresetBasis {
    /// The offset that the preset gives: an absolute one makes the position equal to its value, a relative one shifts the position
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

/// The sum of a position and an offset on the circle of `range` units.
pub fn shift(position: u64, offset: u64, range: u64) -> u64 {
    match position.checked_add(offset) {
        Some(sum) if sum < range => sum,
        Some(sum) => sum % range.max(1),
        None => ((u128::from(position) + u128::from(offset)) % u128::from(range.max(1))) as u64,
    }
}

/// How the place of the sensor became what it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampled {
    /// It is the first one since power-up.
    First,
    /// The shaft was turned.
    Turned,
    /// The shaft was put there without a way between.
    Put,
}

/// The steps of measuring at which a deviation may take another result; each default changes nothing.
#[allow(unused_variables, reason = "the names say what a step is given")]
pub trait MeasuringSteps {
    /// The sensor was sampled.
    fn sampled(&mut self, measuring: &Measuring, how: Sampled) {}

    /// The range that positions go round, from the scaling that was set.
    fn range(&mut self, scaling: &Scaling, hardware: &Hardware, range: u64) -> u64 {
        range
    }

    /// The position without offset.
    fn position(&mut self, reading: &Reading, position: u64) -> u64 {
        position
    }

    /// The position with offset.
    fn shifted(&mut self, sum: &OffsetSum, position: u64) -> u64 {
        position
    }

    /// The offset that a preset gives.
    fn preset(&mut self, preset: &PresetBasis, offset: u64) -> u64 {
        offset
    }
}

/// The measuring task: it is given places and settings and gives positions.
#[derive(Clone, Debug)]
pub struct Measuring {
    /// The settings in force.
    pub settings: Settings,
    /// The offset of all presets so far, in units of the range in force when it was set.
    pub offset: u64,
    /// How often the shaft has gone over the physical zero, clockwise positive; an encoder with a gear keeps it.
    pub laps: i64,
    /// What the sensor can tell apart.
    pub hardware: Hardware,
    /// The place that the sensor sees, clockwise.
    pub place: u64,
    is_first: bool,
    steps: Attached<dyn MeasuringSteps>,
}

impl Measuring {
    /// A measuring task that sees `place`, with the settings of the plain hardware and no offset.
    pub fn new(hardware: Hardware, place: u64, steps: Attached<dyn MeasuringSteps>) -> Measuring {
        let settings = Settings::hardware(&hardware);
        Measuring { settings, offset: 0, laps: 0, hardware, place, is_first: true, steps }
    }

    /// Takes what the sensor sees: a way since is taken for the shorter one.
    pub fn sample(&mut self, place: u64) {
        let is_first = core::mem::replace(&mut self.is_first, false);
        if !is_first {
            self.laps += self.crossing(place);
        }
        self.place = place;
        self.steps.notify(|steps| steps.sampled(self, if is_first { Sampled::First } else { Sampled::Turned }));
    }

    /// 1 if the shorter way to `place` leads over the physical zero forward, -1 backward, 0 if it does not.
    fn crossing(&self, place: u64) -> i64 {
        let (range, half) = (self.hardware.range(), self.hardware.range() / 2);
        match (self.place.saturating_sub(place), place.saturating_sub(self.place)) {
            (back, _) if back > half => 1,
            (_, ahead) if ahead >= range - half => -1,
            _ => 0,
        }
    }

    /// Takes what the sensor sees without regard to what it saw before: the shaft was put there.
    pub fn put(&mut self, place: u64) {
        (self.place, self.is_first) = (place, false);
        self.steps.notify(|steps| steps.sampled(self, Sampled::Put));
    }

    /// Goes on from where the shaft was seen before a pause and the laps that were counted then: a way since is taken for
    /// the shorter one.
    pub fn recall(&mut self, place: u64, laps: i64) {
        let now = self.place;
        self.put(place);
        self.laps = laps;
        self.sample(now);
    }

    /// The same measuring task under other settings.
    pub fn under(&self, settings: Settings) -> Measuring {
        Measuring { settings, ..self.clone() }
    }

    /// The range of positions in force, in units.
    pub fn range(&self) -> u64 {
        let scaling = self.settings.circle(&self.hardware);
        self.steps.apply(scaling.range, |steps, range| steps.range(&scaling, &self.hardware, range))
    }

    /// A place of the sensor, counted in the direction in force.
    pub fn counted(&self, place: u64) -> u64 {
        match self.settings.direction {
            Direction::Clockwise => place,
            // The complement, so that steps back mirror steps forward exactly, whatever the scaling.
            Direction::Counterclockwise => self.hardware.range() - 1 - place,
        }
    }

    /// The place counted over all laps, in the direction in force.
    fn endless(&self) -> i128 {
        let place = i128::from(self.laps) * i128::from(self.hardware.range()) + i128::from(self.place);
        match self.settings.direction {
            Direction::Clockwise => place,
            Direction::Counterclockwise => -1 - place,
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
    fn reading(&self, range: u64) -> Reading {
        let Measuring { settings, hardware, offset, .. } = *self;
        let scaling = Scaling { range, ..settings.scaling };
        Reading { settings, scaling, hardware, place: self.counted(self.place), endless: self.endless(), offset }
    }

    /// The position with the offset as far as it acts, in units; at the last value of its range where it is to stand there.
    pub fn shifted(&self) -> u64 {
        self.positions()[1]
    }

    /// The [position](Measuring::position) without the offset, and the [shifted](Measuring::shifted) one with it.
    pub fn positions(&self) -> [u64; 2] {
        let range = self.range();
        let position = self.position_within(range);
        let sum = || self.sum(position, range);
        [position, self.steps.apply(sum().position(), |steps, shifted| steps.shifted(&sum(), shifted))]
    }

    #[inline]
    fn sum(&self, position: u64, range: u64) -> OffsetSum {
        let Settings { offset_acts, saturates_at, .. } = self.settings;
        OffsetSum { position, offset: self.offset, range, offset_acts, saturates_at }
    }

    /// The offset that a preset now would give; nothing is changed.
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
