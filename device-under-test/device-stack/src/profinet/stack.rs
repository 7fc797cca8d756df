//! The stack while the device has power: its parts, its timers, and the end of connections.

use super::alarm::AlarmOutcome;
use super::ar::DeviceAr;
use super::cm::application_ready;
use super::cyclic::ProviderState;
use super::dcp::DcpState;
use super::diagnosis::PendingDiagnoses;
use super::fast_start_up::FastStartUp;
use super::hooks::{ArEvent, AttachedStackHooks, StackCheck, StackView, StationLoad};
use super::ip::{IpStack, RpcSocket};
use super::lldp::{LldpAgent, LldpMacs, LldpNeighbour};
use super::log_book::LogBookEntry;
use super::maintenance::ImTexts;
use super::phase::{ArPhase, StartUpEvent};
use super::plugged::{PORT_SUBSLOT, PluggedConfiguration, RecordScope};
use super::port_parameters::PortParameters;
use super::rpc::{MapperEntry, RpcServer};
use super::snmp::TrafficCounters;
use crate::earlier;
use crate::profinet::{ArKey, DiagnosisChange, IoApplication, IoIdentity, StackStatus, StationData};
use alloc::vec::Vec;
use station::{Outbox, Time};
use wire::ethernet::Mac;
use wire::octets::ByteOrder;
use wire::profinet::status::AbortReason;

/// The context of each call: current time, application, and output queue.
pub(super) struct StackEnv<'a> {
    /// The current time.
    pub now: Time,
    /// The application.
    pub application: &'a mut dyn IoApplication,
    /// The queue of frames to send.
    pub out: &'a mut Outbox,
}

/// The data that survive a loss of power, except those that the application stores.
#[derive(Clone, Debug)]
pub(super) struct RetainedStackData {
    /// MAC address of the device.
    pub mac: Mac,
    /// MAC address of the specimen, before the hooks.
    specimen_mac: Mac,
    hooks: AttachedStackHooks,
    /// The texts I&M1 to I&M3.
    pub texts: ImTexts,
    /// The last record 0x8090.
    pub fast_start_up: FastStartUp,
    connections: u32,
}

impl RetainedStackData {
    /// Factory state.
    pub(super) fn new(specimen_mac: Mac, hooks: AttachedStackHooks) -> RetainedStackData {
        let mac = hooks.apply(specimen_mac, |hooks, mac| hooks.mac(mac));
        RetainedStackData {
            mac,
            specimen_mac,
            hooks,
            texts: ImTexts::default(),
            fast_start_up: FastStartUp::default(),
            connections: 0,
        }
    }

    /// A new connection number.
    pub(super) fn next_key(&mut self) -> ArKey {
        self.connections = self.connections.wrapping_add(1);
        ArKey(self.connections)
    }
}

/// The stack while the device has power.
pub(super) struct Stack {
    /// The data that survive a loss of power.
    pub retained: RetainedStackData,
    /// The hooks of the deviations.
    pub hooks: AttachedStackHooks,
    /// The name and the addresses in use.
    pub station: StationData,
    /// The name and the addresses after the next start.
    pub stored: StationData,
    /// The state of DCP.
    pub dcp: DcpState,
    pub plugged: PluggedConfiguration,
    /// The identification data.
    pub identity: IoIdentity,
    /// The pending diagnoses.
    pub diagnoses: PendingDiagnoses,
    /// The connections.
    pub ars: Vec<DeviceAr>,
    /// IP, UDP and the web server.
    pub ip: IpStack,
    /// The RPC server.
    pub server: RpcServer,
    /// LLDP.
    pub lldp: LldpAgent,
    /// When the stack started.
    pub started: Time,
    /// The counters of the interface.
    pub traffic: TrafficCounters,
    /// What controllers have written to the ports.
    pub port_parameters: Vec<PortParameters>,
    /// The log book.
    pub log_book: Vec<LogBookEntry>,
}

impl Stack {
    /// The stack as it starts at `now`.
    pub(super) fn new(now: Time, application: &dyn IoApplication, retained: RetainedStackData) -> Stack {
        let stored = application.stored_station();
        let station = load_station(&retained.hooks, StationLoad::PowerUp, &stored);
        let identity = hooked_identity(&retained.hooks, application.identity());
        let mut ip = IpStack::new(now, retained.mac, &retained.hooks);
        ip.configure(&station);
        let mut stack = Stack {
            hooks: retained.hooks.clone(),
            station,
            stored,
            dcp: DcpState::default(),
            plugged: PluggedConfiguration::new(application.plugs(), &identity, &retained.hooks),
            diagnoses: PendingDiagnoses::default(),
            ars: Vec::new(),
            ip,
            server: RpcServer::new(now, MapperEntry::new(&identity), retained.hooks.clone()),
            identity,
            lldp: LldpAgent::new(now),
            started: now,
            traffic: TrafficCounters::default(),
            port_parameters: Vec::new(),
            log_book: Vec::new(),
            retained,
        };
        if !stack.hooks.check(StackCheck::KeepsFastStartUp, true) {
            stack.retained.fast_start_up = FastStartUp::default();
        }
        let settings = stack.hello_settings(true);
        stack.dcp.announce(now, settings);
        stack
    }

    /// The data that survive a loss of power.
    pub(super) fn retained_data(&self) -> RetainedStackData {
        self.retained.clone()
    }

    /// The state that a deviation can read at `now`.
    pub(super) fn view<'a>(&'a self, now: Time, application: &'a dyn IoApplication) -> StackView<'a> {
        let plugged = self.plugged.all();
        StackView { now, application, mac: self.retained.mac, station: &self.station, plugged }
    }

    /// The cable was plugged in: announces the device by LLDP and DCP Hello.
    pub(super) fn announce(&mut self, now: Time) {
        self.lldp.restart(now);
        let settings = self.hello_settings(false);
        self.dcp.announce(now, settings);
    }

    /// Whether the LED flashes for DCP Signal.
    pub(super) fn is_signalling(&self, now: Time) -> bool {
        self.dcp.is_signalling(now)
    }

    /// Completes the status of the device with that of the stack at `now`.
    pub(super) fn complete_status(&self, now: Time, device: StackStatus) -> StackStatus {
        let mut status = StackStatus { is_signalling: self.is_signalling(now), ..device };
        for ar in &self.ars {
            let Some(exchange) = &ar.exchange else { continue };
            status.has_connection = true;
            status.exchanges_data |= ar.phase == ArPhase::Data && exchange.consumer.expires().is_some();
            status.module_differs |= ar.differs;
        }
        status
    }

    /// The alias name of the device, from its neighbour.
    pub(super) fn alias(&self) -> Option<Vec<u8>> {
        self.lldp.neighbour()?.alias()
    }

    /// The station at the other end of the cable.
    pub(super) fn neighbour(&self) -> Option<&LldpNeighbour> {
        self.lldp.neighbour()
    }

    /// Does what is due.
    pub(super) fn wake(&mut self, env: &mut StackEnv<'_>) {
        let now = env.now;
        let is_due = |due: Option<Time>| due.is_some_and(|due| due <= now);
        if is_due(env.application.deadline()) {
            env.application.advance(env.now);
        }
        self.wake_dcp(env);
        if self.lldp.due() <= now {
            let macs = LldpMacs { station: self.retained.mac, port: self.port_mac(PORT_SUBSLOT) };
            self.lldp.wake(env.now, macs, &self.station.name, env.out);
        }
        if is_due(self.ip.due()) {
            self.ip.poll(env.now, env.out);
            self.receive_datagrams(env);
            self.serve_pages(env);
        }
        for at in (0..self.ars.len()).rev() {
            self.wake_connection(env, at);
        }
    }

    fn wake_connection(&mut self, env: &mut StackEnv<'_>, at: usize) {
        let has_problem = self.diagnoses.has_fault(self.ars[at].owned_scope());
        let ar = &mut self.ars[at];
        if let Some(exchange) = &ar.exchange
            && exchange.consumer.expires().is_some_and(|expires| expires <= env.now)
        {
            return self.abort(env, at, AbortReason::CONSUMER_TIMEOUT);
        }
        if ar.phase_due.is_some_and(|due| due <= env.now) {
            match ar.phase {
                ArPhase::Preparing => {
                    ar.step(env.now, StartUpEvent::ApplicationReady);
                    let order = self.hooks.byte_order(ByteOrder::Big);
                    ar.call = Some(application_ready(env.now, self.retained.mac, ar, None, order));
                }
                ArPhase::Access if !self.hooks.check(StackCheck::EndsWhenSilent, true) => ar.phase_due = None,
                ArPhase::Parameters | ArPhase::Waiting | ArPhase::Access => {
                    return self.abort(env, at, AbortReason::CMI_TIMEOUT);
                }
                ArPhase::Announcing | ArPhase::Data => ar.phase_due = None,
            }
        }
        if let Some(exchange) = &mut ar.exchange {
            let state = ProviderState {
                inputs_are_ready: self.hooks.check(StackCheck::InputsReady, ar.phase.is_ready()),
                takes_outputs: self.hooks.check(StackCheck::TakesOutputs, ar.phase.is_ready()),
                has_problem,
            };
            exchange.provider.wake(env, state);
        }
        if let Some(call) = &mut ar.call {
            let to = call.to();
            let (progress, pdus) = call.wake(env.now);
            for pdu in pdus {
                self.ip.send(env.now, RpcSocket::Client, to, pdu, env.out);
            }
            self.process_call_progress(env, at, progress);
        }
    }

    /// Called after each event: fetches diagnosis changes from the application and sends alarms that are due.
    pub(super) fn process_pending(&mut self, env: &mut StackEnv<'_>) {
        while let Some(change) = env.application.next_diagnosis() {
            self.report_diagnosis(change);
        }
        self.check_peers();
        while let Some(change) = env.application.next_plug() {
            self.change_plug(env, change);
        }
        while let Some((slot, subslot)) = env.application.next_event() {
            self.report_event(slot, subslot);
        }
        self.announce_ready_plugs(env);
        for at in (0..self.ars.len()).rev() {
            let Some(exchange) = &mut self.ars[at].exchange else { continue };
            let is_due = exchange.alarms.due().is_some_and(|due| due <= env.now);
            if is_due && let AlarmOutcome::End(reason) = exchange.alarms.wake(env.now, env.out) {
                self.abort(env, at, reason);
            }
        }
        let aborts = self.hooks.apply(false, |hooks, aborts| hooks.aborts(aborts));
        if aborts {
            self.abort_all(env, AbortReason::ABORT_REQUEST);
        }
    }

    /// Notes a diagnosis that appears or disappears, and queues an alarm for the connection that owns its submodule.
    pub(super) fn report_diagnosis(&mut self, mut change: DiagnosisChange) {
        if !self.hooks.apply(true, |hooks, is_noted| hooks.diagnosis(&mut change, is_noted)) {
            return;
        }
        self.diagnoses.note(&change);
        for ar in self.ars.iter_mut().filter(|ar| ar.phase.has_alarms()) {
            let seen = self.hooks.check(StackCheck::DiagnosisOfOthers, false);
            let scope = RecordScope::Connection(if seen { &ar.expected } else { &ar.owned });
            let alarm = self.diagnoses.alarm(&change, scope, &self.plugged);
            if let (Some(alarm), Some(exchange)) = (alarm, &mut ar.exchange) {
                exchange.alarms.push(alarm);
            }
        }
    }

    /// Ends a connection. With a `reason` and an alarm endpoint it sends ERR-RTA.
    pub(super) fn end(&mut self, env: &mut StackEnv<'_>, at: usize, event: ArEvent, reason: Option<AbortReason>) {
        self.hooks.notify(|hooks| hooks.connection(event));
        let mut ar = self.ars.remove(at);
        if let Some(exchange) = &mut ar.exchange {
            if let Some(reason) = reason {
                exchange.alarms.abort(reason, env.out);
            }
            exchange.consumer.stop(env.now, env.application);
        }
        env.application.ended(env.now, ar.key);
        self.hand_over(env, &ar.owned);
    }

    /// Aborts a connection with `reason`.
    pub(super) fn abort(&mut self, env: &mut StackEnv<'_>, at: usize, reason: AbortReason) {
        self.note_abort(env.now, self.ars[at].request.ar_uuid, reason);
        self.end(env, at, ArEvent::Ended, Some(reason));
    }

    /// Aborts all connections with `reason`.
    pub(super) fn abort_all(&mut self, env: &mut StackEnv<'_>, reason: AbortReason) {
        while !self.ars.is_empty() {
            self.abort(env, self.ars.len() - 1, reason);
        }
    }

    /// Starts to use `station`. A new name is announced by LLDP at once.
    pub(super) fn use_station(&mut self, now: Time, station: StationData) {
        self.ip.configure(&station);
        if station.name != self.station.name {
            self.lldp.announce(now);
        }
        self.station = station;
    }

    /// Starts to use the stored name and addresses after a reset.
    pub(super) fn restart_station(&mut self, env: &mut StackEnv<'_>) {
        let mac = self.hooks.apply(self.retained.specimen_mac, |hooks, mac| hooks.mac(mac));
        if mac != self.retained.mac {
            self.retained.mac = mac;
            self.ip = IpStack::new(env.now, mac, &self.hooks);
        }
        self.stored = env.application.stored_station();
        let station = load_station(&self.hooks, StationLoad::Reset, &self.stored);
        self.use_station(env.now, station);
    }

    /// Whether a data hold timer runs for the outputs of a connection.
    pub(super) fn is_monitoring_outputs(&self) -> bool {
        let mut exchanges = self.ars.iter().filter_map(|ar| ar.exchange.as_ref());
        exchanges.any(|exchange| exchange.consumer.expires().is_some())
    }

    /// When the next timer of the stack expires, those of the application excluded.
    pub(super) fn deadline(&self) -> Option<Time> {
        let connections = self.ars.iter().fold(None, |due, ar| earlier(due, ar.due()));
        let announcements = earlier(self.dcp.due(), Some(self.lldp.due()));
        earlier(connections, earlier(self.ip.due(), announcements))
    }
}

/// The stored name and addresses, after the hooks.
fn load_station(hooks: &AttachedStackHooks, start: StationLoad, stored: &StationData) -> StationData {
    hooks.apply(stored.clone(), |hooks, mut station| {
        hooks.load_station(start, &mut station);
        station
    })
}

/// The identification data of the device, after the hooks.
pub(super) fn hooked_identity(hooks: &AttachedStackHooks, identity: &IoIdentity) -> IoIdentity {
    hooks.apply(identity.clone(), |hooks, mut identity| {
        hooks.identity(&mut identity);
        identity
    })
}
