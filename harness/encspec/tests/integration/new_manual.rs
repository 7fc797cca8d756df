//! A new manual needs only YAML in the harness and one file for the reference device.

#[path = "../fixtures/enc81.rs"]
mod device;

use crate::common::program::encspec;
use device::{MANUAL, SUBJECT};
use encspec::engine::scan::check_covers;
use encspec::engine::{DutKind, DutSpec, RunOptions, run};
use encspec::suite::model::Manual;
use encspec::suite_yaml::load;
use encspec::verdict::Verdict;
use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;
use testing::Folder;

fn root() -> PathBuf {
    testing::workspace().canonicalize().expect("the workspace")
}

/// The manual, loaded with the common suites of the built-in ones.
fn manual() -> Manual {
    let folder = root().join("harness/encspec/tests/fixtures").join(MANUAL.name);
    let files = fs::read_dir(&folder).expect("the folder of the manual").map(|entry| entry.expect("an entry").path());
    let sources = files.fold(suites::sources(), |sources, file| {
        let name = file.file_name().and_then(|name| name.to_str()).expect("a name").to_owned();
        sources.with(&format!("{}/{name}", MANUAL.name), fs::read_to_string(&file).expect("a text"))
    });
    let loaded = load(&sources, Some(MANUAL.name)).unwrap_or_else(|errors| panic!("it loads:\n{errors}"));
    loaded.into_iter().find(|of| of.device.name == MANUAL.name).expect("it is loaded")
}

fn dut(variant: &str, bugs: &[&str]) -> DutSpec {
    let bugs = bugs.iter().map(|bug| (*bug).to_owned()).collect();
    let kind = DutKind::External { model: &SUBJECT, variant: None, deviations: bugs };
    DutSpec { manual: MANUAL.name.to_owned(), variant: variant.to_owned(), kind }
}

#[test]
fn suite_and_reference_device_agree() {
    let manual = manual();
    assert_eq!(manual.device.variants, MANUAL.variants);
    let offered: BTreeSet<&str> = SUBJECT.bugs().map(|bug| bug.name).collect();
    let listed: BTreeSet<&str> = manual.bugs.iter().map(|bug| bug.name.as_str()).collect();
    assert!(listed.is_subset(&offered), "{:?}", listed.difference(&offered));
}

#[test]
fn the_run_is_green_and_all_requirements_are_covered() {
    let manual = manual();
    for variant in &manual.variants {
        let options = RunOptions { duts: vec![dut(&variant.name, &[])], ..RunOptions::default() };
        let result = run(std::slice::from_ref(&manual), &options, &|_, _, _| {}).expect("a model can be run");
        let cases: Vec<_> = result.runs.iter().flat_map(|run| &run.cases).collect();
        assert!(cases.len() >= 10, "{} cases", cases.len());
        for case in cases {
            assert_eq!(case.verdict, Verdict::Pass, "{}: {:?}", case.id, case.reason);
        }
        let covered = variant.trials.iter().flat_map(|trial| trial.covers.iter().copied().chain(check_covers(trial)));
        let covered: BTreeSet<usize> = covered.collect();
        assert_eq!(covered.len(), manual.requirements.len());
    }
}

/// Each case that catches a bug fails with it, and so does each requirement that the bug breaks.
#[test]
fn each_bug_shows() {
    let manual = manual();
    for bug in &manual.bugs {
        let mut breaks: BTreeSet<usize> = bug.breaks.iter().copied().collect();
        for variant in &manual.variants {
            let options = RunOptions { duts: vec![dut(&variant.name, &[&bug.name])], ..RunOptions::default() };
            let result = run(std::slice::from_ref(&manual), &options, &|_, _, _| {}).expect("a model can be run");
            let verdicts = &result.runs[0].cases;
            let catching = variant.trials.iter().filter(|trial| trial.catches.contains(&bug.name));
            let catching: BTreeSet<&str> = catching.map(|trial| trial.case()).collect();
            assert!(!catching.is_empty(), "nothing catches {}", bug.name);
            for id in catching {
                let begin = format!("{}/{id}", MANUAL.name);
                let mut of_case = verdicts.iter().filter(|case| case.id.split('[').next() == Some(begin.as_str()));
                assert!(of_case.any(|case| case.verdict == Verdict::Fail), "{id} passes with {}", bug.name);
            }
            for covered in verdicts.iter().flat_map(|case| &case.covers).filter(|of| of.verdict == Verdict::Fail) {
                breaks.remove(&covered.requirement);
            }
        }
        assert!(breaks.is_empty(), "{} does not break all of its requirements", bug.name);
    }
}

/// The manual in a folder of its own, as it is written without a reference device: no bugs.
fn without_bugs(test: &str, called: &str) -> Folder {
    let folder = Folder::new(test);
    let files = fs::read_dir(root().join("harness/encspec/tests/fixtures").join(MANUAL.name)).expect("the manual");
    for file in files.map(|entry| entry.expect("an entry").path()) {
        let name = file.file_name().and_then(|name| name.to_str()).expect("a name").to_owned();
        let text = fs::read_to_string(&file).expect("a text");
        let text = text.replace(&format!("device: {}", MANUAL.name), &format!("device: {called}"));
        let lines =
            text.lines().filter(|line| !line.trim_start().starts_with("catches:")).map(|line| format!("{line}\n"));
        if name != "bugs.yaml" {
            folder.write(&format!("{called}/{name}"), lines.collect::<String>());
        }
    }
    folder
}

#[test]
fn a_manual_without_bugs_is_checked_and_says_what_that_costs() {
    let folder = without_bugs("no-bugs", "mine");
    let said = encspec(&folder, &["check", "mine"]);
    assert_eq!(said.status, Some(0), "{}", said.all());
    assert!(said.out.starts_with("mine: 12 requirements, 0 bugs, "), "{}", said.out);
    assert!(said.out.contains("\n  it lists no bugs: nothing proves that its cases can fail\n"), "{}", said.out);
    folder.write("mine/bugs.yaml", "bugs: { some-bug: [E81-05] }\n");
    let said = encspec(&folder, &["check", "mine"]);
    assert!(said.err.contains("no bug of this manual makes `preset-survives-power-off` fail"), "{}", said.err);
}

/// `--suites` adds a manual to the built-in ones: its common suites are found, and the built-in manuals run as before.
#[test]
fn a_folder_adds_a_manual() {
    let folder = without_bugs("adds", "mine");
    let listed = encspec(&folder, &["list", "--suites", "mine", "mine", "preset-memory/"]);
    assert_eq!((listed.status, listed.err.as_str()), (Some(0), ""), "{}", listed.out);
    assert!(listed.out.starts_with("mine/preset-memory/preset-survives-power-off\n"), "{}", listed.out);
    let run = encspec(&folder, &["run", "--suites", "mine", "parking/parks", "mine/", "--no-evidence"]);
    assert_eq!(run.status, Some(2), "{}", run.all());
    assert!(
        run.err.contains("mine is not run: it has no reference device; name a live device with --dut"),
        "{}",
        run.err
    );
    let run = encspec(&folder, &["run", "--suites", "mine", "lika-xac77-profinet", "parking/", "--no-evidence"]);
    assert_eq!(run.status, Some(0), "{}", run.all());
    let named = encspec(&folder, &["run", "--suites", "mine", "--dut", "model:mine"]);
    assert_eq!(named.status, Some(2), "{}", named.all());
    assert!(named.err.contains("mine has no reference device; name a live device with --dut"), "{}", named.err);
    // A peer that is no device needs no reference device, and must not pass.
    let absent = ["run", "--suites", "mine", "--dut", "null:silent", "--device", "mine", "--no-evidence"];
    let absent = encspec(&folder, &absent);
    assert_eq!(absent.status, Some(1), "{}", absent.all());
    assert!(absent.out.contains("Red: 12 results on 1 device: 12 inconclusive"), "{}", absent.out);
}

#[test]
fn a_manual_of_the_same_name_replaces_the_built_in_one() {
    let folder = without_bugs("replaces", "profinet-io");
    let said = encspec(&folder, &["list", "--suites", "profinet-io", "profinet-io"]);
    assert_eq!(said.status, Some(0), "{}", said.all());
    assert_eq!(said.err, "encspec: profinet-io replaces profinet-io\n");
    assert!(said.out.contains("profinet-io/positions/preset\n") && !said.out.contains("protocol-"), "{}", said.out);
}

/// Common suites and personas may stand in another folder than the manual, and a folder without any suite is a mistake.
#[test]
fn folders_are_added_one_after_the_other() {
    let folder = without_bugs("folders", "mine");
    let common = "common: mine-only\nwhy: It is tried.\ntakes:\n  position: { is: word, why: a position }\ncases:\n  - id: any\n    \
                  why: There is a position.\n    steps: [ { expect: { =position: any } } ]\n";
    folder.write("shared/common/mine-only.yaml", common);
    let persona = "persona: hasty\nwhy: It is tried.\nsource: nothing\n";
    folder.write("shared/personas/hasty.yaml", persona);
    let uses = "suite: mine-only\nuse: mine-only\ndefaults: { start: { module: telegram_81 } }\ngive: { position: G1_XIST1 }\n\
                covers: { any: [E81-02] }\nomit: {}\n";
    folder.write("mine/mine-only.yaml", uses);
    let both = ["list", "--suites", "shared", "--suites", "mine", "mine", "mine-only/"];
    let said = encspec(&folder, &both);
    assert_eq!((said.status, said.err.as_str()), (Some(0), ""), "{}", said.out);
    assert!(said.out.contains("mine/mine-only/any\n"), "{}", said.out);
    let said = encspec(&folder, &["personas", "--suites", "shared"]);
    assert!(said.out.contains("hasty"), "{}", said.all());
    let said = encspec(&folder, &["check", "mine"]);
    assert!(said.err.contains("unknown common suite `mine-only`"), "{}", said.err);
    let said = encspec(&folder, &["check", "mine", "--suites", "shared"]);
    assert_eq!(said.status, Some(0), "{}", said.all());
    folder.write("empty/readme.txt", "nothing\n");
    let said = encspec(&folder, &["list", "--suites", "empty"]);
    assert_eq!(said.status, Some(2), "{}", said.all());
    assert!(said.err.contains("empty: there is no suite here"), "{}", said.err);
}

/// A new manual needs no change in any other file.
#[test]
fn no_other_file_names_it() {
    let words = [MANUAL.name, "ENC81"];
    let own = ["harness/encspec/tests/fixtures", file!()].map(|path| root().join(path));
    let mut folders =
        ["harness", "device-under-test", "suites", ".ci", "reports", "docs"].map(|name| root().join(name)).to_vec();
    let mut files = 0;
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(&folder).expect("a folder").map(|entry| entry.expect("an entry").path()) {
            if own.iter().any(|own| path.starts_with(own)) || path.ends_with("target") {
                continue;
            }
            if path.is_dir() {
                folders.push(path);
            } else if let Ok(text) = fs::read_to_string(&path) {
                files += 1;
                assert!(words.iter().all(|word| !text.contains(word)), "{} names the sixth manual", path.display());
            }
        }
    }
    assert!(files > 300, "only {files} files were searched");
}

/// Parameters need a submodule that gives access to them; without one no case that reads a parameter could run.
#[test]
fn a_module_without_access_to_parameters_is_refused() {
    let folder = without_bugs("no-access", "mine");
    let device = fs::read_to_string(folder.join("mine/device.yaml")).expect("a device");
    let without = |line: &str| {
        assert!(device.contains(line), "{line}");
        folder.write("mine/device.yaml", device.replace(line, ""));
        encspec(&folder, &["check", "mine"])
    };
    let said = without("parameter_access: { index: 0xB02F, at: access_point }\n");
    assert_eq!(said.status, Some(2), "{}", said.all());
    let no_submodule = "parameters cannot be reached: no submodule of this device gives access to them";
    assert!(
        said.err.contains(no_submodule) && said.err.contains("`parameter_access: { at: SUBMODULE }`"),
        "{}",
        said.err
    );
    let said = without("access_point, ");
    assert!(said.err.contains("the module `telegram_81` has no access to them"), "{}", said.err);
    assert!(said.err.contains("positions.yaml") && said.err.contains("errors in the suites"), "{}", said.err);
}
