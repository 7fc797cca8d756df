//! The RPC server of the controller: ApplicationReady and similar calls of the device on UDP port 34964.
//!
//! It answers each call once and stores the answer, so that a repeated call gets the same answer. This module must not know what
//! ApplicationReady means for the start-up.

use super::call::send;
use super::request::Partner;
use alloc::vec::Vec;
use station::Outbox;
use wire::datagram::{Datagram, LONGEST_PAYLOAD};
use wire::octets::ByteOrder;
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::control::{ControlBlock, ControlBlocks, ControlCommand};
use wire::profinet::rpc::{
    Assembled, Fack, Flags1, NdrRequest, NdrResponse, Opnum, PORT, PacketType, Reassembler, RejectStatus, RpcHeader,
    RpcPdu, Uuid,
};
use wire::profinet::status::{CmrpcError, ErrorCode, ErrorSource, PnioStatus};

/// Maximum length of a request in bytes; a ModuleDiffBlock of all slots fits.
const LONGEST_REQUEST: usize = 1 << 16;
/// Number of calls that may be incomplete at the same time.
const MOST_CALLS: usize = 4;

/// The AR whose calls are served.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ServedAr {
    /// The device of the AR.
    pub(super) partner: Partner,
    pub(super) ar_uuid: Uuid,
    pub(super) session_key: u16,
    /// The controller's own activity UUID; a call with it can only be a reflection.
    pub(super) activity: Uuid,
    /// Whether PrmEnd was sent, so that ApplicationReady is allowed.
    pub(super) expected: bool,
}

/// The RPC server of a controller.
#[derive(Debug)]
pub(super) struct ControllerRpcServer {
    own: Partner,
    reassembler: Reassembler,
    last: Option<(Uuid, u32, Vec<u8>)>,
}

impl ControllerRpcServer {
    pub(super) fn new(own: Partner) -> ControllerRpcServer {
        ControllerRpcServer { own, reassembler: Reassembler::new(MOST_CALLS, LONGEST_REQUEST), last: None }
    }

    /// Forgets the last call: a restarted device may restart its sequence numbers.
    pub(super) fn forget(&mut self) {
        self.last = None;
    }

    /// Processes a datagram to the server port and answers it; returns the control block if it was accepted. Only calls of the
    /// device of an AR are served. No other station gets an answer, which a reflector could send back.
    pub(super) fn receive(
        &mut self,
        served: Option<ServedAr>,
        datagram: &Datagram,
        out: &mut Outbox,
    ) -> Option<ControlBlocks> {
        let served = served
            .filter(|served| (served.partner.mac, served.partner.ip) == (datagram.source_mac, *datagram.source.ip()))?;
        let pdu = RpcPdu::parse(datagram.payload).ok().filter(|pdu| pdu.header.activity != served.activity)?;
        let port = datagram.source.port();
        match pdu.header.packet_type {
            PacketType::REQUEST => self.request(served, port, &pdu, out),
            PacketType::PING => {
                match &self.last {
                    Some((activity, sequence, response)) if (*activity, *sequence) == call(&pdu.header) => {
                        self.send(served, port, response, out);
                    }
                    _ => self.send_control(served, port, &pdu.header, PacketType::NOCALL, &[], out),
                }
                None
            }
            _ => None,
        }
    }

    fn request(&mut self, served: ServedAr, port: u16, pdu: &RpcPdu, out: &mut Outbox) -> Option<ControlBlocks> {
        if let Some((activity, sequence, response)) = &self.last
            && (*activity, *sequence) == call(&pdu.header)
        {
            self.send(served, port, response, out);
            return None;
        }
        if pdu.header.interface != Uuid::CONTROLLER_INTERFACE || pdu.header.opnum != Opnum::CONTROL {
            let known = pdu.header.interface == Uuid::CONTROLLER_INTERFACE;
            let status = if known { RejectStatus::OPERATION_RANGE } else { RejectStatus::UNKNOWN_INTERFACE };
            let mut body = Vec::new();
            status.write(&mut body, pdu.header.order());
            self.send_control(served, port, &pdu.header, PacketType::REJECT, &body, out);
            return None;
        }
        let assembled = self.reassembler.take(pdu);
        let flags = pdu.header.flags1;
        if flags.has(Flags1::FRAGMENT) && !flags.has(Flags1::NO_FACK) {
            let (number, fack) = self.reassembler.fack(&pdu.header).unwrap_or((pdu.header.fragment, Fack::default()));
            let mut body = Vec::new();
            complete(fack, &pdu.header).write(&mut body, pdu.header.order());
            let header = RpcHeader { fragment: number, ..pdu.header };
            self.send_control(served, port, &header, PacketType::FACK, &body, out);
        }
        let Assembled::Whole(body) = assembled else { return None };
        self.answer(served, port, &pdu.header, &body, out)
    }

    fn answer(
        &mut self,
        served: ServedAr,
        port: u16,
        header: &RpcHeader,
        body: &[u8],
        out: &mut Outbox,
    ) -> Option<ControlBlocks> {
        let order = header.order();
        let (ndr, blocks) = NdrRequest::parse(order, body).ok()?;
        let control = ControlBlocks::parse(blocks).ok()?;
        let refused = refusal(served, &control.block);
        let status = refused.map_or(PnioStatus::OK, |error| {
            PnioStatus::found(ErrorCode::CONTROL_RESPONSE, ErrorSource::CMRPC, error.0)
        });
        let blocks = ControlBlocks::from(control.block.done()).to_vec();
        let body = NdrResponse::body(order, status, ndr.args_maximum, &blocks);
        let response = RpcPdu::new(header.answer(PacketType::RESPONSE, order), &body).to_vec();
        self.send(served, port, &response, out);
        self.last = Some((header.activity, header.sequence, response));
        refused.is_none().then_some(control)
    }

    fn send(&self, served: ServedAr, port: u16, pdu: &[u8], out: &mut Outbox) {
        send((self.own, PORT), (served.partner, port), pdu, out);
    }

    fn send_control(
        &self,
        served: ServedAr,
        port: u16,
        header: &RpcHeader,
        kind: PacketType,
        body: &[u8],
        out: &mut Outbox,
    ) {
        let header = RpcHeader { fragment: header.fragment, ..header.answer(kind, header.order()) };
        self.send(served, port, &RpcPdu::new(header, body).to_vec(), out);
    }
}

fn call(header: &RpcHeader) -> (Uuid, u32) {
    (header.activity, header.sequence)
}

/// Why a control call is refused.
fn refusal(served: ServedAr, block: &ControlBlock) -> Option<CmrpcError> {
    let is_of_ar = (block.ar_uuid, block.session_key) == (served.ar_uuid, served.session_key);
    let ready = matches!(block.header.kind, BlockType::APPLICATION_READY_REQ | BlockType::PLUG_APPLICATION_READY_REQ)
        && block.control_command.has(ControlCommand::APPLICATION_READY);
    match (is_of_ar, ready, served.expected) {
        (false, _, _) => Some(CmrpcError::AR_UUID_UNKNOWN),
        (true, false, _) => Some(CmrpcError::UNKNOWN_BLOCKS),
        (true, true, false) => Some(CmrpcError::STATE_CONFLICT),
        (true, true, true) => None,
    }
}

/// Adds the window and the sizes that this server offers to a fack: as much as an Ethernet frame carries.
pub(super) fn complete(fack: Fack, header: &RpcHeader) -> Fack {
    let most = LONGEST_PAYLOAD as u32;
    Fack { version: 0, window_size: 8, max_tsdu: most, max_fragment: most, serial: header.serial, ..fack }
}

/// The byte order of the controller's calls.
pub(super) fn order(little_endian: bool) -> ByteOrder {
    if little_endian { ByteOrder::Little } else { ByteOrder::Big }
}
