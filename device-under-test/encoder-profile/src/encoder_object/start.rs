//! Start and end of a connection with cyclic data (XAC77 manual, 11.4).
//!
//! A connection starts with the factory user parameters. A record of the connection replaces them. At PrmEnd the
//! parameters take effect.

use super::modules;
use super::{ConnectionPhase, EncoderModel, EncoderObject};
use crate::profidrive::life_sign::ControllerLifeSign;
use crate::profidrive::telegram::{OutputValues, PreviousCycle};
use crate::profidrive::user_parameters::UserParameterData;
use device_stack::profinet::{ArKey, PluggableSubmodule};
use station::Time;

impl<M: EncoderModel> EncoderObject<M> {
    /// A connection with cyclic data begins.
    pub(super) fn start(&mut self, now: Time, ar: ArKey, plugged: &[PluggableSubmodule]) {
        let plugged = self.deviations.hooks.apply(plugged.to_vec(), |hooks, plugged| hooks.plugged(plugged));
        let delivered = self.factory_parameters();
        let ram = &mut self.ram;
        ram.submodules = modules::submodules_in_use(self.facts, &plugged);
        ram.staged = delivered;
        ram.phase = ConnectionPhase::Parameters(ar);
        ram.has_record = false;
        ram.outputs = OutputValues::default();
        ram.before = PreviousCycle::default();
        ram.watch = ControllerLifeSign::default();
        (ram.wrong_parameters, ram.warnings) = (false, 0);
        let mut live = self.live(now);
        live.deviations.hooks.notify(|hooks| hooks.starts(&live.view()));
        M::started(&mut live);
        let causes = live.causes();
        live.ram.sensor.restart(&causes);
        live.update_errors();
    }

    /// All parameters were sent (PrmEnd). Returns when the data are good.
    pub(super) fn end_parameters(&mut self, now: Time, ar: ArKey) -> Time {
        if self.ram.phase != ConnectionPhase::Parameters(ar) {
            return now;
        }
        self.ram.phase = ConnectionPhase::Data(ar);
        let mut live = self.live(now);
        live.parametrize();
        live.update_errors();
        live.ram.data_since = Some(now);
        now + live.deviations.hooks.apply(live.facts.timing.ready, |hooks, ready| hooks.ready(&live.view(), ready))
    }

    /// A connection of any kind has ended.
    pub(super) fn end(&mut self, now: Time, ar: ArKey) {
        self.responses.forget(ar);
        if self.ram.phase == ConnectionPhase::Parameters(ar) || self.ram.phase == ConnectionPhase::Data(ar) {
            self.ram.phase = ConnectionPhase::Alone;
            self.ram.outputs = OutputValues::default();
            self.ram.data_since = None;
            self.ram.watch = ControllerLifeSign::default();
            self.ram.trigger.ended();
            let mut live = self.live(now);
            live.deviations.hooks.notify(|hooks| hooks.ends(&live.view()));
            live.ram.sensor.ended();
            live.update_errors();
        }
    }

    /// The user parameters in force without a record.
    pub(super) fn factory_parameters(&self) -> UserParameterData {
        self.deviations.factory_parameters(self.facts, &self.variant.hardware)
    }
}
