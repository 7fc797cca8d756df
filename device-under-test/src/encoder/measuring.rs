//! From the place that the sensor sees to positions, with and without offset.

use super::{Direction, Hardware, Scaling};

/// What the user has set about positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// In which direction positions rise.
    pub direction: Direction,
    /// Units and range.
    pub scaling: Scaling,
    /// Whether the offset acts.
    pub offset_acts: bool,
}

impl Settings {
    /// The plain hardware: clockwise, one unit a step, no offset.
    pub fn hardware(hardware: &Hardware) -> Settings {
        Settings { direction: Direction::Clockwise, scaling: Scaling::hardware(hardware), offset_acts: false }
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

/// What a preset is computed from; all in units.
#[derive(Clone, Copy, Debug)]
pub struct Preset {
    /// The value of the preset.
    pub value: u64,
    /// The position without offset at the moment of the preset.
    pub position: u64,
    /// The offset so far.
    pub offset: u64,
    /// The range of positions.
    pub range: u64,
}

/// How the sensor came from one hardware place to the next.
#[derive(Clone, Copy, Debug)]
pub struct Crossing {
    /// The place before.
    pub before: u64,
    /// The place now.
    pub now: u64,
    /// What the hardware can tell apart.
    pub range: u64,
    /// How many hardware ranges the place was taken to lie beyond the physical zero before.
    pub beyond: i64,
}

/// Where bugs can be put into the measuring task.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// The offset that an absolute preset gives.
    pub absolute: fn(Preset) -> u64,
    /// The offset that a relative preset gives.
    pub relative: fn(Preset) -> u64,
    /// The value of a preset in units, from the one that was set, steps per revolution and units per revolution.
    pub value: fn(u64, u64, u64) -> u64,
    /// The position with its offset, from position, offset and range.
    pub shift: fn(u64, u64, u64) -> u64,
    /// How many hardware ranges the place is taken to lie beyond the physical zero: 0, for the sensor is absolute.
    pub beyond: fn(Crossing) -> i64,
}

impl Default for Rules {
    fn default() -> Rules {
        Rules { absolute, relative, value: |value, _, _| value, shift, beyond: |_| 0 }
    }
}

/// The offset that makes the position equal to the value.
pub fn absolute(preset: Preset) -> u64 {
    let Preset { value, position, range, .. } = preset;
    sub(value % range, position % range, range)
}

/// The offset that shifts the position by the value, in the positive counting direction.
pub fn relative(preset: Preset) -> u64 {
    shift(preset.offset, preset.value, preset.range)
}

/// The sum of a position and an offset on the circle of `range` units.
pub fn shift(position: u64, offset: u64, range: u64) -> u64 {
    ((u128::from(position) + u128::from(offset)) % u128::from(range)) as u64
}

fn sub(a: u64, b: u64, range: u64) -> u64 {
    if a >= b { a - b } else { a + (range - b) }
}

/// The measuring task: it is given places and settings and gives positions.
#[derive(Clone, Debug)]
pub struct Measuring {
    /// The settings in force.
    pub settings: Settings,
    /// The offset of all presets so far, in units of the range in force when it was set.
    pub offset: u64,
    hardware: Hardware,
    place: u64,
    beyond: i64,
    rules: Rules,
}

impl Measuring {
    /// A measuring task that sees `place`, with the settings of the plain hardware and no offset.
    pub fn new(hardware: Hardware, place: u64, rules: Rules) -> Measuring {
        Measuring { settings: Settings::hardware(&hardware), offset: 0, hardware, place, beyond: 0, rules }
    }

    /// Takes what the sensor sees.
    pub fn sample(&mut self, place: u64) {
        let range = self.hardware.range();
        self.beyond = (self.rules.beyond)(Crossing { before: self.place, now: place, range, beyond: self.beyond });
        self.place = place;
    }

    /// Takes what the sensor sees without regard to what it saw before: the shaft was put there.
    pub fn put(&mut self, place: u64) {
        (self.place, self.beyond) = (place, 0);
    }

    /// The range of positions in force, in units.
    pub fn range(&self) -> u64 {
        self.settings.scaling.range
    }

    /// The position without offset, in units.
    pub fn position(&self) -> u64 {
        let place = match self.settings.direction {
            Direction::Clockwise => self.place,
            // The complement, so that steps back mirror steps forward exactly, whatever the scaling.
            Direction::Counterclockwise => self.hardware.range() - 1 - self.place,
        };
        let place = place as i64 + self.beyond * self.hardware.range() as i64;
        self.settings.scaling.position(&self.hardware, place)
    }

    /// The position with the offset, as far as it acts, in units.
    pub fn shifted(&self) -> u64 {
        match self.settings.offset_acts {
            true => (self.rules.shift)(self.position(), self.offset, self.range()),
            false => self.position(),
        }
    }

    /// The offset that a preset now would give; nothing is changed.
    pub fn preset(&self, mode: PresetMode, value: u64) -> u64 {
        let units = self.settings.scaling.units_per_revolution;
        let value = (self.rules.value)(value, self.hardware.steps_per_revolution, units);
        let preset = Preset { value, position: self.position(), offset: self.offset, range: self.range() };
        match mode {
            PresetMode::Absolute => (self.rules.absolute)(preset),
            PresetMode::Relative => (self.rules.relative)(preset),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    const MULTITURN: Hardware = Hardware { steps_per_revolution: 65536, revolutions: 16384 };

    fn measuring(scaling: Scaling, direction: Direction, place: u64) -> Measuring {
        let mut measuring = Measuring::new(MULTITURN, place, Rules::default());
        measuring.settings = Settings { direction, scaling, offset_acts: true };
        measuring
    }

    const HARDWARE: Scaling = Scaling::hardware(&MULTITURN);

    // XAC77 manual, p. 88: a relative preset of 1000 makes 6000 of 5000. Catalogue PLC-002: an absolute one makes 1000
    // of 5000 and an offset of -4000, on the circle 2^30 - 4000 = 0x3FFFF060.
    #[rstest]
    #[case(PresetMode::Relative, 1000, 6000, 1000)]
    #[case(PresetMode::Absolute, 1000, 1000, 0x3FFF_F060)]
    #[case(PresetMode::Absolute, 0x3FFF_FFFF, 0x3FFF_FFFF, 0x3FFF_EC77)]
    #[case::minus_1000(PresetMode::Relative, 0xFFFF_FC18, 4000, 0x3FFF_FC18)]
    #[case::beyond_the_range(PresetMode::Absolute, 0x4000_0005, 5, 0x3FFF_EC7D)]
    fn presets(#[case] mode: PresetMode, #[case] value: u64, #[case] position: u64, #[case] offset: u64) {
        let mut measuring = measuring(HARDWARE, Direction::Clockwise, 5000);
        measuring.offset = measuring.preset(mode, value);
        assert_eq!((measuring.shifted(), measuring.offset), (position, offset));
        assert_eq!(measuring.position(), 5000);
        measuring.settings.offset_acts = false;
        assert_eq!(measuring.shifted(), 5000);
    }

    #[test]
    fn relative_presets_add_up_and_an_absolute_one_does_not() {
        let scaling = Scaling { units_per_revolution: 4096, range: 4096 };
        let mut measuring = measuring(scaling, Direction::Clockwise, 16);
        for expected in [1001, 2001, 3001, 4001, 905] {
            measuring.offset = measuring.preset(PresetMode::Relative, 1000);
            assert_eq!(measuring.shifted(), expected);
        }
        measuring.offset = measuring.preset(PresetMode::Absolute, 1000);
        measuring.offset = measuring.preset(PresetMode::Absolute, 1000);
        assert_eq!(measuring.shifted(), 1000);
    }

    #[test]
    fn counter_clockwise_mirrors_every_step() {
        let scaling = Scaling { units_per_revolution: 4096, range: 1 << 24 };
        let mut measuring = measuring(scaling, Direction::Counterclockwise, 0);
        let zero = measuring.position();
        for (place, back) in [(15, 0), (16, 1), (32768, 2048), (65536, 4096)] {
            measuring.sample(place);
            assert_eq!(measuring.position(), zero - back);
        }
    }

    // Manual 11.5 with the physical zero in the middle: forward the position jumps from 189267967 to 0, backward back.
    #[test]
    fn the_red_zone_jumps_in_both_directions() {
        let scaling = Scaling { units_per_revolution: 65536, range: 442_236_928 };
        let mut measuring = measuring(scaling, Direction::Clockwise, 1_073_741_823);
        assert_eq!(measuring.position(), 189_267_967);
        measuring.sample(0);
        assert_eq!(measuring.position(), 0);
        measuring.sample(1_073_741_823);
        assert_eq!(measuring.position(), 189_267_967);
    }
}
