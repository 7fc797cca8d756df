//! IPv4 packets that arrive in fragments (RFC 791, 3.2; RFC 1122, 3.3.2).
//!
//! The IP stack behind this module takes whole packets only.

use alloc::borrow::Cow;
use alloc::vec::Vec;
use station::{Duration, Time};

/// Length of an IPv4 header without options.
const HEADER: usize = 20;
const MORE_FRAGMENTS: u16 = 0x2000;
const OFFSET: u16 = 0x1FFF;

/// An IPv4 packet that is not complete yet.
#[derive(Debug)]
struct PartialPacket {
    /// The header of the first fragment that arrived, without options.
    header: [u8; HEADER],
    /// Offset and payload of each fragment.
    fragments: Vec<(usize, Vec<u8>)>,
    /// Length of the whole payload, known from the last fragment.
    length: Option<usize>,
    /// When it is given up.
    until: Time,
}

impl PartialPacket {
    /// What all fragments of a packet have in common: identification, protocol and both addresses.
    fn key(header: &[u8; HEADER]) -> ([u8; 2], u8, [u8; 8]) {
        let mut addresses = [0; 8];
        addresses.copy_from_slice(&header[12..]);
        ([header[4], header[5]], header[9], addresses)
    }

    /// The whole payload, if no part of it is missing.
    fn payload(&self) -> Option<Vec<u8>> {
        let length = self.length?;
        let mut payload = Vec::with_capacity(length);
        while payload.len() < length {
            let at = payload.len();
            let (start, octets) =
                self.fragments.iter().find(|(start, octets)| *start <= at && at < start + octets.len())?;
            payload.extend_from_slice(&octets[at - start..]);
        }
        payload.truncate(length);
        Some(payload)
    }
}

/// Puts packets together.
#[derive(Debug, Default)]
pub(super) struct FragmentReassembler {
    packets: Vec<PartialPacket>,
}

impl FragmentReassembler {
    /// Number of packets that are put together at the same time. The oldest one is dropped first.
    const PACKETS: usize = 4;
    /// Longest payload of a packet in bytes.
    const LONGEST: usize = 8192;
    /// How long the missing fragments of a packet are awaited (RFC 1122, 3.3.2: between 60 s and 120 s).
    const TIMEOUT: Duration = Duration::from_secs(60);

    /// Takes the payload of an IPv4 frame. Returns a whole packet at once, and the packet that a fragment completes.
    pub(super) fn take<'p>(&mut self, now: Time, packet: &'p [u8]) -> Option<Cow<'p, [u8]>> {
        self.packets.retain(|partial| partial.until > now);
        let header: [u8; HEADER] = *packet.first_chunk()?;
        let fragment = u16::from_be_bytes([header[6], header[7]]);
        if fragment & (MORE_FRAGMENTS | OFFSET) == 0 {
            return Some(Cow::Borrowed(packet));
        }
        let header_length = usize::from(header[0] & 0x0F) * 4;
        let total = usize::from(u16::from_be_bytes([header[2], header[3]]));
        let octets = packet.get(header_length.max(HEADER)..total)?;
        let start = usize::from(fragment & OFFSET) * 8;
        if sum(packet.get(..header_length)?) != 0xFFFF || start + octets.len() > FragmentReassembler::LONGEST {
            return None;
        }
        let key = PartialPacket::key(&header);
        let known = self.packets.iter().position(|partial| PartialPacket::key(&partial.header) == key);
        let at = known.unwrap_or_else(|| {
            if self.packets.len() == FragmentReassembler::PACKETS {
                self.packets.remove(0);
            }
            let until = now + FragmentReassembler::TIMEOUT;
            self.packets.push(PartialPacket { header, fragments: Vec::new(), length: None, until });
            self.packets.len() - 1
        });
        let partial = self.packets.get_mut(at)?;
        if fragment & MORE_FRAGMENTS == 0 {
            partial.length = Some(start + octets.len());
        }
        if !partial.fragments.iter().any(|(known, of)| (*known, of.as_slice()) == (start, octets)) {
            partial.fragments.push((start, octets.to_vec()));
        }
        let payload = partial.payload()?;
        let header = partial.header;
        self.packets.remove(at);
        Some(Cow::Owned(packet_with(header, 0, &payload)))
    }
}

/// The sum of 16-bit words in one's complement (RFC 1071).
fn sum(octets: &[u8]) -> u16 {
    octets.chunks(2).fold(0, |sum: u16, word| {
        let word = u16::from_be_bytes([word[0], word.get(1).copied().unwrap_or_default()]);
        let (sum, carries) = sum.overflowing_add(word);
        sum + u16::from(carries)
    })
}

/// A packet with this header, without options, and this payload.
fn packet_with(mut header: [u8; HEADER], fragment: u16, payload: &[u8]) -> Vec<u8> {
    header[0] = 0x45;
    header[2..4].copy_from_slice(&((HEADER + payload.len()) as u16).to_be_bytes());
    header[6..8].copy_from_slice(&fragment.to_be_bytes());
    header[10..12].fill(0);
    let checksum = !sum(&header);
    header[10..12].copy_from_slice(&checksum.to_be_bytes());
    [&header[..], payload].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    const ICMP: u8 = 1;

    /// A packet with identification 7, from 10.0.0.1 to 10.0.0.2.
    fn fragment(fragment: u16, payload: &[u8]) -> Vec<u8> {
        let mut header = [0; HEADER];
        header[5] = 7;
        header[9] = ICMP;
        header[12..].copy_from_slice(&[10, 0, 0, 1, 10, 0, 0, 2]);
        packet_with(header, fragment, payload)
    }

    #[test]
    fn fragments_in_either_order_become_a_packet() {
        let (first, second) = (fragment(MORE_FRAGMENTS, &[1; 8]), fragment(1, &[2; 3]));
        let whole = fragment(0, &[1, 1, 1, 1, 1, 1, 1, 1, 2, 2, 2]);
        for [one, other] in [[&first, &second], [&second, &first]] {
            let mut of = FragmentReassembler::default();
            assert_eq!(of.take(Time::ZERO, one), None);
            assert_eq!(of.take(Time::ZERO, other).as_deref(), Some(&whole[..]));
            assert!(of.packets.is_empty());
        }
    }

    #[test]
    fn a_packet_is_given_up_after_60_s() {
        let mut of = FragmentReassembler::default();
        assert_eq!(of.take(Time::ZERO, &fragment(MORE_FRAGMENTS, &[1; 8])), None);
        let late = Time::ZERO + FragmentReassembler::TIMEOUT;
        assert_eq!(of.take(late, &fragment(1, &[2; 3])), None);
        assert_eq!(of.packets.len(), 1);
    }
}
