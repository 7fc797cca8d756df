//! `encspec replay --shrink`: finds the shortest case that shows a recorded bug on the device with the same bug.

use crate::built_in;
use encspec::compare::capture::compare_capture;
use encspec::compare::conversation::Conversation;
use encspec::compare::conversation::RecordedConversation;
use encspec::compare::drive::ScriptBench;
use encspec::compare::extract::extract;
use encspec::compare::shrink::{ShrinkPair, ShrinkResult, shrink};
use encspec::engine::{RunOptions, run_trial};
use encspec::suite::model::{Manual, SuiteVariant};
use encspec::verdict::Verdict;
use rstest::rstest;
use station::Time;

/// The maximum number of steps of a case.
const SHORT: usize = 10;

/// A recorded conversation, with manual and variant.
struct TrialConversation<'m> {
    manual: &'m Manual,
    variant: &'m SuiteVariant,
    heard: Conversation,
}

/// The conversation in the first trial that catches `bug` and has `part` in its id, on a device with the bugs `with`.
fn record<'m>(manual: &'m Manual, bug: &str, part: &str, with: &[&str]) -> TrialConversation<'m> {
    let catches = |variant: &'m SuiteVariant| {
        let catches = |catches: &[String]| catches.iter().any(|name| name == bug);
        let mut trials = variant.trials.iter().filter(|of| catches(&of.catches) && of.id.contains(part));
        Some((variant, trials.next()?))
    };
    let (variant, trial) = manual.variants.iter().find_map(catches).unwrap_or_else(|| panic!("a trial catches {bug}"));
    let dut = built_in::model(manual, variant, with);
    let outcome = run_trial(manual, variant, &dut, trial, &RunOptions::default()).expect("a model can be run");
    let bench = ScriptBench::new(&suites::sources(), manual, &variant.name).expect("the manual loads");
    let frames = outcome.trace.iter().map(|frame| (frame.number as u64, frame.time, frame.octets));
    TrialConversation { manual, variant, heard: extract(bench.manual_variant(), frames) }
}

/// The number of steps of the shrunk case. The case was run: it passes without the bug and fails with it.
fn shrunk(manual: &Manual, bug: &str) -> Result<usize, String> {
    let TrialConversation { variant, heard, .. } = record(manual, bug, "", &[bug]);
    let bench = ScriptBench::new(&suites::sources(), manual, &variant.name).expect("the manual loads");
    let (reference, dut) = (built_in::model(manual, variant, &[]), built_in::model(manual, variant, &[bug]));
    let listed = manual.bugs.iter().find(|known| known.name == bug).ok_or("unknown bug")?;
    let pair = ShrinkPair { reference: &reference, dut: &dut, bug: Some(listed) };
    let masks = bench.masks(None).map_err(|error| error.to_string())?;
    match shrink(&bench, &pair, &heard, &masks).map_err(|error| error.to_string())? {
        ShrinkResult::Confirmed { case, .. } => {
            let yaml = case.yaml();
            for (device, expected) in [(&reference, Verdict::Pass), (&dut, Verdict::Fail)] {
                let observed = bench.run(&yaml, device).map_err(|error| format!("{error}\n{yaml}"))?.case.verdict;
                if observed != expected {
                    return Err(format!("{observed} instead of {expected} on {device}:\n{yaml}"));
                }
            }
            Ok(case.steps.len())
        }
        ShrinkResult::Same { .. } => Err("the device does not differ".into()),
        ShrinkResult::NoCase { differences } => Err(format!("no case of {} differences", differences.len())),
    }
}

/// At least nine of ten recordings shrink to a case of at most [`SHORT`] steps.
#[rstest]
#[case("lika-xac77-profinet", ["parking-ignored", "error-without-code", "preset-acknowledged-before-stored", "attribute-not-checked",
    "identification-cut-short", "scaling-always-shown", "preset-value-for-offset", "preset-repeats-while-requested",
    "absolute-value-not-served", "error-code-for-status-word"])]
#[case("sick-afx60-profinet", ["zero-elements-refused", "shift-factors-11", "synchronous-and-free-run", "settings-clipped",
    "array-read-from-zero", "response-without-format", "p922-always-81", "preset-acknowledge-stays",
    "preset-range-not-checked", "error-after-start"])]
#[case("kuebler-sendix58xx-profinet", ["velocity-before-position", "preset-acknowledge-stays", "relative-shift-reversed",
    "zero-elements-refused", "st-pos-modulo-range", "preset-takes-100-ms", "control-by-plc-ignored", "trigger-is-a-level",
    "request-takes-cyclic-value", "preset-mode-inverted"])]
#[case("sick-a3m60-profibus", ["default-compatibility-off", "fixed-bit-missing", "word-format-refused", "limits-clip-values",
    "read-gives-the-offset", "month-before-day", "half-steps-in-xist1", "control-requested-never-set",
    "preset-acknowledge-stays", "edge-needs-several-cycles"])]
#[case("datalogic-amt58-profibus", ["cfg-fault-never-set", "own-address-as-master", "header-without-itself",
    "type-change-alters-the-class", "diagnosis-shifted-by-one", "programmed-steps-of-hardware", "preset-needs-class-2",
    "watchdog-always-active", "velocity-in-class-1", "prm-req-not-set"])]
fn a_recorded_bug_becomes_a_short_case(#[case] name: &str, #[case] bugs: [&str; 10]) {
    let manuals = built_in::only(name);
    let outcomes: Vec<(&str, Result<usize, String>)> =
        bugs.into_iter().map(|bug| (bug, shrunk(&manuals[0], bug))).collect();
    let short = outcomes.iter().filter(|(_, outcome)| outcome.as_ref().is_ok_and(|steps| *steps <= SHORT)).count();
    assert!(short >= 9, "{short} of 10: {outcomes:#?}");
}

/// A recording of the reference device has no differences from the reference device; with a bug it has.
#[rstest]
#[case("lika-xac77-profinet", "preset-adds-instead-of-assigns", "preset/value-of-the-moment")]
#[case("sick-afx60-profinet", "preset-adds-instead-of-assigns", "preset/value-of-the-moment")]
#[case("kuebler-sendix58xx-profinet", "preset-acknowledge-stays", "")]
#[case("sick-a3m60-profibus", "only-first-preset", "")]
#[case("datalogic-amt58-profibus", "preset-needs-class-2", "")]
fn a_recording_of_the_reference_device_has_no_differences(#[case] name: &str, #[case] bug: &str, #[case] part: &str) {
    let manuals = built_in::only(name);
    for (with, differs) in [(&[][..], false), (&[bug][..], true)] {
        let TrialConversation { manual, variant, heard } = record(&manuals[0], bug, part, with);
        let bench = ScriptBench::new(&suites::sources(), manual, &variant.name).expect("the manual loads");
        let masks = bench.masks(None).expect("the masks load");
        let heard = RecordedConversation { conversation: heard, begin: Time::ZERO };
        let report = compare_capture(&bench, &built_in::model(manual, variant, &[]), &heard, &masks)
            .expect("a model can be driven");
        assert_eq!(report.inconclusive, None);
        assert!(report.steps > 1, "{report}");
        assert_eq!(!report.differences.is_empty(), differs, "{report}");
    }
}
