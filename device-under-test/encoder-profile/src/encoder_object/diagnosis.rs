//! What is wrong, and what of it goes into the alarm channel.

use super::places::{ACCESS_POINT_SUBSLOT, ENCODER_API, ENCODER_SLOT};
use super::{Live, Model};
use crate::facts::{Cause, Effect, ErrorFact, Facts};
use crate::profidrive::sensor::Error;
use alloc::vec::Vec;
use device_stack::profinet::{Diagnosis, DiagnosisChange, Severity};

/// Channel of a diagnosis that concerns the submodule as a whole.
const WHOLE_SUBMODULE: u16 = 0x8000;

/// An error that may be there without a fault of the stand.
#[derive(Clone, Copy)]
pub(super) struct Unprovoked {
    /// Its place in the facts.
    number: usize,
    /// What brings it about by itself.
    causes: OwnCauses,
}

/// What of the causes of an error is no fault of the stand.
#[derive(Clone, Copy)]
struct OwnCauses {
    has_life_sign: bool,
    has_wrong_parameters: bool,
    has_model: bool,
}

impl OwnCauses {
    fn of(error: &ErrorFact) -> OwnCauses {
        OwnCauses {
            has_life_sign: error.causes.contains(&Cause::LifeSign),
            has_wrong_parameters: error.causes.contains(&Cause::WrongParameters),
            has_model: error.causes.contains(&Cause::Model),
        }
    }

    fn are_none(self) -> bool {
        !(self.has_life_sign || self.has_wrong_parameters || self.has_model)
    }
}

/// The errors that may be there without a fault of the stand; the first one may stand for a warning.
pub(super) fn without_fault(facts: &Facts) -> Vec<Unprovoked> {
    let known = facts.errors.iter().enumerate();
    let known = known.map(|(number, error)| Unprovoked { number, causes: OwnCauses::of(error) });
    let may_be = |one: &Unprovoked| {
        one.number == 0 || facts.errors[one.number].effect == Effect::NoMemory || !one.causes.are_none()
    };
    known.filter(may_be).collect()
}

impl<M: Model> Live<'_, M> {
    /// The errors whose cause is there now; their numbers are their places in the facts.
    pub fn causes(&self) -> Vec<Error> {
        let rules = &self.behaviour.diagnosis;
        let is_warning = rules.warning_is_error && self.ram.warnings != 0;
        let raised = |number: usize, causes: OwnCauses| {
            let error = &self.facts.errors[number];
            let is_there = self.is_caused(error, causes) || number == 0 && is_warning;
            let is_raised = is_there && (rules.raises)(error);
            is_raised.then(|| Error { number: number as u16, code: (rules.code)(error) })
        };
        match self.faults.are_none() {
            true => self.ram.without_fault.iter().filter_map(|one| raised(one.number, one.causes)).collect(),
            false => {
                let known = self.facts.errors.iter().enumerate();
                known.filter_map(|(number, error)| raised(number, OwnCauses::of(error))).collect()
            }
        }
    }

    fn is_caused(&self, error: &ErrorFact, causes: OwnCauses) -> bool {
        let memory = &self.behaviour.memory;
        let by_itself = causes.has_life_sign && self.ram.watch.has_failed()
            || causes.has_wrong_parameters && self.ram.wrong_parameters
            || causes.has_model && M::is_caused(self, error);
        match error.effect {
            Effect::NoMemory => {
                let is_unnoticed = !memory.reports_unreadable && self.ram.was_unreadable;
                self.faults.cause(error) && !is_unnoticed || memory.reports_empty && self.store.is_empty() || by_itself
            }
            Effect::Nothing | Effect::NoReading => self.faults.cause(error) || by_itself,
        }
    }

    /// The errors that are there, oldest first, as far as the manual knows them.
    pub fn errors(&self) -> Vec<&'static ErrorFact> {
        if self.ram.sensor.errors().is_empty() {
            return Vec::new();
        }
        let known = |error: &Error| {
            let code = self.behaviour.diagnosis.code;
            let there = self.facts.errors.get(usize::from(error.number));
            let there = there.filter(|fact| fact.code == error.code || code(fact) == error.code);
            there.or_else(|| self.facts.errors.iter().find(|fact| fact.code.is_some() && fact.code == error.code))
        };
        self.ram.sensor.errors().iter().filter_map(known).collect()
    }

    /// The fault bits of the errors that are there.
    pub fn fault_bits(&self) -> u32 {
        match self.ram.sensor.errors().is_empty() {
            true => 0,
            false => self.errors().iter().fold(0, |bits, error| bits | error.fault_bits),
        }
    }

    /// The bits of the warnings that are there.
    pub fn warnings(&self) -> u32 {
        self.ram.warnings
    }

    /// Looks which warnings there are.
    pub(super) fn look_for_warnings(&mut self) {
        let known = if self.faults.are_none() { &[] } else { self.facts.warnings };
        let here = known.iter().filter(|warning| warning.cause.is_some_and(|name| self.faults.has(name)));
        let right = here.fold(M::warnings(self), |bits, warning| bits | warning.bit);
        self.ram.had_warning |= right != 0;
        self.ram.warnings = (self.behaviour.diagnosis.warnings)(self.ram.warnings, right);
    }

    /// Error type and severity of what should be told.
    fn wanted(&self) -> Vec<(u16, Severity)> {
        let (rules, bits) = (&self.behaviour.diagnosis, self.warnings());
        if bits == 0 && self.ram.sensor.errors().is_empty() {
            return Vec::new();
        }
        let errors = self.errors().into_iter().map(|error| (error.error_type, error.severity));
        let warnings = self.facts.warnings.iter().filter(|warning| bits & warning.bit != 0);
        let all = errors.chain(warnings.map(|warning| (warning.error_type, warning.severity)));
        let told = all.filter_map(|(error_type, severity)| {
            Some(((rules.error_type)(error_type.or(rules.without_type)?)?, severity))
        });
        told.map(|(error_type, severity)| (error_type, (rules.severity)(error_type, severity))).collect()
    }

    /// Brings the diagnoses in line with errors and warnings.
    pub(super) fn diagnose(&mut self) {
        let rules = &self.behaviour.diagnosis;
        let mut wanted = self.wanted();
        if wanted.is_empty() && self.ram.diagnoses.is_empty() {
            return;
        }
        if !(rules.are_sent)(self.ram.user.compatible, self.ram.user.alarm_channel) {
            wanted.clear();
        }
        if let Some(after) = rules.repeats_after
            && !wanted.is_empty()
            && self.now >= self.ram.told_at + after
        {
            self.ram.told_at = self.now;
            self.ram.diagnoses.clear();
        }
        if !rules.side_by_side {
            wanted.drain(..wanted.len().saturating_sub(1));
        }
        let gone = |known: &(u16, Severity)| rules.disappear && !wanted.contains(known);
        let changes = &mut self.ram.changes;
        self.ram
            .diagnoses
            .iter()
            .filter(|known| gone(known))
            .for_each(|known| changes.push_back(change(*known, false)));
        self.ram.diagnoses.retain(|known| !gone(known));
        for new in wanted {
            if !self.ram.diagnoses.contains(&new) {
                self.ram.diagnoses.push(new);
                self.ram.changes.push_back(change(new, true));
            }
        }
    }
}

fn change((error_type, severity): (u16, Severity), appears: bool) -> DiagnosisChange {
    let diagnosis = Diagnosis {
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
