//! What a device did in a sequence, with the rules that broke.

use engine::step_log::StepLog;

/// The kind of error of a device that does not answer.
pub(crate) const SILENCE: &str = "silence";

/// What a device did in a sequence.
#[derive(Clone, Debug)]
pub struct SequenceLog {
    pub log: StepLog,
    /// Number of frames.
    pub frames: usize,
    /// The rules of the manual that broke.
    pub broken: Vec<BrokenRule>,
    /// Why it says nothing about the device: this host or the line was late, or the bench does not permit it.
    pub spoilt: Option<String>,
}

impl SequenceLog {
    /// Whether the device did not answer at all, not even before the first step.
    pub fn is_silent(&self) -> bool {
        self.log.steps.is_empty() && self.log.protocol_errors.iter().any(|of| of.kind == SILENCE)
    }

    /// The same without what is wrong whatever the device is: protocol errors and broken rules.
    #[must_use]
    pub fn without_errors(&self) -> SequenceLog {
        let mut log = self.log.clone();
        log.protocol_errors.clear();
        SequenceLog { log, frames: self.frames, broken: Vec::new(), spoilt: self.spoilt.clone() }
    }
}

/// A rule that broke in a sequence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BrokenRule {
    pub id: String,
    pub what: String,
    /// The requirements that it covers.
    pub covers: Vec<String>,
}
