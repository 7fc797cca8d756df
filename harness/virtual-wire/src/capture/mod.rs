//! Capture files: reads pcap and pcapng, compressed or not, in one pass with constant memory; writes pcapng.
//!
//! Readers recover as much as possible: damage is an item in the stream of packets, not an error that ends it. This module must
//! not know what the frames mean; a packet carries its link type.

mod interface;
mod packet;
mod pcap;
mod pcapng;
mod reader;
mod unpack;
mod window;
mod writer;

pub use packet::{CaptureItem, CapturedPacket, Damage, DamageEffect, LinkType, NotACapture};
pub use reader::CaptureReader;
pub use writer::PcapngWriter;

#[cfg(test)]
mod tests;
