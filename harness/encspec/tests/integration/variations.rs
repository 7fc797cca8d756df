//! No conforming device fails: with each permitted variation every case and rule passes, and the variation is visible on the wire.

use crate::built_in::{self, manuals};
use encspec::engine::{RunOptions, run, run_trial};
use encspec::suite::model::Manual;
use encspec::verdict::Verdict;
use std::fmt::Write;

fn permitted(manual: &Manual) -> Vec<&'static str> {
    let subject = deviations::subject(&manual.device.name).expect("a reference device for every suite");
    subject.permitted().map(|known| known.name).collect()
}

#[test]
fn with_each_permitted_variation_every_case_and_rule_passes() {
    let mut failed = String::new();
    for manual in manuals() {
        for name in permitted(manual) {
            let duts = manual.variants.iter().map(|variant| built_in::model(manual, variant, &[name])).collect();
            let options = RunOptions { duts, ..RunOptions::default() };
            let result = run(std::slice::from_ref(manual), &options, &|_, _, _| {}).expect("a model can be run");
            for run in &result.runs {
                assert_eq!((run.variations.as_slice(), run.bugs.len()), (&[name.to_owned()][..], 0));
                for case in run.cases.iter().filter(|case| case.verdict != Verdict::Pass) {
                    let _ = writeln!(failed, "{name}: {} {} {}", run.dut.variant, case.verdict, case.id);
                }
            }
        }
    }
    assert!(failed.is_empty(), "a permitted variation fails:\n{failed}");
}

#[test]
fn each_permitted_variation_changes_a_frame() {
    for manual in manuals() {
        for name in permitted(manual) {
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
            assert!(shows, "{}: {name} changes nothing on the wire", manual.device.name);
        }
    }
}
