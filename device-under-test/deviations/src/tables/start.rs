//! Bugs of the record of user parameters.

use super::Deviation;
use encoder_profile::encoder::{Direction, Hardware, Scaling, Unit};
use encoder_profile::profidrive::telegram::Signal;
use encoder_profile::profidrive::user_parameters::{Asked, OCTETS, Rules, UserParameters, unit};

/// The bugs of this seam.
pub static BUGS: &[Deviation] = encoder_bugs! {
    // Record
    "record-length-not-checked" "A record 0xBF00 of another length is accepted."
        => |b| b.user_parameters.checks_length = false;
    "record-taken-once" "Only the first record 0xBF00 after power-up is taken over."
        => |b| b.user_parameters.takes_every_record = false;
    "record-half-taken-in-data-exchange" "A record in data exchange is refused and scales the position nevertheless."
        => |b| b.user_parameters.measures_by_refused = true;
    "bits-2-and-3-exchanged" "Preset control and scaling change places in octet 0."
        => |b| b.user_parameters.octets =
            |octets| octets[0] = octets[0] & 0xF3 | octets[0] >> 1 & 4 | octets[0] << 1 & 8;
    "reserved-bit-7-acts" "Bit 7 of octet 0 turns the code sequence round."
        => |b| b.user_parameters.octets = |octets| octets[0] ^= octets[0] >> 7;
    "scaling-little-endian" "The scaling parameters are read with their least significant octet first."
        => |b| b.user_parameters.octets = scaling_little_endian;
    "octet-17-as-unit" "The velocity unit is read from octet 17."
        => |b| b.user_parameters.octets = |octets| octets[18] = octets[17];
    "unit-from-octet-19" "The velocity unit is read from octet 19."
        => |b| b.user_parameters.octets = |octets| octets[18] = octets[19];
    "reserved-octets-act" "Octet 30 becomes the preset value if it is not 0."
        => |b| b.user_parameters.preset_value = |octets| Some(octets[30].into()).filter(|value| *value != 0);
    "upper-scaling-octets-ignored" "Only the lower 32 bits of the scaling parameters count."
        => |b| b.user_parameters.understand = upper_scaling_octets_ignored;
    "units-and-range-exchanged" "Units per revolution and total range change places."
        => |b| b.user_parameters.understand = units_and_range_exchanged;
    "compatibility-inverted" "Compatibility mode has the natural polarity: 1 is enabled."
        => |b| b.user_parameters.understand = |_, user| UserParameters { compatible: !user.compatible, ..user };
    "tolerance-0-accepted" "No tolerated failures of the sign of life are accepted in silence."
        => |b| b.user_parameters.are_wrong = |_, _, _| false;

    // Class 4 and code sequence
    "class-4-always-on" "The class 4 bit is not looked at."
        => |b| b.user_parameters.understand = |_, user| UserParameters { class_4: true, ..user };
    "code-sequence-ignored" "The position rises clockwise whatever the record says."
        => |b| b.user_parameters.direction = |_, _| Direction::Clockwise;
    "code-sequence-without-class-4" "The code sequence acts although class 4 is off."
        => |b| b.user_parameters.direction = |user, _| user.direction;
    "direction-reversed" "The code sequence of the singleturn encoder is reversed."
        => |b| b.user_parameters.direction = direction_reversed;

    // Scaling
    "scaling-without-class-4" "Scaling acts although class 4 is off."
        => |b| b.user_parameters.scales = |user| user.scaling;
    "scaling-bit-ignored" "Scaling acts although it is off."
        => |b| b.user_parameters.scales = |user| user.class_4;
    "scaling-one-start-late" "The scaling of a record takes effect with the start after it."
        => |b| b.user_parameters.measures_by = scaling_one_start_late;
    "full-range-refused" "The whole range of the hardware is taken for an impossible one."
        => |b| b.user_parameters.judges = |right, asked| right && asked.scaling.range < asked.hardware.range();
    "full-units-refused" "As many units per revolution as the hardware has are taken for impossible."
        => |b| b.user_parameters.judges =
            |right, asked| right && asked.scaling.units_per_revolution < asked.hardware.steps_per_revolution;
    "limits-of-the-other-variant" "The limits of the scaling are those of the other variant."
        => |b| b.user_parameters.limits = |own, other| other.unwrap_or(own);
    "single-limits-not-checked" "Units per revolution and range beyond their limits are accepted in silence."
        => |b| b.user_parameters.judges = single_limits_not_checked;
    "impossible-scaling-accepted" "A ratio that the hardware cannot serve is accepted in silence."
        => |b| b.user_parameters.judges = |right, asked| right || are_single_limits_kept(asked);
    "powers-of-two-only" "Scaling parameters that are no powers of two are taken for impossible."
        => |b| b.user_parameters.judges = |right, asked| {
            right && asked.scaling.units_per_revolution.is_power_of_two() && asked.scaling.range.is_power_of_two()
        };
    "zero-units-stop-the-device" "No units per revolution stop the device, scaling off or not."
        => |b| b.user_parameters.starts = |user| user.units_per_revolution != 0;

    // Velocity unit
    "speed-unit-not-checked" "An unknown velocity unit is taken as steps per second in silence."
        => |b| b.user_parameters.unit = |number| unit(number).or(Some(Unit::PerSecond));
    "speed-unit-ignored" "The velocity is given in steps per second whatever its unit."
        => |b| b.user_parameters.unit = |number| unit(number).map(|_| Unit::PerSecond);
    "speed-unit-refused-without-velocity" "A velocity unit other than 0 is taken for wrong with telegram 81."
        => |b| b.user_parameters.are_wrong = |user, telegram, _| user.speed_unit != 0 && telegram.number == 81;

    // Defaults
    "default-record-is-wrong" "The switches by default are taken for wrong."
        => |b| b.user_parameters.are_wrong = |user, _, default| user.bits == default.bits;
    "defaults-of-another-model" "Without scaling a revolution has 8192 units."
        => |b| b.user_parameters.unscaled =
            |hardware| Scaling { units_per_revolution: 8192, ..Scaling::hardware(hardware) };
    "default-range-of-one-revolution" "Without scaling the total range is one revolution."
        => |b| b.user_parameters.unscaled =
            |hardware| Scaling { range: hardware.steps_per_revolution, ..Scaling::hardware(hardware) };
    "default-switches-inverted" "Without a record each switch of octet 0 is the other way round."
        => |b| b.user_parameters.default = default_switches_inverted;
    "default-tolerance-10" "Without a record ten failures of the sign of life are tolerated."
        => |b| (b.user_parameters.default, b.life_sign.tolerated_without_compatibility) = (default_tolerance_10, |n| n);
    "default-speed-unit-rpm" "Without a record the velocity is given in rpm."
        => |b| b.user_parameters.default =
            |right, _| UserParameters { speed_unit: Unit::Rpm as u8, ..right };
};

/// The bugs of this seam that not all manuals have.
pub static OTHERS: &[Deviation] = encoder_bugs! {
    // Record
    "scaling-of-32-bits" "The scaling parameters are read as if they had 32 bits."
        => |b| b.user_parameters.octets = scaling_of_32_bits;
    "record-of-30-octets" "A record 0xBF00 has to have 30 octets."
        => |b| b.user_parameters.octets_expected = 30;
    "life-sign-octet-refused" "A tolerance of the sign of life other than 0 is taken for wrong."
        => |b| b.user_parameters.are_wrong = |user, _, _| user.life_sign_failures != 0;
    "code-sequence-inverted" "The position falls with the code sequence for which it should rise."
        => |b| b.user_parameters.direction = |user, _| match user.direction {
            Direction::Clockwise if user.class_4 => Direction::Counterclockwise,
            _ => Direction::Clockwise,
        };
    "class-4-inverted" "Class 4 is on while its bit is 0."
        => |b| b.user_parameters.understand = |_, user| UserParameters { class_4: !user.class_4, ..user };
    "missing-record-ignored" "A start without a record is no error."
        => |b| b.user_parameters.without_record = |_| true;
    "invalid-record-accepted" "With a scaling of 0 the parameters before stay in force without an error."
        => |b| b.user_parameters.understand = |before, user| match (user.units_per_revolution, user.range) {
            (0, 0) => before,
            _ => user,
        };
    "parameter-error-latched" "Wrong parameters stay an error for the rest of the connection."
        => |b| b.user_parameters.stays_wrong = true;
    "mantel860-waits-for-preset" "With telegram 860 there is no ApplicationReady before a parameter request."
        => |b| b.records.starts = |telegram, was_asked| telegram.number != 860 || was_asked;

    // In data exchange
    "record-in-exchange-waits-for-start" "A record in data exchange is accepted and changes nothing."
        => |b| b.user_parameters.acts_in_exchange = false;
    "record-of-data-exchange-stays" "A record in data exchange outlasts those of later starts."
        => |b| b.user_parameters.outlasts_starts = true;
    "new-scaling-in-mantel860-only" "A record in data exchange scales the position of telegram 860 alone."
        => |b| b.user_parameters.acts_since =
            |signal, now, at_start| if signal == Signal::Position { now } else { at_start };

    // Scaling
    "revolution-of-hardware-steps" "A unit is a step of the hardware, whatever the units per revolution."
        => |b| b.measuring.scale(|scaling, _, place| place % scaling.range);
    "range-of-24-bits" "Only the lower 24 bits of the total range count."
        => |b| b.user_parameters.understand = |_, user| UserParameters { range: user.range & 0x00FF_FFFF, ..user };
    "range-of-25-bits" "A range of more than 25 bits is taken for impossible."
        => |b| b.user_parameters.judges = |right, asked| right && asked.scaling.range <= 1 << 25;

    // The status, as it is read
    "status-of-31-octets" "The status is the record that was written."
        => |b| b.records.status = |_, written| written.into();
    "status-one-word-late" "The supported warnings are left out of the status, and what is behind them comes earlier."
        => |b| b.records.status = |mut octets, _| {
            octets.drain(20..24);
            octets.extend([0; 4]);
            octets
        };
    "profile-version-in-one-octet" "The version of the profile has one octet."
        => |b| b.at_encoder.element(|_, at, right| if at == (65001, 6) { 0x41 } else { right });
    "profile-version-3-1" "The status tells version 3.1 of the profile."
        => |b| b.at_encoder.element(|_, at, right| if at == (65001, 6) { 0x301 } else { right });
};

fn scaling_of_32_bits(octets: &mut [u8; OCTETS]) {
    for begin in [1, 9] {
        octets.copy_within(begin..begin + 4, begin + 4);
        octets[begin..begin + 4].fill(0);
    }
}

fn scaling_little_endian(octets: &mut [u8; OCTETS]) {
    octets[1..9].reverse();
    octets[9..17].reverse();
}

fn upper_scaling_octets_ignored(_: UserParameters, user: UserParameters) -> UserParameters {
    let UserParameters { units_per_revolution, range, .. } = user;
    UserParameters { units_per_revolution: units_per_revolution & 0xFFFF_FFFF, range: range & 0xFFFF_FFFF, ..user }
}

fn units_and_range_exchanged(_: UserParameters, user: UserParameters) -> UserParameters {
    UserParameters { units_per_revolution: user.range, range: user.units_per_revolution, ..user }
}

fn direction_reversed(user: &UserParameters, hardware: &Hardware) -> Direction {
    match ((Rules::default().direction)(user, hardware), hardware.revolutions) {
        (Direction::Clockwise, 1) => Direction::Counterclockwise,
        (Direction::Counterclockwise, 1) => Direction::Clockwise,
        (direction, _) => direction,
    }
}

fn scaling_one_start_late(before: UserParameters, now: UserParameters) -> UserParameters {
    let UserParameters { scaling, units_per_revolution, range, .. } = before;
    UserParameters { scaling, units_per_revolution, range, ..now }
}

fn are_single_limits_kept(asked: &Asked) -> bool {
    let Asked { scaling: Scaling { units_per_revolution: units, range }, hardware, .. } = *asked;
    (1..=hardware.steps_per_revolution).contains(&units) && (2..=hardware.range()).contains(&range)
}

fn single_limits_not_checked(right: bool, asked: &Asked) -> bool {
    let is_number = asked.scaling.range != 0;
    right || is_number && !are_single_limits_kept(asked)
}

fn default_switches_inverted(right: UserParameters, _: &Hardware) -> UserParameters {
    UserParameters {
        bits: right.bits ^ 0x3F,
        direction: Direction::Counterclockwise,
        class_4: !right.class_4,
        preset_acts_on_xist1: !right.preset_acts_on_xist1,
        scaling: !right.scaling,
        alarm_channel: !right.alarm_channel,
        compatible: !right.compatible,
        ..right
    }
}

fn default_tolerance_10(right: UserParameters, _: &Hardware) -> UserParameters {
    UserParameters { life_sign_failures: 10, ..right }
}
