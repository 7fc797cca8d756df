//! The report as an HTML page: everything that is not green in full, then all cases and requirements.

use super::console::{by_cause, short};
use super::handover;
use super::status::{ExitStatus, ResultColour, reasons, result_colour, status};
use super::text::totals;
use super::words::{bus_lines, common_need, kind_of_cause, level, reproduce};
use crate::page::{Chapter, HtmlPage, PageEntry, PagePacket, PageTable, Timeline, Tone, html as page};
use results::outcome::{CaseFailure, CaseResult, DeviceRun, RunResult};
use results::verdict::{Colour, Verdict};

/// Upper limit of the cases of one device that are shown in full.
const MOST_ENTRIES: usize = 300;

/// Upper limit of the groups of failures that are named.
const MOST_CAUSES: usize = 10;

/// The packet and the timelines from the evidence of a case.
#[derive(Clone, Debug, Default)]
pub struct CaseEvidence {
    /// The packet of the first failure.
    pub packet: Option<PagePacket>,
    /// The timelines of the connections of the case.
    pub timelines: Vec<Timeline>,
}

/// Writes the report; `pictures` reads the evidence of a case, if there is any.
pub fn html(result: &RunResult, pictures: &dyn Fn(&CaseResult) -> CaseEvidence) -> String {
    let mut notes = reasons(result);
    notes.extend(result.ledger_notes.iter().map(|note| note.text.clone()));
    let all = result.runs.iter().flat_map(|run| &run.cases).map(|case| case.verdict);
    let (tone, word) = match status(result) {
        ExitStatus::Green => (Tone::Good, "Green"),
        _ => (Tone::Bad, "Not green"),
    };
    let sentence = [format!("{word}: {}.", totals(all))].into_iter().chain(notes).collect::<Vec<_>>().join(" ");
    let chapters = result.runs.iter().enumerate().map(|(number, run)| chapter(number, result, run, pictures));
    page(&HtmlPage {
        title: "encspec run".to_owned(),
        verdict: (tone, sentence),
        chapters: [handover::cover(result)].into_iter().chain(chapters).collect(),
        data: vec![("evidence", handover::evidence_data(result))],
    })
}

fn chapter(
    number: usize,
    result: &RunResult,
    run: &DeviceRun,
    pictures: &dyn Fn(&CaseResult) -> CaseEvidence,
) -> Chapter {
    let is_detailed =
        |case: &&CaseResult| result_colour(result, run, case) == ResultColour::Red || !case.failures.is_empty();
    let (detailed, repeated) = without_repeated(by_cause(run).into_iter().filter(is_detailed));
    let entries = detailed.iter().take(MOST_ENTRIES).enumerate();
    let mut facts = vec![("identity".to_owned(), run.dut.identity.clone())];
    facts.extend(run.dut.firmware.iter().map(|firmware| ("firmware".to_owned(), firmware.clone())));
    facts.extend(run.dut.details.iter().cloned());
    facts.extend(run.persona.iter().map(|persona| ("persona".to_owned(), persona.clone())));
    if !run.variations.is_empty() {
        facts.push(("variations".to_owned(), run.variations.join(", ")));
    }
    if !run.bugs.is_empty() {
        facts.push(("bugs".to_owned(), run.bugs.join(", ")));
    }
    facts.extend(run.bus.iter().flat_map(bus_lines).map(|line| ("bus".to_owned(), line)));
    facts.push(("cases and rules".to_owned(), totals(run.cases.iter().map(|case| case.verdict))));
    facts.push(("requirements".to_owned(), totals(run.requirements.iter().map(|of| of.verdict))));
    let failures: usize = run.causes.iter().map(|cause| cause.cases.len()).sum();
    for cause in run.causes.iter().take(MOST_CAUSES) {
        let Some(first) = cause.cases.first() else { continue };
        let kind = kind_of_cause(cause);
        let need = common_need(cause).map_or_else(String::new, |need| format!("; {need}"));
        let text =
            format!("{kind}; begin with {} ({} of {failures} failures{need})", short(run, first), cause.cases.len());
        facts.push(("cause".to_owned(), text));
    }
    for (reason, number) in repeated {
        facts.push(("shown once".to_owned(), format!("{number} more inconclusive: {reason}")));
    }
    if detailed.len() > MOST_ENTRIES {
        let text = format!("{} more; see the table of cases and rules", detailed.len() - MOST_ENTRIES);
        facts.push(("not shown in full".to_owned(), text));
    }
    Chapter {
        heading: run.dut.spec.clone(),
        facts,
        timelines: Vec::new(),
        entries: entries
            .map(|(index, case)| {
                let anchor = format!("case-{}-{}", number + 1, index + 1);
                entry(anchor, result, run, case, pictures(case))
            })
            .collect(),
        tables: handover::tables(result, run).into_iter().chain(tables(result, run)).collect(),
    }
}

/// Leaves out inconclusive results whose reason is that of one before; returns how many there are for each reason.
fn without_repeated<'a>(cases: impl Iterator<Item = &'a CaseResult>) -> (Vec<&'a CaseResult>, Vec<(&'a str, usize)>) {
    let mut shown: Vec<&CaseResult> = Vec::new();
    let mut repeated: Vec<(&str, usize)> = Vec::new();
    for case in cases {
        let is_same = |known: &&CaseResult| known.verdict == Verdict::Inconclusive && known.reason == case.reason;
        match case.reason.as_deref() {
            Some(reason) if case.verdict == Verdict::Inconclusive && shown.iter().any(is_same) => {
                match repeated.iter_mut().find(|(known, _)| *known == reason) {
                    Some((_, number)) => *number += 1,
                    None => repeated.push((reason, 1)),
                }
            }
            _ => shown.push(case),
        }
    }
    (shown, repeated)
}

fn entry(anchor: String, result: &RunResult, run: &DeviceRun, case: &CaseResult, pictures: CaseEvidence) -> PageEntry {
    let mut facts = vec![("level".to_owned(), level(case.level).to_owned())];
    facts.extend(case.passed_in_attempt.map(|attempt| ("flaky".to_owned(), format!("it passed in attempt {attempt}"))));
    facts.extend(case.reason.iter().map(|reason| ("reason".to_owned(), reason.clone())));
    case.failures.iter().for_each(|failure| add_failure(failure, &mut facts));
    facts.extend(case.notes.iter().map(|note| ("note".to_owned(), note.clone())));
    facts.extend(case.evidence.iter().map(|evidence| ("evidence".to_owned(), evidence.clone())));
    facts.push(("reproduce".to_owned(), reproduce(result, run, case)));
    PageEntry {
        anchor,
        tone: tone(case.verdict),
        word: case.verdict.word().to_owned(),
        head: format!("{}: {}", case.id, case.why),
        facts,
        packet: pictures.packet,
        timelines: pictures.timelines,
    }
}

/// Adds a failure as pairs of name and value.
fn add_failure(failure: &CaseFailure, facts: &mut Vec<(String, String)>) {
    let mut fact = |name: &str, value: String| facts.push((name.to_owned(), value));
    fact("failure", failure.what.clone());
    fact("blame", failure.blame.word().to_owned());
    fact("step", format!("{} ({})", failure.step, super::json::place(&failure.at)));
    for (id, clause, statement) in &failure.requirements {
        fact("requirement", format!("{id}, {clause}: {statement}"));
    }
    for part in failure.parts.iter().filter(|part| !part.held) {
        fact("expected", format!("{}: {}", part.text, part.expected));
        fact("observed", part.observed.clone());
    }
    if let Some(place) = &failure.place {
        fact("packet", place.frame.to_string());
        fact("display filter", place.filter.clone());
    }
    if !failure.trace.is_empty() {
        fact("frames around it", failure.trace.join("\n"));
    }
    fact("next step", failure.next.clone());
}

fn tone(verdict: Verdict) -> Tone {
    match verdict.colour() {
        Colour::Green => Tone::Good,
        Colour::Neutral => Tone::Plain,
        Colour::Red if verdict == Verdict::Fail => Tone::Bad,
        Colour::Red => Tone::Open,
    }
}

fn tables(result: &RunResult, run: &DeviceRun) -> Vec<PageTable> {
    let columns = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
    let findings = run.findings.iter().map(|of| {
        let said = of.parties().filter_map(|(who, said)| said.map(|said| format!("{who}: {said}")));
        let cells =
            vec![of.severity.word().to_owned(), of.id.clone(), of.text.clone(), said.collect::<Vec<_>>().join("; ")];
        (Tone::Plain, cells)
    });
    let requirements = run.requirements.iter().map(|of| {
        let why = of.note.clone().unwrap_or_else(|| of.cases.join(", "));
        let cells = vec![
            of.verdict.word().to_owned(),
            of.id.clone(),
            of.cites.clone(),
            level(of.level).to_owned(),
            of.statement.clone(),
            why,
        ];
        (tone(of.verdict), cells)
    });
    let cases = run.cases.iter().map(|case| {
        let covers = case.covers.iter().map(|covered| covered.id.as_str()).collect::<Vec<_>>().join(", ");
        let cells = vec![
            case.verdict.word().to_owned(),
            result_colour(result, run, case).word().to_owned(),
            case.id.clone(),
            case.why.clone(),
            covers,
            case.reason.clone().unwrap_or_default(),
        ];
        (tone(case.verdict), cells)
    });
    vec![
        PageTable {
            heading: "Findings outside the cases".to_owned(),
            columns: columns(&["severity", "id", "finding", "manual, description, device"]),
            rows: findings.collect(),
        },
        PageTable {
            heading: "Requirements".to_owned(),
            columns: columns(&["status", "id", "clause", "level", "statement", "cases, or why there is none"]),
            rows: requirements.collect(),
        },
        PageTable {
            heading: "Cases and rules".to_owned(),
            columns: columns(&["verdict", "counts as", "id", "what it checks", "covers", "reason"]),
            rows: cases.collect(),
        },
    ]
}
