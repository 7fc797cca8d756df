//! RPC: fragments, repetitions, pings, cancels, rejects, and the endpoint mapper.

use super::bench::*;
use alloc::vec::Vec;
use rstest::rstest;
use wire::octets::ByteOrder;
use wire::profinet::blocks::control::{ControlBlock, ControlBlocks, ControlCommand};
use wire::profinet::blocks::record::{ReadRequest, ReadResponse, RecordHeader, WriteRequest};
use wire::profinet::rpc::{
    Cancel, CancelAck, Fack, Flags1, InquiryType, LookupHandle, LookupRequest, LookupResponse, NdrRequest, NdrResponse,
    Opnum, PacketType, RejectStatus, RpcHeader, RpcPdu, Uuid, fragments,
};
use wire::profinet::status::PnioStatus;

const RECORD: RecordHeader = RecordHeader {
    version: [1, 0],
    seq_number: 1,
    ar_uuid: AR,
    api: 0x3D00,
    slot_number: 1,
    subslot_number: 2,
    padding: 0,
    index: 0x100,
    record_data_length: 8192,
};

/// A bench with a connection for records only.
fn connected() -> StackBench {
    let mut bench = StackBench::new();
    bench.connect(&access_connect(AR));
    bench
}

fn write_body(order: ByteOrder, data: &[u8]) -> Vec<u8> {
    let mut blocks = Vec::new();
    WriteRequest::of(RECORD, data.to_vec()).write(&mut blocks);
    NdrRequest::body(order, 4096, &blocks)
}

#[rstest]
#[case::big(ByteOrder::Big)]
#[case::little(ByteOrder::Little)]
fn requests_and_answers_are_fragmented(#[case] order: ByteOrder) {
    let mut bench = connected();
    bench.order = order;
    let data: Vec<u8> = (0..3500_u16).map(|number| number as u8).collect();
    let header = bench.header(Opnum::WRITE);
    let pdus = fragments(&header, &write_body(order, &data), 1392);
    assert_eq!(pdus.len(), 3);
    let answers = bench.pdus(&[pdus[1].clone(), pdus[0].clone(), pdus[2].clone()]);
    let answers: Vec<RpcPdu<'_>> = answers.iter().map(|answer| RpcPdu::parse(answer).unwrap()).collect();
    let kinds: Vec<_> = answers.iter().map(|answer| answer.header.packet_type).collect();
    assert_eq!(kinds, [PacketType::FACK, PacketType::FACK, PacketType::RESPONSE]);
    let fack = Fack::parse(order, answers[0].body).unwrap().unwrap();
    assert_eq!((answers[0].header.fragment, fack.selective[..].to_vec()), (0xFFFF, alloc::vec![0b10]));
    assert_eq!(answers[1].header.fragment, 1);
    assert_eq!(bench.device.application().record, data);

    let mut blocks = Vec::new();
    ReadRequest { header: RECORD, ..ReadRequest::default() }.write(&mut blocks);
    let (status, blocks) = bench.operate(Opnum::READ, &blocks);
    assert_eq!(status, PnioStatus::OK);
    assert_eq!(ReadResponse::parse(&blocks).unwrap().record(), data);
    bench.check_with_tshark();
}

#[test]
fn a_repeated_request_gets_the_same_answer_and_is_carried_out_once() {
    let mut bench = connected();
    let header = bench.header(Opnum::WRITE);
    let pdu = RpcPdu::new(header, &write_body(ByteOrder::Big, &[1])).to_vec();
    let first = bench.pdus(core::slice::from_ref(&pdu));
    assert_eq!(bench.pdus(core::slice::from_ref(&pdu)), first);
    assert_eq!(bench.device.application().writes, 1);
    let older =
        RpcPdu::new(RpcHeader { sequence: header.sequence - 1, ..header }, &write_body(ByteOrder::Big, &[2])).to_vec();
    assert!(bench.pdus(&[older]).is_empty());
    let ping = RpcPdu::new(RpcHeader { packet_type: PacketType::PING, ..header }, &[]).to_vec();
    assert_eq!(bench.pdus(core::slice::from_ref(&ping)), first);
    let ack = RpcPdu::new(RpcHeader { packet_type: PacketType::ACK, ..header }, &[]).to_vec();
    assert!(bench.pdus(&[ack]).is_empty());
    assert_eq!(RpcPdu::parse(&bench.pdus(&[ping])[0]).unwrap().header.packet_type, PacketType::NOCALL);
}

#[test]
fn a_cancel_is_acknowledged_and_not_accepted() {
    let mut bench = connected();
    let header = bench.header(Opnum::READ);
    let mut body = Vec::new();
    Cancel { version: 0, cancel_id: 7 }.write(&mut body, ByteOrder::Big);
    let answers = bench.pdus(&[RpcPdu::new(RpcHeader { packet_type: PacketType::CANCEL, ..header }, &body).to_vec()]);
    let pdu = RpcPdu::parse(&answers[0]).unwrap();
    assert_eq!(pdu.header.packet_type, PacketType::CANCEL_ACK);
    let ack = CancelAck::parse(ByteOrder::Big, pdu.body).unwrap().unwrap();
    assert_eq!((ack.cancel_id, ack.accepting), (7, 0));
}

#[rstest]
#[case::interface(|header: &mut RpcHeader| header.interface = Uuid::CONTROLLER_INTERFACE, RejectStatus::UNKNOWN_INTERFACE)]
#[case::operation(|header: &mut RpcHeader| header.opnum = Opnum(6), RejectStatus::OPERATION_RANGE)]
#[case::mapper(|header: &mut RpcHeader| header.interface = Uuid::ENDPOINT_MAPPER, RejectStatus::OPERATION_RANGE)]
#[case::boot_time(|header: &mut RpcHeader| header.server_boot = 77, RejectStatus::WRONG_BOOT_TIME)]
fn calls_are_rejected(#[case] spoil: fn(&mut RpcHeader), #[case] status: RejectStatus) {
    let mut bench = StackBench::new();
    let mut header = bench.header(Opnum::CONNECT);
    spoil(&mut header);
    let (answer, body) = bench.call(&header, &[]).unwrap();
    assert_eq!(answer.packet_type, PacketType::REJECT);
    assert_eq!(RejectStatus::parse(answer.order(), &body).unwrap(), status);
}

#[test]
fn a_body_that_cannot_be_decoded_is_a_fault() {
    let mut bench = StackBench::new();
    let header = bench.header(Opnum::CONNECT);
    let (answer, body) = bench.call(&header, &[0; 19]).unwrap();
    assert_eq!(answer.packet_type, PacketType::FAULT);
    assert_eq!(RejectStatus::parse(answer.order(), &body).unwrap(), RejectStatus::FAULT_NDR);
}

#[rstest]
#[case::connect(Opnum::CONNECT, 0xDB)]
#[case::release(Opnum::RELEASE, 0xDC)]
#[case::read(Opnum::READ, 0xDE)]
#[case::write(Opnum::WRITE, 0xDF)]
#[case::control(Opnum::CONTROL, 0xDD)]
#[case::read_implicit(Opnum::READ_IMPLICIT, 0xDE)]
fn a_wrong_args_length_is_refused(#[case] opnum: Opnum, #[case] code: u8) {
    let mut bench = StackBench::new();
    let mut body = NdrRequest::body(ByteOrder::Big, 4096, &[0; 8]);
    body[7] = 9;
    let header = bench.header(opnum);
    let (answer, body) = bench.call(&header, &body).unwrap();
    let status = NdrResponse::parse(answer.order(), &body).unwrap().0.status;
    assert_eq!(u32::from(status).to_be_bytes(), [code, 0x81, 64, 0]);
}

#[test]
fn an_answer_that_does_not_fit_is_a_fault() {
    let mut bench = StackBench::new();
    let header = bench.header(Opnum::CONNECT);
    let (answer, body) =
        bench.call(&header, &NdrRequest::body(ByteOrder::Big, 10, &access_connect(AR).to_vec())).unwrap();
    assert_eq!(answer.packet_type, PacketType::FAULT);
    assert_eq!(RejectStatus::parse(answer.order(), &body).unwrap(), RejectStatus::OUTPUT_TOO_BIG);
}

#[rstest]
#[case::kind(|block: &mut ControlBlock| block.header.kind.0 = 0x0118, 0xDD81_4001)]
#[case::version(|block: &mut ControlBlock| block.header.version_low = 1, 0xDD81_1403)]
#[case::unknown(|block: &mut ControlBlock| block.ar_uuid = Uuid([1; 16]), 0xDD81_4005)]
#[case::session(|block: &mut ControlBlock| block.session_key = 2, 0xDD81_1406)]
#[case::command(|block: &mut ControlBlock| block.control_command = ControlCommand::RELEASE, 0xDD81_1408)]
#[case::twice(|_: &mut ControlBlock| {}, 0xDD81_4006)]
fn a_wrong_prm_end_is_refused(#[case] spoil: fn(&mut ControlBlock), #[case] status: u32) {
    let mut bench = StackBench::new();
    bench.connect(&full_connect());
    bench.prm_end();
    let mut block = ControlBlock::prm_end(AR, 1);
    spoil(&mut block);
    let (found, _) = bench.operate(Opnum::CONTROL, &ControlBlocks::from(block).to_vec());
    assert_eq!(found, PnioStatus::from(status));
}

#[rstest]
#[case::session(|block: &mut ControlBlock| block.session_key = 2, 0xDC81_2806)]
#[case::command(|block: &mut ControlBlock| block.control_command = ControlCommand::PRM_END, 0xDC81_2808)]
#[case::unknown(|block: &mut ControlBlock| block.ar_uuid = Uuid([1; 16]), 0xDC81_4005)]
fn a_wrong_release_is_refused(#[case] spoil: fn(&mut ControlBlock), #[case] status: u32) {
    let mut bench = connected();
    let mut block = ControlBlock::release(AR, 1);
    spoil(&mut block);
    let (found, _) = bench.operate(Opnum::RELEASE, &ControlBlocks::from(block).to_vec());
    assert_eq!(found, PnioStatus::from(status));
    assert_eq!(bench.release(), PnioStatus::OK);
}

#[rstest]
#[case::all(InquiryType::ALL, Uuid::NIL, true)]
#[case::by_interface(InquiryType::BY_INTERFACE, Uuid::DEVICE_INTERFACE, true)]
#[case::by_another_interface(InquiryType::BY_INTERFACE, Uuid::CONTROLLER_INTERFACE, false)]
#[case::unknown_inquiry(InquiryType(9), Uuid::NIL, false)]
fn the_endpoint_mapper_lists_the_device(
    #[case] inquiry: InquiryType,
    #[case] interface: Uuid,
    #[case] is_listed: bool,
) {
    let mut bench = StackBench::new();
    bench.order = ByteOrder::Little;
    let ask = |bench: &mut StackBench, handle: LookupHandle| {
        let lookup = LookupRequest {
            inquiry_type: inquiry,
            interface: Some((2, interface, 1, 0)),
            ..LookupRequest::all(handle)
        };
        let mut body = Vec::new();
        lookup.write(&mut body, ByteOrder::Little);
        let header = bench.header(Opnum::EPT_LOOKUP);
        let header = RpcHeader { interface: Uuid::ENDPOINT_MAPPER, interface_version: 3, ..header };
        let (answer, body) = bench.call(&header, &body).unwrap();
        LookupResponse::parse(answer.order(), &body).unwrap()
    };
    let first = ask(&mut bench, LookupHandle::default());
    assert_eq!(first.entries.len(), usize::from(is_listed));
    if let [entry] = &first.entries[..] {
        let tower = entry.tower.as_ref().unwrap();
        assert_eq!((tower.port(), tower.address()), (Some(0x8894), Some(DEVICE_IP.octets())));
        assert_eq!(tower.interface(), Some((Uuid::DEVICE_INTERFACE, 1, 0)));
        assert_eq!(entry.annotation, *b"TOY                       TOY-1                    3 V  1  2  3\0");
        let last = ask(&mut bench, first.handle);
        assert_eq!((last.entries.len(), last.status), (0, LookupResponse::NOT_REGISTERED));
        bench.check_with_tshark();
    } else {
        assert_eq!(first.status, LookupResponse::NOT_REGISTERED);
    }
}

#[test]
fn fragments_with_no_fack_get_no_fack() {
    let mut bench = connected();
    let header = bench.header(Opnum::WRITE);
    let header = RpcHeader { flags1: header.flags1 | Flags1::NO_FACK, ..header };
    let pdus = fragments(&header, &write_body(ByteOrder::Big, &[1; 2000]), 1392);
    assert!(bench.pdus(&pdus[..1]).is_empty());
    assert_eq!(bench.pdus(&pdus[1..]).len(), 1);
}
