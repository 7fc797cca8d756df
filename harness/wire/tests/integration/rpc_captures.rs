//! RPC PDUs of real controllers and devices: each is parsed and written again, and compared with tshark and Zeek.

use crate::round_trip::written;
use crate::rpc_reading::{self, RpcBlocks, RpcBody};
use encspec_wire as wire;
use rstest::rstest;
use testing::{packets, shared};
use wire::datagram::Datagram;
use wire::octets::ByteOrder;
use wire::profinet::blocks::BlockType;
use wire::profinet::rpc::{Assembled, Flags1, Opnum, PacketType, Reassembler, RpcPdu, Uuid, fragments};
use wire::profinet::status::PnioStatus;

/// The UDP payloads of a capture that call a PROFINET interface, with their packet numbers; `None` if the captures are absent.
fn payloads(file: &str) -> Option<Vec<(usize, Vec<u8>)>> {
    /// The end of the UUID of all PROFINET interfaces, which does not depend on the byte order.
    const INTERFACE: [u8; 8] = [0x82, 0x71, 0x00, 0xA0, 0x24, 0x42, 0xDF, 0x7D];
    let frames = packets(&shared(&format!("captures/profinet/{file}"))?);
    let mut payloads = Vec::new();
    for (at, frame) in frames.iter().enumerate() {
        if let Ok(datagram) = Datagram::parse(frame)
            && datagram.payload.get(32..40) == Some(&INTERFACE)
        {
            payloads.push((at + 1, datagram.payload.to_vec()));
        }
    }
    Some(payloads)
}

// The counts are those of `tshark -r FILE -Y dcerpc | wc -l`.
#[rstest]
#[case::office("office-noise-versamax.pcap", 38)]
#[case::many("merged-many-devices.pcapng", 950)]
#[case::one_ar("one-ar-life.pcapng", 10)]
#[case::reads("record-reads.pcapng", 18)]
#[case::implicit("implicit-reads-ns.pcapng", 8)]
#[case::zero_timestamps("zero-timestamps.pcap", 1)]
fn every_pdu_is_parsed_and_written_again(#[case] file: &str, #[case] count: usize) {
    let Some(payloads) = payloads(file) else { return };
    assert_eq!(payloads.len(), count);
    let mut reassembler = Reassembler::new(4, 1 << 16);
    for (number, octets) in payloads {
        let pdu = RpcPdu::parse(&octets).unwrap_or_else(|error| panic!("packet {number}: {error}"));
        assert_eq!(rpc_reading::hex(&pdu.to_vec()), rpc_reading::hex(&octets), "packet {number}");
        let Assembled::Whole(body) = reassembler.take(&pdu) else { continue };
        let whole = RpcPdu { body: &body, ..pdu };
        let read = rpc_reading::body(&whole).unwrap_or_else(|error| panic!("packet {number}: {error}"));
        let again = written(|out| rpc_reading::write(&read, out, pdu.header.order()));
        assert_eq!(rpc_reading::hex(&again), rpc_reading::hex(&body), "packet {number}: {read:#?}");
    }
}

#[test]
fn parsed_like_tshark() {
    let text = include_str!("../golden/tshark-rpc-captures.txt");
    let mut compared = 0;
    let mut last = (String::new(), Vec::new());
    for line in text.lines().filter(|line| !line.starts_with('#')) {
        let (packet, fields) = line.split_once(' ').expect("packet and fields");
        let (file, number) = packet.split_once(':').expect("file and packet number");
        if last.0 != file {
            let Some(payloads) = payloads(file) else { return };
            last = (file.to_owned(), payloads);
        }
        let number: usize = number.parse().expect("a packet number");
        let found = last.1.iter().find(|(at, _)| *at == number).unwrap_or_else(|| panic!("{packet} is not RPC"));
        let parsed = rpc_reading::fields(&RpcPdu::parse(&found.1).expect(packet));
        compared += rpc_reading::assert_same(packet, &parsed, &rpc_reading::tshark(fields));
    }
    assert!(compared > 2000, "only {compared} values");
}

/// One line of the log: type, flags, byte order, the UUIDs as in the PDU, and the numbers of the header.
fn as_zeek_logs(pdu: &RpcPdu) -> Vec<String> {
    let header = &pdu.header;
    let little = header.order() == ByteOrder::Little;
    let kind = header.packet_type.word().expect("a known type");
    let flag = |set: bool| if set { "T" } else { "F" }.to_owned();
    let uuid = |uuid: Uuid| {
        let mut octets = Vec::new();
        uuid.write(&mut octets, header.order());
        Uuid(octets.try_into().expect("16 bytes")).to_string().to_uppercase()
    };
    let operation = match header.opnum {
        Opnum::READ_IMPLICIT => "Read Implicit".to_owned(),
        opnum => capital(opnum.word().expect("a known operation")),
    };
    let mut columns = vec![capital(kind)];
    columns.extend((0..8).map(|bit| flag(header.flags1.has(Flags1(1 << bit)))));
    columns.push(flag(header.flags2.0 & 2 != 0));
    columns.push(if little { "Little Endian" } else { "Big Endian" }.to_owned());
    columns.extend(["ASCII".to_owned(), "IEEE".to_owned(), (header.serial >> 8).to_string()]);
    columns.extend([uuid(header.object), uuid(header.interface), uuid(header.activity)]);
    columns.extend(
        [header.server_boot, header.interface_version >> 16, header.interface_version & 0xFFFF].map(|n| n.to_string()),
    );
    columns.extend([header.sequence.to_string(), operation]);
    let words = [header.interface_hint, header.activity_hint, header.body_length, header.fragment];
    columns.extend(words.map(|word| word.to_string()));
    columns.extend([header.auth_protocol.to_string(), (header.serial & 0xFF).to_string()]);
    columns
}

fn capital(word: &str) -> String {
    let (first, rest) = word.split_at(1);
    first.to_uppercase() + rest
}

#[rstest]
#[case::office("office-noise-versamax")]
#[case::one_ar("one-ar-life")]
#[case::reads("record-reads")]
fn parsed_like_zeek(#[case] name: &str) {
    let log = shared(&format!("captures/profinet/{name}.rpc-pdus.log"));
    let extension = if name == "office-noise-versamax" { "pcap" } else { "pcapng" };
    let (Some(log), Some(payloads)) = (log, payloads(&format!("{name}.{extension}"))) else { return };
    let log = std::fs::read_to_string(log).expect("the log");
    let mut zeek: Vec<Vec<String>> = log
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| line.split('\t').skip(10).take(28).map(str::to_owned).collect())
        .collect();
    let mut parsed: Vec<_> =
        payloads.iter().map(|(_, octets)| as_zeek_logs(&RpcPdu::parse(octets).expect("a PDU"))).collect();
    // The log is ordered by time, the packets are not.
    zeek.sort();
    parsed.sort();
    assert_eq!(parsed, zeek);
}

#[test]
fn a_fragmented_write_is_reassembled_and_fragmented_again() {
    let Some(payloads) = payloads("merged-many-devices.pcapng") else { return };
    let packet = |number: usize| &payloads.iter().find(|(at, _)| *at == number).expect("an RPC packet").1;
    let (first, last) = (RpcPdu::parse(packet(57)).expect("packet 57"), RpcPdu::parse(packet(60)).expect("packet 60"));
    let mut reassembler = Reassembler::new(1, 1 << 16);
    assert_eq!(reassembler.take(&last), Assembled::Waiting { given_up: None });
    assert_eq!(reassembler.take(&last), Assembled::Repeated);
    let (fragment, fack) = reassembler.fack(&last.header).expect("an incomplete body");
    assert_eq!((fragment, fack.selective), (0xFFFF, vec![0b10]));
    let Assembled::Whole(body) = reassembler.take(&first) else { panic!("fragment 0 completes the body") };
    assert_eq!(body.len(), 1384 + 48);
    let again = fragments(&first.header, &body, 1384);
    assert_eq!(rpc_reading::hex(&again[0]), rpc_reading::hex(packet(57)));
    assert_eq!(rpc_reading::hex(&again[1]), rpc_reading::hex(packet(60)));
}

#[test]
fn eighty_three_connects_are_refused_without_ar_resources() {
    let Some(payloads) = payloads("merged-many-devices.pcapng") else { return };
    let refused = payloads.iter().filter(|(_, octets)| {
        let pdu = RpcPdu::parse(octets).expect("a PDU");
        let is_answer = pdu.header.packet_type == PacketType::RESPONSE && pdu.header.opnum == Opnum::CONNECT;
        is_answer && status(&pdu).is_some_and(|status| status.word() == Some("out_of_ar_resources"))
    });
    assert_eq!(refused.count(), 83);
}

fn status(pdu: &RpcPdu) -> Option<PnioStatus> {
    match rpc_reading::body(pdu) {
        Ok(RpcBody::Response(ndr, _)) => Some(ndr.status),
        _ => None,
    }
}

#[test]
fn the_module_diff_of_a_connect_and_of_an_application_ready_is_found() {
    let Some(payloads) = payloads("office-noise-versamax.pcap") else { return };
    let mut found = (0, 0);
    for (_, octets) in &payloads {
        match rpc_reading::body(&RpcPdu::parse(octets).expect("a PDU")).expect("a body") {
            RpcBody::Response(_, RpcBlocks::Connect(connect)) => {
                found.0 += usize::from(connect.block(BlockType::MODULE_DIFF).is_some())
            }
            RpcBody::Request(_, RpcBlocks::Control(control)) => {
                found.1 += usize::from(control.block(BlockType::MODULE_DIFF).is_some())
            }
            _ => {}
        }
    }
    assert_eq!(found, (2, 1));
}
