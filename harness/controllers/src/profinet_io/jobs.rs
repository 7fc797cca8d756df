//! Short jobs: Identify, DCP to one station, records, base mode parameters, the endpoint mapper, release.
//!
//! A job receives events until it has an outcome. `startup` has the start-up, the only long job.

use super::call::RpcCallResult;
use super::connect::ArNames;
use super::connection::RecordAddress;
use super::context::{ARGS_MAXIMUM, CallRefusal, CallTarget, ControllerContext, JobEvent, blocks, no_response};
use super::load::LoadJob;
use super::outcome::{
    ArReleaseOutcome, CallError, ControllerOutcome, DcpOutcome, IdentifiedStation, IoParameterOutcome, IoRecordOutcome,
};
use super::ping::PingJob;
use super::raw::RawCallJob;
use super::record;
use super::request::Partner;
use super::search::{answers, is_identification};
use super::snmp::SnmpJob;
use super::startup::{ArStartUpJob, control_outcome, send_control, send_write};
use super::state::{ArState, AwaitedEvent, Wait};
use alloc::boxed::Box;
use alloc::string::ToString;
use alloc::vec::Vec;
use core::net::Ipv4Addr;
use core::time::Duration;
use station::{Outbox, Time};
use wire::ethernet::Mac;
use wire::octets::ByteOrder;
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::record::{ReadRequest, WriteRequest};
use wire::profinet::dcp::ServiceId;
use wire::profinet::rpc::{EndpointEntry, LookupHandle, LookupRequest, LookupResponse, ObjectUuid, Opnum, Uuid};
use wire::profinet::status::{PnioStatus, RecordError};

/// Timeout for the answer to a DCP request; a device may take this long to set a name.
const DCP_WAIT: Duration = Duration::from_secs(3);
/// Timeout for a base mode answer (PROFIdrive profile, parameter access).
const PARAMETER_WAIT: Duration = Duration::from_secs(10);
/// Pause before the answer is read again after "not ready".
const PARAMETER_PAUSE: Duration = Duration::from_millis(10);
/// Maximum length of a base mode answer in bytes; more than the profile allows, so that a longer answer is detected.
const PARAMETER_LENGTH: u32 = 4096;
/// Maximum number of entries requested from an endpoint mapper.
const MOST_ENTRIES: usize = 64;

/// The running job.
#[derive(Debug)]
pub(super) enum ControllerJob {
    /// Collects answers to Identify.
    Identify { xid: u32, until: Time, seen: Vec<IdentifiedStation> },
    /// Waits for the answer to a DCP request.
    Dcp { to: Mac, service: ServiceId, xid: u32, since: Time },
    /// Waits for the answer to a DCP request whose bytes the caller has given.
    RawDcp { to: Mac, service: ServiceId, xid: u32, since: Time },
    /// Waits for the answer to a call whose fields the caller has given.
    Call(RawCallJob),
    /// Sends a net load.
    Load(LoadJob),
    /// Waits for the reply to an ICMP echo request.
    Ping(PingJob),
    /// Waits for the response to an SNMP request.
    Snmp(SnmpJob),
    /// Collects the owners of an address.
    Arp { target: Ipv4Addr, until: Time, owners: Vec<Mac> },
    /// Starts up an AR.
    StartUp(Box<ArStartUpJob>),
    /// Reads a record.
    Read(ReadRequest),
    /// Writes a record.
    Write(WriteRequest),
    /// Writes several records.
    WriteMultiple(WriteRequest, usize),
    /// Writes a base mode request and reads its answer.
    Parameter(IoParameterJob),
    /// Queries an endpoint mapper.
    Lookup(Lookup),
    /// Releases the AR of these names.
    Release(ArNames),
    /// Requests a web page.
    Page,
}

/// A base mode request.
#[derive(Debug)]
pub(super) struct IoParameterJob {
    at: RecordAddress,
    /// The reference of the request; an empty request has none.
    reference: Option<u8>,
    phase: ParameterPhase,
}

/// The phase of a base mode request.
#[derive(Debug)]
enum ParameterPhase {
    /// The request was written.
    Write(WriteRequest),
    /// The answer is read; the request was accepted at this time.
    Read(ReadRequest, Time),
    /// The answer is not ready; it is read again at `until`.
    Pause { since: Time, until: Time },
}

/// A walk through the entries of an endpoint mapper.
#[derive(Debug)]
pub(super) struct Lookup {
    callee: CallTarget,
    entries: Vec<EndpointEntry>,
}

impl ControllerJob {
    /// The AR state while this job runs, if the job determines it.
    pub(super) fn state(&self) -> Option<ArState> {
        match self {
            ControllerJob::StartUp(job) => Some(ArState::Starting(job.stage())),
            ControllerJob::Release(_) => Some(ArState::Releasing),
            _ => None,
        }
    }

    /// When it has something to do; the call has its own deadline.
    pub(super) fn deadline(&self) -> Option<Time> {
        match self {
            ControllerJob::Identify { until, .. } | ControllerJob::Arp { until, .. } => Some(*until),
            ControllerJob::Dcp { since, .. } | ControllerJob::RawDcp { since, .. } => Some(*since + DCP_WAIT),
            ControllerJob::Call(call) => Some(call.until()),
            ControllerJob::Snmp(job) => Some(job.until()),
            ControllerJob::Ping(job) => Some(job.until()),
            ControllerJob::Load(job) => Some(job.due()),
            ControllerJob::StartUp(job) => job.deadline(),
            ControllerJob::Parameter(IoParameterJob { phase: ParameterPhase::Pause { until, .. }, .. }) => Some(*until),
            ControllerJob::Parameter(_)
            | ControllerJob::Read(_)
            | ControllerJob::Write(_)
            | ControllerJob::WriteMultiple(..)
            | ControllerJob::Lookup(_)
            | ControllerJob::Release(_)
            | ControllerJob::Page => None,
        }
    }

    /// Processes an event; returns the outcome at the end.
    pub(super) fn event(
        &mut self,
        context: &mut ControllerContext,
        now: Time,
        event: JobEvent,
        out: &mut Outbox,
    ) -> Option<ControllerOutcome> {
        match (self, event) {
            (ControllerJob::StartUp(job), event) => job.event(context, now, event, out),
            (ControllerJob::Parameter(job), event) => {
                job.event(context, now, event, out).map(ControllerOutcome::Parameter)
            }
            (ControllerJob::Identify { xid, seen, .. }, JobEvent::Dcp(from, dcp)) if is_identification(&dcp, *xid) => {
                let station = IdentifiedStation::of(from, &dcp);
                if !seen.contains(&station) {
                    seen.push(station);
                }
                None
            }
            (ControllerJob::Identify { until, seen, .. }, JobEvent::Wake) if now >= *until => {
                Some(ControllerOutcome::Stations(core::mem::take(seen)))
            }
            (ControllerJob::Arp { target, owners, .. }, JobEvent::Arp(arp)) if arp.sender_ip == *target => {
                if !owners.contains(&arp.sender_mac) {
                    owners.push(arp.sender_mac);
                }
                None
            }
            (ControllerJob::Arp { until, owners, .. }, JobEvent::Wake) if now >= *until => {
                Some(ControllerOutcome::Owners(core::mem::take(owners)))
            }
            (ControllerJob::Dcp { to, service, xid, .. }, JobEvent::Dcp(from, dcp))
                if from == *to && answers(&dcp, *service, *xid) =>
            {
                Some(ControllerOutcome::Dcp(DcpOutcome::of(&dcp)))
            }
            (ControllerJob::RawDcp { to, service, xid, .. }, JobEvent::Dcp(from, dcp))
                if from == *to && answers(&dcp, *service, *xid) =>
            {
                Some(ControllerOutcome::DcpAnswer(dcp))
            }
            (ControllerJob::Call(_), JobEvent::Called(answer)) => Some(ControllerOutcome::Called(Ok(answer))),
            (ControllerJob::Call(call), JobEvent::Wake) if now >= call.until() => {
                let wait = Wait { what: AwaitedEvent::Call, time: RawCallJob::WAIT };
                Some(ControllerOutcome::Called(Err(wait)))
            }
            (ControllerJob::Load(load), JobEvent::Wake) => load.wake(now, out).then_some(ControllerOutcome::Sent),
            (ControllerJob::Ping(_), JobEvent::Echoed(reply)) => Some(ControllerOutcome::Ping(Ok(reply))),
            (ControllerJob::Ping(job), JobEvent::Wake) if now >= job.until() => {
                Some(ControllerOutcome::Ping(Err(Wait { what: AwaitedEvent::Ping, time: PingJob::WAIT })))
            }
            (ControllerJob::Snmp(_), JobEvent::Managed(response)) => Some(ControllerOutcome::Snmp(Ok(response))),
            (ControllerJob::Snmp(job), JobEvent::Wake) if now >= job.until() => {
                Some(ControllerOutcome::Snmp(Err(Wait { what: AwaitedEvent::Snmp, time: SnmpJob::WAIT })))
            }
            (
                ControllerJob::Dcp { service, since, .. } | ControllerJob::RawDcp { service, since, .. },
                JobEvent::Wake,
            ) if now >= *since + DCP_WAIT => {
                let what = if *service == ServiceId::GET { AwaitedEvent::StationGet } else { AwaitedEvent::StationSet };
                Some(ControllerOutcome::Dcp(DcpOutcome::NoAnswer(Wait { what, time: DCP_WAIT })))
            }
            (ControllerJob::Read(request), JobEvent::Answer(answer)) => {
                Some(ControllerOutcome::Record(match blocks(answer) {
                    Ok(blocks) => record::read_answer(request, &blocks),
                    Err(refusal) => refusal.into(),
                }))
            }
            (ControllerJob::Write(request), JobEvent::Answer(answer)) => {
                Some(ControllerOutcome::Record(match blocks(answer) {
                    Ok(blocks) => record::write_answer(request, &blocks),
                    Err(refusal) => refusal.into(),
                }))
            }
            (ControllerJob::WriteMultiple(request, count), JobEvent::Answer(answer)) => {
                Some(ControllerOutcome::Records(match blocks(answer) {
                    Ok(blocks) => record::write_multiple_answer(request, *count, &blocks),
                    Err(refusal) => (0..*count).map(|_| refusal.clone().into()).collect(),
                }))
            }
            (ControllerJob::Lookup(job), JobEvent::Answer(answer)) => {
                job.answer(context, now, answer, out).map(ControllerOutcome::Endpoints)
            }
            (ControllerJob::Release(names), JobEvent::Answer(answer)) => Some(ControllerOutcome::Ended(
                ArReleaseOutcome::Released(control_outcome(answer, *names, BlockType::RELEASE_RES)),
            )),
            (ControllerJob::Page, JobEvent::Page(outcome)) => Some(ControllerOutcome::Page(outcome)),
            // A call that outlived the AR did not belong to it.
            (ControllerJob::Read(_) | ControllerJob::Write(_), JobEvent::Ended(_)) if context.call.is_none() => {
                Some(ControllerOutcome::Record(IoRecordOutcome::Failed(CallError::ArEnded)))
            }
            (ControllerJob::WriteMultiple(_, count), JobEvent::Ended(_)) => Some(ControllerOutcome::Records(
                (0..*count).map(|_| IoRecordOutcome::Failed(CallError::ArEnded)).collect(),
            )),
            _ => None,
        }
    }
}

/// Begins to read a record of the AR.
pub(super) fn read(
    context: &mut ControllerContext,
    now: Time,
    target: RecordAddress,
    length: u32,
    out: &mut Outbox,
) -> Option<ReadRequest> {
    let (uuid, number) = context.record_numbers(1)?;
    let request = record::read(uuid, number, target, length);
    let mut blocks = Vec::new();
    request.write(&mut blocks);
    let maximum = ARGS_MAXIMUM.max(length.saturating_add(record::READ_OVERHEAD));
    context.call_ar(now, AwaitedEvent::Read, Opnum::READ, maximum, &blocks, out);
    Some(request)
}

/// Begins to read a record without an AR.
pub(super) fn read_implicit(
    context: &mut ControllerContext,
    now: Time,
    (partner, object): (Partner, ObjectUuid),
    (target, length): (RecordAddress, u32),
    out: &mut Outbox,
) -> ReadRequest {
    let request = record::read(Uuid::NIL, 0, target, length);
    let mut blocks = Vec::new();
    request.write(&mut blocks);
    let callee = CallTarget {
        partner,
        object: object.into(),
        interface: Uuid::DEVICE_INTERFACE,
        interface_version: 1,
        activity: context.ids.uuid(),
        sequence: 0,
        opnum: Opnum::READ_IMPLICIT,
        order: ByteOrder::Big,
    };
    let maximum = ARGS_MAXIMUM.max(length.saturating_add(record::READ_OVERHEAD));
    let body = wire::profinet::rpc::NdrRequest::body(ByteOrder::Big, maximum, &blocks);
    context.call(now, AwaitedEvent::ReadImplicit, callee, &body, out);
    request
}

/// Begins to release the AR: cyclic data and alarms stop, only the call continues.
pub(super) fn release(context: &mut ControllerContext, now: Time, out: &mut Outbox) -> Option<ArNames> {
    let names = context.ar.as_ref()?.names;
    send_control(context, now, AwaitedEvent::Release, out);
    context.ar = None;
    Some(names)
}

impl IoParameterJob {
    /// Writes the request; `None` without an AR.
    pub(super) fn begin(
        context: &mut ControllerContext,
        now: Time,
        at: RecordAddress,
        request: Vec<u8>,
        out: &mut Outbox,
    ) -> Option<IoParameterJob> {
        let (uuid, number) = context.record_numbers(1)?;
        let reference = request.first().copied();
        let request = record::write(uuid, number, at, request);
        send_write(context, now, &request, out);
        Some(IoParameterJob { at, reference, phase: ParameterPhase::Write(request) })
    }

    fn event(
        &mut self,
        context: &mut ControllerContext,
        now: Time,
        event: JobEvent,
        out: &mut Outbox,
    ) -> Option<IoParameterOutcome> {
        match (&self.phase, event) {
            (_, JobEvent::Ended(_)) => Some(IoParameterOutcome::Failed(CallError::ArEnded)),
            (ParameterPhase::Write(request), JobEvent::Answer(answer)) => {
                match blocks(answer).map(|blocks| record::write_answer(request, &blocks)) {
                    Ok(IoRecordOutcome::Accepted { .. }) => self.read(context, now, now, out),
                    Ok(IoRecordOutcome::Refused(status)) | Err(CallRefusal::Status(status)) => {
                        Some(IoParameterOutcome::WriteRefused(status))
                    }
                    Ok(IoRecordOutcome::Failed(error)) | Err(CallRefusal::Call(error)) => {
                        Some(IoParameterOutcome::Failed(error))
                    }
                }
            }
            (&ParameterPhase::Read(ref request, since), JobEvent::Answer(answer)) => {
                match blocks(answer).map(|blocks| record::read_answer(request, &blocks)) {
                    Ok(IoRecordOutcome::Accepted { data }) if data.is_empty() => {
                        self.read_later_or_give_up(now, since, PnioStatus::OK)
                    }
                    Ok(IoRecordOutcome::Accepted { data }) => Some(self.compared(data)),
                    Ok(IoRecordOutcome::Refused(status)) | Err(CallRefusal::Status(status)) => {
                        if status.record_error() == Some(RecordError::STATE_CONFLICT) {
                            self.read_later_or_give_up(now, since, status)
                        } else {
                            Some(IoParameterOutcome::ReadRefused(status))
                        }
                    }
                    Ok(IoRecordOutcome::Failed(error)) | Err(CallRefusal::Call(error)) => {
                        Some(IoParameterOutcome::Failed(error))
                    }
                }
            }
            (&ParameterPhase::Pause { since, until }, JobEvent::Wake) if now >= until => {
                self.read(context, now, since, out)
            }
            _ => None,
        }
    }

    fn read(
        &mut self,
        context: &mut ControllerContext,
        now: Time,
        since: Time,
        out: &mut Outbox,
    ) -> Option<IoParameterOutcome> {
        match read(context, now, self.at, PARAMETER_LENGTH, out) {
            Some(request) => {
                self.phase = ParameterPhase::Read(request, since);
                None
            }
            None => Some(IoParameterOutcome::Failed(CallError::ArEnded)),
        }
    }

    /// Reads again after a pause, or gives up.
    fn read_later_or_give_up(&mut self, now: Time, since: Time, status: PnioStatus) -> Option<IoParameterOutcome> {
        let until = now + PARAMETER_PAUSE;
        if until.since(since) >= PARAMETER_WAIT {
            let wait = Wait { what: AwaitedEvent::ParameterAnswer, time: now.since(since) };
            return Some(IoParameterOutcome::NotReady(status, wait));
        }
        self.phase = ParameterPhase::Pause { since, until };
        None
    }

    fn compared(&self, answer: Vec<u8>) -> IoParameterOutcome {
        match self.reference {
            Some(sent) if answer.first() != Some(&sent) => IoParameterOutcome::OtherReference { sent, answer },
            _ => IoParameterOutcome::Answer(answer),
        }
    }
}

impl Lookup {
    /// Requests the first entry.
    pub(super) fn begin(context: &mut ControllerContext, now: Time, partner: Partner, out: &mut Outbox) -> Lookup {
        let callee = CallTarget {
            partner,
            object: Uuid::NIL,
            interface: Uuid::ENDPOINT_MAPPER,
            interface_version: 3,
            activity: context.ids.uuid(),
            sequence: 0,
            opnum: Opnum::EPT_LOOKUP,
            order: ByteOrder::Big,
        };
        let job = Lookup { callee, entries: Vec::new() };
        job.ask(context, now, LookupHandle::default(), out);
        job
    }

    fn ask(&self, context: &mut ControllerContext, now: Time, handle: LookupHandle, out: &mut Outbox) {
        let mut body = Vec::new();
        LookupRequest::all(handle).write(&mut body, self.callee.order);
        context.call(now, AwaitedEvent::Lookup, self.callee, &body, out);
    }

    fn answer(
        &mut self,
        context: &mut ControllerContext,
        now: Time,
        answer: RpcCallResult,
        out: &mut Outbox,
    ) -> Option<Result<Vec<EndpointEntry>, CallError>> {
        let (order, body) = match answer {
            RpcCallResult::Response(order, body) => (order, body),
            other => return Some(Err(no_response(other))),
        };
        let response = match LookupResponse::parse(order, &body) {
            Ok(response) => response,
            Err(error) => return Some(Err(CallError::Unfit(error.to_string()))),
        };
        let empty = response.entries.is_empty();
        self.entries.extend(response.entries);
        let last = response.status != 0 || response.handle.uuid.is_nil() || empty;
        if last || self.entries.len() >= MOST_ENTRIES {
            return Some(Ok(core::mem::take(&mut self.entries)));
        }
        self.callee.sequence += 1;
        self.ask(context, now, response.handle, out);
        None
    }
}
