//! The running encoder object: stored data, volatile data, and what happens as time advances.

use super::EncoderModel;
use super::diagnosis::{InternalError, internal_errors};
use super::modules;
use crate::encoder::{Hardware, Measuring, NvmCell, Shaft, Velocity};
use crate::encoder_object::deviations::EncoderDeviations;
use crate::facts::{
    EncoderVariant, ErrorCause, ErrorFact, FaultEffect, ManualFacts, MissingRecordEffect, SubmoduleFacts,
};
use crate::profidrive::checks::EncoderCheck;
use crate::profidrive::life_sign::{ControllerLifeSign, EncoderLifeSign};
use crate::profidrive::preset_trigger::TriggerDetector;
use crate::profidrive::sensor::Sensor;
use crate::profidrive::telegram::{OutputValues, PreviousCycle, SignalImage, Telegram};
use crate::profidrive::user_parameters::{ParametrizedEncoder, UserParameterData};
use alloc::collections::VecDeque;
use alloc::vec::Vec;
use device_stack::profinet::{ArKey, DiagnosisChange, DiagnosisSeverity, StationData};
use station::Time;

/// The non-volatile data.
#[derive(Debug)]
pub struct NonVolatileData {
    /// The offset that results from all presets, stored with each preset.
    pub offset: NvmCell<u64>,
    /// P65000, stored by P971.
    pub preset_value: NvmCell<u32>,
    /// Name and addresses, stored by DCP.
    pub station: NvmCell<StationData>,
}

/// The active stand faults, by name.
#[derive(Clone, Debug, Default)]
pub struct StandFaults(Vec<&'static str>);

impl StandFaults {
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
        !self.0.is_empty()
            && error.causes.iter().any(|cause| matches!(cause, ErrorCause::Stand(name) if self.has(name)))
    }

    /// Whether an active fault has this effect.
    #[inline]
    pub fn have(&self, effect: FaultEffect, facts: &ManualFacts) -> bool {
        !self.0.is_empty() && facts.errors.iter().any(|error| error.effect == effect && self.cause(error))
    }
}

/// The start-up phase of the connection with cyclic data.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum ConnectionPhase {
    /// No connection.
    Alone,
    /// The controller sends parameters.
    Parameters(ArKey),
    /// Data are exchanged.
    Data(ArKey),
}

/// The volatile data.
pub struct VolatileData {
    pub phase: ConnectionPhase,
    /// The submodules with data in use; there is at least one.
    pub submodules: Vec<&'static SubmoduleFacts>,
    /// The user parameters in force.
    pub user: UserParameterData,
    /// The user parameters that take effect at PrmEnd.
    pub staged: UserParameterData,
    /// Whether this connection has written a user parameter record.
    pub has_record: bool,
    /// When data exchange began; `None` without data exchange.
    pub(super) data_since: Option<Time>,
    /// Whether the parameters in force are invalid or missing.
    pub wrong_parameters: bool,
    /// The bits of the present warnings.
    pub(super) warnings: u32,
    /// The errors that can occur without a stand fault.
    pub(super) without_fault: Vec<InternalError>,
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
    pub before: PreviousCycle,
    /// The outputs in use; `None` for each submodule whose outputs are bad or missing.
    pub outputs: OutputValues,
    /// Monitors the sign of life of the controller.
    pub watch: ControllerLifeSign,
    /// The preset without a handshake.
    pub(super) trigger: TriggerDetector,
    /// The signals at the begin of parking, if parking freezes them.
    pub(super) frozen: Option<SignalImage>,
    /// The sign of life of the encoder.
    pub(super) sign_of_life: EncoderLifeSign,
    /// Whether a save by P971 is running or has failed.
    pub is_saving: bool,
    /// Whether there was a warning since power-up.
    pub(super) had_warning: bool,
    /// The pending preset, which takes effect when its offset is stored.
    pub(super) next_preset: Option<PendingPreset>,
    /// ChannelErrorType and severity of the present diagnoses.
    pub(super) diagnoses: Vec<(u16, DiagnosisSeverity)>,
    /// Diagnosis changes that the stack has not fetched yet.
    pub changes: VecDeque<DiagnosisChange>,
}

/// A pending preset.
#[derive(Clone, Copy, Debug)]
pub(super) struct PendingPreset {
    /// The offset after the preset.
    pub offset: u64,
    /// Whether G1_ZSW acknowledges it.
    pub is_answered: bool,
}

impl VolatileData {
    /// The telegram in use; that of the first submodule if there are several.
    pub fn telegram(&self) -> &'static Telegram {
        self.submodules[0].telegram
    }

    /// The state after power-up. Stored data are read, unless the memory is faulty.
    pub fn new(
        now: Time,
        facts: &'static ManualFacts,
        variant: &EncoderVariant,
        deviations: &EncoderDeviations,
        shaft: &Shaft,
        store: &NonVolatileData,
        faults: &StandFaults,
    ) -> VolatileData {
        let hardware = variant.hardware;
        let is_unreadable = faults.have(FaultEffect::NoMemory, facts);
        let encoder = deviations.encoder(facts, hardware);
        let user = deviations.factory_parameters(facts, &hardware);
        let mut measuring = Measuring::new(hardware, hardware.sense(shaft.position(now)), deviations.measuring.clone());
        measuring.settings = user.settings(&encoder);
        let unit = user.velocity_unit(&encoder);
        measuring.offset = if is_unreadable { 0 } else { *store.offset.stored() };
        VolatileData {
            phase: ConnectionPhase::Alone,
            submodules: modules::submodules_in_use(facts, &[]),
            user,
            staged: user,
            has_record: false,
            data_since: None,
            wrong_parameters: false,
            warnings: 0,
            without_fault: internal_errors(facts),
            preset_value: if is_unreadable { 0 } else { *store.preset_value.stored() },
            station: store.station.stored().clone(),
            velocity_is_off: false,
            measuring,
            velocity: Velocity::new(facts.timing.velocity, unit, hardware, now, shaft, deviations.velocity.clone()),
            sensor: Sensor::new(facts.sensor, deviations.checks.clone()),
            before: PreviousCycle::default(),
            outputs: OutputValues::default(),
            watch: ControllerLifeSign::default(),
            trigger: TriggerDetector::new(deviations.checks.clone(), deviations.trigger.clone()),
            frozen: None,
            sign_of_life: EncoderLifeSign::default(),
            is_saving: false,
            had_warning: false,
            next_preset: None,
            diagnoses: Vec::new(),
            changes: VecDeque::new(),
        }
    }
}

/// The powered encoder at one instant.
pub struct PoweredEncoder<'a, M: EncoderModel> {
    pub now: Time,
    pub facts: &'static ManualFacts,
    pub variant: &'static EncoderVariant,
    pub hardware: Hardware,
    pub deviations: &'a EncoderDeviations,
    pub shaft: &'a Shaft,
    pub faults: &'a StandFaults,
    pub store: &'a mut NonVolatileData,
    pub ram: &'a mut VolatileData,
    pub model: &'a mut M,
}

impl<'a, M: EncoderModel> PoweredEncoder<'a, M> {
    /// Advances to `now`: reads the sensor, completes writes and raises errors.
    pub fn advance(&mut self) {
        self.ram.velocity.advance(self.now, self.shaft);
        let stands_still = self.facts.freezes_position_in_preset && self.ram.next_preset.is_some();
        let stands_still = self.deviations.checks.check(EncoderCheck::PositionIsFrozen, stands_still);
        if !self.faults.have(FaultEffect::NoReading, self.facts) && !stands_still {
            let place = M::shaft_position(self);
            self.ram.measuring.sample(self.hardware.sense(place));
        }
        self.settle();
        M::advance(self);
        self.update_errors();
    }

    /// Updates errors, warnings and diagnoses from their causes.
    pub fn update_errors(&mut self) {
        self.ram.sensor.watch(&self.causes());
        self.update_warnings();
        self.diagnose();
    }

    /// Applies the staged user parameters.
    pub fn parametrize(&mut self) {
        let user = self.hooked_user_parameters(self.ram.staged);
        self.ram.user = user;
        let encoder = self.encoder();
        let starts_without = self.facts.without_record == MissingRecordEffect::Default;
        let is_missing =
            !self.ram.has_record && !self.deviations.checks.check(EncoderCheck::StartsWithoutRecord, starts_without);
        self.ram.wrong_parameters = is_missing || !user.are_right(&encoder, self.ram.telegram());
        self.ram.measuring.settings = M::settings(self, user.settings(&encoder));
        self.ram.velocity.set_unit(user.velocity_unit(&encoder));
        M::parametrized(self);
    }

    /// The user parameters to apply, after the hooks.
    pub fn hooked_user_parameters(&self, user: UserParameterData) -> UserParameterData {
        self.deviations.hooks.apply(user, |hooks, user| hooks.user_parameters(&self.view(), user))
    }

    /// The encoder for which user parameters are checked.
    pub fn encoder(&self) -> ParametrizedEncoder<'a> {
        self.deviations.encoder(self.facts, self.hardware)
    }
}
