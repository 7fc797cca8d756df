//! The report for approval: chapter by chapter and requirement by requirement in the order of the manual, without times, frame
//! numbers or paths, so that two reports differ only if the device behaves differently.

use super::words::{finding, level, severities};
use plain_text::printable;
use results::outcome::{CaseResult, DeviceRun, RequirementResult, RunResult};
use results::verdict::Verdict;
use rustc_hash::FxHashMap;
use std::fmt::Write as _;

/// Writes the report of every device.
pub fn text(result: &RunResult) -> String {
    let mut out = String::new();
    for (index, run) in result.runs.iter().enumerate() {
        if index > 0 {
            out.push('\n');
        }
        // Writing into a String cannot fail.
        let _ = device(&mut out, run);
    }
    out
}

fn device(out: &mut String, run: &DeviceRun) -> std::fmt::Result {
    writeln!(out, "{}, variant {}", run.dut.device, run.dut.variant)?;
    writeln!(out, "{}", printable(&run.dut.identity))?;
    if let Some(persona) = &run.persona {
        writeln!(out, "persona {persona}")?;
    }
    for bug in &run.bugs {
        writeln!(out, "bug {bug}")?;
    }
    for variation in &run.variations {
        writeln!(out, "variation {variation}")?;
    }
    writeln!(out, "cases and rules: {}", totals(run.cases.iter().map(|case| case.verdict)))?;
    writeln!(out, "requirements: {}", totals(run.requirements.iter().map(|of| of.verdict)))?;
    if !run.findings.is_empty() {
        writeln!(out, "findings: {}", severities(&run.findings))?;
        run.findings.iter().for_each(|of| out.push_str(&finding(of)));
    }
    let cases: FxHashMap<&str, &CaseResult> = run.cases.iter().map(|case| (case.id.as_str(), case)).collect();
    let (mut chapter, mut clause) = (None, None);
    for of in &run.requirements {
        if chapter != Some(&of.chapter) {
            (chapter, clause) = (Some(&of.chapter), None);
            let own = run.requirements.iter().filter(|other| other.chapter == of.chapter);
            if let Some(chapter) = &of.chapter {
                writeln!(out, "\n# {}: {}", printable(chapter), parts(own.map(|of| of.verdict)))?;
            }
        }
        if clause != Some(of.cites.as_str()) {
            clause = Some(of.cites.as_str());
            writeln!(out, "\n== {}", printable(&of.cites))?;
        }
        requirement(out, of, &cases)?;
    }
    let free: Vec<&CaseResult> = run.cases.iter().filter(|case| case.covers.is_empty()).collect();
    if !free.is_empty() {
        writeln!(out, "\n== without requirement")?;
        free.iter().try_for_each(|case| line(out, case, case.verdict))?;
    }
    Ok(())
}

fn requirement(out: &mut String, of: &RequirementResult, cases: &FxHashMap<&str, &CaseResult>) -> std::fmt::Result {
    writeln!(out, "{} {} {}", of.id, level(of.level), of.verdict)?;
    writeln!(out, "    {}", printable(&of.statement))?;
    if let Some(note) = &of.note {
        writeln!(out, "    note: {}", printable(note))?;
    }
    for id in &of.cases {
        let Some(case) = cases.get(id.as_str()) else { continue };
        let own =
            case.covers.iter().find(|covered| covered.id == of.id).map_or(case.verdict, |covered| covered.verdict);
        line(out, case, own)?;
    }
    Ok(())
}

fn line(out: &mut String, case: &CaseResult, verdict: Verdict) -> std::fmt::Result {
    let id = case.id.split_once('/').map_or(case.id.as_str(), |(_, id)| id);
    write!(out, "    {verdict} {}", printable(id))?;
    if verdict != Verdict::Pass
        && let Some(reason) = &case.reason
    {
        write!(out, ": {}", printable(reason))?;
    }
    out.push('\n');
    for (step, reading) in &case.readings {
        writeln!(out, "        reading {}: {}", printable(reading), printable(step))?;
    }
    if case.slow().next().is_some() {
        writeln!(out, "        slow, which fails nothing")?;
    }
    Ok(())
}

/// The number of verdicts, in all and of each kind.
pub(super) fn totals(verdicts: impl Iterator<Item = Verdict> + Clone) -> String {
    match verdicts.clone().count() {
        0 => "none".into(),
        all => format!("{all}: {}", parts(verdicts)),
    }
}

/// The number of verdicts of each kind.
pub(super) fn parts(verdicts: impl Iterator<Item = Verdict> + Clone) -> String {
    let of = |counted: Verdict| (verdicts.clone().filter(|&verdict| verdict == counted).count(), counted);
    let each = Verdict::ALL.into_iter().map(of).filter(|(n, _)| *n > 0);
    each.map(|(n, verdict)| format!("{n} {verdict}")).collect::<Vec<_>>().join(", ")
}
