//! DCP, ARP, ICMP and LLDP: discovery, name, addresses and resets.

use super::bench::*;
use super::connection::abort;
use crate::profinet::StationData;
use alloc::vec::Vec;
use core::net::Ipv4Addr;
use rstest::rstest;
use station::Duration;
use wire::ethernet::{EtherType, FrameHeader, Mac};
use wire::lldp::{Lldp, Tlv};
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::dcp::{
    BlockError, BlockInfo, BlockQualifier, Dcp, DcpBlock, DcpValue, Element, ResetMode, ServiceType,
};
use wire::profinet::status::AbortReason;

fn name(name: &str) -> DcpValue {
    DcpValue::NameOfStation(name.into())
}

fn address(address: [u8; 4], mask: [u8; 4], gateway: [u8; 4]) -> DcpValue {
    let [address, mask, gateway] = [address, mask, gateway].map(Ipv4Addr::from);
    DcpValue::IpParameter(IpParameter { address, mask, gateway })
}

const MASK: [u8; 4] = [255, 255, 255, 0];

#[rstest]
#[case::all(DcpValue::AllSelector, true)]
#[case::name(name("toy"), true)]
#[case::another_name(name("toy2"), false)]
#[case::part_of_the_name(name("to"), false)]
#[case::device(DcpValue::DeviceId { vendor_id: 0x0239, device_id: 1 }, true)]
#[case::another_device(DcpValue::DeviceId { vendor_id: 0x0239, device_id: 2 }, false)]
#[case::type_of_station(DcpValue::Vendor(b"TOY".to_vec()), true)]
#[case::role(DcpValue::DeviceRole { role: 1, reserved: 0 }, true)]
#[case::controllers(DcpValue::DeviceRole { role: 2, reserved: 0 }, false)]
#[case::address(address([192, 168, 0, 10], MASK, [0; 4]), true)]
#[case::another_address(address([192, 168, 0, 11], MASK, [0; 4]), false)]
#[case::alias(DcpValue::AliasName(b"port-003.switch".to_vec()), true)]
#[case::another_alias(DcpValue::AliasName(b"port-004.switch".to_vec()), false)]
#[case::unknown(DcpValue::OemDeviceId { vendor_id: 0x0239, device_id: 1 }, false)]
fn identify_finds_what_matches(#[case] filter: DcpValue, #[case] is_found: bool) {
    let mut bench = StackBench::new();
    let neighbour = Lldp {
        tlvs: [
            Tlv::ChassisId { subtype: 7, id: b"switch".to_vec() },
            Tlv::PortId { subtype: 7, id: b"port-003".to_vec() },
            Tlv::TimeToLive(20),
        ]
        .into(),
    };
    let mut frame = Vec::new();
    neighbour.write_frame(CONTROLLER, &mut frame);
    bench.send(&frame);
    let answers = bench.dcp(&Dcp::identify(7, 1, [filter].into()), Mac::DCP_MULTICAST);
    assert_eq!(answers.len(), usize::from(is_found));
}

#[test]
fn all_filters_must_match() {
    let mut bench = StackBench::new();
    let device = DcpValue::DeviceId { vendor_id: 0x0239, device_id: 1 };
    let both = Dcp::identify(7, 1, [name("toy"), device.clone()].into());
    assert_eq!(bench.dcp(&both, Mac::DCP_MULTICAST).len(), 1);
    let one = Dcp::identify(8, 1, [name("other"), device].into());
    assert_eq!(bench.dcp(&one, Mac::DCP_MULTICAST).len(), 0);
}

#[test]
fn the_answer_to_identify_contains_the_identification() {
    let mut bench = StackBench::new();
    let answers = bench.dcp(&Dcp::identify(7, 1, [DcpValue::AllSelector].into()), Mac::DCP_MULTICAST);
    let blocks = answers[0].blocks();
    for value in
        [name("toy"), DcpValue::DeviceId { vendor_id: 0x0239, device_id: 1 }, DcpValue::Vendor(b"TOY".to_vec())]
    {
        assert!(blocks.contains(&DcpBlock::report(BlockInfo::NONE, value)));
    }
    assert!(blocks.contains(&DcpBlock::report(BlockInfo::IP_SET, address([192, 168, 0, 10], MASK, [0; 4]))));
    bench.dcp(&Dcp::get(4, [Element::DEVICE_OPTIONS, Element::ALIAS_NAME, Element::DHCP_CLASS].into()), DEVICE);
    bench.dcp(&Dcp::set(5, [DcpBlock::set(BlockQualifier::PERMANENT, name("odd"))].into()), DEVICE);
    bench.dcp(&Dcp::signal(6), DEVICE);
    bench.dcp(&Dcp::reset_to_factory(7, ResetMode::COMMUNICATION), DEVICE);
    bench.run(Duration::from_secs(6));
    bench.check_with_tshark();
}

#[test]
fn the_answer_to_identify_is_delayed_by_the_mac_address() {
    let mut bench = StackBench::new();
    bench.run(Duration::ZERO);
    bench.take();
    let request = Dcp::identify(7, 0x0103, [DcpValue::AllSelector].into());
    let mut frame = Vec::new();
    request.write_frame(Mac::DCP_MULTICAST, CONTROLLER, &mut frame);
    bench.send(&frame);
    // The address ends in 01 00. Modulo 0x103 this is 256 steps of 10 ms.
    bench.run(Duration::from_millis(2_559));
    assert!(bench.take().is_empty());
    bench.run(Duration::from_millis(1));
    assert_eq!(bench.take().len(), 1);
}

#[test]
fn get_reports_values_and_unknown_elements() {
    let mut bench = StackBench::new();
    let unknown = Element { option: 2, suboption: 99 };
    let request = Dcp::get(3, [Element::NAME_OF_STATION, unknown, Element::DHCP_CLASS, Element::MAC].into());
    let answers = bench.dcp(&request, DEVICE);
    assert_eq!(
        answers[0].blocks(),
        [
            DcpBlock::report(BlockInfo::NONE, name("toy")),
            DcpBlock::outcome(unknown, BlockError::SUBOPTION_NOT_SUPPORTED),
            DcpBlock::outcome(Element::DHCP_CLASS, BlockError::OPTION_NOT_SUPPORTED),
            DcpBlock::report(BlockInfo::NONE, DcpValue::Mac(DEVICE)),
        ]
    );
}

#[test]
fn an_unknown_service_is_not_supported() {
    let mut bench = StackBench::new();
    let mut request = Dcp::get(3, Vec::new());
    request.service_id = wire::profinet::dcp::ServiceId(9);
    assert_eq!(bench.dcp(&request, DEVICE)[0].service_type, ServiceType::NOT_SUPPORTED);
}

#[rstest]
#[case::name(name("new"), BlockError::OK)]
#[case::blank_name(name(""), BlockError::OK)]
#[case::bad_name(name("New"), BlockError::SUBOPTION_NOT_SET)]
#[case::address(address([10, 0, 0, 7], [255, 0, 0, 0], [10, 1, 1, 1]), BlockError::OK)]
#[case::no_address(address([0; 4], [0; 4], [0; 4]), BlockError::OK)]
#[case::mask_with_a_gap(address([10, 0, 0, 7], [255, 0, 255, 0], [0; 4]), BlockError::SUBOPTION_NOT_SET)]
#[case::multicast(address([224, 0, 0, 7], [255, 0, 0, 0], [0; 4]), BlockError::SUBOPTION_NOT_SET)]
#[case::loopback(address([127, 0, 0, 1], [255, 0, 0, 0], [0; 4]), BlockError::SUBOPTION_NOT_SET)]
#[case::network(address([10, 0, 0, 0], [255, 0, 0, 0], [0; 4]), BlockError::SUBOPTION_NOT_SET)]
#[case::broadcast(address([10, 255, 255, 255], [255, 0, 0, 0], [0; 4]), BlockError::SUBOPTION_NOT_SET)]
#[case::gateway_elsewhere(address([10, 0, 0, 7], [255, 0, 0, 0], [11, 0, 0, 1]), BlockError::SUBOPTION_NOT_SET)]
#[case::signal(DcpValue::Signal(0x0100), BlockError::OK)]
#[case::unknown_signal(DcpValue::Signal(0x0200), BlockError::SUBOPTION_NOT_SET)]
#[case::factory_reset(DcpValue::FactoryReset, BlockError::OK)]
#[case::read_only(DcpValue::Mac(CONTROLLER), BlockError::SUBOPTION_NOT_SUPPORTED)]
#[case::dhcp(DcpValue::Dhcp { option: 12, octets: Vec::new() }, BlockError::OPTION_NOT_SUPPORTED)]
#[case::half_an_address(DcpValue::Raw { element: Element::IP_PARAMETER, octets: [1, 2].into() }, BlockError::SUBOPTION_NOT_SET)]
fn set_is_answered(#[case] value: DcpValue, #[case] error: BlockError) {
    let mut bench = StackBench::new();
    let element = value.element();
    let answers = bench.dcp(&Dcp::set(3, [DcpBlock::set(BlockQualifier::PERMANENT, value)].into()), DEVICE);
    assert_eq!(answers[0].blocks(), [DcpBlock::outcome(element, error)]);
}

#[rstest]
#[case::permanent(BlockQualifier::PERMANENT, b"new".as_slice())]
#[case::temporary(BlockQualifier::TEMPORARY, b"")]
fn a_temporary_name_is_lost_at_the_next_start(#[case] qualifier: BlockQualifier, #[case] afterwards: &[u8]) {
    let mut bench = StackBench::new();
    bench.dcp(&Dcp::set(3, [DcpBlock::set(qualifier, name("new"))].into()), DEVICE);
    let get_name = |bench: &mut StackBench| {
        bench.dcp(&Dcp::get(4, [Element::NAME_OF_STATION].into()), DEVICE)[0].blocks().to_vec()
    };
    assert_eq!(get_name(&mut bench), [DcpBlock::report(BlockInfo::NONE, name("new"))]);
    assert_eq!(bench.device.application().stored.name, afterwards);
    assert_eq!(bench.device.application().stored.ip, [192, 168, 0, 10], "other elements keep their values");
    bench.device.power(bench.now, false);
    bench.device.power(bench.now, true);
    bench.run(Duration::from_secs(2));
    assert_eq!(get_name(&mut bench), [DcpBlock::report(BlockInfo::NONE, DcpValue::NameOfStation(afterwards.to_vec()))]);
}

#[test]
fn a_transaction_takes_effect_at_its_end() {
    let mut bench = StackBench::new();
    let set = |value| Dcp::set(3, [DcpBlock::set(BlockQualifier::PERMANENT, value)].into());
    bench.dcp(&set(DcpValue::Start), DEVICE);
    bench.dcp(&set(name("new")), DEVICE);
    assert_eq!(bench.device.application().stored.name, b"toy");
    bench.dcp(&set(DcpValue::Stop), DEVICE);
    assert_eq!(bench.device.application().stored.name, b"new");
    let answers = bench.dcp(&set(DcpValue::Stop), DEVICE);
    assert_eq!(answers[0].blocks(), [DcpBlock::outcome(Element::STOP, BlockError::SUBOPTION_NOT_SET)]);
    bench.dcp(&set(DcpValue::Start), DEVICE);
    bench.dcp(&set(name("late")), DEVICE);
    bench.run(Duration::from_secs(3));
    bench.dcp(&set(DcpValue::Stop), DEVICE);
    assert_eq!(bench.device.application().stored.name, b"new", "a transaction without Stop times out");
}

#[rstest]
#[case::name(name("new"), Some(AbortReason::STATION_NAME_CHANGED))]
#[case::same_name(name("toy"), None)]
#[case::address(address([192, 168, 0, 11], MASK, [0; 4]), Some(AbortReason::IP_SUITE_CHANGED))]
#[case::same_address(address([192, 168, 0, 10], MASK, [0; 4]), None)]
#[case::reset(DcpValue::FactoryReset, Some(AbortReason::RESET_TO_FACTORY))]
fn changes_end_a_connection(#[case] value: DcpValue, #[case] reason: Option<AbortReason>) {
    let mut bench = StackBench::new();
    bench.start();
    let mut frame = Vec::new();
    Dcp::set(3, [DcpBlock::set(BlockQualifier::PERMANENT, value)].into()).write_frame(DEVICE, CONTROLLER, &mut frame);
    bench.send(&frame);
    assert_eq!(abort(&bench.take()), reason);
}

#[rstest]
#[case::communication(ResetMode::COMMUNICATION, BlockError::OK)]
#[case::not_of_this_device(ResetMode::ENGINEERING, BlockError::SUBOPTION_NOT_SET)]
#[case::not_of_any_device(ResetMode(0), BlockError::SUBOPTION_NOT_SET)]
fn a_reset_clears_the_data_of_its_mode(#[case] mode: ResetMode, #[case] error: BlockError) {
    let mut bench = StackBench::new();
    let answers = bench.dcp(&Dcp::reset_to_factory(3, mode), DEVICE);
    assert_eq!(answers[0].blocks(), [DcpBlock::outcome(Element::RESET_TO_FACTORY, error)]);
    let is_blank = bench.device.application().stored == StationData::default();
    assert_eq!(is_blank, error == BlockError::OK);
    let answers = bench.dcp(&Dcp::get(4, [Element::NAME_OF_STATION].into()), DEVICE);
    let left = if is_blank { "" } else { "toy" };
    assert_eq!(answers[0].blocks(), [DcpBlock::report(BlockInfo::NONE, name(left))]);
}

#[test]
fn the_led_flashes_for_three_seconds() {
    let mut bench = StackBench::new();
    assert!(!bench.device.is_signalling(bench.now));
    bench.dcp(&Dcp::signal(3), DEVICE);
    bench.run(Duration::from_millis(2_979));
    assert!(bench.device.is_signalling(bench.now));
    bench.run(Duration::from_millis(1));
    assert!(!bench.device.is_signalling(bench.now));
}

#[test]
fn arp_and_ping_are_answered() {
    // An ICMP echo request of 8 bytes of data from 192.168.0.1, as ping sends it.
    let packet = [
        0x45, 0x00, 0x00, 0x24, 0x12, 0x34, 0x40, 0x00, 0x40, 0x01, 0xa7, 0x49, 192, 168, 0, 1, 192, 168, 0, 10, 0x08,
        0x00, 0xb3, 0x97, 0x00, 0x01, 0x00, 0x01, 1, 2, 3, 4, 0x10, 0x20, 0x30, 0x40,
    ];
    let mut bench = StackBench::new();
    bench.run(Duration::ZERO);
    bench.take();
    let mut frame = Vec::new();
    wire::datagram::arp::Arp::request(CONTROLLER, CONTROLLER_IP, DEVICE_IP).write_frame(&mut frame);
    bench.send(&frame);
    let answer = bench.take().remove(0);
    let (header, payload) = FrameHeader::parse(&answer).unwrap();
    assert_eq!((header.destination, header.ether_type), (CONTROLLER, EtherType::ARP));
    assert_eq!(wire::datagram::arp::Arp::parse(payload).unwrap().sender_mac, DEVICE);
    let mut frame = Vec::new();
    FrameHeader::new(DEVICE, CONTROLLER, EtherType::IPV4).write(&mut frame);
    frame.extend(packet);
    bench.send(&frame);
    let answers = bench.take();
    let (_, payload) = FrameHeader::parse(&answers[0]).unwrap();
    assert_eq!((payload[9], payload[20]), (1, 0), "an echo reply");
    assert_eq!(payload[24..36], packet[24..36]);
}

#[test]
fn lldp_is_sent_every_five_seconds() {
    let mut bench = StackBench::new();
    bench.run(Duration::from_secs(11));
    let frames = bench.take();
    let announced: Vec<Lldp> = frames
        .iter()
        .filter_map(|frame| {
            let (header, payload) = FrameHeader::parse(frame).unwrap();
            (header.ether_type == EtherType::LLDP).then(|| Lldp::parse(payload).unwrap())
        })
        .collect();
    assert_eq!(announced.len(), 3);
    assert_eq!(
        announced[0].tlvs[..3],
        [
            Tlv::ChassisId { subtype: 7, id: b"toy".to_vec() },
            Tlv::PortId { subtype: 7, id: b"port-001.toy".to_vec() },
            Tlv::TimeToLive(20)
        ]
    );
}

#[test]
fn a_reflected_frame_is_not_answered() {
    let mut bench = StackBench::new();
    bench.run(Duration::ZERO);
    for frame in bench.take() {
        bench.send(&frame);
    }
    let mut frame = Vec::new();
    Dcp::identify(7, 1, [DcpValue::AllSelector].into()).write_frame(Mac::DCP_MULTICAST, DEVICE, &mut frame);
    bench.send(&frame);
    bench.run(Duration::from_millis(100));
    assert!(bench.take().is_empty());
}
