//! Adds values that no manual prints to the description of a device: idents, the device ID, and layouts that a GSDML confirms.

use super::identity::{PluggedSubmodule, ReportedIdentity};
use super::matching::{self, ModuleMatch, SubmoduleMatch};
use super::model::{AccessPoint, Bits, DataType, Gsdml, GsdmlRecord, GsdmlSubmodule, RecordItem, SubmoduleKind};
use super::parameters::parameter;
use crate::record_match::{FoundParameter, RecordMatch};
use std::fmt;
use suite::device::{DeviceDescription, DeviceRecord, Origin, RecordField};
use suite::model::ConnectionStart;

/// The result of [`overlay`].
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Overlay {
    /// The values that were taken over and their source, as sentences.
    pub taken: Vec<String>,
    /// The values that are still invented, and why, as sentences.
    pub missing: Vec<String>,
    /// For start parameters whose place no manual prints: what was found in the description.
    pub parameters: Vec<FoundParameter>,
}

/// The source of a value.
#[derive(Clone, Copy)]
enum ValueSource {
    Gsdml,
    Device,
}

impl fmt::Display for ValueSource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            ValueSource::Gsdml => "the GSDML",
            ValueSource::Device => "the device",
        })
    }
}

/// Replaces the idents and the device ID that `device.yaml` marks as invented, and interface and ports, by those that the device
/// reports, else by those of the GSDML, and marks them as taken from a description. Records marked as invented are marked too, if the GSDML has the same layout.
/// Values printed in the manual are not changed.
///
/// `variant` is an index into `device.variants`. If a GSDML leaves several choices and the device does not decide between them, nothing
/// is taken over.
pub fn overlay(
    device: &mut DeviceDescription,
    variant: usize,
    gsdml: Option<&Gsdml>,
    says: Option<&ReportedIdentity>,
    confirmed: &[(String, String)],
) -> Overlay {
    let variant = device.variants.get(variant).cloned().unwrap_or_default();
    let points = gsdml.map_or_else(Vec::new, |gsdml| matching::access_points(gsdml, &variant, says));
    let mut work = OverlayBuilder {
        device,
        variant,
        gsdml,
        points,
        says,
        confirmed,
        settled: Vec::new(),
        done: Overlay::default(),
    };
    work.device_id();
    work.access_point();
    work.network();
    work.snmp();
    for index in 0..work.device.modules.len() {
        if work.device.modules[index].absent.is_none() {
            work.module(index);
        }
    }
    work.records();
    work.other_records();
    work.done
}

struct OverlayBuilder<'w> {
    device: &'w mut DeviceDescription,
    variant: String,
    gsdml: Option<&'w Gsdml>,
    points: Vec<&'w AccessPoint>,
    says: Option<&'w ReportedIdentity>,
    /// Fields and names in the GSDML on which a person decided.
    confirmed: &'w [(String, String)],
    /// The indices of the submodules whose ident was taken over.
    settled: Vec<usize>,
    done: Overlay,
}

/// The idents found for a module of the manual.
#[derive(Clone, Default, PartialEq, Eq)]
struct ModuleIdents {
    /// For each submodule its index, the ident of its module, and its own ident.
    submodules: Vec<(usize, u32, u32)>,
}

/// The subslot of the interface; those of its ports follow.
const INTERFACE_SUBSLOT: u16 = 0x8000;

/// Interface and ports of an access point: their subslots and idents, in the order of the subslots.
fn network_of(point: &AccessPoint) -> Vec<(u16, u32)> {
    let is_network = |of: &&GsdmlSubmodule| matches!(of.kind, SubmoduleKind::Interface | SubmoduleKind::Port);
    let found = point.submodules.iter().filter(is_network);
    let mut network: Vec<(u16, u32)> = found.filter_map(|of| Some((*of.subslots.first()?.start(), of.ident))).collect();
    network.sort_unstable();
    network
}

impl<'w> OverlayBuilder<'w> {
    fn taken(&mut self, what: &str, number: u32, from: ValueSource) {
        self.done.taken.push(format!("{what} is 0x{number:X}, from {from}"));
    }

    fn device_id(&mut self) {
        let Some(identity) = self.device.bus.profinet_mut().map(|facts| &mut facts.identity) else { return };
        if identity.device_id_origin != Origin::Invented {
            return;
        }
        let said = self.says.and_then(|says| says.ids).map(|ids| (ids, ValueSource::Device));
        let read = self.gsdml.map(|gsdml| ((gsdml.vendor_id, gsdml.device_id), ValueSource::Gsdml));
        let of_vendor = [said, read].into_iter().flatten().find(|((vendor, _), _)| *vendor == identity.vendor_id);
        match of_vendor {
            Some(((_, id), from)) => {
                (identity.device_id, identity.device_id_origin) = (id, Origin::Description);
                self.taken("the device ID", id.into(), from);
            }
            None => self.done.missing.push("the device ID: neither device nor GSDML of this vendor has it".into()),
        }
    }

    /// The submodule plugged in a slot and subslot.
    fn plugged(&self, slot: u16, subslot: u16) -> Option<&PluggedSubmodule> {
        self.says?.plugged.iter().find(|of| (of.slot, of.subslot) == (slot, subslot))
    }

    fn take_idents(&mut self, index: usize, module_ident: u32, ident: u32, from: ValueSource) {
        let number = self.device.variants.iter().position(|known| *known == self.variant).unwrap_or_default();
        let Some(submodule) = self.device.submodules.get_mut(index) else { return };
        submodule.ident = ident;
        if let Some(known) = submodule.module_idents.as_mut().and_then(|idents| idents.get_mut(number)) {
            *known = module_ident;
        }
        submodule.ident_origin = Origin::Description;
        let name = submodule.name.clone();
        self.settled.push(index);
        self.taken(&format!("the ident of {name}"), ident, from);
    }

    /// Takes over the idents of the submodules of slot 0, which belong to every connection.
    fn access_point(&mut self) {
        for index in 0..self.device.submodules.len() {
            let of = &self.device.submodules[index];
            if of.slot != 0 || of.ident_origin != Origin::Invented {
                continue;
            }
            let said = self.plugged(0, of.subslot).map(|of| (of.module_ident, of.submodule_ident, ValueSource::Device));
            let read = self.points.iter().map(|point| {
                let found = point.submodules.iter().find(|known| matching::holds(&known.subslots, of.subslot));
                found.map(|known| (point.ident, known.ident))
            });
            let read = unanimous(read).map(|(module, ident)| (module, ident, ValueSource::Gsdml));
            match said.or(read) {
                Some((module, ident, from)) => self.take_idents(index, module, ident, from),
                None => self.done.missing.push(format!("the ident of {}: {}", of.name, self.missing_reason())),
            }
        }
    }

    /// Takes over interface and ports, which some controllers expect in each connection. Without a source none are known.
    fn network(&mut self) {
        let own = self.device.profinet().map_or_else(Vec::new, |facts| facts.network.clone());
        if own.is_empty() {
            return;
        }
        let plugged = self.says.map_or(&[][..], |says| &says.plugged).iter();
        let plugged = plugged.filter(|of| of.slot == 0 && of.subslot >= INTERFACE_SUBSLOT);
        let said: Vec<(u16, u32)> = plugged.map(|of| (of.subslot, of.submodule_ident)).collect();
        let read = unanimous(self.points.iter().map(|point| Some(network_of(point)))).unwrap_or_default();
        let found =
            [(said, ValueSource::Device), (read, ValueSource::Gsdml)].into_iter().find(|(of, _)| !of.is_empty());
        match &found {
            Some((network, _)) if *network == own => {}
            Some((_, from)) => self.done.taken.push(format!("the idents of interface and ports are from {from}")),
            None => self.done.missing.push(format!(
                "the idents of interface and ports, which no connection expects therefore: {}",
                self.missing_reason()
            )),
        }
        if let Some(facts) = self.device.bus.profinet_mut() {
            facts.network = found.map(|(network, _)| network).unwrap_or_default();
        }
    }

    /// Takes over whether the device has SNMP, and whether it says Hello.
    fn snmp(&mut self) {
        let read = unanimous(self.points.iter().map(|point| Some(point.has_snmp())));
        if let (Some(has_snmp), Some(facts)) = (read, self.device.bus.profinet_mut()) {
            facts.has_snmp = has_snmp;
        }
        let read = unanimous(self.points.iter().map(|point| Some(point.has_hello())));
        if let (Some(has_hello), Some(facts)) = (read, self.device.bus.profinet_mut()) {
            facts.has_hello = has_hello;
        }
    }

    /// Why no ident was found.
    fn missing_reason(&self) -> String {
        match (self.gsdml, self.points.len()) {
            (None, _) => "there is no GSDML, and the device does not report it".into(),
            (Some(_), 1) => "the GSDML has nothing that matches in this slot".into(),
            (Some(_), n) => {
                format!("the GSDML has {n} access points, and the device does not report which of them it has")
            }
        }
    }

    fn module(&mut self, index: usize) {
        let module = &self.device.modules[index];
        let lacks = |&index: &usize| self.device.submodules[index].ident_origin == Origin::Invented;
        let shared = module.submodules.iter().any(|index| self.settled.contains(index));
        let is_complete = module.ident_origin != Origin::Invented && !module.submodules.iter().any(lacks);
        if is_complete && !shared {
            return;
        }
        let read = self.points.iter().map(|point| self.read(point, index));
        let found = unanimous(read).map(|idents| (idents, ValueSource::Gsdml));
        let found = found.or_else(|| Some((self.plugged_idents(index)?, ValueSource::Device)));
        let Some((idents, from)) = found else {
            // The idents of its submodules alone may be known.
            self.take_plugged_submodules(index);
            let name = &self.device.modules[index].name;
            self.done.missing.push(format!("the idents of {name}: {}", self.missing_reason()));
            return;
        };
        let other_ident = |&&(index, _, ident): &&(usize, u32, u32)| {
            self.settled.contains(&index) && self.device.submodules.get(index).is_some_and(|of| of.ident != ident)
        };
        if let Some((other, _, ident)) = idents.submodules.iter().find(other_ident) {
            let (name, other) = (&self.device.modules[index].name, &self.device.submodules[*other]);
            self.done.missing.push(format!(
                "the idents of {name}: {} would be 0x{ident:X} in it, but is 0x{:X} in another module",
                other.name, other.ident
            ));
            return;
        }
        for &(submodule, module_ident, ident) in &idents.submodules {
            if self.device.submodules[submodule].ident_origin == Origin::Invented {
                self.take_idents(submodule, module_ident, ident, from);
            }
        }
        if self.device.modules[index].ident_origin == Origin::Invented {
            self.module_ident(index, &idents, from);
        }
    }

    /// Takes over the ident of the manual's module in all slots whose submodules have no module ident of their own.
    fn module_ident(&mut self, index: usize, idents: &ModuleIdents, from: ValueSource) {
        let of_module = |&&(index, ..): &&(usize, u32, u32)| {
            self.device.submodules.get(index).is_some_and(|of| of.module_idents.is_none())
        };
        let used: Vec<u32> = idents.submodules.iter().filter(of_module).map(|(_, ident, _)| *ident).collect();
        let module = &mut self.device.modules[index];
        if used.is_empty() {
            module.ident_origin = Origin::Description;
            // Nothing uses the ident of the module, which is that of its slot if it has only one.
            if let Some(ident) = unanimous(idents.submodules.iter().map(|(_, ident, _)| Some(*ident))) {
                module.take_ident(ident);
            }
            return;
        }
        match unanimous(used.into_iter().map(Some)) {
            Some(ident) => {
                module.take_ident(ident);
                let what = format!("the ident of the module of {}", module.name);
                self.taken(&what, ident, from);
            }
            None => {
                let name = &module.name;
                self.done.missing.push(format!("the ident of {name}: it differs in each of its slots"));
            }
        }
    }

    /// The idents of a module in the GSDML.
    fn read(&self, point: &AccessPoint, index: usize) -> Option<ModuleIdents> {
        let gsdml = self.gsdml?;
        let mut idents = ModuleIdents::default();
        for (slot, submodules) in matching::slots(self.device, index) {
            let of = (index, slot, submodules.as_slice());
            let ModuleMatch::One(slotted, found) =
                matching::find(gsdml, point, self.device, of, &self.variant, self.says)
            else {
                return None;
            };
            for (submodule, found) in found {
                let SubmoduleMatch::One(known) = found else { return None };
                idents.submodules.push((submodule, slotted.ident, known.ident));
            }
        }
        Some(idents)
    }

    /// The idents of a module as plugged in the device, if it is certainly this module.
    fn plugged_idents(&self, index: usize) -> Option<ModuleIdents> {
        let of_module = self.device.modules.get(index)?.submodules.iter();
        let each = of_module.map(|&submodule| {
            let plugged = self.certainly_plugged(submodule)?;
            Some((submodule, plugged.module_ident, plugged.submodule_ident))
        });
        Some(ModuleIdents { submodules: each.collect::<Option<_>>()? })
    }

    fn take_plugged_submodules(&mut self, index: usize) {
        for submodule in self.device.modules[index].submodules.clone() {
            let is_invented = self.device.submodules[submodule].ident_origin == Origin::Invented;
            let plugged = self.certainly_plugged(submodule).map(|of| (of.module_ident, of.submodule_ident));
            if let Some((module, ident)) = plugged.filter(|_| is_invented) {
                self.take_idents(submodule, module, ident, ValueSource::Device);
            }
        }
    }

    /// The plugged submodule at the slot and subslot of a submodule, if no other submodule of the manual can be there: it is the only one
    /// at this address, or the only one with these lengths.
    fn certainly_plugged(&self, index: usize) -> Option<&PluggedSubmodule> {
        let of = self.device.submodules.get(index)?;
        let plugged = self.plugged(of.slot, of.subslot).filter(|plugged| plugged.api == of.api)?;
        let rivals = self.device.submodules.iter().filter(|other| {
            (other.slot, other.subslot, other.api) == (of.slot, of.subslot, of.api)
                && plugged.octets.is_none_or(|octets| octets == (other.input_octets, other.output_octets))
        });
        let is_one = plugged.octets.is_none_or(|octets| octets == (of.input_octets, of.output_octets));
        (is_one && rivals.count() == 1).then_some(plugged)
    }

    /// Takes over the layout of start records, by the meaning of their parameters.
    fn records(&mut self) {
        let Some(gsdml) = self.gsdml else { return };
        let known_indices: Vec<u32> = self
            .device
            .records
            .iter()
            .filter(|record| record.origin != Origin::Invented)
            .map(|record| u32::from(record.index))
            .collect();
        for index in 0..self.device.records.len() {
            let record = &self.device.records[index];
            let Some(at) = self.device.submodules.get(record.at).filter(|_| record.start) else { continue };
            let mut submodules = self.meant(gsdml, record.at);
            if submodules.is_empty() {
                let slots = self.points.iter().flat_map(|point| matching::in_slot(gsdml, point, at.slot));
                submodules = slots.flat_map(|slotted| slotted.in_subslot(at.subslot)).collect();
            }
            let known: Vec<&GsdmlRecord> = submodules.into_iter().flat_map(|known| &known.records).collect();
            if record.origin == Origin::Invented {
                let own = known.into_iter().filter(|of| !known_indices.contains(&of.index)).collect::<Vec<_>>();
                self.invented_record(index, &own);
            } else {
                let own = known.into_iter().filter(|of| of.index == u32::from(record.index)).collect::<Vec<_>>();
                self.printed_record(index, &own);
            }
        }
    }

    /// The submodules of the GSDML that a submodule of the manual, by its index, certainly means: a station can have other modules in
    /// the same slot, with records of their own.
    fn meant(&self, gsdml: &'w Gsdml, at: usize) -> Vec<&'w GsdmlSubmodule> {
        let Some(submodule) = self.device.submodules.get(at) else { return Vec::new() };
        let slotted = |point: &'w AccessPoint| {
            let modules = (0..self.device.modules.len()).flat_map(|module| {
                matching::slots(self.device, module).into_iter().map(move |(slot, indices)| (module, slot, indices))
            });
            let found =
                modules.filter(|(_, _, indices)| indices.contains(&at)).filter_map(|(module, slot, indices)| {
                    let of = (module, slot, indices.as_slice());
                    match matching::find(gsdml, point, self.device, of, &self.variant, self.says) {
                        ModuleMatch::One(_, found) => found.into_iter().find(|(index, _)| *index == at),
                        _ => None,
                    }
                });
            found.filter_map(|(_, found)| match found {
                SubmoduleMatch::One(known) => Some(known),
                _ => None,
            })
        };
        let in_access_point = self.points.iter().filter(|_| submodule.slot == 0);
        let in_access_point = in_access_point.filter_map(|point| matching::in_access_point(point, submodule));
        in_access_point.chain(self.points.iter().copied().flat_map(slotted)).collect()
    }

    /// Adds the start records of the GSDML that the manual lacks, with their defaults, to the submodules of the access point and of the
    /// manual's modules.
    fn other_records(&mut self) {
        let Some(gsdml) = self.gsdml else { return };
        let point = match self.points[..] {
            [only] => only,
            _ => return,
        };
        let mut added: Vec<DeviceRecord> = Vec::new();
        // Those of the access point belong to the start-up of every module.
        for (at, of) in self.device.submodules.iter().enumerate().filter(|(_, of)| of.slot == point.slot) {
            let known = matching::in_access_point(point, of);
            for record in known.iter().flat_map(|known| &known.records) {
                self.other_record(record, (None, at), &mut added);
            }
        }
        for module in 0..self.device.modules.len() {
            for (slot, submodules) in matching::slots(self.device, module) {
                let of = (module, slot, submodules.as_slice());
                let found = matching::find(gsdml, point, self.device, of, &self.variant, self.says);
                let ModuleMatch::One(_, found) = found else { continue };
                for (at, found) in found {
                    let SubmoduleMatch::One(known) = found else { continue };
                    for record in &known.records {
                        self.other_record(record, (Some(module), at), &mut added);
                    }
                }
            }
        }
        added.sort_by_key(|record| record.index);
        for record in added {
            let (name, octets) = (&record.name, record.octets);
            self.done
                .taken
                .push(format!("{name} is only in the GSDML, with {octets} bytes; it is sent with its defaults"));
            self.device.records.push(record);
        }
    }

    fn other_record(&self, known: &GsdmlRecord, (module, at): (Option<usize>, usize), added: &mut Vec<DeviceRecord>) {
        let is_known = |record: &DeviceRecord| record.start && u32::from(record.index) == known.index;
        let Ok(index) = u16::try_from(known.index) else { return };
        if self.device.records.iter().any(is_known) {
            return;
        }
        let is_same = |of: &&mut DeviceRecord| (of.index, of.at) == (index, at) && of.template == known.default;
        if let Some(same) = added.iter_mut().find(is_same) {
            if let (Some(with), Some(module)) = (&mut same.with, module) {
                with.push(module);
            }
            return;
        }
        added.push(DeviceRecord {
            name: format!("record_0x{index:x}"),
            index,
            at,
            octets: known.octets,
            start: true,
            with: module.map(|module| vec![module]),
            fields: Vec::new(),
            template: known.default.clone(),
            origin: Origin::Description,
        });
    }

    fn find(&self, record: &DeviceRecord, known: &GsdmlRecord) -> RecordMatch {
        RecordMatch::find(record, known.items.iter().map(parameter).collect(), self.confirmed)
    }

    /// A record whose layout no manual prints: the record of the GSDML in which all of its parameters are found.
    fn invented_record(&mut self, index: usize, known: &[&GsdmlRecord]) {
        let record = &self.device.records[index];
        let found = known.iter().map(|known| (*known, self.find(record, known)));
        let mut best: Option<(&GsdmlRecord, RecordMatch)> = None;
        for (known, found) in found {
            let is_same = best.as_ref().is_some_and(|(other, _)| same_layout(other, known));
            if !is_same && best.as_ref().is_none_or(|(_, other)| found.found() > other.found()) {
                best = Some((known, found));
            }
        }
        let name = record.name.clone();
        let Some((known, found)) = best.filter(|(_, found)| found.found() > 0) else {
            self.done.missing.push(format!("the layout of {name}: no record of the GSDML has its parameters"));
            return;
        };
        self.done.parameters.extend(found.lines(record));
        if let Some(doubts) = found.doubts(record) {
            self.done.missing.push(format!("the layout of {name}: {doubts}"));
            return;
        }
        let record = &mut self.device.records[index];
        record.index = u16::try_from(known.index).unwrap_or(record.index);
        found.take_over(record, &known.default);
        self.done.taken.push(format!(
            "{name} is the record 0x{:X} of the GSDML with {} bytes; its parameters were found by their names",
            known.index, known.octets
        ));
    }

    /// A record whose layout the manual prints: a parameter that the GSDML has elsewhere, or with other values, is in doubt. Fields with
    /// an invented place are confirmed by their place.
    fn printed_record(&mut self, index: usize, known: &[&GsdmlRecord]) {
        let record = &self.device.records[index];
        let same = known.iter().find(|known| known.octets == record.octets);
        let Some(known) = same else { return };
        if let Some(contradictions) = self.find(record, known).contradictions(record) {
            self.done.missing.push(format!("the layout of {}: {contradictions}", record.name));
            self.device.records[index].origin = Origin::Invented;
            return;
        }
        let has = |field: &RecordField| known.items.iter().any(|item| is_place_of(item, field));
        let confirmed: Vec<bool> = record.fields.iter().map(has).collect();
        let record = &mut self.device.records[index];
        for (field, _) in record.fields.iter_mut().zip(&confirmed).filter(|(_, known)| **known) {
            if field.origin == Origin::Invented {
                field.origin = Origin::Description;
                self.done.taken.push(format!("the offset of {}.{} is that of the GSDML", record.name, field.name));
            }
        }
    }
}

/// Whether two records have the same bytes for the same parameters.
fn same_layout(one: &GsdmlRecord, other: &GsdmlRecord) -> bool {
    (one.index, one.octets, &one.default, &one.items) == (other.index, other.octets, &other.default, &other.items)
}

/// Whether an item of a GSDML has the offset and size of a field of the manual.
pub(super) fn is_place_of(item: &RecordItem, field: &RecordField) -> bool {
    let (low, width) = field.bits.unwrap_or((0, field.octets as u32 * 8));
    let place = match (&item.kind, item.bits) {
        (_, Some(Bits { low, width })) => (low, width),
        (DataType::Whole { octets, .. }, _) => (0, u32::from(*octets) * 8),
        _ => (0, item.octets as u32 * 8),
    };
    item.octet == field.octet && place == (low, width)
}

/// The common value, if all have the same and there is at least one.
fn unanimous<T: PartialEq>(mut all: impl Iterator<Item = Option<T>>) -> Option<T> {
    let first = all.next()??;
    all.all(|other| other.as_ref() == Some(&first)).then_some(first)
}

/// Why a live device cannot be started with `start`: a value that the start-up needs is invented for the reference device, and neither
/// a GSDML nor the device provides it. `None` if nothing is missing.
pub fn needs_description(device: &DeviceDescription, start: &ConnectionStart) -> Option<String> {
    let module = device.modules.get(start.module)?;
    let of_module = module.submodules.iter().filter_map(|&index| device.submodules.get(index));
    let access_point = device.submodules.iter().filter(|submodule| submodule.slot == 0);
    let submodules: Vec<_> = access_point.chain(of_module).collect();
    let with_place = |&(_, slot, subslot): &(_, u16, u16)| {
        submodules.iter().any(|submodule| (submodule.slot, submodule.subslot) == (slot, subslot))
    };
    let records = device.records.iter().filter(|record| record.start && record.origin == Origin::Invented);
    let record = records
        .filter_map(|record| device.submodules.get(record.at).map(|at| (record, at.slot, at.subslot)))
        .find(with_place);
    let invented = |origin: Origin| origin == Origin::Invented;
    let what = match submodules.iter().find(|submodule| invented(submodule.ident_origin)) {
        _ if invented(device.bus.number_origin()) => "device ID".to_owned(),
        Some(submodule) => format!("ident of {}", submodule.name),
        None if invented(module.ident_origin) => format!("ident of {}", module.name),
        None => format!("layout of {}", record?.0.name),
    };
    Some(device.bus.needs_description(&what))
}
