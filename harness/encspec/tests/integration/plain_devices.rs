//! The reference devices are plain: their code follows the manuals, and all deviations are attached from outside.

use crate::code_rules::{files, relative_path, text};
use std::collections::BTreeSet;
use std::path::PathBuf;

/// The device crates without `deviations`.
const DEVICES: [&str; 3] = ["device-stack", "encoder-profile", "reference-devices"];

/// The files that a reader of a manual opens first, with at most [`FIRST_READ`] lines each.
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

/// The sources of the device crates without tests, by their path below `device-under-test`.
fn of_devices() -> Vec<(String, PathBuf)> {
    let of = |name: &&str| files(format!("device-under-test/{name}/src"), "rs");
    let named =
        DEVICES.iter().flat_map(of).map(|path| (relative_path(&path).replacen("device-under-test/", "", 1), path));
    named.filter(|(name, _)| !name.contains("/tests/") && !name.ends_with("/tests.rs")).collect()
}

#[test]
fn no_device_names_a_deviation() {
    let names: BTreeSet<&str> =
        deviations::subjects().iter().flat_map(deviations::Subject::deviations).map(|known| known.name).collect();
    assert!(names.len() > 1000);
    for (name, path) in of_devices() {
        let text = text(&path);
        let words = text.split('"').skip(1).step_by(2);
        let named: Vec<&str> = words.filter(|word| names.contains(word)).collect();
        assert!(named.is_empty(), "{name} names {named:?}");
    }
}

/// A step is a method with a result in a trait whose name ends in `Steps`.
#[test]
fn steps_are_few() {
    let (mut traits, mut steps) = (Vec::new(), Vec::new());
    for (_, path) in of_devices() {
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
fn files_that_are_opened_first_are_short() {
    let all = of_devices();
    for first in OPENED_FIRST {
        let mut found = all.iter().filter(|(name, _)| name.starts_with(first)).peekable();
        assert!(found.peek().is_some(), "{first} does not exist");
        for (name, path) in found {
            let lines = text(path).lines().count();
            assert!(lines <= FIRST_READ, "{name} has {lines} lines, {FIRST_READ} at most");
        }
    }
}
