//! ARP for IPv4 on Ethernet (RFC 826).

use crate::error::Result;
use crate::ethernet::{EtherType, FrameHeader, Mac, pad};
use crate::octets::{Append, ByteReader};
use alloc::vec::Vec;
use core::net::Ipv4Addr;

/// The operation of an ARP packet; unknown values are preserved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ArpOperation(pub u16);

impl ArpOperation {
    /// Asks which station has the target address.
    pub const REQUEST: ArpOperation = ArpOperation(1);
    /// The sender has the address.
    pub const REPLY: ArpOperation = ArpOperation(2);
}

/// An ARP packet.
///
/// Bytes: 0-1 hardware 1 (Ethernet), 2-3 protocol 0x0800, 4 length 6, 5 length 4, 6-7 operation, 8-13 and 14-17 sender, 18-23 and
/// 24-27 target.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Arp {
    /// Request or reply.
    pub operation: ArpOperation,
    /// MAC address of the sender.
    pub sender_mac: Mac,
    /// IPv4 address of the sender; 0.0.0.0 in a probe for a conflict (RFC 5227).
    pub sender_ip: Ipv4Addr,
    /// MAC address of the target; zero in a request.
    pub target_mac: Mac,
    /// IPv4 address of the target.
    pub target_ip: Ipv4Addr,
}

impl Arp {
    /// A request for the MAC address of `target`.
    pub fn request(sender_mac: Mac, sender_ip: Ipv4Addr, target: Ipv4Addr) -> Arp {
        Arp { operation: ArpOperation::REQUEST, sender_mac, sender_ip, target_mac: Mac::ZERO, target_ip: target }
    }

    /// The reply to this request: the target address belongs to `mac`.
    pub fn reply(&self, mac: Mac) -> Arp {
        Arp {
            operation: ArpOperation::REPLY,
            sender_mac: mac,
            sender_ip: self.target_ip,
            target_mac: self.sender_mac,
            target_ip: self.sender_ip,
        }
    }

    /// Parses the payload of a frame of [`EtherType::ARP`]; ignores padding.
    pub fn parse(payload: &[u8]) -> Result<Arp> {
        let mut reader = ByteReader::new("ARP", payload);
        for (field, octets, expected, number) in [
            ("HTYPE", 2, "1 (Ethernet)", 1),
            ("PTYPE", 2, "0x0800 (IPv4)", EtherType::IPV4.0),
            ("HLEN", 1, "6", 6),
            ("PLEN", 1, "4", 4),
        ] {
            let found = if octets == 1 { reader.u8()?.into() } else { reader.u16()? };
            if found != number {
                return Err(reader.wrong(field, octets, expected, found.into()));
            }
        }
        Ok(Arp {
            operation: ArpOperation(reader.u16()?),
            sender_mac: Mac::read(&mut reader)?,
            sender_ip: Ipv4Addr::from(reader.u32()?),
            target_mac: Mac::read(&mut reader)?,
            target_ip: Ipv4Addr::from(reader.u32()?),
        })
    }

    /// Appends the packet without an Ethernet header.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put_u16(1);
        out.put_u16(EtherType::IPV4.0);
        out.put(&[6, 4]);
        out.put_u16(self.operation.0);
        out.put(&self.sender_mac.0);
        out.put(&self.sender_ip.octets());
        out.put(&self.target_mac.0);
        out.put(&self.target_ip.octets());
    }

    /// Appends the packet in a padded frame: a request as broadcast, any other operation to its target.
    pub fn write_frame(&self, out: &mut Vec<u8>) {
        let destination = if self.operation == ArpOperation::REQUEST { Mac::BROADCAST } else { self.target_mac };
        let start = out.len();
        FrameHeader::new(destination, self.sender_mac, EtherType::ARP).write(out);
        self.write(out);
        pad(out, start);
    }
}
