//! The user parameter data that encoders of the profile are given at each start: record 0xBF00, 31 octets.
//!
//! Layout, the same in all manuals that follow the profile: octet 0 bits (0 code sequence, 1 class 4, 2 G1_XIST1 preset
//! control, 3 scaling, 4 alarm channel, 5 compatibility), 1-8 units per revolution, 9-16 total range, 17 tolerated
//! failures of the sign of life, 18 velocity unit, 19-30 reserved. Source: XAC77 manual, 11.4.

use super::telegram::{Signal, Telegram};
use crate::encoder::{Direction, Hardware, Scaling, Settings, Unit};
use wire::octets::Reader;

/// Octets of the record.
pub const OCTETS: usize = 31;

/// The user parameters, as far as they have a function.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UserParameters {
    /// Bits 0 to 5 of octet 0 as they came, for the operating status.
    pub bits: u8,
    /// Bit 0: in which direction the position rises.
    pub direction: Direction,
    /// Bit 1: class 4, without which direction, preset and scaling do nothing.
    pub class_4: bool,
    /// Bit 2, 0 for enabled: whether a preset acts on G1_XIST1.
    pub preset_acts_on_xist1: bool,
    /// Bit 3: scaling.
    pub scaling: bool,
    /// Bit 4: whether diagnoses are sent in compatibility mode.
    pub alarm_channel: bool,
    /// Bit 5, 0 for enabled: compatibility with version 3.1 of the profile.
    pub compatible: bool,
    /// Measuring units per revolution.
    pub units_per_revolution: u64,
    /// Total measuring range in units.
    pub range: u64,
    /// Tolerated failures of the sign of life of the controller in compatibility mode.
    pub life_sign_failures: u8,
    /// In what the velocity is expressed.
    pub speed_unit: u8,
}

/// A scaling that is asked for.
#[derive(Clone, Copy, Debug)]
pub struct Asked {
    /// The scaling.
    pub scaling: Scaling,
    /// The hardware that has to serve it.
    pub hardware: Hardware,
    /// Whether positions begin anew after their range wherever the shaft turns.
    pub is_cyclic: bool,
}

/// Where bugs can be put into the user parameters.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// Whether another length than 31 octets is refused.
    pub checks_length: bool,
    /// Whether each record is taken over, or only the first after power-up.
    pub takes_every_record: bool,
    /// Whether a record that is taken in data exchange is in force at once, and not at the next start only.
    pub acts_in_exchange: bool,
    /// Whether a record that is taken in data exchange outlasts those of later starts.
    pub outlasts_starts: bool,
    /// The octets that a record has.
    pub octets_expected: usize,
    /// The parameters without a record, from the right ones.
    pub default: fn(UserParameters, &Hardware) -> UserParameters,
    /// Whether the parameters without a record are in force without an error, from what is right.
    pub without_record: fn(bool) -> bool,
    /// The octets that are read, from those of the record.
    pub octets: fn(&mut [u8; OCTETS]),
    /// How the fields are understood, from the parameters in force before and those of this start.
    pub understand: fn(UserParameters, UserParameters) -> UserParameters,
    /// The preset value that a record brings; none leaves it as it is.
    pub preset_value: fn(&[u8; OCTETS]) -> Option<u32>,
    /// The parameters that turn and scale the position from a start on, from those before and those of this start.
    pub measures_by: fn(UserParameters, UserParameters) -> UserParameters,
    /// Whether a record in data exchange, which is refused, turns and scales the position nevertheless.
    pub measures_by_refused: bool,
    /// Whether a record with these parameters is taken.
    pub accepts: fn(&UserParameters, &Hardware) -> bool,
    /// Whether the velocity is measured with these parameters.
    pub measures_velocity: fn(&UserParameters) -> bool,
    /// Whether the encoder gets into data exchange with these parameters.
    pub starts: fn(&UserParameters) -> bool,
    /// In which direction the position rises.
    pub direction: fn(&UserParameters, &Hardware) -> Direction,
    /// Whether scaling is in force.
    pub scales: fn(&UserParameters) -> bool,
    /// The scaling in force where that of the user is not.
    pub unscaled: fn(&Hardware) -> Scaling,
    /// Whether presets and their offset are in force.
    pub presets: fn(&UserParameters) -> bool,
    /// Whether a preset acts on G1_XIST2 and G1_XIST3.
    pub presets_xist2: fn(&UserParameters) -> bool,
    /// The hardware of another variant of the manual, if there is one; the device fills it in.
    pub other: Option<Hardware>,
    /// The hardware whose limits count, from its own and that of another variant.
    pub limits: fn(Hardware, Option<Hardware>) -> Hardware,
    /// Whether positions begin anew after their range wherever the shaft turns.
    pub is_cyclic: fn(&UserParameters) -> bool,
    /// Whether the hardware can serve a scaling.
    pub serves: fn(&Asked) -> bool,
    /// The last word on a scaling, from whether the hardware can serve it.
    pub judges: fn(bool, &Asked) -> bool,
    /// Whether something beside scaling and unit is wrong in the parameters for a telegram; the last are those by
    /// default.
    pub are_wrong: fn(&UserParameters, &Telegram, &UserParameters) -> bool,
    /// The unit of a number; none for a number that is none.
    pub unit: fn(u8) -> Option<Unit>,
    /// The settings that act on a position signal, from those in force.
    pub acts_on: fn(Signal, Settings, &Hardware) -> Settings,
    /// The scaling of the velocity, from the one in force.
    pub scales_velocity: fn(Scaling, &Hardware, &UserParameters) -> Scaling,
    /// Whether wrong parameters stay wrong for the rest of the connection.
    pub stays_wrong: bool,
    /// The settings that act on a position signal, from those in force and those at the end of the start-up.
    pub acts_since: fn(Signal, Settings, Settings) -> Settings,
    /// Whether positions stand at their last value beyond the range, from whether they should.
    pub stands: fn(bool) -> bool,
}

impl Default for Rules {
    fn default() -> Rules {
        Rules {
            checks_length: true,
            takes_every_record: true,
            acts_in_exchange: true,
            outlasts_starts: false,
            octets_expected: OCTETS,
            default: |right, _| right,
            without_record: |right| right,
            octets: |_| {},
            understand: |_, now| now,
            preset_value: |_| None,
            measures_by: |_, now| now,
            measures_by_refused: false,
            accepts: |_, _| true,
            measures_velocity: |_| true,
            starts: |_| true,
            direction: |parameters, _| if parameters.class_4 { parameters.direction } else { Direction::Clockwise },
            scales: |parameters| parameters.class_4 && parameters.scaling,
            unscaled: Scaling::hardware,
            presets: |parameters| parameters.class_4,
            presets_xist2: |_| true,
            other: None,
            limits: |own, _| own,
            is_cyclic: |_| true,
            serves,
            judges: |right, _| right,
            are_wrong: |parameters, _, _| parameters.compatible && parameters.life_sign_failures == 0,
            unit,
            acts_on: |_, settings, _| settings,
            scales_velocity: |scaling, _, _| scaling,
            stays_wrong: false,
            acts_since: |_, now, _| now,
            stands: |right| right,
        }
    }
}

/// Whether the hardware can serve a scaling.
///
/// Units per revolution go from 1 to the steps of the hardware, the range from 2 to all its steps, and the range must
/// not need more revolutions than there are. A range below one revolution is served.
pub fn serves(asked: &Asked) -> bool {
    let Asked { scaling: Scaling { units_per_revolution: units, range }, hardware, .. } = *asked;
    (1..=hardware.steps_per_revolution).contains(&units)
        && (2..=hardware.range()).contains(&range)
        && range <= units.saturating_mul(hardware.revolutions)
}

/// The velocity unit of a number.
pub fn unit(number: u8) -> Option<Unit> {
    match number {
        0 => Some(Unit::PerSecond),
        1 => Some(Unit::Per100Milliseconds),
        2 => Some(Unit::Per10Milliseconds),
        3 => Some(Unit::Rpm),
        _ => None,
    }
}

impl UserParameters {
    /// Reads the record; none if octets are missing. Reserved bits and octets have no function.
    pub fn parse(octets: &[u8]) -> Option<UserParameters> {
        let mut reader = Reader::new("user parameter data", octets);
        let bits = reader.u8().ok()?;
        let units_per_revolution = u64::from_be_bytes(reader.array().ok()?);
        let range = u64::from_be_bytes(reader.array().ok()?);
        let [life_sign_failures, speed_unit] = reader.array().ok()?;
        reader.take(OCTETS - 19).ok()?;
        Some(UserParameters::of(bits, Scaling { units_per_revolution, range }, life_sign_failures, speed_unit))
    }

    /// Those of a record with these octets and numbers: `bits` is octet 0, of which bits 6 and 7 have no function.
    pub fn of(bits: u8, scaling: Scaling, life_sign_failures: u8, speed_unit: u8) -> UserParameters {
        let bit = |n: u32| bits >> n & 1 != 0;
        UserParameters {
            bits: bits & 0x3F,
            direction: if bit(0) { Direction::Counterclockwise } else { Direction::Clockwise },
            class_4: bit(1),
            preset_acts_on_xist1: !bit(2),
            scaling: bit(3),
            alarm_channel: bit(4),
            compatible: !bit(5),
            units_per_revolution: scaling.units_per_revolution,
            range: scaling.range,
            life_sign_failures,
            speed_unit,
        }
    }

    /// The scaling in force; none if the hardware cannot serve what is asked for. Values that are not in force are not
    /// looked at.
    pub fn scaling(&self, hardware: &Hardware, rules: &Rules) -> Option<Scaling> {
        if !(rules.scales)(self) {
            return Some((rules.unscaled)(hardware));
        }
        let scaling = Scaling { units_per_revolution: self.units_per_revolution, range: self.range };
        let limits = (rules.limits)(*hardware, rules.other);
        let asked = Asked { scaling, hardware: limits, is_cyclic: (rules.is_cyclic)(self) };
        (rules.judges)((rules.serves)(&asked), &Asked { hardware: *hardware, ..asked }).then_some(scaling)
    }

    /// Whether something is set that the encoder cannot do with this telegram: the parametrization error.
    ///
    /// The tolerated failures count in compatibility mode only, and are at least 1 there. `default` are the parameters
    /// without a record.
    pub fn are_wrong(&self, hardware: &Hardware, telegram: &Telegram, default: &UserParameters, rules: &Rules) -> bool {
        self.scaling(hardware, rules).is_none()
            || (rules.unit)(self.speed_unit).is_none()
            || (rules.are_wrong)(self, telegram, default)
    }

    /// The velocity unit in force; where it is none, steps per second stand in for it.
    pub fn velocity_unit(&self, rules: &Rules) -> Unit {
        (rules.unit)(self.speed_unit).unwrap_or(Unit::PerSecond)
    }

    /// The settings of the measuring task; where the scaling is wrong, that of the hardware stands in for it.
    pub fn settings(&self, hardware: &Hardware, rules: &Rules) -> Settings {
        let scaling = self.scaling(hardware, rules).unwrap_or(Scaling::hardware(hardware));
        Settings::scaled((rules.direction)(self, hardware), scaling, (rules.presets)(self))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::profidrive::telegram::STANDARD;
    use rstest::rstest;

    const MULTITURN: Hardware = Hardware { steps_per_revolution: 65536, revolutions: 16384 };
    const SINGLETURN: Hardware = Hardware { steps_per_revolution: 262_144, revolutions: 1 };

    // The defaults of the XAC77: manual, chapter 18.
    fn default(hardware: &Hardware) -> UserParameters {
        UserParameters::of(0x22, Scaling::hardware(hardware), 1, 0)
    }

    fn are_wrong(parameters: &UserParameters, hardware: &Hardware) -> bool {
        parameters.are_wrong(hardware, &STANDARD[0], &default(hardware), &Rules::default())
    }

    // The default record of the multiturn encoder, octet by octet: manual, chapters 11.4 and 18.
    const DEFAULT: [u8; OCTETS] =
        [0x22, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0x40, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0];

    #[test]
    fn the_default_record() {
        let parameters = UserParameters::parse(&DEFAULT);
        assert_eq!(parameters, Some(default(&MULTITURN)));
        assert!(!are_wrong(&default(&MULTITURN), &MULTITURN));
        assert!(!are_wrong(&default(&SINGLETURN), &SINGLETURN));
    }

    #[test]
    fn every_prefix_is_refused_and_every_flipped_bit_is_read() {
        for length in 0..OCTETS {
            assert_eq!(UserParameters::parse(&DEFAULT[..length]), None);
        }
        for bit in 0..8 * OCTETS {
            let mut octets = DEFAULT;
            octets[bit / 8] ^= 1 << (bit % 8);
            let parameters = UserParameters::parse(&octets).expect("the length is right");
            let reserved = matches!(bit, 6 | 7) || bit / 8 >= 19;
            assert_eq!(parameters == default(&MULTITURN), reserved, "bit {bit}");
            parameters.settings(&MULTITURN, &Rules::default());
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
        let parameters = UserParameters { scaling: true, units_per_revolution: units, range, ..default(&hardware) };
        assert_eq!(are_wrong(&parameters, &hardware), !right);
        let unscaled = UserParameters { scaling: false, ..parameters };
        assert!(!are_wrong(&unscaled, &hardware));
        let class_3 = UserParameters { class_4: false, ..parameters };
        assert!(!are_wrong(&class_3, &hardware));
        assert_eq!(class_3.settings(&hardware, &Rules::default()), Settings::hardware(&hardware));
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
        let parameters = UserParameters::parse(&octets).expect("the length is right");
        assert_eq!(are_wrong(&parameters, &MULTITURN), wrong);
    }

    // The limits of the other variant count, and the last word is spoken about the own hardware.
    #[test]
    fn limits_and_judgement() {
        let asked = UserParameters { scaling: true, range: 1 << 20, ..default(&MULTITURN) };
        let mut rules = Rules { other: Some(SINGLETURN), ..Rules::default() };
        assert!(asked.scaling(&MULTITURN, &rules).is_some());
        rules.limits = |own, other| other.unwrap_or(own);
        assert!(asked.scaling(&MULTITURN, &rules).is_none());
        rules.judges = |right, asked| !right && asked.hardware == MULTITURN && asked.is_cyclic;
        assert!(asked.scaling(&MULTITURN, &rules).is_some());
    }
}
