//! The actual state of interface and ports: records 0x8080 (interface), 0x802A (port), 0xF841 (all of them). Source:
//! IEC 61158-6-10, PDInterfaceDataReal, PDPortDataReal, MultipleBlockHeader.
//!
//! Padding aligns the next field to a multiple of four bytes from the start of the block.

use super::{BlockHeader, BlockType};
use crate::error::Result;
use crate::ethernet::Mac;
use crate::octets::{Append, ByteReader};
use alloc::vec::Vec;
use core::net::Ipv4Addr;

/// Length of a block header in bytes, which counts for the padding.
const HEADER: usize = 6;

/// PDInterfaceDataReal: block 0x0240.
///
/// Bytes after the block header: length of the name, name, padding, MAC address of six, padding of two, IP address,
/// subnet mask and gateway of four each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct InterfaceDataReal {
    /// The name of the station.
    pub chassis: Vec<u8>,
    /// The MAC address of the interface.
    pub mac: Mac,
    /// The IP address.
    pub address: Ipv4Addr,
    /// The subnet mask.
    pub mask: Ipv4Addr,
    /// The gateway; 0.0.0.0 or the address of the interface for none.
    pub gateway: Ipv4Addr,
}

/// PDPortDataReal: block 0x020F.
///
/// Bytes after the block header: padding of two, slot and subslot of two each, length of the port name, the port name,
/// number of neighbours, padding, the neighbours, MAU type of two, padding of two, domain boundary and multicast boundary
/// of four each, port state, link state, padding of two, media type of four.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PortDataReal {
    /// Slot of the interface.
    pub slot: u16,
    /// Subslot of the port.
    pub subslot: u16,
    /// The port name, for instance `port-001`.
    pub port: Vec<u8>,
    /// The neighbours at the other end of the cable.
    pub peers: Vec<Peer>,
    /// The MAU type (RFC 4836, dot3MauType): 16 is 100BASE-TX full duplex, 15 the same half duplex, 0 unknown.
    pub mau_type: u16,
    /// Domain boundary: sync domains that do not pass the port, as bits.
    pub domain_boundary: u32,
    /// Multicast boundary: multicast addresses that do not pass the port, as bits.
    pub multicast_boundary: u32,
    /// The port state (IEEE 802.1D): 0 unknown, 5 forwarding.
    pub port_state: u8,
    /// The link state: 1 up, 2 down.
    pub link_state: u8,
    /// The media type: 1 copper.
    pub media_type: u32,
}

/// A neighbour.
///
/// Bytes: length of the port name, the port name, length of the station name, the station name, padding, line delay of
/// four, MAC address of six, padding of two.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Peer {
    /// The port name of the neighbour.
    pub port: Vec<u8>,
    /// The station name of the neighbour.
    pub chassis: Vec<u8>,
    /// The line delay; 0 unknown.
    pub line_delay: u32,
    /// The MAC address of the neighbour.
    pub mac: Mac,
}

/// MultipleBlockHeader: the blocks of one submodule, block 0x0400.
///
/// Bytes after the block header: padding of two, API of four, slot and subslot of two each, then the blocks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MultipleBlock {
    /// API of the submodule.
    pub api: u32,
    /// Slot of the submodule.
    pub slot: u16,
    /// Subslot of the submodule.
    pub subslot: u16,
    /// The blocks, not parsed.
    pub blocks: Vec<u8>,
}

/// Skips the padding in the body of a block with `whole` bytes.
fn skip(body: &mut ByteReader<'_>, whole: usize) -> Result<()> {
    let read = whole - body.left() + HEADER;
    body.take(read.next_multiple_of(4) - read)?;
    Ok(())
}

/// Appends the padding of a block that starts at byte `start` of `out`.
fn pad(out: &mut Vec<u8>, start: usize) {
    out.resize(start + (out.len() - start).next_multiple_of(4), 0);
}

fn read_text(body: &mut ByteReader<'_>) -> Result<Vec<u8>> {
    let length = body.u8()?;
    Ok(body.take(length.into())?.to_vec())
}

/// Appends the length and the text, truncated to 255 bytes.
fn write_text(text: &[u8], out: &mut Vec<u8>) {
    let text = text.get(..255).unwrap_or(text);
    out.put_u8(text.len() as u8);
    out.put(text);
}

impl InterfaceDataReal {
    /// Reads the block with its header; fails on another type or version.
    pub fn read(reader: &mut ByteReader<'_>) -> Result<InterfaceDataReal> {
        let mut body = BlockHeader::read_only(reader, BlockType::PD_INTERFACE_DATA_REAL, "0x0240 in version 1.0")?;
        let whole = body.left();
        let chassis = read_text(&mut body)?;
        skip(&mut body, whole)?;
        let mac = Mac::read(&mut body)?;
        skip(&mut body, whole)?;
        let mut address = || body.u32().map(Ipv4Addr::from);
        Ok(InterfaceDataReal { chassis, mac, address: address()?, mask: address()?, gateway: address()? })
    }

    /// Reads the record 0x8080.
    pub fn parse(octets: &[u8]) -> Result<InterfaceDataReal> {
        InterfaceDataReal::read(&mut ByteReader::new("PDInterfaceDataReal", octets))
    }

    /// Appends the block.
    pub fn write(&self, out: &mut Vec<u8>) {
        let start = out.len();
        BlockHeader::write(BlockType::PD_INTERFACE_DATA_REAL, out, |out| {
            write_text(&self.chassis, out);
            pad(out, start);
            out.put(&self.mac.0);
            pad(out, start);
            for address in [self.address, self.mask, self.gateway] {
                out.put(&address.octets());
            }
        });
    }
}

impl Peer {
    fn read(body: &mut ByteReader<'_>, whole: usize) -> Result<Peer> {
        let port = read_text(body)?;
        let chassis = read_text(body)?;
        skip(body, whole)?;
        let line_delay = body.u32()?;
        let mac = Mac::read(body)?;
        skip(body, whole)?;
        Ok(Peer { port, chassis, line_delay, mac })
    }

    fn write(&self, out: &mut Vec<u8>, start: usize) {
        write_text(&self.port, out);
        write_text(&self.chassis, out);
        pad(out, start);
        out.put_u32(self.line_delay);
        out.put(&self.mac.0);
        pad(out, start);
    }
}

impl PortDataReal {
    /// Reads the block with its header; fails on another type or version.
    pub fn read(reader: &mut ByteReader<'_>) -> Result<PortDataReal> {
        let mut body = BlockHeader::read_only(reader, BlockType::PD_PORT_DATA_REAL, "0x020F in version 1.0")?;
        let whole = body.left();
        skip(&mut body, whole)?;
        let (slot, subslot) = (body.u16()?, body.u16()?);
        let port = read_text(&mut body)?;
        let number = body.u8()?;
        skip(&mut body, whole)?;
        let mut peers = Vec::new();
        for _ in 0..number {
            peers.push(Peer::read(&mut body, whole)?);
        }
        let mau_type = body.u16()?;
        skip(&mut body, whole)?;
        let (domain_boundary, multicast_boundary) = (body.u32()?, body.u32()?);
        let (port_state, link_state) = (body.u8()?, body.u8()?);
        skip(&mut body, whole)?;
        let media_type = body.u32()?;
        Ok(PortDataReal {
            slot,
            subslot,
            port,
            peers,
            mau_type,
            domain_boundary,
            multicast_boundary,
            port_state,
            link_state,
            media_type,
        })
    }

    /// Reads the record 0x802A.
    pub fn parse(octets: &[u8]) -> Result<PortDataReal> {
        PortDataReal::read(&mut ByteReader::new("PDPortDataReal", octets))
    }

    /// Appends the block with at most 255 neighbours.
    pub fn write(&self, out: &mut Vec<u8>) {
        let start = out.len();
        BlockHeader::write(BlockType::PD_PORT_DATA_REAL, out, |out| {
            pad(out, start);
            out.put_u16(self.slot);
            out.put_u16(self.subslot);
            write_text(&self.port, out);
            let peers = self.peers.get(..255).unwrap_or(&self.peers);
            out.put_u8(peers.len() as u8);
            pad(out, start);
            peers.iter().for_each(|peer| peer.write(out, start));
            out.put_u16(self.mau_type);
            pad(out, start);
            out.put_u32(self.domain_boundary);
            out.put_u32(self.multicast_boundary);
            out.put(&[self.port_state, self.link_state]);
            pad(out, start);
            out.put_u32(self.media_type);
        });
    }
}

impl MultipleBlock {
    /// Reads the block with its header; fails on another type or version.
    pub fn read(reader: &mut ByteReader<'_>) -> Result<MultipleBlock> {
        let mut body = BlockHeader::read_only(reader, BlockType::MULTIPLE, "0x0400 in version 1.0")?;
        body.u16()?;
        Ok(MultipleBlock { api: body.u32()?, slot: body.u16()?, subslot: body.u16()?, blocks: body.rest().to_vec() })
    }

    /// Reads the blocks of a record 0xF841.
    pub fn parse_record(octets: &[u8]) -> Result<Vec<MultipleBlock>> {
        let mut reader = ByteReader::new("PDRealData", octets);
        let mut blocks = Vec::new();
        while !reader.is_empty() {
            blocks.push(MultipleBlock::read(&mut reader)?);
        }
        Ok(blocks)
    }

    /// Appends the block.
    pub fn write(&self, out: &mut Vec<u8>) {
        BlockHeader::write(BlockType::MULTIPLE, out, |out| {
            out.put_u16(0);
            out.put_u32(self.api);
            out.put_u16(self.slot);
            out.put_u16(self.subslot);
            out.put(&self.blocks);
        });
    }
}
