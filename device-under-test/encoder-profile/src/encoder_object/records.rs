//! The records of the encoder object: user parameters (XAC77 manual, 11.4) and parameter access (11.2 and 11.3).

use super::modules::{ACCESS_POINT_SUBSLOT, ENCODER_API, ENCODER_SLOT};
use super::{ConnectionPhase, EncoderModel, EncoderObject, PoweredEncoder};
use crate::facts::LateRecordEffect;
use crate::profidrive::checks::EncoderCheck;
use crate::profidrive::parameters::{BadRequest, ParameterManager};
use crate::profidrive::user_parameters::UserParameterData;
use alloc::borrow::Cow;
use alloc::vec::Vec;
use device_stack::profinet::{ArKey, RecordAccess, RecordRefusal};
use station::Time;

/// Index of the user parameter record.
const USER_PARAMETERS: u16 = 0xBF00;

impl<M: EncoderModel> PoweredEncoder<'_, M> {
    /// Whether the access addresses the parameter access point, which has the records of the encoder object.
    pub fn is_at_access_point(&self, access: &RecordAccess) -> bool {
        let RecordAccess { api, slot, subslot, .. } = *access;
        let is_access_point = (api, slot, subslot) == (ENCODER_API, ENCODER_SLOT, ACCESS_POINT_SUBSLOT);
        self.deviations.checks.check(EncoderCheck::RecordAnswersAt(api, slot, subslot), is_access_point)
    }

    fn is_parameter_access(&self, index: u16) -> bool {
        self.deviations.checks.check(EncoderCheck::IsParameterAccess(index), index == self.facts.parameter_access)
    }
}

impl<M: EncoderModel> EncoderObject<M> {
    /// Writes a record.
    pub(super) fn write(&mut self, now: Time, access: RecordAccess, data: &[u8]) -> Result<(), RecordRefusal> {
        let hooks = self.deviations.hooks.clone();
        let data = hooks.apply(Ok(Cow::Borrowed(data)), |hooks, data| {
            let data = data.map(Cow::into_owned);
            hooks.write_record(&self.live(now).view(), &access, data).map(Cow::Owned)
        });
        self.take_record(now, access, &data?)
    }

    fn take_record(&mut self, now: Time, access: RecordAccess, data: &[u8]) -> Result<(), RecordRefusal> {
        if let Some(written) = M::write_record(&mut self.live(now), access, data) {
            return written;
        }
        self.access(now, access)?;
        match access.index {
            USER_PARAMETERS => self.write_user_parameters(now, access, data),
            index if self.live(now).is_parameter_access(index) => self.request_parameters(now, access, data),
            _ => Err(RecordRefusal::InvalidIndex),
        }
    }

    /// Reads a record.
    pub(super) fn read(&mut self, now: Time, access: RecordAccess, out: &mut Vec<u8>) -> Result<(), RecordRefusal> {
        let mut octets = Vec::new();
        let read = self.give_record(now, access, &mut octets).map(|()| octets);
        let hooks = self.deviations.hooks.clone();
        out.extend(hooks.apply(read, |hooks, read| hooks.read_record(&self.live(now).view(), &access, read))?);
        Ok(())
    }

    fn give_record(&mut self, now: Time, access: RecordAccess, out: &mut Vec<u8>) -> Result<(), RecordRefusal> {
        if let Some(read) = M::read_record(&mut self.live(now), access, out) {
            return read;
        }
        self.access(now, access)?;
        match access.index {
            USER_PARAMETERS => Err(RecordRefusal::AccessDenied),
            index if self.live(now).is_parameter_access(index) => {
                let key = access.ar.ok_or(RecordRefusal::StateConflict)?;
                let waiting = self.responses.fetch(key);
                let response =
                    self.deviations.hooks.apply(waiting, |hooks, waiting| hooks.fetched_response(key, waiting));
                out.extend(response.ok_or(RecordRefusal::StateConflict)?);
                Ok(())
            }
            _ => Err(RecordRefusal::InvalidIndex),
        }
    }

    fn access(&mut self, now: Time, access: RecordAccess) -> Result<(), RecordRefusal> {
        let live = self.live(now);
        let is_served = live.is_at_access_point(&access) && M::serves(&live, access.index);
        if is_served { Ok(()) } else { Err(RecordRefusal::InvalidIndex) }
    }

    /// Processes a user parameter record. During start-up it takes effect at PrmEnd; during data exchange it takes
    /// effect at once, if the manual allows it.
    fn write_user_parameters(&mut self, now: Time, access: RecordAccess, data: &[u8]) -> Result<(), RecordRefusal> {
        let user = UserParameterData::parse(data).ok_or(RecordRefusal::WriteLength)?;
        let is_of = |phase: fn(ArKey) -> ConnectionPhase| access.ar.is_some_and(|ar| self.ram.phase == phase(ar));
        let may_be_late = self.facts.record_in_exchange == LateRecordEffect::InForce;
        let in_exchange =
            is_of(ConnectionPhase::Data) && self.deviations.checks.check(EncoderCheck::RecordInExchange, may_be_late);
        if !is_of(ConnectionPhase::Parameters) && !in_exchange {
            return Err(RecordRefusal::StateConflict);
        }
        (self.ram.staged, self.ram.has_record) = (user, true);
        if self.deviations.checks.check(EncoderCheck::RecordActsAtOnce, in_exchange) {
            let mut live = self.live(now);
            live.parametrize();
            live.update_errors();
        }
        Ok(())
    }

    fn request_parameters(&mut self, now: Time, access: RecordAccess, data: &[u8]) -> Result<(), RecordRefusal> {
        let key = access.ar.ok_or(RecordRefusal::StateConflict)?;
        let hooks = self.deviations.hooks.clone();
        let request = hooks.apply(data.to_vec(), |hooks, octets| hooks.parameter_request(key, octets));
        let manager =
            ParameterManager { serves_any_axis: self.facts.serves_any_axis, checks: self.deviations.checks.clone() };
        let exchange = manager.answer(&request, &mut self.live(now)).map_err(|bad| match bad {
            BadRequest::TooShort => RecordRefusal::WriteLength,
            BadRequest::Count => RecordRefusal::InvalidRange,
        })?;
        let response = hooks.apply(exchange.octets(), |hooks, octets| hooks.parameter_response(&exchange, octets));
        self.responses.keep(key, response);
        Ok(())
    }
}
