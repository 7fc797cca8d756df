//! The judge: evaluates conditions and rules over a stream of frames and events, with three-valued results.
//!
//! It works on virtual trials, live devices and captures. [`image`] holds the values of a connection, [`window`] the time windows,
//! [`rule`] and [`rule_set`] the rules. Rules are evaluated again only if a value that they used has changed ([`tracked_inputs`],
//! [`parameter_cache`]); in a recording one frame alone does not prove a violation ([`evidence`]). The judge sends no frames.

#![allow(missing_docs, reason = "internal crate: self-explanatory items need no comment")]

pub mod answer;
pub mod answer_parts;
pub mod condition;
pub mod diagnosis;
pub mod evidence;
pub mod follow;
pub mod format;
pub mod image;
pub mod observe;
pub mod observed_state;
pub mod page;
pub mod parameter_cache;
pub mod rule;
pub mod rule_set;
pub mod slow;
pub mod tracked_inputs;
pub mod view;
pub mod violation;
pub mod window;
pub mod wire_position;

use station::Time;

/// The kind of an observation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TickKind {
    /// An output image.
    Output,
    /// An input image that the device marks as good.
    Sample,
    /// An input image that the device marks as bad.
    BadSample,
    /// An alarm, an abort, an answer, a change of an LED, an LLDP announcement.
    Event,
}

impl TickKind {
    /// Whether `expect`, `always` and `then` are judged: at samples and events.
    pub fn is_judged(self) -> bool {
        match self {
            TickKind::Sample | TickKind::BadSample | TickKind::Event => true,
            TickKind::Output => false,
        }
    }
}

/// One observation on a connection; the image is already updated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct JudgeTick {
    pub time: Time,
    /// Number of the frame in the trace, from 1; 0 without a frame.
    pub frame: u64,
    pub kind: TickKind,
}

/// Three-valued truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Truth {
    /// The condition holds.
    True,
    /// The condition does not hold.
    False,
    /// A value is unknown.
    Unknown,
}

impl Truth {
    /// Three-valued `and`.
    pub fn and(self, other: Truth) -> Truth {
        match (self, other) {
            (Truth::False, _) | (_, Truth::False) => Truth::False,
            (Truth::True, Truth::True) => Truth::True,
            _ => Truth::Unknown,
        }
    }
}

/// Three-valued `not`; unknown stays unknown.
impl std::ops::Not for Truth {
    type Output = Truth;

    fn not(self) -> Truth {
        match self {
            Truth::True => Truth::False,
            Truth::False => Truth::True,
            Truth::Unknown => Truth::Unknown,
        }
    }
}

impl From<bool> for Truth {
    fn from(value: bool) -> Truth {
        if value { Truth::True } else { Truth::False }
    }
}
