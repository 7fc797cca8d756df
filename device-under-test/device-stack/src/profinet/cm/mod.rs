//! Context management: the operations Connect, Release, Read, Write and Control.

mod check;
mod connect;
mod control;
mod layout;
mod record;

pub(super) use control::application_ready;

use super::rpc::{RpcCall, RpcReply};
use super::stack::{Stack, StackEnv};
use alloc::vec::Vec;
use wire::octets::ByteOrder;
use wire::profinet::rpc::{NdrRequest, NdrResponse, Opnum, RejectStatus, Uuid};
use wire::profinet::status::{CmrpcError, ErrorCode, ErrorSource, PnioStatus};

/// The result of an operation.
pub(super) struct CmAnswer {
    status: PnioStatus,
    blocks: Vec<u8>,
}

impl CmAnswer {
    pub(super) fn done(blocks: Vec<u8>) -> CmAnswer {
        CmAnswer { status: PnioStatus::OK, blocks }
    }
}

impl From<PnioStatus> for CmAnswer {
    fn from(status: PnioStatus) -> CmAnswer {
        CmAnswer { status, blocks: Vec::new() }
    }
}

/// A status of the CMRPC layer.
pub(super) const fn cmrpc(code: ErrorCode, error: CmrpcError) -> PnioStatus {
    PnioStatus::found(code, ErrorSource::CMRPC, error.0)
}

impl Stack {
    /// Carries out a call on the interface of the device.
    pub(super) fn execute(&mut self, env: &mut StackEnv<'_>, mut request: RpcCall) -> RpcReply {
        let view = self.view(env.now, env.application);
        self.hooks.notify(|hooks| hooks.call(&view, &request.header, &mut request.body));
        let Ok((ndr, blocks)) = NdrRequest::parse(request.header.order(), &request.body) else {
            return RpcReply::Fault(RejectStatus::FAULT_NDR);
        };
        let mut answer = match operation(request.header.opnum) {
            None => return RpcReply::Reject(RejectStatus::OPERATION_RANGE),
            Some((code, _)) if ndr.args_length as usize != blocks.len() || ndr.actual_count != ndr.args_length => {
                cmrpc(code, CmrpcError::ARGS_LENGTH).into()
            }
            Some((_, carry_out)) => carry_out(self, env, &request, blocks).unwrap_or_else(CmAnswer::from),
        };
        self.hooks.notify(|hooks| hooks.answer(&request.header, &mut answer.status, &mut answer.blocks));
        self.response(self.hooks.byte_order(request.header.order()), &ndr, &answer)
    }

    fn response(&self, order: ByteOrder, ndr: &NdrRequest, answer: &CmAnswer) -> RpcReply {
        if answer.blocks.len() > ndr.args_maximum as usize {
            return RpcReply::Fault(RejectStatus::OUTPUT_TOO_BIG);
        }
        RpcReply::Response(NdrResponse::body(order, answer.status, ndr.args_maximum, &answer.blocks))
    }

    /// The index of the connection `uuid`. If there is none, the error carries `code`, the ErrorCode of the answer.
    fn find(&self, code: ErrorCode, uuid: Uuid) -> Result<usize, PnioStatus> {
        let found = self.ars.iter().position(|ar| ar.request.ar_uuid == uuid);
        found.ok_or(cmrpc(code, CmrpcError::AR_UUID_UNKNOWN))
    }
}

type CmOperation = fn(&mut Stack, &mut StackEnv<'_>, &RpcCall, &[u8]) -> Result<CmAnswer, PnioStatus>;

/// The operations, each with the ErrorCode of its answers.
fn operation(opnum: Opnum) -> Option<(ErrorCode, CmOperation)> {
    Some(match opnum {
        Opnum::CONNECT => (ErrorCode::CONNECT_RESPONSE, Stack::connect),
        Opnum::RELEASE => (ErrorCode::RELEASE_RESPONSE, Stack::release),
        Opnum::READ => (ErrorCode::READ_RESPONSE, Stack::read),
        Opnum::WRITE => (ErrorCode::WRITE_RESPONSE, Stack::write),
        Opnum::CONTROL => (ErrorCode::CONTROL_RESPONSE, Stack::control),
        Opnum::READ_IMPLICIT => (ErrorCode::READ_RESPONSE, Stack::read_implicit),
        _ => return None,
    })
}
