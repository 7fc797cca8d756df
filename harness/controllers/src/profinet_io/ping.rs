//! Packets in IP fragments, and the echo of ICMP.

use super::context::ControllerContext;
use super::jobs::ControllerJob;
use super::request::Partner;
use alloc::vec::Vec;
use core::net::{Ipv4Addr, SocketAddrV4};
use core::time::Duration;
use station::{Outbox, Time};
use wire::datagram::fragments::{FragmentCollector, LONGEST_FRAGMENT, OutgoingPacket, udp};
use wire::datagram::icmp::IcmpEcho;
use wire::datagram::{Ipv4, arp::Arp};
use wire::ethernet::Mac;

/// How a packet is sent in IP fragments.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FragmentedSending {
    /// Bytes of payload in each fragment; `None` for as many as fit in a frame.
    pub octets: Option<usize>,
    /// The fragments that are sent, in this order; `None` for all.
    pub sent: Option<Vec<usize>>,
}

impl FragmentedSending {
    /// Sends a packet.
    pub(super) fn send(&self, packet: &OutgoingPacket<'_>, out: &mut Outbox) {
        let frames = packet.frames(self.octets.unwrap_or(LONGEST_FRAGMENT));
        match &self.sent {
            None => frames.iter().for_each(|frame| out.push(frame)),
            Some(sent) => sent.iter().filter_map(|at| frames.get(*at)).for_each(|frame| out.push(frame)),
        }
    }

    /// Sends a datagram.
    pub(super) fn send_datagram(
        &self,
        identification: u16,
        from: (Partner, u16),
        to: (Partner, u16),
        payload: &[u8],
        out: &mut Outbox,
    ) {
        let end = |(station, port): (Partner, u16)| SocketAddrV4::new(station.ip, port);
        let packet = OutgoingPacket {
            source: (from.0.mac, from.0.ip),
            destination: (to.0.mac, to.0.ip),
            protocol: Ipv4::UDP,
            identification,
            payload: &udp(end(from), end(to), payload),
        };
        self.send(&packet, out);
    }
}

/// An echo request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PingRequest {
    /// The address that is asked; `None` for that of the device.
    pub ip: Option<Ipv4Addr>,
    /// The data.
    pub data: Vec<u8>,
    /// Whether the checksum is wrong.
    pub is_damaged: bool,
    /// How the packet is sent.
    pub fragments: FragmentedSending,
}

/// A reply to an echo request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PingReply {
    /// The reply, with the identifier and the sequence number of the request.
    pub echo: IcmpEcho,
    /// Whether it has the data of the request.
    pub has_same_data: bool,
}

/// An echo request that waits for its reply.
#[derive(Debug)]
pub(super) struct PingJob {
    device: Mac,
    request: IcmpEcho,
    collector: FragmentCollector,
    since: Time,
}

impl PingJob {
    /// How long the reply is awaited; the request is sent once.
    pub(super) const WAIT: Duration = Duration::from_secs(1);

    /// When it gives up.
    pub(super) fn until(&self) -> Time {
        self.since + PingJob::WAIT
    }

    /// The reply that a packet from `source` completes, if it does.
    pub(super) fn reply(&mut self, source: Mac, packet: &Ipv4<'_>) -> Option<PingReply> {
        if source != self.device || packet.protocol != Ipv4::ICMP {
            return None;
        }
        let echo = IcmpEcho::parse(&self.collector.add(packet)?).ok()?;
        let is_reply =
            echo.is_reply && (echo.identifier, echo.sequence) == (self.request.identifier, self.request.sequence);
        let has_same_data = echo.data == self.request.data;
        is_reply.then_some(PingReply { echo, has_same_data })
    }
}

/// Sends an echo request, after an ARP request from which the device learns where the reply goes, and begins to wait.
pub(super) fn ping(
    context: &mut ControllerContext,
    now: Time,
    partner: Partner,
    ping: &PingRequest,
    out: &mut Outbox,
) -> ControllerJob {
    let own = context.own;
    out.push_with(|octets| Arp::request(own.mac, own.ip, partner.ip).write_frame(octets));
    let number = context.ids.xid();
    let request = IcmpEcho {
        is_reply: false,
        identifier: (number >> 16) as u16,
        sequence: number as u16,
        data: ping.data.clone(),
    };
    let mut payload = request.to_vec();
    if ping.is_damaged {
        payload[2] ^= 0x55;
    }
    let packet = OutgoingPacket {
        source: (own.mac, own.ip),
        destination: (partner.mac, ping.ip.unwrap_or(partner.ip)),
        protocol: Ipv4::ICMP,
        identification: number as u16 | 1,
        payload: &payload,
    };
    ping.fragments.send(&packet, out);
    ControllerJob::Ping(PingJob { device: partner.mac, request, collector: FragmentCollector::default(), since: now })
}
