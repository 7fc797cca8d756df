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
        "default-counterclockwise" "The code sequence bit is inverted."
            => |d| d.fields(|fields| switched(fields, 0, 1));
        "default-class-4-off" "Class 4 is off with the factory user bytes."
            => |d| d.fields(|fields| if fields == UserByteFields::DELIVERED { switched(fields, 0, 2) } else { fields });
        "default-preset-control-off" "The preset control bit is inverted."
            => |d| d.fields(|fields| switched(fields, 0, 4));
        "default-scaling-on" "Scaling is always on; for the highest resolution it uses 8192 steps and a range of 67108864."
            => |d| d.fields(default_scaling_on);
        "default-alarm-channel-on" "The alarm channel is always on."
            => |d| d.fields(|fields| set(fields, 0, 0x10));
        "default-compatibility-off" "The compatibility mode bit is inverted."
            => |d| d.fields(|fields| switched(fields, 0, 0x20));
        "clock-simulated-by-default" "The clock is always simulated."
            => |d| d.fields(|fields| set(fields, 1, 2));
        "default-show-fault-code-off" "The bit that switches on fault codes is inverted."
            => |d| d.fields(|fields| switched(fields, 1, 4));
        "default-speed-calculation-off" "The speed calculation bit is inverted."
            => |d| d.fields(|fields| switched(fields, 1, 8));
        "default-resolution-of-13-bits" "Steps above 8192 and ranges above 67108864 are shown as these limits."
            => |d| d.encoder.element(|_, at, right| match at { (65001, 9) => right.min(8192), (65001, 10) => right.min(1 << 26), _ => right });
        "default-tolerance-wrong" "A tolerance of 1 is used and shown as 10."
            => |d| d.fields(|fields| UserByteFields { failures: if fields.failures == 1 { 10 } else { fields.failures }, ..fields });
        "default-speed-unit-steps" "Unit 3 is used and shown as steps per second."
            => |d| d.fields(|fields| UserByteFields { speed_unit: if fields.speed_unit == 3 { 0 } else { fields.speed_unit }, ..fields });
        "default-samples-1" "The position is always a single sample."
            => |d| d.fields(|fields| UserByteFields { samples: if matches!(fields.samples, 1 | 2 | 4 | 8) { 1 } else { fields.samples }, ..fields });
        "default-round-axis-on" "P1009 always reads 1 for the mode."
            => |d| d.encoder.element(|_, at, right| if at == (1009, 0) { 1 } else { right });
        "default-fraction-wrong" "P1009 reads 1 and 0 for nominator and divisor while the round axis is off."
            => |d| {
                let has_axis = d.track(false, |encoder, _, _| encoder.model.fields.has_axis());
                d.encoder.element(move |_, at, right| match at {
                    (1009, 1) if !has_axis.get() => 1,
                    (1009, 2) if !has_axis.get() => 0,
                    _ => right,
                });
            };
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

fn default_scaling_on(fields: UserByteFields) -> UserByteFields {
    match (fields.units, fields.range) {
        (16384, 0x8000_0000) => UserByteFields { units: 8192, range: 1 << 26, ..set(fields, 0, 8) },
        _ => set(fields, 0, 8),
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
