//! Runs read back from their JSON, merged from parts, and compared with each other.

use crate::common::program::encspec;
use crate::sample_run;
use encspec::cli::Suites;
use encspec::cli::filter::FilterArgs;
use encspec::cli::run::RunRequest;
use encspec::report::diff::{ChangeKind, RunDiff};
use encspec::report::{self, ExitStatus};
use encspec::result::{CaseKind, DescriptionKind, RunPart, RunResult};
use encspec::results::merge::{MergeError, MergedReport, merge};
use encspec::suite::model::Level;
use encspec::suite::model::Manual;
use encspec::verdict::Verdict::{self, Fail, Inconclusive, NotApplicable, NotRun, Pass, Xfail, Xpass};
use rstest::rstest;
use std::sync::LazyLock;
use testing::Folder;

const XAC77: &str = "model:lika-xac77-profinet/xac7718";
const AMT58: &str = "model:datalogic-amt58-profibus/hm5816-16384";
const SPLIT: &str = "preset/";

static MANUALS: LazyLock<Vec<Manual>> = LazyLock::new(|| Suites::default().load().expect("the shipped suites"));

/// Runs a reference device, with a bug if it is not empty.
fn run(dut: &str, bug: &str, filters: &[&str], part: Option<(usize, usize)>) -> RunResult {
    let request = RunRequest {
        duts: vec![dut.to_owned()],
        bugs: Some(bug.to_owned()).into_iter().filter(|bug| !bug.is_empty()).collect(),
        filter: FilterArgs { filters: filters.iter().map(|of| (*of).to_owned()).collect(), ..FilterArgs::default() },
        part: part.map(|(number, of)| format!("{number}/{of}").parse().expect("a part")),
        ..RunRequest::default()
    };
    let ready = request.ready(&MANUALS).map_err(|stop| stop.message).expect("a reference device");
    ready.run(&MANUALS, &|_, _, _| {}).map_err(|stop| stop.message).expect("a virtual bench")
}

/// A report with this name, as it is after its way through a file.
fn report_of(name: &str, result: &RunResult) -> MergedReport {
    let (version, result) = report::read(&report::json(result)).expect("a report");
    MergedReport { name: name.to_owned(), version, result }
}

/// The parts of a run in reverse order.
fn parts(dut: &str, bug: &str, filters: &[&str], of: usize) -> Vec<MergedReport> {
    let part = |number| report_of(&format!("{number}.json"), &run(dut, bug, filters, Some((number, of))));
    (1..=of).rev().map(part).collect()
}

#[rstest]
#[case::conforming(XAC77, "", &[], 4)]
#[case::with_bug(XAC77, "only-first-preset", &[], 3)]
#[case::filtered(XAC77, "only-first-preset", &[SPLIT], 3)]
#[case::profibus(AMT58, "", &[], 5)]
fn merged_parts_give_the_report_of_the_whole_run(
    #[case] dut: &str,
    #[case] bug: &str,
    #[case] filters: &[&str],
    #[case] of: usize,
) {
    let whole = run(dut, bug, filters, None);
    let mut merged = merge(parts(dut, bug, filters, of)).expect("all parts");
    // Which failures have a common cause is found again by the command, which has the suites.
    merged.runs[0].causes = whole.runs[0].causes.clone();
    assert!(whole.runs[0].cases.len() > 10);
    assert_eq!(report::status(&merged), report::status(&whole));
    let (merged, whole) = (report::json(&merged), report::json(&whole));
    let difference = merged.lines().zip(whole.lines()).find(|(one, other)| one != other);
    assert_eq!(difference, None);
    assert_eq!(merged.len(), whole.len());
}

#[test]
fn a_report_that_is_read_and_written_is_the_same() {
    let mut sample = sample_run::everything();
    let mut gsd = sample.runs[0].findings[0].clone();
    gsd.description = Some((DescriptionKind::Gsd, "14 octets".into()));
    sample.runs[0].findings.push(gsd);
    sample.runs[0].cases[1].passed_in_attempt = Some(2);
    sample.runs[0].dut.firmware = Some("1.3.0".into());
    sample.runs[0].bug_notes = vec!["a: b".into()];
    sample.gate_must = true;
    sample.fail_on_not_applicable = true;
    sample.accept_flaky = true;
    sample.min_pass = Some("80%".parse().expect("a percentage"));
    sample.repeat = vec!["--suites".into(), "a b".into()];
    sample.filters = vec!["!preset".into()];
    sample.part = Some(RunPart { number: 2, of: 3 });
    sample.unmatched_entries = vec!["ledger entry FW-1 for a".into()];
    sample.origin.commit = Some("0123456".into());
    sample.origin.started = Some("2026-11-28T04:05:06Z".into());
    sample.origin.host = Some("bench".into());
    for result in [sample, run(AMT58, "", &[SPLIT], None)] {
        let text = report::json(&result);
        let (version, read) = report::read(&text).expect("a report");
        assert_eq!(version, env!("CARGO_PKG_VERSION"));
        assert_eq!(report::json(&read), text);
        assert_eq!(report::text(&read), report::text(&result));
        assert_eq!(report::junit(&read), report::junit(&result));
    }
}

#[rstest]
#[case::empty("", "EOF")]
#[case::other_json("{}", "missing field `tool`")]
#[case::last_run(r#"{"runs": []}"#, "missing field `tool`")]
#[case::replay(
    r#"{"tool":{"name":"wireshark","version":"4"},"gate":"must","ledger_notes":[],"runs":[]}"#,
    "`wireshark`"
)]
fn another_text_is_no_report(#[case] text: &str, #[case] says: &str) {
    let error = report::read(text).expect_err("no report").to_string();
    assert!(error.starts_with("not a JSON report of `encspec run`: ") && error.contains(says), "{error}");
}

#[test]
fn an_unknown_verdict_is_no_pass() {
    let text = report::json(&sample_run::everything()).replacen("\"verdict\": \"pass\"", "\"verdict\": \"passed\"", 1);
    let error = report::read(&text).expect_err("an unknown verdict").to_string();
    assert!(error.contains("`passed` is no verdict at line"), "{error}");
}

/// A part with one case, and with one rule of this verdict.
fn part(number: usize, of: usize, rule: Verdict) -> MergedReport {
    let case = sample_run::case(&format!("a/{number}"), CaseKind::Trial, Pass, Level::Must);
    let mut rule = sample_run::case("rules/one", CaseKind::Rule, rule, Level::Must);
    rule.reason = (rule.verdict == NotRun).then(|| "the premise never occurred in 9 frames and events".to_owned());
    rule.decided = Some(encspec::result::DecisionCounts { premises: 0, undecided: 0, checked: 9 });
    let mut result = sample_run::run(vec![case, rule]);
    result.part = Some(RunPart { number, of });
    result.runs[0].filtered = true;
    MergedReport { name: format!("{number}.json"), version: "1.0.0".into(), result }
}

/// The verdict of a rule over two parts; `fail` is the worst, and what one part excuses or decides holds for all.
#[rstest]
#[case(Pass, NotRun, Pass)]
#[case(NotRun, NotRun, NotRun)]
#[case(Fail, Pass, Fail)]
#[case(Fail, Xfail, Fail)]
#[case(Inconclusive, Pass, Inconclusive)]
#[case(Xfail, Xpass, Xfail)]
#[case(Xpass, NotRun, Xpass)]
#[case(NotApplicable, Pass, Pass)]
fn a_rule_over_all_parts(#[case] one: Verdict, #[case] other: Verdict, #[case] expected: Verdict) {
    for verdicts in [[one, other], [other, one]] {
        let merged = merge(vec![part(1, 2, verdicts[0]), part(2, 2, verdicts[1])]).expect("two parts");
        let ids: Vec<&str> = merged.runs[0].cases.iter().map(|case| case.id.as_str()).collect();
        assert_eq!(ids, ["acme-profinet/a/1", "acme-profinet/a/2", "acme-profinet/rules/one"]);
        assert_eq!(merged.runs[0].cases[2].verdict, expected);
    }
}

#[test]
fn a_rule_that_no_part_decided_makes_the_merged_run_red() {
    let reports = vec![part(1, 2, NotRun), part(2, 2, NotRun)];
    assert_eq!(report::status(&reports[0].result), ExitStatus::Green);
    let merged = merge(reports).expect("two parts");
    let rule = &merged.runs[0].cases[2];
    let reason =
        "the premise never occurred in 18 frames and events; in a whole run every rule has to be decided at least once";
    assert_eq!(rule.reason.as_deref(), Some(reason));
    assert_eq!(report::status(&merged), ExitStatus::Red);
}

#[test]
fn a_ledger_entry_that_no_part_matches_makes_the_merged_run_red() {
    let mut reports = vec![part(1, 2, Pass), part(2, 2, Pass)];
    reports[0].result.unmatched_entries = vec!["ledger entry A".into(), "ledger entry B".into()];
    reports[1].result.unmatched_entries = vec!["ledger entry B".into()];
    let merged = merge(reports).expect("two parts");
    let notes: Vec<&str> = merged.ledger_notes.iter().map(|note| note.text.as_str()).collect();
    assert_eq!(notes, ["ledger entry B matches no test: correct or remove it."]);
    assert_eq!(report::status(&merged), ExitStatus::Red);
}

#[test]
fn parts_that_are_missing_or_there_twice_are_refused() {
    assert_eq!(merge(Vec::new()).expect_err("no report"), MergeError::Empty);
    let missing = merge(vec![part(4, 4, Pass), part(2, 4, Pass)]).expect_err("half of it").to_string();
    assert!(missing.starts_with("parts 1/4, 3/4 of acme-profinet/single are missing"), "{missing}");
    let twice = merge(vec![part(1, 2, Pass), part(1, 2, Pass), part(2, 2, Pass)]).expect_err("twice").to_string();
    assert!(twice.contains("1.json and 1.json are both part 1/2 of acme-profinet/single"), "{twice}");
    let mut whole = part(1, 2, Pass);
    whole.result.part = None;
    let both = merge(vec![whole.clone(), whole.clone()]).expect_err("two whole runs").to_string();
    assert!(both.contains("are both a whole run of acme-profinet/single"), "{both}");
    let mixed = merge(vec![whole, part(1, 2, Pass)]).expect_err("a part and a whole").to_string();
    assert!(mixed.contains("--part is whole run in the one and 2 parts in the other"), "{mixed}");
}

#[rstest]
#[case("the version of encspec is 1.0.0 in the one and 2.0.0 in the other", |of: &mut MergedReport| of.version = "2.0.0".into())]
#[case("the commit of encspec is unknown in the one and abc in the other", |of: &mut MergedReport| of.result.origin.commit = Some("abc".into()))]
#[case("--gate is should in the one and must in the other", |of: &mut MergedReport| of.result.gate_must = true)]
#[case("the filter is none in the one and preset/ in the other", |of: &mut MergedReport| of.result.filters = vec![SPLIT.into()])]
#[case("--fail-on not-applicable is off", |of: &mut MergedReport| of.result.fail_on_not_applicable = true)]
#[case("--accept-flaky is off", |of: &mut MergedReport| of.result.accept_flaky = true)]
#[case("--min-pass is not set", |of: &mut MergedReport| of.result.min_pass = Some("3".parse().expect("a number")))]
#[case("the firmware is unknown in the one and 1.2.3", |of: &mut MergedReport| of.result.runs[0].dut.firmware = Some("1.2.3".into()))]
#[case("the kind of device is model in the one and nic", |of: &mut MergedReport| of.result.runs[0].dut.kind = "nic".into())]
#[case("part 2/2 of acme-profinet/single is missing", |of: &mut MergedReport| of.result.runs[0].bugs = vec!["late".into()])]
fn parts_that_do_not_belong_together_are_refused(#[case] says: &str, #[case] change: fn(&mut MergedReport)) {
    let mut other = part(2, 2, Pass);
    change(&mut other);
    let error = merge(vec![part(1, 2, Pass), other]).expect_err("they do not belong together").to_string();
    assert!(error.contains(says), "{error}");
}

#[test]
fn runs_of_different_devices_are_joined() {
    let mut one = part(1, 1, Pass);
    one.result.part = None;
    let mut other = one.clone();
    other.result.runs[0].dut.variant = "double".into();
    let merged = merge(vec![one, other]).expect("two devices");
    let variants: Vec<&str> = merged.runs.iter().map(|run| run.dut.variant.as_str()).collect();
    assert_eq!(variants, ["single", "double"]);
}

/// Two runs of a case and what differs; `virtual_device` says whether the device is in this process.
fn compared(change: impl Fn(&mut RunResult), later: impl Fn(&mut RunResult)) -> RunDiff {
    let good = || sample_run::case("a/good", CaseKind::Trial, Pass, Level::Must);
    let mut before = sample_run::run(vec![good(), sample_run::case("a/b", CaseKind::Trial, Pass, Level::Must)]);
    let mut after = before.clone();
    change(&mut before);
    later(&mut after);
    RunDiff::of(&before, &after, ["1.0.0", "1.0.0"]).expect("the same device")
}

fn failed(result: &mut RunResult) {
    let case = &mut result.runs[0].cases[1];
    (case.verdict, case.failures, case.reason) = (Fail, vec![sample_run::failure()], Some("It is wrong.".into()));
}

fn verdict(verdict: Verdict) -> impl Fn(&mut RunResult) {
    move |result| result.runs[0].cases[1].verdict = verdict
}

fn kinds(diff: &RunDiff) -> Vec<ChangeKind> {
    diff.devices[0].changes.iter().map(|change| change.kind).collect()
}

#[test]
fn each_kind_of_change_is_found() {
    let none = |_: &mut RunResult| {};
    let is = |diff: RunDiff, kind: ChangeKind, regression: bool| {
        assert_eq!(kinds(&diff), [kind]);
        assert_eq!(diff.is_regression(), regression, "{kind:?}");
    };
    assert_eq!(kinds(&compared(none, none)), []);
    assert_eq!(kinds(&compared(failed, failed)), []);
    is(compared(none, failed), ChangeKind::NewlyFails, true);
    is(compared(none, verdict(Inconclusive)), ChangeKind::NewlyFails, true);
    is(compared(verdict(Xfail), verdict(Xpass)), ChangeKind::NewlyFails, true);
    is(compared(failed, none), ChangeKind::NewlyPasses, false);
    is(compared(none, verdict(NotApplicable)), ChangeKind::NoLongerTested, true);
    is(compared(failed, verdict(NotApplicable)), ChangeKind::NoLongerTested, true);
    is(compared(failed, verdict(Xfail)), ChangeKind::OtherVerdict, false);
    is(compared(failed, verdict(Inconclusive)), ChangeKind::OtherVerdict, false);
    let other_check = |result: &mut RunResult| {
        failed(result);
        result.runs[0].cases[1].failures[0].parts[1].text = "velocity: 0".into();
    };
    is(compared(failed, other_check), ChangeKind::OtherReason, false);
    let reading = |result: &mut RunResult| result.runs[0].cases[1].readings = vec![("either".into(), "moves".into())];
    is(compared(none, reading), ChangeKind::OtherReading, false);
    let slow = |result: &mut RunResult| result.runs[0].cases[1].notes = vec!["slow: 300 ms".into()];
    is(compared(none, slow), ChangeKind::Slower, false);
    assert_eq!(kinds(&compared(slow, slow)), []);
    let new_case = |result: &mut RunResult| {
        failed(result);
        result.runs[0].cases[1].id = "acme-profinet/a/new".into();
    };
    assert_eq!(kinds(&compared(none, new_case)), [ChangeKind::NewlyFails, ChangeKind::NoLongerTested]);
}

#[test]
fn nothing_of_the_host_is_compared() {
    let on_another_host = |result: &mut RunResult| {
        failed(result);
        let case = &mut result.runs[0].cases[1];
        case.evidence = Some("elsewhere/a.pcapng".into());
        case.frames = 99;
        case.at.line = 3;
        case.failures[0].trace.clear();
        case.failures[0].place = None;
        case.failures[0].parts[1].observed = "0x1002 (4098)".into();
        result.origin.host = Some("elsewhere".into());
        result.origin.started = Some("2026-11-28T04:05:06Z".into());
        result.runs[0].dut.spec = "elsewhere.yaml".into();
    };
    assert_eq!(kinds(&compared(failed, on_another_host)), []);
    let late = |time: &'static str, kind: &'static str| {
        move |result: &mut RunResult| {
            verdict(Inconclusive)(result);
            result.runs[0].cases[1].reason = Some(format!("The harness was {time} late."));
            result.runs[0].dut.kind = kind.into();
        }
    };
    assert_eq!(kinds(&compared(late("22.651407ms", "nic"), late("30ms", "nic"))), []);
    let longer = |kind: &'static str, factor: u32| {
        move |result: &mut RunResult| {
            result.runs[0].dut.kind = kind.into();
            result.runs[0].cases[1].duration *= factor;
        }
    };
    assert_eq!(kinds(&compared(longer("nic", 1), longer("nic", 3))), []);
    assert_eq!(kinds(&compared(longer("model", 1), longer("model", 3))), [ChangeKind::Slower]);
}

#[test]
fn what_a_filter_left_out_is_counted_and_no_regression() {
    let left_out = |result: &mut RunResult| {
        result.runs[0].cases.remove(1);
        result.runs[0].filtered = true;
    };
    let diff = compared(|_| {}, left_out);
    assert_eq!((kinds(&diff), diff.devices[0].left_out, diff.is_regression()), (vec![], 1, false));
    assert!(
        diff.console().contains("not compared, since a filter left it out: 1 result of the older run"),
        "{}",
        diff.console()
    );
}

#[test]
fn a_device_that_is_gone_and_a_new_error_are_regressions() {
    let two = |result: &mut RunResult| {
        let mut other = result.runs[0].clone();
        other.dut.variant = "double".into();
        result.runs.push(other);
    };
    let gone = compared(two, |_| {});
    assert!(gone.is_regression() && gone.console().contains("acme-profinet/double: only in the older run"));
    assert!(!compared(|_| {}, two).is_regression());
    let error = compared(|_| {}, |result| result.runs[0].findings = sample_run::everything().runs[0].findings.clone());
    assert!(error.is_regression());
    assert!(error.console().contains("new error     telegram_83.inputs"), "{}", error.console());
}

#[test]
fn every_format_names_what_newly_fails() {
    let diff = compared(
        |_| {},
        |result| {
            failed(result);
            result.runs[0].cases[1].reason = Some("<b>|\u{1b}[2J".into());
        },
    );
    let sentence = "Worse: 1 newly fails, 1 as before.";
    for (name, text) in
        [("console", diff.console()), ("markdown", diff.markdown()), ("html", diff.html()), ("json", diff.json())]
    {
        assert!(name == "json" || text.contains(sentence), "{name}: {text}");
        assert!(text.contains("acme-profinet/a/b") && text.contains("fail"), "{name}: {text}");
        assert!(!text.contains('\u{1b}'), "{name}");
    }
    let row = diff.markdown().lines().find(|line| line.starts_with("| acme")).map(str::to_owned);
    assert_eq!(row.as_deref(), Some("| acme-profinet/a/b | pass | fail: &lt;b&gt;\\|\\\\u{1b}\\[2J |"));
    let json: serde_json::Value = serde_json::from_str(&diff.json()).expect("JSON");
    assert_eq!((&json["regression"], &json["devices"][0]["changes"][0]["kind"]), (&true.into(), &"newly-fails".into()));
}

#[test]
fn the_commands_diff_and_merge() {
    let folder = Folder::new("diff-and-merge");
    let run = |name: &str, more: &[&str]| {
        let report = format!("json={name}");
        let arguments = [&["run", "--dut", XAC77, "--no-evidence", "--report", report.as_str(), SPLIT], more].concat();
        encspec(&folder, &arguments).status
    };
    assert_eq!(run("good.json", &[]), Some(0));
    assert_eq!(run("bad.json", &["--bug", "only-first-preset"]), Some(1));
    assert_eq!(run("1.json", &["--part", "1/2", "--bug", "only-first-preset"]), Some(1));
    assert_eq!(run("2.json", &["--part", "2/2", "--bug", "only-first-preset"]), Some(1));
    let worse = encspec(&folder, &["diff", "good.json", "bad.json", "--report", "markdown=diff.md"]);
    assert_eq!(worse.status, Some(1));
    assert!(worse.out.contains("\nWorse: ") && worse.out.contains("newly fails"), "{}", worse.out);
    assert!(std::fs::read_to_string(folder.join("diff.md")).expect("the file").starts_with("**Worse: "));
    assert_eq!(encspec(&folder, &["diff", "bad.json", "good.json"]).status, Some(0));
    assert_eq!(encspec(&folder, &["diff", "bad.json", "nowhere.json"]).status, Some(2));
    let merged = encspec(&folder, &["merge", "2.json", "1.json", "--report", "json=merged.json"]);
    assert_eq!(merged.status, Some(1), "{}", merged.err);
    let text = |name: &str| std::fs::read_to_string(folder.join(name)).expect("a report");
    assert_eq!(text("merged.json"), text("bad.json"));
    let half = encspec(&folder, &["merge", "2.json"]);
    assert_eq!(half.status, Some(2));
    assert!(
        half.err.contains("part 1/2 of lika-xac77-profinet/xac7718 with bug only-first-preset is missing"),
        "{}",
        half.err
    );
}
