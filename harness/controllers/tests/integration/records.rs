//! Records, base mode parameters, fragments, implicit reads, the endpoint mapper, DCP services, release and abort.
#![allow(clippy::unwrap_used, reason = "a test that unwraps nothing has failed")]

use crate::common::*;
use core::time::Duration;
use encspec_controllers::profinet_io::*;
use rstest::rstest;
use wire::datagram::Datagram;
use wire::datagram::arp::Arp;
use wire::ethernet::{FrameHeader, Mac};
use wire::octets::ByteOrder;
use wire::profinet::alarm::RtaBody;
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::control::{ControlBlock, ControlBlocks, ControlCommand};
use wire::profinet::blocks::record::{ReadRequest, ReadResponse};
use wire::profinet::dcp::{BlockError, BlockQualifier, Dcp, DcpBlock, DcpValue, Element};
use wire::profinet::rpc::{
    EndpointEntry, Flags1, LookupHandle, LookupRequest, LookupResponse, NdrResponse, ObjectUuid, Opnum, PORT,
    PacketType, RpcHeader, RpcPdu, Tower, Uuid, fragments,
};
use wire::profinet::status::{AbortReason, ErrorCode, PnioStatus, RecordError};

const STATE_CONFLICT: PnioStatus = PnioStatus::record(ErrorCode::READ_RESPONSE, RecordError::STATE_CONFLICT);
const INVALID_INDEX: PnioStatus = PnioStatus::record(ErrorCode::READ_RESPONSE, RecordError::INVALID_INDEX);
const PARTNER: Partner = Partner { mac: DEVICE, ip: DEVICE_IP };

fn parameter(request: &[u8]) -> ControllerRequest {
    ControllerRequest::Parameter { at: PARAMETERS, request: request.to_vec() }
}

#[test]
fn a_record_is_written_and_read() {
    let mut rig = ControllerRig::standing();
    let written = rig.ask(ControllerRequest::Write { target: PARAMETERS, data: vec![1, 2, 3] });
    assert_eq!(written, ControllerOutcome::Record(IoRecordOutcome::Accepted { data: vec![] }));
    let read = rig.ask(ControllerRequest::Read { target: PARAMETERS, length: 100 });
    assert_eq!(read, ControllerOutcome::Record(IoRecordOutcome::Accepted { data: vec![1, 2, 3] }));
}

#[rstest]
#[case::refused(|_: &ReceivedCall| Reaction::Refuse(INVALID_INDEX), IoRecordOutcome::Refused(INVALID_INDEX))]
#[case::silent(|_: &ReceivedCall| Reaction::Silence,
    IoRecordOutcome::Failed(CallError::NoAnswer(Wait { what: AwaitedEvent::Read, time: Duration::from_secs(4) })))]
#[case::other_record(|call: &ReceivedCall| other(call, |answer| answer.header.index = 1),
    IoRecordOutcome::Failed(CallError::Unfit("Index is 1, 45102 was sent".into())))]
#[case::other_number(|call: &ReceivedCall| other(call, |answer| answer.header.seq_number += 1),
    IoRecordOutcome::Failed(CallError::Unfit("SeqNumber is 2, 1 was sent".into())))]
#[case::other_ar(|call: &ReceivedCall| other(call, |answer| answer.header.ar_uuid = Uuid::NIL),
    IoRecordOutcome::Failed(CallError::Unfit("ARUUID is 00000000-0000-0000-0000-000000000000".into())))]
fn a_failed_read_reports_the_reason(#[case] hook: fn(&ReceivedCall) -> Reaction, #[case] outcome: IoRecordOutcome) {
    let mut rig = ControllerRig::standing();
    rig.device.hook = Box::new(hook);
    assert_eq!(rig.ask(ControllerRequest::Read { target: PARAMETERS, length: 10 }), ControllerOutcome::Record(outcome));
    assert_eq!(rig.controller.state(), ArState::Data);
}

fn other(call: &ReceivedCall, change: impl Fn(&mut ReadResponse)) -> Reaction {
    let mut answer = ReadResponse::to(&ReadRequest::parse(call.blocks).unwrap(), vec![5]);
    change(&mut answer);
    let mut blocks = Vec::new();
    answer.write(&mut blocks);
    Reaction::Blocks(blocks)
}

#[test]
fn without_an_ar_there_are_no_records() {
    let mut rig = ControllerRig::new();
    let none = || IoRecordOutcome::Failed(CallError::ArEnded);
    assert_eq!(rig.ask(ControllerRequest::Read { target: PARAMETERS, length: 1 }), ControllerOutcome::Record(none()));
    assert_eq!(
        rig.ask(ControllerRequest::Write { target: PARAMETERS, data: vec![] }),
        ControllerOutcome::Record(none())
    );
    let records = vec![StartUpRecord { target: PARAMETERS, data: vec![] }];
    assert_eq!(rig.ask(ControllerRequest::WriteMultiple(records)), ControllerOutcome::Records(vec![none()]));
    let failed = IoParameterOutcome::Failed(CallError::ArEnded);
    assert_eq!(rig.ask(parameter(&[1])), ControllerOutcome::Parameter(failed));
    assert_eq!(rig.ask(ControllerRequest::Release), ControllerOutcome::Ended(ArReleaseOutcome::NoAr));
    assert_eq!(
        rig.ask(ControllerRequest::Abort { code: AbortReason::ABORT_REQUEST }),
        ControllerOutcome::Ended(ArReleaseOutcome::NoAr)
    );
}

#[test]
fn several_records_go_in_one_write() {
    let mut rig = ControllerRig::standing();
    let record = |index, length| StartUpRecord { target: RecordAddress { index, ..PARAMETERS }, data: vec![7; length] };
    let outcome = rig.ask(ControllerRequest::WriteMultiple(vec![record(1, 3), record(2, 5)]));
    assert_eq!(outcome, ControllerOutcome::Records(vec![IoRecordOutcome::Accepted { data: vec![] }; 2]));
}

/// The device answers "not ready" for less than ten seconds; its answer is then accepted.
#[rstest]
#[case::at_once(0, 1)]
#[case::later(7, 8)]
fn the_answer_to_a_parameter_request_is_read_until_it_is_ready(#[case] conflicts: usize, #[case] reads: usize) {
    let mut rig = ControllerRig::standing();
    rig.device.hook = Box::new(move |call| match call.header.opnum {
        Opnum::READ if call.before < conflicts => Reaction::Refuse(STATE_CONFLICT),
        _ => Reaction::Usual,
    });
    let outcome = rig.ask(parameter(&[9, 1, 0, 1, 0x10, 0, 3, 0xCA, 0, 0]));
    assert_eq!(
        outcome,
        ControllerOutcome::Parameter(IoParameterOutcome::Answer(vec![9, 1, 0, 1, 0x10, 0, 3, 0xCA, 0, 0]))
    );
    assert_eq!(rig.device.calls.iter().filter(|opnum| **opnum == Opnum::READ).count(), reads);
}

#[test]
fn a_parameter_request_that_is_never_answered_ends_after_ten_seconds() {
    let mut rig = ControllerRig::standing();
    rig.device.hook = Box::new(|call| match call.header.opnum {
        Opnum::READ => Reaction::Refuse(STATE_CONFLICT),
        _ => Reaction::Usual,
    });
    let before = rig.now;
    let outcome = rig.ask(parameter(&[9, 1]));
    let ControllerOutcome::Parameter(IoParameterOutcome::NotReady(STATE_CONFLICT, wait)) = outcome else {
        panic!("{outcome:?}")
    };
    assert_eq!(wait.what, AwaitedEvent::ParameterAnswer);
    let took = rig.now.since(before);
    assert!(took > Duration::from_millis(9950) && took <= Duration::from_secs(10), "{took:?}");
    assert_eq!(rig.controller.state(), ArState::Data);
}

/// An empty record also means "not ready".
#[test]
fn an_empty_answer_is_read_again() {
    let mut rig = ControllerRig::standing();
    rig.device.hook = Box::new(|call| match call.header.opnum {
        Opnum::READ if call.before < 3 => other(call, |answer| {
            answer.data.clear();
            answer.header.record_data_length = 0;
        }),
        _ => Reaction::Usual,
    });
    assert_eq!(rig.ask(parameter(&[9, 1])), ControllerOutcome::Parameter(IoParameterOutcome::Answer(vec![9, 1])));
}

#[rstest]
#[case::write(Opnum::WRITE, IoParameterOutcome::WriteRefused(INVALID_INDEX))]
#[case::read(Opnum::READ, IoParameterOutcome::ReadRefused(INVALID_INDEX))]
fn a_refused_parameter_request_reports_whether_write_or_read_failed(
    #[case] half: Opnum,
    #[case] outcome: IoParameterOutcome,
) {
    let mut rig = ControllerRig::standing();
    rig.device.hook =
        Box::new(move |call| if call.header.opnum == half { Reaction::Refuse(INVALID_INDEX) } else { Reaction::Usual });
    assert_eq!(rig.ask(parameter(&[9, 1])), ControllerOutcome::Parameter(outcome));
}

#[test]
fn an_answer_with_another_reference_is_not_taken() {
    let mut rig = ControllerRig::standing();
    rig.device.hook = Box::new(|call| match call.header.opnum {
        Opnum::READ => other(call, |answer| answer.data = vec![5]),
        _ => Reaction::Usual,
    });
    let outcome = IoParameterOutcome::OtherReference { sent: 9, answer: vec![5] };
    assert_eq!(rig.ask(parameter(&[9, 1])), ControllerOutcome::Parameter(outcome));
}

#[test]
fn the_end_of_the_ar_ends_the_running_request() {
    let mut rig = ControllerRig::standing();
    rig.device.hook = Box::new(|_| Reaction::Silence);
    rig.controller.request(rig.now, parameter(&[9, 1])).unwrap();
    rig.run(Duration::from_millis(10));
    rig.let_device(|device, out| device.abort(AbortReason::STATION_NAME_CHANGED, out));
    rig.run(Duration::from_millis(1));
    let failed = IoParameterOutcome::Failed(CallError::ArEnded);
    assert_eq!(rig.controller.take_outcome(), Some(ControllerOutcome::Parameter(failed)));
    let end = ArEnd::Aborted(PnioStatus::abort(AbortReason::STATION_NAME_CHANGED));
    assert_eq!(rig.controller.take_end(), Some(end));
    assert_eq!(rig.controller.take_end(), None);
}

/// A write that does not fit in a frame is sent in fragments, each after the fack of the previous one.
#[test]
fn a_long_record_is_written_in_fragments() {
    let mut rig = ControllerRig::standing();
    let data: Vec<u8> = (0..4000u32).map(|number| number as u8).collect();
    let before = rig.log.len();
    let written = rig.ask(ControllerRequest::Write { target: PARAMETERS, data: data.clone() });
    assert_eq!(written, ControllerOutcome::Record(IoRecordOutcome::Accepted { data: vec![] }));
    assert_eq!(rig.device.parameter, data);
    let pdus: Vec<(bool, RpcHeader)> = rig.log[before..]
        .iter()
        .filter_map(|(_, from_controller, frame)| {
            Some((*from_controller, RpcPdu::parse(Datagram::parse(frame).ok()?.payload).ok()?.header))
        })
        .collect();
    let turns: Vec<_> =
        pdus.iter().map(|(from_controller, header)| (*from_controller, header.packet_type, header.fragment)).collect();
    assert_eq!(
        turns,
        [
            (true, PacketType::REQUEST, 0),
            (false, PacketType::FACK, 0),
            (true, PacketType::REQUEST, 1),
            (false, PacketType::FACK, 1),
            (true, PacketType::REQUEST, 2),
            (false, PacketType::RESPONSE, 0),
        ]
    );
}

/// A server that sends no fack gets all fragments at once when the first repetition is due.
#[test]
fn a_server_without_facks_gets_all_fragments_at_once() {
    let mut rig = ControllerRig::standing();
    rig.device.facks = false;
    let written = rig.ask(ControllerRequest::Write { target: PARAMETERS, data: vec![3; 4000] });
    assert_eq!(written, ControllerOutcome::Record(IoRecordOutcome::Accepted { data: vec![] }));
    assert_eq!(rig.device.parameter, vec![3; 4000]);
}

/// A long answer arrives in fragments; each is acknowledged as requested, and a lost one is repeated.
#[rstest]
#[case::in_order(&[0, 1, 2])]
#[case::mixed(&[2, 0, 0, 1])]
fn a_long_record_is_read_in_fragments(#[case] order: &'static [usize]) {
    let mut rig = ControllerRig::standing();
    let data: Vec<u8> = (0..3000u32).map(|number| number as u8).collect();
    let expected = data.clone();
    rig.device.hook = Box::new(move |call| {
        let answer = ReadResponse::to(&ReadRequest::parse(call.blocks).unwrap(), data.clone());
        let mut blocks = Vec::new();
        answer.write(&mut blocks);
        let body = NdrResponse::body(ByteOrder::Big, PnioStatus::OK, 4096, &blocks);
        let header = RpcHeader { flags1: Flags1(0), ..call.header.answer(PacketType::RESPONSE, ByteOrder::Big) };
        let pieces = fragments(&header, &body, 1392);
        Reaction::Instead(order.iter().map(|at| pieces[*at].clone()).collect())
    });
    let read = rig.ask(ControllerRequest::Read { target: PARAMETERS, length: 3000 });
    assert_eq!(read, ControllerOutcome::Record(IoRecordOutcome::Accepted { data: expected }));
    rig.run(Duration::from_millis(1));
    let facks = rig.sent_pdus().iter().filter(|(_, header)| header.packet_type == PacketType::FACK).count();
    assert_eq!(facks, order.iter().filter(|at| **at != 2).count());
}

#[test]
fn a_record_is_read_without_an_ar() {
    let mut rig = ControllerRig::new();
    rig.device.ip = ip();
    rig.device.parameter = vec![4, 5];
    let object = ObjectUuid { instance: 1, device_id: 7, vendor_id: 0x012A };
    let target = RecordAddress { index: 0xF840, ..RecordAddress::default() };
    let read = rig.ask(ControllerRequest::ReadImplicit { partner: PARTNER, object, target, length: 64 });
    assert_eq!(read, ControllerOutcome::Record(IoRecordOutcome::Accepted { data: vec![4, 5] }));
    assert_eq!((rig.device.calls.as_slice(), rig.controller.state()), (&[Opnum::READ_IMPLICIT][..], ArState::None));
}

#[test]
fn an_implicit_read_outlives_the_ar() {
    let mut rig = ControllerRig::standing();
    rig.device.hook = Box::new(|call| if call.before == 0 { Reaction::Silence } else { Reaction::Usual });
    let object = ObjectUuid { instance: 1, device_id: 7, vendor_id: 0x012A };
    let read = ControllerRequest::ReadImplicit { partner: PARTNER, object, target: PARAMETERS, length: 64 };
    rig.controller.request(rig.now, read).unwrap();
    rig.run(Duration::from_millis(1));
    rig.let_device(|device, out| device.abort(AbortReason::LINK_DOWN, out));
    rig.run(Duration::from_secs(2));
    assert_eq!(rig.controller.state(), ArState::None);
    let Some(ControllerOutcome::Record(outcome)) = rig.controller.take_outcome() else { panic!("no outcome") };
    assert!(outcome.is_accepted());
}

#[test]
fn the_endpoint_mapper_is_walked_through() {
    let mut rig = ControllerRig::new();
    rig.device.order = None;
    let entry = |interface| EndpointEntry {
        object: Uuid::NIL,
        tower: Some(Tower::udp(interface, 1, 0, PORT, DEVICE_IP.octets())),
        annotation: vec![b' '; 64],
    };
    let known = [entry(Uuid::DEVICE_INTERFACE), entry(Uuid::ENDPOINT_MAPPER)];
    let answers = known.clone();
    rig.device.hook = Box::new(move |call| {
        // A lookup has no PROFINET NDR header, so the hook parses the bytes again that the rig took for one.
        let at = call.before;
        let handle = LookupHandle { attributes: 0, uuid: if at == 0 { Uuid([7; 16]) } else { Uuid::NIL } };
        let response = LookupResponse { handle, max_entries: 1, entries: vec![answers[at].clone()], status: 0 };
        let mut body = Vec::new();
        response.write(&mut body, ByteOrder::Little);
        Reaction::Instead(vec![
            RpcPdu::new(call.header.answer(PacketType::RESPONSE, ByteOrder::Little), &body).to_vec(),
        ])
    });
    assert_eq!(
        rig.ask(ControllerRequest::EndpointLookup { partner: PARTNER }),
        ControllerOutcome::Endpoints(Ok(known.to_vec()))
    );
    let sent: Vec<LookupRequest> = rig
        .sent()
        .filter_map(|(_, frame)| Datagram::parse(frame).ok())
        .map(|datagram| LookupRequest::parse(ByteOrder::Big, RpcPdu::parse(datagram.payload).unwrap().body).unwrap())
        .collect();
    assert_eq!((sent[0].handle.uuid, sent[1].handle.uuid), (Uuid::NIL, Uuid([7; 16])));
    assert!(rig.sent_pdus().iter().all(|(_, header)| header.interface_version == 3));
}

#[test]
fn release_ends_the_ar_even_if_the_device_aborts_it_first() {
    let mut rig = ControllerRig::standing();
    rig.controller.request(rig.now, ControllerRequest::Release).unwrap();
    rig.let_device(|device, out| device.abort(AbortReason::RELEASE_RECEIVED, out));
    rig.run(Duration::from_millis(1));
    let released = ArReleaseOutcome::Released(ControlOutcome::Accepted);
    assert_eq!(rig.controller.take_outcome(), Some(ControllerOutcome::Ended(released)));
    assert_eq!((rig.controller.state(), rig.controller.take_end()), (ArState::None, None));
    let sent = rig.controller.cycles_sent();
    rig.run(Duration::from_millis(100));
    assert_eq!(rig.controller.cycles_sent(), sent);
}

/// An answer to Release that is another block, is about another AR, or is not Done.
#[rstest]
#[case::other_block(|block: &mut ControlBlock| block.header.kind = BlockType::PRM_END_RES, "BlockType is 0x8110")]
#[case::other_ar(|block: &mut ControlBlock| block.session_key = 9, "the block is about AR")]
#[case::not_done(|block: &mut ControlBlock| block.control_command = ControlCommand(4), "ControlCommand is 0x0004")]
fn an_answer_to_a_control_call_must_fit(#[case] change: fn(&mut ControlBlock), #[case] why: &str) {
    let mut rig = ControllerRig::standing();
    rig.device.hook = Box::new(move |call| {
        let mut block = ControlBlocks::parse(call.blocks).unwrap().block.done();
        change(&mut block);
        Reaction::Blocks(ControlBlocks::from(block).to_vec())
    });
    let outcome = rig.ask(ControllerRequest::Release);
    let ControllerOutcome::Ended(ArReleaseOutcome::Released(ControlOutcome::Failed(CallError::Unfit(text)))) = outcome
    else {
        panic!("{outcome:?}")
    };
    assert!(text.starts_with(why), "{text}");
}

#[test]
fn a_release_without_answer_ends_the_ar_too() {
    let mut rig = ControllerRig::standing();
    rig.device.hook = Box::new(|_| Reaction::Silence);
    let ControllerOutcome::Ended(ArReleaseOutcome::Released(ControlOutcome::Failed(CallError::NoAnswer(wait)))) =
        rig.ask(ControllerRequest::Release)
    else {
        panic!("another outcome")
    };
    assert_eq!((wait.what, rig.controller.state()), (AwaitedEvent::Release, ArState::None));
}

#[test]
fn an_abort_sends_its_code_and_interrupts_the_running_request() {
    let mut rig = ControllerRig::standing();
    rig.device.hook = Box::new(|_| Reaction::Silence);
    rig.controller.request(rig.now, parameter(&[1, 1])).unwrap();
    rig.run(Duration::from_millis(10));
    assert_eq!(
        rig.ask(ControllerRequest::Abort { code: AbortReason::ABORT_REQUEST }),
        ControllerOutcome::Ended(ArReleaseOutcome::Aborted)
    );
    rig.run(Duration::from_millis(1));
    let [(_, pdu)] = rig.device.rta.as_slice() else { panic!("{:?}", rig.device.rta) };
    let status = PnioStatus::abort(AbortReason::ABORT_REQUEST);
    assert_eq!(pdu.body, RtaBody::Error { status, more: vec![] });
    assert!(!rig.controller.is_busy());
}

#[test]
fn dcp_services_return_the_values_of_the_device() {
    let mut rig = ControllerRig::new();
    let wait = Duration::from_millis(500);
    let ControllerOutcome::Stations(stations) = rig.ask(ControllerRequest::Identify { by: IdentifyBy::All, wait })
    else {
        panic!()
    };
    let [station] = stations.as_slice() else { panic!("{stations:?}") };
    assert_eq!((station.name.as_slice(), station.station_type.as_slice()), (NAME.as_bytes(), &b"Encoder"[..]));
    assert_eq!((station.mac, station.role), (DEVICE, Some(1)));
    let none = rig.ask(ControllerRequest::Identify { by: IdentifyBy::Name(b"unknown".to_vec()), wait });
    assert_eq!(none, ControllerOutcome::Stations(vec![]));
    let set =
        |value| ControllerRequest::DcpSet { to: DEVICE, blocks: vec![DcpBlock::set(BlockQualifier::PERMANENT, value)] };
    assert_eq!(rig.ask(set(DcpValue::NameOfStation(b"other".to_vec()))), ControllerOutcome::Dcp(DcpOutcome::Accepted));
    rig.device.set_ip_error = BlockError::IN_OPERATION;
    let refused = DcpOutcome::Refused(vec![(Element::IP_PARAMETER, BlockError::IN_OPERATION)]);
    assert_eq!(rig.ask(set(DcpValue::IpParameter(ip()))), ControllerOutcome::Dcp(refused));
    let get = ControllerRequest::DcpGet { to: DEVICE, elements: vec![Element::NAME_OF_STATION] };
    let ControllerOutcome::Dcp(DcpOutcome::Values(values)) = rig.ask(get) else { panic!() };
    assert_eq!(values[0].value, DcpValue::NameOfStation(b"other".to_vec()));
    assert_eq!(rig.ask(ControllerRequest::DcpSignal { to: DEVICE }), ControllerOutcome::Dcp(DcpOutcome::Accepted));
    let absent = Mac([2, 9, 9, 9, 9, 9]);
    let wait = Wait { what: AwaitedEvent::StationSet, time: Duration::from_secs(3) };
    assert_eq!(
        rig.ask(ControllerRequest::DcpSignal { to: absent }),
        ControllerOutcome::Dcp(DcpOutcome::NoAnswer(wait))
    );
}

/// Every station that claims the address is listed, and a probe has no sender address.
#[rstest]
#[case(false, [192, 168, 0, 77], &[DEVICE])]
#[case(true, [192, 168, 0, 77], &[DEVICE])]
#[case(true, [192, 168, 0, 78], &[])]
fn an_arp_request_collects_the_owners_of_an_address(
    #[case] probe: bool,
    #[case] target: [u8; 4],
    #[case] owners: &[Mac],
) {
    let mut rig = ControllerRig::new();
    rig.device.ip.address = [192, 168, 0, 77].into();
    let wait = Duration::from_millis(500);
    assert_eq!(
        rig.ask(ControllerRequest::Arp { target: target.into(), probe, wait }),
        ControllerOutcome::Owners(owners.to_vec())
    );
    let (_, frame) = rig.sent().next().unwrap();
    let sent = Arp::parse(FrameHeader::parse(frame).unwrap().1).unwrap();
    assert_eq!((sent.sender_ip.is_unspecified(), sent.target_mac), (probe, Mac::ZERO));
}

#[rstest]
#[case::factory(DcpResetForm::Factory, DcpValue::FactoryReset, 0)]
#[case::to_factory(DcpResetForm::ToFactory { qualifier: 4 }, DcpValue::ResetToFactory, 4)]
fn both_forms_of_reset_are_sent(#[case] reset: DcpResetForm, #[case] value: DcpValue, #[case] qualifier: u16) {
    let mut rig = ControllerRig::new();
    assert_eq!(
        rig.ask(ControllerRequest::DcpReset { to: DEVICE, reset }),
        ControllerOutcome::Dcp(DcpOutcome::Accepted)
    );
    let (_, frame) = rig.sent().next().unwrap();
    let dcp = Dcp::parse(FrameHeader::parse(frame).unwrap().1).unwrap();
    assert_eq!(dcp.blocks(), [DcpBlock { word: Some(qualifier), value }]);
}
