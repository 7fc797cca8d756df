//! Exploring a reference device: a conforming one does not differ, a bug becomes a short case, and a permitted variation is learned.

use crate::built_in::{manual, manuals, model};
use crate::common::program::encspec;
use encspec::verdict::Verdict;
use explore::bench::ExploreBench;
use explore::campaign::{Campaign, CampaignOptions, CampaignResult};
use explore::learn::LearnedReference;
use rstest::rstest;
use std::fs;
use testing::{DailySample, Folder};

/// Sequences of each variant, one of [`PARTS`] each day.
const SEQUENCES: u64 = 200;
const PARTS: u64 = 20;
/// The most steps of a case.
const MOST_STEPS: usize = 10;

/// Explores a variant of a manual with these deviations.
fn explored(name: &str, variant: usize, deviations: &[&str], options: &CampaignOptions) -> CampaignResult {
    let of = manual(name);
    let dut = model(of, &of.variants[variant], deviations);
    let bench = ExploreBench::new(&suites::sources(), of, &dut.variant).expect("a bench");
    let reference = LearnedReference::new(&dut).expect("a reference device");
    Campaign::new(&bench, &dut, Some(reference), options).run(&mut |_| {}).expect("a result")
}

#[test]
fn every_sequence_loads_and_a_conforming_device_does_not_differ() {
    let sample = DailySample::one_of(PARTS);
    let seeds = sample.items(0..PARTS);
    let (mut sequences, mut wrong) = (0, Vec::new());
    for of in manuals() {
        for (variant, named) in of.variants.iter().enumerate() {
            for seed in &seeds {
                let options =
                    CampaignOptions { seed: *seed, sequences: Some(SEQUENCES / PARTS), ..CampaignOptions::default() };
                let result = explored(&of.device.name, variant, &[], &options);
                sequences += result.sequences;
                let device = format!("{}/{} seed {seed}", of.device.name, named.name);
                wrong.extend(result.invalid.iter().map(|error| format!("{device}: {error}")));
                wrong.extend(result.findings.iter().map(|of| format!("{device}: {} differs", of.name)));
                assert!(result.frames > 0, "{device}: no frame was sent");
            }
        }
    }
    assert!(wrong.is_empty(), "{sample}: {}", wrong.join("\n"));
    assert!(sequences >= 10 * SEQUENCES / PARTS, "only {sequences} sequences were run");
}

#[rstest]
#[case::error("lika-xac77-profinet", "error-clears-itself")]
#[case::preset("kuebler-sendix58xx-profinet", "preset-acknowledge-stays")]
#[case::position("sick-afx60-profinet", "xist2-always-shows-position")]
#[case::time_stamp("sick-a3m60-profibus", "time-stamp-by-two")]
fn a_bug_becomes_a_short_case(#[case] name: &str, #[case] bug: &str) {
    let options = CampaignOptions { seed: 1, sequences: Some(60), most_findings: 1, ..CampaignOptions::default() };
    let result = explored(name, 0, &[bug], &options);
    let finding = result.findings.first().expect("a finding");
    assert!(finding.is_stable);
    let case = finding.case.as_ref().expect("a case");
    assert!(finding.steps.len() <= MOST_STEPS, "{}", case.yaml());
    assert!(!case.covers.is_empty());
    let of = manual(name);
    let bench = ExploreBench::new(&suites::sources(), of, &of.variants[0].name).expect("a bench");
    let verdict = |bugs: &[&str]| {
        let outcome = bench.judge(case, &model(of, &of.variants[0], bugs), None).expect("an outcome");
        outcome.case.verdict
    };
    assert_eq!((verdict(&[]), verdict(&[bug])), (Verdict::Pass, Verdict::Fail), "{}", case.yaml());
}

/// Explores a variant as if no reference device were known.
fn explored_alone(name: &str, variant: usize, deviations: &[&str], options: &CampaignOptions) -> Vec<String> {
    let of = manual(name);
    let dut = model(of, &of.variants[variant], deviations);
    let bench = ExploreBench::new(&suites::sources(), of, &dut.variant).expect("a bench");
    let result = Campaign::new(&bench, &dut, None, options).run(&mut |_| {}).expect("a result");
    assert!(result.invalid.is_empty(), "{:?}", result.invalid);
    result.findings.into_iter().map(|of| format!("{}: {}", of.name, of.device)).collect()
}

#[test]
fn what_a_power_cycle_keeps_is_judged_without_a_reference_device() {
    let is_about_it = |found: &String| found.starts_with("retention");
    let options = |sequences| CampaignOptions { seed: 2, sequences: Some(sequences), ..CampaignOptions::default() };
    for of in manuals() {
        let found = explored_alone(&of.device.name, 0, &[], &options(96));
        assert!(!found.iter().any(is_about_it), "{}: {found:?}", of.device.name);
    }
    let found = explored_alone("lika-xac77-profinet", 0, &["every-write-is-stored"], &options(96));
    assert!(found.iter().any(|of| of.starts_with("retention: P65000")), "{found:?}");
}

#[test]
fn a_permitted_variation_is_learned_and_not_reported() {
    let options = CampaignOptions { seed: 1, sequences: Some(20), ..CampaignOptions::default() };
    let result = explored("lika-xac77-profinet", 0, &["last-control-word-held"], &options);
    let found: Vec<&str> = result.findings.iter().map(|of| of.name.as_str()).collect();
    assert!(found.is_empty(), "{found:?}");
    assert_eq!(result.learned, ["last-control-word-held"]);
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_a_finding_the_status_1() {
    let folder = Folder::new("explore-twice");
    let dut = ["explore", "--dut", "model:lika-xac77-profinet/xac7718", "--seed", "1", "--sequences", "6"];
    let run = |out: &str, bug: &[&str]| {
        let (json, junit) = (format!("json={out}.json"), format!("junit={out}.xml"));
        let reports = ["--out", out, "--report", &json, "--report", &junit];
        let arguments: Vec<&str> = dut.iter().chain(bug).chain(&reports).copied().collect();
        let said = encspec(folder.as_ref(), &arguments);
        let read = |name: &str| fs::read_to_string(folder.as_ref().join(name)).expect("a file");
        let files = if bug.is_empty() { String::new() } else { read(&format!("{out}/explored-1.yaml")) };
        (said.status, said.out, files, read(&format!("{out}.xml")), said.err)
    };
    let (status, text, case, junit, err) = run("one", &["--bug", "error-clears-itself"]);
    assert_eq!(status, Some(1), "{err}");
    assert!(text.contains("passes on the reference device"), "{text}");
    assert!(
        case.contains("encspec explore --dut model:lika-xac77-profinet/xac7718 --bug error-clears-itself --seed 1")
    );
    assert!(junit.contains("<failure"), "{junit}");
    let (_, again, same, ..) = run("two", &["--bug", "error-clears-itself"]);
    assert_eq!((text, case), (again, same));
    let (status, text, ..) = run("three", &[]);
    assert_eq!((status, text.contains("no difference from the reference device")), (Some(0), true), "{text}");
}

#[rstest]
#[case::bug(&["--dut", "model:lika-xac77-profinet/xac7718", "--bug", "error-clears-itsel"], "did you mean `error-clears-itself`?")]
#[case::variants(&["--dut", "model:lika-xac77-profinet"], "has several variants; name one")]
#[case::live(&["--dut", "null:silent"], "needs `--device MANUAL[/VARIANT]`")]
fn a_usage_error_of_explore_is_reported(#[case] arguments: &[&str], #[case] says: &str) {
    let folder = Folder::new(&format!("explore-mistake-{}", arguments.join("-").replace(['/', ':', ' '], "_")));
    let said = encspec(&folder, &[&["explore"], arguments].concat());
    assert_eq!(said.status, Some(2), "{}", said.err);
    assert!(said.err.contains(says), "{}", said.err);
}
