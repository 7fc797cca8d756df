//! The controller: it assigns requests, frames and deadlines to its jobs, the AR and the server.

use super::alarms::AlarmAcknowledge;
use super::broken;
use super::connection::Connection;
use super::context::{Context, Event};
use super::exchange::Sample;
use super::http::Browser;
use super::jobs::{self, Job, Lookup, Parameter};
use super::outcome::{ArEnd, CallError, Ended, Outcome, ParameterOutcome, RecordOutcome};
use super::request::{Busy, IdentifyBy, Partner, Request, Reset, Settings};
use super::startup::{StartUpJob, send_write};
use super::state::ArState;
use super::{call, presence, record};
use crate::outputs::Outputs;
use alloc::boxed::Box;
use alloc::vec::Vec;
use core::cell::Cell;
use core::net::Ipv4Addr;
use core::time::Duration;
use station::{Outbox, Station, Time};
use wire::datagram::arp::{Arp, Operation};
use wire::datagram::{Datagram, Ipv4};
use wire::ethernet::{EtherType, FrameHeader, Mac};
use wire::profinet::alarm::AlarmPriority;
use wire::profinet::dcp::{Block, BlockQualifier, Dcp, ServiceType, Value};
use wire::profinet::rpc::PORT;
use wire::profinet::rt::{FrameId, FrameKind};
use wire::profinet::status::AbortReason;

/// A PROFINET IO controller.
///
/// It accepts one [`Request`] at a time. After [`Controller::request`] it is due at once, so its next frames leave when it is
/// woken. An established AR needs no further requests.
#[derive(Debug)]
pub struct Controller {
    context: Context,
    job: Option<Job>,
    due: Option<(Time, Request)>,
    outcome: Option<Outcome>,
    end: Option<ArEnd>,
    /// The start-up to repeat if its AR is lost, and when, once it was lost.
    again: Option<(Box<Connection>, Option<Time>)>,
    /// The cached deadline. It is valid until the next event or call.
    deadline: Cell<Option<Option<Time>>>,
}

impl Controller {
    /// A controller without an AR, with all outputs 0 and good.
    pub fn new(settings: Settings) -> Controller {
        let context = Context::new(settings);
        let deadline = Cell::default();
        Controller { context, job: None, due: None, outcome: None, end: None, again: None, deadline }
    }

    /// Accepts a request, which begins at the next wake; an outcome that was not taken is discarded. Fails while the previous
    /// request has not ended. [`Request::Abort`] is accepted at any time: it also ends the running request, whose outcome is then
    /// that of the abort.
    pub fn request(&mut self, now: Time, request: Request) -> Result<(), Busy> {
        let may_interrupt = matches!(request, Request::Abort { .. });
        if self.is_busy() && !may_interrupt {
            return Err(Busy);
        }
        self.deadline.take();
        self.outcome = None;
        match &request {
            Request::Connect(connection) => {
                self.again = connection.reconnect.map(|_| (connection.clone(), None));
            }
            Request::Release | Request::Abort { .. } => self.again = None,
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
    pub fn take_outcome(&mut self) -> Option<Outcome> {
        self.outcome.take()
    }

    /// Takes the reason why the AR ended without a request, once; the outcome of a start-up reports its own end.
    pub fn take_end(&mut self) -> Option<ArEnd> {
        self.end.take()
    }

    /// The state of the AR as the controller knows it.
    pub fn state(&self) -> ArState {
        let of_job = self.job.as_ref().and_then(Job::state);
        of_job.unwrap_or(if self.context.ar.is_some() { ArState::Data } else { ArState::None })
    }

    /// Number of cyclic frames sent in the current or last AR.
    pub fn cycles_sent(&self) -> u64 {
        self.context.cycles_sent
    }

    /// The cyclic outputs; they outlive every AR.
    pub fn outputs_mut(&mut self) -> &mut Outputs {
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
    pub fn settings(&self) -> &Settings {
        &self.context.settings
    }

    fn begin(&mut self, now: Time, request: Request, out: &mut Outbox) {
        match self.job_of(now, request, out) {
            Ok(job) => self.job = Some(job),
            Err(outcome) => (self.job, self.outcome) = (None, Some(outcome)),
        }
    }

    /// Begins a request: returns a job, or the outcome at once.
    fn job_of(&mut self, now: Time, request: Request, out: &mut Outbox) -> Result<Job, Outcome> {
        let context = &mut self.context;
        let no_ar = RecordOutcome::Failed(CallError::ArEnded);
        match request {
            Request::Identify { by, wait } => Ok(identify(context, now, by, wait, out)),
            Request::DcpGet { to, elements } => {
                let xid = context.ids.xid();
                Ok(dcp(context, now, to, Dcp::get(xid, elements), out))
            }
            Request::DcpSet { to, blocks } => {
                let xid = context.ids.xid();
                Ok(dcp(context, now, to, Dcp::set(xid, blocks), out))
            }
            Request::DcpSignal { to } => {
                let xid = context.ids.xid();
                Ok(dcp(context, now, to, Dcp::signal(xid), out))
            }
            Request::DcpReset { to, reset } => {
                let block = match reset {
                    Reset::Factory => Block::set(BlockQualifier(0), Value::FactoryReset),
                    Reset::ToFactory { qualifier } => Block::set(BlockQualifier(qualifier), Value::ResetToFactory),
                };
                let xid = context.ids.xid();
                Ok(dcp(context, now, to, Dcp::set(xid, [block].into()), out))
            }
            Request::Connect(_) if context.ar.is_some() => Err(Outcome::Impossible("an AR stands already")),
            Request::Connect(connection) => StartUpJob::begin(connection, context, now, out).map(Job::StartUp),
            Request::Release => jobs::release(context, now, out).map(Job::Release).ok_or(Outcome::Ended(Ended::NoAr)),
            Request::Abort { code } => Err(Outcome::Ended(abort(context, code, out))),
            Request::Write { target, data } => {
                let (uuid, number) = context.record_numbers(1).ok_or(Outcome::Record(no_ar))?;
                let request = record::write(uuid, number, target, data);
                send_write(context, now, &request, out);
                Ok(Job::Write(request))
            }
            Request::WriteMultiple(records) => {
                let count = records.len();
                let numbers = context.record_numbers(count as u16 + 1);
                let (uuid, number) = numbers.ok_or_else(|| Outcome::Records(alloc::vec![no_ar; count]))?;
                let request = record::write_multiple(uuid, number, &records);
                send_write(context, now, &request, out);
                Ok(Job::WriteMultiple(request, count))
            }
            Request::Read { target, length } => {
                jobs::read(context, now, target, length, out).map(Job::Read).ok_or(Outcome::Record(no_ar))
            }
            Request::ReadImplicit { partner, object, target, length } => {
                Ok(Job::Read(jobs::read_implicit(context, now, (partner, object), (target, length), out)))
            }
            Request::Parameter { at, request } => Parameter::begin(context, now, at, request, out)
                .map(Job::Parameter)
                .ok_or(Outcome::Parameter(ParameterOutcome::Failed(CallError::ArEnded))),
            Request::EndpointLookup { partner } => Ok(Job::Lookup(Lookup::begin(context, now, partner, out))),
            Request::Page { partner, request } => {
                let settings = &context.settings;
                let browser = context.browser.get_or_insert_with(|| Browser::new(now, settings).into());
                browser.visit(now, partner, &request, out);
                Ok(Job::Page)
            }
            Request::Lldp { chassis, port } => {
                presence::announce(&context.settings, &chassis, &port, out);
                Err(Outcome::Sent)
            }
            Request::Arp { target, probe, wait } => {
                let sender = if probe { Ipv4Addr::UNSPECIFIED } else { context.settings.ip };
                let request = Arp::request(context.settings.mac, sender, target);
                out.push_with(|octets| request.write_frame(octets));
                Ok(Job::Arp { target, until: now + wait, owners: Vec::new() })
            }
            Request::Raw(frame) => {
                out.push(&frame);
                Err(Outcome::Sent)
            }
            Request::Broken { broken, partner } => Err(match broken::frame(context, broken, partner) {
                Ok(frame) => {
                    out.push(&frame);
                    Outcome::Broken(frame)
                }
                Err(why) => Outcome::Impossible(why),
            }),
        }
    }

    /// Passes an event to the job. The end of an AR goes to the job, or else to the caller.
    fn dispatch(&mut self, now: Time, event: Event, out: &mut Outbox) {
        if let Event::Ended(end) = &event
            && !matches!(self.job, Some(Job::StartUp(_)))
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
        self.dispatch(now, Event::Ended(end), out);
    }

    fn profinet(&mut self, now: Time, header: &FrameHeader, payload: &[u8], out: &mut Outbox) {
        let Ok(frame_id) = FrameId::peek(payload) else { return };
        let ar = self.context.ar.as_mut();
        match frame_id.kind() {
            FrameKind::RtClass1 | FrameKind::RtClass2 if header.destination == self.context.own.mac => {
                let exchange = ar.and_then(|ar| ar.exchange.as_mut());
                let sample =
                    exchange.map_or(Sample::Foreign, |exchange| exchange.consumer.receive(now, header.source, payload));
                if sample != Sample::Foreign && self.job.is_some() {
                    self.dispatch(now, Event::Sample(sample), out);
                }
            }
            FrameKind::AlarmHigh | FrameKind::AlarmLow if header.destination == self.context.own.mac => {
                let (Some(alarms), Some(priority)) =
                    (ar.and_then(|ar| ar.alarms.as_mut()), AlarmPriority::from_frame_id(frame_id.0))
                else {
                    return;
                };
                if let Some(end) = alarms.receive(now, header.source, priority, &payload[2..], out) {
                    self.ended(now, end, out);
                }
            }
            FrameKind::DcpIdentifyRequest | FrameKind::DcpIdentifyResponse | FrameKind::DcpGetSet => {
                let Ok(dcp) = Dcp::parse(payload) else { return };
                if dcp.service_type == ServiceType::REQUEST {
                    let pending = matches!(self.job, Some(Job::Identify { xid, .. }) if xid == dcp.xid);
                    if !pending {
                        presence::identify(&self.context.settings, header.source, &dcp, out);
                    }
                } else if header.destination == self.context.own.mac {
                    self.dispatch(now, Event::Dcp(header.source, dcp), out);
                }
            }
            _ => {}
        }
    }

    fn arp(&mut self, now: Time, header: &FrameHeader, payload: &[u8], out: &mut Outbox) {
        let Ok(arp) = Arp::parse(payload) else { return };
        let Partner { mac, ip } = self.context.own;
        if arp.operation == Operation::REQUEST && arp.target_ip == ip {
            out.push_with(|octets| arp.reply(mac).write_frame(octets));
        } else if arp.operation == Operation::REPLY && arp.sender_mac == header.source {
            self.dispatch(now, Event::Arp(arp), out);
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
                let call = self.context.call.as_mut();
                if let Some(answer) = call.and_then(|call| call.receive(now, &datagram, out)) {
                    self.context.call = None;
                    self.dispatch(now, Event::Answer(answer), out);
                }
            }
            PORT => {
                let served = self.context.served();
                if let Some(control) = self.context.server.receive(served, &datagram, out) {
                    let diff = self.context.application_is_ready(now, &control);
                    self.dispatch(now, Event::Ready(diff), out);
                }
            }
            _ => {}
        }
    }

    /// Passes a frame, or the time, to the browser.
    fn browse(&mut self, now: Time, frame: Option<(&FrameHeader, &[u8])>, out: &mut Outbox) {
        let Some(browser) = &mut self.context.browser else { return };
        if let Some(outcome) = browser.go_on(now, frame, out) {
            self.dispatch(now, Event::Page(outcome), out);
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
            self.dispatch(now, Event::Answer(answer), out);
        }
    }

    fn wake_ar(&mut self, now: Time, out: &mut Outbox) {
        let Context { ar: Some(ar), outputs, cycles_sent, .. } = &mut self.context else { return };
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
            EtherType::IPV4 => self.datagram(now, frame, out),
            _ => {}
        }
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        self.deadline.take();
        self.wake_ar(now, out);
        self.wake_call(now, out);
        if self.context.browser.as_ref().and_then(|browser| browser.due()).is_some_and(|due| due <= now) {
            self.browse(now, None, out);
        }
        if self.job.is_some() {
            self.dispatch(now, Event::Wake, out);
        }
        if let Some((_, request)) = self.due.take_if(|(due, _)| now >= *due) {
            self.begin(now, request, out);
        }
        if !self.is_busy()
            && self.context.ar.is_none()
            && let Some((connection, due)) = &mut self.again
            && due.take_if(|due| now >= *due).is_some()
        {
            let request = Request::Connect(connection.clone());
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
        }
        consider(self.due.as_ref().map(|(due, _)| *due));
        consider(self.context.call.as_ref().map(|call| call.deadline()));
        consider(self.job.as_ref().and_then(Job::deadline));
        consider(self.context.browser.as_ref().and_then(|browser| browser.due()));
        consider(self.again.as_ref().and_then(|(_, due)| *due).filter(|_| !self.is_busy()));
        first
    }
}

fn identify(context: &mut Context, now: Time, by: IdentifyBy, wait: Duration, out: &mut Outbox) -> Job {
    // A single station answers at once. The answers of all stations are spread over half of `wait`, in units of 10 ms.
    let spread = (wait.as_millis() / 20).clamp(1, 6400) as u16;
    let (delay, filters) = match by {
        IdentifyBy::All => (spread, Vec::from([Value::AllSelector])),
        IdentifyBy::Name(name) => (1, [Value::NameOfStation(name)].into()),
        IdentifyBy::Alias(name) => (1, [Value::AliasName(name)].into()),
        IdentifyBy::Values(values) => (spread, values),
    };
    let xid = context.ids.xid();
    let own = context.settings.mac;
    out.push_with(|octets| Dcp::identify(xid, delay, filters).write_frame(Mac::DCP_MULTICAST, own, octets));
    Job::Identify { xid, until: now + wait, seen: Vec::new() }
}

fn dcp(context: &mut Context, now: Time, to: Mac, request: Dcp, out: &mut Outbox) -> Job {
    let own = context.settings.mac;
    out.push_with(|octets| request.write_frame(to, own, octets));
    Job::Dcp { to, service: request.service_id, xid: request.xid, since: now }
}

fn abort(context: &mut Context, code: AbortReason, out: &mut Outbox) -> Ended {
    if context.ar.is_none() {
        context.call = None;
        return Ended::NoAr;
    }
    context.abort(code, out);
    Ended::Aborted
}
