//! The start-up of an AR: search, Connect, records, PrmEnd, ApplicationReady, first valid data.
//!
//! A refused record does not end a start-up; a call without an answer does. If a start-up fails after the device has accepted the
//! Connect, the device gets an ERR-RTA.

use super::call::RpcCallResult;
use super::connect;
use super::connection::{ArConfig, StartUpRecord};
use super::context::{ARGS_MAXIMUM, CallRefusal, ControllerContext, JobEvent, blocks};
use super::exchange::InputSample;
use super::layout::Layout;
use super::outcome::{
    ArFailureReason, ArStartUpFailure, ArStartUpResult, CallError, ConnectOutcome, ControlOutcome, ControllerOutcome,
    IoRecordOutcome,
};
use super::record;
use super::request::Partner;
use super::search::DeviceSearch;
use super::state::{ArStartUpStage, AwaitedEvent, Wait};
use alloc::boxed::Box;
use alloc::format;
use alloc::string::ToString;
use alloc::vec::Vec;
use core::time::Duration;
use station::{Outbox, Time};
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::control::{ControlBlock, ControlBlocks, ControlCommand};
use wire::profinet::blocks::record::WriteRequest;
use wire::profinet::rpc::Opnum;
use wire::profinet::status::{AbortReason, CmrpcError, PnioStatus};

/// Pause before Connect is repeated to a device without a free AR.
const RESOURCES_PAUSE: Duration = Duration::from_secs(1);
/// Number of such repetitions.
const RESOURCES_REPEATS: u8 = 5;

/// A running start-up.
#[derive(Debug)]
pub(super) struct ArStartUpJob {
    connection: Box<ArConfig>,
    layout: Layout,
    result: ArStartUpResult,
    phase: ArStartUpPhase,
    ready: bool,
}

/// The phase of a start-up.
#[derive(Debug)]
enum ArStartUpPhase {
    /// The search for the device.
    Search(DeviceSearch),
    /// Connect was sent.
    Connect(Partner),
    /// The device has no free AR; Connect is repeated at this time.
    Pause(Partner, Time),
    /// This record was sent.
    Record(WriteRequest),
    /// All records were sent in one call.
    WriteMultiple(WriteRequest),
    /// PrmEnd is sent at this time.
    ParameterPause(Time),
    /// PrmEnd was sent.
    ParameterEnd,
    /// ApplicationReady is awaited since this time.
    ApplicationReady(Time),
    /// Valid data are awaited since this time.
    FirstData(Time),
}

impl ArStartUpJob {
    /// Begins a start-up; returns the outcome at once if a value is out of range.
    pub(super) fn begin(
        connection: Box<ArConfig>,
        context: &mut ControllerContext,
        now: Time,
        out: &mut Outbox,
    ) -> Result<Box<ArStartUpJob>, ControllerOutcome> {
        if !connection.unchecked
            && let Err(limit) = connection.check()
        {
            let failed = Some(ArStartUpFailure { stage: ArStartUpStage::Check, why: ArFailureReason::Limit(limit) });
            return Err(ControllerOutcome::StartUp(Box::new(ArStartUpResult { failed, ..ArStartUpResult::default() })));
        }
        let search = DeviceSearch::new(&connection, context, now, out);
        let layout = Layout::of(&connection.submodules);
        Ok(Box::new(ArStartUpJob {
            connection,
            layout,
            result: ArStartUpResult::default(),
            phase: ArStartUpPhase::Search(search),
            ready: false,
        }))
    }

    pub(super) fn stage(&self) -> ArStartUpStage {
        match &self.phase {
            ArStartUpPhase::Search(search) => search.stage(),
            ArStartUpPhase::Connect(_) | ArStartUpPhase::Pause(..) => ArStartUpStage::Connect,
            ArStartUpPhase::Record(_) | ArStartUpPhase::WriteMultiple(_) => ArStartUpStage::Records,
            ArStartUpPhase::ParameterPause(_) | ArStartUpPhase::ParameterEnd => ArStartUpStage::ParameterEnd,
            ArStartUpPhase::ApplicationReady(_) => ArStartUpStage::ApplicationReady,
            ArStartUpPhase::FirstData(_) => ArStartUpStage::FirstData,
        }
    }

    pub(super) fn deadline(&self) -> Option<Time> {
        match &self.phase {
            ArStartUpPhase::Search(search) => Some(search.deadline()),
            ArStartUpPhase::Pause(_, until) | ArStartUpPhase::ParameterPause(until) => Some(*until),
            ArStartUpPhase::ApplicationReady(since) => Some(*since + self.connection.application_ready),
            ArStartUpPhase::FirstData(since) => Some(*since + self.connection.first_data),
            ArStartUpPhase::Connect(_)
            | ArStartUpPhase::Record(_)
            | ArStartUpPhase::WriteMultiple(_)
            | ArStartUpPhase::ParameterEnd => None,
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
        match (&mut self.phase, event) {
            (_, JobEvent::Ended(end)) => self.fail(context, now, ArFailureReason::Ended(end), out),
            (ArStartUpPhase::Search(search), event) => {
                match search.event(context, now, &event, &mut self.result, out) {
                    Ok(Some(partner)) => self.connect(context, now, partner, out),
                    Ok(None) => None,
                    Err(failure) => self.end(Some(failure)),
                }
            }
            (ArStartUpPhase::Pause(partner, until), JobEvent::Wake) if now >= *until => {
                let partner = *partner;
                self.connect(context, now, partner, out)
            }
            (ArStartUpPhase::Connect(partner), JobEvent::Answer(answer)) => {
                let partner = *partner;
                self.connected(context, now, partner, answer, out)
            }
            (ArStartUpPhase::Record(request), JobEvent::Answer(answer)) => {
                let outcome = match blocks(answer) {
                    Ok(blocks) => record::write_answer(request, &blocks),
                    Err(refusal) => refusal.into(),
                };
                self.recorded(context, now, [outcome].into(), out)
            }
            (ArStartUpPhase::WriteMultiple(request), JobEvent::Answer(answer)) => {
                let count = self.connection.records.len();
                let outcomes = match blocks(answer) {
                    Ok(blocks) => record::write_multiple_answer(request, count, &blocks),
                    Err(refusal) => (0..count).map(|_| refusal.clone().into()).collect(),
                };
                self.recorded(context, now, outcomes, out)
            }
            (ArStartUpPhase::ParameterPause(until), JobEvent::Wake) if now >= *until => {
                self.end_parameters(context, now, out);
                None
            }
            (ArStartUpPhase::ParameterEnd, JobEvent::Answer(answer)) => self.parameter_ended(context, now, answer, out),
            (_, JobEvent::Ready(diff)) => {
                self.result.module_diff = diff.or(self.result.module_diff.take());
                self.ready = true;
                if let ArStartUpPhase::ApplicationReady(_) = self.phase { self.is_ready(now) } else { None }
            }
            (ArStartUpPhase::ApplicationReady(since), JobEvent::Wake)
                if now >= *since + self.connection.application_ready =>
            {
                let time = now.since(*since);
                self.result.application_ready = Some(false);
                self.fail(
                    context,
                    now,
                    ArFailureReason::Waited(Wait { what: AwaitedEvent::ApplicationReady, time }),
                    out,
                )
            }
            (ArStartUpPhase::FirstData(_), JobEvent::Sample(InputSample::Good)) => {
                self.result.first_data = Some(true);
                self.end(None)
            }
            (ArStartUpPhase::FirstData(since), JobEvent::Wake) if now >= *since + self.connection.first_data => {
                let time = now.since(*since);
                self.result.first_data = Some(false);
                self.result.standing = true;
                let why = ArFailureReason::Waited(Wait { what: AwaitedEvent::FirstData, time });
                self.end(Some(ArStartUpFailure { stage: ArStartUpStage::FirstData, why }))
            }
            _ => None,
        }
    }

    fn connect(
        &mut self,
        context: &mut ControllerContext,
        now: Time,
        partner: Partner,
        out: &mut Outbox,
    ) -> Option<ControllerOutcome> {
        self.result.partner = Some(partner);
        self.phase = ArStartUpPhase::Connect(partner);
        context.begin_ar(&self.connection, partner);
        if let Some(ar) = &context.ar {
            let blocks = connect::request(&self.connection, &self.layout, ar.names, &context.settings);
            // The array of the answer is never declared shorter than that of the request.
            let maximum = self.connection.args_maximum.unwrap_or(ARGS_MAXIMUM).max(blocks.len() as u32);
            context.call_ar(now, AwaitedEvent::Connect, Opnum::CONNECT, maximum, &blocks, out);
        }
        None
    }

    fn connected(
        &mut self,
        context: &mut ControllerContext,
        now: Time,
        partner: Partner,
        answer: RpcCallResult,
        out: &mut Outbox,
    ) -> Option<ControllerOutcome> {
        let opened = blocks(answer).and_then(|blocks| {
            let names = context.ar.as_ref().map(|ar| ar.names).ok_or(CallRefusal::Call(CallError::ArEnded))?;
            connect::accept(&self.connection, names, partner.mac, &blocks)
                .map_err(|why| CallRefusal::Call(CallError::Unfit(why)))
        });
        match opened {
            Ok(opened) => {
                self.result.connect = Some(ConnectOutcome::Accepted);
                if let Some(data) = opened.data {
                    context.open_ar(&self.connection, &self.layout, data, now);
                }
                if let Some(diff) = &opened.module_diff {
                    context.exclude_improper(diff);
                    // What another controller owns is its to parametrize.
                    let is_own = |of: &StartUpRecord| !connect::is_locked(diff, of.target.slot, of.target.subslot);
                    self.connection.records.retain(is_own);
                }
                self.result.module_diff = opened.module_diff;
                if self.connection.has_data() { self.records(context, now, out) } else { self.end(None) }
            }
            Err(CallRefusal::Status(status)) if is_out_of_resources(status) && self.may_repeat() => {
                context.drop_ar();
                self.result.connect_repeats += 1;
                self.phase = ArStartUpPhase::Pause(partner, now + RESOURCES_PAUSE);
                None
            }
            Err(refusal) => {
                self.result.connect = Some(match &refusal {
                    CallRefusal::Status(status) => ConnectOutcome::Refused(*status),
                    CallRefusal::Call(error) => ConnectOutcome::Failed(error.clone()),
                });
                self.fail(context, now, refusal.into(), out)
            }
        }
    }

    fn may_repeat(&self) -> bool {
        self.connection.repeats && self.result.connect_repeats < RESOURCES_REPEATS
    }

    fn records(&mut self, context: &mut ControllerContext, now: Time, out: &mut Outbox) -> Option<ControllerOutcome> {
        let records = &self.connection.records;
        let done = self.result.records.len();
        if self.connection.write_multiple && done == 0 && !records.is_empty() {
            let (uuid, number) = context.record_numbers(records.len() as u16 + 1)?;
            let request = record::write_multiple(uuid, number, records);
            send_write(context, now, &request, out);
            self.phase = ArStartUpPhase::WriteMultiple(request);
        } else if let Some(next) = records.get(done) {
            let (uuid, number) = context.record_numbers(1)?;
            let request = record::write(uuid, number, next.target, next.data.clone());
            send_write(context, now, &request, out);
            self.phase = ArStartUpPhase::Record(request);
        } else if self.connection.parameter_pause.is_zero() {
            self.end_parameters(context, now, out);
        } else {
            self.phase = ArStartUpPhase::ParameterPause(now + self.connection.parameter_pause);
        }
        None
    }

    fn end_parameters(&mut self, context: &mut ControllerContext, now: Time, out: &mut Outbox) {
        send_control(context, now, AwaitedEvent::ParameterEnd, out);
        self.phase = ArStartUpPhase::ParameterEnd;
    }

    fn recorded(
        &mut self,
        context: &mut ControllerContext,
        now: Time,
        outcomes: Vec<IoRecordOutcome>,
        out: &mut Outbox,
    ) -> Option<ControllerOutcome> {
        let silent = outcomes.iter().find_map(|outcome| match outcome {
            IoRecordOutcome::Failed(error @ CallError::NoAnswer(_)) => Some(error.clone()),
            _ => None,
        });
        self.result.records.extend(outcomes);
        match silent {
            Some(error) => self.fail(context, now, ArFailureReason::Call(error), out),
            None => self.records(context, now, out),
        }
    }

    fn parameter_ended(
        &mut self,
        context: &mut ControllerContext,
        now: Time,
        answer: RpcCallResult,
        out: &mut Outbox,
    ) -> Option<ControllerOutcome> {
        let outcome =
            context.ar.as_ref().map(|ar| ar.names).map_or(ControlOutcome::Failed(CallError::ArEnded), |names| {
                control_outcome(answer, names, BlockType::PRM_END_RES)
            });
        self.result.parameter_end = Some(outcome.clone());
        match outcome {
            ControlOutcome::Accepted if self.ready => self.is_ready(now),
            ControlOutcome::Accepted => {
                self.phase = ArStartUpPhase::ApplicationReady(now);
                None
            }
            ControlOutcome::Refused(status) => self.fail(context, now, ArFailureReason::Refused(status), out),
            ControlOutcome::Failed(error) => self.fail(context, now, ArFailureReason::Call(error), out),
        }
    }

    fn is_ready(&mut self, now: Time) -> Option<ControllerOutcome> {
        self.result.application_ready = Some(true);
        self.phase = ArStartUpPhase::FirstData(now);
        None
    }

    /// Ends the start-up and, if the device knows it, the AR.
    fn fail(
        &mut self,
        context: &mut ControllerContext,
        now: Time,
        why: ArFailureReason,
        out: &mut Outbox,
    ) -> Option<ControllerOutcome> {
        let stage = self.stage();
        let is_unfit = matches!(self.result.connect, Some(ConnectOutcome::Failed(CallError::Unfit(_))));
        if context.ar.is_some() && (is_unfit || !self.connection.replaced_fields.is_empty()) {
            // The device may have opened an AR that it cannot relate to our ERR-RTA.
            send_control(context, now, AwaitedEvent::Release, out);
        }
        let reason = match stage {
            ArStartUpStage::Check | ArStartUpStage::Identify | ArStartUpStage::Address | ArStartUpStage::Resolve => {
                AbortReason::NAME_RESOLUTION
            }
            ArStartUpStage::Connect => AbortReason::RPC_CONNECT,
            ArStartUpStage::Records => AbortReason::RPC_WRITE,
            ArStartUpStage::ParameterEnd => AbortReason::RPC_CONTROL,
            ArStartUpStage::ApplicationReady => AbortReason::APPLICATION_READY_TIMEOUT,
            ArStartUpStage::FirstData => AbortReason::CONSUMER_TIMEOUT,
        };
        context.abort(reason, out);
        self.end(Some(ArStartUpFailure { stage, why }))
    }

    fn end(&mut self, failed: Option<ArStartUpFailure>) -> Option<ControllerOutcome> {
        let mut result = Box::new(core::mem::take(&mut self.result));
        result.standing |= failed.is_none();
        result.failed = failed;
        Some(ControllerOutcome::StartUp(result))
    }
}

fn is_out_of_resources(status: PnioStatus) -> bool {
    status.cmrpc_error() == Some(CmrpcError::OUT_OF_AR_RESOURCES)
}

/// Sends a Write in the AR.
pub(super) fn send_write(context: &mut ControllerContext, now: Time, request: &WriteRequest, out: &mut Outbox) {
    let mut blocks = Vec::new();
    request.write(&mut blocks);
    context.call_ar(now, AwaitedEvent::Write, Opnum::WRITE, ARGS_MAXIMUM.max(blocks.len() as u32), &blocks, out);
}

/// Sends PrmEnd or Release in the AR.
pub(super) fn send_control(context: &mut ControllerContext, now: Time, what: AwaitedEvent, out: &mut Outbox) {
    let Some(ar) = &mut context.ar else { return };
    let names = ar.names;
    let (block, opnum) = if what == AwaitedEvent::Release {
        (ControlBlock::release(names.uuid, names.session_key), Opnum::RELEASE)
    } else {
        ar.prm_end_sent = true;
        (ControlBlock::prm_end(names.uuid, names.session_key), Opnum::CONTROL)
    };
    context.call_ar(now, what, opnum, ARGS_MAXIMUM, &ControlBlocks::from(block).to_vec(), out);
}

/// The outcome of a control call: the answer must be a block `kind` about the AR `names` with ControlCommand Done.
pub(super) fn control_outcome(answer: RpcCallResult, names: connect::ArNames, kind: BlockType) -> ControlOutcome {
    let blocks = match blocks(answer) {
        Ok(blocks) => blocks,
        Err(CallRefusal::Status(status)) => return ControlOutcome::Refused(status),
        Err(CallRefusal::Call(error)) => return ControlOutcome::Failed(error),
    };
    let unfit = |why| ControlOutcome::Failed(CallError::Unfit(why));
    match ControlBlocks::parse(&blocks) {
        Err(error) => unfit(error.to_string()),
        Ok(ControlBlocks { block, .. }) if block.header.kind != kind => {
            unfit(format!("BlockType is {:#06x}", block.header.kind.0))
        }
        Ok(ControlBlocks { block, .. }) if (block.ar_uuid, block.session_key) != (names.uuid, names.session_key) => {
            unfit(format!("the block is about AR {} in session {}", block.ar_uuid, block.session_key))
        }
        Ok(ControlBlocks { block, .. }) if !block.control_command.has(ControlCommand::DONE) => {
            unfit(format!("ControlCommand is {:#06x}", block.control_command.0))
        }
        Ok(_) => ControlOutcome::Accepted,
    }
}

impl From<CallRefusal> for IoRecordOutcome {
    fn from(refusal: CallRefusal) -> IoRecordOutcome {
        match refusal {
            CallRefusal::Status(status) => IoRecordOutcome::Refused(status),
            CallRefusal::Call(error) => IoRecordOutcome::Failed(error),
        }
    }
}

impl From<CallRefusal> for ArFailureReason {
    fn from(refusal: CallRefusal) -> ArFailureReason {
        match refusal {
            CallRefusal::Status(status) => ArFailureReason::Refused(status),
            CallRefusal::Call(error) => ArFailureReason::Call(error),
        }
    }
}
