//! Pending diagnoses, and how alarms and records report them.

use super::plugged::{Place, Plugged, Scope};
use crate::profinet::{Diagnosis, DiagnosisChange, Severity};
use alloc::vec::Vec;
use wire::profinet::alarm::{AlarmNotification, AlarmPriority, AlarmSpecifier, AlarmType};
use wire::profinet::diagnosis::{
    self, AlarmItem, Change, ChannelDiagnosis, ChannelErrorType, ChannelProperties, DiagnosisData, ExtChannelDiagnosis,
};

/// The diagnoses that are pending, oldest first.
#[derive(Debug, Default)]
pub(super) struct Diagnoses {
    pending: Vec<Diagnosis>,
}

fn place(diagnosis: &Diagnosis) -> Place {
    Place { api: diagnosis.api, slot: diagnosis.slot, subslot: diagnosis.subslot }
}

fn same(one: &Diagnosis, other: &Diagnosis) -> bool {
    (place(one), one.channel, one.error_type, one.extended.map(|detail| detail.0))
        == (place(other), other.channel, other.error_type, other.extended.map(|detail| detail.0))
}

fn properties(diagnosis: &Diagnosis, change: Change) -> ChannelProperties {
    let severity = match diagnosis.severity {
        Severity::Fault => diagnosis::Severity::Diagnosis,
        Severity::MaintenanceDemanded => diagnosis::Severity::MaintenanceDemanded,
        Severity::MaintenanceRequired => diagnosis::Severity::MaintenanceRequired,
    };
    ChannelProperties::new(severity, change)
}

fn item(diagnosis: &Diagnosis, change: Change) -> AlarmItem {
    let channel = ChannelDiagnosis {
        channel: diagnosis.channel,
        properties: properties(diagnosis, change),
        error_type: ChannelErrorType(diagnosis.error_type),
    };
    match diagnosis.extended {
        None => AlarmItem::Channel([channel].into()),
        Some((ext_error_type, add_value)) => {
            AlarmItem::ExtChannel([ExtChannelDiagnosis { channel, ext_error_type, add_value }].into())
        }
    }
}

impl Diagnoses {
    /// Adds or removes the diagnosis of a change.
    pub(super) fn note(&mut self, change: &DiagnosisChange) {
        self.pending.retain(|pending| !same(pending, &change.diagnosis));
        if change.appears {
            self.pending.push(change.diagnosis);
        }
    }

    /// The pending diagnoses in `scope`.
    pub(super) fn pending(&self, scope: Scope<'_>) -> impl Iterator<Item = &Diagnosis> {
        self.pending.iter().filter(move |diagnosis| scope.contains(place(diagnosis)))
    }

    /// Whether a fault is pending in `scope`.
    pub(super) fn has_fault(&self, scope: Scope<'_>) -> bool {
        self.pending(scope).any(|diagnosis| diagnosis.severity == Severity::Fault)
    }

    /// The alarm for `change`, which must already be noted. `None` if nothing is plugged at the address or
    /// `connection` does not contain it.
    pub(super) fn alarm(
        &self,
        change: &DiagnosisChange,
        connection: Scope<'_>,
        plugged: &Plugged,
    ) -> Option<AlarmNotification> {
        let diagnosis = &change.diagnosis;
        let subslot = Scope::Subslot(place(diagnosis));
        let plug = plugged.at(place(diagnosis)).filter(|_| connection.contains(place(diagnosis)))?;
        let others = self.pending(subslot).any(|other| other.channel == diagnosis.channel && !same(other, diagnosis));
        let (alarm_type, change) = match (change.appears, others) {
            (true, _) => (AlarmType::DIAGNOSIS, Change::Appears),
            (false, true) => (AlarmType::DIAGNOSIS_DISAPPEARS, Change::DisappearsOthersRemain),
            (false, false) => (AlarmType::DIAGNOSIS_DISAPPEARS, Change::Disappears),
        };
        let mut maintenance = 0;
        for pending in self.pending(subslot) {
            maintenance |= match pending.severity {
                Severity::Fault => 0,
                Severity::MaintenanceRequired => 1,
                Severity::MaintenanceDemanded => 2,
            };
        }
        let mut flags = 0;
        for (is_set, flag) in [
            (self.pending(subslot).next().is_some(), AlarmSpecifier::CHANNEL_DIAGNOSIS),
            (self.has_fault(subslot), AlarmSpecifier::SUBMODULE_DIAGNOSIS_STATE),
            (self.has_fault(connection), AlarmSpecifier::AR_DIAGNOSIS_STATE),
        ] {
            flags |= if is_set { flag } else { 0 };
        }
        let maintenance = (maintenance != 0).then_some(AlarmItem::Maintenance(maintenance));
        Some(AlarmNotification {
            priority: AlarmPriority::Low,
            alarm_type,
            api: diagnosis.api,
            slot: diagnosis.slot,
            subslot: diagnosis.subslot,
            module_ident: plug.module_ident,
            submodule_ident: plug.submodule_ident,
            specifier: AlarmSpecifier::new(0, flags),
            items: maintenance.into_iter().chain([item(diagnosis, change)]).collect(),
        })
    }

    /// Appends the blocks of a diagnosis record about `scope`. Without `with_maintenance` it contains faults only.
    pub(super) fn write(&self, scope: Scope<'_>, with_maintenance: bool, out: &mut Vec<u8>) {
        let is_reported = |diagnosis: &&Diagnosis| with_maintenance || diagnosis.severity == Severity::Fault;
        for diagnosis in self.pending(scope).filter(is_reported) {
            let block = DiagnosisData {
                api: Some(diagnosis.api),
                slot: diagnosis.slot,
                subslot: diagnosis.subslot,
                channel: ChannelDiagnosis::WHOLE_SUBMODULE,
                properties: properties(diagnosis, Change::Appears),
                item: item(diagnosis, Change::Appears),
            };
            block.write(out);
        }
    }
}
