//! A connection: who opened it, how far it has come, what it exchanges.

use super::alarm::AlarmEndpoint;
use super::cyclic::{Consumer, Provider};
use super::phase::{Event, Phase};
use super::plugged::{Expected, Scope};
use super::rpc::Call;
use crate::earlier;
use crate::profinet::ArKey;
use alloc::vec::Vec;
use core::net::Ipv4Addr;
use station::{Duration, Time};
use wire::profinet::blocks::connect::ArBlockReq;
use wire::profinet::blocks::module_diff::ModuleDiffBlock;

/// A connection.
#[derive(Debug)]
pub(super) struct Ar {
    /// Its number for the application.
    pub key: ArKey,
    /// What the initiator wanted.
    pub request: ArBlockReq,
    /// Where the initiator is.
    pub peer: Ipv4Addr,
    /// The UDP port at which the initiator is called.
    pub peer_port: u16,
    /// How far it has come.
    pub phase: Phase,
    /// The submodules that the initiator expects.
    pub expected: Vec<Expected>,
    /// How what is plugged differs from them, as told to the initiator.
    pub difference: Option<ModuleDiffBlock>,
    /// Whether what is plugged now differs from them.
    pub differs: bool,
    /// Cyclic data and alarms, unless it is for records alone.
    pub exchange: Option<Exchange>,
    /// ApplicationReady while it is not confirmed.
    pub call: Option<Call>,
    /// When the phase is over at the latest, or at last.
    pub phase_due: Option<Time>,
}

/// Cyclic data and alarms of a connection.
#[derive(Debug)]
pub(super) struct Exchange {
    /// The inputs.
    pub provider: Provider,
    /// The outputs.
    pub consumer: Consumer,
    /// The alarms.
    pub alarms: AlarmEndpoint,
}

impl Ar {
    /// Takes an event at `now`; says whether it fits.
    pub(super) fn step(&mut self, now: Time, event: Event) -> bool {
        let Some(next) = self.phase.after(event) else { return false };
        if next != self.phase {
            self.phase = next;
            self.phase_due = next.waits_for_initiator().then(|| now + self.activity_timeout());
        }
        true
    }

    /// Starts the activity timeout again, because the initiator was active.
    pub(super) fn touch(&mut self, now: Time) {
        if self.phase.waits_for_initiator() {
            self.phase_due = Some(now + self.activity_timeout());
        }
    }

    fn activity_timeout(&self) -> Duration {
        Duration::from_millis(100) * u32::from(self.request.cm_initiator_activity_timeout_factor)
    }

    /// Its submodules.
    pub(super) fn scope(&self) -> Scope<'_> {
        Scope::Connection(&self.expected)
    }

    /// When something is to be done without a frame.
    pub(super) fn due(&self) -> Option<Time> {
        let due = earlier(self.phase_due, self.call.as_ref().map(Call::due));
        let Some(Exchange { provider, consumer, alarms }) = &self.exchange else { return due };
        let cyclic = earlier(Some(provider.due()), consumer.expires());
        earlier(due, earlier(cyclic, alarms.due()))
    }
}
