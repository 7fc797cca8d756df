//! The reason why a step failed, and the party to blame.

use judge::wire_position::WirePosition;
use results::outcome::{FailureCause, JudgedPart};
use results::verdict::Verdict;
use suite::Location;

/// The reason why a step failed; boxed, since nearly all steps pass.
pub type BoxedStepError = Box<StepError>;

/// The facts about a failed step.
#[derive(Clone, Debug)]
pub struct StepError {
    /// The party to blame.
    pub blame: FailureCause,
    /// What failed, in one sentence.
    pub what: String,
    /// Expected and observed values.
    pub parts: Vec<JudgedPart>,
    /// The decisive frame.
    pub frame: Option<u64>,
    /// The byte and bit in that frame, if it shows them.
    pub place: Option<WirePosition>,
    /// The verdict if the device did not fail: the stand cannot do it, or nothing can be said.
    pub verdict: Option<Verdict>,
    /// The text and position of the failed rule, if it is inside the step.
    pub step: Option<(String, Location)>,
}

impl StepError {
    /// Whether something wrong was observed: neither a lost connection nor a name without a value is.
    pub fn has_observed(&self) -> bool {
        self.parts.iter().any(|part| !part.held && !part.observed.starts_with("unknown"))
    }

    /// The device did something other than expected.
    pub fn device(what: impl Into<String>, parts: Vec<JudgedPart>) -> BoxedStepError {
        let what = what.into();
        Box::new(StepError {
            blame: FailureCause::Device,
            what,
            parts,
            frame: None,
            place: None,
            verdict: None,
            step: None,
        })
    }

    /// Something other than the device failed, with this verdict.
    pub fn other(blame: FailureCause, verdict: Verdict, what: impl Into<String>) -> BoxedStepError {
        let mut trouble = StepError::device(what, Vec::new());
        (trouble.blame, trouble.verdict) = (blame, Some(verdict));
        trouble
    }

    /// Sets the decisive frame.
    pub fn at(mut self: Box<Self>, frame: u64) -> BoxedStepError {
        self.frame = Some(frame);
        self
    }

    /// Whether the device did something other than expected.
    pub fn is_of_device(&self) -> bool {
        self.blame == FailureCause::Device && self.verdict.is_none()
    }

    /// Makes it inconclusive: the device only had to be brought into the initial state of the test.
    pub fn before_the_test(mut self: Box<Self>) -> BoxedStepError {
        self.verdict = Some(self.verdict.unwrap_or(Verdict::Inconclusive));
        self
    }
}

/// The result of a step.
pub type StepResult = Result<(), BoxedStepError>;

/// The trouble with a step during which the run or the line ended.
pub fn ended(why: &str) -> BoxedStepError {
    StepError::other(FailureCause::Environment, Verdict::Inconclusive, format!("The trial could not continue: {why}."))
}

/// The trouble with a step that needs a connection when there is none.
pub fn no_connection() -> BoxedStepError {
    StepError::device("There is no connection, so there is no data exchange and no request.", Vec::new())
}

/// The trouble with a step of the other bus; the loader rejects such suites.
pub fn other_bus() -> BoxedStepError {
    StepError::other(FailureCause::Suite, Verdict::Error, "This service belongs to the other bus.")
}
