//! The phases of a connection and the events that change them.

/// A phase of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Phase {
    /// Connected; the controller sends parameters.
    Parameters,
    /// All parameters were sent (PrmEnd); the application is not ready yet.
    Preparing,
    /// ApplicationReady was sent and is not confirmed.
    Announcing,
    /// ApplicationReady is confirmed; no outputs were received.
    Waiting,
    /// Cyclic data in both directions.
    Data,
    /// A connection for records only.
    Access,
}

/// An event of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Event {
    /// PrmEnd was received.
    ParametersEnded,
    /// The application is ready.
    ApplicationReady,
    /// The controller confirmed ApplicationReady.
    ReadyConfirmed,
    /// Outputs were received.
    OutputsCame,
}

impl Phase {
    /// The phase after `event`, or `None` if this phase does not allow it.
    pub(super) fn after(self, event: Event) -> Option<Phase> {
        match (self, event) {
            (Phase::Parameters, Event::ParametersEnded) => Some(Phase::Preparing),
            (Phase::Preparing, Event::ApplicationReady) => Some(Phase::Announcing),
            (Phase::Announcing, Event::ReadyConfirmed) => Some(Phase::Waiting),
            (Phase::Waiting, Event::OutputsCame) => Some(Phase::Data),
            (phase @ (Phase::Parameters | Phase::Preparing | Phase::Announcing | Phase::Data), Event::OutputsCame) => {
                Some(phase)
            }
            (
                Phase::Preparing | Phase::Announcing | Phase::Waiting | Phase::Data | Phase::Access,
                Event::ParametersEnded,
            )
            | (
                Phase::Parameters | Phase::Announcing | Phase::Waiting | Phase::Data | Phase::Access,
                Event::ApplicationReady,
            )
            | (
                Phase::Parameters | Phase::Preparing | Phase::Waiting | Phase::Data | Phase::Access,
                Event::ReadyConfirmed,
            )
            | (Phase::Access, Event::OutputsCame) => None,
        }
    }

    /// Whether the application has reported that it is ready.
    pub(super) fn is_ready(self) -> bool {
        match self {
            Phase::Announcing | Phase::Waiting | Phase::Data => true,
            Phase::Parameters | Phase::Preparing | Phase::Access => false,
        }
    }

    /// Whether alarms may be sent.
    pub(super) fn has_alarms(self) -> bool {
        match self {
            Phase::Waiting | Phase::Data => true,
            Phase::Parameters | Phase::Preparing | Phase::Announcing | Phase::Access => false,
        }
    }

    /// Whether the initiator must act next, within its activity timeout.
    pub(super) fn waits_for_initiator(self) -> bool {
        match self {
            Phase::Parameters | Phase::Waiting | Phase::Access => true,
            Phase::Preparing | Phase::Announcing | Phase::Data => false,
        }
    }
}
