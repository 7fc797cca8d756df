//! Medium access of the master: how it gets the token and passes it on, silence, and slot time.
//!
//! This module must not know the content of the requests.

use super::access::{Action, MediumAccess, PendingTransfer, Purpose, TokenHold};
use super::master::{MOST_MISFITS, ProfibusMaster};
use super::message::DpMessage;
use super::outcome::DataLinkAnswer;
use super::settings::MasterSettings;
use alloc::vec::Vec;
use core::time::Duration;
use station::{Outbox, Station, Time};
use wire::WireError;
use wire::profibus::fdl::{
    AnswerFunction, BitTimes, DataFrame, Extension, FdlFrame, FunctionCode, LONGEST, RequestFunction, StationType,
};

/// How often the token is sent to a master that does not use it.
const TOKEN_TRIES: u8 = 3;

impl ProfibusMaster {
    /// How long the bus must be silent before this master claims the token (TTO).
    fn time_out(&self) -> Duration {
        self.time(BitTimes(self.settings.slot_time.0 * (6 + 2 * u64::from(self.settings.address))))
    }

    /// The duration of the longest frame, for a frame whose end never arrives.
    fn longest(&self) -> Duration {
        self.time(BitTimes::of_octets(LONGEST + 1))
    }

    fn act(&mut self, now: Time, hold: TokenHold, action: Action, out: &mut Outbox) {
        match action {
            Action::Clock => {
                let control = self.exchange.as_mut().and_then(|exchange| {
                    exchange.clock_done(now);
                    exchange.connection.clock
                });
                if let Some(clock) = control {
                    let message = DpMessage::global_control(wire::profibus::fdl::BROADCAST, clock.control);
                    self.send(now, message, Purpose::Discarded, hold, out);
                }
            }
            Action::Exchange => self.cycle(now, hold, out),
            Action::Diagnosis => {
                if let Some(exchange) = &self.exchange {
                    let message = DpMessage::diagnosis(exchange.connection.address);
                    self.send(now, message, Purpose::Diagnosis, hold, out);
                }
            }
            Action::Job => self.work(now, hold, out),
            Action::Gap(station) => {
                let hold = TokenHold { gap: None, has_polled: true, ..hold };
                self.send(now, DpMessage::fdl_status(station), Purpose::Gap, hold, out);
            }
            Action::Pass => {
                self.note_starvation(now, &hold);
                self.pass(now, self.ring.successor(), 1, out);
            }
        }
    }

    /// Sends the token to `to` for the `tries`-th time.
    fn pass(&mut self, now: Time, to: u8, tries: u8, out: &mut Outbox) {
        let own = self.settings.address;
        self.transmit(now, out, |octets| FdlFrame::Token { da: to, sa: own }.write(octets));
        if to == own {
            self.take_token(self.silent_since);
        } else {
            let until = self.later(self.silent_since, self.settings.slot_time);
            self.waiting_since = now;
            self.access = MediumAccess::Passing { to, tries, until };
        }
    }

    /// Claims the token after a silence so long that no master can have it, and sends it twice to this master itself.
    fn claim(&mut self, now: Time, out: &mut Outbox) {
        self.ring.clear();
        self.token_received = None;
        self.pass(now, self.settings.address, 1, out);
        if let MediumAccess::Holding(hold) = &mut self.access {
            *hold = TokenHold { has_worked: true, has_sent_message: true, gap: None, ..*hold };
        }
    }

    /// Handles a missing or invalid answer.
    fn repeat(&mut self, now: Time, out: &mut Outbox) {
        match core::mem::replace(&mut self.access, MediumAccess::Listening) {
            MediumAccess::AwaitingAnswer(mut transfer, hold) if transfer.retries > 0 => {
                transfer.retries -= 1;
                let own = self.settings.address;
                self.transmit(now, out, |octets| transfer.message.write(own, transfer.count, octets));
                transfer.sent = self.silent_since;
                transfer.until = self.later(self.silent_since, self.settings.slot_time);
                // What is sent again on purpose is no retry.
                if transfer.repetition.is_none() {
                    self.statistics.repeated(transfer.message.to);
                }
                self.access = MediumAccess::AwaitingAnswer(transfer, hold);
            }
            MediumAccess::AwaitingAnswer(mut transfer, hold) => {
                let answer = transfer.unfit.take().unwrap_or(DataLinkAnswer::None);
                if transfer.purpose != Purpose::Gap {
                    self.statistics.unanswered(transfer.message.to);
                }
                self.answered(now, transfer, hold, answer);
            }
            access => self.access = access,
        }
    }

    /// Processes a frame that arrives while an answer is awaited.
    ///
    /// It began at `begin`.
    fn take_answer(&mut self, now: Time, begin: Time, frame: Result<FdlFrame<'_>, WireError>) {
        let own = self.settings.address;
        let is_valid = matches!(frame, Ok(FdlFrame::Data(_)));
        match core::mem::replace(&mut self.access, MediumAccess::Listening) {
            MediumAccess::AwaitingAnswer(mut transfer, hold) => match transfer.message.answer(own, frame) {
                DataLinkAnswer::Unfit(why) => {
                    if is_valid && transfer.purpose != Purpose::Gap && self.misfits.len() < MOST_MISFITS {
                        self.misfits.push((transfer.message.to, why.clone()));
                    }
                    transfer.unfit = Some(DataLinkAnswer::Unfit(why));
                    transfer.until = self.later(now, self.settings.idle_after_answer());
                    self.access = MediumAccess::AwaitingAnswer(transfer, hold);
                }
                answer => {
                    if transfer.purpose != Purpose::Gap {
                        self.measure(&transfer, begin);
                    }
                    self.answered(now, transfer, hold, answer);
                }
            },
            access => self.access = access,
        }
    }

    /// Adds the time of an answer that began at `begin` to the statistics.
    fn measure(&mut self, transfer: &PendingTransfer, begin: Time) {
        let MasterSettings { baud, min_tsdr, max_tsdr, .. } = self.settings;
        // To the nearest bit: the times of a bus are rounded to whole nanoseconds.
        let half = baud.nanoseconds(BitTimes(1)) / 2;
        let time = baud.bits(begin.nanos_since(transfer.sent).saturating_add(half));
        self.statistics.answered(transfer.message.to, time, (min_tsdr, max_tsdr));
    }

    /// Gives up the token because another master uses the bus.
    fn lose_token(&mut self, now: Time) {
        let access = core::mem::replace(&mut self.access, MediumAccess::Waiting);
        if let MediumAccess::AwaitingAnswer(transfer, hold) = access {
            let answer = DataLinkAnswer::Unfit("another master".into());
            self.answered(now, transfer, hold, answer);
        }
        self.waiting_since = now;
        self.access = MediumAccess::Waiting;
    }

    /// Whether only another master that has the token sends `frame`.
    fn is_of_other_master(&self, frame: &FdlFrame<'_>) -> bool {
        let speaker = match frame {
            FdlFrame::Token { sa, .. } => *sa,
            FdlFrame::Data(frame) if frame.fc.is_request() => frame.sa,
            _ => return false,
        };
        speaker != self.settings.address
    }

    /// Processes a frame of another master.
    fn receive_foreign(&mut self, now: Time, frame: FdlFrame<'_>) {
        let own = self.settings.address;
        match self.access {
            MediumAccess::Listening | MediumAccess::Waiting => {}
            MediumAccess::Passing { .. } => self.access = MediumAccess::Waiting,
            MediumAccess::Holding(_) | MediumAccess::AwaitingAnswer(..) => self.lose_token(now),
        }
        match frame {
            FdlFrame::Token { da, sa } if da == own && self.is_in_ring() => {
                if self.ring.token_offered(sa) {
                    self.take_token(now);
                }
                return;
            }
            FdlFrame::Token { da, sa } => self.ring.token_observed(sa, da),
            FdlFrame::Data(frame) if frame.da == own && frame.fc.requested() == Some(RequestFunction::FDL_STATUS) => {
                let station = match self.access {
                    MediumAccess::Listening if self.ring.is_complete() => StationType::MASTER_READY,
                    MediumAccess::Listening => StationType::MASTER_NOT_READY,
                    _ => StationType::MASTER_IN_RING,
                };
                let fc = FunctionCode::answer(AnswerFunction::OK, station);
                let mut reply = Vec::new();
                DataFrame::new((frame.sa, Extension::NONE), (own, Extension::NONE), fc, &[]).write(&mut reply);
                self.reply = Some((now + self.time(BitTimes::DEFAULT_MIN_TSDR), reply));
            }
            _ => {}
        }
        self.ring.token_in_use();
    }

    /// Whether other masters may pass the token to this one.
    fn is_in_ring(&self) -> bool {
        matches!(self.access, MediumAccess::Waiting) || self.ring.is_complete()
    }

    /// When a waiting job gives up because the token does not arrive, or leaves no time for it.
    fn patience(&self) -> Option<Time> {
        self.job.as_ref()?;
        let is_without =
            matches!(self.access, MediumAccess::Listening | MediumAccess::Waiting | MediumAccess::Passing { .. });
        let without = is_without.then_some(self.waiting_since);
        let since = [without, self.starved_since].into_iter().flatten().min()?;
        Some(since + self.settings.patience)
    }
}

impl Station for ProfibusMaster {
    fn carrier(&mut self, now: Time) {
        self.replan();
        self.hearing = Some(now);
    }

    fn receive(&mut self, now: Time, frame: &[u8], _out: &mut Outbox) {
        self.replan();
        // A line reports the first character when it was read, which may be as late as the last one.
        let lasts = self.time(BitTimes::of_octets(frame.len()));
        let begin = self.hearing.take().unwrap_or(now).min(now - lasts);
        (self.silent_since, self.pause) = (now, self.settings.idle_after_answer());
        match FdlFrame::parse(frame) {
            Ok(frame) if self.is_of_other_master(&frame) => self.receive_foreign(now, frame),
            frame if matches!(self.access, MediumAccess::AwaitingAnswer(..)) => self.take_answer(now, begin, frame),
            _ => {}
        }
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        let planned = self.planned.take().filter(|_| self.due.is_none());
        self.replan();
        if let Some((_, request)) = self.due.take_if(|(due, _)| now >= *due) {
            self.begin(now, request);
        }
        if self.patience().is_some_and(|until| now >= until) {
            let (patience, is_starved) = (self.settings.patience, self.starved_since.is_some());
            if let Some(outcome) = self.job.as_mut().map(|job| job.without_token(patience, is_starved)) {
                self.conclude(outcome);
            }
        }
        if let Some((_, reply)) = self.reply.take_if(|(due, _)| now >= *due) {
            self.transmit(now, out, |octets| octets.extend_from_slice(&reply));
            return;
        }
        if let Some(since) = self.hearing {
            if now < since + self.longest() {
                return;
            }
            (self.hearing, self.silent_since) = (None, now);
        }
        match &self.access {
            MediumAccess::Listening | MediumAccess::Waiting => {
                if now >= self.silent_since + self.time_out() {
                    self.claim(now, out);
                }
            }
            MediumAccess::Holding(hold) => {
                let hold = *hold;
                let (at, action) = planned.unwrap_or_else(|| self.plan(&hold));
                if now >= at {
                    self.act(now, hold, action, out);
                }
            }
            MediumAccess::AwaitingAnswer(transfer, _) => {
                if now >= transfer.until {
                    self.repeat(now, out);
                }
            }
            MediumAccess::Passing { to, tries, until } => {
                let (to, tries) = (*to, *tries);
                if now < *until {
                    return;
                }
                if tries < TOKEN_TRIES {
                    self.pass(now, to, tries + 1, out);
                } else {
                    self.ring.remove(to);
                    self.pass(now, self.ring.successor(), 1, out);
                }
            }
        }
    }

    fn deadline(&self) -> Option<Time> {
        let deadline = self.deadline.get().unwrap_or_else(|| self.next_due());
        self.deadline.set(Some(deadline));
        Some(deadline)
    }
}

impl ProfibusMaster {
    /// When it has something to do next.
    fn next_due(&self) -> Time {
        let due = self.due.as_ref().map(|(due, _)| *due);
        let reply = self.reply.as_ref().map(|(due, _)| *due);
        let medium = match (self.hearing, &self.access) {
            (Some(since), _) => since + self.longest(),
            (None, MediumAccess::Listening | MediumAccess::Waiting) => self.silent_since + self.time_out(),
            (None, MediumAccess::Holding(hold)) => {
                let planned = self.plan(hold);
                self.planned.set(Some(planned));
                planned.0
            }
            (
                None,
                MediumAccess::AwaitingAnswer(PendingTransfer { until, .. }, _) | MediumAccess::Passing { until, .. },
            ) => *until,
        };
        [due, reply, self.patience()].into_iter().flatten().fold(medium, Time::min)
    }
}
