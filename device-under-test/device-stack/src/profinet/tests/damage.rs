//! Damaged frames: the device neither panics nor stops.

use super::bench::*;
use alloc::vec::Vec;
use station::{Duration, Outbox, Station};
use wire::profinet::dcp::{BlockQualifier, Dcp, DcpBlock, DcpValue};
use wire::profinet::status::PnioStatus;

/// Valid frames: one of each kind that the other tests send.
fn frames() -> Vec<Vec<u8>> {
    let mut bench = StackBench::new();
    bench.start();
    bench.device.application_mut().change(0x9001, true);
    bench.exchange(1);
    bench.release();
    bench.connect(&access_connect(AR));
    for request in [
        Dcp::identify(7, 1, [DcpValue::NameOfStation(b"toy".to_vec())].into()),
        Dcp::get(8, [wire::profinet::dcp::Element::IP_PARAMETER].into()),
        Dcp::set(9, [DcpBlock::set(BlockQualifier::PERMANENT, DcpValue::NameOfStation(b"toy".to_vec()))].into()),
    ] {
        bench.dcp(&request, DEVICE);
    }
    let mut frames = bench.sent();
    // One frame of each length, kind and operation.
    let kind = |frame: &Vec<u8>| (frame.len(), frame[12..20].to_vec(), frame.get(110..112).map(<[u8]>::to_vec));
    frames.sort_by_key(kind);
    frames.dedup_by_key(|frame| kind(frame));
    frames
}

/// Every prefix of a frame, and the frame with each bit flipped.
fn damaged(frame: &[u8]) -> impl Iterator<Item = Vec<u8>> {
    let prefixes = (0..frame.len()).map(|length| frame[..length].to_vec());
    let flips = (0..frame.len() * 8).map(|bit| {
        let mut flipped = frame.to_vec();
        flipped[bit / 8] ^= 1 << (bit % 8);
        flipped
    });
    prefixes.chain(flips)
}

#[test]
fn no_damaged_frame_makes_the_device_panic() {
    let frames = frames();
    assert!(frames.len() > 8);
    for frame in &frames {
        let mut bench = StackBench::new();
        let mut count = 0;
        for damaged in damaged(frame) {
            bench.device.receive(bench.now, &damaged, &mut Outbox::new());
            count += 1;
            if count % 256 == 0 {
                bench.run(Duration::from_millis(1));
            }
        }
        bench.run(Duration::from_secs(200));
        bench.device.power(bench.now, false);
        bench.device.power(bench.now, true);
        bench.run(Duration::from_secs(3));
        let all = Dcp::identify(7, 1, [DcpValue::AllSelector].into());
        assert_eq!(bench.dcp(&all, wire::ethernet::Mac::DCP_MULTICAST).len(), 1);
    }
}

#[test]
fn no_damaged_frame_makes_a_device_in_data_exchange_panic() {
    for frame in &frames() {
        let mut bench = StackBench::new();
        bench.start();
        for (number, damaged) in damaged(frame).enumerate() {
            bench.device.receive(bench.now, &damaged, &mut Outbox::new());
            if number % 64 == 0 {
                bench.exchange(1);
            }
        }
        bench.run(Duration::from_secs(200));
    }
}

#[test]
fn noise_is_ignored() {
    let mut bench = StackBench::new();
    let mut state = 0x2545_F491_4F6C_DD1D_u64;
    let mut random = || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        state
    };
    let heads: [&[u8]; 5] = [
        &[0x88, 0x92, 0xFE, 0xFE],
        &[0x88, 0x92, 0xFE, 0xFD],
        &[0x88, 0x92, 0xFE, 0x01],
        &[0x08, 0x00, 0x45],
        &[0x88, 0xCC],
    ];
    for _ in 0..20_000 {
        let length = (random() % 200) as usize;
        let noise: Vec<u8> = (0..length).map(|_| random() as u8).collect();
        let head = heads[(random() % 5) as usize];
        let frame = [&DEVICE.0[..], &CONTROLLER.0, head, &noise].concat();
        bench.device.receive(bench.now, &frame, &mut Outbox::new());
    }
    bench.take();
    let mut fresh = StackBench::new();
    core::mem::swap(&mut fresh.device, &mut bench.device);
    assert!(matches!(fresh.connect(&access_connect(AR)).0, PnioStatus::OK));
}
