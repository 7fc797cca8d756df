//! The virtual Ethernet segment and its clock.
//!
//! Deterministic: the same stations and inputs give the same frames at the same nanoseconds, on every machine.

use std::collections::VecDeque;

use station::{Duration, Outbox, Station, Time};

use crate::violation::WireViolation;
use crate::wakes::{ViolationLog, Wakes};

/// One byte at 100 Mbit/s, in nanoseconds.
const OCTET: u64 = 80;
/// Preamble and start-of-frame delimiter, in bytes (IEEE 802.3, 3.1.1).
const PREAMBLE: usize = 8;
/// Frame check sequence, in bytes.
const CHECK_SEQUENCE: usize = 4;
/// Interpacket gap between two frames of one sender, in byte times.
const GAP: usize = 12;
/// Latency of a switch, typically some microseconds; in nanoseconds.
const SWITCH_LATENCY: u64 = 3_000;
/// Length of two addresses and an EtherType.
const SHORTEST: usize = 14;
/// The length to which a network interface pads a shorter frame, in bytes without check sequence.
const PADDED: usize = 60;
/// Longest untagged frame in bytes, without check sequence.
const LONGEST: usize = 1514;
/// Length of an 802.1Q tag, in bytes.
const TAG: usize = 4;
/// Maximum backlog of queued frames of a port.
const BACKLOG: Duration = Duration::from_millis(100);

/// A virtual switched segment at 100 Mbit/s full duplex, with any number of stations and the clock they share.
///
/// The caller owns the stations and passes them to each step; a station's port is its index in that slice. A frame sent at `t`
/// arrives at every other port after its last bit: preamble, frame and check sequence at 80 ns per byte, plus 3 µs for the
/// switch. Frames of one sender queue. Frames shorter than 60 bytes arrive padded with zeros, as network interfaces send them.
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
    objections: ViolationLog,
}

/// The result of one [`VirtualWire::step`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VirtualStep {
    /// Nothing was left to do before the given time, and the clock stands there.
    Idle,
    /// A frame was delivered or a station was woken.
    Worked,
}

/// A frame as recorded by a tap in the middle of the segment.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TappedFrame<'a> {
    /// When its first bit is sent.
    pub begin: Time,
    /// When it arrives at the other ports.
    pub time: Time,
    /// The port that sent it.
    pub port: usize,
    /// Its bytes: on Ethernet from the destination address, padded to 60, without check sequence; on PROFIBUS all.
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
    /// A silent segment; its clock starts at [`Time::ZERO`].
    pub fn new() -> VirtualWire {
        VirtualWire::default()
    }

    /// The current time.
    pub fn now(&self) -> Time {
        self.now
    }

    /// Violations of the wire rules by the stations, in order; the first thousand are stored.
    pub fn violations(&self) -> &[WireViolation] {
        self.objections.stored()
    }

    /// Number of violations, including those that are not stored.
    pub fn violation_count(&self) -> u64 {
        self.objections.count()
    }

    /// Advances the clock to the next event, but not beyond `until`, and processes it.
    ///
    /// An event is one frame that arrives at all other ports (in port order), or the wake-up of one station. After each event all
    /// frames that the station sends are queued. At the same instant arrivals come first (by order of sending), then wake-ups (by
    /// port). Deadlines are queried again at every step, so the caller may use the stations in between; a deadline in the past is
    /// due now. `tap` receives every frame once, when it arrives.
    pub fn step(
        &mut self,
        stations: &mut [&mut dyn Station],
        until: Time,
        tap: &mut dyn FnMut(TappedFrame<'_>),
    ) -> VirtualStep {
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
                return VirtualStep::Idle;
            }
        }
        VirtualStep::Worked
    }

    /// Steps until nothing is left to do before `until`; the clock then stands at `until`.
    pub fn run(&mut self, stations: &mut [&mut dyn Station], until: Time, tap: &mut dyn FnMut(TappedFrame<'_>)) {
        while self.step(stations, until, tap) == VirtualStep::Worked {}
    }

    /// Sends `frame` now as if the station at `port` had sent it; a `port` without a station is allowed.
    ///
    /// Returns the violation, if any; it is also stored in [`violations`](Self::violations).
    pub fn inject(&mut self, port: usize, frame: &[u8]) -> Result<(), WireViolation> {
        if self.lines.len() <= port {
            self.lines.resize(port + 1, Time::ZERO);
        }
        self.transmit(port, frame)
    }

    fn deliver(&mut self, stations: &mut [&mut dyn Station], tap: &mut dyn FnMut(TappedFrame<'_>)) {
        let Some(flight) = self.in_flight.pop_front() else { return };
        tap(TappedFrame { begin: flight.begin, time: self.now, port: flight.port, frame: &flight.frame });
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

    /// Queues the frames in the outbox of the station at `port`.
    fn drain(&mut self, port: usize) {
        let mut sent = std::mem::take(&mut self.outbox);
        for frame in sent.frames() {
            // The violation is stored; as on a real wire, the sender is not notified.
            let _ = self.transmit(port, frame);
        }
        sent.clear();
        self.outbox = sent;
    }

    fn transmit(&mut self, port: usize, frame: &[u8]) -> Result<(), WireViolation> {
        let length = frame.len();
        let tag = if frame.get(12..14) == Some(&[0x81, 0x00]) { TAG } else { 0 };
        let time = self.now;
        let start = self.lines[port].max(time);
        if length < SHORTEST {
            return Err(self.objections.raise(WireViolation::TooShort { port, time, length }));
        }
        if length > LONGEST + tag {
            return Err(self.objections.raise(WireViolation::TooLong { port, time, length }));
        }
        if start.since(time) > BACKLOG {
            return Err(self.objections.raise(WireViolation::Congested { port, time }));
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

/// The duration of `count` bytes at 100 Mbit/s, in nanoseconds.
fn octets(count: usize) -> u64 {
    count as u64 * OCTET
}

#[cfg(test)]
mod tests;
