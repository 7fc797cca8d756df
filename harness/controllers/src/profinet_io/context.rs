//! The state that all jobs of the controller share: the current call, the AR, the cyclic outputs.
//!
//! This module must not know the order of a start-up; `startup` has it.

use super::alarms::{self, AlarmAcknowledge, ControllerAlarms};
use super::call::{ControllerCall, RpcCallResult};
use super::connect::{AcceptedData, ArNames, is_improper};
use super::connect_field::ConnectField;
use super::connection::ArConfig;
use super::exchange::{self, InputSample, IoExchange};
use super::http::{Browser, PageOutcome};
use super::ids::Ids;
use super::layout::Layout;
use super::outcome::{ArEnd, CallError};
use super::ping::PingReply;
use super::plug::PluggedSubmodules;
use super::raw::RawAnswer;
use super::request::{ControllerSettings, Partner};
use super::server::{ControllerRpcServer, ServedAr, order};
use super::state::AwaitedEvent;
use crate::outputs::CyclicOutputs;
use alloc::boxed::Box;
use alloc::string::ToString;
use alloc::vec::Vec;
use station::{Outbox, Time};
use wire::datagram::arp::Arp;
use wire::ethernet::Mac;
use wire::octets::ByteOrder;
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::control::ControlBlocks;
use wire::profinet::blocks::module_diff::ModuleDiffBlock;
use wire::profinet::dcp::Dcp;
use wire::profinet::rpc::{Flags1, NdrRequest, NdrResponse, ObjectUuid, Opnum, PacketType, RpcHeader, Uuid};
use wire::profinet::status::{AbortReason, PnioStatus};
use wire::snmp::SnmpMessage;

/// Default ARArgsMaximum: maximum length of an answer in bytes.
pub(super) const ARGS_MAXIMUM: u32 = 4096;

/// An event for a job.
#[derive(Debug)]
pub(super) enum JobEvent {
    /// A wake-up; the job checks its own deadline.
    Wake,
    /// A DCP frame from this address.
    Dcp(Mac, Dcp),
    /// An ARP reply whose sender address matches its Ethernet source.
    Arp(Arp),
    /// The end of the outstanding call.
    Answer(RpcCallResult),
    /// An answer to a call whose fields the caller has given.
    Called(RawAnswer),
    /// The reply to an ICMP echo request.
    Echoed(PingReply),
    /// The response to an SNMP request.
    Managed(SnmpMessage),
    /// ApplicationReady came and was answered; how the modules differ, if it says so.
    Ready(Option<ModuleDiffBlock>),
    /// A cyclic frame arrived.
    Sample(InputSample),
    /// The AR ended without a request of the caller and has been dropped.
    Ended(ArEnd),
    /// The outcome of a request to a web server.
    Page(PageOutcome),
}

/// The shared state of all jobs.
#[derive(Debug)]
pub(super) struct ControllerContext {
    pub(super) settings: ControllerSettings,
    pub(super) own: Partner,
    pub(super) ids: Ids,
    pub(super) outputs: CyclicOutputs,
    pub(super) server: ControllerRpcServer,
    pub(super) call: Option<ControllerCall>,
    /// Whether the current call belongs to the AR and ends with it.
    call_in_ar: bool,
    pub(super) ar: Option<ActiveAr>,
    pub(super) cycles_sent: u64,
    /// How far alarms are acknowledged.
    pub(super) alarm_acknowledge: AlarmAcknowledge,
    /// The device of the current AR or of the last one.
    pub(super) partner: Option<Partner>,
    pub(super) browser: Option<Box<Browser>>,
    /// The activity of the last call whose fields the caller has given.
    pub(super) last_activity: Option<Uuid>,
    sessions: u16,
    /// The ARUUID of the last AR that was tried.
    last_uuid: Option<Uuid>,
}

/// The AR.
#[derive(Debug)]
pub(super) struct ActiveAr {
    pub(super) names: ArNames,
    pub(super) partner: Partner,
    pub(super) object: Uuid,
    pub(super) order: ByteOrder,
    pub(super) activity: Uuid,
    sequence: u32,
    record: u16,
    /// Whether PrmEnd was sent.
    pub(super) prm_end_sent: bool,
    pub(super) exchange: Option<IoExchange>,
    pub(super) alarms: Option<ControllerAlarms>,
    pub(super) plugs: PluggedSubmodules,
}

impl ActiveAr {
    /// The device, called in the AR or beside it.
    pub(super) fn callee(&self, activity: Uuid, sequence: u32, opnum: Opnum) -> CallTarget {
        CallTarget {
            partner: self.partner,
            object: self.object,
            interface: Uuid::DEVICE_INTERFACE,
            interface_version: 1,
            activity,
            sequence,
            opnum,
            order: self.order,
        }
    }
}

/// Why a call was not answered with success.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum CallRefusal {
    /// The device refused.
    Status(PnioStatus),
    /// There is no usable answer.
    Call(CallError),
}

/// The destination of a call and the operation.
#[derive(Clone, Copy, Debug)]
pub(super) struct CallTarget {
    pub(super) partner: Partner,
    pub(super) object: Uuid,
    pub(super) interface: Uuid,
    pub(super) interface_version: u32,
    pub(super) activity: Uuid,
    pub(super) sequence: u32,
    pub(super) opnum: Opnum,
    pub(super) order: ByteOrder,
}

impl CallTarget {
    /// The header of the request.
    pub(super) fn header(&self) -> RpcHeader {
        RpcHeader {
            flags1: Flags1::IDEMPOTENT,
            object: self.object,
            interface: self.interface,
            interface_version: self.interface_version,
            activity: self.activity,
            sequence: self.sequence,
            opnum: self.opnum,
            ..RpcHeader::new(PacketType::REQUEST, self.order)
        }
    }
}

impl ControllerContext {
    pub(super) fn new(settings: ControllerSettings) -> ControllerContext {
        let own = Partner { mac: settings.mac, ip: settings.ip };
        let ids = Ids::new(settings.seed);
        let server = ControllerRpcServer::new(own);
        ControllerContext {
            settings,
            own,
            ids,
            outputs: CyclicOutputs::default(),
            server,
            call: None,
            call_in_ar: false,
            ar: None,
            cycles_sent: 0,
            alarm_acknowledge: AlarmAcknowledge::Given,
            partner: None,
            browser: None,
            last_activity: None,
            sessions: 0,
            last_uuid: None,
        }
    }

    /// Begins a new AR with `partner`; the device does not know it yet.
    pub(super) fn begin_ar(&mut self, connection: &ArConfig, partner: Partner) {
        self.sessions = self.sessions.wrapping_add(1).max(1);
        self.server.forget();
        let new = self.ids.uuid();
        let uuid = if connection.same_uuid { self.last_uuid.unwrap_or(new) } else { new };
        let uuid = ConnectField::ar_uuid(&connection.replaced_fields).unwrap_or(uuid);
        self.last_uuid = Some(uuid);
        let alarm_reference = connection.alarm_reference.unwrap_or(self.sessions);
        let names = ArNames { uuid, session_key: self.sessions, alarm_reference };
        let ArConfig { instance, device_id, vendor_id, .. } = *connection;
        self.partner = Some(partner);
        self.ar = Some(ActiveAr {
            names,
            partner,
            object: ObjectUuid { instance, device_id, vendor_id }.into(),
            order: order(connection.little_endian),
            activity: self.ids.uuid(),
            sequence: 0,
            record: 0,
            prm_end_sent: false,
            exchange: None,
            alarms: None,
            plugs: PluggedSubmodules::new(connection.parameter_pause),
        });
    }

    /// Starts alarms and cyclic data once the device has accepted the Connect.
    pub(super) fn open_ar(&mut self, connection: &ArConfig, layout: &Layout, opened: AcceptedData, now: Time) {
        let ControllerContext { own, ar: Some(ar), outputs, alarm_acknowledge, .. } = self else { return };
        let references = (ar.names.alarm_reference, opened.alarm_reference);
        let mut alarms =
            ControllerAlarms::new(alarms::AlarmCrAddresses::new(connection, (own.mac, ar.partner.mac), references));
        alarms.acknowledge = *alarm_acknowledge;
        ar.alarms = Some(alarms);
        let ends = exchange::CyclicAddresses {
            own: own.mac,
            device: ar.partner.mac,
            frame_id_in: opened.frame_id_in,
            frame_id_out: opened.frame_id_out,
        };
        self.cycles_sent = 0;
        let fits = layout.output.data_length <= wire::profinet::rt::LONGEST_DATA;
        ar.exchange = fits.then(|| IoExchange::new(connection, layout, ends, outputs, now));
    }

    /// Excludes submodules that cannot deliver data from the check for valid samples.
    pub(super) fn exclude_improper(&mut self, diff: &ModuleDiffBlock) {
        if let Some(exchange) = self.ar.as_mut().and_then(|ar| ar.exchange.as_mut()) {
            exchange.consumer.exclude(|slot, subslot| is_improper(diff, slot, subslot));
        }
    }

    /// Processes an ApplicationReady that was answered positively: the controller's data become valid, and frames of the device
    /// are due.
    pub(super) fn application_is_ready(&mut self, now: Time, control: &ControlBlocks) -> Option<ModuleDiffBlock> {
        if let Some(exchange) = self.ar.as_mut().and_then(|ar| ar.exchange.as_mut()) {
            exchange.provider.application_is_ready();
            exchange.consumer.expect(now);
        }
        let diff = control.block(BlockType::MODULE_DIFF).and_then(|block| ModuleDiffBlock::parse(&block).ok())?;
        self.exclude_improper(&diff);
        Some(diff)
    }

    /// Ends the AR with an ERR-RTA, if it has an alarm connection, and drops it with its call.
    pub(super) fn abort(&mut self, reason: AbortReason, out: &mut Outbox) {
        if let Some(alarms) = self.ar.as_ref().and_then(|ar| ar.alarms.as_ref()) {
            alarms.abort(reason, out);
        }
        self.drop_ar();
    }

    /// Drops the AR and its call.
    pub(super) fn drop_ar(&mut self) {
        self.ar = None;
        self.call = self.call.take().filter(|_| !self.call_in_ar);
    }

    /// The device whose calls are served now.
    pub(super) fn served(&self) -> Option<ServedAr> {
        self.ar.as_ref().map(|ar| ServedAr {
            partner: ar.partner,
            ar_uuid: ar.names.uuid,
            session_key: ar.names.session_key,
            activity: ar.activity,
            expected: ar.prm_end_sent,
        })
    }

    /// The AR UUID and the number of the next record access; reserves `count` numbers. `None` without an AR.
    pub(super) fn record_numbers(&mut self, count: u16) -> Option<(Uuid, u16)> {
        let ar = self.ar.as_mut()?;
        let number = ar.record;
        ar.record = number.wrapping_add(count);
        Some((ar.names.uuid, number))
    }

    /// Calls the device of the AR; returns `false` if there is no AR.
    pub(super) fn call_ar(
        &mut self,
        now: Time,
        what: AwaitedEvent,
        opnum: Opnum,
        maximum: u32,
        blocks: &[u8],
        out: &mut Outbox,
    ) -> bool {
        let Some(ar) = &mut self.ar else { return false };
        let callee = ar.callee(ar.activity, ar.sequence, opnum);
        ar.sequence += 1;
        self.call(now, what, callee, &NdrRequest::body(callee.order, maximum, blocks), out);
        self.call_in_ar = true;
        true
    }

    /// Begins a call outside the AR; discards a previous one.
    pub(super) fn call(&mut self, now: Time, what: AwaitedEvent, callee: CallTarget, body: &[u8], out: &mut Outbox) {
        self.call_in_ar = false;
        self.call = Some(ControllerCall::new(what, (self.own, callee.partner), callee.header(), body, now, out));
    }
}

/// The blocks of a positive answer on a PROFINET interface.
pub(super) fn blocks(answer: RpcCallResult) -> Result<Vec<u8>, CallRefusal> {
    match answer {
        RpcCallResult::Response(order, body) => match NdrResponse::parse(order, &body) {
            Ok((ndr, _)) if !ndr.status.is_ok() => Err(CallRefusal::Status(ndr.status)),
            Ok((ndr, blocks)) => match blocks.get(..ndr.args_length as usize) {
                Some(blocks) => Ok(blocks.to_vec()),
                None => Err(CallRefusal::Call(CallError::Unfit("ArgsLength goes beyond the answer".into()))),
            },
            Err(error) => Err(CallRefusal::Call(CallError::Unfit(error.to_string()))),
        },
        other => Err(CallRefusal::Call(no_response(other))),
    }
}

/// Why there is no response.
pub(super) fn no_response(answer: RpcCallResult) -> CallError {
    match answer {
        RpcCallResult::Rejected(status) => CallError::Rejected(status),
        RpcCallResult::Faulted(status) => CallError::Faulted(status),
        RpcCallResult::None(wait) => CallError::NoAnswer(wait),
        RpcCallResult::Response(..) => CallError::Unfit("the response cannot be read".into()),
    }
}
