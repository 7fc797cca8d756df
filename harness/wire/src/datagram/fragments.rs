//! IPv4 packets in fragments (RFC 791, 3.2), and the packets that are put together again.

use super::{IPV4_HEADER, Ipv4};
use crate::ethernet::{EtherType, FrameHeader, Mac, pad};
use alloc::vec;
use alloc::vec::Vec;
use core::net::{Ipv4Addr, SocketAddrV4};
use smoltcp::phy::ChecksumCapabilities;
use smoltcp::wire::{UdpPacket, UdpRepr};

/// Bytes of payload in a fragment that fills a frame.
pub const LONGEST_FRAGMENT: usize = 1480;
/// Flag for more fragments.
const MORE_FRAGMENTS: u16 = 0x2000;
/// The fragment offset counts units of this many bytes.
const UNIT: usize = 8;
const UDP_HEADER: usize = 8;
const TIME_TO_LIVE: u8 = 64;

/// One packet that may be sent in fragments.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OutgoingPacket<'a> {
    /// MAC and IP address of the sender.
    pub source: (Mac, Ipv4Addr),
    /// MAC and IP address of the receiver.
    pub destination: (Mac, Ipv4Addr),
    /// Protocol number of the payload.
    pub protocol: u8,
    /// Identification, the same in all fragments.
    pub identification: u16,
    /// The whole payload.
    pub payload: &'a [u8],
}

impl OutgoingPacket<'_> {
    /// The frames with the packet: fragments with `octets` bytes of payload each, rounded down to a multiple of 8.
    pub fn frames(&self, octets: usize) -> Vec<Vec<u8>> {
        let octets = (octets.min(LONGEST_FRAGMENT) / UNIT * UNIT).max(UNIT);
        let count = self.payload.len().div_ceil(octets).max(1);
        let piece = |number: usize| {
            let start = number * octets;
            let end = (start + octets).min(self.payload.len());
            let more = if number + 1 < count { MORE_FRAGMENTS } else { 0 };
            self.frame(more | (start / UNIT) as u16, &self.payload[start..end])
        };
        (0..count).map(piece).collect()
    }

    fn frame(&self, fragment: u16, piece: &[u8]) -> Vec<u8> {
        let mut frame = Vec::new();
        FrameHeader::new(self.destination.0, self.source.0, EtherType::IPV4).write(&mut frame);
        let start = frame.len();
        frame.extend([0x45, 0]);
        frame.extend(((IPV4_HEADER + piece.len()) as u16).to_be_bytes());
        frame.extend(self.identification.to_be_bytes());
        frame.extend(fragment.to_be_bytes());
        frame.extend([TIME_TO_LIVE, self.protocol, 0, 0]);
        frame.extend(self.source.1.octets());
        frame.extend(self.destination.1.octets());
        let sum = checksum(&frame[start..]);
        frame[start + 10..start + 12].copy_from_slice(&sum.to_be_bytes());
        frame.extend(piece);
        pad(&mut frame, 0);
        frame
    }
}

/// A UDP datagram with its header and its checksum, the payload of an IPv4 packet.
pub fn udp(source: SocketAddrV4, destination: SocketAddrV4, payload: &[u8]) -> Vec<u8> {
    let mut octets = vec![0; UDP_HEADER + payload.len()];
    UdpRepr { src_port: source.port(), dst_port: destination.port() }.emit(
        &mut UdpPacket::new_unchecked(&mut octets),
        &(*source.ip()).into(),
        &(*destination.ip()).into(),
        payload.len(),
        |buffer| buffer.copy_from_slice(payload),
        &ChecksumCapabilities::default(),
    );
    octets
}

/// The checksum of the Internet protocols: the complement of the sum in one's complement (RFC 1071).
pub fn checksum(octets: &[u8]) -> u16 {
    let words = octets.chunks(2).map(|pair| u32::from(pair[0]) << 8 | u32::from(pair.get(1).copied().unwrap_or(0)));
    let mut sum: u32 = words.sum();
    while sum > 0xFFFF {
        sum = (sum & 0xFFFF) + (sum >> 16);
    }
    !(sum as u16)
}

/// Fragments of one packet, until they are complete.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FragmentCollector {
    identification: u16,
    pieces: Vec<(usize, Vec<u8>)>,
    /// The length of the payload, from the last fragment.
    length: Option<usize>,
}

impl FragmentCollector {
    /// Adds a packet or a fragment; returns the payload once it is complete. A fragment of another packet drops those
    /// of the last one.
    pub fn add(&mut self, packet: &Ipv4<'_>) -> Option<Vec<u8>> {
        if !packet.is_fragment() {
            return Some(packet.payload.to_vec());
        }
        if packet.identification != self.identification {
            *self = FragmentCollector { identification: packet.identification, ..FragmentCollector::default() };
        }
        let start = usize::from(packet.fragment & 0x1FFF) * UNIT;
        if packet.fragment & MORE_FRAGMENTS == 0 {
            self.length = Some(start + packet.payload.len());
        }
        self.pieces.push((start, packet.payload.to_vec()));
        self.pieces.sort();
        let mut whole = Vec::new();
        for (start, piece) in &self.pieces {
            // What an earlier piece has already is skipped.
            let known = whole.len().checked_sub(*start)?;
            whole.extend_from_slice(piece.get(known..).unwrap_or_default());
        }
        if self.length != Some(whole.len()) {
            return None;
        }
        *self = FragmentCollector::default();
        Some(whole)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Datagram;
    use super::*;
    use rstest::rstest;

    const ONE: (Mac, Ipv4Addr) = (Mac([2, 0, 0, 0, 0, 1]), Ipv4Addr::new(192, 168, 0, 1));
    const OTHER: (Mac, Ipv4Addr) = (Mac([2, 0, 0, 0, 0, 2]), Ipv4Addr::new(192, 168, 0, 2));

    fn packet(payload: &[u8]) -> OutgoingPacket<'_> {
        OutgoingPacket { source: ONE, destination: OTHER, protocol: Ipv4::UDP, identification: 7, payload }
    }

    /// The example of RFC 1071, 3: the sum of 00 01 f2 03 f4 f5 f6 f7 is ddf2.
    #[test]
    fn the_checksum_is_the_complement_of_the_sum() {
        assert_eq!(checksum(&[0x00, 0x01, 0xF2, 0x03, 0xF4, 0xF5, 0xF6, 0xF7]), !0xDDF2);
    }

    #[test]
    fn a_datagram_in_one_fragment_is_a_whole_datagram() {
        let (from, to) = (SocketAddrV4::new(ONE.1, 5), SocketAddrV4::new(OTHER.1, 6));
        let payload = udp(from, to, b"payload");
        let frames = packet(&payload).frames(LONGEST_FRAGMENT);
        let datagram = Datagram::parse(&frames[0]).expect("a datagram");
        assert!(frames.len() == 1 && datagram.checksum_ok());
        assert_eq!((datagram.source, datagram.destination, datagram.payload), (from, to, &b"payload"[..]));
    }

    #[rstest]
    #[case::in_order(&[0, 1, 2], true)]
    #[case::reversed(&[2, 1, 0], true)]
    #[case::one_twice(&[0, 0, 2, 1], true)]
    #[case::one_missing(&[0, 2], false)]
    #[case::last_missing(&[0, 1], false)]
    fn fragments_are_put_together(#[case] order: &[usize], #[case] is_whole: bool) {
        let payload: Vec<u8> = (0..44).collect();
        let frames = packet(&payload).frames(17);
        assert_eq!(frames.len(), 3);
        let mut collector = FragmentCollector::default();
        let mut whole = None;
        for number in order {
            let (_, octets) = FrameHeader::parse(&frames[*number]).expect("a frame");
            whole = whole.or(collector.add(&Ipv4::parse(octets).expect("a packet")));
        }
        assert_eq!(whole, is_whole.then_some(payload));
    }
}
