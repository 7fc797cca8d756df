//! Interface and port data of a real device; the values are those of tshark 4.0.17:
//! `tshark -r record-reads.pcapng -Y 'frame.number == 4' -V`.
#![allow(clippy::unwrap_used, reason = "an unwrap fails the test")]

use crate::round_trip::written;
use encspec_wire::ethernet::Mac;
use encspec_wire::profinet::blocks::physical::{InterfaceDataReal, MultipleBlock, Peer, PortDataReal};
use std::net::Ipv4Addr;
use testing::{packets, shared};

/// The record 0xF841: 224 bytes after the header of the response, from byte 142 of the frame on.
fn record() -> Option<Vec<u8>> {
    let path = shared("captures/profinet/record-reads.pcapng")?;
    let frame = packets(&path).swap_remove(3);
    Some(frame[142 + 64..][..224].to_vec())
}

#[test]
fn interface_and_two_ports() {
    let Some(octets) = record() else { return };
    let blocks = MultipleBlock::parse_record(&octets).unwrap();
    let places: Vec<_> = blocks.iter().map(|block| (block.api, block.slot, block.subslot)).collect();
    assert_eq!(places, [(0, 0, 0x8000), (0, 0, 0x8001), (0, 0, 0x8002)]);
    let interface = InterfaceDataReal::parse(&blocks[0].blocks).unwrap();
    assert_eq!(
        interface,
        InterfaceDataReal {
            chassis: b"versamax-pns11".to_vec(),
            mac: Mac([0x00, 0x09, 0x91, 0x43, 0xE0, 0x67]),
            address: Ipv4Addr::new(192, 168, 1, 2),
            mask: Ipv4Addr::new(255, 255, 255, 0),
            gateway: Ipv4Addr::new(192, 168, 1, 2),
        }
    );
    let with_neighbour = PortDataReal {
        slot: 0,
        subslot: 0x8001,
        port: b"port-001".to_vec(),
        peers: vec![Peer {
            port: b"port-004".to_vec(),
            chassis: b"siemens-x208-switch".to_vec(),
            line_delay: 0,
            mac: Mac([0x00, 0x0E, 0x8C, 0xEF, 0x75, 0xC5]),
        }],
        mau_type: 16,
        domain_boundary: 0,
        multicast_boundary: 0,
        port_state: 0,
        link_state: 1,
        media_type: 1,
    };
    let alone = PortDataReal {
        subslot: 0x8002,
        port: b"port-002".to_vec(),
        peers: vec![],
        mau_type: 0,
        link_state: 2,
        ..with_neighbour.clone()
    };
    for (block, port) in blocks[1..].iter().zip([with_neighbour, alone]) {
        assert_eq!(PortDataReal::parse(&block.blocks).unwrap(), port);
        assert_eq!(written(|out| port.write(out)), block.blocks);
    }
    assert_eq!(written(|out| interface.write(out)), blocks[0].blocks);
    assert_eq!(written(|out| blocks.iter().for_each(|block| block.write(out))), octets);
}

#[test]
fn a_truncated_record_is_an_error() {
    let Some(octets) = record() else { return };
    let blocks = MultipleBlock::parse_record(&octets).unwrap();
    for length in 0..blocks[1].blocks.len() {
        assert!(PortDataReal::parse(&blocks[1].blocks[..length]).is_err(), "{length}");
    }
    assert!(MultipleBlock::parse_record(&octets[..223]).is_err());
}
