//! Recordings of conforming devices: every trial of every manual runs on the virtual wire, is written as a capture and replayed from
//! the file alone. No protocol check may blame the device.

use crate::built_in::manuals;
use crate::recordings::trace_file;
use encspec::engine::{DutKind, DutSpec, RunOptions, run_trial};
use encspec::replay::{CHECKS, CaptureBlame, CaptureFinding, FindingSeverity, capture};
use encspec::suite::model::{Manual, SuiteVariant, Trial};
use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

fn recorded(manual: &Manual, variant: &SuiteVariant, trial: &Trial) -> Vec<u8> {
    let kind = DutKind::Model { deviations: Vec::new() };
    let dut = DutSpec { manual: manual.device.name.clone(), variant: variant.name.clone(), kind };
    let outcome = run_trial(manual, variant, &dut, trial, &RunOptions::default()).expect("a model can be run");
    trace_file(manual, &outcome.trace)
}

/// The findings of the protocol checks, by trial.
fn all_findings(manuals: &[Manual]) -> Vec<(String, CaptureFinding)> {
    let variants =
        manuals.iter().flat_map(|manual| manual.variants.iter().take(1).map(move |variant| (manual, variant)));
    let trials: Vec<(&Manual, &SuiteVariant, &Trial)> = variants
        .flat_map(|(manual, variant)| variant.trials.iter().map(move |trial| (manual, variant, trial)))
        .collect();
    let (next, found) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    thread::scope(|scope| {
        for _ in 0..thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                while let Some(&(manual, variant, trial)) = trials.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let report = capture("recorded", &recorded(manual, variant, trial)[..], &[]).expect("a capture");
                    let name = format!("{}/{}", manual.device.name, trial.id);
                    let mut found = found.lock().expect("no thread panics");
                    found.extend(report.findings.into_iter().map(|finding| (name.clone(), finding)));
                }
            });
        }
    });
    found.into_inner().expect("no thread panics")
}

#[test]
fn no_protocol_check_blames_a_conforming_device() {
    let manuals = manuals();
    let found = all_findings(manuals);
    let mut counts: BTreeMap<(String, &str, &str), (usize, String)> = BTreeMap::new();
    for (trial, finding) in &found {
        assert!(CHECKS.iter().any(|check| check.id == finding.id), "{}", finding.id);
        let key = (finding.id.clone(), finding.severity.word(), finding.blame.word());
        let of = counts.entry(key).or_insert((0, format!("{trial}: {}", finding.text)));
        of.0 += 1;
    }
    for ((id, severity, blame), (count, example)) in &counts {
        println!("{id} {severity} {blame}: {count}, for instance {example}");
    }
    let blamed: Vec<String> = found
        .iter()
        .filter(|(_, finding)| finding.blame == CaptureBlame::Device && finding.severity == FindingSeverity::Error)
        .map(|(trial, finding)| format!("{trial}: {} {}", finding.id, finding.text))
        .collect();
    assert_eq!(blamed, [""; 0]);
}
