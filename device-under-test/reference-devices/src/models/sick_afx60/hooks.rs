//! The hooks of the AFS60 and AFM60: the seams at which a deviation may change what comes in, what is kept and what is shown, and
//! the checks that it may flip.
//!
//! The encoders themselves are plain. Without the feature `deviations` no hook is ever called.

use super::limits::{Limits, Speeds};
use super::round_axis::Axis;
use super::service_log::ServiceLog;
use super::start_record::Fields;
use super::{PoweredEncoder, State};
use core::time::Duration;
use device_stack::Attached;

/// A decision, with what it is about; the comment says what `true` means.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Check {
    /// The velocity is calculated.
    VelocityIsCalculated,
    /// The speed is above its limit.
    TooFast(Speeds),
    /// The speed is below its limit.
    TooSlow(Speeds),
    /// A temperature in degrees Celsius is below the lower or above the upper limit.
    TemperatureIsOutside(f64, [f64; 2]),
    /// A supply in millivolts is below its limit.
    Undervoltage(u64, u64),
    /// A supply in millivolts is above its limit.
    Overvoltage(u64, u64),
    /// The supply has come back from below its limit, and the encoder starts anew.
    Restarts,
    /// The encoder works.
    Works {
        /// Whether a reset by hand waits for the supply to go.
        is_reset_due: bool,
    },
    /// There is a round axis.
    HasRoundAxis,
    /// A preset is carried out with this value.
    PresetValue {
        /// The value in units.
        value: u64,
        /// How many positions there are.
        range: u64,
        /// The revolutions that the encoder tells apart.
        revolutions: u64,
    },
    /// The address switches request the reset.
    ResetSwitches([u32; 3]),
    /// The button has been held for long enough for the reset.
    ResetIsHeld(Duration),
    /// The preset value of the start is taken.
    StartPresetValue {
        /// Whether a preset value was ever stored.
        is_stored: bool,
    },
    /// The record of the start is right.
    StartRecord(Fields),
    /// The value of this parameter is stored now: with each write of its own, or by P971.
    Stores(u16),
    /// A counter of P1004 goes on from here.
    Counts(u16),
}

/// What changes that which the encoder keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// The supply has come.
    PowerUp,
    /// The supply goes.
    PowerDown {
        /// Whether a save by P971 is interrupted.
        is_saving: bool,
    },
    /// A connection with cyclic data begins.
    Start,
    /// The encoder is reset to factory settings.
    Reset,
    /// P1003 is reset.
    LogReset,
}

/// What the encoder keeps, beside what is in the encoder object.
#[derive(Clone, Debug)]
pub struct Kept {
    /// P1006 and P1007.
    pub limits: Limits,
    /// P1002 to P1004.
    pub log: ServiceLog,
    /// P1009.
    pub axis: Axis,
    /// P65000.
    pub preset_value: u32,
}

impl Kept {
    /// What `live` keeps.
    pub(super) fn of(live: &PoweredEncoder<'_, State>) -> Kept {
        let State { limits, service, axis, .. } = &*live.model;
        Kept { limits: limits.limits, log: service.clone(), axis: *axis, preset_value: live.ram.preset_value }
    }

    /// Lets deviations change what is left of it after an event.
    pub(super) fn keep(self, live: &mut PoweredEncoder<'_, State>, event: Event) {
        let hooks = &live.model.hooks.0;
        if !hooks.is_any() {
            return;
        }
        let Kept { limits, log, axis, preset_value } =
            hooks.apply(Kept::of(live), |hooks, right| hooks.kept(event, &self, right));
        live.ram.preset_value = preset_value;
        if event == Event::Reset {
            live.model.limits.memory.replace(limits);
        }
        (live.model.limits.limits, live.model.service, live.model.axis) = (limits, log, axis);
    }
}

/// The hooks; each default changes nothing.
#[allow(unused_variables, reason = "the names say what a hook is given")]
pub trait Afx60Hooks {
    /// The decision that counts, from what it is about and the decision of the manual.
    fn check(&mut self, check: Check, verdict: bool) -> bool {
        verdict
    }

    /// What is kept over an event, from what was there before it and what the manual leaves of it.
    fn kept(&mut self, event: Event, before: &Kept, right: Kept) -> Kept {
        right
    }

    /// The record of the vendor as it arrives in a start.
    fn start_record(&mut self, fields: Fields) -> Fields {
        fields
    }
}

/// The handle of the deviations of an AFS60 or AFM60.
#[derive(Clone, Debug, Default)]
pub struct Hooks(pub Attached<dyn Afx60Hooks>);

impl Hooks {
    /// The decision that counts: `verdict`, unless a deviation flips it.
    pub fn check(&self, check: Check, verdict: bool) -> bool {
        self.0.apply(verdict, |hooks, verdict| hooks.check(check, verdict))
    }
}
