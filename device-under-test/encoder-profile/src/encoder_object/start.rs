//! The start of a connection, and the records of the encoder object.

use super::places::{self, ACCESS_POINT_SUBSLOT, ENCODER_API, ENCODER_SLOT};
use super::{EncoderObject, Live, Model, Phase};
use crate::facts::InExchange;
use crate::profidrive::life_sign::Watch;
use crate::profidrive::mantel::Cleared;
use crate::profidrive::parameters::{BadRequest, Manager};
use crate::profidrive::telegram::{Emitter, Outputs};
use crate::profidrive::user_parameters::{self, UserParameters};
use alloc::vec::Vec;
use core::time::Duration;
use device_stack::profinet::{Access, ArKey, Plug, RecordRefusal};
use station::Time;

/// Record of the user parameters.
const USER_PARAMETERS: u16 = 0xBF00;
/// Later than anybody waits for good data.
const NEVER: Duration = Duration::from_secs(3600);

impl<M: Model> Live<'_, M> {
    /// Whether a record of the encoder object is looked for where it answers.
    pub fn is_here(&self, access: &Access) -> bool {
        let asked = (access.api, access.slot, access.subslot);
        (self.behaviour.records.answer_at)(asked, (ENCODER_API, ENCODER_SLOT, ACCESS_POINT_SUBSLOT))
    }
}

impl<M: Model> EncoderObject<M> {
    /// A connection with cyclic data begins.
    pub(super) fn start(&mut self, now: Time, ar: ArKey, plugged: &[Plug]) {
        let default = self.default_record();
        let ram = &mut self.ram;
        ram.submodules = places::in_use(self.facts, plugged);
        if self.behaviour.telegram.stays {
            if ram.latched.is_empty() {
                ram.latched.clone_from(&ram.submodules);
            }
            ram.submodules.clone_from(&ram.latched);
        }
        let rules = &self.behaviour.user_parameters;
        if (rules.takes_every_record || !ram.was_parametrized) && !(rules.outlasts_starts && ram.was_changed) {
            ram.staged = default;
        }
        ram.phase = Phase::Parameters(ar);
        (ram.has_record, ram.has_request) = (false, false);
        ram.outputs = Outputs::default();
        ram.last_preset = None;
        ram.emitter = Emitter::new(self.behaviour.telegram);
        ram.watch = Watch::default();
        (ram.wrong_parameters, ram.warnings) = (false, 0);
        (ram.good_since, ram.last_control, ram.had_control) = (None, false, false);
        let mut live = self.live(now);
        M::started(&mut live);
        let causes = live.causes();
        live.ram.sensor.restart(&causes);
        live.look_for_errors();
    }

    /// All parameters were sent; gives the time at which there are good data.
    pub(super) fn end_parameters(&mut self, now: Time, ar: ArKey) -> Time {
        if self.ram.phase != Phase::Parameters(ar) {
            return now;
        }
        self.ram.phase = Phase::Data(ar);
        let ready = self.facts.timing.ready;
        let mut live = self.live(now);
        live.parametrize();
        live.look_for_errors();
        (live.ram.settings_at_start, live.ram.data_since) = (live.ram.measuring.settings, Some(now));
        let starts = (live.behaviour.user_parameters.starts)(&live.ram.user)
            && (live.behaviour.records.starts)(live.ram.telegram(), live.ram.has_request);
        now + if starts { ready } else { NEVER }
    }

    /// A connection of any kind has ended.
    pub(super) fn end(&mut self, now: Time, ar: ArKey) {
        self.responses.forget(ar);
        if self.ram.phase == Phase::Parameters(ar) || self.ram.phase == Phase::Data(ar) {
            self.ram.phase = Phase::Alone;
            self.ram.outputs = Outputs::default();
            self.ram.data_since = None;
            self.ram.watch = Watch::default();
            self.ram.trigger.clear(Cleared::End);
            let mut live = self.live(now);
            live.ram.sensor.ended();
            live.look_for_errors();
        }
    }

    /// Writes a record.
    pub(super) fn write(&mut self, now: Time, access: Access, data: &[u8]) -> Result<(), RecordRefusal> {
        if let Some(written) = M::write_record(&mut self.live(now), access, data) {
            return written;
        }
        self.access(now, access)?;
        match access.index {
            USER_PARAMETERS => self.write_user_parameters(now, access, data),
            index if index == self.behaviour.records.parameter_access => self.request_parameters(now, access, data),
            _ => Err(RecordRefusal::InvalidIndex),
        }
    }

    /// Reads a record.
    pub(super) fn read(&mut self, now: Time, access: Access, out: &mut Vec<u8>) -> Result<(), RecordRefusal> {
        if let Some(read) = M::read_record(&mut self.live(now), access, out) {
            return read;
        }
        self.access(now, access)?;
        match access.index {
            USER_PARAMETERS => Err(RecordRefusal::AccessDenied),
            index if index == self.behaviour.records.parameter_access => {
                let key = access.ar.ok_or(RecordRefusal::StateConflict)?;
                let waiting = self.responses.fetch(key);
                let response =
                    self.behaviour.hooks.apply(waiting, |hooks, waiting| hooks.fetched_response(key, waiting));
                out.extend(response.ok_or(RecordRefusal::StateConflict)?);
                Ok(())
            }
            _ => Err(RecordRefusal::InvalidIndex),
        }
    }

    fn access(&mut self, now: Time, access: Access) -> Result<(), RecordRefusal> {
        let live = self.live(now);
        match live.is_here(&access) && M::serves(&live, access.index) {
            true => Ok(()),
            false => Err(RecordRefusal::InvalidIndex),
        }
    }

    /// The user parameters without a record.
    pub(super) fn default_record(&self) -> UserParameters {
        let hardware = &self.variant.hardware;
        (self.behaviour.user_parameters.default)((self.facts.default_record)(hardware), hardware)
    }

    fn write_user_parameters(&mut self, now: Time, access: Access, data: &[u8]) -> Result<(), RecordRefusal> {
        let rules = self.behaviour.user_parameters;
        if rules.checks_length && data.len() != rules.octets_expected {
            return Err(RecordRefusal::WriteLength);
        }
        let mut octets = [0; user_parameters::OCTETS];
        octets.iter_mut().zip(data).for_each(|(octet, sent)| *octet = *sent);
        self.ram.record = octets;
        (rules.octets)(&mut octets);
        let parameters = UserParameters::parse(&octets).ok_or(RecordRefusal::WriteLength)?;
        if !(rules.accepts)(&parameters, &self.variant.hardware) {
            return Err(RecordRefusal::InvalidParameter);
        }
        if !(self.behaviour.records.go_with)(self.ram.telegram(), parameters.class_4) {
            return Err(RecordRefusal::InvalidParameter);
        }
        let in_exchange = self.facts.record_in_exchange == InExchange::InForce
            && access.ar.is_some_and(|ar| self.ram.phase == Phase::Data(ar));
        let in_start = access.ar.is_some_and(|ar| self.ram.phase == Phase::Parameters(ar));
        if !in_start && !in_exchange {
            if rules.measures_by_refused {
                self.ram.measuring.settings = parameters.settings(&self.variant.hardware, &rules);
            }
            return Err(RecordRefusal::StateConflict);
        }
        let is_outlasted = in_start && self.ram.was_changed && rules.outlasts_starts;
        if (rules.takes_every_record || !self.ram.was_parametrized) && !is_outlasted {
            self.ram.staged = parameters;
        }
        self.ram.was_changed |= in_exchange;
        (self.ram.was_parametrized, self.ram.has_record) = (true, true);
        let mut live = self.live(now);
        if let Some(value) = (rules.preset_value)(&octets) {
            live.set_preset_value(value);
        }
        if in_exchange && rules.acts_in_exchange {
            live.parametrize();
            live.look_for_errors();
        }
        Ok(())
    }

    fn request_parameters(&mut self, now: Time, access: Access, data: &[u8]) -> Result<(), RecordRefusal> {
        let key = access.ar.ok_or(RecordRefusal::StateConflict)?;
        self.ram.has_request = true;
        if !(self.behaviour.records.takes_requests)(&self.ram.user) {
            return Err(RecordRefusal::StateConflict);
        }
        self.ram.held_up_until = now + self.behaviour.records.hold_up;
        self.responses.forget(key);
        let hooks = self.behaviour.hooks.clone();
        let request = hooks.apply(data.to_vec(), |hooks, octets| hooks.parameter_request(key, octets));
        let manager = Manager { serves_any_axis: self.facts.serves_any_axis, checks: self.behaviour.checks.clone() };
        let exchange = manager.answer(&request, &mut self.live(now)).map_err(|bad| match bad {
            BadRequest::TooShort => RecordRefusal::WriteLength,
            BadRequest::Count => RecordRefusal::InvalidRange,
        })?;
        let response = hooks.apply(exchange.octets(), |hooks, octets| hooks.parameter_response(&exchange, octets));
        self.responses.keep(key, response);
        Ok(())
    }
}
