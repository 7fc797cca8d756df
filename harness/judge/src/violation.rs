//! What is kept of a rule that was broken.

use super::Tick;
use super::place::Spot;
use expression::NameId;
use results::outcome::PartSeen;

/// A rule that was broken: where, and what was wanted and seen there.
#[derive(Clone, Debug)]
pub struct Violation {
    /// Where it was broken; for a deadline the last tick that was looked at.
    pub tick: Tick,
    /// Where the premise was true, for a rule with one.
    pub trigger: Option<Tick>,
    /// How, in a few words.
    pub how: String,
    /// The parts of the condition.
    pub parts: Vec<PartSeen>,
    /// The names of the parts.
    pub names: Vec<NameId>,
    /// The frame, the octet and the bit that show it; none where it shows in no frame.
    pub place: Option<Spot>,
}

impl Violation {
    /// The number of the frame that shows it: of the one that brought what is wrong, else of the one at which it was noticed.
    pub fn frame(&self) -> u64 {
        self.place.map_or(self.tick.frame, |(frame, ..)| frame)
    }

    /// The first frame that it rests on.
    pub fn rests_on(&self) -> u64 {
        self.trigger.map_or(self.tick.frame, |trigger| trigger.frame.min(self.tick.frame))
    }
}
