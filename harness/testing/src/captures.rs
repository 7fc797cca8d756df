//! Captures and manuals of strangers: where they are looked for, and the packets in a capture.
//!
//! They are other people's work and stay outside the checkout; what needs them says so and does without. Packets are read without a
//! line of ours, so that our reader can be held against it.

use crate::{skip, workspace};
use pcap_parser::{Block, PcapBlockOwned, PcapError};
use std::env;
use std::fs::File;
use std::path::{Path, PathBuf};

/// The file or folder `name` among the manuals and captures of strangers, for instance `captures/profinet/one-ar-life.pcapng`.
///
/// They are where `ENCSPEC_SHARED` says, without that variable in the folder `shared` beside the checkout. A variable that names no
/// folder is never silently replaced by the folder beside the checkout. Where `name` is absent the test is skipped, which is said.
pub fn shared(name: &str) -> Option<PathBuf> {
    let folder = env::var_os("ENCSPEC_SHARED").map_or_else(|| workspace().join("../shared"), PathBuf::from);
    let why = if folder.is_dir() {
        let file = folder.join(name);
        if file.exists() {
            return Some(file);
        }
        format!("{} is not there", file.display())
    } else {
        "there is no folder ../shared beside the checkout and ENCSPEC_SHARED names none".to_owned()
    };
    skip(&format!("{name} is needed, {why}"));
    None
}

/// All packets of a capture, pcap or pcapng, in their order; packet number 1 stands at 0.
///
/// # Panics
///
/// If it cannot be read to its end.
pub fn packets(path: &Path) -> Vec<Vec<u8>> {
    let file = File::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut reader = pcap_parser::create_reader(1 << 20, file).expect("a capture");
    let mut packets = Vec::new();
    loop {
        match reader.next() {
            Ok((offset, block)) => {
                match block {
                    PcapBlockOwned::Legacy(packet) => packets.push(packet.data.to_vec()),
                    PcapBlockOwned::NG(Block::EnhancedPacket(packet)) => {
                        packets.push(packet.data[..packet.caplen as usize].to_vec());
                    }
                    _ => {}
                }
                reader.consume(offset);
            }
            Err(PcapError::Eof) => return packets,
            Err(PcapError::Incomplete(_)) => reader.refill().expect("the rest of the capture"),
            Err(error) => panic!("{}: {error:?}", path.display()),
        }
    }
}
