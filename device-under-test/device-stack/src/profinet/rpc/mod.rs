//! RPC: the server for calls of controllers, the endpoint mapper, and the ApplicationReady call of the device.
//!
//! This module must not know the operations.

mod caller;
mod endpoint_mapper;
mod server;

pub(super) use caller::{CallProgress, OutgoingCall};
pub(super) use endpoint_mapper::MapperEntry;
pub(super) use server::{PduAction, RpcCall, RpcReply, RpcServer};

use alloc::vec::Vec;
use wire::datagram::LONGEST_PAYLOAD;
use wire::profinet::rpc::{RpcHeader, fragments};

/// The PDUs of a body, each short enough for one frame.
fn pdus(header: &RpcHeader, body: &[u8]) -> Vec<Vec<u8>> {
    fragments(header, body, LONGEST_PAYLOAD - RpcHeader::LENGTH)
}
