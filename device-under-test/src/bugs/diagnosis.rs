//! Bugs of faults, diagnoses and alarms.

use super::Bug;
use crate::application::Severity;
use crate::behaviour::View;
use wire::profinet::alarm::AlarmNotification;
use wire::profinet::diagnosis::AlarmItem;

/// Fault bits in P65001: memory and commissioning.
const MEMORY: u64 = 1 << 5;
const COMMISSIONING: u64 = 1 << 4;

/// The bugs of this seam.
pub static BUGS: &[Bug] = bugs! {
    // Faults in P65001
    "fault-bits-exchanged" "Memory and commissioning change places in P65001."
        => |b| b.values.element = fault_bits_exchanged;
    "faults-never-set" "The faults in P65001 are always 0."
        => |b| b.values.element = |_, at, right| if at == (65001, 2) { 0 } else { right };
    "faults-show-supported" "The faults in P65001 are those that are supported."
        => |b| b.values.element =
            |_, at, right| if at == (65001, 2) { MEMORY | COMMISSIONING } else { right };

    // Alarms
    "one-error-type-for-all" "Every fault is reported with the error type of wrong user parameters."
        => |b| b.diagnosis.error_type = |_| Some(0x9011);
    "no-alarm-for-parameters" "Wrong user parameters are not reported over the alarm channel."
        => |b| b.diagnosis.error_type = |right| Some(right).filter(|right| *right != 0x9011);
    "one-alarm-for-all" "A second fault replaces the first one in the alarm channel."
        => |b| b.diagnosis.side_by_side = false;
    "alarm-never-disappears" "A channel diagnosis stays when its fault has gone."
        => |b| b.diagnosis.disappear = false;
    "alarm-switch-in-v41-mode" "Alarm channel control acts without compatibility mode too."
        => |b| b.diagnosis.are_sent = |_, alarm_channel| alarm_channel;
    "alarm-switch-inverted" "Alarm channel control has the opposite polarity: 1 is off."
        => |b| b.diagnosis.are_sent = |compatible, alarm_channel| !compatible || !alarm_channel;
    "alarm-switch-ignored" "Alarm channel control is not looked at: faults are always reported."
        => |b| b.diagnosis.are_sent = |_, _| true;
    "diagnosis-as-manufacturer-data" "Alarms carry data of the vendor in place of a channel diagnosis."
        => |b| b.stack.alarm = diagnosis_as_manufacturer_data;
    "alarms-block-inputs" "The inputs are bad while an alarm waits for its acknowledgement."
        => |b| b.stack.sends_inputs_during_alarm = false;
    "diagnosis-record-empty" "The records of diagnosis are empty while a diagnosis is pending."
        => |b| b.stack.tells_diagnoses = false;
    "fault-reported-as-maintenance" "A fault is reported as a need for maintenance."
        => |b| b.diagnosis.severity = |_, _| Severity::MaintenanceRequired;
};

fn diagnosis_as_manufacturer_data(alarm: &mut AlarmNotification) {
    for item in &mut alarm.items {
        if let AlarmItem::Channel(diagnoses) = item {
            let data = diagnoses.iter().flat_map(|diagnosis| diagnosis.error_type.0.to_be_bytes()).collect();
            *item = AlarmItem::Other { identifier: 1, data };
        }
    }
}

fn fault_bits_exchanged(_: &View<'_>, at: (u16, usize), right: u64) -> u64 {
    if at == (65001, 2) { right << 1 & MEMORY | right >> 1 & COMMISSIONING } else { right }
}
