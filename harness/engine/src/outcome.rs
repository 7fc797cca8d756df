//! The outcome of a trial, with the results of the rules in it; or why no trial can run.

use judge::slow::SlowReaction;
use judge::violation::RuleViolation;
use results::outcome::{CaseFailure, CaseResult, DecisionCounts, DeviceFinding};
use virtual_wire::Trace;

/// The outcome of one trial.
#[derive(Clone, Debug)]
pub struct TrialOutcome {
    /// The result of the trial.
    pub case: CaseResult,
    /// The result of each rule of the variant, in their order.
    pub rules: Vec<TrialRuleResult>,
    /// Findings about the device: readings of the manual that are faults.
    pub findings: Vec<DeviceFinding>,
    /// The identity that the device reported.
    pub identity: Option<String>,
    /// Why the trial says nothing about a live device: a disturbed line, the end of the run, or a late host.
    pub disturbed: Option<String>,
    /// The permitted variation of a reference device that made the trial fail.
    pub likely_reading: Option<String>,
    /// All frames.
    pub trace: Trace,
}

/// The result of a rule in a trial.
#[derive(Clone, Debug)]
pub struct TrialRuleResult {
    /// How often it was decided.
    pub decided: DecisionCounts,
    /// The first violation, and the failure to report.
    pub broken: Option<(RuleViolation, CaseFailure)>,
    /// What came later than the limit of the rule, which is ours.
    pub slow: Option<SlowReaction>,
    /// Whether the trial was disturbed, so that it says nothing about the device.
    pub disturbed: bool,
}

/// The bench cannot be used; the text says why.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct BenchError(pub String);
