//! The bus of a device and the facts that depend on it.
//!
//! [`DeviceDescription`](super::DeviceDescription) has the facts that both buses share; the variants of [`DeviceBus`] have the facts of one bus.

use super::{DeviceModule, Origin, ProfibusFacts, ProfinetFacts};
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// Default watchdog factor (PROFINET): cycles without a frame.
const WATCHDOG_FACTOR: u32 = 10;
/// Default watchdog of a slave (PROFIBUS).
const SLAVE_WATCHDOG: Duration = Duration::from_secs(1);

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize)]
pub enum Bus {
    /// PROFINET IO.
    Profinet,
    /// PROFIBUS DP.
    Profibus,
}

impl Bus {
    /// Whether it is PROFIBUS.
    pub fn is_profibus(self) -> bool {
        self == Bus::Profibus
    }
}

/// A value for each bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PerBus<T> {
    pub profinet: T,
    pub profibus: T,
}

impl<T> PerBus<T> {
    /// Calls `make` for each bus.
    pub fn new(mut make: impl FnMut(Bus) -> T) -> PerBus<T> {
        PerBus { profinet: make(Bus::Profinet), profibus: make(Bus::Profibus) }
    }

    /// The value of a bus.
    pub fn of(&self, bus: Bus) -> &T {
        match bus {
            Bus::Profinet => &self.profinet,
            Bus::Profibus => &self.profibus,
        }
    }

    /// The value of a bus, mutable.
    pub fn of_mut(&mut self, bus: Bus) -> &mut T {
        match bus {
            Bus::Profinet => &mut self.profinet,
            Bus::Profibus => &mut self.profibus,
        }
    }

    /// Both values, PROFINET first.
    pub fn into_both(self) -> [T; 2] {
        [self.profinet, self.profibus]
    }
}

/// The bus of a device with its bus-specific facts.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub enum DeviceBus {
    /// PROFINET IO.
    Profinet(ProfinetFacts),
    /// PROFIBUS DP.
    Profibus(ProfibusFacts),
}

impl DeviceBus {
    /// The bus.
    pub fn kind(&self) -> Bus {
        match self {
            DeviceBus::Profinet(_) => Bus::Profinet,
            DeviceBus::Profibus(_) => Bus::Profibus,
        }
    }

    /// The facts of a device on PROFINET.
    pub fn profinet(&self) -> Option<&ProfinetFacts> {
        match self {
            DeviceBus::Profinet(facts) => Some(facts),
            DeviceBus::Profibus(_) => None,
        }
    }

    /// The facts of a device on PROFIBUS.
    pub fn profibus(&self) -> Option<&ProfibusFacts> {
        match self {
            DeviceBus::Profibus(facts) => Some(facts),
            DeviceBus::Profinet(_) => None,
        }
    }

    /// The facts of a device on PROFINET, mutable.
    pub fn profinet_mut(&mut self) -> Option<&mut ProfinetFacts> {
        match self {
            DeviceBus::Profinet(facts) => Some(facts),
            DeviceBus::Profibus(_) => None,
        }
    }

    /// The facts of a device on PROFIBUS, mutable.
    pub fn profibus_mut(&mut self) -> Option<&mut ProfibusFacts> {
        match self {
            DeviceBus::Profibus(facts) => Some(facts),
            DeviceBus::Profinet(_) => None,
        }
    }

    /// Source of the device ID or ident number.
    pub fn number_origin(&self) -> Origin {
        match self {
            DeviceBus::Profinet(facts) => facts.identity.device_id_origin,
            DeviceBus::Profibus(facts) => facts.ident_origin,
        }
    }

    /// Whether a device in its factory state takes its address from its switches, so that they have to be set back after a reset;
    /// otherwise the reset clears its name, which has to be restored.
    pub fn switches_go_back(&self) -> bool {
        self.kind().is_profibus()
    }

    /// The default watchdog of connections if neither the case nor the bench sets one.
    pub fn usual_watchdog(&self, cycle: Duration) -> Duration {
        match self {
            DeviceBus::Profinet(_) => cycle * WATCHDOG_FACTOR,
            DeviceBus::Profibus(_) => SLAVE_WATCHDOG,
        }
    }

    /// The message if neither the manual nor a description has `what`.
    pub fn needs_description(&self, what: &str) -> String {
        match self {
            DeviceBus::Profinet(_) => format!(
                "the manual prints no {what}, and neither a GSDML nor the device has it: name a GSDML in the bench file"
            ),
            DeviceBus::Profibus(_) => {
                format!(
                    "the manual prints no {what}, and no GSD has it: name the vendor's GSD in the bench file with `gsd`"
                )
            }
        }
    }
}

/// How a controller requests a module.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum ModuleBus {
    /// By its ident number.
    Profinet { ident: u32 },
    /// By a configuration with parameters.
    Profibus {
        /// The identifiers, as Chk_Cfg sends them.
        cfg: Vec<u8>,
        /// Start parameters that the module requires unless the case sets them: fields of the only record and their values.
        fixes: Vec<(usize, i128)>,
    },
}

impl From<ProfinetFacts> for DeviceBus {
    fn from(facts: ProfinetFacts) -> DeviceBus {
        DeviceBus::Profinet(facts)
    }
}

impl From<ProfibusFacts> for DeviceBus {
    fn from(facts: ProfibusFacts) -> DeviceBus {
        DeviceBus::Profibus(facts)
    }
}

impl DeviceModule {
    /// A module of a device on PROFINET.
    pub fn on_profinet(name: &str, ident: u32, ident_origin: Origin, submodules: Vec<usize>) -> DeviceModule {
        DeviceModule {
            name: name.to_owned(),
            bus: ModuleBus::Profinet { ident },
            ident_origin,
            submodules,
            absent: None,
        }
    }

    /// A module of a device on PROFIBUS, with its identifiers and required parameters.
    pub fn on_profibus(
        name: &str,
        (cfg, fixes): (Vec<u8>, Vec<(usize, i128)>),
        ident_origin: Origin,
        submodules: Vec<usize>,
    ) -> DeviceModule {
        DeviceModule {
            name: name.to_owned(),
            bus: ModuleBus::Profibus { cfg, fixes },
            ident_origin,
            submodules,
            absent: None,
        }
    }

    /// Takes over the ident number of a description.
    pub fn take_ident(&mut self, of_description: u32) {
        if let ModuleBus::Profinet { ident } = &mut self.bus {
            (*ident, self.ident_origin) = (of_description, Origin::Description);
        }
    }

    /// Takes over the identifiers of a description.
    pub fn take_cfg(&mut self, of_description: &[u8]) {
        if let ModuleBus::Profibus { cfg, .. } = &mut self.bus {
            (*cfg, self.ident_origin) = (of_description.to_vec(), Origin::Description);
        }
    }

    /// Ident number on PROFINET.
    pub fn ident(&self) -> Option<u32> {
        match self.bus {
            ModuleBus::Profinet { ident } => Some(ident),
            ModuleBus::Profibus { .. } => None,
        }
    }

    /// The identifiers of its configuration on PROFIBUS; empty on PROFINET.
    pub fn cfg(&self) -> &[u8] {
        match &self.bus {
            ModuleBus::Profibus { cfg, .. } => cfg,
            ModuleBus::Profinet { .. } => &[],
        }
    }

    /// Start parameters that the module requires on PROFIBUS, with their values.
    pub fn fixes(&self) -> &[(usize, i128)] {
        match &self.bus {
            ModuleBus::Profibus { fixes, .. } => fixes,
            ModuleBus::Profinet { .. } => &[],
        }
    }
}
