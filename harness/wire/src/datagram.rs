//! UDP over IPv4 over Ethernet, one datagram per frame; ARP in [`arp`].
//!
//! A datagram is read from one frame: PROFINET fragments long calls in RPC, not in IP. [`fragments`] has packets in several frames.
//! This module must not know ports, nor the content of a datagram.

pub mod arp;
pub mod fragments;
pub mod icmp;

use crate::error::{Result, WireError};
use crate::ethernet::{EtherType, FrameHeader, Mac, pad};
use crate::octets::ByteReader;
use alloc::vec::Vec;
use core::net::{Ipv4Addr, SocketAddrV4};
use smoltcp::phy::ChecksumCapabilities;
use smoltcp::wire::{IpProtocol, Ipv4Packet, Ipv4Repr, UdpPacket, UdpRepr};

const IPV4_HEADER: usize = 20;
const UDP_HEADER: usize = 8;

/// The longest payload of a datagram in one Ethernet frame, in bytes.
pub const LONGEST_PAYLOAD: usize = 1500 - IPV4_HEADER - UDP_HEADER;

/// The result of checking a checksum.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Checksum {
    /// It is correct.
    Good,
    /// It is 0 in UDP: the sender computed none (RFC 768).
    Absent,
    /// It is wrong; also in a capture taken before the network interface fills it in (checksum offload).
    Bad,
}

impl Checksum {
    fn from_agreement(agrees: bool) -> Checksum {
        if agrees { Checksum::Good } else { Checksum::Bad }
    }
}

/// An IPv4 packet, or one fragment of it (RFC 791, 3.1).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ipv4<'a> {
    /// The source address.
    pub source: Ipv4Addr,
    /// The destination address.
    pub destination: Ipv4Addr,
    /// Protocol number of the payload; 6 is TCP, 17 is UDP.
    pub protocol: u8,
    /// Identification, the same in all fragments of one packet.
    pub identification: u16,
    /// Flags and fragment offset: bit 15 reserved, 14 don't fragment (DF), 13 more fragments (MF), 12-0 offset in units of 8 bytes.
    pub fragment: u16,
    /// Time to live: the number of hops left.
    pub time_to_live: u8,
    /// The result of checking the header checksum.
    pub checksum: Checksum,
    /// Options, including their padding.
    pub options: &'a [u8],
    /// The data after the header, without the padding of the frame.
    pub payload: &'a [u8],
}

impl<'a> Ipv4<'a> {
    /// The protocol number of ICMP.
    pub const ICMP: u8 = 1;
    /// The protocol number of TCP.
    pub const TCP: u8 = 6;
    /// The protocol number of UDP.
    pub const UDP: u8 = 17;

    /// The packet in a frame, with the header of the frame; `None` if there is none that can be read.
    pub fn of_frame(frame: &'a [u8]) -> Option<(FrameHeader, Ipv4<'a>)> {
        let (header, payload) = FrameHeader::parse(frame).ok()?;
        (header.ether_type == EtherType::IPV4)
            .then(|| Ipv4::parse(payload).ok())
            .flatten()
            .map(|packet| (header, packet))
    }

    /// Parses the payload of a frame of [`EtherType::IPV4`]; a wrong checksum is not an error, see [`Ipv4::checksum`].
    pub fn parse(payload: &'a [u8]) -> Result<Ipv4<'a>> {
        let mut reader = ByteReader::new("IPv4", payload);
        let first = reader.u8()?;
        if first >> 4 != 4 {
            return Err(reader.wrong("Version", 1, "4", (first >> 4).into()));
        }
        let header_length = usize::from(first & 0x0f) * 4;
        if header_length < IPV4_HEADER {
            return Err(reader.wrong("IHL", 1, "at least 5", (first & 0x0f).into()));
        }
        reader.u8()?;
        let total_length = reader.u16()?;
        let Some(payload_length) = usize::from(total_length).checked_sub(header_length) else {
            return Err(reader.wrong("Total Length", 2, "at least the length of the header", total_length.into()));
        };
        let (identification, fragment) = (reader.u16()?, reader.u16()?);
        let (time_to_live, protocol) = (reader.u8()?, reader.u8()?);
        reader.u16()?;
        let (source, destination) = (Ipv4Addr::from(reader.u32()?), Ipv4Addr::from(reader.u32()?));
        let options = reader.take(header_length - IPV4_HEADER)?;
        let body = reader.take(payload_length)?;
        let checksum = Checksum::from_agreement(Ipv4Packet::new_unchecked(payload).verify_checksum());
        Ok(Ipv4 {
            source,
            destination,
            protocol,
            identification,
            fragment,
            time_to_live,
            checksum,
            options,
            payload: body,
        })
    }

    /// Whether this is a fragment of a packet.
    pub fn is_fragment(&self) -> bool {
        self.fragment & 0x3fff != 0
    }
}

/// A UDP datagram with its Ethernet and IP addresses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Datagram<'a> {
    /// Source MAC address.
    pub source_mac: Mac,
    /// Destination MAC address.
    pub destination_mac: Mac,
    /// Source IP address and port.
    pub source: SocketAddrV4,
    /// Destination IP address and port.
    pub destination: SocketAddrV4,
    /// The result of checking the IPv4 header checksum.
    pub ip_checksum: Checksum,
    /// The result of checking the UDP checksum.
    pub udp_checksum: Checksum,
    /// The payload of the datagram.
    pub payload: &'a [u8],
    /// Offset of the payload in the frame, in bytes.
    pub payload_offset: usize,
}

impl<'a> Datagram<'a> {
    /// Parses a whole frame, tagged or not; fails unless it is one unfragmented UDP datagram.
    ///
    /// Wrong checksums are not an error, see [`Datagram::checksum_ok`].
    pub fn parse(frame: &'a [u8]) -> Result<Datagram<'a>> {
        let (header, packet) = FrameHeader::parse(frame)?;
        let at = header.payload_offset();
        if header.ether_type != EtherType::IPV4 {
            return Err(wrong("Ethernet", at - 2, "EtherType", "0x0800 (IPv4)", header.ether_type.0.into()));
        }
        let ip = Ipv4::parse(packet).map_err(|error| error.at_offset(at))?;
        if ip.is_fragment() {
            return Err(wrong(
                "IPv4",
                at + 6,
                "Fragment Offset",
                "a packet that is not fragmented",
                ip.fragment.into(),
            ));
        }
        if ip.protocol != Ipv4::UDP {
            return Err(wrong("IPv4", at + 9, "Protocol", "17 (UDP)", ip.protocol.into()));
        }
        let at = at + IPV4_HEADER + ip.options.len();
        let (source_port, destination_port, udp_checksum, payload) =
            parse_udp(&ip).map_err(|error| error.at_offset(at))?;
        Ok(Datagram {
            source_mac: header.source,
            destination_mac: header.destination,
            source: SocketAddrV4::new(ip.source, source_port),
            destination: SocketAddrV4::new(ip.destination, destination_port),
            ip_checksum: ip.checksum,
            udp_checksum,
            payload,
            payload_offset: at + UDP_HEADER,
        })
    }

    /// Whether the IPv4 checksum is correct, and the UDP checksum is correct or absent.
    pub fn checksum_ok(&self) -> bool {
        self.ip_checksum == Checksum::Good && self.udp_checksum != Checksum::Bad
    }
}

fn wrong(layer: &'static str, offset: usize, field: &'static str, wanted: &'static str, found: u64) -> WireError {
    WireError::Value { layer, offset, field, expected: wanted, observed: found }
}

/// Parses the UDP datagram in `ip`: ports, checksum, payload.
fn parse_udp<'a>(ip: &Ipv4<'a>) -> Result<(u16, u16, Checksum, &'a [u8])> {
    let mut reader = ByteReader::new("UDP", ip.payload);
    let (source, destination) = (reader.u16()?, reader.u16()?);
    let length = reader.u16()?;
    let Some(payload_length) = usize::from(length).checked_sub(UDP_HEADER) else {
        return Err(reader.wrong("Length", 2, "at least 8", length.into()));
    };
    let sum = reader.u16()?;
    let payload = reader.take(payload_length)?;
    let checksum = if sum == 0 {
        Checksum::Absent
    } else {
        let packet = UdpPacket::new_unchecked(ip.payload);
        Checksum::from_agreement(packet.verify_checksum(&ip.source.into(), &ip.destination.into()))
    };
    Ok((source, destination, checksum, payload))
}

/// Appends a whole frame with one UDP datagram: with both checksums, DF set, padded to the minimum frame length.
///
/// Fails if `payload` is longer than [`LONGEST_PAYLOAD`]; `out` is then unchanged.
pub fn write_udp(
    source: (Mac, SocketAddrV4),
    destination: (Mac, SocketAddrV4),
    payload: &[u8],
    out: &mut Vec<u8>,
) -> Result<()> {
    if payload.len() > LONGEST_PAYLOAD {
        return Err(wrong("UDP", 4, "payload length", "at most 1472 bytes", payload.len() as u64));
    }
    let start = out.len();
    FrameHeader::new(destination.0, source.0, EtherType::IPV4).write(out);
    let ip_at = out.len();
    let udp_at = ip_at + IPV4_HEADER;
    out.resize(udp_at + UDP_HEADER + payload.len(), 0);
    let (source, destination) = (source.1, destination.1);
    let checksums = ChecksumCapabilities::default();
    Ipv4Repr {
        src_addr: *source.ip(),
        dst_addr: *destination.ip(),
        next_header: IpProtocol::Udp,
        payload_len: UDP_HEADER + payload.len(),
        hop_limit: 64,
    }
    .emit(&mut Ipv4Packet::new_unchecked(&mut out[ip_at..]), &checksums);
    UdpRepr { src_port: source.port(), dst_port: destination.port() }.emit(
        &mut UdpPacket::new_unchecked(&mut out[udp_at..]),
        &(*source.ip()).into(),
        &(*destination.ip()).into(),
        payload.len(),
        |octets| octets.copy_from_slice(payload),
        &checksums,
    );
    pad(out, start);
    Ok(())
}
