//! The request that the master is carrying out.

use super::acyclic::{AcyclicPoint, AcyclicTiming, ParameterJob, RecordJob};
use super::broken;
use super::connection::SlaveConfig;
use super::message::DpMessage;
use super::ms2::{Class2Connection, Ms2Job};
use super::outcome::{ConnectionState, DataLinkAnswer, MasterOutcome, SlaveFailureReason, SlaveReleaseOutcome};
use super::request::MasterRequest;
use super::settings::MasterSettings;
use super::startup::SlaveStartUpJob;
use alloc::boxed::Box;
use alloc::vec::Vec;
use station::Time;
use wire::profibus::address::SetSlaveAddress;
use wire::profibus::fdl::RequestFunction;
use wire::profibus::prm::{SetPrm, StationStatus};
use wire::profibus::sap::SlaveSap;

/// A request that has begun.
#[derive(Debug)]
pub(super) enum MasterJob {
    /// One message, whose answer is the outcome; it is sent from this time on.
    Single(DpMessage, Time),
    /// A station gets another address.
    SetAddress {
        message: DpMessage,
        new: u8,
        since: Time,
    },
    /// Raw bytes without an answer.
    Raw {
        octets: Vec<u8>,
        since: Time,
    },
    /// A damaged frame, and the request that its answer has to fit.
    Damaged {
        octets: Vec<u8>,
        request: DpMessage,
        since: Time,
    },
    StartUp(Box<SlaveStartUpJob>),
    Record(RecordJob),
    Parameter(ParameterJob),
    /// A request on MS2, or an Idle of the master itself.
    Ms2(Box<Ms2Job>),
    Release(DpMessage, Time),
}

/// The next step of a job.
#[derive(Debug)]
pub(super) enum MasterJobStep {
    Send(DpMessage),
    Raw(Vec<u8>),
    /// A damaged frame, whose answer is awaited once.
    Damaged(Vec<u8>, DpMessage),
    /// The cyclic exchange begins; the job waits for its samples.
    Exchange(Box<SlaveConfig>),
    Done(MasterOutcome),
}

impl MasterJob {
    /// The job for `request`, which is not [`MasterRequest::Abort`]; `released` is the connection that Release ends, and `ms2` the one of
    /// a class 2 master that stands.
    pub fn new(
        request: MasterRequest,
        now: Time,
        settings: &MasterSettings,
        pace: AcyclicTiming,
        released: Option<&SlaveConfig>,
        ms2: Option<Class2Connection>,
    ) -> Result<MasterJob, MasterOutcome> {
        let single = |message| Ok(MasterJob::Single(message, now));
        match request {
            MasterRequest::Connect(connection) => {
                Ok(MasterJob::StartUp(SlaveStartUpJob::new(connection, settings.address, now).into()))
            }
            MasterRequest::Abort => Err(MasterOutcome::Ended(SlaveReleaseOutcome::Aborted)),
            MasterRequest::Release => match released {
                Some(connection) => Ok(MasterJob::Release(unlock(connection), now)),
                None => Err(MasterOutcome::Ended(SlaveReleaseOutcome::NoConnection)),
            },
            MasterRequest::Diagnosis { to } => single(DpMessage::diagnosis(to)),
            MasterRequest::Configuration { to } => single(DpMessage::service(to, SlaveSap::GET_CFG, Vec::new())),
            MasterRequest::ReadInputs { to } => single(DpMessage::service(to, SlaveSap::READ_INPUTS, Vec::new())),
            MasterRequest::ReadOutputs { to } => single(DpMessage::service(to, SlaveSap::READ_OUTPUTS, Vec::new())),
            MasterRequest::SetSlaveAddress { to, set } => {
                Ok(MasterJob::SetAddress { message: set_address(to, &set), new: set.address, since: now })
            }
            MasterRequest::GlobalControl { to, control } => single(DpMessage::global_control(to, control)),
            MasterRequest::FdlStatus { to } => single(DpMessage::fdl_status(to)),
            MasterRequest::SetPrm { to, octets } => single(DpMessage::service(to, SlaveSap::SET_PRM, octets)),
            MasterRequest::CheckConfiguration { to, octets } => {
                single(DpMessage::service(to, SlaveSap::CHK_CFG, octets))
            }
            MasterRequest::DataExchange { to, octets } => single(DpMessage::exchange(to, octets)),
            MasterRequest::Service { to, dsap, ssap, octets } => {
                single(DpMessage { to, dsap, ssap, function: RequestFunction::SRD_HIGH, data: octets })
            }
            MasterRequest::Read { to, slot, index, length } => {
                Ok(MasterJob::Record(RecordJob::read(now, pace, AcyclicPoint::ms1(to), (slot, index), length)))
            }
            MasterRequest::Write { to, slot, index, data } => {
                Ok(MasterJob::Record(RecordJob::write(now, pace, AcyclicPoint::ms1(to), (slot, index), data)))
            }
            MasterRequest::AcknowledgeAlarm { to, own_access_point, slot, alarm_type, specifier } => {
                let point = if own_access_point { AcyclicPoint::alarms(to) } else { AcyclicPoint::ms1(to) };
                Ok(MasterJob::Record(RecordJob::acknowledge(now, pace, point, slot, (alarm_type, specifier))))
            }
            MasterRequest::Call { to, slot, index } => {
                Ok(MasterJob::Record(RecordJob::call(now, pace, AcyclicPoint::ms1(to), slot, index)))
            }
            MasterRequest::Parameter { to, slot, request } => {
                Ok(MasterJob::Parameter(ParameterJob::new(now, pace, to, slot, request)))
            }
            MasterRequest::Ms2 { to, service } => match Ms2Job::new(now, pace, to, service, ms2) {
                Ok(job) => Ok(MasterJob::Ms2(Box::new(job))),
                Err(why) => Err(MasterOutcome::Impossible(why)),
            },
            MasterRequest::Repeated { .. } => Err(MasterOutcome::Impossible("a request is repeated once")),
            MasterRequest::Raw(octets) => Ok(MasterJob::Raw { octets, since: now }),
            MasterRequest::Broken { to, broken } => {
                let octets = broken::frame(settings.address, to, broken);
                Ok(MasterJob::Damaged { octets, request: broken::request(to, broken), since: now })
            }
        }
    }

    /// Whether its frames can be sent again: each has an answer, after which the station is where it was.
    pub fn is_repeatable(&self) -> bool {
        match self {
            MasterJob::Single(message, _) => message.is_counted(),
            MasterJob::Record(_) => true,
            MasterJob::Ms2(_) => true,
            _ => false,
        }
    }

    /// When it has something to send; `None` while it waits for something else.
    pub fn due(&self) -> Option<Time> {
        match self {
            MasterJob::Single(_, since) | MasterJob::Release(_, since) => Some(*since),
            MasterJob::SetAddress { since, .. } | MasterJob::Raw { since, .. } | MasterJob::Damaged { since, .. } => {
                Some(*since)
            }
            MasterJob::StartUp(job) => job.due(),
            MasterJob::Record(job) => Some(job.due()),
            MasterJob::Parameter(job) => Some(job.due()),
            MasterJob::Ms2(job) => Some(job.due()),
        }
    }

    /// The next step.
    pub fn next(&mut self, now: Time) -> MasterJobStep {
        match self {
            MasterJob::Single(message, _) | MasterJob::Release(message, _) | MasterJob::SetAddress { message, .. } => {
                MasterJobStep::Send(message.clone())
            }
            MasterJob::Raw { octets, .. } => MasterJobStep::Raw(octets.clone()),
            MasterJob::Damaged { octets, request, .. } => MasterJobStep::Damaged(octets.clone(), request.clone()),
            MasterJob::StartUp(job) => job.next(now),
            MasterJob::Record(job) => MasterJobStep::Send(job.message()),
            MasterJob::Parameter(job) => MasterJobStep::Send(job.message()),
            MasterJob::Ms2(job) => MasterJobStep::Send(job.message()),
        }
    }

    /// Processes the answer to what was sent; returns the outcome at the end.
    pub fn answered(&mut self, now: Time, answer: DataLinkAnswer) -> Option<MasterOutcome> {
        match self {
            MasterJob::Single(..) | MasterJob::SetAddress { .. } => Some(MasterOutcome::Answer(answer)),
            MasterJob::Release(..) => Some(MasterOutcome::Ended(SlaveReleaseOutcome::Released(answer))),
            // The master takes its result, which changes the connection.
            MasterJob::Raw { .. } | MasterJob::Ms2(_) => None,
            MasterJob::Damaged { octets, .. } => {
                Some(MasterOutcome::Broken { octets: core::mem::take(octets), answer })
            }
            MasterJob::StartUp(job) => job.answered(now, answer),
            MasterJob::Record(job) => job.answered(now, answer).map(MasterOutcome::Record),
            MasterJob::Parameter(job) => job.answered(now, answer).map(MasterOutcome::Parameter),
        }
    }

    /// Records that a message without an answer was sent; returns the outcome at the end.
    pub fn sent(&mut self) -> Option<MasterOutcome> {
        match self {
            MasterJob::Single(..) | MasterJob::SetAddress { .. } => Some(MasterOutcome::Sent),
            MasterJob::Release(..) => Some(MasterOutcome::Ended(SlaveReleaseOutcome::Aborted)),
            MasterJob::Raw { .. }
            | MasterJob::Damaged { .. }
            | MasterJob::StartUp(_)
            | MasterJob::Record(_)
            | MasterJob::Parameter(_)
            | MasterJob::Ms2(_) => None,
        }
    }

    /// The connection state while this job runs, if the job determines it.
    pub fn state(&self) -> Option<ConnectionState> {
        match self {
            MasterJob::StartUp(job) => Some(ConnectionState::Starting(job.stage())),
            MasterJob::Release(..) => Some(ConnectionState::Releasing),
            _ => None,
        }
    }

    /// Whether its next message has high priority, as those of the DP-V0 services and raw bytes have. DP-V1, and the FDL status of a
    /// station, have low priority.
    pub fn is_high(&self) -> bool {
        match self {
            MasterJob::Single(message, _) => message.is_high(),
            MasterJob::Record(_) | MasterJob::Parameter(_) | MasterJob::Ms2(_) => false,
            MasterJob::SetAddress { .. }
            | MasterJob::Raw { .. }
            | MasterJob::Damaged { .. }
            | MasterJob::StartUp(_)
            | MasterJob::Release(..) => true,
        }
    }

    /// The outcome if the token does not arrive within `patience`, or, where the master `is_starved`, always arrives too late.
    pub fn without_token(&mut self, patience: core::time::Duration, is_starved: bool) -> MasterOutcome {
        match self {
            MasterJob::StartUp(job) => job.fail(SlaveFailureReason::NoToken(patience)),
            _ if is_starved => MasterOutcome::Impossible("the token comes too late to leave time for the request"),
            _ => MasterOutcome::Impossible("the master does not get the token"),
        }
    }
}

fn set_address(to: u8, set: &SetSlaveAddress) -> DpMessage {
    let mut data = Vec::new();
    set.write(&mut data);
    DpMessage::service(to, SlaveSap::SET_SLAVE_ADDRESS, data)
}

/// A Set_Prm that releases the slave of `connection` (Unlock_Req).
fn unlock(connection: &SlaveConfig) -> DpMessage {
    let mut data = Vec::new();
    match SetPrm::parse(&connection.set_prm) {
        Ok(prm) => SetPrm { status: StationStatus::UNLOCK_REQ, user: Vec::new(), ..prm }.write(&mut data),
        Err(_) => data.extend([StationStatus::UNLOCK_REQ.0, 1, 1, 11, 0, 0, 0]),
    }
    DpMessage::service(connection.address, SlaveSap::SET_PRM, data)
}
