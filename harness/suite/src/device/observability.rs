//! How the values of names come about: a row for each kind of name.
//!
//! Conditions, expectations and rules ask this table when a value can change and what they have to wait for, so that a new kind of
//! name is described in one place.

use super::{EventName, NameKind};

/// How the value of a name comes about: when it is news, what shows it, and what an expectation waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Observability {
    /// At which frames or events it is news.
    pub updated: UpdatedAt,
    /// What shows it on a wire.
    pub visible: VisibleIn,
    /// Whether it comes with the frames of a connection, so that there is a sample to wait for.
    pub comes_by_itself: bool,
    /// Whether its value at the last sample is not kept: asked names and LEDs.
    pub is_beyond_samples: bool,
    /// Whether neither a frame nor an event nor time changes it.
    pub is_settled: bool,
    /// Whether it changes although no octet of the cyclic data does.
    pub changes_unseen: bool,
}

/// When the value of a name is news.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UpdatedAt {
    /// At frames in the direction of this signal.
    Signal(usize),
    /// At frames to the device.
    Output,
    /// At frames of the device.
    Input,
    /// At an event.
    Event,
    /// At a diagnosis.
    Diagnosis,
    /// At any time.
    Always,
}

/// What shows the value of a name on a wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VisibleIn {
    /// The cyclic data.
    Cyclic,
    /// A request that writes or reads it.
    Written,
    /// No frame.
    Elsewhere,
    /// An event, at its instant only.
    Event,
}

impl NameKind {
    /// How its value comes about. A new kind gets its row here.
    pub fn observability(&self) -> Observability {
        use NameKind as N;
        let seen = |updated: UpdatedAt, visible: VisibleIn| Observability {
            updated,
            visible,
            comes_by_itself: false,
            is_beyond_samples: false,
            is_settled: false,
            changes_unseen: false,
        };
        let sample =
            |updated: UpdatedAt, visible: VisibleIn| Observability { comes_by_itself: true, ..seen(updated, visible) };
        let beyond = |visible: VisibleIn| Observability { is_beyond_samples: true, ..seen(UpdatedAt::Always, visible) };
        let settled = |visible: VisibleIn| Observability { is_settled: true, ..seen(UpdatedAt::Always, visible) };
        let hidden = |updated: UpdatedAt| Observability { changes_unseen: true, ..seen(updated, VisibleIn::Event) };
        match self {
            N::Signal { signal, .. } => sample(UpdatedAt::Signal(*signal), VisibleIn::Cyclic),
            N::OutputOctets(_) | N::OutputStatus(_) => sample(UpdatedAt::Output, VisibleIn::Event),
            N::InputOctets(_) | N::InputLength | N::InputStatus(_) | N::ConsumerStatus(_) => {
                sample(UpdatedAt::Input, VisibleIn::Event)
            }
            N::Elapsed => sample(UpdatedAt::Always, VisibleIn::Event),
            N::DiagnosisPending => hidden(UpdatedAt::Input),
            N::Diagnosis(_) => hidden(UpdatedAt::Diagnosis),
            N::Event(event) if event.is_lldp() => {
                Observability { is_beyond_samples: true, ..seen(UpdatedAt::Event, VisibleIn::Event) }
            }
            N::Event(EventName::Abort | EventName::AbortCode) => seen(UpdatedAt::Event, VisibleIn::Event),
            N::Event(_) => sample(UpdatedAt::Event, VisibleIn::Event),
            N::Parameter { .. } | N::Record { .. } => Observability { is_settled: true, ..beyond(VisibleIn::Written) },
            N::StartParameter { .. } => settled(VisibleIn::Written),
            N::Derived(_) => seen(UpdatedAt::Always, VisibleIn::Written),
            N::Led(_) | N::Station(_) | N::Page { .. } => beyond(VisibleIn::Elsewhere),
            N::Answer(_) => beyond(VisibleIn::Event),
            N::Saved(_) | N::Bench(_) => settled(VisibleIn::Elsewhere),
            N::Constant(_) => settled(VisibleIn::Event),
            N::Stand(_) | N::Counter(_) => seen(UpdatedAt::Always, VisibleIn::Elsewhere),
            N::Cyclic
            | N::AlarmAcknowledge
            | N::GlobalControl
            | N::ClockOffset
            | N::Configuration
            | N::Connection
            | N::Cycle => seen(UpdatedAt::Always, VisibleIn::Event),
        }
    }
}
