//! The reports of a hand-made run in every format, and the approved report of the whole suite on each variant.
//!
//! The approved reports are in `reports/`. Read every change before you commit it.

use crate::built_in::{self, manuals};
use crate::sample_run;
use encspec::cli::Suites;
use encspec::cli::run::RunRequest;
use encspec::engine::{RunOptions, run};
use encspec::report::{self, ConsoleOptions, ExitStatus, ReportFormat};
use encspec::result::{BusStatistics, RunResult};
use rstest::rstest;
use wire::profibus::fdl::BitTimes;

fn approved(name: &str, text: &str) {
    let mut settings = insta::Settings::clone_current();
    settings.set_snapshot_path("../../../../reports");
    settings.set_prepend_module_to_snapshot(false);
    settings.set_omit_expression(true);
    settings.bind(|| insta::assert_snapshot!(name, text));
}

#[rstest]
#[case("console", ReportFormat::Console)]
#[case("json", ReportFormat::Json)]
#[case("junit", ReportFormat::Junit)]
#[case("tap", ReportFormat::Tap)]
#[case("text", ReportFormat::Text)]
fn a_run_made_by_hand(#[case] name: &str, #[case] format: ReportFormat) {
    approved(&format!("made-by-hand.{name}"), &format.write(&sample_run::everything()));
}

#[test]
fn the_short_report_for_people() {
    let text = report::console(&sample_run::everything(), ConsoleOptions::default());
    approved("made-by-hand.console-short", &text);
}

#[test]
fn a_run_on_profibus_says_what_the_master_measured() {
    let mut bus = BusStatistics::default();
    for bits in [11, 12, 160] {
        bus.answered(3, BitTimes(bits), (BitTimes(11), BitTimes(150)));
    }
    bus.repeated(3);
    bus.unanswered(99);
    bus.rotation.add(BitTimes(500));
    let mut result = sample_run::everything();
    assert!(!report::json(&result).contains("\"bus\""), "other runs have no such key");
    result.runs[0].bus = Some(bus);
    let console = report::console(&result, ConsoleOptions::default());
    let first = "  bus           station 3: answers after 11/61/160 bits (min/mean/max; TSDR 11 to 150, 1 later), 1 retry; \
                 1 more address asked\n";
    let second = "                token rotation 500/500/500 bits (min/mean/max)\n";
    assert!(console.contains(&format!("{first}{second}")), "{console}");
    let html = report::html(&result, &|_| report::CaseEvidence::default());
    assert!(html.contains("answers after 11/61/160 bits") && html.contains("token rotation 500/500/500"));
    let json: serde_json::Value = serde_json::from_str(&report::json(&result)).expect("JSON");
    let bus = &json["runs"][0]["bus"];
    assert_eq!((&bus["min_tsdr_bits"], &bus["max_tsdr_bits"]), (&11.into(), &150.into()));
    let expected = serde_json::json!({ "min": 11, "mean": 61, "max": 160, "sum": 183 });
    assert_eq!((&bus["stations"][0]["answer_bits"], &bus["stations"][0]["after_max_tsdr"]), (&expected, &1.into()));
    assert_eq!((&bus["stations"][1]["station"], &bus["stations"][1]["unanswered"]), (&99.into(), &1.into()));
    assert_eq!((&bus["token_rotations"], &bus["rotation_bits"]["max"]), (&1.into(), &500.into()));
}

#[test]
fn the_measurements_of_all_trials_are_combined() {
    for manual in manuals() {
        let variant = &manual.variants[0];
        let selection = variant.trials[0].case().into();
        let options =
            RunOptions { duts: vec![built_in::model(manual, variant, &[])], selection, ..RunOptions::default() };
        let result = run(std::slice::from_ref(manual), &options, &|_, _, _| {}).expect("a model can be run");
        let bus = result.runs[0].bus.as_ref();
        assert_eq!(bus.is_some(), manual.device.profibus().is_some(), "{}", manual.device.name);
        if let Some(bus) = bus {
            let [least, ..] = bus.stations()[0].answers.least_mean_most().expect("the slave answers");
            assert_eq!(least, BitTimes::DEFAULT_MIN_TSDR, "{}", manual.device.name);
            assert!(bus.stations().iter().all(|of| of.late == 0) && bus.rotation.count() > 0, "{}", manual.device.name);
        }
    }
}

/// A finding of a reading is in the properties of the suite and of each failed row of its case.
#[test]
fn junit_has_findings() {
    let mut result = sample_run::everything();
    let mut finding = result.runs[0].findings[0].clone();
    (finding.id, finding.text) = ("preset/it's:printed".into(), "The octets stand as printed.".into());
    result.runs[0].findings.push(finding);
    let text = report::junit(&result);
    let property = "<property name=\"finding\" value=\"The octets stand as printed.\"/>";
    let (before, _) = text.split_once(property).expect("the failed case has the finding");
    let opened = before.rfind("<testcase ").expect("inside of a case");
    assert!(before[opened..].starts_with("<testcase name=\"it&apos;s[row 1]\""), "{}", &before[opened..]);
    assert_eq!(text.matches("The octets stand as printed.").count(), 2);
}

#[test]
fn colours_do_not_change_the_text() {
    let look = ConsoleOptions { colour: true, verbose: true, quiet: false };
    let coloured = report::console(&sample_run::everything(), look);
    let plain = report::console(&sample_run::everything(), ConsoleOptions { colour: false, ..look });
    assert_ne!(coloured, plain);
    let mut stripped = String::new();
    let mut rest = coloured.as_str();
    while let Some((before, after)) = rest.split_once("\x1b[") {
        stripped.push_str(before);
        rest = after.split_once('m').map_or("", |(_, after)| after);
    }
    stripped.push_str(rest);
    assert_eq!(stripped, plain);
}

#[rstest]
#[case(ReportFormat::Console)]
#[case(ReportFormat::Json)]
#[case(ReportFormat::Junit)]
#[case(ReportFormat::Tap)]
#[case(ReportFormat::Text)]
fn text_from_a_device_cannot_control_the_terminal(#[case] format: ReportFormat) {
    let evil = "a\u{1b}[2J\u{7}\u{9b}31m\u{202e}b\r\nINJECTED";
    let mut result = sample_run::everything();
    let run = &mut result.runs[0];
    run.dut.identity = evil.into();
    for case in &mut run.cases {
        case.reason = Some(evil.into());
        case.notes = vec![evil.into()];
        for failure in &mut case.failures {
            failure.what = evil.into();
            failure.trace = vec![evil.into()];
            failure.parts.iter_mut().for_each(|part| part.observed = evil.into());
        }
    }
    result.ledger_notes.push(encspec::result::LedgerNote { text: evil.into(), red: true });
    let text = format.write(&result);
    let is_control = |c: &char| (c.is_control() && *c != '\n') || *c == '\u{202e}';
    assert_eq!(text.chars().find(is_control), None);
    assert!(!text.contains("\nINJECTED"), "a line feed from the device starts a line");
}

/// JSON, TAP, JUnit and console report and the exit status agree on whether a run is green.
#[test]
fn the_reports_agree() {
    for gate_must in [false, true] {
        for verdict in encspec::verdict::Verdict::ALL {
            for level in [
                encspec::suite::model::Level::Must,
                encspec::suite::model::Level::Should,
                encspec::suite::model::Level::Info,
            ] {
                let good = sample_run::case(
                    "a/good",
                    encspec::result::CaseKind::Trial,
                    encspec::verdict::Verdict::Pass,
                    encspec::suite::model::Level::Must,
                );
                let other = sample_run::case("a/other", encspec::result::CaseKind::Trial, verdict, level);
                let mut result = sample_run::run(vec![good, other]);
                result.gate_must = gate_must;
                let green = report::status(&result) == ExitStatus::Green;
                let what = format!("{verdict} at {level:?}, gate_must {gate_must}");
                assert_eq!(report::json(&result).contains("\"green\": true"), green, "JSON: {what}");
                assert_eq!(tap_is_green(&report::tap(&result)), green, "TAP: {what}");
                assert_eq!(junit_is_green(&report::junit(&result)), green, "JUnit: {what}");
                assert_eq!(
                    report::console(&result, ConsoleOptions::default()).contains("\nGreen:"),
                    green,
                    "console: {what}"
                );
            }
        }
    }
}

fn tap_is_green(text: &str) -> bool {
    !text.lines().any(|line| line.starts_with("not ok") && !line.contains(" # TODO "))
}

fn junit_is_green(text: &str) -> bool {
    let suites = text.lines().find(|line| line.contains("<testsuites ")).expect("the root of the report");
    suites.contains("failures=\"0\"") && suites.contains("errors=\"0\"")
}

fn whole_suite() -> RunResult {
    let manuals = Suites::default().load().expect("the shipped suites");
    let ready = RunRequest::default().ready(&manuals).map_err(|stop| stop.message).expect("every reference device");
    ready.run(&manuals, &|_, _, _| {}).map_err(|stop| stop.message).expect("a virtual bench")
}

/// The approved report of each variant. A change in it is a change of the verdicts about a device.
#[test]
fn the_whole_suite() {
    let mut result = whole_suite();
    assert!(!result.runs.is_empty(), "there are reference devices");
    for run in std::mem::take(&mut result.runs) {
        let name = format!("{}.{}", run.dut.device, run.dut.variant);
        let one = RunResult { runs: vec![run], ..RunResult::default() };
        approved(&name, &report::text(&one));
    }
}
