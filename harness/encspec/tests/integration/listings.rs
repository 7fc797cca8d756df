//! `encspec coverage`, `errata` and `bugs` on a small manual with one requirement of each kind.

use crate::common::program;
use rstest::rstest;
use serde_json::{Value, json};
use testing::Folder;

const DEVICE: &str = "\
device: probe
bus: profinet
title: A probe
identity: { vendor_id: 0x0239, device_id: { value: 1, from_source: invented }, station_type: PROBE }
variants: [one]
timing: { reaction: 100ms, start: 10s, power_up: 10s, save: 5s }
signals:
  STW: { from: controller, width: 16, fields: { park: 14 } }
  ZSW: { from: device, width: 16, fields: { parked: 14, error: 15 } }
submodules:
  dap: { slot: 0, subslot: 1, ident: 1 }
  cyclic: { slot: 1, subslot: 1, ident: 2, octets: { out: 2, in: 2 }, outputs: [STW], inputs: [ZSW] }
modules:
  only: { ident: 1, submodules: [cyclic] }
";

const REQUIREMENTS: &str = "\
requirements:
  - { id: PRB-1, cites: section 1, statement: Plain., level: must, source: manual, channel: cyclic }
  - { id: PRB-2, cites: section 2, statement: Open., level: should, source: manual, channel: cyclic, ambiguity: How soon? }
  - { id: PRB-3, cites: section 3; section 9, statement: Torn., level: should, source: manual, channel: cyclic,
      ambiguity: 3 says so and 9 says no., class: contradictory, reading: As section 3 has it. }
  - { id: PRB-4, cites: section 4; section 8, statement: Torn too., level: should, source: manual, channel: cyclic,
      class: contradictory, reading: As section 8 has it. }
  - { id: PRB-5, cites: section 5, statement: Shown by others., level: must, source: manual, channel: cyclic,
      class: implicit, reason: PRB-1 shows it. }
  - { id: PRB-6, cites: section 6, statement: Hidden., level: must, source: manual, channel: model,
      class: untestable, reason: Nothing shows it. }
  - { id: PRB-7, cites: section 7, statement: Elsewhere., level: must, source: manual, channel: model,
      class: out-of-scope, reason: It is about a tool. }
  - { id: PRB-8, cites: section 8, statement: Later., level: must, source: manual, channel: cyclic,
      class: no-check, reason: Its check needs a second cable. }
";

const BUGS: &str = "\
bugs:
  stuck: [PRB-1, PRB-3]
  loose: [PRB-1]
";

const TOPIC: &str = "\
suite: topic
defaults: { start: { module: only } }
cases:
  - id: parks
    why: It parks.
    covers: [PRB-1]
    catches: [stuck]
    steps:
      - set: { STW.park: 1 }
      - expect: { ZSW.parked: 1 }
  - id: torn
    why: One of two.
    covers: [PRB-3]
    catches: [stuck]
    steps:
      - set: { STW.park: 1 }
      - either:
          as-section-3: [ { expect: { ZSW.parked: 1 } } ]
          as-section-9: [ { expect: { ZSW.error: 1 } } ]
rules:
  - id: never-both
    why: They exclude each other.
    covers: [PRB-2]
    catches: [loose]
    always: not (ZSW.parked and ZSW.error)
";

/// The output and the exit status.
fn encspec(test: &str, arguments: &[&str]) -> (String, Option<i32>) {
    let folder = Folder::new(test);
    for (name, text) in [("device", DEVICE), ("requirements", REQUIREMENTS), ("bugs", BUGS), ("topic", TOPIC)] {
        folder.write(&format!("suites/probe/{name}.yaml"), text);
    }
    let said = program::encspec(&folder, &[arguments, &["--suites", "suites"]].concat());
    (said.all(), said.status)
}

fn good(test: &str, arguments: &[&str]) -> String {
    let (said, status) = encspec(test, arguments);
    assert_eq!(status, Some(0), "{said}");
    said
}

fn as_json(test: &str, arguments: &[&str]) -> Value {
    serde_json::from_str(&good(test, &[arguments, &["--format", "json"]].concat())).expect("JSON")
}

/// Contradictory and implicit requirements count as covered if a case covers them. Untestable and out-of-scope requirements do not
/// count at all.
#[test]
fn coverage_counts_testable_requirements() {
    let said = as_json("counts", &["coverage", "probe"]);
    let manual = &said["manuals"][0];
    assert_eq!((&manual["total"], &manual["testable"], &manual["covered"]), (&json!(8), &json!(6), &json!(3)));
    assert_eq!(manual["uncovered"], json!(["PRB-4", "PRB-5", "PRB-8"]));
    let classes = json!({
        "covered": 2, "uncovered": 0, "no-check": 1, "implicit": 1, "untestable": 1, "out-of-scope": 1, "contradictory": 2
    });
    assert_eq!(manual["by_class"], classes);
    assert_eq!(manual["no_check"], json!([{ "id": "PRB-8", "why": "Its check needs a second cable." }]));
    let live = json!({ "link": "nic", "no_stand": ["PRB-1", "PRB-2", "PRB-3"], "with_stand": [], "never": [] });
    assert_eq!(manual["live"], live);
    let text = good("counts-text", &["coverage", "probe"]);
    assert!(text.contains("\n  live, at a network interface:\n    without a stand      3 (100.0 %)\n"), "{text}");
    assert!(text.starts_with("probe: 3 of 6 testable requirements covered (50.0 %)\n"), "{text}");
    assert!(text.contains("\n  2 untestable or out of scope (25.0 %)\n"), "{text}");
    assert!(
        text.contains("\n  not covered:\n    PRB-4 PRB-5 PRB-8\n    PRB-8: Its check needs a second cable.\n"),
        "{text}"
    );
}

#[test]
fn errata_lists_contradictions_and_open_points() {
    let text = good("errata-text", &["errata", "probe"]);
    let expected = "\
probe: 8 requirements; the manual contradicts itself on 2 and leaves something open on 1

Where probe contradicts itself

PRB-3 (should)
    Torn.
    clause: section 3
    clause: section 9
    open: 3 says so and 9 says no.
    read as: As section 3 has it.
    accepted: as-section-3 | as-section-9 (in probe/topic/torn)
    tested by probe/topic/torn

PRB-4 (should)
    Torn too.
    clause: section 4
    clause: section 8
    read as: As section 8 has it.

Where probe leaves something open

PRB-2 (should)
    Open.
    clause: section 2
    open: How soon?
    tested by probe/topic/never-both
";
    assert_eq!(text, expected);
}

#[test]
fn errata_as_json() {
    let said = as_json("errata-json", &["errata", "probe"]);
    let manual = &said["manuals"][0];
    let torn = &manual["contradictions"][0];
    assert_eq!(torn["clauses"], json!(["section 3", "section 9"]));
    assert_eq!(torn["reading"], "As section 3 has it.");
    let accepted = json!([{ "case": "probe/topic/torn", "readings": ["as-section-3", "as-section-9"] }]);
    assert_eq!(torn["accepted"], accepted);
    assert_eq!(manual["silences"].as_array().map(Vec::len), Some(1));
    assert_eq!(manual["silences"][0].get("reading"), None);
}

#[rstest]
#[case(&["bugs", "probe"], &["probe: 2 bugs; 2 of 8 requirements (25.0 %) are broken by at least one bug\n", "  stuck\n    breaks PRB-1, PRB-3\n",
    "    caught by probe/topic/torn\n", "  not broken by any bug:\n    PRB-2 PRB-4 PRB-5 PRB-6 PRB-7 PRB-8\n"])]
#[case(&["bugs", "probe", "loo"], &["  loose\n", "    breaks PRB-1, section 1\n           Plain.\n"])]
#[case(&["bugs", "probe", "prb-3"], &["  stuck\n", "    breaks PRB-3, section 3; section 9\n           Torn.\n"])]
fn bugs_are_listed_with_what_they_break(#[case] arguments: &[&str], #[case] says: &[&str]) {
    let text = good(&arguments.join("-"), arguments);
    for part in says {
        assert!(text.contains(part), "`{part}` is not in:\n{text}");
    }
    assert_eq!(text.contains("  loose\n"), arguments.last() != Some(&"prb-3"));
}

#[test]
fn bugs_as_json() {
    let said = as_json("bugs-json", &["bugs", "probe", "stuck"]);
    let manual = &said["manuals"][0];
    assert_eq!((&manual["requirements"], &manual["broken"]), (&json!(8), &json!(2)));
    assert_eq!(manual["unbroken"].as_array().map(Vec::len), Some(6));
    assert_eq!(manual["bugs"].as_array().map(Vec::len), Some(1));
    assert_eq!(manual["bugs"][0]["breaks"][1]["id"], "PRB-3");
    assert_eq!(manual["bugs"][0]["caught_by"], json!(["probe/topic/parks", "probe/topic/torn"]));
}

#[test]
fn an_unknown_bug_is_a_usage_error() {
    let (said, status) = encspec("unknown", &["bugs", "probe", "losse"]);
    assert_eq!(status, Some(2));
    assert!(said.contains("no bug name contains `losse`"), "{said}");
}
