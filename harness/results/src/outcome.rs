//! The results of a run as plain data. Every report is made from this data only.

use crate::verdict::Verdict;
use std::time::Duration;
use suite::Location;
use suite::model::Level;

pub use wire::profibus::fdl::BitTimes;
pub use wire::profibus::statistics::{BitTimeRange, BusStatistics, StationStatistics};

/// The results of one call of `encspec run`, one entry per device under test.
#[derive(Clone, Debug, Default)]
pub struct RunResult {
    pub runs: Vec<DeviceRun>,
    /// Notes on ledger entries that match no test or have expired.
    pub ledger_notes: Vec<LedgerNote>,
    /// Whether only `must` requirements affect the exit status (`--gate must`).
    pub gate_must: bool,
    /// Whether results that are not applicable make the run red (`--fail-on not-applicable`).
    pub fail_on_not_applicable: bool,
    /// How many results of each device have to pass (`--min-pass`).
    pub min_pass: Option<MinimumPass>,
    /// Whether a failed trial that passed when it was repeated counts as neutral (`--accept-flaky`).
    pub accept_flaky: bool,
    /// Command-line arguments to repeat in each command that reproduces a failure (`--suites DIR`).
    pub repeat: Vec<String>,
    /// The filters of the command line, as they were written; empty if everything was selected.
    pub filters: Vec<String>,
    /// Which part of the trials this is (`--part`); `None`: all of them.
    pub part: Option<RunPart>,
    /// The entries of the ledger that matched no test of a part; in a whole run this is a red note.
    pub unmatched_entries: Vec<String>,
    /// What made the run, and where.
    pub origin: RunOrigin,
}

/// One of several parts of the trials of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RunPart {
    /// The number of this part, from 1.
    pub number: usize,
    /// The number of parts.
    pub of: usize,
}

/// Formats it as `--part` takes it.
impl std::fmt::Display for RunPart {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

/// What made a run, and where: what a report needs to be traced back.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct RunOrigin {
    /// The commit from which encspec was built, if it is known.
    pub commit: Option<String>,
    /// When a live run began, as `2026-11-28T04:05:06Z`; virtual runs have no time.
    pub started: Option<String>,
    /// The name of the host of a live run.
    pub host: Option<String>,
    /// Who ran it (`--operator`).
    pub operator: Option<String>,
    /// The suites, each with the SHA-256 of its files.
    pub suites: Vec<(String, String)>,
}

/// The results of a device that have to pass at least.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MinimumPass {
    /// A number of results.
    Results(usize),
    /// A percentage of all results, 0 to 100.
    Percent(u8),
}

impl MinimumPass {
    /// Whether `passed` of `all` results are enough.
    pub fn is_reached(self, passed: usize, all: usize) -> bool {
        match self {
            MinimumPass::Results(least) => passed >= least,
            MinimumPass::Percent(least) => passed * 100 >= usize::from(least) * all,
        }
    }
}

/// The form of `--min-pass`: `40` or `80%`.
impl std::str::FromStr for MinimumPass {
    type Err = String;

    fn from_str(text: &str) -> Result<MinimumPass, String> {
        let wrong = || format!("`{text}` is no number of results; write 40, or 80% for a percentage");
        match text.strip_suffix('%') {
            Some(percent) => {
                let percent = percent.trim_end().parse().ok().filter(|percent| *percent <= 100);
                percent.map(MinimumPass::Percent).ok_or_else(wrong)
            }
            None => text.parse().map(MinimumPass::Results).map_err(|_| wrong()),
        }
    }
}

/// Formats it as `--min-pass` takes it.
impl std::fmt::Display for MinimumPass {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            MinimumPass::Results(least) => write!(f, "{least}"),
            MinimumPass::Percent(least) => write!(f, "{least}%"),
        }
    }
}

/// A note on the ledger of known failures.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LedgerNote {
    pub text: String,
    /// Whether it makes the run fail.
    pub red: bool,
}

/// What was found about one device under test.
#[derive(Clone, Debug)]
pub struct DeviceRun {
    pub dut: Dut,
    /// Trials and rules in the order of the suites: trials first, then rules.
    pub cases: Vec<CaseResult>,
    /// The requirements in the order of the manual.
    pub requirements: Vec<RequirementResult>,
    /// Whether a filter excluded trials.
    pub filtered: bool,
    /// The persona of the controller; `None`: the default behaviour of the harness.
    pub persona: Option<String>,
    /// Bugs that were enabled in a reference device.
    pub bugs: Vec<String>,
    /// Permitted variations that were enabled in a reference device.
    pub variations: Vec<String>,
    /// Descriptions of enabled bugs that no manual lists, as `name: sentence`.
    pub bug_notes: Vec<String>,
    /// Findings outside of cases, in the order found: contradictions between manual, description and device, wrong claims of the
    /// bench file.
    pub findings: Vec<DeviceFinding>,
    /// The failures grouped by probable cause, the first one first; empty if fewer than two results failed.
    pub causes: Vec<ProbableCause>,
    /// What the master measured on PROFIBUS over all trials; `None` on PROFINET, and if no trial ran.
    pub bus: Option<BusStatistics>,
}

/// Failures that probably have one cause.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ProbableCause {
    /// What all of them need, in words, and passed cases mostly do not: `procedure preset`, `check of G1_XIST1`. Empty for one failure.
    pub common: Vec<String>,
    /// The ids of the failed cases and rules; the shortest case comes first.
    pub cases: Vec<String>,
    /// The ids of the requirements that fail in them.
    pub requirements: Vec<String>,
}

/// A contradiction between the manual, the vendor's description (GSDML or GSD) and the device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeviceFinding {
    /// Stable identifier: the subject and its property, for instance `telegram_83.octets`.
    pub id: String,
    pub severity: FindingSeverity,
    /// The disagreement in one sentence.
    pub text: String,
    /// The value of the manual or the bench file, if it has one.
    pub manual: Option<String>,
    /// The kind and the value of the vendor's description, if there is one.
    pub description: Option<(DescriptionKind, String)>,
    /// The value of the device, if it was read.
    pub device: Option<String>,
}

impl DeviceFinding {
    /// The value of a description of this kind.
    pub fn described_by(&self, kind: DescriptionKind) -> Option<&str> {
        self.description.as_ref().filter(|(known, _)| *known == kind).map(|(_, said)| said.as_str())
    }

    /// The possible sources, each with its value: the manual, each kind of description, the device.
    pub fn parties(&self) -> impl Iterator<Item = (&'static str, Option<&str>)> {
        let described = DescriptionKind::ALL.map(|kind| (kind.title(), self.described_by(kind)));
        [("manual", self.manual.as_deref())].into_iter().chain(described).chain([("device", self.device.as_deref())])
    }
}

/// A kind of device description of a vendor.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DescriptionKind {
    /// GSDML of PROFINET.
    Gsdml,
    /// GSD of PROFIBUS.
    Gsd,
}

impl DescriptionKind {
    /// Every kind, in the order of reports.
    pub const ALL: [DescriptionKind; 2] = [DescriptionKind::Gsdml, DescriptionKind::Gsd];

    /// Title, key in bench files and JSON, and whether JSON writes a missing value as null.
    const fn facts(self) -> (&'static str, &'static str, bool) {
        match self {
            DescriptionKind::Gsdml => ("GSDML", "gsdml", true),
            DescriptionKind::Gsd => ("GSD", "gsd", false),
        }
    }

    /// The title in reports.
    pub fn title(self) -> &'static str {
        self.facts().0
    }

    /// The key in bench files and JSON.
    pub fn key(self) -> &'static str {
        self.facts().1
    }

    /// Whether JSON writes a missing value as null; otherwise the key is left out.
    pub fn is_always_written(self) -> bool {
        self.facts().2
    }
}

/// The severity of a finding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum FindingSeverity {
    /// For information only.
    Info,
    /// Should be checked; does not make a run fail.
    Warning,
    /// Makes a run fail.
    Error,
}

impl FindingSeverity {
    /// The word in reports.
    pub fn word(self) -> &'static str {
        match self {
            FindingSeverity::Info => "info",
            FindingSeverity::Warning => "warning",
            FindingSeverity::Error => "error",
        }
    }
}

/// A device under test.
#[derive(Clone, Debug)]
pub struct Dut {
    /// `model`, `null`, `nic`, `socket`, `serial`.
    pub kind: String,
    /// The device as in `--dut`, for instance `model:lika-xac77-profinet/xac7718` or `null:silent`.
    pub spec: String,
    /// Name of the manual, for instance `lika-xac77-profinet`.
    pub device: String,
    pub variant: String,
    /// The identity reported by the device (escaped), or a sentence that no device answered.
    pub identity: String,
    /// The firmware version reported by the device, for instance `1.3.0`.
    pub firmware: Option<String>,
    /// What else identifies the device and its bench, as name and value: MAC address, serial number, GSDML with its hash, abilities.
    pub details: Vec<(String, String)>,
}

/// Whether a result is that of a trial or of a rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CaseKind {
    /// A row of a case.
    Trial,
    /// A rule, judged on all connections.
    Rule,
}

/// The result of a trial or a rule.
#[derive(Clone, Debug)]
pub struct CaseResult {
    /// `<manual>/<suite>/<case>[row]`.
    pub id: String,
    pub kind: CaseKind,
    /// Its sentence in the suite.
    pub why: String,
    pub verdict: Verdict,
    /// The highest level of the failed requirements, else of the covered ones.
    pub level: Level,
    /// The requirements that it covers, including those of its checks.
    pub covers: Vec<Covered>,
    /// Why the verdict is not `pass`, in one sentence.
    pub reason: Option<String>,
    /// The failures; the first one decided the verdict.
    pub failures: Vec<CaseFailure>,
    /// Interpretations of the manual that the device matches: step and reading.
    pub readings: Vec<(String, String)>,
    /// Values of `save`.
    pub saved: Vec<(String, String)>,
    /// Notes that do not change the verdict, for instance unexpected alarms on a live device.
    pub notes: Vec<String>,
    /// For a rule: how often it was decided.
    pub decided: Option<DecisionCounts>,
    /// Duration in virtual or real time.
    pub duration: Duration,
    /// Number of frames while it ran.
    pub frames: u64,
    /// Position in the suite.
    pub at: Location,
    /// The capture that it wrote, if any.
    pub evidence: Option<String>,
    /// The SHA-256 of that capture.
    pub evidence_sha256: Option<String>,
    /// How often a live trial was repeated because the harness or the line was late.
    pub repeats: u32,
    /// The attempt, from 2, in which a failed trial passed (`--retries`). The verdict stays that of the first attempt.
    pub passed_in_attempt: Option<u32>,
    /// For a live trial that is not applicable: the lines of the bench file, or options, that would change it.
    pub bench_lines: Vec<String>,
}

/// How the note begins that something was later than a limit which no manual prints.
pub const SLOW: &str = "slow: ";

impl CaseResult {
    /// A result of which nothing else is known: without reason, notes, frames and evidence.
    pub fn new(
        id: String,
        kind: CaseKind,
        why: String,
        (verdict, level): (Verdict, Level),
        at: Location,
    ) -> CaseResult {
        CaseResult {
            id,
            kind,
            why,
            verdict,
            level,
            covers: Vec::new(),
            reason: None,
            failures: Vec::new(),
            readings: Vec::new(),
            saved: Vec::new(),
            notes: Vec::new(),
            decided: None,
            duration: Duration::ZERO,
            frames: 0,
            at,
            evidence: None,
            evidence_sha256: None,
            repeats: 0,
            passed_in_attempt: None,
            bench_lines: Vec::new(),
        }
    }

    /// The notes on what was later than a limit which no manual prints.
    pub fn slow(&self) -> impl Iterator<Item = &str> {
        self.notes.iter().map(String::as_str).filter(|note| note.starts_with(SLOW))
    }
}

/// The reason of a rule that was never decided.
pub fn never_decided(decided: &DecisionCounts, filtered: bool) -> String {
    let red = if filtered { "" } else { "; in a whole run every rule has to be decided at least once" };
    format!("the premise never occurred in {} frames and events{red}", decided.checked)
}

/// How often a rule was decided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct DecisionCounts {
    /// Decided premises (`when`), or samples with a known condition (`always`).
    pub premises: u64,
    /// Undecided premises.
    pub undecided: u64,
    /// Frames and events checked.
    pub checked: u64,
}

/// The verdict of a trial on one requirement; a check with `covers` is judged separately.
#[derive(Clone, Debug)]
pub struct Covered {
    /// Index in the requirements of the manual.
    pub requirement: usize,
    pub id: String,
    /// The verdict of this trial on it.
    pub verdict: Verdict,
}

/// The combined verdict of all trials and rules on a requirement.
#[derive(Clone, Debug)]
pub struct RequirementResult {
    pub id: String,
    /// Chapter and topic, for instance `7 factory reset`; `None` if the requirements are not divided into chapters.
    pub chapter: Option<String>,
    /// The clause of the manual.
    pub cites: String,
    /// The requirement in one sentence.
    pub statement: String,
    pub level: Level,
    /// The worst verdict of its cases; `not-run` if none ran, with the reason in `note`.
    pub verdict: Verdict,
    /// Why it was not judged, for instance because it is untestable.
    pub note: Option<String>,
    /// The ids of the cases.
    pub cases: Vec<String>,
}

/// The cause of a failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum FailureCause {
    Device,
    /// The harness.
    Harness,
    /// Link, stand or permissions.
    Environment,
    Suite,
    /// Nothing was judged, so no party is to blame.
    Undecided,
}

impl FailureCause {
    /// The word in reports.
    pub fn word(self) -> &'static str {
        match self {
            FailureCause::Device => "device",
            FailureCause::Harness => "harness",
            FailureCause::Environment => "environment",
            FailureCause::Suite => "suite",
            FailureCause::Undecided => "undecided",
        }
    }
}

/// A failure with everything that a report shows: expected and observed values, frame, trace.
#[derive(Clone, Debug)]
pub struct CaseFailure {
    /// The cause.
    pub blame: FailureCause,
    /// What failed, in one sentence.
    pub what: String,
    /// The step or rule as written in the suite.
    pub step: String,
    /// Position of the step or rule.
    pub at: Location,
    /// The requirements that it is judged for: id, clause, sentence.
    pub requirements: Vec<(String, String, String)>,
    /// The parts of the condition with expected and observed values.
    pub parts: Vec<JudgedPart>,
    /// The position on the wire, if a frame shows the failure.
    pub place: Option<FailurePosition>,
    /// The trace around it, one line per frame or event, numbered as in Wireshark.
    pub trace: Vec<String>,
    /// What to do next, in one sentence.
    pub next: String,
    /// Whether it happened before the test, in `start` or `given`, so that the device was not judged.
    pub before_test: bool,
}

/// One part of a condition with its expected and observed value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct JudgedPart {
    /// The part as written in the suite.
    pub text: String,
    /// The expected value, hexadecimal and decimal.
    pub expected: String,
    /// The observed value, hexadecimal, decimal and with named bits, or why there is none.
    pub observed: String,
    /// Whether the part holds.
    pub held: bool,
}

/// A position on the wire.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FailurePosition {
    /// Number of the frame in the capture of the trial, from 1.
    pub frame: u64,
    /// Offset of the byte from the start of the frame.
    pub octet: Option<usize>,
    /// Bit of that byte, 0 is the least significant.
    pub bit: Option<u8>,
    /// A Wireshark display filter for the frame.
    pub filter: String,
}

/// How much of what was selected a run could judge on a live device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TestedShare {
    /// Number of trials with a verdict on the device or the bench.
    pub tested: usize,
    /// Number of trials.
    pub all: usize,
    /// The lines of the bench file, or options, that would make most trials applicable, each with their number; the most first.
    pub lines: Vec<(String, usize)>,
}

impl TestedShare {
    /// Whether most trials were not applicable or did not run.
    pub fn is_little(&self) -> bool {
        self.tested * 2 < self.all
    }
}

impl DeviceRun {
    /// A part of a run with one result: the device as in `--dut`, its kind, manual and variant.
    pub fn of_one(spec: &str, (kind, device, variant): (&str, &str, &str), case: &CaseResult) -> DeviceRun {
        DeviceRun {
            dut: Dut {
                kind: kind.to_owned(),
                spec: spec.to_owned(),
                device: device.to_owned(),
                variant: variant.to_owned(),
                identity: String::new(),
                firmware: None,
                details: Vec::new(),
            },
            cases: vec![case.clone()],
            requirements: Vec::new(),
            filtered: true,
            persona: None,
            bugs: Vec::new(),
            variations: Vec::new(),
            bug_notes: Vec::new(),
            findings: Vec::new(),
            causes: Vec::new(),
            bus: None,
        }
    }

    /// Whether the device runs in this process: then every rule can be decided.
    pub fn is_virtual(&self) -> bool {
        ["model", "null"].contains(&self.dut.kind.as_str())
    }

    /// How much of the selected trials was tested; `None` for a device in this process, and if only rules were judged.
    pub fn tested_share(&self) -> Option<TestedShare> {
        let trials = || self.cases.iter().filter(|case| case.kind == CaseKind::Trial);
        if self.is_virtual() || trials().next().is_none() {
            return None;
        }
        let tested = trials().filter(|case| !matches!(case.verdict, Verdict::NotApplicable | Verdict::NotRun)).count();
        let mut lines: Vec<(String, usize)> = Vec::new();
        for line in trials().flat_map(|case| &case.bench_lines) {
            match lines.iter_mut().find(|(known, _)| known == line) {
                Some((_, number)) => *number += 1,
                None => lines.push((line.clone(), 1)),
            }
        }
        lines.sort_by(|(one, of_one), (other, of_other)| of_other.cmp(of_one).then_with(|| one.cmp(other)));
        Some(TestedShare { tested, all: trials().count(), lines })
    }

    /// Number of results with each verdict.
    pub fn summary(&self) -> Vec<(Verdict, usize)> {
        Verdict::ALL
            .iter()
            .map(|&verdict| (verdict, self.cases.iter().filter(|case| case.verdict == verdict).count()))
            .collect()
    }
}
