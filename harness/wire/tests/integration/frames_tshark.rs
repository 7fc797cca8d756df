//! Frames that scapy cannot build, written by this crate and dissected by tshark: the fields must have the written values.

use core::net::{Ipv4Addr, SocketAddrV4};
use encspec_wire as wire;
use rstest::rstest;
use std::path::PathBuf;
use std::process::Command;
use wire::datagram::write_udp;
use wire::ethernet::{EtherType, FrameHeader, Mac, Vlan, pad};
use wire::profinet::dcp::block::IpParameter;
use wire::profinet::dcp::{BlockInfo, BlockQualifier, Dcp, DcpBlock, DcpValue, Element, ResetMode};
use wire::profinet::rt::{ApduStatus, CyclicFrame, DataStatus, FrameId, FrameKind};

const CONTROLLER: Mac = Mac([2, 0, 0, 0, 0, 1]);
const DEVICE: Mac = Mac([2, 0, 0, 0, 1, 0]);

/// Writes `frames` to a new capture.
fn capture(test: &str, frames: &[Vec<u8>]) -> PathBuf {
    let mut file = testing::hex("d4c3b2a1 0200 0400 00000000 00000000 ffff0000 01000000");
    for frame in frames {
        let length = u32::try_from(frame.len()).expect("a short frame").to_le_bytes();
        file.extend([0; 8]);
        file.extend(length);
        file.extend(length);
        file.extend(frame);
    }
    let path = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("{test}.pcap"));
    std::fs::write(&path, file).expect("the temporary folder is writable");
    path
}

/// The output of tshark for `frames` with `arguments`, one line each; `None`, with a message, if there is no tshark.
fn tshark(test: &str, frames: &[Vec<u8>], arguments: &[&str]) -> Option<Vec<String>> {
    let path = capture(test, frames);
    let checks = ["-o", "udp.check_checksum:TRUE", "-o", "ip.check_checksum:TRUE", "-r"];
    let output = match Command::new("tshark").args(checks).arg(&path).args(arguments).output() {
        Ok(output) => output,
        Err(error) => {
            testing::skip(&format!("tshark cannot be run: {error}"));
            return None;
        }
    };
    assert!(output.status.success(), "tshark: {}", String::from_utf8_lossy(&output.stderr));
    Some(String::from_utf8_lossy(&output.stdout).lines().map(str::to_owned).collect())
}

/// Asserts that each of `fields` has its value in `frame`, and that tshark has no warnings.
fn assert_fields(test: &str, frame: Vec<u8>, fields: &[(&str, &str)]) {
    let mut arguments = vec!["-T", "fields", "-e", "_ws.malformed", "-e", "_ws.expert.severity"];
    arguments.extend(fields.iter().flat_map(|(field, _)| ["-e", field]));
    let Some(lines) = tshark(test, &[frame], &arguments) else { return };
    let found: Vec<&str> = lines[0].split('\t').collect();
    assert_eq!(found[0], "", "tshark calls the frame malformed");
    let warning = 6_291_456;
    let severe = |severity: &&str| severity.parse::<u32>().is_ok_and(|severity| severity >= warning);
    assert_eq!(found[1].split(',').find(severe), None, "tshark warns");
    let expected: Vec<&str> = fields.iter().map(|(_, value)| *value).collect();
    assert_eq!(found[2..], expected, "{fields:?}");
}

fn dcp_frame(destination: Mac, source: Mac, dcp: &Dcp) -> Vec<u8> {
    crate::round_trip::written(|out| dcp.write_frame(destination, source, out))
}

#[test]
fn hello_has_name_address_and_device() {
    let address = Ipv4Addr::new(192, 168, 0, 10);
    let ip = IpParameter { address, mask: Ipv4Addr::new(255, 255, 255, 0), gateway: address };
    let hello = Dcp::hello(
        0x1234_5678,
        vec![
            DcpBlock::report(BlockInfo::NONE, DcpValue::NameOfStation(b"enc-1".to_vec())),
            DcpBlock::report(BlockInfo::IP_SET, DcpValue::IpParameter(ip)),
            DcpBlock::report(BlockInfo::NONE, DcpValue::DeviceId { vendor_id: 0x0106, device_id: 0x0303 }),
            DcpBlock::report(BlockInfo::NONE, DcpValue::DeviceInitiative(1)),
        ],
    );
    let fields = [
        ("eth.dst", "01:0e:cf:00:00:01"),
        ("pn_rt.frame_id", "65276"),
        ("pn_dcp.service_id", "6"),
        ("pn_dcp.service_type", "0"),
        ("pn_dcp.xid", "0x12345678"),
        ("pn_dcp.option", "2,1,2,6"),
        ("pn_dcp.block_length", "7,14,6,4"),
        ("pn_dcp.suboption_device_nameofstation", "enc-1"),
        ("pn_dcp.suboption_ip_block_info", "1"),
        ("pn_dcp.suboption_ip_ip", "192.168.0.10"),
        ("pn_dcp.suboption_ip_subnetmask", "255.255.255.0"),
        ("pn_dcp.suboption_ip_standard_gateway", "192.168.0.10"),
        ("pn_dcp.suboption_vendor_id", "0x0106"),
        ("pn_dcp.suboption_device_id", "0x0303"),
        ("pn_dcp.deviceinitiative_value", "1"),
    ];
    assert_fields("hello", dcp_frame(Mac::DCP_HELLO_MULTICAST, DEVICE, &hello), &fields);
}

#[test]
fn a_transaction_encloses_its_blocks() {
    let name = DcpValue::NameOfStation(b"enc-1".to_vec());
    let set = Dcp::set(
        7,
        vec![
            DcpBlock::set(BlockQualifier::TEMPORARY, DcpValue::Start),
            DcpBlock::set(BlockQualifier::PERMANENT, name),
            DcpBlock::set(BlockQualifier::TEMPORARY, DcpValue::Stop),
        ],
    );
    let fields = [
        ("pn_dcp.option", "5,2,5"),
        ("pn_dcp.suboption_control", "1,2"),
        ("pn_dcp.suboption_device", "2"),
        ("pn_dcp.block_length", "2,7,2"),
        ("pn_dcp.block_qualifier", "0,1,0"),
        ("pn_dcp.suboption_device_nameofstation", "enc-1"),
    ];
    assert_fields("transaction", dcp_frame(DEVICE, CONTROLLER, &set), &fields);
}

#[test]
fn get_requests_several_elements() {
    let get = Dcp::get(7, vec![Element::IP_PARAMETER, Element::NAME_OF_STATION, Element::DHCP_CLIENT]);
    let fields = [
        ("pn_dcp.data_length", "6"),
        ("pn_dcp.option", "1,2,3"),
        ("pn_dcp.suboption_ip", "2"),
        ("pn_dcp.suboption_device", "2"),
        ("pn_dcp.suboption_dhcp", "61"),
    ];
    assert_fields("get", dcp_frame(DEVICE, CONTROLLER, &get), &fields);
}

#[rstest]
#[case("application", ResetMode::APPLICATION, "Reset application data")]
#[case("communication", ResetMode::COMMUNICATION, "Reset communication parameter")]
#[case("engineering", ResetMode::ENGINEERING, "Reset engineering parameter")]
#[case("all", ResetMode::ALL, "Resets all stored data")]
#[case("device", ResetMode::DEVICE, "Resets all stored data in the IOD or IOC to its factory values")]
#[case("factory_image", ResetMode::FACTORY_IMAGE, "Reset and restore data")]
fn a_reset_has_its_mode(#[case] word: &str, #[case] mode: ResetMode, #[case] text: &str) {
    assert_eq!(mode.word(), Some(word));
    let test = format!("reset-{word}");
    let frame = dcp_frame(DEVICE, CONTROLLER, &Dcp::reset_to_factory(1, mode));
    let Some(lines) = tshark(&test, &[frame], &["-V"]) else { return };
    let line = lines.iter().find(|line| line.contains("BlockQualifier: ResettoFactory")).expect("a qualifier");
    assert!(line.contains(text), "tshark prints: {line}");
}

#[rstest]
#[case("untagged", None, 0xc001, 0x35, ["", "0x01", "0x01", "0x01", "0x01", "0x00"])]
#[case("tagged", Some(Vlan::RT), 0x8000, 0x15, ["6", "0x01", "0x01", "0x01", "0x00", "0x00"])]
#[case("low", Some(Vlan::LOW_ALARM), 0x8000, 0xb0, ["5", "0x00", "0x00", "0x01", "0x01", "0x01"])]
fn the_bits_of_a_cyclic_frame_match_their_names(
    #[case] test: &str,
    #[case] tag: Option<Vlan>,
    #[case] frame_id: u16,
    #[case] data_status: u8,
    #[case] bits: [&str; 6],
) {
    let [priority, primary, valid, run, no_problem, ignore] = bits;
    let status = DataStatus(data_status);
    let named = [
        status.has(DataStatus::PRIMARY),
        status.is_valid(),
        status.is_run(),
        !status.has_problem(),
        status.has(DataStatus::IGNORE),
    ];
    assert_eq!(named.map(|bit| if bit { "0x01" } else { "0x00" }), [primary, valid, run, no_problem, ignore]);
    let frame = crate::round_trip::written(|out| {
        let header = FrameHeader::new(DEVICE, CONTROLLER, EtherType::PROFINET);
        tag.map_or(header, |tag| header.tagged(tag)).write(out);
        let status = ApduStatus { cycle_counter: 0x1240, data_status: status, transfer_status: 0 };
        CyclicFrame { frame_id: FrameId(frame_id), data: &[0x5a; 60], status, padding: &[] }.write(out);
    });
    let frame_id = frame_id.to_string();
    let fields = [
        ("vlan.priority", priority),
        ("pn_rt.frame_id", &frame_id),
        ("pn_rt.cycle_counter", "4672"),
        ("pn_rt.ds_primary", primary),
        ("pn_rt.ds_valid", valid),
        ("pn_rt.ds_operate", run),
        ("pn_rt.ds_ok", no_problem),
        ("pn_rt.ds_ignore", ignore),
        ("frame.len", if priority.is_empty() { "80" } else { "84" }),
    ];
    assert_fields(&format!("cyclic-{test}"), frame, &fields);
}

#[test]
fn both_checksums_of_a_datagram_are_correct() {
    let source = (CONTROLLER, SocketAddrV4::new(Ipv4Addr::new(10, 255, 0, 1), 65535));
    let destination = (DEVICE, SocketAddrV4::new(Ipv4Addr::new(10, 0, 255, 254), 34965));
    let frame = crate::round_trip::written(|out| write_udp(source, destination, &[0xff; 1471], out).expect("it fits"));
    let fields = [
        ("ip.checksum.status", "1"),
        ("udp.checksum.status", "1"),
        ("ip.src", "10.255.0.1"),
        ("ip.dst", "10.0.255.254"),
        ("udp.srcport", "65535"),
        ("udp.dstport", "34965"),
        ("udp.length", "1479"),
        ("ip.flags.df", "1"),
        ("ip.ttl", "64"),
    ];
    assert_fields("udp", frame, &fields);
}

/// The start of the line that tshark 4.0 prints for a frame ID.
fn words_of_tshark(kind: FrameKind) -> &'static str {
    match kind {
        FrameKind::Ptcp => "Sync|PTCP|Delay",
        FrameKind::RtClass3 => "(class=3)",
        FrameKind::RtClass2 => "0x8000-0xBBFF|0xBC00-0xBFFF",
        FrameKind::RtClass1 => "0xC000-0xF7FF|0xF800-0xFBFF",
        FrameKind::AlarmHigh => "Alarm high",
        FrameKind::AlarmLow => "Alarm low",
        FrameKind::Rsi => "RSI",
        FrameKind::DcpHello => ") hello",
        FrameKind::DcpGetSet => ") get/set",
        FrameKind::DcpIdentifyRequest => "identify multicast request",
        FrameKind::DcpIdentifyResponse => "identify response",
        FrameKind::Fragment => "Fragmentation",
        FrameKind::Reserved => "eserved",
    }
}

/// All frame IDs compared with tshark, which counts the gap before the delay frames as delay frames.
#[test]
fn the_kind_of_each_frame_id_is_that_of_tshark() {
    let frame = |id: u16| {
        let mut frame = Vec::new();
        FrameHeader::new(DEVICE, CONTROLLER, EtherType::PROFINET).write(&mut frame);
        frame.extend(id.to_be_bytes());
        pad(&mut frame, 0);
        frame
    };
    let frames: Vec<_> = (0..=u16::MAX).map(frame).collect();
    let Some(lines) = tshark("frame-ids", &frames, &["-O", "pn_rt"]) else { return };
    let printed: Vec<_> = lines.iter().filter(|line| line.contains("    FrameID: ")).collect();
    assert_eq!(printed.len(), frames.len());
    for (id, line) in (0..=u16::MAX).zip(printed).filter(|(id, _)| !(0xff22..=0xff3f).contains(id)) {
        let kind = FrameId(id).kind();
        let agrees = words_of_tshark(kind).split('|').any(|word| line.contains(word));
        assert!(agrees, "{id:#06x}: {kind:?}, tshark prints {line}");
        let cyclic = matches!(kind, FrameKind::RtClass1 | FrameKind::RtClass2 | FrameKind::RtClass3);
        assert_eq!(FrameId(id).is_cyclic(), cyclic, "{id:#06x}");
    }
}
