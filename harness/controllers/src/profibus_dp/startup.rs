//! The start-up of a slave: its services in sequence, as a state machine that sends nothing itself.

use super::connection::{Connection, Service};
use super::exchange::{Sample, is_lost};
use super::job::Next;
use super::message::Message;
use super::outcome::{Answer, ConnectionEnd, Failure, FailureReason, Outcome, Stage, StartUp};
use alloc::boxed::Box;
use core::time::Duration;
use station::Time;
use wire::profibus::diag::{Status1, Status2};
use wire::profibus::fdl::BROADCAST;
use wire::profibus::global_control::{ControlCommand, GlobalControl};
use wire::profibus::sap::SlaveSap;

/// Time between two Slave_Diag requests while the slave is absent.
const SEARCH_PAUSE: Duration = Duration::from_millis(10);

/// A running start-up.
#[derive(Debug)]
pub(super) struct StartUpJob {
    connection: Box<Connection>,
    own: u8,
    /// Index of the current service.
    at: usize,
    /// When this service began.
    since: Time,
    next: Time,
    told: Box<StartUp>,
    is_exchanging: bool,
}

impl StartUpJob {
    pub fn new(connection: Box<Connection>, own: u8, now: Time) -> StartUpJob {
        let told = Box::default();
        StartUpJob { connection, own, at: 0, since: now, next: now, told, is_exchanging: false }
    }

    /// The current stage; after the last one, that one.
    pub fn stage(&self) -> Stage {
        match self.service().or(self.connection.services.last().copied()) {
            None => Stage::Token,
            Some(Service::Diagnosis) => Stage::Diagnosis,
            Some(Service::SetPrm) => Stage::SetPrm,
            Some(Service::CheckConfiguration) => Stage::CheckConfiguration,
            Some(Service::Ready | Service::Operate) => Stage::Ready,
            Some(Service::Exchange) => Stage::Exchange,
        }
    }

    fn service(&self) -> Option<Service> {
        self.connection.services.get(self.at).copied()
    }

    /// When it has something to send; `None` while it waits for the first valid data.
    pub fn due(&self) -> Option<Time> {
        (!self.is_exchanging).then_some(self.next)
    }

    /// The next step.
    pub fn next(&mut self, now: Time) -> Next {
        let to = self.connection.address;
        match self.service() {
            None => Next::Done(self.done()),
            Some(Service::Diagnosis | Service::Ready) => Next::Send(Message::diagnosis(to)),
            Some(Service::SetPrm) => {
                Next::Send(Message::service(to, SlaveSap::SET_PRM, self.connection.set_prm.clone()))
            }
            Some(Service::CheckConfiguration) => {
                Next::Send(Message::service(to, SlaveSap::CHK_CFG, self.connection.chk_cfg.clone()))
            }
            Some(Service::Operate) => {
                self.advance(now);
                let control = GlobalControl { command: ControlCommand::default(), groups: 0 };
                Next::Send(Message::global_control(BROADCAST, control))
            }
            Some(Service::Exchange) => {
                self.is_exchanging = true;
                Next::Exchange(self.connection.clone())
            }
        }
    }

    fn advance(&mut self, now: Time) {
        (self.at, self.since, self.next) = (self.at + 1, now, now);
    }

    /// Processes the answer to what was sent; returns the outcome at the end.
    pub fn answered(&mut self, now: Time, answer: Answer) -> Option<Outcome> {
        let is_silent = matches!(answer, Answer::None | Answer::Unfit(_));
        let is_late = now.since(self.since) >= self.connection.patience;
        match self.service()? {
            Service::Diagnosis => {
                self.told.diagnosis_before = Some(answer.clone());
                match (is_silent, is_late) {
                    (false, _) => self.advance(now),
                    (true, false) => self.next = now + SEARCH_PAUSE,
                    (true, true) => return Some(self.fail(FailureReason::Answer(answer))),
                }
            }
            Service::SetPrm | Service::CheckConfiguration => {
                let slot = match self.service() {
                    Some(Service::SetPrm) => &mut self.told.set_prm,
                    _ => &mut self.told.chk_cfg,
                };
                *slot = Some(answer.clone());
                if is_silent {
                    return Some(self.fail(FailureReason::Answer(answer)));
                }
                self.advance(now);
            }
            Service::Ready => return self.ready(now, answer, is_silent, is_late),
            Service::Operate | Service::Exchange => {}
        }
        None
    }

    /// Processes a diagnosis after Set_Prm and Chk_Cfg.
    fn ready(&mut self, now: Time, answer: Answer, is_silent: bool, is_late: bool) -> Option<Outcome> {
        self.told.diagnosis_after = Some(answer.clone());
        let Some(diagnosis) = answer.diagnosis() else {
            if is_silent && !is_late {
                self.next = now + SEARCH_PAUSE;
                return None;
            }
            return Some(self.fail(FailureReason::Answer(answer)));
        };
        let is_waiting =
            diagnosis.status_1.has(Status1::STATION_NOT_READY) || diagnosis.status_2.has(Status2::STAT_DIAG);
        if is_lost(&diagnosis, self.own) || diagnosis.status_1.has(Status1::NOT_SUPPORTED) {
            return Some(self.fail(FailureReason::Diagnosis(diagnosis)));
        }
        match (is_waiting, is_late) {
            (false, _) => self.advance(now),
            (true, false) => self.next = now + self.connection.cycle,
            (true, true) => return Some(self.fail(FailureReason::NotReady(self.connection.patience))),
        }
        None
    }

    /// Processes the result of a Data_Exchange; returns the outcome at the end.
    pub fn sampled(&mut self, answer: Answer, sample: &Sample) -> Option<Outcome> {
        self.told.first_data = Some(answer.clone());
        match sample {
            Sample::Good(_) => {
                self.told.standing = true;
                self.at += 1;
                Some(self.done())
            }
            Sample::Missed => None,
            Sample::End(ConnectionEnd::Diagnosis(diagnosis)) => {
                Some(self.fail(FailureReason::Diagnosis(diagnosis.clone())))
            }
            Sample::End(ConnectionEnd::Answer(_)) => Some(self.fail(FailureReason::Answer(answer))),
        }
    }

    /// Ends the start-up in its current stage.
    pub fn fail(&mut self, why: FailureReason) -> Outcome {
        self.told.failed = Some(Failure { stage: self.stage(), why });
        self.done()
    }

    fn done(&mut self) -> Outcome {
        Outcome::StartUp(core::mem::take(&mut self.told))
    }
}
