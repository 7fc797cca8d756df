//! What the tests of the codecs share: golden frames, and packets of the captures beside the checkout.
#![allow(dead_code, reason = "every test program uses a part of it")]

use pcap_parser::{Block, PcapBlockOwned, PcapError};
use std::io::Write;
use std::path::{Path, PathBuf};

/// Octets from hexadecimal digits; blanks are passed over.
pub fn hex(digits: &str) -> Vec<u8> {
    let digits: Vec<u8> = digits.bytes().filter(|octet| !octet.is_ascii_whitespace()).collect();
    assert!(digits.len().is_multiple_of(2), "an odd number of hexadecimal digits");
    let octet = |pair: &[u8]| u8::from_str_radix(std::str::from_utf8(pair).expect("ASCII"), 16).expect("hexadecimal");
    digits.chunks(2).map(octet).collect()
}

/// The frames of a golden file: its lines `name hex`, comments left out.
pub fn golden(file: &str) -> Vec<(String, Vec<u8>)> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden").join(file);
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    text.lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| line.split_once(' ').expect("a line is a name and hexadecimal digits"))
        .map(|(name, digits)| (name.to_owned(), hex(digits)))
        .collect()
}

/// What `write` appends; it is shown that what stood before it is left alone.
pub fn written(write: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let junk = [0xa5; 7];
    let mut out = junk.to_vec();
    write(&mut out);
    assert_eq!(out[..junk.len()], junk, "the writer touched what stood before it");
    out.split_off(junk.len())
}

/// A file under the folder that `ENCSPEC_SHARED` names, else `../shared` beside the checkout.
///
/// `None`, after a line on the terminal that says so, where there is no such folder.
pub fn shared(file: &str) -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared");
    let folder = std::env::var_os("ENCSPEC_SHARED").map_or(beside, PathBuf::from);
    if folder.is_dir() {
        return Some(folder.join(file));
    }
    skip(&format!("{file} is not there: no folder {}; set ENCSPEC_SHARED", folder.display()));
    None
}

/// Says on the terminal, past the test harness, that the current test looks at nothing.
pub fn skip(why: &str) {
    let thread = std::thread::current();
    let test = thread.name().unwrap_or("a test");
    let _ = writeln!(std::io::stderr(), "skipped: {test}: {why}");
}

/// All packets of a capture, pcap or pcapng, in their order; packet number 1 stands at 0.
pub fn packets(path: &Path) -> Vec<Vec<u8>> {
    let file = std::fs::File::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
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
