//! The master: it assigns requests and answers to the ring, the cyclic exchange and the current request.

use super::access::{Access, Action, Hold, Purpose, Transfer};
use super::acyclic::Pace;
use super::exchange::{Exchange, Sample};
use super::job::{Job, Next};
use super::message::{Counts, Message};
use super::outcome::{Answer, ConnectionEnd, ConnectionState, Ended, Outcome};
use super::request::{Busy, Request, Settings};
use super::ring::Ring;
use super::{OUTPUT_SLOT, OUTPUT_SUBSLOT};
use crate::outputs::Outputs;
use alloc::vec::Vec;
use core::cell::Cell;
use core::time::Duration;
use station::{Outbox, Time};
use wire::profibus::fdl::{BitTimes, Frame, FrameCount};
use wire::profibus::global_control::{ControlCommand, GlobalControl};
use wire::profibus::sap::SlaveSap;

/// Shortest time between two DP-V1 polls.
const POLL: Duration = Duration::from_millis(1);

/// A PROFIBUS DP master.
///
/// It accepts one [`Request`] at a time. A request begins as soon as the master has the token and the bus is free. A running
/// connection needs no further requests.
#[derive(Debug)]
pub struct Master {
    pub(super) settings: Settings,
    pub(super) outputs: Outputs,
    pub(super) access: Access,
    pub(super) ring: Ring,
    counts: Counts,
    /// Since when the bus is silent, as far as this master knows.
    pub(super) quiet: Time,
    /// How long the bus has to be silent before the next frame of this master.
    pub(super) pause: BitTimes,
    /// Since when another station is sending.
    pub(super) hearing: Option<Time>,
    /// The pending reply to another master, and when it is sent.
    pub(super) reply: Option<(Time, Vec<u8>)>,
    pub(super) due: Option<(Time, Request)>,
    pub(super) job: Option<Job>,
    /// Since when there is a job but no token.
    pub(super) begging: Time,
    pub(super) exchange: Option<Exchange>,
    is_clear: bool,
    outcome: Option<Outcome>,
    end: Option<ConnectionEnd>,
    inputs: Vec<u8>,
    is_diagnosis_pending: bool,
    cycles_sent: u64,
    cycles_done: u64,
    pub(super) clock_offset: Duration,
    pub(super) is_clock_stopped: bool,
    /// The cached deadline. It is valid until the next event or call.
    pub(super) deadline: Cell<Option<Time>>,
    /// The cached next action with the token, and when.
    pub(super) planned: Cell<Option<(Time, Action)>>,
}

impl Master {
    /// A master outside the ring, in Operate, without a connection, with all outputs 0.
    pub fn new(settings: Settings) -> Master {
        let ring = Ring::new(settings.address, settings.highest, settings.gap_factor);
        let pause = settings.idle;
        Master {
            settings,
            outputs: Outputs::default(),
            access: Access::Listening,
            ring,
            counts: Counts::default(),
            quiet: Time::ZERO,
            pause,
            hearing: None,
            reply: None,
            due: None,
            job: None,
            begging: Time::ZERO,
            exchange: None,
            is_clear: false,
            outcome: None,
            end: None,
            inputs: Vec::new(),
            is_diagnosis_pending: false,
            cycles_sent: 0,
            cycles_done: 0,
            clock_offset: Duration::ZERO,
            is_clock_stopped: false,
            deadline: Cell::default(),
            planned: Cell::default(),
        }
    }

    /// Accepts a request, which begins once the bus is free; an outcome that was not taken is discarded. Fails while the previous
    /// request has not ended. [`Request::Abort`] is accepted at any time: it also ends the running request, whose outcome is then
    /// that of the abort.
    pub fn request(&mut self, now: Time, request: Request) -> Result<(), Busy> {
        if self.is_busy() && request != Request::Abort {
            return Err(Busy);
        }
        self.replan();
        self.outcome = None;
        self.due = Some((now, request));
        Ok(())
    }

    /// Whether the last request has not ended yet.
    pub fn is_busy(&self) -> bool {
        self.job.is_some() || self.due.is_some()
    }

    /// Takes the outcome of the last request, once.
    pub fn take_outcome(&mut self) -> Option<Outcome> {
        self.outcome.take()
    }

    /// Takes the reason why the connection ended without a request, once; the outcome of a start-up reports its own end.
    pub fn take_end(&mut self) -> Option<ConnectionEnd> {
        self.end.take()
    }

    /// The state of the connection as the master knows it.
    pub fn state(&self) -> ConnectionState {
        let of_job = self.job.as_ref().and_then(Job::state);
        let standing = if self.exchange.is_some() { ConnectionState::Exchange } else { ConnectionState::None };
        of_job.unwrap_or(standing)
    }

    /// Number of Data_Exchange requests sent in the current or last connection; repetitions do not count.
    pub fn cycles_sent(&self) -> u64 {
        self.cycles_sent
    }

    /// Number of these that are finished: answered or given up.
    pub fn cycles_done(&self) -> u64 {
        self.cycles_done
    }

    /// The cyclic outputs, stored as slot [`OUTPUT_SLOT`], subslot [`OUTPUT_SUBSLOT`]; they outlive every connection.
    pub fn outputs_mut(&mut self) -> &mut Outputs {
        self.replan();
        &mut self.outputs
    }

    /// Sets the outputs from the first byte on.
    pub fn set_outputs(&mut self, octets: &[u8]) {
        self.replan();
        self.outputs.declare_bytes(OUTPUT_SLOT, OUTPUT_SUBSLOT, octets.len());
        self.outputs.set_bytes(octets);
    }

    /// The inputs of the last valid Data_Exchange answer.
    pub fn inputs(&self) -> &[u8] {
        &self.inputs
    }

    /// Whether the last valid Data_Exchange answer had high priority.
    pub fn is_diagnosis_pending(&self) -> bool {
        self.is_diagnosis_pending
    }

    /// Stops (`true`) or resumes the clock of isochronous mode; it outlives every connection.
    pub fn stop_clock(&mut self, stopped: bool) {
        self.replan();
        self.is_clock_stopped = stopped;
    }

    /// Shifts the clock of isochronous mode relative to the start of the cycle; it outlives every connection.
    ///
    /// To make a clock early, shift it late by the cycle minus the lead.
    pub fn shift_clock(&mut self, offset: Duration) {
        self.replan();
        self.clock_offset = offset;
    }

    /// The settings of the master.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Discards the cached deadline and action after an event.
    pub(super) fn replan(&mut self) {
        self.deadline.take();
        self.planned.take();
    }

    /// The duration of `bits`.
    pub(super) fn time(&self, bits: BitTimes) -> Duration {
        Duration::from_nanos(self.settings.baud.nanoseconds(bits))
    }

    /// The time `bits` after `time`.
    pub(super) fn later(&self, time: Time, bits: BitTimes) -> Time {
        time.after_nanos(self.settings.baud.nanoseconds(bits))
    }

    /// Begins a request, with or without the token.
    pub(super) fn begin(&mut self, now: Time, request: Request) {
        if request == Request::Abort {
            self.abort();
            return;
        }
        if matches!(request, Request::Connect(_)) && self.exchange.is_some() {
            self.outcome = Some(Outcome::Impossible("a connection stands already"));
            return;
        }
        let released = match request {
            Request::Release => self.exchange.take().map(|exchange| exchange.connection),
            _ => None,
        };
        let poll = self.exchange.as_ref().map_or(POLL, |exchange| exchange.connection.cycle.max(POLL));
        let pace = Pace { poll, patience: self.settings.acyclic };
        self.begging = now;
        match Job::new(request, now, &self.settings, pace, released.as_deref()) {
            Ok(job) => self.job = Some(job),
            Err(outcome) => self.outcome = Some(outcome),
        }
    }

    fn abort(&mut self) {
        let had = self.exchange.take().is_some() | self.job.take().is_some();
        if let Access::Asking(transfer, _) = &mut self.access
            && transfer.purpose != Purpose::Gap
        {
            transfer.purpose = Purpose::Nobody;
        }
        let ended = if had { Ended::Aborted } else { Ended::NoConnection };
        self.outcome = Some(Outcome::Ended(ended));
    }

    /// Ends the job with its outcome.
    pub(super) fn conclude(&mut self, outcome: Outcome) {
        if let Outcome::StartUp(start_up) = &outcome
            && !start_up.standing
        {
            self.exchange = None;
        }
        (self.job, self.outcome) = (None, Some(outcome));
    }

    /// Sends the frame that `write` appends; the silence after it begins at its end.
    pub(super) fn transmit(&mut self, now: Time, out: &mut Outbox, write: impl FnOnce(&mut Vec<u8>)) {
        let mut length = 0;
        out.push_with(|octets| {
            let before = octets.len();
            write(octets);
            length = octets.len() - before;
        });
        self.quiet = self.later(now, BitTimes::of_octets(length));
        self.pause = self.settings.idle;
        self.hearing = None;
    }

    /// Sends `message` and waits for its answer, if its function has one.
    pub(super) fn send(&mut self, now: Time, message: Message, purpose: Purpose, hold: Hold, out: &mut Outbox) {
        let count = if message.is_counted() { self.counts.next(message.to) } else { FrameCount::Unused };
        let own = self.settings.address;
        self.transmit(now, out, |octets| message.write(own, count, octets));
        let hold = Hold { has_worked: true, ..hold };
        if !message.wants_answer() {
            self.pause = self.pause.max(self.settings.max_tsdr);
            self.access = Access::Holding(hold);
            return;
        }
        let retries = if purpose == Purpose::Gap { 0 } else { self.settings.retries };
        let until = self.later(self.quiet, self.settings.slot_time);
        let transfer = Transfer { message, purpose, count, retries, until, unfit: None };
        self.access = Access::Asking(transfer, hold);
    }

    /// Performs the next step of the job.
    pub(super) fn work(&mut self, now: Time, hold: Hold, out: &mut Outbox) {
        let Some(job) = &mut self.job else { return };
        match job.next(now) {
            Next::Send(message) => {
                self.take_mode(&message);
                let is_over = !message.wants_answer();
                self.send(now, message, Purpose::Job, Hold { has_asked: true, ..hold }, out);
                if is_over && let Some(outcome) = self.job.as_mut().and_then(Job::sent) {
                    self.conclude(outcome);
                }
            }
            Next::Raw(octets, outcome) => {
                if let Ok(Frame::Data(frame)) = Frame::parse(&octets) {
                    self.counts.forget(frame.da);
                }
                self.transmit(now, out, |frame| frame.extend_from_slice(&octets));
                self.pause = self.pause.max(self.settings.slot_time);
                self.access = Access::Holding(Hold { has_worked: true, has_asked: true, ..hold });
                self.conclude(outcome);
            }
            Next::Exchange(connection) => {
                (self.cycles_sent, self.cycles_done) = (0, 0);
                (self.end, self.is_diagnosis_pending) = (None, false);
                self.inputs.clear();
                self.exchange = Some(Exchange::new(connection, now));
            }
            Next::Done(outcome) => self.conclude(outcome),
        }
    }

    /// Records Clear or Operate, which are also states of the master.
    fn take_mode(&mut self, message: &Message) {
        if message.dsap == Some(SlaveSap::GLOBAL_CONTROL.0)
            && let Ok(control) = GlobalControl::parse(&message.data)
        {
            self.is_clear = control.command.has(ControlCommand::CLEAR_DATA);
        }
    }

    /// Begins the next cycle.
    pub(super) fn cycle(&mut self, now: Time, hold: Hold, out: &mut Outbox) {
        let has_clock = !self.is_clock_stopped;
        let Some(exchange) = &mut self.exchange else { return };
        let message = exchange.message(&mut self.outputs, self.is_clear);
        exchange.sent(now, has_clock);
        self.cycles_sent += 1;
        self.send(now, message, Purpose::Exchange, hold, out);
    }

    /// Processes the answer to a request, or its final timeout.
    pub(super) fn answered(&mut self, now: Time, transfer: Transfer, hold: Hold, answer: Answer) {
        self.access = Access::Holding(hold);
        let Transfer { message, purpose, count, .. } = transfer;
        let is_answer = !matches!(answer, Answer::None | Answer::Unfit(_));
        if message.is_counted() {
            if is_answer {
                self.counts.answered(message.to, count);
            } else {
                self.counts.forget(message.to);
            }
        }
        match purpose {
            Purpose::Nobody => {}
            Purpose::Gap => {
                let station = match answer {
                    Answer::Frame { station, .. } => Some(station),
                    _ => None,
                };
                self.ring.asked(message.to, station);
            }
            Purpose::Diagnosis => {
                let own = self.settings.address;
                let end = self.exchange.as_mut().and_then(|exchange| exchange.diagnosed(&answer, own));
                if let Some(end) = end {
                    self.ended(answer, end);
                }
            }
            Purpose::Exchange => {
                if let Some(exchange) = &mut self.exchange {
                    exchange.take_back(message);
                }
                self.sampled(answer);
            }
            Purpose::Job => {
                let Some(job) = &mut self.job else { return };
                if let Job::SetAddress { new, .. } = job
                    && answer.is_positive()
                {
                    self.counts.forget(message.to);
                    self.counts.forget(*new);
                }
                if let Some(outcome) = job.answered(now, answer) {
                    self.conclude(outcome);
                }
            }
        }
    }

    fn sampled(&mut self, answer: Answer) {
        self.cycles_done += 1;
        let Some(exchange) = &mut self.exchange else { return };
        let is_high = matches!(&answer, Answer::Frame { function, .. } if function.is_high());
        // Only a start-up needs the answer itself.
        let start_up_answer = matches!(self.job, Some(Job::StartUp(_))).then(|| answer.clone());
        let sample = exchange.answered(answer);
        if let Sample::End(end) = &sample {
            self.exchange = None;
            if start_up_answer.is_none() {
                self.end = Some(end.clone());
            }
        }
        if let (Some(Job::StartUp(job)), Some(answer)) = (&mut self.job, start_up_answer)
            && let Some(outcome) = job.sampled(answer, &sample)
        {
            self.conclude(outcome);
        }
        if let Sample::Good(inputs) = sample {
            (self.inputs, self.is_diagnosis_pending) = (inputs, is_high);
        }
    }

    /// Ends the connection without a request of the caller.
    fn ended(&mut self, answer: Answer, end: ConnectionEnd) {
        self.exchange = None;
        match &mut self.job {
            Some(Job::StartUp(job)) => {
                if let Some(outcome) = job.sampled(answer, &Sample::End(end)) {
                    self.conclude(outcome);
                }
            }
            _ => self.end = Some(end),
        }
    }
}
