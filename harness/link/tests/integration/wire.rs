//! Stations on a live wire: with a port that the test simulates, and with a virtual cable.

use crate::common::{A_WHILE, LONG, frame, two_ends};
use encspec_link::{Clock, LinkError, LocalStation, Nic, Port, Wire, WireStep, namespace};
use station::{Duration, Outbox, Station, Time};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use testing::stall::retry_on_stall;

const ONE: [u8; 6] = [0x02, 0, 0, 0, 0, 0x01];
const TWO: [u8; 6] = [0x02, 0, 0, 0, 0, 0x02];
const THREE: [u8; 6] = [0x02, 0, 0, 0, 0, 0x03];
const ALL: [u8; 6] = [0xFF; 6];
const GROUP: [u8; 6] = [0x01, 0x0E, 0xCF, 0, 0, 0];
const ELSEWHERE: [u8; 6] = [0x02, 0, 0, 0, 0, 0x55];

/// The frames that a simulated port will receive and those it has sent, shared with the test.
#[derive(Default)]
struct PortState {
    /// Frames to receive, with the time since the start of the wire.
    incoming: VecDeque<(Time, Vec<u8>)>,
    sent: Vec<Vec<u8>>,
    gone: bool,
}

#[derive(Clone, Default)]
struct SimulatedPort(Arc<Mutex<PortState>>);

impl SimulatedPort {
    fn line(&self) -> MutexGuard<'_, PortState> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Port for SimulatedPort {
    fn send(&mut self, frame: &[u8]) -> Result<(), LinkError> {
        if self.line().gone {
            return Err(LinkError::Gone("the peer is gone".to_string()));
        }
        self.line().sent.push(frame.to_vec());
        Ok(())
    }

    fn receive(&mut self, clock: &Clock, until: Time, into: &mut Vec<u8>) -> Result<Option<Time>, LinkError> {
        loop {
            let mut line = self.line();
            if line.gone {
                return Err(LinkError::Gone("the peer is gone".to_string()));
            }
            let now = clock.now();
            if line.incoming.front().is_some_and(|(time, _)| *time <= now) {
                let (time, frame) = line.incoming.pop_front().expect("there is one");
                *into = frame;
                return Ok(Some(time));
            }
            drop(line);
            if now >= until {
                return Ok(None);
            }
            std::thread::yield_now();
        }
    }

    fn recover(&mut self, _: &Clock, _: Time) -> Result<(), LinkError> {
        self.line().gone = false;
        Ok(())
    }

    fn mac(&self) -> Option<[u8; 6]> {
        None
    }

    fn describe(&self) -> String {
        "the played line".to_string()
    }
}

/// A station that records its calls, sends `sends` at each of its deadlines and answers nothing.
#[derive(Default)]
struct ScriptedStation {
    deadlines: VecDeque<Time>,
    sends: Vec<Vec<u8>>,
    received: Vec<(Time, Vec<u8>)>,
    woken: Vec<Time>,
    /// Is always due.
    restless: bool,
    /// A received frame removes all of its deadlines.
    gives_up: bool,
}

impl ScriptedStation {
    fn at(deadlines: impl IntoIterator<Item = u64>, sends: &[Vec<u8>]) -> ScriptedStation {
        let deadlines = deadlines.into_iter().map(millis).collect();
        ScriptedStation { deadlines, sends: sends.to_vec(), ..ScriptedStation::default() }
    }
}

impl Station for ScriptedStation {
    fn receive(&mut self, now: Time, frame: &[u8], _: &mut Outbox) {
        self.received.push((now, frame.to_vec()));
        if self.gives_up {
            self.deadlines.clear();
        }
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        self.woken.push(now);
        self.deadlines.pop_front();
        for frame in &self.sends {
            out.push(frame);
        }
    }

    fn deadline(&self) -> Option<Time> {
        if self.restless { Some(Time::ZERO) } else { self.deadlines.front().copied() }
    }
}

fn millis(millis: u64) -> Time {
    Time::ZERO + Duration::from_millis(millis)
}

/// Steps until everything up to `until` is done; returns what the tap got.
fn run(wire: &mut Wire, stations: &mut [LocalStation<'_>], until: Time) -> Vec<(Time, Vec<u8>)> {
    let mut tapped = Vec::new();
    let mut tap = |time, frame: &[u8]| tapped.push((time, frame.to_vec()));
    while wire.step(stations, until, &mut |_| true, &mut tap).expect("the line works") == WireStep::Worked {}
    assert!(wire.now() >= until);
    tapped
}

fn played() -> (SimulatedPort, Wire) {
    let port = SimulatedPort::default();
    (port.clone(), Wire::new(Box::new(port)))
}

#[test]
fn a_unicast_frame_reaches_its_station_and_a_multicast_frame_reaches_all() {
    retry_on_stall(|| {
        let (port, mut wire) = played();
        for to in [ONE, TWO, ALL, GROUP, ELSEWHERE] {
            port.line().incoming.push_back((millis(1), frame(to, 60)));
        }
        port.line().incoming.push_back((millis(2), vec![1, 2, 3]));
        let (mut one, mut two) = (ScriptedStation::default(), ScriptedStation::default());
        let tapped = run(&mut wire, &mut [(ONE, &mut one), (TWO, &mut two)], millis(5));
        let to = |station: &ScriptedStation| {
            station.received.iter().map(|(_, frame)| frame[..6].to_vec()).collect::<Vec<_>>()
        };
        assert_eq!(to(&one), [ONE, ALL, GROUP]);
        assert_eq!(to(&two), [TWO, ALL, GROUP]);
        assert_eq!(tapped.len(), 6, "the tap also gets frames for stations elsewhere");
        assert_eq!(tapped[5], (millis(2), vec![1, 2, 3]));
        assert!(one.received.iter().all(|(time, _)| *time == millis(1)), "the time is the arrival time");
    });
}

#[test]
fn a_sent_frame_goes_to_the_port_and_to_the_other_stations_of_the_wire() {
    retry_on_stall(|| {
        let (port, mut wire) = played();
        let sends = [frame(TWO, 60), frame(GROUP, 60), frame(ELSEWHERE, 64), frame(ONE, 14)];
        let mut one = ScriptedStation::at([1], &sends);
        let (mut two, mut three) = (ScriptedStation::default(), ScriptedStation::default());
        let tapped = run(&mut wire, &mut [(ONE, &mut one), (TWO, &mut two), (THREE, &mut three)], millis(5));
        let mut padded = frame(ONE, 14);
        padded.resize(60, 0);
        let all = [sends[0].clone(), sends[1].clone(), sends[2].clone(), padded];
        assert_eq!(port.line().sent, all[1..], "a frame for another station of the wire stays there");
        assert_eq!(
            tapped.iter().map(|(_, frame)| frame.clone()).collect::<Vec<_>>(),
            all,
            "the tap gets each frame once"
        );
        assert_eq!(one.received, [], "a station does not receive its own frames");
        assert_eq!(two.received.iter().map(|(_, frame)| frame.clone()).collect::<Vec<_>>(), sends[..2]);
        assert_eq!(three.received.iter().map(|(_, frame)| frame.clone()).collect::<Vec<_>>(), sends[1..2]);
        assert!(two.received[0].0 >= one.woken[0]);
    });
}

#[test]
fn a_frame_that_the_guard_refuses_reaches_neither_port_nor_station() {
    retry_on_stall(|| {
        let (port, mut wire) = played();
        let mut one = ScriptedStation::at([1], &[frame(ALL, 60), frame(GROUP, 61)]);
        let mut two = ScriptedStation::default();
        let mut tapped = 0;
        let mut guarded = Vec::new();
        let mut guard = |frame: &[u8]| {
            guarded.push(frame[..6].to_vec());
            frame[..6] == GROUP
        };
        let stations: &mut [LocalStation<'_>] = &mut [(ONE, &mut one), (TWO, &mut two)];
        while wire.step(stations, millis(3), &mut guard, &mut |_, _| tapped += 1) == Ok(WireStep::Worked) {}
        assert_eq!(guarded, [ALL, GROUP]);
        assert_eq!(port.line().sent, [frame(GROUP, 61)]);
        assert_eq!((tapped, two.received.len(), wire.held_back()), (1, 1, 1));
    });
}

#[test]
fn waiting_frames_are_delivered_before_due_stations_are_woken() {
    retry_on_stall(|| {
        let (port, mut wire) = played();
        for number in 0..1000_u16 {
            let mut numbered = frame(ONE, 60);
            numbered[14..16].copy_from_slice(&number.to_be_bytes());
            port.line().incoming.push_back((millis(2), numbered));
        }
        let mut one = ScriptedStation::at([1, 1, 1], &[]);
        // All frames and deadlines are in the past before the first step.
        let stations: &mut [LocalStation<'_>] = &mut [(ONE, &mut one)];
        while wire.now() < millis(3) {}
        while wire.step(stations, millis(3), &mut |_| true, &mut |_, _| {}) == Ok(WireStep::Worked) {}
        assert_eq!(one.received.len(), 1000);
        assert_eq!(one.woken.len(), 3, "a flood of frames does not block the stations");
        let first = one.woken[0];
        let before = one.received.iter().take_while(|(time, _)| *time < first).count();
        assert!((1..=256).contains(&before), "{before} frames came before the first wake");
        let numbers: Vec<_> =
            one.received.iter().map(|(_, frame)| u16::from_be_bytes([frame[14], frame[15]])).collect();
        assert!(numbers.is_sorted());
    });
}

#[test]
fn no_station_is_woken_early_and_lateness_is_recorded() {
    retry_on_stall(|| {
        let (_port, mut wire) = played();
        let mut one = ScriptedStation::at((1..=50).map(|n| n * 2), &[frame(ELSEWHERE, 60)]);
        run(&mut wire, &mut [(ONE, &mut one)], millis(110));
        assert_eq!(one.woken.len(), 50);
        let late: Vec<_> =
            one.woken.iter().zip(1..).map(|(woken, n)| (woken.as_nanos()).checked_sub(n * 2_000_000)).collect();
        assert!(late.iter().all(Option::is_some), "{late:?}");
        let lateness = wire.lateness();
        assert_eq!((lateness.wakes().count(), lateness.gaps().count()), (50, 49));
        let worst = late.into_iter().flatten().max().expect("there are wakes");
        assert_eq!(lateness.wakes().max(), Duration::from_nanos(worst));
        assert!(lateness.wakes().p50() <= lateness.wakes().p99() && lateness.wakes().p999() <= lateness.wakes().max());
        let gaps: Vec<_> = one.woken.windows(2).map(|pair| pair[1].since(pair[0])).collect();
        assert_eq!(Some(lateness.gaps().max()), gaps.into_iter().max());
        wire.reset_lateness();
        assert_eq!((wire.lateness().wakes().count(), wire.lateness().gaps().max()), (0, Duration::ZERO));
    });
}

/// A frame that arrived while the wire was not stepped cancels an overdue deadline, as the end of a connection does.
#[test]
fn a_missed_deadline_that_a_frame_cancels_is_recorded_as_late() {
    retry_on_stall(|| {
        let (port, mut wire) = played();
        port.line().incoming.push_back((millis(5), frame(ONE, 60)));
        let mut one = ScriptedStation { gives_up: true, ..ScriptedStation::at([1], &[frame(ELSEWHERE, 60)]) };
        while wire.now() < millis(6) {
            std::thread::yield_now();
        }
        run(&mut wire, &mut [(ONE, &mut one)], millis(8));
        assert_eq!((one.woken.len(), one.received.len()), (0, 1));
        assert!(wire.lateness().wakes().max() >= Duration::from_millis(5), "{:?}", wire.lateness().wakes().max());
    });
}

#[test]
fn events_after_the_end_of_a_step_are_left_for_later_steps() {
    retry_on_stall(|| {
        let (port, mut wire) = played();
        port.line().incoming.push_back((millis(1), frame(ONE, 60)));
        port.line().incoming.push_back((millis(20), frame(ONE, 61)));
        let mut one = ScriptedStation::at([2, 21], &[]);
        run(&mut wire, &mut [(ONE, &mut one)], millis(10));
        assert_eq!((one.received.len(), one.woken.len()), (1, 1));
        while wire.now() < millis(25) {}
        run(&mut wire, &mut [(ONE, &mut one)], millis(15));
        assert_eq!((one.received.len(), one.woken.len()), (1, 1), "although the clock is past it");
        run(&mut wire, &mut [(ONE, &mut one)], millis(22));
        assert_eq!((one.received.len(), one.woken.len()), (2, 2));
        assert_eq!(one.received[1].0, millis(20), "the time is still the arrival time");
    });
}

#[test]
fn a_step_returns_although_nothing_happens() {
    retry_on_stall(|| {
        let (_port, mut wire) = played();
        let mut one = ScriptedStation::default();
        let before = wire.now();
        let step = wire.step(&mut [(ONE, &mut one)], Time::MAX, &mut |_| true, &mut |_, _| {});
        let took = wire.now().since(before);
        assert_eq!(step, Ok(WireStep::Worked));
        assert!(took >= Duration::from_millis(100) && took < LONG, "{took:?}");
    });
}

#[test]
fn a_station_that_is_always_due_does_not_block_the_others() {
    retry_on_stall(|| {
        let (_port, mut wire) = played();
        let mut restless = ScriptedStation { restless: true, ..ScriptedStation::default() };
        let mut two = ScriptedStation::at([5], &[]);
        run(&mut wire, &mut [(ONE, &mut restless), (TWO, &mut two)], millis(20));
        assert_eq!(two.woken.len(), 1);
        assert!(restless.woken.len() >= 1000, "it is suspended only after a thousand wakes");
    });
}

#[test]
fn reported_times_never_decrease() {
    retry_on_stall(|| {
        let (port, mut wire) = played();
        // The kernel's timestamps may be earlier than a frame that a station has just sent, and out of order.
        for at in [30, 10, 20] {
            port.line().incoming.push_back((millis(at), frame(ALL, 60)));
        }
        let mut one = ScriptedStation::at([5, 25, 35], &[frame(ELSEWHERE, 60)]);
        let tapped = run(&mut wire, &mut [(ONE, &mut one)], millis(50));
        assert_eq!(tapped.len(), 6);
        assert!(tapped.is_sorted_by_key(|(time, _)| *time), "{tapped:?}");
        assert!(one.received.is_sorted_by_key(|(time, _)| *time));
    });
}

#[test]
fn a_restart_sets_the_clock_to_zero_and_discards_waiting_frames() {
    retry_on_stall(|| {
        let (port, mut wire) = played();
        let mut one = ScriptedStation::at([1], &[frame(TWO, 60)]);
        let mut two = ScriptedStation::default();
        port.line().incoming.push_back((millis(3), frame(ALL, 60)));
        let stations: &mut [LocalStation<'_>] = &mut [(ONE, &mut one), (TWO, &mut two)];
        while wire.now() < millis(100) {}
        port.line().incoming.push_back((millis(90), frame(ALL, 60)));
        for _ in 0..2 {
            wire.step(stations, millis(4), &mut |_| true, &mut |_, _| {}).expect("the line works");
        }
        assert_eq!(port.line().incoming.len(), 0, "one frame is read and kept for later");
        port.line().incoming.push_back((millis(91), frame(ALL, 60)));
        wire.restart();
        assert!(wire.now() < millis(100));
        let (mut fresh, mut other) = (ScriptedStation::at([1], &[]), ScriptedStation::default());
        let tapped = run(&mut wire, &mut [(ONE, &mut other), (TWO, &mut fresh)], millis(3));
        assert_eq!(tapped, [], "no waiting frame is tapped");
        assert_eq!(
            (fresh.received.len(), fresh.woken.len()),
            (0, 1),
            "no waiting frame and no frame between stations is delivered"
        );
        assert_eq!((one.woken.len(), two.received.len()), (1, 1));
    });
}

#[test]
fn a_line_that_is_gone_is_an_error_until_it_is_recovered() {
    retry_on_stall(|| {
        let (port, mut wire) = played();
        port.line().gone = true;
        let mut one = ScriptedStation::at([1, 2], &[frame(ELSEWHERE, 60)]);
        let gone = LinkError::Gone("the peer is gone".to_string());
        let mut tapped = 0;
        let stations: &mut [LocalStation<'_>] = &mut [(ONE, &mut one)];
        assert_eq!(wire.step(stations, millis(10), &mut |_| true, &mut |_, _| tapped += 1), Err(gone));
        wire.recover(millis(20)).expect("it comes back");
        while wire.step(stations, millis(10), &mut |_| true, &mut |_, _| tapped += 1) == Ok(WireStep::Worked) {}
        assert_eq!((tapped, port.line().sent.len()), (2, 2));
    });
}

#[test]
fn two_wires_exchange_frames_over_a_cable_at_one_millisecond() {
    retry_on_stall(|| {
        if !two_ends() {
            return;
        }
        let open = |name| Nic::open(name).unwrap_or_else(|error| panic!("{error}"));
        let (left, right) = (open("left"), open("right"));
        let mut near = Wire::new(Box::new(left));
        let mut one = ScriptedStation::at(1..=200, &[frame(TWO, 60)]);
        let far = std::thread::spawn(move || {
            let mut far = Wire::new(Box::new(right));
            let mut two = ScriptedStation::default();
            let mut tapped = 0;
            while tapped < 200 && far.now() < Time::ZERO + LONG {
                let until = far.now() + A_WHILE;
                tapped += run(&mut far, &mut [(TWO, &mut two)], until).len();
            }
            (two, tapped)
        });
        let sent = run(&mut near, &mut [(ONE, &mut one)], millis(250));
        let (two, tapped) = far.join().expect("the far end runs");
        assert_eq!((sent.len(), tapped, two.received.len()), (200, 200, 200));
        assert_eq!(near.lateness().wakes().count(), 200);
    });
}

#[test]
fn a_wire_whose_interface_is_taken_down_fails_and_recovers_when_it_is_up_again() {
    retry_on_stall(|| {
        if !two_ends() {
            return;
        }
        let mut wire = Wire::new(Box::new(Nic::open("left").unwrap_or_else(|error| panic!("{error}"))));
        let mut one = ScriptedStation::default();
        namespace::run(&["link", "set", "left", "down"]).expect("left can be taken down");
        let error = loop {
            match wire.step(&mut [(ONE, &mut one)], wire.now() + LONG, &mut |_| true, &mut |_, _| {}) {
                Ok(_) => {}
                Err(error) => break error,
            }
        };
        assert!(error.is_gone(), "{error}");
        assert!(wire.recover(wire.now() + A_WHILE).is_err());
        namespace::run(&["link", "set", "left", "up"]).expect("left can be brought up");
        wire.recover(wire.now() + LONG).expect("it is back");
        let until = wire.now() + A_WHILE;
        run(&mut wire, &mut [(ONE, &mut one)], until);
    });
}
