//! The controller: it assigns requests, frames and deadlines to its jobs, the AR and the server.

use super::alarms::AlarmAcknowledge;
use super::broken;
use super::connection::ArConfig;
use super::context::{ControllerContext, JobEvent};
use super::exchange::InputSample;
use super::http::Browser;
use super::jobs::{self, ControllerJob, IoParameterJob, Lookup};
use super::outcome::{ArEnd, ArReleaseOutcome, CallError, ControllerOutcome, IoParameterOutcome, IoRecordOutcome};
use super::plug::needs_parameters;
use super::request::{ControllerBusy, ControllerRequest, ControllerSettings, DcpResetForm, IdentifyBy, Partner};
use super::startup::{ArStartUpJob, send_write};
use super::state::ArState;
use super::{call, load, ping, presence, raw, record, snmp};
use crate::outputs::CyclicOutputs;
use alloc::boxed::Box;
use alloc::vec::Vec;
use core::cell::Cell;
use core::net::Ipv4Addr;
use core::time::Duration;
use station::{Outbox, Station, Time};
use wire::datagram::arp::{Arp, ArpOperation};
use wire::datagram::{Datagram, Ipv4};
use wire::ethernet::{EtherType, FrameHeader, Mac};
use wire::profinet::alarm::AlarmPriority;
use wire::profinet::dcp::{BlockQualifier, Dcp, DcpBlock, DcpValue, ServiceType};
use wire::profinet::rpc::PORT;
use wire::profinet::rt::{FrameId, FrameKind};
use wire::profinet::status::AbortReason;

/// A PROFINET IO controller.
///
/// It accepts one [`ControllerRequest`] at a time. After [`Controller::request`] it is due at once, so its next frames leave when it is
/// woken. An established AR needs no further requests.
#[derive(Debug)]
pub struct Controller {
    context: ControllerContext,
    job: Option<ControllerJob>,
    due: Option<(Time, ControllerRequest)>,
    outcome: Option<ControllerOutcome>,
    end: Option<ArEnd>,
    /// The start-up to repeat if its AR is lost, and when, once it was lost.
    again: Option<(Box<ArConfig>, Option<Time>)>,
    /// The cached deadline. It is valid until the next event or call.
    deadline: Cell<Option<Option<Time>>>,
}

impl Controller {
    /// A controller without an AR, with all outputs 0 and good.
    pub fn new(settings: ControllerSettings) -> Controller {
        let context = ControllerContext::new(settings);
        let deadline = Cell::default();
        Controller { context, job: None, due: None, outcome: None, end: None, again: None, deadline }
    }

    /// Accepts a request, which begins at the next wake; an outcome that was not taken is discarded. Fails while the previous
    /// request has not ended. [`ControllerRequest::Abort`] is accepted at any time: it also ends the running request, whose outcome is then
    /// that of the abort.
    pub fn request(&mut self, now: Time, request: ControllerRequest) -> Result<(), ControllerBusy> {
        let may_interrupt = matches!(request, ControllerRequest::Abort { .. });
        if self.is_busy() && !may_interrupt {
            return Err(ControllerBusy);
        }
        self.deadline.take();
        self.outcome = None;
        match &request {
            ControllerRequest::Connect(connection) => {
                self.again = connection.reconnect.map(|_| (connection.clone(), None));
            }
            ControllerRequest::Release | ControllerRequest::Abort { .. } => self.again = None,
            _ => {}
        }
        self.due = Some((now, request));
        Ok(())
    }

    /// Whether the last request has not ended yet.
    pub fn is_busy(&self) -> bool {
        self.job.is_some() || self.due.is_some()
    }

    /// Takes the outcome of the last request or of an automatic reconnect, once.
    pub fn take_outcome(&mut self) -> Option<ControllerOutcome> {
        self.outcome.take()
    }

    /// Takes the reason why the AR ended without a request, once; the outcome of a start-up reports its own end.
    pub fn take_end(&mut self) -> Option<ArEnd> {
        self.end.take()
    }

    /// The state of the AR as the controller knows it.
    pub fn state(&self) -> ArState {
        let of_job = self.job.as_ref().and_then(ControllerJob::state);
        of_job.unwrap_or(if self.context.ar.is_some() { ArState::Data } else { ArState::None })
    }

    /// Number of cyclic frames sent in the current or last AR.
    pub fn cycles_sent(&self) -> u64 {
        self.context.cycles_sent
    }

    /// The cyclic outputs; they outlive every AR.
    pub fn outputs_mut(&mut self) -> &mut CyclicOutputs {
        &mut self.context.outputs
    }

    /// Sets how far alarms are acknowledged; it outlives every AR. Acknowledgements withheld before are sent now.
    pub fn acknowledge_alarms(&mut self, acknowledge: AlarmAcknowledge) {
        self.deadline.take();
        self.context.alarm_acknowledge = acknowledge;
        if let Some(alarms) = self.context.ar.as_mut().and_then(|ar| ar.alarms.as_mut()) {
            alarms.acknowledge = acknowledge;
        }
    }

    /// The device of the current AR, or of the last one that was tried.
    pub fn partner(&self) -> Option<Partner> {
        self.context.partner
    }

    /// The settings of the controller.
    pub fn settings(&self) -> &ControllerSettings {
        &self.context.settings
    }

    fn begin(&mut self, now: Time, request: ControllerRequest, out: &mut Outbox) {
        match self.job_of(now, request, out) {
            Ok(job) => self.job = Some(job),
            Err(outcome) => (self.job, self.outcome) = (None, Some(outcome)),
        }
    }

    /// Begins a request: returns a job, or the outcome at once.
    fn job_of(
        &mut self,
        now: Time,
        request: ControllerRequest,
        out: &mut Outbox,
    ) -> Result<ControllerJob, ControllerOutcome> {
        let context = &mut self.context;
        let no_ar = IoRecordOutcome::Failed(CallError::ArEnded);
        match request {
            ControllerRequest::Identify { by, wait } => Ok(identify(context, now, by, wait, out)),
            ControllerRequest::DcpGet { to, elements } => {
                let xid = context.ids.xid();
                Ok(dcp(context, now, to, Dcp::get(xid, elements), out))
            }
            ControllerRequest::DcpSet { to, blocks } => {
                let xid = context.ids.xid();
                Ok(dcp(context, now, to, Dcp::set(xid, blocks), out))
            }
            ControllerRequest::RawDcp { to, request } => {
                let xid = raw::dcp(context, to, &request, out);
                Ok(ControllerJob::RawDcp { to, service: request.service, xid, since: now })
            }
            ControllerRequest::RawCall { partner, call } => Ok(raw::call(context, now, partner, &call, out)),
            ControllerRequest::Load(load) => Ok(load::begin(context, now, load)),
            ControllerRequest::Ping { partner, ping } => Ok(ping::ping(context, now, partner, &ping, out)),
            ControllerRequest::Snmp { partner, octets, gets_id } => {
                Ok(snmp::ask(context, now, partner, (octets, gets_id), out))
            }
            ControllerRequest::DcpSignal { to } => {
                let xid = context.ids.xid();
                Ok(dcp(context, now, to, Dcp::signal(xid), out))
            }
            ControllerRequest::DcpReset { to, reset } => {
                let block = match reset {
                    DcpResetForm::Factory => DcpBlock::set(BlockQualifier(0), DcpValue::FactoryReset),
                    DcpResetForm::ToFactory { qualifier } => {
                        DcpBlock::set(BlockQualifier(qualifier), DcpValue::ResetToFactory)
                    }
                };
                let xid = context.ids.xid();
                Ok(dcp(context, now, to, Dcp::set(xid, [block].into()), out))
            }
            ControllerRequest::Connect(_) if context.ar.is_some() => {
                Err(ControllerOutcome::Impossible("an AR stands already"))
            }
            ControllerRequest::Connect(connection) => {
                ArStartUpJob::begin(connection, context, now, out).map(ControllerJob::StartUp)
            }
            ControllerRequest::Release => jobs::release(context, now, out)
                .map(ControllerJob::Release)
                .ok_or(ControllerOutcome::Ended(ArReleaseOutcome::NoAr)),
            ControllerRequest::Abort { code } => Err(ControllerOutcome::Ended(abort(context, code, out))),
            ControllerRequest::Write { target, data } => {
                let (uuid, number) = context.record_numbers(1).ok_or(ControllerOutcome::Record(no_ar))?;
                let request = record::write(uuid, number, target, data);
                send_write(context, now, &request, out);
                Ok(ControllerJob::Write(request))
            }
            ControllerRequest::WriteMultiple(records) => {
                let count = records.len();
                let numbers = context.record_numbers(count as u16 + 1);
                let (uuid, number) = numbers.ok_or_else(|| ControllerOutcome::Records(alloc::vec![no_ar; count]))?;
                let request = record::write_multiple(uuid, number, &records);
                send_write(context, now, &request, out);
                Ok(ControllerJob::WriteMultiple(request, count))
            }
            ControllerRequest::Read { target, length } => jobs::read(context, now, target, length, out)
                .map(ControllerJob::Read)
                .ok_or(ControllerOutcome::Record(no_ar)),
            ControllerRequest::ReadImplicit { partner, object, target, length } => {
                Ok(ControllerJob::Read(jobs::read_implicit(context, now, (partner, object), (target, length), out)))
            }
            ControllerRequest::Parameter { at, request } => IoParameterJob::begin(context, now, at, request, out)
                .map(ControllerJob::Parameter)
                .ok_or(ControllerOutcome::Parameter(IoParameterOutcome::Failed(CallError::ArEnded))),
            ControllerRequest::EndpointLookup { partner } => {
                Ok(ControllerJob::Lookup(Lookup::begin(context, now, partner, out)))
            }
            ControllerRequest::Page { partner, request } => {
                let settings = &context.settings;
                let browser = context.browser.get_or_insert_with(|| Browser::new(now, settings).into());
                browser.visit(now, partner, &request, out);
                Ok(ControllerJob::Page)
            }
            ControllerRequest::Lldp { chassis, port } => {
                presence::announce(&context.settings, &chassis, &port, out);
                Err(ControllerOutcome::Sent)
            }
            ControllerRequest::Arp { target, probe, wait } => {
                let sender = if probe { Ipv4Addr::UNSPECIFIED } else { context.settings.ip };
                let request = Arp::request(context.settings.mac, sender, target);
                out.push_with(|octets| request.write_frame(octets));
                Ok(ControllerJob::Arp { target, until: now + wait, owners: Vec::new() })
            }
            ControllerRequest::Raw(frame) => {
                out.push(&frame);
                Err(ControllerOutcome::Sent)
            }
            ControllerRequest::Broken { broken, partner } => Err(match broken::frame(context, broken, partner) {
                Ok(frame) => {
                    out.push(&frame);
                    ControllerOutcome::Broken(frame)
                }
                Err(why) => ControllerOutcome::Impossible(why),
            }),
        }
    }

    /// Passes an event to the job. The end of an AR goes to the job, or else to the caller.
    fn dispatch(&mut self, now: Time, event: JobEvent, out: &mut Outbox) {
        if let JobEvent::Ended(end) = &event
            && !matches!(self.job, Some(ControllerJob::StartUp(_)))
        {
            self.end = Some(end.clone());
        }
        let Some(job) = &mut self.job else { return };
        if let Some(outcome) = job.event(&mut self.context, now, event, out) {
            (self.job, self.outcome) = (None, Some(outcome));
        }
    }

    /// Handles the end of the AR without a request of the caller.
    fn ended(&mut self, now: Time, end: ArEnd, out: &mut Outbox) {
        match &end {
            ArEnd::Aborted(_) => self.context.drop_ar(),
            ArEnd::Watchdog(_) => self.context.abort(AbortReason::CONSUMER_TIMEOUT, out),
            ArEnd::AlarmUnacknowledged(_) => self.context.abort(AbortReason::ALARM_ACK_SEND, out),
        }
        if let Some((connection, due)) = &mut self.again
            && let Some(reconnect) = connection.reconnect
        {
            *due = Some(now + reconnect.after);
        }
        self.dispatch(now, JobEvent::Ended(end), out);
    }

    fn profinet(&mut self, now: Time, header: &FrameHeader, payload: &[u8], out: &mut Outbox) {
        let Ok(frame_id) = FrameId::peek(payload) else { return };
        let ar = self.context.ar.as_mut();
        match frame_id.kind() {
            FrameKind::RtClass1 | FrameKind::RtClass2 if header.destination == self.context.own.mac => {
                let exchange = ar.and_then(|ar| ar.exchange.as_mut());
                let sample = exchange
                    .map_or(InputSample::Foreign, |exchange| exchange.consumer.receive(now, header.source, payload));
                if sample != InputSample::Foreign && self.job.is_some() {
                    self.dispatch(now, JobEvent::Sample(sample), out);
                }
            }
            FrameKind::AlarmHigh | FrameKind::AlarmLow if header.destination == self.context.own.mac => {
                let (Some(ar), Some(priority)) = (ar, AlarmPriority::from_frame_id(frame_id.0)) else { return };
                let Some(alarms) = &mut ar.alarms else { return };
                match alarms.receive(now, header.source, priority, &payload[2..], out) {
                    Err(end) => self.ended(now, end, out),
                    Ok(Some(alarm)) if needs_parameters(&alarm) => ar.plugs.add(now, alarm.specifier.sequence_number()),
                    Ok(_) => {}
                }
            }
            FrameKind::DcpIdentifyRequest | FrameKind::DcpIdentifyResponse | FrameKind::DcpGetSet => {
                let Ok(dcp) = Dcp::parse(payload) else { return };
                if dcp.service_type == ServiceType::REQUEST {
                    let pending = matches!(self.job, Some(ControllerJob::Identify { xid, .. }) if xid == dcp.xid);
                    if !pending {
                        presence::identify(&self.context.settings, header.source, &dcp, out);
                    }
                } else if header.destination == self.context.own.mac {
                    self.dispatch(now, JobEvent::Dcp(header.source, dcp), out);
                }
            }
            _ => {}
        }
    }

    fn arp(&mut self, now: Time, header: &FrameHeader, payload: &[u8], out: &mut Outbox) {
        let Ok(arp) = Arp::parse(payload) else { return };
        let Partner { mac, ip } = self.context.own;
        if arp.operation == ArpOperation::REQUEST && arp.target_ip == ip {
            out.push_with(|octets| arp.reply(mac).write_frame(octets));
        } else if arp.operation == ArpOperation::REPLY && arp.sender_mac == header.source {
            self.dispatch(now, JobEvent::Arp(arp), out);
            self.browse(now, Some((header, payload)), out);
        }
    }

    /// A wrong UDP checksum is accepted: virtual interfaces do not fill it in.
    fn datagram(&mut self, now: Time, frame: &[u8], out: &mut Outbox) {
        let Ok(datagram) = Datagram::parse(frame) else { return };
        let own = self.context.own;
        if (datagram.destination_mac, *datagram.destination.ip()) != (own.mac, own.ip) {
            return;
        }
        match datagram.destination.port() {
            call::CLIENT_PORT => {
                let raw = match &self.job {
                    Some(ControllerJob::Call(job)) => job.answer(&datagram),
                    _ => None,
                };
                if let Some(answer) = raw {
                    return self.dispatch(now, JobEvent::Called(answer), out);
                }
                if self.context.ar.as_mut().is_some_and(|ar| ar.plugs.receive(now, &datagram, out)) {
                    return;
                }
                let call = self.context.call.as_mut();
                if let Some(answer) = call.and_then(|call| call.receive(now, &datagram, out)) {
                    self.context.call = None;
                    self.dispatch(now, JobEvent::Answer(answer), out);
                }
            }
            snmp::MANAGER_PORT => {
                if let Some(ControllerJob::Snmp(job)) = &self.job
                    && let Some(response) = job.response(&datagram)
                {
                    self.dispatch(now, JobEvent::Managed(response), out);
                }
            }
            PORT => {
                let served = self.context.served();
                if let Some(control) = self.context.server.receive(served, &datagram, out) {
                    let diff = self.context.application_is_ready(now, &control);
                    self.dispatch(now, JobEvent::Ready(diff), out);
                }
            }
            _ => {}
        }
    }

    /// Passes a packet to the job that waits for a reply to an echo request.
    fn echo(&mut self, now: Time, header: &FrameHeader, payload: &[u8], out: &mut Outbox) {
        let Some(ControllerJob::Ping(job)) = &mut self.job else { return };
        let Ok(packet) = Ipv4::parse(payload) else { return };
        if packet.destination == self.context.own.ip
            && let Some(reply) = job.reply(header.source, &packet)
        {
            self.dispatch(now, JobEvent::Echoed(reply), out);
        }
    }

    /// Passes a frame, or the time, to the browser.
    fn browse(&mut self, now: Time, frame: Option<(&FrameHeader, &[u8])>, out: &mut Outbox) {
        let Some(browser) = &mut self.context.browser else { return };
        if let Some(outcome) = browser.go_on(now, frame, out) {
            self.dispatch(now, JobEvent::Page(outcome), out);
        }
    }

    /// Whether a frame is a TCP packet to this controller.
    fn is_segment(&self, header: &FrameHeader, payload: &[u8]) -> bool {
        let is_to_controller =
            |packet: Ipv4<'_>| (packet.protocol, packet.destination) == (Ipv4::TCP, self.context.own.ip);
        header.destination == self.context.own.mac && Ipv4::parse(payload).is_ok_and(is_to_controller)
    }

    fn wake_call(&mut self, now: Time, out: &mut Outbox) {
        let call = self.context.call.as_mut();
        if let Some(answer) = call.and_then(|call| call.wake(now, out)) {
            self.context.call = None;
            self.dispatch(now, JobEvent::Answer(answer), out);
        }
    }

    fn wake_ar(&mut self, now: Time, out: &mut Outbox) {
        let ControllerContext { ar: Some(ar), outputs, cycles_sent, .. } = &mut self.context else { return };
        let mut end = None;
        if let Some(exchange) = &mut ar.exchange {
            *cycles_sent += u64::from(exchange.provider.wake(now, outputs, out));
            end = exchange.consumer.wake(now).map(ArEnd::Watchdog);
        }
        if let Some(alarms) = &mut ar.alarms {
            end = end.or_else(|| alarms.wake(now, out));
        }
        if let Some(end) = end {
            self.ended(now, end, out);
        }
    }
}

impl Station for Controller {
    fn receive(&mut self, now: Time, frame: &[u8], out: &mut Outbox) {
        let Ok((header, payload)) = FrameHeader::parse(frame) else { return };
        if header.source == self.context.own.mac || header.source.is_group() {
            return;
        }
        if header.destination != self.context.own.mac && !header.destination.is_group() {
            return;
        }
        self.deadline.take();
        match header.ether_type {
            EtherType::PROFINET => self.profinet(now, &header, payload, out),
            EtherType::ARP => self.arp(now, &header, payload, out),
            EtherType::IPV4 if self.is_segment(&header, payload) => self.browse(now, Some((&header, payload)), out),
            EtherType::IPV4 => {
                self.echo(now, &header, payload, out);
                self.datagram(now, frame, out);
            }
            _ => {}
        }
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        self.deadline.take();
        self.wake_ar(now, out);
        self.wake_call(now, out);
        self.context.wake_plugs(now, out);
        if self.context.browser.as_ref().and_then(|browser| browser.due()).is_some_and(|due| due <= now) {
            self.browse(now, None, out);
        }
        if self.job.is_some() {
            self.dispatch(now, JobEvent::Wake, out);
        }
        if let Some((_, request)) = self.due.take_if(|(due, _)| now >= *due) {
            self.begin(now, request, out);
        }
        if !self.is_busy()
            && self.context.ar.is_none()
            && let Some((connection, due)) = &mut self.again
            && due.take_if(|due| now >= *due).is_some()
        {
            let request = ControllerRequest::Connect(connection.clone());
            self.begin(now, request, out);
        }
    }

    fn deadline(&self) -> Option<Time> {
        let deadline = self.deadline.get().unwrap_or_else(|| self.next_due());
        self.deadline.set(Some(deadline));
        deadline
    }
}

impl Controller {
    /// When it has something to do next.
    fn next_due(&self) -> Option<Time> {
        let mut first: Option<Time> = None;
        let mut consider = |due: Option<Time>| {
            if let Some(due) = due {
                first = Some(first.map_or(due, |first| first.min(due)));
            }
        };
        if let Some(ar) = &self.context.ar {
            if let Some(exchange) = &ar.exchange {
                consider(Some(exchange.provider.deadline()));
                consider(exchange.consumer.deadline());
            }
            consider(ar.alarms.as_ref().and_then(|alarms| alarms.deadline()));
            consider(ar.plugs.deadline());
        }
        consider(self.due.as_ref().map(|(due, _)| *due));
        consider(self.context.call.as_ref().map(|call| call.deadline()));
        consider(self.job.as_ref().and_then(ControllerJob::deadline));
        consider(self.context.browser.as_ref().and_then(|browser| browser.due()));
        consider(self.again.as_ref().and_then(|(_, due)| *due).filter(|_| !self.is_busy()));
        first
    }
}

fn identify(
    context: &mut ControllerContext,
    now: Time,
    by: IdentifyBy,
    wait: Duration,
    out: &mut Outbox,
) -> ControllerJob {
    // A single station answers at once. The answers of all stations are spread over half of `wait`, in units of 10 ms.
    let spread = (wait.as_millis() / 20).clamp(1, 6400) as u16;
    let (delay, filters) = match by {
        IdentifyBy::Filters { octets, delay } => {
            let xid = raw::identify(context, &octets, delay, out);
            return ControllerJob::Identify { xid, until: now + wait, seen: Vec::new() };
        }
        IdentifyBy::All => (spread, Vec::from([DcpValue::AllSelector])),
        IdentifyBy::Name(name) => (1, [DcpValue::NameOfStation(name)].into()),
        IdentifyBy::Alias(name) => (1, [DcpValue::AliasName(name)].into()),
        IdentifyBy::Values(values) => (spread, values),
    };
    let xid = context.ids.xid();
    let own = context.settings.mac;
    out.push_with(|octets| Dcp::identify(xid, delay, filters).write_frame(Mac::DCP_MULTICAST, own, octets));
    ControllerJob::Identify { xid, until: now + wait, seen: Vec::new() }
}

fn dcp(context: &mut ControllerContext, now: Time, to: Mac, request: Dcp, out: &mut Outbox) -> ControllerJob {
    let own = context.settings.mac;
    out.push_with(|octets| request.write_frame(to, own, octets));
    ControllerJob::Dcp { to, service: request.service_id, xid: request.xid, since: now }
}

fn abort(context: &mut ControllerContext, code: AbortReason, out: &mut Outbox) -> ArReleaseOutcome {
    if context.ar.is_none() {
        context.call = None;
        return ArReleaseOutcome::NoAr;
    }
    context.abort(code, out);
    ArReleaseOutcome::Aborted
}
