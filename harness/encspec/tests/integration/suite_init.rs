//! `encspec suite init`: a suite from the description of each reference device loads, runs, and accuses no conforming device.

use crate::common::program::encspec;
use encspec::engine::{DutKind, DutSpec, RunOptions, run};
use encspec::suite::model::Manual;
use encspec::suite_yaml::load;
use encspec::verdict::Verdict;
use std::fs;
use testing::Folder;

/// Writes the suite of a description with the program; its folder, and what it said.
fn written(test: &str, option: &str, text: &str) -> (Folder, String) {
    let folder = Folder::new(test);
    folder.write("description", text);
    let said = encspec(&folder, &["suite", "init", option, "description", "--output", "mine"]);
    assert_eq!(said.status, Some(0), "{test}: {}", said.all());
    assert!(said.err.contains("wrote mine; read its comments, then: encspec check mine"), "{}", said.err);
    let checked = encspec(&folder, &["check", "mine"]);
    assert_eq!(checked.status, Some(0), "{test}: {}", checked.all());
    assert!(checked.out.contains("nothing proves that its cases can fail"), "{}", checked.out);
    (folder, said.err)
}

/// The suite in the folder `mine`, whose only variant is called `variant`.
fn loaded(folder: &Folder, variant: &str) -> Manual {
    let (sources, added) = suites::sources().and_folder(&folder.join("mine")).expect("the folder can be read");
    assert_eq!(added.manuals, ["mine"]);
    let text = fs::read_to_string(folder.join("mine/device.yaml")).expect("a device");
    let lines = text.lines().map(|line| match line.starts_with("variants: [") {
        true => format!("variants: [{variant}]\n"),
        false => format!("{line}\n"),
    });
    let sources = sources.with("mine/device.yaml", lines.collect::<String>());
    let manuals = load(&sources, Some("mine")).unwrap_or_else(|errors| panic!("{errors}"));
    manuals.into_iter().next().expect("a manual")
}

/// Runs a suite on the reference device of another manual.
fn on_reference_device(manual: &Manual, name: &str, variant: &str) -> Vec<(String, Verdict, Option<String>)> {
    let model = deviations::subject(name).expect("a reference device");
    let kind = DutKind::External { model, variant: None, deviations: Vec::new() };
    let dut = DutSpec { manual: "mine".to_owned(), variant: variant.to_owned(), kind };
    let options = RunOptions { duts: vec![dut], ..RunOptions::default() };
    let result = run(std::slice::from_ref(manual), &options, &|_, _, _| {}).expect("a model can be run");
    result.runs.into_iter().flat_map(|run| run.cases).map(|case| (case.id, case.verdict, case.reason)).collect()
}

/// The manual and the variant of a built-in description: the reference device that has it.
fn variant_of(path: &str) -> (String, String) {
    let (name, file) = path.split_once('/').expect("a folder");
    let variants = deviations::subject(name).expect("a reference device").manual.variants;
    let letters = |text: &str| text.to_ascii_lowercase().replace(|letter: char| !letter.is_ascii_alphanumeric(), "");
    let called = variants.iter().filter(|variant| letters(file).contains(&letters(variant)));
    let variant = called.max_by_key(|variant| variant.len()).or(variants.first()).expect("a variant");
    (name.to_owned(), (*variant).to_owned())
}

fn check(option: &str, path: &str, text: &str) -> usize {
    let (name, variant) = variant_of(path);
    let (folder, _) = written(&format!("init-{}", path.replace('/', "-")), option, text);
    let manual = loaded(&folder, &variant);
    let results = on_reference_device(&manual, &name, &variant);
    let wrong: Vec<_> = results.iter().filter(|(_, verdict, _)| *verdict != Verdict::Pass).collect();
    assert!(wrong.is_empty(), "{path}: {wrong:#?}");
    results.len()
}

#[test]
fn a_suite_from_each_gsdml_passes_on_its_reference_device() {
    for (path, text) in suites::gsdml() {
        let passed = check("--gsdml", path, text);
        assert!(passed > 35, "{path}: {passed} results");
    }
}

#[test]
fn a_suite_from_each_gsd_passes_on_its_reference_device() {
    for (path, text) in suites::gsd() {
        let passed = check("--gsd", path, text);
        assert!(passed > 10, "{path}: {passed} results");
    }
}

/// A suite that accuses no conforming device must also notice something: a device with bugs, and peers that are no device.
#[test]
fn a_written_suite_finds_a_bug_and_null_devices() {
    let (path, text) = suites::gsdml().iter().find(|(path, _)| path.contains("XAC7718")).expect("it is built in");
    let (folder, _) = written("init-bug", "--gsdml", text);
    let (name, variant) = variant_of(path);
    let manual = loaded(&folder, &variant);
    let model = deviations::subject(&name).expect("a reference device");
    let bugs: Vec<&str> = model.bugs().map(|bug| bug.name).collect();
    let bug = ["any-name-answered", "name-lost-at-power-off", "im0-without-vendor"]
        .into_iter()
        .find(|bug| bugs.contains(bug));
    let kind =
        DutKind::External { model, variant: None, deviations: vec![bug.expect("a bug of any station").to_owned()] };
    let dut = DutSpec { manual: "mine".to_owned(), variant: variant.clone(), kind };
    let options = RunOptions { duts: vec![dut], ..RunOptions::default() };
    let result = run(std::slice::from_ref(&manual), &options, &|_, _, _| {}).expect("a model can be run");
    assert!(result.runs[0].cases.iter().any(|case| case.verdict == Verdict::Fail));
    let silent = ["run", "--suites", "mine", "--dut", "null:silent", "--device", "mine", "--no-evidence"];
    let silent = encspec(&folder, &silent);
    assert_eq!(silent.status, Some(1), "{}", silent.all());
}

/// The start parameters have the names, words and defaults of the GSDML; they are in its record 0xBF00.
#[test]
fn start_parameters_have_names_and_defaults() {
    let (_, text) = suites::gsdml().iter().find(|(path, _)| path.contains("XAC7718")).expect("it is built in");
    let (folder, _) = written("init-start", "--gsdml", text);
    let device = fs::read_to_string(folder.join("mine/device.yaml")).expect("a device");
    for line in [
        "    index: 0xBF00\n",
        "    start: true\n",
        "  code_sequence: { clockwise: 0, counterclockwise: 1 }\n",
        "      code_sequence: { octet: 0, bit: 0, words: code_sequence, default: clockwise",
        "      measuring_units_per_revolution: { octets: [1, 8], default: 262144",
    ] {
        assert!(device.contains(line), "`{line}` is not in:\n{device}");
    }
}

/// A device without modules is its access point alone, and other access points are named.
#[test]
fn a_device_with_several_access_points_says_so() {
    let (folder, _) = written("init-vendor", "--gsdml", include_str!("../gsdml/of-a-vendor.xml"));
    let device = fs::read_to_string(folder.join("mine/device.yaml")).expect("a device");
    let others =
        "# Decide: the GSDML has other access points (D2, D3); `--access-point ID` writes a suite for one of them.\n";
    assert!(device.contains(others), "{device}");
    let said = encspec(&folder, &["suite", "init", "--gsdml", "description", "--access-point", "D2", "-o", "second"]);
    assert_eq!(said.status, Some(0), "{}", said.all());
    let unknown = encspec(&folder, &["suite", "init", "--gsdml", "description", "--access-point", "D9", "-o", "none"]);
    assert!(unknown.err.contains("unknown access point `D9`"), "{}", unknown.err);
}

#[test]
fn nothing_is_overwritten_and_mistakes_are_named() {
    let folder = Folder::new("init-mistakes");
    folder.write("mine/keep.txt", "kept\n");
    let (_, text) = suites::gsd()[0];
    folder.write("device.gsd", text);
    for (arguments, says) in [
        (&["suite", "init", "--gsd", "device.gsd", "-o", "mine"][..], "mine cannot be written: File exists"),
        (&["suite", "init", "--gsd", "device.gsd", "-o", "common"], "`common` cannot be the name of a manual"),
        (&["suite", "init", "--gsdml", "device.gsd"], "device.gsd:1:"),
        (&["suite", "init"], "--gsdml"),
        (&["suite", "init", "--gsd", "device.gsd", "--access-point", "x"], "cannot be used with"),
    ] {
        let said = encspec(&folder, arguments);
        assert_eq!(said.status, Some(2), "{}", said.all());
        assert!(said.err.contains(says), "{}", said.err);
    }
    assert_eq!(fs::read_dir(folder.join("mine")).expect("the folder").count(), 1);
}
