//! PrmEnd and Release, and the ApplicationReady call to the controller.

use super::super::ar::DeviceAr;
use super::super::hooks::ArEvent;
use super::super::phase::StartUpEvent;
use super::super::rpc::{OutgoingCall, RpcCall};
use super::super::stack::{Stack, StackEnv};
use super::{CmAnswer, cmrpc, connect};
use core::net::SocketAddrV4;
use station::Time;
use wire::ethernet::Mac;
use wire::octets::{ByteOrder, ByteReader};
use wire::profinet::blocks::connect::ArType;
use wire::profinet::blocks::control::{ControlBlock, ControlBlocks, ControlCommand};
use wire::profinet::blocks::{BlockType, RawBlock};
use wire::profinet::rpc::Uuid;
use wire::profinet::status::{CmrpcError, ErrorCode, ErrorSource, PnioStatus};

/// Length of a control block after its version, in bytes.
const BODY: usize = 26;
const LENGTH_FIELD: u8 = 1;
const VERSION_HIGH: u8 = 2;
const VERSION_LOW: u8 = 3;
const SESSION_KEY: u8 = 6;
const COMMAND: u8 = 8;

/// Reads the block of a Control or Release. Its type must be `kind`.
fn read(code: ErrorCode, kind: BlockType, finder: ErrorSource, blocks: &[u8]) -> Result<ControlBlock, PnioStatus> {
    let found = |field| PnioStatus::found(code, finder, field);
    let raw = RawBlock::read(&mut ByteReader::new("Control", blocks)).map_err(|_| found(LENGTH_FIELD))?;
    if raw.header.kind != kind {
        return Err(cmrpc(code, CmrpcError::UNKNOWN_BLOCKS));
    }
    for (field, holds) in [
        (LENGTH_FIELD, raw.body.len() == BODY),
        (VERSION_HIGH, raw.header.version_high == 1),
        (VERSION_LOW, raw.header.version_low == 0),
    ] {
        if !holds {
            return Err(found(field));
        }
    }
    ControlBlocks::parse(blocks).map(|control| control.block).map_err(|_| found(LENGTH_FIELD))
}

impl Stack {
    /// Control: this device accepts PrmEnd after Connect, and PrmEnd for a submodule that was plugged or released.
    pub(super) fn control(
        &mut self,
        env: &mut StackEnv<'_>,
        _: &RpcCall,
        blocks: &[u8],
    ) -> Result<CmAnswer, PnioStatus> {
        let code = ErrorCode::CONTROL_RESPONSE;
        let is_plug = blocks.starts_with(&BlockType::PLUG_PRM_END_REQ.0.to_be_bytes());
        let (kind, finder) = match is_plug {
            true => (BlockType::PLUG_PRM_END_REQ, ErrorSource::CONTROL_BLOCK_PLUG),
            false => (BlockType::PRM_END_REQ, ErrorSource::CONTROL_BLOCK),
        };
        let block = read(code, kind, finder, blocks)?;
        let at = self.find(code, block.ar_uuid)?;
        let ar = &mut self.ars[at];
        if block.session_key != ar.request.session_key {
            return Err(PnioStatus::found(code, finder, SESSION_KEY));
        }
        if block.control_command != ControlCommand::PRM_END {
            return Err(PnioStatus::found(code, finder, COMMAND));
        }
        if is_plug {
            return self.end_plug_parameters(env, at, &block);
        }
        if !ar.step(env.now, StartUpEvent::ParametersEnded) {
            return Err(cmrpc(code, CmrpcError::STATE_CONFLICT));
        }
        ar.phase_due = Some(env.application.parameter_end(env.now, ar.key));
        Ok(CmAnswer::done(ControlBlocks::from(block.done()).to_vec()))
    }

    /// Release: ends the connection.
    pub(super) fn release(
        &mut self,
        env: &mut StackEnv<'_>,
        _: &RpcCall,
        blocks: &[u8],
    ) -> Result<CmAnswer, PnioStatus> {
        let (code, finder) = (ErrorCode::RELEASE_RESPONSE, ErrorSource::RELEASE_BLOCK);
        let block = read(code, BlockType::RELEASE_REQ, finder, blocks)?;
        let at = self.find(code, block.ar_uuid)?;
        if block.session_key != self.ars[at].request.session_key {
            return Err(PnioStatus::found(code, finder, SESSION_KEY));
        }
        if block.control_command != ControlCommand::RELEASE {
            return Err(PnioStatus::found(code, finder, COMMAND));
        }
        let error = self.hooks.apply(None, |hooks, error| hooks.release_error(error));
        self.end(env, at, ArEvent::Released, error);
        Ok(CmAnswer::done(ControlBlocks::from(block.done()).to_vec()))
    }
}

/// The ApplicationReady call to the initiator of `ar`, with headers in `order`. With the sequence number of a plug alarm
/// it is about the submodule of that alarm, otherwise about the whole connection.
pub(in super::super) fn application_ready(
    now: Time,
    mac: Mac,
    ar: &mut DeviceAr,
    plug: Option<u16>,
    order: ByteOrder,
) -> OutgoingCall {
    let interface = match ar.request.ar_type {
        ArType::IOSAR => Uuid::SUPERVISOR_INTERFACE,
        _ => Uuid::CONTROLLER_INTERFACE,
    };
    let mut block = ControlBlock::application_ready(ar.request.ar_uuid, ar.request.session_key);
    if let Some(sequence) = plug {
        block.header.kind = BlockType::PLUG_APPLICATION_READY_REQ;
        block.alarm_sequence_number = sequence;
    }
    let mut blocks = ControlBlocks::from(block);
    blocks.more.extend(ar.difference.as_ref().filter(|_| plug.is_none()).and_then(connect::raw));
    let to = SocketAddrV4::new(ar.peer, ar.peer_port);
    let sequence = ar.calls;
    ar.calls = ar.calls.wrapping_add(1);
    OutgoingCall::control(
        now,
        (mac, ar.key, sequence),
        to,
        (interface, ar.request.cm_initiator_object_uuid),
        &blocks,
        order,
    )
}
