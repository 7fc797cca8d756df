//! A whole start-up against a conforming device, then with one error at a time.
#![allow(clippy::unwrap_used, reason = "a test that unwraps nothing has failed")]

use crate::common::*;
use core::time::Duration;
use encspec_controllers::profinet_io::*;
use rstest::rstest;
use wire::datagram::arp::Arp;
use wire::ethernet::{EtherType, FrameHeader, Mac, Vlan};
use wire::octets::ByteOrder;
use wire::profinet::blocks::connect::{ArProperties, ArType, Connect};
use wire::profinet::blocks::module_diff::{
    ApiDiff, ArInfo, IdentInfo, ModuleDiff, ModuleDiffBlock, ModuleState, SubmoduleDiff, SubmoduleState,
};
use wire::profinet::dcp::{BlockError, BlockQualifier, Dcp, DcpValue, ServiceId};
use wire::profinet::rpc::{Flags1, NdrRequest, NdrResponse, Opnum, PacketType, RejectStatus, RpcHeader, RpcPdu};
use wire::profinet::rt::{Instance, IoxS};
use wire::profinet::status::{AbortReason, CmrpcError, ErrorCode, ErrorSource, PnioStatus, RecordError};

const OUT_OF_RESOURCES: PnioStatus =
    PnioStatus::found(ErrorCode::CONNECT_RESPONSE, ErrorSource::CMRPC, CmrpcError::OUT_OF_AR_RESOURCES.0);

#[test]
fn an_ar_starts_up_stage_by_stage() {
    let mut rig = ControllerRig::new();
    let result = rig.start(connection());
    assert_eq!(result.failed, None);
    assert_eq!(result.identify.as_ref().map(|station| (station.mac, station.id)), Some((DEVICE, Some((0x012A, 7)))));
    assert_eq!(result.address_set, Some(true));
    assert_eq!(result.connect, Some(ConnectOutcome::Accepted));
    assert_eq!(result.records, [IoRecordOutcome::Accepted { data: vec![] }]);
    assert_eq!(result.parameter_end, Some(ControlOutcome::Accepted));
    assert_eq!((result.application_ready, result.first_data, result.standing), (Some(true), Some(true), true));
    assert_eq!(rig.device.calls, [Opnum::CONNECT, Opnum::WRITE, Opnum::CONTROL]);
    assert_eq!(rig.device.ready_answered, Some(PnioStatus::OK));
    assert_eq!(rig.controller.state(), ArState::Data);
    assert_eq!(rig.controller.partner(), Some(Partner { mac: DEVICE, ip: DEVICE_IP }));
}

#[test]
fn a_lost_ar_reconnects_in_the_same_tick_with_the_same_uuid() {
    let again = Some(Reconnect { after: Duration::ZERO });
    let mut rig = ControllerRig::new();
    assert!(rig.start(ArConfig { reconnect: again, same_uuid: true, ..connection() }).standing);
    let opened = |rig: &ControllerRig| rig.device.ar.as_ref().map(|ar| ar.uuid);
    let first = opened(&rig);
    rig.device.cyclic = false;
    while rig.controller.take_end().is_none() {
        let until = rig.now + Duration::from_secs(1);
        assert!(rig.step(until), "the AR is lost");
    }
    assert!(rig.controller.is_busy(), "it reconnects in the tick of the loss");
    rig.device.cyclic = true;
    rig.run(Duration::from_secs(2));
    assert_eq!((rig.controller.state(), opened(&rig)), (ArState::Data, first));
    assert!(matches!(rig.controller.take_outcome(), Some(ControllerOutcome::StartUp(result)) if result.standing));
    rig.ask(ControllerRequest::Release);
    rig.run(Duration::from_secs(2));
    assert_eq!(rig.controller.state(), ArState::None, "no reconnect after a release");
}

#[test]
fn the_address_is_set_temporarily_and_only_if_it_differs() {
    let mut rig = ControllerRig::standing();
    let sets = |rig: &ControllerRig| -> Vec<Dcp> {
        let payload = |frame: &[u8]| Dcp::parse(FrameHeader::parse(frame).unwrap().1).ok();
        rig.sent().filter_map(|(_, frame)| payload(frame)).filter(|dcp| dcp.service_id == ServiceId::SET).collect()
    };
    let [set] = sets(&rig).try_into().unwrap();
    assert_eq!(set.blocks()[0].value, DcpValue::IpParameter(ip()));
    assert_eq!(set.blocks()[0].qualifier(), BlockQualifier::TEMPORARY);
    assert_eq!(
        rig.ask(ControllerRequest::Release),
        ControllerOutcome::Ended(ArReleaseOutcome::Released(ControlOutcome::Accepted))
    );
    let result = rig.start(connection());
    assert_eq!((result.address_set, result.standing), (Some(false), true));
    assert_eq!(sets(&rig).len(), 1);
}

#[test]
fn a_device_with_a_known_mac_address_is_called_directly() {
    let mut rig = ControllerRig::new();
    rig.device.name.clear();
    let result = rig.start(ArConfig { device: DeviceAddress::Mac(DEVICE), ..connection() });
    assert!(result.standing, "{result:?}");
    let to_all = |frame: &[u8]| FrameHeader::parse(frame).unwrap().0.destination == Mac::DCP_MULTICAST;
    assert!(!rig.sent().any(|(_, frame)| to_all(frame)));
}

/// With `gives_address: false` the device is called at its own address, or at the intended one if it has none.
#[test]
fn a_device_that_keeps_its_address() {
    let mut rig = ControllerRig::new();
    let own = wire::profinet::dcp::block::IpParameter { address: [192, 168, 0, 77].into(), ..ip() };
    rig.device.ip = own;
    let none = || ArConfig { gives_address: false, ..connection() };
    let result = rig.start(none());
    assert_eq!(result.address_set, None);
    assert_eq!((rig.device.ip, result.partner.map(|partner| partner.ip)), (own, Some(own.address)));
    let mut rig = ControllerRig::new();
    let result = rig.start(none());
    assert_eq!((result.address_set, result.partner), (None, Some(Partner { mac: DEVICE, ip: ip().address })));
    assert!(rig.device.ip.address.is_unspecified());
    let arp = |frame: &[u8]| FrameHeader::parse(frame).is_ok_and(|(header, _)| header.ether_type == EtherType::ARP);
    assert!(!rig.sent().any(|(_, frame)| arp(frame)), "no address to probe");
}

#[test]
fn a_device_that_appears_late_is_found() {
    let mut rig = ControllerRig::new();
    rig.device.name = b"another".to_vec();
    rig.controller.request(rig.now, ControllerRequest::Connect(Box::new(connection()))).unwrap();
    rig.run(Duration::from_secs(3));
    assert_eq!(rig.controller.state(), ArState::Starting(ArStartUpStage::Identify));
    rig.device.name = NAME.into();
    rig.run(Duration::from_secs(2));
    assert_eq!(rig.controller.state(), ArState::Data);
}

/// The error of the device, the stage in which the start-up ends, and the message.
#[rstest]
#[case::no_device(|d: &mut ScriptedDevice| d.name = b"x".to_vec(), ArStartUpStage::Identify, "an answer to DCP Identify did not come within 5s")]
#[case::no_set(|d: &mut ScriptedDevice| d.set_ip_error = BlockError::LOCAL_REASONS, ArStartUpStage::Address,
    "the device refused its address: local_reasons (5)")]
#[case::no_connect(|d: &mut ScriptedDevice| d.hook = silent(Opnum::CONNECT), ArStartUpStage::Connect,
    "the answer to Connect did not come within 4s")]
#[case::refused(|d: &mut ScriptedDevice| d.hook = refusing(Opnum::CONNECT, PnioStatus::found(ErrorCode::CONNECT_RESPONSE, ErrorSource::AR_BLOCK, 4)),
    ArStartUpStage::Connect, "refused: connect_response: faulty_ar_block in ARType (db 81 01 04)")]
#[case::no_write(|d: &mut ScriptedDevice| d.hook = silent(Opnum::WRITE), ArStartUpStage::Records, "the answer to Write did not come within 4s")]
#[case::no_end(|d: &mut ScriptedDevice| d.hook = silent(Opnum::CONTROL), ArStartUpStage::ParameterEnd,
    "the answer to PrmEnd did not come within 4s")]
#[case::no_ready(|d: &mut ScriptedDevice| d.sends_ready = false, ArStartUpStage::ApplicationReady,
    "ApplicationReady did not come within 10s")]
#[case::bad_data(|d: &mut ScriptedDevice| d.iops = IoxS::BAD, ArStartUpStage::FirstData,
    "the first good cyclic data did not come within 3s")]
#[case::no_data(|d: &mut ScriptedDevice| d.cyclic = false, ArStartUpStage::FirstData, "the next cyclic frame did not come within 20ms")]
fn a_failed_start_up_reports_its_stage_and_the_wait(
    #[case] spoil: fn(&mut ScriptedDevice),
    #[case] stage: ArStartUpStage,
    #[case] why: &str,
) {
    let mut rig = ControllerRig::new();
    spoil(&mut rig.device);
    let result = rig.start(connection());
    let failure = result.failed.unwrap();
    assert_eq!(failure.stage, stage);
    assert_eq!(failure.why.to_string(), why);
    let bad_but_alive = matches!(failure.why, ArFailureReason::Waited(Wait { what: AwaitedEvent::FirstData, .. }));
    assert_eq!(result.standing, bad_but_alive);
    assert_eq!(rig.controller.state(), if bad_but_alive { ArState::Data } else { ArState::None });
    assert_eq!(rig.controller.take_end(), None, "the outcome of a start-up reports its end");
}

fn silent(opnum: Opnum) -> Box<dyn FnMut(&ReceivedCall) -> Reaction> {
    Box::new(move |call| if call.header.opnum == opnum { Reaction::Silence } else { Reaction::Usual })
}

fn refusing(opnum: Opnum, status: PnioStatus) -> Box<dyn FnMut(&ReceivedCall) -> Reaction> {
    Box::new(move |call| if call.header.opnum == opnum { Reaction::Refuse(status) } else { Reaction::Usual })
}

#[test]
fn a_failed_start_up_aborts_the_ar() {
    let mut rig = ControllerRig::new();
    rig.device.sends_ready = false;
    rig.start(connection());
    rig.run(Duration::from_millis(1));
    let [(_, pdu)] = rig.device.rta.as_slice() else { panic!("{:?}", rig.device.rta) };
    let wire::profinet::alarm::RtaBody::Error { status, .. } = &pdu.body else { panic!("{pdu:?}") };
    assert_eq!(*status, PnioStatus::abort(AbortReason::APPLICATION_READY_TIMEOUT));
    assert_eq!((pdu.header.dst_endpoint, pdu.header.src_endpoint), (ALARM_REFERENCE, 1));
}

#[rstest]
#[case::once(1, 1, true)]
#[case::always(99, 5, false)]
fn connect_is_repeated_when_the_device_is_out_of_ar_resources(
    #[case] refusals: usize,
    #[case] repeats: u8,
    #[case] standing: bool,
) {
    let mut rig = ControllerRig::new();
    rig.device.hook = Box::new(move |call| match call.header.opnum {
        Opnum::CONNECT if call.before < refusals => Reaction::Refuse(OUT_OF_RESOURCES),
        _ => Reaction::Usual,
    });
    let result = rig.start(connection());
    assert_eq!((result.connect_repeats, result.standing), (repeats, standing));
    let last = if standing { ConnectOutcome::Accepted } else { ConnectOutcome::Refused(OUT_OF_RESOURCES) };
    assert_eq!(result.connect, Some(last));
}

#[test]
fn connect_is_asked_once_where_the_refusal_is_the_answer() {
    let mut rig = ControllerRig::new();
    rig.device.hook = Box::new(|call| match call.header.opnum {
        Opnum::CONNECT => Reaction::Refuse(OUT_OF_RESOURCES),
        _ => Reaction::Usual,
    });
    let result = rig.start(ArConfig { repeats: false, ..connection() });
    assert_eq!((result.connect_repeats, result.connect), (0, Some(ConnectOutcome::Refused(OUT_OF_RESOURCES))));
}

#[test]
fn a_lost_request_is_repeated_with_its_sequence_number() {
    let mut rig = ControllerRig::new();
    rig.device.hook = Box::new(|call| if call.before == 0 { Reaction::Silence } else { Reaction::Usual });
    let result = rig.start(connection());
    assert!(result.standing, "{result:?}");
    let of = |opnum| -> Vec<_> {
        let all = rig.sent_pdus().into_iter();
        all.filter(|(_, h)| h.packet_type == PacketType::REQUEST && h.opnum == opnum).collect()
    };
    for (opnum, number) in [(Opnum::CONNECT, 0), (Opnum::WRITE, 1), (Opnum::CONTROL, 2)] {
        let [(first, one), (second, two)] = of(opnum).try_into().unwrap();
        assert_eq!(one, two, "the repetition is the same PDU");
        assert_eq!((one.sequence, second.since(first)), (number, Duration::from_secs(1)));
    }
}

/// Invalid answers: from another activity, another call, another source, or of a kind that answers nothing.
#[rstest]
#[case::other_activity(|h: &mut RpcHeader| h.activity.0[3] ^= 1)]
#[case::other_sequence(|h: &mut RpcHeader| h.sequence += 1)]
#[case::request(|h: &mut RpcHeader| h.packet_type = PacketType::REQUEST)]
#[case::ack(|h: &mut RpcHeader| h.packet_type = PacketType::ACK)]
fn an_answer_to_another_call_is_ignored(#[case] change: fn(&mut RpcHeader)) {
    let mut rig = ControllerRig::new();
    rig.device.hook = Box::new(move |call| {
        let body = NdrResponse::body(ByteOrder::Big, OUT_OF_RESOURCES, 4096, &[]);
        let mut header = call.header.answer(PacketType::RESPONSE, ByteOrder::Big);
        change(&mut header);
        Reaction::Instead(vec![RpcPdu::new(header, &body).to_vec()])
    });
    let result = rig.start(connection());
    assert_eq!(result.failed.unwrap().why.to_string(), "the answer to Connect did not come within 4s");
}

/// The first fragment of an answer comes again after each repetition, and the last never comes.
#[test]
fn a_fragment_that_is_known_already_does_not_prolong_a_call() {
    let mut rig = ControllerRig::new();
    rig.device.hook = Box::new(|call| {
        let answer = call.header.answer(PacketType::RESPONSE, ByteOrder::Big);
        let header = RpcHeader { flags1: Flags1::FRAGMENT | Flags1::NO_FACK, ..answer };
        Reaction::Instead(vec![RpcPdu::new(header, &[0; 40]).to_vec()])
    });
    let began = rig.now;
    let result = rig.start(connection());
    assert!(result.failed.unwrap().why.to_string().starts_with("the answer to Connect did not come within 4"));
    assert!(rig.now.since(began) < Duration::from_secs(8), "it took {:?}", rig.now.since(began));
}

#[rstest]
#[case::reject(PacketType::REJECT, CallError::Rejected(RejectStatus::UNKNOWN_INTERFACE))]
#[case::fault(PacketType::FAULT, CallError::Faulted(RejectStatus::UNKNOWN_INTERFACE))]
fn reject_and_fault_are_reported(#[case] kind: PacketType, #[case] error: CallError) {
    let mut rig = ControllerRig::new();
    rig.device.hook = Box::new(move |call| {
        let mut body = Vec::new();
        RejectStatus::UNKNOWN_INTERFACE.write(&mut body, ByteOrder::Little);
        Reaction::Instead(vec![RpcPdu::new(call.header.answer(kind, ByteOrder::Little), &body).to_vec()])
    });
    assert_eq!(rig.start(connection()).connect, Some(ConnectOutcome::Failed(error)));
}

#[test]
fn a_working_server_is_pinged_and_called_again_if_it_lost_the_call() {
    let mut rig = ControllerRig::new();
    rig.device.hook = Box::new(|call| match call.before {
        0 => {
            Reaction::Instead(vec![RpcPdu::new(call.header.answer(PacketType::WORKING, ByteOrder::Big), &[]).to_vec()])
        }
        _ => Reaction::Usual,
    });
    rig.controller
        .request(rig.now, ControllerRequest::Connect(Box::new(ArConfig { records: vec![], ..connection() })))
        .unwrap();
    rig.run(Duration::from_millis(1900));
    let (_, ping) = rig.sent_pdus().into_iter().find(|(_, header)| header.packet_type == PacketType::PING).unwrap();
    assert_eq!((ping.sequence, rig.device.calls.len()), (0, 1));
    let nocall = RpcPdu::new(ping.answer(PacketType::NOCALL, ByteOrder::Big), &[]).to_vec();
    rig.let_device(|device, out| device.send_pdu(&nocall, 49_152, out));
    rig.run(Duration::from_millis(100));
    assert_eq!(&rig.device.calls[..2], [Opnum::CONNECT, Opnum::CONNECT]);
}

#[rstest]
#[case::other_ar(|ar: &mut wire::profinet::blocks::connect::ArBlockRes| ar.ar_uuid.0[0] ^= 1, "ARBlockRes is about AR")]
#[case::other_session(|ar: &mut wire::profinet::blocks::connect::ArBlockRes| ar.session_key += 1, "ARBlockRes is about AR")]
#[case::other_type(|ar: &mut wire::profinet::blocks::connect::ArBlockRes| ar.ar_type = ArType::IOSAR, "ARType is 0x0006")]
#[case::other_mac(|ar: &mut wire::profinet::blocks::connect::ArBlockRes| ar.cm_responder_mac_add = OWN, "CMResponderMacAdd is")]
fn a_connect_response_must_fit(
    #[case] change: fn(&mut wire::profinet::blocks::connect::ArBlockRes),
    #[case] why: &str,
) {
    use wire::profinet::blocks::connect::ConnectContent;
    let mut rig = ControllerRig::new();
    rig.device.hook = Box::new(move |call| {
        let blocks = ScriptedDevice::new().carry_out(Opnum::CONNECT, call.blocks);
        let mut answer = Connect::parse(&blocks).unwrap();
        if let ConnectContent::ArRes(ar) = &mut answer.blocks[0].content {
            change(ar);
        }
        Reaction::Blocks(answer.to_vec())
    });
    let result = rig.start(connection());
    assert!(!result.standing);
    let Some(ConnectOutcome::Failed(CallError::Unfit(text))) = result.connect else { panic!("{result:?}") };
    assert!(text.starts_with(why), "{text}");
}

/// A Connect request returned as a response has no ARBlockRes.
#[test]
fn a_reflected_request_is_not_a_response() {
    let mut rig = ControllerRig::new();
    rig.device.hook = Box::new(|call| Reaction::Blocks(call.blocks.to_vec()));
    let result = rig.start(connection());
    let error = CallError::Unfit("there is no ARBlockRes".into());
    assert_eq!((result.connect, result.standing), (Some(ConnectOutcome::Failed(error)), false));
}

#[test]
fn a_refused_record_does_not_end_the_start_up() {
    let mut rig = ControllerRig::new();
    let status = PnioStatus::record(ErrorCode::WRITE_RESPONSE, RecordError::INVALID_RANGE);
    rig.device.hook = refusing(Opnum::WRITE, status);
    let result = rig.start(connection());
    assert_eq!(result.records, [IoRecordOutcome::Refused(status)]);
    assert!(result.standing);
}

#[test]
fn records_are_written_in_one_call_if_configured() {
    let mut rig = ControllerRig::new();
    let mut connection = ArConfig { write_multiple: true, ..connection() };
    connection.records.push(StartUpRecord { target: RecordAddress { index: 0xBF01, ..PARAMETERS }, data: vec![9] });
    let result = rig.start(connection);
    assert_eq!(result.records, vec![IoRecordOutcome::Accepted { data: vec![] }; 2]);
    assert_eq!(rig.device.calls, [Opnum::CONNECT, Opnum::WRITE, Opnum::CONTROL]);
}

#[test]
fn an_abort_in_the_middle_of_a_call_ends_the_start_up() {
    let mut rig = ControllerRig::new();
    rig.device.hook = silent(Opnum::CONTROL);
    rig.controller.request(rig.now, ControllerRequest::Connect(Box::new(connection()))).unwrap();
    while rig.controller.state() != ArState::Starting(ArStartUpStage::ParameterEnd) {
        assert!(rig.step(rig.now + Duration::from_secs(1)));
    }
    rig.let_device(|device, out| device.abort(AbortReason::CMI_TIMEOUT, out));
    rig.run(Duration::from_millis(1));
    let Some(ControllerOutcome::StartUp(result)) = rig.controller.take_outcome() else { panic!("no outcome") };
    let end = ArEnd::Aborted(PnioStatus::abort(AbortReason::CMI_TIMEOUT));
    assert_eq!(
        result.failed,
        Some(ArStartUpFailure { stage: ArStartUpStage::ParameterEnd, why: ArFailureReason::Ended(end) })
    );
}

#[test]
fn two_stations_with_one_name_are_reported() {
    let mut rig = ControllerRig::new();
    rig.controller.request(rig.now, ControllerRequest::Connect(Box::new(connection()))).unwrap();
    rig.run(Duration::from_millis(1));
    let (_, _, answer) = rig.log.iter().find(|(_, ours, frame)| !ours && frame[14..16] == [0xFE, 0xFF]).unwrap();
    let mut forged = answer.clone();
    forged[11] ^= 0x77;
    let mut out = station::Outbox::new();
    out.push(&forged);
    rig.launch(false, &out);
    rig.run(Duration::from_millis(100));
    let Some(ControllerOutcome::StartUp(result)) = rig.controller.take_outcome() else { panic!("no outcome") };
    let ArFailureReason::SameName(stations) = result.failed.unwrap().why else { panic!("another failure") };
    assert_eq!(stations, [DEVICE, Mac([2, 0, 0, 0, 1, 0x77])]);
}

#[test]
fn an_address_that_another_station_has_is_not_given() {
    let mut rig = ControllerRig::new();
    rig.controller.request(rig.now, ControllerRequest::Connect(Box::new(connection()))).unwrap();
    while rig.controller.state() != ArState::Starting(ArStartUpStage::Address) {
        assert!(rig.step(rig.now + Duration::from_secs(1)));
    }
    let other = Mac([2, 0, 0, 0, 9, 9]);
    let mut out = station::Outbox::new();
    out.push_with(|octets| Arp::request(OWN, OWN_IP, DEVICE_IP).reply(other).write_frame(octets));
    rig.launch(false, &out);
    rig.run(Duration::from_millis(1));
    let Some(ControllerOutcome::StartUp(result)) = rig.controller.take_outcome() else { panic!("no outcome") };
    assert_eq!(result.failed.unwrap().why, ArFailureReason::SameAddress(other));
}

#[test]
fn device_access_opens_an_ar_without_data() {
    let mut rig = ControllerRig::new();
    let connection = ArConfig { device_access: true, ar_type: ArType::IOSAR, submodules: vec![], ..connection() };
    let mut response = None;
    let result = rig.start(connection);
    for (_, frame) in rig.sent() {
        if let Ok(datagram) = wire::datagram::Datagram::parse(frame) {
            let pdu = RpcPdu::parse(datagram.payload).unwrap();
            let (_, blocks) = NdrRequest::parse(ByteOrder::Big, pdu.body).unwrap();
            response = Some(Connect::parse(blocks).unwrap());
        }
    }
    assert!(result.standing && result.first_data.is_none(), "{result:?}");
    let connect = response.unwrap();
    assert_eq!(connect.blocks.len(), 1);
    assert!(connect.ar_req().unwrap().ar_properties.has(ArProperties::DEVICE_ACCESS));
    rig.run(Duration::from_secs(1));
    assert_eq!((rig.controller.state(), rig.controller.cycles_sent()), (ArState::Data, 0));
}

/// The owner of a submodule parametrizes it; a record of a submodule without a difference is written.
#[rstest]
#[case::of_another(1, ArInfo::LOCKED_BY_CONTROLLER, &[Opnum::CONNECT, Opnum::CONTROL])]
#[case::of_a_supervisor(1, ArInfo::LOCKED_BY_SUPERVISOR, &[Opnum::CONNECT, Opnum::CONTROL])]
#[case::own(1, ArInfo::OWN, &[Opnum::CONNECT, Opnum::WRITE, Opnum::CONTROL])]
#[case::another_submodule(2, ArInfo::LOCKED_BY_CONTROLLER, &[Opnum::CONNECT, Opnum::WRITE, Opnum::CONTROL])]
fn records_of_a_locked_submodule_are_not_written(#[case] subslot: u16, #[case] owner: ArInfo, #[case] calls: &[Opnum]) {
    let mut rig = ControllerRig::new();
    let state = SubmoduleState::new(IdentInfo::OK, owner, 0);
    let submodules = vec![SubmoduleDiff { subslot, submodule_ident: 2, state }];
    let module = ModuleDiff { slot: 1, module_ident: 0x22, state: ModuleState::PROPER_MODULE, submodules };
    let diff = ModuleDiffBlock { apis: vec![ApiDiff { api: 0x3D00, modules: vec![module] }] };
    rig.device.hook = Box::new(move |call| match call.header.opnum {
        Opnum::CONNECT => {
            let mut blocks = ScriptedDevice::new().carry_out(Opnum::CONNECT, call.blocks);
            diff.write(&mut blocks);
            Reaction::Blocks(blocks)
        }
        _ => Reaction::Usual,
    });
    rig.start(connection());
    assert_eq!(rig.device.calls, calls);
}

/// A submodule that the device reports as wrong is not awaited, whether Connect or ApplicationReady reports it.
#[test]
fn valid_data_of_a_wrong_submodule_are_not_awaited() {
    let mut rig = ControllerRig::new();
    rig.device.iops = IoxS::BAD;
    let state = SubmoduleState::new(IdentInfo::WRONG, ArInfo::OWN, 0);
    let submodules = vec![SubmoduleDiff { subslot: 2, submodule_ident: 82, state }];
    let module = ModuleDiff { slot: 1, module_ident: 0x22, state: ModuleState::PROPER_MODULE, submodules };
    let diff = ModuleDiffBlock { apis: vec![ApiDiff { api: 0x3D00, modules: vec![module] }] };
    let reported = diff.clone();
    rig.device.hook = Box::new(move |call| match call.header.opnum {
        Opnum::CONNECT => {
            let mut blocks = ScriptedDevice::new().carry_out(Opnum::CONNECT, call.blocks);
            reported.write(&mut blocks);
            Reaction::Blocks(blocks)
        }
        _ => Reaction::Usual,
    });
    let result = rig.start(connection());
    assert_eq!((result.module_diff, result.first_data), (Some(diff), Some(true)));
}

#[test]
fn cyclic_frames_begin_with_the_connect_response_and_become_valid_with_application_ready() {
    let mut rig = ControllerRig::new();
    rig.device.sends_ready = false;
    rig.controller.request(rig.now, ControllerRequest::Connect(Box::new(connection()))).unwrap();
    rig.run(Duration::from_secs(1));
    assert_eq!(rig.controller.state(), ArState::Starting(ArStartUpStage::ApplicationReady));
    let bad = IoxS::bad(Instance::Controller).0;
    let frame = rig.device.outputs.last().unwrap();
    assert_eq!(frame[..2], OUTPUT_FRAME_ID.to_be_bytes());
    // Four bytes of data, their IOPS, five IOCS; after 40 bytes of data the cycle counter, the data status, the transfer status.
    assert_eq!((&frame[6..12], frame.len()), (&[bad; 6][..], 46));
    assert_eq!(frame[44..], [0x35, 0]);
    rig.let_device(|device, out| device.application_ready(out));
    rig.run(Duration::from_millis(10));
    assert_eq!(rig.controller.state(), ArState::Data);
    assert_eq!(rig.device.outputs.last().unwrap()[6..12], [0x80; 6]);
    let tagged = |frame: &[u8]| {
        let (header, _) = FrameHeader::parse(frame).unwrap();
        header.ether_type != EtherType::PROFINET || header.tag == Some(Vlan::RT) || frame[14] == 0xFE
    };
    assert!(rig.sent().all(|(_, frame)| tagged(frame)));
}

#[test]
fn a_second_request_is_refused_until_the_first_has_ended() {
    let mut rig = ControllerRig::new();
    let connect = || ControllerRequest::Connect(Box::new(connection()));
    rig.controller.request(rig.now, connect()).unwrap();
    assert_eq!(rig.controller.request(rig.now, connect()), Err(ControllerBusy));
    rig.run(Duration::from_secs(1));
    assert_eq!(rig.controller.state(), ArState::Data);
    assert_eq!(rig.ask(connect()), ControllerOutcome::Impossible("an AR stands already"));
}
