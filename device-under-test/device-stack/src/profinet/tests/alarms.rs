//! Diagnoses as alarms: transport, repetition, acknowledgement, abort.

use super::bench::*;
use super::connection::abort;
use alloc::vec::Vec;
use rstest::rstest;
use station::Duration;
use wire::ethernet::{EtherType, FrameHeader, Vlan};
use wire::octets::Append;
use wire::profinet::alarm::{AlarmNotification, AlarmPriority, AlarmType, RtaBody, RtaHeader, RtaKind, RtaPdu};
use wire::profinet::diagnosis::{AlarmItem, ChannelChange};
use wire::profinet::rpc::Opnum;
use wire::profinet::rt::DataStatus;
use wire::profinet::status::{AbortReason, PnioStatus};

/// The alarm PDUs among `frames`, all of low priority.
fn alarms(frames: &[Vec<u8>]) -> Vec<RtaPdu> {
    let low = |frame: &Vec<u8>| {
        let (header, payload) = FrameHeader::parse(frame).ok()?;
        let rta = payload.strip_prefix(&[0xFE, 0x01]).filter(|_| header.ether_type == EtherType::PROFINET)?;
        assert_eq!(header.tag, Some(Vlan::LOW_ALARM));
        RtaPdu::parse(rta).ok()
    };
    frames.iter().filter_map(low).collect()
}

fn notification(pdu: &RtaPdu) -> &AlarmNotification {
    match &pdu.body {
        RtaBody::Notification(notification) => notification,
        other => panic!("no notification: {other:?}"),
    }
}

fn send(bench: &mut StackBench, priority: AlarmPriority, header: RtaHeader, body: RtaBody) {
    let mut frame = Vec::new();
    FrameHeader::new(DEVICE, CONTROLLER, EtherType::PROFINET).tagged(Vlan::LOW_ALARM).write(&mut frame);
    frame.put_u16(priority.frame_id());
    RtaPdu { header, body }.write(&mut frame);
    bench.send(&frame);
}

/// Acknowledges `pdu` by RTA ACK, and then, with `sequence`, by an Alarm Ack.
fn acknowledge(bench: &mut StackBench, pdu: &RtaPdu, sequence: u16) {
    let RtaHeader { dst_endpoint, src_endpoint, send_seq_num, .. } = pdu.header;
    let ack = RtaHeader::new(RtaKind::ACK, src_endpoint, dst_endpoint, 0xFFFE, send_seq_num);
    send(bench, AlarmPriority::Low, ack, RtaBody::Octets(Vec::new()));
    let data = RtaHeader::new(RtaKind::DATA, src_endpoint, dst_endpoint, sequence, send_seq_num);
    let body = RtaBody::Acknowledgement(notification(pdu).acknowledgement(PnioStatus::OK));
    send(bench, AlarmPriority::Low, data, body);
}

#[test]
fn a_diagnosis_appears_and_disappears() {
    let mut bench = StackBench::new();
    bench.start();
    bench.device.application_mut().change(0x9001, true);
    bench.device.application_mut().change(0x9002, true);
    bench.exchange(1);
    let frames = bench.take();
    let sent = alarms(&frames);
    assert_eq!(sent.len(), 1, "one alarm at a time");
    assert_eq!((sent[0].header.send_seq_num, sent[0].header.ack_seq_num), (0xFFFF, 0xFFFE));
    assert_eq!(sent[0].header.dst_endpoint, alarm_cr().local_alarm_reference);
    let alarm = notification(&sent[0]);
    assert_eq!((alarm.alarm_type, alarm.slot, alarm.subslot, alarm.submodule_ident), (AlarmType::DIAGNOSIS, 1, 2, 83));
    assert_eq!((alarm.specifier.sequence_number(), alarm.specifier.ar_diagnosis_state()), (0, true));
    assert_eq!(alarm.items[0].channels()[0].error_type.0, 0x9001);
    assert!(matches!(alarm.items[..], [AlarmItem::Channel(_)]));

    acknowledge(&mut bench, &sent[0], 0xFFFF);
    let answers = alarms(&bench.take());
    assert_eq!((answers[0].header.kind, answers[0].header.ack_seq_num), (RtaKind::ACK, 0xFFFF));
    assert_eq!((answers[1].header.send_seq_num, answers[1].header.ack_seq_num), (0, 0xFFFF));
    assert_eq!(notification(&answers[1]).specifier.sequence_number(), 1);
    acknowledge(&mut bench, &answers[1], 0);
    bench.take();

    bench.device.application_mut().change(0x9001, false);
    bench.exchange(1);
    let sent = alarms(&bench.take());
    let alarm = notification(&sent[0]);
    assert_eq!(alarm.alarm_type, AlarmType::DIAGNOSIS_DISAPPEARS);
    assert_eq!(alarm.items[0].channels()[0].properties.change(), ChannelChange::DisappearsOthersRemain);
    assert!(alarm.specifier.submodule_diagnosis_state());
    acknowledge(&mut bench, &sent[0], 1);
    bench.device.application_mut().change(0x9002, false);
    bench.exchange(1);
    let sent = alarms(&bench.take());
    let alarm = notification(sent.last().unwrap());
    assert_eq!(alarm.items[0].channels()[0].properties.change(), ChannelChange::Disappears);
    assert_eq!(alarm.specifier.0 & 0xF800, 0);
    bench.check_with_tshark();
}

#[test]
fn the_data_status_shows_a_fault() {
    let mut bench = StackBench::new();
    bench.start();
    bench.device.application_mut().change(0x9001, true);
    bench.exchange(2);
    let status = |bench: &mut StackBench| StackBench::inputs(&bench.take()).last().unwrap().1.data_status;
    assert_eq!(status(&mut bench), DataStatus(0x15));
    bench.device.application_mut().change(0x9001, false);
    bench.exchange(2);
    assert_eq!(status(&mut bench), DataStatus(0x35));
}

#[test]
fn an_alarm_without_acknowledgement_is_repeated_and_then_ends_the_connection() {
    let mut bench = StackBench::new();
    bench.start();
    bench.device.application_mut().change(0x9001, true);
    bench.exchange(199);
    let frames = bench.take();
    let sent = alarms(&frames);
    assert_eq!(sent.len(), 4, "one alarm and three repetitions, 100 ms apart");
    assert!(sent.iter().all(|pdu| *pdu == sent[0]));
    assert_eq!(abort(&frames), None);
    bench.exchange(3);
    assert_eq!(abort(&bench.take()), Some(AbortReason::ALARM_SEND));
}

#[test]
fn pending_diagnoses_are_reported_to_a_new_connection() {
    let mut bench = StackBench::new();
    bench.device.application_mut().change(0x9001, true);
    let (status, _) = bench.connect(&full_connect());
    assert_eq!(status, PnioStatus::OK);
    bench.exchange(2);
    bench.prm_end();
    bench.exchange(3);
    assert!(alarms(&bench.frames).is_empty(), "no alarm before the controller has confirmed ApplicationReady");
    let call = bench.ready_calls().remove(0);
    bench.answer_ready(&call, PnioStatus::OK);
    assert_eq!(alarms(&bench.take()).len(), 1);
}

#[rstest]
#[case::the_next(0xFFFF, RtaKind::ACK)]
#[case::a_later_one(0x0003, RtaKind::NACK)]
fn data_pdus_of_the_controller_are_acknowledged_in_order(#[case] sequence: u16, #[case] kind: RtaKind) {
    let mut bench = StackBench::new();
    bench.start();
    let header = RtaHeader::new(RtaKind::DATA, 1, 5, sequence, 0xFFFE);
    send(&mut bench, AlarmPriority::Low, header, RtaBody::Octets([0, 0x55, 0, 2, 1, 0].into()));
    assert_eq!(alarms(&bench.take())[0].header.kind, kind);
}

#[rstest]
#[case::low(AlarmPriority::Low)]
#[case::high(AlarmPriority::High)]
fn an_err_rta_of_the_controller_ends_the_connection_without_an_answer(#[case] priority: AlarmPriority) {
    let mut bench = StackBench::new();
    bench.start();
    let status = PnioStatus::abort(AbortReason::ABORT_REQUEST);
    let header = RtaHeader::new(RtaKind::ERR, 1, 5, 0xFFFE, 0xFFFE);
    send(&mut bench, priority, header, RtaBody::Error { status, more: Vec::new() });
    assert_eq!(bench.device.application().log.last().unwrap(), "ended");
    bench.run(Duration::from_secs(1));
    assert_eq!(abort(&bench.take()), None);
}

#[test]
fn alarms_for_other_endpoints_are_ignored() {
    let mut bench = StackBench::new();
    bench.start();
    let status = PnioStatus::abort(AbortReason::ABORT_REQUEST);
    let header = RtaHeader::new(RtaKind::ERR, 1, 6, 0xFFFE, 0xFFFE);
    send(&mut bench, AlarmPriority::Low, header, RtaBody::Error { status, more: Vec::new() });
    assert_ne!(bench.device.application().log.last().unwrap(), "ended");
    let (status, _) = bench.operate(Opnum::READ, &[]);
    assert_eq!(status, PnioStatus::from(0xDE81_0801));
}
