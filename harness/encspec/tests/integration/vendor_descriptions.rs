//! A device whose vendor's GSDML or GSD has other idents, another order, and other places of start parameters than ours is tested as far
//! as the reference device: all it needs is found in the description.

use crate::built_in::{manuals, model};
use crate::on_two_threads::every;
use controllers::random::SplitMix64;
use deviations::{DescriptionChange, Place, StartLayout};
use encspec::engine::{RunOptions, run};
use encspec::gsd::{self, FieldType, Gsd};
use encspec::gsdml::{self, Bits, DataType, Gsdml, GsdmlRecord, GsdmlSubmodule, SubmoduleKind};
use encspec::suite::device::DeviceDescription;
use encspec::suite::model::{Manual, SuiteVariant};
use encspec::suite_yaml::load;
use encspec::verdict::Verdict;
use std::fmt::Write;
use std::sync::Arc;
use testing::DailySample;

/// How many descriptions there are of each device.
const DESCRIPTIONS: u64 = 200;
/// The bytes of DP-V1 before the user bytes of the A3M60.
const DPV1: usize = 3;

/// The variations that a description may have, for each seed others.
fn variations(manual: &Manual, seed: u64) -> Vec<String> {
    let subject = deviations::subject(&manual.device.name).expect("a reference device for every suite");
    let mut numbers = SplitMix64::new(seed);
    let mut names = Vec::new();
    // Number of ports and labels of web pages are no part of what a GSDML says of start parameters.
    let is_in_file = |name: &str| {
        let changes = subject.description_changes(std::iter::once(name));
        let is_other =
            |of: &DescriptionChange| matches!(of, DescriptionChange::Ports(_) | DescriptionChange::Label(..));
        !changes.is_empty() && !changes.iter().any(is_other)
    };
    for known in subject.permitted() {
        match known.name {
            "start-parameters-elsewhere" => names.push(format!("start-parameters-elsewhere:{seed}")),
            name if is_in_file(name) && numbers.bits().is_multiple_of(2) => names.push(name.to_owned()),
            _ => {}
        }
    }
    names
}

fn shuffle<T>(numbers: &mut SplitMix64, items: &mut [T]) {
    for last in (1..items.len()).rev() {
        items.swap(last, (numbers.bits() % (last as u64 + 1)) as usize);
    }
}

/// The same name as vendors may write it.
fn respell(numbers: &mut SplitMix64, name: &mut String) {
    match numbers.bits() % 4 {
        0 => *name = name.to_uppercase(),
        1 => *name = name.replace(' ', "_"),
        2 => name.push_str(" (parameter)"),
        _ => {}
    }
}

/// The place of a parameter in another layout; `None` if it is not among those that moved.
fn moved(layout: &StartLayout, own: Place) -> Option<Place> {
    layout.places.iter().find(|(known, _)| *known == own).map(|(_, other)| *other)
}

/// Moves the parameters of a record to where `layout` has them.
fn move_items(numbers: &mut SplitMix64, record: &mut GsdmlRecord, layout: &StartLayout) {
    record.octets = layout.default.len();
    record.default.clone_from(&layout.default);
    for item in &mut record.items {
        let own = match (&item.kind, item.bits) {
            (DataType::Whole { octets, .. }, _) => Place::Bytes(item.octet, (*octets).into()),
            (_, Some(bits)) => Place::Bit(item.octet, bits.low),
            _ => panic!("{} is no number", item.name),
        };
        match moved(layout, own).unwrap_or_else(|| panic!("{} stays where it is", item.name)) {
            Place::Bytes(octet, _) => item.octet = octet,
            Place::Bit(octet, low) => (item.octet, item.bits) = (octet, Some(Bits { low, width: 1 })),
        }
        respell(numbers, &mut item.name);
    }
    shuffle(numbers, &mut record.items);
}

fn change_gsdml(gsdml: &mut Gsdml, change: &DescriptionChange, numbers: &mut SplitMix64) {
    match change {
        DescriptionChange::Idents(mask) => {
            for module in &mut gsdml.modules {
                module.ident ^= mask.module;
                module.submodules.iter_mut().for_each(|submodule| submodule.ident ^= mask.submodule);
            }
            gsdml.submodules.iter_mut().for_each(|submodule| submodule.ident ^= mask.submodule);
            let of_points = gsdml.access_points.iter_mut().flat_map(|point| &mut point.submodules);
            let network = of_points.filter(|of| matches!(of.kind, SubmoduleKind::Interface | SubmoduleKind::Port));
            network.for_each(|submodule| submodule.ident ^= mask.network);
        }
        DescriptionChange::DeviceId(id) => gsdml.device_id = *id,
        DescriptionChange::StartParameters(layout) => {
            let of_modules = gsdml.modules.iter_mut().flat_map(|module| &mut module.submodules);
            let records = of_modules.chain(&mut gsdml.submodules).flat_map(|submodule| &mut submodule.records);
            records.filter(|record| record.index == 0x1000).for_each(|record| move_items(numbers, record, layout));
        }
        DescriptionChange::StartRecords(records) => {
            for record in *records {
                let is_there =
                    |of: &&mut GsdmlSubmodule| of.subslots.iter().any(|range| range.contains(&record.subslot));
                let of_modules = gsdml.modules.iter_mut().flat_map(|module| &mut module.submodules);
                let of_points = gsdml.access_points.iter_mut().flat_map(|point| &mut point.submodules);
                let found: Vec<&mut GsdmlSubmodule> = match record.slot {
                    0 => of_points.filter(is_there).collect(),
                    _ => of_modules.filter(is_there).collect(),
                };
                for submodule in found {
                    submodule.records.push(GsdmlRecord {
                        name: "Vendor settings".into(),
                        index: record.index.into(),
                        octets: record.default.len(),
                        transfer_sequence: 0,
                        default: record.default.to_vec(),
                        items: Vec::new(),
                    });
                }
            }
        }
        DescriptionChange::Ports(_) | DescriptionChange::Label(..) => panic!("{change:?} is not in a GSDML"),
    }
}

/// Moves the parameters of Set_Prm to where `layout` has them.
fn move_fields(gsd: &mut Gsd, layout: &StartLayout, numbers: &mut SplitMix64) {
    let head: Vec<u8> =
        gsd.parameters.constants.iter().flat_map(|(_, octets)| octets.iter().take(DPV1)).copied().collect();
    gsd.parameters.octets = DPV1 + layout.default.len();
    let mut octets = head;
    octets.resize(DPV1, 0);
    octets.extend(&layout.default);
    gsd.parameters.constants = vec![(0, octets)];
    for (at, field) in &mut gsd.parameters.fields {
        let own = match field.kind {
            FieldType::Bits { low, .. } => Place::Bit(*at - DPV1, low.into()),
            ref kind => Place::Bytes(*at - DPV1, kind.octets()),
        };
        match moved(layout, own).unwrap_or_else(|| panic!("{} stays where it is", field.name)) {
            Place::Bytes(octet, _) => *at = octet + DPV1,
            Place::Bit(octet, bit) => {
                let bit = bit as u8;
                (*at, field.kind) = (octet + DPV1, FieldType::Bits { low: bit, high: bit });
            }
        }
        respell(numbers, &mut field.name);
    }
    shuffle(numbers, &mut gsd.parameters.fields);
}

/// Takes over the description that the vendor of the varied device would give with it; what is missing in it.
fn describe(device: &mut DeviceDescription, variant: &SuiteVariant, names: &[String], seed: u64) -> Vec<String> {
    let subject = deviations::subject(&device.name).expect("a reference device for every suite");
    let changes = subject.description_changes(names.iter().map(String::as_str));
    let numbers = &mut SplitMix64::new(!seed);
    let index = device.variants.iter().position(|of| *of == variant.name).expect("a variant of the manual");
    if device.profibus().is_none() {
        let (_, mut gsdml) = suites::gsdml_for(&device.name, &variant.name).expect("a GSDML");
        changes.iter().for_each(|change| change_gsdml(&mut gsdml, change, numbers));
        gsdml.access_points.iter_mut().for_each(|point| shuffle(numbers, &mut point.modules));
        gsdml.modules.iter_mut().for_each(|module| shuffle(numbers, &mut module.pluggable));
        gsdml::overlay(device, index, Some(&gsdml), None, &[]).missing
    } else {
        let of_manual = |path: &str| path.split('/').any(|part| part == device.name);
        let (_, text) = suites::gsd().iter().find(|(path, _)| of_manual(path)).expect("a GSD");
        let mut gsd = gsd::read(text).expect("it is read");
        for change in &changes {
            let DescriptionChange::StartParameters(layout) = change else { panic!("{change:?} is not in a GSD") };
            move_fields(&mut gsd, layout, numbers);
        }
        gsd::overlay(device, Some(&gsd), &[]).missing
    }
}

/// What is not tested, or not right, with the description of this seed; `None` if everything is.
fn failures(name: &str, at: usize, seed: u64) -> Option<String> {
    let mut all = load(&suites::sources(), None).unwrap_or_else(|errors| panic!("{errors}"));
    let manual = all.iter_mut().find(|of| of.device.name == name).expect("a built-in manual");
    let names = variations(manual, seed);
    let variant = &manual.variants[at];
    let device = Arc::get_mut(&mut manual.device).expect("it is used by nothing else");
    let mut failed = String::new();
    for missing in describe(device, variant, &names, seed) {
        let _ = writeln!(failed, "{name}/{} {seed}: {missing}", variant.name);
    }
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let duts = vec![model(manual, variant, &names)];
    let options = RunOptions { duts, threads: 1, ..RunOptions::default() };
    let result = run(std::slice::from_ref(manual), &options, &|_, _, _| {}).expect("a model can be run");
    for case in result.runs.iter().flat_map(|run| &run.cases).filter(|case| case.verdict != Verdict::Pass) {
        let _ = writeln!(failed, "{} {seed}: {} {} ({names:?})", manual.variants[at].name, case.verdict, case.id);
    }
    (!failed.is_empty()).then_some(failed)
}

#[test]
fn a_device_is_tested_in_full_by_the_description_of_its_vendor() {
    let devices = manuals().iter().filter(|manual| manual.device.name != "profinet-io");
    let each = devices.flat_map(|of| (0..of.variants.len()).map(move |at| (of.device.name.as_str(), at)));
    let each = each.flat_map(|(name, at)| (0..DESCRIPTIONS).map(move |seed| (name, at, seed)));
    let sample = DailySample::one_of(200);
    let failed = every(&sample.items(each), |(name, at, seed)| failures(name, *at, *seed)).concat();
    assert!(failed.is_empty(), "{sample}: not all is tested:\n{failed}");
}
