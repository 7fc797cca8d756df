//! The encoder object at work: what it stores, what it holds while it has power, and what it does as time goes by.

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

/// What keeps its contents without power.
#[derive(Debug)]
pub struct Store {
    /// The offset of all presets, stored with each preset.
    pub offset: Cell<u64>,
    /// P65000, stored by P971.
    pub preset_value: Cell<u32>,
    /// Name and addresses, stored by DCP.
    pub station: Cell<StationData>,
}

/// The faults that the stand has brought about, by name.
#[derive(Clone, Debug, Default)]
pub struct Faults(Vec<&'static str>);

impl Faults {
    /// Brings a fault about (`present`) or takes it away.
    pub(super) fn set(&mut self, name: &'static str, present: bool) {
        self.0.retain(|known| *known != name);
        if present {
            self.0.push(name);
        }
    }

    /// Whether the fault of this name is there.
    #[inline]
    pub fn has(&self, name: &str) -> bool {
        !self.0.is_empty() && self.0.contains(&name)
    }

    /// Whether there is none.
    #[inline]
    pub fn are_none(&self) -> bool {
        self.0.is_empty()
    }

    /// Whether a fault is there that brings an error about.
    #[inline]
    pub fn cause(&self, error: &ErrorFact) -> bool {
        !self.0.is_empty() && error.causes.iter().any(|cause| matches!(cause, Cause::Stand(name) if self.has(name)))
    }

    /// Whether a fault is there that has this effect.
    #[inline]
    pub fn have(&self, effect: Effect, facts: &Facts) -> bool {
        !self.0.is_empty() && facts.errors.iter().any(|error| error.effect == effect && self.cause(error))
    }
}

/// Where the start-up of the connection with cyclic data stands.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// There is no such connection.
    Alone,
    /// It sends its parameters.
    Parameters(ArKey),
    /// Data are exchanged.
    Data(ArKey),
}

/// What is lost without power.
pub struct Ram {
    /// Where the start-up stands.
    pub phase: Phase,
    /// The submodules with data in use; there is at least one.
    pub submodules: Vec<&'static Submodule>,
    /// The user parameters in force.
    pub user: UserParameters,
    /// The parameters that take effect at the end of the start-up.
    pub staged: UserParameters,
    /// Whether this connection has brought a record of user parameters.
    pub has_record: bool,
    /// Since when data are exchanged, if they are.
    pub(super) data_since: Option<Time>,
    /// Whether the parameters in force ask for something impossible.
    pub wrong_parameters: bool,
    /// The warnings that are there.
    pub(super) warnings: u32,
    /// The errors that may be there without a fault of the stand.
    pub(super) without_fault: Vec<Unprovoked>,
    /// P65000.
    pub preset_value: u32,
    /// Name and addresses in use.
    pub station: StationData,
    /// Whether no velocity is calculated.
    pub velocity_is_off: bool,
    /// Positions.
    pub measuring: Measuring,
    /// Velocity.
    pub velocity: Velocity,
    /// Handshakes and latched errors.
    pub sensor: Sensor,
    /// The signals of the last cycle.
    pub before: Before,
    /// What was taken from the controller; of each submodule none while its outputs are bad or missing.
    pub outputs: Outputs,
    /// The watch over the controller.
    pub watch: Watch,
    /// The preset without a handshake.
    pub(super) trigger: Trigger,
    /// The signals at the moment when parking fixed them.
    pub(super) frozen: Option<Image>,
    /// The sign of life that the encoder gives.
    pub(super) sign_of_life: Given,
    /// Whether a save by P971 is running or has failed.
    pub is_saving: bool,
    /// Whether there was a warning since power-up.
    pub(super) had_warning: bool,
    /// The preset that takes effect when its offset is stored.
    pub(super) next_preset: Option<NextPreset>,
    /// Error type and severity of the diagnoses that are there.
    pub(super) diagnoses: Vec<(u16, Severity)>,
    /// Diagnoses that came or went and were not fetched yet.
    pub changes: VecDeque<DiagnosisChange>,
}

/// A preset that is being carried out.
#[derive(Clone, Copy, Debug)]
pub(super) struct NextPreset {
    /// The offset that it gives.
    pub offset: u64,
    /// Whether G1_ZSW answers when it is carried out.
    pub is_answered: bool,
}

impl Ram {
    /// The telegram in use; of several submodules the first.
    pub fn telegram(&self) -> &'static Telegram {
        self.submodules[0].telegram
    }

    /// Memory after power-up: what is stored is read, unless the memory is faulty.
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

/// The encoder at one instant, with power.
pub struct Live<'a, M: Model> {
    /// Now.
    pub now: Time,
    /// What the manual says.
    pub facts: &'static Facts,
    /// Which encoder of the manual it is.
    pub variant: &'static Variant,
    /// What its sensor tells apart.
    pub hardware: Hardware,
    /// How it behaves.
    pub deviations: &'a EncoderDeviations,
    /// Its shaft.
    pub shaft: &'a Shaft,
    /// What the stand has brought about.
    pub faults: &'a Faults,
    /// What it has stored.
    pub store: &'a mut Store,
    /// What it would lose without power.
    pub ram: &'a mut Ram,
    /// What is the model's own.
    pub model: &'a mut M,
}

impl<'a, M: Model> Live<'a, M> {
    /// Looks at the sensor, ends what is done and raises errors.
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

    /// Raises the errors whose cause is there, and brings the diagnoses in line with them.
    pub fn look_for_errors(&mut self) {
        self.ram.sensor.watch(&self.causes());
        self.look_for_warnings();
        self.diagnose();
    }

    /// Takes the user parameters that were staged into force.
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

    /// User parameters as they come into force.
    pub fn understood(&self, user: UserParameters) -> UserParameters {
        self.deviations.hooks.apply(user, |hooks, user| hooks.user_parameters(&self.view(), user))
    }

    /// The encoder, as user parameters are judged for it.
    pub fn encoder(&self) -> ParametrizedEncoder<'a> {
        self.deviations.encoder(self.facts, self.hardware)
    }
}
