//! DP-V1 records and acknowledgements of alarms: MS1 for the class 1 master, MS2 connections for class 2 masters.
//!
//! A request is acknowledged, and the master fetches the answer with an empty poll once it is available. This module
//! must not know the content of records.

use super::application::{AcknowledgedAlarm, Dpv1Access, Dpv1Channel, Dpv1RecordRefusal, SlaveIdentity};
use super::link::ServiceAnswer;
use super::slave::SlaveEnv;
use alloc::vec::Vec;
use core::time::Duration;
use station::Time;
use wire::profibus::dpv1::{
    self, Dpv1AbortReason, Dpv1Function, Dpv1Pdu, Dpv1Record, Endpoint, InitiateFeatures, PduDirection, RecordError,
    Subnet,
};
use wire::profibus::fdl::AnswerFunction;
use wire::profibus::sap::SlaveSap;

/// Longest record in bytes.
const MOST_DATA: u8 = 240;
/// Shortest Send_Timeout of the slave, in units of 10 ms.
const LEAST_TIMEOUT: u16 = 10;
/// Unit of Send_Timeout: 10 ms (IEC 61158-6-3).
const SEND_TIMEOUT_UNIT: Duration = Duration::from_millis(10);
/// Time that the slave needs to process a record; invented.
pub(super) const RECORD_TIME: Duration = Duration::from_millis(2);

/// A request to a service access point of class 2 masters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ms2Request<'a> {
    pub sap: u8,
    pub master: u8,
    pub data: &'a [u8],
    /// The time that a record takes.
    pub takes: Duration,
}

/// The answer that waits to be fetched from a service access point.
#[derive(Clone, Debug, Default)]
struct SapResponse {
    /// When the answer is available, and its bytes.
    answer: Option<(Time, Vec<u8>)>,
}

impl SapResponse {
    /// The answer to an empty poll.
    fn poll(&mut self, now: Time) -> ServiceAnswer {
        match self.answer.take_if(|(due, _)| *due <= now) {
            Some((_, octets)) => ServiceAnswer::data(octets),
            None => ServiceAnswer::Taken,
        }
    }

    fn put(&mut self, due: Time, pdu: &Dpv1Pdu) {
        let mut octets = Vec::new();
        pdu.write(&mut octets);
        self.answer = Some((due, octets));
    }
}

/// A connection of a class 2 master.
#[derive(Clone, Debug)]
struct Ms2Connection {
    sap: u8,
    master: u8,
    timeout: Duration,
    until: Time,
    response: SapResponse,
}

/// The answers that wait to be fetched, and the MS2 connections.
#[derive(Clone, Debug, Default)]
pub(super) struct Dpv1Records {
    ms1: SapResponse,
    /// Of the access point that only acknowledges alarms.
    alarms: SapResponse,
    /// The master that waits for the resource manager, and the answer for it.
    manager: Option<(u8, SapResponse)>,
    connections: Vec<Ms2Connection>,
}

impl Dpv1Records {
    /// A request or a poll of the class 1 master.
    pub fn serve_ms1(&mut self, env: &mut SlaveEnv<'_>, data: &[u8], takes: Duration) -> ServiceAnswer {
        serve(&mut self.ms1, env, data, takes)
    }

    /// An acknowledgement or a poll at the access point that only acknowledges alarms.
    pub fn serve_alarms(&mut self, env: &mut SlaveEnv<'_>, data: &[u8], takes: Duration) -> ServiceAnswer {
        if data.first().is_some_and(|function| *function != Dpv1Function::ALARM_ACK.0) {
            return ServiceAnswer::NO_SERVICE;
        }
        serve(&mut self.alarms, env, data, takes)
    }

    /// MS1 has ended.
    pub fn end_ms1(&mut self, env: &mut SlaveEnv<'_>) {
        (self.ms1, self.alarms) = Default::default();
        env.application.forget(env.application_time(), Dpv1Channel::Ms1);
    }

    /// A request or a poll of a class 2 master.
    pub fn serve_ms2(
        &mut self,
        env: &mut SlaveEnv<'_>,
        request: Ms2Request<'_>,
        identity: &SlaveIdentity,
    ) -> ServiceAnswer {
        if identity.ms2 == 0 {
            return ServiceAnswer::NO_SERVICE;
        }
        if SlaveSap(request.sap) == SlaveSap::RESOURCE_MANAGER {
            return self.serve_resource_manager(env, request, identity);
        }
        let position = self.connections.iter_mut().position(|of| (of.sap, of.master) == (request.sap, request.master));
        let Some(at) = position else { return ServiceAnswer::NO_SERVICE };
        let Some(connection) = self.connections.get_mut(at) else { return ServiceAnswer::NO_SERVICE };
        connection.until = env.now + connection.timeout;
        if request.data.is_empty() {
            return connection.response.poll(env.now);
        }
        if connection.response.answer.is_some() {
            return ServiceAnswer::Code(AnswerFunction::NO_RESOURCE);
        }
        let due = env.now + request.takes;
        match Dpv1Pdu::parse(request.data, PduDirection::Request) {
            Ok(Dpv1Pdu::Abort { .. }) => self.end(env, at),
            Ok(Dpv1Pdu::Idle(_)) => connection.response.put(env.now, &Dpv1Pdu::Idle(Vec::new())),
            _ => {
                let answer = answer(env, Dpv1Channel::Ms2(request.sap), request.data);
                connection.response.put(due, &answer);
            }
        }
        ServiceAnswer::Taken
    }

    fn serve_resource_manager(
        &mut self,
        env: &mut SlaveEnv<'_>,
        request: Ms2Request<'_>,
        identity: &SlaveIdentity,
    ) -> ServiceAnswer {
        if request.data.is_empty() {
            return match &mut self.manager {
                Some((master, response)) if *master == request.master => {
                    let answer = response.poll(env.now);
                    if response.answer.is_none() {
                        self.manager = None;
                    }
                    answer
                }
                Some(_) | None => ServiceAnswer::Taken,
            };
        }
        let Ok(Dpv1Pdu::InitiateRequest { send_timeout, abilities, .. }) =
            Dpv1Pdu::parse(request.data, PduDirection::Request)
        else {
            return ServiceAnswer::NO_SERVICE;
        };
        let free = (0..identity.ms2 as u8).find(|sap| self.connections.iter().all(|of| of.sap != *sap));
        let Some(sap) = free else { return ServiceAnswer::Code(AnswerFunction::NO_RESOURCE) };
        let send_timeout = send_timeout.max(LEAST_TIMEOUT);
        let timeout = SEND_TIMEOUT_UNIT * u32::from(send_timeout) * 2;
        let mut response = SapResponse::default();
        let swap = |abilities: InitiateFeatures| {
            let supported = identity.abilities.clone().unwrap_or(InitiateFeatures {
                features: [1, 0],
                profile_features: [0, 0],
                profile: 0,
                source: Endpoint::default(),
                destination: Endpoint::default(),
            });
            InitiateFeatures { source: abilities.destination, destination: abilities.source, ..supported }
        };
        response.put(
            env.now + request.takes,
            &Dpv1Pdu::InitiateResponse { most_data: MOST_DATA, abilities: swap(abilities) },
        );
        self.connections.push(Ms2Connection {
            sap,
            master: request.master,
            timeout,
            until: env.now + timeout,
            response,
        });
        let mut response = SapResponse::default();
        response.put(env.now, &Dpv1Pdu::ResourceManager { sap, send_timeout });
        self.manager = Some((request.master, response));
        ServiceAnswer::Taken
    }

    fn end(&mut self, env: &mut SlaveEnv<'_>, at: usize) {
        let connection = self.connections.remove(at);
        env.application.forget(env.application_time(), Dpv1Channel::Ms2(connection.sap));
    }

    /// Ends MS2 connections whose timeout has expired.
    pub fn wake(&mut self, env: &mut SlaveEnv<'_>) {
        while let Some(at) = self.connections.iter().position(|of| of.until <= env.now) {
            self.end(env, at);
        }
    }

    /// When the next MS2 connection times out.
    pub fn due(&self) -> Option<Time> {
        self.connections.iter().map(|of| of.until).min()
    }
}

/// Serves a request or a poll of the class 1 master at an access point with one pending response.
fn serve(response: &mut SapResponse, env: &mut SlaveEnv<'_>, data: &[u8], takes: Duration) -> ServiceAnswer {
    if data.is_empty() {
        return response.poll(env.now);
    }
    if response.answer.is_some() {
        return ServiceAnswer::Code(AnswerFunction::NO_RESOURCE);
    }
    let due = env.now + takes;
    response.put(due, &answer(env, Dpv1Channel::Ms1, data));
    ServiceAnswer::Taken
}

/// The answer to a record request, or to an acknowledgement of an alarm.
fn answer(env: &mut SlaveEnv<'_>, channel: Dpv1Channel, data: &[u8]) -> Dpv1Pdu {
    let at = env.application_time();
    let access = |record: &Dpv1Record| Dpv1Access { channel, slot: record.slot, index: record.index };
    match Dpv1Pdu::parse(data, PduDirection::Request) {
        Ok(Dpv1Pdu::Read(record)) => {
            let mut octets = Vec::new();
            match env.application.read(at, access(&record), &mut octets) {
                Ok(()) => {
                    octets.truncate(record.length.min(MOST_DATA).into());
                    Dpv1Pdu::Read(Dpv1Record { length: octets.len() as u8, data: octets, ..record })
                }
                Err(refusal) => refused(Dpv1Function::READ_REFUSED, refusal),
            }
        }
        Ok(Dpv1Pdu::Write(record)) => match env.application.write(at, access(&record), &record.data) {
            Ok(()) => Dpv1Pdu::Write(Dpv1Record { data: Vec::new(), ..record }),
            Err(refusal) => refused(Dpv1Function::WRITE_REFUSED, refusal),
        },
        Ok(Dpv1Pdu::AlarmAck { slot, alarm_type, specifier }) if channel == Dpv1Channel::Ms1 => {
            let alarm = AcknowledgedAlarm { slot, alarm_type, specifier };
            match env.application.acknowledge_alarm(at, alarm) {
                Ok(()) => Dpv1Pdu::AlarmAck { slot, alarm_type, specifier },
                Err(refusal) => refused(Dpv1Function::ALARM_ACK_REFUSED, refusal),
            }
        }
        Ok(pdu) => {
            refused(Dpv1Function(pdu.function().0 | 0x80), Dpv1RecordRefusal::error(RecordError::FEATURE_NOT_SUPPORTED))
        }
        Err(_) if matches!(channel, Dpv1Channel::Ms2(_)) => {
            let more = Vec::new();
            Dpv1Pdu::Abort { subnet: Subnet::NO, reason: Dpv1AbortReason::BAD_REQUEST, more }
        }
        Err(_) => {
            let function = Dpv1Function(data.first().copied().unwrap_or_default() | 0x80);
            refused(function, Dpv1RecordRefusal::error(RecordError::WRITE_LENGTH_ERROR))
        }
    }
}

fn refused(function: Dpv1Function, refusal: Dpv1RecordRefusal) -> Dpv1Pdu {
    let Dpv1RecordRefusal { decode, code_1, code_2 } = refusal;
    Dpv1Pdu::Refused(dpv1::Dpv1Refusal { function, decode, code_1, code_2 })
}
