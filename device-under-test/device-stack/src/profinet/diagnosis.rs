//! Pending diagnoses, and how alarms and records report them.

use super::plugged::{PluggedConfiguration, RecordScope, SubmoduleAddress};
use crate::profinet::{DiagnosisChange, DiagnosisSeverity, SubmoduleDiagnosis};
use alloc::vec::Vec;
use wire::profinet::alarm::{AlarmNotification, AlarmPriority, AlarmSpecifier, AlarmType};
use wire::profinet::diagnosis::{
    self, AlarmItem, ChannelChange, ChannelDiagnosis, ChannelErrorType, ChannelProperties, DiagnosisData,
    ExtChannelDiagnosis,
};

/// The diagnoses that are pending, oldest first.
#[derive(Debug, Default)]
pub(super) struct PendingDiagnoses {
    pending: Vec<SubmoduleDiagnosis>,
}

fn submodule_address(diagnosis: &SubmoduleDiagnosis) -> SubmoduleAddress {
    SubmoduleAddress { api: diagnosis.api, slot: diagnosis.slot, subslot: diagnosis.subslot }
}

fn is_same_diagnosis(one: &SubmoduleDiagnosis, other: &SubmoduleDiagnosis) -> bool {
    (submodule_address(one), one.channel, one.error_type, one.extended.map(|detail| detail.0))
        == (submodule_address(other), other.channel, other.error_type, other.extended.map(|detail| detail.0))
}

fn properties(diagnosis: &SubmoduleDiagnosis, change: ChannelChange) -> ChannelProperties {
    let severity = match diagnosis.severity {
        DiagnosisSeverity::Fault => diagnosis::MaintenanceSeverity::Diagnosis,
        DiagnosisSeverity::MaintenanceDemanded => diagnosis::MaintenanceSeverity::MaintenanceDemanded,
        DiagnosisSeverity::MaintenanceRequired => diagnosis::MaintenanceSeverity::MaintenanceRequired,
    };
    ChannelProperties::new(severity, change)
}

fn item(diagnosis: &SubmoduleDiagnosis, change: ChannelChange) -> AlarmItem {
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

impl PendingDiagnoses {
    /// Adds or removes the diagnosis of a change.
    pub(super) fn note(&mut self, change: &DiagnosisChange) {
        self.pending.retain(|pending| !is_same_diagnosis(pending, &change.diagnosis));
        if change.appears {
            self.pending.push(change.diagnosis);
        }
    }

    /// The pending diagnoses in `scope`.
    pub(super) fn pending(&self, scope: RecordScope<'_>) -> impl Iterator<Item = &SubmoduleDiagnosis> {
        self.pending.iter().filter(move |diagnosis| scope.contains(submodule_address(diagnosis)))
    }

    /// Whether a fault is pending in `scope`.
    pub(super) fn has_fault(&self, scope: RecordScope<'_>) -> bool {
        self.pending(scope).any(|diagnosis| diagnosis.severity == DiagnosisSeverity::Fault)
    }

    /// The alarm for `change`, which must already be noted. `None` if nothing is plugged at the address or
    /// `connection` does not contain it.
    pub(super) fn alarm(
        &self,
        change: &DiagnosisChange,
        connection: RecordScope<'_>,
        plugged: &PluggedConfiguration,
    ) -> Option<AlarmNotification> {
        let diagnosis = &change.diagnosis;
        let subslot = RecordScope::Subslot(submodule_address(diagnosis));
        let plug =
            plugged.at(submodule_address(diagnosis)).filter(|_| connection.contains(submodule_address(diagnosis)))?;
        let others = self
            .pending(subslot)
            .any(|other| other.channel == diagnosis.channel && !is_same_diagnosis(other, diagnosis));
        let (alarm_type, change) = match (change.appears, others) {
            (true, _) => (AlarmType::DIAGNOSIS, ChannelChange::Appears),
            (false, true) => (AlarmType::DIAGNOSIS_DISAPPEARS, ChannelChange::DisappearsOthersRemain),
            (false, false) => (AlarmType::DIAGNOSIS_DISAPPEARS, ChannelChange::Disappears),
        };
        let mut maintenance = 0;
        for pending in self.pending(subslot) {
            maintenance |= match pending.severity {
                DiagnosisSeverity::Fault => 0,
                DiagnosisSeverity::MaintenanceRequired => 1,
                DiagnosisSeverity::MaintenanceDemanded => 2,
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
    pub(super) fn write(&self, scope: RecordScope<'_>, with_maintenance: bool, out: &mut Vec<u8>) {
        let is_reported =
            |diagnosis: &&SubmoduleDiagnosis| with_maintenance || diagnosis.severity == DiagnosisSeverity::Fault;
        for diagnosis in self.pending(scope).filter(is_reported) {
            let block = DiagnosisData {
                api: Some(diagnosis.api),
                slot: diagnosis.slot,
                subslot: diagnosis.subslot,
                channel: ChannelDiagnosis::WHOLE_SUBMODULE,
                properties: properties(diagnosis, ChannelChange::Appears),
                item: item(diagnosis, ChannelChange::Appears),
            };
            block.write(out);
        }
    }
}
