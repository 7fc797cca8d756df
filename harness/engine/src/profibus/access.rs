//! Reading and writing a slave: diagnosis, configuration, station address, and parameters by data set 47.

use super::{failed, reply, unexpected};
use crate::trial::Run;
use crate::trial::access::Answered;
use crate::trial::trouble::Trouble;
use controllers::profibus_dp::{Outcome, ParameterOutcome, RecordOutcome, Request};
use expression::Value;
use judge::answer::{Refusal, Reply};
use judge::diagnosis;
use suite::device::{NameKind, ParameterAccess};
use suite::model::{Access, AnswerPart, Instead};
use wire::profibus::dpv1::Refusal as Dpv1Refusal;

/// The station addresses of slaves.
const STATIONS: std::ops::RangeInclusive<u8> = 0..=126;
/// The longest data of a parameter response, in bytes.
const LONGEST: u8 = 240;

impl<'a> Run<'a> {
    /// Reads the diagnosis.
    pub(super) fn diagnosis(&mut self, access: &'a Access) -> Result<Answered, Trouble> {
        let to = self.station_of(access.to.as_ref())?;
        let answer = self.diagnose(access.second, to)?;
        let mut answered = Answered::whole(reply(&answer), access.items.len());
        let Some(octets) = answer.data().filter(|_| answer.diagnosis().is_some()) else {
            if answer.is_positive() {
                let why = format!("the answer of Slave_Diag is no diagnosis: {answer}");
                return Ok(Answered::whole(Reply::Wrong(why), access.items.len()));
            }
            return Ok(answered);
        };
        let own = self.place.line.masters[usize::from(access.second)];
        let device = &self.world.manual.device;
        answered.values = access
            .items
            .iter()
            .map(|item| match self.kind(item.name) {
                Some(NameKind::Diagnosis(name)) => diagnosis::value(device, *name, octets, Some(own)),
                _ => Value::Unknown,
            })
            .collect();
        answered.replies.push((AnswerPart::Bytes, Reply::Value(Value::bytes(octets))));
        Ok(answered)
    }

    /// Reads the configuration.
    pub(super) fn configuration(&mut self, access: &'a Access) -> Result<Answered, Trouble> {
        let to = self.station_of(access.to.as_ref())?;
        let answer = self.ask_link(access.second, Request::Configuration { to })?;
        let mut answered = Answered::whole(reply(&answer), access.items.len());
        if let Some(octets) = answer.data() {
            answered.values = vec![Value::bytes(octets); access.items.len()];
            answered.replies.push((AnswerPart::Bytes, Reply::Value(Value::bytes(octets))));
        }
        Ok(answered)
    }

    /// Finds the address of the slave with the right ident number by asking every address.
    pub(super) fn station_address(&mut self, access: &'a Access) -> Result<Answered, Trouble> {
        let expected = self.ident();
        let masters = self.place.line.masters;
        let mut found = Vec::new();
        for address in STATIONS.filter(|address| !masters.contains(address)) {
            let there = self.ask_link(access.second, Request::FdlStatus { to: address })?;
            if there.is_none() {
                continue;
            }
            if self.diagnose(access.second, address)?.diagnosis().is_some_and(|diagnosis| diagnosis.ident == expected) {
                found.push(address);
                self.slave.meet(address);
            }
        }
        Ok(match found.as_slice() {
            [address] => Answered {
                replies: vec![(AnswerPart::Whole, Reply::Accepted)],
                values: vec![Value::whole(*address); access.items.len()],
            },
            [] => Answered::whole(Reply::Silent("no slave with this ident number answers".into()), access.items.len()),
            several => {
                let addresses = several.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
                let why = format!("slaves with this ident number answer at several addresses: {addresses}");
                Answered::whole(Reply::Wrong(why), access.items.len())
            }
        })
    }

    /// Sends a parameter request by its data set; returns the response, or why there is none.
    pub(super) fn data_set(&mut self, access: &'a Access, request: Vec<u8>) -> Result<Result<Vec<u8>, Reply>, Trouble> {
        let to = self.station_of(access.to.as_ref())?;
        let (mut slot, mut index) = (self.parameter_slot(), None);
        for instead in &access.instead {
            match instead {
                Instead::Slot(other) => slot = u8::try_from(*other).unwrap_or(u8::MAX),
                Instead::Index(other) => index = Some(u8::try_from(*other).unwrap_or(u8::MAX)),
                _ => {}
            }
        }
        if let Some(index) = index.filter(|index| u16::from(*index) != ParameterAccess::DATA_SET) {
            return self.other_data_set(access.second, (to, slot, index), request);
        }
        let outcome = self.ask_master(access.second, Request::Parameter { to, slot, request })?;
        let Outcome::Parameter(outcome) = outcome else { return Err(unexpected(&outcome)) };
        Ok(Err(match outcome {
            ParameterOutcome::Answer(octets) => return Ok(Ok(octets)),
            ParameterOutcome::OtherReference { sent, answer } => {
                let observed = answer.first().copied().unwrap_or_default();
                Reply::Wrong(format!("the answer carries reference {observed}, the request had {sent}"))
            }
            ParameterOutcome::WriteRefused(refusal) | ParameterOutcome::ReadRefused(refusal) => refused(&refusal),
            ParameterOutcome::NotReady(_, time) => Reply::Silent(format!("no answer was ready within {time:?}")),
            ParameterOutcome::Failed(error) => failed(&error),
        }))
    }

    /// The same by another data set.
    fn other_data_set(
        &mut self,
        second: bool,
        (to, slot, index): (u8, u8, u8),
        data: Vec<u8>,
    ) -> Result<Result<Vec<u8>, Reply>, Trouble> {
        for request in [Request::Write { to, slot, index, data }, Request::Read { to, slot, index, length: LONGEST }] {
            let is_read = matches!(request, Request::Read { .. });
            let outcome = self.ask_master(second, request)?;
            let Outcome::Record(outcome) = outcome else { return Err(unexpected(&outcome)) };
            match record(&outcome) {
                Reply::Accepted => {}
                reply => return Ok(Err(reply)),
            }
            if let (RecordOutcome::Accepted { data }, true) = (outcome, is_read) {
                return Ok(Ok(data));
            }
        }
        Ok(Err(Reply::Silent("no response".into())))
    }
}

/// The result of an access to a record.
pub fn record(outcome: &RecordOutcome) -> Reply {
    match outcome {
        RecordOutcome::Accepted { .. } => Reply::Accepted,
        RecordOutcome::Refused(refusal) => refused(refusal),
        RecordOutcome::Failed(error) => failed(error),
    }
}

fn refused(refusal: &Dpv1Refusal) -> Reply {
    let Dpv1Refusal { decode, code_1, code_2, .. } = *refusal;
    Reply::Refused(Refusal::Dpv1 { decode: decode.0, code1: code_1, code2: code_2 })
}
