//! Ethernet, UDP, ARP, RT, DCP and LLDP in frames of real devices; the values and the counts are those of tshark 4.0.17:
//! `tshark -r FILE -Y 'frame.number == N' -V`, the counts with `-o udp.check_checksum:TRUE -Y FILTER`.

use crate::round_trip::written;
use core::net::Ipv4Addr;
use encspec_wire as wire;
use rstest::rstest;
use testing::{packets, shared};
use wire::datagram::arp::{Arp, ArpOperation};
use wire::datagram::{Checksum, Datagram};
use wire::ethernet::{EtherType, FrameHeader, Mac, Vlan};
use wire::lldp::{Lldp, Tlv};
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::dcp::{BlockError, BlockInfo, BlockQualifier, Dcp, DcpBlock, DcpValue, Element, ResetMode};
use wire::profinet::rt::{ApduStatus, CyclicFrame, DataStatus, FrameId, FrameKind};

const RESET: &str = "dcp-name-ip-reset.pcap";
const ODD: &str = "odd-station-name.pcap";
const OFFICE: &str = "office-noise-versamax.pcap";

fn capture(file: &str) -> Option<Vec<Vec<u8>>> {
    Some(packets(&shared(&format!("captures/profinet/{file}"))?))
}

fn name(name: &[u8]) -> DcpValue {
    DcpValue::NameOfStation(name.into())
}

fn address(address: [u8; 4]) -> DcpValue {
    let address = Ipv4Addr::from(address);
    DcpValue::IpParameter(IpParameter { address, mask: Ipv4Addr::new(255, 255, 255, 0), gateway: address })
}

fn tell(value: DcpValue) -> DcpBlock {
    DcpBlock::report(BlockInfo::NONE, value)
}

fn identity(kind: &[u8], station: &[u8], device_id: u16, role: u8, instance: u8, ip: DcpBlock) -> Vec<DcpBlock> {
    vec![
        tell(DcpValue::DeviceOptions(vec![Element::DEVICE_INSTANCE])),
        tell(DcpValue::Vendor(kind.into())),
        tell(name(station)),
        tell(DcpValue::DeviceId { vendor_id: 0x002a, device_id }),
        tell(DcpValue::DeviceRole { role, reserved: 0 }),
        tell(DcpValue::DeviceInstance { high: 0, low: instance }),
        ip,
    ]
}

fn get() -> Dcp {
    Dcp::get(0x0301_0001, vec![Element::IP_PARAMETER, Element::DHCP_CLIENT])
}

fn identify(xid: u32) -> Dcp {
    Dcp::identify(xid, 1, vec![DcpValue::AllSelector])
}

fn permanent(xid: u32, value: DcpValue) -> Dcp {
    Dcp::set(xid, vec![DcpBlock::set(BlockQualifier::PERMANENT, value)])
}

const PRIORITY_0: Option<Vlan> = Some(Vlan::priority_tag(0));

#[rstest]
#[case::get(RESET, 1, None, get())]
#[case::get_with_a_block_error(RESET, 2, PRIORITY_0, get().response(vec![
    DcpBlock::report(BlockInfo::IP_SET, address([192, 168, 0, 21])),
    DcpBlock::outcome(Element::DHCP_CLIENT, BlockError::SUBOPTION_NOT_SUPPORTED),
]))]
#[case::identify_a_controller(RESET, 5, PRIORITY_0, identify(0x0301_0003).response(identity(
    b"S7-1500", b"plcxb1.profinet-schnittstellexb15ee1", 0x010e, 2, 100,
    DcpBlock::report(BlockInfo::IP_SET, address([192, 168, 0, 21])),
)))]
#[case::reset(RESET, 7, None, Dcp::reset_to_factory(0x0301_0001, ResetMode::COMMUNICATION))]
#[case::reset_done(RESET, 8, PRIORITY_0, Dcp::set(0x0301_0001, vec![]).response(vec![
    DcpBlock::outcome(Element::RESET_TO_FACTORY, BlockError::OK),
]))]
#[case::empty_name_after_the_reset(RESET, 12, PRIORITY_0, identify(0x0301_0004).response(identity(
    b"ET200SP", b"", 0x0313, 1, 1, DcpBlock::report(BlockInfo::IP_NOT_SET, DcpValue::IpParameter(IpParameter::NONE)),
)))]
#[case::set_the_address(RESET, 17, None, permanent(0x0301_0002, address([192, 168, 0, 10])))]
#[case::set_the_name(RESET, 23, None, permanent(0x0301_0003, name(b"et200sp")))]
#[case::set_an_odd_name_and_end_the_transaction(ODD, 3, PRIORITY_0, Dcp::set(0x0100_0001, vec![
    DcpBlock::set(BlockQualifier::PERMANENT, name(b"%n%n%n ")),
    DcpBlock::set(BlockQualifier::TEMPORARY, DcpValue::Stop),
]))]
fn a_dcp_frame_is_parsed(#[case] file: &str, #[case] number: usize, #[case] tag: Option<Vlan>, #[case] expected: Dcp) {
    let Some(frames) = capture(file) else { return };
    let (header, payload) = FrameHeader::parse(&frames[number - 1]).expect("a frame");
    assert_eq!(header.tag, tag);
    assert_eq!(Dcp::parse(payload), Ok(expected));
}

/// Every frame that the filter counts is parsed without an error and serializes to the same bytes.
#[rstest]
#[case("dcp-name-ip-reset.pcap", 28, 0, 0)]
#[case("duplicate-station-name.pcap", 25, 0, 0)]
#[case("implicit-reads-ns.pcapng", 4, 8, 0)]
#[case("odd-station-name.pcap", 4, 0, 0)]
#[case("office-noise-versamax.pcap", 19, 201, 19)]
#[case("zero-timestamps.pcap", 4, 0, 2)]
fn nothing_is_lost_between_parsing_and_writing(
    #[case] file: &str,
    #[case] dcp: usize,
    #[case] lldp: usize,
    #[case] arp: usize,
) {
    let Some(frames) = capture(file) else { return };
    let mut counts = [0; 3];
    for (frame, number) in frames.iter().zip(1..) {
        let (header, payload) = FrameHeader::parse(frame).expect("a frame");
        assert_eq!(written(|out| header.write(out)), frame[..header.payload_offset()], "{file} {number}");
        let (which, again) = match header.ether_type {
            EtherType::PROFINET if is_dcp(payload) => {
                let dcp = Dcp::parse(payload).unwrap_or_else(|error| panic!("{file} {number}: {error}"));
                let mut again = written(|out| dcp.write(out));
                if !payload[DCP_LENGTH].is_multiple_of(2) {
                    // One device omits the last byte of padding; the writer never does.
                    assert_eq!(again.pop(), Some(0), "{file} {number}");
                    again[DCP_LENGTH] -= 1;
                }
                (0, again)
            }
            EtherType::LLDP => {
                let lldp = Lldp::parse(payload).unwrap_or_else(|error| panic!("{file} {number}: {error}"));
                (1, written(|out| lldp.write(out)))
            }
            EtherType::ARP => {
                let arp = Arp::parse(payload).unwrap_or_else(|error| panic!("{file} {number}: {error}"));
                (2, written(|out| arp.write(out)))
            }
            _ => continue,
        };
        counts[which] += 1;
        assert!(payload.starts_with(&again), "{file} {number}: {again:02x?} instead of {payload:02x?}");
    }
    assert_eq!(counts, [dcp, lldp, arp], "{file}");
}

/// Offset of the low byte of DCPDataLength.
const DCP_LENGTH: usize = 11;

fn is_dcp(payload: &[u8]) -> bool {
    use FrameKind::{DcpGetSet, DcpHello, DcpIdentifyRequest, DcpIdentifyResponse};
    let kind = FrameId::peek(payload).expect("a frame id").kind();
    matches!(kind, DcpHello | DcpGetSet | DcpIdentifyRequest | DcpIdentifyResponse)
}

#[rstest]
#[case::from_the_device(486, 0xc002, 8192, 0x15, &[0; 40])]
#[case::from_the_controller(586, 0xc000, 61152, 0x35, &[0x80, 0, 0, 0x80, 0x80, 0x80, 0, 0, 0, 0, 0x80, 0, 0x80, 0])]
fn a_cyclic_frame_is_parsed(
    #[case] number: usize,
    #[case] frame_id: u16,
    #[case] cycle_counter: u16,
    #[case] data_status: u8,
    #[case] data: &[u8],
) {
    let Some(frames) = capture(OFFICE) else { return };
    let (_, payload) = FrameHeader::parse(&frames[number - 1]).expect("a frame");
    let cyclic = CyclicFrame::parse(payload, 40).expect("a cyclic frame");
    assert_eq!(cyclic.frame_id, FrameId(frame_id));
    let status = ApduStatus { cycle_counter, data_status: DataStatus(data_status), transfer_status: 0 };
    assert_eq!(cyclic.status, status);
    assert_eq!(cyclic.data.len(), 40);
    assert_eq!(cyclic.data[..data.len()], *data);
    assert!(cyclic.data[data.len()..].iter().all(|octet| *octet == 0));
}

#[test]
fn the_number_of_cyclic_frames_is_that_of_tshark() {
    let Some(frames) = capture(OFFICE) else { return };
    let cyclic = |frame: &&Vec<u8>| {
        let (header, payload) = FrameHeader::parse(frame).expect("a frame");
        header.ether_type == EtherType::PROFINET && FrameId::peek(payload).is_ok_and(FrameId::is_cyclic)
    };
    assert_eq!(frames.iter().filter(cyclic).count(), 102);
}

#[test]
fn lldp_of_a_neighbour_is_parsed() {
    let Some(frames) = capture(OFFICE) else { return };
    let (header, payload) = FrameHeader::parse(&frames[37]).expect("a frame");
    assert_eq!(header.destination, Mac::LLDP_MULTICAST);
    let address = testing::hex("05 01 c0a80102 02 00000001 00");
    let tlvs = vec![
        Tlv::ChassisId { subtype: 7, id: b"versamax-pns11".to_vec() },
        Tlv::PortId { subtype: 7, id: b"port-001".to_vec() },
        Tlv::TimeToLive(20),
        Tlv::ManagementAddress(address),
        Tlv::PortStatus { rt_class_2: 0, rt_class_3: 0 },
        Tlv::ChassisMac("00:09:91:43:e0:67".parse().expect("a MAC address")),
        Tlv::MacPhy { autonegotiation: 3, advertised: 0x6c00, mau_type: 16 },
    ];
    assert_eq!(Lldp::parse(payload), Ok(Lldp { tlvs }));
}

#[rstest]
#[case::probe(66, ArpOperation::REQUEST, "00:a0:45:6d:d3:44", [0; 4], "00:00:00:00:00:00", [192, 168, 1, 1])]
#[case::reply(475, ArpOperation::REPLY, "00:09:91:43:e0:67", [192, 168, 1, 2], "00:a0:45:6d:d3:43", [192, 168, 1, 3])]
fn an_arp_packet_is_parsed(
    #[case] number: usize,
    #[case] operation: ArpOperation,
    #[case] sender_mac: &str,
    #[case] sender_ip: [u8; 4],
    #[case] target_mac: &str,
    #[case] target_ip: [u8; 4],
) {
    let Some(frames) = capture(OFFICE) else { return };
    let (_, payload) = FrameHeader::parse(&frames[number - 1]).expect("a frame");
    let arp = Arp::parse(payload).expect("ARP");
    assert_eq!((arp.operation, arp.sender_ip.octets(), arp.target_ip.octets()), (operation, sender_ip, target_ip));
    assert_eq!([arp.sender_mac.to_string(), arp.target_mac.to_string()], [sender_mac, target_mac]);
}

/// The number of datagrams, and of those with a correct, a wrong and no checksum.
#[rstest]
#[case("implicit-reads-ns.pcapng", [8, 8, 0, 0])]
#[case("merged-many-devices.pcapng", [950, 803, 108, 39])]
#[case("office-noise-versamax.pcap", [1043, 1043, 0, 0])]
#[case("record-reads.pcapng", [18, 17, 0, 1])]
fn the_number_of_datagrams_and_checksums_is_that_of_tshark(#[case] file: &str, #[case] expected: [usize; 4]) {
    let Some(frames) = capture(file) else { return };
    let datagrams: Vec<_> = frames.iter().filter_map(|frame| Datagram::parse(frame).ok()).collect();
    let with = |checksum| datagrams.iter().filter(|datagram| datagram.udp_checksum == checksum).count();
    assert!(datagrams.iter().all(|datagram| datagram.ip_checksum == Checksum::Good));
    let counts = [datagrams.len(), with(Checksum::Good), with(Checksum::Bad), with(Checksum::Absent)];
    assert_eq!(counts, expected);
}
