//! The running encoder object: stored data, volatile data, and what happens as time advances.

use super::Model;
use super::diagnosis::{Unprovoked, without_fault};
use super::places;
use crate::encoder::{Cell, Hardware, Measuring, Shaft, Velocity};
use crate::encoder_object::deviations::EncoderDeviations;
use crate::facts::{Cause, Effect, ErrorFact, Facts, Submodule, Variant, WithoutRecord};
use crate::profidrive::checks::Check;
use crate::profidrive::life_sign::{Given, Watch};
use crate::profidrive::preset_trigger::Trigger;
use crate::profidrive::sensor::Sensor;
use crate::profidrive::telegram::{Before, Image, Outputs, Telegram};
use crate::profidrive::user_parameters::{ParametrizedEncoder, UserParameters};
use alloc::collections::VecDeque;
use alloc::vec::Vec;
use device_stack::profinet::{ArKey, DiagnosisChange, Severity, StationData};
use station::Time;

/// The non-volatile data.
#[derive(Debug)]
pub struct Store {
    /// The offset that results from all presets, stored with each preset.
    pub offset: Cell<u64>,
    /// P65000, stored by P971.
    pub preset_value: Cell<u32>,
    /// Name and addresses, stored by DCP.
    pub station: Cell<StationData>,
}

/// The active stand faults, by name.
#[derive(Clone, Debug, Default)]
pub struct Faults(Vec<&'static str>);

impl Faults {
    /// Sets (`present`) or clears a fault.
    pub(super) fn set(&mut self, name: &'static str, present: bool) {
        self.0.retain(|known| *known != name);
        if present {
            self.0.push(name);
        }
    }

    /// Whether the fault of this name is active.
    #[inline]
    pub fn has(&self, name: &str) -> bool {
        !self.0.is_empty() && self.0.contains(&name)
    }

    /// Whether no fault is active.
    #[inline]
    pub fn are_none(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether an active fault causes this error.
    #[inline]
    pub fn cause(&self, error: &ErrorFact) -> bool {
        !self.0.is_empty() && error.causes.iter().any(|cause| matches!(cause, Cause::Stand(name) if self.has(name)))
    }

    /// Whether an active fault has this effect.
    #[inline]
    pub fn have(&self, effect: Effect, facts: &Facts) -> bool {
        !self.0.is_empty() && facts.errors.iter().any(|error| error.effect == effect && self.cause(error))
    }
}

/// The start-up phase of the connection with cyclic data.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// No connection.
    Alone,
    /// The controller sends parameters.
    Parameters(ArKey),
    /// Data are exchanged.
    Data(ArKey),
}

/// The volatile data.
pub struct Ram {
    pub phase: Phase,
    /// The submodules with data in use; there is at least one.
    pub submodules: Vec<&'static Submodule>,
    /// The user parameters in force.
    pub user: UserParameters,
    /// The user parameters that take effect at PrmEnd.
    pub staged: UserParameters,
    /// Whether this connection has written a user parameter record.
    pub has_record: bool,
    /// When data exchange began; `None` without data exchange.
    pub(super) data_since: Option<Time>,
    /// Whether the parameters in force are invalid or missing.
    pub wrong_parameters: bool,
    /// The bits of the present warnings.
    pub(super) warnings: u32,
    /// The errors that can occur without a stand fault.
    pub(super) without_fault: Vec<Unprovoked>,
    /// P65000.
    pub preset_value: u32,
    /// Name and addresses in use.
    pub station: StationData,
    /// Whether the velocity is not calculated.
    pub velocity_is_off: bool,
    pub measuring: Measuring,
    pub velocity: Velocity,
    /// Handshakes and latched errors.
    pub sensor: Sensor,
    /// The signals of the last cycle.
    pub before: Before,
    /// The outputs in use; `None` for each submodule whose outputs are bad or missing.
    pub outputs: Outputs,
    /// Monitors the sign of life of the controller.
    pub watch: Watch,
    /// The preset without a handshake.
    pub(super) trigger: Trigger,
    /// The signals at the begin of parking, if parking freezes them.
    pub(super) frozen: Option<Image>,
    /// The sign of life of the encoder.
    pub(super) sign_of_life: Given,
    /// Whether a save by P971 is running or has failed.
    pub is_saving: bool,
    /// Whether there was a warning since power-up.
    pub(super) had_warning: bool,
    /// The pending preset, which takes effect when its offset is stored.
    pub(super) next_preset: Option<NextPreset>,
    /// ChannelErrorType and severity of the present diagnoses.
    pub(super) diagnoses: Vec<(u16, Severity)>,
    /// Diagnosis changes that the stack has not fetched yet.
    pub changes: VecDeque<DiagnosisChange>,
}

/// A pending preset.
#[derive(Clone, Copy, Debug)]
pub(super) struct NextPreset {
    /// The offset after the preset.
    pub offset: u64,
    /// Whether G1_ZSW acknowledges it.
    pub is_answered: bool,
}

impl Ram {
    /// The telegram in use; that of the first submodule if there are several.
    pub fn telegram(&self) -> &'static Telegram {
        self.submodules[0].telegram
    }

    /// The state after power-up. Stored data are read, unless the memory is faulty.
    pub fn new(
        now: Time,
        facts: &'static Facts,
        variant: &Variant,
        deviations: &EncoderDeviations,
        shaft: &Shaft,
        store: &Store,
        faults: &Faults,
    ) -> Ram {
        let hardware = variant.hardware;
        let is_unreadable = faults.have(Effect::NoMemory, facts);
        let encoder = deviations.encoder(facts, hardware);
        let user = deviations.delivered(facts, &hardware);
        let mut measuring = Measuring::new(hardware, hardware.sense(shaft.place(now)), deviations.measuring.clone());
        measuring.settings = user.settings(&encoder);
        let unit = user.velocity_unit(&encoder);
        measuring.offset = if is_unreadable { 0 } else { *store.offset.stored() };
        Ram {
            phase: Phase::Alone,
            submodules: places::in_use(facts, &[]),
            user,
            staged: user,
            has_record: false,
            data_since: None,
            wrong_parameters: false,
            warnings: 0,
            without_fault: without_fault(facts),
            preset_value: if is_unreadable { 0 } else { *store.preset_value.stored() },
            station: store.station.stored().clone(),
            velocity_is_off: false,
            measuring,
            velocity: Velocity::new(facts.timing.velocity, unit, hardware, now, shaft, deviations.velocity.clone()),
            sensor: Sensor::new(facts.sensor, deviations.checks.clone()),
            before: Before::default(),
            outputs: Outputs::default(),
            watch: Watch::default(),
            trigger: Trigger::new(deviations.checks.clone(), deviations.trigger.clone()),
            frozen: None,
            sign_of_life: Given::default(),
            is_saving: false,
            had_warning: false,
            next_preset: None,
            diagnoses: Vec::new(),
            changes: VecDeque::new(),
        }
    }
}

/// The powered encoder at one instant.
pub struct Live<'a, M: Model> {
    pub now: Time,
    pub facts: &'static Facts,
    pub variant: &'static Variant,
    pub hardware: Hardware,
    pub deviations: &'a EncoderDeviations,
    pub shaft: &'a Shaft,
    pub faults: &'a Faults,
    pub store: &'a mut Store,
    pub ram: &'a mut Ram,
    pub model: &'a mut M,
}

impl<'a, M: Model> Live<'a, M> {
    /// Advances to `now`: reads the sensor, completes writes and raises errors.
    pub fn advance(&mut self) {
        self.ram.velocity.advance(self.now, self.shaft);
        let stands_still = self.facts.stands_still_in_preset && self.ram.next_preset.is_some();
        let stands_still = self.deviations.checks.check(Check::PositionStandsStill, stands_still);
        if !self.faults.have(Effect::NoReading, self.facts) && !stands_still {
            let place = M::place(self);
            self.ram.measuring.sample(self.hardware.sense(place));
        }
        self.settle();
        M::advance(self);
        self.look_for_errors();
    }

    /// Updates errors, warnings and diagnoses from their causes.
    pub fn look_for_errors(&mut self) {
        self.ram.sensor.watch(&self.causes());
        self.look_for_warnings();
        self.diagnose();
    }

    /// Applies the staged user parameters.
    pub fn parametrize(&mut self) {
        let user = self.understood(self.ram.staged);
        self.ram.user = user;
        let encoder = self.encoder();
        let starts_without = self.facts.without_record == WithoutRecord::Default;
        let is_missing =
            !self.ram.has_record && !self.deviations.checks.check(Check::StartsWithoutRecord, starts_without);
        self.ram.wrong_parameters = is_missing || !user.are_right(&encoder, self.ram.telegram());
        self.ram.measuring.settings = M::settings(self, user.settings(&encoder));
        self.ram.velocity.set_unit(user.velocity_unit(&encoder));
        M::parametrized(self);
    }

    /// The user parameters to apply, after the hooks.
    pub fn understood(&self, user: UserParameters) -> UserParameters {
        self.deviations.hooks.apply(user, |hooks, user| hooks.user_parameters(&self.view(), user))
    }

    /// The encoder for which user parameters are checked.
    pub fn encoder(&self) -> ParametrizedEncoder<'a> {
        self.deviations.encoder(self.facts, self.hardware)
    }
}
