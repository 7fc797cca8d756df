//! Captures held against the reference device: a shaft that turned is turned again, what cannot be done again is left out and said.

use crate::shipped;
use encspec::compare::drive::Bench;
use encspec::compare::heard::Heard;
use encspec::compare::hold::hold;
use encspec::compare::listen::listen;
use encspec::engine::{RunOptions, run_trial};
use encspec::replay::AgainstReport;
use encspec::suite::model::{Manual, Trial, Variant};
use rstest::rstest;
use station::Time;

/// Records a trial with these bugs, and holds the recording against the healthy reference device.
fn held(manual: &Manual, variant: &Variant, trial: &Trial, bugs: &[&str]) -> AgainstReport {
    held_against(manual, variant, trial, [bugs, &[]])
}

/// Records a trial with some bugs, and holds the recording against a device with others.
fn held_against(manual: &Manual, variant: &Variant, trial: &Trial, [bugs, others]: [&[&str]; 2]) -> AgainstReport {
    let bench = Bench::new(&suites::sources(), manual, &variant.name).expect("the manual loads");
    let masks = bench.masks(None).expect("the masks load");
    let dut = shipped::model(manual, variant, bugs);
    let outcome = run_trial(manual, variant, &dut, trial, &RunOptions::default()).expect("a model can be run");
    let frames = outcome.trace.iter().map(|frame| (frame.number as u64, frame.time, frame.octets));
    let heard = Heard { said: listen(bench.whom(), frames), begin: Time::ZERO };
    let report = hold(&bench, &shipped::model(manual, variant, others), &heard, &masks).expect("a model can be driven");
    let alike = report.differences.iter().find(|of| of.recorded == of.ours);
    assert!(alike.is_none(), "what differs does not look alike: {report}");
    report
}

/// The first trial whose id contains `part`, with its variant.
fn trial<'m>(manual: &'m Manual, part: &str) -> (&'m Variant, &'m Trial) {
    let found = |variant: &'m Variant| Some((variant, variant.trials.iter().find(|trial| trial.id.contains(part))?));
    manual.variants.iter().find_map(found).unwrap_or_else(|| panic!("{part} is a trial"))
}

/// A device that counts the wrong way shows the same places as one whose shaft turns the other way, and that is said.
#[test]
fn which_way_a_shaft_turned_is_in_no_capture() {
    let manuals = shipped::only("lika-xac77-profinet");
    let (variant, trial) = trial(&manuals[0], "position/revolutions-of-a-range");
    let report = held(&manuals[0], variant, trial, &["direction-reversed"]);
    assert!(report.shaft.contains("the real direction of the shaft is not in a capture"), "{report}");
    assert!(report.differences.is_empty(), "{report}");
}

/// A second master has no step, so what is answered behind it is not compared, and the report says so.
#[test]
fn what_cannot_be_done_again_is_left_out_and_said() {
    let manuals = shipped::only("datalogic-amt58-profibus");
    let (variant, trial) = trial(&manuals[0], "diagnosis/address-of-the-master");
    let report = held(&manuals[0], variant, trial, &[]);
    assert!(report.left_out.iter().any(|left| left.matters && left.what.contains("master 2")), "{report}");
    assert!(report.differences.is_empty(), "{report}");
    assert!(report.to_string().contains("later answers of the device are not compared"), "{report}");
}

/// Slaves follow the clock of the bus again. Where it fails, or the sign of life of the master does, the very cycle matters: what
/// is answered behind that is not compared, and the report says so.
#[rstest]
#[case("isochronous/synchronised", "never-synchronised", None)]
#[case("isochronous/bus-cycles[8ms]", "never-synchronised", None)]
#[case("isochronous/clock-lost", "never-synchronised", Some("the clock of isochronous mode was missing"))]
#[case("signals/no-sign-of-life-outside-isochronous-mode", "never-synchronised", Some("did not advance"))]
#[case("isochronous/life-sign-lost", "never-synchronised", Some("the master's sign of life did not advance"))]
fn a_clock_of_the_bus_runs_again(#[case] part: &str, #[case] bug: &str, #[case] left: Option<&str>) {
    let manuals = shipped::only("sick-a3m60-profibus");
    let (variant, trial) = trial(&manuals[0], part);
    let report = held(&manuals[0], variant, trial, &[]);
    assert!(report.differences.is_empty(), "{report}");
    let found = report.left_out.iter().find(|of| of.matters).map(|of| of.what.as_str());
    assert_eq!(found.is_some(), left.is_some(), "{report}");
    assert!(found.zip(left).is_none_or(|(found, left)| found.contains(left)), "{report}");
    let report = held(&manuals[0], variant, trial, &[bug]);
    assert!(!report.differences.is_empty(), "{bug} shows");
}

/// What is set by DCP while a connection stands, or before it, is set again.
#[rstest]
#[case("lika-xac77-profinet", "station/renamed-in-data-exchange")]
#[case("profinet-io", "protocol-discovery")]
fn what_is_set_by_dcp_is_set_again(#[case] name: &str, #[case] part: &str) {
    let manuals = shipped::only(name);
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

/// A velocity that is measured once a second shows nothing where it was only measured at another time, and its sign all the same.
#[test]
fn a_velocity_may_be_measured_at_another_time() {
    let manuals = shipped::only("kuebler-sendix58xx-profinet");
    let (variant, trial) = trial(&manuals[0], "velocity/once-a-second[mantel860]");
    let healthy = held(&manuals[0], variant, trial, &[]);
    assert!(healthy.differences.is_empty() && healthy.inconclusive.is_none(), "{healthy}");
    assert!(healthy.shaft.contains("velocity is updated every 1000 ms"), "{healthy}");
    let inverted = held_against(&manuals[0], variant, trial, [&[], &["speed-sign-inverted"]]);
    assert!(inverted.differences.iter().any(|of| of.name == "velocity"), "{inverted}");
}

/// Who is asked for a module that it is not is asked for it again, and does not come to data again.
#[rstest]
#[case::in_the_head("device-identity/other-access-point[dap-1]")]
#[case::behind_it("leds/wrong-module")]
fn a_module_that_is_not_there_is_asked_for_again(#[case] part: &str) {
    let manuals = shipped::only("kuebler-sendix58xx-profinet");
    let (variant, trial) = trial(&manuals[0], part);
    let report = held(&manuals[0], variant, trial, &[]);
    assert!(report.differences.is_empty() && report.inconclusive.is_none() && report.steps > 0, "{report}");
}

/// A request for parameters at a place where there are none is asked there again, and is refused there again.
#[rstest]
#[case("sick-afx60-profinet")]
#[case("kuebler-sendix58xx-profinet")]
fn a_request_at_another_place_is_asked_there_again(#[case] name: &str) {
    let manuals = shipped::only(name);
    let (variant, trial) = trial(&manuals[0], "parameter-requests/other-places");
    let report = held(&manuals[0], variant, trial, &[]);
    assert!(report.differences.is_empty() && report.inconclusive.is_none(), "{report}");
}

/// A difference in cyclic data names the packet, the octet and the bit, and how to find it.
#[test]
fn a_difference_says_where_it_stands() {
    let manuals = shipped::only("lika-xac77-profinet");
    let (variant, trial) = trial(&manuals[0], "parking/stays-parked");
    let report = held(&manuals[0], variant, trial, &["parking-ignored"]);
    let parked = report.differences.iter().find(|of| of.name == "G1_ZSW.parked").expect("it is not parked");
    // Behind 14 octets of Ethernet, the frame id, and the status of the slot 0: ZSW2_ENC, then G1_ZSW, whose bit 14 is bit 6 of
    // its first octet.
    assert_eq!(parked.bit, Some(6), "{report}");
    let sign = report.to_string();
    assert!(sign.contains("bit 6]"), "{sign}");
    assert_eq!(parked.filter.as_deref(), Some(format!("frame.number == {}", parked.frame).as_str()));
    let json = serde_json::to_value(&report).expect("JSON");
    assert!(json["differences"][0]["octet"].is_u64() && json["differences"][0]["filter"].is_string(), "{json:#}");
}

/// A recording of a healthy encoder that turned differs in nothing; with a bug that the movement shows it does.
#[rstest]
#[case("lika-xac77-profinet", "velocity/sign-of-the-movement[counterclockwise-forward]", "speed-ignores-code-sequence")]
#[case("lika-xac77-profinet", "position/revolutions-of-a-range", "range-ignored")]
#[case("sick-afx60-profinet", "velocity/scaled-velocity[counterclockwise]", "speed-ignores-code-sequence")]
#[case("kuebler-sendix58xx-profinet", "telegrams/velocity-at-the-end[mantel860-backward]", "speed-without-sign")]
#[case("sick-a3m60-profibus", "velocity/sign[io-counterclockwise]", "speed-ignores-code-sequence")]
#[case("datalogic-amt58-profibus", "velocity/sign[counterclockwise-forward]", "speed-ignores-code-sequence")]
fn a_shaft_that_turned_is_turned_again(#[case] name: &str, #[case] part: &str, #[case] bug: &str) {
    let manuals = shipped::only(name);
    let (variant, trial) = trial(&manuals[0], part);
    let healthy = held(&manuals[0], variant, trial, &[]);
    assert_eq!(healthy.inconclusive, None);
    assert!(healthy.shaft.contains("turned with"), "{healthy}");
    assert!(healthy.differences.is_empty(), "{healthy}");
    let wrong = held(&manuals[0], variant, trial, &[bug]);
    assert!(!wrong.differences.is_empty(), "{bug}: {wrong}");
}
