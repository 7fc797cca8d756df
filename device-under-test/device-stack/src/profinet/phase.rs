//! How far a connection has come: a table of phases and events.

/// How far a connection has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Phase {
    /// Connected; the controller sends parameters.
    Parameters,
    /// The parameters are complete; the application makes itself ready.
    Preparing,
    /// The controller was told of the readiness and has not confirmed it.
    Announcing,
    /// All is agreed; no outputs have come.
    Waiting,
    /// Cyclic data in both directions.
    Data,
    /// A connection for records alone.
    Access,
}

/// What happens to a connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Event {
    /// PrmEnd came.
    ParametersEnded,
    /// The application is ready.
    ApplicationReady,
    /// The controller confirmed ApplicationReady.
    ReadyConfirmed,
    /// Outputs came.
    OutputsCame,
}

impl Phase {
    /// The phase after `event`, or `None` where it does not fit.
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

    /// Whether the application has told that it is ready.
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

    /// Whether the next step is the initiator's, within its activity timeout.
    pub(super) fn waits_for_initiator(self) -> bool {
        match self {
            Phase::Parameters | Phase::Waiting | Phase::Access => true,
            Phase::Preparing | Phase::Announcing | Phase::Data => false,
        }
    }
}
