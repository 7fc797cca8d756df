//! The manual for a reference device with another description: what a GSDML or a bench file says of a live device, a variation says here.

use super::dut::{DutKind, DutSpec};
use deviations::{DescriptionChange, IdentMask, Place, StartLayout, VendorRecord};
use std::sync::Arc;
use suite::device::{DeviceDescription, DeviceRecord, Origin, RecordField};
use suite::model::Manual;

/// Returns the manual with the description of the device that `dut` is, without the compiled suites; `None` if it is the same. A live
/// device has what its GSDML or GSD and its bench file say. A reference device has what its variations change: like the overlay of a
/// GSDML, that replaces only what the manual does not print.
pub fn described(manual: &Manual, dut: &DutSpec) -> Option<Manual> {
    if let Some(live) = dut.live() {
        let device = &live.manual().device;
        return (!Arc::ptr_eq(device, &manual.device)).then(|| with_device(manual, device.clone()));
    }
    if dut.variations().is_empty() {
        return None;
    }
    let changes = dut.model().ok()?.description_changes(dut.variations().iter().map(String::as_str));
    if changes.is_empty() {
        return None;
    }
    let mut device = (*manual.device).clone();
    let has_manual = !matches!(dut.kind, DutKind::External { .. });
    let is_free = |origin: Origin| is_free(origin, has_manual);
    for change in changes {
        match change {
            DescriptionChange::Idents(mask) => change_idents(&mut device, &manual.device, mask, is_free),
            DescriptionChange::DeviceId(id) => {
                if let Some(facts) = device.bus.profinet_mut().filter(|of| is_free(of.identity.device_id_origin)) {
                    (facts.identity.device_id, facts.identity.device_id_origin) = (id, Origin::Description);
                }
            }
            DescriptionChange::Ports(count) => {
                let interface_and_ports = usize::from(count) + 1;
                device.bus.profinet_mut().into_iter().for_each(|facts| facts.network.truncate(interface_and_ports));
            }
            DescriptionChange::Label(label, other) => {
                let shown = device.pages.iter_mut().flat_map(|page| &mut page.shows);
                shown.filter(|value| value.label == label).for_each(|value| other.clone_into(&mut value.label));
            }
            DescriptionChange::StartParameters(layout) => move_start_parameters(&mut device, &layout, is_free),
            DescriptionChange::StartRecords(records) => add_start_records(&mut device, records),
        }
    }
    Some(with_device(manual, Arc::new(device)))
}

fn with_device(manual: &Manual, device: Arc<DeviceDescription>) -> Manual {
    let (requirements, bugs) = (manual.requirements.clone(), manual.bugs.clone());
    Manual { device, requirements, bugs, variants: Vec::new(), unused: Vec::new(), also: manual.also.clone() }
}

/// Whether neither the manual nor a description says what a value is, so that it may be another one. A reference device without its
/// manual has nothing but a description, which a variation may change.
fn is_free(origin: Origin, has_manual: bool) -> bool {
    origin == Origin::Invented || !has_manual && origin == Origin::Description
}

/// Changes the idents that are free in `before`; several masks may change them, one after the other.
fn change_idents(
    device: &mut DeviceDescription,
    before: &DeviceDescription,
    mask: IdentMask,
    is_free: impl Fn(Origin) -> bool,
) {
    let submodules = device.submodules.iter_mut().zip(&before.submodules);
    for (submodule, _) in submodules.filter(|(of, before)| of.slot != 0 && is_free(before.ident_origin)) {
        submodule.ident ^= mask.submodule;
        submodule.module_idents.iter_mut().flatten().for_each(|ident| *ident ^= mask.module);
        submodule.ident_origin = Origin::Description;
    }
    device
        .bus
        .profinet_mut()
        .into_iter()
        .flat_map(|facts| &mut facts.network)
        .for_each(|(_, ident)| *ident ^= mask.network);
    let modules = device.modules.iter_mut().zip(&before.modules);
    for (module, _) in modules.filter(|(_, before)| is_free(before.ident_origin)) {
        if let Some(ident) = module.ident() {
            module.take_ident(ident ^ mask.module);
        }
    }
}

/// Moves the fields of each start record that no manual prints to their places in `layout`.
fn move_start_parameters(device: &mut DeviceDescription, layout: &StartLayout, is_free: impl Fn(Origin) -> bool) {
    for record in device.records.iter_mut().filter(|record| record.start && is_free(record.origin)) {
        record.octets = layout.default.len();
        record.template.clone_from(&layout.default);
        record.origin = Origin::Description;
        for field in &mut record.fields {
            if let Some((_, other)) = layout.places.iter().find(|(own, _)| *own == place(field)) {
                (field.octet, field.bits) = match *other {
                    Place::Bytes(octet, _) => (octet, None),
                    Place::Bit(octet, bit) => (octet, Some((bit, 1))),
                };
                field.origin = Origin::Description;
            }
        }
    }
}

/// Adds start records that only a description has, with their defaults, to the start-up of each module with their submodule.
fn add_start_records(device: &mut DeviceDescription, records: &[VendorRecord]) {
    for record in records {
        let submodules = device.submodules.iter().enumerate();
        for (at, of) in submodules.filter(|(_, of)| (of.slot, of.subslot) == (record.slot, record.subslot)) {
            let modules = device.modules.iter().enumerate();
            let with = modules.filter(|(_, module)| module.submodules.contains(&at)).map(|(index, _)| index).collect();
            device.records.push(DeviceRecord {
                name: format!("record_0x{:x}_{}", record.index, of.name),
                index: record.index,
                at,
                octets: record.default.len(),
                start: true,
                with: (record.slot != 0).then_some(with),
                fields: Vec::new(),
                template: record.default.to_vec(),
                origin: Origin::Description,
            });
        }
    }
}

fn place(field: &RecordField) -> Place {
    match field.bits {
        Some((bit, _)) => Place::Bit(field.octet, bit),
        None => Place::Bytes(field.octet, field.octets),
    }
}
