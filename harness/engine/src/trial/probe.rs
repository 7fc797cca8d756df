//! Looks at a live device before the first trial, and puts it back after the last: what it is really like, what the bench
//! claims wrongly, what its parameters were.
//!
//! It judges no requirement; what is found here are findings about the bench.

use super::Run;
use crate::live::Kept;
use description::gsdml::Connected;
use results::bench_file::BenchFile;
use results::journal::{self, Found};
use results::outcome::{Finding, Severity};
use suite::device::{Device, Parameter};
use suite::model::{Start, StartParameter};
use wire::profidrive::{ErrorNumber, Format, ParameterAddress, ParameterValue, Request as ParameterRequest, Response};

/// What was seen before the first trial.
#[derive(Clone, Debug, Default)]
pub struct Looked {
    /// The firmware that the device names in I&M0.
    pub firmware: Option<String>,
    /// The parameters that a suite may write, as they were found.
    pub parameters: Vec<journal::Parameter>,
    /// The submodules that connections stood with.
    pub connected: Vec<Connected>,
    /// What the bench claims wrongly.
    pub findings: Vec<Finding>,
}

/// What became of a value that was written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Written {
    /// The device took it.
    Taken,
    /// It cannot be changed, so that nobody has changed it by writing.
    ReadOnly,
    /// The device refused it, or did not answer.
    Refused,
}

impl Run<'_> {
    /// Connects once with each module of the manual that can be tried, and reads what is to be kept.
    pub fn look_around(&mut self, bench: &BenchFile) -> Looked {
        let mut looked = Looked::default();
        let device = &self.world.manual.device;
        let mut standing = false;
        for (index, module) in device.modules.iter().enumerate() {
            let is_claimed = bench.telegrams.as_ref().is_none_or(|claimed| claimed.contains(&module.name));
            let start = plain_start(device, self.variant_number(), index);
            let unknown = description::gsdml::needs_description(device, &start).is_some();
            // Without a claim one connection is enough to look around by.
            if unknown || (bench.telegrams.is_none() && standing) {
                continue;
            }
            let Ok(Some(accepted)) = self.driver.stands_with(self, &start) else { continue };
            if accepted && !standing {
                standing = true;
                looked.firmware = self.driver.firmware(self);
                looked.parameters = self.parameters_now();
                looked.findings.extend(bench.lacks.iter().filter_map(|name| self.lacks(name)));
            }
            if accepted {
                looked.connected.extend(module.submodules.iter().filter_map(|&submodule| {
                    let of = device.submodules.get(submodule)?;
                    let (input, output) = (of.input_octets, of.output_octets);
                    Some(Connected { slot: of.slot, subslot: of.subslot, ident: of.ident, input, output })
                }));
            }
            if bench.telegrams.is_some() && accepted != is_claimed {
                let claims = if is_claimed { "supports" } else { "does not support" };
                let does = if accepted { "connects with it" } else { "does not connect with it" };
                looked.findings.push(wrong_claim(&module.name, claims, does));
            }
        }
        // Nothing is judged here; what cannot be let go of now is told by the first trial.
        self.world.closing = true;
        let _ = self.disconnect(false);
        if let (Some(said), Some(seen)) = (&bench.firmware, &looked.firmware)
            && said != seen
        {
            looked.findings.push(Finding {
                id: "firmware".into(),
                severity: Severity::Error,
                text: format!("The bench says that the device runs the firmware {said}; it says {seen}."),
                manual: Some(format!("{said} (bench file)")),
                description: None,
                device: Some(seen.clone()),
            });
        }
        looked
    }

    /// The parameters that keep what is written to them, one request each so that a device which knows only some says so.
    fn parameters_now(&mut self) -> Vec<journal::Parameter> {
        let device = &self.world.manual.device;
        let kept = device.parameters.iter().filter(|of| of.writable && !of.permanent);
        let mut places: Vec<(u16, u16)> = Vec::new();
        for Parameter { number, elements, .. } in kept {
            let alone = elements.is_empty().then_some(0);
            places.extend(
                elements.iter().map(|(_, subindex)| *subindex).chain(alone).map(|subindex| (*number, subindex)),
            );
        }
        places.into_iter().filter_map(|place| self.parameter_now(place)).collect()
    }

    fn parameter_now(&mut self, (number, subindex): (u16, u16)) -> Option<journal::Parameter> {
        let do_id = self.world.manual.device.parameter_access.do_id;
        let request = ParameterRequest::read_values(1, do_id, vec![ParameterAddress::value(number, subindex)]);
        let octets = self.parameter_response(&request)?;
        let value = Response::parse(&octets).ok()?.values.into_iter().next()?;
        let is_value = value.error().is_none() && value.count == 1;
        is_value.then_some(journal::Parameter { number, subindex, format: value.format.0, octets: value.data })
    }

    /// The response to a parameter request in the connection that stands.
    fn parameter_response(&mut self, request: &ParameterRequest) -> Option<Vec<u8>> {
        let mut octets = Vec::new();
        request.write(&mut octets);
        self.driver.parameter_response(self, octets)
    }

    /// A finding if the device has what the bench says it lacks.
    fn lacks(&mut self, name: &str) -> Option<Finding> {
        let device = &self.world.manual.device;
        let has = match device.records.iter().find(|record| record.name == name) {
            Some(record) => self.driver.has_record(self, record)?,
            None => {
                let number = name.strip_prefix('P')?.parse().ok()?;
                let array = device.parameters.iter().find(|of| of.number == number)?.elements.first();
                self.parameter_now((number, array.map_or(0, |(_, subindex)| *subindex))).is_some()
            }
        };
        has.then(|| wrong_claim(name, "does not have", "answers when it is read"))
    }

    /// Gives the device back the name, the address and the parameters that it was found with, where they are others now; what
    /// did not go back, in words.
    pub fn put_back(&mut self, found: &Found, kept: &Kept<'_>) -> Vec<String> {
        // This is done however the run ended.
        self.world.closing = true;
        let _ = self.disconnect(false);
        self.driver.put_back(self, found, kept)
    }

    /// The same for the parameters alone.
    pub fn put_kept_back(&mut self, kept: &Kept<'_>, left: &mut Vec<String>) {
        if kept.parameters.is_empty() && kept.wrote_parameters {
            left.push("parameters, which could not be read before they were written".into());
        }
        if !kept.parameters.is_empty() {
            self.put_parameters_back(kept, left);
        }
    }

    fn put_parameters_back(&mut self, kept: &Kept<'_>, left: &mut Vec<String>) {
        let device = &self.world.manual.device;
        let module = (0..device.modules.len())
            .map(|index| plain_start(device, self.variant_number(), index))
            .find(|start| description::gsdml::needs_description(device, start).is_none());
        let stands = module.is_some_and(|start| matches!(self.driver.stands_with(self, &start), Ok(Some(true))));
        let mut all = stands;
        for parameter in kept.parameters {
            let place = (parameter.number, parameter.subindex);
            let is_same = |run: &mut Self| run.parameter_now(place).as_ref() == Some(parameter);
            let is_back = stands
                && (is_same(self)
                    || match self.write_parameter(parameter) {
                        Written::Taken => is_same(self),
                        Written::ReadOnly => true,
                        Written::Refused => false,
                    });
            if !is_back {
                let element = if parameter.subindex == 0 { String::new() } else { format!(".{}", parameter.subindex) };
                left.push(format!("P{}{element} (0x{})", parameter.number, hex(&parameter.octets)));
                all = false;
            }
        }
        // What the run has saved is saved once more, so that it is not there again after the next power-on.
        let number = device.parameter_access.save;
        let save = device.parameters.iter().find(|of| of.number == number && of.writable);
        if let (true, true, Some(save)) = (all, kept.saved, save) {
            let format = save.kind.formats.first().copied().unwrap_or(Format::WORD.0);
            let save = journal::Parameter { number, subindex: 0, format, octets: vec![0, 1] };
            if self.write_parameter(&save) != Written::Taken {
                left.push("what the memory keeps of the parameters".into());
            }
        }
        let _ = self.disconnect(false);
    }

    fn write_parameter(&mut self, parameter: &journal::Parameter) -> Written {
        let value = ParameterValue::new(Format(parameter.format), 1, parameter.octets.clone());
        let change = vec![(ParameterAddress::value(parameter.number, parameter.subindex), value)];
        let do_id = self.world.manual.device.parameter_access.do_id;
        let octets = self.parameter_response(&ParameterRequest::change_values(1, do_id, change));
        let Some(Ok(response)) = octets.as_deref().map(Response::parse) else { return Written::Refused };
        let error = response.values.first().and_then(ParameterValue::error).map(|error| error.number);
        match (response.header.id.is_negative(), error) {
            (false, _) => Written::Taken,
            (true, Some(ErrorNumber::READ_ONLY)) => Written::ReadOnly,
            (true, _) => Written::Refused,
        }
    }
}

fn hex(octets: &[u8]) -> String {
    octets.iter().map(|octet| format!("{octet:02X}")).collect()
}

fn wrong_claim(name: &str, claims: &str, does: &str) -> Finding {
    Finding {
        id: format!("claim.{name}"),
        severity: Severity::Error,
        text: format!("The bench says that the device {claims} {name}; it {does}."),
        manual: Some(format!("{claims} {name} (bench file)")),
        description: None,
        device: Some(does.to_owned()),
    }
}

/// The start-up with a module and every start parameter at its default.
fn plain_start(device: &Device, variant: usize, module: usize) -> Start {
    let mut parameters = Vec::new();
    for (record, of) in device.records.iter().enumerate().filter(|(_, record)| record.starts(module)) {
        for (field, of) in of.fields.iter().enumerate() {
            parameters.extend(of.default.get(variant).map(|&value| StartParameter { record, field, value }));
        }
    }
    Start {
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
