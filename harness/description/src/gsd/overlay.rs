//! Adds values that no manual prints to the description of a slave: its ident number, the identifiers of its modules, and the
//! layout of the user bytes if the GSD has the same.

use super::compare::{dpv1_length, is_at};
use super::model::Gsd;
use crate::gsdml::Overlay;
use plain_text::hex;
use suite::device::{DeviceDescription, Origin};
use wire::profibus::cfg::{Identifier, io_lengths};

/// Replaces the ident number and the identifiers that `device.yaml` marks as invented by those of a GSD, and marks them as taken from
/// a description. The layout of the user bytes is marked too, if the GSD has each of its fields at the same offset.
///
/// Values printed in the manual are not changed. If several modules of a GSD have the same lengths, none of them is used.
pub fn overlay(device: &mut DeviceDescription, gsd: Option<&Gsd>) -> Overlay {
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
    modules(device, gsd, &mut done);
    user_octets(device, gsd, &mut done);
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

fn user_octets(device: &mut DeviceDescription, gsd: Option<&Gsd>, done: &mut Overlay) {
    let Some(slave) = device.profibus() else { return };
    let before = dpv1_length(slave);
    let Some(record) = device.records.first_mut().filter(|record| record.origin == Origin::Invented) else { return };
    let has = |gsd: &Gsd| {
        let mut fields = record.fields.iter();
        fields.all(|field| {
            gsd.modules.iter().flat_map(|module| gsd.fields(module)).any(|(at, known)| is_at(field, before, at, known))
        })
    };
    if gsd.is_some_and(has) {
        record.origin = Origin::Description;
        record.fields.iter_mut().for_each(|field| field.origin = Origin::Description);
        done.taken.push("the layout of the user bytes of Set_Prm is that of the GSD".into());
    } else {
        done.missing.push("the layout of the user bytes of Set_Prm: no GSD has all fields at the same offsets".into());
    }
}
