//! The report as workflow commands of GitHub Actions: an annotation for each red result and each reason of the run as a whole.
//!
//! A flaky result that was accepted is a warning. GitHub shows ten annotations of each kind for a step; the Markdown report has all.

use super::status::{ExitStatus, ResultColour, reasons, result_colour, status};
use super::text::totals;
use super::words::reproduce;
use plain_text::printable;
use results::outcome::{CaseResult, DeviceRun, RunResult};
use std::fmt::Write as _;

/// Writes the report.
pub fn github(result: &RunResult) -> String {
    let mut out = String::new();
    for run in &result.runs {
        for case in &run.cases {
            match result_colour(result, run, case) {
                ResultColour::Red => annotation(&mut out, "error", result, run, case),
                ResultColour::Neutral(_) if case.passed_in_attempt.is_some() => {
                    annotation(&mut out, "warning", result, run, case);
                }
                ResultColour::Neutral(_) | ResultColour::Green => {}
            }
        }
    }
    for reason in reasons(result) {
        command(&mut out, "error", "", "encspec", &reason);
    }
    let all = totals(result.runs.iter().flat_map(|run| &run.cases).map(|case| case.verdict));
    match status(result) {
        ExitStatus::Green => command(&mut out, "notice", "", "encspec", &format!("Green: {all}.")),
        _ => command(&mut out, "error", "", "encspec", &format!("Red: {all}.")),
    }
    out
}

fn annotation(out: &mut String, kind: &str, result: &RunResult, run: &DeviceRun, case: &CaseResult) {
    // Only suites that the command line names are files of the repository in which the job runs.
    let place = match result.repeat.is_empty() {
        true => String::new(),
        false => {
            let file = property(&case.at.file.display().to_string());
            format!("file={file},line={},col={},", case.at.line, case.at.column)
        }
    };
    let reason = case.reason.as_deref().unwrap_or(&case.why);
    let clauses = case.failures.first().into_iter().flat_map(|failure| &failure.requirements);
    let clauses: String = clauses.map(|(id, clause, _)| format!("\n{id}, {clause}")).collect();
    let flaky = case.passed_in_attempt.map(|attempt| format!("\nflaky: it passed in attempt {attempt}"));
    let text = format!("{reason}{clauses}{}\n{}", flaky.unwrap_or_default(), reproduce(result, run, case));
    command(out, kind, &place, &format!("{} {}", case.verdict, case.id), &text);
}

fn command(out: &mut String, kind: &str, place: &str, title: &str, text: &str) {
    // Line feeds separate the lines of an annotation; those of a device are escaped before.
    let lines: Vec<String> = text.split('\n').map(|line| data(&printable(line))).collect();
    // Writing into a String cannot fail.
    let _ = writeln!(out, "::{kind} {place}title={}::{}", property(&printable(title)), lines.join("%0A"));
}

/// The text of a workflow command.
fn data(text: &str) -> String {
    text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A")
}

/// A property of a workflow command.
fn property(text: &str) -> String {
    data(text).replace(':', "%3A").replace(',', "%2C")
}
