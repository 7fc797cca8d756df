//! Which parameters of the vendor and of the station there are. Manual, tables 33 to 35.
//!
//! P971 can be read as PROFIdrive has it; P1010 is reserved and reads 0.

use super::axis;
use super::limits;
use super::log;
use super::status;
use super::{Live, State};
use device_stack::profinet::port_mac;
use encoder_profile::encoder::PresetMode;
use encoder_profile::encoder_object::{double_word, double_words, octets_of, word, words};
use encoder_profile::profidrive::parameters::Parameter;
use wire::ethernet::Mac;
use wire::profidrive::ErrorNumber;

/// FPGA version 1.2.0, the printed example.
const FPGA_VERSION: u64 = 0x0001_0200;
/// Seconds of a unit of the operating time in P65001: 0.1 h.
const OPERATING_TIME_UNIT: u64 = 360;
/// Bit of the alarm channel in the operating status, and of V4.1 of the profile.
const ALARM_CHANNEL: u64 = 1 << 4;
const NOT_COMPATIBLE: u64 = 1 << 5;

/// A parameter that the encoder object does not know, or not so.
pub fn own_parameter(live: &Live<'_, State>, number: u16) -> Option<Parameter> {
    let station = &live.ram.station;
    let address = |octets| double_word(u32::from_be_bytes(octets).into());
    let Mac(mac) = live.model.mac;
    let port = |number| octets_of(&port_mac(live.model.mac, number).0);
    Some(match number {
        // 0x3D, and the version in decimal.
        965 => word(if live.ram.user.compatible { 0x3D1F } else { 0x3D29 }),
        980 if live.rules.own.list_is_writable => {
            let mut list = words(live.facts.listed.iter().copied().map(u64::from).collect()).writable();
            live.model.list.iter().for_each(|(at, value)| list.values[*at] = *value);
            list
        }
        1000 => word(status::status_words(live)[0].into()),
        1001 => words(status::status_words(live).map(u64::from).to_vec()),
        1002 | 1003 => log::log_parameter(live, number),
        1004 => log::counters_parameter(live),
        1005 => limits::speed_parameter(live),
        1006 | 1007 => limits::limits_parameter(live, number),
        1009 => axis::axis_parameter(live),
        1010 => word(0),
        1011 => port(1),
        1012 => port(2),
        1013 => double_word(FPGA_VERSION),
        1014 => word((live.model.around.degrees() as u16).into()),
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
            if live.rules.own.faults_stay {
                status[2] |= live.model.status.faults_seen;
            }
            double_words(status.to_vec())
        }
        _ => return None,
    })
}

/// Writes a parameter that the encoder object does not know, or that does more here.
pub fn write_own(
    live: &mut Live<'_, State>,
    number: u16,
    subindex: u16,
    values: &[u64],
) -> Option<Result<(), ErrorNumber>> {
    match number {
        971 => {
            let is_running = live.store.preset_value.deadline().is_some();
            if is_running && live.rules.own.second_save_spoils {
                live.store.preset_value.write(live.now, 0, live.facts.timing.save);
                return Some(Ok(()));
            }
            if values.first() == Some(&1) {
                if live.rules.own.saves_limits {
                    limits::store_limits(live);
                }
                live.model.status.saving = super::status::Saving::Running;
            }
            None
        }
        1003 => Some(log::reset_log(live, values)),
        1005 => Some(limits::write_speed(live, subindex, values)),
        1006 | 1007 => Some(limits::write_limits(live, number, subindex, values)),
        1009 => Some(axis::write_axis(live, subindex, values)),
        980 => {
            live.model.list.extend((usize::from(subindex)..).zip(values.iter().copied()));
            Some(Ok(()))
        }
        65000 => write_preset_value(live, values.first().copied().unwrap_or(0) as u32),
        _ => None,
    }
}

/// What P65000 does when it is written, beside taking the value.
fn write_preset_value(live: &mut Live<'_, State>, value: u32) -> Option<Result<(), ErrorNumber>> {
    let rules = &live.rules.own;
    if rules.start_locks && live.model.transmits {
        return Some(Ok(()));
    }
    if live.model.saves_each_change && rules.saves_by_itself {
        live.store.preset_value.write(live.now, value, live.facts.timing.save);
    }
    if rules.warns_at_the_write && u64::from(value) >= live.positions() {
        live.model.status.has_invalid_preset = true;
    }
    if rules.presets_while_requested && live.ram.sensor.request().home {
        live.ram.measuring.offset = live.ram.measuring.preset(PresetMode::Absolute, value.into());
    }
    None
}
