//! DCP requests and RPC calls whose bytes the caller writes itself, and the first answer to each.

use super::call::{CLIENT_PORT, send};
use super::context::{ARGS_MAXIMUM, ControllerContext};
use super::jobs::ControllerJob;
use super::ping::FragmentedSending;
use super::request::Partner;
use alloc::vec::Vec;
use core::time::Duration;
use station::{Outbox, Time};
use wire::datagram::{Datagram, LONGEST_PAYLOAD};
use wire::ethernet::{Mac, pad};
use wire::octets::ByteOrder;
use wire::profinet::dcp::{Dcp, DcpValue, ServiceId};
use wire::profinet::rpc::{
    Flags1, NdrRequest, ObjectUuid, Opnum, PORT, PacketType, RpcHeader, RpcPdu, Uuid, fragments,
};

/// How long the answer to a call is awaited; the call is sent once.
const CALL_WAIT: Duration = Duration::from_secs(2);
/// Offset of DCPDataLength in a DCP frame without a tag.
const DCP_LENGTH_AT: usize = 24;

/// A DCP request whose blocks are given as bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RawDcpRequest {
    /// Get or Set.
    pub service: ServiceId,
    /// Everything after DCPDataLength.
    pub octets: Vec<u8>,
}

/// What a call is to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RawObject {
    /// The object of the device.
    Device(ObjectUuid),
    /// This UUID.
    Other(Uuid),
}

/// Which activity a call belongs to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RawActivity {
    /// A new one.
    #[default]
    New,
    /// That of the last call.
    Last,
}

/// The content of a call.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RawBody {
    /// These bytes.
    Octets(Vec<u8>),
    /// These blocks after an NDR header that fits.
    Blocks(Vec<u8>),
}

/// An RPC PDU whose fields are given.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RawCall {
    /// The kind of the PDU.
    pub packet: PacketType,
    /// The object that is called.
    pub object: RawObject,
    /// The interface that is called.
    pub interface: Uuid,
    /// The version of the interface.
    pub interface_version: u32,
    /// The operation.
    pub opnum: Opnum,
    /// The activity.
    pub activity: RawActivity,
    /// The sequence number within the activity.
    pub sequence: u32,
    /// The boot time of the server that the client has seen; 0 for none.
    pub server_boot: u32,
    /// The byte order.
    pub order: ByteOrder,
    /// The content.
    pub body: RawBody,
    /// Bytes of the body in each fragment; `None` for a body in one piece.
    pub fragment: Option<usize>,
    /// The fragments that are sent, in this order; `None` for all.
    pub sent: Option<Vec<usize>>,
    /// How each datagram is sent in IP fragments; `None` for whole datagrams.
    pub ip: Option<FragmentedSending>,
}

/// A PDU that answers a call.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RawAnswer {
    /// Its kind.
    pub packet: PacketType,
    /// Its byte order.
    pub order: ByteOrder,
    /// Its body.
    pub body: Vec<u8>,
}

/// A call that waits for its first answer.
#[derive(Debug)]
pub(super) struct RawCallJob {
    device: Mac,
    header: RpcHeader,
    /// Whether the whole request was sent, so that acknowledged fragments are no answer.
    is_whole: bool,
    pub(super) since: Time,
}

impl RawCallJob {
    /// When it gives up.
    pub(super) fn until(&self) -> Time {
        self.since + CALL_WAIT
    }

    /// How long it has waited then.
    pub(super) const WAIT: Duration = CALL_WAIT;

    /// The answer in a datagram, if it is one.
    pub(super) fn answer(&self, datagram: &Datagram) -> Option<RawAnswer> {
        let pdu = RpcPdu::parse(datagram.payload).ok().filter(|_| datagram.source_mac == self.device)?;
        let header = &pdu.header;
        let is_answer = (header.activity, header.sequence) == (self.header.activity, self.header.sequence)
            && header.packet_type != PacketType::WORKING
            && !(self.is_whole && header.packet_type == PacketType::FACK);
        is_answer.then(|| RawAnswer { packet: header.packet_type, order: header.order(), body: pdu.body.to_vec() })
    }
}

/// Sends a call and begins to wait for its answer.
pub(super) fn call(
    context: &mut ControllerContext,
    now: Time,
    partner: Partner,
    call: &RawCall,
    out: &mut Outbox,
) -> ControllerJob {
    let activity = match (call.activity, context.last_activity) {
        (RawActivity::Last, Some(last)) => last,
        _ => context.ids.uuid(),
    };
    context.last_activity = Some(activity);
    let header = RpcHeader {
        flags1: Flags1::IDEMPOTENT,
        object: match call.object {
            RawObject::Device(object) => object.into(),
            RawObject::Other(uuid) => uuid,
        },
        interface: call.interface,
        interface_version: call.interface_version,
        activity,
        sequence: call.sequence,
        server_boot: call.server_boot,
        opnum: call.opnum,
        ..RpcHeader::new(call.packet, call.order)
    };
    let body = match &call.body {
        RawBody::Octets(octets) => octets.clone(),
        RawBody::Blocks(blocks) => NdrRequest::body(call.order, ARGS_MAXIMUM, blocks),
    };
    let most = LONGEST_PAYLOAD - RpcHeader::LENGTH;
    let pdus = fragments(&header, &body, call.fragment.unwrap_or(most).min(most));
    let all: Vec<usize> = (0..pdus.len()).collect();
    let sent = call.sent.as_ref().unwrap_or(&all);
    let (from, to) = ((context.own, CLIENT_PORT), (partner, PORT));
    for pdu in sent.iter().filter_map(|at| pdus.get(*at)) {
        match &call.ip {
            None => send(from, to, pdu, out),
            Some(ip) => ip.send_datagram(context.ids.xid() as u16 | 1, from, to, pdu, out),
        }
    }
    let is_whole = all.iter().all(|at| sent.contains(at));
    ControllerJob::Call(RawCallJob { device: partner.mac, header, is_whole, since: now })
}

/// Sends an Identify whose filters are given as bytes.
pub(super) fn identify(context: &mut ControllerContext, filters: &[u8], delay: u16, out: &mut Outbox) -> u32 {
    let xid = context.ids.xid();
    let request = Dcp::identify(xid, delay, [DcpValue::AllSelector].into());
    let mut frame = Vec::new();
    request.write_frame(Mac::DCP_MULTICAST, context.settings.mac, &mut frame);
    out.push(&with_blocks(frame, filters));
    xid
}

/// Sends a DCP request to one station.
pub(super) fn dcp(context: &mut ControllerContext, to: Mac, request: &RawDcpRequest, out: &mut Outbox) -> u32 {
    let xid = context.ids.xid();
    let empty = match request.service {
        ServiceId::GET => Dcp::get(xid, Vec::new()),
        _ => Dcp { service_id: request.service, ..Dcp::set(xid, Vec::new()) },
    };
    let mut frame = Vec::new();
    empty.write_frame(to, context.settings.mac, &mut frame);
    out.push(&with_blocks(frame, &request.octets));
    xid
}

/// The frame with these bytes after DCPDataLength, which fits them.
fn with_blocks(mut frame: Vec<u8>, octets: &[u8]) -> Vec<u8> {
    frame.truncate(DCP_LENGTH_AT);
    frame.extend((octets.len() as u16).to_be_bytes());
    frame.extend(octets);
    pad(&mut frame, 0);
    frame
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;
    use wire::profinet::dcp::DcpBody;

    const TO: Mac = Mac([2, 0, 0, 0, 0, 1]);
    const FROM: Mac = Mac([2, 0, 0, 0, 0, 2]);

    /// The blocks are sent as they are, behind a length that fits them; a short frame is padded.
    #[rstest]
    #[case::one_element(&[2, 2])]
    #[case::several_elements(&[2, 3, 2, 4, 0x7F, 1])]
    fn elements_of_a_get_are_sent_as_given(#[case] octets: &[u8]) {
        let mut frame = Vec::new();
        Dcp::get(7, Vec::new()).write_frame(TO, FROM, &mut frame);
        let frame = with_blocks(frame, octets);
        assert_eq!(frame.len(), 60);
        let sent = Dcp::parse(&frame[14..]).expect("a DCP frame");
        let DcpBody::Elements(elements) = &sent.body else { panic!("a Get has elements") };
        let sent: Vec<u8> = elements.iter().flat_map(|element| [element.option, element.suboption]).collect();
        assert_eq!(sent, octets);
    }

    #[test]
    fn a_block_that_is_too_long_is_not_corrected() {
        let mut frame = Vec::new();
        Dcp::set(7, Vec::new()).write_frame(TO, FROM, &mut frame);
        let frame = with_blocks(frame, &[2, 2, 1, 0xF0, 0, 1]);
        assert_eq!(frame[24..32], [0, 6, 2, 2, 1, 0xF0, 0, 1]);
        assert!(Dcp::parse(&frame[14..]).is_err());
    }
}
