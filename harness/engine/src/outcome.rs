//! What a trial of a run comes to, with what the rules saw in it; or why none can be run.

use judge::violation::Violation;
use results::outcome::{CaseResult, Decided, Failure, Finding};
use virtual_wire::Trace;

/// What one trial came to.
#[derive(Clone, Debug)]
pub struct TrialOutcome {
    /// The trial itself.
    pub case: CaseResult,
    /// What each rule of the variant saw in it, in their order.
    pub rules: Vec<RuleSeen>,
    /// What was found about the device: readings of the manual that are faults.
    pub findings: Vec<Finding>,
    /// What the device said it is.
    pub identity: Option<String>,
    /// Why what was seen says nothing about a live device: the line, the end of the run, or we ourselves were late.
    pub disturbed: Option<String>,
    /// Every frame.
    pub trace: Trace,
}

/// What a rule saw in a trial.
#[derive(Clone, Debug)]
pub struct RuleSeen {
    /// How often it was decided.
    pub decided: Decided,
    /// The first time it was broken, and what a person is told about it.
    pub broken: Option<(Violation, Failure)>,
    /// Whether the trial was disturbed, so that what was seen in it says nothing about the device.
    pub disturbed: bool,
}

/// The bench cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct BenchError(pub String);
