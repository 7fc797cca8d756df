//! No conforming device fails: with each permitted variation, and with random combinations of them, every case and rule passes. Each
//! variation is visible on the wire, and none hides a bug.

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
    let sample = DailySample::one_of(12);
    let failed = every(&sample.items(each), |(of, variant, name)| failures(of, variant, &[name], name)).concat();
    assert!(failed.is_empty(), "{sample}: a permitted variation fails:\n{failed}");
}

#[test]
fn with_random_combinations_of_variations_every_case_and_rule_passes() {
    let each = devices().flat_map(|(of, variant)| (0..COMBINATIONS).map(move |seed| (of, variant, seed)));
    let sample = DailySample::one_of(200);
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
    let sample = DailySample::one_of(41);
    let jobs = sample.items(each);
    let escaped = every(&jobs, |(manual, bug, seed)| {
        let combination = combination(manual, *seed);
        let hides = |name: &str| HIDDEN.iter().any(|(hidden, by, _)| *hidden == bug.name && *by == name);
        if combination.iter().any(|name| hides(name)) {
            return None;
        }
        let caught = manual.variants.iter().any(|variant| is_caught(manual, variant, bug, &combination));
        (!caught).then(|| format!("{} --bug {} --vary random:{seed}\n", manual.device.name, bug.name))
    });
    let count = escaped.len();
    assert!(
        count * 100 <= jobs.len() * ESCAPED_PERCENT,
        "{sample}: no case that catches these fails:\n{}",
        escaped.concat()
    );
}

/// How many of a hundred bugs may still escape under a combination; 0 is the goal.
const ESCAPED_PERCENT: usize = 4;

/// Bugs that a device cannot show while it has a variation, each with the variation and the reason.
const HIDDEN: [(&str, &str, &str); 46] = [
    ("one-header-for-two-blocks", "diagnosis-in-portions", "each response has one block"),
    ("life-sign-tolerance-not-shown", "p925-always-1", "P925 is 1 in either case"),
    ("supported-faults-0", "supported-bits-as-used", "the parameters have the other reading"),
    ("range-offset-with-a-sign", "range-offset-constant", "the parameter does not change"),
    ("range-offset-lost", "range-offset-constant", "the parameter does not change"),
    ("internal-shift-undefined", "internal-shift-constant", "the parameter does not change"),
    ("p971-reads-memory", "p971-cannot-be-read", "no value is read"),
    ("operating-time-in-hours", "operating-time-in-motion", "the parameter is another counter"),
    ("operating-time-not-kept", "operating-time-in-motion", "the parameter is another counter"),
    ("settings-kept-in-part", "speed-settings-kept", "all settings are kept"),
    ("error-codes-combined", "latest-code-first", "the code is replaced"),
    ("other-fault-bits-in-compatibility-mode", "faults-0-in-v31", "there are no faults in compatibility mode"),
    ("acknowledgement-ignored", "errors-clear-themselves", "the error is gone before it is acknowledged"),
    ("xist1-shows-error", "xist1-0-with-an-error", "G1_XIST1 is 0"),
    ("code-gone-with-the-first-error", "code-of-several-until-power-off", "the code stays"),
    ("io-codes-ored", "code-of-several-until-power-off", "the code of several errors is sent"),
    ("first-error-kept", "code-of-several-until-power-off", "the code of several errors is sent"),
    ("code-for-a-missing-clock", "no-clock-with-io-modules", "the mode is refused"),
    ("multi-read-answers-first-only", "one-parameter-at-a-time", "requests for several parameters are refused"),
    ("answers-in-order-of-number", "one-parameter-at-a-time", "requests for several parameters are refused"),
    ("one-error-drops-all", "one-parameter-at-a-time", "requests for several parameters are refused"),
    ("multi-write-stops-at-first-error", "one-parameter-at-a-time", "requests for several parameters are refused"),
    ("response-cut-off", "one-parameter-at-a-time", "requests for several parameters are refused"),
    ("record-half-taken-in-data-exchange", "record-in-force-at-once", "the record takes effect as a whole"),
    ("undefined-speed-unit-taken", "unknown-unit-is-rpm", "the unit is replaced"),
    ("tolerance-of-4-bits", "tolerance-limited", "the tolerance is replaced"),
    ("more-revolutions-than-there-are", "range-limited-to-all-revolutions", "the range is replaced"),
    ("rule-of-powers-missing", "range-rounded-down", "the range is replaced"),
    ("highest-preset-is-an-error", "io-positions-of-26-bits", "there is no such preset"),
    ("preset-acknowledge-stays", "preset-done-within-a-cycle", "bit 12 is never seen"),
    ("preset-acknowledged-too-early", "preset-done-within-a-cycle", "bit 12 is never seen"),
    ("works-at-0", "forbidden-address-is-126", "the address 0 is replaced"),
    ("simultaneous-presets-add", "presets-fast", "the first preset is stored before the second begins"),
    ("position-runs-during-preset", "presets-fast", "the preset is over before the next cycle"),
    ("sign-of-life-stops-during-preset", "presets-fast", "the preset is over before the next cycle"),
    ("axis-unknown-as-parameter", "any-axis-answered", "no axis is unknown"),
    (
        "impossible-scaling-accepted",
        "wrong-parameters-refused",
        "the record is refused before anything of it is judged or reported",
    ),
    (
        "single-limits-not-checked",
        "wrong-parameters-refused",
        "the record is refused before anything of it is judged or reported",
    ),
    (
        "speed-unit-not-checked",
        "wrong-parameters-refused",
        "the record is refused before anything of it is judged or reported",
    ),
    (
        "tolerance-0-accepted",
        "wrong-parameters-refused",
        "the record is refused before anything of it is judged or reported",
    ),
    (
        "no-alarm-for-parameters",
        "wrong-parameters-refused",
        "the record is refused before anything of it is judged or reported",
    ),
    (
        "one-alarm-for-all",
        "wrong-parameters-refused",
        "the record is refused before anything of it is judged or reported",
    ),
    (
        "diagnosis-record-empty",
        "wrong-parameters-refused",
        "the record is refused before anything of it is judged or reported",
    ),
    ("reserved-bit-7-acts", "reserved-bits-refused", "the record is refused"),
    ("reserved-bytes-act", "reserved-bits-refused", "the record is refused"),
    ("range-below-a-revolution-ignored", "range-below-a-revolution-is-an-error", "such a range is an error"),
];

/// Whether a case or rule that catches the bug fails with it on a device that also has the variations.
fn is_caught(manual: &Manual, variant: &SuiteVariant, bug: &Bug, combination: &[&str]) -> bool {
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
        variant.trials.iter().partition(|trial| catches(&trial.catches));
    catching.into_iter().any(fails) || (catching_rules().any(|catches| catches) && others.into_iter().any(fails))
}

/// Each of these bugs changes an error code by one; a shaft that is not still must not hide it.
#[test]
fn codes_are_compared_exactly_while_the_position_flickers() {
    for (device, bug) in [
        ("sick-afx60-profinet", "commissioning-with-own-code"),
        ("sick-a3m60-profibus", "error-needs-request"),
        ("kuebler-sendix58xx-profinet", "error-codes-combined"),
    ] {
        let manual = manuals().iter().find(|manual| manual.device.name == device).expect("a built-in manual");
        let bug = manual.bugs.iter().find(|known| known.name == bug).expect("a bug of it");
        let caught = manual.variants.iter().any(|variant| is_caught(manual, variant, bug, &["position-flickers"]));
        assert!(caught, "{device} --bug {}", bug.name);
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
const NOT_SEEN_YET: [(&str, &[&str]); 1] = [("sick-afx60-profinet", &["hold-time-checked-late"])];

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
