//! Ethernet, UDP, ARP, RT, DCP and LLDP against frames built with scapy, see golden/frames.py: the parsers against the
//! fields in the script, the writers against the bytes.

use crate::round_trip::written;
use core::net::{Ipv4Addr, SocketAddrV4};
use encspec_wire as wire;
use rstest::rstest;
use wire::datagram::arp::{Arp, ArpOperation};
use wire::datagram::{Checksum, Datagram, Ipv4, write_udp};
use wire::ethernet::{EtherType, FrameHeader, Mac, Vlan};
use wire::lldp::{Lldp, Oui, Tlv};
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::dcp::{
    BlockError, BlockInfo, BlockQualifier, Dcp, DcpBlock, DcpValue, Element, ResetMode, ServiceType,
};
use wire::profinet::rt::{CyclicFrame, DataStatus, FrameId, Instance, IoxS};

const CONTROLLER: Mac = Mac([2, 0, 0, 0, 0, 1]);
const DEVICE: Mac = Mac([2, 0, 0, 0, 1, 0]);
const CONTROLLER_IP: Ipv4Addr = Ipv4Addr::new(192, 168, 0, 1);
const DEVICE_IP: Ipv4Addr = Ipv4Addr::new(192, 168, 0, 10);
const XID: u32 = 0x0100_0001;

fn frame(name: &str) -> Vec<u8> {
    let frames = testing::golden("scapy-rt-dcp.txt");
    frames.into_iter().find(|(known, _)| known == name).unwrap_or_else(|| panic!("no golden frame {name}")).1
}

const IOPS_GOOD: u8 = 0x80;
const BAD_BY_DEVICE: u8 = 0x40;

#[rstest]
#[case::untagged("rt_untagged", None, None, 0xc001, b"\x80\x04\x1f\x00\x00", 0x1240, 0x35)]
#[case::tagged("rt_tagged", Some(Vlan::RT), None, 0x8000, b"\x80\x12\x34", 0xffc0, 0x15)]
#[case::two_tags(
    "rt_two_tags",
    Some(Vlan { protocol: EtherType::PROVIDER_VLAN, control: 0x2007 }),
    Some(Vlan { protocol: EtherType::VLAN, control: 0xc123 }),
    0xc001, b"\x01", 1, 0x34
)]
fn a_cyclic_frame_is_read_and_written(
    #[case] name: &str,
    #[case] tag: Option<Vlan>,
    #[case] inner_tag: Option<Vlan>,
    #[case] frame_id: u16,
    #[case] values: &[u8],
    #[case] cycle_counter: u16,
    #[case] data_status: u8,
) {
    let golden = frame(name);
    let (header, payload) = FrameHeader::parse(&golden).expect("a frame");
    let expected =
        FrameHeader { destination: DEVICE, source: CONTROLLER, tag, inner_tag, ether_type: EtherType::PROFINET };
    assert_eq!(header, expected);
    assert_eq!(&golden[header.payload_offset()..], payload);

    let cyclic = CyclicFrame::parse(payload, 40).expect("a cyclic frame");
    assert_eq!(cyclic.frame_id, FrameId(frame_id));
    assert_eq!(cyclic.status.cycle_counter, cycle_counter);
    assert_eq!(cyclic.status.data_status, DataStatus(data_status));
    assert_eq!(cyclic.status.transfer_status, 0);
    assert_eq!(cyclic.padding, b"");
    let (data, rest) = cyclic.data.split_at(values.len());
    assert_eq!(data, values);
    assert_eq!(rest[..2], [IOPS_GOOD, BAD_BY_DEVICE]);
    assert!(rest[2..].iter().all(|octet| *octet == 0));
    assert_eq!(CyclicFrame::parse_to_end(payload), Ok(cyclic));

    let octets = written(|out| {
        header.write(out);
        cyclic.write(out);
    });
    assert_eq!(octets, golden);
}

#[test]
fn the_longest_cyclic_frame_keeps_its_reserved_bits() {
    let golden = frame("rt_long");
    let (header, payload) = FrameHeader::parse(&golden).expect("a frame");
    let cyclic = CyclicFrame::parse(payload, 1440).expect("a cyclic frame");
    assert_eq!((cyclic.data[255], cyclic.data[256], cyclic.data[1419]), (255, 0, 139));
    assert_eq!(cyclic.status.data_status, DataStatus(0xc8));
    assert_eq!(cyclic.status.data_status.reserved(), 0x48);
    assert!(!cyclic.status.data_status.is_valid() && !cyclic.status.data_status.is_run());
    assert!(cyclic.status.data_status.has_problem() && cyclic.status.data_status.has(DataStatus::IGNORE));
    assert_eq!(cyclic.status.transfer_status, 1);
    let octets = written(|out| {
        header.write(out);
        cyclic.write(out);
    });
    assert_eq!(octets, golden);
}

#[test]
fn the_status_follows_the_data_whatever_comes_after_it() {
    let golden = frame("rt_untagged");
    let mut padded = golden[FrameHeader::UNTAGGED_LENGTH..].to_vec();
    padded.extend([0xee; 6]);
    let cyclic = CyclicFrame::parse(&padded, 40).expect("a cyclic frame");
    assert_eq!(cyclic.status.cycle_counter, 0x1240);
    assert_eq!(cyclic.padding, [0xee; 6]);
    let longer = CyclicFrame::parse(&padded, 47).expect_err("seven bytes are missing");
    assert_eq!(longer.to_string(), "PROFINET RT: byte 52: expected 1 bytes, 0 left");
}

/// `PNIORealTime_IOxS` of scapy in the golden frames: one good, one bad, detected by the device.
#[test]
fn iops_has_the_instance_that_detected_the_bad_state() {
    let golden = frame("rt_untagged");
    let [good, bad] = [IoxS(golden[21]), IoxS(golden[22])];
    assert!(good.is_good() && !bad.is_good());
    assert_eq!(bad, IoxS::bad(Instance::Device));
    assert_eq!(bad.instance(), Instance::Device);
    assert!(
        (good.reserved(), good.is_extended()) == (0, false)
            && IoxS(0x83).is_extended()
            && IoxS(0x9f).reserved() == 0x1e
    );
}

fn ip(gateway: Ipv4Addr, mask: [u8; 4]) -> IpParameter {
    IpParameter { address: DEVICE_IP, mask: Ipv4Addr::from(mask), gateway }
}

fn servers() -> [Ipv4Addr; 4] {
    [[8, 8, 8, 8], [9, 9, 9, 9], [0, 0, 0, 0], [1, 1, 1, 1]].map(Ipv4Addr::from)
}

fn station(name: &str) -> DcpValue {
    DcpValue::NameOfStation(name.into())
}

fn set(qualifier: BlockQualifier, value: DcpValue) -> Dcp {
    Dcp::set(XID, vec![DcpBlock::set(qualifier, value)])
}

fn tell(value: DcpValue) -> DcpBlock {
    DcpBlock::report(BlockInfo::NONE, value)
}

fn identify_response() -> Dcp {
    let net = [255, 255, 255, 0];
    Dcp::identify(XID, 1, vec![DcpValue::AllSelector]).response(vec![
        tell(DcpValue::Vendor(b"encoder".to_vec())),
        tell(station("enc-10")),
        tell(DcpValue::DeviceId { vendor_id: 0x0106, device_id: 0x0303 }),
        tell(DcpValue::DeviceRole { role: 1, reserved: 0 }),
        tell(DcpValue::DeviceOptions(vec![Element::NAME_OF_STATION, Element::IP_PARAMETER, Element::RESET_TO_FACTORY])),
        tell(DcpValue::AliasName(b"port-001.enc-1".to_vec())),
        tell(DcpValue::DeviceInstance { high: 0, low: 1 }),
        tell(DcpValue::OemDeviceId { vendor_id: 0x1234, device_id: 0x5678 }),
        tell(DcpValue::Mac(DEVICE)),
        DcpBlock::report(BlockInfo(0x81), DcpValue::IpParameter(ip(Ipv4Addr::UNSPECIFIED, net))),
        DcpBlock::report(BlockInfo::IP_BY_DHCP, DcpValue::FullIpSuite(ip(CONTROLLER_IP, [255, 255, 0, 0]), servers())),
        tell(DcpValue::DeviceInitiative(1)),
        tell(DcpValue::Raw { element: Element { option: 0x80, suboption: 9 }, octets: vec![0xde, 0xad, 0xbe, 0xef] }),
    ])
}

#[rstest]
#[case("identify_all", Dcp::identify(XID, 1, vec![DcpValue::AllSelector]))]
#[case("identify_by_name", Dcp::identify(XID, 6400, vec![station("enc-one")]))]
#[case("identify_by_alias", Dcp::identify(XID, 1, vec![DcpValue::AliasName(b"port-001.enc-1".to_vec())]))]
#[case("get_device_id", Dcp::get(XID, vec![Element::DEVICE_ID]))]
#[case("set_name_permanent", set(BlockQualifier::PERMANENT, station("enc-one")))]
#[case("set_name_temporary", set(BlockQualifier::TEMPORARY, station("enc-10")))]
#[case("set_ip_permanent", set(BlockQualifier(1), DcpValue::IpParameter(ip(CONTROLLER_IP, [255, 255, 255, 0]))))]
#[case("set_full_ip", set(BlockQualifier(0), DcpValue::FullIpSuite(ip(CONTROLLER_IP, [255, 255, 255, 0]), servers())))]
#[case("signal", Dcp::signal(XID))]
#[case("factory_reset", Dcp::factory_reset(XID))]
#[case("reset_communication", Dcp::reset_to_factory(XID, ResetMode::COMMUNICATION))]
#[case("reset_all", Dcp::reset_to_factory(XID, ResetMode::ALL))]
#[case("identify_response", identify_response())]
#[case("get_response", Dcp::get(XID, vec![]).response(vec![
    tell(DcpValue::DeviceId { vendor_id: 0x0106, device_id: 0x0303 }),
    DcpBlock::outcome(Element::DHCP_CLIENT, BlockError::SUBOPTION_NOT_SUPPORTED),
]))]
#[case("set_response_ok", Dcp::set(XID, vec![]).response(vec![DcpBlock::outcome(Element::NAME_OF_STATION, BlockError::OK)]))]
#[case("set_response_refused", Dcp::set(XID, vec![]).response(vec![
    DcpBlock::outcome(Element::IP_PARAMETER, BlockError::IN_OPERATION),
    DcpBlock::outcome(Element::STOP, BlockError::OPTION_NOT_SUPPORTED),
]))]
#[case("not_supported", Dcp::set(XID, vec![]).not_supported())]
fn a_dcp_frame_is_read_and_written(#[case] name: &str, #[case] expected: Dcp) {
    let golden = frame(name);
    let (header, payload) = FrameHeader::parse(&golden).expect("a frame");
    let (destination, source) = match (expected.service_type, expected.frame_id) {
        (ServiceType::REQUEST, FrameId::DCP_IDENTIFY_REQUEST) => (Mac::DCP_MULTICAST, CONTROLLER),
        (ServiceType::REQUEST, _) => (DEVICE, CONTROLLER),
        _ => (CONTROLLER, DEVICE),
    };
    assert_eq!(header, FrameHeader::new(destination, source, EtherType::PROFINET));
    assert_eq!(Dcp::parse(payload), Ok(expected.clone()));
    assert_eq!(written(|out| expected.write_frame(destination, source, out)), golden);
}

#[rstest]
#[case("arp_request", Arp::request(CONTROLLER, CONTROLLER_IP, DEVICE_IP))]
#[case("arp_reply", Arp::request(CONTROLLER, CONTROLLER_IP, DEVICE_IP).reply(DEVICE))]
fn an_arp_frame_is_read_and_written(#[case] name: &str, #[case] expected: Arp) {
    let golden = frame(name);
    let (header, payload) = FrameHeader::parse(&golden).expect("a frame");
    assert_eq!(header.ether_type, EtherType::ARP);
    assert_eq!(Arp::parse(payload), Ok(expected));
    assert_eq!(written(|out| expected.write_frame(out)), golden);
    assert_eq!(expected.operation == ArpOperation::REQUEST, name == "arp_request");
}

fn ports() -> ((Mac, SocketAddrV4), (Mac, SocketAddrV4)) {
    let source = (CONTROLLER, SocketAddrV4::new(CONTROLLER_IP, 49152));
    (source, (DEVICE, SocketAddrV4::new(DEVICE_IP, 34964)))
}

#[rstest]
#[case("udp", b"a datagram that needs no padding", 42)]
#[case("udp_odd", b"an odd number of octets in it", 42)]
#[case("udp_short", b"short", 42)]
fn a_datagram_is_read_and_written(#[case] name: &str, #[case] payload: &[u8], #[case] payload_offset: usize) {
    let golden = frame(name);
    let (source, destination) = ports();
    let datagram = Datagram::parse(&golden).expect("a datagram");
    let expected = Datagram {
        source_mac: source.0,
        destination_mac: destination.0,
        source: source.1,
        destination: destination.1,
        ip_checksum: Checksum::Good,
        udp_checksum: Checksum::Good,
        payload,
        payload_offset,
    };
    assert_eq!(datagram, expected);
    assert_eq!(written(|out| write_udp(source, destination, payload, out).expect("it fits")), golden);
}

#[rstest]
#[case("udp_no_checksum", Checksum::Good, Checksum::Absent, true, b"nobody computed a sum", 42)]
#[case("udp_bad_checksum", Checksum::Good, Checksum::Bad, false, b"this sum is wrong", 42)]
#[case("ip_bad_checksum", Checksum::Bad, Checksum::Good, false, b"that sum is wrong", 42)]
#[case("udp_options", Checksum::Good, Checksum::Good, true, b"behind options", 46)]
#[case("udp_tagged", Checksum::Good, Checksum::Good, true, b"behind a tag", 46)]
fn a_datagram_is_parsed_with_the_results_of_its_checksums(
    #[case] name: &str,
    #[case] ip_checksum: Checksum,
    #[case] udp_checksum: Checksum,
    #[case] ok: bool,
    #[case] payload: &[u8],
    #[case] payload_offset: usize,
) {
    let golden = frame(name);
    let datagram = Datagram::parse(&golden).expect("a datagram");
    assert_eq!((datagram.ip_checksum, datagram.udp_checksum, datagram.checksum_ok()), (ip_checksum, udp_checksum, ok));
    assert_eq!((datagram.payload, datagram.payload_offset), (payload, payload_offset));
    assert_eq!(golden[payload_offset..][..payload.len()], *payload);
}

#[rstest]
#[case("ip_first_fragment", "IPv4: byte 20: Fragment Offset is 0x2000, expected a packet that is not fragmented")]
#[case("ip_last_fragment", "IPv4: byte 20: Fragment Offset is 0x3, expected a packet that is not fragmented")]
#[case("icmp", "IPv4: byte 23: Protocol is 0x1, expected 17 (UDP)")]
#[case("arp_reply", "Ethernet: byte 12: EtherType is 0x806, expected 0x0800 (IPv4)")]
fn the_error_for_any_other_packet_says_what_it_is(#[case] name: &str, #[case] error: &str) {
    let golden = frame(name);
    assert_eq!(Datagram::parse(&golden).expect_err("no datagram").to_string(), error);
}

#[test]
fn a_fragment_is_parsed_as_an_ipv4_packet() {
    let golden = frame("ip_last_fragment");
    let packet = Ipv4::parse(&golden[FrameHeader::UNTAGGED_LENGTH..]).expect("an IPv4 packet");
    assert!(packet.is_fragment());
    assert_eq!((packet.identification, packet.protocol, packet.payload.len()), (7, Ipv4::UDP, 24));
}

#[test]
fn a_datagram_longer_than_a_frame_is_an_error() {
    let (source, destination) = ports();
    let mut out = vec![1, 2, 3];
    assert_eq!(write_udp(source, destination, &[0; 1472], &mut out), Ok(()));
    assert_eq!(out.len(), 3 + 1514);
    out.truncate(3);
    write_udp(source, destination, &[0; 1473], &mut out).expect_err("one byte too many");
    assert_eq!(out, [1, 2, 3]);
}

fn neighbour() -> Lldp {
    Lldp {
        tlvs: vec![
            Tlv::ChassisId { subtype: Tlv::LOCALLY_ASSIGNED, id: b"encoder-under-test".to_vec() },
            Tlv::PortId { subtype: Tlv::LOCALLY_ASSIGNED, id: b"port-001".to_vec() },
            Tlv::TimeToLive(20),
            Tlv::PortDescription(b"first port".to_vec()),
            Tlv::SystemName(b"encoder".to_vec()),
            Tlv::SystemDescription(b"an absolute encoder".to_vec()),
            Tlv::SystemCapabilities { capabilities: 0x80, enabled: 0x80 },
            Tlv::PortDelays([1, 2, 3, 4, 5]),
            Tlv::PortStatus { rt_class_2: 1, rt_class_3: 2 },
            Tlv::ChassisMac(DEVICE),
            Tlv::MacPhy { autonegotiation: 3, advertised: 0x6c00, mau_type: 16 },
            Tlv::Organizational { oui: Oui([0x00, 0x80, 0xc2]), subtype: 1, octets: vec![0, 1] },
        ],
    }
}

#[test]
fn an_lldp_frame_is_read_and_written() {
    let golden = frame("lldp");
    let (header, payload) = FrameHeader::parse(&golden).expect("a frame");
    assert_eq!(header, FrameHeader::new(Mac::LLDP_MULTICAST, DEVICE, EtherType::LLDP));
    assert_eq!(Lldp::parse(payload), Ok(neighbour()));
    assert_eq!(written(|out| neighbour().write_frame(DEVICE, out)), golden);
}

#[test]
fn a_tlv_of_invalid_length_is_preserved() {
    let short = Lldp::parse(&testing::hex("0601 14  fe06 000ecf 02 0001  0000")).expect("well formed");
    let expected = [
        Tlv::Raw { kind: 3, octets: vec![0x14] },
        Tlv::Organizational { oui: Oui::PNO, subtype: 2, octets: vec![0, 1] },
    ];
    assert_eq!(short.tlvs, expected);
    assert_eq!(written(|out| short.write(out)), testing::hex("0601 14  fe06 000ecf 02 0001  0000"));
}

/// Runs every parser on every prefix of every golden frame, and on the frame with every bit flipped.
#[test]
fn no_damage_makes_a_parser_panic() {
    for (name, golden) in testing::golden("scapy-rt-dcp.txt") {
        let few = &golden[..golden.len().min(220)];
        testing::every_prefix_and_flip(few, |octets| {
            let _ = Datagram::parse(octets);
            let Ok((header, payload)) = FrameHeader::parse(octets) else { return };
            let _ = (Arp::parse(payload), Ipv4::parse(payload), FrameId::peek(payload));
            let _ = (CyclicFrame::parse(payload, 40), CyclicFrame::parse_to_end(payload));
            let read_twice = |dcp: Dcp| Dcp::parse(&written(|out| dcp.write(out))) == Ok(dcp);
            assert!(Dcp::parse(payload).map_or(true, read_twice), "{name}: DCP loses data");
            let read_twice = |lldp: Lldp| Lldp::parse(&written(|out| lldp.write(out))) == Ok(lldp);
            assert!(Lldp::parse(payload).map_or(true, read_twice), "{name}: LLDP loses data");
            let again = written(|out| {
                header.write(out);
                out.extend(payload);
            });
            assert_eq!(again, octets, "{name}: the header loses data");
        });
    }
}
