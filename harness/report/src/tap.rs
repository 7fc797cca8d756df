//! The report as TAP 14: a test point for each case and rule, and one for each reason why the run as a whole fails.
//!
//! A failure that does not count is marked `TODO`: in TAP such a point may fail.

use super::status::{ResultColour, reasons, result_colour};
use super::words::{level, printable_json, reproduce};
use plain_text::printable;
use results::outcome::{CaseResult, DeviceRun, RunResult};
use results::verdict::Verdict;
use std::fmt::Write as _;

/// Writes the report.
pub fn tap(result: &RunResult) -> String {
    let whole = reasons(result);
    let points = result.runs.iter().map(|run| run.cases.len()).sum::<usize>() + whole.len();
    let mut out = format!("TAP version 14\n1..{points}\n");
    let mut number = 0;
    for run in &result.runs {
        for case in &run.cases {
            number += 1;
            // Writing into a String cannot fail.
            let _ = point(&mut out, number, result, run, case);
        }
    }
    for reason in whole {
        number += 1;
        let _ = writeln!(out, "not ok {number} - {}", description(&reason));
    }
    out
}

fn point(out: &mut String, number: usize, result: &RunResult, run: &DeviceRun, case: &CaseResult) -> std::fmt::Result {
    let colour = result_colour(result, run, case);
    let reason = case.reason.as_deref().unwrap_or_default();
    let (ok, directive) = match (case.verdict, colour) {
        (Verdict::Pass, _) => (true, None),
        (Verdict::NotApplicable, ResultColour::Green | ResultColour::Neutral(_)) => {
            (true, Some(format!("SKIP {reason}")))
        }
        (Verdict::NotRun, ResultColour::Neutral(why)) => (true, Some(format!("SKIP not run, {why}: {reason}"))),
        (Verdict::Xfail, _) => (false, Some(format!("TODO {reason}"))),
        (_, ResultColour::Neutral(why)) => (false, Some(format!("TODO {why}"))),
        _ => (false, None),
    };
    write!(
        out,
        "{} {number} - {} on {}",
        if ok { "ok" } else { "not ok" },
        description(&case.id),
        description(&run.dut.spec)
    )?;
    if let Some(directive) = directive {
        write!(out, " # {}", description(&directive))?;
    }
    out.push('\n');
    for note in case.slow() {
        writeln!(out, "# {}", description(note))?;
    }
    if !ok {
        writeln!(out, "  ---")?;
        writeln!(out, "  verdict: {}", case.verdict)?;
        writeln!(out, "  level: {}", level(case.level))?;
        if let Some(attempt) = case.passed_in_attempt {
            writeln!(out, "  flaky: it passed in attempt {attempt}")?;
        }
        field(out, "reason", case.reason.as_deref())?;
        if let Some(failure) = case.failures.first() {
            writeln!(out, "  blame: {}", failure.blame.word())?;
            field(out, "message", Some(&failure.what))?;
            field(out, "step", Some(&failure.step))?;
            field(out, "at", Some(&super::json::place(&failure.at)))?;
        }
        field(out, "evidence", case.evidence.as_deref())?;
        field(out, "reproduce", Some(&reproduce(result, run, case)))?;
        writeln!(out, "  ...")?;
    }
    Ok(())
}

/// A text in the YAML block after a point; JSON strings are valid YAML.
fn field(out: &mut String, key: &str, text: Option<&str>) -> std::fmt::Result {
    match text {
        Some(text) => writeln!(out, "  {key}: {}", printable_json(&serde_json::Value::from(text).to_string())),
        None => Ok(()),
    }
}

/// A text in a test line, where `#` begins a directive.
fn description(text: &str) -> String {
    printable(text).replace('\\', "\\\\").replace('#', "\\#")
}
