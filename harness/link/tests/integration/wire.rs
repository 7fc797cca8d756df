//! Stations on a live wire: a port that is played by the test, and a virtual cable.

use crate::common::{A_WHILE, LONG, frame, two_ends};
use encspec_link::{Clock, LinkError, Local, Nic, Port, Step, Wire, namespace};
use station::{Duration, Outbox, Station, Time};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use testing::patience::patiently;

const ONE: [u8; 6] = [0x02, 0, 0, 0, 0, 0x01];
const TWO: [u8; 6] = [0x02, 0, 0, 0, 0, 0x02];
const THREE: [u8; 6] = [0x02, 0, 0, 0, 0, 0x03];
const ALL: [u8; 6] = [0xFF; 6];
const GROUP: [u8; 6] = [0x01, 0x0E, 0xCF, 0, 0, 0];
const STRANGER: [u8; 6] = [0x02, 0, 0, 0, 0, 0x55];

/// What a played port has in store and what it was given, shared with the test.
#[derive(Default)]
struct Line {
    /// Frames that come in, each so long after the start of the wire.
    incoming: VecDeque<(Time, Vec<u8>)>,
    sent: Vec<Vec<u8>>,
    gone: bool,
}

#[derive(Clone, Default)]
struct Played(Arc<Mutex<Line>>);

impl Played {
    fn line(&self) -> MutexGuard<'_, Line> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Port for Played {
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

/// A station that keeps what happens to it, sends `sends` at each of its deadlines and answers nothing.
#[derive(Default)]
struct Scripted {
    deadlines: VecDeque<Time>,
    sends: Vec<Vec<u8>>,
    received: Vec<(Time, Vec<u8>)>,
    woken: Vec<Time>,
    /// Wants to be woken at once, for ever.
    restless: bool,
    /// A frame puts an end to all of its deadlines.
    gives_up: bool,
}

impl Scripted {
    fn at(deadlines: impl IntoIterator<Item = u64>, sends: &[Vec<u8>]) -> Scripted {
        let deadlines = deadlines.into_iter().map(millis).collect();
        Scripted { deadlines, sends: sends.to_vec(), ..Scripted::default() }
    }
}

impl Station for Scripted {
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

/// Steps until nothing is left up to `until`; returns what the tap saw.
fn run(wire: &mut Wire, stations: &mut [Local<'_>], until: Time) -> Vec<(Time, Vec<u8>)> {
    let mut seen = Vec::new();
    let mut tap = |time, frame: &[u8]| seen.push((time, frame.to_vec()));
    while wire.step(stations, until, &mut |_| true, &mut tap).expect("the line works") == Step::Worked {}
    assert!(wire.now() >= until);
    seen
}

fn played() -> (Played, Wire) {
    let port = Played::default();
    (port.clone(), Wire::new(Box::new(port)))
}

#[test]
fn a_frame_reaches_the_station_that_it_is_for_and_a_group_reaches_all() {
    patiently(|| {
        let (port, mut wire) = played();
        for to in [ONE, TWO, ALL, GROUP, STRANGER] {
            port.line().incoming.push_back((millis(1), frame(to, 60)));
        }
        port.line().incoming.push_back((millis(2), vec![1, 2, 3]));
        let (mut one, mut two) = (Scripted::default(), Scripted::default());
        let seen = run(&mut wire, &mut [(ONE, &mut one), (TWO, &mut two)], millis(5));
        let to = |station: &Scripted| station.received.iter().map(|(_, frame)| frame[..6].to_vec()).collect::<Vec<_>>();
        assert_eq!(to(&one), [ONE, ALL, GROUP]);
        assert_eq!(to(&two), [TWO, ALL, GROUP]);
        assert_eq!(seen.len(), 6, "the tap also sees what is for nobody here");
        assert_eq!(seen[5], (millis(2), vec![1, 2, 3]));
        assert!(one.received.iter().all(|(time, _)| *time == millis(1)), "the time is that of the arrival");
    });
}

#[test]
fn what_a_station_sends_goes_out_and_reaches_the_others_here() {
    patiently(|| {
        let (port, mut wire) = played();
        let sends = [frame(TWO, 60), frame(GROUP, 60), frame(STRANGER, 64), frame(ONE, 14)];
        let mut one = Scripted::at([1], &sends);
        let (mut two, mut three) = (Scripted::default(), Scripted::default());
        let seen = run(&mut wire, &mut [(ONE, &mut one), (TWO, &mut two), (THREE, &mut three)], millis(5));
        let mut filled_up = frame(ONE, 14);
        filled_up.resize(60, 0);
        let all = [sends[0].clone(), sends[1].clone(), sends[2].clone(), filled_up];
        assert_eq!(port.line().sent, all);
        assert_eq!(seen.iter().map(|(_, frame)| frame.clone()).collect::<Vec<_>>(), all, "each is shown once");
        assert_eq!(one.received, [], "nobody hears itself");
        assert_eq!(two.received.iter().map(|(_, frame)| frame.clone()).collect::<Vec<_>>(), sends[..2]);
        assert_eq!(three.received.iter().map(|(_, frame)| frame.clone()).collect::<Vec<_>>(), sends[1..2]);
        assert!(two.received[0].0 >= one.woken[0]);
    });
}

#[test]
fn what_the_guard_refuses_is_seen_by_nobody() {
    patiently(|| {
        let (port, mut wire) = played();
        let mut one = Scripted::at([1], &[frame(TWO, 60), frame(GROUP, 61)]);
        let mut two = Scripted::default();
        let mut shown = 0;
        let mut asked = Vec::new();
        let mut guard = |frame: &[u8]| {
            asked.push(frame[..6].to_vec());
            frame[..6] == GROUP
        };
        let stations: &mut [Local<'_>] = &mut [(ONE, &mut one), (TWO, &mut two)];
        while wire.step(stations, millis(3), &mut guard, &mut |_, _| shown += 1) == Ok(Step::Worked) {}
        assert_eq!(asked, [TWO, GROUP]);
        assert_eq!(port.line().sent, [frame(GROUP, 61)]);
        assert_eq!((shown, two.received.len(), wire.held_back()), (1, 1, 1));
    });
}

#[test]
fn frames_that_wait_come_before_stations_that_are_due() {
    patiently(|| {
        let (port, mut wire) = played();
        for number in 0..1000_u16 {
            let mut numbered = frame(ONE, 60);
            numbered[14..16].copy_from_slice(&number.to_be_bytes());
            port.line().incoming.push_back((millis(2), numbered));
        }
        let mut one = Scripted::at([1, 1, 1], &[]);
        // All of it lies in the past once the first step is done.
        let stations: &mut [Local<'_>] = &mut [(ONE, &mut one)];
        while wire.now() < millis(3) {}
        while wire.step(stations, millis(3), &mut |_| true, &mut |_, _| {}) == Ok(Step::Worked) {}
        assert_eq!(one.received.len(), 1000);
        assert_eq!(one.woken.len(), 3, "a flood does not keep the stations asleep for ever");
        let first = one.woken[0];
        let before = one.received.iter().take_while(|(time, _)| *time < first).count();
        assert!((1..=256).contains(&before), "{before} frames came before the first wake");
        let numbers: Vec<_> =
            one.received.iter().map(|(_, frame)| u16::from_be_bytes([frame[14], frame[15]])).collect();
        assert!(numbers.is_sorted());
    });
}

#[test]
fn nobody_is_woken_early_and_lateness_is_counted() {
    patiently(|| {
        let (_port, mut wire) = played();
        let mut one = Scripted::at((1..=50).map(|n| n * 2), &[frame(STRANGER, 60)]);
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

/// A frame that waited while we were away ends what was due before it is done, as the end of a connection does.
#[test]
fn what_is_overdue_and_then_put_off_was_late_all_the_same() {
    patiently(|| {
        let (port, mut wire) = played();
        port.line().incoming.push_back((millis(5), frame(ONE, 60)));
        let mut one = Scripted { gives_up: true, ..Scripted::at([1], &[frame(STRANGER, 60)]) };
        while wire.now() < millis(6) {
            std::thread::yield_now();
        }
        run(&mut wire, &mut [(ONE, &mut one)], millis(8));
        assert_eq!((one.woken.len(), one.received.len()), (0, 1));
        assert!(wire.lateness().wakes().max() >= Duration::from_millis(5), "{:?}", wire.lateness().wakes().max());
    });
}

#[test]
fn what_is_due_later_than_asked_for_is_left_for_later() {
    patiently(|| {
        let (port, mut wire) = played();
        port.line().incoming.push_back((millis(1), frame(ONE, 60)));
        port.line().incoming.push_back((millis(20), frame(ONE, 61)));
        let mut one = Scripted::at([2, 21], &[]);
        run(&mut wire, &mut [(ONE, &mut one)], millis(10));
        assert_eq!((one.received.len(), one.woken.len()), (1, 1));
        while wire.now() < millis(25) {}
        run(&mut wire, &mut [(ONE, &mut one)], millis(15));
        assert_eq!((one.received.len(), one.woken.len()), (1, 1), "although the clock is past it");
        run(&mut wire, &mut [(ONE, &mut one)], millis(22));
        assert_eq!((one.received.len(), one.woken.len()), (2, 2));
        assert_eq!(one.received[1].0, millis(20), "it is still the time of the arrival");
    });
}

#[test]
fn a_step_comes_back_although_nothing_happens() {
    patiently(|| {
        let (_port, mut wire) = played();
        let mut one = Scripted::default();
        let before = wire.now();
        let step = wire.step(&mut [(ONE, &mut one)], Time::MAX, &mut |_| true, &mut |_, _| {});
        let took = wire.now().since(before);
        assert_eq!(step, Ok(Step::Worked));
        assert!(took >= Duration::from_millis(100) && took < LONG, "{took:?}");
    });
}

#[test]
fn a_station_that_wants_to_be_woken_for_ever_keeps_nobody_from_anything() {
    patiently(|| {
        let (_port, mut wire) = played();
        let mut restless = Scripted { restless: true, ..Scripted::default() };
        let mut two = Scripted::at([5], &[]);
        run(&mut wire, &mut [(ONE, &mut restless), (TWO, &mut two)], millis(20));
        assert_eq!(two.woken.len(), 1);
        assert!(restless.woken.len() >= 1000, "it is left alone only after a thousand wakes");
    });
}

#[test]
fn what_is_shown_never_goes_back_in_time() {
    patiently(|| {
        let (port, mut wire) = played();
        // The kernel's times may be earlier than what a station has just sent, and out of order.
        for at in [30, 10, 20] {
            port.line().incoming.push_back((millis(at), frame(ALL, 60)));
        }
        let mut one = Scripted::at([5, 25, 35], &[frame(STRANGER, 60)]);
        let seen = run(&mut wire, &mut [(ONE, &mut one)], millis(50));
        assert_eq!(seen.len(), 6);
        assert!(seen.is_sorted_by_key(|(time, _)| *time), "{seen:?}");
        assert!(one.received.is_sorted_by_key(|(time, _)| *time));
    });
}

#[test]
fn a_restart_sets_the_clock_to_zero_and_forgets_what_waited() {
    patiently(|| {
        let (port, mut wire) = played();
        let mut one = Scripted::at([1], &[frame(TWO, 60)]);
        let mut two = Scripted::default();
        port.line().incoming.push_back((millis(3), frame(ALL, 60)));
        let stations: &mut [Local<'_>] = &mut [(ONE, &mut one), (TWO, &mut two)];
        while wire.now() < millis(100) {}
        port.line().incoming.push_back((millis(90), frame(ALL, 60)));
        for _ in 0..2 {
            wire.step(stations, millis(4), &mut |_| true, &mut |_, _| {}).expect("the line works");
        }
        assert_eq!(port.line().incoming.len(), 0, "one is looked at and kept");
        port.line().incoming.push_back((millis(91), frame(ALL, 60)));
        wire.restart();
        assert!(wire.now() < millis(100));
        let (mut fresh, mut other) = (Scripted::at([1], &[]), Scripted::default());
        let seen = run(&mut wire, &mut [(ONE, &mut other), (TWO, &mut fresh)], millis(3));
        assert_eq!(seen, [], "nothing that lay there is shown");
        assert_eq!(
            (fresh.received.len(), fresh.woken.len()),
            (0, 1),
            "nor delivered, nor what was on its way among stations"
        );
        assert_eq!((one.woken.len(), two.received.len()), (1, 1));
    });
}

#[test]
fn a_line_that_is_gone_is_an_error_until_it_is_recovered() {
    patiently(|| {
        let (port, mut wire) = played();
        port.line().gone = true;
        let mut one = Scripted::at([1, 2], &[frame(STRANGER, 60)]);
        let gone = LinkError::Gone("the peer is gone".to_string());
        let mut shown = 0;
        let stations: &mut [Local<'_>] = &mut [(ONE, &mut one)];
        assert_eq!(wire.step(stations, millis(10), &mut |_| true, &mut |_, _| shown += 1), Err(gone));
        wire.recover(millis(20)).expect("it comes back");
        while wire.step(stations, millis(10), &mut |_| true, &mut |_, _| shown += 1) == Ok(Step::Worked) {}
        assert_eq!((shown, port.line().sent.len()), (2, 2));
    });
}

#[test]
fn two_wires_speak_over_a_cable_at_one_millisecond() {
    patiently(|| {
        if !two_ends() {
            return;
        }
        let open = |name| Nic::open(name).unwrap_or_else(|error| panic!("{error}"));
        let (left, right) = (open("left"), open("right"));
        let mut near = Wire::new(Box::new(left));
        let mut one = Scripted::at(1..=200, &[frame(TWO, 60)]);
        let far = std::thread::spawn(move || {
            let mut far = Wire::new(Box::new(right));
            let mut two = Scripted::default();
            let mut seen = 0;
            while seen < 200 && far.now() < Time::ZERO + LONG {
                let until = far.now() + A_WHILE;
                seen += run(&mut far, &mut [(TWO, &mut two)], until).len();
            }
            (two, seen)
        });
        let sent = run(&mut near, &mut [(ONE, &mut one)], millis(250));
        let (two, seen) = far.join().expect("the far end runs");
        assert_eq!((sent.len(), seen, two.received.len()), (200, 200, 200));
        assert_eq!(near.lateness().wakes().count(), 200);
    });
}

#[test]
fn a_wire_whose_interface_is_taken_down_says_so_and_goes_on_when_it_is_back() {
    patiently(|| {
        if !two_ends() {
            return;
        }
        let mut wire = Wire::new(Box::new(Nic::open("left").unwrap_or_else(|error| panic!("{error}"))));
        let mut one = Scripted::default();
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
