//! What real controllers have asked of real devices, asked of this one.

use super::bench::*;
use super::toy::Toy;
use crate::profinet::StackBehaviour;
use alloc::vec::Vec;
use pcap_parser::{Block, PcapBlockOwned, PcapError};
use std::io::Write;
use std::path::{Path, PathBuf};
use wire::datagram::Datagram;
use wire::profinet::blocks::connect::Connect;
use wire::profinet::rpc::{NdrResponse, Opnum, PacketType, Pdu, Uuid};

/// A capture of the folder that `ENCSPEC_SHARED` names, else of `../shared` beside the checkout; `None`, after a line that
/// says so, where there is no such folder.
fn capture(file: &str) -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared");
    let folder = std::env::var_os("ENCSPEC_SHARED").map_or(beside, PathBuf::from);
    if folder.is_dir() {
        return Some(folder.join("captures/profinet").join(file));
    }
    let _ = writeln!(std::io::stderr(), "skipped: {file} is not there: no folder {}", folder.display());
    None
}

fn packets(path: &Path) -> Vec<Vec<u8>> {
    let file = std::fs::File::open(path).unwrap();
    let mut reader = pcap_parser::create_reader(1 << 20, file).unwrap();
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
            Err(PcapError::Incomplete(_)) => reader.refill().unwrap(),
            Err(_) => return packets,
        }
    }
}

/// Every Connect of a capture in turn, to a device in which nothing is plugged: packet number and status, where it is refused.
fn refused(file: &str) -> Option<(usize, Vec<(usize, u32)>)> {
    let mut seen = 0;
    let mut refused = Vec::new();
    for (at, packet) in packets(&capture(file)?).iter().enumerate() {
        let Ok(datagram) = Datagram::parse(packet) else { continue };
        let Ok(pdu) = Pdu::parse(datagram.payload) else { continue };
        let called = (pdu.header.packet_type, pdu.header.interface, pdu.header.opnum);
        if called != (PacketType::REQUEST, Uuid::DEVICE_INTERFACE, Opnum::CONNECT) {
            continue;
        }
        seen += 1;
        let mut toy = Toy::new();
        toy.plugs.clear();
        let mut bench = Bench::of(toy, StackBehaviour::default());
        let (header, body) = bench.call(&pdu.header, pdu.body).unwrap();
        assert_eq!(header.packet_type, PacketType::RESPONSE);
        let (ndr, blocks) = NdrResponse::parse(header.order(), &body).unwrap();
        if ndr.status.is_ok() {
            let answer = Connect::parse(blocks).unwrap();
            assert_eq!(answer.ar_res().unwrap().cm_responder_mac_add, DEVICE);
        } else {
            refused.push((at + 1, ndr.status.into()));
        }
    }
    Some((seen, refused))
}

#[test]
fn the_controller_of_the_versamax_is_understood() {
    let Some(outcome) = refused("office-noise-versamax.pcap") else { return };
    assert_eq!(outcome, (4, Vec::new()));
}

#[test]
fn controllers_of_thirteen_vendors_are_understood() {
    let Some((seen, refused)) = refused("merged-many-devices.pcapng") else { return };
    assert!(seen > 100);
    // Refused are IRInfoBlock (30, 54, 55: RT_CLASS_3 wanted) and SRInfoBlock (393: redundancy wanted), unknown blocks here.
    let unknown_blocks = 0xDB81_4001;
    assert_eq!(refused, [30, 54, 55, 393].map(|number| (number, unknown_blocks)));
}
