//! Ethernet II frames with and without 802.1Q tags.
//!
//! This module must not know what the payload of a frame means.

use crate::error::Result;
use crate::octets::{Append, ByteReader};
use alloc::vec::Vec;
use core::fmt;
use core::str::FromStr;

/// A MAC address; displayed as `aa:bb:cc:dd:ee:ff`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Mac(pub [u8; 6]);

impl Mac {
    /// The broadcast address.
    pub const BROADCAST: Mac = Mac([0xff; 6]);
    /// The zero address, the target MAC address of an ARP request.
    pub const ZERO: Mac = Mac([0; 6]);
    /// The destination of DCP Identify requests (IEC 61158-6-10, DCP multicast MAC address 0).
    pub const DCP_MULTICAST: Mac = Mac([0x01, 0x0e, 0xcf, 0x00, 0x00, 0x00]);
    /// The destination of DCP Hello requests (IEC 61158-6-10, DCP multicast MAC address 1).
    pub const DCP_HELLO_MULTICAST: Mac = Mac([0x01, 0x0e, 0xcf, 0x00, 0x00, 0x01]);
    /// The nearest bridge, the destination of LLDP (IEEE 802.1AB, 7.1).
    pub const LLDP_MULTICAST: Mac = Mac([0x01, 0x80, 0xc2, 0x00, 0x00, 0x0e]);

    /// Whether it is a multicast or the broadcast address.
    #[inline]
    pub fn is_group(self) -> bool {
        self.0[0] & 1 != 0
    }

    /// Reads an address of six bytes.
    #[inline]
    pub fn read(reader: &mut ByteReader<'_>) -> Result<Mac> {
        reader.array().map(Mac)
    }
}

impl fmt::Display for Mac {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [a, b, c, d, e, g] = self.0;
        write!(f, "{a:02x}:{b:02x}:{c:02x}:{d:02x}:{e:02x}:{g:02x}")
    }
}

/// The text is not a MAC address.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a MAC address is six pairs of hexadecimal digits with a colon or a hyphen between them")]
pub struct NotAMac;

impl FromStr for Mac {
    type Err = NotAMac;

    fn from_str(text: &str) -> Result<Mac, NotAMac> {
        let mut pairs = text.split([':', '-']);
        let mut octets = [0; 6];
        for octet in &mut octets {
            let pair = pairs.next().filter(|pair| pair.len() == 2 && !pair.starts_with('+')).ok_or(NotAMac)?;
            *octet = u8::from_str_radix(pair, 16).map_err(|_| NotAMac)?;
        }
        if pairs.next().is_some() { Err(NotAMac) } else { Ok(Mac(octets)) }
    }
}

/// The EtherType of a frame; unknown values are preserved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct EtherType(pub u16);

impl EtherType {
    /// IPv4.
    pub const IPV4: EtherType = EtherType(0x0800);
    /// ARP.
    pub const ARP: EtherType = EtherType(0x0806);
    /// The tag of a customer VLAN (IEEE 802.1Q).
    pub const VLAN: EtherType = EtherType(0x8100);
    /// The tag of a provider VLAN (IEEE 802.1ad).
    pub const PROVIDER_VLAN: EtherType = EtherType(0x88a8);
    /// PROFINET: RT cyclic data, alarms, DCP and PTCP.
    pub const PROFINET: EtherType = EtherType(0x8892);
    /// LLDP.
    pub const LLDP: EtherType = EtherType(0x88cc);

    #[inline]
    fn is_tag(self) -> bool {
        matches!(self, EtherType::VLAN | EtherType::PROVIDER_VLAN)
    }
}

/// An 802.1Q tag.
///
/// Bytes: 0-1 tag protocol identifier, 2-3 control information: bits 15-13 priority, 12 drop eligible, 11-0 VLAN id.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Vlan {
    /// [`EtherType::VLAN`] or [`EtherType::PROVIDER_VLAN`].
    pub protocol: EtherType,
    /// The tag control information (TCI), as in the frame.
    pub control: u16,
}

impl Vlan {
    /// The tag of RT cyclic data and high alarms: priority 6, VLAN 0 (IEC 61158-6-10).
    pub const RT: Vlan = Vlan::priority_tag(6);
    /// The tag of low alarms: priority 5, VLAN 0 (IEC 61158-6-10).
    pub const LOW_ALARM: Vlan = Vlan::priority_tag(5);

    /// A tag of VLAN 0 that carries only a priority, 0..=7.
    pub const fn priority_tag(priority: u8) -> Vlan {
        Vlan { protocol: EtherType::VLAN, control: ((priority & 7) as u16) << 13 }
    }

    /// Priority code point, 0..=7.
    pub fn priority(self) -> u8 {
        (self.control >> 13) as u8
    }

    /// Whether the frame may be dropped first.
    pub fn drop_eligible(self) -> bool {
        self.control & 0x1000 != 0
    }

    /// VLAN id, 0..=4095; 0 means that the tag carries only a priority.
    pub fn id(self) -> u16 {
        self.control & 0x0fff
    }
}

/// Everything before the payload of a frame.
///
/// Bytes: 0-5 destination, 6-11 source, then four for each tag, then two EtherType.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct FrameHeader {
    /// The destination address.
    pub destination: Mac,
    /// The source address.
    pub source: Mac,
    /// The outermost 802.1Q tag.
    pub tag: Option<Vlan>,
    /// The second tag of a doubly tagged frame; written only after an outer tag.
    ///
    /// A third tag is not parsed: `ether_type` is then its tag protocol identifier.
    pub inner_tag: Option<Vlan>,
    /// The EtherType of the payload.
    pub ether_type: EtherType,
}

impl FrameHeader {
    /// Length of the header of an untagged frame, in bytes.
    pub const UNTAGGED_LENGTH: usize = 14;

    /// The header of an untagged frame.
    pub const fn new(destination: Mac, source: Mac, ether_type: EtherType) -> FrameHeader {
        FrameHeader { destination, source, tag: None, inner_tag: None, ether_type }
    }

    /// The same header with `tag` as its only tag.
    pub const fn tagged(self, tag: Vlan) -> FrameHeader {
        FrameHeader { tag: Some(tag), inner_tag: None, ..self }
    }

    /// Parses the header of `frame`; returns it and the payload, including padding.
    #[inline]
    pub fn parse(frame: &[u8]) -> Result<(FrameHeader, &[u8])> {
        let mut reader = ByteReader::new("Ethernet", frame);
        let (destination, source) = (Mac::read(&mut reader)?, Mac::read(&mut reader)?);
        let mut ether_type = EtherType(reader.u16()?);
        let mut tag = || -> Result<Option<Vlan>> {
            if !ether_type.is_tag() {
                return Ok(None);
            }
            let tag = Vlan { protocol: ether_type, control: reader.u16()? };
            ether_type = EtherType(reader.u16()?);
            Ok(Some(tag))
        };
        let outer = tag()?;
        let inner_tag = tag()?;
        Ok((FrameHeader { destination, source, tag: outer, inner_tag, ether_type }, reader.rest()))
    }

    /// Length of this header in bytes, which is the offset of the payload in the frame.
    pub fn payload_offset(&self) -> usize {
        let tags = match (self.tag, self.inner_tag) {
            (None, _) => 0,
            (Some(_), None) => 1,
            (Some(_), Some(_)) => 2,
        };
        FrameHeader::UNTAGGED_LENGTH + 4 * tags
    }

    /// Appends the header to `out`.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put(&self.destination.0);
        out.put(&self.source.0);
        for tag in self.tag.iter().chain(self.tag.and(self.inner_tag.as_ref())) {
            out.put_u16(tag.protocol.0);
            out.put_u16(tag.control);
        }
        out.put_u16(self.ether_type.0);
    }
}

/// The minimum length of a frame in bytes, without the frame check sequence (IEEE 802.3).
pub const SHORTEST_FRAME: usize = 60;

/// Pads the frame from byte `start` to the end of `out` to [`SHORTEST_FRAME`] with zeros.
pub fn pad(out: &mut Vec<u8>, start: usize) {
    let least = start + SHORTEST_FRAME;
    if out.len() < least {
        out.resize(least, 0);
    }
}
