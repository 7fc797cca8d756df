//! The suite for any PROFIdrive encoder on the encoders of three manuals, each described by its GSDML alone: no conforming device fails,
//! with any permitted variation, and most bugs that the suite of the manual finds in the shared areas are found without the manual.

mod missed;

use crate::built_in::manual;
use crate::on_two_threads::every;
use encspec::cli::encoder::GsdmlEncoder;
use encspec::engine::{DutKind, DutSpec, RunOptions, run};
use encspec::suite::model::Manual;
use encspec::verdict::Verdict;
use missed::MISSED;
use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;
use std::sync::LazyLock;
use testing::DailySample;

/// The encoders of the manuals, and the plain one.
const DEVICES: [(&str, &str); 7] = [
    ("sick-afx60-profinet", "afs60"),
    ("sick-afx60-profinet", "afm60"),
    ("lika-xac77-profinet", "xac7718"),
    ("lika-xac77-profinet", "xac7716-16384"),
    ("kuebler-sendix58xx-profinet", "sendix-singleturn"),
    ("kuebler-sendix58xx-profinet", "sendix-multiturn"),
    ("profidrive-encoder", "encoder"),
];

/// The lists of bugs of each manual that are about signals, handshakes, presets, scaling, velocity, signs of life and parameter access.
const AREAS: [(&str, &[&str]); 3] = [
    ("sick-afx60-profinet", &["signals", "handshakes", "presets", "scaling", "velocity", "parameter-access"]),
    ("lika-xac77-profinet", &["signals", "handshakes", "presets", "measuring", "velocity", "parameter-access"]),
    ("kuebler-sendix58xx-profinet", &["signals", "handshakes", "presets", "scaling", "velocity", "parameter-access"]),
];

/// Percentage of the bugs in these areas that the GSDML alone has to suffice for, for each manual.
const FOUND: usize = 60;

/// Random combinations of variations for each device.
const COMBINATIONS: u64 = 3;

/// A device with the suite that its GSDML gives.
struct DescribedDevice {
    manual: Manual,
    dut: DutSpec,
}

static DESCRIBED: LazyLock<Vec<DescribedDevice>> = LazyLock::new(|| {
    let described = |&(name, variant): &(&str, &str)| {
        let (path, gsdml) = suites::gsdml_for(name, variant).expect("it is shipped");
        let encoder = GsdmlEncoder::new(Path::new(path), gsdml).expect("an encoder");
        let model = format!("{name}/{variant}");
        let (manual, dut) = encoder.of_model(suites::sources(), &model, Vec::new()).expect("a device with this GSDML");
        DescribedDevice { manual, dut }
    };
    DEVICES.iter().map(described).collect()
});

impl DescribedDevice {
    fn with(&self, names: &[&str]) -> DutSpec {
        let DutKind::External { model, variant, .. } = &self.dut.kind else { panic!("no model") };
        let deviations = names.iter().map(|name| (*name).to_owned()).collect();
        let kind = DutKind::External { model, variant: variant.clone(), deviations };
        DutSpec { kind, ..self.dut.clone() }
    }

    /// The results that a conforming device must not have, with these deviations.
    fn accusations(&self, names: &[&str]) -> String {
        self.results(names, &[Verdict::Fail, Verdict::Error, Verdict::Inconclusive, Verdict::NotRun])
    }

    /// The cases and rules with one of these verdicts, with these deviations.
    fn results(&self, names: &[&str], verdicts: &[Verdict]) -> String {
        let options = RunOptions { duts: vec![self.with(names)], threads: 1, ..RunOptions::default() };
        let result = run(std::slice::from_ref(&self.manual), &options, &|_, _, _| {}).expect("a model can be run");
        let cases = result.runs.iter().flat_map(|run| &run.cases);
        let mut text = String::new();
        for case in cases.filter(|case| verdicts.contains(&case.verdict)) {
            let reason = case.reason.as_deref().unwrap_or_default();
            let _ =
                writeln!(text, "{} --vary {}: {} {} {reason}", self.dut, names.join(" --vary "), case.verdict, case.id);
        }
        text
    }
}

#[test]
fn no_conforming_encoder_fails() {
    let sure =
        every(&DESCRIBED.iter().collect::<Vec<_>>(), |of| Some(of.accusations(&[])).filter(|text| !text.is_empty()));
    assert!(sure.is_empty(), "{}", sure.concat());
}

/// What the device does not have is not applicable; but much of the suite is.
#[test]
fn much_of_the_suite_applies_to_each_encoder() {
    for of in DESCRIBED.iter() {
        let options = RunOptions { duts: vec![of.dut.clone()], threads: 1, ..RunOptions::default() };
        let result = run(std::slice::from_ref(&of.manual), &options, &|_, _, _| {}).expect("a model can be run");
        let passed = result.runs[0].cases.iter().filter(|case| case.verdict == Verdict::Pass).count();
        assert!(passed * 5 > 2 * result.runs[0].cases.len(), "{}: {passed}", of.dut);
        for case in result.runs[0].cases.iter().filter(|case| case.verdict == Verdict::NotApplicable) {
            assert!(case.reason.as_ref().is_some_and(|why| !why.is_empty()), "{}: {}", of.dut, case.id);
        }
    }
}

#[test]
fn no_permitted_variation_fails() {
    let mut jobs: Vec<(&DescribedDevice, Vec<&str>)> = Vec::new();
    for of in DESCRIBED.iter() {
        let DutKind::External { model, .. } = &of.dut.kind else { continue };
        jobs.extend(model.permitted().map(|known| (of, vec![known.name])));
        let random = |seed| model.random_variations(seed).into_iter().map(|known| known.name).collect();
        jobs.extend((0..COMBINATIONS).map(|seed| (of, random(seed))));
    }
    let sample = DailySample::one_of(24);
    let failed = every(&sample.items(jobs), |(of, names)| Some(of.accusations(names)).filter(|text| !text.is_empty()));
    assert!(failed.is_empty(), "{sample}: a conforming device is accused:\n{}", failed.concat());
}

/// The bugs of an area that the suite of the manual lists.
fn bugs(name: &str, areas: &[&str]) -> Vec<String> {
    let lists = areas.iter().map(|area| format!("{name}/bugs-{area}.yaml"));
    let files = suites::sources();
    let text: String = lists
        .map(|path| {
            files.files().find(|(known, _)| *known == path).map(|(_, text)| text.to_owned()).expect("a list of bugs")
        })
        .collect();
    let listed: BTreeSet<&str> =
        text.lines().filter_map(|line| line.strip_prefix("  ")?.split_once(':')).map(|(name, _)| name).collect();
    let of_manual = manual(name).bugs.iter().map(|bug| bug.name.clone());
    of_manual.filter(|bug| listed.contains(bug.as_str())).collect()
}

/// At least 60 % of the bugs of these areas that the suite of the manual finds are found without it; `MISSED` says why each other is not.
#[test]
fn most_bugs_are_found_without_a_manual() {
    let mut each = Vec::new();
    for (name, areas) in AREAS {
        let bugs = bugs(name, areas);
        let reasons = MISSED.iter().filter(|(of, ..)| *of == name);
        let missed: Vec<&str> = reasons.flat_map(|(.., bugs)| bugs.iter().copied()).collect();
        let unknown: Vec<&&str> = missed.iter().filter(|bug| !bugs.iter().any(|known| known == *bug)).collect();
        assert!(unknown.is_empty(), "{name}: not in these areas: {unknown:?}");
        let found: Vec<String> = bugs.iter().filter(|bug| !missed.contains(&bug.as_str())).cloned().collect();
        println!("{name}: {} of {} bugs are found", found.len(), bugs.len());
        assert!(found.len() * 100 >= bugs.len() * FOUND, "{name}: {} of {}", found.len(), bugs.len());
        each.extend(found.into_iter().map(|bug| (name, bug)));
    }
    let sample = DailySample::one_of(24);
    let missed = every(&sample.items(each), |(name, bug)| {
        let mut devices = DESCRIBED.iter().zip(DEVICES).filter(|(_, (of, _))| of == name).map(|(of, _)| of);
        let is_found = devices.any(|of| !of.results(&[bug.as_str()], &[Verdict::Fail]).is_empty());
        (!is_found).then(|| format!("{name} --bug {bug}\n"))
    });
    assert!(missed.is_empty(), "{sample}: not found:\n{}", missed.concat());
}
