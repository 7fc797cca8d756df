//! Interface, ports and neighbours: LLDP announcements, and the records about them.

use super::bench::*;
use super::records::{implicit, read};
use super::toy::ToyIoApplication;
use alloc::vec::Vec;
use core::net::Ipv4Addr;
use rstest::rstest;
use station::Duration;
use wire::datagram::arp::Arp;
use wire::ethernet::{EtherType, FrameHeader, Mac};
use wire::lldp::{Lldp, Tlv};
use wire::profinet::blocks::physical::{InterfaceDataReal, MultipleBlock, Peer, PortDataReal};
use wire::profinet::dcp::{BlockQualifier, Dcp, DcpBlock, DcpValue};

const PORT: (u32, u16, u16) = (0, 0, 0x8001);
const INTERFACE: (u32, u16, u16) = (0, 0, 0x8000);

/// Sends the LLDP announcement of a neighbour with this chassis and port.
fn announce(bench: &mut StackBench, chassis: (u8, &[u8]), port: &str, mac: Option<Mac>) {
    let mut tlvs = Vec::from([
        Tlv::ChassisId { subtype: chassis.0, id: chassis.1.to_vec() },
        Tlv::PortId { subtype: Tlv::LOCALLY_ASSIGNED, id: port.into() },
        Tlv::TimeToLive(20),
    ]);
    tlvs.extend(mac.map(Tlv::ChassisMac));
    let mut frame = Vec::new();
    Lldp { tlvs }.write_frame(CONTROLLER, &mut frame);
    bench.send(&frame);
}

fn peers(bench: &mut StackBench) -> Vec<Peer> {
    let (status, octets) = implicit(bench, PORT, 0x802A);
    assert!(status.is_ok());
    PortDataReal::parse(&octets).unwrap().peers
}

/// dot3MauType 16 is 100BASE-TX full duplex (RFC 4836). Link state 1 is up and media type 1 is copper, as in a
/// capture of a real device that reports its ports.
#[test]
fn a_port_is_reported_with_its_neighbour() {
    let mut bench = StackBench::new();
    announce(&mut bench, (Tlv::LOCALLY_ASSIGNED, b"switch"), "port-003", Some(Mac([2, 0, 0, 0, 9, 9])));
    let (status, octets) = implicit(&mut bench, PORT, 0x802A);
    assert!(status.is_ok());
    let port = PortDataReal::parse(&octets).unwrap();
    assert_eq!((port.slot, port.subslot, port.port.as_slice()), (0, 0x8001, &b"port-001"[..]));
    assert_eq!((port.mau_type, port.link_state, port.media_type), (16, 1, 1));
    let mac = Mac([2, 0, 0, 0, 9, 9]);
    assert_eq!(port.peers, [Peer { port: b"port-003".to_vec(), chassis: b"switch".to_vec(), line_delay: 0, mac }]);
}

#[rstest]
#[case::name_in_the_chassis(7, b"switch", "port-003", "port-003", "switch")]
#[case::name_after_the_port(7, b"a long description", "port-003.switch-1", "port-003", "switch-1")]
#[case::nameless(4, &[2, 0, 0, 0, 0, 1], "port-003", "port-003", "02-00-00-00-00-01")]
fn the_name_of_a_neighbour_comes_from_its_announcement(
    #[case] subtype: u8,
    #[case] chassis: &[u8],
    #[case] port_id: &str,
    #[case] port: &str,
    #[case] name: &str,
) {
    let mut bench = StackBench::new();
    assert_eq!(peers(&mut bench), []);
    announce(&mut bench, (subtype, chassis), port_id, None);
    let peers = peers(&mut bench);
    assert_eq!(peers.len(), 1);
    assert_eq!((peers[0].port.as_slice(), peers[0].chassis.as_slice()), (port.as_bytes(), name.as_bytes()));
    assert_eq!(peers[0].mac, CONTROLLER, "the sender, if the announcement contains no ChassisMac");
}

#[test]
fn one_record_reports_interface_and_ports() {
    let mut bench = StackBench::new();
    let (status, octets) = implicit(&mut bench, (0, 0, 1), 0xF841);
    assert!(status.is_ok());
    let blocks = MultipleBlock::parse_record(&octets).unwrap();
    let addresses: Vec<_> = blocks.iter().map(|block| (block.api, block.slot, block.subslot)).collect();
    assert_eq!(addresses, [(0, 0, 0x8000), (0, 0, 0x8001), (0, 0, 0x8002)]);
    let interface = InterfaceDataReal::parse(&blocks[0].blocks).unwrap();
    assert_eq!((interface.chassis.as_slice(), interface.mac), (&b"toy"[..], DEVICE));
    assert_eq!(interface.address, Ipv4Addr::new(192, 168, 0, 10));
    let second = PortDataReal::parse(&blocks[2].blocks).unwrap();
    assert_eq!((second.port.as_slice(), second.mau_type, second.link_state), (&b"port-002"[..], 0, 2));
    let (_, alone) = implicit(&mut bench, INTERFACE, 0x8080);
    assert_eq!(alone, blocks[0].blocks);
}

#[rstest]
#[case::port_of_the_access_point((0, 0, 1), 0x802A)]
#[case::port_of_the_interface(INTERFACE, 0x802A)]
#[case::interface_of_a_port(PORT, 0x8080)]
#[case::second_port((0, 0, 0x8002), 0x802A)]
fn records_of_missing_submodules_are_refused(#[case] place: (u32, u16, u16), #[case] index: u16) {
    let mut toy = ToyIoApplication::new();
    toy.identity.ports = 1;
    let mut bench = StackBench::of(toy);
    assert!(!implicit(&mut bench, place, index).0.is_ok());
    assert!(implicit(&mut bench, PORT, 0x802A).0.is_ok(), "the only port has the record");
}

#[test]
fn a_record_of_the_port_can_be_read_within_a_connection() {
    let mut bench = StackBench::new();
    bench.start();
    assert!(read(&mut bench, PORT, 0x802A).0.is_ok());
    bench.check_with_tshark();
}

fn announced(bench: &mut StackBench) -> Vec<Lldp> {
    let frames = bench.take();
    let headers = frames.iter().filter_map(|frame| FrameHeader::parse(frame).ok());
    headers
        .filter(|(header, _)| header.ether_type == EtherType::LLDP)
        .map(|(_, payload)| Lldp::parse(payload).unwrap())
        .collect()
}

#[test]
fn a_new_name_is_announced_at_once() {
    let mut bench = StackBench::new();
    bench.run(Duration::from_secs(1));
    bench.take();
    let name = DcpValue::NameOfStation(b"new".to_vec());
    let mut frame = Vec::new();
    Dcp::set(3, [DcpBlock::set(BlockQualifier::PERMANENT, name)].into()).write_frame(DEVICE, CONTROLLER, &mut frame);
    bench.send(&frame);
    bench.run(Duration::from_millis(1));
    let [lldp] = &announced(&mut bench)[..] else { panic!("one announcement") };
    assert_eq!(lldp.tlvs[0], Tlv::ChassisId { subtype: 7, id: b"new".to_vec() });
}

/// RFC 5227: an ARP probe comes from 0.0.0.0, and the station with the address answers it.
#[rstest]
#[case::own([192, 168, 0, 10], 1)]
#[case::of_another([192, 168, 0, 11], 0)]
#[case::none([0; 4], 0)]
fn probes_for_the_address_of_the_device_are_answered(#[case] target: [u8; 4], #[case] answers: usize) {
    let mut bench = StackBench::new();
    bench.take();
    let probe = Arp::request(CONTROLLER, Ipv4Addr::UNSPECIFIED, target.into());
    let mut frame = Vec::new();
    probe.write_frame(&mut frame);
    bench.send(&frame);
    let frames = bench.take();
    let replies = frames.iter().filter_map(|frame| FrameHeader::parse(frame).ok());
    let replies = replies.filter(|(header, _)| header.ether_type == EtherType::ARP);
    let replies: Vec<Arp> = replies.map(|(_, payload)| Arp::parse(payload).unwrap()).collect();
    assert_eq!(replies, alloc::vec![probe.reply(DEVICE); answers]);
}
