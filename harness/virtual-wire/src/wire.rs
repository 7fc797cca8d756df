//! The virtual Ethernet segment and its clock.
//!
//! Deterministic: the same stations and inputs give the same frames at the same nanoseconds, on every machine.

use std::collections::VecDeque;

use station::{Duration, Outbox, Station, Time};

use crate::violation::Violation;
use crate::wakes::{Objections, Wakes};

/// One octet at 100 Mbit/s, in nanoseconds.
const OCTET: u64 = 80;
/// Preamble and start-of-frame delimiter, in octets (IEEE 802.3, 3.1.1).
const PREAMBLE: usize = 8;
/// Frame check sequence, in octets.
const CHECK_SEQUENCE: usize = 4;
/// Silence between two frames of one sender, in octets' worth of time.
const GAP: usize = 12;
/// A switch of an installation hands a frame on after some microseconds; in nanoseconds.
const SWITCH_LATENCY: u64 = 3_000;
/// Two addresses and an EtherType.
const SHORTEST: usize = 14;
/// What a network interface fills a shorter frame up to, in octets without check sequence.
const PADDED: usize = 60;
/// Longest untagged frame in octets, without check sequence.
const LONGEST: usize = 1514;
/// What an 802.1Q tag adds, in octets.
const TAG: usize = 4;
/// How far ahead of the clock the frames that a port has queued may reach.
const BACKLOG: Duration = Duration::from_millis(100);

/// A virtual switched segment at 100 Mbit/s full duplex, with any number of stations and the clock they share.
///
/// The stations belong to the caller and are handed in at each step; a station's port is its index in that slice.
/// A frame sent at `t` arrives at every other port once its last bit is through: preamble, frame, check sequence at
/// 80 ns an octet, then 3 µs of switch. The frames of one sender queue behind each other. Frames shorter than 60
/// octets arrive padded with zeros, as network interfaces send them.
#[derive(Debug, Default)]
pub struct VirtualWire {
    now: Time,
    /// Sorted by arrival, then by order of sending.
    in_flight: VecDeque<Flight>,
    spare: Vec<Vec<u8>>,
    outbox: Outbox,
    /// When the line of each port is free again.
    lines: Vec<Time>,
    wakes: Wakes,
    objections: Objections,
}

/// What one [`VirtualWire::step`] did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// Nothing was left to do up to the time given, and the clock stands there.
    Idle,
    /// A frame was delivered or a station was woken.
    Worked,
}

/// A frame as a tap in the middle of the segment sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seen<'a> {
    /// When its first bit is sent.
    pub begin: Time,
    /// When it has arrived at the other ports.
    pub time: Time,
    /// The port that sent it.
    pub port: usize,
    /// Its octets: on Ethernet from the destination address, padded to 60, without check sequence; on PROFIBUS all.
    pub frame: &'a [u8],
}

#[derive(Debug)]
struct Flight {
    begin: Time,
    arrival: Time,
    port: usize,
    frame: Vec<u8>,
}

impl VirtualWire {
    /// A silent segment whose clock stands at [`Time::ZERO`].
    pub fn new() -> VirtualWire {
        VirtualWire::default()
    }

    /// What the clock shows.
    pub fn now(&self) -> Time {
        self.now
    }

    /// What the stations did that no wire carries, in order; the first thousand are kept.
    pub fn violations(&self) -> &[Violation] {
        self.objections.kept()
    }

    /// How many violations there were, those included that are not kept.
    pub fn violations_seen(&self) -> u64 {
        self.objections.seen()
    }

    /// Moves the clock to the next event, but not beyond `until`, and lets it happen.
    ///
    /// An event is one frame reaching all the other ports (in port order) or one station being woken; after each
    /// input all frames that the station sends are taken over. Of events at one instant, arrivals come first (by
    /// order of sending), then wakes (by port). Deadlines are asked for anew at every step, so that the caller may
    /// act on stations in between; one that lies in the past is due now. `tap` sees every frame once, as it arrives.
    pub fn step(&mut self, stations: &mut [&mut dyn Station], until: Time, tap: &mut dyn FnMut(Seen<'_>)) -> Step {
        if self.lines.len() < stations.len() {
            self.lines.resize(stations.len(), Time::ZERO);
        }
        let arrival = self.in_flight.front().map(|flight| flight.arrival).filter(|arrival| *arrival <= until);
        let wake = self.wakes.earliest(self.now, stations).filter(|(due, _)| *due <= until);
        match (arrival, wake) {
            (Some(arrival), due) if due.is_none_or(|(due, _)| arrival <= due) => {
                self.now = self.now.max(arrival);
                self.deliver(stations, tap);
            }
            (_, Some((due, port))) => {
                self.now = due;
                self.wake(port, stations);
            }
            (_, None) => {
                self.now = self.now.max(until);
                return Step::Idle;
            }
        }
        Step::Worked
    }

    /// Steps until nothing is left to do up to `until`; the clock then stands there.
    pub fn run(&mut self, stations: &mut [&mut dyn Station], until: Time, tap: &mut dyn FnMut(Seen<'_>)) {
        while self.step(stations, until, tap) == Step::Worked {}
    }

    /// Sends `frame` now as though the station at `port` had sent it; a `port` without station is an extra one.
    ///
    /// Returns what the wire objects to, which is also kept among the [`violations`](Self::violations).
    pub fn inject(&mut self, port: usize, frame: &[u8]) -> Result<(), Violation> {
        if self.lines.len() <= port {
            self.lines.resize(port + 1, Time::ZERO);
        }
        self.transmit(port, frame)
    }

    fn deliver(&mut self, stations: &mut [&mut dyn Station], tap: &mut dyn FnMut(Seen<'_>)) {
        let Some(flight) = self.in_flight.pop_front() else { return };
        tap(Seen { begin: flight.begin, time: self.now, port: flight.port, frame: &flight.frame });
        for (port, station) in stations.iter_mut().enumerate().filter(|(port, _)| *port != flight.port) {
            station.receive(self.now, &flight.frame, &mut self.outbox);
            if !self.outbox.is_empty() {
                self.drain(port);
            }
        }
        self.spare.push(flight.frame);
    }

    fn wake(&mut self, port: usize, stations: &mut [&mut dyn Station]) {
        stations[port].wake(self.now, &mut self.outbox);
        if !self.outbox.is_empty() {
            self.drain(port);
        }
        if let Some(livelock) = self.wakes.woken(self.now, port) {
            self.objections.raise(livelock);
        }
    }

    /// Takes over what the station at `port` has put into the outbox.
    fn drain(&mut self, port: usize) {
        let mut sent = std::mem::take(&mut self.outbox);
        for frame in sent.frames() {
            // The violation is on record; the sender learns no more of it than on a real wire.
            let _ = self.transmit(port, frame);
        }
        sent.clear();
        self.outbox = sent;
    }

    fn transmit(&mut self, port: usize, frame: &[u8]) -> Result<(), Violation> {
        let length = frame.len();
        let tag = if frame.get(12..14) == Some(&[0x81, 0x00]) { TAG } else { 0 };
        let time = self.now;
        let start = self.lines[port].max(time);
        if length < SHORTEST {
            return Err(self.objections.raise(Violation::TooShort { port, time, length }));
        }
        if length > LONGEST + tag {
            return Err(self.objections.raise(Violation::TooLong { port, time, length }));
        }
        if start.since(time) > BACKLOG {
            return Err(self.objections.raise(Violation::Congested { port, time }));
        }

        let on_the_line = PREAMBLE + length.max(PADDED) + CHECK_SEQUENCE;
        self.lines[port] = start.after_nanos(octets(on_the_line + GAP));
        let arrival = start.after_nanos(octets(on_the_line) + SWITCH_LATENCY);

        let mut padded = self.spare.pop().unwrap_or_default();
        padded.clear();
        padded.extend_from_slice(frame);
        padded.resize(length.max(PADDED), 0);
        let flight = Flight { begin: start, arrival, port, frame: padded };
        match self.in_flight.iter().rev().take_while(|flight| flight.arrival > arrival).count() {
            0 => self.in_flight.push_back(flight),
            behind => self.in_flight.insert(self.in_flight.len() - behind, flight),
        }
        Ok(())
    }
}

/// How many nanoseconds `count` octets take at 100 Mbit/s.
fn octets(count: usize) -> u64 {
    count as u64 * OCTET
}

#[cfg(test)]
mod tests;
