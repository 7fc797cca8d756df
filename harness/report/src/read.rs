//! Reads the JSON report back into a [`RunResult`], so that runs can be compared and merged.
//!
//! Writing what was read gives the same JSON. Keys that this version does not know are ignored; keys that older versions did not
//! write may be missing.

use results::outcome::{
    BitTimeRange, BitTimes, BusStatistics, CaseFailure, CaseKind, CaseResult, Covered, DecisionCounts, DescriptionKind,
    DeviceFinding, DeviceRun, Dut, FailureCause, FailurePosition, FindingSeverity, JudgedPart, LedgerNote,
    ProbableCause, RequirementResult, RunOrigin, RunPart, RunResult, StationStatistics,
};
use results::verdict::Verdict;
use serde::Deserialize;
use serde::de::{Deserializer, Error as _, MapAccess, Visitor};
use std::path::PathBuf;
use std::sync::Arc;
use std::time::Duration;
use suite::Location;
use suite::model::Level;

/// Why a text is not a JSON report of `encspec run`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ReadError(String);

impl std::fmt::Display for ReadError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "not a JSON report of `encspec run`: {}", self.0)
    }
}

impl std::error::Error for ReadError {}

/// Reads a JSON report: the version of encspec that wrote it, and the run.
///
/// # Errors
///
/// The text is not such a report; the error says where.
pub fn read(text: &str) -> Result<(String, RunResult), ReadError> {
    let read: ReportText = serde_json::from_str(text).map_err(|error| ReadError(error.to_string()))?;
    if read.tool.name != "encspec" {
        return Err(ReadError(format!("it was written by `{}`", read.tool.name)));
    }
    let min_pass = read.min_pass.map(|least| least.parse()).transpose().map_err(ReadError)?;
    let result = RunResult {
        runs: read.runs.into_iter().map(DeviceRunText::into_run).collect(),
        ledger_notes: read.ledger_notes.into_iter().map(|of| LedgerNote { text: of.text, red: of.red }).collect(),
        gate_must: read.gate == "must",
        fail_on_not_applicable: read.fail_on_not_applicable,
        min_pass,
        accept_flaky: read.accept_flaky,
        repeat: read.repeat,
        filters: read.filters,
        part: read.part.map(|of| RunPart { number: of.number, of: of.of }),
        unmatched_entries: read.unmatched_entries,
        origin: RunOrigin {
            commit: read.tool.commit,
            started: read.started,
            host: read.host,
            operator: read.operator,
            suites: read.suites.0,
        },
    };
    Ok((read.tool.version, result))
}

#[derive(Deserialize)]
struct ReportText {
    tool: ToolText,
    started: Option<String>,
    host: Option<String>,
    operator: Option<String>,
    #[serde(default)]
    suites: TextMapText,
    gate: String,
    #[serde(default)]
    fail_on_not_applicable: bool,
    min_pass: Option<String>,
    #[serde(default)]
    accept_flaky: bool,
    #[serde(default)]
    repeat: Vec<String>,
    #[serde(default)]
    filters: Vec<String>,
    part: Option<PartOfRunText>,
    #[serde(default)]
    unmatched_entries: Vec<String>,
    ledger_notes: Vec<LedgerNoteText>,
    runs: Vec<DeviceRunText>,
}

#[derive(Deserialize)]
struct ToolText {
    name: String,
    version: String,
    commit: Option<String>,
}

#[derive(Deserialize)]
struct PartOfRunText {
    number: usize,
    of: usize,
}

#[derive(Deserialize)]
struct LedgerNoteText {
    text: String,
    red: bool,
}

#[derive(Deserialize)]
struct DeviceRunText {
    dut: DutText,
    persona: Option<String>,
    bugs: Vec<String>,
    #[serde(default)]
    bug_notes: Vec<String>,
    #[serde(default)]
    variations: Vec<String>,
    filtered: bool,
    #[serde(default)]
    causes: Vec<CauseText>,
    cases: Vec<CaseText>,
    requirements: Vec<RequirementText>,
    findings: Vec<FindingText>,
    bus: Option<BusText>,
}

impl DeviceRunText {
    fn into_run(self) -> DeviceRun {
        let ids: Vec<String> = self.requirements.iter().map(|of| of.id.clone()).collect();
        let causes = self.causes.into_iter().map(|of| ProbableCause {
            common: of.common,
            cases: of.cases,
            requirements: of.requirements,
        });
        DeviceRun {
            dut: self.dut.into_dut(),
            cases: self.cases.into_iter().map(|case| case.into_case(&ids)).collect(),
            requirements: self.requirements.into_iter().map(RequirementText::into_requirement).collect(),
            filtered: self.filtered,
            persona: self.persona,
            bugs: self.bugs,
            variations: self.variations,
            bug_notes: self.bug_notes,
            findings: self.findings.into_iter().map(FindingText::into_finding).collect(),
            causes: causes.collect(),
            bus: self.bus.map(BusText::into_bus),
        }
    }
}

#[derive(Deserialize)]
struct DutText {
    kind: String,
    spec: String,
    device: String,
    variant: String,
    identity: String,
    firmware: Option<String>,
    #[serde(default)]
    details: TextMapText,
}

impl DutText {
    fn into_dut(self) -> Dut {
        let DutText { kind, spec, device, variant, identity, firmware, details } = self;
        Dut { kind, spec, device, variant, identity, firmware, details: details.0 }
    }
}

/// Names with a text each, in the order of the report.
#[derive(Default)]
struct TextMapText(Vec<(String, String)>);

impl<'de> Deserialize<'de> for TextMapText {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<TextMapText, D::Error> {
        struct InOrder;
        impl<'de> Visitor<'de> for InOrder {
            type Value = TextMapText;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("names with a text each")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<TextMapText, A::Error> {
                let mut entries = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    entries.push(entry);
                }
                Ok(TextMapText(entries))
            }
        }
        from.deserialize_map(InOrder)
    }
}

#[derive(Deserialize)]
struct CauseText {
    common: Vec<String>,
    cases: Vec<String>,
    requirements: Vec<String>,
}

#[derive(Deserialize)]
struct CaseText {
    id: String,
    #[serde(deserialize_with = "kind")]
    kind: CaseKind,
    why: String,
    #[serde(deserialize_with = "verdict")]
    verdict: Verdict,
    #[serde(deserialize_with = "level")]
    level: Level,
    covers: Vec<String>,
    #[serde(default)]
    apart: Vec<CoveredText>,
    reason: Option<String>,
    failure: Option<FailureText>,
    #[serde(default)]
    more_failures: Vec<FailureText>,
    #[serde(default)]
    readings: Vec<ReadingText>,
    #[serde(default)]
    saved: Vec<SavedText>,
    #[serde(default)]
    notes: Vec<String>,
    decided: Option<DecidedText>,
    #[serde(default)]
    duration_ns: u64,
    #[serde(default)]
    frames: u64,
    #[serde(deserialize_with = "location")]
    at: Location,
    evidence: Option<String>,
    evidence_sha256: Option<String>,
    #[serde(default)]
    repeats: u32,
    passed_in_attempt: Option<u32>,
    #[serde(default)]
    bench_lines: Vec<String>,
}

impl CaseText {
    /// The case; `ids` are those of the requirements of its run.
    fn into_case(self, ids: &[String]) -> CaseResult {
        let covered = |id: String| {
            let apart = self.apart.iter().find(|of| of.id == id).map(|of| of.verdict);
            let requirement = ids.iter().position(|known| *known == id).unwrap_or(usize::MAX);
            Covered { requirement, id, verdict: apart.unwrap_or(self.verdict) }
        };
        CaseResult {
            covers: self.covers.into_iter().map(covered).collect(),
            id: self.id,
            kind: self.kind,
            why: self.why,
            verdict: self.verdict,
            level: self.level,
            reason: self.reason,
            failures: self.failure.into_iter().chain(self.more_failures).map(FailureText::into_failure).collect(),
            readings: self.readings.into_iter().map(|of| (of.step, of.reading)).collect(),
            saved: self.saved.into_iter().map(|of| (of.name, of.value)).collect(),
            notes: self.notes,
            decided: self.decided.map(|of| DecisionCounts {
                premises: of.premises,
                undecided: of.undecided,
                checked: of.looked_at,
            }),
            duration: Duration::from_nanos(self.duration_ns),
            frames: self.frames,
            at: self.at,
            evidence: self.evidence,
            evidence_sha256: self.evidence_sha256,
            repeats: self.repeats,
            passed_in_attempt: self.passed_in_attempt,
            bench_lines: self.bench_lines,
        }
    }
}

#[derive(Deserialize)]
struct CoveredText {
    id: String,
    #[serde(deserialize_with = "verdict")]
    verdict: Verdict,
}

#[derive(Deserialize)]
struct ReadingText {
    step: String,
    reading: String,
}

#[derive(Deserialize)]
struct SavedText {
    name: String,
    value: String,
}

#[derive(Deserialize)]
struct DecidedText {
    premises: u64,
    undecided: u64,
    looked_at: u64,
}

#[derive(Deserialize)]
struct FailureText {
    #[serde(deserialize_with = "blame")]
    blame: FailureCause,
    what: String,
    step: String,
    #[serde(deserialize_with = "location")]
    at: Location,
    requirements: Vec<BrokenRequirementText>,
    parts: Vec<PartText>,
    place: Option<PlaceText>,
    trace: Vec<String>,
    next: String,
    #[serde(default)]
    before_test: bool,
}

impl FailureText {
    fn into_failure(self) -> CaseFailure {
        let parts = self.parts.into_iter().map(|of| JudgedPart {
            text: of.text,
            expected: of.expected,
            observed: of.seen,
            held: of.held,
        });
        CaseFailure {
            blame: self.blame,
            what: self.what,
            step: self.step,
            at: self.at,
            requirements: self.requirements.into_iter().map(|of| (of.id, of.clause, of.statement)).collect(),
            parts: parts.collect(),
            place: self.place.map(|PlaceText { frame, octet, bit, filter }| FailurePosition {
                frame,
                octet,
                bit,
                filter,
            }),
            trace: self.trace,
            next: self.next,
            before_test: self.before_test,
        }
    }
}

#[derive(Deserialize)]
struct BrokenRequirementText {
    id: String,
    clause: String,
    statement: String,
}

#[derive(Deserialize)]
struct PartText {
    text: String,
    expected: String,
    seen: String,
    held: bool,
}

#[derive(Deserialize)]
struct PlaceText {
    frame: u64,
    octet: Option<usize>,
    bit: Option<u8>,
    filter: String,
}

#[derive(Deserialize)]
struct RequirementText {
    id: String,
    chapter: Option<String>,
    clause: String,
    statement: String,
    #[serde(deserialize_with = "level")]
    level: Level,
    #[serde(deserialize_with = "verdict")]
    status: Verdict,
    note: Option<String>,
    cases: Vec<String>,
}

impl RequirementText {
    fn into_requirement(self) -> RequirementResult {
        RequirementResult {
            id: self.id,
            chapter: self.chapter,
            cites: self.clause,
            statement: self.statement,
            level: self.level,
            verdict: self.status,
            note: self.note,
            cases: self.cases,
        }
    }
}

#[derive(Deserialize)]
struct FindingText {
    id: String,
    #[serde(deserialize_with = "severity")]
    severity: FindingSeverity,
    text: String,
    manual: Option<String>,
    gsdml: Option<String>,
    gsd: Option<String>,
    device: Option<String>,
}

impl FindingText {
    fn into_finding(self) -> DeviceFinding {
        let gsd = self.gsd.map(|said| (DescriptionKind::Gsd, said));
        DeviceFinding {
            id: self.id,
            severity: self.severity,
            text: self.text,
            manual: self.manual,
            description: self.gsdml.map(|said| (DescriptionKind::Gsdml, said)).or(gsd),
            device: self.device,
        }
    }
}

#[derive(Deserialize)]
struct BusText {
    min_tsdr_bits: u64,
    max_tsdr_bits: u64,
    stations: Vec<StationText>,
    token_rotations: u64,
    rotation_bits: Option<RangeText>,
}

#[derive(Deserialize)]
struct StationText {
    station: u8,
    answers: u64,
    answer_bits: Option<RangeText>,
    after_max_tsdr: u64,
    retries: u64,
    unanswered: u64,
}

#[derive(Deserialize)]
struct RangeText {
    min: u64,
    mean: u64,
    max: u64,
    sum: Option<u64>,
}

/// The range of `count` durations. Older reports have no sum, only the rounded mean.
fn range(count: u64, of: Option<RangeText>) -> BitTimeRange {
    of.map_or_else(BitTimeRange::default, |of| {
        BitTimeRange::from_parts(count, [of.min, of.max, of.sum.unwrap_or(of.mean.saturating_mul(count))])
    })
}

impl BusText {
    fn into_bus(self) -> BusStatistics {
        let station = |of: StationText| StationStatistics {
            station: of.station,
            answers: range(of.answers, of.answer_bits),
            late: of.after_max_tsdr,
            retries: of.retries,
            unanswered: of.unanswered,
        };
        let stations = self.stations.into_iter().map(station).collect();
        let tsdr = (BitTimes(self.min_tsdr_bits), BitTimes(self.max_tsdr_bits));
        BusStatistics::from_parts(stations, range(self.token_rotations, self.rotation_bits), tsdr)
    }
}

/// One of the words of a report.
fn word<'de, D: Deserializer<'de>, T: Copy>(from: D, what: &str, words: &[(&str, T)]) -> Result<T, D::Error> {
    let text = String::deserialize(from)?;
    let known = words.iter().find(|(word, _)| *word == text);
    known.map(|(_, of)| *of).ok_or_else(|| D::Error::custom(format!("`{}` is no {what}", text.escape_default())))
}

fn verdict<'de, D: Deserializer<'de>>(from: D) -> Result<Verdict, D::Error> {
    word(from, "verdict", &Verdict::ALL.map(|of| (of.word(), of)))
}

fn level<'de, D: Deserializer<'de>>(from: D) -> Result<Level, D::Error> {
    word(from, "level", &[Level::Must, Level::Should, Level::Info].map(|of| (super::words::level(of), of)))
}

fn kind<'de, D: Deserializer<'de>>(from: D) -> Result<CaseKind, D::Error> {
    word(from, "kind of result", &[("case", CaseKind::Trial), ("rule", CaseKind::Rule)])
}

fn blame<'de, D: Deserializer<'de>>(from: D) -> Result<FailureCause, D::Error> {
    use FailureCause::{Device, Environment, Harness, Suite, Undecided};
    word(from, "blame", &[Device, Harness, Environment, Suite, Undecided].map(|of| (of.word(), of)))
}

fn severity<'de, D: Deserializer<'de>>(from: D) -> Result<FindingSeverity, D::Error> {
    use FindingSeverity::{Error, Info, Warning};
    word(from, "severity", &[Info, Warning, Error].map(|of| (of.word(), of)))
}

fn location<'de, D: Deserializer<'de>>(from: D) -> Result<Location, D::Error> {
    let text = String::deserialize(from)?;
    let wrong = || D::Error::custom(format!("`{}` is not FILE:LINE:COLUMN", text.escape_default()));
    let mut parts = text.rsplitn(3, ':');
    let column = parts.next().and_then(|part| part.parse().ok()).ok_or_else(wrong)?;
    let line = parts.next().and_then(|part| part.parse().ok()).ok_or_else(wrong)?;
    let file = parts.next().ok_or_else(wrong)?;
    Ok(Location { file: Arc::new(PathBuf::from(file)), line, column })
}
