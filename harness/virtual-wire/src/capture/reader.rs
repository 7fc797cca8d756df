//! The reader of both formats, and the conversion of a record to a packet.

use std::borrow::Cow;
use std::fmt;
use std::io::Read;
use std::ops::Range;

use pcap_parser::{OptionCode, PcapError, parse_option_be, parse_option_le};
use station::Time;

use super::interface::CaptureByteOrder;
use super::pcap::Pcap;
use super::pcapng::Pcapng;
use super::unpack::{PackingDamage, Unpacked};
use super::window::FileWindow;
use super::{CaptureItem, CapturedPacket, Damage, DamageEffect, LinkType, NotACapture};

/// Reads a pcap or pcapng file packet by packet, in one pass, with memory independent of the file size; also compressed with gzip
/// or zstd.
///
/// Supports both byte orders, microseconds and nanoseconds, several sections and interfaces; blocks without a packet are skipped.
/// Damage is reported at its position; reading resumes at the next certain record or block.
pub struct CaptureReader<R: Read> {
    window: FileWindow<Unpacked<R>>,
    format: CaptureFormat,
    /// Length in bytes of the record returned last.
    taken: usize,
}

#[derive(Debug)]
enum CaptureFormat {
    Pcap(Pcap),
    Pcapng(Pcapng),
}

/// What a format found at the start of the window.
pub(super) enum FoundRecord {
    /// A packet in a record of `length` bytes.
    Packet { length: usize, place: PacketOffsets },
    /// Damage; the window is after it.
    Damage(Damage),
}

impl FoundRecord {
    /// Damage at the offset `at` of the file.
    pub fn damage(at: u64, what: String) -> FoundRecord {
        FoundRecord::Damage(Damage { at, what, effect: DamageEffect::Missing })
    }

    /// Corrected damage: no packet is missing.
    pub fn corrected(at: u64, what: String) -> FoundRecord {
        FoundRecord::Damage(Damage { at, what, effect: DamageEffect::Corrected })
    }

    /// Damage from the start of the window to the end of the file.
    pub fn rest_of_file<R: Read>(window: &mut FileWindow<R>, what: String) -> FoundRecord {
        let at = window.offset();
        window.consume(usize::MAX);
        FoundRecord::damage(at, what)
    }
}

/// The offsets of a packet's parts in the window, and its other fields.
pub(super) struct PacketOffsets {
    pub number: usize,
    pub time: Time,
    pub section: u32,
    pub interface: u32,
    pub link_type: LinkType,
    pub captured: Range<usize>,
    pub original_length: u32,
    pub options: Range<usize>,
    pub order: CaptureByteOrder,
}

impl<R: Read> CaptureReader<R> {
    /// Detects the format from the first bytes of `input`, regardless of the file name.
    ///
    /// `input` needs no buffer of its own. A file that begins like a capture and ends within its header is accepted;
    /// [`next`](Self::next) then returns the damage.
    pub fn new(input: R) -> Result<CaptureReader<R>, NotACapture> {
        let mut window = FileWindow::new(Unpacked::new(input)?);
        if window.fill_to(4) < 4
            && let Some(error) = window.failure()
        {
            return Err(NotACapture::Unreadable(error));
        }
        let format = match window.octets() {
            [0x0A, 0x0D, 0x0D, 0x0A, ..] => CaptureFormat::Pcapng(Pcapng::new()),
            octets if Pcap::begins(octets) => CaptureFormat::Pcap(Pcap::new()),
            [] => return Err(NotACapture::Empty),
            octets => return Err(NotACapture::OtherFormat(octets[..octets.len().min(4)].to_vec())),
        };
        Ok(CaptureReader { window, format, taken: 0 })
    }

    /// The next packet or damage, or `None` at the end of the file.
    #[allow(clippy::should_implement_trait, reason = "the packet borrows from the reader, which no Iterator can say")]
    pub fn next(&mut self) -> Option<CaptureItem<'_>> {
        self.window.consume(self.taken);
        self.taken = 0;
        let found = match &mut self.format {
            CaptureFormat::Pcap(pcap) => pcap.advance(&mut self.window),
            CaptureFormat::Pcapng(pcapng) => pcapng.advance(&mut self.window),
        };
        match found {
            Some(FoundRecord::Packet { length, place }) => {
                self.taken = length;
                Some(CaptureItem::Packet(place.packet(self.window.octets())))
            }
            Some(FoundRecord::Damage(damage)) => Some(CaptureItem::Damage(damage)),
            None => {
                let failure = self.window.failure()?;
                let at = self.window.offset();
                let packing = failure.get_ref().and_then(|cause| cause.downcast_ref::<PackingDamage>());
                let effect = match packing {
                    Some(PackingDamage { untrusted: true, .. }) => DamageEffect::Untrusted,
                    _ => DamageEffect::Missing,
                };
                Some(CaptureItem::Damage(Damage { at, what: format!("reading stopped: {failure}"), effect }))
            }
        }
    }
}

impl<R: Read> fmt::Debug for CaptureReader<R> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("CaptureReader").field("format", &self.format).finish_non_exhaustive()
    }
}

impl PacketOffsets {
    fn packet(self, octets: &[u8]) -> CapturedPacket<'_> {
        let options = octets.get(self.options).unwrap_or_default();
        CapturedPacket {
            number: self.number,
            time: self.time,
            section: self.section,
            interface: self.interface,
            link_type: self.link_type,
            captured: octets.get(self.captured).unwrap_or_default(),
            original_length: self.original_length,
            comment: if options.is_empty() { None } else { comment(options, self.order) },
        }
    }
}

/// The comments in the options of a packet block.
fn comment(mut options: &[u8], order: CaptureByteOrder) -> Option<Cow<'_, str>> {
    let mut comment: Option<Cow<'_, str>> = None;
    loop {
        let parsed = match order {
            CaptureByteOrder::Little => parse_option_le::<PcapError<&[u8]>>(options),
            CaptureByteOrder::Big => parse_option_be::<PcapError<&[u8]>>(options),
        };
        let Ok((rest, option)) = parsed else { return comment };
        match option.code {
            OptionCode::EndOfOpt => return comment,
            OptionCode::Comment => {
                let end = 4 + usize::from(option.len);
                let text = String::from_utf8_lossy(options.get(4..end).unwrap_or_default());
                comment = Some(match comment {
                    None => text,
                    Some(before) => Cow::Owned(format!("{before}\n{text}")),
                });
            }
            _ => {}
        }
        options = rest;
    }
}
