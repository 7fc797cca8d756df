//! Medium access of the master: token, silence, slot time, and what is sent next.
//!
//! This module must not know the content of the requests.

use super::access::{Access, Action, Hold, Purpose, Transfer};
use super::job::Job;
use super::master::Master;
use super::message::Message;
use super::outcome::Answer;
use alloc::vec::Vec;
use core::time::Duration;
use station::{Outbox, Station, Time};
use wire::WireError;
use wire::profibus::fdl::{
    AnswerFunction, BitTimes, DataFrame, Extension, Frame, FunctionCode, LONGEST, RequestFunction, StationType,
};

/// How often the token is sent to a master that does not use it.
const TOKEN_TRIES: u8 = 3;

impl Master {
    /// How long the bus must be silent before this master claims the token (TTO).
    fn time_out(&self) -> Duration {
        self.time(BitTimes(self.settings.slot_time.0 * (6 + 2 * u64::from(self.settings.address))))
    }

    /// The duration of the longest frame, for a frame whose end never arrives.
    fn longest(&self) -> Duration {
        self.time(BitTimes::of_octets(LONGEST + 1))
    }

    /// When an unused token is passed on, so that the other masters see it in use within the slot time.
    fn hands_token_on(&self) -> Time {
        let half = BitTimes(self.settings.slot_time.0 / 2);
        self.later(self.quiet, if self.ring.is_alone() { self.settings.token_pause } else { half })
    }

    /// The next action with the token, and when.
    fn plan(&self, hold: &Hold) -> (Time, Action) {
        let free = self.later(self.quiet, self.pause);
        let mut best = (if hold.has_worked { free } else { self.hands_token_on().max(free) }, Action::Pass);
        if !self.ring.is_alone() && hold.has_worked && free >= self.later(hold.since, self.settings.rotation) {
            return best;
        }
        let clock = match &self.exchange {
            Some(exchange) if !self.is_clock_stopped => exchange.clock_due(self.clock_offset),
            _ => None,
        };
        let exchange = self.exchange.as_ref().filter(|_| !self.outputs.is_paused());
        let diagnosis = self.exchange.as_ref().filter(|exchange| exchange.wants_diagnosis());
        let job = self.job.as_ref().filter(|_| !hold.has_asked).and_then(Job::due);
        // Of two actions due at the same time, the later one in this list wins.
        let candidates = [
            hold.gap.map(|station| (free, Action::Gap(station))),
            job.map(|due| (due, Action::Job)),
            diagnosis.map(|_| (free, Action::Diagnosis)),
            exchange.map(|exchange| (exchange.due(clock), Action::Exchange)),
            clock.map(|due| (due, Action::Clock)),
        ];
        for (due, action) in candidates.into_iter().flatten() {
            let at = due.max(free);
            if at <= best.0 {
                best = (at, action);
            }
        }
        match clock {
            // The bus must be free when the clock is due.
            Some(clock) if best.1 != Action::Clock && best.0 + self.lasts(best.1) > clock => {
                (clock.max(free), Action::Clock)
            }
            _ => best,
        }
    }

    /// How long an action keeps the bus busy, including the silence after it.
    fn lasts(&self, action: Action) -> Duration {
        let connection = self.exchange.as_ref().map(|exchange| &exchange.connection);
        let slot = self.settings.slot_time.0;
        let bits = match action {
            Action::Clock => 0,
            Action::Pass => BitTimes::of_octets(3).0,
            Action::Gap(_) => BitTimes::of_octets(6).0 + slot,
            Action::Exchange => {
                let octets = connection.map_or(0, |of| of.output_length + of.input_length);
                BitTimes::of_octets(18 + octets).0 + slot
            }
            Action::Diagnosis | Action::Job => BitTimes::of_octets(2 * LONGEST).0 + slot,
        };
        let lasts = self.time(BitTimes(bits + self.settings.idle.0));
        let most = connection.map_or(lasts, |of| of.cycle / 4);
        lasts.min(most)
    }

    fn act(&mut self, now: Time, hold: Hold, action: Action, out: &mut Outbox) {
        match action {
            Action::Clock => {
                let control = self.exchange.as_mut().and_then(|exchange| {
                    exchange.clock_done(now);
                    exchange.connection.clock
                });
                if let Some(clock) = control {
                    let message = Message::global_control(wire::profibus::fdl::BROADCAST, clock.control);
                    self.send(now, message, Purpose::Nobody, hold, out);
                }
            }
            Action::Exchange => self.cycle(now, hold, out),
            Action::Diagnosis => {
                if let Some(exchange) = &self.exchange {
                    let message = Message::diagnosis(exchange.connection.address);
                    self.send(now, message, Purpose::Diagnosis, hold, out);
                }
            }
            Action::Job => self.work(now, hold, out),
            Action::Gap(station) => {
                let hold = Hold { gap: None, ..hold };
                self.send(now, Message::fdl_status(station), Purpose::Gap, hold, out);
            }
            Action::Pass => self.pass(now, self.ring.successor(), 1, out),
        }
    }

    /// Sends the token to `to` for the `tries`-th time.
    fn pass(&mut self, now: Time, to: u8, tries: u8, out: &mut Outbox) {
        let own = self.settings.address;
        self.transmit(now, out, |octets| Frame::Token { da: to, sa: own }.write(octets));
        if to == own {
            self.take_token(self.quiet);
        } else {
            let until = self.later(self.quiet, self.settings.slot_time);
            self.begging = now;
            self.access = Access::Passing { to, tries, until };
        }
    }

    fn take_token(&mut self, since: Time) {
        let gap = self.ring.token();
        self.access = Access::Holding(Hold { since, has_worked: false, has_asked: false, gap });
    }

    /// Claims the token after a silence so long that no master can have it, and sends it twice to this master itself.
    fn claim(&mut self, now: Time, out: &mut Outbox) {
        self.ring.clear();
        self.pass(now, self.settings.address, 1, out);
        if let Access::Holding(hold) = &mut self.access {
            *hold = Hold { has_worked: true, has_asked: true, gap: None, ..*hold };
        }
    }

    /// Handles a missing or invalid answer.
    fn repeat(&mut self, now: Time, out: &mut Outbox) {
        match core::mem::replace(&mut self.access, Access::Listening) {
            Access::Asking(mut transfer, hold) if transfer.retries > 0 => {
                transfer.retries -= 1;
                let own = self.settings.address;
                self.transmit(now, out, |octets| transfer.message.write(own, transfer.count, octets));
                transfer.until = self.later(self.quiet, self.settings.slot_time);
                self.access = Access::Asking(transfer, hold);
            }
            Access::Asking(mut transfer, hold) => {
                let answer = transfer.unfit.take().unwrap_or(Answer::None);
                self.answered(now, transfer, hold, answer);
            }
            access => self.access = access,
        }
    }

    /// Processes a frame that arrives while an answer is awaited.
    fn take_answer(&mut self, now: Time, frame: Result<Frame<'_>, WireError>) {
        let own = self.settings.address;
        match core::mem::replace(&mut self.access, Access::Listening) {
            Access::Asking(mut transfer, hold) => match transfer.message.answer(own, frame) {
                Answer::Unfit(why) => {
                    transfer.unfit = Some(Answer::Unfit(why));
                    transfer.until = self.later(now, self.settings.idle);
                    self.access = Access::Asking(transfer, hold);
                }
                answer => self.answered(now, transfer, hold, answer),
            },
            access => self.access = access,
        }
    }

    /// Gives up the token because another master uses the bus.
    fn lose_token(&mut self, now: Time) {
        let access = core::mem::replace(&mut self.access, Access::Waiting);
        if let Access::Asking(transfer, hold) = access {
            let answer = Answer::Unfit("another master".into());
            self.answered(now, transfer, hold, answer);
        }
        self.begging = now;
        self.access = Access::Waiting;
    }

    /// Whether only another master that has the token sends `frame`.
    fn is_of_other_master(&self, frame: &Frame<'_>) -> bool {
        let speaker = match frame {
            Frame::Token { sa, .. } => *sa,
            Frame::Data(frame) if frame.fc.is_request() => frame.sa,
            _ => return false,
        };
        speaker != self.settings.address
    }

    /// Processes a frame of another master.
    fn overhear(&mut self, now: Time, frame: Frame<'_>) {
        let own = self.settings.address;
        match self.access {
            Access::Listening | Access::Waiting => {}
            Access::Passing { .. } => self.access = Access::Waiting,
            Access::Holding(_) | Access::Asking(..) => self.lose_token(now),
        }
        match frame {
            Frame::Token { da, sa } => {
                self.ring.heard(sa, da);
                let is_in = matches!(self.access, Access::Waiting) || self.ring.is_known();
                if da == own && is_in {
                    self.take_token(now);
                }
            }
            Frame::Data(frame) if frame.da == own && frame.fc.requested() == Some(RequestFunction::FDL_STATUS) => {
                let station = match self.access {
                    Access::Listening if self.ring.is_known() => StationType::MASTER_READY,
                    Access::Listening => StationType::MASTER_NOT_READY,
                    _ => StationType::MASTER_IN_RING,
                };
                let fc = FunctionCode::answer(AnswerFunction::OK, station);
                let mut reply = Vec::new();
                DataFrame::new((frame.sa, Extension::NONE), (own, Extension::NONE), fc, &[]).write(&mut reply);
                self.reply = Some((now + self.time(BitTimes::LEAST_DELAY), reply));
            }
            _ => {}
        }
    }

    /// When a waiting job gives up because the token does not arrive.
    fn patience(&self) -> Option<Time> {
        let is_without = matches!(self.access, Access::Listening | Access::Waiting | Access::Passing { .. });
        (is_without && self.job.is_some()).then(|| self.begging + self.settings.patience)
    }
}

impl Station for Master {
    fn carrier(&mut self, now: Time) {
        self.replan();
        self.hearing = Some(now);
    }

    fn receive(&mut self, now: Time, frame: &[u8], _out: &mut Outbox) {
        self.replan();
        self.hearing = None;
        (self.quiet, self.pause) = (now, self.settings.idle);
        match Frame::parse(frame) {
            Ok(frame) if self.is_of_other_master(&frame) => self.overhear(now, frame),
            frame if matches!(self.access, Access::Asking(..)) => self.take_answer(now, frame),
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
            let patience = self.settings.patience;
            if let Some(outcome) = self.job.as_mut().map(|job| job.without_token(patience)) {
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
            (self.hearing, self.quiet) = (None, now);
        }
        match &self.access {
            Access::Listening | Access::Waiting => {
                if now >= self.quiet + self.time_out() {
                    self.claim(now, out);
                }
            }
            Access::Holding(hold) => {
                let hold = *hold;
                let (at, action) = planned.unwrap_or_else(|| self.plan(&hold));
                if now >= at {
                    self.act(now, hold, action, out);
                }
            }
            Access::Asking(transfer, _) => {
                if now >= transfer.until {
                    self.repeat(now, out);
                }
            }
            Access::Passing { to, tries, until } => {
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

impl Master {
    /// When it has something to do next.
    fn next_due(&self) -> Time {
        let due = self.due.as_ref().map(|(due, _)| *due);
        let reply = self.reply.as_ref().map(|(due, _)| *due);
        let medium = match (self.hearing, &self.access) {
            (Some(since), _) => since + self.longest(),
            (None, Access::Listening | Access::Waiting) => self.quiet + self.time_out(),
            (None, Access::Holding(hold)) => {
                let planned = self.plan(hold);
                self.planned.set(Some(planned));
                planned.0
            }
            (None, Access::Asking(Transfer { until, .. }, _) | Access::Passing { until, .. }) => *until,
        };
        [due, reply, self.patience()].into_iter().flatten().fold(medium, Time::min)
    }
}
