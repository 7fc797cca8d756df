//! Connect: from the blocks of the request to a connection and the blocks of the answer.

use super::super::alarm::AlarmEndpoint;
use super::super::ar::{Ar, Exchange};
use super::super::cyclic::{Consumer, Provider};
use super::super::phase::{Event, Phase};
use super::super::plugged::Expected;
use super::super::rpc::Request;
use super::super::stack::{Env, Stack};
use super::check::{self, ExchangePlan, Plan};
use super::{Answer, cmrpc};
use crate::profinet::ArKey;
use alloc::vec::Vec;
use wire::ethernet::Mac;
use wire::profinet::blocks::RawBlock;
use wire::profinet::blocks::connect::{
    ArBlockRes, ArProperties, ArRpcBlock, ArServerBlockRes, Connect, ConnectBlock, Content, IocrBlockReq, IocrBlockRes,
    IocrType, RtClass,
};
use wire::profinet::blocks::module_diff::{ArInfo, IdentInfo, ModuleDiffBlock, ModuleState, SubmoduleState};
use wire::profinet::rpc;
use wire::profinet::status::{AbortReason, CmrpcError, ErrorCode, PnioStatus};

/// How many connections for records alone there can be, beside those with cyclic data.
const ACCESS_CONNECTIONS: usize = 2;

/// UDP port for cyclic data over UDP, which this device has not.
const UDP_RT_PORT: u16 = 0x8892;

impl Stack {
    /// Opens a connection.
    pub(super) fn connect(
        &mut self,
        env: &mut Env<'_>,
        request: &Request,
        blocks: &[u8],
    ) -> Result<Answer, PnioStatus> {
        let plan = check::connect(blocks, &self.plugged, &self.behaviour)?;
        if let Some(at) = self.ars.iter().position(|ar| ar.request.ar_uuid == plan.ar.ar_uuid) {
            if !(self.behaviour.gives_way)(true) {
                return Err(cmrpc(ErrorCode::CONNECT_RESPONSE, CmrpcError::OUT_OF_AR_RESOURCES));
            }
            self.end(env, at, Some(AbortReason::RE_RUN));
        }
        self.make_way(env, &plan);
        let others = self.ars.iter().filter(|ar| ar.exchange.is_some() == plan.exchange.is_some()).count();
        if self.kept.is_worn_out()
            || others >= if plan.exchange.is_some() { self.behaviour.connections } else { ACCESS_CONNECTIONS }
        {
            return Err(cmrpc(ErrorCode::CONNECT_RESPONSE, CmrpcError::OUT_OF_AR_RESOURCES));
        }
        let key = self.kept.next_key();
        let mut answer = Connect::of([Content::ArRes(ArBlockRes {
            ar_type: plan.ar.ar_type,
            ar_uuid: plan.ar.ar_uuid,
            session_key: plan.ar.session_key,
            cm_responder_mac_add: self.kept.mac,
            responder_udp_rt_port: UDP_RT_PORT,
        })]);
        let mut ar = Ar {
            key,
            peer: *request.from.ip(),
            peer_port: plan.rpc_port.unwrap_or(rpc::PORT),
            phase: Phase::Access,
            expected: Vec::new(),
            difference: None,
            exchange: None,
            call: None,
            differs: false,
            has_ended: false,
            phase_due: None,
            request: plan.ar.clone(),
        };
        if let Some(exchange) = &plan.exchange {
            self.open_exchange(env, &mut ar, exchange, &mut answer);
        }
        if plan.rpc_port.is_some() {
            answer.blocks.push(Content::ArRpcRes(ArRpcBlock { rpc_server_port: rpc::PORT }).into());
        }
        self.push_server_block(&plan, &mut answer);
        ar.touch(env.now);
        if ar.phase == Phase::Parameters && !self.behaviour.waits_for_parameters {
            ar.step(env.now, Event::ParametersEnded);
            ar.phase_due = Some(env.now);
        }
        self.ars.push(ar);
        Ok(Answer::done(answer.to_vec()))
    }

    /// Ends the connection with cyclic data that the controller of `plan` still has here, if there is no room beside it.
    ///
    /// A controller that comes again has given up the old connection, of which the device learns only when the outputs
    /// have been missing for long enough; waiting for that would refuse it for no reason.
    fn make_way(&mut self, env: &mut Env<'_>, plan: &Plan) {
        let exchanges = self.ars.iter().filter(|ar| ar.exchange.is_some()).count();
        if plan.exchange.is_none() || exchanges < self.behaviour.connections || !(self.behaviour.gives_way)(false) {
            return;
        }
        let controller = plan.ar.cm_initiator_mac_add;
        let is_old = |ar: &Ar| ar.exchange.is_some() && !ar.has_ended && ar.request.cm_initiator_mac_add == controller;
        if let Some(at) = self.ars.iter().position(is_old) {
            self.end(env, at, Some(AbortReason::RE_RUN));
        }
    }

    fn push_server_block(&self, plan: &Plan, answer: &mut Connect) {
        if plan.ar.ar_properties.has(ArProperties::STARTUP_ADVANCED) {
            let cm_responder_station_name = self.station.name.clone();
            answer.blocks.push(Content::ArServerRes(ArServerBlockRes { cm_responder_station_name }).into());
        }
    }

    /// Opens the cyclic connections and the alarms of `ar`, and appends what is answered about them.
    fn open_exchange(&mut self, env: &mut Env<'_>, ar: &mut Ar, plan: &ExchangePlan, answer: &mut Connect) {
        let fitting = self.plugged.adapt(&plan.expected);
        ar.phase = Phase::Parameters;
        ar.expected = plan.expected.clone();
        ar.difference = self.difference(&plan.expected);
        let Stack { ars, plugged, .. } = self;
        for ar in ars.iter_mut().chain([&mut *ar]) {
            ar.differs = plugged.differs(&ar.expected);
        }
        env.application.started(env.now, ar.key, &fitting);
        for iocr in &plan.iocrs {
            answer.blocks.push(
                Content::IocrRes(IocrBlockRes {
                    iocr_type: iocr.iocr_type,
                    iocr_reference: iocr.iocr_reference,
                    frame_id: frame_id(iocr),
                })
                .into(),
            );
        }
        let macs = (ar.request.cm_initiator_mac_add, self.kept.mac);
        let exchange = self.exchange(env, ar.key, macs, plan);
        if let Some(exchange) = &exchange {
            answer.blocks.push(Content::AlarmCrRes(exchange.alarms.response()).into());
        }
        ar.exchange = exchange;
        if let Some(difference) = &ar.difference {
            answer.blocks.extend(raw(difference).map(ConnectBlock::from));
        }
    }

    /// What is told about how what is plugged differs from `expected`.
    fn difference(&self, expected: &[Expected]) -> Option<ModuleDiffBlock> {
        let proper = || self.behaviour.tells_proper_modules.then(|| self.plugged.comparison(expected, true));
        let mut told = self.plugged.difference(expected).or_else(proper)?;
        for module in told.apis.iter_mut().flat_map(|api| &mut api.modules) {
            if module.state == ModuleState::PROPER_MODULE {
                module.state = self.behaviour.proper_state;
                let submodules = module.submodules.iter_mut().filter(|_| module.state == ModuleState::SUBSTITUTE);
                let state = SubmoduleState::new(IdentInfo::SUBSTITUTE, ArInfo::OWN, 0);
                submodules.for_each(|submodule| submodule.state = state);
            }
        }
        self.behaviour.reports_module_diff.then_some(told)
    }

    fn exchange(&self, env: &Env<'_>, key: ArKey, macs: (Mac, Mac), plan: &ExchangePlan) -> Option<Exchange> {
        let iocr = |kind| plan.iocrs.iter().find(|iocr| iocr.iocr_type == kind);
        let (inputs, outputs) = (iocr(IocrType::INPUT)?, iocr(IocrType::OUTPUT)?);
        let is_plugged = |submodule: &Expected| self.plugged.fitting(submodule).is_some();
        Some(Exchange {
            provider: Provider::new(env.now, macs, inputs, &plan.expected, is_plugged, &self.behaviour),
            consumer: Consumer::new(macs.0, self.output_frame_id(outputs), outputs, &plan.expected, is_plugged),
            alarms: AlarmEndpoint::new(macs, key.0 as u16, &plan.alarm_cr, &self.behaviour),
        })
    }
}

impl Stack {
    /// The frame id under which the outputs of `iocr` are taken.
    fn output_frame_id(&self, iocr: &IocrBlockReq) -> u16 {
        let is_proposed = iocr.frame_id != 0xFFFF;
        if is_proposed { (self.behaviour.output_frame_id)(iocr.frame_id) } else { frame_id(iocr) }
    }
}

/// The frame id that holds: where the initiator leaves it open, the first of its class.
fn frame_id(iocr: &IocrBlockReq) -> u16 {
    match (iocr.frame_id, iocr.iocr_properties.rt_class()) {
        (0xFFFF, RtClass::RT_CLASS_1) => 0xC000,
        (0xFFFF, _) => 0x8000,
        (agreed, _) => agreed,
    }
}

/// The ModuleDiffBlock as other blocks carry it.
pub(super) fn raw(difference: &ModuleDiffBlock) -> Option<RawBlock> {
    let mut octets = Vec::new();
    difference.write(&mut octets);
    RawBlock::parse(&octets).ok()
}
