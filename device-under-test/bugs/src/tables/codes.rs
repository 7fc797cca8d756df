//! Bugs of error codes, faults, warnings and the alarm channel, for encoders that monitor supply and temperature.

use super::Group;
use super::diagnosis_state::SilencedErrorCodes;
use super::limits::with_cause;
use super::service::status_words;
use super::unrequested_presets::takes_writes;
use crate::needs::Need;
use crate::seams::Deviations;
use alloc::rc::Rc;
use core::cell::Cell;
use device_stack::profinet::DiagnosisSeverity;
use encoder_profile::checks::EncoderCheck;
use reference_devices::manuals;
use reference_devices::models::sick_afx60::hooks::Afx60Event;

/// The bugs, by what they need.
pub static GROUPS: &[Group] = &[
    // Error types, codes and parameters of the AFS60 and AFM60
    Group {
        needs: &[Need::Of(&manuals::SICK_AFX60)],
        deviations: bugs! {
            "alarm-codes-exchanged" "The error types of errors are swapped in pairs."
                => |d| d.encoder.error_type(|right| Some(match right { 0x9000 => 0x9011, 0x9011 => 0x9000, 0x9001 => 0x9002, 0x9002 => 0x9001, 0x900A => 0x900B, _ => right }));
            "warning-codes-exchanged" "The error types of warnings are rotated."
                => |d| d.encoder.error_type(|right| Some(match right { 0x9005 => 0x9010, 0x9006 => 0x9005, 0x9010 => 0x9006, _ => right }));
            "warnings-reported-as-faults" "Warnings are reported as faults."
                => |d| d.encoder.diagnoses(|_, all| all.into_iter().map(|(error_type, _)| (error_type, DiagnosisSeverity::Fault)).collect());
            "alarm-switch-silences-codes" "In compatibility mode with the alarm channel off, error codes are not shown either."
                => |d| {
                    let silence = SilencedErrorCodes::default();
                    d.checks.add(silence.clone());
                    d.encoder.add(silence);
                };
            "no-alarm-in-compatibility-mode" "In compatibility mode no diagnosis is reported."
                => |d| d.checks.check(|check, right| match check { EncoderCheck::AlarmChannel { compatible, .. } => !compatible, _ => right });
            "no-alarm-for-a-position-error" "A position error is not reported as a diagnosis."
                => |d| d.encoder.error_type(|right| Some(right).filter(|right| *right != 0x900A));
            "sensor-bits-without-error" "Sensor and memory faults are reported in the sensor status only."
                => |d| d.encoder.raise(|error| !matches!(error.code, Some(0x0001 | 0x1001)));
            "voltage-is-a-warning-only" "A supply voltage beyond its limits is reported in the sensor status only."
                => |d| d.encoder.raise(|error| !matches!(error.code, Some(0x1003 | 0x1004)));
            "code-of-the-sensor-missing" "A sensor error has no code."
                => |d| d.encoder.code(|error| error.code.filter(|code| *code != 0x0001));
            "code-of-a-command-missing" "An unsupported command has no error code."
                => |d| d.encoder.code(|error| error.code.filter(|code| *code != 0x0F01));
            "code-of-the-temperature-missing" "Overtemperature has no code."
                => |d| d.encoder.code(|error| error.code.filter(|code| *code != 0x0F05));
            "code-of-undervoltage-missing" "Undervoltage has no code."
                => |d| d.encoder.code(|error| error.code.filter(|code| *code != 0x1003));
            "code-of-overvoltage-missing" "Overvoltage has no code."
                => |d| d.encoder.code(|error| error.code.filter(|code| *code != 0x1004));
            "commissioning-with-own-code" "The diagnosis during commissioning has the code 1002h."
                => |d| d.encoder.code(|error| if error.fault_bits == 1 << 4 { Some(0x1002) } else { error.code });
            "error-after-start" "Each connection begins with a position error."
                => |d| error_after_start(d);
            "faults-stay-after-acknowledgement" "Faults stay in P65001 after their acknowledgement."
                => |d| faults_stay_after_acknowledgement(d);
            "invalid-scaling-not-noticed" "User parameters that cannot be served are accepted silently."
                => |d| {
                    d.checks.serves(|_, _, _| true);
                    status_words(d, |_, [a, b, c]| [a, b & !0x0002, c]);
                };
            "vendor-is-device-id" "P964 contains the device ID as the vendor."
                => |d| d.encoder.element(|_, at, right| if at == (964, 0) { 0x7701 } else { right });
            "type-is-device-id" "P964 contains the device ID as the type."
                => |d| d.encoder.element(|_, at, right| if at == (964, 1) { 0x7701 } else { right });
            "subclass-of-class-4" "P975 announces class 4 too."
                => |d| d.encoder.element(|_, at, right| if at == (975, 6) { 0xC000 } else { right });
            "resolution-in-bits" "P979 contains the resolution as a number of bits."
                => |d| d.encoder.element(|_, at, right| if at == (979, 2) { right.trailing_zeros().into() } else { right });
            "gateway-and-mask-exchanged" "P61003 contains the subnet mask and P61004 the gateway."
                => |d| d.encoder.element(|view, at, right| match at { (61003, 0) => number(view.station.mask), (61004, 0) => number(view.station.gateway), _ => right });
            "mask-as-prefix-length" "P61004 contains the prefix length of the subnet mask."
                => |d| d.encoder.element(|_, at, right| if at == (61004, 0) { right.count_ones().into() } else { right });
            "name-of-delivery-shown" "P61000 contains the factory name."
                => |d| {
                    d.encoder.truncate_elements(61000, 6);
                    d.encoder.element(|_, at, right| if let (61000, n @ 0..=5) = at { b"afx60a"[n].into() } else { right });
                };
            "port-1-mac-for-station" "P61002 contains the MAC address of port 1."
                => |d| d.encoder.element(|_, at, right| if at == (61002, 5) { right + 1 } else { right });
            "port-macs-exchanged" "P1011 contains the MAC address of port 2 and P1012 that of port 1."
                => |d| d.encoder.element(|_, at, right| match at { (1011, 5) => right + 1, (1012, 5) => right - 1, _ => right });
            "port-1-mac-twice" "P1012 contains the MAC address of port 1."
                => |d| d.encoder.element(|_, at, right| if at == (1012, 5) { right - 1 } else { right });
            "temperature-as-magnitude" "A temperature below 0 is shown without its sign."
                => |d| d.encoder.element(|_, at, right| if at == (1014, 0) { (right as u16 as i16).unsigned_abs().into() } else { right });
            "fpga-version-reversed" "The bytes of P1013 are in reverse order."
                => |d| d.encoder.element(|_, at, right| if at == (1013, 0) { 0x0302_0100 } else { right });
            "constants-can-be-written" "P980 can be written."
                => |d| takes_writes(d, 980, 0);
        },
    },
    // Operating status: P65001
    Group {
        needs: &[Need::EncoderProfile],
        deviations: bugs! {
            "fault-bits-one-too-high" "The fault bits are shifted up by one bit."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 2) { right << 1 } else { right });
            "short-circuit-shown" "The short-circuit fault is always set."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 2) { right | 8 } else { right });
            "short-circuit-supported" "The short-circuit fault is announced as supported."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 3) { right | 8 } else { right });
            "warnings-never-set" "The warnings in P65001 are always 0."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 4) { 0 } else { right });
            "warning-bits-exchanged" "The warning bits are rotated."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 4) { right << 1 & 6 | right >> 2 & 1 } else { right });
            "unsupported-warnings-shown" "The operating time warning is always set."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 4) { right | 1 << 4 } else { right });
            "battery-warning-supported" "The battery warning is announced as supported."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 5) { right | 1 << 5 } else { right });
            "offset-never-shown" "The offset is always shown as 0."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 8) { 0 } else { right });
            "range-less-one" "The total range is shown as one less, as the highest position."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 10) { right.saturating_sub(1) } else { right });
            "profile-version-as-in-p965" "The profile version has the format of P965."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 6) { 0x29 } else { right });
            "operating-time-in-seconds" "The operating time is shown in seconds."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 7) { right * 360 } else { right });
            "operating-time-0" "The operating time is always 0."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 7) { 0 } else { right });
            "speed-unit-codes-shifted" "The number of the velocity unit is one too high."
                => |d| d.encoder.element(|_, at, right| if at == (65001, 11) { right + 1 } else { right });
            "preset-value-reduced" "A preset value beyond the range is reduced modulo the range."
                => |d| d.encoder.element(|view, at, right| if at == (65000, 0) { right % view.measuring.range().max(1) } else { right });
        },
    },
];

fn error_after_start(d: &mut Deviations) {
    let has_started = Rc::new(Cell::new(false));
    let starts = has_started.clone();
    d.afx60.kept(move |event, _, retained| {
        starts.set(starts.get() || event == Afx60Event::Start);
        retained
    });
    // The cause is present only at the time of the start.
    let mut start = None;
    d.encoder.causes(move |view, causes| {
        if has_started.take() {
            start = Some(view.now);
        }
        if start == Some(view.now) { with_cause(view, causes, 0x0001) } else { causes }
    });
}

fn faults_stay_after_acknowledgement(d: &mut Deviations) {
    let faults = Rc::new(Cell::new(0));
    let (collected, cleared) = (faults.clone(), faults.clone());
    d.encoder.causes(move |view, causes| {
        collected.set(collected.get() | view.faults);
        causes
    });
    d.afx60.kept(move |event, _, retained| {
        if let Afx60Event::Start | Afx60Event::PowerUp = event {
            cleared.set(0);
        }
        retained
    });
    d.encoder.element(move |_, at, right| if at == (65001, 2) { right | u64::from(faults.get()) } else { right });
}

fn number(address: [u8; 4]) -> u64 {
    u32::from_be_bytes(address).into()
}
