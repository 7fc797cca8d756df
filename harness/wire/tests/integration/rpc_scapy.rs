//! RPC PDUs against scapy and tshark, see golden/rpc.py: the parsers against tshark's dissection of scapy's bytes, the writers
//! against the bytes, and whole PDUs built with the types of this crate against those of scapy.

use crate::round_trip::written;
use crate::rpc_reading::{self, RpcBlocks, RpcBody};
use encspec_wire as wire;
use rstest::rstest;
use wire::ethernet::Mac;
use wire::octets::ByteOrder;
use wire::profinet::blocks::connect::{
    AlarmCrBlockReq, ArBlockReq, ArProperties, ArRpcBlock, ArServerBlockRes, ArType, Connect, ConnectContent,
    DataDescription, ExpectedModule, ExpectedSubmodule, ExpectedSubmoduleBlockReq, FrameObject, IocrApi, IocrBlockReq,
    IocrType, PrmServerBlockReq, RtClass, SubmoduleType,
};
use wire::profinet::blocks::control::{ControlBlock, ControlBlocks};
use wire::profinet::blocks::record::{ReadRequest, ReadResponse, RecordHeader, WriteRequest, WriteResponse};
use wire::profinet::rpc::{
    Flags1, LookupHandle, LookupRequest, NdrRequest, NdrResponse, ObjectUuid, Opnum, PacketType, RpcHeader, RpcPdu,
    Tower, Uuid,
};
use wire::profinet::status::{CmrpcError, ErrorCode, ErrorSource, PnioStatus, RecordError};

const AR: Uuid = Uuid([0x12, 0x34, 0x56, 0x78, 0x9a, 0xbc, 0xde, 0xf0, 0x11, 0x22, 0x33, 0x44, 0x55, 0x66, 0x77, 0x88]);
const OBJECT: ObjectUuid = ObjectUuid { instance: 1, device_id: 0x07d2, vendor_id: 0x010c };

fn golden(name: &str) -> Vec<u8> {
    let pdus = testing::golden("scapy-rpc.txt");
    pdus.into_iter().find(|(known, _)| known == name).unwrap_or_else(|| panic!("no golden PDU {name}")).1
}

fn readings(file: &str) -> Vec<(String, String)> {
    let text = std::fs::read_to_string(format!("{}/tests/golden/{file}", env!("CARGO_MANIFEST_DIR"))).expect(file);
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    lines.map(|line| line.split_once(' ').expect("name and fields")).map(|(a, b)| (a.into(), b.into())).collect()
}

#[test]
fn parsed_like_tshark() {
    let readings = readings("tshark-rpc.txt");
    assert_eq!(readings.len(), testing::golden("scapy-rpc.txt").len());
    let mut compared = 0;
    for (name, fields) in readings {
        let octets = golden(&name);
        let parsed = rpc_reading::fields(&RpcPdu::parse(&octets).expect(&name));
        compared += rpc_reading::assert_same(&name, &parsed, &rpc_reading::tshark(&fields));
    }
    assert!(compared > 1000, "only {compared} values");
}

#[test]
fn every_pdu_is_written_unchanged() {
    for (name, octets) in testing::golden("scapy-rpc.txt") {
        let pdu = RpcPdu::parse(&octets).expect(&name);
        let body = rpc_reading::body(&pdu).unwrap_or_else(|error| panic!("{name}: {error}"));
        let again = written(|out| {
            pdu.header.write(out);
            rpc_reading::write(&body, out, pdu.header.order());
        });
        assert_eq!(rpc_reading::hex(&again), rpc_reading::hex(&octets), "{name}: {body:#?}");
    }
}

#[test]
fn no_prefix_and_no_flipped_bit_makes_a_parser_panic() {
    for (name, octets) in testing::golden("scapy-rpc.txt") {
        println!("{name}");
        let attempt = |pdu: &RpcPdu| {
            if let Ok(body) = rpc_reading::body(pdu) {
                rpc_reading::write(&body, &mut Vec::new(), pdu.header.order());
            }
        };
        testing::every_prefix_and_flip(&octets, |octets| {
            if let Ok(pdu) = RpcPdu::parse(octets)
                && pdu.header.packet_type.word().is_some()
                && pdu.header.opnum.word().is_some()
            {
                attempt(&pdu);
            }
        });
        let pdu = RpcPdu::parse(&octets).expect(&name);
        testing::every_prefix_and_flip(pdu.body, |body| attempt(&RpcPdu { body, ..pdu }));
    }
}

#[test]
fn every_prefix_of_a_pdu_is_an_error() {
    for (name, octets) in testing::golden("scapy-rpc.txt") {
        for length in 0..octets.len() {
            assert!(RpcPdu::parse(&octets[..length]).is_err(), "{name}: {length} bytes");
        }
    }
}

fn request(order: ByteOrder, opnum: Opnum, interface: Uuid, blocks: &[u8]) -> Vec<u8> {
    let header = RpcHeader {
        flags1: Flags1::IDEMPOTENT,
        serial: 0x1234,
        object: OBJECT.into(),
        interface,
        activity: "00112233-4455-6677-8899-aabbccddeeff".parse().expect("a UUID"),
        sequence: 7,
        opnum,
        ..RpcHeader::new(PacketType::REQUEST, order)
    };
    RpcPdu::new(header, &NdrRequest::body(order, 4096, blocks)).to_vec()
}

fn response(order: ByteOrder, opnum: Opnum, status: PnioStatus, blocks: &[u8]) -> Vec<u8> {
    let request = request(order, opnum, Uuid::DEVICE_INTERFACE, &[]);
    let header = RpcHeader {
        flags1: Flags1::LAST_FRAGMENT | Flags1::NO_FACK,
        server_boot: 0x0102_0304,
        serial: 0x1234,
        ..RpcPdu::parse(&request).expect("a valid request").header.answer(PacketType::RESPONSE, order)
    };
    RpcPdu::new(header, &NdrResponse::body(order, status, 4096, blocks)).to_vec()
}

fn objects(rows: &[(u16, u16, u16)]) -> Vec<FrameObject> {
    rows.iter()
        .map(|(slot, subslot, offset)| FrameObject {
            slot_number: *slot,
            subslot_number: *subslot,
            frame_offset: *offset,
        })
        .collect()
}

fn iocr(iocr_type: IocrType, frame_id: u16, data: &[(u16, u16, u16)], iocs: &[(u16, u16, u16)]) -> ConnectContent {
    ConnectContent::IocrReq(IocrBlockReq {
        iocr_type,
        iocr_reference: iocr_type.0,
        lt: 0x8892,
        iocr_properties: RtClass::RT_CLASS_2.into(),
        data_length: 40,
        frame_id,
        send_clock_factor: 32,
        reduction_ratio: 2,
        phase: 1,
        frame_send_offset: 0xFFFF_FFFF,
        watchdog_factor: 10,
        data_hold_factor: 10,
        iocr_tag_header: 0xC000,
        apis: vec![IocrApi { api: 0, io_data_objects: objects(data), iocs: objects(iocs) }],
        ..IocrBlockReq::default()
    })
}

fn module(api: u32, slot: u16, ident: u32, submodules: Vec<ExpectedSubmodule>) -> ConnectContent {
    let module =
        ExpectedModule { api, slot_number: slot, module_ident_number: ident, module_properties: 0, submodules };
    ConnectContent::ExpectedSubmodule(ExpectedSubmoduleBlockReq { modules: vec![module] })
}

fn submodule(subslot: u16, ident: u32, kind: SubmoduleType, data: Vec<DataDescription>) -> ExpectedSubmodule {
    ExpectedSubmodule {
        subslot_number: subslot,
        submodule_ident_number: ident,
        submodule_properties: kind.into(),
        data_descriptions: data,
    }
}

fn connect() -> Connect {
    Connect::of([
        ConnectContent::ArReq(ArBlockReq {
            ar_type: ArType::IOCAR_SINGLE,
            ar_uuid: AR,
            session_key: 2,
            cm_initiator_mac_add: Mac([2, 0, 0, 0, 0, 1]),
            cm_initiator_object_uuid: OBJECT.into(),
            ar_properties: ArProperties::ACTIVE
                | ArProperties::PARAMETRIZATION_BY_INITIATOR
                | ArProperties::STARTUP_ADVANCED,
            cm_initiator_activity_timeout_factor: 600,
            initiator_udp_rt_port: 0x8892,
            cm_initiator_station_name: b"controller".to_vec(),
        }),
        iocr(IocrType::INPUT, 0x8001, &[(0, 1, 0), (1, 1, 1), (1, 2, 14)], &[(1, 2, 27)]),
        iocr(IocrType::OUTPUT, 0xFFFF, &[(1, 2, 0)], &[(0, 1, 5), (1, 1, 6), (1, 2, 7)]),
        module(0, 0, 0x101, vec![submodule(1, 0x11, SubmoduleType::NO_IO, vec![DataDescription::input(0)])]),
        module(
            0x3D00,
            1,
            0x202,
            vec![
                submodule(1, 0x21, SubmoduleType::INPUT, vec![DataDescription::input(12)]),
                submodule(
                    2,
                    0x22,
                    SubmoduleType::INPUT_OUTPUT,
                    vec![DataDescription::input(12), DataDescription::output(4)],
                ),
            ],
        ),
        ConnectContent::AlarmCrReq(AlarmCrBlockReq {
            alarm_cr_type: 1,
            lt: 0x8892,
            rta_timeout_factor: 1,
            rta_retries: 3,
            local_alarm_reference: 5,
            max_alarm_data_length: 200,
            alarm_cr_tag_header_high: 0xC000,
            alarm_cr_tag_header_low: 0xA000,
            ..AlarmCrBlockReq::default()
        }),
    ])
}

fn record(seq_number: u16, index: u16) -> RecordHeader {
    let ar_uuid = AR;
    RecordHeader { seq_number, ar_uuid, api: 0x3D00, slot_number: 1, subslot_number: 1, index, ..Default::default() }
}

fn read_header(length: u32) -> RecordHeader {
    RecordHeader { record_data_length: length, ..record(5, 0xB02E) }
}

#[rstest]
fn whole_pdus_are_those_of_scapy(#[values(ByteOrder::Big, ByteOrder::Little)] order: ByteOrder) {
    let word = if order == ByteOrder::Big { "big" } else { "little" };
    let device = Uuid::DEVICE_INTERFACE;
    let write = WriteRequest::of(record(3, 0xB02E), (0..10).collect());
    let inner =
        [WriteRequest::of(record(3, 0x1000), vec![1, 2, 3]), WriteRequest::of(record(3, 0x1001), vec![4, 5, 6, 7, 8])];
    let multiple = WriteRequest::multiple(AR, 4, &inner);
    let denied = PnioStatus::record(ErrorCode::WRITE_RESPONSE, RecordError::ACCESS_DENIED);
    let length_error =
        PnioStatus { error_code2: 6, ..PnioStatus::record(ErrorCode::WRITE_RESPONSE, RecordError::WRITE_LENGTH_ERROR) };
    let answers = vec![WriteResponse::to(&inner[0], PnioStatus::OK), WriteResponse::to(&inner[1], length_error)];
    let read = ReadRequest { header: read_header(240), ..ReadRequest::default() };
    let found = ReadResponse { additional_value1: 1, ..ReadResponse::to(&read, (0..12).collect()) };
    let implicit = RecordHeader { index: 0xAFF0, subslot_number: 1, record_data_length: 64, ..RecordHeader::default() };
    let implicit = ReadRequest { header: implicit, target_ar_uuid: AR, ..ReadRequest::default() };
    let prm_end = ControlBlock::prm_end(AR, 2);
    let release = ControlBlock::release(AR, 2);
    let control = |block: ControlBlock| ControlBlocks::from(block).to_vec();
    let out_of_resources =
        PnioStatus::found(ErrorCode::CONNECT_RESPONSE, ErrorSource::CMRPC, CmrpcError::OUT_OF_AR_RESOURCES.0);
    let cases = [
        ("connect_request", request(order, Opnum::CONNECT, device, &connect().to_vec())),
        ("connect_refused", response(order, Opnum::CONNECT, out_of_resources, &[])),
        ("write", request(order, Opnum::WRITE, device, &written(|out| write.write(out)))),
        (
            "write_response",
            response(order, Opnum::WRITE, denied, &written(|out| WriteResponse::to(&write, denied).write(out))),
        ),
        ("write_multiple", request(order, Opnum::WRITE, device, &written(|out| multiple.write(out)))),
        (
            "write_multiple_response",
            response(
                order,
                Opnum::WRITE,
                PnioStatus::OK,
                &written(|out| {
                    WriteResponse::to_multiple(&multiple, answers).iter().for_each(|answer| answer.write(out))
                }),
            ),
        ),
        ("read", request(order, Opnum::READ, device, &written(|out| read.write(out)))),
        ("read_response", response(order, Opnum::READ, PnioStatus::OK, &written(|out| found.write(out)))),
        ("read_implicit", request(order, Opnum::READ_IMPLICIT, device, &written(|out| implicit.write(out)))),
        ("prm_end", request(order, Opnum::CONTROL, device, &control(prm_end))),
        ("prm_end_done", response(order, Opnum::CONTROL, PnioStatus::OK, &control(prm_end.done()))),
        (
            "application_ready",
            request(
                order,
                Opnum::CONTROL,
                Uuid::CONTROLLER_INTERFACE,
                &control(ControlBlock::application_ready(AR, 2)),
            ),
        ),
        ("release", request(order, Opnum::RELEASE, device, &control(release))),
        ("release_done", response(order, Opnum::RELEASE, PnioStatus::OK, &control(release.done()))),
    ];
    for (name, octets) in cases {
        let name = format!("{name}_{word}");
        assert_eq!(rpc_reading::hex(&octets), rpc_reading::hex(&golden(&name)), "{name}");
    }
}

#[rstest]
#[case::request("lookup_request_big", ByteOrder::Big)]
#[case::request("lookup_request_little", ByteOrder::Little)]
fn a_lookup_of_all_endpoints_is_that_of_scapy(#[case] name: &str, #[case] order: ByteOrder) {
    let octets = golden(name);
    let body = written(|out| LookupRequest::all(LookupHandle::default()).write(out, order));
    assert_eq!(rpc_reading::hex(&body), rpc_reading::hex(&octets[RpcHeader::LENGTH..]));
}

fn contents(name: &str) -> Vec<ConnectContent> {
    let octets = golden(name);
    match rpc_reading::body(&RpcPdu::parse(&octets).expect(name)).expect(name) {
        RpcBody::Request(_, RpcBlocks::Connect(connect)) | RpcBody::Response(_, RpcBlocks::Connect(connect)) => {
            connect.blocks.into_iter().map(|block| block.content).collect()
        }
        other => panic!("{name} is {other:?}"),
    }
}

#[test]
fn the_blocks_unknown_to_scapy_and_tshark_have_the_values_of_the_script() {
    let request = contents("connect_prm_server_little");
    let server = PrmServerBlockReq {
        parameter_server_object_uuid: OBJECT.into(),
        parameter_server_properties: 0x0102_0304,
        cm_initiator_activity_timeout_factor: 0x258,
        parameter_server_station_name: b"prm-server".to_vec(),
    };
    assert_eq!(
        request[1..],
        [ConnectContent::PrmServerReq(server), ConnectContent::ArRpcReq(ArRpcBlock { rpc_server_port: 34966 })]
    );
    let response = contents("connect_server_little");
    let server = ArServerBlockRes { cm_responder_station_name: b"encoder-under-test".to_vec() };
    assert_eq!(
        response[1..],
        [ConnectContent::ArServerRes(server), ConnectContent::ArRpcRes(ArRpcBlock { rpc_server_port: 34965 })]
    );
}

#[test]
fn an_ar_server_block_is_padded_to_four_bytes() {
    let octets = golden("connect_server_big");
    let connect = Connect::of(contents("connect_server_big"));
    assert_eq!(
        rpc_reading::hex(&connect.to_vec()),
        rpc_reading::hex(&octets[RpcHeader::LENGTH + NdrResponse::LENGTH..])
    );
}

#[rstest]
#[case::none(0, 0, 0)]
#[case::companion_first(1 << 9, 1, 0)]
#[case::companion_second(2 << 9, 2, 0)]
#[case::time_aware(1 << 28, 0, 0)]
#[case::reserved_low(0xE0, 0, 0xE0)]
#[case::reserved_high(0x0FFF_F000, 0, 0x0FFF_F000)]
#[case::everything(0xFFFF_FFFF, 3, 0x0FFF_F0E0)]
fn ar_properties_keep_their_reserved_bits(#[case] bits: u32, #[case] companion: u8, #[case] reserved: u32) {
    // The masks are those of `tshark -G fields` for pn_io.ar_properties.*.
    let properties = ArProperties(bits);
    assert_eq!((properties.companion_ar(), properties.reserved()), (companion, reserved));
}

#[test]
fn a_tower_has_the_port_of_the_device() {
    let octets = golden("lookup_response_big");
    let pdu = RpcPdu::parse(&octets).expect("a PDU");
    let RpcBody::LookupResponse(lookup) = rpc_reading::body(&pdu).expect("a lookup response") else {
        panic!("no lookup response");
    };
    let tower = lookup.entries[0].tower.as_ref().expect("a tower");
    assert_eq!(*tower, Tower::udp(Uuid::DEVICE_INTERFACE, 1, 0, 34964, [192, 168, 0, 10]));
    assert_eq!(tower.interface(), Some((Uuid::DEVICE_INTERFACE, 1, 0)));
    assert_eq!(ObjectUuid::of(lookup.entries[0].object), Some(OBJECT));
}
