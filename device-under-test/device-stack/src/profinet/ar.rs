//! A connection (AR): its initiator, its phase, its cyclic data and alarms.

use super::alarm::AlarmEndpoint;
use super::connection_record::AgreedExchange;
use super::cyclic::{InputProvider, OutputConsumer};
use super::ownership::PluggedAfterwards;
use super::phase::{ArPhase, StartUpEvent};
use super::plugged::{ExpectedSubmoduleData, RecordScope, SubmoduleAddress};
use super::rpc::OutgoingCall;
use crate::earlier;
use crate::profinet::{ArKey, IoApplication};
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
    /// Those of them that the connection owns: no other connection had them first.
    pub owned: Vec<ExpectedSubmoduleData>,
    /// Plugged or released submodules whose parameters are not complete.
    pub plugs: Vec<PluggedAfterwards>,
    /// AlarmSequenceNumbers of submodules that are ready and not announced yet.
    pub ready_plugs: Vec<u16>,
    /// Number of calls to the initiator so far.
    pub calls: u32,
    /// The ModuleDiffBlock that was sent to the initiator.
    pub difference: Option<ModuleDiffBlock>,
    /// Whether the plugged submodules now differ from the expected ones.
    pub differs: bool,
    /// What the Connect agreed on about cyclic data and alarms; `None` for a connection for records only.
    pub agreed: Option<AgreedExchange>,
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

    /// The submodules that the connection owns.
    pub(super) fn owned_scope(&self) -> RecordScope<'_> {
        RecordScope::Connection(&self.owned)
    }

    /// Whether the connection owns the submodule at `place`.
    pub(super) fn owns(&self, place: SubmoduleAddress) -> bool {
        self.owned.iter().any(|submodule| submodule.place == place)
    }

    /// Says whether the submodule at `place` can have good data. Outputs that end are reported to `application`.
    pub(super) fn set_usable(
        &mut self,
        now: Time,
        place: SubmoduleAddress,
        is_usable: bool,
        application: &mut dyn IoApplication,
    ) {
        if let Some(exchange) = &mut self.exchange {
            exchange.provider.set_usable((place.slot, place.subslot), is_usable);
            exchange.consumer.set_usable(now, (place.slot, place.subslot), is_usable, application);
        }
    }

    /// The next time at which a timer of the connection expires.
    pub(super) fn due(&self) -> Option<Time> {
        let due = earlier(self.phase_due, self.call.as_ref().map(OutgoingCall::due));
        let Some(ArExchange { provider, consumer, alarms }) = &self.exchange else { return due };
        let cyclic = earlier(Some(provider.due()), consumer.expires());
        earlier(due, earlier(cyclic, alarms.due()))
    }
}
