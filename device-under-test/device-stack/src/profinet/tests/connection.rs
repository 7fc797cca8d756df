//! The life of a connection, from Connect to its end.

use super::bench::*;
use alloc::vec::Vec;
use rstest::rstest;
use station::Duration;
use wire::ethernet::{EtherType, FrameHeader};
use wire::octets::ByteOrder;
use wire::profinet::alarm::{RtaBody, RtaPdu};
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::connect::{
    ArProperties, Connect, ConnectContent, IocrType, SubmoduleProperties, SubmoduleType,
};
use wire::profinet::blocks::control::ControlBlocks;
use wire::profinet::blocks::module_diff::{IdentInfo, ModuleDiffBlock, ModuleState};
use wire::profinet::rpc::{NdrRequest, Opnum, PacketType, RpcPdu, Uuid};
use wire::profinet::rt::DataStatus;
use wire::profinet::status::{AbortReason, PnioStatus};

/// The reason of the last ERR-RTA among `frames`.
pub fn abort(frames: &[Vec<u8>]) -> Option<AbortReason> {
    frames.iter().rev().find_map(|frame| {
        let (header, payload) = FrameHeader::parse(frame).ok()?;
        let rta = (header.ether_type == EtherType::PROFINET && payload.starts_with(&[0xFE, 0x01]))
            .then(|| RtaPdu::parse(&payload[2..]).ok())??;
        match rta.body {
            RtaBody::Error { status, .. } => status.abort_reason(),
            _ => None,
        }
    })
}

#[rstest]
#[case::big(ByteOrder::Big)]
#[case::little(ByteOrder::Little)]
fn a_connection_from_connect_to_release(#[case] order: ByteOrder) {
    let mut bench = StackBench::new();
    bench.order = order;
    let (status, answer) = bench.connect(&full_connect());
    assert_eq!(status, PnioStatus::OK);
    let ar = answer.ar_res().unwrap();
    assert_eq!((ar.ar_uuid, ar.session_key, ar.cm_responder_mac_add), (AR, 1, DEVICE));
    let frame_ids: Vec<_> = answer.iocr_responses().map(|iocr| (iocr.iocr_type, iocr.frame_id)).collect();
    assert_eq!(frame_ids, [(IocrType::INPUT, 0x8001), (IocrType::OUTPUT, 0x8000)]);
    assert_eq!(answer.alarm_cr_res().unwrap().max_alarm_data_length, 200);
    assert!(answer.block(BlockType::MODULE_DIFF).is_none() && answer.ar_server_res().is_none());

    bench.exchange(2);
    let frames = StackBench::inputs(&bench.take());
    assert_eq!(frames.len(), 2);
    let (data, apdu) = &frames[1];
    assert_eq!(
        data[..18],
        [[0xA5; 16].as_slice(), &[0, 0]].concat()[..],
        "IOPS and IOCS are bad before ApplicationReady"
    );
    assert_eq!(apdu.data_status, DataStatus::NORMAL);
    assert_eq!(apdu.cycle_counter.wrapping_sub(frames[0].1.cycle_counter), 64);

    assert_eq!(bench.prm_end(), PnioStatus::OK);
    assert_eq!(bench.device.application().outputs, None, "outputs are not consumed before the application is ready");
    bench.take();
    bench.exchange(3);
    let calls = bench.ready_calls();
    let pdu = RpcPdu::parse(&calls[0]).unwrap();
    assert_eq!((pdu.header.interface, pdu.header.opnum), (Uuid::CONTROLLER_INTERFACE, Opnum::CONTROL));
    assert_eq!(pdu.header.object, ar_block().cm_initiator_object_uuid);
    let blocks = NdrRequest::parse(pdu.header.order(), pdu.body).unwrap().1;
    let control = ControlBlocks::parse(blocks).unwrap();
    assert_eq!(control.block.header.kind, BlockType::APPLICATION_READY_REQ);
    assert!(control.more.is_empty());
    bench.answer_ready(&calls[0], PnioStatus::OK);

    bench.exchange(2);
    let frames = StackBench::inputs(&bench.take());
    let good = [[0xA5; 16].as_slice(), &[0x80; 7]].concat();
    assert_eq!(
        frames.last().unwrap().0[..23],
        good[..],
        "IOPS and IOCS of the telegram, IOPS of the five other submodules"
    );
    assert_eq!(bench.device.application().outputs.as_deref(), Some(&[1, 2, 3, 4][..]));

    assert_eq!(bench.release(), PnioStatus::OK);
    bench.run(Duration::from_secs(1));
    assert!(StackBench::inputs(&bench.take()).is_empty());
    assert_eq!(bench.device.application().log, ["started 6", "parameters", "ended"]);
    assert_eq!(bench.device.application().outputs, None);
    bench.check_with_tshark();
}

#[test]
fn advanced_start_up_reports_the_name_of_the_device() {
    let mut bench = StackBench::new();
    let mut connect = full_connect();
    if let ConnectContent::ArReq(ar) = &mut connect.blocks[0].content {
        ar.ar_properties = ar.ar_properties | ArProperties::STARTUP_ADVANCED;
    }
    let (status, answer) = bench.connect(&connect);
    assert_eq!(status, PnioStatus::OK);
    assert_eq!(answer.ar_server_res().unwrap().cm_responder_station_name, b"toy");
    bench.check_with_tshark();
}

#[test]
fn missing_outputs_end_the_connection() {
    let mut bench = StackBench::new();
    bench.start();
    bench.run(Duration::from_millis(3));
    assert_eq!(abort(&bench.take()), None, "the last frame is 5 ms old, the data hold time is 6 ms");
    bench.run(Duration::from_millis(1));
    let frames = bench.take();
    assert_eq!(abort(&frames), Some(AbortReason::CONSUMER_TIMEOUT));
    assert_eq!(bench.device.application().log.last().unwrap(), "ended");
    assert_eq!(bench.device.application().outputs, None);
}

#[test]
fn a_silent_initiator_ends_the_connection() {
    let mut bench = StackBench::new();
    bench.connect(&full_connect());
    bench.run(Duration::from_millis(59_999));
    assert_eq!(abort(&bench.take()), None);
    bench.run(Duration::from_millis(1));
    assert_eq!(abort(&bench.take()), Some(AbortReason::CMI_TIMEOUT));
}

#[test]
fn application_ready_is_repeated_and_then_aborted() {
    let mut bench = StackBench::new();
    bench.connect(&full_connect());
    bench.prm_end();
    bench.take();
    bench.run(Duration::from_millis(4_900));
    let calls = bench.ready_calls();
    assert_eq!(calls.len(), 5);
    assert!(calls.iter().all(|call| *call == calls[0]));
    bench.run(Duration::from_millis(200));
    assert_eq!(abort(&bench.take()), Some(AbortReason::RPC_CLIENT_CALL));
}

#[rstest]
#[case::negative(PacketType::RESPONSE, AbortReason::RPC_CONTROL)]
#[case::rejected(PacketType::REJECT, AbortReason::RPC_CLIENT_CALL)]
#[case::faulted(PacketType::FAULT, AbortReason::RPC_CLIENT_CALL)]
fn a_refused_application_ready_ends_the_connection(#[case] kind: PacketType, #[case] reason: AbortReason) {
    let mut bench = StackBench::new();
    bench.connect(&full_connect());
    bench.prm_end();
    bench.take();
    bench.run(Duration::from_millis(6));
    let call = bench.ready_calls().remove(0);
    if kind == PacketType::RESPONSE {
        bench.answer_ready(&call, PnioStatus::from(0xDD81_4006));
    } else {
        bench.answer_call(&RpcPdu::parse(&call).unwrap().header, kind, &[0, 0, 0, 1]);
    }
    assert_eq!(abort(&bench.take()), Some(reason));
}

#[rstest]
#[case::bad_provider_status([1, 2, 3, 4, 0x00], 0x35, None)]
#[case::stop([1, 2, 3, 4, 0x80], 0x25, None)]
#[case::invalid([1, 2, 3, 4, 0x80], 0x31, None)]
#[case::backup([1, 2, 3, 4, 0x80], 0x34, None)]
#[case::problem_of_the_controller([1, 2, 3, 4, 0x80], 0x15, Some([1, 2, 3, 4]))]
#[case::to_be_ignored([1, 2, 3, 4, 0x80], 0xB5, Some([9, 9, 9, 9]))]
fn outputs_are_consumed_when_every_status_is_good(
    #[case] head: [u8; 5],
    #[case] status: u8,
    #[case] outputs: Option<[u8; 4]>,
) {
    let mut bench = StackBench::new();
    bench.start();
    bench.outputs([9; 4]);
    let mut data = [0x80; 40];
    data[..5].copy_from_slice(&head);
    bench.output_frame(&data, DataStatus(status), 0);
    assert_eq!(bench.device.application().outputs, outputs.map(Vec::from));
}

#[test]
fn bad_inputs_of_the_application_have_a_bad_iops() {
    let mut bench = StackBench::new();
    bench.start();
    bench.device.application_mut().good = false;
    bench.exchange(1);
    let frames = StackBench::inputs(&bench.take());
    assert_eq!(frames[0].0[16..18], [0x00, 0x80], "IOPS of the telegram, then its IOCS");
}

#[test]
fn unknown_modules_and_submodules_are_reported() {
    let mut bench = StackBench::new();
    let mut modules = modules();
    modules[1].submodules[1].submodule_ident_number = 99;
    modules[1].submodules.push(submodule(3, 7, SubmoduleType::NO_IO, 0, 0));
    modules.push(module(0, 2, 0x99, alloc::vec![submodule(1, 1, Default::default(), 0, 0)]));
    modules.push(module(0, 7, 0x99, alloc::vec![submodule(1, 1, Default::default(), 0, 0)]));
    let (status, answer) = bench.connect(&Connect::of(connect_blocks(&modules)));
    assert_eq!(status, PnioStatus::OK);
    let difference = ModuleDiffBlock::parse(&answer.block(BlockType::MODULE_DIFF).unwrap()).unwrap();
    let reported: Vec<_> = difference
        .apis
        .iter()
        .flat_map(|api| api.modules.iter().map(move |module| (api.api, module.slot, module.module_ident, module.state)))
        .collect();
    assert_eq!(
        reported,
        [
            (0x3D00, 1, 1, ModuleState::PROPER_MODULE),
            (0, 2, 0x20, ModuleState::WRONG_MODULE),
            (0, 7, 0, ModuleState::NO_MODULE)
        ]
    );
    let submodules: Vec<_> = difference.apis[0].modules[0]
        .submodules
        .iter()
        .map(|submodule| (submodule.subslot, submodule.submodule_ident, submodule.state.ident_info()))
        .collect();
    assert_eq!(submodules, [(2, 81, IdentInfo::WRONG), (3, 0, IdentInfo::NO_SUBMODULE)]);

    bench.prm_end();
    bench.take();
    bench.run(Duration::from_millis(6));
    let call = bench.ready_calls().remove(0);
    let pdu = RpcPdu::parse(&call).unwrap();
    let control = ControlBlocks::parse(NdrRequest::parse(pdu.header.order(), pdu.body).unwrap().1).unwrap();
    assert!(control.block(BlockType::MODULE_DIFF).is_some());
    bench.answer_ready(&call, PnioStatus::OK);
    bench.exchange(2);
    let frames = StackBench::inputs(&bench.take());
    assert_eq!(frames.last().unwrap().0[16], 0x00, "a submodule that is not plugged has a bad IOPS");
    bench.check_with_tshark();
    assert_eq!(bench.device.application().inputs, 0);
}

#[test]
fn an_expected_module_is_plugged_if_possible() {
    let mut bench = StackBench::new();
    let mut modules = modules();
    let output = SubmoduleType::OUTPUT;
    modules.push(module(0, 2, 0x21, alloc::vec![submodule(1, 0x211, output, 0, 2)]));
    let (status, answer) = bench.connect(&Connect::of(connect_blocks(&modules)));
    assert_eq!((status, answer.block(BlockType::MODULE_DIFF)), (PnioStatus::OK, None));
}

#[test]
fn a_submodule_with_discard_ioxs_occupies_no_byte() {
    let mut bench = StackBench::new();
    let mut modules = modules();
    modules[0].submodules[0].submodule_properties = SubmoduleProperties::DISCARD_IOXS;
    let mut blocks = connect_blocks(&modules);
    for block in &mut blocks {
        if let ConnectContent::IocrReq(iocr) = block {
            let objects = iocr.apis.iter_mut().flat_map(|api| api.io_data_objects.iter_mut().chain(&mut api.iocs));
            for object in objects.filter(|object| (object.slot_number, object.subslot_number) == (0, 1)) {
                object.frame_offset = 0;
            }
        }
    }
    assert_eq!(bench.connect(&Connect::of(blocks)).0, PnioStatus::OK);
    bench.exchange(2);
    assert_eq!(StackBench::inputs(&bench.take())[0].0[0], 0xA5, "the first byte belongs to the telegram only");
}

#[test]
fn a_repeated_connect_replaces_the_connection() {
    let mut bench = StackBench::new();
    bench.start();
    let (status, _) = bench.connect(&full_connect());
    assert_eq!(status, PnioStatus::OK);
    assert_eq!(abort(&bench.take()), Some(AbortReason::RE_RUN));
    assert_eq!(bench.device.application().log, ["started 6", "parameters", "ended", "started 6"]);
}

#[test]
fn power_cycle_and_cable() {
    let mut bench = StackBench::new();
    bench.start();
    bench.device.power(bench.now, false);
    bench.exchange(5);
    assert!(bench.take().is_empty(), "without power the device sends nothing");
    bench.device.power(bench.now, true);
    bench.run(Duration::from_millis(1_999));
    assert!(bench.take().is_empty(), "the device is booting");
    bench.run(Duration::from_millis(1));
    let frames = bench.take();
    assert_eq!(frames.len(), 2, "LLDP and Hello");
    assert_eq!(bench.release(), PnioStatus::from(0xDC81_4005), "the connection is lost");
    bench.take();
    bench.device.link(bench.now, false);
    bench.run(Duration::from_secs(20));
    assert!(bench.take().is_empty());
    bench.device.link(bench.now, true);
    bench.run(Duration::ZERO);
    assert_eq!(bench.take().len(), 2);
}
