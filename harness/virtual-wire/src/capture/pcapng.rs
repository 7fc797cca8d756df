//! The pcapng format: blocks with their length at both ends, in sections with their own byte order.

use std::io::Read;
use std::ops::Range;

use pcap_parser::{
    BOM_MAGIC, CB_MAGIC, DCB_MAGIC, DSB_MAGIC, EPB_MAGIC, IDB_MAGIC, ISB_MAGIC, NRB_MAGIC, SHB_MAGIC, SJE_MAGIC,
    SPB_MAGIC, parse_enhancedpacketblock_be, parse_enhancedpacketblock_le, parse_interfacedescriptionblock_be,
    parse_interfacedescriptionblock_le, parse_simplepacketblock_be, parse_simplepacketblock_le,
};
use station::Time;

use super::interface::{CaptureByteOrder, PcapngInterface};
use super::reader::{FoundRecord, PacketOffsets};
use super::window::FileWindow;

/// Type of the obsolete packet block, replaced by the enhanced packet block.
const OLD_PACKET: u32 = 2;
/// Type, length and trailing length.
const SHORTEST: usize = 12;
/// Maximum plausible length of a block in bytes; Wireshark uses the same limit.
const LONGEST: usize = 16 * 1024 * 1024;
/// Offset of the packet in an enhanced (or obsolete) packet block.
const PACKET: usize = 28;
/// Offset of the packet in a simple packet block.
const SIMPLE_PACKET: usize = 12;

/// A pcapng file from its first section header on.
#[derive(Debug)]
pub(super) struct Pcapng {
    order: CaptureByteOrder,
    /// Number of sections so far.
    sections: u32,
    interfaces: Vec<PcapngInterface>,
    /// The undescribed interface that was reported last.
    unknown: Option<u32>,
    number: usize,
}

/// The content of a block with a plausible length.
enum BlockContent {
    Packet(PacketOffsets),
    Nothing,
    Unusable(String),
}

impl Pcapng {
    pub fn new() -> Pcapng {
        Pcapng { order: CaptureByteOrder::Little, sections: 0, interfaces: Vec::new(), unknown: None, number: 0 }
    }

    /// The next packet or damage at the start of the window, or `None` at the end of the file.
    pub fn advance<R: Read>(&mut self, window: &mut FileWindow<R>) -> Option<FoundRecord> {
        loop {
            let available = window.fill_to(SHORTEST);
            if available == 0 {
                return None;
            }
            if available < SHORTEST {
                let what = format!("the file ends within the header of a block: {available} of {SHORTEST} bytes");
                return Some(FoundRecord::rest_of_file(window, what));
            }
            let (order, length) = match self.head(window.octets()) {
                Ok(head) => head,
                Err(what) => return Some(self.resynchronise(window, what)),
            };
            let available = window.fill_to(length);
            if available < length {
                return Some(self.run_over_the_end(window, available, length));
            }
            let trailer = order.word(window.octets(), length - 4);
            if trailer.map(|trailer| trailer as usize) != Some(length) {
                return Some(self.correct_trailer(window, order, length));
            }

            let at = window.offset();
            match self.read(&window.octets()[..length], order) {
                BlockContent::Packet(place) => return Some(FoundRecord::Packet { length, place }),
                BlockContent::Nothing => window.consume(length),
                BlockContent::Unusable(what) => {
                    window.consume(length);
                    return Some(FoundRecord::damage(at, what));
                }
            }
            if at == 0 && window.fill_to(1) == 0 {
                let what = "the file ends after its header and holds no packet".to_string();
                return Some(FoundRecord::damage(window.offset(), what));
            }
        }
    }

    /// Byte order and length of the block at the start of `octets`, which has at least [`SHORTEST`] bytes. Only a section header
    /// defines a byte order.
    fn head(&self, octets: &[u8]) -> Result<(CaptureByteOrder, usize), String> {
        let order = match octets.first_chunk::<4>().map(|magic| u32::from_le_bytes(*magic)) {
            Some(SHB_MAGIC) => [CaptureByteOrder::Little, CaptureByteOrder::Big]
                .into_iter()
                .find(|order| order.word(octets, 8) == Some(BOM_MAGIC))
                .ok_or("a section header without byte-order mark")?,
            _ => self.order,
        };
        let length = order.word(octets, 4).unwrap_or_default();
        match usize::try_from(length) {
            Ok(length) if (SHORTEST..=LONGEST).contains(&length) => Ok((order, length)),
            _ => Err(format!("a block claims {length} bytes")),
        }
    }

    fn read(&mut self, block: &[u8], order: CaptureByteOrder) -> BlockContent {
        match order.word(block, 0).unwrap_or_default() {
            SHB_MAGIC => {
                self.order = order;
                self.sections += 1;
                self.interfaces.clear();
                self.unknown = None;
                BlockContent::Nothing
            }
            IDB_MAGIC => {
                let parsed = match order {
                    CaptureByteOrder::Little => parse_interfacedescriptionblock_le(block),
                    CaptureByteOrder::Big => parse_interfacedescriptionblock_be(block),
                };
                match parsed {
                    Ok((_, description)) => {
                        self.interfaces.push(PcapngInterface::read(&description, order));
                        BlockContent::Nothing
                    }
                    Err(_) => BlockContent::Unusable(format!("an interface description of {} bytes", block.len())),
                }
            }
            EPB_MAGIC => self.enhanced_packet(block, order),
            OLD_PACKET => self.old_packet(block, order),
            SPB_MAGIC => self.simple_packet(block, order),
            SJE_MAGIC | CB_MAGIC | DCB_MAGIC => {
                // Wireshark shows these as events with a number.
                self.number += 1;
                BlockContent::Nothing
            }
            _ => BlockContent::Nothing,
        }
    }

    fn enhanced_packet(&mut self, block: &[u8], order: CaptureByteOrder) -> BlockContent {
        let parsed = match order {
            CaptureByteOrder::Little => parse_enhancedpacketblock_le(block),
            CaptureByteOrder::Big => parse_enhancedpacketblock_be(block),
        };
        let Ok((_, packet)) = parsed else { return too_short(block, order, 20) };
        let ticks = u64::from(packet.ts_high) << 32 | u64::from(packet.ts_low);
        let captured = PACKET..PACKET + packet.caplen as usize;
        let options = PACKET + packet.data.len()..block.len() - 4;
        self.packet(packet.if_id, Some(ticks), captured, packet.origlen, options, order)
    }

    /// The obsolete packet block uses half of the interface word as a drop counter.
    fn old_packet(&mut self, block: &[u8], order: CaptureByteOrder) -> BlockContent {
        let fields = [8, 12, 16, 20, 24].map(|at| order.word(block, at).unwrap_or_default());
        let [word, high, low, captured, original] = fields;
        let interface = match order {
            CaptureByteOrder::Little => word & 0xFFFF,
            CaptureByteOrder::Big => word >> 16,
        };
        let end = PACKET.saturating_add(captured as usize);
        let options = end.saturating_add(3) & !3;
        if options > block.len().saturating_sub(4) {
            return too_short(block, order, 20);
        }
        let ticks = u64::from(high) << 32 | u64::from(low);
        self.packet(interface, Some(ticks), PACKET..end, original, options..block.len() - 4, order)
    }

    /// A simple packet belongs to the first interface, has no time, and is cut to the snap length of the interface.
    fn simple_packet(&mut self, block: &[u8], order: CaptureByteOrder) -> BlockContent {
        let parsed = match order {
            CaptureByteOrder::Little => parse_simplepacketblock_le(block),
            CaptureByteOrder::Big => parse_simplepacketblock_be(block),
        };
        let Ok((_, packet)) = parsed else { return too_short(block, order, 8) };
        let limit = match self.interfaces.first() {
            Some(PcapngInterface { longest_captured: 1.., .. }) => self.interfaces[0].longest_captured,
            _ => u32::MAX,
        };
        let captured = packet.data.len().min(packet.origlen.min(limit) as usize);
        self.packet(0, None, SIMPLE_PACKET..SIMPLE_PACKET + captured, packet.origlen, 0..0, order)
    }

    fn packet(
        &mut self,
        interface: u32,
        ticks: Option<u64>,
        captured: Range<usize>,
        original_length: u32,
        options: Range<usize>,
        order: CaptureByteOrder,
    ) -> BlockContent {
        let Some(described) = self.interfaces.get(interface as usize) else {
            if self.unknown.replace(interface) == Some(interface) {
                return BlockContent::Nothing;
            }
            return BlockContent::Unusable(format!(
                "packets of interface {interface} are left out: no block of the section describes it"
            ));
        };
        self.number += 1;
        BlockContent::Packet(PacketOffsets {
            number: self.number,
            time: ticks.map_or(Time::ZERO, |ticks| described.time(ticks)),
            section: self.sections,
            interface,
            link_type: described.link_type,
            captured,
            original_length,
            options,
            order,
        })
    }

    /// Handles a block whose two lengths differ; if the first one leads to another block, only the second was damaged.
    fn correct_trailer<R: Read>(
        &mut self,
        window: &mut FileWindow<R>,
        order: CaptureByteOrder,
        length: usize,
    ) -> FoundRecord {
        let at = window.offset();
        let trailer = order.word(window.octets(), length - 4).unwrap_or_default();
        let what = format!("a block claims {length} bytes at its start and {trailer} at its end");
        if window.fill_to(length + 1) == length || self.is_block(window, length) {
            let right = order.octets(length as u32);
            window.octets_mut()[length - 4..length].copy_from_slice(&right);
            return FoundRecord::corrected(at, format!("{what}, taken as {length}"));
        }
        self.resynchronise(window, what)
    }

    fn run_over_the_end<R: Read>(
        &mut self,
        window: &mut FileWindow<R>,
        available: usize,
        length: usize,
    ) -> FoundRecord {
        if (1..available).any(|at| self.is_block(window, at)) {
            return self.resynchronise(window, format!("a block claims {length} bytes, beyond the end of the file"));
        }
        FoundRecord::rest_of_file(window, format!("the file ends within a block: {available} of {length} bytes"))
    }

    /// Resumes at the next position with a complete block of a known type.
    fn resynchronise<R: Read>(&mut self, window: &mut FileWindow<R>, what: String) -> FoundRecord {
        let at = window.offset();
        window.consume(1);
        while window.fill_to(SHORTEST) >= SHORTEST {
            // The window moves to each candidate, so that memory does not grow with the skipped bytes.
            let last = window.octets().len() - SHORTEST;
            match (0..=last).find(|&start| self.is_head(&window.octets()[start..])) {
                None => window.consume(last + 1),
                Some(start) => {
                    window.consume(start);
                    if self.is_block(window, 0) {
                        break;
                    }
                    window.consume(1);
                }
            }
        }
        if window.octets().len() < SHORTEST {
            window.consume(usize::MAX);
        }
        let skipped = window.offset() - at;
        FoundRecord::damage(at, format!("{what}; {skipped} bytes skipped"))
    }

    /// Whether a block of a known type and a possible length may begin here.
    fn is_head(&self, octets: &[u8]) -> bool {
        let known = match self.order.word(octets, 0) {
            Some(block_type) => matches!(
                block_type,
                SHB_MAGIC
                    | IDB_MAGIC
                    | OLD_PACKET
                    | SPB_MAGIC
                    | NRB_MAGIC
                    | ISB_MAGIC
                    | EPB_MAGIC
                    | SJE_MAGIC
                    | DSB_MAGIC
                    | CB_MAGIC
                    | DCB_MAGIC
            ),
            None => false,
        };
        known && self.head(octets).is_ok_and(|(_, length)| length % 4 == 0)
    }

    /// Whether a complete block of a known type is `start` bytes into the window.
    fn is_block<R: Read>(&self, window: &mut FileWindow<R>, start: usize) -> bool {
        if window.fill_to(start + SHORTEST) < start + SHORTEST || !self.is_head(&window.octets()[start..]) {
            return false;
        }
        let Ok((order, length)) = self.head(&window.octets()[start..]) else { return false };
        let end = start + length;
        window.fill_to(end) >= end && order.word(window.octets(), end - 4) == Some(length as u32)
    }
}

/// A packet block whose captured length, a word at `at`, exceeds the block.
fn too_short(block: &[u8], order: CaptureByteOrder, at: usize) -> BlockContent {
    let claim = order.word(block, at).unwrap_or_default();
    BlockContent::Unusable(format!("a packet claims {claim} bytes in a block of {}", block.len()))
}
