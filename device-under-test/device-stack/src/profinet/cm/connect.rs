//! Connect: opens a connection from the blocks of the request and builds the blocks of the answer.

use super::super::alarm::AlarmEndpoint;
use super::super::ar::{ArExchange, DeviceAr};
use super::super::connection_record::{AgreedExchange, UDP_RT_PORT};
use super::super::cyclic::{InputProvider, OutputConsumer};
use super::super::hooks::{ArEvent, StackCheck};
use super::super::phase::ArPhase;
use super::super::plugged::ExpectedSubmoduleData;
use super::super::rpc::RpcCall;
use super::super::stack::{Stack, StackEnv};
use super::check::{self, ConnectPlan, ExchangePlan};
use super::{CmAnswer, cmrpc};
use alloc::vec::Vec;
use wire::ethernet::Mac;
use wire::profinet::blocks::RawBlock;
use wire::profinet::blocks::connect::{
    ArBlockRes, ArProperties, ArRpcBlock, ArServerBlockRes, Connect, ConnectBlock, ConnectContent, IocrBlockReq,
    IocrBlockRes, IocrType, RtClass,
};
use wire::profinet::blocks::module_diff::ModuleDiffBlock;
use wire::profinet::rpc;
use wire::profinet::status::{AbortReason, CmrpcError, ErrorCode, PnioStatus};

impl Stack {
    /// Opens a connection.
    pub(super) fn connect(
        &mut self,
        env: &mut StackEnv<'_>,
        request: &RpcCall,
        blocks: &[u8],
    ) -> Result<CmAnswer, PnioStatus> {
        let plan = check::connect(blocks, &self.plugged, &self.hooks)?;
        self.end_replaced_connections(env, &plan);
        if !self.has_free_connection(env, &plan) {
            return Err(cmrpc(ErrorCode::CONNECT_RESPONSE, CmrpcError::OUT_OF_AR_RESOURCES));
        }
        let key = self.retained.next_key();
        let mut answer = Connect::of([ConnectContent::ArRes(ArBlockRes {
            ar_type: plan.ar.ar_type,
            ar_uuid: plan.ar.ar_uuid,
            session_key: plan.ar.session_key,
            cm_responder_mac_add: self.retained.mac,
            responder_udp_rt_port: UDP_RT_PORT,
        })]);
        let mut ar = DeviceAr {
            key,
            peer: *request.from.ip(),
            peer_port: plan.rpc_port.unwrap_or(rpc::PORT),
            phase: ArPhase::Access,
            expected: Vec::new(),
            owned: Vec::new(),
            plugs: Vec::new(),
            ready_plugs: Vec::new(),
            calls: 0,
            difference: None,
            agreed: None,
            exchange: None,
            call: None,
            differs: false,
            phase_due: None,
            request: plan.ar.clone(),
        };
        if let Some(exchange) = &plan.exchange {
            self.open_exchange(env, &mut ar, exchange, &mut answer);
        }
        if plan.rpc_port.is_some() {
            answer.blocks.push(ConnectContent::ArRpcRes(ArRpcBlock { rpc_server_port: rpc::PORT }).into());
        }
        self.push_server_block(&plan, &mut answer);
        ar.touch(env.now);
        self.ars.push(ar);
        self.hooks.notify(|hooks| hooks.connection(ArEvent::Opened));
        Ok(CmAnswer::done(answer.to_vec()))
    }

    /// Ends the connection of the same UUID. If no connection with cyclic data is free, or if the controller of `plan`
    /// still has a connection with one of the same submodules, also ends that one.
    ///
    /// A controller that connects again has dropped its old connection. The device would notice that only when the
    /// data hold time expires, and would refuse the controller until then without need.
    fn end_replaced_connections(&mut self, env: &mut StackEnv<'_>, plan: &ConnectPlan) {
        let gives_way = |is_old| self.hooks.check(StackCheck::ReplacesConnection, is_old);
        if let Some(at) = self.ars.iter().position(|ar| gives_way(ar.request.ar_uuid == plan.ar.ar_uuid)) {
            self.abort(env, at, AbortReason::RE_RUN);
        }
        let Some(exchange) = &plan.exchange else { return };
        let is_free = self.has_free_connection(env, plan);
        let controller = plan.ar.cm_initiator_mac_add;
        let is_old = |ar: &DeviceAr| {
            let is_same = exchange.expected.iter().any(|submodule| ar.owns(submodule.place));
            ar.exchange.is_some() && ar.request.cm_initiator_mac_add == controller && (is_same || !is_free)
        };
        let gives_way = |is_old| self.hooks.check(StackCheck::ReplacesConnection, is_old);
        if let Some(at) = self.ars.iter().position(|ar| gives_way(is_old(ar))) {
            self.abort(env, at, AbortReason::RE_RUN);
        }
    }

    /// Whether a connection of the kind of `plan` is free.
    fn has_free_connection(&self, env: &StackEnv<'_>, plan: &ConnectPlan) -> bool {
        let is_exchange = plan.exchange.is_some();
        let others = self.ars.iter().filter(|ar| ar.exchange.is_some() == is_exchange).count();
        let most = if is_exchange { env.application.controllers() } else { env.application.supervisors() };
        self.hooks.check(StackCheck::ConnectionLimit { is_exchange, others }, others < most)
    }

    fn push_server_block(&self, plan: &ConnectPlan, answer: &mut Connect) {
        if plan.ar.ar_properties.has(ArProperties::STARTUP_ADVANCED) {
            let cm_responder_station_name = self.station.name.clone();
            answer.blocks.push(ConnectContent::ArServerRes(ArServerBlockRes { cm_responder_station_name }).into());
        }
    }

    /// Opens cyclic data and alarms of `ar` and appends their blocks to the answer.
    fn open_exchange(&mut self, env: &mut StackEnv<'_>, ar: &mut DeviceAr, plan: &ExchangePlan, answer: &mut Connect) {
        let (locked, free): (Vec<_>, Vec<_>) =
            plan.expected.iter().copied().partition(|submodule| self.is_owned(submodule.place));
        let fitting = self.plugged.adapt(&free);
        ar.phase = ArPhase::Parameters;
        ar.expected = plan.expected.clone();
        ar.owned = free.into_iter().filter(|submodule| self.plugged.knows(submodule)).collect();
        ar.difference = self.difference(&plan.expected, &locked);
        let Stack { ars, plugged, .. } = self;
        for ar in ars.iter_mut().chain([&mut *ar]) {
            ar.differs = plugged.differs(&ar.expected);
        }
        env.application.started(env.now, ar.key, &fitting);
        for iocr in &plan.iocrs {
            answer.blocks.push(
                ConnectContent::IocrRes(IocrBlockRes {
                    iocr_type: iocr.iocr_type,
                    iocr_reference: iocr.iocr_reference,
                    frame_id: self.frame_id(iocr),
                })
                .into(),
            );
        }
        let macs = (ar.request.cm_initiator_mac_add, self.retained.mac);
        let exchange = self.exchange(env, ar, macs, plan);
        if let Some(exchange) = &exchange {
            let alarms = exchange.alarms.response();
            let frame_id = |iocr: &IocrBlockReq| self.frame_id(iocr);
            let reference = alarms.local_alarm_reference;
            ar.agreed = Some(AgreedExchange::new(&plan.iocrs, &plan.alarm_cr, reference, frame_id));
            answer.blocks.push(ConnectContent::AlarmCrRes(alarms).into());
        }
        ar.exchange = exchange;
        if let Some(difference) = &ar.difference {
            answer.blocks.extend(raw(difference).map(ConnectBlock::from));
        }
    }

    /// The ModuleDiffBlock for `expected`, of which another connection owns those in `locked`, after the hooks.
    fn difference(
        &self,
        expected: &[ExpectedSubmoduleData],
        locked: &[ExpectedSubmoduleData],
    ) -> Option<ModuleDiffBlock> {
        self.hooks.apply(self.plugged.difference(expected, locked), |hooks, mut differing| {
            hooks.difference(&self.plugged.comparison(expected, locked), &mut differing);
            differing
        })
    }

    /// The FrameID of an IOCR. If the initiator leaves it open (0xFFFF), the first one of its class.
    fn frame_id(&self, iocr: &IocrBlockReq) -> u16 {
        match iocr.frame_id {
            0xFFFF => self.hooks.apply(first_frame_id(iocr), |hooks, frame_id| hooks.chosen_frame_id(frame_id)),
            agreed => agreed,
        }
    }

    fn exchange(&self, env: &StackEnv<'_>, ar: &DeviceAr, macs: (Mac, Mac), plan: &ExchangePlan) -> Option<ArExchange> {
        let iocr = |kind| plan.iocrs.iter().find(|iocr| iocr.iocr_type == kind);
        let (inputs, outputs) = (iocr(IocrType::INPUT)?, iocr(IocrType::OUTPUT)?);
        let is_usable =
            |submodule: &ExpectedSubmoduleData| self.plugged.fitting(submodule).is_some() && ar.owns(submodule.place);
        let reference = self.hooks.apply(ar.key.0 as u16, |hooks, reference| hooks.alarm_reference(reference));
        Some(ArExchange {
            provider: InputProvider::new(env.now, macs, inputs, &plan.expected, is_usable, self.hooks.clone()),
            consumer: OutputConsumer::new(
                macs.0,
                self.frame_id(outputs),
                outputs,
                &plan.expected,
                is_usable,
                self.hooks.clone(),
            ),
            alarms: AlarmEndpoint::new(macs, reference, &plan.alarm_cr, self.hooks.clone()),
        })
    }
}

/// The first FrameID of the class of an IOCR.
fn first_frame_id(iocr: &IocrBlockReq) -> u16 {
    if iocr.iocr_properties.rt_class() == RtClass::RT_CLASS_1 { 0xC000 } else { 0x8000 }
}

/// The ModuleDiffBlock as a raw block.
pub(super) fn raw(difference: &ModuleDiffBlock) -> Option<RawBlock> {
    let mut octets = Vec::new();
    difference.write(&mut octets);
    RawBlock::parse(&octets).ok()
}
