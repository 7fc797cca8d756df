//! The parameters of the XAC77: what a read of record 0xB02E gives. Manual, 11.2 and 11.3.

use super::live::Live;
use crate::behaviour::View;
use crate::profidrive::parameters::{Parameter, Parameters};
use alloc::vec;
use alloc::vec::Vec;
use wire::profidrive::{ErrorNumber, Format};

/// Vendor, in P964 and P975.
pub const VENDOR_ID: u16 = 0x0239;
/// Software 1.10 of 24 October 2013: version table on p. 43, date of the first description file.
pub const SOFTWARE: [u64; 3] = [110, 2013, 2410];
/// What P980 lists: the defined parameters in ascending order.
const DEFINED: [u16; 9] = [922, 964, 965, 971, 975, 979, 61001, 65000, 65001];
/// Faults that P65001 knows: bit 4 commissioning, bit 5 memory.
const SUPPORTED_FAULTS: u64 = 0x30;

/// Error code and fault bit of the memory fault.
pub const MEMORY: (u16, u32) = (0x1001, 1 << 5);
/// Error code and fault bit of the parametrization fault.
pub const COMMISSIONING: (u16, u32) = (0x1002, 1 << 4);

impl Parameters for Live<'_> {
    fn parameter(&self, number: u16) -> Option<Parameter> {
        let mut shown = self.right_parameter(number)?;
        let (values, view) = (&self.behaviour.values, self.view());
        for (subindex, value) in shown.values.iter_mut().enumerate() {
            *value = (values.element)(&view, (number, subindex), *value);
        }
        let count = (values.elements)(number, shown.values.len());
        shown.values.truncate(count);
        Some(Parameter { format: (values.format)(number, shown.format), ..shown })
    }

    fn write(&mut self, number: u16, value: u64) -> Result<(), ErrorNumber> {
        match number {
            971 => {
                let saves = (self.behaviour.values.saves)(value).ok_or(ErrorNumber::VALUE_NOT_ALLOWED)?;
                if saves {
                    self.save();
                }
                Ok(())
            }
            65000 => {
                self.set_preset_value((self.behaviour.values.preset_value)(value as u32));
                Ok(())
            }
            _ => Err(ErrorNumber::READ_ONLY),
        }
    }
}

impl Live<'_> {
    fn right_parameter(&self, number: u16) -> Option<Parameter> {
        let [version, year, day] = SOFTWARE;
        let vendor = u64::from(VENDOR_ID);
        Some(match number {
            // Telegram selection.
            922 => word(self.ram.telegram.number.into()),
            // Device identification: vendor, type, software version, year, day and month, number of drive objects.
            964 => words(vec![vendor, 1, version, year, day, 1]),
            // Encoder profile 0x3D and its version, decimal.
            965 => octets([0x3D, if self.ram.user.compatible { 31 } else { 41 }]),
            // Transfer to non-volatile memory: 1 while it runs or after it has failed.
            971 => word(self.ram.is_saving.into()).writable(),
            // Encoder object: as P964, then type encoder interface, class 4, number of this object.
            975 => words(vec![vendor, 1, version, year, day, 5, 0x8000, 1]),
            // Sensor format: header, rotary and valid, steps per revolution, shift factors, revolutions.
            979 => {
                let hardware = self.hardware;
                double_words(vec![0x5011, 0x8000_0000, hardware.steps_per_revolution, 0, 0, hardware.revolutions])
            }
            // List of the defined parameters.
            980 => words(DEFINED.map(u64::from).to_vec()),
            // IP of the station, first octet uppermost.
            61001 => double_word(u32::from_be_bytes(self.ram.address).into()),
            // Preset value.
            65000 => double_word(self.ram.preset_value.into()).writable(),
            // Operating status.
            65001 => double_words(self.operating_status()),
            _ => return None,
        })
    }

    /// P65001: header, status, faults, supported faults, warnings, supported warnings, profile version 4.1, operating
    /// time (not measured), offset, units per revolution, range, velocity unit.
    fn operating_status(&self) -> Vec<u64> {
        let (user, measuring) = (&self.ram.user, &self.ram.measuring);
        let errors = self.ram.sensor.errors();
        let faults = [MEMORY, COMMISSIONING].iter().filter(|(code, _)| errors.contains(code));
        let faults = faults.fold(0, |bits, (_, bit)| bits | bit);
        vec![
            0x000C_0101,
            user.bits.into(),
            faults.into(),
            SUPPORTED_FAULTS,
            0,
            0,
            0x401,
            0xFFFF_FFFF,
            measuring.offset % measuring.range(),
            measuring.settings.scaling.units_per_revolution,
            measuring.range(),
            user.speed_unit.into(),
        ]
    }

    fn view(&self) -> View<'_> {
        View {
            now: self.now,
            hardware: self.hardware,
            user: &self.ram.user,
            measuring: &self.ram.measuring,
            preset_value: self.ram.preset_value,
            offset_at_power_up: self.ram.offset_at_power_up,
            address_before: self.ram.address_before,
        }
    }
}

impl Parameter {
    fn writable(self) -> Parameter {
        Parameter { is_writable: true, ..self }
    }
}

fn word(value: u64) -> Parameter {
    Parameter { is_array: false, ..words(vec![value]) }
}

fn double_word(value: u64) -> Parameter {
    Parameter { is_array: false, ..double_words(vec![value]) }
}

fn words(values: Vec<u64>) -> Parameter {
    Parameter { format: Format::WORD, is_array: true, is_writable: false, values }
}

fn double_words(values: Vec<u64>) -> Parameter {
    Parameter { format: Format::DOUBLE_WORD, ..words(values) }
}

fn octets(octets: [u8; 2]) -> Parameter {
    Parameter { format: Format::OCTET_STRING, is_array: false, ..words(octets.map(u64::from).to_vec()) }
}
