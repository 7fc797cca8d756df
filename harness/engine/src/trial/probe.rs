//! Reads a live device before the first trial and restores it after the last: its identity, wrong claims of the bench, and its
//! parameters.
//!
//! It judges no requirement; its findings are about the bench.

use super::RunningTrial;
use crate::live::{DeviceBackup, RestoreOutcome};
use description::gsdml::AcceptedSubmodule;
use results::bench_file::{ANY_SLAVE, BenchFile};
use results::journal::{self, InitialDevice, InitialImRecord, change};
use results::outcome::{DeviceFinding, FindingSeverity};
use suite::device::{Changed, DeviceDescription, DeviceModule, DeviceParameter};
use suite::model::{ConnectionStart, StartParameter};
use wire::profidrive::{
    ErrorNumber, ParameterAddress, ParameterFormat, ParameterRequest, ParameterResponse, ParameterValue,
};

/// Index of I&M0; those of I&M1 to I&M4 follow.
const IM0: u16 = 0xAFF0;

/// The state of a live device before the first trial.
#[derive(Clone, Debug, Default)]
pub struct ProbedDevice {
    /// The firmware that the device reports in I&M0.
    pub firmware: Option<String>,
    /// What else it reports there, as name and value: serial number, hardware revision, order number.
    pub identification: Vec<(String, String)>,
    /// The values of the parameters that a suite may write.
    pub parameters: Vec<journal::InitialParameter>,
    /// I&M1 to I&M4.
    pub im_records: Vec<journal::InitialImRecord>,
    /// The submodules with which connections were established.
    pub connected: Vec<AcceptedSubmodule>,
    /// Wrong claims of the bench.
    pub findings: Vec<DeviceFinding>,
    /// Why the device is not of the claimed variant, so that nothing is judged.
    pub refuted: Option<DeviceFinding>,
}

/// Why a value was not written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum ParameterRefusal {
    /// The device refused it with this error number of PROFIdrive.
    Error(ErrorNumber),
    /// There is no usable answer.
    NoAnswer,
}

impl ParameterRefusal {
    /// The reason in words.
    fn text(self) -> String {
        match self {
            ParameterRefusal::Error(number) => {
                format!("refused: {} ({})", number.word().unwrap_or("unknown error"), number.0)
            }
            ParameterRefusal::NoAnswer => "no usable answer".to_owned(),
        }
    }
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
            // A module that is the same as a claimed one stands for a feature, which no connection shows.
            let is_same = |other: &DeviceModule| {
                other.submodules == module.submodules && other.ident() == module.ident() && other.name != module.name
            };
            let claimed = bench.telegrams.iter().flatten();
            let mut claimed = claimed.filter_map(|name| device.modules.iter().find(|other| other.name == *name));
            if !is_claimed && !module.submodules.is_empty() && claimed.any(is_same) {
                continue;
            }
            // Without claims one connection is enough.
            if unknown || (bench.telegrams.is_none() && connected) {
                continue;
            }
            // The modules of a slave without a manual stand for features, which no connection shows.
            if device.name == ANY_SLAVE && connected {
                continue;
            }
            let Ok(Some(accepted)) = self.driver.connects_with(self, &start) else { continue };
            if accepted && !connected {
                connected = true;
                probed.firmware = self.driver.firmware(self);
                probed.identification = self.driver.identification(self);
                probed.parameters = self.parameters_now();
                probed.im_records = self.driver.im_records(self);
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
        if !connected {
            probed.im_records = self.driver.im_records(self);
        }
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
        // These are no values: a write to them saves or resets.
        let acts = |index: usize, number: u16| {
            let resets = device.changes.factory_reset.contains(&Changed::Parameter(index));
            number == device.parameter_access.save || resets
        };
        let kept = device.parameters.iter().enumerate().filter(|(index, of)| of.writable && !acts(*index, of.number));
        let kept = kept.map(|(_, of)| of);
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

    /// Restores the device to its state before the run.
    pub fn restore(&mut self, found: &InitialDevice, kept: &DeviceBackup<'_>) -> RestoreOutcome {
        // This is done however the run ended.
        self.world.closing = true;
        let _ = self.disconnect(true);
        let _ = self.disconnect(false);
        self.driver.restore(self, found, kept)
    }

    /// Restores parameters and I&M1 to I&M4 in one connection, if they may have changed.
    pub fn restore_values(&mut self, kept: &DeviceBackup<'_>, outcome: &mut RestoreOutcome) {
        let parameters = if kept.wrote_parameters() { kept.parameters } else { &[] };
        let mut records = if kept.wrote_im_records() { kept.im_records.to_vec() } else { Vec::new() };
        if !records.is_empty() && parameters.is_empty() {
            // Nothing is connected where all records are as before.
            let now = self.driver.im_records(self);
            records.retain(|record| !now.contains(record));
        }
        if kept.changes.iter().any(|word| word.starts_with(change::PARAMETERS)) && kept.parameters.is_empty() {
            outcome.left.push("the parameters, which could not be read before they were written".to_owned());
        }
        if parameters.is_empty() && records.is_empty() {
            return;
        }
        let device = &self.world.manual.device;
        let start = (0..device.modules.len())
            .map(|index| default_start(device, self.variant_number(), index))
            .find(|start| description::gsdml::needs_description(device, start).is_none());
        let connected = match start {
            None => Err("no connection is possible without the GSDML or GSD of the device; name it in the bench file"),
            Some(start) if matches!(self.driver.connects_with(self, &start), Ok(Some(true))) => Ok(()),
            Some(_) => Err("the device cannot be connected"),
        };
        self.restore_parameters(parameters, kept.saved_parameters(), connected, outcome);
        for record in &records {
            let written = connected.map_err(str::to_owned).and_then(|()| self.driver.restore_im_record(self, record));
            if let Err(why) = written {
                let InitialImRecord { slot, subslot, index, octets, .. } = record;
                let number = index.saturating_sub(IM0);
                let octets = hex(octets);
                outcome.left.push(format!("I&M{number} at slot {slot} subslot {subslot} (0x{octets}): {why}"));
            }
        }
        let _ = self.disconnect(false);
    }

    fn restore_parameters(
        &mut self,
        parameters: &[journal::InitialParameter],
        saved: bool,
        connected: Result<(), &str>,
        outcome: &mut RestoreOutcome,
    ) {
        let mut all = !parameters.is_empty();
        for parameter in parameters {
            if let Err(why) = connected.map_err(str::to_owned).and_then(|()| self.restore_parameter(parameter)) {
                let element = if parameter.subindex == 0 { String::new() } else { format!(".{}", parameter.subindex) };
                let octets = hex(&parameter.octets);
                outcome.left.push(format!("P{}{element} (0x{octets}): {why}", parameter.number));
                all = false;
            }
        }
        // If the run saved parameters, the restored ones are saved too, so that they survive the next power-on.
        let device = &self.world.manual.device;
        let number = device.parameter_access.save;
        let save = device.parameters.iter().find(|of| of.number == number && of.writable);
        if let (true, true, Some(save)) = (all, saved, save) {
            let format = save.kind.formats.first().copied().unwrap_or(ParameterFormat::WORD.0);
            let save = journal::InitialParameter { number, subindex: 0, format, octets: vec![0, 1] };
            if let Err(why) = self.write_parameter(&save) {
                outcome.left.push(format!("the parameters in non-volatile memory: {}", why.text()));
            }
        }
    }

    /// Writes a parameter, unless it is as before; one that is read-only was not changed by any trial.
    fn restore_parameter(&mut self, parameter: &journal::InitialParameter) -> Result<(), String> {
        let address = (parameter.number, parameter.subindex);
        if self.parameter_now(address).as_ref() == Some(parameter) {
            return Ok(());
        }
        match self.write_parameter(parameter) {
            Ok(()) if self.parameter_now(address).as_ref() == Some(parameter) => Ok(()),
            Ok(()) => Err("the device accepts it and reports another value".to_owned()),
            Err(ParameterRefusal::Error(ErrorNumber::READ_ONLY)) => Ok(()),
            Err(why) => Err(why.text()),
        }
    }

    /// Writes a value.
    fn write_parameter(&mut self, parameter: &journal::InitialParameter) -> Result<(), ParameterRefusal> {
        let value = ParameterValue::new(ParameterFormat(parameter.format), 1, parameter.octets.clone());
        let change = vec![(ParameterAddress::value(parameter.number, parameter.subindex), value)];
        let do_id = self.world.manual.device.parameter_access.do_id;
        let octets = self.parameter_response(&ParameterRequest::change_values(1, do_id, change));
        let Some(Ok(response)) = octets.as_deref().map(ParameterResponse::parse) else {
            return Err(ParameterRefusal::NoAnswer);
        };
        let error = response.values.first().and_then(ParameterValue::error).map(|error| error.number);
        match (response.header.id.is_negative(), error) {
            (false, _) => Ok(()),
            (true, Some(number)) => Err(ParameterRefusal::Error(number)),
            (true, None) => Err(ParameterRefusal::NoAnswer),
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
pub(super) fn default_start(device: &DeviceDescription, variant: usize, module: usize) -> ConnectionStart {
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
