//! Runs any number of stations of this process on one port in real time.

use std::collections::VecDeque;

use crate::{Clock, Lateness, LinkError, Port, ProcessorShortage};
use station::{Duration, Outbox, Station, Time};

/// The length to which a network interface pads a shorter frame, in bytes without frame check sequence.
const PADDED: usize = 60;
/// The longest time that a step takes if nothing happens; it then returns to the caller.
const LONGEST_STEP: Duration = Duration::from_millis(100);
/// The number of frames delivered in a row while a station is due; then the station is woken.
const FRAMES_BEFORE_A_WAKE: u32 = 256;
/// A station that is still due after this many wakes in a row is suspended for [`LEFT_ALONE`].
const WAKES_IN_A_ROW: u32 = 1_000;
/// How long a station that is always due is suspended, so that other stations and the port are served.
const LEFT_ALONE: Duration = Duration::from_millis(1);
/// The maximum number of waiting frames that a restart of the clock discards.
const THROWN_AWAY: usize = 100_000;

/// A station of this process on a wire, with its MAC address.
pub type LocalStation<'a> = ([u8; 6], &'a mut dyn Station);

/// The result of one [`Wire::step`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WireStep {
    /// The given time has come, and everything due by then is done.
    Idle,
    /// A frame was delivered, a station was woken, or the step has reached its longest time: step again.
    Worked,
}

/// Any number of stations of this process on one port; the counterpart of the virtual wire.
///
/// The caller owns the stations and passes them to each step, always in the same order. A unicast frame is delivered to the
/// station with that address, a multicast frame to all stations but the sender. Frames go to the port and to the other stations
/// of the wire.
pub struct Wire {
    port: Box<dyn Port>,
    clock: Clock,
    /// The time last reported to the tap and the stations; it never goes back.
    last_reported: Time,
    /// The arrival time of the received frame in `incoming` that is not delivered yet.
    pending: Option<Time>,
    incoming: Vec<u8>,
    /// Frames between stations of this process: sender, frame.
    among_us: VecDeque<(usize, Vec<u8>)>,
    spare: Vec<Vec<u8>>,
    outbox: Outbox,
    padded: Vec<u8>,
    delivered_in_a_row: u32,
    turns: Vec<WakeStreak>,
    lateness: Lateness,
    shortage: ProcessorShortage,
    held_back: u64,
}

/// The wakes in a row of a station.
#[derive(Clone, Copy, Debug, Default)]
struct WakeStreak {
    in_a_row: u32,
    not_before: Time,
}

impl std::fmt::Debug for Wire {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Wire").field("port", &self.port.describe()).field("clock", &self.clock).finish_non_exhaustive()
    }
}

impl Wire {
    /// The port, for another wire.
    pub fn into_port(self) -> Box<dyn Port> {
        self.port
    }

    /// A wire on `port`; its clock starts at [`Time::ZERO`] now.
    pub fn new(port: Box<dyn Port>) -> Wire {
        Wire {
            port,
            clock: Clock::start(),
            last_reported: Time::ZERO,
            pending: None,
            incoming: Vec::new(),
            among_us: VecDeque::new(),
            spare: Vec::new(),
            outbox: Outbox::new(),
            padded: Vec::new(),
            delivered_in_a_row: 0,
            turns: Vec::new(),
            lateness: Lateness::default(),
            shortage: ProcessorShortage::default(),
            held_back: 0,
        }
    }

    /// The clock of this wire, until [`restart`](Self::restart).
    pub fn clock(&self) -> &Clock {
        &self.clock
    }

    /// The present time of the clock.
    pub fn now(&self) -> Time {
        self.clock.now()
    }

    /// The port of this wire.
    pub fn port(&self) -> &dyn Port {
        self.port.as_ref()
    }

    /// The port of this wire, mutable, for [`Port::lost`].
    pub fn port_mut(&mut self) -> &mut dyn Port {
        self.port.as_mut()
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
        self.shortage =
            if self.port.ends_on_this_host() { ProcessorShortage::begin() } else { ProcessorShortage::default() };
    }

    /// The number of frames that the guard has held back.
    pub fn held_back(&self) -> u64 {
        self.held_back
    }

    /// Sets the clock to [`Time::ZERO`] and discards the frames that arrived before.
    pub fn restart(&mut self) {
        let cut = self.clock.now();
        self.pending = None;
        self.among_us.clear();
        let mut pending = None;
        for _ in 0..THROWN_AWAY {
            // If the line is gone, the next step fails again.
            let Ok(Some(time)) = self.port.receive(&self.clock, Time::ZERO, &mut self.incoming) else { break };
            if time > cut {
                pending = Some(Time::ZERO + time.since(cut));
                break;
            }
        }
        self.pending = pending;
        self.clock = self.clock.started_at(cut);
        self.last_reported = Time::ZERO;
        self.delivered_in_a_row = 0;
        self.turns.clear();
        self.lateness.clock_restarts();
    }

    /// After [`LinkError::Gone`]: tries to restore the line until the clock shows `until`.
    pub fn recover(&mut self, until: Time) -> Result<(), LinkError> {
        self.port.recover(&self.clock, until)
    }

    /// Waits for the next event, at most until `until`, and handles it: delivers one frame or wakes one station.
    ///
    /// Waiting frames are delivered before due stations are woken; of several due stations the one with the earliest deadline comes
    /// first. A station is never woken before its deadline. Frames that arrive and deadlines that fall after `until` are left for
    /// a later step. Each frame that a station sends is passed to `guard`; if it returns true the frame is padded to 60 bytes with
    /// zeros, sent at once, passed to `tap`, and queued for the stations of this wire that it is addressed to. `tap` also gets each
    /// received frame, whatever its destination. The times passed to `tap` never decrease.
    ///
    /// Fails if the line is gone; the step may then have been done in part.
    pub fn step(
        &mut self,
        stations: &mut [LocalStation<'_>],
        until: Time,
        guard: &mut dyn FnMut(&[u8]) -> bool,
        tap: &mut dyn FnMut(Time, &[u8]),
    ) -> Result<WireStep, LinkError> {
        if self.turns.len() < stations.len() {
            self.turns.resize(stations.len(), WakeStreak::default());
        }
        if let Some((sender, frame)) = self.among_us.pop_front() {
            let now = self.report_time(self.clock.now());
            let result = self.deliver(stations, Some(sender), now, &frame, guard, tap);
            self.spare.push(frame);
            return result.map(|()| WireStep::Worked);
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
                    // The caller may judge this frame before the missed station is woken.
                    if let Some((deadline, _)) = next {
                        self.lateness.overdue(deadline, self.clock.now());
                    }
                    let frame = std::mem::take(&mut self.incoming);
                    let now = self.report_time(arrived);
                    tap(now, &frame);
                    let result = self.deliver(stations, None, now, &frame, guard, tap);
                    self.incoming = frame;
                    // A deadline that the frame has moved is not woken for any more, but it was missed: count it.
                    if let Some((deadline, index)) = due
                        && stations[index].1.deadline().is_none_or(|next| next > deadline)
                    {
                        self.lateness.woken(deadline, self.clock.now());
                    }
                    return result.map(|()| WireStep::Worked);
                }
            }
            if let Some((deadline, index)) = due {
                self.delivered_in_a_row = 0;
                self.wake(stations, index, deadline, guard, tap)?;
                return Ok(WireStep::Worked);
            }
            let now = self.clock.now();
            if now >= until && self.next_deadline(stations).is_none_or(|(due, _)| due > until) {
                return Ok(WireStep::Idle);
            }
            if now >= break_off {
                return Ok(WireStep::Worked);
            }
        }
    }

    /// The next deadline and the index of its station.
    fn next_deadline(&self, stations: &[LocalStation<'_>]) -> Option<(Time, usize)> {
        let due = stations
            .iter()
            .zip(&self.turns)
            .enumerate()
            .filter_map(|(index, ((_, station), turns))| Some((station.deadline()?.max(turns.not_before), index)));
        due.min()
    }

    fn wake(
        &mut self,
        stations: &mut [LocalStation<'_>],
        index: usize,
        deadline: Time,
        guard: &mut dyn FnMut(&[u8]) -> bool,
        tap: &mut dyn FnMut(Time, &[u8]),
    ) -> Result<(), LinkError> {
        let now = self.report_time(self.clock.now());
        self.lateness.woken(deadline, now);
        let station = &mut stations[index].1;
        station.wake(now, &mut self.outbox);
        let turns = &mut self.turns[index];
        turns.in_a_row = if station.deadline().is_some_and(|again| again <= now) { turns.in_a_row + 1 } else { 0 };
        if turns.in_a_row >= WAKES_IN_A_ROW {
            *turns = WakeStreak { in_a_row: 0, not_before: now + LEFT_ALONE };
        }
        if !self.outbox.is_empty() {
            self.lateness.sent(index, now);
        }
        self.drain(stations, index, guard, tap)
    }

    fn deliver(
        &mut self,
        stations: &mut [LocalStation<'_>],
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

    /// Sends the frames that the station at `index` has put into the outbox. A frame for another of the stations does not get to the wire.
    fn drain(
        &mut self,
        stations: &[LocalStation<'_>],
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
            // Between these stations alone no wire is needed.
            let others = || stations.iter().enumerate().filter(|(other, _)| *other != index);
            let stays_here = others().any(|(_, (mac, _))| frame.starts_with(mac));
            if !stays_here && !guard(frame) {
                self.held_back += 1;
                continue;
            }
            self.padded.clear();
            self.padded.extend_from_slice(frame);
            self.padded.resize(frame.len().max(PADDED), 0);
            let now = self.report_time(self.clock.now());
            if !stays_here && let Err(error) = self.port.send(&self.padded) {
                result = result.and(Err(error));
                continue;
            }
            tap(now, &self.padded);
            if others().any(|(_, (mac, _))| is_for(frame, *mac)) {
                let mut copy = self.spare.pop().unwrap_or_default();
                copy.clear();
                copy.extend_from_slice(&self.padded);
                self.among_us.push_back((index, copy));
            }
        }
        sent.clear();
        self.outbox = sent;
        result
    }

    /// The time to report for an event at `time`: never earlier than the last reported time.
    fn report_time(&mut self, time: Time) -> Time {
        self.last_reported = self.last_reported.max(time);
        self.last_reported
    }
}

/// Whether the destination of `frame` is `mac` or a multicast address.
fn is_for(frame: &[u8], mac: [u8; 6]) -> bool {
    frame.get(..6).is_some_and(|destination| destination[0] & 1 == 1 || destination == mac)
}
