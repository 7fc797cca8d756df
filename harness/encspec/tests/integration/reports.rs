//! The reports of a hand-made run in every format, and the approved report of the whole suite on each variant.
//!
//! The approved reports are in `reports/`. Read every change before you commit it.

use crate::sample_run;
use encspec::cli::Suites;
use encspec::cli::run::RunRequest;
use encspec::report::{self, ConsoleOptions, ExitStatus, ReportFormat};
use encspec::result::RunResult;
use rstest::rstest;

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
    let look = ConsoleOptions { colour: true, verbose: true };
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
