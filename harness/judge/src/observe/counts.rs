//! How many frames of which kind were seen.

use std::collections::BTreeMap;
use wire::profinet::rpc::{Header, Opnum, PacketType, Uuid};

/// How many frames of which kind were seen.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// All frames.
    pub frames: u64,
    /// Frames of EtherType 0x8892.
    pub profinet: u64,
    /// Those of them that carry cyclic data, seen twice or not.
    pub cyclic: u64,
    /// Frames that were seen twice, for instance by a mirror port, and counted once.
    pub repeated: u64,
    /// PROFINET frames that could not be read.
    pub unreadable: u64,
    /// Frames that are none of ours.
    pub other: u64,
    /// Connections that were not followed because there were too many.
    pub connections_left_out: u64,
    /// RPC PDUs of PROFINET and of the endpoint mapper, each fragment and each repetition for itself.
    pub rpc: BTreeMap<RpcKind, u64>,
}

/// What an RPC PDU is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RpcKind {
    /// Request, response, ping and so on.
    pub packet_type: PacketType,
    /// The operation; 6 stands for all unknown ones.
    pub opnum: Opnum,
    /// Whether the endpoint mapper is meant.
    pub endpoint_mapper: bool,
}

impl Counts {
    /// Counts an RPC PDU.
    pub(super) fn rpc(&mut self, header: &Header) {
        let kind = RpcKind {
            packet_type: PacketType(header.packet_type.0.min(PacketType::CANCEL_ACK.0 + 1)),
            opnum: Opnum(header.opnum.0.min(Opnum::READ_IMPLICIT.0 + 1)),
            endpoint_mapper: header.interface == Uuid::ENDPOINT_MAPPER,
        };
        *self.rpc.entry(kind).or_default() += 1;
    }
}
