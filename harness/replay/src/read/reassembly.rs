//! Reassembles the IP fragments of a capture (RFC 791, 3.2).
//!
//! `etherparse` reads the Ethernet header and the 802.1Q tags of each frame, the IPv4 header of each packet and the UDP header of
//! each fragmented datagram. Whole frames pass unchanged; the frame that completes a fragmented datagram stands for the whole one.
//! Memory is bounded, and the result depends only on the frames and their times. This module must not know what a datagram means.

use etherparse::defrag::{IpDefragBuf, IpFragRange};
use etherparse::{
    EtherType, Ethernet2HeaderSlice, IpFragOffset, IpNumber, Ipv4Header, Ipv4Slice, SingleVlanSlice, UdpHeader,
    UdpHeaderSlice, UdpSlice,
};
use station::{Duration, Time};
use std::net::Ipv4Addr;

/// How long a datagram waits for its fragments. They are sent back to back, and an unanswered RPC is not repeated sooner.
const PATIENCE: Duration = Duration::from_secs(1);
/// A fragment of a datagram completed less than this ago is a copy made by a mirror port.
const MIRROR: Duration = Duration::from_millis(1);
/// Upper limit of the datagrams reassembled at the same time; the oldest is given up first.
const MOST_DATAGRAMS: usize = 32;
/// The longest payload of an IPv4 packet without options.
const LONGEST: usize = 65_515;
/// Tags read before the EtherType, as in `wire`.
const MOST_TAGS: usize = 2;

/// What a frame is for the reassembly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reassembled {
    /// Not a fragment of UDP, or one that cannot be used: the frame stands for itself.
    Untouched,
    /// A fragment of an incomplete datagram, or a repeated fragment.
    Part,
    /// It completes a datagram: [`IpReassembler::whole`] has the reassembled frame.
    Whole,
}

/// A datagram that cannot be reassembled.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LostDatagram {
    /// The number of the last frame with a fragment of it.
    pub frame: u64,
    /// The time of that frame.
    pub time: Time,
    /// The UDP ports, source and destination.
    pub ports: (u16, u16),
    /// Which datagram it is and why it is lost.
    pub why: String,
}

/// Reassembles a bounded number of datagrams.
#[derive(Debug, Default)]
pub struct IpReassembler {
    /// The datagrams, in the order in which they began.
    datagrams: Vec<PartialDatagram>,
    lost: Vec<LostDatagram>,
    whole: Vec<u8>,
    spare: Vec<Vec<u8>>,
}

/// What the fragments of one datagram have in common (RFC 791, 2.3); with tags stripped by a mirror port it is another datagram.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct DatagramKey {
    /// Destination, then source.
    macs: [[u8; 6]; 2],
    vlans: [Option<u16>; MOST_TAGS],
    source: Ipv4Addr,
    destination: Ipv4Addr,
    identification: u16,
}

/// A fragment of a UDP datagram.
#[derive(Debug)]
struct IpFragment<'a> {
    key: DatagramKey,
    header: Ipv4Header,
    /// The bytes before the IPv4 header.
    link: &'a [u8],
    offset: IpFragOffset,
    more: bool,
    payload: &'a [u8],
}

#[derive(Debug)]
struct PartialDatagram {
    key: DatagramKey,
    parts: IpDefragBuf,
    /// The link header and IPv4 header of the first fragment.
    head: Option<(Vec<u8>, Ipv4Header)>,
    first: (u64, Time),
    last: (u64, Time),
    is_complete: bool,
}

impl IpReassembler {
    /// Takes in the next frame; `number` counts from 1, and `time` must not step back without [`interrupt`](Self::interrupt).
    pub fn take(&mut self, number: u64, time: Time, octets: &[u8]) -> Reassembled {
        if !self.datagrams.is_empty() {
            self.expire(time);
        }
        match IpFragment::read(octets) {
            Some(fragment) => self.fragment(number, time, &fragment),
            None => Reassembled::Untouched,
        }
    }

    /// The reassembled frame of the last [`Reassembled::Whole`].
    pub fn whole(&self) -> &[u8] {
        &self.whole
    }

    /// The datagrams lost since the last call whose ports are known, in the order of their loss.
    pub fn lost(&mut self) -> impl Iterator<Item = LostDatagram> {
        self.lost.drain(..)
    }

    /// Gives up all incomplete datagrams: frames may be missing, the clock was set, or the capture ended.
    pub fn interrupt(&mut self) {
        while !self.datagrams.is_empty() {
            self.give_up(0, "the capture may have lost frames");
        }
    }

    fn expire(&mut self, now: Time) {
        while let Some(oldest) = self.datagrams.first()
            && oldest.first.1 + PATIENCE < now
        {
            self.give_up(0, "the rest did not follow within a second");
        }
    }

    fn fragment(&mut self, number: u64, time: Time, fragment: &IpFragment<'_>) -> Reassembled {
        if let Some(at) = self.datagrams.iter().position(|datagram| datagram.key == fragment.key) {
            let datagram = &mut self.datagrams[at];
            if datagram.is_complete {
                if datagram.has(fragment) && time.since(datagram.last.1) < MIRROR {
                    return Reassembled::Part;
                }
                // The sender uses the same identification again.
                self.give_up(at, "");
            } else {
                datagram.last = (number, time);
                if datagram.add(fragment) {
                    return self.complete(at);
                }
                self.give_up(at, "its fragments contradict each other");
            }
        }
        if self.datagrams.len() >= MOST_DATAGRAMS {
            let done = self.datagrams.iter().position(|datagram| datagram.is_complete);
            self.give_up(done.unwrap_or(0), "too many other datagrams came in between");
        }
        // `IpDefragBuf` relies on the length of its buffer, and every byte of it must be initialised.
        let octets = self.spare.pop().unwrap_or_else(|| vec![0; LONGEST]);
        let mut datagram = PartialDatagram {
            key: fragment.key,
            parts: IpDefragBuf::new(IpNumber::UDP, octets, Vec::new()),
            head: None,
            first: (number, time),
            last: (number, time),
            is_complete: false,
        };
        if !datagram.add(fragment) {
            self.spare.push(datagram.parts.take_bufs().0);
            return Reassembled::Untouched;
        }
        self.datagrams.push(datagram);
        Reassembled::Part
    }

    /// Builds the frame of the datagram at `at`, if no fragment is missing.
    fn complete(&mut self, at: usize) -> Reassembled {
        let Some(datagram) = self.datagrams.get_mut(at).filter(|datagram| datagram.parts.is_complete()) else {
            return Reassembled::Part;
        };
        let octets = datagram.parts.data();
        let Some((link, mut header)) = datagram.head.clone() else { return Reassembled::Part };
        let belongs_together = UdpSlice::from_slice(octets).map_or(true, |udp| is_intact(&udp, &header));
        if !belongs_together || header.set_payload_len(octets.len()).is_err() {
            self.give_up(at, "its fragments do not belong together (UDP checksum or length)");
            return Reassembled::Part;
        }
        (header.more_fragments, header.fragment_offset) = (false, IpFragOffset::ZERO);
        header.header_checksum = header.calc_header_checksum();
        self.whole.clear();
        self.whole.extend_from_slice(&link);
        self.whole.extend_from_slice(&header.to_bytes());
        self.whole.extend_from_slice(octets);
        datagram.is_complete = true;
        Reassembled::Whole
    }

    /// Drops a datagram; an incomplete one is lost.
    fn give_up(&mut self, at: usize, why: &str) {
        let datagram = self.datagrams.remove(at);
        self.lost.extend(datagram.lost(why));
        self.spare.push(datagram.parts.take_bufs().0);
    }
}

impl<'a> IpFragment<'a> {
    /// The fragment of a UDP datagram in a frame; `None` if there is nothing to reassemble.
    #[inline]
    fn read(octets: &'a [u8]) -> Option<IpFragment<'a>> {
        let ethernet = Ethernet2HeaderSlice::from_slice(octets).ok()?;
        let mut ether_type = ethernet.ether_type();
        let mut at = ethernet.slice().len();
        let mut vlans = [None; MOST_TAGS];
        for vlan in &mut vlans {
            if !matches!(ether_type, EtherType::VLAN_TAGGED_FRAME | EtherType::PROVIDER_BRIDGING) {
                break;
            }
            let tag = SingleVlanSlice::from_slice(octets.get(at..)?).ok()?;
            *vlan = Some(tag.vlan_identifier().value());
            ether_type = tag.ether_type();
            at += tag.header_slice().len();
        }
        if ether_type != EtherType::IPV4 {
            return None;
        }
        let (link, packet) = octets.split_at_checked(at)?;
        let packet = Ipv4Slice::from_slice(packet).ok()?;
        let header = packet.header();
        let payload = packet.payload();
        if !header.is_fragmenting_payload() || payload.ip_number != IpNumber::UDP || payload.payload.is_empty() {
            return None;
        }
        let key = DatagramKey {
            macs: [ethernet.destination(), ethernet.source()],
            vlans,
            source: header.source_addr(),
            destination: header.destination_addr(),
            identification: header.identification(),
        };
        let (offset, more) = (header.fragments_offset(), header.more_fragments());
        Some(IpFragment { key, header: header.to_header(), link, offset, more, payload: payload.payload })
    }

    fn begin(&self) -> usize {
        self.offset.byte_offset().into()
    }

    fn end(&self) -> usize {
        self.begin() + self.payload.len()
    }
}

impl PartialDatagram {
    /// Adds a fragment; returns whether it agrees with the bytes that are already there.
    fn add(&mut self, fragment: &IpFragment<'_>) -> bool {
        let ends_too_early = |range: &IpFragRange| !fragment.more && usize::from(range.end) > fragment.end();
        let differs = |range: &IpFragRange| {
            let from = usize::from(range.start).max(fragment.begin());
            let to = usize::from(range.end).min(fragment.end());
            from < to && !self.is_same(fragment, from, to)
        };
        let ranges = self.parts.sections();
        if fragment.end() > LONGEST || ranges.iter().any(|range| ends_too_early(range) || differs(range)) {
            return false;
        }
        if self.parts.add(fragment.offset, fragment.more, fragment.payload).is_err() {
            return false;
        }
        if fragment.begin() == 0 && self.head.is_none() {
            self.head = Some((fragment.link.to_vec(), fragment.header.clone()));
        }
        true
    }

    /// Whether the bytes `from..to` are those of the fragment.
    fn is_same(&self, fragment: &IpFragment<'_>, from: usize, to: usize) -> bool {
        let begin = fragment.begin();
        self.parts.data().get(from..to) == fragment.payload.get(from - begin..to - begin)
    }

    /// Whether all bytes of a fragment are already there.
    fn has(&self, fragment: &IpFragment<'_>) -> bool {
        let covers = |range: &IpFragRange| {
            usize::from(range.start) <= fragment.begin() && fragment.end() <= usize::from(range.end)
        };
        self.parts.sections().iter().any(covers) && self.is_same(fragment, fragment.begin(), fragment.end())
    }

    /// The loss to report; `None` if the datagram is complete or its ports are not known.
    fn lost(&self, why: &str) -> Option<LostDatagram> {
        if self.is_complete {
            return None;
        }
        let mut ranges = self.parts.sections().clone();
        ranges.sort_unstable_by_key(|range| range.start);
        let first = ranges.first().filter(|range| range.start == 0)?;
        let udp = UdpHeaderSlice::from_slice(self.parts.data().get(..first.end.into())?).ok()?;
        let mut gaps: Vec<String> =
            ranges.windows(2).map(|pair| format!("bytes {} to {}", pair[0].end, pair[1].start - 1)).collect();
        if self.parts.end().is_none() {
            gaps.extend(ranges.last().map(|range| format!("what follows byte {}", range.end - 1)));
        }
        let missing = if gaps.is_empty() { String::new() } else { format!(" {} missing;", gaps.join(", ")) };
        let DatagramKey { source, destination, identification, .. } = self.key;
        let why = format!(
            "IPv4: datagram 0x{identification:04X} from {source} to {destination}, fragmented since frame {}, cannot be \
     reassembled:{missing} {why}",
            self.first.0
        );
        let (frame, time) = self.last;
        Some(LostDatagram { frame, time, ports: (udp.source_port(), udp.destination_port()), why })
    }
}

/// Whether the UDP checksum is correct; a sender may have computed none (RFC 768).
fn is_intact(udp: &UdpSlice<'_>, ip: &Ipv4Header) -> bool {
    let header = UdpHeader { checksum: 0, ..udp.to_header() };
    let payload = udp.payload();
    udp.checksum() == 0 || header.calc_checksum_ipv4_raw(ip.source, ip.destination, payload) == Ok(udp.checksum())
}
