//! Cyclic exchange: the grid, counters, status, watchdog, and alarms.
#![allow(clippy::unwrap_used, reason = "a test that unwraps nothing has failed")]

use crate::common::*;
use core::time::Duration;
use encspec_controllers::outputs::{CounterMode, CyclicOutputs, OutputSignal, SignalCounter};
use encspec_controllers::profinet_io::*;
use rstest::rstest;
use wire::ethernet::{FrameHeader, Vlan};
use wire::profinet::alarm::{
    AlarmAck, AlarmNotification, AlarmPriority, AlarmSpecifier, AlarmType, RtaBody, RtaHeader, RtaKind, RtaPdu,
};
use wire::profinet::rt::{ApduStatus, CyclicFrame, FrameId};
use wire::profinet::status::{AbortReason, PnioStatus};

/// Declares two signals of 16 bits in the only submodule with outputs; the first has a sign of life in its upper four bits.
fn declared(outputs: &mut CyclicOutputs) -> &mut CyclicOutputs {
    let sign_of_life = SignalCounter { low: 12, width: 4, first: 1, last: 15 };
    let signal = |counters| OutputSignal { bytes: 2, little_endian: false, counters };
    outputs.declare([signal(vec![sign_of_life]), signal(vec![])]);
    outputs.lay_out([((1, 2), &[0, 1][..])]);
    outputs
}

/// The four output bytes of each cyclic frame that arrived.
fn outputs(rig: &ControllerRig) -> Vec<[u8; 4]> {
    rig.device.outputs.iter().map(|frame| frame[2..6].try_into().unwrap()).collect()
}

#[test]
fn frames_leave_on_the_grid_and_the_cycle_counter_matches_it() {
    let mut rig = ControllerRig::standing();
    let before = rig.log.len();
    rig.run(Duration::from_secs(3));
    let mut last: Option<(u64, u16)> = None;
    let mut frames = 0;
    for (time, from_controller, frame) in &rig.log[before..] {
        let (_, payload) = FrameHeader::parse(frame).unwrap();
        if !*from_controller || FrameId::peek(payload).unwrap() != FrameId(OUTPUT_FRAME_ID) {
            continue;
        }
        let ApduStatus { cycle_counter, .. } = CyclicFrame::parse(payload, 40).unwrap().status;
        let due = time.as_nanos() - 10_000;
        assert_eq!((due % 2_000_000, u64::from(cycle_counter)), (0, due / 31_250 % 65_536));
        if let Some((earlier, counter)) = last {
            assert_eq!((due - earlier, cycle_counter.wrapping_sub(counter)), (2_000_000, 64));
        }
        (last, frames) = (Some((due, cycle_counter)), frames + 1);
    }
    assert_eq!(frames, 1500);
    assert_eq!(rig.controller.cycles_sent(), rig.device.outputs.len() as u64);
}

#[test]
fn a_late_wake_sends_one_frame_and_stays_on_the_grid() {
    use station::{Outbox, Station, Time};
    let mut rig = ControllerRig::standing();
    let next = rig.controller.deadline().unwrap();
    let sent = rig.controller.cycles_sent();
    let mut out = Outbox::new();
    rig.controller.wake(next + Duration::from_millis(5), &mut out);
    assert_eq!((out.frames().count(), rig.controller.cycles_sent() - sent), (1, 1));
    let counter = out.frames().next().unwrap()[14 + 4 + 42..][..2].to_vec();
    let due = next.as_nanos() + 4_000_000;
    assert_eq!(counter, ((due / 31_250) as u16).to_be_bytes());
    assert_eq!(rig.controller.deadline(), Some(Time::from_nanos(due + 2_000_000)));
}

#[test]
fn outputs_are_retained_across_a_reconnect() {
    let mut rig = ControllerRig::new();
    declared(rig.controller.outputs_mut()).set_bytes(&[0, 0, 0xAB, 0xCD]);
    assert!(rig.start(connection()).standing);
    rig.run(Duration::from_millis(4));
    assert_eq!(outputs(&rig).last(), Some(&[0, 0, 0xAB, 0xCD]));
    assert_eq!(
        rig.ask(ControllerRequest::Release),
        ControllerOutcome::Ended(ArReleaseOutcome::Released(ControlOutcome::Accepted))
    );
    rig.device.outputs.clear();
    assert!(rig.start(connection()).standing);
    assert_eq!(outputs(&rig).first(), Some(&[0, 0, 0xAB, 0xCD]));
    rig.controller.outputs_mut().set(1, 4, 4, 0xF);
    rig.run(Duration::from_millis(4));
    assert_eq!(outputs(&rig).last(), Some(&[0, 0, 0, 0xF0]));
    rig.controller.outputs_mut().reset();
    rig.run(Duration::from_millis(4));
    assert_eq!(outputs(&rig).last(), Some(&[0x20, 0, 0, 0]));
}

#[test]
fn a_sign_of_life_counts_with_each_frame() {
    let mut rig = ControllerRig::standing();
    rig.run(Duration::from_millis(1));
    rig.device.outputs.clear();
    declared(rig.controller.outputs_mut()).set(0, 0, 12, 0x47F);
    rig.run(Duration::from_millis(34));
    let mut expected: Vec<[u8; 4]> = (1..=15).chain(1..=2).map(|life: u8| [life << 4 | 4, 0x7F, 0, 0]).collect();
    assert_eq!(outputs(&rig), expected);
    rig.controller.outputs_mut().count(0, 12, 4, CounterMode::Held);
    rig.run(Duration::from_millis(4));
    rig.controller.outputs_mut().set(0, 12, 4, 0);
    rig.run(Duration::from_millis(2));
    rig.controller.outputs_mut().count(0, 12, 4, CounterMode::Counting);
    rig.run(Duration::from_millis(2));
    expected.extend([[0x24, 0x7F, 0, 0], [0x24, 0x7F, 0, 0], [0x04, 0x7F, 0, 0], [0x14, 0x7F, 0, 0]]);
    assert_eq!(outputs(&rig), expected);
}

#[test]
fn the_provider_status_can_be_set_to_bad() {
    let mut rig = ControllerRig::standing();
    let iops = |rig: &mut ControllerRig| {
        rig.run(Duration::from_millis(4));
        rig.device.outputs.last().unwrap()[6]
    };
    assert_eq!(iops(&mut rig), 0x80);
    rig.controller.outputs_mut().status(Some((1, 2)), false);
    assert_eq!(iops(&mut rig), 0x60);
    rig.controller.outputs_mut().status(Some((1, 2)), true);
    rig.controller.outputs_mut().status(None, false);
    assert_eq!(iops(&mut rig), 0x60);
    rig.controller.outputs_mut().status(None, true);
    assert_eq!(iops(&mut rig), 0x80);
}

#[test]
fn a_pause_sends_nothing_and_counts_nothing() {
    let mut rig = ControllerRig::standing();
    rig.run(Duration::from_millis(1));
    rig.controller.outputs_mut().pause(true);
    let sent = rig.controller.cycles_sent();
    rig.run(Duration::from_secs(1));
    assert_eq!((rig.controller.cycles_sent(), rig.controller.state()), (sent, ArState::Data));
    rig.controller.outputs_mut().pause(false);
    rig.run(Duration::from_millis(20));
    assert_eq!(rig.controller.cycles_sent(), sent + 10);
}

#[test]
fn the_ar_ends_when_no_frame_comes_for_the_data_hold_time() {
    let mut rig = ControllerRig::standing();
    rig.run(Duration::from_secs(1));
    assert_eq!(rig.controller.take_end(), None);
    rig.device.cyclic = false;
    rig.run(Duration::from_millis(25));
    let wait = Wait { what: AwaitedEvent::Data, time: Duration::from_millis(20) };
    assert_eq!(rig.controller.take_end(), Some(ArEnd::Watchdog(wait)));
    assert_eq!(rig.controller.state(), ArState::None);
    let [(_, pdu)] = rig.device.rta.as_slice() else { panic!("{:?}", rig.device.rta) };
    let status = PnioStatus::abort(AbortReason::CONSUMER_TIMEOUT);
    assert_eq!(pdu.body, RtaBody::Error { status, more: vec![] });
}

/// Frames that are not new frames of this stream do not reset the watchdog; an unchanged frame does.
#[rstest]
#[case::control(|_: &mut Vec<u8>| {}, false)]
#[case::another_station(|frame: &mut Vec<u8>| frame[11] ^= 1, true)]
#[case::another_receiver(|frame: &mut Vec<u8>| frame[5] ^= 4, true)]
#[case::another_stream(|frame: &mut Vec<u8>| frame[19] ^= 2, true)]
#[case::a_frame_that_is_cut(|frame: &mut Vec<u8>| frame.truncate(50), true)]
#[case::a_counter_that_stands(|frame: &mut Vec<u8>| frame[60..62].fill(0), true)]
#[case::a_transfer_error(|frame: &mut Vec<u8>| frame[63] = 1, true)]
fn only_new_frames_of_the_stream_reset_the_watchdog(#[case] change: fn(&mut Vec<u8>), #[case] ends: bool) {
    let mut rig = ControllerRig::standing();
    rig.run(Duration::from_millis(10));
    rig.device.cyclic = false;
    let is_input = |(_, from_controller, frame): &&(station::Time, bool, Vec<u8>)| {
        !from_controller && frame[18..20] == [0xC0, 0x01]
    };
    let frame = rig.log.iter().rev().find(is_input).unwrap().2.clone();
    for _ in 0..12 {
        let mut next = frame.clone();
        next[60..62].copy_from_slice(&((rig.now.as_nanos() / 31_250) as u16).to_be_bytes());
        change(&mut next);
        let mut out = station::Outbox::new();
        out.push(&next);
        rig.launch(false, &out);
        rig.run(Duration::from_millis(2));
    }
    assert_eq!(matches!(rig.controller.take_end(), Some(ArEnd::Watchdog(_))), ends);
}

fn alarm(priority: AlarmPriority, number: u16) -> AlarmNotification {
    AlarmNotification {
        priority,
        alarm_type: AlarmType::DIAGNOSIS,
        api: 0x3D00,
        slot: 1,
        subslot: 2,
        module_ident: 0x22,
        submodule_ident: 81,
        specifier: AlarmSpecifier::new(number, AlarmSpecifier::CHANNEL_DIAGNOSIS),
        items: vec![],
    }
}

fn send_alarm(rig: &mut ControllerRig, priority: AlarmPriority, sequence: u16, acknowledged: u16, number: u16) {
    rig.let_device(|device, out| {
        let reference = device.ar.as_ref().unwrap().controller_reference;
        let header = RtaHeader::new(RtaKind::DATA, reference, ALARM_REFERENCE, sequence, acknowledged);
        device.send_rta(priority, &RtaPdu { header, body: RtaBody::Notification(alarm(priority, number)) }, out);
    });
    rig.run(Duration::from_micros(100));
}

fn send_ack(rig: &mut ControllerRig, priority: AlarmPriority, sequence: u16, acknowledged: u16) {
    rig.let_device(|device, out| {
        let reference = device.ar.as_ref().unwrap().controller_reference;
        let header = RtaHeader::new(RtaKind::ACK, reference, ALARM_REFERENCE, sequence, acknowledged);
        device.send_rta(priority, &RtaPdu { header, body: RtaBody::Octets(vec![]) }, out);
    });
    rig.run(Duration::from_micros(100));
}

/// The RTA PDUs that arrived at the device: kind, priority, sequence number, acknowledged number.
fn rta_received(rig: &mut ControllerRig) -> Vec<(RtaKind, AlarmPriority, u16, u16)> {
    let pdus = core::mem::take(&mut rig.device.rta);
    let short = |(priority, pdu): &(AlarmPriority, RtaPdu)| {
        (pdu.header.kind, *priority, pdu.header.send_seq_num, pdu.header.ack_seq_num)
    };
    pdus.iter().map(short).collect()
}

/// Each priority has its own sequence numbers: first 0xFFFF, then from 0 on; 0xFFFE means "none yet".
#[test]
fn alarms_are_acknowledged_twice_and_each_priority_has_its_own_numbers() {
    use AlarmPriority::{High, Low};
    let mut rig = ControllerRig::standing();
    send_alarm(&mut rig, Low, 0xFFFF, 0xFFFE, 5);
    let [(_, ack), (_, application)] = rig.device.rta.as_slice() else { panic!("{:?}", rig.device.rta) };
    assert_eq!((ack.header.dst_endpoint, ack.header.src_endpoint), (ALARM_REFERENCE, 1));
    assert!(application.header.tack() && !ack.header.tack());
    let RtaBody::Acknowledgement(ack) = &application.body else { panic!("{application:?}") };
    let AlarmNotification { alarm_type, api, slot, subslot, specifier, .. } = alarm(Low, 5);
    let status = PnioStatus::OK;
    assert_eq!(*ack, AlarmAck { priority: Low, alarm_type, api, slot, subslot, specifier, status });
    assert_eq!(rta_received(&mut rig), [(RtaKind::ACK, Low, 0xFFFE, 0xFFFF), (RtaKind::DATA, Low, 0xFFFF, 0xFFFF)]);
    send_ack(&mut rig, Low, 0xFFFF, 0xFFFF);
    send_alarm(&mut rig, High, 0xFFFF, 0xFFFE, 6);
    assert_eq!(rta_received(&mut rig), [(RtaKind::ACK, High, 0xFFFE, 0xFFFF), (RtaKind::DATA, High, 0xFFFF, 0xFFFF)]);
    send_ack(&mut rig, High, 0xFFFF, 0xFFFF);
    send_alarm(&mut rig, Low, 0, 0xFFFF, 7);
    assert_eq!(rta_received(&mut rig), [(RtaKind::ACK, Low, 0xFFFF, 0), (RtaKind::DATA, Low, 0, 0)]);
    rig.run(Duration::from_secs(1));
    let tags: Vec<_> = rig
        .sent()
        .filter_map(|(_, frame)| FrameHeader::parse(frame).ok())
        .filter(|(_, payload)| matches!(payload[..2], [0xFC | 0xFE, 0x01]))
        .map(|(header, payload)| (payload[0], header.tag))
        .collect();
    assert!(tags.contains(&(0xFC, Some(Vlan::RT))) && tags.contains(&(0xFE, Some(Vlan::LOW_ALARM))));
}

#[test]
fn a_repeated_alarm_is_acknowledged_again_but_not_processed_again() {
    let mut rig = ControllerRig::standing();
    send_alarm(&mut rig, AlarmPriority::Low, 0xFFFF, 0xFFFE, 5);
    send_ack(&mut rig, AlarmPriority::Low, 0xFFFF, 0xFFFF);
    rta_received(&mut rig);
    send_alarm(&mut rig, AlarmPriority::Low, 0xFFFF, 0xFFFE, 5);
    assert_eq!(rta_received(&mut rig), [(RtaKind::ACK, AlarmPriority::Low, 0xFFFF, 0xFFFF)]);
    send_alarm(&mut rig, AlarmPriority::Low, 9, 0xFFFE, 5);
    assert_eq!(rta_received(&mut rig), [(RtaKind::NACK, AlarmPriority::Low, 0xFFFF, 0xFFFF)]);
}

#[test]
fn an_unacknowledged_alarm_ack_is_repeated_and_then_ends_the_ar() {
    let mut rig = ControllerRig::standing();
    send_alarm(&mut rig, AlarmPriority::High, 0xFFFF, 0xFFFE, 5);
    rta_received(&mut rig);
    rig.run(Duration::from_millis(350));
    let again = (RtaKind::DATA, AlarmPriority::High, 0xFFFF, 0xFFFF);
    assert_eq!(rta_received(&mut rig), [again; 3]);
    rig.run(Duration::from_millis(100));
    let wait = Wait { what: AwaitedEvent::AlarmAcknowledged, time: Duration::from_millis(400) };
    assert_eq!(rig.controller.take_end(), Some(ArEnd::AlarmUnacknowledged(wait)));
    let [(kind, priority, ..)] = rta_received(&mut rig)[..] else { panic!("one ERR-RTA") };
    assert_eq!((kind, priority), (RtaKind::ERR, AlarmPriority::Low));
}

/// `Held`: no acknowledgement at all until `Given`; the repetition then counts as the first alarm. `Received`: the transport
/// acknowledges, the application only after `Given`.
#[test]
fn withheld_acknowledgements_are_sent_later() {
    use AlarmPriority::Low;
    let mut rig = ControllerRig::standing();
    rig.controller.acknowledge_alarms(AlarmAcknowledge::Held);
    send_alarm(&mut rig, Low, 0xFFFF, 0xFFFE, 5);
    rig.run(Duration::from_secs(1));
    assert_eq!(rta_received(&mut rig), []);
    rig.controller.acknowledge_alarms(AlarmAcknowledge::Given);
    send_alarm(&mut rig, Low, 0xFFFF, 0xFFFE, 5);
    assert_eq!(rta_received(&mut rig), [(RtaKind::ACK, Low, 0xFFFE, 0xFFFF), (RtaKind::DATA, Low, 0xFFFF, 0xFFFF)]);
    send_ack(&mut rig, Low, 0xFFFF, 0xFFFF);
    rig.controller.acknowledge_alarms(AlarmAcknowledge::Received);
    send_alarm(&mut rig, Low, 0, 0xFFFF, 6);
    send_alarm(&mut rig, Low, 1, 0xFFFF, 7);
    rig.run(Duration::from_secs(1));
    assert_eq!(rta_received(&mut rig), [(RtaKind::ACK, Low, 0xFFFF, 0), (RtaKind::ACK, Low, 0xFFFF, 1)]);
    rig.controller.acknowledge_alarms(AlarmAcknowledge::Given);
    rig.run(Duration::from_micros(100));
    assert_eq!(rta_received(&mut rig), [(RtaKind::DATA, Low, 0, 1)]);
    send_ack(&mut rig, Low, 1, 0);
    assert_eq!(rta_received(&mut rig), [(RtaKind::DATA, Low, 1, 1)]);
    assert_eq!((rig.controller.state(), rig.controller.take_end()), (ArState::Data, None));
}

#[test]
fn an_alarm_for_another_endpoint_is_ignored() {
    let mut rig = ControllerRig::standing();
    rig.let_device(|device, out| {
        for (to, from) in [(0x7777, ALARM_REFERENCE), (device.ar.as_ref().unwrap().controller_reference, 0x7777)] {
            let header = RtaHeader::new(RtaKind::DATA, to, from, 0xFFFF, 0xFFFE);
            let body = RtaBody::Notification(alarm(AlarmPriority::Low, 1));
            device.send_rta(AlarmPriority::Low, &RtaPdu { header, body }, out);
        }
        let header = RtaHeader::new(RtaKind::ERR, 0x7777, ALARM_REFERENCE, 0xFFFF, 0xFFFE);
        let status = PnioStatus::abort(AbortReason::LINK_DOWN);
        device.send_rta(AlarmPriority::Low, &RtaPdu { header, body: RtaBody::Error { status, more: vec![] } }, out);
    });
    rig.run(Duration::from_secs(1));
    assert!(rig.device.rta.is_empty());
    assert_eq!((rig.controller.state(), rig.controller.take_end()), (ArState::Data, None));
}

/// The controller's ERR-RTA has the same content as one of a real controller (office-noise-versamax.pcap, packet 602), apart from
/// addresses and references.
#[test]
fn the_err_rta_matches_that_of_a_real_controller() {
    let Some(capture) = testing::shared("captures/profinet/office-noise-versamax.pcap") else { return };
    let captured = &testing::packets(&capture)[601][16..44];
    let mut rig = ControllerRig::new();
    assert!(rig.start(ArConfig { vlan: false, ..connection() }).standing);
    assert_eq!(
        rig.ask(ControllerRequest::Abort { code: AbortReason::INSTANCE_CLOSED }),
        ControllerOutcome::Ended(ArReleaseOutcome::Aborted)
    );
    rig.run(Duration::from_millis(1));
    let (_, from_controller) = rig.sent().last().unwrap();
    let from_controller =
        if from_controller.len() == 60 { &from_controller[16..44] } else { panic!("{} bytes", from_controller.len()) };
    assert_eq!(from_controller[4..], captured[4..]);
}
