//! The reference devices are plain: they read like their manuals, and everything by which they may deviate is attached from outside.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The crates of the devices, without the one of the deviations.
const DEVICES: [&str; 3] = ["device-stack", "encoder-profile", "reference-devices"];

/// What a reader of a manual opens first: at most [`FIRST_READ`] lines each.
const OPENED_FIRST: [&str; 11] = [
    "device-stack/src/profibus/slave.rs",
    "device-stack/src/profibus/state_machine.rs",
    "device-stack/src/profibus/start_up.rs",
    "device-stack/src/profibus/exchange.rs",
    "device-stack/src/profinet/cyclic",
    "encoder-profile/src/encoder_object/cyclic",
    "encoder-profile/src/encoder_object/memory.rs",
    "encoder-profile/src/profidrive/sensor",
    "encoder-profile/src/profidrive/preset_trigger.rs",
    "encoder-profile/src/profidrive/parameters",
    "reference-devices/src/models/datalogic_amt58/preset.rs",
];

const FIRST_READ: usize = 150;
const MOST_STEPS: usize = 60;
const MOST_TRAITS_OF_STEPS: usize = 12;

fn root() -> PathBuf {
    testing::workspace().join("device-under-test")
}

/// The sources below a folder or the file itself, without tests.
fn sources(path: &Path) -> Vec<PathBuf> {
    if path.is_file() {
        return vec![path.to_owned()];
    }
    let entries = fs::read_dir(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let paths = entries.map(|entry| entry.expect("an entry of a folder").path());
    let is_test = |path: &PathBuf| path.file_stem().is_some_and(|name| name == "tests");
    let mut found: Vec<PathBuf> = paths.filter(|path| !is_test(path)).flat_map(|path| sources(&path)).collect();
    found.sort();
    found.retain(|path| path.extension().is_some_and(|extension| extension == "rs"));
    found
}

fn text(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

fn of_devices() -> Vec<PathBuf> {
    DEVICES.iter().flat_map(|name| sources(&root().join(name).join("src"))).collect()
}

#[test]
fn no_device_names_a_deviation() {
    let names: BTreeSet<&str> =
        deviations::subjects().iter().flat_map(deviations::Subject::deviations).map(|known| known.name).collect();
    assert!(names.len() > 1000);
    for path in of_devices() {
        let text = text(&path);
        let words = text.split('"').skip(1).step_by(2);
        let named: Vec<&str> = words.filter(|word| names.contains(word)).collect();
        assert!(named.is_empty(), "{} names {named:?}", path.display());
    }
}

/// A step is a method of a trait whose name ends in `Steps`; what only notifies is none.
#[test]
fn steps_are_few() {
    let (mut traits, mut steps) = (Vec::new(), Vec::new());
    for path in of_devices() {
        let text = text(&path);
        for (name, body) in text.split("pub trait ").skip(1).filter_map(|rest| rest.split_once('{')) {
            let name = name.trim();
            if !name.ends_with("Steps") {
                continue;
            }
            let body = body.split("\n}").next().unwrap_or_default();
            let methods = body.split("    fn ").skip(1);
            let methods = methods.filter(|method| method.split('{').next().is_some_and(|head| head.contains("->")));
            steps.extend(methods.map(|method| format!("{name}::{}", method.split('(').next().unwrap_or_default())));
            traits.push(name.to_owned());
        }
    }
    assert!(!steps.is_empty() && steps.len() <= MOST_STEPS, "{} steps: {steps:#?}", steps.len());
    assert!(traits.len() <= MOST_TRAITS_OF_STEPS, "{traits:?}");
}

#[test]
fn what_is_opened_first_is_short() {
    for path in OPENED_FIRST.iter().flat_map(|path| sources(&root().join(path))) {
        let lines = text(&path).lines().count();
        assert!(lines <= FIRST_READ, "{} has {lines} lines, {FIRST_READ} at most", path.display());
    }
}
