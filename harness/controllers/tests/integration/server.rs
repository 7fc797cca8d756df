//! Calls of the device to the controller: ApplicationReady in all forms, and invalid calls.
#![allow(clippy::unwrap_used, reason = "a test that unwraps nothing has failed")]

use crate::common::*;
use core::time::Duration;
use encspec_controllers::profinet_io::*;
use rstest::rstest;
use wire::octets::ByteOrder;
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::control::{ControlBlock, ControlBlocks, ControlCommand};
use wire::profinet::rpc::{
    Flags1, NdrRequest, NdrResponse, PacketType, RejectStatus, RpcHeader, RpcPdu, Uuid, fragments,
};
use wire::profinet::status::{CmrpcError, ErrorCode, ErrorSource, PnioStatus};

/// A start-up that waits for ApplicationReady, and the block that the device must send.
fn waiting() -> (ControllerRig, ControlBlock) {
    let mut rig = ControllerRig::new();
    rig.device.sends_ready = false;
    rig.controller.request(rig.now, ControllerRequest::Connect(Box::new(connection()))).unwrap();
    while rig.controller.state() != ArState::Starting(ArStartUpStage::ApplicationReady) {
        assert!(rig.step(rig.now + Duration::from_secs(1)));
    }
    rig.device.replies.clear();
    let ar = rig.device.ar.as_ref().unwrap();
    let block = ControlBlock::application_ready(ar.uuid, ar.session_key);
    (rig, block)
}

/// Sends a call of the device and returns the answer.
fn call(rig: &mut ControllerRig, sequence: u32, block: ControlBlock, order: ByteOrder) -> (RpcHeader, Vec<u8>) {
    rig.let_device(|device, out| device.call(sequence, &ControlBlocks::from(block).to_vec(), order, out));
    rig.run(Duration::from_millis(5));
    let [reply]: [_; 1] = core::mem::take(&mut rig.device.replies).try_into().unwrap();
    reply
}

#[rstest]
#[case::big(ByteOrder::Big)]
#[case::little(ByteOrder::Little)]
fn application_ready_is_answered_in_its_own_byte_order(#[case] order: ByteOrder) {
    let (mut rig, block) = waiting();
    let (header, body) = call(&mut rig, 5, block, order);
    assert_eq!((header.packet_type, header.order(), header.sequence), (PacketType::RESPONSE, order, 5));
    let (ndr, blocks) = NdrResponse::parse(order, &body).unwrap();
    let answer = ControlBlocks::parse(blocks).unwrap().block;
    assert_eq!((ndr.status, answer.header.kind), (PnioStatus::OK, BlockType::APPLICATION_READY_RES));
    assert_eq!((answer.ar_uuid, answer.control_command), (block.ar_uuid, ControlCommand::DONE));
    assert_eq!(rig.controller.state(), ArState::Data);
}

#[test]
fn a_repeated_call_gets_the_same_answer_and_a_ping_too() {
    let (mut rig, block) = waiting();
    let first = call(&mut rig, 5, block, ByteOrder::Big);
    assert_eq!(call(&mut rig, 5, block, ByteOrder::Big), first);
    for (sequence, expected) in [(5, PacketType::RESPONSE), (6, PacketType::NOCALL)] {
        let header = RpcHeader { packet_type: PacketType::PING, ..call_header(sequence, ByteOrder::Big) };
        rig.let_device(|device, out| device.send_call(&RpcPdu::new(header, &[]).to_vec(), out));
        rig.run(Duration::from_millis(1));
        let [(reply, _)]: [_; 1] = core::mem::take(&mut rig.device.replies).try_into().unwrap();
        assert_eq!((reply.packet_type, reply.sequence), (expected, sequence));
    }
    assert_eq!(rig.controller.state(), ArState::Data);
}

#[test]
fn application_ready_may_come_in_fragments() {
    let (mut rig, block) = waiting();
    let body = NdrRequest::body(ByteOrder::Big, 4096, &ControlBlocks::from(block).to_vec());
    let pdus = fragments(&call_header(1, ByteOrder::Big), &body, 24);
    for pdu in &pdus {
        assert_eq!(rig.controller.state(), ArState::Starting(ArStartUpStage::ApplicationReady));
        rig.let_device(|device, out| device.send_call(pdu, out));
        rig.run(Duration::from_millis(5));
    }
    assert_eq!(rig.controller.state(), ArState::Data);
    let kinds: Vec<_> = rig.device.replies.iter().map(|(header, _)| (header.packet_type, header.fragment)).collect();
    assert_eq!(kinds, [(PacketType::FACK, 0), (PacketType::FACK, 1), (PacketType::RESPONSE, 0)]);
    assert_eq!(pdus.len(), 3);
}

#[rstest]
#[case::another_ar(|block: &mut ControlBlock| block.ar_uuid.0[5] ^= 1, CmrpcError::AR_UUID_UNKNOWN)]
#[case::another_session(|block: &mut ControlBlock| block.session_key += 1, CmrpcError::AR_UUID_UNKNOWN)]
#[case::another_command(|block: &mut ControlBlock| block.control_command = ControlCommand(0), CmrpcError::UNKNOWN_BLOCKS)]
#[case::another_block(|block: &mut ControlBlock| block.header.kind = BlockType::PRM_END_REQ, CmrpcError::UNKNOWN_BLOCKS)]
fn a_call_that_is_not_application_ready_of_this_ar_is_refused(
    #[case] change: fn(&mut ControlBlock),
    #[case] error: CmrpcError,
) {
    let (mut rig, mut block) = waiting();
    change(&mut block);
    let (_, body) = call(&mut rig, 5, block, ByteOrder::Big);
    let (ndr, _) = NdrResponse::parse(ByteOrder::Big, &body).unwrap();
    assert_eq!(ndr.status, PnioStatus::found(ErrorCode::CONTROL_RESPONSE, ErrorSource::CMRPC, error.0));
    assert_eq!(rig.controller.state(), ArState::Starting(ArStartUpStage::ApplicationReady));
}

#[rstest]
#[case::interface(|header: &mut RpcHeader| header.interface = Uuid::DEVICE_INTERFACE, RejectStatus::UNKNOWN_INTERFACE)]
#[case::operation(|header: &mut RpcHeader| header.opnum.0 = 9, RejectStatus::OPERATION_RANGE)]
fn an_unsupported_call_is_rejected(#[case] change: fn(&mut RpcHeader), #[case] status: RejectStatus) {
    let (mut rig, _) = waiting();
    let mut header = call_header(5, ByteOrder::Little);
    change(&mut header);
    rig.let_device(|device, out| device.send_call(&RpcPdu::new(header, &[]).to_vec(), out));
    rig.run(Duration::from_millis(1));
    let [(reply, body)]: [_; 1] = core::mem::take(&mut rig.device.replies).try_into().unwrap();
    assert_eq!((reply.packet_type, reply.flags1), (PacketType::REJECT, Flags1::NO_FACK));
    assert_eq!(RejectStatus::parse(ByteOrder::Little, &body), Ok(status));
}

/// Some devices call before they have answered PrmEnd: the call counts, and the answer is still awaited.
#[test]
fn application_ready_may_overtake_the_answer_to_prm_end() {
    let mut rig = ControllerRig::new();
    rig.device.sends_ready = false;
    rig.device.hook = Box::new(|call| match call.header.opnum {
        wire::profinet::rpc::Opnum::CONTROL if call.before == 0 => Reaction::Silence,
        _ => Reaction::Usual,
    });
    rig.controller.request(rig.now, ControllerRequest::Connect(Box::new(connection()))).unwrap();
    while rig.controller.state() != ArState::Starting(ArStartUpStage::ParameterEnd) {
        assert!(rig.step(rig.now + Duration::from_secs(1)));
    }
    rig.run(Duration::from_millis(1));
    rig.let_device(|device, out| device.application_ready(out));
    rig.run(Duration::from_millis(500));
    assert_eq!(rig.controller.state(), ArState::Starting(ArStartUpStage::ParameterEnd));
    rig.run(Duration::from_secs(1));
    assert_eq!(rig.controller.state(), ArState::Data);
}

#[test]
fn application_ready_before_prm_end_is_refused() {
    let mut rig = ControllerRig::new();
    rig.device.sends_ready = false;
    rig.device.hook = Box::new(|call| match call.header.opnum {
        wire::profinet::rpc::Opnum::WRITE => Reaction::Silence,
        _ => Reaction::Usual,
    });
    rig.controller.request(rig.now, ControllerRequest::Connect(Box::new(connection()))).unwrap();
    while rig.controller.state() != ArState::Starting(ArStartUpStage::Records) {
        assert!(rig.step(rig.now + Duration::from_secs(1)));
    }
    rig.let_device(|device, out| device.application_ready(out));
    rig.run(Duration::from_millis(1));
    let status = PnioStatus::found(ErrorCode::CONTROL_RESPONSE, ErrorSource::CMRPC, CmrpcError::STATE_CONFLICT.0);
    assert_eq!(rig.device.ready_answered, Some(status));
}
