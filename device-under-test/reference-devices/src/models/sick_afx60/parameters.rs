//! The parameters of the vendor and the station. Manual, tables 33 to 35.
//!
//! P971 can be read, as in PROFIdrive; P1010 is reserved and reads 0.

use super::hooks::Afx60Check;
use super::sensor_status::SaveProgress;
use super::{Afx60State, PoweredEncoder, controls, limits, round_axis, sensor_status, service_log};
use device_stack::profinet::port_mac;
use encoder_profile::encoder_object::{double_word, double_words, octets_of, word, words};
use encoder_profile::profidrive::parameters::ParameterContent;
use wire::ethernet::Mac;
use wire::profidrive::ErrorNumber;

/// FPGA version 1.2.0, the printed example.
const FPGA_VERSION: u64 = 0x0001_0200;
/// Unit of the operating time in P65001 in seconds: 0.1 h.
const OPERATING_TIME_UNIT: u64 = 360;
/// Bit of the alarm channel in the operating status, followed by the bit for V4.1 of the profile.
const ALARM_CHANNEL: u64 = 1 << 4;
const NOT_COMPATIBLE: u64 = 1 << 5;

/// Returns a parameter that the encoder object does not have, or that differs here.
pub fn own_parameter(live: &PoweredEncoder<'_, Afx60State>, number: u16) -> Option<ParameterContent> {
    let station = &live.ram.station;
    let address = |octets| double_word(u32::from_be_bytes(octets).into());
    let Mac(mac) = live.model.mac;
    let port = |number| octets_of(&port_mac(live.model.mac, number).0);
    Some(match number {
        // 0x3D and the version, 31 or 41.
        965 => word(if live.ram.user.compatible { 0x3D1F } else { 0x3D29 }),
        1000 => word(sensor_status::status_a(live).into()),
        1001 => words(sensor_status::status_words(live).map(u64::from).to_vec()),
        1002 | 1003 => service_log::log_parameter(live, number),
        1004 => service_log::counters_parameter(live),
        1005 => limits::speed_parameter(live),
        1006 | 1007 => limits::limits_parameter(live, number),
        1009 => round_axis::axis_parameter(live),
        1010 => word(0),
        1011 => port(1),
        1012 => port(2),
        1013 => double_word(FPGA_VERSION),
        1014 => word((controls::measured(live).degrees() as u16).into()),
        61000 => octets_of(&station.name),
        61002 => octets_of(&mac),
        61003 => address(station.gateway),
        61004 => address(station.mask),
        65001 => {
            let mut status = live.operating_status();
            // The alarm channel cannot be switched off in V4.1.
            if status[1] & NOT_COMPATIBLE != 0 {
                status[1] |= ALARM_CHANNEL;
            }
            status[7] = live.model.service.operating_seconds() / OPERATING_TIME_UNIT;
            double_words(status.to_vec())
        }
        _ => return None,
    })
}

/// Writes a parameter that the encoder object does not have, or that does more here.
pub fn write_own(
    live: &mut PoweredEncoder<'_, Afx60State>,
    number: u16,
    subindex: u16,
    values: &[u64],
) -> Option<Result<(), ErrorNumber>> {
    match number {
        971 => {
            let saves = values.first() == Some(&1);
            if live.model.hooks.check(Afx60Check::Stores(971), saves) {
                limits::store_limits(live);
            }
            if saves {
                live.model.status.saving = SaveProgress::Running;
            }
            None
        }
        1003 => Some(service_log::reset_log(live, values)),
        1005 => Some(limits::write_speed(live, subindex, values)),
        1006 | 1007 => Some(limits::write_limits(live, number, subindex, values)),
        1009 => Some(round_axis::write_axis(live, subindex, values)),
        65000 => {
            let value = values.first().copied().unwrap_or(0) as u32;
            if live.model.hooks.check(Afx60Check::Stores(65000), live.model.saves_each_change) {
                live.store.preset_value.write(live.now, value, limits::save_takes(live));
            }
            None
        }
        _ => None,
    }
}
