//! Deviations of the PROFINET stack in its RPC calls: activities, fragments, refusals, the endpoint mapper.

use super::rpc_calls_state::{DropsRepetition, FragmentsInOrder};
use super::{Deviation, Group};
use crate::needs::Need;
use crate::seams::stack::Stack;
use device_stack::profinet::StackCheck;
use wire::datagram::Datagram;
use wire::profinet::rpc::{self, Flags1, NdrRequest, Opnum, PacketType, RpcHeader, RpcPdu, Uuid};
use wire::profinet::status::{CmrpcError, ErrorCode, ErrorSource, PnioStatus};

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[Group { needs: &[Need::Profinet], deviations: BUGS }];

const BUGS: &[Deviation] = bugs! {
    "pings-ignored" "A ping is not answered."
        => |d| ignores(&mut d.stack, |header| header.packet_type == PacketType::PING);
    "cancels-ignored" "A cancel is not answered."
        => |d| ignores(&mut d.stack, |header| header.packet_type == PacketType::CANCEL);
    "unknown-interfaces-ignored" "A call of an unknown interface is not answered."
        => |d| ignores(&mut d.stack, |header| !matches!(header.interface, Uuid::DEVICE_INTERFACE | Uuid::ENDPOINT_MAPPER));
    "unknown-operations-ignored" "A call of an operation that the interface does not have is not answered."
        => |d| ignores(&mut d.stack, |header| match header.interface {
            Uuid::ENDPOINT_MAPPER => header.opnum != Opnum::EPT_LOOKUP,
            _ => header.opnum > Opnum::READ_IMPLICIT,
        });
    "other-boot-times-ignored" "A call with another boot time of the server is not answered."
        => |d| ignores(&mut d.stack, |header| header.server_boot == u32::MAX);
    "endpoint-mapper-silent" "The endpoint mapper does not answer."
        => |d| ignores(&mut d.stack, |header| header.interface == Uuid::ENDPOINT_MAPPER);
    "fragments-ignored" "Calls in several fragments are ignored."
        => |d| ignores(&mut d.stack, |header| header.flags1.has(Flags1::FRAGMENT));
    "fragments-in-order-only" "Fragments of a call that come in another order are dropped."
        => |d| d.stack.add(FragmentsInOrder::default());
    "repeated-call-ignored" "A call that is repeated is not answered again."
        => |d| d.stack.add(DropsRepetition::default());
    "old-call-answered" "A call that is older than the last one of its activity is carried out."
        => |d| d.stack.set(StackCheck::OldCall, false);
    "args-length-not-checked" "ArgsLength of a call is not compared with the length of its blocks."
        => |d| d.stack.call(|_, header, body| {
            let order = header.order();
            if let Ok((ndr, blocks)) = NdrRequest::parse(order, body) {
                *body = NdrRequest::body(order, ndr.args_maximum, blocks);
            }
        });
    "record-header-not-checked" "Type, length and version of the block of a read are not checked."
        => |d| d.stack.blocks(Opnum::READ_IMPLICIT, |_, blocks| {
            if let Some(head) = blocks.get_mut(..6) {
                head.copy_from_slice(&[0x00, 0x09, 0x00, 0x3C, 0x01, 0x00]);
            }
        });
    "unknown-connection-answered" "Calls for a connection that does not exist are answered positively."
        => |d| d.stack.answer(|_, status, _| {
            let codes =
                [ErrorCode::READ_RESPONSE, ErrorCode::WRITE_RESPONSE, ErrorCode::RELEASE_RESPONSE, ErrorCode::CONTROL_RESPONSE];
            let unknown = |code| PnioStatus::found(code, ErrorSource::CMRPC, CmrpcError::AR_UUID_UNKNOWN.0);
            if codes.into_iter().any(|code| *status == unknown(code)) {
                *status = PnioStatus::OK;
            }
        });
};

/// Drops the PDUs to the server for which `is_ignored` returns `true`.
fn ignores(stack: &mut Stack, is_ignored: fn(&RpcHeader) -> bool) {
    stack.filter_frames(move |_, frame| to_server(frame).is_none_or(|header| !is_ignored(&header)));
}

/// The header of a PDU to the RPC server.
pub(super) fn to_server(frame: &[u8]) -> Option<RpcHeader> {
    let datagram = Datagram::parse(frame).ok().filter(|datagram| datagram.destination.port() == rpc::PORT)?;
    RpcPdu::parse(datagram.payload).ok().map(|pdu| pdu.header)
}
