//! Bugs of faults, diagnoses and alarms.

use super::Group;
use super::connection_state::AlarmsBlockInputs;
use super::diagnosis_state::{AlarmStorm, StayingDiagnoses, StayingWarnings, with_error_type};
use super::signal_image::{ERROR, POSITION, has_error};
use crate::needs::Need;
use alloc::vec::Vec;
use device_stack::profinet::DiagnosisSeverity;
use encoder_profile::checks::EncoderCheck;
use encoder_profile::hooks::EncoderView;
use encoder_profile::profidrive::sensor::SensorError;
use encoder_profile::profidrive::telegram::{PreviousCycle, SignalImage};
use reference_devices::manuals;
use wire::profinet::alarm::AlarmNotification;
use wire::profinet::diagnosis::AlarmItem;

/// Fault bit of the memory in P65001.
const MEMORY: u64 = 1 << 5;
/// Fault bit of the commissioning in P65001.
const COMMISSIONING: u64 = 1 << 4;

/// The bugs, by what they need.
pub static GROUPS: &[Group] = &[
    // Faults in P65001
    Group {
        needs: &[Need::EncoderProfile],
        deviations: bugs! {
            "faults-never-set" "The faults in P65001 are always 0."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 2) { 0 } else { right });
            "faults-show-supported" "The faults in P65001 are equal to the supported faults."
                => |d| d.encoder.element(|view, at, right| if at == (65001, 2) { view.facts.supported_faults.into() } else { right });
            "supported-faults-are-the-present" "The supported faults in P65001 are equal to the present faults."
                => |d| d.encoder.element(|view, at, right| if at == (65001, 3) { view.faults.into() } else { right });
        },
    },
    // Fault bits of memory and commissioning
    Group {
        needs: &[Need::Of(&manuals::LIKA_XAC77)],
        deviations: bugs! {
            "fault-bits-exchanged" "The fault bits of memory and commissioning are swapped in P65001."
                => |d| d.encoder.element(fault_bits_exchanged);
            "one-error-type-for-all" "Every fault is reported with the error type of invalid user parameters."
                => |d| d.encoder.error_type(|_| Some(0x9011));
            "no-alarm-for-parameters" "Invalid user parameters are not reported over the alarm channel."
                => |d| d.encoder.error_type(|right| Some(right).filter(|right| *right != 0x9011));
        },
    },
    // Diagnoses in the alarm channel
    Group {
        needs: &[Need::Diagnosis],
        deviations: bugs! {
            "one-alarm-for-all" "A second fault replaces the first one in the alarm channel."
                => |d| d.encoder.diagnoses(|_, all| all.into_iter().next_back().into_iter().collect());
            "alarm-never-disappears" "A channel diagnosis stays after its fault has disappeared."
                => |d| d.encoder.add(StayingDiagnoses::default());
            "alarm-switch-in-v41-mode" "Alarm channel control has an effect even without compatibility mode."
                => |d| d.checks.check(|check, right| match check { EncoderCheck::AlarmChannel { is_on, .. } => is_on, _ => right });
            "alarm-switch-inverted" "Alarm channel control has the inverse polarity: 1 is off."
                => |d| d.checks.check(|check, right| match check { EncoderCheck::AlarmChannel { compatible, is_on } => !compatible || !is_on, _ => right });
            "alarm-switch-ignored" "Alarm channel control is ignored: faults are always reported."
                => |d| d.checks.check(|check, right| right || matches!(check, EncoderCheck::AlarmChannel { .. }));
            "diagnosis-as-manufacturer-data" "Alarms carry manufacturer data instead of a channel diagnosis."
                => |d| d.stack.alarm(|alarm, is_sent| {
                    diagnosis_as_manufacturer_data(alarm);
                    is_sent
                });
            "alarms-block-inputs" "The inputs are bad while an alarm waits for its acknowledgement."
                => |d| d.stack.add(AlarmsBlockInputs::default());
            "diagnosis-record-empty" "The diagnosis records are empty while a diagnosis is pending."
                => |d| d.stack.record(|index, data| if is_diagnosis(index) { data.clear() });
            "fault-reported-as-maintenance" "A fault is reported as maintenance required."
                => |d| d.encoder.diagnoses(|_, all| all.into_iter().map(|(error_type, _)| (error_type, DiagnosisSeverity::MaintenanceRequired)).collect());
        },
    },
    // Errors and codes of the Sendix, which reports no diagnosis
    Group {
        needs: &[Need::Of(&manuals::KUEBLER_SENDIX58XX)],
        deviations: bugs! {
            "position-error-not-shown" "A sensor without valid data raises no error; the position is frozen."
                => |d| d.checks.check(|check, right| match check {
                    EncoderCheck::RaisesError { code: Some(0x0001), .. } => false,
                    _ => right,
                });
            "memory-code-of-the-profile" "A memory error has the code 1001h of the encoder profile."
                => |d| d.encoder.signals(|_, now| SignalImage { g1_xist2: if has_error(&now) && now.g1_xist2 == 0x20 { 0x1001 } else { now.g1_xist2 }, ..now });
            "memory-error-not-cyclic" "A memory error is shown only in the operating status."
                => |d| d.encoder.signals(memory_error_not_cyclic);
            "code-in-the-position-of-mantel860" "While there is an error, the plain position is replaced by the error code."
                => |d| d.encoder.signals(|_, now| SignalImage { plain_position: if has_error(&now) { now.g1_xist2 } else { now.plain_position }, ..now });
            "errors-latched-for-ever" "An error stays after its cause has disappeared, even after power-off."
                => |d| d.encoder.causes({
                    let mut ever: Vec<SensorError> = Vec::new();
                    move |_, all| {
                        let others: Vec<_> = all.into_iter().filter(|error| !ever.contains(error)).collect();
                        ever.extend(others.iter().filter(|error| error.code != Some(0x1002)));
                        let of_now = others.into_iter().filter(|error| error.code == Some(0x1002));
                        ever.iter().copied().chain(of_now).collect()
                    }
                });
            "supported-warnings-5" "The second warning is not announced as supported."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 5) { right & !2 } else { right });
            "alarm-storm" "While there is an error a diagnosis alarm is sent every 100 ms."
                => |d| d.encoder.add(AlarmStorm::default());
            "alarm-channel-works" "With the alarm channel bit set, faults are reported over the alarm channel."
                => |d| d.encoder.diagnoses(|view, right| if view.user.alarm_channel { with_error_type(view) } else { right });
        },
    },
    // Warnings
    Group {
        needs: &[Need::Warning],
        deviations: bugs! {
            "warnings-show-supported" "The warnings are equal to the supported warnings."
                => |d| d.encoder.element(|view, at, right| if at == (65001, 4) { view.facts.supported_warnings.into() } else { right });
            "one-warning-only" "Of several warnings only the one with the lowest bit is set."
                => |d| d.encoder.warnings(|_, right| right & right.wrapping_neg());
            "warnings-latched" "A warning stays after its cause has disappeared, until the next connection."
                => |d| d.encoder.add(StayingWarnings::default());
            "warning-shown-as-error" "A warning also raises the position error."
                => |d| d.encoder.causes(warning_shown_as_error);
        },
    },
    Group {
        needs: &[Need::OfEither(&manuals::KUEBLER_SENDIX58XX, &manuals::SICK_A3M60)],
        deviations: bugs! {
            "speed-limit-at-8192" "The overspeed warning is raised above 8192 rpm."
                => |d| d.checks.check(|check, right| match check { EncoderCheck::TooFast(rpm) => rpm.abs() > 8192, _ => right });
        },
    },
    // Overspeed counterclockwise
    Group {
        needs: &[Need::OfEither(&manuals::KUEBLER_SENDIX58XX, &manuals::SICK_AFX60)],
        deviations: bugs! {
            "speed-warning-forward-only" "A counterclockwise speed never raises the warning."
                => |d| d.checks.check(|check, right| match check { EncoderCheck::TooFast(rpm) => right && rpm > 0, _ => right });
        },
    },
];

fn is_diagnosis(index: u16) -> bool {
    matches!(index & 0x0FFF, 0x00A..=0x00C) || index == 0xF80C
}

fn diagnosis_as_manufacturer_data(alarm: &mut AlarmNotification) {
    for item in &mut alarm.items {
        if let AlarmItem::Channel(diagnoses) = item {
            let data = diagnoses.iter().flat_map(|diagnosis| diagnosis.error_type.0.to_be_bytes()).collect();
            *item = AlarmItem::Other { identifier: 1, data };
        }
    }
}

fn fault_bits_exchanged(_: &EncoderView<'_>, at: (u16, usize), right: u64) -> u64 {
    if at == (65001, 2) { right << 1 & MEMORY | right >> 1 & COMMISSIONING } else { right }
}

fn memory_error_not_cyclic(_: &PreviousCycle, now: SignalImage) -> SignalImage {
    if has_error(&now) && now.g1_xist2 == 0x20 {
        SignalImage {
            zsw2_enc: now.zsw2_enc & !0x0008,
            g1_zsw: now.g1_zsw & !ERROR | POSITION,
            g1_xist2: now.position as u32,
            ..now
        }
    } else {
        now
    }
}

fn warning_shown_as_error(view: &EncoderView<'_>, mut causes: Vec<SensorError>) -> Vec<SensorError> {
    if view.warnings != 0 && causes.iter().all(|error| error.number != 0) {
        causes.insert(0, SensorError { number: 0, code: view.facts.errors[0].code });
    }
    causes
}
