//! The plugged submodules, and their comparison with the expected configuration of a Connect.

use super::hooks::AttachedStackHooks;
use crate::profinet::{Identity, Plug};
use alloc::vec::Vec;
use wire::profinet::blocks::connect::{ExpectedModule, SubmoduleProperties, SubmoduleType};
use wire::profinet::blocks::module_diff::{
    ApiDiff, ArInfo, IdentInfo, ModuleDiff, ModuleDiffBlock, ModuleState, SubmoduleDiff, SubmoduleState,
};

/// Subslot of the interface, in slot 0.
pub const INTERFACE_SUBSLOT: u16 = 0x8000;
/// Submodule ident of the interface; invented for the reference devices.
pub const INTERFACE_IDENT: u32 = 0x8000;
/// Subslot of the first port, in slot 0. The other ports have the next subslots.
pub const PORT_SUBSLOT: u16 = 0x8001;
/// Submodule ident of the first port. The other ports have the next numbers. All are invented for the reference
/// devices.
pub const PORT_IDENT: u32 = 0x8001;

/// The address of a submodule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Place {
    /// Application process.
    pub api: u32,
    /// Slot.
    pub slot: u16,
    /// Subslot.
    pub subslot: u16,
}

impl From<&Plug> for Place {
    fn from(plug: &Plug) -> Place {
        Place { api: plug.api, slot: plug.slot, subslot: plug.subslot }
    }
}

/// The submodules that a record or a question covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scope<'a> {
    /// One submodule.
    Subslot(Place),
    /// All submodules of a module.
    Slot {
        /// Application process.
        api: u32,
        /// Slot.
        slot: u16,
    },
    /// All submodules of a connection.
    Connection(&'a [Expected]),
    /// All submodules of an API.
    Api(u32),
    /// All submodules.
    Device,
}

impl Scope<'_> {
    /// Whether the scope contains the submodule at `place`.
    pub(super) fn contains(&self, place: Place) -> bool {
        match *self {
            Scope::Subslot(one) => one == place,
            Scope::Slot { api, slot } => (api, slot) == (place.api, place.slot),
            Scope::Connection(expected) => expected.iter().any(|submodule| submodule.place == place),
            Scope::Api(api) => api == place.api,
            Scope::Device => true,
        }
    }
}

/// A submodule that a Connect expects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Expected {
    /// Its address.
    pub place: Place,
    /// Ident number of its module.
    pub module_ident: u32,
    /// Ident number of the submodule.
    pub submodule_ident: u32,
    /// The direction of its data.
    pub kind: SubmoduleType,
    /// Whether it occupies no byte of any frame, not even a status (DiscardIOXS). Connect gives it a frame offset
    /// nevertheless.
    pub discards_status: bool,
    /// Input data in bytes.
    pub input_octets: u16,
    /// Output data in bytes.
    pub output_octets: u16,
}

impl Expected {
    /// The submodules of `module`.
    pub(super) fn of(module: &ExpectedModule) -> impl Iterator<Item = Expected> {
        module.submodules.iter().map(|submodule| {
            let octets = |output| {
                let one = submodule.data_descriptions.iter().find(|one| one.is_output() == output);
                one.map_or(0, |one| one.submodule_data_length)
            };
            Expected {
                place: Place { api: module.api, slot: module.slot_number, subslot: submodule.subslot_number },
                module_ident: module.module_ident_number,
                submodule_ident: submodule.submodule_ident_number,
                kind: submodule.submodule_properties.submodule_type(),
                discards_status: submodule.submodule_properties.has(SubmoduleProperties::DISCARD_IOXS),
                input_octets: octets(false),
                output_octets: octets(true),
            }
        })
    }

    /// Whether the submodule is a data object, possibly of length 0, in output frames (`output`) or in input frames.
    pub(super) fn provides(&self, output: bool) -> bool {
        let sends_outputs = matches!(self.kind, SubmoduleType::OUTPUT | SubmoduleType::INPUT_OUTPUT);
        if output { sends_outputs } else { self.kind != SubmoduleType::OUTPUT }
    }
}

/// The plugged submodules, and those that can be plugged.
#[derive(Debug)]
pub(super) struct Plugged {
    possible: Vec<Plug>,
    real: Vec<Plug>,
}

impl Plugged {
    /// The state before the first connection: the first alternative of each subslot of `plugs`, the interface and the
    /// ports.
    pub(super) fn new(plugs: &[Plug], identity: &Identity, hooks: &AttachedStackHooks) -> Plugged {
        let mut possible = plugs.to_vec();
        let head = plugs.iter().find(|plug| plug.slot == 0);
        let (api, module_ident) = head.map_or((0, 0), |plug| (plug.api, plug.module_ident));
        let interface = (INTERFACE_SUBSLOT, INTERFACE_IDENT);
        let ports = (0..identity.ports).map(|port| (PORT_SUBSLOT + port, PORT_IDENT + u32::from(port)));
        for (subslot, submodule_ident) in core::iter::once(interface).chain(ports) {
            possible.push(Plug {
                api,
                slot: 0,
                module_ident,
                subslot,
                submodule_ident,
                input_octets: 0,
                output_octets: 0,
            });
        }
        hooks.notify(|hooks| hooks.plugs(&mut possible));
        let mut plugged = Plugged { possible, real: Vec::new() };
        for at in 0..plugged.possible.len() {
            let plug = plugged.possible[at];
            let place = Place::from(&plug);
            let is_first_module = plugged.module_ident(place).is_none_or(|ident| ident == plug.module_ident);
            if is_first_module && plugged.at(place).is_none() {
                plugged.real.push(plug);
            }
        }
        plugged
    }

    /// All plugged submodules.
    pub(super) fn all(&self) -> &[Plug] {
        &self.real
    }

    /// The plugged ports.
    pub(super) fn ports(&self) -> impl Iterator<Item = &Plug> {
        self.real.iter().filter(|plug| plug.slot == 0 && plug.subslot > INTERFACE_SUBSLOT)
    }

    /// The submodule plugged at `place`.
    pub(super) fn at(&self, place: Place) -> Option<&Plug> {
        self.real.iter().find(|plug| Place::from(*plug) == place)
    }

    /// The ident of the module plugged in the slot of `place` for its API.
    fn module_ident(&self, place: Place) -> Option<u32> {
        self.real.iter().find(|plug| (plug.api, plug.slot) == (place.api, place.slot)).map(|plug| plug.module_ident)
    }

    /// The submodule that can be plugged for `expected`: same address, same module and submodule ident.
    pub(super) fn fitting(&self, expected: &Expected) -> Option<Plug> {
        let fits = |plug: &&Plug| {
            Place::from(*plug) == expected.place
                && (plug.module_ident, plug.submodule_ident) == (expected.module_ident, expected.submodule_ident)
        };
        self.possible.iter().find(fits).copied()
    }

    /// Plugs the expected submodules as far as possible and returns those that fit.
    pub(super) fn adapt(&mut self, expected: &[Expected]) -> Vec<Plug> {
        let fitting: Vec<Plug> = expected.iter().filter_map(|submodule| self.fitting(submodule)).collect();
        for plug in &fitting {
            let place = Place::from(plug);
            if self.module_ident(place) != Some(plug.module_ident) {
                let slot = (place.api, place.slot);
                self.real.retain(|other| (other.api, other.slot) != slot);
                for other in self
                    .possible
                    .iter()
                    .filter(|other| (other.api, other.slot) == slot && other.module_ident == plug.module_ident)
                {
                    if !self.real.iter().any(|real| Place::from(real) == Place::from(other)) {
                        self.real.push(*other);
                    }
                }
            }
            if let Some(real) = self.real.iter_mut().find(|real| Place::from(&**real) == place) {
                *real = *plug;
            }
        }
        fitting
    }

    /// The ModuleDiffBlock for `expected`; `None` if nothing differs.
    pub(super) fn difference(&self, expected: &[Expected]) -> Option<ModuleDiffBlock> {
        let differing = expected.iter().filter(|submodule| self.at_fits(submodule).is_none());
        Some(self.compare(differing)).filter(|difference| !difference.apis.is_empty())
    }

    /// Whether the plugged submodules differ from `expected`.
    pub(super) fn differs(&self, expected: &[Expected]) -> bool {
        expected.iter().any(|submodule| self.at_fits(submodule).is_none())
    }

    /// A ModuleDiffBlock with every expected submodule, including those that do not differ.
    pub(super) fn comparison(&self, expected: &[Expected]) -> ModuleDiffBlock {
        self.compare(expected.iter())
    }

    fn compare<'a>(&self, expected: impl Iterator<Item = &'a Expected>) -> ModuleDiffBlock {
        let mut apis: Vec<ApiDiff> = Vec::new();
        for submodule in expected {
            let Place { api, slot, subslot } = submodule.place;
            let (module_ident, state) = match self.module_ident(submodule.place) {
                None => (0, ModuleState::NO_MODULE),
                Some(ident) if ident != submodule.module_ident => (ident, ModuleState::WRONG_MODULE),
                Some(ident) => (ident, ModuleState::PROPER_MODULE),
            };
            let modules = match apis.iter().position(|diff| diff.api == api) {
                Some(at) => &mut apis[at].modules,
                None => {
                    apis.push(ApiDiff { api, modules: Vec::new() });
                    let last = apis.len() - 1;
                    &mut apis[last].modules
                }
            };
            let module = match modules.iter().position(|diff| diff.slot == slot) {
                Some(at) => &mut modules[at],
                None => {
                    modules.push(ModuleDiff { slot, module_ident, state, submodules: Vec::new() });
                    let last = modules.len() - 1;
                    &mut modules[last]
                }
            };
            if state == ModuleState::PROPER_MODULE {
                let real = self.at(submodule.place);
                let ident_info = match real {
                    Some(_) if self.at_fits(submodule).is_some() => IdentInfo::OK,
                    Some(_) => IdentInfo::WRONG,
                    None => IdentInfo::NO_SUBMODULE,
                };
                module.submodules.push(SubmoduleDiff {
                    subslot,
                    submodule_ident: real.map_or(0, |plug| plug.submodule_ident),
                    state: SubmoduleState::new(ident_info, ArInfo::OWN, 0),
                });
            }
        }
        ModuleDiffBlock { apis }
    }

    fn at_fits(&self, expected: &Expected) -> Option<&Plug> {
        self.at(expected.place).filter(|plug| {
            (plug.module_ident, plug.submodule_ident) == (expected.module_ident, expected.submodule_ident)
        })
    }
}
