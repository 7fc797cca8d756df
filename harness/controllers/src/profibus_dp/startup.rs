//! The start-up of a slave: its services in sequence, as a state machine that sends nothing itself.

use super::connection::{SlaveConfig, StartUpService};
use super::exchange::{ExchangeSample, is_lost};
use super::job::MasterJobStep;
use super::message::DpMessage;
use super::outcome::{
    DataLinkAnswer, MasterOutcome, SlaveConnectionEnd, SlaveFailureReason, SlaveStartUpFailure, SlaveStartUpResult,
    SlaveStartUpStage,
};
use alloc::boxed::Box;
use core::time::Duration;
use station::Time;
use wire::profibus::diag::{Status1, Status2};
use wire::profibus::fdl::BROADCAST;
use wire::profibus::global_control::{GlobalCommand, GlobalControl};
use wire::profibus::sap::SlaveSap;

/// Time between two Slave_Diag requests while the slave is absent.
const SEARCH_PAUSE: Duration = Duration::from_millis(10);

/// A running start-up.
#[derive(Debug)]
pub(super) struct SlaveStartUpJob {
    connection: Box<SlaveConfig>,
    own: u8,
    /// Index of the current service.
    at: usize,
    /// When this service began.
    since: Time,
    next: Time,
    result: Box<SlaveStartUpResult>,
    is_exchanging: bool,
}

impl SlaveStartUpJob {
    pub fn new(connection: Box<SlaveConfig>, own: u8, now: Time) -> SlaveStartUpJob {
        let result = Box::default();
        SlaveStartUpJob { connection, own, at: 0, since: now, next: now, result, is_exchanging: false }
    }

    /// The current stage; after the last one, that one.
    pub fn stage(&self) -> SlaveStartUpStage {
        match self.service().or(self.connection.services.last().copied()) {
            None => SlaveStartUpStage::Token,
            Some(StartUpService::Diagnosis) => SlaveStartUpStage::Diagnosis,
            Some(StartUpService::SetPrm) => SlaveStartUpStage::SetPrm,
            Some(StartUpService::CheckConfiguration) => SlaveStartUpStage::CheckConfiguration,
            Some(StartUpService::Ready | StartUpService::Operate) => SlaveStartUpStage::Ready,
            Some(StartUpService::Exchange) => SlaveStartUpStage::Exchange,
        }
    }

    fn service(&self) -> Option<StartUpService> {
        self.connection.services.get(self.at).copied()
    }

    /// When it has something to send; `None` while it waits for the first valid data.
    pub fn due(&self) -> Option<Time> {
        (!self.is_exchanging).then_some(self.next)
    }

    /// The next step.
    pub fn next(&mut self, now: Time) -> MasterJobStep {
        let to = self.connection.address;
        match self.service() {
            None => MasterJobStep::Done(self.done()),
            Some(StartUpService::Diagnosis | StartUpService::Ready) => MasterJobStep::Send(DpMessage::diagnosis(to)),
            Some(StartUpService::SetPrm) => {
                MasterJobStep::Send(DpMessage::service(to, SlaveSap::SET_PRM, self.connection.set_prm.clone()))
            }
            Some(StartUpService::CheckConfiguration) => {
                MasterJobStep::Send(DpMessage::service(to, SlaveSap::CHK_CFG, self.connection.chk_cfg.clone()))
            }
            Some(StartUpService::Operate) => {
                self.advance(now);
                let control = GlobalControl { command: GlobalCommand::default(), groups: 0 };
                MasterJobStep::Send(DpMessage::global_control(BROADCAST, control))
            }
            Some(StartUpService::Exchange) => {
                self.is_exchanging = true;
                MasterJobStep::Exchange(self.connection.clone())
            }
        }
    }

    fn advance(&mut self, now: Time) {
        (self.at, self.since, self.next) = (self.at + 1, now, now);
    }

    /// Processes the answer to what was sent; returns the outcome at the end.
    pub fn answered(&mut self, now: Time, answer: DataLinkAnswer) -> Option<MasterOutcome> {
        let is_silent = matches!(answer, DataLinkAnswer::None | DataLinkAnswer::Unfit(_));
        let is_late = now.since(self.since) >= self.connection.patience;
        match self.service()? {
            StartUpService::Diagnosis => {
                self.result.diagnosis_before = Some(answer.clone());
                match (is_silent, is_late) {
                    (false, _) => self.advance(now),
                    (true, false) => self.next = now + SEARCH_PAUSE,
                    (true, true) => return Some(self.fail(SlaveFailureReason::Answer(answer))),
                }
            }
            StartUpService::SetPrm | StartUpService::CheckConfiguration => {
                let slot = match self.service() {
                    Some(StartUpService::SetPrm) => &mut self.result.set_prm,
                    _ => &mut self.result.chk_cfg,
                };
                *slot = Some(answer.clone());
                if is_silent {
                    return Some(self.fail(SlaveFailureReason::Answer(answer)));
                }
                self.advance(now);
            }
            StartUpService::Ready => return self.ready(now, answer, is_silent, is_late),
            StartUpService::Operate | StartUpService::Exchange => {}
        }
        None
    }

    /// Processes a diagnosis after Set_Prm and Chk_Cfg.
    fn ready(&mut self, now: Time, answer: DataLinkAnswer, is_silent: bool, is_late: bool) -> Option<MasterOutcome> {
        self.result.diagnosis_after = Some(answer.clone());
        let Some(diagnosis) = answer.diagnosis() else {
            if is_silent && !is_late {
                self.next = now + SEARCH_PAUSE;
                return None;
            }
            return Some(self.fail(SlaveFailureReason::Answer(answer)));
        };
        let is_waiting =
            diagnosis.status_1.has(Status1::STATION_NOT_READY) || diagnosis.status_2.has(Status2::STAT_DIAG);
        if is_lost(&diagnosis, self.own) || diagnosis.status_1.has(Status1::NOT_SUPPORTED) {
            return Some(self.fail(SlaveFailureReason::Diagnosis(diagnosis)));
        }
        match (is_waiting, is_late) {
            (false, _) => self.advance(now),
            (true, false) => self.next = now + self.connection.cycle,
            (true, true) => return Some(self.fail(SlaveFailureReason::NotReady(self.connection.patience))),
        }
        None
    }

    /// Processes the result of a Data_Exchange; returns the outcome at the end.
    pub fn sampled(&mut self, answer: DataLinkAnswer, sample: &ExchangeSample) -> Option<MasterOutcome> {
        self.result.first_data = Some(answer.clone());
        match sample {
            ExchangeSample::Good(_) => {
                self.result.standing = true;
                self.at += 1;
                Some(self.done())
            }
            ExchangeSample::End(SlaveConnectionEnd::Diagnosis(diagnosis)) => {
                Some(self.fail(SlaveFailureReason::Diagnosis(diagnosis.clone())))
            }
            ExchangeSample::End(SlaveConnectionEnd::Answer(_)) => Some(self.fail(SlaveFailureReason::Answer(answer))),
        }
    }

    /// Ends the start-up in its current stage.
    pub fn fail(&mut self, why: SlaveFailureReason) -> MasterOutcome {
        self.result.failed = Some(SlaveStartUpFailure { stage: self.stage(), why });
        self.done()
    }

    fn done(&mut self) -> MasterOutcome {
        MasterOutcome::StartUp(core::mem::take(&mut self.result))
    }
}
