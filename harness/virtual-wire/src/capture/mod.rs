//! Capture files: reading pcap and pcapng, packed or not, in one pass with flat memory, writing pcapng.
//!
//! What can be read is read: damage is an item in the stream of packets, never the end of the program. Nothing here
//! knows what the frames mean; a packet carries its link type and the rest is for others.

mod interface;
mod packet;
mod pcap;
mod pcapng;
mod reader;
mod unpack;
mod window;
mod writer;

pub use packet::{Damage, Effect, Item, LinkType, NotACapture, Packet};
pub use reader::CaptureReader;
pub use writer::PcapngWriter;

#[cfg(test)]
mod tests;
