//! Merges the parts of a run (`--part`), and runs of different devices, into one run.
//!
//! Parts that do not belong together are refused, and so is a run of which a part is missing: what was not tested must not be
//! reported as if it were.

use crate::ledger::{unmatched, update_requirements};
use crate::outcome::{
    CaseKind, CaseResult, DecisionCounts, DeviceFinding, DeviceRun, FindingSeverity, LedgerNote, RunPart, RunResult,
    never_decided,
};
use crate::verdict::Verdict;
use thiserror::Error;

/// A report to be merged.
#[derive(Clone, Debug)]
pub struct MergedReport {
    /// The name of its file, for messages.
    pub name: String,
    /// The version of encspec that wrote it.
    pub version: String,
    pub result: RunResult,
}

/// Why reports cannot be merged.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum MergeError {
    #[error("there is no report to merge")]
    Empty,
    /// Two reports differ in what has to be the same.
    #[error(
        "{one} and {other} do not belong together: {what} is {} in the one and {} in the other",
        values[0],
        values[1]
    )]
    Different { one: String, other: String, what: &'static str, values: [String; 2] },
    /// The same part, or the same whole run, is there twice.
    #[error("{one} and {other} are both {what} of {device}; each result may be there once")]
    Twice { one: String, other: String, what: String, device: String },
    /// Some parts of a run are not there.
    #[error("{} of {device} {}: the merged report would claim tests that were not run", listed(missing), verb(missing))]
    Missing { device: String, missing: Vec<RunPart> },
}

fn listed(missing: &[RunPart]) -> String {
    let names: Vec<String> = missing.iter().map(RunPart::to_string).collect();
    format!("{} {}", if missing.len() == 1 { "part" } else { "parts" }, names.join(", "))
}

fn verb(missing: &[RunPart]) -> &'static str {
    if missing.len() == 1 { "is missing" } else { "are missing" }
}

/// The runs of one device, each with the index of its report.
struct DeviceGroup {
    key: (String, usize),
    runs: Vec<(usize, DeviceRun)>,
}

/// Merges reports into one.
///
/// # Errors
///
/// The reports do not belong together, or a part is missing.
pub fn merge(reports: Vec<MergedReport>) -> Result<RunResult, MergeError> {
    let first = reports.first().ok_or(MergeError::Empty)?;
    for other in &reports {
        compare(first, other)?;
    }
    let mut merged = RunResult { runs: Vec::new(), part: None, ..first.result.clone() };
    merged.unmatched_entries.clear();
    merged.ledger_notes.clear();
    let mut groups: Vec<DeviceGroup> = Vec::new();
    for (index, report) in reports.iter().enumerate() {
        let mut before: Vec<String> = Vec::new();
        for run in &report.result.runs {
            let name = name_of(run);
            let key = (name.clone(), before.iter().filter(|known| **known == name).count());
            before.push(name);
            match groups.iter_mut().find(|group| group.key == key) {
                Some(group) => group.runs.push((index, run.clone())),
                None => groups.push(DeviceGroup { key, runs: vec![(index, run.clone())] }),
            }
        }
        for note in &report.result.ledger_notes {
            add(&mut merged.ledger_notes, note.clone());
        }
    }
    for mut group in groups {
        check_complete(&reports, &group)?;
        group.runs.sort_by_key(|(index, _)| reports[*index].result.part.map(|part| part.number));
        for name in unmatched_in_all(&reports, &group) {
            add(&mut merged.ledger_notes, LedgerNote { text: unmatched(&name), red: true });
        }
        // All parts together are a whole run, unless a filter left something out.
        let is_part = group.runs.iter().any(|(index, _)| reports[*index].result.part.is_some());
        let filtered = group.runs.iter().any(|(_, run)| run.filtered) && !(is_part && merged.filters.is_empty());
        merged.runs.push(device(group.runs.into_iter().map(|(_, run)| run).collect(), filtered));
    }
    for (name, hash) in reports.iter().flat_map(|report| &report.result.origin.suites) {
        if merged.origin.suites.iter().all(|(known, _)| known != name) {
            merged.origin.suites.push((name.clone(), hash.clone()));
        }
    }
    let origins = || reports.iter().map(|report| &report.result.origin);
    merged.origin.started = origins().filter_map(|of| of.started.clone()).min();
    let mut hosts: Vec<String> = Vec::new();
    origins().filter_map(|of| of.host.clone()).for_each(|host| add(&mut hosts, host));
    merged.origin.host = (!hosts.is_empty()).then(|| hosts.join(", "));
    Ok(merged)
}

fn add<T: PartialEq>(list: &mut Vec<T>, item: T) {
    if !list.contains(&item) {
        list.push(item);
    }
}

/// The device of a run, and what was enabled in it.
fn name_of(run: &DeviceRun) -> String {
    let persona = run.persona.iter().map(|persona| format!(" with persona {persona}"));
    let bugs = run.bugs.iter().map(|bug| format!(" with bug {bug}"));
    let variations = run.variations.iter().map(|variation| format!(" with variation {variation}"));
    let with: String = persona.chain(bugs).chain(variations).collect();
    format!("{}/{}{with}", run.dut.device, run.dut.variant)
}

/// What has to be the same in all reports.
fn compare(one: &MergedReport, other: &MergedReport) -> Result<(), MergeError> {
    let facts = |of: &MergedReport| {
        let RunResult { gate_must, fail_on_not_applicable, min_pass, accept_flaky, filters, origin, .. } = &of.result;
        let yes_no = |is: bool| if is { "on" } else { "off" }.to_owned();
        [
            ("the version of encspec", of.version.clone()),
            ("the commit of encspec", origin.commit.clone().unwrap_or_else(|| "unknown".to_owned())),
            ("--gate", if *gate_must { "must" } else { "should" }.to_owned()),
            ("--fail-on not-applicable", yes_no(*fail_on_not_applicable)),
            ("--min-pass", min_pass.map_or_else(|| "not set".to_owned(), |least| least.to_string())),
            ("--accept-flaky", yes_no(*accept_flaky)),
            ("the filter", if filters.is_empty() { "none".to_owned() } else { filters.join(" ") }),
        ]
    };
    for (name, hash) in &one.result.origin.suites {
        let theirs = other.result.origin.suites.iter().find(|(known, _)| known == name).map(|(_, hash)| hash);
        if let Some(theirs) = theirs.filter(|theirs| *theirs != hash) {
            return Err(different((&one.name, &other.name), "the hash of a suite", [hash.clone(), theirs.clone()]));
        }
    }
    for ((what, ours), (_, theirs)) in facts(one).into_iter().zip(facts(other)) {
        if ours != theirs {
            return Err(different((&one.name, &other.name), what, [ours, theirs]));
        }
    }
    Ok(())
}

fn different((one, other): (&str, &str), what: &'static str, values: [String; 2]) -> MergeError {
    MergeError::Different { one: one.to_owned(), other: other.to_owned(), what, values }
}

/// Whether the runs of a device are all parts of one run, each once, or one whole run.
fn check_complete(reports: &[MergedReport], group: &DeviceGroup) -> Result<(), MergeError> {
    let Some((first, run)) = group.runs.first() else { return Ok(()) };
    let first = &reports[*first];
    let device = group.key.0.clone();
    let parts_word = |part: Option<RunPart>| part.map_or("whole run".to_owned(), |part| format!("{} parts", part.of));
    for (at, (index, other_run)) in group.runs.iter().enumerate() {
        let other = &reports[*index];
        let names = (first.name.as_str(), other.name.as_str());
        let (ours, theirs) = (first.result.part, other.result.part);
        if ours.map(|part| part.of) != theirs.map(|part| part.of) {
            return Err(different(names, "--part", [parts_word(ours), parts_word(theirs)]));
        }
        let word = |firmware: &Option<String>| firmware.clone().unwrap_or_else(|| "unknown".to_owned());
        if run.dut.firmware != other_run.dut.firmware {
            return Err(different(names, "the firmware", [word(&run.dut.firmware), word(&other_run.dut.firmware)]));
        }
        if run.dut.kind != other_run.dut.kind {
            return Err(different(names, "the kind of device", [run.dut.kind.clone(), other_run.dut.kind.clone()]));
        }
        let same = |(index, _): &&(usize, DeviceRun)| reports[*index].result.part == theirs;
        if let Some((before, _)) = group.runs.iter().take(at).find(same) {
            let what = theirs.map_or("a whole run".to_owned(), |part| format!("part {part}"));
            let one = reports[*before].name.clone();
            return Err(MergeError::Twice { one, other: other.name.clone(), what, device });
        }
    }
    let of = first.result.part.map_or(0, |part| part.of);
    let is_there =
        |number: usize| group.runs.iter().any(|(at, _)| reports[*at].result.part.is_some_and(|p| p.number == number));
    let missing: Vec<RunPart> =
        (1..=of).filter(|number| !is_there(*number)).map(|number| RunPart { number, of }).collect();
    if missing.is_empty() { Ok(()) } else { Err(MergeError::Missing { device, missing }) }
}

/// The entries of the ledger that matched no test in any part of this device.
fn unmatched_in_all(reports: &[MergedReport], group: &DeviceGroup) -> Vec<String> {
    let mut of_parts = group.runs.iter().map(|(index, _)| &reports[*index].result.unmatched_entries);
    let Some(first) = of_parts.next() else { return Vec::new() };
    let others: Vec<&Vec<String>> = of_parts.collect();
    first.iter().filter(|name| others.iter().all(|other| other.contains(name))).cloned().collect()
}

/// Merges the parts of the run of one device, in the order of their numbers.
fn device(mut parts: Vec<DeviceRun>, filtered: bool) -> DeviceRun {
    if parts.len() == 1 {
        return DeviceRun { filtered, ..parts.remove(0) };
    }
    let mut cases = dealt(parts.iter().map(|run| of_kind(run, CaseKind::Trial)).collect());
    let rules = in_order(&parts.iter().map(|run| of_kind(run, CaseKind::Rule)).collect::<Vec<_>>());
    cases.extend(rules.into_iter().map(|of_parts| rule(&of_parts, filtered)));
    let mut findings: Vec<DeviceFinding> = Vec::new();
    for (number, run) in parts.iter().enumerate() {
        if run.dut.spec != parts[0].dut.spec {
            let text = format!("Part {} ran on {} ({}).", number + 1, run.dut.spec, run.dut.identity);
            findings.push(DeviceFinding {
                id: format!("part-{}", number + 1),
                severity: FindingSeverity::Info,
                text,
                manual: None,
                description: None,
                device: None,
            });
        }
        run.findings.iter().for_each(|finding| add(&mut findings, finding.clone()));
    }
    let bus = parts.iter().filter_map(|run| run.bus.clone()).reduce(|mut all, of_part| {
        all.merge(&of_part);
        all
    });
    let mut merged = DeviceRun { cases, findings, bus, filtered, causes: Vec::new(), ..parts[0].clone() };
    update_requirements(&mut merged);
    for of in &mut merged.requirements {
        let covering = || merged.cases.iter().filter(|case| case.covers.iter().any(|covered| covered.id == of.id));
        of.cases = covering().map(|case| case.id.clone()).collect();
        let unjudged: Vec<&str> = covering()
            .filter(|case| case.verdict == Verdict::Fail)
            .filter(|case| case.covers.iter().any(|of_case| of_case.id == of.id && of_case.verdict == Verdict::NotRun))
            .map(|case| case.id.as_str())
            .collect();
        let of_parts = parts.iter().flat_map(|run| &run.requirements).filter(|known| known.id == of.id);
        of.note = match of.cases.is_empty() {
            true => of_parts.filter_map(|known| known.note.clone()).next(),
            false if of.verdict == Verdict::NotRun && !unjudged.is_empty() => {
                Some(format!("not judged in a case that failed before: {}", unjudged.join(", ")))
            }
            false => None,
        };
    }
    merged
}

fn of_kind(run: &DeviceRun, kind: CaseKind) -> Vec<&CaseResult> {
    run.cases.iter().filter(|case| case.kind == kind).collect()
}

/// The trials in the order of the suite: they were dealt out to the parts in turn.
fn dealt(parts: Vec<Vec<&CaseResult>>) -> Vec<CaseResult> {
    let longest = parts.iter().map(Vec::len).max().unwrap_or_default();
    (0..longest).flat_map(|at| parts.iter().filter_map(move |part| part.get(at))).map(|case| (*case).clone()).collect()
}

/// The results of each rule, in an order that fits every part.
fn in_order<'a>(parts: &[Vec<&'a CaseResult>]) -> Vec<Vec<&'a CaseResult>> {
    let mut rules: Vec<Vec<&CaseResult>> = Vec::new();
    for part in parts {
        let mut next = 0;
        for case in part {
            match rules.iter().position(|known| known.iter().any(|of| of.id == case.id)) {
                Some(at) => {
                    rules[at].push(case);
                    next = at + 1;
                }
                None => {
                    rules.insert(next, vec![case]);
                    next += 1;
                }
            }
        }
    }
    rules
}

/// The result of a rule over all parts: broken if it is broken in one, decided if it is decided in one.
fn rule(of_parts: &[&CaseResult], filtered: bool) -> CaseResult {
    use Verdict::{Error, Fail, Inconclusive, NotApplicable, NotRun, Pass, Xfail, Xpass};
    // What the ledger excuses in one part passes in another one, which proves nothing against the entry.
    let order = [Fail, Error, Inconclusive, Xfail, Xpass, Pass, NotRun, NotApplicable];
    let rank = |case: &CaseResult| order.iter().position(|known| *known == case.verdict);
    let mut sorted: Vec<&CaseResult> = of_parts.to_vec();
    sorted.sort_by_key(|case| rank(case));
    let mut merged = sorted[0].clone();
    let mut decided = DecisionCounts::default();
    for of in of_parts.iter().filter_map(|case| case.decided) {
        decided.premises += of.premises;
        decided.undecided += of.undecided;
        decided.checked += of.checked;
    }
    merged.decided = Some(decided);
    merged.frames = decided.checked;
    for note in of_parts.iter().flat_map(|case| &case.notes) {
        add(&mut merged.notes, note.clone());
    }
    let is_never = |case: &&CaseResult| {
        case.reason.as_deref().is_some_and(|reason| reason.starts_with("the premise never occurred"))
    };
    if merged.verdict == NotRun && of_parts.iter().all(is_never) {
        merged.reason = Some(never_decided(&decided, filtered));
    }
    merged
}
