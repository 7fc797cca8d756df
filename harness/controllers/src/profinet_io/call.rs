//! An RPC call from its request to its answer: fragments, repetition, ping.
//!
//! An unanswered request is repeated with the same sequence number. Once the server reports "working", it is pinged instead; if
//! it then reports that it does not know the call, the request is sent again. This module knows neither ARs nor blocks.

use super::request::Partner;
use super::state::{AwaitedEvent, Wait};
use alloc::vec::Vec;
use core::net::SocketAddrV4;
use core::time::Duration;
use station::{Outbox, Time};
use wire::datagram::{Datagram, LONGEST_PAYLOAD, write_udp};
use wire::octets::ByteOrder;
use wire::profinet::rpc::{
    Assembled, Flags1, PORT, PacketType, Reassembler, RejectStatus, RpcHeader, RpcPdu, fragments,
};

/// The UDP port from which the controller calls.
pub(super) const CLIENT_PORT: u16 = 49_152;
/// After this time without a sign of the server, the request or the ping is repeated.
const REPEAT: Duration = Duration::from_secs(1);
/// After this number of silent periods in a row the controller gives up.
const SILENT_PERIODS: u8 = 4;
/// The controller gives up after this time even if the server keeps reporting "working".
const LONGEST_WORK: Duration = Duration::from_secs(60);
/// Maximum length of an answer in bytes; four times the largest PROFINET record.
const LONGEST_ANSWER: usize = 1 << 18;
/// Bytes in a fragment, so that its datagram fits in a frame.
const FRAGMENT: usize = LONGEST_PAYLOAD - RpcHeader::LENGTH;

/// A call that has not been answered yet.
#[derive(Debug)]
pub(super) struct ControllerCall {
    what: AwaitedEvent,
    own: Partner,
    partner: Partner,
    header: RpcHeader,
    pdus: Vec<Vec<u8>>,
    phase: CallPhase,
    began: Time,
    next: Time,
    silent: u8,
    reassembler: Reassembler,
}

/// The phase of a call.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum CallPhase {
    /// This fragment of the request was sent; its fack is awaited.
    Sending(usize),
    /// The whole request was sent.
    Sent,
    /// The server has reported "working".
    Working,
}

/// How a call ended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum RpcCallResult {
    /// The whole body of the response.
    Response(ByteOrder, Vec<u8>),
    /// The server did not begin the operation.
    Rejected(RejectStatus),
    /// The server began the operation and failed.
    Faulted(RejectStatus),
    /// No answer.
    None(Wait),
}

impl ControllerCall {
    /// Begins a call to `partner` with a request of this `header` and `body`.
    pub(super) fn new(
        what: AwaitedEvent,
        (own, partner): (Partner, Partner),
        header: RpcHeader,
        body: &[u8],
        now: Time,
        out: &mut Outbox,
    ) -> ControllerCall {
        let pdus = fragments(&header, body, FRAGMENT);
        let phase = if pdus.len() > 1 { CallPhase::Sending(0) } else { CallPhase::Sent };
        let reassembler = Reassembler::new(1, LONGEST_ANSWER);
        let call = ControllerCall {
            what,
            own,
            partner,
            header,
            pdus,
            phase,
            began: now,
            next: now + REPEAT,
            silent: 0,
            reassembler,
        };
        call.send_fragment(0, out);
        call
    }

    /// When something must be repeated.
    pub(super) fn deadline(&self) -> Time {
        self.next
    }

    /// Repeats what is due, or gives up.
    pub(super) fn wake(&mut self, now: Time, out: &mut Outbox) -> Option<RpcCallResult> {
        if now < self.next {
            return None;
        }
        self.silent += 1;
        if self.silent >= SILENT_PERIODS || now.since(self.began) >= LONGEST_WORK {
            return Some(RpcCallResult::None(Wait { what: self.what, time: now.since(self.began) }));
        }
        self.next = now + REPEAT;
        match self.phase {
            CallPhase::Working => self.send_control(PacketType::PING, 0, &[], out),
            CallPhase::Sending(_) | CallPhase::Sent => self.send_all(out),
        }
        None
    }

    /// Processes a datagram; anything that is not an answer of the partner to this call is ignored.
    pub(super) fn receive(&mut self, now: Time, datagram: &Datagram, out: &mut Outbox) -> Option<RpcCallResult> {
        let from_partner = (datagram.source_mac, *datagram.source.ip()) == (self.partner.mac, self.partner.ip);
        let pdu = RpcPdu::parse(datagram.payload).ok().filter(|_| from_partner)?;
        if (pdu.header.activity, pdu.header.sequence) != (self.header.activity, self.header.sequence) {
            return None;
        }
        let order = pdu.header.order();
        match pdu.header.packet_type {
            PacketType::RESPONSE => self.response(now, &pdu, out),
            PacketType::REJECT => RejectStatus::parse(order, pdu.body).ok().map(RpcCallResult::Rejected),
            PacketType::FAULT => RejectStatus::parse(order, pdu.body).ok().map(RpcCallResult::Faulted),
            PacketType::WORKING => {
                self.restart_timer(now);
                self.phase = CallPhase::Working;
                None
            }
            PacketType::NOCALL if self.phase == CallPhase::Working => {
                self.next = now + REPEAT;
                self.send_all(out);
                None
            }
            PacketType::FACK => {
                self.fack(now, pdu.header.fragment, out);
                None
            }
            _ => None,
        }
    }

    fn response(&mut self, now: Time, pdu: &RpcPdu, out: &mut Outbox) -> Option<RpcCallResult> {
        let assembled = self.reassembler.take(pdu);
        // A fragment that says nothing new is no sign that the answer is on its way.
        if matches!(assembled, Assembled::Whole(_) | Assembled::Waiting { .. }) {
            self.restart_timer(now);
        }
        let flags = pdu.header.flags1;
        if flags.has(Flags1::FRAGMENT) && !flags.has(Flags1::NO_FACK) {
            let (number, fack) =
                self.reassembler.fack(&pdu.header).unwrap_or((pdu.header.fragment, Default::default()));
            let fack = super::server::complete(fack, &pdu.header);
            let mut body = Vec::new();
            fack.write(&mut body, self.header.order());
            self.send_control(PacketType::FACK, number, &body, out);
        }
        match assembled {
            Assembled::Whole(body) => Some(RpcCallResult::Response(pdu.header.order(), body)),
            Assembled::Waiting { .. } | Assembled::Repeated | Assembled::Contradicts | Assembled::Refused => None,
        }
    }

    /// Processes an acknowledgement of this fragment and all before it.
    fn fack(&mut self, now: Time, fragment: u16, out: &mut Outbox) {
        let CallPhase::Sending(at) = self.phase else { return self.restart_timer(now) };
        if fragment == u16::MAX || usize::from(fragment) < at {
            return;
        }
        self.restart_timer(now);
        let next = (usize::from(fragment) + 1).min(self.pdus.len() - 1);
        self.phase = if next + 1 == self.pdus.len() { CallPhase::Sent } else { CallPhase::Sending(next) };
        self.send_fragment(next, out);
    }

    fn restart_timer(&mut self, now: Time) {
        self.silent = 0;
        self.next = now + REPEAT;
    }

    fn send_all(&mut self, out: &mut Outbox) {
        self.phase = CallPhase::Sent;
        (0..self.pdus.len()).for_each(|at| self.send_fragment(at, out));
    }

    fn send_fragment(&self, at: usize, out: &mut Outbox) {
        if let Some(pdu) = self.pdus.get(at) {
            send((self.own, CLIENT_PORT), (self.partner, PORT), pdu, out);
        }
    }

    fn send_control(&self, packet_type: PacketType, fragment: u16, body: &[u8], out: &mut Outbox) {
        let flags1 = Flags1(0);
        let header = RpcHeader { packet_type, flags1, fragment, ..self.header };
        send((self.own, CLIENT_PORT), (self.partner, PORT), &RpcPdu::new(header, body).to_vec(), out);
    }
}

/// Sends `payload` from one station and port to the other; what does not fit in a frame is not sent.
pub(super) fn send(from: (Partner, u16), to: (Partner, u16), payload: &[u8], out: &mut Outbox) {
    let end = |(station, port): (Partner, u16)| (station.mac, SocketAddrV4::new(station.ip, port));
    if payload.len() <= LONGEST_PAYLOAD {
        out.push_with(|octets| {
            let _fits = write_udp(end(from), end(to), payload, octets);
        });
    }
}
