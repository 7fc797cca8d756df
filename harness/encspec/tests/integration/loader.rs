//! The loader: a small manual of each bus, and how records, parameters and common suites are loaded.

use crate::small_manual::{DEVICE, TOPIC, profibus, profinet};
use encspec::suite::model::{AnswerMatcher, AnswerPart, ConnectionStart, StartDeviation, StartParameter, Verb};
use encspec::suite_yaml::load;
use rstest::rstest;
use std::time::Duration;

/// Requirements of the case itself.
const ITSELF: &str = "    covers: [PRB-1]\n";

#[test]
fn the_small_manual_loads() {
    if let Err(errors) = load(&profinet(), None) {
        panic!("{errors}");
    }
}

#[test]
fn unused_definitions_are_listed() {
    let manuals = load(&profinet(), None).expect("it loads");
    let unused: Vec<&str> = manuals[0].unused.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(
        unused,
        [
            "signal `SPD`",
            "field `only_long.level`",
            "record `longer`",
            "field `longer.scaling_in_use`",
            "field `longer.state`",
            "fault `memory`",
            "role `position`",
        ]
    );
}

#[test]
fn an_unknown_manual_is_named() {
    let errors = load(&profinet(), Some("prboe")).expect_err("there is none");
    assert_eq!(errors.to_string(), "suites: there is no manual `prboe`\n   = did you mean `probe`?");
}

/// A check with its own `covers` does not count for the requirements of the case. A case may have no requirements if only such checks
/// can fail (for the opposite see the folders `load_errors/probe/more/*-of-their-own` and `*-of-its-own`).
#[rstest]
#[case("", "- read: { P922: 81 }\n        covers: [PRB-1]")]
#[case("", "- send: { dcp_signal: {} }\n      - read: { P922: 81 }\n        covers: [PRB-1]")]
#[case("", "- write: { P971: 1 }\n      - expect: ZSW.parked\n        covers: [PRB-1]")]
#[case("", "- steps: [ { expect: ZSW.parked, covers: [PRB-1] } ]")]
#[case(ITSELF, "- read: { P922: 81 }\n        covers: [PRB-1]\n      - expect: ZSW.parked")]
#[case(ITSELF, "- read: { P922: 81 }\n        covers: [PRB-1]\n      - steps: [ { expect: ZSW.parked } ]")]
#[case(
    ITSELF,
    "- read: { P922: 81 }\n        covers: [PRB-1]\n      - send: { dcp_signal: {} }\n        answer: accepted"
)]
#[case(ITSELF, "- observe: [ { always: ZSW.parked } ]\n        steps: [ { read: { P922: 81 }, covers: [PRB-1] } ]")]
fn requirements_that_a_check_can_fail(#[case] covers: &str, #[case] steps: &str) {
    let topic = format!(
        "suite: more\ndefaults: {{ start: {{ module: long }} }}\ncases:\n  - id: blind\n    why: Nothing.\n{covers}    steps:\n      {steps}\n"
    );
    if let Err(errors) = load(&profinet().with("probe/more.yaml", topic), None) {
        panic!("{errors}");
    }
}

/// A record may belong to the start-up of some modules only, two records may go to one submodule, and one index may have different
/// layouts for writing and reading.
#[test]
fn records_of_the_start_up() {
    let topic = TOPIC.replacen("connect: { module: short, scaling", "connect: { module: long, level: 3, scaling", 1);
    let topic =
        topic.replacen("- read: { page.level: 3 }", "- read: { longer.scaling_in_use: enabled, longer.state: 1 }", 1);
    let manuals = load(&profinet().with("probe/topic.yaml", topic), None).unwrap_or_else(|errors| panic!("{errors}"));
    let device = &manuals[0].device;
    let fields = |start: &ConnectionStart| -> Vec<(String, i128)> {
        let field = |of: &StartParameter| device.records[of.record].fields[of.field].name.clone();
        start.parameters.iter().map(|of| (field(of), of.value)).collect()
    };
    let trials = &manuals[0].variants[0].trials;
    let first = trials.iter().find(|trial| trial.id == "topic/first[on]").and_then(|trial| trial.start());
    let expected = [("scaling".to_owned(), 0), ("range".to_owned(), 4096), ("level".to_owned(), 7)];
    assert_eq!(fields(first.expect("it connects")), expected);
    let short = load(&profinet(), None).expect("it loads");
    let second = short[0].variants[0].trials.iter().find(|trial| trial.id == "topic/second").expect("it is there");
    let Some(Verb::Connect { start, .. }) = second.how().steps.first().map(|step| &step.verb) else {
        panic!("it connects first")
    };
    assert_eq!(
        fields(start),
        expected[..2].iter().map(|(name, value)| (name.clone(), if *value == 0 { 1 } else { 100 })).collect::<Vec<_>>()
    );
}

/// The default parameter access is that of the drive profile; each part of it can be overridden.
#[rstest]
#[case("", (0xB02E, None, 1, 971))]
#[case("parameter_access: { at: pap }", (0xB02E, Some("pap"), 1, 971))]
#[case("parameter_access: { index: 47, do_id: 255 }", (47, None, 255, 971))]
#[case("parameter_access: { save: P972 }", (0xB02E, None, 1, 972))]
fn the_parameter_access(#[case] says: &str, #[case] expected: (u16, Option<&str>, u8, u16)) {
    let device =
        DEVICE.replacen("codes: {", &format!("  P972: {{ type: u16, access: read_write }}\n{says}\ncodes: {{"), 1);
    let manuals = load(&profinet().with("probe/device.yaml", device), None).unwrap_or_else(|errors| panic!("{errors}"));
    let device = &manuals[0].device;
    let access = device.parameter_access;
    let at = device.profinet().and_then(|facts| facts.parameter_point).map(|at| device.submodules[at].name.as_str());
    assert_eq!((access.index, at, access.do_id, access.save), expected);
}

#[test]
fn a_manual_selects_rows_and_variants_of_a_common_case() {
    let manuals = load(&profinet(), None).expect("it loads");
    let ids = |variant: usize| -> Vec<&str> {
        let trials = &manuals[0].variants[variant].trials;
        trials.iter().filter_map(|trial| trial.id.strip_prefix("wide/")).collect()
    };
    assert_eq!(ids(0), ["table[1]", "table[only]", "own[1]"]);
    assert_eq!(ids(1), ["table[1]", "more[usual]", "more[unusual]", "own[1]"]);
    let trials = &manuals[0].variants[1].trials;
    let more = trials.iter().find(|trial| trial.id == "wide/more[unusual]").expect("it is there");
    assert_eq!((more.covers.as_slice(), more.catches.as_slice()), (&[0][..], &["stuck".to_owned()][..]));
    let rules: Vec<&str> = manuals[0].variants[0].rules.iter().map(|rule| rule.id.as_str()).collect();
    assert_eq!(rules, ["topic/never-both", "topic/parks", "wide/follows", "wide/own-rule"]);
}

#[test]
fn the_small_slave_loads() {
    let manuals = load(&profibus(), None).unwrap_or_else(|errors| panic!("{errors}"));
    let device = &manuals[0].device;
    let slave = device.profibus().expect("it is on PROFIBUS");
    assert_eq!((slave.address, slave.set_prm.dpv1, slave.ident), (5, Some([0x80, 0, 0]), 0x0C0A));
    assert_eq!(device.modules[1].cfg(), [0xD3, 0xE1]);
    assert_eq!((device.parameter_access.index, slave.parameter_slot), (47, 1));
    let unused: Vec<&str> = manuals[0].unused.iter().map(|(name, _)| name.as_str()).collect();
    let left = [
        "word `kind.single`",
        "code `diagnosis_error.amplitude`",
        "field `preset.value`",
        "signal `speed`",
        "switch `address`",
        "role `position`",
    ];
    assert_eq!(unused, left);
}

#[test]
fn parameters_of_a_module_are_sent_unless_the_case_overrides_them() {
    let manuals = load(&profibus(), None).expect("it loads");
    let trials = &manuals[0].variants[0].trials;
    let first = trials[0].start().expect("a connection");
    assert_eq!(first.parameters.iter().map(|of| of.value).collect::<Vec<_>>(), [0, 0, 100]);
    assert_eq!(first.watchdog(&manuals[0].device), Duration::from_millis(100));
    let cycles = trials.iter().find(|trial| trial.id == "topic/cycles").expect("it is there");
    let start = cycles.start().expect("a connection");
    assert_eq!(start.cycle(&manuals[0].device), Duration::from_millis(1));
    assert_eq!(start.watchdog(&manuals[0].device), Duration::from_secs(1));
    let refused = trials.iter().find(|trial| trial.id == "topic/configuration[bytes]").expect("it is there");
    let Verb::Connect { start, answer: Some(AnswerMatcher::Parts(parts)), .. } = &refused.how().steps[0].verb else {
        panic!("it connects and expects an answer");
    };
    assert_eq!(start.instead, [StartDeviation::ChkCfg(vec![0xF0])]);
    assert_eq!(parts[0].0, AnswerPart::SetPrm);
    let Verb::Connect { start, .. } = &refused.how().steps[1].verb else { panic!("it connects") };
    assert_eq!(start.parameters.iter().map(|of| of.value).collect::<Vec<_>>(), [1, 1, 4096]);
}

#[test]
fn a_diagnosis_is_parsed_as_device_yaml_describes() {
    let manuals = load(&profibus(), None).expect("it loads");
    let slave = manuals[0].device.profibus().expect("it is on PROFIBUS");
    let blocks = slave.diagnosis.blocks.as_ref().expect("it has blocks");
    assert_eq!(blocks.codes(&[0, 12, 0, 2, 12, 10]), Some(vec![]));
    assert_eq!(blocks.codes(&[8, 12, 0, 2, 12, 10, 0x81, 0x40, 0x38, 0x81, 0x40, 0x36]), Some(vec![0x38, 0x36]));
    assert_eq!(blocks.codes(&[8, 12, 0, 2, 12, 10, 0x81, 0x40]), None, "cut off");
    assert_eq!(blocks.codes(&[8, 12, 0, 2, 12, 10, 0x81, 0x41, 0x38]), None, "another channel");
    let offset = &slave.diagnosis.fields[1];
    let mut octets = [0; 14];
    octets[10..].copy_from_slice(&(-2_i32).to_be_bytes());
    assert_eq!((offset.number_in(&octets), offset.number_in(&octets[..13])), (Some(-2), None));
}
