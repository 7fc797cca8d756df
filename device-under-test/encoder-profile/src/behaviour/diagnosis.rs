//! What goes into the alarm channel.

use crate::facts::ErrorFact;
use core::time::Duration;
use device_stack::profinet::Severity;

/// Diagnoses in the alarm channel.
#[derive(Clone, Copy, Debug)]
pub struct Diagnosis {
    /// Whether they are sent, from compatibility mode and alarm channel control.
    pub are_sent: fn(bool, bool) -> bool,
    /// The error type that is reported, from the right one; none reports nothing.
    pub error_type: fn(u16) -> Option<u16>,
    /// Whether a speed in revolutions per minute is too high, from whether it is above the limit of the manual.
    pub is_too_fast: fn(i64, bool) -> bool,
    /// The warnings that are there, from those before and the right ones.
    pub warnings: fn(u32, u32) -> u32,
    /// Whether an error is raised when its cause is there.
    pub raises: fn(&ErrorFact) -> bool,
    /// The code of an error in G1_XIST2.
    pub code: fn(&ErrorFact) -> Option<u16>,
    /// Whether codes are shown in G1_XIST2 and bit 15 of G1_ZSW, from compatibility mode and alarm channel control.
    pub shows_codes: fn(bool, bool) -> bool,
    /// Whether a warning is the first error of the manual as well.
    pub warning_is_error: bool,
    /// The error type of what goes without a diagnosis.
    pub without_type: Option<u16>,
    /// After how long a diagnosis that is there is told again.
    pub repeats_after: Option<Duration>,
    /// Whether several stand side by side.
    pub side_by_side: bool,
    /// Whether they go with their fault.
    pub disappear: bool,
    /// How bad one is, from the error type that is reported and the right severity.
    pub severity: fn(u16, Severity) -> Severity,
}

impl Default for Diagnosis {
    fn default() -> Diagnosis {
        Diagnosis {
            are_sent: |compatible, alarm_channel| !compatible || alarm_channel,
            error_type: Some,
            is_too_fast: |_, right| right,
            warnings: |_, right| right,
            raises: |_| true,
            code: |error| error.code,
            shows_codes: |_, _| true,
            warning_is_error: false,
            without_type: None,
            repeats_after: None,
            side_by_side: true,
            disappear: true,
            severity: |_, right| right,
        }
    }
}
