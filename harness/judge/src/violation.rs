//! A violation of a rule.

use super::JudgeTick;
use super::wire_position::WirePosition;
use expression::NameId;
use results::outcome::JudgedPart;

/// A violation of a rule: position, expected and observed values.
#[derive(Clone, Debug)]
pub struct RuleViolation {
    /// The tick of the violation; for a missed deadline the last tick before it.
    pub tick: JudgeTick,
    /// The tick at which the premise was true, for a rule with a premise.
    pub trigger: Option<JudgeTick>,
    /// How the condition failed, in a few words: `the condition does not hold`.
    pub how: String,
    /// The parts of the condition.
    pub parts: Vec<JudgedPart>,
    /// The names in the condition.
    pub names: Vec<NameId>,
    /// Frame, byte and bit that show the violation; `None` if no frame shows it.
    pub place: Option<WirePosition>,
}

impl RuleViolation {
    /// Number of the frame with the wrong value, else of the frame at which the violation was detected.
    pub fn frame(&self) -> u64 {
        self.place.map_or(self.tick.frame, |(frame, ..)| frame)
    }

    /// Number of the first frame that the violation is based on.
    pub fn rests_on(&self) -> u64 {
        self.trigger.map_or(self.tick.frame, |trigger| trigger.frame.min(self.tick.frame))
    }
}
