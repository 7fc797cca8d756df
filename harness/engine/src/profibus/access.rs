//! Reading and writing a slave: diagnosis, configuration, station address, and parameters by data set 47.

use super::{failed, reply, unexpected};
use crate::trial::RunningTrial;
use crate::trial::access::AccessAnswer;
use crate::trial::step_error::BoxedStepError;
use controllers::profibus_dp::{DpParameterOutcome, DpRecordOutcome, MasterOutcome, MasterRequest};
use expression::Value;
use judge::answer::{NegativeResponse, ReceivedReply};
use judge::diagnosis;
use suite::device::{NameKind, ParameterAccess};
use suite::model::{AcyclicAccess, AnswerPart, RequestDeviation};
use wire::profibus::dpv1::Dpv1Refusal;

/// The station addresses of slaves.
const STATIONS: std::ops::RangeInclusive<u8> = 0..=126;
/// The longest data of a parameter response, in bytes.
const LONGEST: u8 = 240;

impl<'a> RunningTrial<'a> {
    /// Reads the diagnosis.
    pub(super) fn diagnosis(&mut self, access: &'a AcyclicAccess) -> Result<AccessAnswer, BoxedStepError> {
        let to = self.station_of(access.to.as_ref())?;
        let answer = self.diagnose(access.second, to)?;
        let mut answered = AccessAnswer::whole(reply(&answer), access.items.len());
        let Some(octets) = answer.data().filter(|_| answer.diagnosis().is_some()) else {
            if answer.is_positive() {
                let why = format!("the answer of Slave_Diag is no diagnosis: {answer}");
                return Ok(AccessAnswer::whole(ReceivedReply::Wrong(why), access.items.len()));
            }
            return Ok(answered);
        };
        let own = self.environment.line.masters[usize::from(access.second)];
        let device = &self.world.manual.device;
        answered.values = access
            .items
            .iter()
            .map(|item| match self.kind(item.name) {
                Some(NameKind::Diagnosis(name)) => diagnosis::value(device, *name, octets, Some(own)),
                _ => Value::Unknown,
            })
            .collect();
        answered.replies.push((AnswerPart::Bytes, ReceivedReply::Value(Value::bytes(octets))));
        Ok(answered)
    }

    /// Reads the configuration.
    pub(super) fn configuration(&mut self, access: &'a AcyclicAccess) -> Result<AccessAnswer, BoxedStepError> {
        let to = self.station_of(access.to.as_ref())?;
        let answer = self.ask_link(access.second, MasterRequest::Configuration { to })?;
        let mut answered = AccessAnswer::whole(reply(&answer), access.items.len());
        if let Some(octets) = answer.data() {
            answered.values = vec![Value::bytes(octets); access.items.len()];
            answered.replies.push((AnswerPart::Bytes, ReceivedReply::Value(Value::bytes(octets))));
        }
        Ok(answered)
    }

    /// Finds the address of the slave with the right ident number by asking every address.
    pub(super) fn station_address(&mut self, access: &'a AcyclicAccess) -> Result<AccessAnswer, BoxedStepError> {
        let expected = self.ident();
        let masters = self.environment.line.masters;
        let mut found = Vec::new();
        for address in STATIONS.filter(|address| !masters.contains(address)) {
            let there = self.ask_link(access.second, MasterRequest::FdlStatus { to: address })?;
            if there.is_none() {
                continue;
            }
            if self.diagnose(access.second, address)?.diagnosis().is_some_and(|diagnosis| diagnosis.ident == expected) {
                found.push(address);
                self.slave.remember(address);
            }
        }
        Ok(match found.as_slice() {
            [address] => AccessAnswer {
                replies: vec![(AnswerPart::Whole, ReceivedReply::Accepted)],
                values: vec![Value::whole(*address); access.items.len()],
            },
            [] => AccessAnswer::whole(
                ReceivedReply::Silent("no slave with this ident number answers".into()),
                access.items.len(),
            ),
            several => {
                let addresses = several.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
                let why = format!("slaves with this ident number answer at several addresses: {addresses}");
                AccessAnswer::whole(ReceivedReply::Wrong(why), access.items.len())
            }
        })
    }

    /// Sends a parameter request by its data set; returns the response, or why there is none.
    pub(super) fn data_set(
        &mut self,
        access: &'a AcyclicAccess,
        request: Vec<u8>,
    ) -> Result<Result<Vec<u8>, ReceivedReply>, BoxedStepError> {
        let to = self.station_of(access.to.as_ref())?;
        let (mut slot, mut index) = (self.parameter_slot(), None);
        for instead in &access.instead {
            match instead {
                RequestDeviation::Slot(other) => slot = u8::try_from(*other).unwrap_or(u8::MAX),
                RequestDeviation::Index(other) => index = Some(u8::try_from(*other).unwrap_or(u8::MAX)),
                _ => {}
            }
        }
        if let Some(index) = index.filter(|index| u16::from(*index) != ParameterAccess::DATA_SET) {
            return self.other_data_set(access.second, (to, slot, index), request);
        }
        let outcome = self.ask_master(access.second, MasterRequest::Parameter { to, slot, request })?;
        let MasterOutcome::Parameter(outcome) = outcome else { return Err(unexpected(&outcome)) };
        Ok(Err(match outcome {
            DpParameterOutcome::Answer(octets) => return Ok(Ok(octets)),
            DpParameterOutcome::OtherReference { sent, answer } => {
                let observed = answer.first().copied().unwrap_or_default();
                ReceivedReply::Wrong(format!("the answer carries reference {observed}, the request had {sent}"))
            }
            DpParameterOutcome::WriteRefused(refusal) | DpParameterOutcome::ReadRefused(refusal) => refused(&refusal),
            DpParameterOutcome::NotReady(_, time) => {
                ReceivedReply::Silent(format!("no answer was ready within {time:?}"))
            }
            DpParameterOutcome::Failed(error) => failed(&error),
        }))
    }

    /// The same by another data set.
    fn other_data_set(
        &mut self,
        second: bool,
        (to, slot, index): (u8, u8, u8),
        data: Vec<u8>,
    ) -> Result<Result<Vec<u8>, ReceivedReply>, BoxedStepError> {
        for request in
            [MasterRequest::Write { to, slot, index, data }, MasterRequest::Read { to, slot, index, length: LONGEST }]
        {
            let is_read = matches!(request, MasterRequest::Read { .. });
            let outcome = self.ask_master(second, request)?;
            let MasterOutcome::Record(outcome) = outcome else { return Err(unexpected(&outcome)) };
            match record(&outcome) {
                ReceivedReply::Accepted => {}
                reply => return Ok(Err(reply)),
            }
            if let (DpRecordOutcome::Accepted { data }, true) = (outcome, is_read) {
                return Ok(Ok(data));
            }
        }
        Ok(Err(ReceivedReply::Silent("no response".into())))
    }
}

/// The result of an access to a record.
pub fn record(outcome: &DpRecordOutcome) -> ReceivedReply {
    match outcome {
        DpRecordOutcome::Accepted { .. } => ReceivedReply::Accepted,
        DpRecordOutcome::Refused(refusal) => refused(refusal),
        DpRecordOutcome::Aborted(end) => ReceivedReply::Refused(NegativeResponse::Abort(end.reason.0)),
        DpRecordOutcome::Failed(error) => failed(error),
    }
}

/// A refusal with its error bytes.
pub fn refused(refusal: &Dpv1Refusal) -> ReceivedReply {
    let Dpv1Refusal { decode, code_1, code_2, .. } = *refusal;
    ReceivedReply::Refused(NegativeResponse::Dpv1 { decode: decode.0, code1: code_1, code2: code_2 })
}
