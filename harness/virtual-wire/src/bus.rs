//! The virtual RS-485 bus and its clock.
//!
//! Deterministic: the same stations and inputs give the same frames at the same nanoseconds, on every machine.

use std::collections::VecDeque;

use station::{Duration, Outbox, Station, Time};
use wire::profibus::fdl::{BaudRate, BitTimes, LONGEST};

use crate::burst_role::BurstRole;
use crate::min_tsdr::MinTsdrs;
use crate::violation::WireViolation;
use crate::wakes::{ViolationLog, Wakes};
use crate::wire::{TappedFrame, VirtualStep};

/// Maximum backlog of queued frames of a port.
const BACKLOG: Duration = Duration::from_millis(500);

/// A virtual RS-485 bus, half duplex, with any number of stations and the clock they share.
///
/// The caller owns the stations and passes them to each step; a station's port is its index in that slice. A frame sent at `t`
/// has its first start bit at `t` and arrives at every other port with its last stop bit, 11 bits per byte later. Frames that a
/// port sends while it is still sending follow without a gap. Overlapping frames of two ports are lost: the other ports receive
/// noise that no parser accepts as a frame. Frames sent at a forbidden time are transmitted nevertheless and recorded as
/// violations.
#[derive(Debug)]
pub struct VirtualBus {
    baud: BaudRate,
    slot: BitTimes,
    /// Max TSDR of the stations on this bus, if they have one.
    max_tsdr: Option<BitTimes>,
    min_tsdrs: MinTsdrs,
    now: Time,
    /// Sorted by begin, without overlap.
    bursts: VecDeque<Burst>,
    /// Whether the other ports have been notified of the start of the first burst.
    is_carrier_reported: bool,
    /// The last finished burst.
    last: Option<FinishedBurst>,
    spare: Vec<Vec<u8>>,
    outbox: Outbox,
    wakes: Wakes,
    objections: ViolationLog,
}

/// Contiguous bytes of one port, or of several ports after a collision.
#[derive(Debug)]
struct Burst {
    begin: Time,
    end: Time,
    /// The port that began it.
    port: usize,
    /// The other ports that sent at the same time.
    others: Vec<usize>,
    part: BurstRole,
    octets: Vec<u8>,
}

/// The data of the previous burst that determine when the next frame may begin.
#[derive(Clone, Copy, Debug)]
struct FinishedBurst {
    end: Time,
    /// Whether a station must answer it.
    expects_answer: bool,
}

impl VirtualBus {
    /// A silent bus at `baud` with the slot time `slot`; its clock starts at [`Time::ZERO`].
    pub fn new(baud: BaudRate, slot: BitTimes) -> VirtualBus {
        VirtualBus {
            baud,
            slot,
            max_tsdr: None,
            min_tsdrs: MinTsdrs::default(),
            now: Time::ZERO,
            bursts: VecDeque::new(),
            is_carrier_reported: false,
            last: None,
            spare: Vec::new(),
            outbox: Outbox::new(),
            wakes: Wakes::default(),
            objections: ViolationLog::default(),
        }
    }

    /// The same bus, with answers later than `max_tsdr` after their request recorded as violations; `None`: only those after the
    /// slot time.
    pub fn with_max_tsdr(self, max_tsdr: Option<BitTimes>) -> VirtualBus {
        VirtualBus { max_tsdr, ..self }
    }

    /// The current time.
    pub fn now(&self) -> Time {
        self.now
    }

    /// Violations of the bus rules by the stations, in order; the first thousand are stored.
    pub fn violations(&self) -> &[WireViolation] {
        self.objections.stored()
    }

    /// Number of violations, including those that are not stored.
    pub fn violation_count(&self) -> u64 {
        self.objections.count()
    }

    /// Advances the clock to the next event, but not beyond `until`, and processes it.
    ///
    /// An event is a burst that begins or ends at all other ports (in port order), or the wake-up of one station. After each
    /// event all frames that the station sends are queued. At the same instant a burst that ends comes first, then wake-ups (by
    /// port), then a burst that begins; a burst that begins when it is sent is no separate step. Deadlines are queried again at
    /// every step, so the caller may use the stations in between; a deadline in the past is due now. `tap` receives every burst
    /// once, when it ends.
    pub fn step(
        &mut self,
        stations: &mut [&mut dyn Station],
        until: Time,
        tap: &mut dyn FnMut(TappedFrame<'_>),
    ) -> VirtualStep {
        let wake = self.wakes.earliest(self.now, stations).filter(|(due, _)| *due <= until);
        let burst = self.bursts.front().map(|burst| if self.is_carrier_reported { burst.end } else { burst.begin });
        let burst = burst.filter(|due| *due <= until);
        match (burst, wake) {
            (Some(due), None) => self.advance(due, stations, tap),
            (Some(due), Some((wake, _))) if due < wake || (due == wake && self.is_carrier_reported) => {
                self.advance(due, stations, tap);
            }
            (_, Some((due, port))) => {
                self.now = due;
                self.wake(port, stations);
                self.begin_at_once(stations);
            }
            (None, None) => {
                self.now = self.now.max(until);
                return VirtualStep::Idle;
            }
        }
        VirtualStep::Worked
    }

    /// Starts the first burst if it begins now and no wake-up is due before it.
    fn begin_at_once(&mut self, stations: &mut [&mut dyn Station]) {
        let begins = !self.is_carrier_reported && self.bursts.front().is_some_and(|burst| burst.begin <= self.now);
        if begins && self.wakes.earliest(self.now, stations).is_none_or(|(due, _)| due > self.now) {
            self.begin(stations);
        }
    }

    /// Steps until nothing is left to do before `until`; the clock then stands at `until`.
    pub fn run(&mut self, stations: &mut [&mut dyn Station], until: Time, tap: &mut dyn FnMut(TappedFrame<'_>)) {
        while self.step(stations, until, tap) == VirtualStep::Worked {}
    }

    /// Sends `octets` now as if the station at `port` had sent them; a `port` without a station is allowed.
    ///
    /// Returns the violation, if any; it is also stored in [`violations`](Self::violations).
    pub fn inject(&mut self, port: usize, octets: &[u8]) -> Result<(), WireViolation> {
        self.transmit(port, octets)
    }

    fn advance(&mut self, due: Time, stations: &mut [&mut dyn Station], tap: &mut dyn FnMut(TappedFrame<'_>)) {
        self.now = self.now.max(due);
        if !self.is_carrier_reported {
            self.begin(stations);
            return;
        }
        self.is_carrier_reported = false;
        let Some(burst) = self.bursts.pop_front() else { return };
        let is_asking = burst.part.expects_answer();
        self.last = Some(FinishedBurst { end: burst.end, expects_answer: is_asking });
        self.min_tsdrs.observe(burst.part);
        tap(TappedFrame { begin: burst.begin, time: self.now, port: burst.port, frame: &burst.octets });
        for (port, station) in stations.iter_mut().enumerate().filter(|(port, _)| !burst.is_sent_by(*port)) {
            station.receive(self.now, &burst.octets, &mut self.outbox);
            if !self.outbox.is_empty() {
                self.drain(port);
            }
        }
        self.spare.push(burst.octets);
    }

    /// Notifies the other ports that the first burst begins.
    fn begin(&mut self, stations: &mut [&mut dyn Station]) {
        self.is_carrier_reported = true;
        let Some(burst) = self.bursts.front() else { return };
        for (port, station) in stations.iter_mut().enumerate() {
            if !burst.is_sent_by(port) {
                station.carrier(self.now);
            }
        }
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
            // The violation is stored; as on a real bus, the sender is not notified.
            let _ = self.transmit(port, frame);
        }
        sent.clear();
        self.outbox = sent;
    }

    fn transmit(&mut self, port: usize, octets: &[u8]) -> Result<(), WireViolation> {
        let length = octets.len();
        if !(1..=LONGEST).contains(&length) {
            return Err(self.objections.raise(WireViolation::NoFrame { port, time: self.now, length }));
        }
        let own = self.bursts.iter().filter(|burst| burst.is_sent_by(port)).map(|burst| burst.end).max();
        let begin = own.unwrap_or(self.now).max(self.now);
        if begin.since(self.now) > BACKLOG {
            return Err(self.objections.raise(WireViolation::Congested { port, time: self.now }));
        }
        let end = begin.after_nanos(self.baud.nanoseconds(BitTimes::of_octets(length)));
        let mut copy = self.spare.pop().unwrap_or_default();
        copy.clear();
        copy.extend_from_slice(octets);
        let part = BurstRole::of(octets);
        let burst = Burst { begin, end, port, others: Vec::new(), part, octets: copy };
        let objection = match self.bursts.iter().find(|other| other.begin < end && begin < other.end) {
            Some(other) => Some(WireViolation::Collision { port, time: begin, other: other.port }),
            None => self.timing(&burst),
        };
        self.insert(burst);
        match objection {
            Some(violation) => Err(self.objections.raise(violation)),
            None => Ok(()),
        }
    }

    /// The timing violation of `burst`, which overlaps no other.
    fn timing(&self, burst: &Burst) -> Option<WireViolation> {
        let before = self.bursts.iter().filter(|other| other.end <= burst.begin).max_by_key(|other| other.end);
        let last = match before {
            Some(before) => FinishedBurst { end: before.end, expects_answer: before.part.expects_answer() },
            None => self.last?,
        };
        let (port, time) = (burst.port, burst.begin);
        let silent = self.bits(time.nanos_since(last.end));
        let (least, obeyed) = (self.min_tsdrs.of_next_answer().0, self.min_tsdrs.longest_of_next_answer().0);
        match burst.part {
            BurstRole::Request(_) | BurstRole::Unanswered if silent < BitTimes::TSYN.0 => {
                Some(WireViolation::NoSilence { port, time, silent })
            }
            BurstRole::Answer(_) if silent < least => Some(WireViolation::TooEarly { port, time, silent, least }),
            // A slave obeys the min TSDR of its master, even one that no answer can obey in time.
            BurstRole::Answer(_) if last.expects_answer && silent > self.slot.0.max(obeyed) => {
                Some(WireViolation::TooLate { port, time, silent, slot: self.slot.0 })
            }
            BurstRole::Answer(_) if last.expects_answer => match self.max_tsdr {
                Some(BitTimes(most)) if silent > most.max(obeyed) => {
                    Some(WireViolation::AfterMaxTsdr { port, time, silent, most })
                }
                _ => None,
            },
            _ => None,
        }
    }

    /// Whole bits in `nanoseconds`; a bit that rounding shortened by 1 ns counts as whole.
    fn bits(&self, nanoseconds: u64) -> u64 {
        self.baud.bits(nanoseconds.saturating_add(1)).0
    }

    /// Inserts `burst` in order of time, merged with all bursts that it overlaps.
    fn insert(&mut self, mut burst: Burst) {
        if self.bursts.is_empty() {
            self.is_carrier_reported = false;
            self.bursts.push_back(burst);
            return;
        }
        let is_sending = self.is_carrier_reported.then(|| self.bursts.front().map(|first| first.begin)).flatten();
        let octet = self.baud.nanoseconds(BitTimes(BitTimes::PER_OCTET)).max(1);
        while let Some(at) = self.bursts.iter().position(|other| other.begin < burst.end && burst.begin < other.end) {
            if let Some(other) = self.bursts.remove(at) {
                burst = other.collide(burst, octet);
            }
        }
        // Ports already notified of the first burst are not notified again.
        self.is_carrier_reported = is_sending
            .is_some_and(|begin| self.bursts.front().is_some_and(|first| first.begin == begin) || burst.begin == begin);
        let at = self.bursts.iter().take_while(|other| other.begin <= burst.begin).count();
        self.bursts.insert(at, burst);
    }
}

impl Burst {
    fn is_sent_by(&self, port: usize) -> bool {
        self.port == port || self.others.contains(&port)
    }

    /// The result of two overlapping bursts: 0 bits are dominant, and the whole is not a frame.
    fn collide(self, later: Burst, octet: u64) -> Burst {
        let (mut first, second) = if self.begin <= later.begin { (self, later) } else { (later, self) };
        let at = (second.begin.since(first.begin).as_nanos() / u128::from(octet)) as usize;
        first.octets.resize(first.octets.len().max((at + second.octets.len()).min(LONGEST)), 0xFF);
        for (octet, other) in first.octets.iter_mut().skip(at).zip(&second.octets) {
            *octet &= other;
        }
        if BurstRole::of(&first.octets) != BurstRole::Noise {
            first.octets.fill(0);
        }
        first.part = BurstRole::Noise;
        first.end = first.end.max(second.end);
        first.others.push(second.port);
        first.others.extend(second.others);
        first
    }
}

#[cfg(test)]
mod tests;
