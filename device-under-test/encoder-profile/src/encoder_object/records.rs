//! The records of the encoder object: user parameters (XAC77 manual, 11.4) and parameter access (11.2 and 11.3).

use super::places::{ACCESS_POINT_SUBSLOT, ENCODER_API, ENCODER_SLOT};
use super::{EncoderObject, Live, Model, Phase};
use crate::facts::InExchange;
use crate::profidrive::checks::Check;
use crate::profidrive::parameters::{BadRequest, Manager};
use crate::profidrive::user_parameters::UserParameters;
use alloc::borrow::Cow;
use alloc::vec::Vec;
use device_stack::profinet::{Access, ArKey, RecordRefusal};
use station::Time;

/// Index of the user parameter record.
const USER_PARAMETERS: u16 = 0xBF00;

impl<M: Model> Live<'_, M> {
    /// Whether the access addresses the parameter access point, which has the records of the encoder object.
    pub fn is_here(&self, access: &Access) -> bool {
        let Access { api, slot, subslot, .. } = *access;
        let is_access_point = (api, slot, subslot) == (ENCODER_API, ENCODER_SLOT, ACCESS_POINT_SUBSLOT);
        self.deviations.checks.check(Check::RecordAnswersAt(api, slot, subslot), is_access_point)
    }

    fn is_parameter_access(&self, index: u16) -> bool {
        self.deviations.checks.check(Check::IsParameterAccess(index), index == self.facts.parameter_access)
    }
}

impl<M: Model> EncoderObject<M> {
    /// Writes a record.
    pub(super) fn write(&mut self, now: Time, access: Access, data: &[u8]) -> Result<(), RecordRefusal> {
        let hooks = self.deviations.hooks.clone();
        let data = hooks.apply(Ok(Cow::Borrowed(data)), |hooks, data| {
            let data = data.map(Cow::into_owned);
            hooks.write_record(&self.live(now).view(), &access, data).map(Cow::Owned)
        });
        self.take_record(now, access, &data?)
    }

    fn take_record(&mut self, now: Time, access: Access, data: &[u8]) -> Result<(), RecordRefusal> {
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
    pub(super) fn read(&mut self, now: Time, access: Access, out: &mut Vec<u8>) -> Result<(), RecordRefusal> {
        let mut octets = Vec::new();
        let read = self.give_record(now, access, &mut octets).map(|()| octets);
        let hooks = self.deviations.hooks.clone();
        out.extend(hooks.apply(read, |hooks, read| hooks.read_record(&self.live(now).view(), &access, read))?);
        Ok(())
    }

    fn give_record(&mut self, now: Time, access: Access, out: &mut Vec<u8>) -> Result<(), RecordRefusal> {
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

    fn access(&mut self, now: Time, access: Access) -> Result<(), RecordRefusal> {
        let live = self.live(now);
        let is_served = live.is_here(&access) && M::serves(&live, access.index);
        if is_served { Ok(()) } else { Err(RecordRefusal::InvalidIndex) }
    }

    /// Processes a user parameter record. During start-up it takes effect at PrmEnd; during data exchange it takes
    /// effect at once, if the manual allows it.
    fn write_user_parameters(&mut self, now: Time, access: Access, data: &[u8]) -> Result<(), RecordRefusal> {
        let user = UserParameters::parse(data).ok_or(RecordRefusal::WriteLength)?;
        let is_of = |phase: fn(ArKey) -> Phase| access.ar.is_some_and(|ar| self.ram.phase == phase(ar));
        let in_exchange = self.facts.record_in_exchange == InExchange::InForce && is_of(Phase::Data);
        if !is_of(Phase::Parameters) && !in_exchange {
            return Err(RecordRefusal::StateConflict);
        }
        (self.ram.staged, self.ram.has_record) = (user, true);
        if self.deviations.checks.check(Check::RecordActsAtOnce, in_exchange) {
            let mut live = self.live(now);
            live.parametrize();
            live.look_for_errors();
        }
        Ok(())
    }

    fn request_parameters(&mut self, now: Time, access: Access, data: &[u8]) -> Result<(), RecordRefusal> {
        let key = access.ar.ok_or(RecordRefusal::StateConflict)?;
        self.responses.forget(key);
        let hooks = self.deviations.hooks.clone();
        let request = hooks.apply(data.to_vec(), |hooks, octets| hooks.parameter_request(key, octets));
        let manager = Manager { serves_any_axis: self.facts.serves_any_axis, checks: self.deviations.checks.clone() };
        let exchange = manager.answer(&request, &mut self.live(now)).map_err(|bad| match bad {
            BadRequest::TooShort => RecordRefusal::WriteLength,
            BadRequest::Count => RecordRefusal::InvalidRange,
        })?;
        let response = hooks.apply(exchange.octets(), |hooks, octets| hooks.parameter_response(&exchange, octets));
        self.responses.keep(key, response);
        Ok(())
    }
}
