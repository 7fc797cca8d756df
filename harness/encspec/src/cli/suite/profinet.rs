//! The `device.yaml` of a device on PROFINET, from its GSDML.

use super::Suite;
use super::names::{FreshNames, slug};
use super::signals::{CyclicItem, ItemForm, Signals};
use super::topics;
use description::gsdml::{AccessPoint, DataItem, Gsdml, GsdmlModule, GsdmlSubmodule, PluggableItem, SubmoduleKind};
use std::ops::RangeInclusive;

/// A submodule of the suite.
pub(super) struct NewSubmodule<'g> {
    pub name: String,
    pub of: &'g GsdmlSubmodule,
    pub slot: u16,
    pub subslot: u16,
    pub module_ident: Option<u32>,
    pub outputs: Vec<String>,
    pub inputs: Vec<String>,
}

/// What one connection consists of.
pub(super) struct NewModule {
    pub name: String,
    pub ident: u32,
    /// Its submodules, as indices.
    pub submodules: Vec<usize>,
}

/// A submodule of a description at its slot and subslot, with the ident of its module.
#[derive(Clone, Copy)]
struct SlottedSubmodule<'g> {
    of: &'g GsdmlSubmodule,
    slot: u16,
    subslot: u16,
    ident: u32,
}

/// What is known while the suite is made.
#[derive(Default)]
pub(super) struct Writer<'g> {
    pub names: FreshNames,
    /// Submodules and modules are named apart from what stands in expressions.
    pub of_submodules: FreshNames,
    pub of_modules: FreshNames,
    pub signals: Signals,
    pub submodules: Vec<NewSubmodule<'g>>,
    pub modules: Vec<NewModule>,
    pub remarks: Vec<String>,
}

/// The suite of the device that an access point of a GSDML describes.
pub(super) fn suite(gsdml: &Gsdml, point: &AccessPoint, folder: &str) -> Result<Suite, String> {
    let mut writer = Writer::default();
    for name in ["vendor", "im0", "im1"] {
        writer.names.new_name(name, name);
    }
    let variant = slug(&point.info.name, "variant");
    let network = network(point);
    let always = writer.access_point(gsdml, point)?;
    writer.modules(gsdml, point, &always);
    if writer.modules.is_empty() {
        let with_data = always.clone();
        writer.modules.push(NewModule {
            name: writer.of_modules.new_name(&point.info.name, "device"),
            ident: point.ident,
            submodules: with_data,
        });
    }
    let has_im1 = point.submodules.iter().any(|of| of.writable_im.contains(&1));
    let device = writer.text(gsdml, point, &variant, &network, folder, has_im1);
    let length = |module: &NewModule, of: fn(&NewSubmodule<'_>) -> usize| -> usize {
        module.submodules.iter().filter_map(|&at| writer.submodules.get(at)).map(of).sum()
    };
    let outputs = |module: &&NewModule| length(module, |of| of.outputs.len()) > 0;
    let inputs = |module: &&NewModule| length(module, |of| of.inputs.len()) > 0;
    let both = |module: &&NewModule| outputs(module) && inputs(module);
    let main =
        writer.modules.iter().find(both).or_else(|| writer.modules.iter().find(inputs)).or(writer.modules.first());
    let Some(main) = main else { return Err("the GSDML has no module to connect".to_owned()) };
    let longest = main.submodules.iter().filter_map(|&at| writer.submodules.get(at));
    let longest = longest.max_by_key(|of| of.outputs.len() + of.inputs.len());
    let facts = topics::ConnectedModule {
        module: &main.name,
        longest: longest.map_or("dap", |of| &of.name),
        has_both: both(&main),
        has_im1,
    };
    let mut files = vec![("device.yaml".to_owned(), device)];
    files.extend(topics::profinet(&facts)?);
    Ok(Suite { files, decisions: writer.remarks })
}

/// Interface and ports: subslots and idents.
fn network(point: &AccessPoint) -> Vec<(u16, u32)> {
    let of = point.submodules.iter().filter(|of| matches!(of.kind, SubmoduleKind::Interface | SubmoduleKind::Port));
    let at = |of: &GsdmlSubmodule| Some((*of.subslots.first()?.start(), of.ident));
    of.filter_map(at).filter(|(subslot, _)| (0x8000..=0x8FFF).contains(subslot)).collect()
}

/// The first place where an item always is, is by default, or can be.
fn usual_place(offered: &PluggableItem) -> Option<u16> {
    let lists: [&[RangeInclusive<u16>]; 3] = [&offered.fixed, &offered.used, &offered.places];
    lists.into_iter().find_map(|list| list.first()).map(|range| *range.start())
}

impl<'g> Writer<'g> {
    /// The submodules of the access point that are in every connection, as indices.
    fn access_point(&mut self, gsdml: &'g Gsdml, point: &'g AccessPoint) -> Result<Vec<usize>, String> {
        if point.slot != 0 {
            return Err(format!("the access point {} is in slot {}; a suite has it in slot 0", point.id, point.slot));
        }
        let built_in = point.submodules.iter().filter(|of| of.kind == SubmoduleKind::Virtual);
        let mut places: Vec<SlottedSubmodule<'g>> = built_in.filter_map(|of| at(of, 0, point.ident)).collect();
        for offered in point.pluggable.iter().filter(|offered| !offered.fixed.is_empty()) {
            let of = gsdml.submodules.get(offered.index).zip(usual_place(offered));
            places.extend(of.map(|(of, subslot)| SlottedSubmodule { of, slot: 0, subslot, ident: point.ident }));
        }
        let all: Vec<usize> = places.into_iter().filter_map(|place| self.submodule(place, point.ident)).collect();
        let has_data =
            |at: &usize| self.submodules.get(*at).is_some_and(|of| !of.outputs.is_empty() || !of.inputs.is_empty());
        Ok(all.into_iter().filter(has_data).collect())
    }

    /// A connection for each module, and for each of the submodules that can be plugged into it in turn.
    fn modules(&mut self, gsdml: &'g Gsdml, point: &'g AccessPoint, always: &[usize]) {
        let offered: Vec<(&PluggableItem, &GsdmlModule, u16)> = point
            .modules
            .iter()
            .filter_map(|of| Some((of, gsdml.modules.get(of.index)?, usual_place(of)?)))
            .filter(|(.., slot)| *slot != 0)
            .collect();
        let mut connected: Vec<Vec<(*const GsdmlSubmodule, u16, u16)>> = Vec::new();
        for (_, module, slot) in &offered {
            // What is fixed in other slots is in every connection.
            let beside: Vec<SlottedSubmodule<'g>> = offered
                .iter()
                .filter(|(of, _, other)| !of.fixed.is_empty() && other != slot)
                .flat_map(|(_, module, slot)| first_parts(gsdml, module, *slot))
                .collect();
            let (built_in, turns) = parts(gsdml, module, *slot);
            let turns = if turns.is_empty() { vec![(Vec::new(), None)] } else { turns };
            for (plugged, called) in turns {
                let places: Vec<&SlottedSubmodule<'g>> = built_in.iter().chain(&plugged).chain(&beside).collect();
                let mut key: Vec<(*const GsdmlSubmodule, u16, u16)> =
                    places.iter().map(|place| (std::ptr::from_ref(place.of), place.slot, place.subslot)).collect();
                key.sort_unstable();
                if connected.contains(&key) {
                    continue;
                }
                connected.push(key);
                let mut submodules = always.to_vec();
                let before = submodules.len();
                submodules.extend(places.into_iter().filter_map(|place| self.submodule(*place, module.ident)));
                if submodules.len() == before {
                    self.remarks
                        .push(format!("the module `{}` has no submodule that can be connected", module.info.name));
                    continue;
                }
                let name = self.of_modules.new_name(called.unwrap_or(&module.info.name), "module");
                self.modules.push(NewModule { name, ident: module.ident, submodules });
            }
        }
        let mut free = offered.iter().filter(|(of, ..)| of.fixed.is_empty()).map(|(.., slot)| *slot);
        let first = free.next();
        if free.any(|slot| Some(slot) != first) {
            self.remarks.push(
                "the device takes modules in several slots: combine them to what you connect, under `modules`"
                    .to_owned(),
            );
        }
    }

    /// The index of a submodule in a connection whose module has the ident `ident`; none if its data cannot be written.
    fn submodule(&mut self, place: SlottedSubmodule<'g>, ident: u32) -> Option<usize> {
        let SlottedSubmodule { of, slot, subslot, .. } = place;
        let module_ident = (slot == 0 || place.ident != ident).then_some(place.ident);
        let is_same = |known: &NewSubmodule<'_>| {
            std::ptr::eq(known.of, of)
                && (known.slot, known.subslot, known.module_ident) == (slot, subslot, module_ident)
        };
        if let Some(known) = self.submodules.iter().position(is_same) {
            return Some(known);
        }
        let (Some(outputs), Some(inputs)) = (items(&of.outputs), items(&of.inputs)) else {
            self.remarks.push(format!("the submodule `{}` has data of unknown length and is left out", of.info.name));
            return None;
        };
        let is_dap = slot == 0 && self.submodules.is_empty();
        let called = if is_dap { "dap" } else { of.info.name.as_str() };
        let called = if called.is_empty() { of.id.as_str() } else { called };
        let name = self.of_submodules.new_name(called, "submodule");
        let outputs = self.signals.of(&outputs, true, &mut self.names);
        let inputs = self.signals.of(&inputs, false, &mut self.names);
        self.submodules.push(NewSubmodule { name, of, slot, subslot, module_ident, outputs, inputs });
        Some(self.submodules.len() - 1)
    }
}

/// A built-in submodule at its first subslot.
fn at(of: &GsdmlSubmodule, slot: u16, ident: u32) -> Option<SlottedSubmodule<'_>> {
    let subslot = of.subslots.first().map_or(1, |range| *range.start());
    matches!(of.kind, SubmoduleKind::Virtual | SubmoduleKind::Pluggable).then_some(SlottedSubmodule {
        of,
        slot,
        subslot,
        ident,
    })
}

/// Submodules that are plugged together, and the name of the one that tells them from others.
type PluggedTogether<'g> = (Vec<SlottedSubmodule<'g>>, Option<&'g str>);

/// The submodules that a module always has, and those that can be plugged into it, in turn.
fn parts<'g>(
    gsdml: &'g Gsdml,
    module: &'g GsdmlModule,
    slot: u16,
) -> (Vec<SlottedSubmodule<'g>>, Vec<PluggedTogether<'g>>) {
    let ident = module.ident;
    let mut built_in: Vec<SlottedSubmodule<'g>> =
        module.submodules.iter().filter_map(|of| at(of, slot, ident)).collect();
    let mut by_subslot: Vec<(u16, Vec<(SlottedSubmodule<'g>, bool)>)> = Vec::new();
    for offered in &module.pluggable {
        let Some((of, subslot)) = gsdml.submodules.get(offered.index).zip(usual_place(offered)) else { continue };
        let place = SlottedSubmodule { of, slot, subslot, ident };
        if !offered.fixed.is_empty() {
            built_in.push(place);
            continue;
        }
        match by_subslot.iter_mut().find(|(known, _)| *known == subslot) {
            Some((_, list)) => list.push((place, !offered.used.is_empty())),
            None => by_subslot.push((subslot, vec![(place, !offered.used.is_empty())])),
        }
    }
    by_subslot.sort_by_key(|(_, list)| std::cmp::Reverse(list.len()));
    let Some(((_, varied), others)) = by_subslot.split_first() else { return (built_in, Vec::new()) };
    // In the other subslots is what an engineering tool puts there by default.
    let usual =
        others.iter().filter_map(|(_, list)| list.iter().find(|(_, is_used)| *is_used).map(|(place, _)| *place));
    let usual: Vec<SlottedSubmodule<'g>> = usual.collect();
    let turn = |(place, _): &(SlottedSubmodule<'g>, bool)| {
        (std::iter::once(*place).chain(usual.iter().copied()).collect(), Some(place.of.info.name.as_str()))
    };
    (built_in, varied.iter().map(turn).collect())
}

/// What a module has and, of what can be plugged into it in turn, the first.
fn first_parts<'g>(gsdml: &'g Gsdml, module: &'g GsdmlModule, slot: u16) -> Vec<SlottedSubmodule<'g>> {
    let (mut built_in, turns) = parts(gsdml, module, slot);
    built_in.extend(turns.into_iter().next().into_iter().flat_map(|(plugged, _)| plugged));
    built_in
}

/// The items of the cyclic data; none if the length of one is unknown.
fn items(of: &[DataItem]) -> Option<Vec<CyclicItem>> {
    let item = |item: &DataItem| {
        let form = match item.kind.as_str() {
            "Float32" | "Float64" => ItemForm::Float,
            "VisibleString" => ItemForm::Text,
            _ => ItemForm::Number,
        };
        Some(CyclicItem {
            form,
            called: item.name.clone(),
            octets: item.octets?,
            signed: item.kind.starts_with("Integer"),
            bits: item.bits.clone(),
            remark: None,
        })
    };
    of.iter().map(item).collect()
}
