//! The master itself: who gets which request and which answer.

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

/// The least time between two polls of DP-V1.
const POLL: Duration = Duration::from_millis(1);

/// A PROFIBUS DP master.
///
/// It takes one [`Request`] at a time. After [`Master::request`] it begins as soon as it has the token and the bus is free. While a
/// connection stands it needs no request to keep it up.
#[derive(Debug)]
pub struct Master {
    pub(super) settings: Settings,
    pub(super) outputs: Outputs,
    pub(super) access: Access,
    pub(super) ring: Ring,
    counts: Counts,
    /// Since when the bus is silent, as far as we know.
    pub(super) quiet: Time,
    /// How long it has to be silent before our next frame.
    pub(super) pause: BitTimes,
    /// Since when somebody else is sending.
    pub(super) hearing: Option<Time>,
    /// What is answered to another master, and when.
    pub(super) reply: Option<(Time, Vec<u8>)>,
    pub(super) due: Option<(Time, Request)>,
    pub(super) job: Option<Job>,
    /// Since when there is a job and no token.
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
    /// Its deadline, where it was asked since something happened to it: until then it stays the same.
    pub(super) deadline: Cell<Option<Time>>,
    /// What it then found to do next with the token, and when.
    pub(super) planned: Cell<Option<(Time, Action)>>,
}

impl Master {
    /// A master that is not yet in the ring, in Operate, without a connection, with all outputs 0.
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

    /// Takes a request, which begins once the bus is free; an outcome that nobody took is forgotten.
    ///
    /// The error says that the one before has not ended yet. [`Request::Abort`] is taken at any time: it also ends what is under way,
    /// whose outcome is then that of the abort.
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

    /// What became of the last request, once.
    pub fn take_outcome(&mut self) -> Option<Outcome> {
        self.outcome.take()
    }

    /// Why the connection ended without our asking, once; the end of a start-up is told in its outcome instead.
    pub fn take_end(&mut self) -> Option<ConnectionEnd> {
        self.end.take()
    }

    /// What it sees of its connection.
    pub fn state(&self) -> ConnectionState {
        let of_job = self.job.as_ref().and_then(Job::state);
        let standing = if self.exchange.is_some() { ConnectionState::Exchange } else { ConnectionState::None };
        of_job.unwrap_or(standing)
    }

    /// Data_Exchange requests sent in the present connection, or in the last one; repetitions do not count.
    pub fn cycles_sent(&self) -> u64 {
        self.cycles_sent
    }

    /// Those of them that are over: answered, or given up.
    pub fn cycles_done(&self) -> u64 {
        self.cycles_done
    }

    /// What is sent cyclically, as the outputs of slot [`OUTPUT_SLOT`], subslot [`OUTPUT_SUBSLOT`]; it outlives every connection.
    pub fn outputs_mut(&mut self) -> &mut Outputs {
        self.replan();
        &mut self.outputs
    }

    /// Sets the outputs from the first octet on.
    pub fn set_outputs(&mut self, octets: &[u8]) {
        self.replan();
        self.outputs.declare_bytes(OUTPUT_SLOT, OUTPUT_SUBSLOT, octets.len());
        self.outputs.set_bytes(octets);
    }

    /// The inputs of the last good Data_Exchange.
    pub fn inputs(&self) -> &[u8] {
        &self.inputs
    }

    /// Whether the last good Data_Exchange was answered with high priority.
    pub fn is_diagnosis_pending(&self) -> bool {
        self.is_diagnosis_pending
    }

    /// Stops (`true`) or resumes the clock of isochronous mode; it outlives every connection.
    pub fn stop_clock(&mut self, stopped: bool) {
        self.replan();
        self.is_clock_stopped = stopped;
    }

    /// Shifts the clock of isochronous mode against the beginning of the cycle; it outlives every connection.
    ///
    /// A clock that is to come early is one that comes late by what the cycle is longer.
    pub fn shift_clock(&mut self, offset: Duration) {
        self.replan();
        self.clock_offset = offset;
    }

    /// Who the master is.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Something happened: what is next, and when, has to be found out anew.
    pub(super) fn replan(&mut self) {
        self.deadline.take();
        self.planned.take();
    }

    /// How long `bits` last.
    pub(super) fn time(&self, bits: BitTimes) -> Duration {
        Duration::from_nanos(self.settings.baud.nanoseconds(bits))
    }

    /// The time `bits` after `time`.
    pub(super) fn later(&self, time: Time, bits: BitTimes) -> Time {
        time.after_nanos(self.settings.baud.nanoseconds(bits))
    }

    /// Begins what was asked for, with the token or without.
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

    /// Puts the frame that `write` appends on the bus; the silence behind it begins at its end.
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

    /// Sends `message` and waits for its answer, where there is to be one.
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

    /// Lets the job do what it wants to do now.
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

    /// Clear and Operate are states of the master too.
    fn take_mode(&mut self, message: &Message) {
        if message.dsap == Some(SlaveSap::GLOBAL_CONTROL.0)
            && let Ok(control) = GlobalControl::parse(&message.data)
        {
            self.is_clear = control.command.has(ControlCommand::CLEAR_DATA);
        }
    }

    /// The next cycle begins.
    pub(super) fn cycle(&mut self, now: Time, hold: Hold, out: &mut Outbox) {
        let has_clock = !self.is_clock_stopped;
        let Some(exchange) = &mut self.exchange else { return };
        let message = exchange.message(&mut self.outputs, self.is_clear);
        exchange.sent(now, has_clock);
        self.cycles_sent += 1;
        self.send(now, message, Purpose::Exchange, hold, out);
    }

    /// A request has its answer, or never gets one.
    pub(super) fn answered(&mut self, now: Time, transfer: Transfer, hold: Hold, answer: Answer) {
        self.access = Access::Holding(hold);
        let Transfer { message, purpose, count, .. } = transfer;
        let is_answer = !matches!(answer, Answer::None | Answer::Unfit(_));
        if message.is_counted() {
            match is_answer {
                true => self.counts.answered(message.to, count),
                false => self.counts.forget(message.to),
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
        // Only a start-up wants to know the answer itself.
        let told = matches!(self.job, Some(Job::StartUp(_))).then(|| answer.clone());
        let sample = exchange.answered(answer);
        if let Sample::End(end) = &sample {
            self.exchange = None;
            if told.is_none() {
                self.end = Some(end.clone());
            }
        }
        if let (Some(Job::StartUp(job)), Some(answer)) = (&mut self.job, told)
            && let Some(outcome) = job.sampled(answer, &sample)
        {
            self.conclude(outcome);
        }
        if let Sample::Good(inputs) = sample {
            (self.inputs, self.is_diagnosis_pending) = (inputs, is_high);
        }
    }

    /// The connection ended without our asking.
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
