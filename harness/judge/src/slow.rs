//! What came later than a limit of ours, but not too late: a note, never a failure, because no manual prints the limit.

use super::JudgeTick;
use plain_text::span;
use results::outcome::SLOW;
use station::Duration;
use suite::model::{Deadline, OurLimit, RuleBody, SuiteRule};

/// Something that was late, once or several times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SlowReaction {
    /// The longest time that it took.
    pub took: Duration,
    /// The limit.
    pub limit: Duration,
    /// The tick from which the slowest one was measured.
    pub trigger: JudgeTick,
    /// How often it was late.
    pub times: u64,
}

impl SlowReaction {
    /// Both together: the longest time, and how often.
    #[must_use]
    pub fn and(self, other: SlowReaction) -> SlowReaction {
        let slowest = if other.took > self.took { other } else { self };
        SlowReaction { times: self.times + other.times, ..slowest }
    }

    /// Both together where either may be missing.
    pub fn of_both(one: Option<SlowReaction>, other: Option<SlowReaction>) -> Option<SlowReaction> {
        match (one, other) {
            (Some(one), Some(other)) => Some(one.and(other)),
            (one, other) => one.or(other),
        }
    }

    /// The note that what a rule requires was late; `trial` names where, besides the frame.
    pub fn note_of_rule(self, rule: &SuiteRule, trial: Option<&str>) -> Option<String> {
        let RuleBody::When { within, .. } = &rule.body else { return None };
        let trial = trial.map_or_else(String::new, |trial| format!("trial {trial}, "));
        Some(self.note(within, &format!("{} ({trial}from frame {})", rule.why, self.trigger.frame)))
    }

    /// The note of a report; `what` was late.
    pub fn note(&self, within: &Deadline, what: &str) -> String {
        let names = within.ours.as_ref().map(|ours| ours.names.join(" and ")).unwrap_or_default();
        let (took, limit) = (span(self.took), span(self.limit));
        let times =
            if self.times > 1 { format!("; {} times, this was the slowest", self.times) } else { String::new() };
        format!("{SLOW}{took}, our limit is {limit} ({names}), the manual gives none: {what}{times}")
    }
}

/// What a failure says of a limit of ours: up to when it was waited, and what the limit was.
pub fn waited(limit: Duration, patient: Duration, ours: &OurLimit) -> String {
    format!("{}, although our limit is only {} ({})", span(patient), span(limit), ours.names.join(" and "))
}
