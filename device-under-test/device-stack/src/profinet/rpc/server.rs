//! The server: from PDUs to requests and from replies to PDUs, with fragments, repetitions, pings and cancels.

use super::super::StackBehaviour;
use super::endpoint_mapper::{self, Registered};
use super::pdus;
use alloc::vec::Vec;
use core::net::SocketAddrV4;
use station::Time;
use wire::octets::Order;
use wire::profinet::rpc::{
    Assembled, Cancel, CancelAck, Fack, Flags1, Header, Opnum, PacketType, Pdu, Reassembler, RejectStatus, Uuid,
};

/// A call that is to be carried out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in super::super) struct Request {
    /// What is called by whom.
    pub header: Header,
    /// NDR header and blocks.
    pub body: Vec<u8>,
    /// Where the caller is.
    pub from: SocketAddrV4,
}

/// What came of a call.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in super::super) enum Reply {
    /// It was carried out: NDR header and blocks.
    Response(Vec<u8>),
    /// It could not be decoded, or failed.
    Fault(RejectStatus),
    /// It was not begun.
    Reject(RejectStatus),
}

/// What to do with a PDU that came in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in super::super) enum Taken {
    /// Nothing is to be said.
    Nothing,
    /// It was no call.
    Damaged,
    /// These PDUs go back.
    Say(Vec<Vec<u8>>),
    /// A call is to be carried out.
    Execute(Request),
}

/// What callers have called, one call for each activity.
#[derive(Debug)]
pub(in super::super) struct Server {
    reassembler: Reassembler,
    calls: Vec<Call>,
    registered: Registered,
    boot: u32,
}

#[derive(Debug)]
struct Call {
    activity: Uuid,
    sequence: u32,
    to: SocketAddrV4,
    state: CallState,
}

#[derive(Debug)]
enum CallState {
    Executing,
    Working { answer: Vec<Vec<u8>>, until: Time },
    Answered { answer: Vec<Vec<u8>> },
}

impl Server {
    /// How many callers are remembered; the one that was silent for longest makes room.
    const CALLERS: usize = 16;
    /// Most octets of a request.
    const LONGEST_REQUEST: usize = 65_536;

    /// A server that has started at `now` and lists `registered`.
    pub(in super::super) fn new(now: Time, registered: Registered) -> Server {
        let seconds = now.as_nanos() / 1_000_000_000;
        Server {
            reassembler: Reassembler::new(Server::CALLERS, Server::LONGEST_REQUEST),
            calls: Vec::new(),
            registered,
            boot: u32::try_from(seconds).unwrap_or(u32::MAX - 1) + 1,
        }
    }

    /// Takes the payload of a datagram; what is no RPC is passed over.
    pub(in super::super) fn take(
        &mut self,
        payload: &[u8],
        from: SocketAddrV4,
        address: [u8; 4],
        behaviour: &StackBehaviour,
    ) -> Taken {
        let Ok(pdu) = Pdu::parse(payload) else { return Taken::Damaged };
        match pdu.header.packet_type {
            PacketType::REQUEST => self.take_request(&pdu, from, address, behaviour),
            PacketType::PING => self.take_ping(&pdu.header, behaviour),
            PacketType::CANCEL => self.take_cancel(&pdu, behaviour),
            PacketType::ACK => {
                let is_done =
                    |call: &Call| is_call(call, &pdu.header) && matches!(call.state, CallState::Answered { .. });
                self.calls.retain(|call| !is_done(call));
                Taken::Nothing
            }
            _ => Taken::Nothing,
        }
    }

    fn take_request(
        &mut self,
        pdu: &Pdu<'_>,
        from: SocketAddrV4,
        address: [u8; 4],
        behaviour: &StackBehaviour,
    ) -> Taken {
        let header = &pdu.header;
        if let Some(at) = self.calls.iter().position(|call| call.activity == header.activity) {
            let call = &self.calls[at];
            if is_call(call, header) && behaviour.keeps_answers {
                let goes_on = header.flags1.has(Flags1::FRAGMENT) && !header.flags1.has(Flags1::LAST_FRAGMENT);
                return if goes_on { Taken::Nothing } else { self.again(header, behaviour) };
            }
            if (call.sequence.wrapping_sub(header.sequence) as i32) > 0 {
                return Taken::Nothing;
            }
        }
        let body = match self.reassembler.take(pdu) {
            Assembled::Whole(body) => body,
            Assembled::Waiting { .. } | Assembled::Repeated if header.flags1.has(Flags1::NO_FACK) => {
                return Taken::Nothing;
            }
            Assembled::Waiting { .. } | Assembled::Repeated => return self.fack(header, behaviour),
            Assembled::Contradicts | Assembled::Refused => {
                return self.say(
                    header,
                    PacketType::REJECT,
                    behaviour,
                    &reject(RejectStatus::PROTOCOL_ERROR, header, behaviour),
                );
            }
        };
        self.calls.retain(|call| call.activity != header.activity);
        if self.calls.len() >= Server::CALLERS {
            self.calls.remove(0);
        }
        self.calls.push(Call {
            activity: header.activity,
            sequence: header.sequence,
            to: from,
            state: CallState::Executing,
        });
        let request = Request { header: *header, body, from };
        if header.server_boot != 0 && header.server_boot != self.boot {
            return self.refuse(&request, RejectStatus::WRONG_BOOT_TIME, behaviour);
        }
        match header.interface {
            Uuid::DEVICE_INTERFACE if header.opnum <= Opnum::READ_IMPLICIT => Taken::Execute(request),
            Uuid::ENDPOINT_MAPPER if header.opnum == Opnum::EPT_LOOKUP => {
                let order = (behaviour.answer_order)(header.order());
                let reply = endpoint_mapper::lookup(&request, order, &self.registered, address);
                Taken::Say(self.answer_at_once(&request, &reply, behaviour))
            }
            Uuid::DEVICE_INTERFACE | Uuid::ENDPOINT_MAPPER => {
                self.refuse(&request, RejectStatus::OPERATION_RANGE, behaviour)
            }
            _ => self.refuse(&request, RejectStatus::UNKNOWN_INTERFACE, behaviour),
        }
    }

    fn refuse(&mut self, request: &Request, status: RejectStatus, behaviour: &StackBehaviour) -> Taken {
        Taken::Say(self.answer_at_once(request, &Reply::Reject(status), behaviour))
    }

    fn take_ping(&mut self, header: &Header, behaviour: &StackBehaviour) -> Taken {
        if self.calls.iter().any(|call| is_call(call, header)) {
            self.again(header, behaviour)
        } else {
            self.say(header, PacketType::NOCALL, behaviour, &[])
        }
    }

    /// What is said to somebody who asks for a call that is known: the answer, or that it is not there yet.
    fn again(&self, header: &Header, behaviour: &StackBehaviour) -> Taken {
        match self.calls.iter().find(|call| is_call(call, header)).map(|call| &call.state) {
            Some(CallState::Answered { answer }) => Taken::Say(answer.clone()),
            Some(CallState::Executing | CallState::Working { .. }) | None => {
                self.say(header, PacketType::WORKING, behaviour, &[])
            }
        }
    }

    fn take_cancel(&self, pdu: &Pdu<'_>, behaviour: &StackBehaviour) -> Taken {
        let Ok(cancel) = Cancel::parse(pdu.header.order(), pdu.body) else { return Taken::Nothing };
        let mut body = Vec::new();
        let ack = CancelAck { version: cancel.version, cancel_id: cancel.cancel_id, accepting: 0 };
        ack.write(&mut body, (behaviour.answer_order)(pdu.header.order()));
        self.say(&pdu.header, PacketType::CANCEL_ACK, behaviour, &body)
    }

    fn fack(&self, header: &Header, behaviour: &StackBehaviour) -> Taken {
        let Some((fragment, fack)) = self.reassembler.fack(header) else { return Taken::Nothing };
        let order = (behaviour.answer_order)(header.order());
        let longest = Server::LONGEST_REQUEST as u32;
        let fack = Fack { version: 1, window_size: 8, max_tsdu: longest, max_fragment: 1472, ..fack };
        let mut body = Vec::new();
        fack.write(&mut body, order);
        let answer = Header { fragment, server_boot: self.boot, ..header.answer(PacketType::FACK, order) };
        Taken::Say([Pdu::new(answer, &body).to_vec()].into())
    }

    fn say(&self, header: &Header, kind: PacketType, behaviour: &StackBehaviour, body: &[u8]) -> Taken {
        let order = (behaviour.answer_order)(header.order());
        let answer = Header { server_boot: self.boot, ..header.answer(kind, order) };
        Taken::Say([Pdu::new(answer, body).to_vec()].into())
    }

    fn answer_at_once(&mut self, request: &Request, reply: &Reply, behaviour: &StackBehaviour) -> Vec<Vec<u8>> {
        let order = (behaviour.answer_order)(request.header.order());
        let mut octets = Vec::new();
        let (kind, body) = match reply {
            Reply::Response(body) => (PacketType::RESPONSE, body),
            Reply::Fault(status) => (PacketType::FAULT, {
                status.write(&mut octets, order);
                &octets
            }),
            Reply::Reject(status) => (PacketType::REJECT, {
                status.write(&mut octets, order);
                &octets
            }),
        };
        let header = Header { server_boot: self.boot, ..request.header.answer(kind, order) };
        let answer = pdus(&header, body);
        if let Some(call) = self.calls.iter_mut().find(|call| is_call(call, &request.header)) {
            call.state = CallState::Answered { answer: answer.clone() };
        }
        answer
    }

    /// Takes the reply to a request that was carried out at `now`; [`due`](Server::due) says when it is to be sent.
    pub(in super::super) fn reply(&mut self, now: Time, request: &Request, reply: &Reply, behaviour: &StackBehaviour) {
        let answer = self.answer_at_once(request, reply, behaviour);
        if let Some(call) = self.calls.iter_mut().find(|call| is_call(call, &request.header)) {
            call.state = CallState::Working { answer, until: now + behaviour.answer_time };
        }
    }

    /// When the next reply is to be sent.
    pub(in super::super) fn due(&self) -> Option<Time> {
        let until = |call: &Call| match call.state {
            CallState::Working { until, .. } => Some(until),
            CallState::Executing | CallState::Answered { .. } => None,
        };
        self.calls.iter().filter_map(until).min()
    }

    /// The next reply that is due at `now`.
    pub(in super::super) fn next_reply(&mut self, now: Time) -> Option<(SocketAddrV4, Vec<Vec<u8>>)> {
        let is_due = |call: &&mut Call| matches!(call.state, CallState::Working { until, .. } if until <= now);
        let call = self.calls.iter_mut().find(is_due)?;
        let CallState::Working { answer, .. } = core::mem::replace(&mut call.state, CallState::Executing) else {
            return None;
        };
        call.state = CallState::Answered { answer: answer.clone() };
        Some((call.to, answer))
    }
}

fn is_call(call: &Call, header: &Header) -> bool {
    (call.activity, call.sequence) == (header.activity, header.sequence)
}

fn reject(status: RejectStatus, header: &Header, behaviour: &StackBehaviour) -> Vec<u8> {
    let mut body = Vec::new();
    status.write(&mut body, (behaviour.answer_order)(header.order()));
    body
}

/// The order in which words of an answer to `header` stand.
pub(in super::super) fn answer_order(header: &Header, behaviour: &StackBehaviour) -> Order {
    (behaviour.answer_order)(header.order())
}
