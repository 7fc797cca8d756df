use rstest::rstest;

use super::*;
use crate::null::{BusBabbler, BusReflector};
use wire::profibus::fdl::FdlFrame;

const BAUD: BaudRate = BaudRate(1_500_000);
const SLOT: BitTimes = BitTimes(300);

/// A Slave_Diag request from 2 to 3 and a short acknowledgement.
const REQUEST: [u8; 11] = [0x68, 0x05, 0x05, 0x68, 0x83, 0x82, 0x6D, 0x3C, 0x3E, 0xEC, 0x16];
const ANSWER: [u8; 1] = [0xE5];
const TOKEN: [u8; 3] = [0xDC, 0x02, 0x02];

/// Sends bytes at given times, and records when bursts began and what it received.
#[derive(Default)]
struct BusScript {
    frames: VecDeque<(u64, Vec<u8>)>,
    heard: Vec<u64>,
    received: Vec<(u64, Vec<u8>)>,
}

impl BusScript {
    fn new(frames: &[(u64, &[u8])]) -> BusScript {
        let frames = frames.iter().map(|(time, octets)| (*time, octets.to_vec())).collect();
        BusScript { frames, ..BusScript::default() }
    }
}

impl Station for BusScript {
    fn carrier(&mut self, now: Time) {
        self.heard.push(now.as_nanos());
    }

    fn receive(&mut self, now: Time, frame: &[u8], _out: &mut Outbox) {
        self.received.push((now.as_nanos(), frame.to_vec()));
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        while self.frames.front().is_some_and(|(time, _)| *time <= now.as_nanos()) {
            let (_, octets) = self.frames.pop_front().expect("there is a first one");
            out.push(&octets);
        }
    }

    fn deadline(&self) -> Option<Time> {
        self.frames.front().map(|(time, _)| Time::from_nanos(*time))
    }
}

fn bits(count: u64) -> u64 {
    BAUD.nanoseconds(BitTimes(count))
}

/// A frame recorded by the tap: begin and end in nanoseconds, port, bytes.
type Tapped = (u64, u64, usize, Vec<u8>);

/// Runs two scripts and a listener on a bus; returns the bus, the listener, and the recorded frames.
fn run(a: &[(u64, &[u8])], b: &[(u64, &[u8])]) -> (VirtualBus, BusScript, Vec<Tapped>) {
    let (mut a, mut b, mut listener) = (BusScript::new(a), BusScript::new(b), BusScript::default());
    let mut bus = VirtualBus::new(BAUD, SLOT);
    let mut seen = Vec::new();
    bus.run(&mut [&mut a, &mut b, &mut listener], Time::from_nanos(10_000_000), &mut |frame| {
        seen.push((frame.begin.as_nanos(), frame.time.as_nanos(), frame.port, frame.frame.to_vec()));
    });
    (bus, listener, seen)
}

#[rstest]
#[case::one_octet(BaudRate(12_000_000), 1, 917)]
#[case::a_token(BaudRate(1_500_000), 3, 22_000)]
#[case::the_longest(BaudRate(9_600), 255, 292_187_500)]
fn a_frame_lasts_eleven_bits_per_byte(#[case] baud: BaudRate, #[case] octets: usize, #[case] nanoseconds: u64) {
    let mut listener = BusScript::default();
    let mut bus = VirtualBus::new(baud, SLOT);
    bus.inject(4, &vec![0; octets]).expect("no other port is sending");
    bus.run(&mut [&mut listener], Time::from_nanos(1_000_000_000), &mut |_| {});
    assert_eq!(listener.heard, [0]);
    assert_eq!(listener.received, [(nanoseconds, vec![0; octets])]);
}

#[test]
fn an_answer_in_time_is_no_violation() {
    let end = bits(11 * 11);
    for delay in [11, 12, 300] {
        let (bus, listener, seen) = run(&[(0, &REQUEST)], &[(end + bits(delay), &ANSWER)]);
        assert_eq!(bus.violations(), []);
        assert_eq!(listener.received.len(), 2);
        let begin = end + bits(delay);
        assert_eq!(seen[1], (begin, begin + bits(11), 1, ANSWER.to_vec()));
    }
}

#[rstest]
#[case::too_early(10, Some("port 1 answered at 0.000087 after 10 bit times; min TSDR is 11"))]
#[case::too_late(301, Some("port 1 answered at 0.000281 after 301 bit times; the slot time is 300"))]
fn an_answer_at_the_wrong_time_is_a_violation(#[case] delay: u64, #[case] objection: Option<&str>) {
    let (bus, listener, _) = run(&[(0, &REQUEST)], &[(bits(11 * 11) + bits(delay), &ANSWER)]);
    let reported: Vec<_> = bus.violations().iter().map(ToString::to_string).collect();
    assert_eq!(reported.first().map(String::as_str), objection);
    assert_eq!(listener.received.len(), 2, "it is transmitted nevertheless");
}

#[rstest]
#[case::at_max_tsdr(150, &[])]
#[case::after_max_tsdr(151, &["port 1 answered at 0.000181 after 151 bit times; max TSDR is 150"])]
#[case::after_the_slot_time(301, &["port 1 answered at 0.000281 after 301 bit times; the slot time is 300"])]
fn with_max_tsdr_an_answer_within_the_slot_time_may_be_too_late(#[case] delay: u64, #[case] objections: &[&str]) {
    let mut asking = BusScript::new(&[(0, &REQUEST)]);
    let mut answering = BusScript::new(&[(bits(11 * 11) + bits(delay), &ANSWER)]);
    let mut bus = VirtualBus::new(BAUD, SLOT).with_max_tsdr(Some(BitTimes(150)));
    bus.run(&mut [&mut asking, &mut answering], Time::from_nanos(10_000_000), &mut |_| {});
    let reported: Vec<_> = bus.violations().iter().map(ToString::to_string).collect();
    assert_eq!(reported, objections);
}

/// A master may ask for a min TSDR that is longer than max TSDR and the slot time; the slave that obeys is not late.
#[rstest]
#[case::obeyed(0xFF, 255, &[])]
#[case::later(0xFF, 301, &["port 1 answered at 0.000494 after 301 bit times; the slot time is 300"])]
#[case::not_asked_for(0x00, 255, &["port 1 answered at 0.000464 after 255 bit times; max TSDR is 150"])]
fn a_slave_obeys_the_min_tsdr_of_its_set_prm(#[case] min_tsdr: u8, #[case] delay: u64, #[case] objections: &[&str]) {
    let prm = [0x83, 0x82, 0x7D, 0x3D, 0x3E, 0x88, 20, 5, min_tsdr, 0x16, 0x55, 0];
    let sum = prm.iter().fold(0_u8, |sum, octet| sum.wrapping_add(*octet));
    let prm = [&[0x68, 12, 12, 0x68], prm.as_slice(), &[sum, 0x16]].concat();
    let acknowledged = bits(18 * 11) + bits(11);
    let asked = acknowledged + bits(11) + bits(100);
    let mut asking = BusScript::new(&[(0, &prm), (asked, &REQUEST)]);
    let mut answering = BusScript::new(&[(acknowledged, &ANSWER), (asked + bits(11 * 11) + bits(delay), &ANSWER)]);
    let mut bus = VirtualBus::new(BAUD, SLOT).with_max_tsdr(Some(BitTimes(150)));
    bus.run(&mut [&mut asking, &mut answering], Time::from_nanos(10_000_000), &mut |_| {});
    let reported: Vec<_> = bus.violations().iter().map(ToString::to_string).collect();
    assert_eq!(reported, objections);
}

#[rstest]
#[case::request(&REQUEST)]
#[case::token(&TOKEN)]
fn a_request_needs_silence_before_it(#[case] octets: &[u8]) {
    let end = bits(3 * 11);
    let (bus, _, _) = run(&[(0, &TOKEN), (end + bits(32), octets)], &[]);
    assert_eq!(
        bus.violations(),
        [WireViolation::NoSilence { port: 0, time: Time::from_nanos(end + bits(32)), silent: 32 }]
    );
    let (bus, _, _) = run(&[(0, &TOKEN), (end + bits(33), octets)], &[]);
    assert_eq!(bus.violations(), []);
}

#[test]
fn what_a_port_sends_while_it_sends_follows_without_gap() {
    let (bus, listener, _) = run(&[(0, &TOKEN), (1_000, &TOKEN)], &[]);
    assert_eq!(listener.received, [(bits(33), TOKEN.to_vec()), (bits(66), TOKEN.to_vec())]);
    assert_eq!(bus.violations(), [WireViolation::NoSilence { port: 0, time: Time::from_nanos(bits(33)), silent: 0 }]);
}

#[test]
fn frames_that_overlap_are_lost() {
    let (bus, listener, seen) = run(&[(0, &REQUEST)], &[(bits(60), &ANSWER)]);
    let time = Time::from_nanos(bits(60));
    assert_eq!(bus.violations(), [WireViolation::Collision { port: 1, time, other: 0 }]);
    assert_eq!(seen.len(), 1);
    assert_eq!((seen[0].0, seen[0].1, seen[0].2), (0, bits(11 * 11), 0));
    assert!(FdlFrame::parse(&seen[0].3).is_err());
    assert_eq!(listener.received, [(bits(11 * 11), seen[0].3.clone())]);
    assert_eq!(listener.heard, [0]);
}

#[test]
fn two_equal_frames_that_begin_at_once_are_lost_too() {
    let (bus, listener, seen) = run(&[(0, &ANSWER)], &[(0, &ANSWER)]);
    assert_eq!(bus.violation_count(), 1);
    assert_eq!((seen.len(), listener.received.len()), (1, 1));
    assert!(FdlFrame::parse(&seen[0].3).is_err());
}

#[test]
fn a_collision_lasts_as_long_as_both() {
    let (_, listener, seen) = run(&[(0, &TOKEN)], &[(bits(20), &REQUEST)]);
    assert_eq!((seen[0].0, seen[0].1), (0, bits(20) + bits(11 * 11)));
    assert_eq!(listener.received.len(), 1);
    // A third frame after both begins a burst of its own.
    let later = bits(200);
    let (bus, listener, _) = run(&[(0, &TOKEN), (later, &TOKEN)], &[(bits(20), &REQUEST)]);
    assert_eq!((bus.violation_count(), listener.received.len()), (1, 2));
}

#[test]
fn a_sender_does_not_receive_its_own_frames() {
    let (mut a, mut b) = (BusScript::new(&[(0, &REQUEST)]), BusScript::new(&[(bits(60), &ANSWER)]));
    let mut bus = VirtualBus::new(BAUD, SLOT);
    bus.run(&mut [&mut a, &mut b], Time::from_nanos(1_000_000), &mut |_| {});
    assert_eq!((a.received.len(), b.received.len()), (0, 0));
    assert_eq!((a.heard.len(), b.heard.len()), (0, 1));
}

#[rstest]
#[case::nothing(0)]
#[case::too_long(256)]
fn a_frame_of_impossible_length_is_refused(#[case] length: usize) {
    let mut bus = VirtualBus::new(BAUD, SLOT);
    assert_eq!(bus.inject(3, &vec![0; length]), Err(WireViolation::NoFrame { port: 3, time: Time::ZERO, length }));
}

#[test]
fn a_bus_queues_half_a_second_and_drops_the_rest() {
    let mut bus = VirtualBus::new(BaudRate(9_600), SLOT);
    let dropped = (0..4).filter(|_| matches!(bus.inject(0, &[0; 255]), Err(WireViolation::Congested { .. }))).count();
    // Each frame lasts 292 ms: two lie within 500 ms, the third begins there.
    assert_eq!(dropped, 2);
}

#[test]
fn events_at_one_instant_have_an_order() {
    // The second frame begins when the first has ended, and the listener receives the end before the begin.
    let end = bits(33);
    let (_, listener, _) = run(&[(0, &TOKEN)], &[(end, &[0x00])]);
    assert_eq!(listener.heard, [0, end]);
    assert_eq!(listener.received, [(end, TOKEN.to_vec()), (end + bits(11), vec![0x00])]);
}

#[test]
fn a_reflector_answers_with_the_request() {
    let mut reflector = BusReflector::new(Duration::from_nanos(bits(11)));
    let mut asker = BusScript::new(&[(0, &REQUEST)]);
    let mut bus = VirtualBus::new(BAUD, SLOT);
    let mut seen = Vec::new();
    bus.run(&mut [&mut asker, &mut reflector], Time::from_nanos(1_000_000), &mut |frame| {
        seen.push((frame.port, frame.frame.to_vec()));
    });
    assert_eq!((seen.len(), &seen[2].1[..]), (3, &REQUEST[..]));
    let Ok(FdlFrame::Data(answer)) = FdlFrame::parse(&seen[1].1) else { panic!("{seen:?}") };
    assert_eq!((answer.da, answer.sa, answer.source.sap, answer.destination.sap), (2, 3, Some(60), Some(62)));
}

#[test]
fn a_babbler_sends_the_same_bytes_for_the_same_seed() {
    let babble = |seed| {
        let mut babbler = BusBabbler::new(seed, Duration::from_micros(500), 3, 2);
        let mut seen = Vec::new();
        let mut bus = VirtualBus::new(BAUD, SLOT);
        bus.run(&mut [&mut babbler], Time::from_nanos(50_000_000), &mut |frame| seen.push(frame.frame.to_vec()));
        seen
    };
    assert_eq!(babble(1), babble(1));
    assert_ne!(babble(1), babble(2));
    let frames = babble(1);
    let good = frames.iter().filter(|octets| FdlFrame::parse(octets).is_ok()).count();
    assert!(good > 20 && good < frames.len(), "{good} of {}", frames.len());
}
