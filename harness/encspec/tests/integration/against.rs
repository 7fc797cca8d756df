//! `encspec replay --against` with the reference device: the shaft is turned as in the capture; requests that cannot be repeated are
//! left out and listed.

use crate::built_in;
use encspec::compare::capture::compare_capture;
use encspec::compare::conversation::RecordedConversation;
use encspec::compare::drive::ScriptBench;
use encspec::compare::extract::extract;
use encspec::engine::{RunOptions, run_trial};
use encspec::replay::AgainstReport;
use encspec::suite::model::{Manual, SuiteVariant, Trial};
use rstest::rstest;
use station::Time;

/// Records a trial with these bugs and compares the recording with the reference device.
fn held(manual: &Manual, variant: &SuiteVariant, trial: &Trial, bugs: &[&str]) -> AgainstReport {
    held_against(manual, variant, trial, [bugs, &[]])
}

/// Records a trial with some bugs and compares the recording with a device that has others.
fn held_against(manual: &Manual, variant: &SuiteVariant, trial: &Trial, [bugs, others]: [&[&str]; 2]) -> AgainstReport {
    let bench = ScriptBench::new(&suites::sources(), manual, &variant.name).expect("the manual loads");
    let masks = bench.masks(None).expect("the masks load");
    let dut = built_in::model(manual, variant, bugs);
    let outcome = run_trial(manual, variant, &dut, trial, &RunOptions::default()).expect("a model can be run");
    let frames = outcome.trace.iter().map(|frame| (frame.number as u64, frame.time, frame.octets));
    let heard = RecordedConversation { conversation: extract(bench.manual_variant(), frames), begin: Time::ZERO };
    let report = compare_capture(&bench, &built_in::model(manual, variant, others), &heard, &masks)
        .expect("a model can be driven");
    let equal = report.differences.iter().find(|of| of.recorded == of.ours);
    assert!(equal.is_none(), "a difference with two equal texts: {report}");
    report
}

/// The first trial whose id contains `part`, with its variant.
fn trial<'m>(manual: &'m Manual, part: &str) -> (&'m SuiteVariant, &'m Trial) {
    let found =
        |variant: &'m SuiteVariant| Some((variant, variant.trials.iter().find(|trial| trial.id.contains(part))?));
    manual.variants.iter().find_map(found).unwrap_or_else(|| panic!("{part} is a trial"))
}

/// A device that counts in the wrong direction shows the same positions as one whose shaft turns in the other direction. The report
/// says so.
#[test]
fn a_capture_does_not_show_the_direction_of_the_shaft() {
    let manuals = built_in::only("lika-xac77-profinet");
    let (variant, trial) = trial(&manuals[0], "position/revolutions-of-a-range");
    let report = held(&manuals[0], variant, trial, &["direction-reversed"]);
    assert!(report.shaft.contains("the real direction of the shaft is not in a capture"), "{report}");
    assert!(report.differences.is_empty(), "{report}");
}

/// The suite language has no step for a second master, so answers after it are not compared. The report says so.
#[test]
fn requests_that_cannot_be_repeated_are_listed() {
    let manuals = built_in::only("datalogic-amt58-profibus");
    let (variant, trial) = trial(&manuals[0], "diagnosis/address-of-the-master");
    let report = held(&manuals[0], variant, trial, &[]);
    assert!(report.left_out.iter().any(|left| left.matters && left.what.contains("master 2")), "{report}");
    assert!(report.differences.is_empty(), "{report}");
    assert!(report.to_string().contains("later answers of the device are not compared"), "{report}");
}

/// Slaves synchronise with the bus clock again. If the clock or the master's sign of life failed, the exact cycle matters: answers
/// after that are not compared. The report says so.
#[rstest]
#[case("isochronous/synchronised", "never-synchronised", None)]
#[case("isochronous/bus-cycles[8ms]", "never-synchronised", None)]
#[case("isochronous/clock-lost", "never-synchronised", Some("the clock of isochronous mode was missing"))]
#[case("isochronous/life-sign-lost", "never-synchronised", Some("the master's sign of life did not advance"))]
fn the_bus_clock_runs_as_recorded(#[case] part: &str, #[case] bug: &str, #[case] left: Option<&str>) {
    let manuals = built_in::only("sick-a3m60-profibus");
    let (variant, trial) = trial(&manuals[0], part);
    let report = held(&manuals[0], variant, trial, &[]);
    assert!(report.differences.is_empty(), "{report}");
    let found = report.left_out.iter().find(|of| of.matters).map(|of| of.what.as_str());
    assert_eq!(found.is_some(), left.is_some(), "{report}");
    assert!(found.zip(left).is_none_or(|(found, left)| found.contains(left)), "{report}");
    let report = held(&manuals[0], variant, trial, &[bug]);
    assert!(!report.differences.is_empty(), "{bug} shows");
}

/// DCP settings before and during a connection are repeated.
#[rstest]
#[case("lika-xac77-profinet", "station/renamed-in-data-exchange")]
#[case("profinet-io", "protocol-discovery")]
fn dcp_settings_are_repeated(#[case] name: &str, #[case] part: &str) {
    let manuals = built_in::only(name);
    let trials =
        manuals[0].variants.iter().flat_map(|variant| variant.trials.iter().map(move |trial| (variant, trial)));
    let mut driven = 0;
    for (variant, trial) in trials.filter(|(_, trial)| trial.id.contains(part)) {
        let report = held(&manuals[0], variant, trial, &[]);
        assert!(report.differences.is_empty(), "{}: {report}", trial.id);
        driven += usize::from(report.inconclusive.is_none());
    }
    assert!(driven > 0, "{name}");
}

/// A velocity that is updated once a second may differ by the time of the update, but not in its sign.
#[test]
fn a_velocity_may_be_updated_at_another_time() {
    let manuals = built_in::only("kuebler-sendix58xx-profinet");
    let (variant, trial) = trial(&manuals[0], "velocity/once-a-second[mantel860]");
    let conforming = held(&manuals[0], variant, trial, &[]);
    assert!(conforming.differences.is_empty() && conforming.inconclusive.is_none(), "{conforming}");
    assert!(conforming.shaft.contains("velocity is updated every 1000 ms"), "{conforming}");
    let inverted = held_against(&manuals[0], variant, trial, [&[], &["speed-sign-inverted"]]);
    assert!(inverted.differences.iter().any(|of| of.name == "velocity"), "{inverted}");
}

/// A request for a wrong module is repeated, and again no data are exchanged.
#[rstest]
#[case::in_the_head("device-identity/other-access-point[dap-1]")]
#[case::behind_it("leds/wrong-module")]
fn a_request_for_a_wrong_module_is_repeated(#[case] part: &str) {
    let manuals = built_in::only("kuebler-sendix58xx-profinet");
    let (variant, trial) = trial(&manuals[0], part);
    let report = held(&manuals[0], variant, trial, &[]);
    assert!(report.differences.is_empty() && report.inconclusive.is_none() && report.steps > 0, "{report}");
}

/// A parameter request at a slot without parameters is repeated there and refused again.
#[rstest]
#[case("sick-afx60-profinet")]
#[case("kuebler-sendix58xx-profinet")]
fn a_request_at_another_slot_is_repeated_there(#[case] name: &str) {
    let manuals = built_in::only(name);
    let (variant, trial) = trial(&manuals[0], "parameter-requests/other-places");
    let report = held(&manuals[0], variant, trial, &[]);
    assert!(report.differences.is_empty() && report.inconclusive.is_none(), "{report}");
}

/// A difference in cyclic data has the packet, byte, bit and a display filter.
#[test]
fn a_difference_has_its_position() {
    let manuals = built_in::only("lika-xac77-profinet");
    let (variant, trial) = trial(&manuals[0], "parking/stays-parked");
    let report = held(&manuals[0], variant, trial, &["parking-ignored"]);
    let parked = report.differences.iter().find(|of| of.name == "G1_ZSW.parked").expect("it is not parked");
    // After 14 bytes of Ethernet header, the frame id and the status of slot 0: ZSW2_ENC, then G1_ZSW, whose bit 14 is bit 6 of its
    // first byte.
    assert_eq!(parked.bit, Some(6), "{report}");
    let text = report.to_string();
    assert!(text.contains("bit 6]"), "{text}");
    assert_eq!(parked.filter.as_deref(), Some(format!("frame.number == {}", parked.frame).as_str()));
    let json = serde_json::to_value(&report).expect("JSON");
    assert!(json["differences"][0]["octet"].is_u64() && json["differences"][0]["filter"].is_string(), "{json:#}");
}

/// The recording of a conforming encoder that turned has no differences; with a bug that the movement shows it has.
#[rstest]
#[case("lika-xac77-profinet", "velocity/sign-of-the-velocity[clockwise-forward]", "speed-sign-inverted")]
#[case("lika-xac77-profinet", "position/revolutions-of-a-range", "range-ignored")]
#[case("sick-afx60-profinet", "velocity/highest-velocity[-6000]", "speed-without-sign")]
#[case("kuebler-sendix58xx-profinet", "telegrams/velocity-at-the-end[mantel860-backward]", "speed-without-sign")]
#[case("sick-a3m60-profibus", "velocity/sign[io-counterclockwise]", "speed-ignores-code-sequence")]
#[case("datalogic-amt58-profibus", "velocity/sign[clockwise-backward]", "speed-units-exchanged")]
fn the_shaft_is_turned_as_recorded(#[case] name: &str, #[case] part: &str, #[case] bug: &str) {
    let manuals = built_in::only(name);
    let (variant, trial) = trial(&manuals[0], part);
    let conforming = held(&manuals[0], variant, trial, &[]);
    assert_eq!(conforming.inconclusive, None);
    assert!(conforming.shaft.contains("turned with"), "{conforming}");
    assert!(conforming.differences.is_empty(), "{conforming}");
    let wrong = held(&manuals[0], variant, trial, &[bug]);
    assert!(!wrong.differences.is_empty(), "{bug}: {wrong}");
}
