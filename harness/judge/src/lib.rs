//! The judge: conditions and rules over a stream of frames and events, three-valued.
//!
//! It is the same for a virtual trial, a live device and a capture. It knows names and their values ([`image`]), windows of
//! time ([`window`]) and rules ([`rule`], [`rule_set`]), which are looked at anew only where something changed that they asked
//! for ([`steady`], [`settled`]) and, in a recording, not believed on one frame alone ([`witness`]). It must not know who sends
//! the frames, and it sends none.

pub mod answer;
pub mod answer_parts;
pub mod condition;
pub mod diagnosis;
pub mod follow;
pub mod format;
pub mod image;
pub mod observe;
pub mod page;
pub mod place;
pub mod rule;
pub mod rule_set;
pub mod scene;
pub mod settled;
pub mod steady;
pub mod view;
pub mod violation;
pub mod window;
pub mod witness;

use station::Time;

/// What kind of thing was seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TickKind {
    /// An output image was seen.
    Output,
    /// An input image was seen, and the device vouches for it.
    Sample,
    /// An input image was seen, and the device marks it as bad.
    BadSample,
    /// An alarm, an abort, an answer, a change of an LED, an announcement.
    Event,
}

impl TickKind {
    /// Whether `expect`, `always` and `then` are judged here: at samples and events.
    pub fn is_judged(self) -> bool {
        match self {
            TickKind::Sample | TickKind::BadSample | TickKind::Event => true,
            TickKind::Output => false,
        }
    }
}

/// One thing seen on a connection; the image has been brought up to date with it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tick {
    /// When.
    pub time: Time,
    /// The number of the frame in the trace, from 1; 0 where no frame stands for it.
    pub frame: u64,
    /// What.
    pub kind: TickKind,
}

/// Three-valued truth.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Truth {
    /// It holds.
    True,
    /// It does not hold.
    False,
    /// It cannot be known.
    Unknown,
}

impl Truth {
    /// Both have to hold.
    pub fn and(self, other: Truth) -> Truth {
        match (self, other) {
            (Truth::False, _) | (_, Truth::False) => Truth::False,
            (Truth::True, Truth::True) => Truth::True,
            _ => Truth::Unknown,
        }
    }
}

/// The contrary; unknown stays unknown.
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
