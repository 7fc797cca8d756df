//! A network interface at one end of a virtual cable (veth), in a network namespace.
#![cfg(target_os = "linux")]

use crate::common::{frame, next, silent, two_ends};
use encspec_link::{Clock, LinkError, Nic, Port, namespace, portable};
use rstest::rstest;
use station::{Duration, Time};
use std::net::UdpSocket;
use testing::stall::retry_on_stall;

const PEER: [u8; 6] = [0x02, 0, 0, 0, 0, 0x55];

fn both() -> (Nic, Nic, Clock) {
    let open = |name| Nic::open(name).unwrap_or_else(|error| panic!("{error}"));
    (open("left"), open("right"), Clock::start())
}

#[test]
fn a_frame_for_any_address_crosses_the_cable_unchanged() {
    retry_on_stall(|| {
        if !two_ends() {
            return;
        }
        let (mut left, mut right, clock) = both();
        for length in [14, 59, 60, 1514] {
            let sent = frame(PEER, length);
            left.send(&sent).expect("it is sent");
            assert_eq!(next(&mut right, &clock).1, sent);
        }
    });
}

/// Each kind of VLAN tag that the kernel removes from a frame: priority only, VLAN and priority, service tag.
#[rstest]
#[case::priority_only(0x8100, 0xC000)]
#[case::vlan_and_priority(0x8100, 0xC123)]
#[case::all_zero(0x8100, 0x0000)]
#[case::service_tag(0x88A8, 0x6001)]
fn a_vlan_tag_is_restored(#[case] kind: u16, #[case] content: u16) {
    retry_on_stall(|| {
        if !two_ends() {
            return;
        }
        let (mut left, mut right, clock) = both();
        let plain = frame(PEER, 60);
        let mut sent = plain[..12].to_vec();
        sent.extend_from_slice(&kind.to_be_bytes());
        sent.extend_from_slice(&content.to_be_bytes());
        sent.extend_from_slice(&plain[12..]);
        left.send(&sent).expect("it is sent");
        assert_eq!(next(&mut right, &clock).1, sent);
    });
}

#[test]
fn the_longest_tagged_frame_is_sent_and_a_longer_one_is_lost() {
    retry_on_stall(|| {
        if !two_ends() {
            return;
        }
        let (mut left, mut right, clock) = both();
        let mut tagged = frame(PEER, 1518);
        tagged[12..16].copy_from_slice(&[0x81, 0x00, 0xC0, 0x00]);
        left.send(&tagged).expect("it is sent");
        assert_eq!(next(&mut right, &clock).1, tagged);
        left.send(&frame(PEER, 1600)).expect("a frame that is too long is dropped without an error");
        assert!(silent(&mut right, &clock));
    });
}

#[test]
fn the_time_of_arrival_is_that_of_the_kernel() {
    retry_on_stall(|| {
        if !two_ends() {
            return;
        }
        let (mut left, mut right, clock) = both();
        // The kernel starts to timestamp frames a moment after the first socket requests it.
        left.send(&frame(PEER, 60)).expect("it is sent");
        next(&mut right, &clock);
        assert!(silent(&mut right, &clock));
        let before = clock.now();
        left.send(&frame(PEER, 60)).expect("it is sent");
        let after = clock.now();
        assert!(silent(&mut left, &clock), "the frame waits in the receive buffer meanwhile");
        let (arrived, _) = next(&mut right, &clock);
        let slack = Duration::from_millis(1);
        assert!(arrived + slack >= before && arrived <= after + slack, "sent {before} to {after}, arrived {arrived}");
    });
}

#[test]
fn sent_frames_do_not_come_back() {
    retry_on_stall(|| {
        if !two_ends() {
            return;
        }
        let (mut left, mut right, clock) = both();
        let mut second = Nic::open("left").expect("an interface can be opened twice");
        left.send(&frame([0xFF; 6], 60)).expect("it is sent");
        next(&mut right, &clock);
        assert!(silent(&mut left, &clock) && silent(&mut second, &clock), "sent frames are not received");
    });
}

#[test]
fn receive_does_not_wait_after_its_time_has_passed() {
    retry_on_stall(|| {
        if !two_ends() {
            return;
        }
        let (mut left, mut right, clock) = both();
        left.send(&frame(PEER, 60)).expect("it is sent");
        let mut into = Vec::new();
        assert!(
            right.receive(&clock, Time::ZERO, &mut into).expect("the line works").is_some(),
            "a frame that has arrived is returned"
        );
        assert!(right.receive(&clock, Time::ZERO, &mut into).expect("the line works").is_none());
        let until = clock.now() + Duration::from_millis(20);
        assert!(right.receive(&clock, until, &mut into).expect("the line works").is_none());
        let after = clock.now();
        assert!(after >= until && after < until + Duration::from_secs(1), "waited from {until} to {after}");
    });
}

/// On a virtual cable the kernel leaves the UDP checksum to the network adapter, which does not exist.
#[test]
fn a_checksum_left_to_the_hardware_is_filled_in() {
    retry_on_stall(|| {
        if !two_ends() {
            return;
        }
        namespace::run(&["address", "add", "10.9.8.1/24", "dev", "left"]).expect("an address");
        namespace::run(&["neighbour", "add", "10.9.8.2", "lladdr", "02:00:00:00:00:55", "dev", "left"])
            .expect("a neighbour");
        let (_, mut right, clock) = both();
        let socket = UdpSocket::bind("10.9.8.1:50000").expect("a socket of the kernel");
        for payload in [&b"odd"[..], b"even"] {
            socket.send_to(payload, "10.9.8.2:34964").expect("it is sent");
            let received = loop {
                let (_, received) = next(&mut right, &clock);
                if received[12..14] == [0x08, 0x00] {
                    break received;
                }
            };
            assert_ne!(received[40..42], [0, 0], "the datagram has a checksum");
            assert_eq!(udp_sum(&received), 0xFFFF, "the sum over pseudo header and datagram, RFC 768");
        }
    });
}

/// The sum of RFC 768 over addresses, a zero, the protocol, the UDP length and the datagram; 0xFFFF if the checksum is right.
fn udp_sum(frame: &[u8]) -> u64 {
    let ip = &frame[14..];
    let udp = &ip[20..usize::from(u16::from_be_bytes([ip[2], ip[3]]))];
    let mut covered = ip[12..20].to_vec();
    covered.extend_from_slice(&[0, 17]);
    covered.extend_from_slice(&u16::try_from(udp.len()).expect("a datagram is short").to_be_bytes());
    covered.extend_from_slice(udp);
    covered.resize(covered.len().next_multiple_of(2), 0);
    let mut sum: u64 = covered.chunks_exact(2).map(|pair| u64::from(u16::from_be_bytes([pair[0], pair[1]]))).sum();
    while sum > 0xFFFF {
        sum = (sum & 0xFFFF) + (sum >> 16);
    }
    sum
}

#[test]
fn the_error_of_an_unusable_interface_is_one_sentence() {
    retry_on_stall(|| {
        if !two_ends() {
            return;
        }
        let why = |name: &str| match Nic::open(name) {
            Err(LinkError::Unusable(why)) => why,
            other => panic!("{name}: {other:?}"),
        };
        assert_eq!(why("eth\n7"), "there is no interface eth\\n7: the interfaces are right, left");
        assert_eq!(
            why("a-name-beyond-the-fifteen"),
            "there is no interface a-name-beyond-the-fifteen: the interfaces are right, left"
        );
        assert_eq!(why("lo"), "the interface lo carries no Ethernet frames: the interfaces are right, left");
        namespace::run(&["link", "set", "left", "down"]).expect("left can be taken down");
        assert_eq!(why("left"), "the interface left is down: bring it up with `ip link set left up`");
        namespace::run(&["link", "del", "left"]).expect("left can be deleted");
        assert_eq!(why("left"), "there is no interface left: this host has none");
    });
}

#[test]
fn interfaces_are_listed_with_their_state() {
    retry_on_stall(|| {
        if !two_ends() {
            return;
        }
        let (left, _, _) = both();
        let known = encspec_link::interfaces();
        let names: Vec<_> = known.iter().map(|known| known.name.as_str()).collect();
        assert_eq!(names, ["lo", "right", "left"]);
        assert!(known[0].loopback && known[2].up && known[2].running);
        assert_eq!(known[2].mac, left.mac());
        assert_eq!(left.describe(), "the interface left");
    });
}

/// Waits for a change of the carrier, which the kernel reports with a short delay.
#[track_caller]
fn until_carrier(nic: &Nic, there: bool) {
    let clock = Clock::start();
    while nic.carrier() != there {
        assert!(clock.now() < Time::ZERO + crate::common::LONG, "timeout while waiting for carrier {there}");
        std::thread::yield_now();
    }
}

#[test]
fn a_line_that_is_taken_down_is_gone_until_it_is_up_again() {
    retry_on_stall(|| {
        if !two_ends() {
            return;
        }
        let (mut left, mut right, clock) = both();
        namespace::run(&["link", "set", "right", "down"]).expect("right can be taken down");
        let gone =
            LinkError::Gone("the interface right was taken down; bring it up with `ip link set right up`".to_string());
        let mut into = Vec::new();
        for _ in 0..2 {
            assert_eq!(right.receive(&clock, clock.now() + crate::common::LONG, &mut into), Err(gone.clone()));
            assert_eq!(right.send(&frame(PEER, 60)), Err(gone.clone()));
        }
        until_carrier(&left, false);
        assert!(silent(&mut left, &clock), "the other end is silent and has no error");
        left.send(&frame(PEER, 60)).expect("a sent frame is lost without an error");
        let before = clock.now();
        assert!(right.recover(&clock, before + crate::common::A_WHILE).expect_err("it is still down").is_gone());
        assert!(clock.now() >= before + crate::common::A_WHILE);

        namespace::run(&["link", "set", "right", "up"]).expect("right can be brought up");
        right.recover(&clock, clock.now() + crate::common::LONG).expect("it is back");
        until_carrier(&left, true);
        until_carrier(&right, true);
        left.send(&frame(PEER, 60)).expect("it is sent");
        assert_eq!(next(&mut right, &clock).1, frame(PEER, 60));
    });
}

#[test]
fn an_interface_that_is_removed_and_created_again_is_recovered() {
    retry_on_stall(|| {
        if !two_ends() {
            return;
        }
        let (_, mut right, clock) = both();
        namespace::run(&["link", "del", "left"]).expect("the pair can be deleted");
        let error =
            right.receive(&clock, clock.now() + crate::common::LONG, &mut Vec::new()).expect_err("right was removed");
        assert_eq!(error, LinkError::Gone("the interface right was removed; plug its adapter in again".to_string()));
        namespace::veth("left", "right").expect("a new pair");
        right.recover(&clock, clock.now() + crate::common::LONG).expect("it is back");
        let mut left = Nic::open("left").expect("left can be opened");
        left.send(&frame(PEER, 60)).expect("it is sent");
        assert_eq!(next(&mut right, &clock).1, frame(PEER, 60), "frames for any address are received again");
    });
}

#[test]
fn frames_that_overflow_the_receive_buffer_are_counted_as_lost() {
    retry_on_stall(|| {
        if !two_ends() {
            return;
        }
        let (mut left, mut right, clock) = both();
        assert_eq!(right.lost(), 0);
        for _ in 0..40_000 {
            left.send(&frame(PEER, 1514)).expect("it is sent");
        }
        let lost = right.lost();
        assert!(lost > 0 && right.lost() == lost, "counted once: {lost}");
        let mut taken = 0;
        while right.receive(&clock, Time::ZERO, &mut Vec::new()).expect("the line works").is_some() {
            taken += 1;
        }
        assert_eq!(taken + lost, 40_000);
    });
}

#[test]
fn the_portable_implementation_carries_frames_both_ways() {
    retry_on_stall(|| {
        if !two_ends() {
            return;
        }
        let mut left = portable::PortableNic::open("left").expect("left can be opened");
        let mut right = portable::PortableNic::open("right").expect("right can be opened");
        let clock = Clock::start();
        left.send(&frame(PEER, 60)).expect("it is sent");
        assert_eq!(next(&mut right, &clock).1, frame(PEER, 60));
        right.send(&frame([0xFF; 6], 1514)).expect("it is sent");
        assert_eq!(next(&mut left, &clock).1, frame([0xFF; 6], 1514));
        assert!(silent(&mut left, &clock) && silent(&mut right, &clock));
        assert_eq!(left.mac(), Nic::open("left").expect("left can be opened").mac());

        namespace::run(&["link", "set", "right", "down"]).expect("right can be taken down");
        let error =
            right.receive(&clock, clock.now() + crate::common::LONG, &mut Vec::new()).expect_err("right is down");
        assert!(error.is_gone(), "{error}");
        namespace::run(&["link", "set", "right", "up"]).expect("right can be brought up");
        right.recover(&clock, clock.now() + crate::common::LONG).expect("it is back");
        let mut left = Nic::open("left").expect("left finds its peer again");
        left.send(&frame(PEER, 60)).expect("it is sent");
        assert_eq!(next(&mut right, &clock).1, frame(PEER, 60));
    });
}

#[test]
fn an_interface_without_a_cable_can_be_opened_and_is_silent() {
    retry_on_stall(|| {
        if !two_ends() {
            return;
        }
        namespace::run(&["link", "set", "left", "down"]).expect("left can be taken down");
        let mut right = Nic::open("right").expect("it is up");
        until_carrier(&right, false);
        right.send(&frame(PEER, 60)).expect("a sent frame is lost without an error");
        assert!(silent(&mut right, &Clock::start()));
    });
}
