//! What a run found, as plain data. Every report reads this and nothing else; nothing here is computed while reporting.

use crate::verdict::Verdict;
use std::time::Duration;
use suite::Location;
use suite::model::Level;

/// Everything that one call of `encspec run` found, one entry per device under test.
#[derive(Clone, Debug, Default)]
pub struct RunResult {
    /// One device under test each.
    pub runs: Vec<DeviceRun>,
    /// Entries of the ledger of known failures that matched nothing or are over, as sentences.
    pub ledger_notes: Vec<LedgerNote>,
    /// Whether only `must` counts (`--gate must`).
    pub gate_must: bool,
    /// Arguments of the command line that each line to reproduce a failure has to repeat (`--suites DIR`).
    pub repeat: Vec<String>,
}

/// A remark about the ledger of known failures.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LedgerNote {
    /// The sentence.
    pub text: String,
    /// Whether it makes the run fail.
    pub red: bool,
}

/// What was found about one device under test.
#[derive(Clone, Debug)]
pub struct DeviceRun {
    /// Who it is.
    pub dut: Dut,
    /// Trials and rules in the order of the suites: trials first, then rules.
    pub cases: Vec<CaseResult>,
    /// The requirements in the order of the manual.
    pub requirements: Vec<RequirementResult>,
    /// Whether a filter left trials out.
    pub filtered: bool,
    /// In the manner of which persona it was addressed; none: in our controller's own.
    pub persona: Option<String>,
    /// Bugs that were switched on in a reference device.
    pub bugs: Vec<String>,
    /// Variations that a reference device had because its manual permits them.
    pub variations: Vec<String>,
    /// What those of the bugs do that no manual lists, as `name: sentence`.
    pub bug_notes: Vec<String>,
    /// What was found about the device besides its cases: where manual, description and device disagree, wrong claims of
    /// the bench; in the order in which it was found.
    pub findings: Vec<Finding>,
}

/// A disagreement between what the manual, the vendor's description (GSDML or GSD) and the device itself say.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// What it is about, the same on every run: the subject and what of it, for instance `telegram_83.octets`.
    pub id: String,
    /// How it weighs.
    pub severity: Severity,
    /// The disagreement in one sentence.
    pub text: String,
    /// What the manual says, or the bench in its place; none: it says nothing.
    pub manual: Option<String>,
    /// What the vendor's description says, and which kind it is of; none: it says nothing, or there is none.
    pub description: Option<(DescriptionKind, String)>,
    /// What the device says; none: it says nothing, or was not asked.
    pub device: Option<String>,
}

impl Finding {
    /// What a description of this kind says.
    pub fn described_by(&self, kind: DescriptionKind) -> Option<&str> {
        self.description.as_ref().filter(|(known, _)| *known == kind).map(|(_, said)| said.as_str())
    }

    /// Who could say something, each with what it says: the manual, each kind of description, the device.
    pub fn parties(&self) -> impl Iterator<Item = (&'static str, Option<&str>)> {
        let described = DescriptionKind::ALL.map(|kind| (kind.title(), self.described_by(kind)));
        [("manual", self.manual.as_deref())].into_iter().chain(described).chain([("device", self.device.as_deref())])
    }
}

/// A kind of description that a vendor gives with a device.
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

    /// What it is called, its key in bench files and in JSON, and whether JSON also says that it says nothing.
    const fn facts(self) -> (&'static str, &'static str, bool) {
        match self {
            DescriptionKind::Gsdml => ("GSDML", "gsdml", true),
            DescriptionKind::Gsd => ("GSD", "gsd", false),
        }
    }

    /// What it is called.
    pub fn title(self) -> &'static str {
        self.facts().0
    }

    /// Its key in bench files and in JSON.
    pub fn key(self) -> &'static str {
        self.facts().1
    }

    /// Whether JSON says null where it says nothing; else it leaves the key out.
    pub fn is_always_told(self) -> bool {
        self.facts().2
    }
}

/// How a finding weighs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// Only to be known.
    Info,
    /// To be looked at; it does not make a run fail.
    Warning,
    /// It makes a run fail.
    Error,
}

impl Severity {
    /// The word in reports.
    pub fn word(self) -> &'static str {
        match self {
            Severity::Info => "info",
            Severity::Warning => "warning",
            Severity::Error => "error",
        }
    }
}

/// A device under test.
#[derive(Clone, Debug)]
pub struct Dut {
    /// `model`, `null`, `nic`, `socket`, `serial`.
    pub kind: String,
    /// As `--dut` names it, for instance `model:lika-xac77-profinet/xac7718` or `null:silent`.
    pub spec: String,
    /// The manual, for instance `lika-xac77-profinet`.
    pub device: String,
    /// The variant.
    pub variant: String,
    /// What the device said it is (escaped), or a sentence that nobody answered.
    pub identity: String,
    /// The firmware that it says it runs, for instance `1.3.0`, where it said so.
    pub firmware: Option<String>,
}

/// Whether a result comes from a trial or from a rule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CaseKind {
    /// A row of a case.
    Trial,
    /// A rule over all traces.
    Rule,
}

/// What a trial or a rule came to.
#[derive(Clone, Debug)]
pub struct CaseResult {
    /// `<manual>/<suite>/<case>[row]`.
    pub id: String,
    /// Trial or rule.
    pub kind: CaseKind,
    /// Its sentence.
    pub why: String,
    /// The verdict.
    pub verdict: Verdict,
    /// The weight: that of the weightiest requirement that failed, else of the weightiest that is covered.
    pub level: Level,
    /// The requirements that it covers, checks included.
    pub covers: Vec<Covered>,
    /// Why it is not a plain pass; one sentence.
    pub reason: Option<String>,
    /// The failures, the first one is the one that decided.
    pub failures: Vec<Failure>,
    /// Readings of the manual that the device took: step and reading.
    pub readings: Vec<(String, String)>,
    /// Values that `save` kept.
    pub saved: Vec<(String, String)>,
    /// Notes that do not change the verdict (unexpected alarms on a live device and such).
    pub notes: Vec<String>,
    /// For a rule: how often its premise was seen and decided, and how many samples were looked at.
    pub decided: Option<Decided>,
    /// Virtual or real time that it took.
    pub duration: Duration,
    /// Frames seen while it ran.
    pub frames: u64,
    /// Where it stands in the suite.
    pub at: Location,
    /// The capture that it left, where it left one.
    pub evidence: Option<String>,
}

/// How often a rule was decided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Decided {
    /// Decided premises (`when`), or samples at which the condition was known (`always`).
    pub premises: u64,
    /// Premises that stayed undecided.
    pub undecided: u64,
    /// Frames and events looked at.
    pub looked_at: u64,
}

/// A requirement that a trial covers, with its own verdict: a check with `covers` is judged alone.
#[derive(Clone, Debug)]
pub struct Covered {
    /// Index into the requirements of the manual.
    pub requirement: usize,
    /// The id.
    pub id: String,
    /// What this trial says about it.
    pub verdict: Verdict,
}

/// What all trials and rules together say about a requirement.
#[derive(Clone, Debug)]
pub struct RequirementResult {
    /// The id.
    pub id: String,
    /// The chapter and topic, for instance `7 factory reset`; none where the manual's requirements are not parted.
    pub chapter: Option<String>,
    /// The clause.
    pub cites: String,
    /// Our sentence of it.
    pub statement: String,
    /// The weight.
    pub level: Level,
    /// The worst verdict of its cases; `not-run` where none ran, with the reason in `note`.
    pub verdict: Verdict,
    /// Why it was not judged (no case yet, untestable, ...).
    pub note: Option<String>,
    /// The ids of the cases.
    pub cases: Vec<String>,
}

/// Who is to blame for a failure.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Blame {
    /// The device under test.
    Device,
    /// We.
    Harness,
    /// What lies between: link, stand, permissions.
    Environment,
    /// The suite.
    Suite,
}

impl Blame {
    /// The word in reports.
    pub fn word(self) -> &'static str {
        match self {
            Blame::Device => "device",
            Blame::Harness => "harness",
            Blame::Environment => "environment",
            Blame::Suite => "suite",
        }
    }
}

/// A failure as a person needs it: what was asked for, what came, where it stands in which frame.
#[derive(Clone, Debug)]
pub struct Failure {
    /// Who is to blame.
    pub blame: Blame,
    /// What broke, in one sentence.
    pub what: String,
    /// The step or rule as written.
    pub step: String,
    /// Where the step or rule stands.
    pub at: Location,
    /// Requirements it is judged for: id, clause, our sentence.
    pub requirements: Vec<(String, String, String)>,
    /// Each part of the condition: wanted and seen.
    pub parts: Vec<PartSeen>,
    /// Where it shows on the wire.
    pub place: Option<Place>,
    /// The trace around it, a line per frame or event, numbers as in Wireshark.
    pub trace: Vec<String>,
    /// What to do next.
    pub next: String,
}

/// One part of a condition: wanted and seen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PartSeen {
    /// The part as written.
    pub text: String,
    /// What was wanted, hex and decimal.
    pub wanted: String,
    /// What was seen, hex, decimal and named bits; or that nothing was seen.
    pub seen: String,
    /// Whether it held.
    pub held: bool,
}

/// A place on the wire.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// Number of the frame in the trial's capture, from 1.
    pub frame: u64,
    /// Offset of the octet from the first octet of the frame.
    pub octet: Option<usize>,
    /// The bit in that octet, 0 is the least significant.
    pub bit: Option<u8>,
    /// A Wireshark display filter that finds it.
    pub filter: String,
}

impl DeviceRun {
    /// How many results have each verdict.
    pub fn summary(&self) -> Vec<(Verdict, usize)> {
        Verdict::ALL
            .iter()
            .map(|&verdict| (verdict, self.cases.iter().filter(|case| case.verdict == verdict).count()))
            .collect()
    }
}
