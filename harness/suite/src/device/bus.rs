//! The bus that a device speaks, and what differs with it.
//!
//! What both buses have stands in [`Device`](super::Device); what only one of them has stands in its variant here, so that a device on
//! PROFIBUS has no empty fields of PROFINET, and the other way round.

use super::{Module, Origin, ProfibusFacts, ProfinetFacts};
use serde::{Deserialize, Serialize};
use std::time::Duration;

/// Cycles without a frame after which connections end where nothing else is said.
const WATCHDOG_FACTOR: u32 = 10;
/// The watchdog of a slave where nothing else is said.
const SLAVE_WATCHDOG: Duration = Duration::from_secs(1);

/// A bus.
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

/// Something for either bus.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PerBus<T> {
    /// That of PROFINET.
    pub profinet: T,
    /// That of PROFIBUS.
    pub profibus: T,
}

impl<T> PerBus<T> {
    /// What `make` gives for each bus.
    pub fn new(mut make: impl FnMut(Bus) -> T) -> PerBus<T> {
        PerBus { profinet: make(Bus::Profinet), profibus: make(Bus::Profibus) }
    }

    /// That of a bus.
    pub fn of(&self, bus: Bus) -> &T {
        match bus {
            Bus::Profinet => &self.profinet,
            Bus::Profibus => &self.profibus,
        }
    }

    /// The same, to be changed.
    pub fn of_mut(&mut self, bus: Bus) -> &mut T {
        match bus {
            Bus::Profinet => &mut self.profinet,
            Bus::Profibus => &mut self.profibus,
        }
    }

    /// Both, that of PROFINET first.
    pub fn into_both(self) -> [T; 2] {
        [self.profinet, self.profibus]
    }
}

/// The bus of a device, with what only devices on this bus have.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub enum DeviceBus {
    /// PROFINET IO.
    Profinet(ProfinetFacts),
    /// PROFIBUS DP.
    Profibus(ProfibusFacts),
}

impl DeviceBus {
    /// Which bus it is.
    pub fn kind(&self) -> Bus {
        match self {
            DeviceBus::Profinet(_) => Bus::Profinet,
            DeviceBus::Profibus(_) => Bus::Profibus,
        }
    }

    /// What only devices on PROFINET have.
    pub fn profinet(&self) -> Option<&ProfinetFacts> {
        match self {
            DeviceBus::Profinet(facts) => Some(facts),
            DeviceBus::Profibus(_) => None,
        }
    }

    /// What only devices on PROFIBUS have.
    pub fn profibus(&self) -> Option<&ProfibusFacts> {
        match self {
            DeviceBus::Profibus(facts) => Some(facts),
            DeviceBus::Profinet(_) => None,
        }
    }

    /// The facts of a device on PROFINET, to be changed.
    pub fn profinet_mut(&mut self) -> Option<&mut ProfinetFacts> {
        match self {
            DeviceBus::Profinet(facts) => Some(facts),
            DeviceBus::Profibus(_) => None,
        }
    }

    /// The facts of a device on PROFIBUS, to be changed.
    pub fn profibus_mut(&mut self) -> Option<&mut ProfibusFacts> {
        match self {
            DeviceBus::Profibus(facts) => Some(facts),
            DeviceBus::Profinet(_) => None,
        }
    }

    /// Where the number comes from that says which type of device it is: the device ID, or the ident number.
    pub fn number_origin(&self) -> Origin {
        match self {
            DeviceBus::Profinet(facts) => facts.identity.device_id_origin,
            DeviceBus::Profibus(facts) => facts.ident_origin,
        }
    }

    /// Whether a device in its factory state finds its address by its switches, so that they go back after it; else it has lost its
    /// name, which is given back.
    pub fn switches_go_back(&self) -> bool {
        self.kind().is_profibus()
    }

    /// The time without frames after which a connection ends that says none, where the bench says none either.
    pub fn usual_watchdog(&self, cycle: Duration) -> Duration {
        match self {
            DeviceBus::Profinet(_) => cycle * WATCHDOG_FACTOR,
            DeviceBus::Profibus(_) => SLAVE_WATCHDOG,
        }
    }

    /// What to do where neither the manual nor a description says `what`.
    pub fn needs_description(&self, what: &str) -> String {
        match self {
            DeviceBus::Profinet(_) => format!(
                "the manual prints no {what}, and neither a GSDML nor the device says it: name a GSDML in the bench file"
            ),
            DeviceBus::Profibus(_) => {
                format!("the manual prints no {what}, and no GSD says it: name the vendor's in the bench file by `gsd`")
            }
        }
    }
}

/// How a controller asks a device for a module.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum ModuleBus {
    /// By the ident number of the module.
    Profinet {
        /// The ident number.
        ident: u32,
    },
    /// By a configuration, with parameters that go with it.
    Profibus {
        /// The identifiers, as Chk_Cfg sends them.
        cfg: Vec<u8>,
        /// Start parameters that go with it where the case does not say them: fields of the only record, and their values.
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

impl Module {
    /// A module of a device on PROFINET.
    pub fn on_profinet(name: &str, ident: u32, ident_origin: Origin, submodules: Vec<usize>) -> Module {
        Module { name: name.to_owned(), bus: ModuleBus::Profinet { ident }, ident_origin, submodules }
    }

    /// A module of a device on PROFIBUS, with its identifiers and the parameters that go with it.
    pub fn on_profibus(
        name: &str,
        (cfg, fixes): (Vec<u8>, Vec<(usize, i128)>),
        ident_origin: Origin,
        submodules: Vec<usize>,
    ) -> Module {
        Module { name: name.to_owned(), bus: ModuleBus::Profibus { cfg, fixes }, ident_origin, submodules }
    }

    /// Gives it the ident number that a description says.
    pub fn take_ident(&mut self, of_description: u32) {
        if let ModuleBus::Profinet { ident } = &mut self.bus {
            (*ident, self.ident_origin) = (of_description, Origin::Description);
        }
    }

    /// Gives it the identifiers that a description says.
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

    /// Start parameters that go with it on PROFIBUS, with their values.
    pub fn fixes(&self) -> &[(usize, i128)] {
        match &self.bus {
            ModuleBus::Profibus { fixes, .. } => fixes,
            ModuleBus::Profinet { .. } => &[],
        }
    }
}
