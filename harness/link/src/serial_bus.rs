//! Many stations of this process on one serial line, run by the clock: the live sibling of the virtual bus.

use std::collections::VecDeque;

use crate::wire::Step;
use crate::{Clock, Lateness, LinkError, Serial};
use plain_text::hex_start;
use station::{Duration, Outbox, Station, Time};

/// Bits on the line for one octet: start bit, 8 bits, even parity, stop bit.
const BITS_PER_OCTET: u64 = 11;
/// So many bits of silence end a frame.
const SILENCE_BITS: u64 = 33;
/// A shorter silence is not told from octets that the kernel has gathered.
const SHORTEST_SILENCE: Duration = Duration::from_millis(20);
/// A step comes back after so long even if nothing happens, so that the caller can look at other things.
const LONGEST_STEP: Duration = Duration::from_millis(100);

/// Finds the frames in octets; who knows the protocol implements it.
pub trait Split: Send {
    /// Takes octets as they came.
    fn push(&mut self, octets: &[u8]);

    /// The next piece that is complete.
    fn next_piece(&mut self) -> Option<Piece>;

    /// Says that the line was silent, so that what waits is over; gives the next piece, until there is none.
    fn silence(&mut self) -> Option<Piece>;

    /// Whether octets wait for others to follow.
    fn is_waiting(&self) -> bool;
}

/// What a [`Split`] finds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Piece {
    /// The octets.
    pub octets: Vec<u8>,
    /// Whether they are a frame, else damage.
    pub is_frame: bool,
}

/// What was on the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Heard<'a> {
    /// When its first bit was sent, as far as that can be known.
    pub begin: Time,
    /// When it ended.
    pub end: Time,
    /// The station of this process that sent it; none came in.
    pub sender: Option<usize>,
    /// Its octets.
    pub octets: &'a [u8],
    /// Whether they are a frame, else damage.
    pub is_frame: bool,
}

/// Any number of stations of this process on one serial line.
///
/// The stations belong to the caller and are handed in at each step, always in the same order. Each of them hears everything
/// but what it has sent itself.
pub struct SerialBus {
    serial: Serial,
    split: Box<dyn Split>,
    clock: Clock,
    /// What the tap was told last: its time never goes back.
    told: Time,
    pieces: VecDeque<(Time, Piece)>,
    /// When the octets began that wait for others.
    hearing: Option<Time>,
    last_octet: Time,
    /// What our stations sent for each other: when it ends, who sent it.
    among_us: VecDeque<(Time, usize, Vec<u8>)>,
    input: Vec<u8>,
    outbox: Outbox,
    lateness: Lateness,
    held_back: u64,
}

impl std::fmt::Debug for SerialBus {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SerialBus").field("serial", &self.serial).field("clock", &self.clock).finish_non_exhaustive()
    }
}

impl SerialBus {
    /// A bus on `serial`, whose frames `split` finds; its clock shows [`Time::ZERO`] now.
    pub fn new(serial: Serial, split: Box<dyn Split>) -> SerialBus {
        SerialBus {
            serial,
            split,
            clock: Clock::start(),
            told: Time::ZERO,
            pieces: VecDeque::new(),
            hearing: None,
            last_octet: Time::ZERO,
            among_us: VecDeque::new(),
            input: Vec::new(),
            outbox: Outbox::new(),
            lateness: Lateness::default(),
            held_back: 0,
        }
    }

    /// The clock of this bus, until [`restart`](Self::restart).
    pub fn clock(&self) -> &Clock {
        &self.clock
    }

    /// What the clock shows.
    pub fn now(&self) -> Time {
        self.clock.now()
    }

    /// The line.
    pub fn serial(&self) -> &Serial {
        &self.serial
    }

    /// How punctual the stations were woken, since the start or the last [`reset_lateness`](Self::reset_lateness).
    pub fn lateness(&self) -> &Lateness {
        &self.lateness
    }

    /// Forgets how punctual the stations were woken.
    pub fn reset_lateness(&mut self) {
        self.lateness.reset();
    }

    /// How many frames the guard has held back.
    pub fn held_back(&self) -> u64 {
        self.held_back
    }

    /// Sets the clock to [`Time::ZERO`] and throws away what came before.
    pub fn restart(&mut self) {
        self.serial.forget();
        while self.split.silence().is_some() {}
        self.pieces.clear();
        self.among_us.clear();
        self.hearing = None;
        self.clock = self.clock.started_at(self.clock.now());
        (self.told, self.last_octet) = (Time::ZERO, Time::ZERO);
        self.lateness.clock_restarts();
    }

    /// After [`LinkError::Gone`]: tries to get the line back until the clock shows `until`.
    pub fn recover(&mut self, until: Time) -> Result<(), LinkError> {
        self.serial.recover(&self.clock, until)
    }

    /// Says nothing for `time` and gives what is heard in it, frames and damage.
    pub fn listen(&mut self, time: Duration) -> Result<Vec<Piece>, LinkError> {
        let until = self.now() + time;
        let mut heard = Vec::new();
        let mut tap = |found: Heard<'_>| {
            heard.push(Piece { octets: found.octets.to_vec(), is_frame: found.is_frame });
        };
        while self.step(&mut [], until, &mut |_| false, &mut tap)? == Step::Worked {}
        Ok(heard)
    }

    /// Listens for `time` and refuses a bus on which anybody says anything.
    pub fn refuse_traffic(&mut self, time: Duration) -> Result<(), LinkError> {
        let until = self.now() + time;
        let mut heard: Option<Vec<u8>> = None;
        loop {
            let mut tap = |found: Heard<'_>| heard = Some(found.octets.to_vec());
            let step = self.step(&mut [], until, &mut |_| false, &mut tap)?;
            if let Some(octets) = heard {
                return Err(LinkError::Unusable(format!(
                    "somebody else sends on {}: {}; take the other master off the bus",
                    self.serial.describe(),
                    hex_start(&octets, 16)
                )));
            }
            if step == Step::Idle {
                return Ok(());
            }
        }
    }

    /// Waits for what comes next, but not beyond `until`, and lets it happen: one frame is delivered, or one station is woken.
    ///
    /// What has come in is read before a station is woken. Each frame that a station sends is shown to `guard`; if that agrees it
    /// goes out at once and is shown to `tap`, which also sees everything that comes in, damage included.
    ///
    /// A line that is gone is an error; the step may then have been done in part.
    pub fn step(
        &mut self,
        stations: &mut [&mut dyn Station],
        until: Time,
        guard: &mut dyn FnMut(&[u8]) -> bool,
        tap: &mut dyn FnMut(Heard<'_>),
    ) -> Result<Step, LinkError> {
        let break_off = self.now() + LONGEST_STEP;
        loop {
            if let Some((begin, piece)) = self.pieces.pop_front() {
                let end = self.tell(self.last_octet);
                let (octets, is_frame) = (&piece.octets[..], piece.is_frame);
                tap(Heard { begin: begin.min(end), end, sender: None, octets, is_frame });
                self.deliver(stations, (None, end), octets, guard, tap)?;
                return Ok(Step::Worked);
            }
            self.read(stations)?;
            if !self.pieces.is_empty() {
                continue;
            }
            let now = self.now();
            if self.among_us.front().is_some_and(|(end, _, _)| *end <= now)
                && let Some((_, sender, octets)) = self.among_us.pop_front()
            {
                self.deliver(stations, (Some(sender), now), &octets, guard, tap)?;
                return Ok(Step::Worked);
            }
            let due = earliest(stations).filter(|(due, _)| *due <= until);
            if let Some((deadline, index)) = due.filter(|(due, _)| *due <= now) {
                self.wake(stations, index, deadline, guard, tap)?;
                return Ok(Step::Worked);
            }
            if now >= until {
                return Ok(Step::Idle);
            }
            if now >= break_off {
                return Ok(Step::Worked);
            }
            let silence = self.split.is_waiting().then(|| self.last_octet + self.silence());
            let ours = self.among_us.front().map(|(end, _, _)| *end);
            let next = [due.map(|(due, _)| due), silence, ours, Some(break_off), Some(until)];
            let next = next.into_iter().flatten().min().unwrap_or(until);
            self.serial.wait(&self.clock, next)?;
        }
    }

    /// Reads what is here and finds the frames in it.
    fn read(&mut self, stations: &mut [&mut dyn Station]) -> Result<(), LinkError> {
        self.input.clear();
        let came = self.serial.receive(&mut self.input)?;
        let now = self.now();
        if came {
            if self.hearing.is_none() {
                self.hearing = Some(now - self.lasts(self.input.len()));
                stations.iter_mut().for_each(|station| station.carrier(now));
            }
            self.last_octet = now;
            self.split.push(&self.input);
            while let Some(piece) = self.split.next_piece() {
                self.keep(piece);
            }
        } else if self.split.is_waiting() && now >= self.last_octet + self.silence() {
            while let Some(piece) = self.split.silence() {
                self.keep(piece);
            }
        }
        if !self.split.is_waiting() {
            self.hearing = None;
        }
        Ok(())
    }

    fn keep(&mut self, piece: Piece) {
        let begin = self.hearing.take().unwrap_or(self.last_octet);
        self.pieces.push_back((begin, piece));
        self.hearing = self.split.is_waiting().then_some(self.last_octet);
    }

    fn wake(
        &mut self,
        stations: &mut [&mut dyn Station],
        index: usize,
        deadline: Time,
        guard: &mut dyn FnMut(&[u8]) -> bool,
        tap: &mut dyn FnMut(Heard<'_>),
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
        tap: &mut dyn FnMut(Heard<'_>),
    ) -> Result<(), LinkError> {
        let mut result = Ok(());
        for index in (0..stations.len()).filter(|index| sender != Some(*index)) {
            stations[index].receive(now, octets, &mut self.outbox);
            result = result.and(self.drain(stations, index, guard, tap));
        }
        result
    }

    /// Sends what the station at `index` has put into the outbox.
    fn drain(
        &mut self,
        stations: &mut [&mut dyn Station],
        index: usize,
        guard: &mut dyn FnMut(&[u8]) -> bool,
        tap: &mut dyn FnMut(Heard<'_>),
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
            let begin = self.tell(self.clock.now());
            if let Err(error) = self.serial.send(octets) {
                result = result.and(Err(error));
                continue;
            }
            let end = begin + self.lasts(octets.len());
            tap(Heard { begin, end, sender: Some(index), octets, is_frame: true });
            if stations.len() > 1 {
                let others = stations.iter_mut().enumerate().filter(|(other, _)| *other != index);
                others.for_each(|(_, station)| station.carrier(begin));
                self.among_us.push_back((end, index, octets.to_vec()));
            }
        }
        sent.clear();
        self.outbox = sent;
        result
    }

    /// How long `count` octets last on the line; on a pseudoterminal no time.
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

    /// The time to be told for something that happened at `time`.
    fn tell(&mut self, time: Time) -> Time {
        self.told = self.told.max(time);
        self.told
    }
}

/// Which station is to be woken next, and when.
fn earliest(stations: &[&mut dyn Station]) -> Option<(Time, usize)> {
    let due = stations.iter().enumerate().filter_map(|(index, station)| Some((station.deadline()?, index)));
    due.min()
}
