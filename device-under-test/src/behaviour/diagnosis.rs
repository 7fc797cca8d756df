//! What goes into the alarm channel.

use crate::application::Severity;

/// Diagnoses in the alarm channel.
#[derive(Clone, Copy, Debug)]
pub struct Diagnosis {
    /// Whether they are sent, from compatibility mode and alarm channel control.
    pub are_sent: fn(bool, bool) -> bool,
    /// The error type that is reported, from the right one; none reports nothing.
    pub error_type: fn(u16) -> Option<u16>,
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
            side_by_side: true,
            disappear: true,
            severity: |_, right| right,
        }
    }
}
