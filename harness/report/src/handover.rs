//! What makes the HTML report one to hand over: the cover, the summary by chapter, known failures, what was not tested, and the
//! evidence with its hashes.

use super::page::{Chapter, PageTable, Tone};
use super::status::{ResultColour, result_colour};
use super::text::parts;
use super::words::level;
use results::outcome::{CaseKind, DeviceRun, RunResult};
use results::verdict::Verdict;
use serde_json::{Value, json};

/// The cover: what was tested, with what, when and where.
pub(super) fn cover(result: &RunResult) -> Chapter {
    let origin = &result.origin;
    let commit = origin.commit.iter().map(|commit| format!(", commit {commit}"));
    let mut facts =
        vec![("encspec".to_owned(), format!("{}{}", env!("CARGO_PKG_VERSION"), commit.collect::<String>()))];
    let mut fact = |name: &str, value: Option<String>| facts.extend(value.map(|value| (name.to_owned(), value)));
    fact("date", origin.started.clone());
    fact("operator", origin.operator.clone());
    fact("host", origin.host.clone());
    fact("what counts", Some(counted(result)));
    fact("filters", (!result.filters.is_empty()).then(|| result.filters.join(" ")));
    fact("part", result.part.map(|part| part.to_string()));
    for (name, hash) in &origin.suites {
        fact("suite", Some(format!("{name}, SHA-256 {hash}")));
    }
    for run in &result.runs {
        let firmware = run.dut.firmware.as_deref().unwrap_or("unknown");
        fact("device", Some(format!("{}, firmware {firmware}", run.dut.identity)));
    }
    Chapter { heading: "Report".to_owned(), facts, ..Chapter::default() }
}

fn counted(result: &RunResult) -> String {
    let mut text = match result.gate_must {
        true => "failures of requirements of level must".to_owned(),
        false => "failures of requirements of the levels must and should".to_owned(),
    };
    if result.fail_on_not_applicable {
        text += "; what is not applicable";
    }
    if let Some(least) = result.min_pass {
        text += &format!("; fewer passes than {least}");
    }
    if result.accept_flaky {
        text += "; a failed case that passed when it was repeated is accepted";
    }
    text
}

/// The tables of a device besides its cases and requirements.
pub(super) fn tables(result: &RunResult, run: &DeviceRun) -> Vec<PageTable> {
    vec![by_chapter(run), known_failures(run), not_tested(result, run), evidence(run)]
}

fn table(heading: &str, columns: &[&str], rows: Vec<(Tone, Vec<String>)>) -> PageTable {
    let columns = columns.iter().map(|column| (*column).to_owned()).collect();
    PageTable { heading: heading.to_owned(), columns, rows }
}

/// How many requirements of each chapter, or of each clause where there are no chapters, have which status.
fn by_chapter(run: &DeviceRun) -> PageTable {
    let name = |at: usize| {
        let of = &run.requirements[at];
        of.chapter.as_ref().unwrap_or(&of.cites)
    };
    let mut chapters: Vec<&String> = Vec::new();
    (0..run.requirements.len()).map(name).for_each(|chapter| {
        if !chapters.contains(&chapter) {
            chapters.push(chapter);
        }
    });
    let row = |chapter: &String| {
        let of =
            || (0..run.requirements.len()).filter(|at| name(*at) == chapter).map(|at| run.requirements[at].verdict);
        let tone = match of().any(|verdict| verdict == Verdict::Fail) {
            true => Tone::Bad,
            false => Tone::Plain,
        };
        (tone, vec![chapter.clone(), of().count().to_string(), parts(of())])
    };
    let rows = chapters.into_iter().map(row).collect();
    table("Summary by chapter", &["chapter or clause", "requirements", "status"], rows)
}

/// The failures that the ledger declares.
fn known_failures(run: &DeviceRun) -> PageTable {
    let known = run.cases.iter().filter(|case| matches!(case.verdict, Verdict::Xfail | Verdict::Xpass));
    let row = |case: &results::outcome::CaseResult| {
        let reason = case.reason.clone().unwrap_or_default();
        (Tone::Open, vec![case.verdict.word().to_owned(), case.id.clone(), level(case.level).to_owned(), reason])
    };
    table("Known failures that were declared", &["verdict", "id", "level", "reason"], known.map(row).collect())
}

/// What was not tested, grouped by the reason.
fn not_tested(result: &RunResult, run: &DeviceRun) -> PageTable {
    let cases = run.cases.iter().filter(|case| is_untested(case.verdict));
    let cases = cases.map(|case| (reason_of(result, run, case), case.id.as_str()));
    let free = run.requirements.iter().filter(|of| of.cases.is_empty());
    let free = free.map(|of| (of.note.clone().unwrap_or_default(), of.id.as_str()));
    let mut groups: Vec<(String, Vec<&str>)> = Vec::new();
    for (reason, id) in cases.chain(free) {
        match groups.iter_mut().find(|(known, _)| *known == reason) {
            Some((_, ids)) => ids.push(id),
            None => groups.push((reason, vec![id])),
        }
    }
    let rows =
        groups.into_iter().map(|(reason, ids)| (Tone::Open, vec![ids.len().to_string(), reason, ids.join(", ")]));
    table("Not tested", &["number", "reason", "cases, rules and requirements"], rows.collect())
}

fn is_untested(verdict: Verdict) -> bool {
    matches!(verdict, Verdict::NotApplicable | Verdict::NotRun)
}

fn reason_of(result: &RunResult, run: &DeviceRun, case: &results::outcome::CaseResult) -> String {
    let reason = case.reason.clone().unwrap_or_default();
    match (case.kind, result_colour(result, run, case)) {
        (CaseKind::Rule, ResultColour::Neutral(why)) if case.verdict == Verdict::NotRun => {
            format!("its premise never occurred ({why})")
        }
        _ => reason,
    }
}

fn evidence(run: &DeviceRun) -> PageTable {
    let rows = run.cases.iter().filter_map(|case| {
        let hash = case.evidence_sha256.clone().unwrap_or_else(|| "not known".to_owned());
        Some((Tone::Plain, vec![case.id.clone(), case.evidence.clone()?, hash]))
    });
    table("Evidence", &["id", "file", "SHA-256"], rows.collect())
}

/// The files of the evidence with their hashes, for `encspec verify`.
pub(super) fn evidence_data(result: &RunResult) -> Value {
    let cases = result.runs.iter().flat_map(|run| &run.cases);
    let files = cases.filter_map(|case| {
        Some(json!({ "id": case.id, "file": case.evidence.as_ref()?, "sha256": case.evidence_sha256 }))
    });
    Value::Array(files.collect())
}
