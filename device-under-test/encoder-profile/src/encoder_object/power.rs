//! Loss of power, loading from memory, and factory resets.

use super::{EncoderModel, EncoderObject, VolatileData};
use crate::encoder_object::hooks::RetainedEncoderData;
use crate::facts::ClearedData;
use crate::profidrive::parameters::PendingResponses;
use device_stack::profinet::StationData;
use station::Time;

impl<M: EncoderModel> EncoderObject<M> {
    /// The supply is switched on: initialises volatile data and loads stored data.
    pub(super) fn load(&mut self, now: Time) {
        self.ram =
            VolatileData::new(now, self.facts, self.variant, &self.deviations, &self.shaft, &self.store, &self.faults);
        self.responses = PendingResponses::default();
        self.powered = true;
        self.apply_retained(now);
        M::power_up(&mut self.live(now));
        self.deviations.hooks.notify(|hooks| hooks.powered_up());
    }

    /// Applies the retained data after the hooks.
    pub(super) fn apply_retained(&mut self, now: Time) {
        if !self.deviations.hooks.is_any() {
            return;
        }
        let retained = self.retained();
        let live = self.live(now);
        let retained = live.deviations.hooks.apply(retained, |hooks, retained| hooks.load(&live.view(), retained));
        (self.ram.measuring.offset, self.ram.preset_value) = (retained.offset, retained.preset_value);
        self.identity.serial_number = retained.serial_number;
        if *self.store.station.stored() != retained.station {
            self.set_station_of(retained.station);
        }
    }

    /// The supply fails: a running write is lost.
    pub(super) fn lose_power(&mut self, now: Time) {
        let mut live = self.live(now);
        M::power_down(&mut live);
        live.deviations.hooks.notify(|hooks| hooks.power_down(&live.view()));
        self.store.offset.power_down();
        self.store.preset_value.power_down();
        self.powered = false;
    }

    /// Clears the data of a factory reset.
    pub(super) fn reset(&mut self, now: Time, reset: ClearedData) {
        let before = self.retained();
        let mut left = before.clone();
        if reset.application {
            (left.offset, left.preset_value) = (0, 0);
        }
        if reset.station {
            left.station = StationData::default();
        }
        let live = self.live(now);
        let left = live.deviations.hooks.apply(left, |hooks, left| hooks.reset(&live.view(), reset, left));
        if reset.application || left.offset != before.offset {
            self.store.offset.replace(left.offset);
            self.ram.measuring.offset = left.offset;
        }
        if reset.application || left.preset_value != before.preset_value {
            self.store.preset_value.replace(left.preset_value);
            self.ram.preset_value = left.preset_value;
        }
        if reset.station || left.station != before.station {
            self.set_station_of(left.station);
        }
        self.identity.serial_number = left.serial_number;
        if reset.application {
            self.reset_application(now);
        }
    }

    fn reset_application(&mut self, now: Time) {
        self.ram.staged = self.factory_parameters();
        let mut live = self.live(now);
        M::reset(&mut live);
        live.parametrize();
        live.update_errors();
    }

    fn retained(&self) -> RetainedEncoderData {
        RetainedEncoderData {
            offset: self.ram.measuring.offset,
            preset_value: self.ram.preset_value,
            station: self.store.station.stored().clone(),
            serial_number: self.identity.serial_number.clone(),
        }
    }

    /// Sets name and addresses, in use and in memory.
    fn set_station_of(&mut self, station: StationData) {
        self.ram.station.clone_from(&station);
        self.store.station.replace(station);
    }
}
