//! Reads by which values a device shows its variant, in a connection of its own.
//!
//! It judges nothing and says nothing about the claim: a reading that is refused or missing says nothing.

use super::RunningTrial;
use super::probe::default_start;
use description::gsdml::{SensorFormat, needs_description};
use description::variant::{VariantReading, order_reading};
use suite::device::{DeviceDescription, VariantValue, VariantValueSource};
use suite::model::{ConnectionStart, StartParameter};
use wire::profidrive::{ParameterAddress, ParameterRequest, ParameterResponse};

/// The cycles after which inputs are read.
const CYCLES: u64 = 8;
/// The sensor format: encoder profile 3.162, P979.
const SENSOR_FORMAT: u16 = 979;
/// The elements of P979: steps per revolution, shift of G1_XIST1, revolutions.
const STEPS: u16 = 2;
const SHIFT_OF_XIST1: u16 = 3;
const REVOLUTIONS: u16 = 5;

impl RunningTrial<'_> {
    /// Connects with the start parameters that the manual's variants are distinguished with, and reads what differs.
    ///
    /// The default parameters of each variant are tried, those of the claimed one first, since a device may refuse those of another.
    /// Nothing is sent whose layout or ident was invented.
    pub fn variant_readings(&mut self) -> Vec<VariantReading> {
        let device = &self.world.manual.device;
        let mut readings = Vec::new();
        if device.variants.len() < 2 {
            return readings;
        }
        let is_model = self.world.segment.is_model();
        let known = |start: &ConnectionStart| is_model || needs_description(device, start).is_none();
        let own = self.variant_number();
        'starts: for parameters in &device.variant_identification.starts {
            let variants = std::iter::once(own).chain((0..device.variants.len()).filter(|other| *other != own));
            for variant in variants {
                let modules = 0..device.modules.len();
                let mut starts = modules.map(|module| identifying_start(device, variant, module, parameters));
                let Some(start) = starts.find(known) else { break 'starts };
                match self.driver.connects_with(self, &start) {
                    Ok(Some(true)) => {
                        readings = self.readings_in_connection();
                        break;
                    }
                    Ok(Some(false)) => {}
                    // A device that does not answer is not asked again.
                    Ok(None) | Err(_) => break 'starts,
                }
            }
            if !readings.is_empty() {
                break;
            }
        }
        self.world.closing = true;
        let _ = self.disconnect(false);
        readings
    }

    /// What the device says in P979 of its sensor; `None` if it does not say it.
    pub fn sensor_format(&mut self) -> Option<SensorFormat> {
        let device = &self.world.manual.device;
        let module = device.modules.iter().position(|module| module.absent.is_none())?;
        let start = default_start(device, self.variant_number(), module);
        let is_connected = matches!(self.driver.connects_with(self, &start), Ok(Some(true)));
        let mut element = |subindex: u16| {
            let source = VariantValueSource::Parameter { number: SENSOR_FORMAT, subindex };
            let value = VariantValue { name: String::new(), source, expected: Vec::new() };
            let number = if is_connected { self.identifying_number(&value, None) } else { None };
            number.and_then(|number| u32::try_from(number).ok())
        };
        let [steps, shift, revolutions] = [STEPS, SHIFT_OF_XIST1, REVOLUTIONS].map(&mut element);
        self.world.closing = true;
        let _ = self.disconnect(false);
        let shift = shift.filter(|shift| *shift < 32)?;
        Some(SensorFormat { shift, steps: steps.unwrap_or_default(), revolutions: revolutions.unwrap_or_default() })
    }

    fn readings_in_connection(&mut self) -> Vec<VariantReading> {
        let device = &self.world.manual.device;
        let order = self.driver.order_number(self);
        let mut readings: Vec<VariantReading> =
            order.and_then(|order| order_reading(device, &order)).into_iter().collect();
        let _ = self.driver.cycles(self, CYCLES);
        let diagnosis = self.driver.diagnosis_octets(self);
        for value in &device.variant_identification.values {
            let number = self.identifying_number(value, diagnosis.as_deref());
            readings.extend(number.and_then(|number| VariantReading::of_number(value, number)));
        }
        readings
    }

    fn identifying_number(&mut self, value: &VariantValue, diagnosis: Option<&[u8]>) -> Option<i128> {
        let device = &self.world.manual.device;
        match value.source {
            VariantValueSource::Parameter { number, subindex } => {
                let do_id = device.parameter_access.do_id;
                let address = ParameterAddress::value(number, subindex);
                let mut request = Vec::new();
                ParameterRequest::read_values(1, do_id, vec![address]).write(&mut request);
                let octets = self.driver.parameter_response(self, request)?;
                let value = ParameterResponse::parse(&octets).ok()?.values.into_iter().next()?;
                let is_number = value.error().is_none() && value.count == 1 && (1..=8).contains(&value.data.len());
                is_number.then(|| value.data.iter().fold(0, |number, octet| number << 8 | i128::from(*octet)))
            }
            VariantValueSource::Diagnosis(index) => {
                device.profibus()?.diagnosis.fields.get(index)?.number_in(diagnosis?)
            }
            VariantValueSource::Input(signal) => self.world.scene.follower.image.signal(signal).map(i128::from),
        }
    }
}

/// The start-up with a module, the defaults of a variant and the start parameters with which variants are distinguished.
fn identifying_start(
    device: &DeviceDescription,
    variant: usize,
    module: usize,
    parameters: &[(String, i128)],
) -> ConnectionStart {
    let mut start = default_start(device, variant, module);
    let identifying = |of: &StartParameter| {
        let name = &device.records.get(of.record)?.fields.get(of.field)?.name;
        let known = parameters.iter().find(|(known, _)| known == name);
        known.map(|(_, number)| *number)
    };
    for parameter in &mut start.parameters {
        parameter.value = identifying(parameter).unwrap_or(parameter.value);
    }
    start
}
