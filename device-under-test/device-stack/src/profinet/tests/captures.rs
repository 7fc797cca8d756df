//! What real controllers have asked of real devices, asked of this one.

use super::bench::*;
use super::toy::Toy;
use alloc::vec::Vec;
use wire::datagram::Datagram;
use wire::profinet::blocks::connect::Connect;
use wire::profinet::rpc::{NdrResponse, Opnum, PacketType, Pdu, Uuid};

/// Every Connect of a capture in turn, to a device in which nothing is plugged: packet number and status, where it is refused.
fn refused(file: &str) -> Option<(usize, Vec<(usize, u32)>)> {
    let mut seen = 0;
    let mut refused = Vec::new();
    for (at, packet) in
        testing::packets(&testing::shared(&std::format!("captures/profinet/{file}"))?).iter().enumerate()
    {
        let Ok(datagram) = Datagram::parse(packet) else { continue };
        let Ok(pdu) = Pdu::parse(datagram.payload) else { continue };
        let called = (pdu.header.packet_type, pdu.header.interface, pdu.header.opnum);
        if called != (PacketType::REQUEST, Uuid::DEVICE_INTERFACE, Opnum::CONNECT) {
            continue;
        }
        seen += 1;
        let mut toy = Toy::new();
        toy.plugs.clear();
        let mut bench = Bench::of(toy);
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
