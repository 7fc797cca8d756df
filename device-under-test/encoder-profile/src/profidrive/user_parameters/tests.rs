use super::*;
use crate::profidrive::telegram::STANDARD;
use rstest::rstest;

const MULTITURN: Hardware = Hardware { steps_per_revolution: 65536, revolutions: 16384 };
const SINGLETURN: Hardware = Hardware { steps_per_revolution: 262_144, revolutions: 1 };

// The defaults of the XAC77: manual, chapter 18.
fn default(hardware: &Hardware) -> UserParameterData {
    UserParameterData::of(0x22, Scaling::hardware(hardware), 1, 0)
}

static LIMITS: StartLimits = StartLimits { serves, velocity_units: VELOCITY_UNITS, tolerated_failures: 1..=u8::MAX };

fn settings(parameters: &UserParameterData, hardware: Hardware) -> MeasuringSettings {
    let encoder =
        ParametrizedEncoder { hardware, limits: &LIMITS, checks: &AttachedChecks::default(), steps: &Attached::NONE };
    parameters.settings(&encoder)
}

fn are_wrong(parameters: &UserParameterData, hardware: &Hardware) -> bool {
    let (hardware, checks) = (*hardware, &AttachedChecks::default());
    let encoder = ParametrizedEncoder { hardware, limits: &LIMITS, checks, steps: &Attached::NONE };
    !parameters.are_right(&encoder, &STANDARD[0])
}

// The default record of the multiturn encoder, byte by byte: manual, chapters 11.4 and 18.
const DEFAULT: [u8; OCTETS] =
    [0x22, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0x40, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];

#[test]
fn the_default_record() {
    let parameters = UserParameterData::parse(&DEFAULT);
    assert_eq!(parameters, Some(default(&MULTITURN)));
    assert!(!are_wrong(&default(&MULTITURN), &MULTITURN));
    assert!(!are_wrong(&default(&SINGLETURN), &SINGLETURN));
}

#[test]
fn every_other_length_is_refused_and_every_flipped_bit_is_read() {
    for length in 0..OCTETS {
        assert_eq!(UserParameterData::parse(&DEFAULT[..length]), None);
    }
    assert_eq!(UserParameterData::parse(&[&DEFAULT[..], &[0]].concat()), None);
    for bit in 0..8 * OCTETS {
        let mut octets = DEFAULT;
        octets[bit / 8] ^= 1 << (bit % 8);
        let parameters = UserParameterData::parse(&octets).expect("the length is right");
        let reserved = matches!(bit, 6 | 7) || bit / 8 >= 19;
        assert_eq!(parameters == default(&MULTITURN), reserved, "bit {bit}");
        settings(&parameters, MULTITURN);
    }
}

// Catalogue SCL-006, SCL-007, SCL-010, SCL-011, SCL-016, G1E-005, G1E-006 and manual 11.4, examples.
#[rstest]
#[case(MULTITURN, 1, 16384, true)]
#[case(MULTITURN, 65536, 1 << 30, true)]
#[case(MULTITURN, 65536, 442_236_928, true)]
#[case(MULTITURN, 4096, 1024, true)]
#[case(MULTITURN, 0, 1024, false)]
#[case(MULTITURN, 65537, 65537, false)]
#[case(MULTITURN, 65536, 1, false)]
#[case(MULTITURN, 65536, (1 << 30) + 1, false)]
#[case(MULTITURN, 1, 16385, false)]
#[case(MULTITURN, 1, 32768, false)]
#[case(MULTITURN, 1 << 32 | 4096, 1 << 24, false)]
#[case(MULTITURN, 4096, 1 << 32 | 1 << 24, false)]
#[case(SINGLETURN, 262_144, 262_144, true)]
#[case(SINGLETURN, 2, 2, true)]
#[case(SINGLETURN, 262_145, 262_144, false)]
#[case(SINGLETURN, 262_144, 262_145, false)]
#[case(SINGLETURN, 1, 2, false)]
fn limits(#[case] hardware: Hardware, #[case] units: u64, #[case] range: u64, #[case] right: bool) {
    let parameters = UserParameterData { scaling: true, units_per_revolution: units, range, ..default(&hardware) };
    assert_eq!(are_wrong(&parameters, &hardware), !right);
    let unscaled = UserParameterData { scaling: false, ..parameters };
    assert!(!are_wrong(&unscaled, &hardware));
    let class_3 = UserParameterData { class_4: false, ..parameters };
    assert!(!are_wrong(&class_3, &hardware));
    assert_eq!(settings(&class_3, hardware), MeasuringSettings::hardware(&hardware));
}

#[rstest]
#[case(0, 3, false)]
#[case(0, 4, true)]
#[case(0, 255, true)]
#[case::no_failures_tolerated_in_compatibility_mode(0x20, 0, true)]
fn other_fields(#[case] flip: u8, #[case] unit: u8, #[case] wrong: bool) {
    let mut octets = DEFAULT;
    octets[0] ^= flip;
    octets[18] = unit;
    octets[17] = u8::from(flip == 0);
    let parameters = UserParameterData::parse(&octets).expect("the length is right");
    assert_eq!(are_wrong(&parameters, &MULTITURN), wrong);
}
