//! Peculiarities of controllers in the field. A conforming device accepts all of them.

use super::bench::*;
use super::connection::abort;
use super::toy::API;
use crate::profinet::port_mac;
use alloc::vec::Vec;
use rstest::rstest;
use station::Duration;
use wire::ethernet::{EtherType, FrameHeader, Mac};
use wire::lldp::{Lldp, Tlv};
use wire::octets::{Append, ByteOrder};
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::connect::{
    ArProperties, Connect, ConnectContent, IocrBlockReq, IocrType, RtClass, SubmoduleType,
};
use wire::profinet::blocks::record::{RecordHeader, WriteRequest};
use wire::profinet::dcp::{Dcp, DcpValue, Element};
use wire::profinet::rpc::{Opnum, Uuid};
use wire::profinet::rt::{ApduStatus, CyclicFrame, DataStatus, FrameId};
use wire::profinet::status::AbortReason;

type PersonaTrial = fn(&mut StackBench) -> bool;

fn connect_with(bench: &mut StackBench, change: fn(&mut IocrBlockReq)) -> bool {
    let mut blocks = connect_blocks(&modules());
    for block in &mut blocks {
        if let ConnectContent::IocrReq(iocr) = block {
            change(iocr);
        }
    }
    bench.connect(&Connect::of(blocks)).0.is_ok()
}

pub fn class_1(bench: &mut StackBench) -> bool {
    connect_with(bench, |iocr| {
        iocr.iocr_properties = RtClass::RT_CLASS_1.into();
        iocr.frame_id = if iocr.iocr_type == IocrType::INPUT { 0xC001 } else { 0xC002 };
    })
}

pub fn second_phase(bench: &mut StackBench) -> bool {
    connect_with(bench, |iocr| iocr.phase = 2)
}

pub fn slow(bench: &mut StackBench) -> bool {
    connect_with(bench, |iocr| iocr.reduction_ratio = 512)
}

pub fn advanced(bench: &mut StackBench) -> bool {
    let mut connect = full_connect();
    if let ConnectContent::ArReq(ar) = &mut connect.blocks[0].content {
        ar.ar_properties = ar.ar_properties | ArProperties::STARTUP_ADVANCED;
    }
    bench.connect(&connect).0.is_ok()
}

pub fn little_endian(bench: &mut StackBench) -> bool {
    bench.order = ByteOrder::Little;
    let connect = full_connect().to_vec();
    let header = bench.header(Opnum::CONNECT);
    let body = wire::profinet::rpc::NdrRequest::body(ByteOrder::Little, 16_384, &connect);
    bench.call(&header, &body).unwrap().0.packet_type == wire::profinet::rpc::PacketType::RESPONSE
}

pub fn alarms_second(bench: &mut StackBench) -> bool {
    let mut blocks = connect_blocks(&modules());
    let alarms = blocks.pop().unwrap();
    blocks.insert(1, alarms);
    bench.connect(&Connect::of(blocks)).0.is_ok()
}

/// Adds blocks 0x010B and 0x0601 with three bytes each, by which a controller offers fast start-up.
pub fn fast_start_up(bench: &mut StackBench) -> bool {
    let mut octets = full_connect().to_vec();
    for kind in [0x010B_u16, 0x0601] {
        octets.put_u16(kind);
        octets.put(&[0, 5, 1, 0, 0, 0, 0]);
    }
    bench.operate(Opnum::CONNECT, &octets).0.is_ok()
}

/// Sends outputs with `frame_id`, and returns whether they were consumed.
fn takes_outputs(bench: &mut StackBench, frame_id: u16, is_tagged: bool) -> bool {
    bench.prm_end();
    bench.run(Duration::from_millis(6));
    let mut data = [0x80; 40];
    data[..4].copy_from_slice(&[7; 4]);
    let status = ApduStatus { cycle_counter: 9000, data_status: DataStatus::NORMAL, transfer_status: 0 };
    let header = FrameHeader::new(DEVICE, CONTROLLER, EtherType::PROFINET);
    let mut frame = Vec::new();
    if is_tagged { header.tagged(wire::ethernet::Vlan::RT) } else { header }.write(&mut frame);
    CyclicFrame { frame_id: FrameId(frame_id), data: &data, status, padding: &[] }.write(&mut frame);
    bench.send(&frame);
    bench.device.application().outputs.as_deref() == Some(&[7; 4])
}

pub fn untagged(bench: &mut StackBench) -> bool {
    bench.connect(&full_connect());
    takes_outputs(bench, 0x8000, false)
}

pub fn proposed_frame_id(bench: &mut StackBench) -> bool {
    let is_taken =
        connect_with(bench, |iocr| iocr.frame_id = if iocr.frame_id == 0xFFFF { 0x8010 } else { iocr.frame_id });
    is_taken && takes_outputs(bench, 0x8010, true)
}

fn again(bench: &mut StackBench, uuid: Uuid) -> bool {
    bench.start();
    let mut connect = full_connect();
    if let ConnectContent::ArReq(ar) = &mut connect.blocks[0].content {
        ar.ar_uuid = uuid;
    }
    let is_taken = bench.connect(&connect).0.is_ok();
    is_taken && abort(&bench.take()) == Some(AbortReason::RE_RUN)
}

pub fn again_with_the_same_uuid(bench: &mut StackBench) -> bool {
    again(bench, AR)
}

pub fn again_with_a_new_uuid(bench: &mut StackBench) -> bool {
    again(bench, Uuid([8; 16]))
}

pub fn several_records(bench: &mut StackBench) -> bool {
    bench.connect(&full_connect());
    let at =
        RecordHeader { ar_uuid: AR, api: API, slot_number: 1, subslot_number: 2, index: 0x100, ..Default::default() };
    let records = [[1, 1, 1, 1], [2, 2, 2, 2]].map(|data| WriteRequest::of(at, data.to_vec()));
    let mut blocks = Vec::new();
    WriteRequest::multiple(AR, 1, &records).write(&mut blocks);
    assert!(bench.operate(Opnum::WRITE, &blocks).0.is_ok());
    bench.device.application().writes == 2
}

pub fn nothing_differs(bench: &mut StackBench) -> bool {
    bench.connect(&full_connect()).1.block(BlockType::MODULE_DIFF).is_none()
}

pub fn reports_its_ids(bench: &mut StackBench) -> bool {
    let answers = bench.dcp(&Dcp::get(3, [Element::DEVICE_ID].into()), DEVICE);
    answers[0].blocks()[0].value == DcpValue::DeviceId { vendor_id: 0x0239, device_id: 1 }
}

pub fn has_im0(bench: &mut StackBench) -> bool {
    super::records::implicit(bench, (0, 0, 1), 0xAFF0).0.is_ok()
}

pub fn a_reset_ends_the_connection(bench: &mut StackBench) -> bool {
    bench.start();
    let mut frame = Vec::new();
    let reset = wire::profinet::dcp::DcpBlock::set(wire::profinet::dcp::BlockQualifier(0), DcpValue::FactoryReset);
    Dcp::set(3, [reset].into()).write_frame(DEVICE, CONTROLLER, &mut frame);
    bench.send(&frame);
    abort(&bench.take()).is_some()
}

pub fn outputs_end_with_the_connection(bench: &mut StackBench) -> bool {
    bench.start();
    bench.release();
    bench.device.application().outputs.is_none()
}

pub fn inputs_continue_with_bad_outputs(bench: &mut StackBench) -> bool {
    bench.start();
    bench.output_frame(&[0; 40], DataStatus::NORMAL, 0);
    let before = bench.device.application().inputs;
    bench.run(CYCLE);
    bench.device.application().inputs != before
}

/// Two submodules with outputs; the IOPS of the second one is bad.
pub fn a_bad_status_concerns_one_submodule(bench: &mut StackBench) -> bool {
    let mut modules = modules();
    modules.push(module(0, 2, 0x21, alloc::vec![submodule(1, 0x211, SubmoduleType::OUTPUT, 0, 2)]));
    assert!(bench.connect(&Connect::of(connect_blocks(&modules))).0.is_ok());
    bench.prm_end();
    bench.run(Duration::from_millis(6));
    let mut data = [0x80; 40];
    // The IOPS of the telegram follows its data; every later status byte is bad.
    data[5..].fill(0);
    bench.output_frame(&data, DataStatus::NORMAL, 0);
    bench.device.application().outputs.is_some()
}

#[rstest]
#[case::class_1(class_1)]
#[case::phase(second_phase)]
#[case::reduction(slow)]
#[case::advanced(advanced)]
#[case::byte_order(little_endian)]
#[case::blocks(alarms_second)]
#[case::passed_over(fast_start_up)]
#[case::untagged(untagged)]
#[case::frame_id(proposed_frame_id)]
#[case::same_uuid(again_with_the_same_uuid)]
#[case::new_uuid(again_with_a_new_uuid)]
#[case::multiple(several_records)]
#[case::proper_modules(nothing_differs)]
#[case::device_id(reports_its_ids)]
#[case::im0(has_im0)]
#[case::reset(a_reset_ends_the_connection)]
#[case::outputs(outputs_end_with_the_connection)]
#[case::inputs(inputs_continue_with_bad_outputs)]
#[case::outputs_apart(a_bad_status_concerns_one_submodule)]
fn a_device_accepts(#[case] is_accepted: PersonaTrial) {
    assert!(is_accepted(&mut StackBench::new()));
}

#[test]
fn a_second_controller_does_not_replace_the_first_one() {
    let mut bench = StackBench::new();
    bench.start();
    let mut connect = full_connect();
    if let ConnectContent::ArReq(ar) = &mut connect.blocks[0].content {
        (ar.ar_uuid, ar.cm_initiator_mac_add) = (Uuid([8; 16]), Mac([2, 0, 0, 0, 0, 2]));
    }
    assert!(!bench.connect(&connect).0.is_ok());
    assert_eq!(abort(&bench.take()), None);
}

#[test]
fn class_3_is_not_ignored() {
    let mut bench = StackBench::new();
    let mut octets = full_connect().to_vec();
    octets.put(&[0x01, 0x09, 0, 4, 1, 0, 0, 0]);
    assert!(!bench.operate(Opnum::CONNECT, &octets).0.is_ok());
}

/// The MAC address of a port is that of the device plus the port number (invented). The announcement comes from port
/// 1.
#[test]
fn an_announcement_comes_from_the_port_and_names_the_device() {
    assert_eq!(port_mac(Mac([2, 0, 0, 0, 0xFF, 0xFF]), 2), Mac([2, 0, 0, 1, 0, 1]));
    let mut bench = StackBench::new();
    bench.run(Duration::from_millis(1));
    let frames = bench.take();
    let announced: Vec<_> = frames
        .iter()
        .filter_map(|frame| FrameHeader::parse(frame).ok())
        .filter(|(header, _)| header.ether_type == EtherType::LLDP)
        .map(|(header, payload)| (header.source, Lldp::parse(payload).unwrap()))
        .collect();
    let [(source, lldp)] = &announced[..] else { panic!("expected one announcement, at the only cable") };
    assert_eq!(*source, Mac([2, 0, 0, 0, 1, 1]));
    assert!(lldp.tlvs.contains(&Tlv::ChassisMac(DEVICE)));
}
