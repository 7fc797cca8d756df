//! Bugs of the parameters in Set_Prm, of Chk_Cfg, and of the factory settings of a PROFIBUS encoder.

use super::Group;
use crate::needs::Need;
use crate::seams::a3m60::{with_fields, with_user_octets};
use crate::seams::slave::{frame, with_data};
use alloc::vec::Vec;
use core::time::Duration;
use device_stack::profibus::SlaveHooks;
use encoder_profile::checks::EncoderCheck;
use encoder_profile::encoder::{Hardware, VelocityUnit};
use encoder_profile::hooks::RetainedEncoderData;
use encoder_profile::profidrive::user_parameters::{UserParameterData, serves};
use reference_devices::manuals;
use reference_devices::models::sick_a3m60::set_prm::{OCTETS, UserByteFields};
use reference_devices::models::sick_a3m60::{CONFIGURATIONS, IsochronousTimes};
use wire::profibus::prm::SetPrm;
use wire::profibus::sap::{SapService, SlaveSap};

/// The bugs, by what they need.
pub static GROUPS: &[Group] = &[Group {
    needs: &[Need::Of(&manuals::SICK_A3M60)],
    deviations: bugs! {
        // Factory settings
        "default-counterclockwise" "Without user bytes the code sequence is counterclockwise."
            => |d| d.a3m60.delivered(|fields| switched(fields, 0, 1));
        "default-class-4-off" "Without user bytes class 4 is off."
            => |d| d.a3m60.delivered(|fields| switched(fields, 0, 2));
        "default-preset-control-off" "Without user bytes the preset control is off."
            => |d| d.a3m60.delivered(|fields| switched(fields, 0, 4));
        "default-scaling-on" "Without user bytes scaling is on, with 8192 steps and a range of 67108864."
            => |d| d.a3m60.delivered(|fields| UserByteFields { units: 8192, range: 1 << 26, ..switched(fields, 0, 8) });
        "default-alarm-channel-on" "Without user bytes the alarm channel is on."
            => |d| d.a3m60.delivered(|fields| switched(fields, 0, 0x10));
        "default-compatibility-off" "Without user bytes compatibility mode is off."
            => |d| d.a3m60.delivered(|fields| switched(fields, 0, 0x20));
        "clock-simulated-by-default" "The clock is always simulated."
            => |d| d.fields(|fields| set(fields, 1, 2));
        "default-show-fault-code-off" "Without user bytes no fault codes are shown."
            => |d| d.a3m60.delivered(|fields| switched(fields, 1, 4));
        "default-speed-calculation-off" "Without user bytes the speed is not calculated."
            => |d| d.a3m60.delivered(|fields| switched(fields, 1, 8));
        "default-resolution-of-13-bits" "Without user bytes P65001 has 8192 steps and a range of 67108864."
            => |d| d.a3m60.delivered(|fields| UserByteFields { units: 8192, range: 1 << 26, ..switched(fields, 0, 8) });
        "default-tolerance-wrong" "Without user bytes the tolerance is 10."
            => |d| d.a3m60.delivered(|fields| UserByteFields { failures: 10, ..fields });
        "default-speed-unit-steps" "Without user bytes the speed is in steps per second."
            => |d| d.a3m60.delivered(|fields| UserByteFields { speed_unit: 0, ..fields });
        "default-samples-1" "Without user bytes the position is a single sample."
            => |d| d.a3m60.delivered(|fields| UserByteFields { samples: 1, ..fields });
        "default-round-axis-on" "Without user bytes the round axis is on."
            => |d| d.a3m60.delivered(|fields| UserByteFields { range: 1 << 26, ..switched(fields, 1, 1) });
        "default-fraction-wrong" "Without user bytes nominator and divisor are 1 and 2."
            => |d| d.a3m60.delivered(|fields| UserByteFields { nominator: 1, divisor: 2, ..fields });
        "waits-for-a-clock" "The encoder waits for the clock even without isochronous parameters."
            => |d| d.a3m60.times(|times| times.or(Some(MILLISECOND)));
        "delivered-preset-value-wrong" "The factory value of P65000 is FFFFFFFFh."
            => |d| d.encoder.load(|_, retained| match retained.preset_value {
                0 => RetainedEncoderData { preset_value: u32::MAX, ..retained },
                _ => retained,
            });

        // Accepted and refused parameters
        "zero-units-taken" "Steps per revolution of 0 are accepted."
            => |d| d.checks.serves(|user, _, right| right || user.units_per_revolution == 0);
        "range-of-zero-taken" "A range of 0 is treated as one revolution."
            => |d| d.fields(|fields| UserByteFields { range: if fields.range == 0 { fields.units } else { fields.range }, ..fields });
        "impossible-scaling-accepted" "Steps per revolution and ranges above those of the sensor are accepted silently."
            => |d| d.checks.serves(impossible_scaling_accepted);
        "rule-of-powers-missing" "Any range is accepted without the round axis."
            => |d| d.checks.serves(|user, hardware, _| serves(user, hardware));
        "more-revolutions-than-there-are" "A range of more revolutions than the encoder has is accepted."
            => |d| d.checks.serves(more_revolutions_than_there_are);
        "singleturn-range-refused" "A range of one revolution is refused."
            => |d| d.checks.serves(|user, _, right| right && user.range != user.units_per_revolution);
        "range-halved" "The range in force is half of the one that is set."
            => |d| d.fields(|fields| UserByteFields { range: fields.range / 2, ..fields });
        "unit-4-ignored" "Unit 4 is treated as revolutions per minute."
            => |d| d.fields(|fields| UserByteFields { speed_unit: if fields.speed_unit == 4 { 3 } else { fields.speed_unit }, ..fields });
        "speed-unit-ignored" "The velocity is always in revolutions per minute."
            => |d| d.start.velocity_unit(|_, _| VelocityUnit::Rpm);
        "speed-units-exchanged" "The units 1 and 2 are swapped."
            => |d| d.fields(speed_units_exchanged);
        "undefined-speed-unit-taken" "An undefined velocity unit is treated as steps per second."
            => |d| d.checks.check(|check, right| right || matches!(check, EncoderCheck::VelocityUnitExists(_)));
        "user-bytes-shifted" "The user bytes are read one byte late."
            => |d| d.user_octets(|octets| if octets.len() == OCTETS {
                octets.rotate_left(1);
                octets[OCTETS - 1] = 0;
            });
        "parameter-length-not-checked" "Surplus user bytes are ignored."
            => |d| d.user_octets(|octets| octets.truncate(OCTETS));
        "missing-bytes-from-old-buffer" "Missing user bytes are taken from the previous Set_Prm."
            => |d| d.slave.add(FilledUserBytes(DELIVERED.to_vec()));
        "get-cfg-constant" "Get_Cfg always returns the first module."
            => |d| d.slave.answer(get_cfg_constant);
        "round-axis-modulo-stays" "The round axis stays on after it was on."
            => |d| d.slave.add(RoundAxisStays(UserByteFields::DELIVERED));
        "configuration-not-checked" "Any configuration is accepted; an invalid one is treated as that of the first module."
            => |d| d.slave.request(SlaveSap::CHK_CFG, |data| {
                if !CONFIGURATIONS.contains(&data.as_slice()) {
                    *data = CONFIGURATIONS[0].to_vec();
                }
                true
            });
        "telegram-83-refused" "The configuration of telegram 83 is refused."
            => |d| d.slave.request(SlaveSap::CHK_CFG, |data| unless(data, CONFIGURATIONS[3]));
        "module-missing" "The configuration of IO 08 is refused."
            => |d| d.slave.request(SlaveSap::CHK_CFG, |data| unless(data, CONFIGURATIONS[1]));
    },
}];

const MILLISECOND: IsochronousTimes =
    IsochronousTimes { cycle: Duration::from_millis(1), window: Duration::from_micros(1), is_simulated: false };

fn switched(fields: UserByteFields, octet: usize, bits: u8) -> UserByteFields {
    let mut switches = fields.switches;
    switches[octet] ^= bits;
    UserByteFields { switches, ..fields }
}

fn set(fields: UserByteFields, octet: usize, bits: u8) -> UserByteFields {
    let mut switches = fields.switches;
    switches[octet] |= bits;
    UserByteFields { switches, ..fields }
}

/// The factory user bytes.
const DELIVERED: [u8; OCTETS] = [0x02, 0x0C, 0, 0, 0x40, 0, 0x80, 0, 0, 0, 1, 3, 0, 0, 0x10, 0, 0, 0, 0, 1, 8, 0, 0, 0];

/// Makes a configuration invalid if it is `refused`.
fn unless(data: &mut Vec<u8>, refused: &[u8]) -> bool {
    if data == refused {
        data.clear();
    }
    true
}

fn get_cfg_constant(telegram: &mut Vec<u8>) {
    let Some(frame) = frame(telegram) else { return };
    if !frame.fc.is_request() && SapService::of(&frame) == SapService::Slave(SlaveSap::GET_CFG) {
        *telegram = with_data(&frame, CONFIGURATIONS[0]);
    }
}

/// Fills missing user bytes from the previous Set_Prm.
struct FilledUserBytes(Vec<u8>);

impl SlaveHooks for FilledUserBytes {
    fn parameters(&mut self, parameters: &mut SetPrm) -> bool {
        with_user_octets(parameters, &mut |octets| {
            octets.extend(self.0.iter().skip(octets.len()).copied().collect::<Vec<_>>());
            if octets.len() == OCTETS {
                self.0.clone_from(octets);
            }
        });
        true
    }

    fn starts(&mut self) {
        self.0 = DELIVERED.to_vec();
    }
}

/// The previous user bytes, whose round axis stays on.
struct RoundAxisStays(UserByteFields);

impl SlaveHooks for RoundAxisStays {
    fn parameters(&mut self, parameters: &mut SetPrm) -> bool {
        with_fields(parameters, &mut |fields| {
            let before = self.0;
            if before.has_axis() && !fields.has_axis() {
                self.0 = UserByteFields {
                    nominator: before.nominator,
                    divisor: before.divisor,
                    range: before.range,
                    ..set(fields, 1, 1)
                };
            } else {
                self.0 = fields;
            }
            self.0
        });
        true
    }

    fn starts(&mut self) {
        self.0 = UserByteFields::DELIVERED;
    }
}

fn more_revolutions_than_there_are(user: &UserParameterData, hardware: &Hardware, right: bool) -> bool {
    let (units, range) = (user.units_per_revolution, user.range);
    let is_possible = (1..=hardware.steps_per_revolution).contains(&units);
    right || is_possible && range.is_multiple_of(units) && (range / units).is_power_of_two()
}

fn impossible_scaling_accepted(user: &UserParameterData, hardware: &Hardware, right: bool) -> bool {
    right || user.units_per_revolution > hardware.steps_per_revolution || user.range > hardware.range()
}

fn speed_units_exchanged(fields: UserByteFields) -> UserByteFields {
    let speed_unit = match fields.speed_unit {
        1 => 2,
        2 => 1,
        other => other,
    };
    UserByteFields { speed_unit, ..fields }
}
