//! The request that the master is carrying out.

use super::acyclic::{Pace, ParameterJob, RecordJob};
use super::broken;
use super::connection::Connection;
use super::message::Message;
use super::outcome::{Answer, ConnectionState, Ended, FailureReason, Outcome};
use super::request::{Request, Settings};
use super::startup::StartUpJob;
use alloc::boxed::Box;
use alloc::vec::Vec;
use station::Time;
use wire::profibus::address::SetSlaveAddress;
use wire::profibus::fdl::RequestFunction;
use wire::profibus::prm::{SetPrm, StationStatus};
use wire::profibus::sap::SlaveSap;

/// A request that has begun.
#[derive(Debug)]
pub(super) enum Job {
    /// One message, whose answer is the outcome; it is sent from this time on.
    Single(Message, Time),
    /// A station gets another address.
    SetAddress {
        message: Message,
        new: u8,
        since: Time,
    },
    /// Raw bytes, and the outcome.
    Raw {
        octets: Vec<u8>,
        outcome: Outcome,
        since: Time,
    },
    StartUp(Box<StartUpJob>),
    Record(RecordJob),
    Parameter(ParameterJob),
    Release(Message, Time),
}

/// The next step of a job.
#[derive(Debug)]
pub(super) enum Next {
    Send(Message),
    Raw(Vec<u8>, Outcome),
    /// The cyclic exchange begins; the job waits for its samples.
    Exchange(Box<Connection>),
    Done(Outcome),
}

impl Job {
    /// The job for `request`, which is not [`Request::Abort`]; `released` is the connection that Release ends.
    pub fn new(
        request: Request,
        now: Time,
        settings: &Settings,
        pace: Pace,
        released: Option<&Connection>,
    ) -> Result<Job, Outcome> {
        let single = |message| Ok(Job::Single(message, now));
        match request {
            Request::Connect(connection) => Ok(Job::StartUp(StartUpJob::new(connection, settings.address, now).into())),
            Request::Abort => Err(Outcome::Ended(Ended::Aborted)),
            Request::Release => match released {
                Some(connection) => Ok(Job::Release(unlock(connection), now)),
                None => Err(Outcome::Ended(Ended::NoConnection)),
            },
            Request::Diagnosis { to } => single(Message::diagnosis(to)),
            Request::Configuration { to } => single(Message::service(to, SlaveSap::GET_CFG, Vec::new())),
            Request::ReadInputs { to } => single(Message::service(to, SlaveSap::READ_INPUTS, Vec::new())),
            Request::ReadOutputs { to } => single(Message::service(to, SlaveSap::READ_OUTPUTS, Vec::new())),
            Request::SetSlaveAddress { to, set } => {
                Ok(Job::SetAddress { message: set_address(to, &set), new: set.address, since: now })
            }
            Request::GlobalControl { to, control } => single(Message::global_control(to, control)),
            Request::FdlStatus { to } => single(Message::fdl_status(to)),
            Request::SetPrm { to, octets } => single(Message::service(to, SlaveSap::SET_PRM, octets)),
            Request::CheckConfiguration { to, octets } => single(Message::service(to, SlaveSap::CHK_CFG, octets)),
            Request::DataExchange { to, octets } => single(Message::exchange(to, octets)),
            Request::Service { to, dsap, ssap, octets } => {
                single(Message { to, dsap, ssap, function: RequestFunction::SRD_HIGH, data: octets })
            }
            Request::Read { to, slot, index, length } => {
                Ok(Job::Record(RecordJob::read(now, pace, to, (slot, index), length)))
            }
            Request::Write { to, slot, index, data } => {
                Ok(Job::Record(RecordJob::write(now, pace, to, (slot, index), data)))
            }
            Request::Parameter { to, slot, request } => {
                Ok(Job::Parameter(ParameterJob::new(now, pace, to, slot, request)))
            }
            Request::Raw(octets) => Ok(Job::Raw { octets, outcome: Outcome::Sent, since: now }),
            Request::Broken { to, broken } => {
                let octets = broken::frame(settings.address, to, broken);
                Ok(Job::Raw { octets: octets.clone(), outcome: Outcome::Broken(octets), since: now })
            }
        }
    }

    /// When it has something to send; `None` while it waits for something else.
    pub fn due(&self) -> Option<Time> {
        match self {
            Job::Single(_, since) | Job::Release(_, since) => Some(*since),
            Job::SetAddress { since, .. } | Job::Raw { since, .. } => Some(*since),
            Job::StartUp(job) => job.due(),
            Job::Record(job) => Some(job.due()),
            Job::Parameter(job) => Some(job.due()),
        }
    }

    /// The next step.
    pub fn next(&mut self, now: Time) -> Next {
        match self {
            Job::Single(message, _) | Job::Release(message, _) | Job::SetAddress { message, .. } => {
                Next::Send(message.clone())
            }
            Job::Raw { octets, outcome, .. } => Next::Raw(octets.clone(), outcome.clone()),
            Job::StartUp(job) => job.next(now),
            Job::Record(job) => Next::Send(job.message()),
            Job::Parameter(job) => Next::Send(job.message()),
        }
    }

    /// Processes the answer to what was sent; returns the outcome at the end.
    pub fn answered(&mut self, now: Time, answer: Answer) -> Option<Outcome> {
        match self {
            Job::Single(..) | Job::SetAddress { .. } => Some(Outcome::Answer(answer)),
            Job::Release(..) => Some(Outcome::Ended(Ended::Released(answer))),
            Job::Raw { .. } => None,
            Job::StartUp(job) => job.answered(now, answer),
            Job::Record(job) => job.answered(now, answer).map(Outcome::Record),
            Job::Parameter(job) => job.answered(now, answer).map(Outcome::Parameter),
        }
    }

    /// Records that a message without an answer was sent; returns the outcome at the end.
    pub fn sent(&mut self) -> Option<Outcome> {
        match self {
            Job::Single(..) | Job::SetAddress { .. } => Some(Outcome::Sent),
            Job::Release(..) => Some(Outcome::Ended(Ended::Aborted)),
            Job::Raw { .. } | Job::StartUp(_) | Job::Record(_) | Job::Parameter(_) => None,
        }
    }

    /// The connection state while this job runs, if the job determines it.
    pub fn state(&self) -> Option<ConnectionState> {
        match self {
            Job::StartUp(job) => Some(ConnectionState::Starting(job.stage())),
            Job::Release(..) => Some(ConnectionState::Releasing),
            _ => None,
        }
    }

    /// The outcome if the token does not arrive within `patience`.
    pub fn without_token(&mut self, patience: core::time::Duration) -> Outcome {
        match self {
            Job::StartUp(job) => job.fail(FailureReason::NoToken(patience)),
            _ => Outcome::Impossible("the master does not get the token"),
        }
    }
}

fn set_address(to: u8, set: &SetSlaveAddress) -> Message {
    let mut data = Vec::new();
    set.write(&mut data);
    Message::service(to, SlaveSap::SET_SLAVE_ADDRESS, data)
}

/// A Set_Prm that releases the slave of `connection` (Unlock_Req).
fn unlock(connection: &Connection) -> Message {
    let mut data = Vec::new();
    match SetPrm::parse(&connection.set_prm) {
        Ok(prm) => SetPrm { status: StationStatus::UNLOCK_REQ, user: Vec::new(), ..prm }.write(&mut data),
        Err(_) => data.extend([StationStatus::UNLOCK_REQ.0, 1, 1, 11, 0, 0, 0]),
    }
    Message::service(connection.address, SlaveSap::SET_PRM, data)
}
