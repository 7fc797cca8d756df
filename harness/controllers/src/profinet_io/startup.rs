//! The start-up of an AR: search, Connect, records, PrmEnd, ApplicationReady, first valid data.
//!
//! A refused record does not end a start-up; a call without an answer does. If a start-up fails after the device has accepted the
//! Connect, the device gets an ERR-RTA.

use super::call::Answer;
use super::connect;
use super::connection::Connection;
use super::context::{ARGS_MAXIMUM, Context, Event, Refusal, blocks};
use super::exchange::Sample;
use super::layout::Layout;
use super::outcome::{
    CallError, ConnectOutcome, ControlOutcome, Failure, FailureReason, Outcome, RecordOutcome, StartUp,
};
use super::record;
use super::request::Partner;
use super::search::Search;
use super::state::{Stage, Wait, Waiting};
use alloc::boxed::Box;
use alloc::format;
use alloc::string::ToString;
use alloc::vec::Vec;
use core::time::Duration;
use station::{Outbox, Time};
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::control::{Control, ControlBlock, ControlCommand};
use wire::profinet::blocks::record::WriteRequest;
use wire::profinet::rpc::Opnum;
use wire::profinet::status::{AbortReason, CmrpcError, PnioStatus};

/// Pause before Connect is repeated to a device without a free AR.
const RESOURCES_PAUSE: Duration = Duration::from_secs(1);
/// Number of such repetitions.
const RESOURCES_REPEATS: u8 = 5;

/// A running start-up.
#[derive(Debug)]
pub(super) struct StartUpJob {
    connection: Box<Connection>,
    layout: Layout,
    result: StartUp,
    phase: Phase,
    ready: bool,
}

/// The phase of a start-up.
#[derive(Debug)]
enum Phase {
    /// The search for the device.
    Search(Search),
    /// Connect was sent.
    Connect(Partner),
    /// The device has no free AR; Connect is repeated at this time.
    Pause(Partner, Time),
    /// This record was sent.
    Record(WriteRequest),
    /// All records were sent in one call.
    WriteMultiple(WriteRequest),
    /// PrmEnd was sent.
    ParameterEnd,
    /// ApplicationReady is awaited since this time.
    ApplicationReady(Time),
    /// Valid data are awaited since this time.
    FirstData(Time),
}

impl StartUpJob {
    /// Begins a start-up; returns the outcome at once if a value is out of range.
    pub(super) fn begin(
        connection: Box<Connection>,
        context: &mut Context,
        now: Time,
        out: &mut Outbox,
    ) -> Result<Box<StartUpJob>, Outcome> {
        if !connection.unchecked
            && let Err(limit) = connection.check()
        {
            let failed = Some(Failure { stage: Stage::Check, why: FailureReason::Limit(limit) });
            return Err(Outcome::StartUp(Box::new(StartUp { failed, ..StartUp::default() })));
        }
        let search = Search::new(&connection, context, now, out);
        let layout = Layout::of(&connection.submodules);
        Ok(Box::new(StartUpJob {
            connection,
            layout,
            result: StartUp::default(),
            phase: Phase::Search(search),
            ready: false,
        }))
    }

    pub(super) fn stage(&self) -> Stage {
        match &self.phase {
            Phase::Search(search) => search.stage(),
            Phase::Connect(_) | Phase::Pause(..) => Stage::Connect,
            Phase::Record(_) | Phase::WriteMultiple(_) => Stage::Records,
            Phase::ParameterEnd => Stage::ParameterEnd,
            Phase::ApplicationReady(_) => Stage::ApplicationReady,
            Phase::FirstData(_) => Stage::FirstData,
        }
    }

    pub(super) fn deadline(&self) -> Option<Time> {
        match &self.phase {
            Phase::Search(search) => Some(search.deadline()),
            Phase::Pause(_, until) => Some(*until),
            Phase::ApplicationReady(since) => Some(*since + self.connection.application_ready),
            Phase::FirstData(since) => Some(*since + self.connection.first_data),
            Phase::Connect(_) | Phase::Record(_) | Phase::WriteMultiple(_) | Phase::ParameterEnd => None,
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
        match (&mut self.phase, event) {
            (_, Event::Ended(end)) => self.fail(context, FailureReason::Ended(end), out),
            (Phase::Search(search), event) => match search.event(context, now, &event, &mut self.result, out) {
                Ok(Some(partner)) => self.connect(context, now, partner, out),
                Ok(None) => None,
                Err(failure) => self.end(Some(failure)),
            },
            (Phase::Pause(partner, until), Event::Wake) if now >= *until => {
                let partner = *partner;
                self.connect(context, now, partner, out)
            }
            (Phase::Connect(partner), Event::Answer(answer)) => {
                let partner = *partner;
                self.connected(context, now, partner, answer, out)
            }
            (Phase::Record(request), Event::Answer(answer)) => {
                let outcome = match blocks(answer) {
                    Ok(blocks) => record::write_answer(request, &blocks),
                    Err(refusal) => refusal.into(),
                };
                self.recorded(context, now, [outcome].into(), out)
            }
            (Phase::WriteMultiple(request), Event::Answer(answer)) => {
                let count = self.connection.records.len();
                let outcomes = match blocks(answer) {
                    Ok(blocks) => record::write_multiple_answer(request, count, &blocks),
                    Err(refusal) => (0..count).map(|_| refusal.clone().into()).collect(),
                };
                self.recorded(context, now, outcomes, out)
            }
            (Phase::ParameterEnd, Event::Answer(answer)) => self.parameter_ended(context, now, answer, out),
            (_, Event::Ready(diff)) => {
                self.result.module_diff = diff.or(self.result.module_diff.take());
                self.ready = true;
                if let Phase::ApplicationReady(_) = self.phase { self.is_ready(now) } else { None }
            }
            (Phase::ApplicationReady(since), Event::Wake) if now >= *since + self.connection.application_ready => {
                let time = now.since(*since);
                self.result.application_ready = Some(false);
                self.fail(context, FailureReason::Waited(Wait { what: Waiting::ApplicationReady, time }), out)
            }
            (Phase::FirstData(_), Event::Sample(Sample::Good)) => {
                self.result.first_data = Some(true);
                self.end(None)
            }
            (Phase::FirstData(since), Event::Wake) if now >= *since + self.connection.first_data => {
                let time = now.since(*since);
                self.result.first_data = Some(false);
                self.result.standing = true;
                let why = FailureReason::Waited(Wait { what: Waiting::FirstData, time });
                self.end(Some(Failure { stage: Stage::FirstData, why }))
            }
            _ => None,
        }
    }

    fn connect(&mut self, context: &mut Context, now: Time, partner: Partner, out: &mut Outbox) -> Option<Outcome> {
        self.result.partner = Some(partner);
        self.phase = Phase::Connect(partner);
        context.begin_ar(&self.connection, partner);
        if let Some(ar) = &context.ar {
            let blocks = connect::request(&self.connection, &self.layout, ar.names, &context.settings);
            // The array of the answer is never declared shorter than that of the request.
            let maximum = self.connection.args_maximum.unwrap_or(ARGS_MAXIMUM).max(blocks.len() as u32);
            context.call_ar(now, Waiting::Connect, Opnum::CONNECT, maximum, &blocks, out);
        }
        None
    }

    fn connected(
        &mut self,
        context: &mut Context,
        now: Time,
        partner: Partner,
        answer: Answer,
        out: &mut Outbox,
    ) -> Option<Outcome> {
        let opened = blocks(answer).and_then(|blocks| {
            let names = context.ar.as_ref().map(|ar| ar.names).ok_or(Refusal::Call(CallError::ArEnded))?;
            connect::accept(&self.connection, names, partner.mac, &blocks)
                .map_err(|why| Refusal::Call(CallError::Unfit(why)))
        });
        match opened {
            Ok(opened) => {
                self.result.connect = Some(ConnectOutcome::Accepted);
                if let Some(data) = opened.data {
                    context.open_ar(&self.connection, &self.layout, data, now);
                }
                if let Some(diff) = &opened.module_diff {
                    context.heed(diff);
                }
                self.result.module_diff = opened.module_diff;
                if self.connection.has_data() { self.records(context, now, out) } else { self.end(None) }
            }
            Err(Refusal::Status(status)) if is_out_of_resources(status) && self.may_repeat() => {
                context.drop_ar();
                self.result.connect_repeats += 1;
                self.phase = Phase::Pause(partner, now + RESOURCES_PAUSE);
                None
            }
            Err(refusal) => {
                self.result.connect = Some(match &refusal {
                    Refusal::Status(status) => ConnectOutcome::Refused(*status),
                    Refusal::Call(error) => ConnectOutcome::Failed(error.clone()),
                });
                self.fail(context, refusal.into(), out)
            }
        }
    }

    fn may_repeat(&self) -> bool {
        self.result.connect_repeats < RESOURCES_REPEATS
    }

    fn records(&mut self, context: &mut Context, now: Time, out: &mut Outbox) -> Option<Outcome> {
        let records = &self.connection.records;
        let done = self.result.records.len();
        if self.connection.write_multiple && done == 0 && !records.is_empty() {
            let (uuid, number) = context.record_numbers(records.len() as u16 + 1)?;
            let request = record::write_multiple(uuid, number, records);
            send_write(context, now, &request, out);
            self.phase = Phase::WriteMultiple(request);
        } else if let Some(next) = records.get(done) {
            let (uuid, number) = context.record_numbers(1)?;
            let request = record::write(uuid, number, next.target, next.data.clone());
            send_write(context, now, &request, out);
            self.phase = Phase::Record(request);
        } else {
            send_control(context, now, Waiting::ParameterEnd, out);
            self.phase = Phase::ParameterEnd;
        }
        None
    }

    fn recorded(
        &mut self,
        context: &mut Context,
        now: Time,
        outcomes: Vec<RecordOutcome>,
        out: &mut Outbox,
    ) -> Option<Outcome> {
        let silent = outcomes.iter().find_map(|outcome| match outcome {
            RecordOutcome::Failed(error @ CallError::NoAnswer(_)) => Some(error.clone()),
            _ => None,
        });
        self.result.records.extend(outcomes);
        match silent {
            Some(error) => self.fail(context, FailureReason::Call(error), out),
            None => self.records(context, now, out),
        }
    }

    fn parameter_ended(
        &mut self,
        context: &mut Context,
        now: Time,
        answer: Answer,
        out: &mut Outbox,
    ) -> Option<Outcome> {
        let outcome =
            context.ar.as_ref().map(|ar| ar.names).map_or(ControlOutcome::Failed(CallError::ArEnded), |names| {
                control_outcome(answer, names, BlockType::PRM_END_RES)
            });
        self.result.parameter_end = Some(outcome.clone());
        match outcome {
            ControlOutcome::Accepted if self.ready => self.is_ready(now),
            ControlOutcome::Accepted => {
                self.phase = Phase::ApplicationReady(now);
                None
            }
            ControlOutcome::Refused(status) => self.fail(context, FailureReason::Refused(status), out),
            ControlOutcome::Failed(error) => self.fail(context, FailureReason::Call(error), out),
        }
    }

    fn is_ready(&mut self, now: Time) -> Option<Outcome> {
        self.result.application_ready = Some(true);
        self.phase = Phase::FirstData(now);
        None
    }

    /// Ends the start-up and, if the device knows it, the AR.
    fn fail(&mut self, context: &mut Context, why: FailureReason, out: &mut Outbox) -> Option<Outcome> {
        let stage = self.stage();
        let reason = match stage {
            Stage::Check | Stage::Identify | Stage::Address | Stage::Resolve => AbortReason::NAME_RESOLUTION,
            Stage::Connect => AbortReason::RPC_CONNECT,
            Stage::Records => AbortReason::RPC_WRITE,
            Stage::ParameterEnd => AbortReason::RPC_CONTROL,
            Stage::ApplicationReady => AbortReason::APPLICATION_READY_TIMEOUT,
            Stage::FirstData => AbortReason::CONSUMER_TIMEOUT,
        };
        context.abort(reason, out);
        self.end(Some(Failure { stage, why }))
    }

    fn end(&mut self, failed: Option<Failure>) -> Option<Outcome> {
        let mut result = Box::new(core::mem::take(&mut self.result));
        result.standing |= failed.is_none();
        result.failed = failed;
        Some(Outcome::StartUp(result))
    }
}

fn is_out_of_resources(status: PnioStatus) -> bool {
    status.cmrpc_error() == Some(CmrpcError::OUT_OF_AR_RESOURCES)
}

/// Sends a Write in the AR.
pub(super) fn send_write(context: &mut Context, now: Time, request: &WriteRequest, out: &mut Outbox) {
    let mut blocks = Vec::new();
    request.write(&mut blocks);
    context.call_ar(now, Waiting::Write, Opnum::WRITE, ARGS_MAXIMUM.max(blocks.len() as u32), &blocks, out);
}

/// Sends PrmEnd or Release in the AR.
pub(super) fn send_control(context: &mut Context, now: Time, what: Waiting, out: &mut Outbox) {
    let Some(ar) = &mut context.ar else { return };
    let names = ar.names;
    let (block, opnum) = if what == Waiting::Release {
        (ControlBlock::release(names.uuid, names.session_key), Opnum::RELEASE)
    } else {
        ar.prm_end_sent = true;
        (ControlBlock::prm_end(names.uuid, names.session_key), Opnum::CONTROL)
    };
    context.call_ar(now, what, opnum, ARGS_MAXIMUM, &Control::from(block).to_vec(), out);
}

/// The outcome of a control call: the answer must be a block `kind` about the AR `names` with ControlCommand Done.
pub(super) fn control_outcome(answer: Answer, names: connect::ArNames, kind: BlockType) -> ControlOutcome {
    let blocks = match blocks(answer) {
        Ok(blocks) => blocks,
        Err(Refusal::Status(status)) => return ControlOutcome::Refused(status),
        Err(Refusal::Call(error)) => return ControlOutcome::Failed(error),
    };
    let unfit = |why| ControlOutcome::Failed(CallError::Unfit(why));
    match Control::parse(&blocks) {
        Err(error) => unfit(error.to_string()),
        Ok(Control { block, .. }) if block.header.kind != kind => {
            unfit(format!("BlockType is {:#06x}", block.header.kind.0))
        }
        Ok(Control { block, .. }) if (block.ar_uuid, block.session_key) != (names.uuid, names.session_key) => {
            unfit(format!("the block is about AR {} in session {}", block.ar_uuid, block.session_key))
        }
        Ok(Control { block, .. }) if !block.control_command.has(ControlCommand::DONE) => {
            unfit(format!("ControlCommand is {:#06x}", block.control_command.0))
        }
        Ok(_) => ControlOutcome::Accepted,
    }
}

impl From<Refusal> for RecordOutcome {
    fn from(refusal: Refusal) -> RecordOutcome {
        match refusal {
            Refusal::Status(status) => RecordOutcome::Refused(status),
            Refusal::Call(error) => RecordOutcome::Failed(error),
        }
    }
}

impl From<Refusal> for FailureReason {
    fn from(refusal: Refusal) -> FailureReason {
        match refusal {
            Refusal::Status(status) => FailureReason::Refused(status),
            Refusal::Call(error) => FailureReason::Call(error),
        }
    }
}
