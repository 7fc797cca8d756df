//! Errors and warnings, and the diagnoses about them.

use super::modules::{ACCESS_POINT_SUBSLOT, ENCODER_API, ENCODER_SLOT};
use super::{EncoderModel, PoweredEncoder};
use crate::facts::{ErrorCause, ErrorFact, FaultEffect, ManualFacts};
use crate::profidrive::checks::EncoderCheck;
use crate::profidrive::sensor::SensorError;
use alloc::vec::Vec;
use device_stack::profinet::{DiagnosisChange, DiagnosisSeverity, SubmoduleDiagnosis};

/// Channel of a diagnosis of the whole submodule.
const WHOLE_SUBMODULE: u16 = 0x8000;

/// An error that can occur without a stand fault.
#[derive(Clone, Copy)]
pub(super) struct InternalError {
    /// Its index in the facts.
    number: usize,
    /// Its causes other than stand faults.
    causes: InternalCauses,
}

/// The causes of an error other than stand faults.
#[derive(Clone, Copy)]
struct InternalCauses {
    has_life_sign: bool,
    has_wrong_parameters: bool,
    has_model: bool,
}

impl InternalCauses {
    fn of(error: &ErrorFact) -> InternalCauses {
        InternalCauses {
            has_life_sign: error.causes.contains(&ErrorCause::LifeSign),
            has_wrong_parameters: error.causes.contains(&ErrorCause::WrongParameters),
            has_model: error.causes.contains(&ErrorCause::Model),
        }
    }

    fn are_none(self) -> bool {
        !(self.has_life_sign || self.has_wrong_parameters || self.has_model)
    }
}

/// The errors that can occur without a stand fault. The first error is included, because a model may raise it for a
/// warning.
pub(super) fn internal_errors(facts: &ManualFacts) -> Vec<InternalError> {
    let known = facts.errors.iter().enumerate();
    let known = known.map(|(number, error)| InternalError { number, causes: InternalCauses::of(error) });
    let may_be = |one: &InternalError| {
        one.number == 0 || facts.errors[one.number].effect == FaultEffect::NoMemory || !one.causes.are_none()
    };
    known.filter(may_be).collect()
}

impl<M: EncoderModel> PoweredEncoder<'_, M> {
    /// The errors whose cause is present. Their numbers are indices into the facts.
    pub fn causes(&self) -> Vec<SensorError> {
        let raised = |number: usize, causes: InternalCauses| {
            let error = &self.facts.errors[number];
            self.is_caused(error, causes).then_some(SensorError { number: number as u16, code: error.code })
        };
        let causes = if self.faults.are_none() {
            self.ram.without_fault.iter().filter_map(|one| raised(one.number, one.causes)).collect()
        } else {
            let known = self.facts.errors.iter().enumerate();
            known.filter_map(|(number, error)| raised(number, InternalCauses::of(error))).collect()
        };
        self.deviations.hooks.apply(causes, |hooks, causes| hooks.causes(&self.view(), causes))
    }

    fn is_caused(&self, error: &ErrorFact, causes: InternalCauses) -> bool {
        let by_itself = causes.has_life_sign && self.ram.watch.has_failed()
            || causes.has_wrong_parameters && self.ram.wrong_parameters
            || causes.has_model && M::is_caused(self, error);
        self.faults.cause(error) || by_itself
    }

    /// The present errors that the manual defines, oldest first.
    pub fn errors(&self) -> Vec<&'static ErrorFact> {
        if self.ram.sensor.errors().is_empty() {
            return Vec::new();
        }
        let known = |error: &SensorError| {
            let there = self.facts.errors.get(usize::from(error.number));
            there.or_else(|| self.facts.errors.iter().find(|fact| fact.code.is_some() && fact.code == error.code))
        };
        self.ram.sensor.errors().iter().filter_map(known).collect()
    }

    /// The fault bits of the present errors.
    pub fn fault_bits(&self) -> u32 {
        self.errors().iter().fold(0, |bits, error| bits | error.fault_bits)
    }

    /// The bits of the present warnings.
    pub fn warnings(&self) -> u32 {
        self.ram.warnings
    }

    /// Updates the warnings from their causes.
    pub(super) fn update_warnings(&mut self) {
        let known = if self.faults.are_none() { &[] } else { self.facts.warnings };
        let present = known.iter().filter(|warning| warning.cause.is_some_and(|name| self.faults.has(name)));
        let right = present.fold(M::warnings(self), |bits, warning| bits | warning.bit);
        self.ram.had_warning |= right != 0;
        self.ram.warnings = self.deviations.hooks.apply(right, |hooks, right| hooks.warnings(&self.view(), right));
    }

    /// Whether diagnoses are reported: always, except in compatibility mode without alarm channel (XAC77 manual,
    /// 11.4).
    pub fn reports_diagnoses(&self) -> bool {
        let (compatible, is_on) = (self.ram.user.compatible, self.ram.user.alarm_channel);
        self.deviations.checks.check(EncoderCheck::AlarmChannel { compatible, is_on }, !compatible || is_on)
    }

    /// ChannelErrorType and severity of the errors and warnings that have a diagnosis.
    fn diagnoses(&self) -> Vec<(u16, DiagnosisSeverity)> {
        let bits = self.warnings();
        if bits == 0 && self.ram.sensor.errors().is_empty() {
            return Vec::new();
        }
        let errors = self.errors().into_iter().map(|error| (error.error_type, error.severity));
        let warnings = self.facts.warnings.iter().filter(|warning| bits & warning.bit != 0);
        let all = errors.chain(warnings.map(|warning| (warning.error_type, warning.severity)));
        all.filter_map(|(error_type, severity)| Some((error_type?, severity))).collect()
    }

    /// The reported diagnoses, after the hooks.
    pub fn hooked_diagnoses(&self, diagnoses: Vec<(u16, DiagnosisSeverity)>) -> Vec<(u16, DiagnosisSeverity)> {
        self.deviations.hooks.apply(diagnoses, |hooks, diagnoses| hooks.diagnoses(&self.view(), diagnoses))
    }

    /// Updates the diagnoses from errors and warnings and queues the changes.
    pub(super) fn diagnose(&mut self) {
        let diagnoses = if self.reports_diagnoses() { self.diagnoses() } else { Vec::new() };
        let diagnoses = self.hooked_diagnoses(diagnoses);
        let (known, changes) = (&mut self.ram.diagnoses, &mut self.ram.changes);
        known.iter().filter(|old| !diagnoses.contains(old)).for_each(|old| changes.push_back(change(*old, false)));
        known.retain(|old| diagnoses.contains(old));
        for new in diagnoses {
            if !known.contains(&new) {
                known.push(new);
                changes.push_back(change(new, true));
            }
        }
    }
}

fn change((error_type, severity): (u16, DiagnosisSeverity), appears: bool) -> DiagnosisChange {
    let diagnosis = SubmoduleDiagnosis {
        api: ENCODER_API,
        slot: ENCODER_SLOT,
        subslot: ACCESS_POINT_SUBSLOT,
        channel: WHOLE_SUBMODULE,
        error_type,
        extended: None,
        severity,
    };
    DiagnosisChange { appears, diagnosis }
}
