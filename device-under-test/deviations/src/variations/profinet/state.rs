//! The parts of the variations of PROFINET that have state or change frames byte by byte.

use crate::seams::late::FrameTopic;
use crate::seams::stack::{cyclic, profinet};
use alloc::vec;
use alloc::vec::Vec;
use core::time::Duration;
use device_stack::profinet::{StackCheck, StackHooks, StackView, StationData, StationLoad};
use station::Time;
use wire::datagram::arp::Arp;
use wire::datagram::{Datagram, write_udp};
use wire::ethernet::{EtherType, FrameHeader, pad};
use wire::profinet::blocks::connect::{Connect, ConnectBlock, ConnectContent};
use wire::profinet::rpc::{Opnum, PacketType, RpcHeader, RpcPdu};
use wire::profinet::status::{CmrpcError, ErrorCode, ErrorSource, PnioStatus};

/// Writes the datagram of a frame again, with another RPC header.
pub fn with_header(frame: &mut Vec<u8>, change: impl FnOnce(&mut RpcHeader)) {
    let Ok(datagram) = Datagram::parse(frame) else { return };
    let Ok(pdu) = RpcPdu::parse(datagram.payload) else { return };
    let mut header = pdu.header;
    change(&mut header);
    if header != pdu.header {
        let payload = RpcPdu::new(header, pdu.body).to_vec();
        *frame = datagram_with(&datagram, datagram.source.port(), &payload);
    }
}

/// Sends the datagrams from port `from` from port `port` instead.
pub fn with_source_port(frame: &mut Vec<u8>, from: u16, port: u16) {
    let Ok(datagram) = Datagram::parse(frame) else { return };
    if datagram.source.port() == from && RpcPdu::parse(datagram.payload).is_ok() {
        *frame = datagram_with(&datagram, port, datagram.payload);
    }
}

fn datagram_with(datagram: &Datagram<'_>, port: u16, payload: &[u8]) -> Vec<u8> {
    let mut source = datagram.source;
    source.set_port(port);
    let mut frame = Vec::new();
    let (from, to) = ((datagram.source_mac, source), (datagram.destination_mac, datagram.destination));
    // The payload was in a frame before, and it has the same length.
    write_udp(from, to, payload, &mut frame).ok();
    frame
}

/// Says `working` before each response to a call of the device interface.
pub enum SaysWorking {}

impl SaysWorking {
    /// The PDU `working` for the first fragment of a response.
    pub fn before_response(topic: FrameTopic, frame: &[u8]) -> Vec<(Duration, Vec<u8>)> {
        if !matches!(topic, FrameTopic::Response(opnum) if opnum != Opnum::EPT_LOOKUP) {
            return Vec::new();
        }
        let mut working = frame.to_vec();
        let Ok(datagram) = Datagram::parse(frame) else { return Vec::new() };
        let Ok(pdu) = RpcPdu::parse(datagram.payload) else { return Vec::new() };
        if pdu.header.fragment != 0 {
            return Vec::new();
        }
        let header = RpcHeader { packet_type: PacketType::WORKING, body_length: 0, ..pdu.header };
        working.clear();
        working.extend(datagram_with(&datagram, datagram.source.port(), &RpcPdu::new(header, &[]).to_vec()));
        vec![(Duration::ZERO, working)]
    }
}

/// Repeats RPC PDUs.
pub enum AnswersTwice {}

impl AnswersTwice {
    /// Each response once more after 30 ms.
    pub fn response(topic: FrameTopic, frame: &[u8]) -> Vec<(Duration, Vec<u8>)> {
        match topic {
            FrameTopic::Response(_) => vec![(Duration::from_millis(30), frame.to_vec())],
            _ => Vec::new(),
        }
    }

    /// The call ApplicationReady twice more, 10 ms apart.
    pub fn application_ready(topic: FrameTopic, frame: &[u8]) -> Vec<(Duration, Vec<u8>)> {
        match topic {
            FrameTopic::Request(Opnum::CONTROL) => {
                [10, 20].map(|after| (Duration::from_millis(after), frame.to_vec())).into()
            }
            _ => Vec::new(),
        }
    }
}

/// The same frame once more, if it is about `of`.
pub fn repeat(topic: FrameTopic, frame: &[u8], of: FrameTopic, after: Duration) -> Vec<(Duration, Vec<u8>)> {
    if topic == of { vec![(after, frame.to_vec())] } else { Vec::new() }
}

/// Changes the blocks of the answer to an accepted Connect.
pub fn changed_blocks(header: &RpcHeader, blocks: &mut Vec<u8>, change: impl FnOnce(&mut Vec<ConnectBlock>)) {
    if header.opnum != Opnum::CONNECT || blocks.is_empty() {
        return;
    }
    let Ok(mut connect) = Connect::parse(blocks) else { return };
    change(&mut connect.blocks);
    *blocks = connect.to_vec();
}

/// Changes what is in each block of the answer to an accepted Connect.
pub fn changed_contents(header: &RpcHeader, blocks: &mut Vec<u8>, change: impl FnMut(&mut ConnectContent)) {
    changed_blocks(header, blocks, |blocks| blocks.iter_mut().map(|block| &mut block.content).for_each(change));
}

/// Sorts the blocks of the answer to an accepted Connect.
pub fn blocks_in_order(header: &RpcHeader, blocks: &mut Vec<u8>, place: fn(&ConnectContent) -> u8) {
    changed_blocks(header, blocks, |blocks| blocks.sort_by_key(|block| place(&block.content)));
}

/// Gives another reason for the refusal of a connection too many.
pub fn refuse(header: &RpcHeader, status: &mut PnioStatus, error: CmrpcError) {
    let of = |error: CmrpcError| PnioStatus::found(ErrorCode::CONNECT_RESPONSE, ErrorSource::CMRPC, error.0);
    if header.opnum == Opnum::CONNECT && *status == of(CmrpcError::OUT_OF_AR_RESOURCES) {
        *status = of(error);
    }
}

/// Gives the outputs of a frame to the application with the next frame. The end of outputs is not delayed.
#[derive(Default)]
pub struct LateOutputs {
    before: Vec<((u16, u16), Vec<u8>)>,
}

impl StackHooks for LateOutputs {
    fn outputs(&mut self, slot: u16, subslot: u16, data: &mut Option<Vec<u8>>) {
        let at = self.before.iter().position(|(place, _)| *place == (slot, subslot));
        let before = at.map(|at| self.before.swap_remove(at).1);
        if let Some(now) = data.as_ref() {
            self.before.push(((slot, subslot), now.clone()));
            *data = before;
        }
    }

    fn load_station(&mut self, _: StationLoad, _: &mut StationData) {
        self.before.clear();
    }
}

/// Sends no cyclic frame before ApplicationReady, but the first one after a third of the data hold time at the latest.
#[derive(Default)]
pub struct FirstFrameWaits {
    hold: Duration,
    is_waiting: bool,
    since: Option<Time>,
}

impl StackHooks for FirstFrameWaits {
    fn data_hold_time(&mut self, agreed: Duration) -> Duration {
        self.hold = agreed;
        agreed
    }

    fn check(&mut self, check: StackCheck<'_>, verdict: bool) -> bool {
        // Where another connection is open, its frames go on.
        if let StackCheck::ConnectionLimit { is_exchange: true, others: 0 } = check {
            (self.is_waiting, self.since) = (true, None);
        }
        verdict
    }

    fn sent_frame(&mut self, view: &StackView<'_>, frame: &mut Vec<u8>) {
        if !self.is_waiting {
            return;
        }
        if FrameTopic::of(frame) == FrameTopic::Request(Opnum::CONTROL) {
            self.is_waiting = false;
        } else if cyclic(frame).is_some() {
            let since = *self.since.get_or_insert(view.now);
            self.is_waiting = view.now < since + self.hold / 3;
            if self.is_waiting {
                frame.clear();
            }
        }
    }
}

/// Announces each new IP address by a gratuitous ARP before the next frame.
#[derive(Default)]
pub struct AnnouncesAddress {
    announces: bool,
    frame: Option<(Time, Vec<u8>)>,
}

impl StackHooks for AnnouncesAddress {
    fn set_station(&mut self, before: &StationData, station: &mut StationData, _: &mut StationData) {
        self.announces |= before.ip != station.ip && station.ip != [0; 4];
    }

    fn load_station(&mut self, _: StationLoad, station: &mut StationData) {
        self.announces |= station.ip != [0; 4];
    }

    fn sent_frame(&mut self, view: &StackView<'_>, _: &mut Vec<u8>) {
        if core::mem::take(&mut self.announces) && view.station.ip != [0; 4] {
            let ip = view.station.ip.into();
            let mut frame = Vec::new();
            Arp::request(view.mac, ip, ip).write_frame(&mut frame);
            self.frame = Some((view.now, frame));
        }
    }

    fn due(&mut self, due: Option<Time>) -> Option<Time> {
        self.frame.iter().map(|(at, _)| *at).chain(due).min()
    }

    fn late_sent(&mut self, _: Time, frames: &mut Vec<Vec<u8>>) {
        frames.extend(self.frame.take().map(|(_, frame)| frame));
    }
}

/// Removes the VLAN tag of a frame.
pub fn untagged(frame: &mut Vec<u8>) {
    let Ok((header, payload)) = FrameHeader::parse(frame) else { return };
    if header.tag.is_some() {
        let payload = payload.to_vec();
        frame.clear();
        FrameHeader { tag: None, inner_tag: None, ..header }.write(frame);
        frame.extend(payload);
        pad(frame, 0);
    }
}

/// Replaces the padding of a DCP, alarm, ARP or UDP frame by `byte`.
pub fn pad_with(frame: &mut [u8], byte: u8) {
    let Some(end) = contents(frame) else { return };
    if let Some(padding) = frame.get_mut(end..) {
        padding.fill(byte);
    }
}

/// Where the contents of a frame end that is padded; `None` if it cannot be known.
fn contents(frame: &[u8]) -> Option<usize> {
    let length = |at: usize| Some(usize::from(u16::from_be_bytes([*frame.get(at)?, *frame.get(at + 1)?])));
    if let Some((_, at, frame_id)) = profinet(frame) {
        return match FrameTopic::of(frame) {
            FrameTopic::Identify | FrameTopic::Dcp(_) => Some(at + 12 + length(at + 10)?),
            // RTA: FrameID, endpoints, type, flags, sequence numbers, length.
            _ if wire::profinet::alarm::AlarmPriority::from_frame_id(frame_id.0).is_some() => {
                Some(at + 14 + length(at + 12)?)
            }
            _ => None,
        };
    }
    let (header, payload) = FrameHeader::parse(frame).ok()?;
    let at = frame.len() - payload.len();
    match header.ether_type {
        EtherType::ARP => Some(at + 28),
        EtherType::IPV4 => Some(at + length(at + 2)?),
        _ => None,
    }
}
