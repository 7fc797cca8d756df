//! What a watch uses: an interface that is only listened at, the system log, and a text for whoever asks by HTTP.
#![cfg(target_os = "linux")]

use crate::common::{LONG, frame, two_ends};
use encspec_link::system_log::{LogSeverity, SystemLog};
use encspec_link::text_server::TextServer;
use encspec_link::{Clock, Nic, NicTap, Port, namespace, transmitted};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::os::unix::net::UnixDatagram;
use testing::stall::retry_on_stall;

const PEER: [u8; 6] = [0x02, 0, 0, 0, 0, 0x55];

fn tap() -> NicTap {
    NicTap::open("right").unwrap_or_else(|error| panic!("{error}"))
}

/// The next frame at the tap.
fn heard(tap: &mut NicTap, clock: &Clock) -> Vec<u8> {
    let mut frames = Vec::new();
    let until = clock.now() + LONG;
    while frames.is_empty() && clock.now() < until {
        let taken = tap.receive(clock, until, &mut |frame| frames.push(frame.octets.to_vec()));
        taken.unwrap_or_else(|error| panic!("{error}"));
    }
    assert_eq!(frames.len(), 1);
    frames.remove(0)
}

#[test]
fn a_tap_receives_what_arrives_and_what_this_host_sends_and_transmits_nothing() {
    retry_on_stall(|| {
        if !two_ends() {
            return;
        }
        let (mut left, mut tap, clock) = (Nic::open("left").expect("it is up"), tap(), Clock::start());
        let before = transmitted::transmitted_frames("right").expect("the system counts frames");
        let mut tagged = frame(PEER, 60);
        tagged.splice(12..12, [0x81, 0x00, 0xC1, 0x23]);
        for sent in [frame(PEER, 60), frame([0xFF; 6], 1514), tagged] {
            left.send(&sent).expect("it is sent");
            assert_eq!(heard(&mut tap, &clock), sent);
        }
        assert_eq!(transmitted::transmitted_frames("right"), Some(before));
        // Another program of this host sends at the interface: that is recorded, and counted.
        let own = frame(PEER, 61);
        Nic::open("right").expect("it is up").send(&own).expect("it is sent");
        assert_eq!(heard(&mut tap, &clock), own);
        assert_eq!(transmitted::transmitted_frames("right"), Some(before + 1));
        assert_eq!(tap.lost(), 0);
    });
}

#[test]
fn frames_that_the_buffer_could_not_hold_are_counted_before_the_frame_after_them() {
    retry_on_stall(|| {
        if !two_ends() {
            return;
        }
        let (mut left, mut tap, clock) = (Nic::open("left").expect("it is up"), tap(), Clock::start());
        let sent = 200_000_u64;
        let octets = frame(PEER, 1_500);
        for _ in 0..sent {
            left.send(&octets).expect("it is sent");
        }
        let (mut received, mut lost) = (0, 0);
        let mut take = |tap: &mut NicTap| {
            let until = clock.now();
            let taken = tap.receive(&clock, until, &mut |frame| {
                received += 1;
                lost += frame.lost_before;
            });
            taken.unwrap_or_else(|error| panic!("{error}"))
        };
        while take(&mut tap) > 0 {}
        // The next frame says how many were dropped before it.
        left.send(&octets).expect("it is sent");
        while take(&mut tap) > 0 {}
        assert!(lost > 0, "all {received} frames found room");
        assert_eq!(received + lost, sent + 1 - left.lost());
    });
}

#[test]
fn an_address_and_a_route_are_reasons_for_frames_of_the_host() {
    retry_on_stall(|| {
        if !two_ends() {
            return;
        }
        assert_eq!(transmitted::why_it_may_transmit("right"), [""; 0]);
        namespace::run(&["address", "add", "192.168.7.1/24", "dev", "right"]).expect("root in its namespace");
        let why = transmitted::why_it_may_transmit("right").join("\n");
        assert!(why.contains("has the address 192.168.7.1") && why.contains("a route leads through right"), "{why}");
    });
}

#[test]
fn a_text_is_served_to_one_client_after_the_other() {
    let server =
        TextServer::listen("127.0.0.1:0".parse().expect("an address"), || "one 1\n".to_owned()).expect("a port");
    for (request, status, body) in
        [("GET /metrics", "200 OK", "one 1\n"), ("POST /metrics", "404 Not Found", "GET /metrics\n")]
    {
        let mut client = TcpStream::connect(server.address()).expect("it listens");
        write!(client, "{request} HTTP/1.1\r\nHost: here\r\n\r\n").expect("it reads");
        let mut answer = String::new();
        client.read_to_string(&mut answer).expect("it answers and closes");
        assert!(answer.starts_with(&format!("HTTP/1.1 {status}\r\n")), "{answer}");
        assert!(answer.ends_with(&format!("\r\n\r\n{body}")), "{answer}");
    }
}

#[test]
fn a_message_has_its_priority_and_one_line() {
    let path = std::env::temp_dir().join(format!("encspec-log-{}", std::process::id()));
    let _ = std::fs::remove_file(&path);
    let log = UnixDatagram::bind(&path).expect("a socket");
    let sender = SystemLog::open(&path).expect("it is there");
    sender.send(LogSeverity::Error, "encspec", "one\ntwo").expect("it is read");
    let mut buffer = [0; 200];
    let length = log.recv(&mut buffer).expect("a message");
    let _ = std::fs::remove_file(&path);
    // Facility daemon (3) times 8, and severity error (3): RFC 5424, 6.2.1.
    assert_eq!(String::from_utf8_lossy(&buffer[..length]), format!("<27>encspec[{}]: one two", std::process::id()));
}
