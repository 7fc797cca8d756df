//! Bugs of the device after no manual, those of its stack apart.

use super::Deviation;
use device_stack::profinet::Severity;

/// The bugs of this seam.
pub static BUGS: &[Deviation] = bugs! {
    "any-name-taken" "A name against the rules is taken."
        => |b| b.plain.takes_name = |_| true;
    "no-name-taken" "No name is taken."
        => |b| b.plain.takes_name = |_| false;
    "name-lost-at-power-off" "The station name is lost at power-off."
        => |b| b.plain.stores_name = false;
    "outputs-reversed" "The octets of the outputs are taken in reverse order."
        => |b| b.plain.mirror = |[a, b, c, d]| [d, c, b, a];
    "diagnosis-never-withdrawn" "A diagnosis stays when its fault has gone."
        => |b| b.plain.withdraws = false;
    "fault-reported-as-maintenance" "A fault is reported as a need for maintenance."
        => |b| b.plain.severity = Severity::MaintenanceRequired;
    "diagnosis-of-another-slot" "A diagnosis names another slot than that of the fault."
        => |b| b.plain.diagnosed = 2;
};
