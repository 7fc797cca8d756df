//! Late and additional frames: the rule added last decides, frames of one kind keep their order, and power-off loses them.

use crate::seams::late::{FrameTopic, Jitter, LateFrames};
use alloc::vec;
use alloc::vec::Vec;
use core::time::Duration;
use wire::datagram::write_udp;
use wire::ethernet::Mac;
use wire::octets::ByteOrder;
use wire::profinet::rpc::{Opnum, PacketType, RpcHeader, RpcPdu};

fn rpc(packet_type: PacketType, opnum: Opnum) -> Vec<u8> {
    let header = RpcHeader { opnum, ..RpcHeader::new(packet_type, ByteOrder::Little) };
    let end = |last: u8| (Mac([2, 0, 0, 0, 0, last]), core::net::SocketAddrV4::new([192, 168, 0, last].into(), 34964));
    let mut frame = Vec::new();
    write_udp(end(1), end(2), &RpcPdu::new(header, &[]).to_vec(), &mut frame).expect("a short payload");
    frame
}

#[test]
fn a_frame_has_the_topic_of_its_service() {
    let topics = [
        rpc(PacketType::RESPONSE, Opnum::CONNECT),
        rpc(PacketType::REQUEST, Opnum::CONTROL),
        rpc(PacketType::WORKING, Opnum::READ),
        vec![0; 60],
    ]
    .map(|frame| FrameTopic::of(&frame));
    let expected = [
        FrameTopic::Response(Opnum::CONNECT),
        FrameTopic::Request(Opnum::CONTROL),
        FrameTopic::Other,
        FrameTopic::Other,
    ];
    assert_eq!(topics, expected);
}

#[test]
fn without_rules_nothing_is_late() {
    let mut late = LateFrames::default();
    assert!(late.is_empty());
    late.sent(|_| None);
    assert!(!late.is_empty());
}

#[test]
fn jitter_stays_below_its_limit_and_repeats_with_its_seed() {
    let times = |seed| {
        let mut jitter = Jitter::new(seed);
        (0..100).map(move |_| jitter.next(Duration::from_millis(3))).collect::<Vec<_>>()
    };
    assert_eq!(times(1), times(1));
    assert_ne!(times(1), times(2));
    assert!(times(3).into_iter().all(|time| time < Duration::from_millis(3)));
}
