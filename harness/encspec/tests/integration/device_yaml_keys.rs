//! Keys of `device.yaml` and names that the built-in manuals hardly use: tested with single lines of the XAC77 description changed,
//! against its reference device.

use encspec::engine::{DutKind, DutSpec, RunOptions, TrialOutcome, run_trial};
use encspec::suite_yaml::{Sources, load};
use encspec::verdict::Verdict::{self, Fail, Inconclusive, Pass};
use rstest::rstest;

const MANUAL: &str = "lika-xac77-profinet";

/// Lines of the description and their replacements.
type DeviceYamlChanges<'a> = &'a [(&'a str, &'a str)];

const XIST1: &str = "G1_XIST1: { from: device, width: 32, position_in: position_range }";
const SHIFTED: DeviceYamlChanges<'static> = &[(XIST1, "G1_XIST1: { from: device, width: 32, shift: 2 }")];
const BY_VARIANT: DeviceYamlChanges<'static> =
    &[(XIST1, "G1_XIST1: { from: device, width: 32, shift: { xac7718: 4, xac7716-16384: 0 } }")];
const MODULE: &str =
    "  telegram_81: { ident: 1, submodules: [parameter_access_point, telegram_81], from_source: invented }";
const SMALLER: DeviceYamlChanges<'static> = &[(
    MODULE,
    "  smaller: { ident: 9, submodules: [parameter_access_point] }\n  telegram_81: { ident: 1, submodules: [parameter_access_point, telegram_81], from_source: invented }",
)];
const FAULTS: &str = "stand:\n  faults:\n";
const LED: DeviceYamlChanges<'static> = &[(FAULTS, "stand:\n  leds: { bus: [dark, red] }\n  faults:\n")];
const SUPPLY: DeviceYamlChanges<'static> =
    &[(FAULTS, "stand:\n  supply: { voltage: 24, temperature: 25 }\n  switches: { hundreds: [0, 9, 3] }\n  faults:\n")];

fn sources(changes: DeviceYamlChanges<'_>, topic: &str) -> Sources {
    let path = format!("{MANUAL}/device.yaml");
    let embedded = suites::sources();
    let mut device = embedded.files().find(|(file, _)| *file == path).expect("it is there").1.to_owned();
    for (line, instead) in changes {
        assert!(device.contains(line), "{line}");
        device = device.replacen(line, instead, 1);
    }
    embedded.with(&path, device).with(&format!("{MANUAL}/tried.yaml"), topic)
}

fn steps(changes: DeviceYamlChanges<'_>, keys: &str, steps: &[&str]) -> TrialOutcome {
    let lines: String = steps.iter().map(|line| format!("      - {line}\n")).collect();
    let topic = format!(
        "suite: tried\ndefaults: {{ start: {{ module: telegram_81 }} }}\ncases:\n  - id: tried\n    why: Tries a meaning.\n    \
         covers: [XAC77-PRK-001]\n{keys}    steps:\n{lines}"
    );
    let manuals = load(&sources(changes, &topic), Some(MANUAL)).unwrap_or_else(|errors| panic!("it loads:\n{errors}"));
    let (manual, variant) = (&manuals[0], &manuals[0].variants[0]);
    let trial = variant.trials.iter().find(|trial| trial.id.ends_with("tried/tried")).expect("the trial is there");
    let kind = DutKind::Model { deviations: Vec::new() };
    let dut = DutSpec { manual: manual.device.name.clone(), variant: variant.name.clone(), kind };
    run_trial(manual, variant, &dut, trial, &RunOptions::default()).expect("a model can be run")
}

const ALIVE: &str = "read: { station.vendor_id: 0x0239 }";
const PRESET: &str = "    given:\n      - do: preset\n        give: { preset_value: 0x1230 }\n";
const PARK: &str = "set: { STW2_ENC: 0x0400, G1_STW.park: 1 }";

/// The position 0x1230 is 0x48C steps of four and 0x123 steps of sixteen; 0x1231 is no whole number of either.
#[rstest]
#[case::in_steps(
    SHIFTED,
    "expect: { G1_XIST1: 0x48C, io.inputs: \"* 00 00 12 30 .. .. .. ..\" }\n        for: 10ms",
    Pass
)]
#[case::not_raw(SHIFTED, "expect: { G1_XIST1: 0x1230 }\n        for: 10ms", Fail)]
#[case::by_variant(BY_VARIANT, "expect: { G1_XIST1: 0x123 }\n        for: 10ms", Pass)]
#[case::unchanged(&[], "expect: { G1_XIST1: 0x1230 }\n        for: 10ms", Pass)]
fn a_signal_may_be_shifted(#[case] changes: DeviceYamlChanges<'_>, #[case] check: &str, #[case] verdict: Verdict) {
    let outcome = steps(changes, PRESET, &[check]);
    assert_eq!(outcome.case.verdict, verdict, "{:?}", outcome.case.reason);
}

#[rstest]
#[case("expect: { G1_XIST1: 0x48C }\n        for: 10ms")]
#[case("expect: { G1_XIST1: { in: [0x48C, 0x48D] } }\n        for: 10ms")]
fn a_value_with_bits_below_the_shift_equals_nothing(#[case] check: &str) {
    let outcome = steps(SHIFTED, PRESET, &["turn: { counts: 1, rpm: 60 }", check]);
    assert_eq!(outcome.case.verdict, Fail, "{:?}", outcome.case.reason);
    let said = format!("{:?}", outcome.case);
    assert!(said.contains("0x00001231, of which the lowest 2 bits are not 0"), "{said}");
    assert!(said.contains("0x48C (1164), on the wire 0x00001230"), "{said}");
}

/// A module with a subset of the submodules does not hide the module in use, whose rules are judged.
#[test]
fn the_module_with_most_submodules_is_in_use() {
    let judged = |changes| {
        let outcome = steps(changes, "", &[PARK, "expect: { G1_ZSW.parked: 1 }"]);
        assert_eq!(outcome.case.verdict, Pass, "{:?}", outcome.case.reason);
        outcome.rules.iter().map(|rule| rule.decided.premises).collect::<Vec<_>>()
    };
    let plain = judged(&[]);
    assert!(plain.iter().any(|premises| *premises > 0));
    assert_eq!(judged(SMALLER), plain);
}

#[rstest]
#[case::octets_of_a_submodule("expect: { io.inputs.telegram_81: \"20 .. 20 00 *\" }\n        for: 10ms", Fail)]
#[case::octets_of_a_submodule_without_any(
    "expect: { io.inputs.parameter_access_point: \"*\" }\n        for: 10ms",
    Pass
)]
#[case::octets_of_a_submodule_that_is_not_there("expect: { io.inputs.telegram_82: any }\n        for: 10ms", Fail)]
#[case::our_octets("expect: { io.outputs.telegram_81: \".. .. 40 00\" }\n        for: 10ms", Pass)]
#[case::octets_of_a_record("read: { im0: \".. *\" }", Pass)]
#[case::other_octets_of_a_record("read: { im0: \"FF FF .. *\" }", Fail)]
#[case::frames_come_in_time("expect: elapsed >= 1ms and elapsed <= 2 * cycle\n        for: 50ms", Pass)]
#[case::frames_do_not_come_faster("expect: elapsed < cycle / 2\n        for: 50ms", Fail)]
#[case::the_port_has_the_address_of_the_device(
    "expect: { lldp: 1, lldp.source: \"10 B9 FE .. .. ..\" }\n        within: 30s",
    Pass
)]
#[case::and_no_other("expect: { lldp: 1, lldp.source: \"10 B9 FF .. .. ..\" }\n        within: 30s", Fail)]
fn a_name_has_its_value(#[case] check: &str, #[case] verdict: Verdict) {
    let outcome = steps(&[], "", &[PARK, check]);
    assert_eq!(outcome.case.verdict, verdict, "{:?}", outcome.case.reason);
}

/// From rest with 60 rpm/s: after one second the shaft has turned half a revolution, 131072 steps.
#[rstest]
#[case::by_a_ramp("set: { shaft.speed: 60, shaft.acceleration: 60 }", Pass)]
#[case::at_once("set: { shaft.speed: 60 }", Fail)]
fn a_speed_is_reached(#[case] speed: &str, #[case] verdict: Verdict) {
    let check = "expect: { G1_XIST1: { from: 0x21000, to: 0x21700 } }\n        within: 0";
    let outcome = steps(&[], PRESET, &[speed, "wait: 1s", check]);
    assert_eq!(outcome.case.verdict, verdict, "{:?}", outcome.case.reason);
}

/// No stand reads an LED of the XAC77: its state is unknown, so the case does not pass.
#[rstest]
#[case("    start: none\n")]
#[case("")]
fn an_led_that_cannot_be_read_does_not_pass(#[case] keys: &str) {
    let outcome = steps(LED, keys, &[ALIVE, "expect: { led.bus: dark }\n        for: 1s"]);
    assert_ne!(outcome.case.verdict, Pass, "{:?}", outcome.case.reason);
}

#[rstest]
#[case("set: { supply.voltage: 9.5 }")]
#[case("set: { supply.temperature: -20 }")]
#[case("set: { switch.hundreds: 9 }")]
fn an_action_that_the_stand_lacks_is_inconclusive(#[case] set: &str) {
    let outcome = steps(SUPPLY, "", &[ALIVE, set]);
    assert_eq!(outcome.case.verdict, Inconclusive, "{:?}", outcome.case.reason);
}

#[rstest]
#[case(&[(XIST1, "G1_XIST1: { from: device, width: 32, shift: 32 }")], ALIVE, "there are 32 bits only")]
#[case(&[("NIST_A:   { from: device, width: 16, signed: true }", "NIST_A:   { from: device, width: 16, signed: true, shift: 1 }")],
    ALIVE, "a number with a sign does not stand further left")]
#[case(&[(FAULTS, "stand:\n  switches: { hundreds: [0] }\n  faults:\n")], ALIVE, "two or three positions")]
#[case(&[(FAULTS, "stand:\n  switches: { hundreds: [0, 9, 10] }\n  faults:\n")], ALIVE, "is among them")]
#[case(&[], "set: { supply.voltage: 9 }", "what `supply.voltage` is put back to after a trial is not said")]
#[case(SUPPLY, "set: { switch.hundreds: 10 }", "10")]
#[case(&[], "set: { io.outputs.telegram_81: \"00 00 00 00\" }", "`io.outputs.telegram_81` has no `set`")]
fn an_invalid_description_is_refused(#[case] changes: DeviceYamlChanges<'_>, #[case] step: &str, #[case] why: &str) {
    let topic = format!(
        "suite: tried\ndefaults: {{ start: {{ module: telegram_81 }} }}\ncases:\n  - id: tried\n    why: Tries a meaning.\n    \
         covers: [XAC77-PRK-001]\n    steps:\n      - {ALIVE}\n      - {step}\n"
    );
    let errors = load(&sources(changes, &topic), Some(MANUAL)).err().map(|errors| errors.to_string());
    assert!(errors.as_ref().is_some_and(|errors| errors.contains(why)), "{errors:?}");
}
