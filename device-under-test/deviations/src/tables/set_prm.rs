//! Bugs of what Set_Prm and Chk_Cfg bring to an encoder with PROFIBUS, and of what is so at delivery.

use super::Deviation;
use core::time::Duration;
use encoder_profile::checks::Check;
use encoder_profile::encoder::{Hardware, Unit};
use encoder_profile::profidrive::user_parameters::{UserParameters, serves};
use reference_devices::models::sick_a3m60::knobs::{Brought, Fields, OCTETS, Times};

/// The bugs of this seam.
pub static BUGS: &[Deviation] = bugs! {
    // At delivery
    "default-counterclockwise" "The code sequence is taken the wrong way round."
        => |b| b.a3m60.understands = |fields| switched(fields, 0, 1);
    "default-class-4-off" "Class 4 is off where the octets of delivery come."
        => |b| b.a3m60.understands = |fields| if fields == Fields::DELIVERED { switched(fields, 0, 2) } else { fields };
    "default-preset-control-off" "The bit of the preset control is taken the wrong way round."
        => |b| b.a3m60.understands = |fields| switched(fields, 0, 4);
    "default-scaling-on" "Scaling is on whatever the bit says, with 8192 steps and 67108864 in all for the highest resolution."
        => |b| b.a3m60.understands = default_scaling_on;
    "default-alarm-channel-on" "The alarm channel works whatever its bit says."
        => |b| b.a3m60.understands = |fields| set(fields, 0, 0x10);
    "default-compatibility-off" "The bit of the compatibility mode is taken the wrong way round."
        => |b| b.a3m60.understands = |fields| switched(fields, 0, 0x20);
    "clock-simulated-by-default" "The clock is simulated whatever the bit says."
        => |b| b.a3m60.understands = |fields| set(fields, 1, 2);
    "default-show-fault-code-off" "The bit that shows fault codes is taken the wrong way round."
        => |b| b.a3m60.understands = |fields| switched(fields, 1, 4);
    "default-speed-calculation-off" "The bit of the speed calculation is taken the wrong way round."
        => |b| b.a3m60.understands = |fields| switched(fields, 1, 8);
    "default-resolution-of-13-bits" "Steps and range above 8192 and 67108864 are shown as these."
        => |b| b.at_encoder.element(|_, at, right| match at { (65001, 9) => right.min(8192), (65001, 10) => right.min(1 << 26), _ => right });
    "default-tolerance-wrong" "A tolerance of 1 counts and is shown as 10."
        => |b| b.a3m60.understands = |fields| Fields { failures: if fields.failures == 1 { 10 } else { fields.failures }, ..fields };
    "default-speed-unit-steps" "Unit 3 counts and is shown as steps per second."
        => |b| b.a3m60.understands = |fields| Fields { speed_unit: if fields.speed_unit == 3 { 0 } else { fields.speed_unit }, ..fields };
    "default-samples-1" "The position is always a single sample."
        => |b| b.a3m60.samples = |_, _| 1;
    "default-round-axis-on" "P1009 reads 1 for the mode, whatever it is."
        => |b| b.a3m60.axis = |axis| with(axis, &[(0, 1)]);
    "default-fraction-wrong" "P1009 reads 1 and 0 for nominator and divisor while the function is off."
        => |b| b.a3m60.axis = |axis| if axis[0] == 0 { with(axis, &[(1, 1), (2, 0)]) } else { axis };
    "waits-for-a-clock" "Without isochronous parameters the encoder waits for the clock all the same."
        => |b| b.a3m60.times = |right| right.or(Some(MILLISECOND));
    "delivered-preset-value-wrong" "P65000 of a new encoder is FFFFFFFFh."
        => |b| b.encoder.memory.preset_value_begins = |stored| if stored == 0 { u32::MAX } else { stored };

    // What is taken
    "zero-units-taken" "No step in a revolution is accepted."
        => |b| b.checks.serves(|user, _, right| right || user.units_per_revolution == 0);
    "range-of-zero-taken" "A range of 0 is taken for one revolution."
        => |b| b.a3m60.understands = |fields| Fields { range: if fields.range == 0 { fields.units } else { fields.range }, ..fields };
    "impossible-scaling-accepted" "More steps in a revolution or a wider range than the sensor has are accepted in silence."
        => |b| b.checks.serves(impossible_scaling_accepted);
    "rule-of-powers-missing" "Any range is accepted without the round axis."
        => |b| b.checks.serves(|user, hardware, _| serves(user, hardware));
    "more-revolutions-than-there-are" "A range of more revolutions than the encoder has is accepted."
        => |b| b.checks.serves(more_revolutions_than_there_are);
    "singleturn-range-refused" "A range of one revolution is refused."
        => |b| b.checks.serves(|user, _, right| right && user.range != user.units_per_revolution);
    "range-halved" "The range in force is half of the one that is set."
        => |b| b.a3m60.understands = |fields| Fields { range: fields.range / 2, ..fields };
    "unit-4-ignored" "Unit 4 counts as revolutions per minute."
        => |b| b.a3m60.understands = |fields| Fields { speed_unit: if fields.speed_unit == 4 { 3 } else { fields.speed_unit }, ..fields };
    "speed-unit-ignored" "The velocity is in revolutions per minute whatever its unit."
        => |b| b.start.velocity_unit(|_, _| Unit::Rpm);
    "speed-units-exchanged" "The units 1 and 2 are exchanged."
        => |b| b.a3m60.understands = speed_units_exchanged;
    "undefined-speed-unit-taken" "A unit that is none is taken for steps per second."
        => |b| b.checks.check(|check, right| right || matches!(check, Check::VelocityUnitExists(_)));
    "user-octets-shifted" "The user octets are read one octet late."
        => |b| b.a3m60.octets = |octets| octets.into_iter().skip(1).collect();
    "parameter-length-not-checked" "Octets behind the last one are not looked at."
        => |b| b.a3m60.takes_length = |length| length >= OCTETS;
    "missing-octets-from-old-buffer" "Octets that are missing are taken from the Set_Prm before."
        => |b| (b.a3m60.takes_length, b.a3m60.fills_missing) = (|length| length <= OCTETS, true);
    "get-cfg-constant" "Get_Cfg tells the first module, whatever is configured."
        => |b| b.a3m60.told_configuration = |_| 0;
    "round-axis-modulo-stays" "The round axis stays on once it was."
        => |b| b.a3m60.starts = round_axis_stays;
    "configuration-not-checked" "Any configuration is taken, and one that is wrong for the first module."
        => |b| b.a3m60.configuration = |_, right| right.or(Some(0));
    "telegram-83-refused" "The configuration of telegram 83 is refused."
        => |b| b.a3m60.configuration = |_, right| right.filter(|module| *module != 3);
    "module-missing" "The configuration of IO 08 is refused."
        => |b| b.a3m60.configuration = |_, right| right.filter(|module| *module != 1);
};

const MILLISECOND: Times =
    Times { cycle: Duration::from_millis(1), window: Duration::from_micros(1), is_simulated: false };

fn switched(fields: Fields, octet: usize, bits: u8) -> Fields {
    let mut switches = fields.switches;
    switches[octet] ^= bits;
    Fields { switches, ..fields }
}

fn set(fields: Fields, octet: usize, bits: u8) -> Fields {
    let mut switches = fields.switches;
    switches[octet] |= bits;
    Fields { switches, ..fields }
}

/// The elements of P1009 with others in some places.
pub fn with(mut axis: [u64; 11], others: &[(usize, u64)]) -> [u64; 11] {
    others.iter().for_each(|(at, value)| axis[*at] = *value);
    axis
}

fn default_scaling_on(fields: Fields) -> Fields {
    match (fields.units, fields.range) {
        (16384, 0x8000_0000) => Fields { units: 8192, range: 1 << 26, ..set(fields, 0, 8) },
        _ => set(fields, 0, 8),
    }
}

fn more_revolutions_than_there_are(user: &UserParameters, hardware: &Hardware, right: bool) -> bool {
    let (units, range) = (user.units_per_revolution, user.range);
    let is_possible = (1..=hardware.steps_per_revolution).contains(&units);
    right || is_possible && range.is_multiple_of(units) && (range / units).is_power_of_two()
}

fn impossible_scaling_accepted(user: &UserParameters, hardware: &Hardware, right: bool) -> bool {
    right || user.units_per_revolution > hardware.steps_per_revolution || user.range > hardware.range()
}

fn speed_units_exchanged(fields: Fields) -> Fields {
    let speed_unit = match fields.speed_unit {
        1 => 2,
        2 => 1,
        other => other,
    };
    Fields { speed_unit, ..fields }
}

fn round_axis_stays(before: Brought, now: Brought) -> Brought {
    match before.fields.has_axis() && !now.fields.has_axis() {
        true => Brought {
            fields: Fields {
                nominator: before.fields.nominator,
                divisor: before.fields.divisor,
                range: before.fields.range,
                ..set(now.fields, 1, 1)
            },
            ..now
        },
        false => now,
    }
}
