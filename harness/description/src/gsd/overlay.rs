//! Puts what no manual prints into the description of a slave: its ident number, the identifiers of its modules, and that the
//! user octets lie where the GSD has them.

use super::compare::{before_the_fields, is_at};
use super::model::Gsd;
use crate::gsdml::Overlay;
use plain_text::hex;
use suite::device::{Device, Origin};
use wire::profibus::cfg::{Identifier, sums};

/// Replaces the ident number and the identifiers that `device.yaml` marks as invented by those of a GSD, and marks them as taken
/// from a description; the layout of the user octets is marked so where the GSD has each of its fields at the same place.
///
/// Nothing that the manual prints is touched. A GSD with several modules of the same lengths gives none of them.
pub fn overlay(device: &mut Device, gsd: Option<&Gsd>) -> Overlay {
    let mut done = Overlay::default();
    if let Some(slave) = device.bus.profibus_mut().filter(|slave| slave.ident_origin == Origin::Invented) {
        match gsd {
            Some(gsd) => {
                (slave.ident, slave.ident_origin) = (gsd.ident, Origin::Description);
                done.taken.push(format!("the ident number is 0x{:04X}, as the GSD says", gsd.ident));
            }
            None => done.missing.push("the ident number: no GSD says it".into()),
        }
    }
    modules(device, gsd, &mut done);
    user_octets(device, gsd, &mut done);
    done
}

fn modules(device: &mut Device, gsd: Option<&Gsd>, done: &mut Overlay) {
    for index in 0..device.modules.len() {
        let module = &device.modules[index];
        if module.ident_origin != Origin::Invented {
            continue;
        }
        let lengths = |cfg: &[u8]| {
            let sums = sums(&Identifier::parse_all(cfg).ok()?);
            Some((sums.outputs, sums.inputs))
        };
        let wanted = lengths(module.cfg());
        let fitting: Vec<_> = gsd
            .into_iter()
            .flat_map(|gsd| &gsd.modules)
            .filter(|known| wanted.is_some() && lengths(&known.cfg) == wanted)
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
                done.taken.push(format!("the identifiers of {name} are {}, as the GSD says", hex(&only.cfg)));
            }
            [] => done.missing.push(format!("the identifiers of {name}: no module of a GSD has its lengths")),
            _ => done.missing.push(format!("the identifiers of {name}: several modules of the GSD have its lengths")),
        }
    }
}

fn user_octets(device: &mut Device, gsd: Option<&Gsd>, done: &mut Overlay) {
    let Some(slave) = device.profibus() else { return };
    let before = before_the_fields(slave);
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
        done.taken.push("the user octets of Set_Prm have their fields where the GSD has fields, too".into());
    } else {
        done.missing.push("the user octets of Set_Prm: no GSD has all their fields at the same places".into());
    }
}
