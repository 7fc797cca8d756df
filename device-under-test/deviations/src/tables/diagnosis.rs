//! Bugs of faults, diagnoses and alarms.

use super::Deviation;
use super::image::{ERROR, POSITION, has_error};
use core::time::Duration;
use device_stack::profinet::Severity;
use encoder_profile::hooks::View;
use encoder_profile::profidrive::telegram::{Before, Image};
use wire::profinet::alarm::AlarmNotification;
use wire::profinet::diagnosis::AlarmItem;

/// Fault bits in P65001: memory and commissioning.
const MEMORY: u64 = 1 << 5;
const COMMISSIONING: u64 = 1 << 4;

/// The bugs of this seam.
pub static BUGS: &[Deviation] = bugs! {
    // Faults in P65001
    "fault-bits-exchanged" "Memory and commissioning change places in P65001."
        => |b| b.at_encoder.element(fault_bits_exchanged);
    "faults-never-set" "The faults in P65001 are always 0."
        => |b| b.at_encoder.element(|_, at, right| if at == (65001, 2) { 0 } else { right });
    "faults-show-supported" "The faults in P65001 are those that are supported."
        => |b| b.at_encoder.element(|view, at, right| if at == (65001, 2) { view.facts.supported_faults.into() } else { right });

    // Alarms
    "one-error-type-for-all" "Every fault is reported with the error type of wrong user parameters."
        => |b| b.encoder.diagnosis.error_type = |_| Some(0x9011);
    "no-alarm-for-parameters" "Wrong user parameters are not reported over the alarm channel."
        => |b| b.encoder.diagnosis.error_type = |right| Some(right).filter(|right| *right != 0x9011);
    "one-alarm-for-all" "A second fault replaces the first one in the alarm channel."
        => |b| b.encoder.diagnosis.side_by_side = false;
    "alarm-never-disappears" "A channel diagnosis stays when its fault has gone."
        => |b| b.encoder.diagnosis.disappear = false;
    "alarm-switch-in-v41-mode" "Alarm channel control acts without compatibility mode too."
        => |b| b.encoder.diagnosis.are_sent = |_, alarm_channel| alarm_channel;
    "alarm-switch-inverted" "Alarm channel control has the opposite polarity: 1 is off."
        => |b| b.encoder.diagnosis.are_sent = |compatible, alarm_channel| !compatible || !alarm_channel;
    "alarm-switch-ignored" "Alarm channel control is not looked at: faults are always reported."
        => |b| b.encoder.diagnosis.are_sent = |_, _| true;
    "diagnosis-as-manufacturer-data" "Alarms carry data of the vendor in place of a channel diagnosis."
        => |b| b.stack.alarm = diagnosis_as_manufacturer_data;
    "alarms-block-inputs" "The inputs are bad while an alarm waits for its acknowledgement."
        => |b| b.stack.sends_inputs_during_alarm = false;
    "diagnosis-record-empty" "The records of diagnosis are empty while a diagnosis is pending."
        => |b| b.stack.tells_diagnoses = false;
    "fault-reported-as-maintenance" "A fault is reported as a need for maintenance."
        => |b| b.encoder.diagnosis.severity = |_, _| Severity::MaintenanceRequired;
};

/// The bugs of this seam that not all manuals have.
pub static OTHERS: &[Deviation] = encoder_bugs! {
    // Errors
    "position-error-not-shown" "A sensor without valid data is no error; the position stands still."
        => |b| b.sensor.raises = |code| code != 0x0001;
    "memory-code-of-the-profile" "A memory error has the code 1001h of the encoder profile."
        => |b| b.at_encoder.image(|_, now| Image { g1_xist2: if has_error(&now) && now.g1_xist2 == 0x20 { 0x1001 } else { now.g1_xist2 }, ..now });
    "memory-error-not-cyclic" "A memory error is shown in the status only."
        => |b| b.at_encoder.image(memory_error_not_cyclic);
    "code-in-the-position-of-mantel860" "While there is an error its code stands in place of the position alone."
        => |b| b.at_encoder.image(|_, now| Image { plain_position: if has_error(&now) { now.g1_xist2 } else { now.plain_position }, ..now });
    "errors-latched-for-ever" "An error stays when its cause has gone."
        => |b| b.sensor.latches = true;

    // Faults and warnings in the status
    "supported-faults-are-the-present" "The supported faults are those that are there."
        => |b| b.at_encoder.element(|view, at, right| if at == (65001, 3) { view.faults.into() } else { right });
    "warnings-show-supported" "The warnings are those that are supported."
        => |b| b.at_encoder.element(|view, at, right| if at == (65001, 4) { view.facts.supported_warnings.into() } else { right });
    "supported-warnings-5" "The second warning is not among those that are supported."
        => |b| b.at_encoder.element(|_, at, right| if at == (65001, 5) { right & !2 } else { right });
    "one-warning-only" "Of several warnings only the lowest bit is set."
        => |b| b.diagnosis.warnings = |_, right| right & right.wrapping_neg();
    "warnings-latched" "A warning stays when its cause has gone, until the next connection."
        => |b| b.diagnosis.warnings = |before, right| before | right;
    "warning-shown-as-error" "A warning raises the error of the position as well."
        => |b| b.diagnosis.warning_is_error = true;
    "speed-limit-included" "A speed of 9000 rpm is a warning already."
        => |b| b.diagnosis.is_too_fast = |rpm, _| rpm.abs() >= 9000;
    "speed-limit-at-8192" "The warning of speed begins above 8192 rpm."
        => |b| b.diagnosis.is_too_fast = |rpm, _| rpm.abs() > 8192;
    "speed-warning-forward-only" "A speed against the clock is never a warning."
        => |b| b.diagnosis.is_too_fast = |rpm, right| right && rpm > 0;

    // Alarms
    "alarm-storm" "While there is an error a diagnosis alarm is sent every 100 ms."
        => |b| (b.diagnosis.without_type, b.diagnosis.repeats_after) = (Some(0x9000), Some(Duration::from_millis(100)));
    "alarm-channel-works" "With the bit of the alarm channel a fault is reported over it."
        => |b| (b.diagnosis.without_type, b.diagnosis.are_sent) = (Some(0x9000), |_, alarm_channel| alarm_channel);
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

fn memory_error_not_cyclic(_: &Before, now: Image) -> Image {
    match has_error(&now) && now.g1_xist2 == 0x20 {
        true => Image {
            zsw2_enc: now.zsw2_enc & !0x0008,
            g1_zsw: now.g1_zsw & !ERROR | POSITION,
            g1_xist2: now.position as u32,
            ..now
        },
        false => now,
    }
}
