//! A description of a live device replaces `device.yaml` of the suite for any PROFINET IO device.

use encspec::gsd;
use encspec::suite_yaml::{ANY_DEVICE, ANY_SLAVE, load};
use std::path::Path;

/// The descriptions in this repository, with vendor and device ID.
const DESCRIPTIONS: [(&str, &str, (u16, u16)); 2] = [
    ("pnio-rt.yaml", include_str!("../../../../.ci/peers/pnio-rt.yaml"), (0x0493, 0x0002)),
    ("pnio-typed.yaml", include_str!("../../../../.ci/peers/pnio-typed.yaml"), (0xFFFF, 0x0001)),
];

#[test]
fn the_suite_loads_with_each_description() {
    let plain = load(&suites::sources(), Some(ANY_DEVICE)).expect("it loads");
    for (file, text, ids) in DESCRIPTIONS {
        let sources = suites::sources().with_description(Path::new(file), text);
        let manuals = load(&sources, Some(ANY_DEVICE)).unwrap_or_else(|errors| panic!("{file}:\n{errors}"));
        let [manual] = manuals.as_slice() else { panic!("one manual has this name") };
        assert_eq!(manual.device.ids(), Some(ids), "{file}");
        assert_eq!(manual.device.profinet().expect("it is on PROFINET").rt_class, 2, "{file}");
        let trials = |of: &encspec::suite::model::Manual| of.variants[0].trials.len();
        assert_eq!(trials(manual), trials(&plain[0]), "{file}: the same cases as for the reference device");
        // Interface and port stand in slot 0 beside the access point, in its module.
        let in_head = manual.device.submodules.iter().filter(|submodule| submodule.slot == 0);
        assert_eq!(in_head.map(|of| of.module_ident(0)).collect::<Vec<_>>(), [Some(1); 3], "{file}");
    }
}

/// A slave needs no description but its GSD.
#[test]
fn the_suite_for_any_slave_loads_with_each_module_of_each_gsd() {
    let plain = load(&suites::sources(), Some(ANY_SLAVE)).expect("it loads");
    for (path, text) in suites::gsd() {
        let read = gsd::read(text).expect("a shipped GSD is read");
        for module in &read.modules {
            // Two modules of a GSD may have the same identifiers, and never the same name.
            let slave = gsd::describe(&read, Some(&module.name)).expect("each module has data");
            let sources = suites::sources().described(ANY_SLAVE, Path::new(path), slave.text);
            let manuals = load(&sources, Some(ANY_SLAVE)).unwrap_or_else(|errors| panic!("{path}:\n{errors}"));
            assert_eq!(manuals[0].device.ident(), Some(read.ident), "{path}");
            assert_eq!(manuals[0].variants[0].trials.len(), plain[0].variants[0].trials.len(), "{path}");
            let data = manuals[0].device.modules.iter().find(|known| known.name == "data").expect("it is described");
            assert_eq!(data.cfg(), module.cfg, "{path}");
            assert!(slave.claimed.contains(&"address_service") == read.set_slave_address, "{path}");
        }
    }
}

#[test]
fn an_error_has_its_position_in_the_description() {
    let text = DESCRIPTIONS[0].1;
    for (right, wrong, message) in [
        ("rt_class: 2", "rt_class: 3", "benches/mine.yaml:8:11: there is no class 3"),
        ("  vendor: 0x0493", "  vender: 0x0493", "unknown name `vendor`"),
        ("  mirror: { ident: 0x0040", "  miror: { ident: 0x0040", "unknown module `mirror`"),
        (
            "bus: profinet",
            "bus: profibus",
            "benches/mine.yaml:4:1: without a manual only devices on PROFINET are tested",
        ),
    ] {
        assert!(text.contains(right), "{right}");
        let text = text.replacen(right, wrong, 1);
        let sources = suites::sources().with_description(Path::new("benches/mine.yaml"), text);
        let errors = load(&sources, Some(ANY_DEVICE)).expect_err(wrong).to_string();
        assert!(errors.contains(message), "{wrong}: {errors}");
    }
}

/// A description stands in no folder of suites, so its device has any name; for a slave the message says what to do instead.
#[test]
fn a_description_has_any_name_and_is_of_profinet() {
    let text = DESCRIPTIONS[0].1.replacen("device: profinet-io", "device: my-device", 1);
    let sources = suites::sources().with_description(Path::new("mine.yaml"), text);
    load(&sources, Some(ANY_DEVICE)).unwrap_or_else(|errors| panic!("{errors}"));
    let slave = "device: my-slave\nbus: profibus\ntitle: A slave\n";
    let sources = suites::sources().with_description(Path::new("mine.yaml"), slave);
    let errors = load(&sources, Some(ANY_DEVICE)).expect_err("a slave").to_string();
    assert!(errors.contains("`encspec suite init --gsd FILE`") && !errors.contains(ANY_DEVICE), "{errors}");
}

/// A parameter of a common suite may be given a constant with the same name; this is not an endless recursion.
#[test]
fn a_parameter_may_be_given_a_constant_of_its_own_name() {
    let path = format!("{ANY_DEVICE}/protocol-records.yaml");
    let text = suites::sources().files().find(|(known, _)| *known == path).map(|(_, text)| text.to_owned());
    let text = text.expect("the suite uses it");
    assert!(text.contains("vendor: =vendor"));
    let twice = text.replace("vendor: =vendor", "vendor: =vendor + vendor - vendor");
    load(&suites::sources().with(&path, twice), Some(ANY_DEVICE)).expect("a constant by an expression");
}

#[test]
fn a_dcp_identify_needs_exactly_one_of_name_alias_and_who() {
    let path = "common/protocol-discovery.yaml";
    let text = suites::sources().files().find(|(known, _)| *known == path).map(|(_, text)| text.to_owned());
    let text = text.expect("it is shipped");
    for (wrong, message) in [
        ("{ who: own_nam }", "did you mean `own_name`"),
        ("{ who: own_name, name: 'a' }", "has exactly one of `name`, `who`, `alias`"),
        ("{}", "has exactly one of `name`, `who`, `alias`"),
    ] {
        let text = text.replacen("{ who: own_name }", wrong, 1);
        let errors = load(&suites::sources().with(path, text), Some(ANY_DEVICE)).expect_err(wrong).to_string();
        assert!(errors.contains(message), "{wrong}: {errors}");
    }
}
