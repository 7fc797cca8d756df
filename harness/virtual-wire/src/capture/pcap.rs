//! The pcap format: one header, then records without markers between them.

use std::io::Read;

use pcap_parser::parse_pcap_header;
use station::Time;

use super::LinkType;
use super::interface::CaptureByteOrder;
use super::reader::{FoundRecord, PacketOffsets};
use super::window::FileWindow;

/// Length of the file header in bytes.
const FILE_HEADER: usize = 24;
/// Maximum plausible length of a packet in bytes; Wireshark uses the same limit.
const LONGEST: u32 = 262_144;
/// Number of consecutive plausible records needed to resume after damage.
const CHAIN: usize = 3;
/// Maximum length of such a chain of records in bytes.
const CHAIN_SPAN: usize = CHAIN * (LONGEST as usize + 24);
/// Number of positions tried before the window moves on.
const STRIDE: usize = 64 * 1024;
/// A single last record is plausible if it has a time, and one within this many seconds of the last record read.
const NEAR: u32 = 86_400;

/// A pcap file after its header.
#[derive(Debug)]
pub(super) struct Pcap {
    shape: Option<PcapRecordFormat>,
    number: usize,
    seconds: u32,
}

/// The format of the records, from the file header.
#[derive(Clone, Copy, Debug)]
struct PcapRecordFormat {
    order: CaptureByteOrder,
    /// Nanoseconds per unit of a record's fraction of a second.
    unit: u32,
    link_type: LinkType,
    /// Length of a record header in bytes: 16, or 24 in Kuznetzov's variant of libpcap.
    header: usize,
}

/// The fixed part of a record.
#[derive(Clone, Copy, Debug)]
struct PcapRecordHeader {
    seconds: u32,
    fraction: u32,
    captured: u32,
    original: u32,
}

impl Pcap {
    pub fn new() -> Pcap {
        Pcap { shape: None, number: 0, seconds: 0 }
    }

    /// Whether a file that begins with `octets` has this format.
    pub fn begins(octets: &[u8]) -> bool {
        matches!(
            octets,
            [0xD4, 0xC3, 0xB2, 0xA1, ..]
                | [0xA1, 0xB2, 0xC3, 0xD4, ..]
                | [0x4D, 0x3C, 0xB2, 0xA1, ..]
                | [0xA1, 0xB2, 0x3C, 0x4D, ..]
                | [0x34, 0xCD, 0xB2, 0xA1, ..]
        )
    }

    /// The next packet or damage at the start of the window, or `None` at the end of the file.
    pub fn advance<R: Read>(&mut self, window: &mut FileWindow<R>) -> Option<FoundRecord> {
        let shape = match self.shape {
            Some(shape) => shape,
            None => match read_file_header(window) {
                Ok(shape) => *self.shape.insert(shape),
                Err(found) => return found,
            },
        };
        let available = window.fill_to(shape.header);
        if available == 0 {
            return None;
        }
        let Some(header) = shape.header_at(window.octets(), 0) else {
            let what = format!("the file ends within a record's header: {available} of {} bytes", shape.header);
            return Some(FoundRecord::rest_of_file(window, what));
        };
        if !header.is_possible() {
            return Some(self.recover(window, shape, header));
        }

        let length = shape.header + header.captured as usize;
        let available = window.fill_to(length + shape.header);
        if available < length {
            return Some(match self.find(window, shape, 1, available) {
                Some(next) => {
                    let claim = format!("a record claims {} bytes, beyond the end of the file", header.captured);
                    skip(window, next, &claim)
                }
                None => FoundRecord::rest_of_file(
                    window,
                    format!("the file ends within a record: {available} of {length} bytes"),
                ),
            });
        }
        let next = shape.header_at(window.octets(), length);
        if next.is_some_and(|next| !next.is_possible())
            && let Some(next) = self.find(window, shape, shape.header, length)
        {
            let claim = format!("a record claims {} bytes and reaches into the next ones", header.captured);
            return Some(skip(window, next, &claim));
        }
        Some(self.packet(shape, header))
    }

    fn packet(&mut self, shape: PcapRecordFormat, header: PcapRecordHeader) -> FoundRecord {
        let length = shape.header + header.captured as usize;
        self.number += 1;
        self.seconds = header.seconds;
        let nanos = u64::from(header.seconds) * 1_000_000_000 + u64::from(header.fraction) * u64::from(shape.unit);
        let place = PacketOffsets {
            number: self.number,
            time: Time::from_nanos(nanos),
            section: 1,
            interface: 0,
            link_type: shape.link_type,
            captured: shape.header..length,
            original_length: header.original,
            options: 0..0,
            order: shape.order,
        };
        FoundRecord::Packet { length, place }
    }

    /// Resumes after a record with an impossible header.
    fn recover<R: Read>(
        &self,
        window: &mut FileWindow<R>,
        shape: PcapRecordFormat,
        header: PcapRecordHeader,
    ) -> FoundRecord {
        let at = window.offset();
        let claim = format!("a record claims {} bytes", header.captured);

        // If the original length leads to a record or to the end of the file, only the captured length was damaged.
        let length = shape.header + header.original.min(LONGEST) as usize;
        if (1..=LONGEST).contains(&header.original)
            && (window.fill_to(length + 1) == length || self.find(window, shape, length, length + 1).is_some())
        {
            window.octets_mut()[8..12].copy_from_slice(&shape.order.octets(header.original));
            return FoundRecord::corrected(at, format!("{claim}, taken as {}", header.original));
        }

        let mut from = 1;
        loop {
            if let Some(next) = self.find(window, shape, from, STRIDE) {
                window.consume(next);
                break;
            }
            if window.octets().is_empty() {
                break;
            }
            window.consume(STRIDE);
            from = 0;
        }
        let skipped = window.offset() - at;
        FoundRecord::damage(at, format!("{claim}; {skipped} bytes skipped"))
    }

    /// The first position in `from..to` with a chain of plausible records.
    fn find<R: Read>(
        &self,
        window: &mut FileWindow<R>,
        shape: PcapRecordFormat,
        from: usize,
        to: usize,
    ) -> Option<usize> {
        let available = window.fill_to(to + CHAIN_SPAN);
        (from..to.min(available)).find(|&at| self.is_chain(window.octets(), shape, at))
    }

    fn is_chain(&self, octets: &[u8], shape: PcapRecordFormat, start: usize) -> bool {
        let mut at = start;
        for seen in 0..CHAIN {
            let Some(header) = shape.header_at(octets, at) else {
                // Less than CHAIN_SPAN bytes: the file ends here.
                return match seen {
                    0 => false,
                    1 => at == octets.len() && self.is_near(octets, shape, start),
                    _ => true,
                };
            };
            if !header.is_believable(shape) {
                return false;
            }
            at += shape.header + header.captured as usize;
            if at > octets.len() {
                return seen >= 2;
            }
        }
        true
    }

    fn is_near(&self, octets: &[u8], shape: PcapRecordFormat, at: usize) -> bool {
        shape
            .header_at(octets, at)
            .is_some_and(|header| header.seconds != 0 && header.seconds.abs_diff(self.seconds) <= NEAR)
    }
}

impl PcapRecordFormat {
    fn header_at(self, octets: &[u8], at: usize) -> Option<PcapRecordHeader> {
        let octets = octets.get(at..)?.get(..self.header)?;
        Some(PcapRecordHeader {
            seconds: self.order.word(octets, 0)?,
            fraction: self.order.word(octets, 4)?,
            captured: self.order.word(octets, 8)?,
            original: self.order.word(octets, 12)?,
        })
    }
}

impl PcapRecordHeader {
    /// Whether a record may have this header; a record without bytes would match a run of zeros.
    fn is_possible(self) -> bool {
        self.captured <= LONGEST && (self.captured, self.original) != (0, 0)
    }

    /// Whether it is likely a header and unlikely anything else.
    fn is_believable(self, shape: PcapRecordFormat) -> bool {
        (1..=LONGEST).contains(&self.captured)
            && (self.captured..=LONGEST).contains(&self.original)
            && u64::from(self.fraction) * u64::from(shape.unit) < 1_000_000_000
    }
}

/// Reads the file header; without one only damage can be reported.
fn read_file_header<R: Read>(window: &mut FileWindow<R>) -> Result<PcapRecordFormat, Option<FoundRecord>> {
    let available = window.fill_to(FILE_HEADER + 1);
    if available == 0 {
        return Err(None);
    }
    let Ok((_, header)) = parse_pcap_header(window.octets()) else {
        let what = format!("the file ends within its header: {available} of {FILE_HEADER} bytes");
        return Err(Some(FoundRecord::rest_of_file(window, what)));
    };
    if available == FILE_HEADER {
        return Err(Some(FoundRecord::rest_of_file(
            window,
            "the file ends after its header and holds no packet".to_string(),
        )));
    }
    window.consume(FILE_HEADER);
    Ok(PcapRecordFormat {
        order: if header.is_bigendian() { CaptureByteOrder::Big } else { CaptureByteOrder::Little },
        unit: if header.is_nanosecond_precision() { 1 } else { 1_000 },
        // The upper half holds the length of the frame check sequence.
        link_type: LinkType(header.network.0 as u16),
        header: if header.is_modified_format() { 24 } else { 16 },
    })
}

/// Damage in the next `count` bytes.
fn skip<R: Read>(window: &mut FileWindow<R>, count: usize, claim: &str) -> FoundRecord {
    let at = window.offset();
    window.consume(count);
    FoundRecord::damage(at, format!("{claim}; {count} bytes skipped"))
}
