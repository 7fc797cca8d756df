//! Third-party captures and manuals: where they are, and the packets in a capture.
//!
//! They are not part of the checkout; a test that needs a missing one is skipped. Packets are read by `pcap-parser` alone, so that
//! the reader of encspec can be compared with it.

use crate::{skip, workspace};
use pcap_parser::{Block, PcapBlockOwned, PcapError};
use std::env;
use std::fs::File;
use std::path::{Path, PathBuf};

/// The path of a third-party file or folder, for instance `captures/profinet/one-ar-life.pcapng`.
///
/// `ENCSPEC_SHARED` names the folder that holds them; without that variable it is the folder `shared` beside the checkout. If the
/// variable is set but names no folder, there is no fallback. If `name` is missing the test is reported as skipped.
pub fn shared(name: &str) -> Option<PathBuf> {
    let folder = env::var_os("ENCSPEC_SHARED").map_or_else(|| workspace().join("../shared"), PathBuf::from);
    let why = if folder.is_dir() {
        let file = folder.join(name);
        if file.exists() {
            return Some(file);
        }
        format!("{} does not exist", file.display())
    } else {
        "neither ENCSPEC_SHARED nor ../shared beside the checkout is a folder".to_owned()
    };
    skip(&format!("it needs {name}: {why}"));
    None
}

/// All packets of a capture (pcap or pcapng) in their order; packet number 1 has index 0.
///
/// # Panics
///
/// If the capture cannot be read to its end.
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
