use rstest::rstest;

use super::*;

/// Sends frames of given lengths at given times, and records what it received and when it was woken.
#[derive(Default)]
struct WireScript {
    frames: VecDeque<(u64, usize)>,
    received: Vec<(u64, Vec<u8>)>,
    woken: Vec<u64>,
}

impl WireScript {
    fn new(frames: &[(u64, usize)]) -> WireScript {
        WireScript { frames: frames.iter().copied().collect(), ..WireScript::default() }
    }

    fn arrivals(&self) -> Vec<(u64, usize)> {
        self.received.iter().map(|(time, frame)| (*time, frame.len())).collect()
    }
}

impl Station for WireScript {
    fn receive(&mut self, now: Time, frame: &[u8], _out: &mut Outbox) {
        self.received.push((now.as_nanos(), frame.to_vec()));
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        self.woken.push(now.as_nanos());
        while self.frames.front().is_some_and(|(time, _)| *time <= now.as_nanos()) {
            let (_, length) = self.frames.pop_front().expect("there is a first one");
            out.push(&vec![0xAA; length]);
        }
    }

    fn deadline(&self) -> Option<Time> {
        self.frames.front().map(|(time, _)| Time::from_nanos(*time))
    }
}

fn ignore(_: TappedFrame<'_>) {}

/// 8 + 64 bytes at 80 ns are 5,760 ns (IEEE 802.3: preamble and shortest frame), plus 3,000 ns for the switch.
const SHORT: u64 = 8_760;

#[rstest]
#[case::shortest_is_padded(14, 60, SHORT)]
#[case::sixty(60, 60, SHORT)]
#[case::sixty_one(61, 61, SHORT + 80)]
#[case::longest(1514, 1514, (8 + 1514 + 4) * 80 + 3_000)]
fn a_frame_takes_its_time_and_arrives_padded(#[case] length: usize, #[case] arrived: usize, #[case] after: u64) {
    let (mut a, mut b, mut c) = (WireScript::new(&[(100, length)]), WireScript::default(), WireScript::default());
    let mut seen = Vec::new();
    let mut wire = VirtualWire::new();
    wire.run(&mut [&mut a, &mut b, &mut c], Time::from_nanos(1_000_000), &mut |frame| {
        seen.push((frame.time.as_nanos(), frame.port, frame.frame.to_vec()));
    });
    assert_eq!(b.arrivals(), [(100 + after, arrived)]);
    assert_eq!(c.arrivals(), b.arrivals());
    assert_eq!(a.received, []);
    let mut expected = vec![0xAA; length];
    expected.resize(arrived, 0);
    assert_eq!(seen, [(100 + after, 0, expected)]);
    assert_eq!(wire.now(), Time::from_nanos(1_000_000));
}

#[test]
fn frames_of_one_sender_queue_and_frames_of_two_do_not() {
    let mut a = WireScript::new(&[(0, 1514), (0, 60), (50, 60)]);
    let mut b = WireScript::new(&[(10, 60)]);
    let mut seen = Vec::new();
    VirtualWire::new().run(&mut [&mut a, &mut b], Time::from_nanos(1_000_000), &mut |frame| {
        seen.push((frame.time.as_nanos(), frame.port, frame.frame.len()));
    });
    // The line is busy for 8 + 1514 + 4 + 12 bytes, then for 8 + 60 + 4 + 12.
    let (long, short) = (1_538 * 80, 84 * 80);
    assert_eq!(
        seen,
        [(10 + SHORT, 1, 60), (1_526 * 80 + 3_000, 0, 1514), (long + SHORT, 0, 60), (long + short + SHORT, 0, 60)]
    );
}

#[test]
fn events_at_one_instant_have_an_order() {
    // Both frames arrive at the time at which the third station requests its wake-up.
    let mut a = WireScript::new(&[(0, 60)]);
    let mut b = WireScript::new(&[(0, 61), (SHORT, 60)]);
    let mut c = WireScript::new(&[(SHORT, 14)]);
    let mut wire = VirtualWire::new();
    let mut order = Vec::new();
    loop {
        let step = wire.step(&mut [&mut a, &mut b, &mut c], Time::from_nanos(SHORT), &mut ignore);
        order.push((wire.now().as_nanos(), c.received.len(), a.woken.len(), b.woken.len(), c.woken.len()));
        if step == VirtualStep::Idle {
            break;
        }
    }
    assert_eq!(
        order,
        [
            (0, 0, 1, 0, 0),
            (0, 0, 1, 1, 0),
            (SHORT, 1, 1, 1, 0),
            (SHORT, 1, 1, 2, 0),
            (SHORT, 1, 1, 2, 1),
            (SHORT, 1, 1, 2, 1)
        ]
    );
}

#[test]
fn frames_that_arrive_together_arrive_in_the_order_of_sending() {
    let (mut a, mut b) = (WireScript::default(), WireScript::default());
    let mut wire = VirtualWire::new();
    for port in [3, 2, 4] {
        wire.inject(port, &[0; 60]).expect("a plain frame");
    }
    let mut ports = Vec::new();
    wire.run(&mut [&mut a, &mut b], Time::from_nanos(1_000_000), &mut |frame| ports.push(frame.port));
    assert_eq!(ports, [3, 2, 4]);
}

#[test]
fn the_clock_stops_at_the_given_time_and_never_goes_back() {
    let mut a = WireScript::new(&[(500, 60)]);
    let mut wire = VirtualWire::new();
    assert_eq!(wire.step(&mut [&mut a], Time::from_nanos(499), &mut ignore), VirtualStep::Idle);
    assert_eq!((wire.now().as_nanos(), a.woken.len()), (499, 0));
    assert_eq!(wire.step(&mut [&mut a], Time::from_nanos(500), &mut ignore), VirtualStep::Worked);
    assert_eq!(wire.step(&mut [&mut a], Time::from_nanos(3), &mut ignore), VirtualStep::Idle);
    assert_eq!(wire.now().as_nanos(), 500);
    wire.run(&mut [&mut a], Time::MAX, &mut ignore);
    assert_eq!(wire.now(), Time::MAX);
}

#[test]
fn a_deadline_in_the_past_is_due_now() {
    let mut a = WireScript::default();
    let mut wire = VirtualWire::new();
    wire.run(&mut [&mut a], Time::from_nanos(1_000), &mut ignore);
    a.frames.push_back((10, 60));
    wire.run(&mut [&mut a], Time::from_nanos(2_000), &mut ignore);
    assert_eq!(a.woken, [1_000]);
}

#[rstest]
#[case::no_ethertype(13, &[])]
#[case::too_long(1515, &[])]
#[case::tagged_too_long(1519, &[0x81, 0x00])]
fn the_wire_refuses_frames_of_impossible_length(#[case] length: usize, #[case] ethertype: &[u8]) {
    let mut frame = vec![0; length];
    frame.iter_mut().skip(12).zip(ethertype).for_each(|(octet, wanted)| *octet = *wanted);
    let mut b = WireScript::default();
    let mut wire = VirtualWire::new();
    let refused = wire.inject(5, &frame).expect_err("a frame of this length does not exist");
    wire.run(&mut [&mut b], Time::from_nanos(1_000_000), &mut ignore);
    assert_eq!(wire.violations(), [refused]);
    assert!(refused.to_string().contains(&format!("port 5 sent a frame of {length} bytes at 0.000000")), "{refused}");
    assert_eq!(b.received, []);
}

#[test]
fn an_injected_frame_reaches_all_stations_and_a_forged_one_all_but_its_sender() {
    let (mut a, mut b) = (WireScript::default(), WireScript::default());
    let mut wire = VirtualWire::new();
    let mut tagged = vec![1; 1518];
    tagged[12..14].copy_from_slice(&[0x81, 0x00]);
    wire.inject(2, &tagged).expect("a tag may be added to the longest frame");
    wire.inject(0, &[2; 60]).expect("a plain frame");
    wire.run(&mut [&mut a, &mut b], Time::from_nanos(1_000_000), &mut ignore);
    assert_eq!(a.arrivals(), [((8 + 1518 + 4) * 80 + 3_000, 1518)]);
    assert_eq!(b.arrivals(), [(SHORT, 60), ((8 + 1518 + 4) * 80 + 3_000, 1518)]);
}

#[test]
fn a_line_queues_a_tenth_of_a_second_and_drops_the_rest() {
    let mut flood = WireScript::new(&[(0, 1514); 2_000]);
    let mut b = WireScript::default();
    let mut wire = VirtualWire::new();
    wire.run(&mut [&mut flood, &mut b], Time::from_nanos(1_000_000_000), &mut ignore);
    // 100 ms hold 812 frames of 123,040 ns; one more begins before they end.
    assert_eq!(b.received.len(), 813);
    assert_eq!(wire.violation_count(), 2_000 - 813);
    assert_eq!(wire.violations().len(), 1_000);
    assert_eq!(wire.violations()[0], WireViolation::Congested { port: 0, time: Time::ZERO });
}

/// Requests its wake-up at the same instant forever.
struct Insomniac;

impl Station for Insomniac {
    fn receive(&mut self, _now: Time, _frame: &[u8], _out: &mut Outbox) {}

    fn wake(&mut self, _now: Time, _out: &mut Outbox) {}

    fn deadline(&self) -> Option<Time> {
        Some(Time::from_nanos(7))
    }
}

#[test]
fn a_station_that_never_sleeps_is_reported_and_does_not_stop_the_others() {
    let mut b = WireScript::new(&[(20, 60)]);
    let mut wire = VirtualWire::new();
    wire.run(&mut [&mut Insomniac, &mut b], Time::from_nanos(1_000_000), &mut ignore);
    assert_eq!(wire.violations(), [WireViolation::Livelock { port: 0, time: Time::from_nanos(7) }]);
    assert_eq!(b.woken, [20]);
    assert_eq!(wire.now(), Time::from_nanos(1_000_000));
}
