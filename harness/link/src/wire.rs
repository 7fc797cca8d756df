//! Many stations of this process on one port, run by the clock.

use std::collections::VecDeque;

use crate::{Clock, Lateness, LinkError, Port};
use station::{Duration, Outbox, Station, Time};

/// What a network interface fills a shorter frame up to, in octets without check sequence.
const PADDED: usize = 60;
/// A step comes back after so long even if nothing happens, so that the caller can look at other things.
const LONGEST_STEP: Duration = Duration::from_millis(100);
/// So many frames are delivered in a row while a station is due; then the station has its turn.
const FRAMES_BEFORE_A_WAKE: u32 = 256;
/// A station that was woken so often in a row and is due still is left alone for [`LEFT_ALONE`].
const WAKES_IN_A_ROW: u32 = 1_000;
/// How long a station that wants to be woken for ever is left alone.
const LEFT_ALONE: Duration = Duration::from_millis(1);
/// How many waiting frames are thrown away at most when the clock starts anew.
const THROWN_AWAY: usize = 100_000;

/// A station of this process on a wire, with the MAC address at which it is.
pub type Local<'a> = ([u8; 6], &'a mut dyn Station);

/// What one [`Wire::step`] did.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Step {
    /// The time given has come and nothing that was due by then is left.
    Idle,
    /// A frame was delivered, a station was woken, or it is merely time to look at other things: step again.
    Worked,
}

/// Any number of stations of this process on one port: the live sibling of the virtual wire.
///
/// The stations belong to the caller and are handed in at each step, always in the same order. A frame for one address reaches
/// the station at that address, a frame for a group reaches all of them but the sender. A wire reaches out to a
/// port and among its own stations alike.
pub struct Wire {
    port: Box<dyn Port>,
    clock: Clock,
    /// What the tap and the stations were told last: their time never goes back.
    told: Time,
    /// A frame that came in, and when.
    pending: Option<Time>,
    incoming: Vec<u8>,
    /// Frames of stations here for stations here: who sent it, and the frame.
    among_us: VecDeque<(usize, Vec<u8>)>,
    spare: Vec<Vec<u8>>,
    outbox: Outbox,
    padded: Vec<u8>,
    delivered_in_a_row: u32,
    turns: Vec<Turns>,
    lateness: Lateness,
    held_back: u64,
}

/// How a station behaves when it is woken.
#[derive(Clone, Copy, Debug, Default)]
struct Turns {
    in_a_row: u32,
    not_before: Time,
}

impl std::fmt::Debug for Wire {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Wire").field("port", &self.port.describe()).field("clock", &self.clock).finish_non_exhaustive()
    }
}

impl Wire {
    /// A wire that reaches out through `port`; its clock shows [`Time::ZERO`] now.
    pub fn new(port: Box<dyn Port>) -> Wire {
        Wire {
            port,
            clock: Clock::start(),
            told: Time::ZERO,
            pending: None,
            incoming: Vec::new(),
            among_us: VecDeque::new(),
            spare: Vec::new(),
            outbox: Outbox::new(),
            padded: Vec::new(),
            delivered_in_a_row: 0,
            turns: Vec::new(),
            lateness: Lateness::default(),
            held_back: 0,
        }
    }

    /// The clock of this wire, until [`restart`](Self::restart).
    pub fn clock(&self) -> &Clock {
        &self.clock
    }

    /// What the clock shows.
    pub fn now(&self) -> Time {
        self.clock.now()
    }

    /// What this wire reaches out through.
    pub fn port(&self) -> &dyn Port {
        self.port.as_ref()
    }

    /// What this wire reaches out through, to ask for what was lost.
    pub fn port_mut(&mut self) -> &mut dyn Port {
        self.port.as_mut()
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

    /// Sets the clock to [`Time::ZERO`] and throws the frames away that arrived before.
    pub fn restart(&mut self) {
        let cut = self.clock.now();
        self.pending = None;
        self.among_us.clear();
        let mut kept = None;
        for _ in 0..THROWN_AWAY {
            // A line that is gone says so again at the next step.
            let Ok(Some(time)) = self.port.receive(&self.clock, Time::ZERO, &mut self.incoming) else { break };
            if time > cut {
                kept = Some(Time::ZERO + time.since(cut));
                break;
            }
        }
        self.pending = kept;
        self.clock = self.clock.started_at(cut);
        self.told = Time::ZERO;
        self.delivered_in_a_row = 0;
        self.turns.clear();
        self.lateness.clock_restarts();
    }

    /// After [`LinkError::Gone`]: tries to get the line back until the clock shows `until`.
    pub fn recover(&mut self, until: Time) -> Result<(), LinkError> {
        self.port.recover(&self.clock, until)
    }

    /// Waits for what comes next, but not beyond `until`, and lets it happen: one frame is delivered, or one station
    /// is woken.
    ///
    /// Frames that wait come before stations that are due; of several of those, the one due first. A station is
    /// never woken before its deadline, and what is due or has arrived after `until` is left for later. Each frame
    /// that a station sends is shown to `guard`; if that agrees it goes out at once, filled up to 60 octets with zeros,
    /// is shown to `tap`, and is kept for those stations here that it is for. `tap` also sees each frame that comes
    /// in, whomever it is for. What is shown to `tap` is never earlier than what was shown before.
    ///
    /// A line that is gone is an error; the step may then have been done in part.
    pub fn step(
        &mut self,
        stations: &mut [Local<'_>],
        until: Time,
        guard: &mut dyn FnMut(&[u8]) -> bool,
        tap: &mut dyn FnMut(Time, &[u8]),
    ) -> Result<Step, LinkError> {
        if self.turns.len() < stations.len() {
            self.turns.resize(stations.len(), Turns::default());
        }
        if let Some((sender, frame)) = self.among_us.pop_front() {
            let now = self.tell(self.clock.now());
            let result = self.deliver(stations, Some(sender), now, &frame, guard, tap);
            self.spare.push(frame);
            return result.map(|()| Step::Worked);
        }
        let break_off = self.clock.now() + LONGEST_STEP;
        loop {
            let now = self.clock.now();
            let next = self.next_deadline(stations).filter(|(due, _)| *due <= until);
            let due = next.filter(|(due, _)| *due <= now);
            let mut wait_for = next.map_or(until, |(due, _)| due.min(until)).min(break_off);
            if due.is_some() {
                wait_for = Time::ZERO;
            }
            if due.is_none() || self.delivered_in_a_row < FRAMES_BEFORE_A_WAKE {
                if self.pending.is_none() {
                    self.pending = self.port.receive(&self.clock, wait_for, &mut self.incoming)?;
                }
                if let Some(arrived) = self.pending.filter(|arrived| *arrived <= until) {
                    self.pending = None;
                    self.delivered_in_a_row = if due.is_some() { self.delivered_in_a_row + 1 } else { 0 };
                    let frame = std::mem::take(&mut self.incoming);
                    let now = self.tell(arrived);
                    tap(now, &frame);
                    let result = self.deliver(stations, None, now, &frame, guard, tap);
                    self.incoming = frame;
                    // What the frame has put off will not be woken for: it was late all the same.
                    if let Some((deadline, index)) = due
                        && stations[index].1.deadline().is_none_or(|next| next > deadline)
                    {
                        self.lateness.woken(deadline, self.clock.now());
                    }
                    return result.map(|()| Step::Worked);
                }
            }
            if let Some((deadline, index)) = due {
                self.delivered_in_a_row = 0;
                self.wake(stations, index, deadline, guard, tap)?;
                return Ok(Step::Worked);
            }
            let now = self.clock.now();
            if now >= until && self.next_deadline(stations).is_none_or(|(due, _)| due > until) {
                return Ok(Step::Idle);
            }
            if now >= break_off {
                return Ok(Step::Worked);
            }
        }
    }

    /// Which station is to be woken next, and when.
    fn next_deadline(&self, stations: &[Local<'_>]) -> Option<(Time, usize)> {
        let due = stations
            .iter()
            .zip(&self.turns)
            .enumerate()
            .filter_map(|(index, ((_, station), turns))| Some((station.deadline()?.max(turns.not_before), index)));
        due.min()
    }

    fn wake(
        &mut self,
        stations: &mut [Local<'_>],
        index: usize,
        deadline: Time,
        guard: &mut dyn FnMut(&[u8]) -> bool,
        tap: &mut dyn FnMut(Time, &[u8]),
    ) -> Result<(), LinkError> {
        let now = self.tell(self.clock.now());
        self.lateness.woken(deadline, now);
        let station = &mut stations[index].1;
        station.wake(now, &mut self.outbox);
        let turns = &mut self.turns[index];
        turns.in_a_row = if station.deadline().is_some_and(|again| again <= now) { turns.in_a_row + 1 } else { 0 };
        if turns.in_a_row >= WAKES_IN_A_ROW {
            *turns = Turns { in_a_row: 0, not_before: now + LEFT_ALONE };
        }
        if !self.outbox.is_empty() {
            self.lateness.sent(index, now);
        }
        self.drain(stations, index, guard, tap)
    }

    fn deliver(
        &mut self,
        stations: &mut [Local<'_>],
        sender: Option<usize>,
        now: Time,
        frame: &[u8],
        guard: &mut dyn FnMut(&[u8]) -> bool,
        tap: &mut dyn FnMut(Time, &[u8]),
    ) -> Result<(), LinkError> {
        let mut result = Ok(());
        for index in 0..stations.len() {
            if sender == Some(index) || !is_for(frame, stations[index].0) {
                continue;
            }
            stations[index].1.receive(now, frame, &mut self.outbox);
            result = result.and(self.drain(stations, index, guard, tap));
        }
        result
    }

    /// Sends what the station at `index` has put into the outbox.
    fn drain(
        &mut self,
        stations: &[Local<'_>],
        index: usize,
        guard: &mut dyn FnMut(&[u8]) -> bool,
        tap: &mut dyn FnMut(Time, &[u8]),
    ) -> Result<(), LinkError> {
        if self.outbox.is_empty() {
            return Ok(());
        }
        let mut sent = std::mem::take(&mut self.outbox);
        let mut result = Ok(());
        for frame in sent.frames() {
            if !guard(frame) {
                self.held_back += 1;
                continue;
            }
            self.padded.clear();
            self.padded.extend_from_slice(frame);
            self.padded.resize(frame.len().max(PADDED), 0);
            let now = self.tell(self.clock.now());
            match self.port.send(&self.padded) {
                Ok(()) => tap(now, &self.padded),
                Err(error) => {
                    result = result.and(Err(error));
                    continue;
                }
            }
            let here = |(other, (mac, _)): (usize, &Local<'_>)| other != index && is_for(frame, *mac);
            if stations.iter().enumerate().any(here) {
                let mut kept = self.spare.pop().unwrap_or_default();
                kept.clear();
                kept.extend_from_slice(&self.padded);
                self.among_us.push_back((index, kept));
            }
        }
        sent.clear();
        self.outbox = sent;
        result
    }

    /// The time to be told for something that happened at `time`.
    fn tell(&mut self, time: Time) -> Time {
        self.told = self.told.max(time);
        self.told
    }
}

/// Whether `frame` is for the station at `mac`: by its address, or by a group's.
fn is_for(frame: &[u8], mac: [u8; 6]) -> bool {
    frame.get(..6).is_some_and(|destination| destination[0] & 1 == 1 || destination == mac)
}
