//! No conforming device fails: with each permitted variation, and with random combinations of them, every case and rule passes. Each
//! variation is visible on the wire, and none hides a bug.

mod hidden;

use self::hidden::{ALWAYS, SOMETIMES};
use crate::built_in::{self, manuals};
use crate::on_two_threads::every;
use encspec::engine::{RunOptions, run, run_trial};
use encspec::suite::model::{Bug, Manual, OtherReadings, RequirementClass, SuiteVariant, Trial};
use encspec::verdict::Verdict;
use std::collections::BTreeSet;
use std::fmt::Write;
use testing::DailySample;

/// Random combinations for each device, with the seeds from 0.
const COMBINATIONS: u64 = 300;
/// Random combinations with which each bug has to be caught.
const COMBINATIONS_OF_A_BUG: u64 = 20;

/// Whether a list of variations by manual has this one.
fn lists(list: &[(&str, &[&str])], manual: &Manual, name: &str) -> bool {
    list.iter().any(|(of, names)| *of == manual.device.name && names.contains(&name))
}

fn permitted(manual: &Manual) -> Vec<&'static str> {
    let subject = deviations::subject(&manual.device.name).expect("a reference device for every suite");
    subject.permitted().map(|known| known.name).collect()
}

/// A random combination of the variations.
pub fn combination(manual: &Manual, seed: u64) -> Vec<&'static str> {
    let subject = deviations::subject(&manual.device.name).expect("a reference device for every suite");
    subject.random_variations(seed).into_iter().map(|known| known.name).collect()
}

/// The results that are not green with these variations; `None` if all are.
fn failures(manual: &Manual, variant: &SuiteVariant, variations: &[&str], what: &str) -> Option<String> {
    let duts = vec![built_in::model(manual, variant, variations)];
    let options = RunOptions { duts, threads: 1, ..RunOptions::default() };
    let result = run(std::slice::from_ref(manual), &options, &|_, _, _| {}).expect("a model can be run");
    let mut failed = String::new();
    for run in &result.runs {
        assert_eq!((run.variations.len(), run.bugs.len()), (variations.len(), 0));
        for case in run.cases.iter().filter(|case| case.verdict != Verdict::Pass) {
            let reading =
                case.notes.iter().find(|note| note.starts_with("likely reading")).cloned().unwrap_or_default();
            let _ = writeln!(failed, "{} --vary {}: {} {} {reading}", run.dut.variant, what, case.verdict, case.id);
        }
    }
    (!failed.is_empty()).then_some(failed)
}

/// Every variant of every manual that permits something.
fn devices() -> impl Iterator<Item = (&'static Manual, &'static SuiteVariant)> {
    let varied = manuals().iter().filter(|manual| !permitted(manual).is_empty());
    varied.flat_map(|manual| manual.variants.iter().map(move |variant| (manual, variant)))
}

#[test]
fn with_each_permitted_variation_every_case_and_rule_passes() {
    let each = devices().flat_map(|(of, variant)| permitted(of).into_iter().map(move |name| (of, variant, name)));
    let sample = DailySample::one_of(24);
    let failed = every(&sample.items(each), |(of, variant, name)| failures(of, variant, &[name], name)).concat();
    assert!(failed.is_empty(), "{sample}: a permitted variation fails:\n{failed}");
}

#[test]
fn with_random_combinations_of_variations_every_case_and_rule_passes() {
    let each = devices().flat_map(|(of, variant)| (0..COMBINATIONS).map(move |seed| (of, variant, seed)));
    let sample = DailySample::one_of(300);
    let jobs = sample.items(each);
    let failed =
        every(&jobs, |(of, variant, seed)| failures(of, variant, &combination(of, *seed), &format!("random:{seed}")));
    assert!(failed.is_empty(), "{sample}: permitted combinations fail:\n{}", failed.concat());
}

/// An `either` that accepts too much would let a bug pass together with a variation.
#[test]
fn each_bug_is_caught_with_random_combinations_of_variations() {
    let each = manuals().iter().filter(|manual| !permitted(manual).is_empty()).flat_map(|manual| {
        let bugs = manual.bugs.iter();
        bugs.flat_map(move |bug| (0..COMBINATIONS_OF_A_BUG).map(move |seed| (manual, bug, seed)))
    });
    let sample = DailySample::one_of(61);
    let jobs = sample.items(each);
    let escaped = every(&jobs, |(manual, bug, seed)| {
        let combination = combination(manual, *seed);
        if ALWAYS.iter().chain(SOMETIMES).any(|hidden| hidden.hides(&bug.name, &combination)) {
            return None;
        }
        let caught = is_caught(manual, bug, &combination);
        (!caught).then(|| format!("{} --bug {} --vary random:{seed}\n", manual.device.name, bug.name))
    });
    assert!(escaped.is_empty(), "{sample}: no case that catches these fails:\n{}", escaped.concat());
}

/// What is listed as hidden and is not would let a case that has become blind pass.
#[test]
fn hidden_bugs_are_hidden() {
    let each = ALWAYS.iter().flat_map(|hidden| hidden.bugs.iter().map(move |bug| (hidden, *bug)));
    let sample = DailySample::one_of(4);
    let wrong = every(&sample.items(each), |(hidden, name)| {
        let mut those_with_both = manuals().iter().filter_map(|manual| {
            let all = permitted(manual);
            let bug = manual.bugs.iter().find(|bug| bug.name == *name)?;
            hidden.by.iter().all(|variation| all.contains(variation)).then_some((manual, bug))
        });
        let is_hidden = those_with_both.any(|(manual, bug)| !is_caught(manual, bug, hidden.by));
        (!is_hidden).then(|| format!("{name} --vary {} ({})\n", hidden.by.join(" --vary "), hidden.why))
    });
    assert!(wrong.is_empty(), "{sample}: these are caught:\n{}", wrong.concat());
    for hidden in SOMETIMES {
        for name in hidden.bugs {
            assert!(manuals().iter().any(|manual| manual.bugs.iter().any(|bug| bug.name == *name)), "{name}");
        }
    }
}

/// Whether a case or rule that catches the bug fails with it on a device of any variant that also has the variations.
fn is_caught(manual: &Manual, bug: &Bug, combination: &[&str]) -> bool {
    manual.variants.iter().any(|variant| is_caught_on(manual, variant, bug, combination))
}

fn is_caught_on(manual: &Manual, variant: &SuiteVariant, bug: &Bug, combination: &[&str]) -> bool {
    // The bug acts last, on what the device with the variations does.
    let dut = built_in::model(manual, variant, &[combination, &[bug.name.as_str()]].concat());
    let catches = |names: &[String]| names.contains(&bug.name);
    let catching_rules = || variant.rules.iter().map(|rule| catches(&rule.catches));
    let fails = |trial: &Trial| {
        let outcome = run_trial(manual, variant, &dut, trial, &RunOptions::default()).expect("a model can be run");
        let by_rule = catching_rules().zip(&outcome.rules).any(|(catches, rule)| catches && rule.broken.is_some());
        by_rule || (catches(&trial.catches) && outcome.case.verdict == Verdict::Fail)
    };
    let (catching, others): (Vec<&Trial>, Vec<&Trial>) =
        variant.trials.iter().filter(|trial| manual.is_own(trial)).partition(|trial| catches(&trial.catches));
    catching.into_iter().any(fails) || (catching_rules().any(|catches| catches) && others.into_iter().any(fails))
}

/// Variations that hid a bug until a check became sharper: codes are compared exactly while the position flickers; nothing may happen
/// for longer than a reaction takes; what happens to a frame on its way acts after the device.
const ONCE_HIDDEN: [(&str, &str, &str); 8] = [
    ("sick-afx60-profinet", "commissioning-with-own-code", "position-flickers"),
    ("sick-a3m60-profibus", "error-needs-request", "position-flickers"),
    ("kuebler-sendix58xx-profinet", "error-codes-combined", "position-flickers"),
    ("sick-a3m60-profibus", "new-value-triggers", "presets-late"),
    ("sick-a3m60-profibus", "trigger-on-both-edges", "presets-late"),
    ("sick-afx60-profinet", "mode-change-repeats-preset", "presets-in-three-times-the-time"),
    ("sick-afx60-profinet", "xist2-freezes-without-control", "outputs-one-cycle-late"),
    ("profinet-io", "cycle-counter-stands-still", "trailer-of-four-bytes"),
];

#[test]
fn bugs_that_a_variation_once_hid_are_caught() {
    for (device, bug, variation) in ONCE_HIDDEN {
        let manual = manuals().iter().find(|manual| manual.device.name == device).expect("a built-in manual");
        let bug = manual.bugs.iter().find(|known| known.name == bug).expect("a bug of it");
        let caught = is_caught(manual, bug, &[variation]);
        assert!(caught, "{device} --bug {} --vary {variation}", bug.name);
    }
}

#[test]
fn each_permitted_variation_changes_a_frame() {
    let each = manuals().iter().flat_map(|manual| permitted(manual).into_iter().map(move |name| (manual, name)));
    let sample = DailySample::one_of(10);
    let invisible = every(&sample.items(each), |(manual, name)| {
        let shows = manual.variants.iter().any(|variant| {
            let differs = |trial| {
                let frames = |deviations: &[&str]| {
                    let dut = built_in::model(manual, variant, deviations);
                    let outcome = run_trial(manual, variant, &dut, trial, &RunOptions::default());
                    let trace = outcome.expect("a model can be run").trace;
                    trace.iter().map(|frame| (frame.time, frame.octets.to_vec())).collect::<Vec<_>>()
                };
                frames(&[]) != frames(&[name])
            };
            variant.trials.iter().any(differs)
        });
        let known = lists(&NOT_SEEN_YET, manual, name) || lists(&SEEN_ON_LEDS_ONLY, manual, name);
        match (shows, known) {
            (false, false) => Some(format!("{} --vary {name} changes nothing\n", manual.device.name)),
            (true, true) => Some(format!("{} --vary {name} is seen by now\n", manual.device.name)),
            (true, false) | (false, true) => None,
        }
    });
    assert!(invisible.is_empty(), "{sample}: {}", invisible.concat());
}

/// Variations of an LED, which no frame can show.
const SEEN_ON_LEDS_ONLY: [(&str, &[&str]); 2] = [
    ("sick-a3m60-profibus", &["memory-errors-on-the-led", "undervoltage-below-8-volts"]),
    (
        "sick-afx60-profinet",
        &[
            "bf-flashes",
            "red-and-orange-flash",
            "sf-dark-during-data-exchange",
            "sf-red-without-data-exchange",
            "traffic-flashes-green",
        ],
    ),
];

/// Variations that no frame of a case shows yet; the list may only shrink.
const NOT_SEEN_YET: [(&str, &[&str]); 6] = [
    ("datalogic-amt58-profibus", &["answer-stored-until-the-next-frame"]),
    (
        "dp-encoder",
        &[
            "answer-stored-until-the-next-frame",
            "fail-safe-without-its-bit",
            "other-masters-acknowledged",
            "without-fail-safe",
        ],
    ),
    ("dp-slave", &["answer-stored-until-the-next-frame", "fail-safe-without-its-bit"]),
    ("profidrive-encoder", &["alarm-acknowledged-late", "alarm-jitters", "alarm-late", "difference-lists-all"]),
    ("sick-a3m60-profibus", &["answer-stored-until-the-next-frame"]),
    ("sick-afx60-profinet", &["hold-time-checked-late"]),
];

/// For each clause that can be read in two ways there is a device of the other reading, or a reason why none shows it.
#[test]
fn each_reading_of_an_ambiguous_clause_has_a_variation_or_a_reason() {
    let mut wrong = String::new();
    for manual in manuals() {
        let known: BTreeSet<&str> = permitted(manual).into_iter().collect();
        let mut unknown = 0;
        for of in &manual.requirements {
            let is_open = of.ambiguity.is_some() || matches!(of.class, RequirementClass::Contradictory(_));
            match &of.other_readings {
                OtherReadings::Varied(names) => {
                    for name in names.iter().filter(|name| !known.contains(name.as_str())) {
                        let _ = writeln!(wrong, "{}: there is no variation {name}", of.id);
                    }
                }
                OtherReadings::Invisible(_) => {}
                OtherReadings::Unknown => unknown += usize::from(is_open),
            }
        }
        if unknown > 0 {
            let _ = writeln!(wrong, "{}: {unknown} readings without variation or reason", manual.device.name);
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}
