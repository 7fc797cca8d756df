//! Adds values that no manual prints to the description of a slave: its ident number, the identifiers of its modules, and the
//! layout of the user bytes if the GSD has the same.

use super::compare::dpv1_length;
use super::model::{FieldType, Gsd, GsdField, GsdModule};
use crate::gsdml::Overlay;
use crate::record_match::RecordMatch;
use crate::start_parameters::DescribedParameter;
use plain_text::hex;
use std::time::Duration;
use suite::device::{DeviceDescription, Origin};
use wire::profibus::cfg::{Identifier, io_lengths};

/// The layout that this module takes over, in its sentences.
const USER_LAYOUT: &str = "the layout of the user bytes of Set_Prm";

/// The unit of Min_Slave_Intervall.
const MIN_SLAVE_INTERVAL_UNIT: Duration = Duration::from_micros(100);

/// Replaces the ident number and the identifiers that `device.yaml` marks as invented by those of a GSD, and marks them as taken from
/// a description. If no manual prints the layout of the user bytes, each of its parameters is found by its meaning; `confirmed` has pairs
/// of a parameter and its name in the GSD on which a person decided.
///
/// Polls are at least Min_Slave_Intervall apart. Values printed in the manual are not changed. If several modules of a GSD have the same lengths, none of them is used.
pub fn overlay(device: &mut DeviceDescription, gsd: Option<&Gsd>, confirmed: &[(String, String)]) -> Overlay {
    let mut done = Overlay::default();
    if let Some(slave) = device.bus.profibus_mut().filter(|slave| slave.ident_origin == Origin::Invented) {
        match gsd {
            Some(gsd) => {
                (slave.ident, slave.ident_origin) = (gsd.ident, Origin::Description);
                done.taken.push(format!("the ident number is 0x{:04X}, from the GSD", gsd.ident));
            }
            None => done.missing.push("the ident number: there is no GSD".into()),
        }
    }
    if let (Some(slave), Some(gsd)) = (device.bus.profibus_mut(), gsd) {
        slave.min_slave_interval = MIN_SLAVE_INTERVAL_UNIT * gsd.min_slave_interval;
    }
    modules(device, gsd, &mut done);
    user_octets(device, gsd, confirmed, &mut done);
    done
}

fn modules(device: &mut DeviceDescription, gsd: Option<&Gsd>, done: &mut Overlay) {
    for index in 0..device.modules.len() {
        let module = &device.modules[index];
        if module.ident_origin != Origin::Invented {
            continue;
        }
        let lengths = |cfg: &[u8]| {
            let sums = io_lengths(&Identifier::parse_all(cfg).ok()?);
            Some((sums.outputs, sums.inputs))
        };
        let expected = lengths(module.cfg());
        let fitting: Vec<_> = gsd
            .into_iter()
            .flat_map(|gsd| &gsd.modules)
            .filter(|known| expected.is_some() && lengths(&known.cfg) == expected)
            .collect();
        let name = module.name.clone();
        match fitting.as_slice() {
            [only] => {
                let module = &mut device.modules[index];
                module.take_cfg(&only.cfg);
                for &submodule in &module.submodules {
                    if let Some(submodule) = device.submodules.get_mut(submodule) {
                        submodule.ident_origin = Origin::Description;
                    }
                }
                done.taken.push(format!("the identifiers of {name} are {}, from the GSD", hex(&only.cfg)));
            }
            [] => done.missing.push(format!("the identifiers of {name}: no module of a GSD has the same lengths")),
            _ => done
                .missing
                .push(format!("the identifiers of {name}: several modules of the GSD have the same lengths")),
        }
    }
}

/// Takes over the layout of the user bytes if no manual prints it, by the meaning of the parameters; a printed one that the GSD
/// contradicts is in doubt.
fn user_octets(device: &mut DeviceDescription, gsd: Option<&Gsd>, confirmed: &[(String, String)], done: &mut Overlay) {
    let Some(slave) = device.profibus() else { return };
    let before = dpv1_length(slave);
    let cfgs: Vec<Vec<u8>> = device.modules.iter().map(|module| module.cfg().to_vec()).collect();
    let Some(record) = device.records.first_mut().filter(|record| !record.fields.is_empty()) else { return };
    let modules = gsd.into_iter().flat_map(|gsd| gsd.modules.iter().map(move |module| (gsd, module)));
    let mut layouts: Vec<UserLayout> = Vec::new();
    for (gsd, module) in modules.filter(|(_, module)| cfgs.contains(&module.cfg)) {
        let layout = UserLayout::of(gsd, module, before);
        if !layouts.contains(&layout) {
            layouts.push(layout);
        }
    }
    let is_printed = record.origin != Origin::Invented;
    let mut missing = |why: &str| done.missing.push(format!("{USER_LAYOUT}: {why}"));
    let layout = match layouts.pop() {
        Some(only) if layouts.is_empty() => only,
        _ if is_printed => return,
        None => return missing("no GSD has a module of this device"),
        Some(_) => return missing("it differs between the modules of the GSD"),
    };
    let found = RecordMatch::find(record, layout.parameters, confirmed);
    if is_printed {
        if let Some(contradictions) = found.contradictions(record) {
            record.origin = Origin::Invented;
            missing(&contradictions);
        }
        return;
    }
    done.parameters.extend(found.lines(record));
    match found.doubts(record) {
        Some(doubts) => missing(&doubts),
        None => {
            found.take_over(record, &layout.default);
            done.taken.push(format!("{USER_LAYOUT} is that of the GSD; its parameters were found by their names"));
        }
    }
}

/// The user bytes with one module of a GSD, after those of DP-V1.
#[derive(PartialEq)]
struct UserLayout {
    default: Vec<u8>,
    parameters: Vec<DescribedParameter>,
}

impl UserLayout {
    fn of(gsd: &Gsd, module: &GsdModule, before: usize) -> UserLayout {
        let default = gsd.default_octets(module);
        let fields = gsd.fields(module).filter(|(at, _)| *at >= before);
        UserLayout {
            default: default.get(before..).unwrap_or_default().to_vec(),
            parameters: fields.map(|(at, field)| parameter(at - before, field)).collect(),
        }
    }
}

/// A field of a GSD as a start parameter.
fn parameter(at: usize, field: &GsdField) -> DescribedParameter {
    let bits = match field.kind {
        FieldType::Octets { .. } => None,
        // A GSD may describe a field of a whole byte by its bits.
        FieldType::Bits { low: 0, high: 7 } => None,
        FieldType::Bits { low, high } => Some((low.into(), u32::from(high - low) + 1)),
    };
    DescribedParameter {
        names: vec![field.name.clone()],
        octet: at,
        octets: field.kind.octets(),
        bits,
        range: field.range.map(|(low, high)| (low.into(), high.into())),
        words: field.texts.iter().map(|(number, text)| ((*number).into(), vec![text.clone()])).collect(),
    }
}
