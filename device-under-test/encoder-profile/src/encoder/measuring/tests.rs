//! Positions, presets, round axes and saturating positions.

use super::*;
use alloc::vec::Vec;
use rstest::rstest;

const MULTITURN: Hardware = Hardware { steps_per_revolution: 65536, revolutions: 16384 };

fn measuring(scaling: Scaling, direction: CountingDirection, place: u64) -> Measuring {
    let mut measuring = Measuring::new(MULTITURN, place, Attached::NONE);
    measuring.settings = MeasuringSettings::scaled(direction, scaling, true);
    measuring
}

const HARDWARE: Scaling = Scaling::hardware(&MULTITURN);

// XAC77 manual, p. 88: a relative preset of 1000 changes 5000 to 6000. Catalogue PLC-002: an absolute preset of 1000
// at 5000 results in an offset of -4000, which is 2^30 - 4000 = 0x3FFFF060.
#[rstest]
#[case(PresetMode::Relative, 1000, 6000, 1000)]
#[case(PresetMode::Absolute, 1000, 1000, 0x3FFF_F060)]
#[case(PresetMode::Absolute, 0x3FFF_FFFF, 0x3FFF_FFFF, 0x3FFF_EC77)]
#[case::minus_1000(PresetMode::Relative, 0xFFFF_FC18, 4000, 0x3FFF_FC18)]
#[case::beyond_the_range(PresetMode::Absolute, 0x4000_0005, 5, 0x3FFF_EC7D)]
fn presets(#[case] mode: PresetMode, #[case] value: u64, #[case] position: u64, #[case] offset: u64) {
    let mut measuring = measuring(HARDWARE, CountingDirection::Clockwise, 5000);
    measuring.offset = measuring.preset(mode, value);
    assert_eq!((measuring.shifted(), measuring.offset), (position, offset));
    assert_eq!(measuring.position(), 5000);
    measuring.settings.offset_acts = false;
    assert_eq!(measuring.shifted(), 5000);
}

#[test]
fn relative_presets_accumulate_and_absolute_presets_do_not() {
    let scaling = Scaling { units_per_revolution: 4096, range: 4096 };
    let mut measuring = measuring(scaling, CountingDirection::Clockwise, 16);
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
    let mut measuring = measuring(scaling, CountingDirection::Counterclockwise, 0);
    let zero = measuring.position();
    for (place, back) in [(15, 0), (16, 1), (32768, 2048), (65536, 4096)] {
        measuring.sample(place);
        assert_eq!(measuring.position(), zero - back);
    }
}

#[rstest]
#[case::forward(5, 15, 0)]
#[case::backward(15, 5, 0)]
#[case::over_zero((1 << 30) - 3, 4, 1)]
#[case::back_over_zero(4, (1 << 30) - 3, -1)]
#[case::to_zero((1 << 30) - 1, 0, 1)]
#[case::from_zero(0, (1 << 30) - 1, -1)]
#[case::half_way_back(1 << 29, 0, 0)]
#[case::half_way_ahead(0, 1 << 29, -1)]
fn laps_are_counted(#[case] before: u64, #[case] now: u64, #[case] laps: i64) {
    let mut measuring = measuring(HARDWARE, CountingDirection::Clockwise, 7);
    measuring.sample(before);
    measuring.sample(now);
    assert_eq!(measuring.laps, laps);
    measuring.restore(before, 10);
    assert_eq!((measuring.place, measuring.laps), (now, 10 + laps));
    measuring.jump(before);
    assert_eq!((measuring.place, measuring.laps), (before, 10 + laps));
}

#[test]
fn other_settings_keep_place_and_offset() {
    let mut measuring = measuring(HARDWARE, CountingDirection::Clockwise, 5000);
    measuring.offset = 7;
    let other = measuring.with_settings(MeasuringSettings::hardware(&MULTITURN));
    assert_eq!((other.shifted(), measuring.shifted()), (5000, 5007));
}

// Manual 11.5 with the physical zero in the middle: forward the position jumps from 189267967 to 0, backward from 0 to 189267967.
#[test]
fn the_red_zone_jumps_in_both_directions() {
    let scaling = Scaling { units_per_revolution: 65536, range: 442_236_928 };
    let mut measuring = measuring(scaling, CountingDirection::Clockwise, 1_073_741_823);
    assert_eq!(measuring.position(), 189_267_967);
    measuring.sample(0);
    assert_eq!(measuring.position(), 0);
    measuring.sample(1_073_741_823);
    assert_eq!(measuring.position(), 189_267_967);
}

const AFM60: Hardware = Hardware { steps_per_revolution: 262_144, revolutions: 4096 };

/// 12.5 revolutions of the encoder are one of the axis, and 4096 revolutions are 327.68. An axis position without
/// counted laps would jump at the physical zero.
#[rstest]
#[case(CountingDirection::Clockwise, [2447, 2448, 2447])]
#[case(CountingDirection::Counterclockwise, [1152, 1151, 1152])]
fn a_round_axis_does_not_jump_at_the_physical_zero(#[case] direction: CountingDirection, #[case] positions: [u64; 3]) {
    let end = AFM60.range();
    let mut measuring = Measuring::new(AFM60, end - 1, Attached::NONE);
    measuring.settings = MeasuringSettings {
        gear: Some(Gear { nominator: 25, divisor: 2, range: 3600 }),
        ..MeasuringSettings::scaled(direction, Scaling::hardware(&AFM60), true)
    };
    let observed = [end - 1, 0, end - 1].map(|place| {
        measuring.sample(place);
        measuring.position()
    });
    assert_eq!(observed, positions);
    assert_eq!(measuring.laps, 0);
    measuring.sample(5);
    measuring.offset = measuring.preset(PresetMode::Absolute, 100);
    assert_eq!((measuring.shifted(), measuring.range(), measuring.laps), (100, 3600, 1));
}

/// Sendix 58xx without cyclic mode and with a range that is no power of two times its units: 1000 units, range 5000.
#[test]
fn a_position_saturates_at_its_last_value() {
    let hardware = Hardware { steps_per_revolution: 65536, revolutions: 4096 };
    let mut measuring = Measuring::new(hardware, 0, Attached::NONE);
    let scaling = Scaling { units_per_revolution: 1000, range: 5000 };
    measuring.settings = MeasuringSettings {
        saturates_at: Some(5000),
        ..MeasuringSettings::scaled(CountingDirection::Clockwise, scaling, true)
    };
    let observed: Vec<_> = [0, 5 * 65536 - 1, 5 * 65536, 4095 * 65536]
        .map(|place| {
            measuring.sample(place);
            measuring.shifted()
        })
        .into();
    assert_eq!(observed, [0, 4999, 4999, 4999]);
    measuring.offset = measuring.preset(PresetMode::Absolute, 10);
    assert_eq!((measuring.shifted(), measuring.range()), (10, 4_096_000));
}

/// One deviation at each step.
#[cfg(feature = "deviations")]
#[test]
fn a_deviation_changes_each_step() {
    use alloc::rc::Rc;
    use core::cell::RefCell;

    #[derive(Default)]
    struct MeasuringDeviation(Vec<Sampled>);

    impl MeasuringSteps for MeasuringDeviation {
        fn sampled(&mut self, measuring: &Measuring, how: Sampled) {
            assert_eq!(measuring.position(), measuring.place, "a hook reads the encoder without deviations");
            self.0.push(how);
        }

        fn range(&mut self, _: &Scaling, hardware: &Hardware, range: u64) -> u64 {
            range.min(hardware.steps_per_revolution)
        }

        fn position(&mut self, reading: &PositionBasis, position: u64) -> u64 {
            assert_eq!(reading.scaling.range, 65536);
            position + self.0.len() as u64
        }

        fn shifted(&mut self, sum: &OffsetSum, position: u64) -> u64 {
            sum.offset * 1000 + position
        }

        fn preset(&mut self, preset: &PresetBasis, offset: u64) -> u64 {
            assert_eq!(preset.value, 7);
            offset * 2
        }
    }

    let deviation = Rc::new(RefCell::new(MeasuringDeviation::default()));
    let mut measuring = Measuring::new(MULTITURN, 1, Attached::new(deviation.clone()));
    measuring.sample(2);
    measuring.sample(3);
    measuring.jump(1);
    assert_eq!(deviation.borrow().0, [Sampled::First, Sampled::Turned, Sampled::Put]);
    assert_eq!((measuring.position(), measuring.range()), (4, 65536));
    measuring.offset = measuring.preset(PresetMode::Absolute, 7);
    assert_eq!((measuring.offset, measuring.shifted()), (6, 6004));
}
