//! Which parameters of the vendor and of the station there are. Manual, tables 33 to 35.
//!
//! P971 can be read as PROFIdrive has it; P1010 is reserved and reads 0.

use super::{Live, State};
use crate::encoder::PresetMode;
use crate::encoder_object::{double_word, double_words, octets_of, word, words};
use crate::profidrive::parameters::Parameter;
use crate::profinet::port_mac;
use wire::ethernet::Mac;
use wire::profidrive::ErrorNumber;

/// FPGA version 1.2.0, the printed example.
const FPGA_VERSION: u64 = 0x0001_0200;
/// Seconds of a unit of the operating time in P65001: 0.1 h.
const OPERATING_TIME_UNIT: u64 = 360;
/// Bit of the alarm channel in the operating status, and of V4.1 of the profile.
const ALARM_CHANNEL: u64 = 1 << 4;
const NOT_COMPATIBLE: u64 = 1 << 5;

impl Live<'_, State> {
    /// A parameter that the encoder object does not know, or not so.
    pub fn own_parameter(&self, number: u16) -> Option<Parameter> {
        let station = &self.ram.station;
        let address = |octets| double_word(u32::from_be_bytes(octets).into());
        let Mac(mac) = self.model.mac;
        let port = |number| octets_of(&port_mac(self.model.mac, number).0);
        Some(match number {
            // 0x3D, and the version in decimal.
            965 => word(if self.ram.user.compatible { 0x3D1F } else { 0x3D29 }),
            980 if self.behaviour.afx60.list_is_writable => {
                let mut list = words(self.facts.listed.iter().copied().map(u64::from).collect()).writable();
                self.model.list.iter().for_each(|(at, value)| list.values[*at] = *value);
                list
            }
            1000 => word(self.status_words()[0].into()),
            1001 => words(self.status_words().map(u64::from).to_vec()),
            1002 | 1003 => self.log_parameter(number),
            1004 => self.counters_parameter(),
            1005 => self.speed_parameter(),
            1006 | 1007 => self.limits_parameter(number),
            1009 => self.axis_parameter(),
            1010 => word(0),
            1011 => port(1),
            1012 => port(2),
            1013 => double_word(FPGA_VERSION),
            1014 => word((self.model.around.degrees() as u16).into()),
            61000 => octets_of(&station.name),
            61002 => octets_of(&mac),
            61003 => address(station.gateway),
            61004 => address(station.mask),
            65001 => {
                let mut status = self.operating_status();
                // The alarm channel cannot be switched off in V4.1.
                if status[1] & NOT_COMPATIBLE != 0 {
                    status[1] |= ALARM_CHANNEL;
                }
                status[7] = self.model.service.operating_seconds() / OPERATING_TIME_UNIT;
                if self.behaviour.afx60.faults_stay {
                    status[2] |= self.model.status.faults_seen;
                }
                double_words(status.to_vec())
            }
            _ => return None,
        })
    }

    /// Writes a parameter that the encoder object does not know, or that does more here.
    pub fn write_own(&mut self, number: u16, subindex: u16, values: &[u64]) -> Option<Result<(), ErrorNumber>> {
        match number {
            971 => {
                let is_running = self.store.preset_value.deadline().is_some();
                if is_running && self.behaviour.afx60.second_save_spoils {
                    self.store.preset_value.write(self.now, 0, self.facts.timing.save);
                    return Some(Ok(()));
                }
                if values.first().is_some_and(|value| (self.behaviour.values.saves)(*value) == Some(true)) {
                    if self.behaviour.afx60.saves_limits {
                        self.store_limits();
                    }
                    self.model.status.saving = super::status::Saving::Running;
                }
                None
            }
            1003 => Some(self.reset_log(values)),
            1005 => Some(self.write_speed(subindex, values)),
            1006 | 1007 => Some(self.write_limits(number, subindex, values)),
            1009 => Some(self.write_axis(subindex, values)),
            980 => {
                self.model.list.extend((usize::from(subindex)..).zip(values.iter().copied()));
                Some(Ok(()))
            }
            65000 => self.write_preset_value(values.first().copied().unwrap_or(0) as u32),
            _ => None,
        }
    }

    /// What P65000 does when it is written, beside taking the value.
    fn write_preset_value(&mut self, value: u32) -> Option<Result<(), ErrorNumber>> {
        let rules = &self.behaviour.afx60;
        if rules.start_locks && self.model.transmits {
            return Some(Ok(()));
        }
        if self.model.saves_each_change && rules.saves_by_itself {
            self.store.preset_value.write(self.now, value, self.facts.timing.save);
        }
        if rules.warns_at_the_write && u64::from(value) >= self.positions() {
            self.model.status.has_invalid_preset = true;
        }
        if rules.presets_while_requested && self.ram.sensor.request().home {
            self.ram.measuring.offset = self.ram.measuring.preset(PresetMode::Absolute, value.into());
        }
        None
    }
}
