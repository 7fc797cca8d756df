//! `encspec replay --against` with a live device at a Unix socket and at a pseudoterminal, with and without consent.
//!
//! If the host stalls the result is inconclusive, and the comparison is repeated.

use crate::common::program::{self, ServeProcess};
use crate::table;
use encspec::compare::drive::ScriptBench as Drive;
use encspec::engine::{DutKind, DutSpec};
use encspec::suite_yaml::load;
use encspec::verdict::Verdict;
use libtest_mimic::Trial;
use serde_json::Value;
use std::path::PathBuf;
use testing::{Folder, stall};

pub fn trials() -> Vec<Trial> {
    let mut trials = table![a_live_device_is_compared_with_a_capture:
        at_a_socket(XAC77, IDENTIFICATION),
        at_a_pseudoterminal(AMT58, DIAGNOSIS),
    ];
    trials.extend(table![the_bug_of_a_live_device_becomes_a_case:
        at_a_socket(XAC77, IDENTIFICATION),
        at_a_pseudoterminal(AMT58, DIAGNOSIS),
    ]);
    trials.extend(table![requests_without_consent_are_not_sent:
        at_a_socket(XAC77, "preset/absolute", "no consent to `position_reference`"),
        at_a_pseudoterminal(AMT58, "preset/every-class[class_2]", "no consent to `position_reference`"),
    ]);
    trials
}

/// How often an inconclusive comparison is repeated.
const TRIES: usize = 4;

/// A device to serve: manual, variant, and its GSDML or GSD.
#[derive(Clone, Copy)]
struct ServedModel {
    manual: &'static str,
    variant: &'static str,
    description: [&'static str; 2],
}

const XAC77: ServedModel = ServedModel {
    manual: "lika-xac77-profinet",
    variant: "xac7718",
    description: ["gsdml", "GSDML-V2.43-encspec-XAC7718-20261121.xml"],
};
const AMT58: ServedModel = ServedModel {
    manual: "datalogic-amt58-profibus",
    variant: "hs5818",
    description: ["gsd", "encspec-amt58-hs5818.gsd"],
};

/// A folder with captures, a bench file and the path of a line.
struct AgainstBench {
    folder: Folder,
    served: ServedModel,
}

impl AgainstBench {
    fn new(served: ServedModel) -> AgainstBench {
        let folder = Folder::new("against");
        AgainstBench { folder, served }
    }

    fn model(&self) -> String {
        format!("model:{}/{}", self.served.manual, self.served.variant)
    }

    /// Serves the reference device with these bugs, and writes its bench file.
    fn serve(&self, bugs: &[&str], consent: &str) -> ServeProcess {
        let line = self.folder.join("line").display().to_string();
        let _ = std::fs::remove_file(&line);
        let model = self.model();
        let suite = testing::workspace().join("suites").join(self.served.manual);
        let [kind, file] = self.served.description;
        let (option, link) = match kind {
            "gsd" => (["--pty".to_owned(), line.clone()], format!("serial:{line}")),
            _ => (["--socket".to_owned(), format!("listen:{line}")], format!("socket:{line}")),
        };
        let slave: &[&str] = if kind == "gsd" { &["--address", "8"] } else { &[] };
        let ip = if kind == "gsd" { "" } else { "ip: 192.168.0.10\nwatchdog: 500ms\n" };
        let file = suite.join(file).display().to_string();
        let text = format!(
            "device: {}/{}\nlink: {link}\n{kind}: {file}\n{ip}{consent}\n",
            self.served.manual, self.served.variant
        );
        std::fs::write(self.folder.join("bench.yaml"), text).expect("the bench file");
        let mut arguments = vec![model.as_str()];
        arguments.extend(option.iter().map(String::as_str));
        arguments.extend(slave);
        bugs.iter().for_each(|bug| arguments.extend(["--bug", *bug]));
        ServeProcess::start(&arguments)
    }

    fn call(&self, arguments: &[&str]) -> (Option<i32>, String) {
        let said = program::encspec(&self.folder, arguments);
        (said.status, said.all())
    }

    /// Records one case on the virtual wire. Returns the path of the capture.
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

    /// Exit status and JSON report of a comparison with the device. `None` if every try was inconclusive.
    fn compared(&self, capture: &str) -> Option<(Option<i32>, Value)> {
        for _ in 0..TRIES {
            let (status, said) =
                self.call(&["replay", capture, "--against", "bench.yaml", "--report", "json=out.json"]);
            let text = std::fs::read_to_string(self.folder.join("out.json")).unwrap_or_else(|_| panic!("{said}"));
            let report: Value = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{error}: {said}"));
            let against = report["captures"][0].clone();
            assert!(against["differences"].is_array(), "{said}");
            if against["inconclusive"].is_null() {
                return Some((status, against));
            }
            assert_eq!(
                against["differences"],
                Value::Array(Vec::new()),
                "an inconclusive result has no differences: {said}"
            );
        }
        None
    }
}

const IDENTIFICATION: (&str, &str) = ("parameter-values/arrays-as-a-whole[p964]", "identification-cut-short");
const DIAGNOSIS: (&str, &str) = ("diagnosis/module-information", "own-address-as-master");

/// A recording of the reference device has no differences from the served one; a recording with a bug has.
fn a_live_device_is_compared_with_a_capture(served: ServedModel, (case, bug): (&str, &str)) {
    let bench = AgainstBench::new(served);
    let (conforming, wrong) = (bench.record(case, &[]), bench.record(case, &[bug]));
    let _serving = bench.serve(&[], "consent: { alone: true }");
    let Some((status, same)) = bench.compared(&conforming) else { panic!("every try was inconclusive") };
    assert_eq!(same["differences"], Value::Array(Vec::new()), "{same:#}");
    assert_eq!(status, Some(0), "{same:#}");
    assert!(same["steps"].as_u64().is_some_and(|steps| steps > 1), "{same:#}");
    assert!(
        same["masked"].as_object().is_some_and(|masked| !masked.is_empty()),
        "the position of its shaft is masked: {same:#}"
    );
    let Some((status, other)) = bench.compared(&wrong) else { panic!("every try was inconclusive") };
    assert_eq!(status, Some(1), "{other:#}");
    assert!(other["differences"].as_array().is_some_and(|found| !found.is_empty()), "{other:#}");
}

/// `--shrink` turns the bug of a live device into a case that fails with the bug and passes without it.
fn the_bug_of_a_live_device_becomes_a_case(served: ServedModel, (case, bug): (&str, &str)) {
    let bench = AgainstBench::new(served);
    let wrong = bench.record(case, &[bug]);
    let _serving = bench.serve(&[bug], "consent: { alone: true }");
    let manuals = load(&suites::sources(), Some(served.manual)).expect("the shipped suites load");
    let drive = Drive::new(&suites::sources(), &manuals[0], served.variant).expect("the manual loads");
    stall::retry_check_on_stall(|| {
        let shrink = ["replay", &wrong, "--shrink", "--dut", "bench.yaml", "--case", "shrunk.yaml"];
        let (status, said) = bench.call(&shrink);
        if status != Some(1) {
            return Err(said);
        }
        let yaml = std::fs::read_to_string(bench.folder.join("shrunk.yaml")).map_err(|_| said.clone())?;
        for (bugs, expected) in [(vec![], Verdict::Pass), (vec![bug.to_owned()], Verdict::Fail)] {
            let kind = DutKind::Model { deviations: bugs };
            let dut = DutSpec { manual: served.manual.to_owned(), variant: served.variant.to_owned(), kind };
            let observed = drive.run(&yaml, &dut).map_err(|error| format!("{error}\n{yaml}"))?.case.verdict;
            if observed != expected {
                return Err(format!("{observed} instead of {expected}:\n{yaml}\n{said}"));
            }
        }
        Ok(())
    });
}

/// Without the consent no request is sent, and the error names the missing consent.
fn requests_without_consent_are_not_sent(served: ServedModel, case: &str, why: &str) {
    let bench = AgainstBench::new(served);
    let capture = bench.record(case, &[]);
    let _serving = bench.serve(&[], "consent: { alone: true }");
    for more in [&["--against", "bench.yaml"][..], &["--shrink", "--dut", "bench.yaml"]] {
        let call = || bench.call(&[&["replay", &capture], more].concat());
        // On a stalled host the master may never get the token.
        let calls = (0..TRIES).map(|_| call()).find(|(_, said)| !said.contains("does not get the token"));
        let (status, said) = calls.expect("a line on which the master gets the token");
        assert_eq!(status, Some(3), "{said}");
        assert!(said.contains(why), "{said}");
    }
}
