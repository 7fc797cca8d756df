//! What is wrong, and what of it goes into the alarm channel.

use super::Live;
use crate::application::{Diagnosis, DiagnosisChange, Severity};
use crate::models::lika_xac77::parameters::{COMMISSIONING, MEMORY};
use crate::models::lika_xac77::{ACCESS_POINT_SUBSLOT, ENCODER_API, ENCODER_SLOT};
use alloc::vec::Vec;

/// Error code of the sign of life.
const LIFE_SIGN: u16 = 0x0F02;
/// Error code of a lost reading: that of the profile for the sensor, for the manual names none.
pub const SENSOR: u16 = 0x0001;
/// Channel of a diagnosis that concerns the submodule as a whole.
const WHOLE_SUBMODULE: u16 = 0x8000;

impl Live<'_> {
    /// The error codes whose cause is there now.
    pub fn causes(&self) -> Vec<u16> {
        let is_noticed = self.behaviour.memory.reports_unreadable || !self.ram.was_unreadable;
        let is_empty = self.behaviour.memory.reports_empty && self.store.is_empty();
        let causes = [
            (self.ram.watch.has_failed(), LIFE_SIGN),
            (self.faults.memory && is_noticed || is_empty, MEMORY.0),
            (self.faults.sensor, SENSOR),
            (self.faults.commissioning || self.ram.wrong_parameters, COMMISSIONING.0),
        ];
        causes.iter().filter(|(is_there, _)| *is_there).map(|(_, code)| *code).collect()
    }

    /// Brings the diagnoses in line with the errors. Error types: manual, 12.2.1.
    pub(super) fn diagnose(&mut self) {
        let rules = &self.behaviour.diagnosis;
        let error_type = |code: &u16| match *code {
            code if code == MEMORY.0 => Some(0x9000),
            code if code == COMMISSIONING.0 => Some(0x9011),
            _ => None,
        };
        let errors = self.ram.sensor.errors().iter();
        let mut wanted: Vec<u16> = errors.filter_map(error_type).filter_map(rules.error_type).collect();
        if !(rules.are_sent)(self.ram.user.compatible, self.ram.user.alarm_channel) {
            wanted.clear();
        }
        if !rules.side_by_side {
            wanted.drain(..wanted.len().saturating_sub(1));
        }
        let gone = |error_type: &u16| rules.disappear && !wanted.contains(error_type);
        let change = |error_type, appears| change(error_type, appears, rules.severity);
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

fn change(error_type: u16, appears: bool, severity: Severity) -> DiagnosisChange {
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
