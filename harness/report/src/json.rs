//! The report as JSON: a contract with other tools. Keys may be added, none is renamed or removed.

use super::status::{ExitStatus, reasons, result_colour, status};
use super::words::{level, printable_json, reproduce};
use results::ledger;
use results::outcome::{
    BitTimeRange, BusStatistics, CaseFailure, CaseKind, CaseResult, DescriptionKind, DeviceFinding, DeviceRun, Dut,
    FailurePosition, JudgedPart, ProbableCause, RequirementResult, RunPart, RunResult,
};
use results::verdict::Verdict;
use serde::{Serialize, Serializer};
use suite::Location;

/// Writes the report, in the order of the run.
pub fn json(result: &RunResult) -> String {
    let report = ReportJson {
        tool: ToolJson { name: "encspec", version: env!("CARGO_PKG_VERSION"), commit: result.origin.commit.as_deref() },
        started: result.origin.started.as_deref(),
        host: result.origin.host.as_deref(),
        operator: result.origin.operator.as_deref(),
        suites: TextMapJson(&result.origin.suites),
        green: status(result) == ExitStatus::Green,
        reasons: reasons(result),
        gate: if result.gate_must { "must" } else { "should" },
        fail_on_not_applicable: result.fail_on_not_applicable,
        min_pass: result.min_pass.map(|least| least.to_string()),
        accept_flaky: result.accept_flaky,
        repeat: &result.repeat,
        filters: &result.filters,
        part: result.part.map(|RunPart { number, of }| PartOfRunJson { number, of }),
        unmatched_entries: &result.unmatched_entries,
        ledger_notes: result
            .ledger_notes
            .iter()
            .map(|note| LedgerNoteJson { text: &note.text, red: note.red })
            .collect(),
        runs: result.runs.iter().map(|run| DeviceRunJson::new(result, run)).collect(),
    };
    // These types have text keys and finite numbers only, so writing them cannot fail.
    let mut text = printable_json(&serde_json::to_string_pretty(&report).unwrap_or_default());
    text.push('\n');
    text
}

/// A position in a suite as `file:line:column`.
pub(super) fn place(at: &Location) -> String {
    format!("{}:{}:{}", at.file.display(), at.line, at.column)
}

#[derive(Serialize)]
struct ReportJson<'a> {
    tool: ToolJson<'a>,
    #[serde(skip_serializing_if = "Option::is_none")]
    started: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    host: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    operator: Option<&'a str>,
    #[serde(skip_serializing_if = "TextMapJson::is_empty")]
    suites: TextMapJson<'a>,
    green: bool,
    /// Why the run as a whole is not green, apart from its cases.
    reasons: Vec<String>,
    gate: &'static str,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    fail_on_not_applicable: bool,
    #[serde(skip_serializing_if = "Option::is_none")]
    min_pass: Option<String>,
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    accept_flaky: bool,
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    repeat: &'a [String],
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    filters: &'a [String],
    #[serde(skip_serializing_if = "Option::is_none")]
    part: Option<PartOfRunJson>,
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    unmatched_entries: &'a [String],
    ledger_notes: Vec<LedgerNoteJson<'a>>,
    runs: Vec<DeviceRunJson<'a>>,
}

#[derive(Serialize)]
struct ToolJson<'a> {
    name: &'static str,
    version: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    commit: Option<&'a str>,
}

/// Names with a text each.
struct TextMapJson<'a>(&'a [(String, String)]);

impl TextMapJson<'_> {
    fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl Serialize for TextMapJson<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, value)| (name, value)))
    }
}

#[derive(Serialize)]
struct PartOfRunJson {
    number: usize,
    of: usize,
}

#[derive(Serialize)]
struct LedgerNoteJson<'a> {
    text: &'a str,
    red: bool,
}

#[derive(Serialize)]
struct DeviceRunJson<'a> {
    dut: DutJson<'a>,
    #[serde(skip_serializing_if = "Option::is_none")]
    persona: Option<&'a str>,
    bugs: &'a [String],
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    bug_notes: &'a [String],
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    variations: &'a [String],
    filtered: bool,
    summary: SummaryJson,
    /// The failures grouped by probable cause.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    causes: Vec<CauseJson<'a>>,
    cases: Vec<CaseJson<'a>>,
    requirements: Vec<RequirementJson<'a>>,
    findings: Vec<FindingJson<'a>>,
    /// What the master measured on PROFIBUS.
    #[serde(skip_serializing_if = "Option::is_none")]
    bus: Option<BusJson>,
}

/// Measurements of the master, in bit times.
#[derive(Serialize)]
struct BusJson {
    min_tsdr_bits: u64,
    max_tsdr_bits: u64,
    stations: Vec<StationJson>,
    token_rotations: u64,
    rotation_bits: Option<RangeJson>,
}

/// The answers of one station.
#[derive(Serialize)]
struct StationJson {
    station: u8,
    answers: u64,
    answer_bits: Option<RangeJson>,
    after_max_tsdr: u64,
    retries: u64,
    unanswered: u64,
}

#[derive(Serialize)]
struct RangeJson {
    min: u64,
    mean: u64,
    max: u64,
    sum: u64,
}

impl RangeJson {
    fn new(range: &BitTimeRange) -> Option<RangeJson> {
        let [min, mean, max] = range.least_mean_most()?.map(|bits| bits.0);
        Some(RangeJson { min, mean, max, sum: range.sum().0 })
    }
}

impl BusJson {
    fn new(bus: &BusStatistics) -> BusJson {
        let stations = bus.stations().iter().map(|of| StationJson {
            station: of.station,
            answers: of.answers.count(),
            answer_bits: RangeJson::new(&of.answers),
            after_max_tsdr: of.late,
            retries: of.retries,
            unanswered: of.unanswered,
        });
        BusJson {
            min_tsdr_bits: bus.tsdr.0.0,
            max_tsdr_bits: bus.tsdr.1.0,
            stations: stations.collect(),
            token_rotations: bus.rotation.count(),
            rotation_bits: RangeJson::new(&bus.rotation),
        }
    }
}

/// Failures that probably have one cause.
#[derive(Serialize)]
struct CauseJson<'a> {
    /// The shortest failed case.
    begin_with: &'a str,
    /// What the cases need and passed cases mostly do not.
    common: &'a [String],
    cases: &'a [String],
    requirements: &'a [String],
}

/// A disagreement of manual, description and device; null means that it has no value.
#[derive(Serialize)]
struct FindingJson<'a> {
    id: &'a str,
    severity: &'static str,
    text: &'a str,
    manual: Option<&'a str>,
    #[serde(flatten)]
    described: DescriptionsJson<'a>,
    device: Option<&'a str>,
}

/// The values in the descriptions, by the key of their kind.
struct DescriptionsJson<'a>(&'a DeviceFinding);

impl Serialize for DescriptionsJson<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let said = DescriptionKind::ALL.into_iter().map(|kind| (kind, self.0.described_by(kind)));
        let written = said.filter(|(kind, said)| said.is_some() || kind.is_always_written());
        serializer.collect_map(written.map(|(kind, said)| (kind.key(), said)))
    }
}

#[derive(Serialize)]
struct DutJson<'a> {
    kind: &'a str,
    spec: &'a str,
    device: &'a str,
    variant: &'a str,
    identity: &'a str,
    firmware: Option<&'a str>,
    #[serde(skip_serializing_if = "TextMapJson::is_empty")]
    details: TextMapJson<'a>,
}

/// Every verdict with its number, in the order of [`Verdict::ALL`].
struct SummaryJson(Vec<(Verdict, usize)>);

impl Serialize for SummaryJson {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(verdict, n)| (verdict.word(), n)))
    }
}

#[derive(Serialize)]
struct CaseJson<'a> {
    id: &'a str,
    kind: &'static str,
    why: &'a str,
    verdict: &'static str,
    /// `green`, `neutral` or `red`: how the verdict counts in this run.
    counts: &'static str,
    level: &'static str,
    covers: Vec<&'a str>,
    /// Requirements whose own check has another verdict than the case.
    apart: Vec<CoveredJson<'a>>,
    reason: Option<&'a str>,
    failure: Option<FailureJson<'a>>,
    more_failures: Vec<FailureJson<'a>>,
    readings: Vec<ReadingJson<'a>>,
    saved: Vec<SavedJson<'a>>,
    notes: &'a [String],
    decided: Option<DecidedJson>,
    duration_ns: u64,
    frames: u64,
    at: String,
    evidence: Option<&'a str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    evidence_sha256: Option<&'a str>,
    reproduce: String,
    /// How often a live trial was repeated for a stall.
    #[serde(skip_serializing_if = "is_zero")]
    repeats: u32,
    /// The attempt in which it passed after it had failed.
    #[serde(skip_serializing_if = "Option::is_none")]
    passed_in_attempt: Option<u32>,
    /// The lines of the bench file that would make the trial applicable.
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    bench_lines: &'a [String],
}

fn is_zero(number: &u32) -> bool {
    *number == 0
}

#[derive(Serialize)]
struct CoveredJson<'a> {
    id: &'a str,
    verdict: &'static str,
}

#[derive(Serialize)]
struct ReadingJson<'a> {
    step: &'a str,
    reading: &'a str,
}

#[derive(Serialize)]
struct SavedJson<'a> {
    name: &'a str,
    value: &'a str,
}

#[derive(Serialize)]
struct DecidedJson {
    premises: u64,
    undecided: u64,
    looked_at: u64,
}

#[derive(Serialize)]
struct FailureJson<'a> {
    blame: &'static str,
    what: &'a str,
    step: &'a str,
    at: String,
    requirements: Vec<BrokenRequirementJson<'a>>,
    parts: Vec<PartJson<'a>>,
    place: Option<PlaceJson<'a>>,
    trace: &'a [String],
    next: &'a str,
    signature: String,
    /// Only if it happened before the test, in `start` or `given`.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    before_test: bool,
}

#[derive(Serialize)]
struct BrokenRequirementJson<'a> {
    id: &'a str,
    clause: &'a str,
    statement: &'a str,
}

#[derive(Serialize)]
struct PartJson<'a> {
    text: &'a str,
    expected: &'a str,
    seen: &'a str,
    held: bool,
}

#[derive(Serialize)]
struct PlaceJson<'a> {
    frame: u64,
    octet: Option<usize>,
    bit: Option<u8>,
    filter: &'a str,
}

#[derive(Serialize)]
struct RequirementJson<'a> {
    id: &'a str,
    #[serde(skip_serializing_if = "Option::is_none")]
    chapter: Option<&'a str>,
    clause: &'a str,
    statement: &'a str,
    level: &'static str,
    status: &'static str,
    note: Option<&'a str>,
    cases: &'a [String],
}

impl<'a> DeviceRunJson<'a> {
    fn new(result: &RunResult, run: &'a DeviceRun) -> DeviceRunJson<'a> {
        let Dut { kind, spec, device, variant, identity, firmware, details } = &run.dut;
        DeviceRunJson {
            dut: DutJson {
                kind,
                spec,
                device,
                variant,
                identity,
                firmware: firmware.as_deref(),
                details: TextMapJson(details),
            },
            persona: run.persona.as_deref(),
            bugs: &run.bugs,
            bug_notes: &run.bug_notes,
            variations: &run.variations,
            filtered: run.filtered,
            summary: SummaryJson(run.summary()),
            causes: run.causes.iter().filter_map(CauseJson::new).collect(),
            cases: run.cases.iter().map(|case| CaseJson::new(result, run, case)).collect(),
            requirements: run.requirements.iter().map(RequirementJson::new).collect(),
            findings: run.findings.iter().map(FindingJson::new).collect(),
            bus: run.bus.as_ref().map(BusJson::new),
        }
    }
}

impl<'a> FindingJson<'a> {
    fn new(of: &'a DeviceFinding) -> FindingJson<'a> {
        let DeviceFinding { id, severity, text, manual, description: _, device } = of;
        let (manual, device) = (manual.as_deref(), device.as_deref());
        FindingJson { id, severity: severity.word(), text, manual, described: DescriptionsJson(of), device }
    }
}

impl<'a> CaseJson<'a> {
    fn new(result: &RunResult, run: &DeviceRun, case: &'a CaseResult) -> CaseJson<'a> {
        let mut failures = case.failures.iter().map(FailureJson::new);
        CaseJson {
            id: &case.id,
            kind: match case.kind {
                CaseKind::Trial => "case",
                CaseKind::Rule => "rule",
            },
            why: &case.why,
            verdict: case.verdict.word(),
            counts: result_colour(result, run, case).word(),
            level: level(case.level),
            covers: case.covers.iter().map(|covered| covered.id.as_str()).collect(),
            apart: case
                .covers
                .iter()
                .filter(|covered| covered.verdict != case.verdict)
                .map(|covered| CoveredJson { id: &covered.id, verdict: covered.verdict.word() })
                .collect(),
            reason: case.reason.as_deref(),
            failure: failures.next(),
            more_failures: failures.collect(),
            readings: case.readings.iter().map(|(step, reading)| ReadingJson { step, reading }).collect(),
            saved: case.saved.iter().map(|(name, value)| SavedJson { name, value }).collect(),
            notes: &case.notes,
            decided: case.decided.map(|decided| DecidedJson {
                premises: decided.premises,
                undecided: decided.undecided,
                looked_at: decided.checked,
            }),
            duration_ns: u64::try_from(case.duration.as_nanos()).unwrap_or(u64::MAX),
            frames: case.frames,
            at: place(&case.at),
            evidence: case.evidence.as_deref(),
            evidence_sha256: case.evidence_sha256.as_deref(),
            reproduce: reproduce(result, run, case),
            repeats: case.repeats,
            passed_in_attempt: case.passed_in_attempt,
            bench_lines: &case.bench_lines,
        }
    }
}

impl<'a> CauseJson<'a> {
    fn new(cause: &'a ProbableCause) -> Option<CauseJson<'a>> {
        let begin_with = cause.cases.first()?;
        Some(CauseJson { begin_with, common: &cause.common, cases: &cause.cases, requirements: &cause.requirements })
    }
}

impl<'a> FailureJson<'a> {
    fn new(failure: &'a CaseFailure) -> FailureJson<'a> {
        FailureJson {
            blame: failure.blame.word(),
            what: &failure.what,
            step: &failure.step,
            at: place(&failure.at),
            requirements: failure
                .requirements
                .iter()
                .map(|(id, clause, statement)| BrokenRequirementJson { id, clause, statement })
                .collect(),
            parts: failure
                .parts
                .iter()
                .map(|JudgedPart { text, expected: wanted, observed: seen, held }| PartJson {
                    text,
                    expected: wanted,
                    seen,
                    held: *held,
                })
                .collect(),
            place: failure.place.as_ref().map(|FailurePosition { frame, octet, bit, filter }| PlaceJson {
                frame: *frame,
                octet: *octet,
                bit: *bit,
                filter,
            }),
            trace: &failure.trace,
            next: &failure.next,
            signature: ledger::signature(failure),
            before_test: failure.before_test,
        }
    }
}

impl<'a> RequirementJson<'a> {
    fn new(of: &'a RequirementResult) -> RequirementJson<'a> {
        RequirementJson {
            id: &of.id,
            chapter: of.chapter.as_deref(),
            clause: &of.cites,
            statement: &of.statement,
            level: level(of.level),
            status: of.verdict.word(),
            note: of.note.as_deref(),
            cases: &of.cases,
        }
    }
}
