//! When and how the values of names change: one row for each kind of name.
//!
//! Conditions, expectations and rules use this table, so a new kind of name is described only here.

use super::{EventName, NameKind};

/// When the value of a name is updated, where it is visible, and what an expectation waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Observability {
    /// The frames or events that update it.
    pub updated: UpdatedAt,
    /// Where it is visible on the wire.
    pub visible: VisibleIn,
    /// Whether frames of a connection carry it, so that an expectation can wait for a sample.
    pub comes_by_itself: bool,
    /// Whether its value is not part of samples: values read on request, and LEDs.
    pub is_beyond_samples: bool,
    /// Whether it is constant: neither frames nor events nor time change it.
    pub is_settled: bool,
    /// Whether it can change without a change of the cyclic data.
    pub changes_unseen: bool,
}

/// What updates the value of a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UpdatedAt {
    /// Frames in the direction of this signal.
    Signal(usize),
    /// Frames to the device.
    Output,
    /// Frames from the device.
    Input,
    /// Events.
    Event,
    /// Diagnoses.
    Diagnosis,
    /// Anything.
    Always,
}

/// Where the value of a name is visible on the wire.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VisibleIn {
    /// In the cyclic data.
    Cyclic,
    /// In a request that writes or reads it.
    Written,
    /// In no frame.
    Elsewhere,
    /// In an event, at its instant only.
    Event,
}

impl NameKind {
    /// When and how the value changes. A new kind of name gets its row here.
    pub fn observability(&self) -> Observability {
        use NameKind as N;
        let observed = |updated: UpdatedAt, visible: VisibleIn| Observability {
            updated,
            visible,
            comes_by_itself: false,
            is_beyond_samples: false,
            is_settled: false,
            changes_unseen: false,
        };
        let sample = |updated: UpdatedAt, visible: VisibleIn| Observability {
            comes_by_itself: true,
            ..observed(updated, visible)
        };
        let beyond =
            |visible: VisibleIn| Observability { is_beyond_samples: true, ..observed(UpdatedAt::Always, visible) };
        let settled = |visible: VisibleIn| Observability { is_settled: true, ..observed(UpdatedAt::Always, visible) };
        let hidden = |updated: UpdatedAt| Observability { changes_unseen: true, ..observed(updated, VisibleIn::Event) };
        match self {
            N::Signal { signal, .. } => sample(UpdatedAt::Signal(*signal), VisibleIn::Cyclic),
            N::OutputOctets(_) | N::OutputStatus(_) => sample(UpdatedAt::Output, VisibleIn::Event),
            N::InputOctets(_) | N::InputLength | N::InputStatus(_) | N::ConsumerStatus(_) => {
                sample(UpdatedAt::Input, VisibleIn::Event)
            }
            N::InputDataStatus | N::InputCounter => {
                Observability { changes_unseen: true, ..sample(UpdatedAt::Input, VisibleIn::Event) }
            }
            N::Elapsed => sample(UpdatedAt::Always, VisibleIn::Event),
            N::DiagnosisPending => hidden(UpdatedAt::Input),
            N::Diagnosis(_) => hidden(UpdatedAt::Diagnosis),
            N::Event(event) if event.is_lldp() || event.is_hello() => {
                Observability { is_beyond_samples: true, ..observed(UpdatedAt::Event, VisibleIn::Event) }
            }
            N::Event(EventName::Abort | EventName::AbortCode) => observed(UpdatedAt::Event, VisibleIn::Event),
            N::Event(_) => sample(UpdatedAt::Event, VisibleIn::Event),
            N::Parameter { .. } | N::Record { .. } => Observability { is_settled: true, ..beyond(VisibleIn::Written) },
            N::StartParameter { .. } => settled(VisibleIn::Written),
            N::Derived(_) => observed(UpdatedAt::Always, VisibleIn::Written),
            N::Led(_) | N::Station(_) | N::Page { .. } => beyond(VisibleIn::Elsewhere),
            N::Answer(_) => beyond(VisibleIn::Event),
            N::Saved(_) | N::Bench(_) => settled(VisibleIn::Elsewhere),
            N::Constant(_) => settled(VisibleIn::Event),
            N::Stand(_) | N::Counter(_) => observed(UpdatedAt::Always, VisibleIn::Elsewhere),
            N::Cyclic
            | N::OutputDataStatus
            | N::AlarmAcknowledge
            | N::GlobalControl
            | N::ClockOffset
            | N::Configuration
            | N::Connection
            | N::Cycle => observed(UpdatedAt::Always, VisibleIn::Event),
        }
    }
}
