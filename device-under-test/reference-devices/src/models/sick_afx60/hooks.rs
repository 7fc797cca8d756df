//! The hooks of the AFS60 and AFM60, with which a deviation can change records, retained data and checks.
//!
//! The encoders themselves have no deviations. Without the feature `deviations` no hook is called.

use super::limits::{Limits, MonitoredSpeed};
use super::round_axis::RoundAxisState;
use super::service_log::ServiceLog;
use super::start_record::StartRecordFields;
use super::{Afx60State, PoweredEncoder};
use core::time::Duration;
use device_stack::Attached;
use station::Time;

/// A decision with its data; each comment describes `true`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Afx60Check {
    /// The velocity is calculated.
    VelocityIsCalculated,
    /// The speed is above its limit.
    TooFast(MonitoredSpeed),
    /// The speed is below its limit.
    TooSlow(MonitoredSpeed),
    /// A temperature in degrees Celsius is below the lower or above the upper limit.
    TemperatureIsOutside(f64, [f64; 2]),
    /// A supply voltage in millivolts is below its limit.
    Undervoltage(u64, u64),
    /// A supply voltage in millivolts is above its limit.
    Overvoltage(u64, u64),
    /// A supply voltage in millivolts is outside its limits, and this is an error.
    SupplyIsWrong(u64),
    /// The supply has returned from below its limit, and the encoder restarts.
    Restarts,
    /// The encoder works.
    Works {
        /// Whether a manual reset waits for power-off.
        is_reset_due: bool,
    },
    /// The encoder has a round axis.
    HasRoundAxis,
    /// A preset is carried out with this value.
    PresetValue {
        /// The value in units.
        value: u64,
        /// The number of positions.
        range: u64,
        /// The number of revolutions of the sensor.
        revolutions: u64,
    },
    /// The address switches request the reset.
    ResetSwitches([u32; 3]),
    /// The button has been held for long enough for the reset.
    ResetIsHeld(Duration),
    /// The preset value of the start is used.
    StartPresetValue {
        /// Whether a preset value was ever stored.
        is_stored: bool,
    },
    /// The vendor record of the start is valid.
    StartRecord(StartRecordFields),
    /// The value of this parameter is stored now, by a write to it or by P971.
    Stores(u16),
    /// A counter of P1004 counts beyond this value.
    Counts(u16),
}

/// An event that changes retained data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Afx60Event {
    /// Power-up.
    PowerUp,
    /// Power-down.
    PowerDown {
        /// Whether a save by P971 is interrupted.
        is_saving: bool,
    },
    /// A connection with cyclic data begins.
    Start,
    /// The encoder is reset to factory settings.
    Reset,
    /// The relative service log, P1003, is reset.
    LogReset,
}

/// The retained data of the encoder, in addition to those of the encoder object.
#[derive(Clone, Debug)]
pub struct RetainedVendorData {
    /// The limits, P1006 and P1007.
    pub limits: Limits,
    /// The service logs, P1002 to P1004.
    pub log: ServiceLog,
    /// The round axis, P1009.
    pub axis: RoundAxisState,
    /// The preset value, P65000.
    pub preset_value: u32,
}

impl RetainedVendorData {
    /// Copies the retained data of `live`.
    pub(super) fn of(live: &PoweredEncoder<'_, Afx60State>) -> RetainedVendorData {
        let Afx60State { limits, service, axis, .. } = &*live.model;
        RetainedVendorData {
            limits: limits.limits,
            log: service.clone(),
            axis: *axis,
            preset_value: live.ram.preset_value,
        }
    }

    /// Lets deviations change the retained data after an event; `self` is the data before the event.
    pub(super) fn keep(self, live: &mut PoweredEncoder<'_, Afx60State>, event: Afx60Event) {
        let hooks = &live.model.hooks.0;
        if !hooks.is_any() {
            return;
        }
        let RetainedVendorData { limits, log, axis, preset_value } =
            hooks.apply(RetainedVendorData::of(live), |hooks, right| hooks.kept(event, &self, right));
        live.ram.preset_value = preset_value;
        if event == Afx60Event::Reset {
            live.model.limits.memory.replace(limits);
        }
        (live.model.limits.limits, live.model.service, live.model.axis) = (limits, log, axis);
    }
}

/// The supply voltage and the temperature that the encoder measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredSupply {
    /// In volts.
    pub volts: f64,
    /// In degrees Celsius.
    pub celsius: f64,
}

impl MeasuredSupply {
    /// Returns the supply voltage in whole millivolts.
    pub fn millivolts(&self) -> u64 {
        (self.volts * 1000.0 + 0.5).max(0.0) as u64
    }

    /// Returns the temperature in whole degrees Celsius.
    pub fn degrees(&self) -> i64 {
        (self.celsius + if self.celsius < 0.0 { -0.5 } else { 0.5 }) as i64
    }
}

/// The hooks. The default implementations change nothing.
#[allow(unused_variables, reason = "the names say what a hook is given")]
pub trait Afx60Hooks {
    /// Returns the decision to use, given the check and the decision of the manual.
    fn check(&mut self, check: Afx60Check, verdict: bool) -> bool {
        verdict
    }

    /// Returns the data retained at an event, given the data before the event and those that remain by the manual.
    fn kept(
        &mut self,
        event: Afx60Event,
        before: &RetainedVendorData,
        right: RetainedVendorData,
    ) -> RetainedVendorData {
        right
    }

    /// Returns the supply voltage in volts and the temperature in degrees Celsius that the encoder measures.
    fn measured(&mut self, now: Time, right: MeasuredSupply) -> MeasuredSupply {
        right
    }

    /// Returns how long a save takes.
    fn save_takes(&mut self, right: Duration) -> Duration {
        right
    }

    /// Is called when the service log has been updated.
    fn logged(&mut self, now: Time, log: &ServiceLog) {}

    /// Returns the vendor record as it arrives during start-up.
    fn start_record(&mut self, fields: StartRecordFields) -> StartRecordFields {
        fields
    }
}

/// The deviations attached to an AFS60 or AFM60.
#[derive(Clone, Debug, Default)]
pub struct Afx60Deviations(pub Attached<dyn Afx60Hooks>);

impl Afx60Deviations {
    /// Returns `verdict`, unless a deviation changes it.
    pub fn check(&self, check: Afx60Check, verdict: bool) -> bool {
        self.0.apply(verdict, |hooks, verdict| hooks.check(check, verdict))
    }
}
