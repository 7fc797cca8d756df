//! The phases of a connection and the events that change them.

/// A phase of a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ArPhase {
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
pub(super) enum StartUpEvent {
    /// PrmEnd was received.
    ParametersEnded,
    /// The application is ready.
    ApplicationReady,
    /// The controller confirmed ApplicationReady.
    ReadyConfirmed,
    /// Outputs were received.
    OutputsCame,
}

impl ArPhase {
    /// The phase after `event`, or `None` if this phase does not allow it.
    pub(super) fn after(self, event: StartUpEvent) -> Option<ArPhase> {
        match (self, event) {
            (ArPhase::Parameters, StartUpEvent::ParametersEnded) => Some(ArPhase::Preparing),
            (ArPhase::Preparing, StartUpEvent::ApplicationReady) => Some(ArPhase::Announcing),
            (ArPhase::Announcing, StartUpEvent::ReadyConfirmed) => Some(ArPhase::Waiting),
            (ArPhase::Waiting, StartUpEvent::OutputsCame) => Some(ArPhase::Data),
            (
                phase @ (ArPhase::Parameters | ArPhase::Preparing | ArPhase::Announcing | ArPhase::Data),
                StartUpEvent::OutputsCame,
            ) => Some(phase),
            (
                ArPhase::Preparing | ArPhase::Announcing | ArPhase::Waiting | ArPhase::Data | ArPhase::Access,
                StartUpEvent::ParametersEnded,
            )
            | (
                ArPhase::Parameters | ArPhase::Announcing | ArPhase::Waiting | ArPhase::Data | ArPhase::Access,
                StartUpEvent::ApplicationReady,
            )
            | (
                ArPhase::Parameters | ArPhase::Preparing | ArPhase::Waiting | ArPhase::Data | ArPhase::Access,
                StartUpEvent::ReadyConfirmed,
            )
            | (ArPhase::Access, StartUpEvent::OutputsCame) => None,
        }
    }

    /// Whether the application has reported that it is ready.
    pub(super) fn is_ready(self) -> bool {
        match self {
            ArPhase::Announcing | ArPhase::Waiting | ArPhase::Data => true,
            ArPhase::Parameters | ArPhase::Preparing | ArPhase::Access => false,
        }
    }

    /// Whether alarms may be sent.
    pub(super) fn has_alarms(self) -> bool {
        match self {
            ArPhase::Waiting | ArPhase::Data => true,
            ArPhase::Parameters | ArPhase::Preparing | ArPhase::Announcing | ArPhase::Access => false,
        }
    }

    /// Whether the initiator must act next, within its activity timeout.
    pub(super) fn waits_for_initiator(self) -> bool {
        match self {
            ArPhase::Parameters | ArPhase::Waiting | ArPhase::Access => true,
            ArPhase::Preparing | ArPhase::Announcing | ArPhase::Data => false,
        }
    }
}
