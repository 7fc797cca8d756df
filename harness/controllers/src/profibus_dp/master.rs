//! The master: it assigns requests and answers to the ring, the cyclic exchange and the current request.

use super::access::{Action, MediumAccess, PendingTransfer, Purpose, TokenHold};
use super::acyclic::AcyclicTiming;
use super::exchange::{ExchangeSample, SlaveExchange};
use super::job::{MasterJob, MasterJobStep};
use super::message::{DpMessage, FrameCountBits};
use super::ms2_state::Ms2State;
use super::outcome::{ConnectionState, DataLinkAnswer, MasterOutcome, SlaveConnectionEnd, SlaveReleaseOutcome};
use super::repetition::RequestRepetition;
use super::request::{MasterBusy, MasterRequest};
use super::ring::LogicalRing;
use super::settings::MasterSettings;
use super::{OUTPUT_SLOT, OUTPUT_SUBSLOT};
use crate::outputs::CyclicOutputs;
use alloc::string::String;
use alloc::vec::Vec;
use core::cell::Cell;
use core::time::Duration;
use station::{Outbox, Time};
use wire::profibus::fdl::{BitTimes, FdlFrame, FrameCount};
use wire::profibus::global_control::{GlobalCommand, GlobalControl};
use wire::profibus::sap::SlaveSap;
use wire::profibus::statistics::BusStatistics;

/// Shortest time between two DP-V1 polls.
pub(super) const POLL: Duration = Duration::from_millis(1);

/// The outcome of a request that cannot be repeated.
const NOT_REPEATABLE: MasterOutcome = MasterOutcome::Impossible("this request cannot be sent again");

/// How many answers that do not fit are kept.
pub(super) const MOST_MISFITS: usize = 16;

/// A PROFIBUS DP master.
///
/// It accepts one [`MasterRequest`] at a time. A request begins as soon as the master has the token and the bus is free. A running
/// connection needs no further requests.
#[derive(Debug)]
pub struct ProfibusMaster {
    pub(super) settings: MasterSettings,
    pub(super) outputs: CyclicOutputs,
    pub(super) access: MediumAccess,
    pub(super) ring: LogicalRing,
    pub(super) counts: FrameCountBits,
    /// Since when the bus is silent, as far as this master knows.
    pub(super) silent_since: Time,
    /// How long the bus has to be silent before the next frame of this master.
    pub(super) pause: BitTimes,
    /// Since when another station is sending.
    pub(super) hearing: Option<Time>,
    /// The pending reply to another master, and when it is sent.
    pub(super) reply: Option<(Time, Vec<u8>)>,
    pub(super) due: Option<(Time, MasterRequest)>,
    pub(super) job: Option<MasterJob>,
    /// Set while the frames of the job are sent again after their answers.
    pub(super) repetition: Option<RequestRepetition>,
    /// Since when there is a job but no token.
    pub(super) waiting_since: Time,
    /// Since when the token leaves no time for the job.
    pub(super) starved_since: Option<Time>,
    /// When the token was received last; TRR is measured from here.
    pub(super) token_received: Option<Time>,
    pub(super) exchange: Option<SlaveExchange>,
    /// The connection of this master as a class 2 master.
    pub(super) ms2: Ms2State,
    is_clear: bool,
    outcome: Option<MasterOutcome>,
    end: Option<SlaveConnectionEnd>,
    inputs: Vec<u8>,
    is_diagnosis_pending: bool,
    cycles_sent: u64,
    cycles_done: u64,
    /// Answers that did not fit the request before them: the station that was asked, and why.
    pub(super) misfits: Vec<(u8, String)>,
    pub(super) statistics: BusStatistics,
    pub(super) clock_offset: Duration,
    pub(super) is_clock_stopped: bool,
    /// The cached deadline. It is valid until the next event or call.
    pub(super) deadline: Cell<Option<Time>>,
    /// The cached next action with the token, and when.
    pub(super) planned: Cell<Option<(Time, Action)>>,
}

impl ProfibusMaster {
    /// A master outside the ring, in Operate, without a connection, with all outputs 0.
    pub fn new(settings: MasterSettings) -> ProfibusMaster {
        let ring = LogicalRing::new(settings.address, settings.highest, settings.gap_factor);
        let pause = settings.idle_after_answer();
        ProfibusMaster {
            settings,
            outputs: CyclicOutputs::default(),
            access: MediumAccess::Listening,
            ring,
            counts: FrameCountBits::default(),
            silent_since: Time::ZERO,
            pause,
            hearing: None,
            reply: None,
            due: None,
            job: None,
            repetition: None,
            waiting_since: Time::ZERO,
            starved_since: None,
            token_received: None,
            exchange: None,
            ms2: Ms2State::default(),
            is_clear: false,
            outcome: None,
            end: None,
            inputs: Vec::new(),
            is_diagnosis_pending: false,
            cycles_sent: 0,
            cycles_done: 0,
            misfits: Vec::new(),
            statistics: BusStatistics::default(),
            clock_offset: Duration::ZERO,
            is_clock_stopped: false,
            deadline: Cell::default(),
            planned: Cell::default(),
        }
    }

    /// Accepts a request, which begins once the bus is free; an outcome that was not taken is discarded. Fails while the previous
    /// request has not ended. [`MasterRequest::Abort`] is accepted at any time: it also ends the running request, whose outcome is then
    /// that of the abort.
    pub fn request(&mut self, now: Time, request: MasterRequest) -> Result<(), MasterBusy> {
        if self.is_busy() && request != MasterRequest::Abort {
            return Err(MasterBusy);
        }
        self.replan();
        self.outcome = None;
        if self.job.is_some() && request != MasterRequest::Abort {
            // An Idle of MS2 has not been answered yet.
            self.ms2.queued = Some((now, request));
        } else {
            self.due = Some((now, request));
        }
        Ok(())
    }

    /// Whether the last request has not ended yet.
    pub fn is_busy(&self) -> bool {
        self.due.is_some() || self.ms2.queued.is_some() || self.job.is_some() && !self.ms2.is_idle
    }

    /// Takes the outcome of the last request, once.
    pub fn take_outcome(&mut self) -> Option<MasterOutcome> {
        self.outcome.take()
    }

    /// Takes the reason why the connection ended without a request, once; the outcome of a start-up reports its own end.
    pub fn take_end(&mut self) -> Option<SlaveConnectionEnd> {
        self.end.take()
    }

    /// The state of the connection as the master knows it.
    pub fn state(&self) -> ConnectionState {
        let of_job = self.job.as_ref().and_then(MasterJob::state);
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

    /// Valid answers that did not fit the request before them, with the station that was asked: from another station, to another station,
    /// or from another access point. At most the first 16 since the start are kept.
    pub fn misfits(&self) -> &[(u8, String)] {
        &self.misfits
    }

    /// The answer times, retries and token rotations since the start.
    pub fn statistics(&self) -> &BusStatistics {
        &self.statistics
    }

    /// The cyclic outputs, stored as slot [`OUTPUT_SLOT`], subslot [`OUTPUT_SUBSLOT`]; they outlive every connection.
    pub fn outputs_mut(&mut self) -> &mut CyclicOutputs {
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
    pub fn settings(&self) -> &MasterSettings {
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
    pub(super) fn begin(&mut self, now: Time, request: MasterRequest) {
        if request == MasterRequest::Abort {
            self.abort();
            return;
        }
        if matches!(request, MasterRequest::Connect(_)) && self.exchange.is_some() {
            self.outcome = Some(MasterOutcome::Impossible("a connection stands already"));
            return;
        }
        let released = match request {
            MasterRequest::Release => self.exchange.take().map(|exchange| exchange.connection),
            _ => None,
        };
        let poll = self.exchange.as_ref().map_or(POLL, |exchange| exchange.connection.cycle.max(POLL));
        let pace = AcyclicTiming { poll, patience: self.settings.acyclic };
        (self.waiting_since, self.starved_since) = (now, None);
        let (request, times) = match request {
            MasterRequest::Repeated { request, times } => (*request, Some(times)),
            request => (request, None),
        };
        self.repetition = times.map(RequestRepetition::new);
        match MasterJob::new(request, now, &self.settings, pace, released.as_deref(), self.ms2.connection) {
            Ok(job) if times.is_some() && !job.is_repeatable() => self.outcome = Some(NOT_REPEATABLE),
            Ok(job) => self.job = Some(job),
            Err(outcome) => self.outcome = Some(outcome),
        }
    }

    fn abort(&mut self) {
        let had = self.exchange.take().is_some() | self.job.take().is_some();
        self.repetition = None;
        self.ms2 = Ms2State::default();
        if let MediumAccess::AwaitingAnswer(transfer, _) = &mut self.access
            && transfer.purpose != Purpose::Gap
        {
            transfer.purpose = Purpose::Discarded;
        }
        let ended = if had { SlaveReleaseOutcome::Aborted } else { SlaveReleaseOutcome::NoConnection };
        self.outcome = Some(MasterOutcome::Ended(ended));
    }

    /// Ends the job with its outcome.
    pub(super) fn conclude(&mut self, outcome: MasterOutcome) {
        if let MasterOutcome::StartUp(start_up) = &outcome
            && !start_up.standing
        {
            self.exchange = None;
        }
        if core::mem::take(&mut self.ms2.is_idle) {
            (self.job, self.due) = (None, self.ms2.queued.take());
            return;
        }
        let outcome = match self.repetition.take() {
            Some(repetition) => repetition.outcome(outcome),
            None => outcome,
        };
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
        self.silent_since = self.later(now, BitTimes::of_octets(length));
        self.pause = self.settings.idle_after_answer();
        self.hearing = None;
        self.keep_ms2(now);
    }

    /// Sends `message` and waits for its answer, if its function has one.
    pub(super) fn send(&mut self, now: Time, message: DpMessage, purpose: Purpose, hold: TokenHold, out: &mut Outbox) {
        let count = if message.is_counted() { self.counts.next(message.to) } else { FrameCount::Unused };
        let own = self.settings.address;
        self.transmit(now, out, |octets| message.write(own, count, octets));
        let hold = TokenHold { has_worked: true, ..hold };
        if !message.expects_answer() {
            self.pause = self.settings.idle_after_unanswered();
            self.access = MediumAccess::Holding(hold);
            return;
        }
        let retries = if purpose == Purpose::Gap { 0 } else { self.settings.retries };
        let until = self.later(self.silent_since, self.settings.slot_time);
        let sent = self.silent_since;
        let transfer = PendingTransfer { message, purpose, count, sent, retries, until, unfit: None, repetition: None };
        self.access = MediumAccess::AwaitingAnswer(transfer, hold);
    }

    /// Performs the next step of the job.
    pub(super) fn work(&mut self, now: Time, hold: TokenHold, out: &mut Outbox) {
        self.starved_since = None;
        let Some(job) = &mut self.job else { return };
        match job.next(now) {
            MasterJobStep::Send(message) if self.needs_introduction(&message) => {
                self.send(now, DpMessage::diagnosis(message.to), Purpose::Discarded, hold, out);
            }
            MasterJobStep::Send(message) => {
                self.take_mode(&message);
                let is_over = !message.expects_answer();
                self.send(now, message, Purpose::Job, TokenHold { has_sent_message: true, ..hold }, out);
                if is_over && let Some(outcome) = self.job.as_mut().and_then(MasterJob::sent) {
                    self.conclude(outcome);
                }
            }
            MasterJobStep::Raw(octets) => {
                self.transmit_raw(now, &octets, out);
                self.pause = self.pause.max(self.settings.slot_time);
                self.access = MediumAccess::Holding(TokenHold { has_worked: true, has_sent_message: true, ..hold });
                self.conclude(MasterOutcome::Sent);
            }
            MasterJobStep::Damaged(octets, message) => {
                self.transmit_raw(now, &octets, out);
                let until = self.later(self.silent_since, self.settings.slot_time);
                let count = FrameCount::First;
                let (purpose, sent, retries) = (Purpose::Job, self.silent_since, 0);
                let (unfit, repetition) = (None, None);
                let transfer = PendingTransfer { message, purpose, count, sent, retries, until, unfit, repetition };
                let hold = TokenHold { has_worked: true, has_sent_message: true, ..hold };
                self.access = MediumAccess::AwaitingAnswer(transfer, hold);
            }
            MasterJobStep::Exchange(connection) => {
                (self.cycles_sent, self.cycles_done) = (0, 0);
                (self.end, self.is_diagnosis_pending) = (None, false);
                self.inputs.clear();
                self.exchange = Some(SlaveExchange::new(connection, now));
            }
            MasterJobStep::Done(outcome) => self.conclude(outcome),
        }
    }

    /// Sends bytes as they are; the frame count of their receiver begins again.
    fn transmit_raw(&mut self, now: Time, octets: &[u8], out: &mut Outbox) {
        if let Ok(FdlFrame::Data(frame)) = FdlFrame::parse(octets) {
            self.counts.forget(frame.da);
        }
        self.transmit(now, out, |frame| frame.extend_from_slice(octets));
    }

    /// Records Clear or Operate, which are also states of the master.
    fn take_mode(&mut self, message: &DpMessage) {
        if message.dsap == Some(SlaveSap::GLOBAL_CONTROL.0)
            && let Ok(control) = GlobalControl::parse(&message.data)
        {
            self.is_clear = control.command.has(GlobalCommand::CLEAR_DATA);
        }
    }

    /// Begins the next cycle.
    pub(super) fn cycle(&mut self, now: Time, hold: TokenHold, out: &mut Outbox) {
        let has_clock = !self.is_clock_stopped;
        let Some(exchange) = &mut self.exchange else { return };
        let message = exchange.message(&mut self.outputs, self.is_clear);
        exchange.sent(now, has_clock);
        self.cycles_sent += 1;
        self.send(now, message, Purpose::Exchange, hold, out);
    }

    /// Processes the answer to a request, or its final timeout.
    pub(super) fn answered(&mut self, now: Time, transfer: PendingTransfer, hold: TokenHold, answer: DataLinkAnswer) {
        let Some((transfer, answer)) = self.repeated(now, transfer, hold, answer) else { return };
        self.access = MediumAccess::Holding(hold);
        let PendingTransfer { message, purpose, count, .. } = transfer;
        if message.is_counted() {
            if answer.is_frame() {
                self.counts.answered(message.to, count);
            } else {
                self.counts.forget(message.to);
            }
        }
        match purpose {
            Purpose::Discarded => {}
            Purpose::Gap => {
                let station = match answer {
                    DataLinkAnswer::Frame { station, .. } => Some(station),
                    _ => None,
                };
                self.ring.polled(message.to, station);
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
                if let MasterJob::SetAddress { new, .. } = job
                    && answer.is_positive()
                {
                    self.counts.forget(message.to);
                    self.counts.forget(*new);
                }
                if let MasterJob::Ms2(job) = job {
                    if let Some(result) = job.answered(now, answer) {
                        self.ms2_done(now, result);
                    }
                } else if let Some(outcome) = job.answered(now, answer) {
                    self.conclude(outcome);
                }
            }
        }
    }

    fn sampled(&mut self, answer: DataLinkAnswer) {
        self.cycles_done += 1;
        let Some(exchange) = &mut self.exchange else { return };
        let is_high = matches!(&answer, DataLinkAnswer::Frame { function, .. } if function.is_high());
        // Only a start-up needs the answer itself.
        let start_up_answer = matches!(self.job, Some(MasterJob::StartUp(_))).then(|| answer.clone());
        let sample = exchange.answered(answer);
        if let ExchangeSample::End(end) = &sample {
            self.exchange = None;
            if start_up_answer.is_none() {
                self.end = Some(end.clone());
            }
        }
        if let (Some(MasterJob::StartUp(job)), Some(answer)) = (&mut self.job, start_up_answer)
            && let Some(outcome) = job.sampled(answer, &sample)
        {
            self.conclude(outcome);
        }
        if let ExchangeSample::Good(inputs) = sample {
            (self.inputs, self.is_diagnosis_pending) = (inputs, is_high);
        }
    }

    /// Ends the connection without a request of the caller.
    fn ended(&mut self, answer: DataLinkAnswer, end: SlaveConnectionEnd) {
        self.exchange = None;
        match &mut self.job {
            Some(MasterJob::StartUp(job)) => {
                if let Some(outcome) = job.sampled(answer, &ExchangeSample::End(end)) {
                    self.conclude(outcome);
                }
            }
            _ => self.end = Some(end),
        }
    }
}
