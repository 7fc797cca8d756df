//! The call of the device to the controller: ApplicationReady, repeated until it is answered.

use super::pdus;
use crate::profinet::ArKey;
use alloc::vec::Vec;
use core::net::SocketAddrV4;
use station::{Duration, Time};
use wire::ethernet::Mac;
use wire::octets::ByteOrder;
use wire::profinet::blocks::control::{ControlBlocks, ControlCommand};
use wire::profinet::rpc::{
    Assembled, Flags1, NdrRequest, NdrResponse, Opnum, PacketType, Reassembler, RpcHeader, RpcPdu, Uuid,
};
use wire::profinet::status::AbortReason;

/// A call to a controller that is not answered yet.
#[derive(Debug)]
pub(in super::super) struct OutgoingCall {
    to: SocketAddrV4,
    header: RpcHeader,
    pdus: Vec<Vec<u8>>,
    attempts_left: u8,
    due: Time,
    reassembler: Reassembler,
}

/// The progress of a call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in super::super) enum CallProgress {
    /// There is no answer yet.
    Open,
    /// The controller confirmed it.
    Done,
    /// The call failed; the connection must be aborted.
    Failed(AbortReason),
}

impl OutgoingCall {
    /// Time without an answer after which the call is repeated.
    const TIMEOUT: Duration = Duration::from_secs(1);
    /// Number of attempts.
    const ATTEMPTS: u8 = 5;
    /// Longest answer that the device accepts, in bytes of blocks.
    const LONGEST_ANSWER: usize = 4096;

    /// A Control call with `blocks` to `interface` and `object` of the station at `to`, with headers in `order`. It is
    /// call `sequence` of the connection `key`.
    pub(in super::super) fn control(
        now: Time,
        (mac, key, sequence): (Mac, ArKey, u32),
        to: SocketAddrV4,
        (interface, object): (Uuid, Uuid),
        blocks: &ControlBlocks,
        order: ByteOrder,
    ) -> OutgoingCall {
        let [k0, k1, k2, k3] = key.0.to_be_bytes();
        let [m0, m1, m2, m3, m4, m5] = mac.0;
        let header = RpcHeader {
            flags1: Flags1::IDEMPOTENT,
            object,
            interface,
            // A UUID of version 1 from the number of the connection and the address of the device.
            activity: Uuid([k0, k1, k2, k3, 0, 0, 0x10, 0, 0x80, 0, m0, m1, m2, m3, m4, m5]),
            opnum: Opnum::CONTROL,
            sequence,
            ..RpcHeader::new(PacketType::REQUEST, order)
        };
        let body = NdrRequest::body(order, OutgoingCall::LONGEST_ANSWER as u32, &blocks.to_vec());
        OutgoingCall {
            to,
            header,
            pdus: pdus(&header, &body),
            attempts_left: OutgoingCall::ATTEMPTS,
            due: now,
            reassembler: Reassembler::new(1, OutgoingCall::LONGEST_ANSWER + NdrResponse::LENGTH),
        }
    }

    /// When the next attempt is due, or the call times out.
    pub(in super::super) fn due(&self) -> Time {
        self.due
    }

    /// The address of the controller.
    pub(in super::super) fn to(&self) -> SocketAddrV4 {
        self.to
    }

    /// The progress at `now`, and the PDUs to send.
    pub(in super::super) fn wake(&mut self, now: Time) -> (CallProgress, &[Vec<u8>]) {
        if now < self.due {
            return (CallProgress::Open, &[]);
        }
        if self.attempts_left == 0 {
            return (CallProgress::Failed(AbortReason::RPC_CLIENT_CALL), &[]);
        }
        self.attempts_left -= 1;
        self.due = now + OutgoingCall::TIMEOUT;
        (CallProgress::Open, &self.pdus)
    }

    /// Processes a PDU from `from`. PDUs that do not answer this call are ignored.
    pub(in super::super) fn take(&mut self, now: Time, payload: &[u8], from: SocketAddrV4) -> CallProgress {
        let Ok(pdu) = RpcPdu::parse(payload) else { return CallProgress::Open };
        let is_mine = (pdu.header.activity, pdu.header.sequence) == (self.header.activity, self.header.sequence);
        if !is_mine || from.ip() != self.to.ip() {
            return CallProgress::Open;
        }
        match pdu.header.packet_type {
            PacketType::RESPONSE => match self.reassembler.take(&pdu) {
                Assembled::Whole(body) => parse_confirmation(pdu.header.order(), &body),
                Assembled::Waiting { .. } | Assembled::Repeated | Assembled::Contradicts => CallProgress::Open,
                Assembled::Refused => CallProgress::Failed(AbortReason::RPC_CLIENT_CALL),
            },
            PacketType::REJECT | PacketType::FAULT => CallProgress::Failed(AbortReason::RPC_CLIENT_CALL),
            PacketType::WORKING => {
                self.due = now + OutgoingCall::TIMEOUT;
                CallProgress::Open
            }
            _ => CallProgress::Open,
        }
    }
}

fn parse_confirmation(order: ByteOrder, body: &[u8]) -> CallProgress {
    let done = NdrResponse::parse(order, body).ok().filter(|(ndr, _)| ndr.status.is_ok());
    let block = done.and_then(|(_, blocks)| ControlBlocks::parse(blocks).ok());
    match block {
        Some(control) if control.block.control_command.has(ControlCommand::DONE) => CallProgress::Done,
        Some(_) | None => CallProgress::Failed(AbortReason::RPC_CONTROL),
    }
}
