//! Bugs of the record of user parameters.

use super::Bug;
use crate::encoder::{Hardware, Scaling, Unit};
use crate::profidrive::user_parameters::{UserParameters, unit};

pub(crate) static BUGS: &[Bug] = bugs! {
    // Start-up record
    "record-length-not-checked" "A record 0xBF00 of another length is accepted."
        => |b| b.user_parameters.checks_length = false;
    "record-taken-once" "Only the first record 0xBF00 after power-up is taken over."
        => |b| b.user_parameters.takes_every_record = false;
    "class-4-always-on" "The class 4 bit is not looked at."
        => |b| b.user_parameters.understand = |user| UserParameters { class_4: true, ..user };
    "code-sequence-ignored" "The position rises clockwise whatever the record says."
        => |b| b.user_parameters.directs = |_| false;
    "code-sequence-without-class-4" "The code sequence acts although class 4 is off."
        => |b| b.user_parameters.directs = |_| true;
    "scaling-without-class-4" "Scaling acts although class 4 is off."
        => |b| b.user_parameters.scales = |user| user.scaling;
    "compatibility-inverted" "Compatibility mode has the natural polarity: 1 is enabled."
        => |b| b.user_parameters.understand = |user| UserParameters { compatible: !user.compatible, ..user };
    "upper-scaling-octets-ignored" "Only the lower 32 bits of the scaling parameters count."
        => |b| b.user_parameters.understand = upper_scaling_octets_ignored;
    "units-and-range-exchanged" "Units per revolution and total range change places."
        => |b| b.user_parameters.understand = units_and_range_exchanged;
    "full-range-refused" "The whole range of the hardware is taken for an impossible one."
        => |b| b.user_parameters.greatest_range = |range| range - 1;
    "default-range-of-one-revolution" "Without scaling the total range is one revolution."
        => |b| b.user_parameters.unscaled = range_of_one_revolution;
    "default-speed-unit-rpm" "Without a record the velocity is given in rpm."
        => |b| b.user_parameters.default = default_speed_unit_rpm;
    "impossible-scaling-accepted" "A ratio that the hardware cannot serve is accepted in silence."
        => |b| b.user_parameters.checks_ratio = false;
    "speed-unit-not-checked" "An unknown velocity unit is taken as steps per second in silence."
        => |b| b.user_parameters.unit = |number| unit(number).or(Some(Unit::PerSecond));
};

fn upper_scaling_octets_ignored(user: UserParameters) -> UserParameters {
    let UserParameters { units_per_revolution, range, .. } = user;
    UserParameters { units_per_revolution: units_per_revolution & 0xFFFF_FFFF, range: range & 0xFFFF_FFFF, ..user }
}

fn units_and_range_exchanged(user: UserParameters) -> UserParameters {
    UserParameters { units_per_revolution: user.range, range: user.units_per_revolution, ..user }
}

fn range_of_one_revolution(hardware: &Hardware) -> Scaling {
    Scaling { range: hardware.steps_per_revolution, ..Scaling::hardware(hardware) }
}

fn default_speed_unit_rpm(hardware: &Hardware) -> UserParameters {
    UserParameters { speed_unit: Unit::Rpm as u8, ..UserParameters::xac77_default(hardware) }
}
