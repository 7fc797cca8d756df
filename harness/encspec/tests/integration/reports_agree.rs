//! All formats and the exit status say the same of each result, over generated runs; and what single formats and options add.

use crate::common::program::{command, encspec};
use crate::sample_run;
use encspec::report::{self, ConsoleOptions, ExitStatus, ReportFormat};
use encspec::result::{CaseKind, DeviceRun, FindingSeverity, LedgerNote, MinimumPass, RunResult};
use encspec::suite::model::Level;
use encspec::verdict::Verdict;
use std::collections::BTreeMap;
use testing::Folder;

const XAC77: &str = "model:lika-xac77-profinet/xac7718";
const RUNS: u64 = 1000;

/// Numbers from a seed (SplitMix64).
struct RunDice(u64);

impl RunDice {
    fn roll(&mut self, sides: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((mixed ^ (mixed >> 31)) % sides as u64) as usize
    }

    fn one_in(&mut self, sides: usize) -> bool {
        self.roll(sides) == 0
    }

    fn of<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.roll(list.len())]
    }
}

/// Reasons that could mislead a reader of some format.
const REASONS: [&str; 6] = [
    "It is late.",
    "ok 1 - passed # TODO later",
    "<failure/> & \"quoted\" | `x` **pass**",
    "::error title=x::y\n::stop-commands::z",
    "\u{1b}[2J\u{202e}\r\nGreen: all",
    "100 % of it: a, b",
];

fn generated(seed: u64) -> RunResult {
    let mut dice = RunDice(seed);
    // Often everything passes but for one result, so that the decision depends on this one.
    let is_mostly_good = dice.one_in(2);
    let mut result = RunResult::default();
    for device in 0..=dice.roll(2) {
        let mut cases = Vec::new();
        for number in 0..1 + dice.roll(6) {
            let is_odd = !is_mostly_good || number == 1;
            let verdict = if is_odd { dice.of(&Verdict::ALL) } else { Verdict::Pass };
            let kind = if number > 0 && dice.one_in(3) { CaseKind::Rule } else { CaseKind::Trial };
            let level = dice.of(&[Level::Must, Level::Should, Level::Info]);
            let mut case = sample_run::case(&format!("s{device}/c{number}"), kind, verdict, level);
            case.reason = (verdict != Verdict::Pass).then(|| dice.of(&REASONS).to_owned());
            let may_be_flaky = matches!(verdict, Verdict::Fail | Verdict::Inconclusive | Verdict::Error);
            case.passed_in_attempt = (may_be_flaky && dice.one_in(3)).then_some(2);
            if verdict == Verdict::Fail {
                case.failures = vec![sample_run::failure()];
            }
            cases.push(case);
        }
        let mut run = sample_run::run(cases).runs.remove(0);
        run.dut.variant = format!("variant{device}");
        run.dut.spec = format!("model:acme-profinet/variant{device}");
        run.dut.kind = dice.of(&["model", "nic", "null"]).to_owned();
        run.filtered = dice.one_in(3);
        if dice.one_in(6) {
            run.findings = sample_run::everything().runs[0].findings.clone();
        }
        result.runs.push(run);
    }
    result.gate_must = dice.one_in(3);
    result.fail_on_not_applicable = dice.one_in(4);
    result.accept_flaky = dice.one_in(2);
    result.min_pass = dice.one_in(5).then_some(MinimumPass::Percent(60));
    if dice.one_in(6) {
        result.ledger_notes.push(LedgerNote { text: dice.of(&REASONS).to_owned(), red: dice.one_in(2) });
    }
    result
}

/// Whether a result makes a run red, as README.md, "Verdicts", and docs/ci.md say.
fn is_red(result: &RunResult, run: &DeviceRun, at: usize) -> bool {
    let case = &run.cases[at];
    let is_rule = case.kind == CaseKind::Rule;
    let is_excused = match case.level {
        Level::Must => false,
        Level::Should => result.gate_must,
        Level::Info => true,
    };
    match case.verdict {
        Verdict::Pass | Verdict::Xfail => false,
        Verdict::NotApplicable => result.fail_on_not_applicable,
        _ if case.passed_in_attempt.is_some() && result.accept_flaky => false,
        Verdict::Fail => !is_excused,
        Verdict::Inconclusive | Verdict::Error | Verdict::Xpass => true,
        Verdict::NotRun => !is_rule || (!run.filtered && run.dut.kind != "nic"),
    }
}

/// What a format says of each result, by its id, and of the whole run; `true` is red.
type Said = (BTreeMap<String, bool>, bool);

/// Writes a run in a format, and reads it back.
type FormatReader = fn(&RunResult) -> Said;

fn json(result: &RunResult) -> Said {
    let report: serde_json::Value = serde_json::from_str(&report::json(result)).expect("JSON");
    let mut said = BTreeMap::new();
    for run in report["runs"].as_array().expect("runs") {
        for case in run["cases"].as_array().expect("cases") {
            said.insert(case["id"].as_str().expect("an id").to_owned(), case["counts"] == "red");
        }
    }
    (said, report["green"] == false)
}

fn junit(result: &RunResult) -> Said {
    let text = report::junit(result);
    let document = roxmltree::Document::parse(&text).expect("XML");
    let mut said = BTreeMap::new();
    for case in document.descendants().filter(|node| node.has_tag_name("testcase")) {
        let red = case.children().any(|child| child.has_tag_name("failure") || child.has_tag_name("error"));
        if let Some(class) = case.attribute("classname") {
            said.insert(format!("{}/{}", class.replace('.', "/"), case.attribute("name").expect("a name")), red);
        }
    }
    let root = document.root_element();
    let counted = |name: &str| root.attribute(name).is_none_or(|number| number != "0");
    (said, counted("failures") || counted("errors"))
}

fn tap(result: &RunResult) -> Said {
    let text = report::tap(result);
    let mut said = BTreeMap::new();
    let mut red = false;
    for line in text.lines().filter(|line| line.starts_with("ok ") || line.starts_with("not ok ")) {
        // `\#` is a number sign of a text; an unescaped one begins a directive.
        let plain = line.replace("\\\\", "").replace("\\#", "");
        let is_red = line.starts_with("not ok ") && !plain.contains(" # TODO");
        red |= is_red;
        let id = line.split(" - ").nth(1).and_then(|rest| rest.split(" on ").next()).unwrap_or_default();
        if id.starts_with("acme-profinet/") {
            said.insert(id.to_owned(), is_red);
        }
    }
    (said, red)
}

fn markdown(result: &RunResult) -> Said {
    let text = report::markdown(result);
    let mut said = BTreeMap::new();
    for line in text.lines() {
        let cells: Vec<&str> = line.split(" | ").collect();
        if let [_, counts, id] = cells[..]
            && id.starts_with("acme-profinet/")
        {
            said.insert(id.trim_end_matches(" |").to_owned(), counts == "red");
        }
    }
    (said, text.starts_with("# encspec: Red\n"))
}

fn html(result: &RunResult) -> Said {
    let text = report::html(result, &|_| report::CaseEvidence::default());
    let mut said = BTreeMap::new();
    for row in text.split("<tr").skip(1) {
        let cells: Vec<&str> = row.split("<td>").skip(1).filter_map(|cell| cell.split("</td>").next()).collect();
        // Other tables of the page have no such column.
        if let [_, counts, id, ..] = cells[..]
            && ["green", "neutral", "red"].contains(&counts)
        {
            said.insert(id.to_owned(), counts == "red");
        }
    }
    (said, text.contains("<p class=\"verdict bad\">"))
}

/// GitHub has annotations for what is red only.
fn github(result: &RunResult) -> Said {
    let text = report::github(result);
    assert!(text.lines().all(|line| line.starts_with("::")), "{text}");
    let mut said = BTreeMap::new();
    for run in &result.runs {
        for case in &run.cases {
            let title = format!("title={} {}::", case.verdict, case.id);
            let red = text.lines().any(|line| line.starts_with("::error ") && line.contains(&title));
            said.insert(case.id.clone(), red);
        }
    }
    (said, text.lines().any(|line| line.starts_with("::error ")))
}

/// The quiet text has what is red, and the last line.
fn console(result: &RunResult) -> Said {
    let look = ConsoleOptions { quiet: true, ..ConsoleOptions::default() };
    let text = report::console(result, look);
    let mut said = BTreeMap::new();
    for run in &result.runs {
        for case in &run.cases {
            let head = format!("  {} {} (", case.verdict.word().to_uppercase(), case.id);
            said.insert(case.id.clone(), text.lines().any(|line| line.starts_with(&head)));
        }
    }
    let verbose = report::console(result, ConsoleOptions { verbose: true, ..ConsoleOptions::default() });
    let last = |text: &str| text.trim_end().lines().last().unwrap_or_default().to_owned();
    assert_eq!(last(&text), last(&verbose));
    (said, last(&text).starts_with("Red:"))
}

#[test]
fn every_format_and_the_exit_status_agree_on_every_verdict() {
    let mut reds = 0;
    for seed in 0..RUNS {
        let result = generated(seed);
        let mut expected = BTreeMap::new();
        for run in &result.runs {
            for (at, case) in run.cases.iter().enumerate() {
                expected.insert(case.id.clone(), is_red(&result, run, at));
            }
        }
        let red = report::status(&result) == ExitStatus::Red;
        assert!(red || !expected.values().any(|red| *red), "seed {seed}: green with a red result");
        reds += usize::from(red);
        let formats: [(&str, FormatReader); 7] = [
            ("console", console),
            ("github", github),
            ("html", html),
            ("json", json),
            ("junit", junit),
            ("markdown", markdown),
            ("tap", tap),
        ];
        for (name, format) in formats {
            let (each, whole) = format(&result);
            assert_eq!(each, expected, "seed {seed}: {name}");
            assert_eq!(whole, red, "seed {seed}: {name}, exit status {:?}", report::status(&result));
        }
        let read = report::read(&report::json(&result)).expect("a report").1;
        assert_eq!(report::status(&read), report::status(&result), "seed {seed}: the JSON read back");
    }
    assert!((200..RUNS as usize - 100).contains(&reds), "{reds} of {RUNS} runs are red");
}

#[test]
fn a_flaky_result_is_shown_and_red_unless_accepted() {
    let mut result = sample_run::everything();
    result.runs[0].cases.retain(|case| ["absolute", "it's[row 1]"].iter().any(|name| case.id.ends_with(name)));
    result.runs[0].findings.clear();
    result.runs[0].cases[1].passed_in_attempt = Some(3);
    for (accept, status) in [(false, ExitStatus::Red), (true, ExitStatus::Green)] {
        result.accept_flaky = accept;
        assert_eq!(report::status(&result), status);
        for (name, format) in ReportFormat::ALL {
            // The report for approval has the verdict of the first attempt only.
            let text = format.write(&result);
            assert!(
                name == "text" || text.contains("passed in attempt 3") || text.contains("\"passed_in_attempt\": 3"),
                "{name}: {text}"
            );
        }
    }
    assert!(report::github(&result).contains("::warning title=fail acme-profinet/preset/it's[row 1]::"));
}

#[test]
fn junit_says_when_and_where_a_live_run_was() {
    let mut result = sample_run::everything();
    assert!(!report::junit(&result).contains("timestamp="));
    result.origin.started = Some("2026-11-28T04:05:06Z".into());
    result.origin.host = Some("bench-7".into());
    result.origin.commit = Some("0123456789ab".into());
    result.runs[0].dut.firmware = Some("1.3.0".into());
    let text = report::junit(&result);
    for part in [
        "time=\"15.000\" timestamp=\"2026-11-28T04:05:06\" hostname=\"bench-7\">",
        "<property name=\"firmware\" value=\"1.3.0\"/>",
        " (0123456789ab)\"/>",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
}

#[test]
fn annotations_have_the_file_of_a_suite_of_the_user() {
    let mut result = sample_run::everything();
    assert!(!report::github(&result).contains("file="));
    result.repeat = vec!["--suites".into(), "suites".into()];
    let text = report::github(&result);
    let line = text.lines().find(|line| line.contains("it's")).expect("the failed case");
    let begin = "::error file=suites/acme-profinet/preset.yaml,line=7,col=9,title=fail acme-profinet/preset/it's[row 1]::It did not";
    assert!(line.starts_with(begin), "{line}");
    assert!(line.contains("%0AACME-001, section 3.1 (p. 9)%0Aencspec run --suites suites"), "{line}");
}

#[test]
fn the_summary_of_a_step_is_written_for_github() {
    let folder = Folder::new("step-summary");
    let summary = folder.write("summary.md", "# Before\n");
    let mut started = command(folder.path(), &["run", "--dut", XAC77, "--report", "github", "identification/"]);
    let output = started.env("GITHUB_STEP_SUMMARY", &summary).output().expect("it runs");
    let out = String::from_utf8_lossy(&output.stdout);
    assert!(out.starts_with("::notice title=encspec::Green: ") && out.contains("\nGreen: "), "{out}");
    let text = std::fs::read_to_string(&summary).expect("the summary");
    assert!(text.starts_with("# Before\n# encspec: Green\n"), "{text}");
}

#[test]
fn the_first_red_result_ends_the_run() {
    let folder = Folder::new("fail-fast");
    let run = |name: &str, threads: &str, more: &[&str]| {
        let report = format!("json={name}");
        let fixed =
            ["run", "--dut", XAC77, "--bug", "only-first-preset", "--fail-fast", "--no-evidence", "--report", &report];
        let said = encspec(&folder, &[&fixed, &["--threads", threads][..], more].concat());
        assert_eq!(said.status, Some(1), "{}", said.err);
        std::fs::read_to_string(folder.join(name)).expect("the report")
    };
    let one = run("one.json", "1", &[]);
    assert_eq!(run("four.json", "4", &[]), one, "it does not depend on threads");
    let report: serde_json::Value = serde_json::from_str(&one).expect("JSON");
    let cases = report["runs"][0]["cases"].as_array().expect("cases");
    let trials: Vec<&str> =
        cases.iter().filter(|of| of["kind"] == "case").filter_map(|of| of["verdict"].as_str()).collect();
    let first = trials.iter().position(|verdict| *verdict == "fail").expect("a failure");
    assert!(first > 0 && trials[..first].iter().all(|verdict| *verdict == "pass"));
    assert!(trials.len() > first + 100 && trials[first + 1..].iter().all(|verdict| *verdict == "not-run"));
    // What the ledger excuses does not end it.
    let ledger = "known_failures:\n- test: operating-status/offset\n  device: lika-xac77-profinet\n  reason: later\n  ticket: FW-1\n  \
                  expires: 2099-12-31\n  signature: 'read: { P65001.offset: * | P65001.offset'\n";
    let ledger = folder.write("ledger.yaml", ledger);
    let excused = run("excused.json", "2", &["--ledger", &ledger.display().to_string()]);
    let report: serde_json::Value = serde_json::from_str(&excused).expect("JSON");
    let verdicts: Vec<&str> =
        report["runs"][0]["cases"].as_array().expect("cases").iter().filter_map(|of| of["verdict"].as_str()).collect();
    let of = |wanted: &str| verdicts.iter().position(|verdict| *verdict == wanted);
    assert!(of("xfail").is_some() && of("xfail") < of("fail"), "{verdicts:?}");
}

#[test]
fn options_for_a_log() {
    let folder = Folder::new("options-for-a-log");
    let run = |more: &[&str]| {
        let fixed = ["run", "--dut", XAC77, "--no-evidence", "preset/second-preset"];
        encspec(&folder, &[&fixed, more].concat())
    };
    let quiet = run(&["-q"]);
    assert_eq!((quiet.status, quiet.out.as_str()), (Some(0), "Green: 1 result on 1 device: 1 pass.\n"));
    assert!(run(&["--color", "always"]).out.contains("\u{1b}[32mGreen:"));
    assert!(!run(&["--color", "never"]).out.contains('\u{1b}'));
    assert_eq!(run(&["-q", "-v"]).status, Some(2));
    assert_eq!(run(&["--accept-flaky"]).status, Some(2), "without --retries nothing can be flaky");
    let retried = run(&["--retries", "2", "--bug", "only-first-preset"]);
    assert_eq!(retried.status, Some(1));
    assert!(retried.out.contains("it did not pass in any of 3 attempts"), "{}", retried.out);
}

#[test]
fn mistakes_in_suites_as_sarif() {
    let folder = Folder::new("sarif");
    let good = encspec(&folder, &["check", "--format", "sarif"]);
    assert_eq!(good.status, Some(0), "{}", good.err);
    let read = |text: &str| -> serde_json::Value { serde_json::from_str(text).expect("JSON") };
    let remarks = read(&good.out)["runs"][0]["results"].as_array().cloned().expect("results");
    assert!(remarks.iter().all(|of| of["level"] == "note" && of["ruleId"] == "unused"), "{}", good.out);
    let small =
        testing::workspace().join("harness/encspec/tests/load_errors/probe/topic/unknown-verb-expcet/case.yaml");
    let fixtures = testing::workspace().join("harness/encspec/tests/fixtures/small_slave/slave");
    std::fs::create_dir_all(folder.join("slave")).expect("a folder");
    let files = std::fs::read_dir(&fixtures).expect("the fixture").map(|entry| entry.expect("an entry").path());
    for file in files.filter(|path| path.is_file()) {
        std::fs::copy(&file, folder.join("slave").join(file.file_name().expect("a name"))).expect("a copy");
    }
    std::fs::copy(small, folder.join("slave/wrong case.yaml")).expect("a copy");
    let bad = encspec(&folder, &["check", "slave", "--format", "sarif"]);
    assert_eq!(bad.status, Some(2), "{}", bad.err);
    let report = read(&bad.out);
    let results = report["runs"][0]["results"].as_array().expect("results");
    let uri = |of: &&serde_json::Value| {
        of["locations"][0]["physicalLocation"]["artifactLocation"]["uri"] == "slave/wrong%20case.yaml"
    };
    let first = results.iter().find(uri).unwrap_or_else(|| panic!("{}", bad.out));
    assert_eq!((&report["version"], &first["level"]), (&"2.1.0".into(), &"error".into()));
    let place = &first["locations"][0]["physicalLocation"];
    assert!(place["region"]["startLine"].as_u64().is_some_and(|line| line > 0));
}

#[test]
fn a_finding_is_an_error_of_the_whole_run() {
    let mut result = sample_run::everything();
    result.runs[0].cases.truncate(1);
    result.runs[0].findings.retain(|finding| finding.severity == FindingSeverity::Error);
    assert_eq!(report::status(&result), ExitStatus::Red);
    assert!(
        report::github(&result).contains("::error title=encspec::1 finding on model%3Aacme-profinet")
            || report::github(&result).contains("::error title=encspec::1 finding on model:acme-profinet")
    );
}
