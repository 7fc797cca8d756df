//! A connection (AR): its initiator, its phase, its cyclic data and alarms.

use super::alarm::AlarmEndpoint;
use super::cyclic::{InputProvider, OutputConsumer};
use super::phase::{ArPhase, StartUpEvent};
use super::plugged::{ExpectedSubmoduleData, RecordScope};
use super::rpc::OutgoingCall;
use crate::earlier;
use crate::profinet::ArKey;
use alloc::vec::Vec;
use core::net::Ipv4Addr;
use station::{Duration, Time};
use wire::profinet::blocks::connect::ArBlockReq;
use wire::profinet::blocks::module_diff::ModuleDiffBlock;

/// Unit of CMInitiatorActivityTimeoutFactor: 100 ms (IEC 61158-6-10).
const ACTIVITY_TIMEOUT_UNIT: Duration = Duration::from_millis(100);

/// One connection (AR).
#[derive(Debug)]
pub(super) struct DeviceAr {
    /// The number by which the application knows the connection.
    pub key: ArKey,
    /// The ARBlockReq of the initiator.
    pub request: ArBlockReq,
    /// IP address of the initiator.
    pub peer: Ipv4Addr,
    /// UDP port of the initiator for calls from the device.
    pub peer_port: u16,
    /// The phase of the start-up.
    pub phase: ArPhase,
    /// The submodules that the initiator expects.
    pub expected: Vec<ExpectedSubmoduleData>,
    /// The ModuleDiffBlock that was sent to the initiator.
    pub difference: Option<ModuleDiffBlock>,
    /// Whether the plugged submodules now differ from the expected ones.
    pub differs: bool,
    /// Cyclic data and alarms; `None` for a connection for records only.
    pub exchange: Option<ArExchange>,
    /// The ApplicationReady call until it is confirmed.
    pub call: Option<OutgoingCall>,
    /// When the current phase ends or times out.
    pub phase_due: Option<Time>,
}

/// Cyclic data and alarms of a connection.
#[derive(Debug)]
pub(super) struct ArExchange {
    /// The inputs.
    pub provider: InputProvider,
    /// The outputs.
    pub consumer: OutputConsumer,
    /// The alarms.
    pub alarms: AlarmEndpoint,
}

impl DeviceAr {
    /// Processes an event at `now`. Returns `false` if the phase does not allow it.
    pub(super) fn step(&mut self, now: Time, event: StartUpEvent) -> bool {
        let Some(next) = self.phase.after(event) else { return false };
        if next != self.phase {
            self.phase = next;
            self.phase_due = next.waits_for_initiator().then(|| now + self.activity_timeout());
        }
        true
    }

    /// Restarts the CMInitiatorActivityTimeout, because the initiator was active.
    pub(super) fn touch(&mut self, now: Time) {
        if self.phase.waits_for_initiator() {
            self.phase_due = Some(now + self.activity_timeout());
        }
    }

    fn activity_timeout(&self) -> Duration {
        ACTIVITY_TIMEOUT_UNIT * u32::from(self.request.cm_initiator_activity_timeout_factor)
    }

    /// The submodules of the connection.
    pub(super) fn scope(&self) -> RecordScope<'_> {
        RecordScope::Connection(&self.expected)
    }

    /// The next time at which a timer of the connection expires.
    pub(super) fn due(&self) -> Option<Time> {
        let due = earlier(self.phase_due, self.call.as_ref().map(OutgoingCall::due));
        let Some(ArExchange { provider, consumer, alarms }) = &self.exchange else { return due };
        let cyclic = earlier(Some(provider.due()), consumer.expires());
        earlier(due, earlier(cyclic, alarms.due()))
    }
}
