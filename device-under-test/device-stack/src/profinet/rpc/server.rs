//! The RPC server: converts PDUs to requests and replies to PDUs. It handles fragments, repetitions, pings and
//! cancels.

use super::super::hooks::{AttachedStackHooks, StackCheck};
use super::endpoint_mapper::{self, MapperEntry};
use super::pdus;
use alloc::vec::Vec;
use core::net::SocketAddrV4;
use station::Time;
use wire::octets::ByteOrder;
use wire::profinet::rpc::{
    Assembled, Cancel, CancelAck, Fack, Flags1, Opnum, PacketType, Reassembler, RejectStatus, RpcHeader, RpcPdu, Uuid,
};

/// A complete request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in super::super) struct RpcCall {
    /// The RPC header.
    pub header: RpcHeader,
    /// NDR header and blocks.
    pub body: Vec<u8>,
    /// Address and port of the caller.
    pub from: SocketAddrV4,
}

/// The result of a call.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in super::super) enum RpcReply {
    /// The call was carried out: NDR header and blocks.
    Response(Vec<u8>),
    /// The request could not be decoded, or the call failed.
    Fault(RejectStatus),
    /// The call was rejected.
    Reject(RejectStatus),
}

/// What to do with a received PDU.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in super::super) enum PduAction {
    /// No answer.
    Nothing,
    /// Send these PDUs back.
    Say(Vec<Vec<u8>>),
    /// Carry out this call.
    Execute(RpcCall),
}

/// The RPC server. It keeps the last answer of each activity.
#[derive(Debug)]
pub(in super::super) struct RpcServer {
    reassembler: Reassembler,
    calls: Vec<AnsweredCall>,
    registered: MapperEntry,
    boot: u32,
    hooks: AttachedStackHooks,
}

#[derive(Debug)]
struct AnsweredCall {
    activity: Uuid,
    sequence: u32,
    answer: Vec<Vec<u8>>,
}

impl RpcServer {
    /// Number of activities whose answer is kept. The oldest one is dropped first.
    const CALLERS: usize = 16;
    /// Longest request in bytes.
    const LONGEST_REQUEST: usize = 65_536;

    /// A server that was started at `now` and whose endpoint mapper lists `registered`.
    pub(in super::super) fn new(now: Time, registered: MapperEntry, hooks: AttachedStackHooks) -> RpcServer {
        let seconds = now.as_nanos() / 1_000_000_000;
        RpcServer {
            reassembler: Reassembler::new(RpcServer::CALLERS, RpcServer::LONGEST_REQUEST),
            calls: Vec::new(),
            registered,
            boot: u32::try_from(seconds).unwrap_or(u32::MAX - 1) + 1,
            hooks,
        }
    }

    /// The byte order of the answer to a request.
    fn order(&self, request: &RpcHeader) -> ByteOrder {
        self.hooks.byte_order(request.order())
    }

    /// Processes the payload of a datagram. Payloads that are not RPC are ignored.
    pub(in super::super) fn take(&mut self, payload: &[u8], from: SocketAddrV4, address: [u8; 4]) -> PduAction {
        let Ok(pdu) = RpcPdu::parse(payload) else { return PduAction::Nothing };
        match pdu.header.packet_type {
            PacketType::REQUEST => self.take_request(&pdu, from, address),
            PacketType::PING => self.take_ping(&pdu.header),
            PacketType::CANCEL => self.take_cancel(&pdu),
            PacketType::ACK => {
                self.calls.retain(|call| !is_call(call, &pdu.header));
                PduAction::Nothing
            }
            _ => PduAction::Nothing,
        }
    }

    fn take_request(&mut self, pdu: &RpcPdu<'_>, from: SocketAddrV4, address: [u8; 4]) -> PduAction {
        let header = &pdu.header;
        if let Some(call) = self.calls.iter().find(|call| call.activity == header.activity) {
            if is_call(call, header) {
                let is_incomplete = header.flags1.has(Flags1::FRAGMENT) && !header.flags1.has(Flags1::LAST_FRAGMENT);
                return if is_incomplete { PduAction::Nothing } else { PduAction::Say(call.answer.clone()) };
            }
            let is_old = (call.sequence.wrapping_sub(header.sequence) as i32) > 0;
            if self.hooks.check(StackCheck::OldCall, is_old) {
                return PduAction::Nothing;
            }
        }
        let body = match self.reassembler.take(pdu) {
            Assembled::Whole(body) => body,
            Assembled::Waiting { .. } | Assembled::Repeated if header.flags1.has(Flags1::NO_FACK) => {
                return PduAction::Nothing;
            }
            Assembled::Waiting { .. } | Assembled::Repeated => return self.fack(header),
            Assembled::Contradicts | Assembled::Refused => {
                let mut body = Vec::new();
                RejectStatus::PROTOCOL_ERROR.write(&mut body, self.order(header));
                return self.answer_pdu(header, PacketType::REJECT, &body);
            }
        };
        let request = RpcCall { header: *header, body, from };
        if header.server_boot != 0 && header.server_boot != self.boot {
            return self.refuse(&request, RejectStatus::WRONG_BOOT_TIME);
        }
        match header.interface {
            Uuid::DEVICE_INTERFACE if header.opnum <= Opnum::READ_IMPLICIT => PduAction::Execute(request),
            Uuid::ENDPOINT_MAPPER if header.opnum == Opnum::EPT_LOOKUP => {
                let reply = endpoint_mapper::lookup(&request, self.order(header), &self.registered, address);
                PduAction::Say(self.answer(&request, &reply))
            }
            Uuid::DEVICE_INTERFACE | Uuid::ENDPOINT_MAPPER => self.refuse(&request, RejectStatus::OPERATION_RANGE),
            _ => self.refuse(&request, RejectStatus::UNKNOWN_INTERFACE),
        }
    }

    fn refuse(&mut self, request: &RpcCall, status: RejectStatus) -> PduAction {
        PduAction::Say(self.answer(request, &RpcReply::Reject(status)))
    }

    fn take_ping(&self, header: &RpcHeader) -> PduAction {
        match self.calls.iter().find(|call| is_call(call, header)) {
            Some(call) => PduAction::Say(call.answer.clone()),
            None => self.answer_pdu(header, PacketType::NOCALL, &[]),
        }
    }

    fn take_cancel(&self, pdu: &RpcPdu<'_>) -> PduAction {
        let Ok(cancel) = Cancel::parse(pdu.header.order(), pdu.body) else { return PduAction::Nothing };
        let mut body = Vec::new();
        let ack = CancelAck { version: cancel.version, cancel_id: cancel.cancel_id, accepting: 0 };
        ack.write(&mut body, self.order(&pdu.header));
        self.answer_pdu(&pdu.header, PacketType::CANCEL_ACK, &body)
    }

    fn fack(&self, header: &RpcHeader) -> PduAction {
        let Some((fragment, fack)) = self.reassembler.fack(header) else { return PduAction::Nothing };
        let order = self.order(header);
        let longest = RpcServer::LONGEST_REQUEST as u32;
        let fack = Fack { version: 1, window_size: 8, max_tsdu: longest, max_fragment: 1472, ..fack };
        let mut body = Vec::new();
        fack.write(&mut body, order);
        let answer = RpcHeader { fragment, server_boot: self.boot, ..header.answer(PacketType::FACK, order) };
        PduAction::Say([RpcPdu::new(answer, &body).to_vec()].into())
    }

    fn answer_pdu(&self, header: &RpcHeader, kind: PacketType, body: &[u8]) -> PduAction {
        let order = self.order(header);
        let answer = RpcHeader { server_boot: self.boot, ..header.answer(kind, order) };
        PduAction::Say([RpcPdu::new(answer, body).to_vec()].into())
    }

    /// The PDUs that answer a request. They are kept in case the caller repeats the request.
    pub(in super::super) fn answer(&mut self, request: &RpcCall, reply: &RpcReply) -> Vec<Vec<u8>> {
        let order = self.order(&request.header);
        let mut octets = Vec::new();
        let (kind, body) = match reply {
            RpcReply::Response(body) => (PacketType::RESPONSE, body),
            RpcReply::Fault(status) => (PacketType::FAULT, {
                status.write(&mut octets, order);
                &octets
            }),
            RpcReply::Reject(status) => (PacketType::REJECT, {
                status.write(&mut octets, order);
                &octets
            }),
        };
        let header = RpcHeader { server_boot: self.boot, ..request.header.answer(kind, order) };
        let answer = pdus(&header, body);
        let RpcHeader { activity, sequence, .. } = request.header;
        self.calls.retain(|call| call.activity != activity);
        if self.calls.len() >= RpcServer::CALLERS {
            self.calls.remove(0);
        }
        self.calls.push(AnsweredCall { activity, sequence, answer: answer.clone() });
        answer
    }
}

fn is_call(call: &AnsweredCall, header: &RpcHeader) -> bool {
    (call.activity, call.sequence) == (header.activity, header.sequence)
}
