//! A new manual needs only YAML in the harness and one file for the reference device.

#[path = "../fixtures/enc81.rs"]
mod device;

use device::{MANUAL, SUBJECT};
use encspec::engine::scan::check_covers;
use encspec::engine::{DutKind, DutSpec, RunOptions, run};
use encspec::suite::model::Manual;
use encspec::suite_yaml::load;
use encspec::verdict::Verdict;
use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;

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
    let kind = DutKind::External { model: &SUBJECT, deviations: bugs };
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
