//! A serial line, against a peer that is played octet by octet at the controlling end of a pseudoterminal.

use encspec_link::serial::pty;
use encspec_link::{Clock, Heard, LinkError, Piece, Serial, SerialBus, SerialSettings, Split, Step};
use station::{Duration, Outbox, Station, Time};
use std::fs::File;
use std::io::{Read, Write};
use std::path::Path;
use std::thread;
use testing::patience::patiently;

/// Frames of a toy protocol: the first octet, 1 to 9, says how many follow; anything else is damage up to the next silence.
#[derive(Default)]
struct Counted(Vec<u8>);

impl Split for Counted {
    fn push(&mut self, octets: &[u8]) {
        self.0.extend_from_slice(octets);
    }

    fn next_piece(&mut self) -> Option<Piece> {
        let count = usize::from(*self.0.first()?);
        if !(1..=9).contains(&count) || self.0.len() < count + 1 {
            return None;
        }
        let rest = self.0.split_off(count + 1);
        Some(Piece { octets: std::mem::replace(&mut self.0, rest), is_frame: true })
    }

    fn silence(&mut self) -> Option<Piece> {
        let octets = std::mem::take(&mut self.0);
        (!octets.is_empty()).then_some(Piece { octets, is_frame: false })
    }

    fn is_waiting(&self) -> bool {
        !self.0.is_empty()
    }
}

/// Sends frames at given times, and remembers what it heard.
#[derive(Default)]
struct Script {
    frames: Vec<(Time, Vec<u8>)>,
    carriers: usize,
    received: Vec<Vec<u8>>,
}

impl Station for Script {
    fn carrier(&mut self, _now: Time) {
        self.carriers += 1;
    }

    fn receive(&mut self, _now: Time, frame: &[u8], _out: &mut Outbox) {
        self.received.push(frame.to_vec());
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        while let Some((_, octets)) = self.frames.first().filter(|(due, _)| *due <= now).cloned() {
            out.push(&octets);
            self.frames.remove(0);
        }
    }

    fn deadline(&self) -> Option<Time> {
        self.frames.first().map(|(due, _)| *due)
    }
}

fn open(settings: &SerialSettings) -> (SerialBus, File) {
    let (control, path) = pty::open().expect("there are pseudoterminals");
    let serial = Serial::open(&path, settings).expect("the other end is there");
    assert!(serial.is_pty());
    (SerialBus::new(serial, Box::<Counted>::default()), control)
}

fn bus() -> (SerialBus, File) {
    open(&SerialSettings::new(1_500_000))
}

/// Runs for `time`; gives what the tap saw: sender, whether a frame, octets.
fn run(bus: &mut SerialBus, stations: &mut [&mut dyn Station], time: Duration) -> Vec<(Option<usize>, bool, Vec<u8>)> {
    let until = bus.now() + time;
    let mut seen = Vec::new();
    let mut last = Time::ZERO;
    let mut tap = |heard: Heard<'_>| {
        assert!(heard.begin <= heard.end && heard.end >= last);
        last = heard.end;
        seen.push((heard.sender, heard.is_frame, heard.octets.to_vec()));
    };
    while bus.step(stations, until, &mut |_| true, &mut tap).expect("the line works") == Step::Worked {}
    seen
}

const A_WHILE: Duration = Duration::from_millis(60);
const LONG: Duration = Duration::from_secs(5);

#[test]
fn every_octet_goes_out_and_comes_in_as_it_is() {
    patiently(|| {
        let (control, path) = pty::open().expect("there are pseudoterminals");
        let mut serial = Serial::open(&path, &SerialSettings::new(19_200)).expect("the other end is there");
        let all: Vec<u8> = (0..=255).collect();
        serial.send(&all).expect("it takes them");
        let mut came = [0; 256];
        (&control).read_exact(&mut came).expect("they arrive");
        assert_eq!(came[..], all[..]);

        (&control).write_all(&all).expect("it takes them");
        let mut came = Vec::new();
        let clock = Clock::start();
        while came.len() < 256 && clock.now() < Time::ZERO + LONG {
            serial.wait(&clock, Time::ZERO + LONG).expect("the line works");
            serial.receive(&mut came).expect("the line works");
        }
        assert_eq!(came, all);
    });
}

#[test]
fn a_frame_in_two_pieces_is_heard_to_begin_and_received_when_it_is_whole() {
    patiently(|| {
        let (mut bus, mut control) = bus();
        let mut station = Script::default();
        control.write_all(&[3, 0xA]).expect("it takes them");
        bus.serial().wait(bus.clock(), bus.now() + LONG).expect("the octets come");
        let now = bus.now();
        bus.step(&mut [&mut station], now, &mut |_| true, &mut |_| ()).expect("it works");
        assert_eq!((station.carriers, station.received.len()), (1, 0));
        control.write_all(&[0xB, 0xC, 1, 0xD]).expect("it takes them");
        let seen = run(&mut bus, &mut [&mut station], A_WHILE);
        assert_eq!(station.received, [vec![3, 0xA, 0xB, 0xC], vec![1, 0xD]]);
        assert_eq!(seen, [(None, true, vec![3, 0xA, 0xB, 0xC]), (None, true, vec![1, 0xD])]);
    });
}

#[test]
fn what_is_no_frame_comes_as_damage_after_a_silence() {
    patiently(|| {
        let (mut bus, mut control) = bus();
        let mut station = Script::default();
        control.write_all(&[0xFF, 1, 2]).expect("it takes them");
        let seen = run(&mut bus, &mut [&mut station], A_WHILE);
        assert_eq!(seen, [(None, false, vec![0xFF, 1, 2])]);
        control.write_all(&[1, 7]).expect("it takes them");
        run(&mut bus, &mut [&mut station], A_WHILE);
        assert_eq!(station.received, [vec![0xFF, 1, 2], vec![1, 7]]);
    });
}

#[test]
fn stations_send_when_they_are_due_and_hear_each_other() {
    patiently(|| {
        let (mut bus, mut control) = bus();
        let due = bus.now() + Duration::from_millis(10);
        let mut first = Script { frames: vec![(due, vec![1, 0x55])], ..Script::default() };
        let mut second = Script::default();
        let seen = run(&mut bus, &mut [&mut first, &mut second], A_WHILE);
        assert_eq!(seen, [(Some(0), true, vec![1, 0x55])]);
        assert_eq!((second.carriers, second.received), (1, vec![vec![1, 0x55]]));
        assert_eq!((first.carriers, first.received.len()), (0, 0));
        let mut came = [0; 2];
        control.read_exact(&mut came).expect("it arrives");
        assert_eq!(came, [1, 0x55]);
        assert_eq!(bus.lateness().wakes().count(), 1);
    });
}

#[test]
fn what_the_guard_holds_back_is_not_sent() {
    patiently(|| {
        let (mut bus, _control) = bus();
        let mut station = Script { frames: vec![(Time::ZERO, vec![1, 0x55])], ..Script::default() };
        let until = bus.now() + A_WHILE;
        let mut seen = 0;
        while bus.step(&mut [&mut station], until, &mut |_| false, &mut |_| seen += 1).expect("it works")
            == Step::Worked
        {}
        assert_eq!((seen, bus.held_back()), (0, 1));
    });
}

#[test]
fn a_bus_on_which_somebody_speaks_is_refused() {
    patiently(|| {
        let (mut bus, mut control) = bus();
        bus.refuse_traffic(A_WHILE).expect("nobody says anything");
        control.write_all(&[2, 0xAB, 0xCD]).expect("it takes them");
        let error = bus.refuse_traffic(A_WHILE).expect_err("somebody speaks").to_string();
        assert!(error.ends_with(": 02 AB CD; take the other master off the bus"), "{error}");
    });
}

#[test]
fn a_restart_forgets_what_came_before() {
    patiently(|| {
        let (mut bus, mut control) = bus();
        control.write_all(&[1, 2]).expect("it takes them");
        bus.serial().wait(bus.clock(), bus.now() + LONG).expect("the octets come");
        let before = bus.now();
        bus.restart();
        assert!(bus.now() < before + LONG);
        assert_eq!(run(&mut bus, &mut [], A_WHILE), []);
    });
}

#[test]
fn what_comes_back_of_ones_own_is_left_out() {
    patiently(|| {
        let settings = SerialSettings { echo: true, ..SerialSettings::new(19_200) };
        let (mut bus, mut control) = open(&settings);
        let mut station = Script { frames: vec![(Time::ZERO, vec![2, 3, 3])], ..Script::default() };
        let echo = thread::spawn(move || {
            let mut came = [0; 3];
            control.read_exact(&mut came).expect("they arrive");
            control.write_all(&came).expect("it takes them");
            control.write_all(&[1, 8]).expect("it takes them");
            control
        });
        let seen = run(&mut bus, &mut [&mut station], A_WHILE);
        let mut control = echo.join().expect("the peer works");
        assert_eq!(seen, [(Some(0), true, vec![2, 3, 3]), (None, true, vec![1, 8])]);
        assert_eq!(bus.serial().garbled(), 0);
        // Something else than what was sent comes back: somebody else was sending.
        station.frames.push((bus.now(), vec![1, 4]));
        run(&mut bus, &mut [&mut station], A_WHILE);
        control.write_all(&[1, 5]).expect("it takes them");
        let seen = run(&mut bus, &mut [&mut station], A_WHILE);
        assert_eq!((seen, bus.serial().garbled()), (vec![(None, true, vec![1, 5])], 1));
    });
}

#[test]
fn a_line_whose_other_end_is_closed_is_gone() {
    patiently(|| {
        let (mut bus, control) = bus();
        drop(control);
        let error = bus.step(&mut [], Time::MAX, &mut |_| true, &mut |_| ()).expect_err("it is gone");
        assert!(error.is_gone(), "{error}");
        let until = bus.now() + Duration::from_millis(50);
        assert!(bus.recover(until).is_err_and(|error| error.is_gone()));
    });
}

#[test]
fn what_is_no_line_is_refused_in_a_sentence() {
    patiently(|| {
        let settings = SerialSettings::new(9_600);
        let refused = |path: &str| match Serial::open(Path::new(path), &settings) {
            Err(LinkError::Unusable(why)) => why,
            other => panic!("{other:?}"),
        };
        assert_eq!(refused("/dev/null"), "/dev/null is no serial line");
        let absent = refused("/dev/no-such-line");
        assert!(absent.starts_with("the serial line /dev/no-such-line cannot be opened"), "{absent}");
        assert!(absent.ends_with("is the adapter plugged in?"), "{absent}");
    });
}

#[test]
fn a_pseudoterminal_of_ours_outlives_who_opens_its_other_end() {
    patiently(|| {
        let folder = testing::Folder::new("pty");
        let link = folder.join("line");
        let settings = SerialSettings::new(19_200);
        let mut ours = Serial::controlling(&link, &settings).expect("there are pseudoterminals");
        let again = Serial::controlling(&link, &settings).expect_err("the link is there already").to_string();
        assert!(again.contains("cannot be made"), "{again}");
        let clock = Clock::start();
        for round in 1..=2 {
            let mut theirs = Serial::open(&link, &settings).expect("the other end is there");
            assert!(theirs.is_pty());
            theirs.send(&[round, 0x0A, 0x0D]).expect("it takes them");
            let mut came = Vec::new();
            while came.len() < 3 && clock.now() < Time::ZERO + LONG {
                ours.wait(&clock, Time::ZERO + LONG).expect("the line works");
                ours.receive(&mut came).expect("the line works");
            }
            assert_eq!(came, [round, 0x0A, 0x0D]);
            drop(theirs);
            assert_eq!(ours.receive(&mut came).ok(), Some(false), "nobody is there, and the line is");
        }
        drop(ours);
        assert!(!link.exists() && std::fs::symlink_metadata(&link).is_err());
    });
}
