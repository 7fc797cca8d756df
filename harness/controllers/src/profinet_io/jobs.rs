//! Short jobs: Identify, DCP to one station, records, base mode parameters, the endpoint mapper, release.
//!
//! A job receives events until it has an outcome. `startup` has the start-up, the only long job.

use super::call::Answer;
use super::connect::ArNames;
use super::connection::Target;
use super::context::{ARGS_MAXIMUM, Callee, Context, Event, Refusal, blocks, no_response};
use super::outcome::{CallError, DcpOutcome, Ended, Outcome, ParameterOutcome, RecordOutcome, StationSeen};
use super::record;
use super::request::Partner;
use super::search::{answers, is_identification};
use super::startup::{StartUpJob, control_outcome, send_control, send_write};
use super::state::{ArState, Wait, Waiting};
use alloc::boxed::Box;
use alloc::string::ToString;
use alloc::vec::Vec;
use core::net::Ipv4Addr;
use core::time::Duration;
use station::{Outbox, Time};
use wire::ethernet::Mac;
use wire::octets::Order;
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::record::{ReadRequest, WriteRequest};
use wire::profinet::dcp::{BlockError, Dcp, ServiceId, ServiceType, Value};
use wire::profinet::rpc::{Entry, LookupHandle, LookupRequest, LookupResponse, ObjectUuid, Opnum, Uuid};
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
pub(super) enum Job {
    /// Collects answers to Identify.
    Identify { xid: u32, until: Time, seen: Vec<StationSeen> },
    /// Waits for the answer to a DCP request.
    Dcp { to: Mac, service: ServiceId, xid: u32, since: Time },
    /// Collects the owners of an address.
    Arp { target: Ipv4Addr, until: Time, owners: Vec<Mac> },
    /// Starts up an AR.
    StartUp(Box<StartUpJob>),
    /// Reads a record.
    Read(ReadRequest),
    /// Writes a record.
    Write(WriteRequest),
    /// Writes several records.
    WriteMultiple(WriteRequest, usize),
    /// Writes a base mode request and reads its answer.
    Parameter(Parameter),
    /// Queries an endpoint mapper.
    Lookup(Lookup),
    /// Releases the AR of these names.
    Release(ArNames),
    /// Requests a web page.
    Page,
}

/// A base mode request.
#[derive(Debug)]
pub(super) struct Parameter {
    at: Target,
    /// The reference of the request; an empty request has none.
    reference: Option<u8>,
    phase: Phase,
}

/// The phase of a base mode request.
#[derive(Debug)]
enum Phase {
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
    callee: Callee,
    entries: Vec<Entry>,
}

impl Job {
    /// The AR state while this job runs, if the job determines it.
    pub(super) fn state(&self) -> Option<ArState> {
        match self {
            Job::StartUp(job) => Some(ArState::Starting(job.stage())),
            Job::Release(_) => Some(ArState::Releasing),
            _ => None,
        }
    }

    /// When it has something to do; the call has its own deadline.
    pub(super) fn deadline(&self) -> Option<Time> {
        match self {
            Job::Identify { until, .. } | Job::Arp { until, .. } => Some(*until),
            Job::Dcp { since, .. } => Some(*since + DCP_WAIT),
            Job::StartUp(job) => job.deadline(),
            Job::Parameter(Parameter { phase: Phase::Pause { until, .. }, .. }) => Some(*until),
            Job::Parameter(_)
            | Job::Read(_)
            | Job::Write(_)
            | Job::WriteMultiple(..)
            | Job::Lookup(_)
            | Job::Release(_)
            | Job::Page => None,
        }
    }

    /// Processes an event; returns the outcome at the end.
    pub(super) fn event(
        &mut self,
        context: &mut Context,
        now: Time,
        event: Event,
        out: &mut Outbox,
    ) -> Option<Outcome> {
        match (self, event) {
            (Job::StartUp(job), event) => job.event(context, now, event, out),
            (Job::Parameter(job), event) => job.event(context, now, event, out).map(Outcome::Parameter),
            (Job::Identify { xid, seen, .. }, Event::Dcp(from, dcp)) if is_identification(&dcp, *xid) => {
                let station = StationSeen::of(from, &dcp);
                if !seen.contains(&station) {
                    seen.push(station);
                }
                None
            }
            (Job::Identify { until, seen, .. }, Event::Wake) if now >= *until => {
                Some(Outcome::Stations(core::mem::take(seen)))
            }
            (Job::Arp { target, owners, .. }, Event::Arp(arp)) if arp.sender_ip == *target => {
                if !owners.contains(&arp.sender_mac) {
                    owners.push(arp.sender_mac);
                }
                None
            }
            (Job::Arp { until, owners, .. }, Event::Wake) if now >= *until => {
                Some(Outcome::Owners(core::mem::take(owners)))
            }
            (Job::Dcp { to, service, xid, .. }, Event::Dcp(from, dcp))
                if from == *to && answers(&dcp, *service, *xid) =>
            {
                Some(Outcome::Dcp(dcp_outcome(&dcp)))
            }
            (Job::Dcp { service, since, .. }, Event::Wake) if now >= *since + DCP_WAIT => {
                let what = if *service == ServiceId::GET { Waiting::StationGet } else { Waiting::StationSet };
                Some(Outcome::Dcp(DcpOutcome::NoAnswer(Wait { what, time: DCP_WAIT })))
            }
            (Job::Read(request), Event::Answer(answer)) => Some(Outcome::Record(match blocks(answer) {
                Ok(blocks) => record::read_answer(request, &blocks),
                Err(refusal) => refusal.into(),
            })),
            (Job::Write(request), Event::Answer(answer)) => Some(Outcome::Record(match blocks(answer) {
                Ok(blocks) => record::write_answer(request, &blocks),
                Err(refusal) => refusal.into(),
            })),
            (Job::WriteMultiple(request, count), Event::Answer(answer)) => {
                Some(Outcome::Records(match blocks(answer) {
                    Ok(blocks) => record::write_multiple_answer(request, *count, &blocks),
                    Err(refusal) => (0..*count).map(|_| refusal.clone().into()).collect(),
                }))
            }
            (Job::Lookup(job), Event::Answer(answer)) => job.answer(context, now, answer, out).map(Outcome::Endpoints),
            (Job::Release(names), Event::Answer(answer)) => {
                Some(Outcome::Ended(Ended::Released(control_outcome(answer, *names, BlockType::RELEASE_RES))))
            }
            (Job::Page, Event::Page(outcome)) => Some(Outcome::Page(outcome)),
            // A call that outlived the AR did not belong to it.
            (Job::Read(_) | Job::Write(_), Event::Ended(_)) if context.call.is_none() => {
                Some(Outcome::Record(RecordOutcome::Failed(CallError::ArEnded)))
            }
            (Job::WriteMultiple(_, count), Event::Ended(_)) => {
                Some(Outcome::Records((0..*count).map(|_| RecordOutcome::Failed(CallError::ArEnded)).collect()))
            }
            _ => None,
        }
    }
}

/// The outcome in an answer to Get or Set.
fn dcp_outcome(dcp: &Dcp) -> DcpOutcome {
    if dcp.service_type == ServiceType::NOT_SUPPORTED {
        return DcpOutcome::NotSupported;
    }
    if dcp.service_id == ServiceId::GET {
        return DcpOutcome::Values(dcp.blocks().to_vec());
    }
    let refused: Vec<_> = dcp
        .blocks()
        .iter()
        .filter_map(|block| match block.value {
            Value::Response { element, error } if error != BlockError::OK => Some((element, error)),
            _ => None,
        })
        .collect();
    if refused.is_empty() { DcpOutcome::Accepted } else { DcpOutcome::Refused(refused) }
}

/// Begins to read a record of the AR.
pub(super) fn read(
    context: &mut Context,
    now: Time,
    target: Target,
    length: u32,
    out: &mut Outbox,
) -> Option<ReadRequest> {
    let (uuid, number) = context.record_numbers(1)?;
    let request = record::read(uuid, number, target, length);
    let mut blocks = Vec::new();
    request.write(&mut blocks);
    let maximum = ARGS_MAXIMUM.max(length.saturating_add(record::READ_OVERHEAD));
    context.call_ar(now, Waiting::Read, Opnum::READ, maximum, &blocks, out);
    Some(request)
}

/// Begins to read a record without an AR.
pub(super) fn read_implicit(
    context: &mut Context,
    now: Time,
    (partner, object): (Partner, ObjectUuid),
    (target, length): (Target, u32),
    out: &mut Outbox,
) -> ReadRequest {
    let request = record::read(Uuid::NIL, 0, target, length);
    let mut blocks = Vec::new();
    request.write(&mut blocks);
    let callee = Callee {
        partner,
        object: object.into(),
        interface: Uuid::DEVICE_INTERFACE,
        interface_version: 1,
        activity: context.ids.uuid(),
        sequence: 0,
        opnum: Opnum::READ_IMPLICIT,
        order: Order::Big,
    };
    let maximum = ARGS_MAXIMUM.max(length.saturating_add(record::READ_OVERHEAD));
    let body = wire::profinet::rpc::NdrRequest::body(Order::Big, maximum, &blocks);
    context.call(now, Waiting::ReadImplicit, callee, &body, out);
    request
}

/// Begins to release the AR: cyclic data and alarms stop, only the call continues.
pub(super) fn release(context: &mut Context, now: Time, out: &mut Outbox) -> Option<ArNames> {
    let names = context.ar.as_ref()?.names;
    send_control(context, now, Waiting::Release, out);
    context.ar = None;
    Some(names)
}

impl Parameter {
    /// Writes the request; `None` without an AR.
    pub(super) fn begin(
        context: &mut Context,
        now: Time,
        at: Target,
        request: Vec<u8>,
        out: &mut Outbox,
    ) -> Option<Parameter> {
        let (uuid, number) = context.record_numbers(1)?;
        let reference = request.first().copied();
        let request = record::write(uuid, number, at, request);
        send_write(context, now, &request, out);
        Some(Parameter { at, reference, phase: Phase::Write(request) })
    }

    fn event(&mut self, context: &mut Context, now: Time, event: Event, out: &mut Outbox) -> Option<ParameterOutcome> {
        match (&self.phase, event) {
            (_, Event::Ended(_)) => Some(ParameterOutcome::Failed(CallError::ArEnded)),
            (Phase::Write(request), Event::Answer(answer)) => {
                match blocks(answer).map(|blocks| record::write_answer(request, &blocks)) {
                    Ok(RecordOutcome::Accepted { .. }) => self.read(context, now, now, out),
                    Ok(RecordOutcome::Refused(status)) | Err(Refusal::Status(status)) => {
                        Some(ParameterOutcome::WriteRefused(status))
                    }
                    Ok(RecordOutcome::Failed(error)) | Err(Refusal::Call(error)) => {
                        Some(ParameterOutcome::Failed(error))
                    }
                }
            }
            (&Phase::Read(ref request, since), Event::Answer(answer)) => {
                match blocks(answer).map(|blocks| record::read_answer(request, &blocks)) {
                    Ok(RecordOutcome::Accepted { data }) if data.is_empty() => self.not_yet(now, since, PnioStatus::OK),
                    Ok(RecordOutcome::Accepted { data }) => Some(self.compared(data)),
                    Ok(RecordOutcome::Refused(status)) | Err(Refusal::Status(status)) => {
                        if status.record_error() == Some(RecordError::STATE_CONFLICT) {
                            self.not_yet(now, since, status)
                        } else {
                            Some(ParameterOutcome::ReadRefused(status))
                        }
                    }
                    Ok(RecordOutcome::Failed(error)) | Err(Refusal::Call(error)) => {
                        Some(ParameterOutcome::Failed(error))
                    }
                }
            }
            (&Phase::Pause { since, until }, Event::Wake) if now >= until => self.read(context, now, since, out),
            _ => None,
        }
    }

    fn read(&mut self, context: &mut Context, now: Time, since: Time, out: &mut Outbox) -> Option<ParameterOutcome> {
        match read(context, now, self.at, PARAMETER_LENGTH, out) {
            Some(request) => {
                self.phase = Phase::Read(request, since);
                None
            }
            None => Some(ParameterOutcome::Failed(CallError::ArEnded)),
        }
    }

    /// Reads again after a pause, or gives up.
    fn not_yet(&mut self, now: Time, since: Time, status: PnioStatus) -> Option<ParameterOutcome> {
        let until = now + PARAMETER_PAUSE;
        if until.since(since) >= PARAMETER_WAIT {
            let wait = Wait { what: Waiting::ParameterAnswer, time: now.since(since) };
            return Some(ParameterOutcome::NotReady(status, wait));
        }
        self.phase = Phase::Pause { since, until };
        None
    }

    fn compared(&self, answer: Vec<u8>) -> ParameterOutcome {
        match self.reference {
            Some(sent) if answer.first() != Some(&sent) => ParameterOutcome::OtherReference { sent, answer },
            _ => ParameterOutcome::Answer(answer),
        }
    }
}

impl Lookup {
    /// Requests the first entry.
    pub(super) fn begin(context: &mut Context, now: Time, partner: Partner, out: &mut Outbox) -> Lookup {
        let callee = Callee {
            partner,
            object: Uuid::NIL,
            interface: Uuid::ENDPOINT_MAPPER,
            interface_version: 3,
            activity: context.ids.uuid(),
            sequence: 0,
            opnum: Opnum::EPT_LOOKUP,
            order: Order::Big,
        };
        let job = Lookup { callee, entries: Vec::new() };
        job.ask(context, now, LookupHandle::default(), out);
        job
    }

    fn ask(&self, context: &mut Context, now: Time, handle: LookupHandle, out: &mut Outbox) {
        let mut body = Vec::new();
        LookupRequest::all(handle).write(&mut body, self.callee.order);
        context.call(now, Waiting::Lookup, self.callee, &body, out);
    }

    fn answer(
        &mut self,
        context: &mut Context,
        now: Time,
        answer: Answer,
        out: &mut Outbox,
    ) -> Option<Result<Vec<Entry>, CallError>> {
        let (order, body) = match answer {
            Answer::Response(order, body) => (order, body),
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
