//! Start and end of a connection with cyclic data (XAC77 manual, 11.4).
//!
//! A connection starts with the factory user parameters. A record of the connection replaces them. At PrmEnd the
//! parameters take effect.

use super::places;
use super::{EncoderObject, Model, Phase};
use crate::profidrive::life_sign::Watch;
use crate::profidrive::telegram::{Before, Outputs};
use crate::profidrive::user_parameters::UserParameters;
use device_stack::profinet::{ArKey, Plug};
use station::Time;

impl<M: Model> EncoderObject<M> {
    /// A connection with cyclic data begins.
    pub(super) fn start(&mut self, now: Time, ar: ArKey, plugged: &[Plug]) {
        let plugged = self.deviations.hooks.apply(plugged.to_vec(), |hooks, plugged| hooks.plugged(plugged));
        let delivered = self.delivered();
        let ram = &mut self.ram;
        ram.submodules = places::in_use(self.facts, &plugged);
        ram.staged = delivered;
        ram.phase = Phase::Parameters(ar);
        ram.has_record = false;
        ram.outputs = Outputs::default();
        ram.before = Before::default();
        ram.watch = Watch::default();
        (ram.wrong_parameters, ram.warnings) = (false, 0);
        let mut live = self.live(now);
        live.deviations.hooks.notify(|hooks| hooks.starts(&live.view()));
        M::started(&mut live);
        let causes = live.causes();
        live.ram.sensor.restart(&causes);
        live.look_for_errors();
    }

    /// All parameters were sent (PrmEnd). Returns when the data are good.
    pub(super) fn end_parameters(&mut self, now: Time, ar: ArKey) -> Time {
        if self.ram.phase != Phase::Parameters(ar) {
            return now;
        }
        self.ram.phase = Phase::Data(ar);
        let mut live = self.live(now);
        live.parametrize();
        live.look_for_errors();
        live.ram.data_since = Some(now);
        now + live.deviations.hooks.apply(live.facts.timing.ready, |hooks, ready| hooks.ready(&live.view(), ready))
    }

    /// A connection of any kind has ended.
    pub(super) fn end(&mut self, now: Time, ar: ArKey) {
        self.responses.forget(ar);
        if self.ram.phase == Phase::Parameters(ar) || self.ram.phase == Phase::Data(ar) {
            self.ram.phase = Phase::Alone;
            self.ram.outputs = Outputs::default();
            self.ram.data_since = None;
            self.ram.watch = Watch::default();
            self.ram.trigger.ended();
            let mut live = self.live(now);
            live.deviations.hooks.notify(|hooks| hooks.ends(&live.view()));
            live.ram.sensor.ended();
            live.look_for_errors();
        }
    }

    /// The user parameters in force without a record.
    pub(super) fn delivered(&self) -> UserParameters {
        self.deviations.delivered(self.facts, &self.variant.hardware)
    }
}
