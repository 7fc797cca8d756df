//! The parameters of the encoder object, read through record 0xB02E (XAC77 manual, 11.2 and 11.3).

use super::{ConnectionPhase, EncoderModel, PoweredEncoder};
use crate::encoder_object::hooks::EncoderView;
use crate::profidrive::checks::EncoderCheck;
use crate::profidrive::parameters::{ParameterContent, ParameterStore, double_word, double_words, octets, word, words};
use wire::profidrive::ErrorNumber;

/// The operating status, P65001.
const OPERATING_STATUS: u16 = 65001;

impl<M: EncoderModel> ParameterStore for PoweredEncoder<'_, M> {
    fn parameter(&self, number: u16) -> Option<ParameterContent> {
        let parameter = M::parameter(self, number).or_else(|| self.shared_parameter(number))?;
        Some(self.deviations.hooks.apply(parameter, |hooks, mut parameter| {
            let view = self.view();
            for (subindex, value) in parameter.values.iter_mut().enumerate() {
                *value = hooks.element(&view, (number, subindex), *value);
            }
            hooks.parameter(&view, number, parameter)
        }))
    }

    fn write(&mut self, number: u16, subindex: u16, values: &[u64]) -> Result<(), ErrorNumber> {
        let at = (number, subindex);
        let values = Some(values.to_vec());
        let values = self.deviations.hooks.apply(values, |hooks, values| hooks.written(&self.view(), at, values));
        let Some(values) = values else { return Ok(()) };
        if let Some(written) = M::write(self, number, subindex, &values) {
            return written;
        }
        let value = values.first().copied().unwrap_or(0);
        match (number, value) {
            // Transfer to non-volatile memory: 1 starts it.
            (971, 0) => {}
            (971, 1) => self.save(),
            (971, _) => return Err(ErrorNumber::VALUE_NOT_ALLOWED),
            // Preset value.
            (65000, _) => {
                let check = EncoderCheck::PresetValue { value: value as u32, range: self.positions() };
                if !self.deviations.checks.check(check, true) {
                    return Err(ErrorNumber::LIMIT);
                }
                self.set_preset_value(value as u32);
            }
            _ => return Err(ErrorNumber::READ_ONLY),
        }
        Ok(())
    }
}

impl<M: EncoderModel> PoweredEncoder<'_, M> {
    /// A parameter of the encoder object, without those of the model.
    pub fn shared_parameter(&self, number: u16) -> Option<ParameterContent> {
        if !self.facts.parameters.contains(&number) {
            return None;
        }
        Some(match number {
            // Telegram selection.
            922 => word(self.ram.telegram().number.into()),
            // Device identification: vendor, type, software version, year, day and month, number of drive objects.
            964 => words(self.unit().chain([1]).map(u64::from).collect()),
            // Encoder profile 0x3D and its version, decimal.
            965 => octets([0x3D, if self.ram.user.compatible { 31 } else { 41 }]),
            // Transfer to non-volatile memory: 1 while it runs or if it has failed.
            971 => word(self.ram.is_saving.into()).writable(),
            // Encoder object: as P964, then the class of the object.
            975 => words(self.unit().chain(self.facts.object_class.iter().copied()).map(u64::from).collect()),
            // Sensor format: header, type, steps per revolution, shift factors, revolutions.
            979 => double_words((self.facts.sensor_format)(self.variant).to_vec()),
            // List of the defined parameters.
            980 => words(self.facts.listed.iter().copied().map(u64::from).collect()),
            // IP address of the station, first byte highest.
            61001 => double_word(u32::from_be_bytes(self.ram.station.ip).into()),
            // Preset value.
            65000 => double_word(self.ram.preset_value.into()).writable(),
            OPERATING_STATUS => double_words(self.operating_status().to_vec()),
            _ => return None,
        })
    }

    /// Vendor, type and the version, year, day and month of the software.
    fn unit(&self) -> impl Iterator<Item = u16> + use<M> {
        let [version, year, day] = self.facts.software;
        [self.facts.identity.vendor_id, self.facts.unit_type, version, year, day].into_iter()
    }

    /// The operating status: header, status, faults, supported faults, warnings, supported warnings, profile version
    /// 4.1, operating time (not measured), offset, units per revolution, range, velocity unit.
    pub fn operating_status(&self) -> [u64; 12] {
        let (user, measuring) = (&self.ram.user, &self.ram.measuring);
        let faults = self.fault_bits();
        [
            self.facts.status_header.into(),
            user.bits.into(),
            faults.into(),
            self.facts.supported_faults.into(),
            self.warnings().into(),
            self.facts.supported_warnings.into(),
            0x401,
            0xFFFF_FFFF,
            measuring.offset % measuring.range().max(1),
            measuring.settings.scaling.units_per_revolution,
            self.positions(),
            user.speed_unit.into(),
        ]
    }

    /// The state of the encoder for a hook.
    pub fn view(&self) -> EncoderView<'_> {
        let mut others = self.facts.variants.iter().map(|variant| variant.hardware);
        EncoderView {
            now: self.now,
            facts: self.facts,
            hardware: self.hardware,
            other_hardware: others.find(|other| *other != self.hardware).unwrap_or(self.hardware),
            user: &self.ram.user,
            previous: &self.ram.before,
            is_starting: matches!(self.ram.phase, ConnectionPhase::Parameters(_)),
            errors: self.ram.sensor.errors(),
            submodules: &self.ram.submodules,
            has_record: self.ram.has_record,
            exchanged_for: self.ram.data_since.map(|since| self.now.since(since)),
            faults: self.fault_bits(),
            warnings: self.ram.warnings,
            positions: self.positions(),
            next_offset: self.ram.next_preset.map(|next| next.offset),
            velocity: &self.ram.velocity,
            measuring: &self.ram.measuring,
            preset_value: self.ram.preset_value,
            station: &self.ram.station,
            sensor: &self.ram.sensor,
            outputs: &self.ram.outputs,
            store: self.store,
            data_since: self.ram.data_since,
        }
    }
}
