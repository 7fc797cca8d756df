//! What each bug did before the bugs left the devices: for every pair of bug and manual the trials and rules that do not pass.
//!
//! The files in `bugs_before/` say so, by the numbers of the trials in their first part. Behaviour stays as it is, so each bug still
//! has to do just that, but for the differences that [`EXPLAINED`] names. `ENCSPEC_BUGS=one,other` looks at some bugs only, whole
//! devices apart from the sample of the day; `ENCSPEC_RECORD=1` writes the files anew.

use encspec_engine::{DutKind, DutSpec, RunOptions, run};
use results::verdict::Verdict;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::PathBuf;
use std::sync::LazyLock;
use suite::model::Manual;
use testing::Sample;

/// Bugs that do something else by now, each with the reason.
const EXPLAINED: &[(&str, &str, &str)] = &[
    (
        "sick-a3m60-profibus",
        "acyclic-access-disturbs-the-clock",
        "a deviating clock is reported beside the one that is taken for a missing one",
    ),
    (
        "sick-a3m60-profibus",
        "functions-in-telegrams-only",
        "a preset is computed with the scaling, so that a value beyond the range is not reached",
    ),
    (
        "kuebler-sendix58xx-profinet",
        "offset-only-in-ram",
        "the offset is written, which counts, and is lost at power-off",
    ),
    ("lika-xac77-profinet", "offset-only-in-ram", "the offset is written, which can fail, and is lost at power-off"),
    (
        "kuebler-sendix58xx-profinet",
        "offset-written-while-requested",
        "the preset no longer fails too, as if each write had undone the one before it",
    ),
    ("lika-xac77-profinet", "every-write-is-stored", "the web server does not know a value that was written by P65000"),
    ("datalogic-amt58-profibus", "address-0-refused", "an address that the bus has set is no longer lost too"),
    ("datalogic-amt58-profibus", "eighth-switch-adds-128", "an address that the bus has set is no longer lost too"),
    (
        "lika-xac77-profinet",
        "web-at-fixed-address",
        "the device no longer answers at its first address beside the new one, so it can be named again after a reset",
    ),
    (
        "lika-xac77-profinet",
        "speed-unit-refused-without-velocity",
        "it no longer takes a tolerance of 0, of which its sentence says nothing",
    ),
    (
        "sick-a3m60-profibus",
        "written-before-checked",
        "the device has no way to write P1009, so that a write of it changes nothing whatever the checks say",
    ),
    (
        "sick-afx60-profinet",
        "written-before-checked",
        "the device has no way to write the elements of P1009 that are read only, whatever the checks say",
    ),
    (
        "sick-afx60-profinet",
        "speed-unit-ignored",
        "the unit that P1005 gives is no longer ignored too, which is another way to set it",
    ),
];

/// What is written of a bug with which the device once could not run every trial.
const PANICS: &str = " panics";

/// The pairs are looked at in so many days.
const DAYS: u64 = 60;

static MANUALS: LazyLock<Vec<Manual>> =
    LazyLock::new(|| suite_yaml::load(&suites::sources(), None).unwrap_or_else(|errors| panic!("{errors}")));

fn file(manual: &Manual) -> PathBuf {
    let name = format!("{}.txt", manual.device.name);
    [env!("CARGO_MANIFEST_DIR"), "tests", "bugs_before", &name].iter().collect()
}

/// The variants and ids of everything that runs on the devices of a manual, in order.
fn trials(manual: &Manual) -> Vec<String> {
    let of = |variant: &suite::model::Variant| {
        let trials = variant.trials.iter().map(|trial| &trial.id).chain(variant.rules.iter().map(|rule| &rule.id));
        trials.map(|id| format!("{}::{id}", variant.name)).collect::<Vec<_>>()
    };
    manual.variants.iter().flat_map(of).collect()
}

/// What does not pass with a bug, by number, with the first letter of its verdict.
fn seen(manual: &Manual, bug: &str, known: &[String]) -> BTreeMap<usize, char> {
    let dut = |variant: &suite::model::Variant| {
        let (manual, variant) = (manual.device.name.clone(), variant.name.clone());
        DutSpec { manual, variant, kind: DutKind::Model { deviations: vec![bug.to_owned()] } }
    };
    let options = RunOptions { duts: manual.variants.iter().map(dut).collect(), ..RunOptions::default() };
    let result = run(std::slice::from_ref(manual), &options, &|_, _, _| {}).expect("a model can be run");
    let mut seen = BTreeMap::new();
    for of in &result.runs {
        for case in of.cases.iter().filter(|case| case.verdict != Verdict::Pass) {
            let own = case.id.strip_prefix(&format!("{}/", manual.device.name)).unwrap_or(&case.id);
            let id = format!("{}::{own}", of.dut.variant);
            let number = known.iter().position(|known| *known == id).unwrap_or_else(|| panic!("{id} is no trial"));
            let letter = case.verdict.to_string().chars().next().unwrap_or('?');
            seen.insert(number, letter);
        }
    }
    seen
}

/// `3-5f 9i`: the trials 3 to 5 fail and 9 is inconclusive.
fn written(seen: &BTreeMap<usize, char>) -> String {
    let mut text = String::new();
    let mut open: Option<(usize, usize, char)> = None;
    let mut put = |(from, to, letter): (usize, usize, char)| {
        let _ = match from == to {
            true => write!(text, " {from}{letter}"),
            false => write!(text, " {from}-{to}{letter}"),
        };
    };
    for (&number, &letter) in seen {
        open = match open {
            Some((from, to, of)) if to + 1 == number && of == letter => Some((from, number, letter)),
            Some(done) => {
                put(done);
                Some((number, number, letter))
            }
            None => Some((number, number, letter)),
        };
    }
    open.into_iter().for_each(&mut put);
    text
}

fn read(text: &str) -> BTreeMap<usize, char> {
    let mut seen = BTreeMap::new();
    for part in text.split_whitespace() {
        let (numbers, letter) = part.split_at(part.len() - 1);
        let (from, to) = numbers.split_once('-').unwrap_or((numbers, numbers));
        let number = |text: &str| text.parse::<usize>().expect("a number");
        seen.extend((number(from)..=number(to)).map(|of| (of, letter.chars().next().expect("a letter"))));
    }
    seen
}

fn record(manual: &Manual) {
    let known = trials(manual);
    let mut text = known.join("\n") + "\n\n";
    for bug in &manual.bugs {
        let did = std::panic::catch_unwind(|| written(&seen(manual, &bug.name, &known)));
        let _ = writeln!(text, "{}:{}", bug.name, did.unwrap_or_else(|_| PANICS.to_owned()));
    }
    std::fs::write(file(manual), text).expect("the file can be written");
}

#[test]
fn each_bug_still_does_what_it_did() {
    if std::env::var_os("ENCSPEC_RECORD").is_some() {
        MANUALS.iter().for_each(record);
        return;
    }
    let (only, sample) = (std::env::var("ENCSPEC_BUGS").ok(), Sample::one_of(DAYS));
    let is_meant = |index: usize, bug: &str| match &only {
        Some(names) => names.split(',').any(|name| name == bug),
        None => sample.has(index),
    };
    let mut index = 0;
    let mut others = String::new();
    for manual in MANUALS.iter() {
        let known = trials(manual);
        let text = std::fs::read_to_string(file(manual)).unwrap_or_default();
        let (first, bugs) = text.split_once("\n\n").unwrap_or_default();
        let before: Vec<&str> = first.lines().collect();
        for line in bugs.lines() {
            let (bug, did) = line.split_once(':').expect("a bug and what it does");
            index += 1;
            if !is_meant(index, bug) || did == PANICS {
                continue;
            }
            let of = |numbers: BTreeMap<usize, char>, names: &[&str]| -> BTreeMap<String, char> {
                numbers.into_iter().map(|(number, letter)| (names[number].to_owned(), letter)).collect()
            };
            let names: Vec<&str> = known.iter().map(String::as_str).collect();
            let (did, does) = (of(read(did), &before), of(seen(manual, bug, &known), &names));
            let is_explained = EXPLAINED.iter().any(|of| (of.0, of.1) == (manual.device.name.as_str(), bug));
            if did == does || is_explained {
                continue;
            }
            let _ = writeln!(others, "{} {bug}", manual.device.name);
            for (trial, letter) in did.iter().filter(|(trial, letter)| does.get(*trial) != Some(letter)) {
                let now = does.get(trial).copied().unwrap_or('p');
                let _ = writeln!(others, "  {trial}: was {letter}, is {now}");
            }
            for (trial, letter) in does.iter().filter(|(trial, _)| !did.contains_key(*trial)) {
                let _ = writeln!(others, "  {trial}: was p, is {letter}");
            }
        }
    }
    assert!(others.is_empty(), "{others}with {sample}");
}
