//! Disagreements between manual, GSDML and device. Values that `device.yaml` marks as invented are not compared, and values taken
//! from a description do not count as the manual's.

use super::identity::{PluggedSubmodule, ReportedIdentity};
use super::matching::{self, ModuleMatch, SlottedModule, SubmoduleMatch, lengths};
use super::model::{AccessPoint, Gsdml, GsdmlSubmodule};
use results::outcome::{DescriptionKind, DeviceFinding, FindingSeverity};
use suite::device::{self, DeviceDescription, Origin};

/// All disagreements of the manual (`device`, for the variant with this index), the GSDML and the device itself, in a fixed order. If
/// a GSDML has several access points that the device can have, the one with the fewest errors is used.
pub fn compare(
    device: &DeviceDescription,
    variant: usize,
    gsdml: Option<&Gsdml>,
    says: Option<&ReportedIdentity>,
) -> Vec<DeviceFinding> {
    let name = device.variants.get(variant).map_or("", String::as_str);
    let points = gsdml.map_or_else(Vec::new, |gsdml| matching::access_points(gsdml, name, says));
    let with = |point: Option<&AccessPoint>| {
        let mut work = GsdmlComparison { device, variant, gsdml, point, says, findings: Vec::new() };
        work.identity();
        work.apis();
        work.modules();
        work.plugged();
        work.maintenance();
        work.remarks();
        work.findings
    };
    let weigh =
        |findings: &Vec<DeviceFinding>| findings.iter().filter(|of| of.severity == FindingSeverity::Error).count();
    let all = points.into_iter().map(|point| with(Some(point)));
    all.min_by_key(weigh).unwrap_or_else(|| with(None))
}

/// The values of manual, GSDML and device for one thing.
#[derive(Default)]
pub(super) struct ComparedValues {
    pub manual: Option<String>,
    pub gsdml: Option<String>,
    pub device: Option<String>,
}

pub(super) struct GsdmlComparison<'w> {
    pub device: &'w DeviceDescription,
    pub variant: usize,
    pub gsdml: Option<&'w Gsdml>,
    pub point: Option<&'w AccessPoint>,
    pub says: Option<&'w ReportedIdentity>,
    findings: Vec<DeviceFinding>,
}

/// A number in the form of idents.
pub(super) fn hex(number: u32) -> String {
    format!("0x{number:X}")
}

/// A slot and subslot for people: the subslots of interface and ports are in hexadecimal.
fn address_text(slot: u16, subslot: u16) -> String {
    match subslot {
        0x8000.. => format!("slot {slot}, subslot 0x{subslot:X}"),
        _ => format!("slot {slot}, subslot {subslot}"),
    }
}

/// A slot and subslot in the id of a finding.
fn address_id(slot: u16, subslot: u16) -> String {
    match subslot {
        0x8000.. => format!("slot_{slot}.subslot_0x{subslot:x}"),
        _ => format!("slot_{slot}.subslot_{subslot}"),
    }
}

fn id(number: u16) -> String {
    format!("0x{number:04X}")
}

/// A value, if the manual prints it.
fn printed<T>(value: T, origin: Origin) -> Option<T> {
    (origin == Origin::Manual).then_some(value)
}

/// A text of a device or a file, cut and escaped.
pub(super) fn quoted(text: &str) -> String {
    let short: String = text.chars().take(60).collect();
    format!("`{}`", short.escape_debug())
}

impl<'w> GsdmlComparison<'w> {
    /// Adds a finding, unless there is the same one: modules share submodules.
    pub(super) fn find(&mut self, id: String, severity: FindingSeverity, text: String, three: ComparedValues) {
        let ComparedValues { manual, gsdml, device } = three;
        let description = gsdml.map(|said| (DescriptionKind::Gsdml, said));
        let finding = DeviceFinding { id, severity, text, manual, description, device };
        if !self.findings.contains(&finding) {
            self.findings.push(finding);
        }
    }

    /// Adds a finding if two of the values differ.
    pub(super) fn differ(&mut self, id: String, severity: FindingSeverity, subject: &str, three: ComparedValues) {
        let said: Vec<(&str, &String)> =
            [("the manual", &three.manual), ("the GSDML", &three.gsdml), ("the device", &three.device)]
                .into_iter()
                .filter_map(|(who, what)| Some((who, what.as_ref()?)))
                .collect();
        if said.windows(2).all(|pair| pair[0].1 == pair[1].1) {
            return;
        }
        let each: Vec<String> = said.iter().map(|(who, what)| format!("{who} says {what}")).collect();
        let text = format!("{subject}: {}.", each.join(", "));
        self.find(id, severity, text, three);
    }

    fn identity(&mut self) {
        let Some(identity) = self.device.profinet().map(|facts| &facts.identity) else { return };
        let said = |of: fn((u16, u16)) -> u16| self.says.and_then(|says| says.ids).map(of).map(id);
        let vendor = ComparedValues {
            manual: Some(id(identity.vendor_id)),
            gsdml: self.gsdml.map(|gsdml| id(gsdml.vendor_id)),
            device: said(|ids| ids.0),
        };
        let device = ComparedValues {
            manual: printed(id(identity.device_id), identity.device_id_origin),
            gsdml: self.gsdml.map(|gsdml| id(gsdml.device_id)),
            device: said(|ids| ids.1),
        };
        self.differ("vendor_id".into(), FindingSeverity::Error, "Vendor ID", vendor);
        self.differ("device_id".into(), FindingSeverity::Error, "Device ID", device);
    }

    /// The submodules of the GSDML that the device has plugged. Those built into its access point are plugged in any case.
    fn plugged_submodules(&self, gsdml: &'w Gsdml, point: &'w AccessPoint) -> Vec<&'w GsdmlSubmodule> {
        let plugged = self.says.map_or(&[][..], |says| &says.plugged);
        let elsewhere = plugged.iter().filter(|of| of.slot != point.slot).flat_map(|of| {
            let modules = matching::in_slot(gsdml, point, of.slot);
            let module = modules.into_iter().find(|slotted| slotted.ident == of.module_ident);
            let there = module.map_or_else(Vec::new, |slotted| slotted.in_subslot(of.subslot));
            there.into_iter().filter(|known| known.ident == of.submodule_ident)
        });
        point.submodules.iter().chain(elsewhere).collect()
    }

    /// Compares the APIs, if the device reports which it has.
    fn apis(&mut self) {
        let Some(said) = self.says.and_then(|says| says.apis.as_ref()) else { return };
        let plugged = self.says.map_or(&[][..], |says| &says.plugged);
        let is_plugged = |of: &&device::DeviceSubmodule| {
            plugged.is_empty() || plugged.iter().any(|there| (there.slot, there.subslot) == (of.slot, of.subslot))
        };
        let manual = || self.device.submodules.iter().filter(is_plugged).map(|submodule| submodule.api);
        let read: Option<Vec<u32>> = self
            .gsdml
            .zip(self.point)
            .map(|(gsdml, point)| self.plugged_submodules(gsdml, point).iter().map(|known| known.api).collect());
        let mut apis: Vec<u32> = manual().chain(read.iter().flatten().copied()).collect();
        apis.sort_unstable();
        apis.dedup();
        let has = |is: bool| Some(if is { "has it" } else { "does not have it" }.to_owned());
        let mut found = Vec::new();
        for api in apis.into_iter().filter(|api| !said.contains(api)) {
            let three = ComparedValues {
                manual: has(manual().any(|known| known == api)),
                gsdml: read.as_ref().and_then(|read| has(read.contains(&api))),
                device: has(false),
            };
            found.push((api, three));
        }
        for (api, three) in found {
            let text = format!("The device does not list API {} in record 0xF821.", hex(api));
            self.find(format!("api_{}", hex(api).to_lowercase()), FindingSeverity::Warning, text, three);
        }
    }

    /// Compares the modules of the manual with the GSDML.
    fn modules(&mut self) {
        let Some((gsdml, point)) = self.gsdml.zip(self.point) else { return };
        let variant = self.device.variants.get(self.variant).map_or("", String::as_str);
        let mut meant = Vec::new();
        for (index, of) in self.device.submodules.iter().enumerate().filter(|(_, of)| of.slot == 0) {
            self.of_access_point(point, of);
            meant.extend(matching::in_access_point(point, of).map(|known| (index, known)));
        }
        for (index, module) in self.device.modules.iter().enumerate() {
            for (slot, submodules) in matching::slots(self.device, index) {
                let place = (index, slot, submodules.as_slice());
                match matching::find(gsdml, point, self.device, place, variant, self.says) {
                    ModuleMatch::One(slotted, found) => {
                        self.module(&module.name, slot, &slotted, index, &submodules);
                        for (index, found) in found {
                            self.submodule(&slotted, index, found);
                            if let SubmoduleMatch::One(known) = found {
                                meant.push((index, known));
                            }
                        }
                    }
                    ModuleMatch::Several => {}
                    ModuleMatch::None => self.no_module(gsdml, point, &module.name, slot, &submodules),
                }
            }
        }
        super::records::compare(self, &meant);
    }

    /// Compares a submodule of slot 0, which is identified by its subslot.
    fn of_access_point(&mut self, point: &'w AccessPoint, of: &device::DeviceSubmodule) {
        let subject = |what: &str| format!("{what} of {} in slot 0", of.name);
        let plugged = self.plugged_at(0, of.subslot);
        let known = matching::in_access_point(point, of);
        let module = ComparedValues {
            manual: printed(hex(of.module_ident(self.variant).unwrap_or(of.ident)), of.ident_origin),
            gsdml: Some(hex(point.ident)),
            device: plugged.map(|plugged| hex(plugged.module_ident)),
        };
        self.differ(
            format!("{}.module_ident", of.name),
            FindingSeverity::Error,
            &subject("Ident of the module"),
            module,
        );
        let own = ComparedValues {
            manual: printed(hex(of.ident), of.ident_origin),
            gsdml: known.map(|known| hex(known.ident)),
            device: plugged.map(|plugged| hex(plugged.submodule_ident)),
        };
        self.differ(format!("{}.ident", of.name), FindingSeverity::Error, &subject("Ident"), own);
        if let Some(known) = known {
            self.shape(of, known, plugged);
        }
    }

    fn module(&mut self, name: &str, slot: u16, slotted: &SlottedModule<'_>, index: usize, submodules: &[usize]) {
        let three = ComparedValues {
            manual: matching::printed_module_ident(self.device, self.variant, index, submodules).map(hex),
            gsdml: Some(hex(slotted.ident)),
            device: None,
        };
        self.differ(
            format!("{name}.module_ident"),
            FindingSeverity::Error,
            &format!("Ident of the module in slot {slot} for {name}"),
            three,
        );
    }

    fn submodule(&mut self, slotted: &SlottedModule<'_>, index: usize, found: SubmoduleMatch<'_>) {
        let Some(of) = self.device.submodules.get(index) else { return };
        let known = match found {
            SubmoduleMatch::One(known) => known,
            SubmoduleMatch::Several => return,
            SubmoduleMatch::None => {
                let there = slotted.in_subslot(of.subslot);
                let three =
                    ComparedValues { manual: Some(shape_of(of)), gsdml: Some(list(there.into_iter())), device: None };
                let text = format!(
                    "The GSDML has no submodule for {} in subslot {} of the module {}.",
                    of.name,
                    of.subslot,
                    quoted(&slotted.info.name)
                );
                self.find(of.name.clone(), FindingSeverity::Error, text, three);
                return;
            }
        };
        let plugged = self.plugged_at(of.slot, of.subslot).filter(|plugged| plugged.submodule_ident == known.ident);
        let ident = ComparedValues {
            manual: printed(hex(of.ident), of.ident_origin),
            gsdml: Some(hex(known.ident)),
            device: None,
        };
        self.differ(format!("{}.ident", of.name), FindingSeverity::Error, &format!("Ident of {}", of.name), ident);
        self.shape(of, known, plugged);
    }

    /// Compares API and lengths of a submodule.
    fn shape(&mut self, of: &device::DeviceSubmodule, known: &GsdmlSubmodule, plugged: Option<&PluggedSubmodule>) {
        let (input, output) = lengths(known);
        let octets = |octets: u16| format!("{octets} bytes");
        let api = ComparedValues {
            manual: Some(hex(of.api)),
            gsdml: Some(hex(known.api)),
            device: plugged.map(|plugged| hex(plugged.api)),
        };
        self.differ(format!("{}.api", of.name), FindingSeverity::Error, &format!("API of {}", of.name), api);
        let said = plugged.and_then(|plugged| plugged.octets);
        let sides = [
            ("inputs", "Input data", of.input_octets, input, said.map(|(input, _)| input)),
            ("outputs", "Output data", of.output_octets, output, said.map(|(_, output)| output)),
        ];
        for (word, what, manual, gsdml, device) in sides {
            let three =
                ComparedValues { manual: Some(octets(manual)), gsdml: gsdml.map(octets), device: device.map(octets) };
            self.differ(
                format!("{}.{word}", of.name),
                FindingSeverity::Error,
                &format!("{what} of {}", of.name),
                three,
            );
        }
    }

    fn no_module(&mut self, gsdml: &'w Gsdml, point: &'w AccessPoint, name: &str, slot: u16, submodules: &[usize]) {
        let of = submodules.iter().filter_map(|&index| self.device.submodules.get(index));
        let expected: Vec<String> = of.map(|of| format!("{}: {}", of.name, shape_of(of))).collect();
        let there = matching::in_slot(gsdml, point, slot);
        let names: Vec<String> = there.iter().take(8).map(|slotted| quoted(&slotted.info.name)).collect();
        let three = ComparedValues {
            manual: Some(expected.join("; ")),
            gsdml: Some(if names.is_empty() { "no module for this slot".into() } else { names.join(", ") }),
            device: None,
        };
        let text = format!("The GSDML has no module for slot {slot} that contains {name}.");
        self.find(name.to_owned(), FindingSeverity::Error, text, three);
    }

    pub(super) fn plugged_at(&self, slot: u16, subslot: u16) -> Option<&'w PluggedSubmodule> {
        self.says?.plugged.iter().find(|of| (of.slot, of.subslot) == (slot, subslot))
    }

    /// Compares the plugged submodules of the device with GSDML and manual.
    fn plugged(&mut self) {
        let Some(says) = self.says else { return };
        for plugged in &says.plugged {
            let &PluggedSubmodule { slot, subslot, .. } = plugged;
            // With a GSDML slot 0 has been compared with the manual already.
            if slot != 0
                || self.point.is_none()
                || self.device.submodules.iter().all(|of| (of.slot, of.subslot) != (0, subslot))
            {
                self.plugged_ident(plugged);
            }
        }
        self.always_there(says);
    }

    fn plugged_ident(&mut self, plugged: &PluggedSubmodule) {
        let &PluggedSubmodule { slot, subslot, module_ident, submodule_ident, .. } = plugged;
        let here: Vec<&device::DeviceSubmodule> =
            self.device.submodules.iter().filter(|of| (of.slot, of.subslot) == (slot, subslot)).collect();
        let is_printed = !here.is_empty() && here.iter().all(|of| of.ident_origin == Origin::Manual);
        let idents: Vec<u32> = here.iter().map(|of| of.ident).collect();
        let manual = is_printed.then(|| numbers(idents.iter().copied()));
        let against_manual = is_printed && !idents.contains(&submodule_ident);
        let place = address_id(slot, subslot);
        let Some((gsdml, point)) = self.gsdml.zip(self.point) else {
            if against_manual {
                let text =
                    format!("The manual has no submodule {} in {}.", hex(submodule_ident), address_text(slot, subslot));
                let three = ComparedValues { manual, gsdml: None, device: Some(hex(submodule_ident)) };
                self.find(place, FindingSeverity::Error, text, three);
            }
            return;
        };
        let modules = matching::in_slot(gsdml, point, slot);
        let Some(slotted) = modules.iter().find(|slotted| slotted.ident == module_ident) else {
            let idents = modules.iter().map(|slotted| slotted.ident);
            let three = ComparedValues { manual: None, gsdml: Some(numbers(idents)), device: Some(hex(module_ident)) };
            let text = format!(
                "The device has the module {} in slot {slot}; the GSDML does not allow it there.",
                hex(module_ident)
            );
            self.find(format!("slot_{slot}.module_ident"), FindingSeverity::Error, text, three);
            return;
        };
        let there = slotted.in_subslot(subslot);
        match there.iter().find(|known| known.ident == submodule_ident) {
            None => {
                let three = ComparedValues {
                    manual,
                    gsdml: Some(numbers(there.iter().map(|known| known.ident))),
                    device: Some(hex(submodule_ident)),
                };
                let text = format!(
                    "The device has the submodule {} in {}; the GSDML does not allow it there.",
                    hex(submodule_ident),
                    address_text(slot, subslot)
                );
                self.find(place, FindingSeverity::Error, text, three);
            }
            Some(known) => {
                let api = ComparedValues { manual: None, gsdml: Some(hex(known.api)), device: Some(hex(plugged.api)) };
                let subject = format!("API in {}", address_text(slot, subslot));
                self.differ(format!("{place}.api"), FindingSeverity::Error, &subject, api);
                if against_manual {
                    let three =
                        ComparedValues { manual, gsdml: Some(hex(known.ident)), device: Some(hex(submodule_ident)) };
                    self.differ(
                        place,
                        FindingSeverity::Error,
                        &format!("Ident in {}", address_text(slot, subslot)),
                        three,
                    );
                }
            }
        }
    }

    /// Reports submodules that are built into a module according to the GSDML, but that the device does not have.
    fn always_there(&mut self, says: &'w ReportedIdentity) {
        let Some((gsdml, point)) = self.gsdml.zip(self.point) else { return };
        let mut slots: Vec<(u16, u32)> = says.plugged.iter().map(|of| (of.slot, of.module_ident)).collect();
        slots.sort_unstable();
        slots.dedup();
        for (slot, module_ident) in slots {
            let modules = matching::in_slot(gsdml, point, slot);
            let Some(slotted) = modules.iter().find(|slotted| slotted.ident == module_ident) else { continue };
            for known in slotted.submodules {
                let Some(subslot) = known.subslots.first().map(|range| *range.start()) else { continue };
                let is_there =
                    says.plugged.iter().any(|of| of.slot == slot && matching::holds(&known.subslots, of.subslot));
                if !is_there {
                    let manual = self.device.submodules.iter().find(|of| (of.slot, of.subslot) == (slot, subslot));
                    let three = ComparedValues {
                        manual: manual.map(|of| format!("{} is present", of.name)),
                        gsdml: Some(format!("{} is built in", quoted(&known.info.name))),
                        device: Some("no submodule".into()),
                    };
                    let name = quoted(&known.info.name);
                    let place = address_text(slot, subslot);
                    let text =
                        format!("The GSDML has {name} built into {place}, but the device has no submodule there.");
                    self.find(address_id(slot, subslot), FindingSeverity::Warning, text, three);
                }
            }
        }
    }

    /// Compares I&M0 of the device with the GSDML.
    fn maintenance(&mut self) {
        let (Some(im0), Some(point)) = (self.says.and_then(|says| says.im0.as_ref()), self.point) else { return };
        let gsdml = self.gsdml;
        let order = String::from_utf8_lossy(&im0.order_id).trim_end().to_owned();
        let called = [Some(&point.info), self.plugged_module(gsdml, point)].into_iter().flatten();
        let numbers: Vec<&str> =
            called.map(|info| info.order_number.as_str()).filter(|number| !number.is_empty()).collect();
        if let Some(first) = numbers.first()
            && !numbers.iter().any(|number| number.eq_ignore_ascii_case(&order))
        {
            let three = ComparedValues { manual: None, gsdml: Some(quoted(first)), device: Some(quoted(&order)) };
            self.differ("order_number".into(), FindingSeverity::Warning, "Order number", three);
        }
        let vendor_id = self.device.ids().map_or(0, |(vendor, _)| vendor);
        if im0.vendor_id != vendor_id {
            let three = ComparedValues {
                manual: Some(id(vendor_id)),
                gsdml: gsdml.map(|gsdml| id(gsdml.vendor_id)),
                device: Some(id(im0.vendor_id)),
            };
            self.differ("im0.vendor_id".into(), FindingSeverity::Error, "Vendor ID in I&M0", three);
        }
        // I&M0 was read in slot 0; other modules have their own.
        let own = point.submodules.iter().flat_map(|of| &of.writable_im);
        let mut claimed: Vec<u16> = own.copied().filter(|n| (1..=15).contains(n)).collect();
        claimed.sort_unstable();
        claimed.dedup();
        let lacking: Vec<String> =
            claimed.iter().filter(|n| im0.im_supported & (1 << **n) == 0).map(|n| format!("I&M{n}")).collect();
        if !lacking.is_empty() {
            let three = ComparedValues {
                manual: None,
                gsdml: Some(format!("{} can be written", lacking.join(", "))),
                device: Some(format!("I&M0 lists 0x{:04X}", im0.im_supported)),
            };
            let text = format!("The GSDML says that {} can be written, but I&M0 does not list it.", lacking.join(", "));
            self.find("writable_im".into(), FindingSeverity::Warning, text, three);
        }
    }

    /// The module in the first slot after the access point, which may have the order number.
    fn plugged_module(&self, gsdml: Option<&'w Gsdml>, point: &'w AccessPoint) -> Option<&'w super::ModuleInfo> {
        let plugged = self.says?.plugged.iter().find(|of| of.slot != point.slot)?;
        let modules = matching::in_slot(gsdml?, point, plugged.slot);
        modules.into_iter().find(|slotted| slotted.ident == plugged.module_ident).map(|slotted| slotted.info)
    }

    /// Reports errors in the GSDML itself.
    fn remarks(&mut self) {
        for remark in self.gsdml.map_or(&[][..], |gsdml| &gsdml.remarks) {
            let three = ComparedValues { gsdml: Some(remark.clone()), ..ComparedValues::default() };
            self.find("gsdml_file".into(), FindingSeverity::Warning, format!("Error in the GSDML: {remark}."), three);
        }
    }
}

/// API and lengths of a submodule in words.
fn shape_of(of: &device::DeviceSubmodule) -> String {
    format!("subslot {}, API {}, {} bytes in, {} out", of.subslot, hex(of.api), of.input_octets, of.output_octets)
}

fn numbers(idents: impl Iterator<Item = u32>) -> String {
    let mut idents: Vec<u32> = idents.collect();
    idents.sort_unstable();
    idents.dedup();
    let shown: Vec<String> = idents.into_iter().take(16).map(hex).collect();
    if shown.is_empty() { "none".into() } else { shown.join(", ") }
}

fn list<'g>(submodules: impl Iterator<Item = &'g GsdmlSubmodule>) -> String {
    let each: Vec<String> = submodules
        .take(8)
        .map(|known| {
            let (input, output) = lengths(known);
            let octets = |of: Option<u16>| of.map_or("?".into(), |of| of.to_string());
            format!(
                "{} (API {}, {} bytes in, {} out)",
                quoted(&known.info.name),
                hex(known.api),
                octets(input),
                octets(output)
            )
        })
        .collect();
    if each.is_empty() { "none".into() } else { each.join(", ") }
}
