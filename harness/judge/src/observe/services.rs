//! RPC of PROFINET: selects packets, counts repetitions once, reassembles fragments.

use super::CallPart;
use super::tracker::{ReceivedFrame, Sink, Tracker};
use wire::WireError;
use wire::datagram::{Datagram, Ipv4};
use wire::profinet::rpc::{Assembled, Flags1, PORT, PacketType, RpcHeader, RpcPdu, Uuid};

impl Tracker {
    /// Processes an IPv4 packet if it carries RPC of PROFINET.
    pub(super) fn datagram(&mut self, received: &ReceivedFrame<'_>, sink: Sink<'_>) {
        let Some((ports, first)) = udp(received.payload) else {
            self.counts.other += 1;
            return;
        };
        let on_port = ports.0 == PORT || ports.1 == PORT;
        if !on_port && !matches!(first, [4, 0..=10]) {
            self.counts.other += 1;
            return;
        }
        let datagram = match Datagram::parse(received.octets) {
            Ok(datagram) => datagram,
            Err(error) if on_port => return self.unreadable(error, sink),
            Err(_) => {
                self.counts.other += 1;
                return;
            }
        };
        match RpcPdu::parse(datagram.payload) {
            Ok(pdu) if on_port || is_profinet_interface(pdu.header.interface) => {
                self.pdu(received, &pdu, datagram.payload_offset, sink)
            }
            Err(error) if on_port => self.unreadable(error.at_offset(datagram.payload_offset), sink),
            Ok(_) | Err(_) => self.counts.other += 1,
        }
    }

    fn pdu(&mut self, received: &ReceivedFrame<'_>, pdu: &RpcPdu<'_>, at: usize, sink: Sink<'_>) {
        self.counts.rpc(&pdu.header);
        if self.is_repeated(received) || pdu.header.interface == Uuid::ENDPOINT_MAPPER {
            return;
        }
        let key = (pdu.header.activity, pdu.header.sequence);
        let is_fragment = pdu.header.flags1.has(Flags1::FRAGMENT);
        let outcome = match pdu.header.packet_type {
            PacketType::REQUEST if is_fragment && self.calls.has_just_come(key, received.time) => Ok(()),
            PacketType::RESPONSE if !self.calls.waits(key) => Ok(()),
            PacketType::REQUEST | PacketType::RESPONSE => match self.fragments.take(pdu) {
                Assembled::Whole(body) if pdu.header.packet_type == PacketType::REQUEST => {
                    self.request(received, &pdu.header, &body, sink)
                }
                Assembled::Whole(body) => self.response(received, &pdu.header, &body, sink),
                Assembled::Waiting { .. } | Assembled::Repeated => Ok(()),
                Assembled::Contradicts | Assembled::Refused => Err(WireError::Value {
                    layer: "RPC header",
                    offset: 72,
                    field: "fragment_number",
                    expected: "a fragment that fits the others",
                    observed: pdu.header.fragment.into(),
                }),
            },
            PacketType::FAULT | PacketType::REJECT => self.failed(received, &pdu.header, pdu.body, sink),
            kind @ (PacketType::WORKING | PacketType::PING) => {
                let part = if kind == PacketType::PING { CallPart::Again } else { CallPart::Working };
                if let Some(what) = self.calls.waiting(key) {
                    self.report_call(received, key, what, part, sink);
                }
                Ok(())
            }
            _ => Ok(()),
        };
        match outcome {
            Ok(()) => {}
            // In a fragmented call offsets are counted from the start of the body.
            Err(error) if is_fragment => self.unreadable(error, sink),
            Err(error) => self.unreadable(error.at_offset(at + RpcHeader::LENGTH), sink),
        }
    }
}

/// The ports of a UDP packet or its first fragment, and the first two bytes of its payload.
fn udp(packet: &[u8]) -> Option<((u16, u16), &[u8])> {
    let header = usize::from(packet.first()? & 0x0F) * 4;
    let fragment = u16::from_be_bytes([*packet.get(6)?, *packet.get(7)?]) & 0x1FFF;
    if *packet.get(9)? != Ipv4::UDP || fragment != 0 {
        return None;
    }
    let port = |at: usize| Some(u16::from_be_bytes([*packet.get(at)?, *packet.get(at + 1)?]));
    let ports = (port(header)?, port(header + 2)?);
    let payload = packet.get(header + 8..).unwrap_or_default();
    Some((ports, payload.get(..2).unwrap_or(payload)))
}

/// Whether the interface is one of PROFINET or the endpoint mapper.
fn is_profinet_interface(interface: Uuid) -> bool {
    const PROFINET: [Uuid; 5] = [
        Uuid::DEVICE_INTERFACE,
        Uuid::CONTROLLER_INTERFACE,
        Uuid::SUPERVISOR_INTERFACE,
        Uuid::PARAMETER_SERVER_INTERFACE,
        Uuid::CIM_INTERFACE,
    ];
    PROFINET.contains(&interface) || interface == Uuid::ENDPOINT_MAPPER
}
