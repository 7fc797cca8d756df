//! Recordings of conforming devices with random permitted variations, replayed from the file alone with the rules of their manual: no
//! finding accuses the device.

use crate::built_in::{self, manuals};
use crate::on_two_threads::every;
use crate::recordings::trace_file;
use crate::variations::combination;
use encspec::engine::{RunOptions, run_trial};
use encspec::replay::{CaptureBlame, CaptureFinding, FindingSeverity, capture};
use encspec::suite::model::{Manual, SuiteVariant, Trial};
use std::slice;
use testing::DailySample;

/// Random combinations of each device, with the seeds from 0.
const COMBINATIONS: u64 = 20;

/// The capture of a trial with these variations.
fn recorded(manual: &Manual, variant: &SuiteVariant, trial: &Trial, variations: &[&str]) -> Vec<u8> {
    let dut = built_in::model(manual, variant, variations);
    let outcome = run_trial(manual, variant, &dut, trial, &RunOptions::default()).expect("a model can be run");
    trace_file(manual, &outcome.trace)
}

/// A rule of the manual that the device broke, or an error of the device.
fn accuses(finding: &CaptureFinding) -> bool {
    let is_serious = finding.severity == FindingSeverity::Error || !finding.requirements.is_empty();
    is_serious && finding.blame == CaptureBlame::Device
}

#[test]
fn no_recording_with_permitted_variations_accuses_the_device() {
    let variants = manuals().iter().flat_map(|manual| manual.variants.iter().map(move |variant| (manual, variant)));
    let each = variants.flat_map(|(manual, variant)| {
        let combinations = (0..COMBINATIONS).map(move |seed| (manual, variant, seed));
        combinations
            .flat_map(|(manual, variant, seed)| variant.trials.iter().map(move |of| (manual, variant, seed, of)))
    });
    let sample = DailySample::one_of(167);
    let jobs = sample.items(each);
    let accused = every(&jobs, |(manual, variant, seed, trial)| {
        let recorded = recorded(manual, variant, trial, &combination(manual, *seed));
        let report = capture("recorded", &recorded[..], slice::from_ref(*manual)).expect("a capture");
        assert!(!report.ars.is_empty() || trial.start().is_none(), "{}: no connection was judged", trial.id);
        let accusing: Vec<String> = report.findings.iter().filter(|of| accuses(of)).map(|of| of.text.clone()).collect();
        let what = format!("{}/{} --vary random:{seed} {}", manual.device.name, variant.name, trial.id);
        (!accusing.is_empty()).then(|| format!("{what}: {accusing:?}\n"))
    });
    assert!(accused.is_empty(), "{sample}: conforming devices are accused:\n{}", accused.concat());
}
