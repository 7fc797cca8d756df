//! Stations that are not devices: a tester must not mistake them for a working device.
//!
//! A run against any of them yields no pass.

use station::{Duration, Outbox, Station, Time};
use wire::profibus::fdl::{AnswerFunction, DataFrame, Extension, FdlFrame, FunctionCode, StationType};

use crate::damage::Random;

/// The cable is plugged in, but no station answers.
#[derive(Clone, Copy, Debug, Default)]
pub struct Silent;

impl Station for Silent {
    fn receive(&mut self, _now: Time, _frame: &[u8], _out: &mut Outbox) {}

    fn wake(&mut self, _now: Time, _out: &mut Outbox) {}

    fn deadline(&self) -> Option<Time> {
        None
    }
}

/// Returns every frame twice: unchanged, and with the two addresses exchanged.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reflector;

impl Station for Reflector {
    fn receive(&mut self, _now: Time, frame: &[u8], out: &mut Outbox) {
        out.push(frame);
        if let Some((destination, rest)) = frame.split_first_chunk::<6>()
            && let Some((source, rest)) = rest.split_first_chunk::<6>()
        {
            out.push_with(|octets| {
                octets.extend_from_slice(source);
                octets.extend_from_slice(destination);
                octets.extend_from_slice(rest);
            });
        }
    }

    fn wake(&mut self, _now: Time, _out: &mut Outbox) {}

    fn deadline(&self) -> Option<Time> {
        None
    }
}

/// Sends random frames at a steady rate, some with the headers of cyclic frames, DCP answers, RPC and ARP for its victim.
///
/// The same seed gives the same frames.
#[derive(Clone, Debug)]
pub struct Babbler {
    random: Random,
    interval: Duration,
    next: Time,
    own: [u8; 6],
    victim: [u8; 6],
}

impl Babbler {
    /// A babbler with the address `own` that sends one frame per `interval` to `victim`, from the start of the run.
    ///
    /// An interval of zero means one nanosecond; the wire then drops what it cannot carry.
    pub fn new(seed: u64, interval: Duration, own: [u8; 6], victim: [u8; 6]) -> Babbler {
        let interval = interval.max(Duration::from_nanos(1));
        Babbler { random: Random::new(seed), interval, next: Time::ZERO, own, victim }
    }

    fn frame(&mut self, octets: &mut Vec<u8>) {
        let random = &mut self.random;
        octets.extend_from_slice(&self.victim);
        octets.extend_from_slice(&self.own);
        // The imitated header, then the number of random bytes.
        let (head, rest): (&[u8], u64) = match random.below(6) {
            // RT_CLASS_1 with the frame ID of an input or output frame; the APDU status is random too.
            0 => (&[0x88, 0x92, 0x80 + random.below(0x40) as u8, random.octet()], 44 + random.below(60)),
            1 => (&[0x81, 0x00, 0xC0, 0x00, 0x88, 0x92, 0xC0, random.below(4) as u8], 44 + random.below(60)),
            // DCP: Identify response, then Get/Set response, each with 26 bytes that claim to be blocks.
            2 => (&[0x88, 0x92, 0xFE, 0xFF, 0x05, 0x01], 40),
            3 => (&[0x88, 0x92, 0xFE, 0xFD, 0x03 + random.below(2) as u8, 0x01], 40),
            4 => (&[0x08, 0x06, 0x00, 0x01, 0x08, 0x00, 0x06, 0x04, 0x00, 0x02], 20),
            _ => (&[], 2 + random.below(1_490)),
        };
        octets.extend_from_slice(head);
        let end = octets.len() + rest as usize;
        while octets.len() < end {
            octets.extend_from_slice(&random.below(1 << 48).to_le_bytes()[..6]);
        }
        octets.truncate(end);
    }
}

impl Station for Babbler {
    fn receive(&mut self, _now: Time, _frame: &[u8], _out: &mut Outbox) {}

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        if now >= self.next {
            out.push_with(|octets| self.frame(octets));
            self.next = now + self.interval;
        }
    }

    fn deadline(&self) -> Option<Time> {
        Some(self.next)
    }
}

/// Returns every frame of a bus twice: unchanged, and with the two addresses exchanged, each after the minimum delay.
#[derive(Clone, Debug)]
pub struct BusReflector {
    delay: Duration,
    due: Option<Time>,
    frames: Vec<Vec<u8>>,
}

impl BusReflector {
    /// A reflector that answers after `delay`.
    pub fn new(delay: Duration) -> BusReflector {
        BusReflector { delay, due: None, frames: Vec::new() }
    }
}

impl Station for BusReflector {
    fn receive(&mut self, now: Time, frame: &[u8], _out: &mut Outbox) {
        self.frames = vec![frame.to_vec()];
        if let Ok(FdlFrame::Data(data)) = FdlFrame::parse(frame) {
            let mut answer = Vec::new();
            let (to, from) = ((data.sa, data.source), (data.da, data.destination));
            let fc = FunctionCode::answer(AnswerFunction::DATA_LOW, StationType::SLAVE);
            DataFrame::new(to, from, fc, data.data).write(&mut answer);
            self.frames.push(answer);
        }
        self.due = Some(now + self.delay);
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        if self.due.is_some_and(|due| now >= due) {
            // The answer with the exchanged addresses first, the unchanged frame after the next delay.
            if let Some(frame) = self.frames.pop() {
                out.push(&frame);
            }
            self.due = (!self.frames.is_empty()).then(|| now + self.delay);
        }
    }

    fn deadline(&self) -> Option<Time> {
        self.due
    }
}

/// Sends random bytes on a bus at a steady rate, some in the form of answers to its victim, tokens and acknowledgements.
///
/// The same seed gives the same bytes.
#[derive(Clone, Debug)]
pub struct BusBabbler {
    random: Random,
    interval: Duration,
    next: Time,
    own: u8,
    victim: u8,
}

impl BusBabbler {
    /// A babbler with the address `own` that sends one frame per `interval` to `victim`, from the start of the run.
    ///
    /// An interval of zero means one nanosecond; the bus then drops what it cannot carry.
    pub fn new(seed: u64, interval: Duration, own: u8, victim: u8) -> BusBabbler {
        let interval = interval.max(Duration::from_nanos(1));
        BusBabbler { random: Random::new(seed), interval, next: Time::ZERO, own, victim }
    }

    fn frame(&mut self, octets: &mut Vec<u8>) {
        let random = &mut self.random;
        let kind = random.below(6);
        let length = match kind {
            0 => 0,
            1 => 6 + random.below(20),
            _ => 1 + random.below(20),
        };
        let data: Vec<u8> = (0..length).map(|_| random.octet()).collect();
        let function = match random.below(3) {
            0 => AnswerFunction::DATA_HIGH,
            _ => AnswerFunction::DATA_LOW,
        };
        let fc = FunctionCode::answer(function, StationType::SLAVE);
        // Answers to Slave_Diag come from access points 60 to 62; cyclic data have none.
        let (to, from) = match kind {
            1 => (Extension::sap(62), Extension::sap(60)),
            _ => (Extension::NONE, Extension::NONE),
        };
        match kind {
            0 => octets.push(0xE5),
            1..=3 => DataFrame::new((self.victim, to), (self.own, from), fc, &data).write(octets),
            4 => FdlFrame::Token { da: random.octet() & 0x7F, sa: random.octet() & 0x7F }.write(octets),
            _ => octets.extend(data),
        }
    }
}

impl Station for BusBabbler {
    fn receive(&mut self, _now: Time, _frame: &[u8], _out: &mut Outbox) {}

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        if now >= self.next {
            out.push_with(|octets| self.frame(octets));
            self.next = now + self.interval;
        }
    }

    fn deadline(&self) -> Option<Time> {
        Some(self.next)
    }
}

/// A station that stops forever after a number of frames, as after a power failure.
#[derive(Debug)]
pub struct DiesAfter<S> {
    station: S,
    left: usize,
    sent: Outbox,
}

impl<S> DiesAfter<S> {
    /// Lets `station` send `frames` frames, then no more; with 0 it never sends.
    pub fn new(station: S, frames: usize) -> DiesAfter<S> {
        DiesAfter { station, left: frames, sent: Outbox::new() }
    }

    /// The inner station, for a stand.
    pub fn station_mut(&mut self) -> &mut S {
        &mut self.station
    }

    /// Whether it has sent its last frame.
    pub fn is_dead(&self) -> bool {
        self.left == 0
    }

    fn pass_on(&mut self, out: &mut Outbox) {
        for frame in self.sent.frames().take(self.left) {
            out.push(frame);
            self.left -= 1;
        }
        self.sent.clear();
    }
}

impl<S: Station> Station for DiesAfter<S> {
    fn receive(&mut self, now: Time, frame: &[u8], out: &mut Outbox) {
        if !self.is_dead() {
            self.station.receive(now, frame, &mut self.sent);
            self.pass_on(out);
        }
    }

    fn carrier(&mut self, now: Time) {
        if !self.is_dead() {
            self.station.carrier(now);
        }
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        if !self.is_dead() {
            self.station.wake(now, &mut self.sent);
            self.pass_on(out);
        }
    }

    fn deadline(&self) -> Option<Time> {
        if self.is_dead() { None } else { self.station.deadline() }
    }
}

#[cfg(test)]
mod tests;
