//! The report as Markdown, for the summary of a CI job or a comment: a table of devices, what is red, and what to do about it.

use super::console::by_cause;
use super::status::{ExitStatus, ResultColour, reasons, result_colour, status};
use super::text::totals;
use super::words::{level, reproduce};
use plain_text::printable;
use results::outcome::{CaseResult, DeviceRun, RunResult};
use std::fmt::Write as _;

/// Upper limit of the red results that are described; the rest is counted. A step summary of GitHub may have 1 MiB.
const MOST: usize = 100;

/// Writes the report.
pub fn markdown(result: &RunResult) -> String {
    let mut out = String::new();
    // Writing into a String cannot fail.
    let _ = write(&mut out, result);
    out
}

/// Text in Markdown and in a cell of its tables: no character of it has a meaning.
pub(super) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in printable(text).chars() {
        match c {
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '&' => out.push_str("&amp;"),
            // An entity, since a mention of a person or an issue would be made of the character itself.
            '@' => out.push_str("&#64;"),
            '#' => out.push_str("&#35;"),
            '\\' | '`' | '*' | '_' | '[' | ']' | '|' | '~' => {
                out.push('\\');
                out.push(c);
            }
            c => out.push(c),
        }
    }
    out
}

fn write(out: &mut String, result: &RunResult) -> std::fmt::Result {
    let all = result.runs.iter().flat_map(|run| &run.cases).map(|case| case.verdict);
    let word = if status(result) == ExitStatus::Green { "Green" } else { "Red" };
    writeln!(out, "# encspec: {word}\n\n{word}: {}.", totals(all))?;
    for reason in reasons(result) {
        writeln!(out, "\n- {}", escaped(&reason))?;
    }
    for note in result.ledger_notes.iter().filter(|note| !note.red) {
        writeln!(out, "\n- {}", escaped(&note.text))?;
    }
    writeln!(out, "\n| device | identity | firmware | results |\n| --- | --- | --- | --- |")?;
    for run in &result.runs {
        let firmware = run.dut.firmware.as_deref().unwrap_or("unknown");
        let (spec, identity, firmware) = (escaped(&run.dut.spec), escaped(&run.dut.identity), escaped(firmware));
        writeln!(out, "| {spec} | {identity} | {firmware} | {} |", totals(run.cases.iter().map(|case| case.verdict)))?;
    }
    for run in &result.runs {
        let counted = |case: &&CaseResult| result_colour(result, run, case) == ResultColour::Red;
        let red: Vec<&CaseResult> = by_cause(run).into_iter().filter(counted).collect();
        if !red.is_empty() {
            writeln!(out, "\n## Red on {}", escaped(&run.dut.spec))?;
        }
        red.iter().take(MOST).try_for_each(|case| entry(out, result, run, case))?;
        if red.len() > MOST {
            writeln!(out, "\nand {} more", red.len() - MOST)?;
        }
    }
    for run in &result.runs {
        let is_flaky = |case: &&CaseResult| {
            case.passed_in_attempt.is_some() && result_colour(result, run, case) != ResultColour::Red
        };
        let flaky: Vec<&CaseResult> = run.cases.iter().filter(is_flaky).collect();
        if !flaky.is_empty() {
            writeln!(out, "\n## Flaky on {}, which this run accepts", escaped(&run.dut.spec))?;
        }
        flaky.iter().take(MOST).try_for_each(|case| entry(out, result, run, case))?;
    }
    writeln!(out, "\n<details><summary>All results</summary>\n")?;
    writeln!(out, "| verdict | counts as | id |\n| --- | --- | --- |")?;
    for run in &result.runs {
        for case in &run.cases {
            let counts = result_colour(result, run, case).word();
            writeln!(out, "| {} | {counts} | {} |", case.verdict, escaped(&case.id))?;
        }
    }
    writeln!(out, "\n</details>")
}

fn entry(out: &mut String, result: &RunResult, run: &DeviceRun, case: &CaseResult) -> std::fmt::Result {
    writeln!(out, "\n### {}: {}\n\n{}\n", case.verdict, escaped(&case.id), escaped(&case.why))?;
    let mut item = |name: &str, text: &str| writeln!(out, "- {name}: {}", escaped(text));
    item("level", level(case.level))?;
    if let Some(attempt) = case.passed_in_attempt {
        item("flaky", &format!("it passed in attempt {attempt}"))?;
    }
    if let Some(reason) = &case.reason {
        item("reason", reason)?;
    }
    if let Some(failure) = case.failures.first() {
        for (id, clause, statement) in &failure.requirements {
            item("requirement", &format!("{id}, {clause}: {statement}"))?;
        }
        for part in failure.parts.iter().filter(|part| !part.held) {
            item("expected", &format!("{}: {}", part.text, part.expected))?;
            item("observed", &part.observed)?;
        }
        item("blame", failure.blame.word())?;
        item("next", &failure.next)?;
    }
    if let Some(evidence) = &case.evidence {
        item("evidence", evidence)?;
    }
    item("reproduce", &reproduce(result, run, case))
}
