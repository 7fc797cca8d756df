//! Disagreements between the records of manual and GSDML.

use super::compare::{ComparedValues, GsdmlComparison, hex, quoted};
use super::model::{GsdmlRecord, GsdmlSubmodule};
use super::overlay::is_place_of;
use results::outcome::FindingSeverity;
use suite::device::{self, Origin, RecordField};

/// The submodule of a GSDML that a submodule of the manual, by its index, means. A station can have other modules in the same slot; their
/// records are not those of the manual's.
pub(super) type MeantSubmodules<'g> = [(usize, &'g GsdmlSubmodule)];

/// Compares the records of each submodule of the manual with the start-up records of the submodules that it means.
pub(super) fn compare(work: &mut GsdmlComparison<'_>, meant: &MeantSubmodules<'_>) {
    let device = work.device;
    for record in
        device.records.iter().filter(|record| record.origin == Origin::Manual && !is_only_read(device, record))
    {
        let Some(at) = device.submodules.get(record.at) else { continue };
        let submodules = meant.iter().filter(|(index, _)| *index == record.at).map(|(_, known)| *known);
        let submodules: Vec<&GsdmlSubmodule> = submodules.filter(|known| known.api == at.api).collect();
        let known: Vec<&GsdmlRecord> =
            submodules.iter().flat_map(|of| &of.records).filter(|of| of.index == u32::from(record.index)).collect();
        if known.is_empty() && record.start && !submodules.is_empty() {
            let three = ComparedValues {
                manual: Some(format!("{} bytes, index {}", record.octets, hex(record.index.into()))),
                gsdml: Some("no such record".into()),
                device: None,
            };
            let text =
                format!("The GSDML does not have the record {}, which the manual requires at start-up.", record.name);
            work.find(record.name.clone(), FindingSeverity::Error, text, three);
        }
        // Several modules of the manual may contain the submodule.
        for known in known {
            record_of(work, record, known);
        }
    }
    unknown(work, meant);
}

/// Whether a record is only for reading: the record that is written at start-up under the same index is another one.
fn is_only_read(device: &device::DeviceDescription, record: &device::DeviceRecord) -> bool {
    let is_written = |of: &device::DeviceRecord| of.start && (of.index, of.at) == (record.index, record.at);
    !record.start && device.records.iter().any(is_written)
}

fn record_of(work: &mut GsdmlComparison<'_>, record: &device::DeviceRecord, known: &GsdmlRecord) {
    let octets = |octets: usize| Some(format!("{octets} bytes"));
    let length = ComparedValues { manual: octets(record.octets), gsdml: octets(known.octets), device: None };
    let subject = format!("Record {}", record.name);
    work.differ(format!("{}.octets", record.name), FindingSeverity::Error, &subject, length);
    for field in record.fields.iter().filter(|field| field.origin == Origin::Manual && !field.text) {
        let name = format!("{}.{}", record.name, field.name);
        let default = field.default.get(work.variant).copied();
        let read = number_in(&known.default, field);
        if let Some(default) = default {
            let text = |number: i128| match field.words.iter().find(|(_, known)| *known == number) {
                Some((word, _)) => format!("{word} ({number})"),
                None => number.to_string(),
            };
            let three = ComparedValues { manual: Some(text(default)), gsdml: read.map(text), device: None };
            work.differ(format!("{name}.default"), FindingSeverity::Error, &format!("Default of {name}"), three);
        }
        let Some(item) = known.items.iter().find(|item| is_place_of(item, field)) else { continue };
        let lowest = item.allowed.iter().map(|range| *range.start()).min();
        let highest = item.allowed.iter().map(|range| *range.end()).max();
        for (word, manual, gsdml) in [("lowest", field.range.0, lowest), ("highest", field.range.1, highest)] {
            if let (Some(manual), Some(gsdml)) = (manual, gsdml) {
                let three =
                    ComparedValues { manual: Some(manual.to_string()), gsdml: Some(gsdml.to_string()), device: None };
                let subject = format!("The {word} {name}");
                work.differ(format!("{name}.{word}"), FindingSeverity::Warning, &subject, three);
            }
        }
    }
}

/// Reports start-up records of the meant submodules that the manual does not have.
fn unknown(work: &mut GsdmlComparison<'_>, meant: &MeantSubmodules<'_>) {
    let device = work.device;
    let of = |index: &usize| device.submodules.get(*index);
    for (of, submodule) in meant.iter().filter_map(|(index, known)| Some((of(index)?, known))) {
        for known in &submodule.records {
            let is_known = device.records.iter().any(|record| u32::from(record.index) == known.index);
            if !is_known {
                let three = ComparedValues {
                    manual: Some("no such record".into()),
                    gsdml: Some(format!("{}, {} bytes", quoted(&known.name), known.octets)),
                    device: None,
                };
                let (slot, subslot, index) = (of.slot, of.subslot, hex(known.index));
                let text = format!("The manual does not have the record {index} of slot {slot}, subslot {subslot}.");
                work.find(format!("record_{}", index.to_lowercase()), FindingSeverity::Info, text, three);
            }
        }
    }
}

/// The number of a field in these bytes; `None` if they are too short.
fn number_in(octets: &[u8], field: &RecordField) -> Option<i128> {
    let place = octets.get(field.octet..field.octet.checked_add(field.octets)?)?;
    let number = place.iter().fold(0u128, |number, octet| (number << 8) | u128::from(*octet));
    let (low, width) = field.bits.unwrap_or((0, field.octets as u32 * 8));
    let mask = if width >= 128 { u128::MAX } else { (1 << width) - 1 };
    i128::try_from((number >> low.min(127)) & mask).ok()
}
