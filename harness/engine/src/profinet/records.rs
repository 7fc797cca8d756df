//! Records: the request for a `read` or `write` of a record or of parameters, and the meaning of its answer.

use super::{startup, unexpected};
use crate::record::put;
use crate::trial::RunningTrial;
use crate::trial::access::AccessAnswer;
use crate::trial::step_error::{BoxedStepError, StepError};
use controllers::profinet_io::{
    ControllerOutcome, ControllerRequest, IoParameterOutcome, IoRecordOutcome, Partner, RecordAddress,
};
use expression::Value;
use judge::answer::ReceivedReply;
use judge::image::field_number;
use results::outcome::FailureCause;
use results::verdict::Verdict;
use suite::device::{NameKind, RecordField};
use suite::model::{AcyclicAccess, AnswerPart, RequestDeviation};
use wire::profinet::rpc::ObjectUuid;
use wire::profinet::status::ErrorCode;

/// Record length in a read request, in bytes: longer than any record.
const READ_LENGTH: u32 = 4096;

impl<'a> RunningTrial<'a> {
    /// Sends a parameter request by its record; returns the response, or why there is none.
    pub(super) fn parameter_record(
        &mut self,
        access: &'a AcyclicAccess,
        octets: Vec<u8>,
    ) -> Result<Result<Vec<u8>, ReceivedReply>, BoxedStepError> {
        let mut at = match self.parameter_access_point() {
            Some(at) => at,
            None => {
                return Err(StepError::other(
                    FailureCause::Suite,
                    Verdict::Error,
                    "The module has no parameter access point.",
                ));
            }
        };
        redirect(&mut at, &access.instead);
        let outcome = self.ask_in_connection(access.second, ControllerRequest::Parameter { at, request: octets })?;
        let ControllerOutcome::Parameter(outcome) = outcome else { return Err(unexpected(&outcome)) };
        Ok(Err(match outcome {
            IoParameterOutcome::Answer(octets) => return Ok(Ok(octets)),
            IoParameterOutcome::OtherReference { sent, answer } => {
                let observed = answer.first().copied().unwrap_or_default();
                ReceivedReply::Wrong(format!("the answer carries reference {observed}, the request had {sent}"))
            }
            IoParameterOutcome::WriteRefused(status) => startup::refused(&status, ErrorCode::WRITE_RESPONSE),
            IoParameterOutcome::ReadRefused(status) => startup::refused(&status, ErrorCode::READ_RESPONSE),
            IoParameterOutcome::NotReady(status, wait) => ReceivedReply::Silent(format!("{wait}; last {status}")),
            IoParameterOutcome::Failed(error) => startup::failed(&error),
        }))
    }

    /// The target of base mode parameter access: the submodule of `device.yaml`, else the submodule of the present module that receives
    /// the start-up records.
    pub(super) fn parameter_access_point(&self) -> Option<RecordAddress> {
        let device = &self.world.manual.device;
        let module = self.module.and_then(|module| device.modules.get(module));
        let access = device.parameter_access;
        let inside = |index: &usize| module.is_none_or(|module| module.submodules.contains(index));
        let index = device.parameter_points().find(inside).or_else(|| device.parameter_points().next())?;
        let at = device.submodules.get(index)?;
        Some(RecordAddress { api: at.api, slot: at.slot, subslot: at.subslot, index: access.index })
    }

    /// Reads or writes a record, in the connection or without one.
    pub(super) fn record(
        &mut self,
        access: &'a AcyclicAccess,
        record: usize,
        write: bool,
    ) -> Result<AccessAnswer, BoxedStepError> {
        let device = &self.world.manual.device;
        let of = &device.records[record];
        let at = &device.submodules[of.at];
        let mut target = RecordAddress { api: at.api, slot: at.slot, subslot: at.subslot, index: of.index };
        let mut data = of.bytes();
        if write {
            let variant = self.variant_number();
            for (index, field) in of.fields.iter().enumerate() {
                let default = field.default.get(variant).or(field.default.first());
                put(of, index, default.copied().unwrap_or_default(), &mut data);
            }
            for item in &access.items {
                let value = self.written(&item.value)?;
                match (self.kind(item.name), value) {
                    (Some(NameKind::Record { field: None, .. }), Value::Bytes(octets)) => data = octets.to_vec(),
                    (Some(NameKind::Record { field: Some(field), .. }), value) => {
                        put(of, *field, value.as_whole().unwrap_or_default(), &mut data);
                    }
                    _ => {}
                }
            }
        }
        let mut length = READ_LENGTH;
        redirect(&mut target, &access.instead);
        for instead in &access.instead {
            match instead {
                RequestDeviation::Index(index) => target.index = *index,
                RequestDeviation::Length(octets) => {
                    data.resize(*octets, 0);
                    length = u32::try_from(*octets).unwrap_or(READ_LENGTH);
                }
                RequestDeviation::Bytes(octets) => data.clone_from(octets),
                _ => {}
            }
        }
        let request = if write {
            ControllerRequest::Write { target, data }
        } else {
            self.record_read(access.second, target, length)
        };
        let outcome = self.ask_in_connection(access.second, request)?;
        let ControllerOutcome::Record(outcome) = outcome else { return Err(unexpected(&outcome)) };
        let reply = startup::record(&outcome, write);
        let mut answered = AccessAnswer::whole(reply.clone(), access.items.len());
        answered.replies.push((AnswerPart::Record(record), reply));
        if let (IoRecordOutcome::Accepted { data }, false) = (&outcome, write) {
            answered.replies.push((AnswerPart::Bytes, ReceivedReply::Value(Value::bytes(data.as_slice()))));
            answered.values = access
                .items
                .iter()
                .map(|item| match self.kind(item.name) {
                    Some(NameKind::Record { field: Some(field), .. }) => {
                        of.fields.get(*field).map_or(Value::Unknown, |field| field_value(field, data))
                    }
                    Some(NameKind::Record { field: None, .. }) => Value::bytes(data.as_slice()),
                    _ => Value::Unknown,
                })
                .collect();
        }
        Ok(answered)
    }

    /// The request to read a record; the second controller reads without a connection if it has none.
    pub(super) fn record_read(&self, second: bool, target: RecordAddress, length: u32) -> ControllerRequest {
        if !second || self.world.stations.is_connected(1) {
            return ControllerRequest::Read { target, length };
        }
        self.implicit_read(target, length)
    }

    /// The request to read a record without a connection.
    pub(super) fn implicit_read(&self, target: RecordAddress, length: u32) -> ControllerRequest {
        let (partner, object) = self.callee();
        ControllerRequest::ReadImplicit { partner, object, target, length }
    }

    /// The device as it is called outside a connection, and its object.
    pub(super) fn callee(&self) -> (Partner, ObjectUuid) {
        let (vendor_id, device_id) = self.world.manual.device.ids().unwrap_or_default();
        let object = ObjectUuid { instance: 1, device_id, vendor_id };
        let partner = self.world.stations.controller(0).and_then(|controller| controller.partner());
        let address = partner.map_or(self.station_ip.address, |partner| partner.ip);
        (Partner { mac: self.mac, ip: address }, object)
    }
}

/// Replaces slot, subslot and API of a target by those of `instead`.
fn redirect(target: &mut RecordAddress, instead: &[RequestDeviation]) {
    for instead in instead {
        match instead {
            RequestDeviation::Slot(slot) => target.slot = *slot,
            RequestDeviation::Subslot(subslot) => target.subslot = *subslot,
            RequestDeviation::Api(api) => target.api = *api,
            _ => {}
        }
    }
}

/// The value of a field of a record.
fn field_value(field: &RecordField, data: &[u8]) -> Value {
    if field.text {
        let Some(octets) = data.get(field.octet..field.octet + field.octets) else { return Value::Unknown };
        return Value::text(String::from_utf8_lossy(octets).trim_end().to_owned());
    }
    match field_number(field, data) {
        Some(number) if !field.words.is_empty() => i64::try_from(number).map_or(Value::Unknown, Value::Word),
        Some(number) if field.bits.is_some_and(|(_, width)| width == 1) => Value::Bit(number != 0),
        Some(number) => Value::whole(number),
        None => Value::Unknown,
    }
}
