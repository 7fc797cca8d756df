//! A capture held against a live device, as a user calls it: at a Unix socket and at a pseudoterminal, with consent and without.
//!
//! The machine may stall whenever it likes: what came of that is told as inconclusive, and then it is tried again.

use crate::common::program::{self, Serving};
use crate::table;
use encspec::compare::drive::Bench as Drive;
use encspec::engine::{DutKind, DutSpec};
use encspec::suite_yaml::load;
use encspec::verdict::Verdict;
use libtest_mimic::Trial;
use serde_json::Value;
use std::path::PathBuf;
use testing::{Folder, patience};

pub fn trials() -> Vec<Trial> {
    let mut trials = table![a_live_device_is_driven_as_the_recorded_one:
        at_a_socket(XAC77, IDENTIFICATION),
        at_a_pseudoterminal(AMT58, DIAGNOSIS),
    ];
    trials.extend(table![the_bug_of_a_live_device_becomes_a_case:
        at_a_socket(XAC77, IDENTIFICATION),
        at_a_pseudoterminal(AMT58, DIAGNOSIS),
    ]);
    trials.extend(table![what_has_no_consent_is_not_driven:
        at_a_socket(XAC77, "preset/absolute", "no consent to position_reference"),
        at_a_pseudoterminal(AMT58, "preset/every-class[class_2]", "no consent to position_reference"),
    ]);
    trials
}

/// So often a capture is driven again that this machine has spoilt by being late.
const LOOKS: usize = 4;

/// A device to be served: manual, variant, and its description.
#[derive(Clone, Copy)]
struct Served {
    manual: &'static str,
    variant: &'static str,
    description: [&'static str; 2],
}

const XAC77: Served = Served {
    manual: "lika-xac77-profinet",
    variant: "xac7718",
    description: ["gsdml", "GSDML-V2.43-encspec-XAC7718-20261121.xml"],
};
const AMT58: Served =
    Served { manual: "datalogic-amt58-profibus", variant: "hs5818", description: ["gsd", "encspec-amt58-hs5818.gsd"] };

/// A folder of its own with captures, a bench file and the name of a line in it.
struct Bench {
    folder: Folder,
    of: Served,
}

impl Bench {
    fn new(of: Served) -> Bench {
        let folder = Folder::new("against");
        Bench { folder, of }
    }

    fn model(&self) -> String {
        format!("model:{}/{}", self.of.manual, self.of.variant)
    }

    /// Serves the reference device with these bugs, and writes the bench file of it.
    fn serve(&self, bugs: &[&str], consent: &str) -> Serving {
        let line = self.folder.join("line").display().to_string();
        let _ = std::fs::remove_file(&line);
        let model = self.model();
        let suite = testing::workspace().join("suites").join(self.of.manual);
        let [kind, file] = self.of.description;
        let (place, link) = match kind {
            "gsd" => (["--pty".to_owned(), line.clone()], format!("serial:{line}")),
            _ => (["--socket".to_owned(), format!("listen:{line}")], format!("socket:{line}")),
        };
        let slave: &[&str] = if kind == "gsd" { &["--address", "8"] } else { &[] };
        let ip = if kind == "gsd" { "" } else { "ip: 192.168.0.10\nwatchdog: 500ms\n" };
        let file = suite.join(file).display().to_string();
        let text =
            format!("device: {}/{}\nlink: {link}\n{kind}: {file}\n{ip}{consent}\n", self.of.manual, self.of.variant);
        std::fs::write(self.folder.join("bench.yaml"), text).expect("the bench file");
        let mut arguments = vec![model.as_str()];
        arguments.extend(place.iter().map(String::as_str));
        arguments.extend(slave);
        bugs.iter().for_each(|bug| arguments.extend(["--bug", *bug]));
        Serving::start(&arguments)
    }

    fn call(&self, arguments: &[&str]) -> (Option<i32>, String) {
        let said = program::encspec(&self.folder, arguments);
        (said.status, said.all())
    }

    /// The capture of one case on the virtual bus.
    fn record(&self, case: &str, bugs: &[&str]) -> String {
        let folder = format!("recorded-{}", bugs.len());
        let model = self.model();
        let mut arguments = vec!["run", "--dut", &model, case, "--record", &folder, "--no-evidence"];
        bugs.iter().for_each(|bug| arguments.extend(["--bug", *bug]));
        let (_, said) = self.call(&arguments);
        let files = std::fs::read_dir(self.folder.join(&folder)).unwrap_or_else(|_| panic!("no capture: {said}"));
        let mut files: Vec<PathBuf> = files.flatten().map(|entry| entry.path()).collect();
        files.sort();
        files.first().unwrap_or_else(|| panic!("no capture: {said}")).display().to_string()
    }

    /// What came of holding a capture against the device; none where the machine came in between every time.
    fn held(&self, capture: &str) -> Option<(Option<i32>, Value)> {
        for _ in 0..LOOKS {
            let (status, said) =
                self.call(&["replay", capture, "--against", "bench.yaml", "--report", "json=out.json"]);
            let text = std::fs::read_to_string(self.folder.join("out.json")).unwrap_or_else(|_| panic!("{said}"));
            let report: Value = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {said}"));
            let against = report["captures"][0].clone();
            assert!(against["differences"].is_array(), "{said}");
            if against["inconclusive"].is_null() {
                return Some((status, against));
            }
            assert_eq!(against["differences"], Value::Array(Vec::new()), "nothing is said against a device: {said}");
        }
        None
    }
}

const IDENTIFICATION: (&str, &str) = ("parameter-values/arrays-as-a-whole[p964]", "identification-cut-short");
const DIAGNOSIS: (&str, &str) = ("diagnosis/module-information", "own-address-as-master");

/// A healthy recording differs in nothing from a healthy live device, and one with a bug does.
fn a_live_device_is_driven_as_the_recorded_one(of: Served, (case, bug): (&str, &str)) {
    let bench = Bench::new(of);
    let (healthy, wrong) = (bench.record(case, &[]), bench.record(case, &[bug]));
    let _serving = bench.serve(&[], "consent: { alone: true }");
    let Some((status, same)) = bench.held(&healthy) else { panic!("the machine came in between every time") };
    assert_eq!(same["differences"], Value::Array(Vec::new()), "{same:#}");
    assert_eq!(status, Some(0), "{same:#}");
    assert!(same["steps"].as_u64().is_some_and(|steps| steps > 1), "{same:#}");
    assert!(same["masked"].as_object().is_some_and(|masked| !masked.is_empty()), "the place of its shaft: {same:#}");
    let Some((status, other)) = bench.held(&wrong) else { panic!("the machine came in between every time") };
    assert_eq!(status, Some(1), "{other:#}");
    assert!(other["differences"].as_array().is_some_and(|found| !found.is_empty()), "{other:#}");
}

/// The bug of a live device becomes a case that fails with this bug and passes without it.
fn the_bug_of_a_live_device_becomes_a_case(of: Served, (case, bug): (&str, &str)) {
    let bench = Bench::new(of);
    let wrong = bench.record(case, &[bug]);
    let _serving = bench.serve(&[bug], "consent: { alone: true }");
    let manuals = load(&suites::sources(), Some(of.manual)).expect("the shipped suites load");
    let drive = Drive::new(&suites::sources(), &manuals[0], of.variant).expect("the manual loads");
    patience::again(|| {
        let shrink = ["replay", &wrong, "--shrink", "--dut", "bench.yaml", "--case", "shrunk.yaml"];
        let (status, said) = bench.call(&shrink);
        if status != Some(1) {
            return Err(said);
        }
        let yaml = std::fs::read_to_string(bench.folder.join("shrunk.yaml")).map_err(|_| said.clone())?;
        for (bugs, wanted) in [(vec![], Verdict::Pass), (vec![bug.to_owned()], Verdict::Fail)] {
            let kind = DutKind::Model { deviations: bugs };
            let dut = DutSpec { manual: of.manual.to_owned(), variant: of.variant.to_owned(), kind };
            let seen = drive.run(&yaml, &dut).map_err(|error| format!("{error}\n{yaml}"))?.case.verdict;
            if seen != wanted {
                return Err(format!("{seen} instead of {wanted}:\n{yaml}\n{said}"));
            }
        }
        Ok(())
    });
}

/// Without consent nothing is done to a device, and it is said what is missing.
fn what_has_no_consent_is_not_driven(of: Served, case: &str, why: &str) {
    let bench = Bench::new(of);
    let capture = bench.record(case, &[]);
    let _serving = bench.serve(&[], "consent: { alone: true }");
    for more in [&["--against", "bench.yaml"][..], &["--shrink", "--dut", "bench.yaml"]] {
        let call = || bench.call(&[&["replay", &capture], more].concat());
        // A machine that is late may get no turn on a line.
        let calls = (0..LOOKS).map(|_| call()).find(|(_, said)| !said.contains("does not get the token"));
        let (status, said) = calls.expect("a line on which there is a turn");
        assert_eq!(status, Some(3), "{said}");
        assert!(said.contains(why), "{said}");
    }
}
