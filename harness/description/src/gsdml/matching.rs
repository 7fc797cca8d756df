//! Finds the modules and submodules of a GSDML that can be in a slot and subslot, and those that a manual means.

use super::identity::ReportedIdentity;
use super::model::{AccessPoint, Gsdml, GsdmlSubmodule, ModuleInfo, PluggableItem};
use super::names::{likeness, same_numbers};
use std::ops::RangeInclusive;
use suite::device::{self, DeviceDescription, Origin};

/// A module in a slot; the access point counts as a module.
#[derive(Clone, Copy)]
pub(super) struct SlottedModule<'g> {
    pub gsdml: &'g Gsdml,
    pub id: &'g str,
    pub info: &'g ModuleInfo,
    pub ident: u32,
    pub submodules: &'g [GsdmlSubmodule],
    pub pluggable: &'g [PluggableItem],
}

/// The module of a GSDML for a module of a manual in a slot.
pub(super) enum ModuleMatch<'g> {
    /// No module of that slot fits.
    None,
    /// Several fit equally well.
    Several,
    /// This module, with the result for each submodule (by its index) of the manual's module.
    One(SlottedModule<'g>, Vec<(usize, SubmoduleMatch<'g>)>),
}

/// The submodule of a GSDML for a submodule of a manual.
#[derive(Clone, Copy)]
pub(super) enum SubmoduleMatch<'g> {
    /// No submodule of that subslot fits.
    None,
    /// Several fit equally well.
    Several,
    One(&'g GsdmlSubmodule),
}

pub(super) fn holds(ranges: &[RangeInclusive<u16>], number: u16) -> bool {
    ranges.iter().any(|range| range.contains(&number))
}

/// The access points that the device can have: the reported one, else those with a name like the variant, else all.
pub(super) fn access_points<'g>(
    gsdml: &'g Gsdml,
    variant: &str,
    says: Option<&ReportedIdentity>,
) -> Vec<&'g AccessPoint> {
    let all = || gsdml.access_points.iter();
    let said = |point: &&AccessPoint| {
        let of_slot = says.and_then(|says| says.plugged.iter().find(|of| of.slot == point.slot));
        of_slot.is_some_and(|plugged| plugged.module_ident == point.ident)
    };
    let best = called_like(gsdml, variant);
    let called = |point: &&AccessPoint| best.is_some_and(|best| likeness_of(point, variant) == best);
    let found: Vec<&AccessPoint> = all().filter(said).collect();
    if !found.is_empty() {
        return found;
    }
    let found: Vec<&AccessPoint> = all().filter(called).collect();
    if found.is_empty() { all().collect() } else { found }
}

/// How well the names of an access point fit a variant.
fn likeness_of(point: &AccessPoint, variant: &str) -> u32 {
    likeness(variant, &[&point.info.name, &point.info.order_number])
}

/// How well the best fitting access point fits a variant by its name; `None` if none has the numbers of the variant, or a word of it if
/// it has no numbers.
///
/// Variants of a family may share their numbers, as `afs60` and `afm60`; then their words decide.
pub(super) fn called_like(gsdml: &Gsdml, variant: &str) -> Option<u32> {
    gsdml.access_points.iter().map(|point| likeness_of(point, variant)).max().filter(|likeness| *likeness > 0)
}

/// The submodule of an access point in the subslot of a submodule of slot 0.
pub(super) fn in_access_point<'g>(point: &'g AccessPoint, of: &device::DeviceSubmodule) -> Option<&'g GsdmlSubmodule> {
    point.submodules.iter().find(|known| holds(&known.subslots, of.subslot))
}

/// The modules that can be in a slot.
pub(super) fn in_slot<'g>(gsdml: &'g Gsdml, point: &'g AccessPoint, slot: u16) -> Vec<SlottedModule<'g>> {
    if slot == point.slot {
        let AccessPoint { id, info, ident, submodules, pluggable, .. } = point;
        return vec![SlottedModule { gsdml, id, info, ident: *ident, submodules, pluggable }];
    }
    let offered = point.modules.iter().filter(|offered| holds(&offered.places, slot));
    let modules = offered.filter_map(|offered| gsdml.modules.get(offered.index));
    modules
        .map(|of| SlottedModule {
            gsdml,
            id: &of.id,
            info: &of.info,
            ident: of.ident,
            submodules: &of.submodules,
            pluggable: &of.pluggable,
        })
        .collect()
}

impl<'g> SlottedModule<'g> {
    /// The submodules that can be in a subslot.
    pub(super) fn in_subslot(&self, subslot: u16) -> Vec<&'g GsdmlSubmodule> {
        let built_in = self.submodules.iter().filter(|of| holds(&of.subslots, subslot));
        let plugged = self.pluggable.iter().filter(|of| holds(&of.places, subslot));
        built_in.chain(plugged.filter_map(|of| self.gsdml.submodules.get(of.index))).collect()
    }

    /// The submodule here for a submodule of the manual, and how well it fits.
    fn find(&self, of: &device::DeviceSubmodule) -> (SubmoduleMatch<'g>, u32) {
        let fits = self.in_subslot(of.subslot).into_iter().filter_map(|known| Some((known, fit(of, known)?)));
        let mut best: (SubmoduleMatch<'g>, u32) = (SubmoduleMatch::None, 0);
        for (known, fit) in fits {
            match best.0 {
                SubmoduleMatch::One(other) if fit == best.1 && other.ident != known.ident => {
                    best.0 = SubmoduleMatch::Several
                }
                SubmoduleMatch::Several | SubmoduleMatch::One(_) if fit <= best.1 => {}
                _ => best = (SubmoduleMatch::One(known), fit),
            }
        }
        best
    }
}

/// The bytes of input and output data; `None` if the length of a type is unknown.
pub(super) fn lengths(submodule: &GsdmlSubmodule) -> (Option<u16>, Option<u16>) {
    let sum =
        |items: &[super::DataItem]| items.iter().try_fold(0u16, |sum, item| Some(sum.saturating_add(item.octets?)));
    (sum(&submodule.inputs), sum(&submodule.outputs))
}

/// How well a submodule of the GSDML fits one of the manual; `None` if it does not.
fn fit(of: &device::DeviceSubmodule, known: &GsdmlSubmodule) -> Option<u32> {
    let called = [known.id.as_str(), known.info.name.as_str()];
    let same_ident = of.ident_origin == Origin::Manual && of.ident == known.ident;
    let same_lengths = lengths(known) == (Some(of.input_octets), Some(of.output_octets));
    let same_api = of.api == known.api;
    let numbers = same_numbers(&of.name, &called);
    if !(same_ident || numbers || (same_lengths && same_api)) {
        return None;
    }
    let points = |holds: bool, points: u32| if holds { points } else { 0 };
    let likeness = likeness(&of.name, &called).min(99);
    Some(points(same_ident, 1000) + points(same_lengths, 200) + points(same_api, 100) + likeness)
}

/// The slots of a module of the manual, with the indices of its submodules in each.
pub(super) fn slots(device: &DeviceDescription, module: usize) -> Vec<(u16, Vec<usize>)> {
    let mut slots: Vec<(u16, Vec<usize>)> = Vec::new();
    for &index in device.modules.get(module).map_or(&[][..], |module| &module.submodules) {
        let Some(slot) = device.submodules.get(index).map(|of| of.slot) else { continue };
        match slots.iter_mut().find(|(known, _)| *known == slot) {
            Some((_, indices)) => indices.push(index),
            None => slots.push((slot, vec![index])),
        }
    }
    slots
}

/// The ident of the module in a slot, if the manual prints it.
pub(super) fn printed_module_ident(
    device: &DeviceDescription,
    variant: usize,
    module: usize,
    submodules: &[usize],
) -> Option<u32> {
    let of_module =
        device.modules.get(module).filter(|of| of.ident_origin == Origin::Manual).and_then(device::DeviceModule::ident);
    let own = submodules.iter().filter_map(|&index| device.submodules.get(index)).find_map(|of| {
        let ident = of.module_ident(variant)?;
        Some((of.ident_origin == Origin::Manual).then_some(ident))
    });
    own.unwrap_or(of_module)
}

/// The module in a slot for a module of the manual. If several fit equally well, the one that the device has plugged is used, else the
/// one with a name like the variant.
pub(super) fn find<'g>(
    gsdml: &'g Gsdml,
    point: &'g AccessPoint,
    device: &DeviceDescription,
    (module, slot, submodules): (usize, u16, &[usize]),
    variant: &str,
    says: Option<&ReportedIdentity>,
) -> ModuleMatch<'g> {
    let plugged = says.and_then(|says| says.plugged.iter().find(|of| of.slot == slot)).map(|of| of.module_ident);
    let number = device.variants.iter().position(|known| known == variant).unwrap_or_default();
    let printed = printed_module_ident(device, number, module, submodules);
    let called = device.modules.get(module).map_or("", |of| &of.name);
    let expected: Vec<(usize, &device::DeviceSubmodule)> =
        submodules.iter().filter_map(|&index| Some((index, device.submodules.get(index)?))).collect();
    let mut best: Option<(ModuleRank, ModuleMatch<'g>)> = None;
    for slotted in in_slot(gsdml, point, slot) {
        let found: Vec<(usize, (SubmoduleMatch<'g>, u32))> =
            expected.iter().map(|(index, of)| (*index, slotted.find(of))).collect();
        let fitting = found.iter().filter(|(_, (found, _))| !matches!(found, SubmoduleMatch::None)).count();
        if fitting == 0 && printed != Some(slotted.ident) {
            continue;
        }
        let ModuleInfo { name, order_number, .. } = slotted.info;
        let rank = ModuleRank {
            printed: printed == Some(slotted.ident),
            fitting,
            exact: slotted.submodules.len() == expected.len(),
            fit: found.iter().map(|(_, (_, fit))| fit).sum::<u32>() + likeness(called, &[slotted.id, name]).min(99),
            plugged: plugged == Some(slotted.ident),
            variant: likeness(variant, &[name, order_number]),
        };
        let one = || ModuleMatch::One(slotted, found.iter().map(|(index, (found, _))| (*index, *found)).collect());
        best = match best.take() {
            Some((known, found)) if rank < known => Some((known, found)),
            Some((known, ModuleMatch::One(other, found))) if rank == known && other.ident == slotted.ident => {
                Some((known, ModuleMatch::One(other, found)))
            }
            Some((known, ModuleMatch::One(..))) if rank == known => Some((known, ModuleMatch::Several)),
            Some((known, found)) if rank == known => Some((known, found)),
            _ => Some((rank, one())),
        };
    }
    best.map_or(ModuleMatch::None, |(_, found)| found)
}

/// How well a module fits, by criteria of decreasing weight.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct ModuleRank {
    printed: bool,
    fitting: usize,
    /// Whether it has as many built-in submodules as the manual's module has submodules.
    exact: bool,
    fit: u32,
    plugged: bool,
    variant: u32,
}
