//! Runs any number of stations of this process on one serial line in real time; the counterpart of the virtual bus.

use std::collections::VecDeque;

use crate::wire::WireStep;
use crate::{Clock, Lateness, LinkError, ProcessorShortage, Serial};
use plain_text::hex_start;
use station::{Duration, Outbox, Station, Time};

/// Bits on the line for one byte: start bit, 8 data bits, parity bit, stop bit.
const BITS_PER_OCTET: u64 = 11;
/// Bits of silence that end a frame: the synchronization time of PROFIBUS (TSYN, 33 bits).
const SILENCE_BITS: u64 = 33;
/// The shortest silence that is detected: a shorter gap may come from the kernel, which delivers bytes in batches.
const SHORTEST_SILENCE: Duration = Duration::from_millis(20);
/// The longest time that a step takes if nothing happens; it then returns to the caller.
const LONGEST_STEP: Duration = Duration::from_millis(100);

/// Splits a stream of bytes into frames; implemented for each protocol.
pub trait Framing: Send {
    /// Takes received bytes.
    fn push(&mut self, octets: &[u8]);

    /// Returns the next complete piece.
    fn next_piece(&mut self) -> Option<LinePiece>;

    /// Reports that the line was silent, which ends an incomplete piece; returns the next piece, until there is none.
    fn silence(&mut self) -> Option<LinePiece>;

    /// Whether the last piece is incomplete.
    fn is_waiting(&self) -> bool;
}

/// A piece of the byte stream, as found by a [`Framing`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LinePiece {
    pub octets: Vec<u8>,
    /// Whether the bytes are a valid frame; otherwise they are damaged.
    pub is_frame: bool,
}

/// A piece that waits for its delivery.
struct ReceivedPiece {
    begin: Time,
    end: Time,
    /// When it was found to be complete; later than its end if a silence ended it.
    found: Time,
    piece: LinePiece,
}

/// A frame, or damaged bytes, on the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BusTransmission<'a> {
    /// The time of its first bit, estimated for received bytes.
    pub begin: Time,
    /// The time of its last bit.
    pub end: Time,
    /// The index of the station of this process that sent it; `None` if it was received.
    pub sender: Option<usize>,
    pub octets: &'a [u8],
    /// Whether the bytes are a valid frame; otherwise they are damaged.
    pub is_frame: bool,
}

/// Any number of stations of this process on one serial line.
///
/// The caller owns the stations and passes them to each step, always in the same order. Each station receives everything except
/// what it has sent itself.
pub struct SerialBus {
    serial: Serial,
    split: Box<dyn Framing>,
    clock: Clock,
    /// The time last reported to the tap; it never goes back.
    last_reported: Time,
    pieces: VecDeque<ReceivedPiece>,
    /// When the incomplete piece began.
    piece_start: Option<Time>,
    last_octet: Time,
    /// Frames between stations of this process: end time, sender, bytes.
    internal_frames: VecDeque<(Time, usize, Vec<u8>)>,
    input: Vec<u8>,
    outbox: Outbox,
    lateness: Lateness,
    shortage: ProcessorShortage,
    held_back: u64,
}

impl std::fmt::Debug for SerialBus {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SerialBus").field("serial", &self.serial).field("clock", &self.clock).finish_non_exhaustive()
    }
}

impl SerialBus {
    /// A bus on `serial` with the framing `split`; its clock starts at [`Time::ZERO`] now.
    pub fn new(serial: Serial, split: Box<dyn Framing>) -> SerialBus {
        SerialBus {
            serial,
            split,
            clock: Clock::start(),
            last_reported: Time::ZERO,
            pieces: VecDeque::new(),
            piece_start: None,
            last_octet: Time::ZERO,
            internal_frames: VecDeque::new(),
            input: Vec::new(),
            outbox: Outbox::new(),
            lateness: Lateness::default(),
            shortage: ProcessorShortage::default(),
            held_back: 0,
        }
    }

    /// The clock of this bus, until [`restart`](Self::restart).
    pub fn clock(&self) -> &Clock {
        &self.clock
    }

    /// The present time of the clock.
    pub fn now(&self) -> Time {
        self.clock.now()
    }

    pub fn serial(&self) -> &Serial {
        &self.serial
    }

    /// How late the stations were woken, since the start or the last [`reset_lateness`](Self::reset_lateness).
    pub fn lateness(&self) -> &Lateness {
        &self.lateness
    }

    /// How long programs of this host waited for a processor since then, if it is worth mentioning and the other end is one of them.
    pub fn shortage(&self) -> Option<Duration> {
        self.shortage.within(self.now())
    }

    /// Resets the statistics of [`lateness`](Self::lateness) and [`shortage`](Self::shortage), when the clock is zero.
    pub fn reset_lateness(&mut self) {
        self.lateness.reset();
        self.shortage = if self.serial.is_pty() { ProcessorShortage::begin() } else { ProcessorShortage::default() };
    }

    /// The number of frames that the guard has held back.
    pub fn held_back(&self) -> u64 {
        self.held_back
    }

    /// Sets the clock to [`Time::ZERO`] and discards everything received before.
    pub fn restart(&mut self) {
        self.serial.discard_input();
        while self.split.silence().is_some() {}
        self.pieces.clear();
        self.internal_frames.clear();
        self.piece_start = None;
        self.clock = self.clock.started_at(self.clock.now());
        (self.last_reported, self.last_octet) = (Time::ZERO, Time::ZERO);
        self.lateness.clock_restarts();
    }

    /// After [`LinkError::Gone`]: tries to restore the line until the clock shows `until`.
    pub fn recover(&mut self, until: Time) -> Result<(), LinkError> {
        self.serial.recover(&self.clock, until)
    }

    /// Listens for `time` without sending; returns the frames and damaged bytes received.
    pub fn listen(&mut self, time: Duration) -> Result<Vec<LinePiece>, LinkError> {
        let until = self.now() + time;
        let mut pieces = Vec::new();
        let mut tap = |found: BusTransmission<'_>| {
            pieces.push(LinePiece { octets: found.octets.to_vec(), is_frame: found.is_frame });
        };
        while self.step(&mut [], until, &mut |_| false, &mut tap)? == WireStep::Worked {}
        Ok(pieces)
    }

    /// Listens for `time`; fails if another station sends on the bus.
    pub fn refuse_traffic(&mut self, time: Duration) -> Result<(), LinkError> {
        let until = self.now() + time;
        let mut traffic: Option<Vec<u8>> = None;
        loop {
            let mut tap = |found: BusTransmission<'_>| traffic = Some(found.octets.to_vec());
            let step = self.step(&mut [], until, &mut |_| false, &mut tap)?;
            if let Some(octets) = traffic {
                return Err(LinkError::Unusable(format!(
                    "another station sends on {}: {}; disconnect the other master from the bus",
                    self.serial.describe(),
                    hex_start(&octets, 16)
                )));
            }
            if step == WireStep::Idle {
                return Ok(());
            }
        }
    }

    /// Waits for the next event, at most until `until`, and handles it: delivers one frame or wakes one station.
    ///
    /// Received bytes are read before a station is woken. Bytes that only a silence ends are delivered when it is over: a deadline that
    /// a station computes from them is not late because of the silence. Each frame that a station sends is passed to `guard`; if it returns true
    /// the frame is sent at once and passed to `tap`, which also gets everything received, including damaged bytes.
    ///
    /// Fails if the line is gone; the step may then have been done in part.
    pub fn step(
        &mut self,
        stations: &mut [&mut dyn Station],
        until: Time,
        guard: &mut dyn FnMut(&[u8]) -> bool,
        tap: &mut dyn FnMut(BusTransmission<'_>),
    ) -> Result<WireStep, LinkError> {
        let break_off = self.now() + LONGEST_STEP;
        loop {
            if let Some(ReceivedPiece { begin, end, found, piece }) = self.pieces.pop_front() {
                let end = self.report_time(end);
                let (octets, is_frame) = (&piece.octets[..], piece.is_frame);
                tap(BusTransmission { begin: begin.min(end), end, sender: None, octets, is_frame });
                self.deliver(stations, (None, found), octets, guard, tap)?;
                return Ok(WireStep::Worked);
            }
            self.read(stations)?;
            if !self.pieces.is_empty() {
                continue;
            }
            let now = self.now();
            if self.internal_frames.front().is_some_and(|(end, _, _)| *end <= now)
                && let Some((_, sender, octets)) = self.internal_frames.pop_front()
            {
                self.deliver(stations, (Some(sender), now), &octets, guard, tap)?;
                return Ok(WireStep::Worked);
            }
            let due = earliest(stations).filter(|(due, _)| *due <= until);
            if let Some((deadline, index)) = due.filter(|(due, _)| *due <= now) {
                self.wake(stations, index, deadline, guard, tap)?;
                return Ok(WireStep::Worked);
            }
            if now >= until {
                return Ok(WireStep::Idle);
            }
            if now >= break_off {
                return Ok(WireStep::Worked);
            }
            let silence = self.split.is_waiting().then(|| self.last_octet + self.silence());
            let internal = self.internal_frames.front().map(|(end, _, _)| *end);
            let next = [due.map(|(due, _)| due), silence, internal, Some(break_off), Some(until)];
            let next = next.into_iter().flatten().min().unwrap_or(until);
            self.serial.wait(&self.clock, next)?;
        }
    }

    /// Reads the received bytes and splits them into frames.
    fn read(&mut self, stations: &mut [&mut dyn Station]) -> Result<(), LinkError> {
        self.input.clear();
        let received = self.serial.receive(&mut self.input)?;
        let now = self.now();
        if received {
            if self.piece_start.is_none() {
                self.piece_start = Some(now - self.lasts(self.input.len()));
                stations.iter_mut().for_each(|station| station.carrier(now));
            }
            self.last_octet = now;
            self.split.push(&self.input);
            while let Some(piece) = self.split.next_piece() {
                self.queue_piece(piece, now);
            }
        } else if self.split.is_waiting() && now >= self.last_octet + self.silence() {
            while let Some(piece) = self.split.silence() {
                self.queue_piece(piece, now);
            }
        }
        if !self.split.is_waiting() {
            self.piece_start = None;
        }
        Ok(())
    }

    fn queue_piece(&mut self, piece: LinePiece, found: Time) {
        let end = self.last_octet;
        let begin = self.piece_start.take().unwrap_or(end);
        self.pieces.push_back(ReceivedPiece { begin, end, found, piece });
        self.piece_start = self.split.is_waiting().then_some(self.last_octet);
    }

    fn wake(
        &mut self,
        stations: &mut [&mut dyn Station],
        index: usize,
        deadline: Time,
        guard: &mut dyn FnMut(&[u8]) -> bool,
        tap: &mut dyn FnMut(BusTransmission<'_>),
    ) -> Result<(), LinkError> {
        let now = self.now();
        self.lateness.woken(deadline, now);
        stations[index].wake(now, &mut self.outbox);
        if !self.outbox.is_empty() {
            self.lateness.sent(index, now);
        }
        self.drain(stations, index, guard, tap)
    }

    fn deliver(
        &mut self,
        stations: &mut [&mut dyn Station],
        (sender, now): (Option<usize>, Time),
        octets: &[u8],
        guard: &mut dyn FnMut(&[u8]) -> bool,
        tap: &mut dyn FnMut(BusTransmission<'_>),
    ) -> Result<(), LinkError> {
        let mut result = Ok(());
        for index in (0..stations.len()).filter(|index| sender != Some(*index)) {
            stations[index].receive(now, octets, &mut self.outbox);
            result = result.and(self.drain(stations, index, guard, tap));
        }
        result
    }

    /// Sends the frames that the station at `index` has put into the outbox.
    fn drain(
        &mut self,
        stations: &mut [&mut dyn Station],
        index: usize,
        guard: &mut dyn FnMut(&[u8]) -> bool,
        tap: &mut dyn FnMut(BusTransmission<'_>),
    ) -> Result<(), LinkError> {
        if self.outbox.is_empty() {
            return Ok(());
        }
        let mut sent = std::mem::take(&mut self.outbox);
        let mut result = Ok(());
        for octets in sent.frames() {
            if !guard(octets) {
                self.held_back += 1;
                continue;
            }
            let begin = self.report_time(self.clock.now());
            if let Err(error) = self.serial.send(octets) {
                result = result.and(Err(error));
                continue;
            }
            let end = begin + self.lasts(octets.len());
            tap(BusTransmission { begin, end, sender: Some(index), octets, is_frame: true });
            if stations.len() > 1 {
                let others = stations.iter_mut().enumerate().filter(|(other, _)| *other != index);
                others.for_each(|(_, station)| station.carrier(begin));
                self.internal_frames.push_back((end, index, octets.to_vec()));
            }
        }
        sent.clear();
        self.outbox = sent;
        result
    }

    /// The transmission time of `count` bytes; zero on a pseudoterminal.
    fn lasts(&self, count: usize) -> Duration {
        if self.serial.is_pty() {
            return Duration::ZERO;
        }
        self.bits(count as u64 * BITS_PER_OCTET)
    }

    fn silence(&self) -> Duration {
        self.bits(SILENCE_BITS).max(SHORTEST_SILENCE)
    }

    fn bits(&self, count: u64) -> Duration {
        Duration::from_nanos(count.saturating_mul(1_000_000_000) / u64::from(self.serial.settings().baud.max(1)))
    }

    /// The time to report for an event at `time`: never earlier than the last reported time.
    fn report_time(&mut self, time: Time) -> Time {
        self.last_reported = self.last_reported.max(time);
        self.last_reported
    }
}

/// The next deadline and the index of its station.
fn earliest(stations: &[&mut dyn Station]) -> Option<(Time, usize)> {
    let due = stations.iter().enumerate().filter_map(|(index, station)| Some((station.deadline()?, index)));
    due.min()
}
