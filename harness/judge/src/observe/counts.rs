//! Number of frames of each kind.

use std::collections::BTreeMap;
use wire::profinet::rpc::{Opnum, PacketType, RpcHeader, Uuid};

/// Number of frames of each kind.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FrameCounts {
    /// All frames.
    pub frames: u64,
    /// Frames of EtherType 0x8892.
    pub profinet: u64,
    /// PROFINET frames with cyclic data, including copies.
    pub cyclic: u64,
    /// Copies of frames, for instance by a mirror port.
    pub repeated: u64,
    /// Unreadable PROFINET frames.
    pub unreadable: u64,
    /// Frames of other protocols.
    pub other: u64,
    /// Connections that are not followed because there are too many.
    pub connections_left_out: u64,
    /// RPC PDUs of PROFINET and of the endpoint mapper, including fragments and repetitions.
    pub rpc: BTreeMap<RpcKind, u64>,
}

/// The kind of an RPC PDU.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct RpcKind {
    /// Packet type: request, response, ping and so on.
    pub packet_type: PacketType,
    /// The operation number; 6 for all unknown ones.
    pub opnum: Opnum,
    /// Whether it belongs to the endpoint mapper.
    pub endpoint_mapper: bool,
}

impl FrameCounts {
    pub(super) fn rpc(&mut self, header: &RpcHeader) {
        let kind = RpcKind {
            packet_type: PacketType(header.packet_type.0.min(PacketType::CANCEL_ACK.0 + 1)),
            opnum: Opnum(header.opnum.0.min(Opnum::READ_IMPLICIT.0 + 1)),
            endpoint_mapper: header.interface == Uuid::ENDPOINT_MAPPER,
        };
        *self.rpc.entry(kind).or_default() += 1;
    }
}
