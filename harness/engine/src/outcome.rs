//! The outcome of a trial, with the results of the rules in it; or why no trial can run.

use crate::step_log::StepLog;
use judge::slow::SlowReaction;
use judge::violation::RuleViolation;
use results::outcome::{CaseFailure, CaseResult, DecisionCounts, DeviceFinding};
use results::verdict::Verdict;
use virtual_wire::Trace;
use wire::profibus::statistics::BusStatistics;

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
    /// Why the trial says nothing about a live device.
    pub disturbed: Option<Disturbance>,
    /// The permitted variation of a reference device that made the trial fail.
    pub likely_reading: Option<String>,
    /// What the masters measured on PROFIBUS; `None` on PROFINET, and if the trial did not run.
    pub bus: Option<BusStatistics>,
    /// All frames.
    pub trace: Trace,
    /// What the device did in each step, of a trial that is not judged.
    pub log: Option<Box<StepLog>>,
}

impl TrialOutcome {
    /// What was late, if that alone left the trial or one of its rules without a verdict; what was recorded without a verdict never
    /// counts after a stall.
    pub fn spoilt_by_stall(&self) -> Option<&str> {
        let stall = self.disturbed.as_ref().filter(|of| of.stall.is_some())?;
        let is_rule = || self.case.verdict == Verdict::Pass && self.rules.iter().any(|rule| rule.broken.is_some());
        (self.log.is_some() || self.case.verdict == Verdict::Inconclusive || is_rule()).then_some(stall.why.as_str())
    }
}

/// Why a trial says nothing about a live device: a disturbed line, the end of the run, or a stall.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Disturbance {
    /// What happened, to follow the word "because".
    pub why: String,
    /// What to repeat the trial for; `None` if a repetition would not help.
    pub stall: Option<Stall>,
}

impl Disturbance {
    /// One after which a repetition would not help.
    pub fn lasting(why: impl Into<String>) -> Disturbance {
        Disturbance { why: why.into(), stall: None }
    }

    /// A delay or loss on the way, after which the trial can be repeated.
    pub fn of_link(why: impl Into<String>) -> Disturbance {
        Disturbance { why: why.into(), stall: Some(Stall::Link) }
    }

    /// A delay of the harness, after which the trial can be repeated.
    pub fn of_harness(why: impl Into<String>) -> Disturbance {
        Disturbance { why: why.into(), stall: Some(Stall::Harness) }
    }
}

/// What was late although nothing is broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stall {
    /// The harness or its host, measured by its own clock.
    Harness,
    /// An answer on a link that cannot tell a slow device from a slow line, or a line with noise.
    Link,
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::live::TrialExclusion;
    use crate::live_run::not_run;
    use rstest::rstest;

    /// An outcome with this verdict and disturbance.
    fn outcome(verdict: Verdict, disturbed: Option<Disturbance>) -> TrialOutcome {
        let manuals = suite_yaml::load(&suites::sources(), Some("profinet-io"));
        let manuals = manuals.unwrap_or_else(|errors| panic!("{errors}"));
        let (manual, variant) = (&manuals[0], &manuals[0].variants[0]);
        let mut outcome = not_run(manual, variant, &variant.trials[0], TrialExclusion::NotRun(String::new()));
        (outcome.case.verdict, outcome.disturbed) = (verdict, disturbed);
        outcome
    }

    #[rstest]
    #[case::late(Verdict::Inconclusive, Some(Disturbance::of_harness("late")), Some("late"))]
    #[case::slow_line(Verdict::Inconclusive, Some(Disturbance::of_link("slow")), Some("slow"))]
    #[case::no_cable(Verdict::Inconclusive, Some(Disturbance::lasting("no cable")), None)]
    #[case::undisturbed(Verdict::Inconclusive, None, None)]
    #[case::failed_before_the_stall(Verdict::Fail, Some(Disturbance::of_harness("late")), None)]
    #[case::passed_all_the_same(Verdict::Pass, Some(Disturbance::of_harness("late")), None)]
    fn only_a_stall_is_a_reason_to_repeat(
        #[case] verdict: Verdict,
        #[case] disturbed: Option<Disturbance>,
        #[case] stall: Option<&str>,
    ) {
        assert_eq!(outcome(verdict, disturbed).spoilt_by_stall(), stall);
    }

    #[test]
    fn a_log_of_a_stall_is_recorded_again() {
        let mut outcome = outcome(Verdict::Pass, Some(Disturbance::of_harness("late")));
        outcome.log = Some(Box::default());
        assert_eq!(outcome.spoilt_by_stall(), Some("late"));
    }
}
