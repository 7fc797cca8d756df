//! The bugs that only a reference AMT58 can have, by topic.

mod addresses;
mod configuration;
mod diagnosis;
mod leds;
mod offset_memory;
mod parameters;
mod preset_memory;
mod presets;
mod red_zone;
mod scaling;
mod values;

use super::{Group, Table, presets as shared_presets, slave};
use crate::needs::Need;
use reference_devices::manuals::DATALOGIC_AMT58;

const AMT58: &[Need] = &[Need::Of(&DATALOGIC_AMT58)];

/// By topic.
pub static GROUPS: &[Group] = &[
    Group { needs: AMT58, deviations: addresses::BUGS },
    Group { needs: AMT58, deviations: configuration::BUGS },
    Group { needs: AMT58, deviations: diagnosis::BUGS },
    Group { needs: AMT58, deviations: leds::BUGS },
    Group { needs: AMT58, deviations: parameters::BUGS },
    Group { needs: AMT58, deviations: presets::BUGS },
    Group { needs: AMT58, deviations: shared_presets::ANYHOW },
    Group { needs: AMT58, deviations: red_zone::BUGS },
    Group { needs: AMT58, deviations: scaling::BUGS },
    Group { needs: AMT58, deviations: values::BUGS },
];

/// Those of the tables that say by name which manuals have them.
pub static BUGS: &[Table] = &[Table::Only(slave::BUGS, SLAVE), Table::All(slave::OTHERS)];

const SLAVE: &[&str] = &[
    "exchange-with-old-parameters",
    "ident-not-checked",
    "watchdog-never-expires",
    "watchdog-always-active",
    "watchdog-in-milliseconds",
    "watchdog-factor-0-taken",
    "min-tsdr-0-refused",
    "unlock-ignored",
    "parameters-taken-without-lock",
    "second-master-takes-over",
    "new-parameters-need-power-off",
    "configuration-taken-after-fault",
    "configuration-before-parameters",
    "inputs-before-configuration",
    "short-outputs-taken",
    "clear-keeps-outputs",
    "freeze-ignored",
    "sync-ignored",
    "read-inputs-are-old",
    "read-outputs-are-old",
    "diagnosis-ends-exchange",
    "no-diagnosis-while-waiting-for-configuration",
    "station-non-existent-set",
    "ready-before-parameters",
    "not-ready-never-cleared",
    "cfg-fault-never-set",
    "cfg-fault-sticks",
    "ext-diag-always-set",
    "invalid-response-set",
    "prm-fault-sticks",
    "prm-fault-never-set",
    "master-lock-set-by-slave",
    "prm-req-not-set",
    "stat-diag-always-set",
    "always-one-missing",
    "watchdog-not-shown",
    "freeze-mode-always-shown",
    "sync-mode-always-shown",
    "deactivated-set",
    "overflow-with-extended-diagnosis",
    "own-address-as-master",
    "ident-swapped-in-exchange",
    "first-master-stays",
    "last-master-kept",
    "address-taken-without-ident",
    "address-from-ident-octets",
    "address-in-decimal",
    "address-127-taken",
    "address-changed-in-exchange",
    "address-after-power-off-only",
    "short-address-telegram-taken",
];
