//! Start parameters whose place no manual prints are found in a GSDML or GSD by their meaning, wherever the vendor put them; where the
//! meaning is another, nothing is sent without a decision.

use crate::built_in::manual;
use controllers::random::SplitMix64;
use encspec::gsd::{self, FieldType, Gsd};
use encspec::gsdml::{self, Bits, DataType, Gsdml, GsdmlRecord, Overlay};
use encspec::suite::device::{DeviceDescription, DeviceRecord, Origin};

/// How many descriptions have another layout, and how many another meaning.
const LAYOUTS: u64 = 200;
const MEANINGS: u64 = 50;
/// The bytes of DP-V1 before the user bytes of the A3M60.
const DPV1: usize = 3;

/// A number below `limit`.
fn below(numbers: &mut SplitMix64, limit: usize) -> usize {
    (numbers.bits() % limit as u64) as usize
}

fn shuffle<T>(numbers: &mut SplitMix64, items: &mut [T]) {
    for last in (1..items.len()).rev() {
        items.swap(last, below(numbers, last + 1));
    }
}

/// The same name as vendors may write it.
fn spelt(numbers: &mut SplitMix64, name: &str) -> String {
    match below(numbers, 4) {
        0 => name.to_uppercase(),
        1 => name.replace(' ', "_"),
        2 => format!("{name} (parameter)"),
        _ => name.to_owned(),
    }
}

/// The record of vendor-specific start parameters of the AFx60.
fn vendor_record(device: &DeviceDescription) -> &DeviceRecord {
    device.records.iter().find(|record| record.name == "vendor_settings").expect("the AFx60 has it")
}

fn each_vendor_record(gsdml: &mut Gsdml, mut change: impl FnMut(&mut GsdmlRecord)) {
    let of_modules = gsdml.modules.iter_mut().flat_map(|module| &mut module.submodules);
    let submodules = of_modules.chain(&mut gsdml.submodules);
    let records = submodules.flat_map(|submodule| &mut submodule.records);
    records.filter(|record| record.index == 0x1000).for_each(&mut change);
}

/// Puts the parameters in another order, with gaps and a parameter that the manual does not have.
fn lay_out(numbers: &mut SplitMix64, record: &mut GsdmlRecord) {
    let mut extra = record.items[below(numbers, record.items.len())].clone();
    extra.name = "Bus topology".into();
    record.items.push(extra);
    shuffle(numbers, &mut record.items);
    let mut at = below(numbers, 4);
    for item in &mut record.items {
        item.name = spelt(numbers, &item.name);
        item.octet = at;
        let DataType::Whole { octets, .. } = item.kind else { panic!("{} is no number", item.name) };
        let fits_in_bits = octets == 1 && item.allowed.iter().all(|range| *range.end() < 16);
        if fits_in_bits && below(numbers, 4) == 0 {
            // The same number of bits elsewhere in the byte is another type.
            (item.kind, item.bits) = (DataType::BitArea, Some(Bits { low: 0, width: 8 }));
        }
        at += usize::from(octets) + below(numbers, 3);
    }
    record.octets = at + below(numbers, 3);
    record.default = (0..record.octets).map(|_| numbers.bits() as u8).collect();
    record.index = 0x2000 + below(numbers, 0x1000) as u32;
}

fn overlaid(gsdml: &Gsdml, confirmed: &[(String, String)]) -> (DeviceDescription, Overlay) {
    let mut device = (*manual("sick-afx60-profinet").device).clone();
    let variant = device.variants.iter().position(|name| name == "afm60").expect("a variant");
    let overlay = gsdml::overlay(&mut device, variant, Some(gsdml), None, confirmed);
    (device, overlay)
}

fn afm60() -> Gsdml {
    let (_, gsdml) = suites::gsdml_for("sick-afx60-profinet", "afm60").expect("it is shipped");
    gsdml
}

#[test]
fn parameters_of_a_gsdml_are_found_in_any_layout() {
    let manual = manual("sick-afx60-profinet");
    let printed = vendor_record(&manual.device);
    for seed in 0..LAYOUTS {
        let mut gsdml = afm60();
        let mut expected = None;
        each_vendor_record(&mut gsdml, |record| {
            lay_out(&mut SplitMix64::new(seed), record);
            expected = Some(record.clone());
        });
        let expected = expected.expect("the GSDML has the record");
        let (device, overlay) = overlaid(&gsdml, &[]);
        let found = vendor_record(&device);
        assert_eq!(found.origin, Origin::Description, "seed {seed}: {:?}", overlay.missing);
        assert_eq!((u32::from(found.index), found.octets), (expected.index, expected.octets), "seed {seed}");
        assert_eq!(found.template, expected.default, "seed {seed}: the parameter of the vendor keeps its default");
        // The reference GSDML has the parameters in the order of the manual.
        let names: Vec<String> = afm60_names();
        for (field, name) in found.fields.iter().zip(&names) {
            let is_it = |item: &&gsdml::RecordItem| {
                item.name.to_lowercase().replace('_', " ").starts_with(&name.to_lowercase())
            };
            let item = expected.items.iter().find(is_it).unwrap_or_else(|| panic!("seed {seed}: {name}"));
            assert_eq!(field.octet, item.octet, "seed {seed}: {}", field.name);
        }
        assert_eq!(found.fields.len(), printed.fields.len());
    }
}

/// The names of the vendor's parameters in the shipped GSDML, in the order of the manual's fields.
fn afm60_names() -> Vec<String> {
    let mut names = Vec::new();
    each_vendor_record(&mut afm60(), |record| {
        names = record.items.iter().map(|item| item.name.clone()).collect();
    });
    names
}

/// Changes the meaning of one parameter; returns what was changed.
fn change_meaning(numbers: &mut SplitMix64, record: &mut GsdmlRecord) -> String {
    loop {
        let at = below(numbers, record.items.len());
        let item = &mut record.items[at];
        let has_words = item.words.len() == 2;
        match below(numbers, 5) {
            0 if has_words => {
                let (one, other) = item.words.split_at_mut(1);
                std::mem::swap(&mut one[0].1, &mut other[0].1);
                return format!("the values of `{}` are swapped", item.name);
            }
            1 if !has_words && item.allowed.iter().any(|range| *range.end() < 0x1_0000) => {
                item.allowed = item.allowed.iter().map(|range| *range.start()..=*range.end() * 10).collect();
                return format!("`{}` has another unit", item.name);
            }
            2 => {
                item.name = format!("Inverted {}", item.name);
                return format!("`{}`", item.name);
            }
            3 => {
                item.name = "Reserve".into();
                return "a parameter is missing".into();
            }
            4 if item.octets == 1 || matches!(item.kind, DataType::Whole { octets: 1, .. }) => {
                (item.kind, item.bits) = (DataType::BitArea, Some(Bits { low: 0, width: 4 }));
                return format!("`{}` has 4 bits", item.name);
            }
            _ => {}
        }
    }
}

#[test]
fn a_gsdml_with_another_meaning_is_not_used_without_a_decision() {
    for seed in 0..MEANINGS {
        let mut gsdml = afm60();
        let mut what = String::new();
        each_vendor_record(&mut gsdml, |record| what = change_meaning(&mut SplitMix64::new(seed), record));
        let (device, overlay) = overlaid(&gsdml, &[]);
        assert_eq!(vendor_record(&device).origin, Origin::Invented, "seed {seed}: {what}");
        let says = overlay.missing.iter().find(|text| text.contains("vendor_settings"));
        let says = says.unwrap_or_else(|| panic!("seed {seed}: {what}: nothing is said"));
        assert!(says.contains("start_parameters"), "seed {seed}: {what}: {says}");
        assert!(overlay.parameters.iter().any(|of| of.doubt.is_some()), "seed {seed}: {what}");
    }
}

#[test]
fn a_person_can_decide_what_a_parameter_means() {
    let mut gsdml = afm60();
    each_vendor_record(&mut gsdml, |record| record.items[3].name = "Abtastintervall".into());
    let (device, overlay) = overlaid(&gsdml, &[]);
    assert_eq!(vendor_record(&device).origin, Origin::Invented);
    assert!(
        overlay.missing.iter().any(|text| text.contains("sampling_interval: no parameter has a name")),
        "{overlay:?}"
    );
    let decided = [("sampling_interval".to_owned(), "Abtastintervall".to_owned())];
    let (device, overlay) = overlaid(&gsdml, &decided);
    assert_eq!(vendor_record(&device).origin, Origin::Description, "{:?}", overlay.missing);
}

/// A name says which parameter it is, not what its values mean.
#[test]
fn a_confirmed_name_does_not_excuse_swapped_values() {
    let mut gsdml = afm60();
    let mut name = String::new();
    each_vendor_record(&mut gsdml, |record| {
        let item = record.items.iter_mut().find(|item| item.words.len() == 2).expect("a switch");
        let (one, other) = item.words.split_at_mut(1);
        std::mem::swap(&mut one[0].1, &mut other[0].1);
        name = item.name.clone();
    });
    let (_, overlay) = overlaid(&gsdml, &[]);
    let field = overlay.parameters.iter().find(|of| of.doubt.is_some()).expect("it is in doubt").field.clone();
    let (device, overlay) = overlaid(&gsdml, &[(field, name)]);
    assert_eq!(vendor_record(&device).origin, Origin::Invented);
    assert!(overlay.missing.iter().any(|text| text.contains("ask the vendor")), "{:?}", overlay.missing);
}

/// What only the vendor has is sent with its defaults, to the submodules that have it.
#[test]
fn a_start_record_that_the_manual_lacks_is_sent_with_its_defaults() {
    let mut gsdml = afm60();
    let mut extra = None;
    each_vendor_record(&mut gsdml, |record| extra = Some(record.clone()));
    let mut extra = extra.expect("the GSDML has it");
    (extra.index, extra.octets, extra.default, extra.items) = (0x1234, 3, vec![7, 8, 9], Vec::new());
    let submodules = gsdml.modules.iter_mut().flat_map(|module| &mut module.submodules).chain(&mut gsdml.submodules);
    let mut at = None;
    for submodule in submodules.filter(|of| of.records.iter().any(|record| record.index == 0x1000)) {
        submodule.records.push(extra.clone());
        at = Some(submodule.ident);
    }
    let (device, overlay) = overlaid(&gsdml, &[]);
    let record = device.records.iter().find(|record| record.index == 0x1234).expect("it is added");
    assert_eq!((record.start, record.origin, record.bytes()), (true, Origin::Description, vec![7, 8, 9]));
    assert_eq!(Some(device.submodules[record.at].ident), at);
    let modules = (0..device.modules.len()).filter(|module| record.starts(*module));
    let has_submodule = |module: &usize| device.modules[*module].submodules.contains(&record.at);
    assert!(modules.clone().count() > 0 && modules.clone().all(|module| has_submodule(&module)));
    assert!(
        overlay.taken.iter().any(|text| text.contains("record_0x1234 is only in the GSDML")),
        "{:?}",
        overlay.taken
    );
}

/// A printed layout counts until the description contradicts it; then nothing is sent.
#[test]
fn a_printed_layout_that_a_gsdml_contradicts_is_in_doubt() {
    let mut gsdml = afm60();
    for submodule in gsdml.modules.iter_mut().flat_map(|module| &mut module.submodules) {
        for record in submodule.records.iter_mut().filter(|record| record.index == 0xBF00) {
            let (one, other) = (record.items[0].bits, record.items[3].bits);
            (record.items[0].bits, record.items[3].bits) = (other, one);
        }
    }
    let (device, overlay) = overlaid(&gsdml, &[]);
    let record = device.records.iter().find(|record| record.name == "bf00").expect("the AFx60 has it");
    assert_eq!(record.origin, Origin::Invented);
    let says = "code_sequence is at byte 0, bit 0 in the manual, and at byte 0, bit 3 in the description";
    assert!(overlay.missing.iter().any(|text| text.contains(says)), "{:?}", overlay.missing);
}

fn a3m60() -> Gsd {
    let (_, text) = suites::gsd().iter().find(|(path, _)| path.starts_with("sick-a3m60")).expect("it is shipped");
    gsd::read(text).expect("it is read")
}

fn overlaid_slave(gsd: &Gsd) -> (DeviceDescription, Overlay) {
    let mut device = (*manual("sick-a3m60-profibus").device).clone();
    let overlay = gsd::overlay(&mut device, Some(gsd), &[]);
    (device, overlay)
}

#[test]
fn parameters_of_a_gsd_are_found_in_any_layout() {
    let names: Vec<String> = a3m60().parameters.fields.iter().map(|(_, field)| field.name.clone()).collect();
    for seed in 0..LAYOUTS {
        let mut numbers = SplitMix64::new(seed);
        let mut gsd = a3m60();
        shuffle(&mut numbers, &mut gsd.parameters.fields);
        let mut at = DPV1 + below(&mut numbers, 3);
        let mut free_bits = 0;
        for (place, field) in &mut gsd.parameters.fields {
            field.name = spelt(&mut numbers, &field.name);
            if let FieldType::Bits { .. } = field.kind {
                field.kind = FieldType::Bits { low: free_bits, high: free_bits };
                *place = at;
                free_bits = (free_bits + 1) % 8;
                at += usize::from(free_bits == 0);
            } else {
                at += usize::from(free_bits != 0);
                (free_bits, *place) = (0, at);
                at += field.kind.octets() + below(&mut numbers, 2);
            }
        }
        gsd.parameters.octets = at + 1 + below(&mut numbers, 3);
        gsd.parameters.constants = vec![(0, vec![0; gsd.parameters.octets])];
        let (device, overlay) = overlaid_slave(&gsd);
        let record = &device.records[0];
        assert_eq!(record.origin, Origin::Description, "seed {seed}: {:?}", overlay.missing);
        assert_eq!(record.octets, gsd.parameters.octets - DPV1, "seed {seed}");
        for (field, name) in record.fields.iter().zip(&names) {
            let is_it = |known: &str| {
                known.to_lowercase().replace('_', " ").starts_with(&name.to_lowercase().replace('_', " "))
            };
            let (place, _) = gsd.parameters.fields.iter().find(|(_, of)| is_it(&of.name)).expect("it is in the GSD");
            assert_eq!(field.octet, place - DPV1, "seed {seed}: {}", field.name);
        }
    }
}

#[test]
fn a_gsd_with_another_meaning_is_not_used_without_a_decision() {
    for seed in 0..MEANINGS {
        let mut numbers = SplitMix64::new(seed);
        let mut gsd = a3m60();
        let what = loop {
            let at = below(&mut numbers, gsd.parameters.fields.len());
            let field = &mut gsd.parameters.fields[at].1;
            match below(&mut numbers, 4) {
                0 if field.texts.len() == 2 => {
                    let (one, other) = field.texts.split_at_mut(1);
                    std::mem::swap(&mut one[0].1, &mut other[0].1);
                    break format!("the values of `{}` are swapped", field.name);
                }
                1 => {
                    field.name = format!("{} inverted", field.name);
                    break format!("`{}`", field.name);
                }
                2 => {
                    field.name = "Reserve".into();
                    break "a parameter is missing".to_owned();
                }
                3 if matches!(field.kind, FieldType::Octets { octets: 4, .. }) => {
                    field.range = field.range.map(|(low, high)| (low, high * 60));
                    break format!("`{}` has another unit", field.name);
                }
                _ => {}
            }
        };
        let (device, overlay) = overlaid_slave(&gsd);
        assert_eq!(device.records[0].origin, Origin::Invented, "seed {seed}: {what}");
        assert!(
            overlay.missing.iter().any(|text| text.contains("start_parameters")),
            "seed {seed}: {what}: {overlay:?}"
        );
    }
}
