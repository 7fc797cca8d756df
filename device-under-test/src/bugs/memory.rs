//! Bugs of non-volatile memory, diagnosis and alarms.

use super::Bug;
use crate::application::Severity;
use crate::models::lika_xac77::parameters::{COMMISSIONING, MEMORY};

pub(crate) static BUGS: &[Bug] = bugs! {
    // Memory
    "offset-only-in-ram" "The offset is lost at power-off."
        => |b| b.memory.stores_offset = false;
    "every-write-is-stored" "P65000 goes to memory without P971."
        => |b| b.memory.stores_every_write = true;
    "preset-acknowledged-before-stored" "The preset is acknowledged while the offset is still being written."
        => |b| b.memory.waits_for_store = false;
    "memory-error-swallowed" "A preset whose offset could not be stored is acknowledged."
        => |b| b.memory.heeds_failure = false;
    "p971-takes-any-value" "Any value written to P971 starts a save."
        => |b| b.values.saves = |value| Some(value != 0);
    "p971-confirms-too-early" "P971 reads 0 before the save is done."
        => |b| b.values.save_is_shown = false;
    "save-never-ends" "P971 reads 1 for ever once it was written."
        => |b| b.memory.ends_save = false;
    "scaling-remembered" "The first record 0xBF00 stays in force for good, over a power cycle too."
        => |b| (b.memory.keeps_user_parameters, b.user_parameters.takes_every_record) = (true, false);
    "name-lost-at-power-off" "The station name is lost at power-off."
        => |b| b.memory.stores_name = false;
    "position-restored-from-memory" "After power-up the position is the one before, wherever the shaft is."
        => |b| b.memory.keeps_position = true;
    "memory-fault-ignored-at-power-up" "A memory that cannot be read at power-up is taken for an empty one."
        => |b| b.memory.reports_unreadable = false;

    // Diagnosis
    "fault-bits-exchanged" "Memory and commissioning change places in P65001."
        => |b| b.values.faults = fault_bits_exchanged;
    "faults-never-set" "The faults in P65001 are always 0."
        => |b| b.values.faults = |_| 0;
    "faults-show-supported" "The faults in P65001 are those that are supported."
        => |b| b.values.faults = |_| MEMORY.1 | COMMISSIONING.1;
    "one-alarm-for-all" "A second fault replaces the first one in the alarm channel."
        => |b| b.diagnosis.side_by_side = false;
    "alarm-never-disappears" "A channel diagnosis stays when its fault has gone."
        => |b| b.diagnosis.disappear = false;
    "alarm-switch-in-v41-mode" "Alarm channel control acts without compatibility mode too."
        => |b| b.diagnosis.are_sent = |_, alarm_channel| alarm_channel;
    "alarm-switch-inverted" "Alarm channel control has the opposite polarity: 1 is off."
        => |b| b.diagnosis.are_sent = |compatible, alarm_channel| !compatible || !alarm_channel;
    "fault-reported-as-maintenance" "A fault is reported as a need for maintenance."
        => |b| b.diagnosis.severity = Severity::MaintenanceRequired;
};

fn fault_bits_exchanged(faults: u32) -> u32 {
    faults << 1 & MEMORY.1 | faults >> 1 & COMMISSIONING.1
}
