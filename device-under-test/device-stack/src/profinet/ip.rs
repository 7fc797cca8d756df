//! ARP, ICMP, UDP and TCP: smoltcp over a queue of frames.
//!
//! This module must not know the content of datagrams.

use super::hooks::AttachedStackHooks;
use super::reassembly::FragmentReassembler;
use super::snmp;
use super::web::{HttpServer, PageHandler};
use crate::profinet::StationData;
use alloc::borrow::Cow;
use alloc::collections::VecDeque;
use alloc::vec;
use alloc::vec::Vec;
use core::net::{Ipv4Addr, SocketAddrV4};
use smoltcp::iface::{Config, Interface, SocketHandle, SocketSet};
use smoltcp::phy::{self, DeviceCapabilities, Medium};
use smoltcp::socket::udp::{PacketBuffer, PacketMetadata, Socket};
use smoltcp::time::Instant;
use smoltcp::wire::{EthernetAddress, IpAddress, IpCidr, IpEndpoint, Ipv4Cidr};
use station::{Duration, Outbox, Time};
use wire::ethernet::{EtherType, FrameHeader, Mac, pad};
use wire::profinet::rpc;

/// Shortest time to the next poll: the resolution of the clock of smoltcp.
const POLL_INTERVAL: Duration = Duration::from_micros(1);

/// A UDP socket of the device.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RpcSocket {
    /// The socket for calls to the device: port 34964.
    Server,
    /// The socket for calls from the device: port 49153.
    Client,
    /// The socket of the SNMP agent: port 161.
    Agent,
}

/// A received datagram.
#[derive(Debug, PartialEq, Eq)]
pub(super) struct ReceivedDatagram {
    /// The socket that received it.
    pub port: RpcSocket,
    /// Address and port of the sender.
    pub from: SocketAddrV4,
    pub payload: Vec<u8>,
}

/// The IP stack of the device.
pub(super) struct IpStack {
    pipe: FramePipe,
    interface: Interface,
    sockets: SocketSet<'static>,
    server: SocketHandle,
    client: SocketHandle,
    agent: SocketHandle,
    web: HttpServer,
    fragments: FragmentReassembler,
    due: Option<Time>,
}

impl IpStack {
    /// The source port of calls from the device.
    pub(super) const CLIENT_PORT: u16 = 0xC001;
    const DATAGRAMS: usize = 64;
    /// Receive buffer in bytes. The stack takes each datagram before the next one arrives.
    const RECEIVED: usize = 8 * 1024;
    /// Send buffer in bytes, for datagrams that wait for ARP: the longest record in fragments.
    const SENT: usize = 32 * 1024;

    /// An IP stack without an address.
    pub(super) fn new(now: Time, mac: Mac, hooks: &AttachedStackHooks) -> IpStack {
        let mut pipe = FramePipe::default();
        let config = Config::new(EthernetAddress(mac.0).into());
        let interface = Interface::new(config, &mut pipe, instant(now));
        let mut sockets = SocketSet::new(Vec::new());
        let mut open = |port: u16| {
            let buffer = |octets| PacketBuffer::new(vec![PacketMetadata::EMPTY; IpStack::DATAGRAMS], vec![0; octets]);
            let mut socket = Socket::new(buffer(IpStack::RECEIVED), buffer(IpStack::SENT));
            let bound = socket.bind(port);
            debug_assert!(bound.is_ok(), "a new socket is not bound, and the port is not 0");
            sockets.add(socket)
        };
        let client_port = hooks.apply(IpStack::CLIENT_PORT, |hooks, port| hooks.client_port(port));
        let (server, client, agent) = (open(rpc::PORT), open(client_port), open(snmp::PORT));
        let web = HttpServer::new(&mut sockets);
        IpStack {
            pipe,
            interface,
            sockets,
            server,
            client,
            agent,
            web,
            fragments: FragmentReassembler::default(),
            due: None,
        }
    }

    /// Sets the addresses of `station`. Without an address the stack answers no request.
    pub(super) fn configure(&mut self, station: &StationData) {
        // smoltcp panics at the address of a group.
        let is_group = |address: &Ipv4Addr| address.is_multicast() || address.is_broadcast();
        let address = Some(Ipv4Addr::from(station.ip)).filter(|address| !is_group(address));
        let address = address.unwrap_or(Ipv4Addr::UNSPECIFIED);
        let prefix = u32::from_be_bytes(station.mask).leading_ones() as u8;
        if !self.interface.has_ip_addr(address) {
            self.web.forget(&mut self.sockets);
        }
        self.interface.update_ip_addrs(|addresses| {
            addresses.clear();
            if !address.is_unspecified() {
                // The list is empty and can hold at least one address.
                addresses.push(IpCidr::Ipv4(Ipv4Cidr::new(address, prefix))).ok();
            }
        });
        let gateway = Ipv4Addr::from(station.gateway);
        let routes = self.interface.routes_mut();
        routes.remove_default_ipv4_route();
        if !gateway.is_unspecified() && gateway != address {
            // The table is empty and can hold at least one route.
            routes.add_default_ipv4_route(gateway).ok();
        }
    }

    /// Processes a frame with ARP or IPv4.
    pub(super) fn receive(&mut self, now: Time, header: &FrameHeader, payload: &[u8], out: &mut Outbox) {
        let payload = match header.ether_type {
            EtherType::IPV4 => match self.fragments.take(now, payload) {
                Some(packet) => packet,
                None => return,
            },
            _ => Cow::Borrowed(payload),
        };
        let mut frame = Vec::with_capacity(FrameHeader::UNTAGGED_LENGTH + payload.len());
        FrameHeader { tag: None, inner_tag: None, ..*header }.write(&mut frame);
        frame.extend_from_slice(&payload);
        self.pipe.incoming = Some(frame);
        self.poll(now, out);
    }

    /// Whether a frame of this type is for this stack.
    pub(super) fn takes(ether_type: EtherType) -> bool {
        matches!(ether_type, EtherType::IPV4 | EtherType::ARP)
    }

    /// The next received datagram.
    pub(super) fn next(&mut self) -> Option<ReceivedDatagram> {
        let ports =
            [(RpcSocket::Server, self.server), (RpcSocket::Client, self.client), (RpcSocket::Agent, self.agent)];
        ports.into_iter().find_map(|(port, handle)| {
            let (payload, meta) = self.sockets.get_mut::<Socket<'_>>(handle).recv().ok()?;
            let IpAddress::Ipv4(address) = meta.endpoint.addr;
            Some(ReceivedDatagram {
                port,
                from: SocketAddrV4::new(address, meta.endpoint.port),
                payload: payload.to_vec(),
            })
        })
    }

    /// Sends a datagram as soon as the MAC address of the receiver is known. If the buffer is full, the datagram is
    /// lost.
    pub(super) fn send(&mut self, now: Time, port: RpcSocket, to: SocketAddrV4, payload: &[u8], out: &mut Outbox) {
        let handle = match port {
            RpcSocket::Server => self.server,
            RpcSocket::Client => self.client,
            RpcSocket::Agent => self.agent,
        };
        let endpoint = IpEndpoint::new(IpAddress::Ipv4(*to.ip()), to.port());
        if self.sockets.get_mut::<Socket<'_>>(handle).send_slice(payload, endpoint).is_ok() {
            self.poll(now, out);
        }
    }

    /// Answers requests to the web server.
    pub(super) fn serve(&mut self, now: Time, is_open: bool, pages: PageHandler<'_>, out: &mut Outbox) {
        while self.web.serve(&mut self.sockets, is_open, pages) {
            self.poll(now, out);
        }
    }

    /// When the next timer of the IP stack expires.
    pub(super) fn due(&self) -> Option<Time> {
        self.due
    }

    /// Does what is due and sends the frames that are ready.
    pub(super) fn poll(&mut self, now: Time, out: &mut Outbox) {
        let instant = instant(now);
        self.interface.poll(instant, &mut self.pipe, &mut self.sockets);
        for frame in self.pipe.outgoing.drain(..) {
            out.push_with(|buffer| {
                let start = buffer.len();
                buffer.extend_from_slice(&frame);
                pad(buffer, start);
            });
        }
        let due = self.interface.poll_at(instant, &self.sockets);
        let soonest = now + POLL_INTERVAL;
        self.due = due.map(|due| soonest.max(Time::ZERO + Duration::from_micros(due.total_micros().unsigned_abs())));
    }
}

fn instant(time: Time) -> Instant {
    Instant::from_micros(i64::try_from(time.as_nanos() / 1000).unwrap_or(i64::MAX))
}

/// A network device for smoltcp: one received frame, any number of frames to send.
#[derive(Debug, Default)]
struct FramePipe {
    incoming: Option<Vec<u8>>,
    outgoing: VecDeque<Vec<u8>>,
}

impl phy::Device for FramePipe {
    type RxToken<'a> = RxFrame;
    type TxToken<'a> = TxFrame<'a>;

    fn receive(&mut self, _: Instant) -> Option<(RxFrame, TxFrame<'_>)> {
        Some((RxFrame(self.incoming.take()?), TxFrame(&mut self.outgoing)))
    }

    fn transmit(&mut self, _: Instant) -> Option<TxFrame<'_>> {
        Some(TxFrame(&mut self.outgoing))
    }

    fn capabilities(&self) -> DeviceCapabilities {
        let mut capabilities = DeviceCapabilities::default();
        capabilities.medium = Medium::Ethernet;
        capabilities.max_transmission_unit = 1514;
        capabilities
    }
}

struct RxFrame(Vec<u8>);

impl phy::RxToken for RxFrame {
    fn consume<R, F: FnOnce(&[u8]) -> R>(self, take: F) -> R {
        take(&self.0)
    }
}

struct TxFrame<'a>(&'a mut VecDeque<Vec<u8>>);

impl phy::TxToken for TxFrame<'_> {
    fn consume<R, F: FnOnce(&mut [u8]) -> R>(self, length: usize, fill: F) -> R {
        let mut frame = vec![0; length];
        let result = fill(&mut frame);
        self.0.push_back(frame);
        result
    }
}
