//! Connect requests from captures of real controllers, sent to this device.

use super::bench::*;
use super::toy::ToyIoApplication;
use alloc::vec::Vec;
use wire::datagram::Datagram;
use wire::profinet::blocks::connect::Connect;
use wire::profinet::rpc::{NdrResponse, Opnum, PacketType, RpcPdu, Uuid};

/// Sends every Connect of a capture to a device without modules. Returns the number of requests, and packet number
/// and status of each refused one.
fn refused(file: &str) -> Option<(usize, Vec<(usize, u32)>)> {
    let mut count = 0;
    let mut refused = Vec::new();
    for (at, packet) in
        testing::packets(&testing::shared(&std::format!("captures/profinet/{file}"))?).iter().enumerate()
    {
        let Ok(datagram) = Datagram::parse(packet) else { continue };
        let Ok(pdu) = RpcPdu::parse(datagram.payload) else { continue };
        let called = (pdu.header.packet_type, pdu.header.interface, pdu.header.opnum);
        if called != (PacketType::REQUEST, Uuid::DEVICE_INTERFACE, Opnum::CONNECT) {
            continue;
        }
        count += 1;
        let mut toy = ToyIoApplication::new();
        toy.plugs.clear();
        let mut bench = StackBench::of(toy);
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
    Some((count, refused))
}

#[test]
fn the_connects_of_a_versamax_controller_are_accepted() {
    let Some(outcome) = refused("office-noise-versamax.pcap") else { return };
    assert_eq!(outcome, (4, Vec::new()));
}

#[test]
fn the_connects_of_controllers_of_thirteen_vendors_are_accepted() {
    let Some((count, refused)) = refused("merged-many-devices.pcapng") else { return };
    assert!(count > 100);
    // IRInfoBlock (packets 30, 54, 55: RT_CLASS_3) and SRInfoBlock (393: system redundancy) are unknown blocks here.
    let unknown_blocks = 0xDB81_4001;
    assert_eq!(refused, [30, 54, 55, 393].map(|number| (number, unknown_blocks)));
}
