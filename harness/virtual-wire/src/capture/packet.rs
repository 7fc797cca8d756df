//! Packets and damage that a capture reader returns.

use std::borrow::Cow;
use std::fmt;
use std::io;

use plain_text::hex;
use station::Time;
use thiserror::Error;

/// The next item of a capture file.
#[derive(Debug)]
pub enum CaptureItem<'a> {
    /// A packet.
    Packet(CapturedPacket<'a>),
    /// A damaged position in the file.
    Damage(Damage),
}

/// A captured packet; its bytes are borrowed from the reader until the next call.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CapturedPacket<'a> {
    /// Its number in the file, from 1, as Wireshark counts. Wireshark also numbers blocks that hold an event instead of a packet
    /// (custom blocks, journal entries); these numbers are skipped. After damage the count continues with the packets that can be
    /// read.
    pub number: usize,
    /// Capture time in nanoseconds since 1970; [`Time::ZERO`] if the file has none. Times may go backwards, and capture files may
    /// contain zeros.
    pub time: Time,
    /// The section of the file, from 1 as in Wireshark; a pcap file has one.
    pub section: u32,
    /// The capturing interface, from 0 within its section.
    pub interface: u32,
    /// The link type, which says what the first byte is.
    pub link_type: LinkType,
    /// The captured bytes.
    pub captured: &'a [u8],
    /// Length of the packet on the wire in bytes, according to the file.
    pub original_length: u32,
    /// The comment of the packet; several are joined by line feeds, and invalid UTF-8 is replaced by U+FFFD.
    pub comment: Option<Cow<'a, str>>,
}

impl CapturedPacket<'_> {
    /// Whether the capture cut off bytes of the packet.
    pub fn is_sliced(&self) -> bool {
        self.captured.len() < self.original_length as usize
    }
}

/// A damaged position in a capture file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Damage {
    /// Offset of the damage in bytes from the start of the file; in a compressed file, of its uncompressed content.
    pub at: u64,
    /// What is wrong and what was skipped, as part of a sentence.
    pub what: String,
    /// The effect on the packets.
    pub effect: DamageEffect,
}

/// The effect of damage on the packets around it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DamageEffect {
    /// Packets may be missing here.
    Missing,
    /// It was corrected; no packet is missing.
    Corrected,
    /// Any packet before it may differ from what was captured: a checksum over them does not match.
    Untrusted,
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "byte {}: {}", self.at, self.what)
    }
}

/// The link type of a packet, as listed at tcpdump.org/linktypes.html.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LinkType(pub u16);

impl LinkType {
    /// An Ethernet frame from its destination address, without frame check sequence.
    pub const ETHERNET: LinkType = LinkType(1);
    /// A PROFIBUS frame (LINKTYPE_PROFIBUS_DL) from its start delimiter.
    pub const PROFIBUS: LinkType = LinkType(257);

    /// The link type that pcap reserves for the user's own purpose `number`, 0 to 15 (LINKTYPE_USER0 to LINKTYPE_USER15).
    pub const fn user(number: u8) -> LinkType {
        LinkType(147 + (number & 0xF) as u16)
    }
}

/// Why a file cannot be read as a capture.
#[derive(Debug, Error)]
pub enum NotACapture {
    /// It could not be read.
    #[error("cannot be read: {0}")]
    Unreadable(#[from] io::Error),
    /// It is empty.
    #[error("is empty, a capture begins with a header")]
    Empty,
    /// Its first bytes match neither pcap nor pcapng.
    #[error("is neither pcap nor pcapng: it begins with {}", hex(.0))]
    OtherFormat(Vec<u8>),
}
