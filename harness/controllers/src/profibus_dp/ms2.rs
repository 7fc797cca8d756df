//! The connection of a class 2 master with a slave (MS2): opening, keeping it alive, closing.
//!
//! The master sends Initiate to the resource manager of the slave, polls that for the access point of the connection, and polls the
//! access point for the response. While the connection stands it sends Idle when it has sent nothing for half the Send_Timeout, and the
//! slave answers with Idle. This module must not know the content of records. Source: IEC 61158-6-3, MSAC2M.

use super::acyclic::{AcyclicPoint, AcyclicTiming, RecordJob};
use super::message::DpMessage;
use super::ms2_outcome::{Ms2End, Ms2Opened, Ms2Outcome};
use super::outcome::{AcyclicError, DataLinkAnswer, DpRecordOutcome};
use super::request::{Ms2Parameters, Ms2Service};
use alloc::format;
use alloc::string::ToString;
use alloc::vec::Vec;
use core::time::Duration;
use station::Time;
use wire::profibus::dpv1::{Dpv1AbortReason, Dpv1Function, Dpv1Pdu, PduDirection, Subnet};
use wire::profibus::sap::SlaveSap;

/// Unit of Send_Timeout: 10 ms.
const SEND_TIMEOUT_UNIT: Duration = Duration::from_millis(10);

/// A standing connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Class2Connection {
    pub to: u8,
    /// The access point of the connection at the slave.
    pub sap: u8,
    /// The longer Send_Timeout of the two stations.
    pub send_timeout: Duration,
}

impl Class2Connection {
    /// When Idle is due after a frame at `now`.
    pub fn idle_due(&self, now: Time) -> Time {
        now + self.send_timeout / 2
    }

    /// How long the slave may take for an answer: it sends Idle at least this often.
    fn pace(&self, pace: AcyclicTiming) -> AcyclicTiming {
        AcyclicTiming { patience: self.send_timeout * 2, ..pace }
    }

    fn point(&self) -> AcyclicPoint {
        AcyclicPoint::ms2(self.to, self.sap)
    }
}

/// A request on MS2, and the change of the connection that it results in.
#[derive(Debug)]
pub(super) struct Ms2Job {
    step: Ms2Step,
    pace: AcyclicTiming,
}

#[derive(Debug)]
enum Ms2Step {
    /// Initiate is sent, then the resource manager is polled.
    Manager { to: u8, parameters: Ms2Parameters, poll: PollState },
    /// The access point is polled for the response to Initiate.
    Opening { connection: Class2Connection, poll: PollState },
    /// A record is read or written.
    Record { connection: Class2Connection, job: RecordJob },
    /// Idle is sent and polled for.
    Idle { connection: Class2Connection, poll: PollState },
    /// Abort is sent, because the caller requested it or after a timeout with this outcome.
    Abort {
        connection: Class2Connection,
        subnet: Subnet,
        reason: Dpv1AbortReason,
        after: Option<Ms2Outcome>,
        since: Time,
    },
}

/// Where a request with its polls stands.
#[derive(Debug)]
struct PollState {
    is_requested: bool,
    next: Time,
    until: Time,
    patience: Duration,
}

impl PollState {
    fn new(now: Time, patience: Duration) -> PollState {
        PollState { is_requested: false, next: now, until: now + patience, patience }
    }
}

/// What a job on MS2 has ended with.
#[derive(Debug)]
pub(super) struct Ms2Result {
    /// The connection after it.
    pub connection: Option<Class2Connection>,
    pub outcome: Ms2Outcome,
}

impl Ms2Job {
    /// The job for a service to the station `to`; fails if it does not fit the standing connection.
    pub fn new(
        now: Time,
        pace: AcyclicTiming,
        to: u8,
        service: Ms2Service,
        standing: Option<Class2Connection>,
    ) -> Result<Ms2Job, &'static str> {
        let connection =
            standing.filter(|standing| standing.to == to).ok_or("no MS2 connection stands with this slave");
        let step = match service {
            Ms2Service::Initiate(_) if standing.is_some() => return Err("an MS2 connection stands already"),
            Ms2Service::Initiate(parameters) => {
                Ms2Step::Manager { to, parameters, poll: PollState::new(now, pace.patience) }
            }
            Ms2Service::Read { slot, index, length } => {
                let connection = connection?;
                let (pace, point) = (connection.pace(pace), connection.point());
                Ms2Step::Record { connection, job: RecordJob::read(now, pace, point, (slot, index), length) }
            }
            Ms2Service::Write { slot, index, data } => {
                let connection = connection?;
                let (pace, point) = (connection.pace(pace), connection.point());
                Ms2Step::Record { connection, job: RecordJob::write(now, pace, point, (slot, index), data) }
            }
            Ms2Service::Call { slot, index } => {
                let connection = connection?;
                let (pace, point) = (connection.pace(pace), connection.point());
                Ms2Step::Record { connection, job: RecordJob::call(now, pace, point, slot, index) }
            }
            Ms2Service::Abort { subnet, reason } => {
                Ms2Step::Abort { connection: connection?, subnet, reason, after: None, since: now }
            }
        };
        Ok(Ms2Job { step, pace })
    }

    /// Idle, which keeps a connection alive.
    pub fn idle(now: Time, pace: AcyclicTiming, connection: Class2Connection) -> Ms2Job {
        let poll = PollState::new(now, connection.pace(pace).patience);
        Ms2Job { step: Ms2Step::Idle { connection, poll }, pace }
    }

    /// When it has something to send.
    pub fn due(&self) -> Time {
        match &self.step {
            Ms2Step::Manager { poll, .. } | Ms2Step::Opening { poll, .. } | Ms2Step::Idle { poll, .. } => poll.next,
            Ms2Step::Record { job, .. } => job.due(),
            Ms2Step::Abort { since, .. } => *since,
        }
    }

    /// The next request or poll.
    pub fn message(&self) -> DpMessage {
        let of = |point: AcyclicPoint, pdu: Option<Dpv1Pdu>| {
            let mut data = Vec::new();
            if let Some(pdu) = pdu {
                pdu.write(&mut data);
            }
            point.message(data)
        };
        match &self.step {
            Ms2Step::Manager { to, parameters, poll } => {
                let Ms2Parameters { send_timeout, abilities } = parameters;
                let pdu = || Dpv1Pdu::InitiateRequest {
                    reserved: [0; 3],
                    send_timeout: *send_timeout,
                    abilities: abilities.clone(),
                };
                of(AcyclicPoint::ms2(*to, SlaveSap::RESOURCE_MANAGER.0), (!poll.is_requested).then(pdu))
            }
            Ms2Step::Opening { connection, .. } => of(connection.point(), None),
            Ms2Step::Record { job, .. } => job.message(),
            Ms2Step::Idle { connection, poll } => {
                of(connection.point(), (!poll.is_requested).then(|| Dpv1Pdu::Idle(Vec::new())))
            }
            Ms2Step::Abort { connection, subnet, reason, .. } => {
                let pdu = Dpv1Pdu::Abort { subnet: *subnet, reason: *reason, more: Vec::new() };
                of(connection.point(), Some(pdu))
            }
        }
    }

    /// Processes an answer of the data link; returns the result at the end.
    pub fn answered(&mut self, now: Time, answer: DataLinkAnswer) -> Option<Ms2Result> {
        let pace = self.pace;
        match &mut self.step {
            Ms2Step::Manager { to, parameters, poll } => {
                let pdu = match polled(now, pace, poll, answer) {
                    Polled::Waiting => return None,
                    Polled::Failed(error) => return Some(closed(Ms2Outcome::Failed(error))),
                    Polled::Pdu(pdu) => pdu,
                };
                match pdu {
                    Dpv1Pdu::ResourceManager { sap, send_timeout } => {
                        let send_timeout = SEND_TIMEOUT_UNIT * u32::from(send_timeout.max(parameters.send_timeout));
                        let connection = Class2Connection { to: *to, sap, send_timeout };
                        let mut poll = PollState::new(now, connection.pace(pace).patience);
                        poll.is_requested = true;
                        self.step = Ms2Step::Opening { connection, poll };
                        None
                    }
                    other => Some(closed(ended(other))),
                }
            }
            Ms2Step::Opening { connection, poll } => match polled(now, pace, poll, answer) {
                Polled::Waiting => None,
                Polled::Failed(error) => self.give_up(now, error),
                Polled::Pdu(Dpv1Pdu::InitiateResponse { most_data, abilities }) => {
                    let Class2Connection { sap, send_timeout, .. } = *connection;
                    let opened = Ms2Opened { sap, send_timeout, most_data, abilities };
                    Some(Ms2Result { connection: Some(*connection), outcome: Ms2Outcome::Opened(opened) })
                }
                Polled::Pdu(other) => Some(closed(ended(other))),
            },
            Ms2Step::Record { connection, job } => {
                let connection = *connection;
                match job.answered(now, answer)? {
                    DpRecordOutcome::Failed(error) => self.give_up(now, error),
                    DpRecordOutcome::Aborted(end) => Some(closed(Ms2Outcome::Record(DpRecordOutcome::Aborted(end)))),
                    outcome => Some(Ms2Result { connection: Some(connection), outcome: Ms2Outcome::Record(outcome) }),
                }
            }
            Ms2Step::Idle { connection, poll } => match polled(now, pace, poll, answer) {
                Polled::Waiting => None,
                Polled::Failed(error) => self.give_up(now, error),
                Polled::Pdu(Dpv1Pdu::Idle(_)) => {
                    Some(Ms2Result { connection: Some(*connection), outcome: Ms2Outcome::Kept })
                }
                Polled::Pdu(other) => Some(closed(ended(other))),
            },
            Ms2Step::Abort { after, .. } => Some(closed(after.take().unwrap_or(Ms2Outcome::Aborted(answer)))),
        }
    }

    /// Ends the connection after a failure: after a timeout the master sends Abort.
    fn give_up(&mut self, now: Time, error: AcyclicError) -> Option<Ms2Result> {
        let (connection, is_record) = match &self.step {
            Ms2Step::Record { connection, .. } => (*connection, true),
            Ms2Step::Opening { connection, .. } | Ms2Step::Idle { connection, .. } => (*connection, false),
            Ms2Step::Manager { .. } | Ms2Step::Abort { .. } => return Some(closed(Ms2Outcome::Failed(error))),
        };
        let is_timeout = matches!(error, AcyclicError::Timeout(_));
        let outcome = match is_record {
            true => Ms2Outcome::Record(DpRecordOutcome::Failed(error)),
            false => Ms2Outcome::Failed(error),
        };
        if !is_timeout {
            return Some(closed(outcome));
        }
        let (subnet, reason) = (Subnet::NO, Dpv1AbortReason::TIMEOUT);
        self.step = Ms2Step::Abort { connection, subnet, reason, after: Some(outcome), since: now };
        None
    }
}

fn closed(outcome: Ms2Outcome) -> Ms2Result {
    Ms2Result { connection: None, outcome }
}

/// The outcome of a PDU that ends a request in another way.
fn ended(pdu: Dpv1Pdu) -> Ms2Outcome {
    match pdu {
        Dpv1Pdu::Refused(refusal) if refusal.function == Dpv1Function::INITIATE_REFUSED => Ms2Outcome::Refused(refusal),
        Dpv1Pdu::Abort { subnet, reason, .. } => Ms2Outcome::Ended(Ms2End { subnet, reason }),
        other => Ms2Outcome::Failed(AcyclicError::Unfit(format!("function {:#04x}", other.function().0))),
    }
}

/// What an answer of the data link to a request or a poll means.
enum Polled {
    Waiting,
    Failed(AcyclicError),
    Pdu(Dpv1Pdu),
}

fn polled(now: Time, pace: AcyclicTiming, poll: &mut PollState, answer: DataLinkAnswer) -> Polled {
    poll.is_requested = true;
    match answer.data() {
        None => Polled::Failed(AcyclicError::Link(answer)),
        Some([]) if now >= poll.until => Polled::Failed(AcyclicError::Timeout(poll.patience)),
        Some([]) => {
            poll.next = now + pace.poll;
            Polled::Waiting
        }
        Some(data) => match Dpv1Pdu::parse(data, PduDirection::Response) {
            Ok(pdu) => Polled::Pdu(pdu),
            Err(error) => Polled::Failed(AcyclicError::Unfit(error.to_string())),
        },
    }
}
