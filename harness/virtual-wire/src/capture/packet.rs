//! What comes out of a capture file.

use std::borrow::Cow;
use std::fmt;
use std::io;

use plain_text::hex;
use station::Time;
use thiserror::Error;

/// What a capture file yields next.
#[derive(Debug)]
pub enum Item<'a> {
    /// A packet that could be read.
    Packet(Packet<'a>),
    /// A place where the file is not as it should be.
    Damage(Damage),
}

/// One captured packet; its octets are borrowed from the reader until the next call.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Packet<'a> {
    /// Its number in the file, from 1, as Wireshark counts.
    ///
    /// Wireshark also gives numbers to blocks that hold no packet but an event (custom blocks, journal entries);
    /// these numbers are left out. Behind damage the count goes on with what is read.
    pub number: usize,
    /// When it was captured, in nanoseconds since 1970; [`Time::ZERO`] where the file does not say.
    ///
    /// Times may go backwards from one packet to the next, and capture files may hold zeros.
    pub time: Time,
    /// The section of the file, from 1 as in Wireshark; a pcap file has one.
    pub section: u32,
    /// The interface that captured it, from 0 within its section.
    pub interface: u32,
    /// What its first octet is.
    pub link_type: LinkType,
    /// The octets that were kept.
    pub captured: &'a [u8],
    /// How many octets the packet had on the wire, as the file claims.
    pub original_length: u32,
    /// The comment stored with it; several are joined by line feeds, and what is not UTF-8 is shown as U+FFFD.
    pub comment: Option<Cow<'a, str>>,
}

impl Packet<'_> {
    /// Whether octets of the packet were left out when it was captured.
    pub fn is_sliced(&self) -> bool {
        self.captured.len() < self.original_length as usize
    }
}

/// A place where a capture file is not as it should be.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Damage {
    /// Where it begins, in octets from the start of the file; of one that was packed, from the start of what is in it.
    pub at: u64,
    /// What is wrong there and what was skipped, as half a sentence.
    pub what: String,
    /// What it means for the packets.
    pub effect: Effect,
}

/// What damage means for the packets around it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Effect {
    /// Packets may be missing here.
    Missing,
    /// It was put right; no packet is missing.
    Mended,
    /// Any packet before it may have other octets than were captured: a check sum over them does not agree.
    Untrusted,
}

impl fmt::Display for Damage {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "octet {}: {}", self.at, self.what)
    }
}

/// What the octets of a packet begin with, as a number of the list at tcpdump.org/linktypes.html.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LinkType(pub u16);

impl LinkType {
    /// An Ethernet frame from its destination address, without check sequence.
    pub const ETHERNET: LinkType = LinkType(1);
    /// A PROFIBUS frame (LINKTYPE_PROFIBUS_DL) from its start delimiter.
    pub const PROFIBUS: LinkType = LinkType(257);
}

/// Why a file cannot be read as a capture at all.
#[derive(Debug, Error)]
pub enum NotACapture {
    /// It could not be read.
    #[error("cannot be read: {0}")]
    Unreadable(#[from] io::Error),
    /// It has no octets.
    #[error("is empty, a capture begins with a header")]
    Empty,
    /// Its first octets are those of neither pcap nor pcapng.
    #[error("is neither pcap nor pcapng: it begins with {}", hex(.0))]
    OtherFormat(Vec<u8>),
}
