//! A serial line, against a peer that the test plays byte by byte at the controlling end of a pseudoterminal.

use encspec_link::serial::pty;
use encspec_link::{
    BusTransmission, Clock, Framing, LinePiece, LinkError, Serial, SerialBus, SerialSettings, WireStep,
};
use station::{Duration, Outbox, Station, Time};
use std::fs::File;
use std::io::{Read, Write};
use std::path::Path;
use std::thread;
use testing::stall::retry_on_stall;

/// Framing of a toy protocol: the first byte, 1 to 9, is the number of bytes that follow; anything else is damaged up to the next
/// silence.
#[derive(Default)]
struct CountedFraming(Vec<u8>);

impl Framing for CountedFraming {
    fn push(&mut self, octets: &[u8]) {
        self.0.extend_from_slice(octets);
    }

    fn next_piece(&mut self) -> Option<LinePiece> {
        let count = usize::from(*self.0.first()?);
        if !(1..=9).contains(&count) || self.0.len() < count + 1 {
            return None;
        }
        let rest = self.0.split_off(count + 1);
        Some(LinePiece { octets: std::mem::replace(&mut self.0, rest), is_frame: true })
    }

    fn silence(&mut self) -> Option<LinePiece> {
        let octets = std::mem::take(&mut self.0);
        (!octets.is_empty()).then_some(LinePiece { octets, is_frame: false })
    }

    fn is_waiting(&self) -> bool {
        !self.0.is_empty()
    }
}

/// Sends frames at given times and records what it receives.
#[derive(Default)]
struct TimedSender {
    frames: Vec<(Time, Vec<u8>)>,
    carriers: usize,
    received: Vec<Vec<u8>>,
    received_last: Time,
}

impl Station for TimedSender {
    fn carrier(&mut self, _now: Time) {
        self.carriers += 1;
    }

    fn receive(&mut self, now: Time, frame: &[u8], _out: &mut Outbox) {
        self.received.push(frame.to_vec());
        self.received_last = now;
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
    (SerialBus::new(serial, Box::<CountedFraming>::default()), control)
}

fn bus() -> (SerialBus, File) {
    open(&SerialSettings::new(1_500_000))
}

/// Runs for `time`; returns what the tap got: sender, whether a valid frame, bytes.
fn run(bus: &mut SerialBus, stations: &mut [&mut dyn Station], time: Duration) -> Vec<(Option<usize>, bool, Vec<u8>)> {
    let until = bus.now() + time;
    let mut observed = Vec::new();
    let mut last = Time::ZERO;
    let mut tap = |sent: BusTransmission<'_>| {
        assert!(sent.begin <= sent.end && sent.end >= last);
        last = sent.end;
        observed.push((sent.sender, sent.is_frame, sent.octets.to_vec()));
    };
    while bus.step(stations, until, &mut |_| true, &mut tap).expect("the line works") == WireStep::Worked {}
    observed
}

const A_WHILE: Duration = Duration::from_millis(60);
const LONG: Duration = Duration::from_secs(5);

#[test]
fn every_byte_is_sent_and_received_unchanged() {
    retry_on_stall(|| {
        let (control, path) = pty::open().expect("there are pseudoterminals");
        let mut serial = Serial::open(&path, &SerialSettings::new(19_200)).expect("the other end is there");
        let all: Vec<u8> = (0..=255).collect();
        serial.send(&all).expect("the line accepts them");
        let mut received = [0; 256];
        (&control).read_exact(&mut received).expect("they arrive");
        assert_eq!(received[..], all[..]);

        (&control).write_all(&all).expect("the line accepts them");
        let mut received = Vec::new();
        let clock = Clock::start();
        while received.len() < 256 && clock.now() < Time::ZERO + LONG {
            serial.wait(&clock, Time::ZERO + LONG).expect("the line works");
            serial.receive(&mut received).expect("the line works");
        }
        assert_eq!(received, all);
    });
}

#[test]
fn a_frame_in_two_pieces_is_reported_at_its_start_and_delivered_when_complete() {
    retry_on_stall(|| {
        let (mut bus, mut control) = bus();
        let mut station = TimedSender::default();
        control.write_all(&[3, 0xA]).expect("the line accepts them");
        bus.serial().wait(bus.clock(), bus.now() + LONG).expect("the bytes arrive");
        let now = bus.now();
        bus.step(&mut [&mut station], now, &mut |_| true, &mut |_| ()).expect("it works");
        assert_eq!((station.carriers, station.received.len()), (1, 0));
        control.write_all(&[0xB, 0xC, 1, 0xD]).expect("the line accepts them");
        let observed = run(&mut bus, &mut [&mut station], A_WHILE);
        assert_eq!(station.received, [vec![3, 0xA, 0xB, 0xC], vec![1, 0xD]]);
        assert_eq!(observed, [(None, true, vec![3, 0xA, 0xB, 0xC]), (None, true, vec![1, 0xD])]);
    });
}

#[test]
fn bytes_that_are_not_a_frame_are_reported_as_damaged_after_a_silence() {
    retry_on_stall(|| {
        let (mut bus, mut control) = bus();
        let mut station = TimedSender::default();
        control.write_all(&[0xFF, 1, 2]).expect("the line accepts them");
        let observed = run(&mut bus, &mut [&mut station], A_WHILE);
        assert_eq!(observed, [(None, false, vec![0xFF, 1, 2])]);
        control.write_all(&[1, 7]).expect("the line accepts them");
        run(&mut bus, &mut [&mut station], A_WHILE);
        assert_eq!(station.received, [vec![0xFF, 1, 2], vec![1, 7]]);
    });
}

/// A deadline that follows from the delivery counts from the end of the silence; otherwise the host would seem to be late.
#[test]
fn bytes_that_a_silence_ends_are_delivered_after_it() {
    retry_on_stall(|| {
        let (mut bus, mut control) = bus();
        let mut station = TimedSender::default();
        control.write_all(&[3, 0xA]).expect("the line accepts them");
        let until = bus.now() + A_WHILE;
        let mut end = None;
        let mut tap = |sent: BusTransmission<'_>| end = Some(sent.end);
        while bus.step(&mut [&mut station], until, &mut |_| true, &mut tap).expect("it works") == WireStep::Worked {}
        let silence = station.received_last.since(end.expect("they are reported"));
        assert!(silence >= Duration::from_millis(20), "{silence:?}");
    });
}

#[test]
fn stations_send_when_due_and_receive_each_others_frames() {
    retry_on_stall(|| {
        let (mut bus, mut control) = bus();
        let due = bus.now() + Duration::from_millis(10);
        let mut first = TimedSender { frames: vec![(due, vec![1, 0x55])], ..TimedSender::default() };
        let mut second = TimedSender::default();
        let observed = run(&mut bus, &mut [&mut first, &mut second], A_WHILE);
        assert_eq!(observed, [(Some(0), true, vec![1, 0x55])]);
        assert_eq!((second.carriers, second.received), (1, vec![vec![1, 0x55]]));
        assert_eq!((first.carriers, first.received.len()), (0, 0));
        let mut received = [0; 2];
        control.read_exact(&mut received).expect("it arrives");
        assert_eq!(received, [1, 0x55]);
        assert_eq!(bus.lateness().wakes().count(), 1);
    });
}

#[test]
fn a_frame_that_the_guard_holds_back_is_not_sent() {
    retry_on_stall(|| {
        let (mut bus, _control) = bus();
        let mut station = TimedSender { frames: vec![(Time::ZERO, vec![1, 0x55])], ..TimedSender::default() };
        let until = bus.now() + A_WHILE;
        let mut tapped = 0;
        while bus.step(&mut [&mut station], until, &mut |_| false, &mut |_| tapped += 1).expect("it works")
            == WireStep::Worked
        {}
        assert_eq!((tapped, bus.held_back()), (0, 1));
    });
}

#[test]
fn a_bus_on_which_another_station_sends_is_refused() {
    retry_on_stall(|| {
        let (mut bus, mut control) = bus();
        bus.refuse_traffic(A_WHILE).expect("no station sends");
        control.write_all(&[2, 0xAB, 0xCD]).expect("the line accepts them");
        let error = bus.refuse_traffic(A_WHILE).expect_err("a station sends").to_string();
        assert!(error.ends_with(": 02 AB CD; disconnect the other master from the bus"), "{error}");
    });
}

#[test]
fn a_restart_discards_bytes_received_before() {
    retry_on_stall(|| {
        let (mut bus, mut control) = bus();
        control.write_all(&[1, 2]).expect("the line accepts them");
        bus.serial().wait(bus.clock(), bus.now() + LONG).expect("the bytes arrive");
        let before = bus.now();
        bus.restart();
        assert!(bus.now() < before + LONG);
        assert_eq!(run(&mut bus, &mut [], A_WHILE), []);
    });
}

#[test]
fn the_echo_of_sent_bytes_is_removed() {
    retry_on_stall(|| {
        let settings = SerialSettings { echo: true, ..SerialSettings::new(19_200) };
        let (mut bus, mut control) = open(&settings);
        let mut station = TimedSender { frames: vec![(Time::ZERO, vec![2, 3, 3])], ..TimedSender::default() };
        let echo = thread::spawn(move || {
            let mut sent = [0; 3];
            control.read_exact(&mut sent).expect("they arrive");
            control.write_all(&sent).expect("the line accepts them");
            control.write_all(&[1, 8]).expect("the line accepts them");
            control
        });
        let observed = run(&mut bus, &mut [&mut station], A_WHILE);
        let mut control = echo.join().expect("the peer works");
        assert_eq!(observed, [(Some(0), true, vec![2, 3, 3]), (None, true, vec![1, 8])]);
        assert_eq!(bus.serial().echo_errors(), 0);
        // The echo differs from the sent bytes: another station was sending.
        station.frames.push((bus.now(), vec![1, 4]));
        run(&mut bus, &mut [&mut station], A_WHILE);
        control.write_all(&[1, 5]).expect("the line accepts them");
        let observed = run(&mut bus, &mut [&mut station], A_WHILE);
        assert_eq!((observed, bus.serial().echo_errors()), (vec![(None, true, vec![1, 5])], 1));
    });
}

#[test]
fn a_line_whose_other_end_is_closed_is_gone() {
    retry_on_stall(|| {
        let (mut bus, control) = bus();
        drop(control);
        let error = bus.step(&mut [], Time::MAX, &mut |_| true, &mut |_| ()).expect_err("it is gone");
        assert!(error.is_gone(), "{error}");
        let until = bus.now() + Duration::from_millis(50);
        assert!(bus.recover(until).is_err_and(|error| error.is_gone()));
    });
}

#[test]
fn the_error_of_an_unusable_line_is_one_sentence() {
    retry_on_stall(|| {
        let settings = SerialSettings::new(9_600);
        let refused = |path: &str| match Serial::open(Path::new(path), &settings) {
            Err(LinkError::Unusable(why)) => why,
            other => panic!("{other:?}"),
        };
        assert_eq!(refused("/dev/null"), "/dev/null is not a serial line");
        let absent = refused("/dev/no-such-line");
        assert!(absent.starts_with("the serial line /dev/no-such-line cannot be opened"), "{absent}");
        assert!(absent.ends_with("is the adapter plugged in?"), "{absent}");
    });
}

#[test]
fn a_pseudoterminal_stays_when_its_other_end_is_closed() {
    retry_on_stall(|| {
        let folder = testing::Folder::new("pty");
        let link = folder.join("line");
        let settings = SerialSettings::new(19_200);
        let mut controlling = Serial::controlling(&link, &settings).expect("there are pseudoterminals");
        let again = Serial::controlling(&link, &settings).expect_err("the link is there already").to_string();
        assert!(again.contains("cannot create the link"), "{again}");
        let clock = Clock::start();
        for round in 1..=2 {
            let mut far = Serial::open(&link, &settings).expect("the other end is there");
            assert!(far.is_pty());
            far.send(&[round, 0x0A, 0x0D]).expect("the line accepts them");
            let mut received = Vec::new();
            while received.len() < 3 && clock.now() < Time::ZERO + LONG {
                controlling.wait(&clock, Time::ZERO + LONG).expect("the line works");
                controlling.receive(&mut received).expect("the line works");
            }
            assert_eq!(received, [round, 0x0A, 0x0D]);
            drop(far);
            assert_eq!(
                controlling.receive(&mut received).ok(),
                Some(false),
                "the line stays without a program at its other end"
            );
        }
        drop(controlling);
        assert!(!link.exists() && std::fs::symlink_metadata(&link).is_err());
    });
}
