//! Pulled and plugged submodules, port parameters and the log book.

use super::bench::*;
use crate::profinet::{PlugChange, PluggableSubmodule};
use alloc::vec::Vec;
use wire::ethernet::FrameHeader;
use wire::profinet::alarm::{AlarmNotification, AlarmType, RtaBody, RtaPdu};
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::control::{ControlBlock, ControlBlocks};
use wire::profinet::rpc::{NdrRequest, Opnum, RpcPdu};
use wire::profinet::status::PnioStatus;

fn alarms(frames: &[Vec<u8>]) -> Vec<AlarmNotification> {
    let notification = |frame: &Vec<u8>| {
        let (_, payload) = FrameHeader::parse(frame).ok()?;
        let pdu = RtaPdu::parse(payload.strip_prefix(&[0xFE, 0x01])?).ok()?;
        if let RtaBody::Notification(notification) = pdu.body { Some(notification) } else { None }
    };
    frames.iter().filter_map(notification).collect()
}

/// The telegram submodule that the bench connects.
fn telegram(bench: &StackBench) -> PluggableSubmodule {
    let plugs = &bench.device.application().plugs;
    *plugs.iter().find(|plug| plug.submodule_ident == 83).unwrap()
}

/// Queues a change and exchanges data; returns the alarms.
fn change(bench: &mut StackBench, change: PlugChange) -> Vec<AlarmNotification> {
    bench.take();
    bench.device.application_mut().plug_changes.push_back(change);
    bench.exchange(2);
    alarms(&bench.take())
}

fn plug_end(bench: &mut StackBench, sequence: u16) -> PnioStatus {
    let mut block = ControlBlock::prm_end(AR, 1);
    block.header.kind = BlockType::PLUG_PRM_END_REQ;
    block.alarm_sequence_number = sequence;
    bench.operate(Opnum::CONTROL, &ControlBlocks::from(block).to_vec()).0
}

#[test]
fn a_pulled_submodule_is_reported_and_the_connection_stays() {
    let mut bench = StackBench::new();
    bench.start();
    let plug = telegram(&bench);
    let sent = change(&mut bench, PlugChange::Pulled(plug));
    assert_eq!((sent[0].alarm_type, sent[0].slot, sent[0].subslot), (AlarmType::PULL, 1, 2));
    assert_eq!(bench.device.application().outputs, None);
    assert_ne!(plug_end(&mut bench, 0), PnioStatus::OK, "nothing is plugged");
    bench.check_with_tshark();
}

#[test]
fn a_plugged_submodule_is_ready_after_its_parameters() {
    let mut bench = StackBench::new();
    bench.start();
    let plug = telegram(&bench);
    bench.device.application_mut().plug_changes.push_back(PlugChange::Pulled(plug));
    let sent = change(&mut bench, PlugChange::Plugged(plug));
    assert_eq!(sent.len(), 1, "the second alarm waits for the acknowledgement of the first");
    assert_eq!(bench.device.application().outputs, None);
    assert_ne!(plug_end(&mut bench, 7), PnioStatus::OK, "another alarm");
    assert_eq!(plug_end(&mut bench, 1), PnioStatus::OK);
    bench.run(CYCLE);
    let calls = bench.ready_calls();
    let pdu = RpcPdu::parse(&calls[0]).unwrap();
    let (_, blocks) = NdrRequest::parse(pdu.header.order(), pdu.body).unwrap();
    let block = ControlBlocks::parse(blocks).unwrap().block;
    assert_eq!((block.header.kind, block.alarm_sequence_number), (BlockType::PLUG_APPLICATION_READY_REQ, 1));
    bench.answer_ready(&calls[0], PnioStatus::OK);
    bench.exchange(2);
    assert_eq!(bench.device.application().outputs, Some([1, 2, 3, 4].to_vec()));
    bench.check_with_tshark();
}

#[test]
fn a_wrong_submodule_is_reported() {
    let mut bench = StackBench::new();
    bench.start();
    let plug = PluggableSubmodule { submodule_ident: 0x7777, ..telegram(&bench) };
    let sent = change(&mut bench, PlugChange::Plugged(plug));
    assert_eq!((sent[0].alarm_type, sent[0].submodule_ident), (AlarmType::PLUG_WRONG, 0x7777));
    assert_ne!(plug_end(&mut bench, 0), PnioStatus::OK);
    bench.check_with_tshark();
}

/// The application reports its own idents, and a deviation may have given the device others.
#[cfg(feature = "deviations")]
#[test]
fn a_submodule_with_other_idents_is_recognized_when_it_is_plugged() {
    use super::toy::ToyIoApplication;
    use crate::attached::Attached;
    use crate::profinet::StackHooks;
    use crate::profinet::plugged::{PluggedConfiguration, SubmoduleAddress};
    use alloc::rc::Rc;
    use core::cell::RefCell;

    struct OtherIdents;

    impl StackHooks for OtherIdents {
        fn plugs(&mut self, plugs: &mut Vec<PluggableSubmodule>) {
            plugs.iter_mut().for_each(|plug| plug.submodule_ident += 0x1000);
        }
    }

    let toy = ToyIoApplication::new();
    let hooks: Attached<dyn StackHooks> = Attached::new(Rc::new(RefCell::new(OtherIdents)));
    let mut plugged = PluggedConfiguration::new(&toy.plugs, &toy.identity, &hooks);
    let plug = toy.plugs[3];
    let place = SubmoduleAddress::from(&plug);
    plugged.pull(place);
    assert_eq!(plugged.at(place), None);
    let as_plugged = PluggableSubmodule { submodule_ident: plug.submodule_ident + 0x1000, ..plug };
    assert_eq!(plugged.plug(plug, &hooks), (as_plugged, true));
    assert_eq!(plugged.at(place), Some(&as_plugged));
    let wrong = PluggableSubmodule { submodule_ident: 0x7777, ..plug };
    assert_eq!(plugged.plug(wrong, &hooks), (wrong, false));
}
