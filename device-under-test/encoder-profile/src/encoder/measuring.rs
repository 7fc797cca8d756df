//! From the place that the sensor sees to positions, with and without offset.

use super::{Direction, Gear, Hardware, Scaling};

/// What the user has set about positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Settings {
    /// In which direction positions rise.
    pub direction: Direction,
    /// Units and range.
    pub scaling: Scaling,
    /// Whether the offset acts.
    pub offset_acts: bool,
    /// The gear by which positions are counted instead of by the scaling; laps of the encoder are counted for it.
    pub gear: Option<Gear>,
    /// The range of a position that stands at its last value beyond it, instead of beginning anew: then offset and
    /// position go round all revolutions of the encoder, and [`Measuring::limited`] shows what is within the range.
    pub saturates_at: Option<u64>,
}

impl Settings {
    /// The plain hardware: clockwise, one unit a step, no offset.
    pub fn hardware(hardware: &Hardware) -> Settings {
        Settings::scaled(Direction::Clockwise, Scaling::hardware(hardware), false)
    }

    /// Positions that rise in `direction`, are counted by `scaling` and begin anew at the end of its range.
    pub const fn scaled(direction: Direction, scaling: Scaling, offset_acts: bool) -> Settings {
        Settings { direction, scaling, offset_acts, gear: None, saturates_at: None }
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
    /// The slip at the moment of the preset.
    pub slip: i64,
}

/// How the encoder came from one look at the sensor to the next; places are counted in the direction in force.
#[derive(Clone, Copy, Debug)]
pub struct Step {
    /// The place before and the settings in force then; none at the first look.
    pub before: Option<(u64, Settings)>,
    /// The place now.
    pub now: u64,
    /// The settings in force now.
    pub settings: Settings,
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
        // Nearly always it is the shorter way as it is.
        let shorter = if (0..range).contains(&way) { way } else { way.rem_euclid(range) };
        shorter - range / 2
    }

    /// 1 if the way leads over the physical zero forward, -1 backward, 0 if it does not.
    pub fn crossing(&self) -> i64 {
        let Some((before, _)) = self.before else { return 0 };
        let (range, place) = (self.hardware.range() as i64, before as i64 + self.way());
        if (0..range).contains(&place) { 0 } else { place.div_euclid(range) }
    }

    /// The units that the hardware counts from physical zero to physical zero.
    pub fn units(&self) -> i64 {
        self.settings.scaling.units(&self.hardware, self.hardware.range()) as i64
    }
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
    /// The range of positions, from the scaling that was set.
    pub range: fn(&Scaling, &Hardware) -> u64,
    /// The position at a place.
    pub scale: fn(&Scaling, &Hardware, u64) -> u64,
    /// By how many units the position is ahead of what the place says: 0, for the sensor is absolute.
    pub slip: fn(&Step) -> i64,
    /// The offset when the position is measured again after a pause, from the offset before and the one with which the
    /// position would be that before the pause.
    pub resume: fn(u64, u64) -> u64,
    /// The offset when a connection begins, from the offset before.
    pub restart: fn(u64) -> u64,
    /// The position that a preset begins with while the encoder is parked, from the position where the shaft is.
    pub parked_position: fn(u64) -> u64,
    /// Whether the position stands still while a preset is being stored, from whether it should.
    pub holds: fn(bool) -> bool,
    /// The laps of the encoder, from those that are right and the step that was made.
    pub laps: fn(i64, &Step) -> i64,
    /// The position of a geared axis at a place that is counted over all laps.
    pub gear: fn(&Gear, &Hardware, i128) -> u64,
    /// The position that is shown of one which stands still beyond its range, from position, range and the units after
    /// which the position begins anew.
    pub limit: fn(u64, u64, u64) -> u64,
}

impl Default for Rules {
    fn default() -> Rules {
        Rules {
            absolute,
            relative,
            value: |value, _, _| value,
            shift,
            range: |scaling, _| scaling.range,
            scale: Scaling::position,
            slip: |_| 0,
            resume: |offset, _| offset,
            restart: |offset| offset,
            parked_position: |position| position,
            holds: |holds| holds,
            laps: |laps, _| laps,
            gear: Gear::position,
            limit: |position, range, _| position.min(range.saturating_sub(1)),
        }
    }
}

/// The offset that makes the position equal to the value.
pub fn absolute(preset: Preset) -> u64 {
    let Preset { value, position, range, .. } = preset;
    let range = range.max(1);
    sub(value % range, position % range, range)
}

/// The offset that shifts the position by the value, in the positive counting direction.
pub fn relative(preset: Preset) -> u64 {
    shift(preset.offset, preset.value, preset.range)
}

/// The sum of a position and an offset on the circle of `range` units.
pub fn shift(position: u64, offset: u64, range: u64) -> u64 {
    match position.checked_add(offset) {
        Some(sum) if sum < range => sum,
        Some(sum) => sum % range.max(1),
        None => ((u128::from(position) + u128::from(offset)) % u128::from(range.max(1))) as u64,
    }
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
    /// How often the shaft has gone over the physical zero, clockwise positive; an encoder with a gear keeps it.
    pub laps: i64,
    hardware: Hardware,
    place: u64,
    /// The place and the settings at the last look at the sensor.
    before: Option<(u64, Settings)>,
    slip: i64,
    rules: Rules,
}

impl Measuring {
    /// A measuring task that sees `place`, with the settings of the plain hardware and no offset.
    pub fn new(hardware: Hardware, place: u64, rules: Rules) -> Measuring {
        let settings = Settings::hardware(&hardware);
        Measuring { settings, offset: 0, laps: 0, hardware, place, before: None, slip: 0, rules }
    }

    /// Takes what the sensor sees.
    pub fn sample(&mut self, place: u64) {
        let mut step = Step {
            before: self.before,
            now: place,
            settings: self.settings,
            offset: self.offset,
            slip: self.slip,
            hardware: self.hardware,
        };
        self.laps = (self.rules.laps)(self.laps + step.crossing(), &step);
        if let Some((before, _)) = &mut step.before {
            *before = self.counted(*before);
        }
        step.now = self.counted(place);
        self.slip = (self.rules.slip)(&step);
        (self.place, self.before) = (place, Some((place, self.settings)));
    }

    /// Takes what the sensor sees without regard to what it saw before: the shaft was put there.
    pub fn put(&mut self, place: u64) {
        (self.place, self.before, self.slip) = (place, Some((place, self.settings)), 0);
    }

    /// Goes on from where the shaft was seen before a pause and the laps that were counted then: a way since is taken for
    /// the shorter one.
    pub fn recall(&mut self, place: u64, laps: i64) {
        let now = self.before.replace((place, self.settings)).map_or(self.place, |(now, _)| now);
        self.laps = laps;
        self.sample(now);
    }

    /// The position is measured again after a pause, before which it was `position`.
    pub fn resume(&mut self, position: u64) {
        let as_before = absolute(Preset {
            value: position,
            position: self.position(),
            offset: self.offset,
            range: self.range(),
            slip: self.slip,
        });
        self.offset = (self.rules.resume)(self.offset, as_before);
    }

    /// A connection begins.
    pub fn restart(&mut self) {
        self.offset = (self.rules.restart)(self.offset);
    }

    /// Whether the position stands still while a preset is being stored, from whether it should.
    pub fn holds(&self, should: bool) -> bool {
        (self.rules.holds)(should)
    }

    /// The same measuring task under other settings.
    pub fn under(&self, settings: Settings) -> Measuring {
        Measuring { settings, ..self.clone() }
    }

    /// The range of positions in force, in units.
    pub fn range(&self) -> u64 {
        (self.rules.range)(&self.settings.circle(&self.hardware), &self.hardware)
    }

    /// A place of the sensor, counted in the direction in force.
    fn counted(&self, place: u64) -> u64 {
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
        if let Some(gear) = self.settings.gear {
            return (self.rules.gear)(&gear, &self.hardware, self.endless());
        }
        let scaling = Scaling { range: self.range(), ..self.settings.scaling };
        let position = (self.rules.scale)(&scaling, &self.hardware, self.counted(self.place));
        match self.slip {
            0 => position,
            slip => (i128::from(position) + i128::from(slip)).rem_euclid(i128::from(scaling.range.max(1))) as u64,
        }
    }

    /// The position with the offset, as far as it acts, in units.
    pub fn shifted(&self) -> u64 {
        self.shifted_from(self.position())
    }

    fn shifted_from(&self, position: u64) -> u64 {
        match self.settings.offset_acts {
            true => (self.rules.shift)(position, self.offset, self.range()),
            false => position,
        }
    }

    /// The position with the offset, at the last value of its range where it has gone beyond and is to stand there.
    pub fn limited(&self) -> u64 {
        self.positions()[1]
    }

    /// The [position](Measuring::position) without the offset, and the [limited](Measuring::limited) one with it.
    pub fn positions(&self) -> [u64; 2] {
        let position = self.position();
        let shifted = self.shifted_from(position);
        let limited = match self.settings.saturates_at {
            Some(range) => (self.rules.limit)(shifted, range, self.range()),
            None => shifted,
        };
        [position, limited]
    }

    /// The offset that a preset now would give; nothing is changed.
    pub fn preset(&self, mode: PresetMode, value: u64) -> u64 {
        self.preset_at(self.position(), mode, value)
    }

    /// The same while the encoder is parked.
    pub fn preset_while_parked(&self, mode: PresetMode, value: u64) -> u64 {
        self.preset_at((self.rules.parked_position)(self.position()), mode, value)
    }

    fn preset_at(&self, position: u64, mode: PresetMode, value: u64) -> u64 {
        let units = self.settings.scaling.units_per_revolution;
        let value = (self.rules.value)(value, self.hardware.steps_per_revolution, units);
        let (range, slip) = (self.range(), self.slip);
        let preset = Preset { value, position, offset: self.offset, range, slip };
        match mode {
            PresetMode::Absolute => (self.rules.absolute)(preset),
            PresetMode::Relative => (self.rules.relative)(preset),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec::Vec;
    use rstest::rstest;

    const MULTITURN: Hardware = Hardware { steps_per_revolution: 65536, revolutions: 16384 };

    fn measuring(scaling: Scaling, direction: Direction, place: u64) -> Measuring {
        let mut measuring = Measuring::new(MULTITURN, place, Rules::default());
        measuring.settings = Settings::scaled(direction, scaling, true);
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

    fn step(settings: Settings, before: Option<u64>, now: u64) -> Step {
        Step { before: before.map(|before| (before, settings)), now, settings, offset: 0, slip: 0, hardware: MULTITURN }
    }

    #[rstest]
    #[case::first(None, 5, 0, 0)]
    #[case::forward(Some(5), 15, 10, 0)]
    #[case::backward(Some(15), 5, -10, 0)]
    #[case::over_zero(Some((1 << 30) - 3), 4, 7, 1)]
    #[case::back_over_zero(Some(4), (1 << 30) - 3, -7, -1)]
    #[case::to_zero(Some((1 << 30) - 1), 0, 1, 1)]
    #[case::from_zero(Some(0), (1 << 30) - 1, -1, -1)]
    fn steps(#[case] before: Option<u64>, #[case] now: u64, #[case] way: i64, #[case] crossing: i64) {
        let step = step(Settings::hardware(&MULTITURN), before, now);
        assert_eq!((step.way(), step.crossing(), step.units()), (way, crossing, 1 << 30));
    }

    #[test]
    fn steps_are_counted_in_the_direction_and_know_the_settings_before() {
        let rules = Rules {
            slip: |step| match step.before {
                Some((_, before)) if before != step.settings => 1_000_000,
                _ => step.slip + step.way(),
            },
            ..Rules::default()
        };
        let mut measuring = Measuring::new(MULTITURN, 100, rules);
        let slips: Vec<i64> = [(100, 1), (103, 1), (101, 2), (99, 2)]
            .map(|(place, units_per_revolution)| {
                let scaling = Scaling { units_per_revolution, range: 16384 };
                measuring.settings = Settings::scaled(Direction::Counterclockwise, scaling, true);
                measuring.sample(place);
                measuring.slip
            })
            .into();
        assert_eq!(slips, [0, -3, 1_000_000, 1_000_002]);
        measuring.put(5);
        assert_eq!(measuring.slip, 0);
        measuring.sample(5);
        assert_eq!(measuring.slip, 0);
    }

    #[test]
    fn a_pause_changes_nothing_but_what_the_rules_say() {
        let mut measuring = measuring(HARDWARE, Direction::Clockwise, 5000);
        measuring.offset = 7;
        measuring.resume(5);
        assert_eq!(measuring.shifted(), 5007);
        let other = measuring.under(Settings::hardware(&MULTITURN));
        assert_eq!((other.shifted(), measuring.shifted()), (5000, 5007));
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

    const AFM60: Hardware = Hardware { steps_per_revolution: 262_144, revolutions: 4096 };

    /// 12.5 revolutions of the encoder are one of the axis: 4096 revolutions are 327.68, so that an axis which forgot the
    /// laps would jump where they begin anew.
    #[rstest]
    #[case(Direction::Clockwise, [2447, 2448, 2447])]
    #[case(Direction::Counterclockwise, [1152, 1151, 1152])]
    fn a_round_axis_goes_on_over_the_physical_zero(#[case] direction: Direction, #[case] positions: [u64; 3]) {
        let end = AFM60.range();
        let mut measuring = Measuring::new(AFM60, end - 1, Rules::default());
        measuring.settings = Settings {
            gear: Some(Gear { nominator: 25, divisor: 2, range: 3600 }),
            ..Settings::scaled(direction, Scaling::hardware(&AFM60), true)
        };
        let seen = [end - 1, 0, end - 1].map(|place| {
            measuring.sample(place);
            measuring.position()
        });
        assert_eq!(seen, positions);
        assert_eq!(measuring.laps, 0);
        measuring.sample(5);
        measuring.offset = measuring.preset(PresetMode::Absolute, 100);
        assert_eq!((measuring.shifted(), measuring.range(), measuring.laps), (100, 3600, 1));
    }

    /// Sendix 58xx with a range that is no power of two of its units and without the cyclic mode: 1000 units, range 5000.
    #[test]
    fn a_position_that_stands_at_its_last_value() {
        let hardware = Hardware { steps_per_revolution: 65536, revolutions: 4096 };
        let mut measuring = Measuring::new(hardware, 0, Rules::default());
        let scaling = Scaling { units_per_revolution: 1000, range: 5000 };
        measuring.settings =
            Settings { saturates_at: Some(5000), ..Settings::scaled(Direction::Clockwise, scaling, true) };
        let seen: Vec<_> = [0, 5 * 65536 - 1, 5 * 65536, 4095 * 65536]
            .map(|place| {
                measuring.sample(place);
                (measuring.shifted(), measuring.limited())
            })
            .into();
        assert_eq!(seen, [(0, 0), (4999, 4999), (5000, 4999), (4_095_000, 4999)]);
        measuring.offset = measuring.preset(PresetMode::Absolute, 10);
        assert_eq!((measuring.shifted(), measuring.limited(), measuring.range()), (10, 10, 4_096_000));
    }

    #[test]
    fn a_preset_can_be_told_to_begin_elsewhere_while_parked() {
        let rules = Rules { parked_position: |_| 0, restart: |_| 0, holds: |_| false, ..Rules::default() };
        let mut measuring = Measuring::new(MULTITURN, 5000, rules);
        assert_eq!(measuring.preset_while_parked(PresetMode::Absolute, 7), 7);
        measuring.offset = measuring.preset(PresetMode::Absolute, 7);
        assert_ne!(measuring.offset, 7);
        assert!(!measuring.holds(true));
        measuring.restart();
        assert_eq!(measuring.offset, 0);
    }
}
