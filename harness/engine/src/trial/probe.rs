//! Reads a live device before the first trial and restores it after the last: its identity, wrong claims of the bench, and its
//! parameters.
//!
//! It judges no requirement; its findings are about the bench.

use super::RunningTrial;
use crate::live::ParameterBackup;
use description::gsdml::AcceptedSubmodule;
use results::bench_file::BenchFile;
use results::journal::{self, InitialDevice};
use results::outcome::{DeviceFinding, FindingSeverity};
use suite::device::{DeviceDescription, DeviceParameter};
use suite::model::{ConnectionStart, StartParameter};
use wire::profidrive::{
    ErrorNumber, ParameterAddress, ParameterFormat, ParameterRequest, ParameterResponse, ParameterValue,
};

/// The state of a live device before the first trial.
#[derive(Clone, Debug, Default)]
pub struct ProbedDevice {
    /// The firmware that the device reports in I&M0.
    pub firmware: Option<String>,
    /// The values of the parameters that a suite may write.
    pub parameters: Vec<journal::InitialParameter>,
    /// The submodules with which connections were established.
    pub connected: Vec<AcceptedSubmodule>,
    /// Wrong claims of the bench.
    pub findings: Vec<DeviceFinding>,
}

/// The result of writing a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ParameterWrite {
    /// The device accepted it.
    Taken,
    /// The parameter cannot be written, so no trial has changed it.
    ReadOnly,
    /// The device refused it or did not answer.
    Refused,
}

impl RunningTrial<'_> {
    /// Connects once with each module of the manual that can be tried, and reads what has to be restored.
    pub fn probe(&mut self, bench: &BenchFile) -> ProbedDevice {
        let mut probed = ProbedDevice::default();
        let device = &self.world.manual.device;
        let mut connected = false;
        for (index, module) in device.modules.iter().enumerate() {
            let is_claimed = bench.telegrams.as_ref().is_none_or(|claimed| claimed.contains(&module.name));
            let start = default_start(device, self.variant_number(), index);
            let unknown = description::gsdml::needs_description(device, &start).is_some();
            // Without claims one connection is enough.
            if unknown || (bench.telegrams.is_none() && connected) {
                continue;
            }
            let Ok(Some(accepted)) = self.driver.connects_with(self, &start) else { continue };
            if accepted && !connected {
                connected = true;
                probed.firmware = self.driver.firmware(self);
                probed.parameters = self.parameters_now();
                probed.findings.extend(bench.lacks.iter().filter_map(|name| self.lacks(name)));
            }
            if accepted {
                probed.connected.extend(module.submodules.iter().filter_map(|&submodule| {
                    let of = device.submodules.get(submodule)?;
                    let (input, output) = (of.input_octets, of.output_octets);
                    Some(AcceptedSubmodule { slot: of.slot, subslot: of.subslot, ident: of.ident, input, output })
                }));
            }
            if bench.telegrams.is_some() && accepted != is_claimed {
                let claims = if is_claimed { "supports" } else { "does not support" };
                let does = if accepted { "connects with it" } else { "does not connect with it" };
                probed.findings.push(wrong_claim(&module.name, claims, does));
            }
        }
        // Nothing is judged here; if releasing fails, the first trial reports it.
        self.world.closing = true;
        let _ = self.disconnect(false);
        if let (Some(claimed), Some(reported)) = (&bench.firmware, &probed.firmware)
            && claimed != reported
        {
            probed.findings.push(DeviceFinding {
                id: "firmware".into(),
                severity: FindingSeverity::Error,
                text: format!("The bench claims firmware {claimed}, but the device reports {reported}."),
                manual: Some(format!("{claimed} (bench file)")),
                description: None,
                device: Some(reported.clone()),
            });
        }
        probed
    }

    /// Reads the parameters that a write changes, with one request each, so that a device that lacks some can refuse those.
    fn parameters_now(&mut self) -> Vec<journal::InitialParameter> {
        let device = &self.world.manual.device;
        let kept = device.parameters.iter().filter(|of| of.writable && !of.permanent);
        let mut addresses: Vec<(u16, u16)> = Vec::new();
        for DeviceParameter { number, elements, .. } in kept {
            let alone = elements.is_empty().then_some(0);
            addresses.extend(
                elements.iter().map(|(_, subindex)| *subindex).chain(alone).map(|subindex| (*number, subindex)),
            );
        }
        addresses.into_iter().filter_map(|address| self.parameter_now(address)).collect()
    }

    fn parameter_now(&mut self, (number, subindex): (u16, u16)) -> Option<journal::InitialParameter> {
        let do_id = self.world.manual.device.parameter_access.do_id;
        let request = ParameterRequest::read_values(1, do_id, vec![ParameterAddress::value(number, subindex)]);
        let octets = self.parameter_response(&request)?;
        let value = ParameterResponse::parse(&octets).ok()?.values.into_iter().next()?;
        let is_value = value.error().is_none() && value.count == 1;
        is_value.then_some(journal::InitialParameter { number, subindex, format: value.format.0, octets: value.data })
    }

    /// The response to a parameter request in the present connection.
    fn parameter_response(&mut self, request: &ParameterRequest) -> Option<Vec<u8>> {
        let mut octets = Vec::new();
        request.write(&mut octets);
        self.driver.parameter_response(self, octets)
    }

    /// A finding if the device has something that it lacks according to the bench.
    fn lacks(&mut self, name: &str) -> Option<DeviceFinding> {
        let device = &self.world.manual.device;
        let has = match device.records.iter().find(|record| record.name == name) {
            Some(record) => self.driver.has_record(self, record)?,
            None => {
                let number = name.strip_prefix('P')?.parse().ok()?;
                let array = device.parameters.iter().find(|of| of.number == number)?.elements.first();
                self.parameter_now((number, array.map_or(0, |(_, subindex)| *subindex))).is_some()
            }
        };
        has.then(|| wrong_claim(name, "does not have", "answers a read of it"))
    }

    /// Restores name, address and parameters of the device, if they have changed; returns what could not be restored, in words.
    pub fn restore(&mut self, found: &InitialDevice, kept: &ParameterBackup<'_>) -> Vec<String> {
        // This is done however the run ended.
        self.world.closing = true;
        let _ = self.disconnect(false);
        self.driver.restore(self, found, kept)
    }

    /// Restores the parameters.
    pub fn restore_parameters(&mut self, kept: &ParameterBackup<'_>, left: &mut Vec<String>) {
        if kept.parameters.is_empty() && kept.wrote_parameters {
            left.push("the parameters, which could not be read before they were written".into());
        }
        if !kept.parameters.is_empty() {
            self.write_back_parameters(kept, left);
        }
    }

    fn write_back_parameters(&mut self, kept: &ParameterBackup<'_>, left: &mut Vec<String>) {
        let device = &self.world.manual.device;
        let module = (0..device.modules.len())
            .map(|index| default_start(device, self.variant_number(), index))
            .find(|start| description::gsdml::needs_description(device, start).is_none());
        let stands = module.is_some_and(|start| matches!(self.driver.connects_with(self, &start), Ok(Some(true))));
        let mut all = stands;
        for parameter in kept.parameters {
            let address = (parameter.number, parameter.subindex);
            let is_same = |run: &mut Self| run.parameter_now(address).as_ref() == Some(parameter);
            let is_back = stands
                && (is_same(self)
                    || match self.write_parameter(parameter) {
                        ParameterWrite::Taken => is_same(self),
                        ParameterWrite::ReadOnly => true,
                        ParameterWrite::Refused => false,
                    });
            if !is_back {
                let element = if parameter.subindex == 0 { String::new() } else { format!(".{}", parameter.subindex) };
                left.push(format!("P{}{element} (0x{})", parameter.number, hex(&parameter.octets)));
                all = false;
            }
        }
        // If the run saved parameters, the restored ones are saved too, so that they survive the next power-on.
        let number = device.parameter_access.save;
        let save = device.parameters.iter().find(|of| of.number == number && of.writable);
        if let (true, true, Some(save)) = (all, kept.saved, save) {
            let format = save.kind.formats.first().copied().unwrap_or(ParameterFormat::WORD.0);
            let save = journal::InitialParameter { number, subindex: 0, format, octets: vec![0, 1] };
            if self.write_parameter(&save) != ParameterWrite::Taken {
                left.push("the parameters in non-volatile memory".into());
            }
        }
        let _ = self.disconnect(false);
    }

    fn write_parameter(&mut self, parameter: &journal::InitialParameter) -> ParameterWrite {
        let value = ParameterValue::new(ParameterFormat(parameter.format), 1, parameter.octets.clone());
        let change = vec![(ParameterAddress::value(parameter.number, parameter.subindex), value)];
        let do_id = self.world.manual.device.parameter_access.do_id;
        let octets = self.parameter_response(&ParameterRequest::change_values(1, do_id, change));
        let Some(Ok(response)) = octets.as_deref().map(ParameterResponse::parse) else {
            return ParameterWrite::Refused;
        };
        let error = response.values.first().and_then(ParameterValue::error).map(|error| error.number);
        match (response.header.id.is_negative(), error) {
            (false, _) => ParameterWrite::Taken,
            (true, Some(ErrorNumber::READ_ONLY)) => ParameterWrite::ReadOnly,
            (true, _) => ParameterWrite::Refused,
        }
    }
}

fn hex(octets: &[u8]) -> String {
    octets.iter().map(|octet| format!("{octet:02X}")).collect()
}

fn wrong_claim(name: &str, claims: &str, does: &str) -> DeviceFinding {
    DeviceFinding {
        id: format!("claim.{name}"),
        severity: FindingSeverity::Error,
        text: format!("The bench claims that the device {claims} {name}, but it {does}."),
        manual: Some(format!("{claims} {name} (bench file)")),
        description: None,
        device: Some(does.to_owned()),
    }
}

/// The start-up with a module and all start parameters at their defaults.
fn default_start(device: &DeviceDescription, variant: usize, module: usize) -> ConnectionStart {
    let mut parameters = Vec::new();
    for (record, of) in device.records.iter().enumerate().filter(|(_, record)| record.starts(module)) {
        for (field, of) in of.fields.iter().enumerate() {
            parameters.extend(of.default.get(variant).map(|&value| StartParameter { record, field, value }));
        }
    }
    ConnectionStart {
        module,
        cycle: None,
        watchdog: None,
        unwatched: false,
        baud: None,
        isochronous: None,
        parameters,
        instead: Vec::new(),
    }
}
