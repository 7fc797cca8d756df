//! The plugged submodules, and their comparison with the expected configuration of a Connect.

use super::hooks::{AttachedStackHooks, StackCheck};
use crate::profinet::{IoIdentity, PluggableSubmodule, RecordAccess};
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
pub(super) struct SubmoduleAddress {
    /// Application process.
    pub api: u32,
    /// Slot.
    pub slot: u16,
    /// Subslot.
    pub subslot: u16,
}

impl From<&PluggableSubmodule> for SubmoduleAddress {
    fn from(plug: &PluggableSubmodule) -> SubmoduleAddress {
        SubmoduleAddress { api: plug.api, slot: plug.slot, subslot: plug.subslot }
    }
}

impl From<RecordAccess> for SubmoduleAddress {
    fn from(access: RecordAccess) -> SubmoduleAddress {
        SubmoduleAddress { api: access.api, slot: access.slot, subslot: access.subslot }
    }
}

/// The submodules that a record or a question covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum RecordScope<'a> {
    /// One submodule.
    Subslot(SubmoduleAddress),
    /// All submodules of a module.
    Slot {
        /// Application process.
        api: u32,
        /// Slot.
        slot: u16,
    },
    /// All submodules of a connection.
    Connection(&'a [ExpectedSubmoduleData]),
    /// All submodules of an API.
    Api(u32),
    /// All submodules.
    Device,
}

impl RecordScope<'_> {
    /// Whether the scope contains the submodule at `place`.
    pub(super) fn contains(&self, place: SubmoduleAddress) -> bool {
        match *self {
            RecordScope::Subslot(one) => one == place,
            RecordScope::Slot { api, slot } => (api, slot) == (place.api, place.slot),
            RecordScope::Connection(expected) => expected.iter().any(|submodule| submodule.place == place),
            RecordScope::Api(api) => api == place.api,
            RecordScope::Device => true,
        }
    }
}

/// A submodule that a Connect expects.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct ExpectedSubmoduleData {
    /// Its address.
    pub place: SubmoduleAddress,
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

impl ExpectedSubmoduleData {
    /// The submodules of `module`.
    pub(super) fn of(module: &ExpectedModule) -> impl Iterator<Item = ExpectedSubmoduleData> {
        module.submodules.iter().map(|submodule| {
            let octets = |output| {
                let one = submodule.data_descriptions.iter().find(|one| one.is_output() == output);
                one.map_or(0, |one| one.submodule_data_length)
            };
            ExpectedSubmoduleData {
                place: SubmoduleAddress {
                    api: module.api,
                    slot: module.slot_number,
                    subslot: submodule.subslot_number,
                },
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
pub(super) struct PluggedConfiguration {
    /// What the application has, before the hooks; `possible` begins with the same submodules after the hooks.
    offered: Vec<PluggableSubmodule>,
    possible: Vec<PluggableSubmodule>,
    real: Vec<PluggableSubmodule>,
    /// Where the right submodule was pulled, whatever is plugged there now.
    pulled: Vec<SubmoduleAddress>,
}

impl PluggedConfiguration {
    /// The state before the first connection: the first alternative of each subslot of `plugs`, the interface and the
    /// ports.
    pub(super) fn new(
        plugs: &[PluggableSubmodule],
        identity: &IoIdentity,
        hooks: &AttachedStackHooks,
    ) -> PluggedConfiguration {
        let mut possible = plugs.to_vec();
        let head = plugs.iter().find(|plug| plug.slot == 0);
        let (api, module_ident) = head.map_or((0, 0), |plug| (plug.api, plug.module_ident));
        let interface = (INTERFACE_SUBSLOT, INTERFACE_IDENT);
        let ports = (0..identity.ports).map(|port| (PORT_SUBSLOT + port, PORT_IDENT + u32::from(port)));
        for (subslot, submodule_ident) in core::iter::once(interface).chain(ports) {
            possible.push(PluggableSubmodule {
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
        let mut plugged =
            PluggedConfiguration { offered: plugs.to_vec(), possible, real: Vec::new(), pulled: Vec::new() };
        for at in 0..plugged.possible.len() {
            let plug = plugged.possible[at];
            let place = SubmoduleAddress::from(&plug);
            let is_first_module = plugged.module_ident(place).is_none_or(|ident| ident == plug.module_ident);
            if is_first_module && plugged.at(place).is_none() {
                plugged.real.push(plug);
            }
        }
        plugged
    }

    /// All plugged submodules.
    pub(super) fn all(&self) -> &[PluggableSubmodule] {
        &self.real
    }

    /// The plugged ports.
    pub(super) fn ports(&self) -> impl Iterator<Item = &PluggableSubmodule> {
        self.real.iter().filter(|plug| plug.slot == 0 && plug.subslot > INTERFACE_SUBSLOT)
    }

    /// The submodule plugged at `place`.
    pub(super) fn at(&self, place: SubmoduleAddress) -> Option<&PluggableSubmodule> {
        self.real.iter().find(|plug| SubmoduleAddress::from(*plug) == place)
    }

    /// The ident of the module plugged in the slot of `place` for its API.
    fn module_ident(&self, place: SubmoduleAddress) -> Option<u32> {
        self.real.iter().find(|plug| (plug.api, plug.slot) == (place.api, place.slot)).map(|plug| plug.module_ident)
    }

    /// The submodule was pulled.
    pub(super) fn pull(&mut self, place: SubmoduleAddress) {
        self.real.retain(|real| SubmoduleAddress::from(real) != place);
        if !self.pulled.contains(&place) {
            self.pulled.push(place);
        }
    }

    /// A submodule of the application was plugged in an empty subslot. Returns it as it is plugged, and whether it is one
    /// that belongs there. One that is listed at this place already is replaced.
    pub(super) fn plug(&mut self, plug: PluggableSubmodule, hooks: &AttachedStackHooks) -> (PluggableSubmodule, bool) {
        let place = SubmoduleAddress::from(&plug);
        let known = self.offered.iter().position(|offered| *offered == plug).and_then(|at| self.possible.get(at));
        let right = known.copied().filter(|known| SubmoduleAddress::from(known) == place);
        let plug = right.unwrap_or(plug);
        if hooks.check(StackCheck::ReplacesPlugged, true) {
            self.pull(place);
        }
        self.real.push(plug);
        if right.is_some() {
            self.pulled.retain(|pulled| *pulled != place);
        }
        (plug, right.is_some())
    }

    /// Whether `expected` is a submodule of the device, be it pulled or not.
    pub(super) fn knows(&self, expected: &ExpectedSubmoduleData) -> bool {
        self.possible_for(expected).is_some()
    }

    /// The submodule that can be plugged for `expected` and is not pulled: same address, same module and submodule
    /// ident.
    pub(super) fn fitting(&self, expected: &ExpectedSubmoduleData) -> Option<PluggableSubmodule> {
        self.possible_for(expected).filter(|_| !self.pulled.contains(&expected.place))
    }

    fn possible_for(&self, expected: &ExpectedSubmoduleData) -> Option<PluggableSubmodule> {
        let fits = |plug: &&PluggableSubmodule| {
            SubmoduleAddress::from(*plug) == expected.place
                && (plug.module_ident, plug.submodule_ident) == (expected.module_ident, expected.submodule_ident)
        };
        self.possible.iter().find(fits).copied()
    }

    /// Plugs the expected submodules as far as possible and returns those that fit.
    pub(super) fn adapt(&mut self, expected: &[ExpectedSubmoduleData]) -> Vec<PluggableSubmodule> {
        let fitting: Vec<PluggableSubmodule> =
            expected.iter().filter_map(|submodule| self.fitting(submodule)).collect();
        for plug in &fitting {
            let place = SubmoduleAddress::from(plug);
            if self.module_ident(place) != Some(plug.module_ident) {
                let slot = (place.api, place.slot);
                self.real.retain(|other| (other.api, other.slot) != slot);
                for other in self
                    .possible
                    .iter()
                    .filter(|other| (other.api, other.slot) == slot && other.module_ident == plug.module_ident)
                {
                    if !self.real.iter().any(|real| SubmoduleAddress::from(real) == SubmoduleAddress::from(other)) {
                        self.real.push(*other);
                    }
                }
            }
            if let Some(real) = self.real.iter_mut().find(|real| SubmoduleAddress::from(&**real) == place) {
                *real = *plug;
            }
        }
        fitting
    }

    /// The ModuleDiffBlock for `expected`, of which another connection owns those in `locked`; `None` if nothing
    /// differs.
    pub(super) fn difference(
        &self,
        expected: &[ExpectedSubmoduleData],
        locked: &[ExpectedSubmoduleData],
    ) -> Option<ModuleDiffBlock> {
        let differs =
            |submodule: &&ExpectedSubmoduleData| self.fitting_at(submodule).is_none() || locked.contains(*submodule);
        Some(self.compare(expected.iter().filter(differs), locked)).filter(|difference| !difference.apis.is_empty())
    }

    /// Whether the plugged submodules differ from `expected`.
    pub(super) fn differs(&self, expected: &[ExpectedSubmoduleData]) -> bool {
        expected.iter().any(|submodule| self.fitting_at(submodule).is_none())
    }

    /// A ModuleDiffBlock with every expected submodule, including those that do not differ.
    pub(super) fn comparison(
        &self,
        expected: &[ExpectedSubmoduleData],
        locked: &[ExpectedSubmoduleData],
    ) -> ModuleDiffBlock {
        self.compare(expected.iter(), locked)
    }

    fn compare<'a>(
        &self,
        expected: impl Iterator<Item = &'a ExpectedSubmoduleData>,
        locked: &[ExpectedSubmoduleData],
    ) -> ModuleDiffBlock {
        let mut apis: Vec<ApiDiff> = Vec::new();
        for submodule in expected {
            let SubmoduleAddress { api, slot, subslot } = submodule.place;
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
                    Some(_) if self.fitting_at(submodule).is_some() => IdentInfo::OK,
                    Some(_) => IdentInfo::WRONG,
                    None => IdentInfo::NO_SUBMODULE,
                };
                let owner = if locked.contains(submodule) { ArInfo::LOCKED_BY_CONTROLLER } else { ArInfo::OWN };
                module.submodules.push(SubmoduleDiff {
                    subslot,
                    submodule_ident: real.map_or(0, |plug| plug.submodule_ident),
                    state: SubmoduleState::new(ident_info, owner, 0),
                });
            }
        }
        ModuleDiffBlock { apis }
    }

    fn fitting_at(&self, expected: &ExpectedSubmoduleData) -> Option<&PluggableSubmodule> {
        self.at(expected.place).filter(|plug| {
            (plug.module_ident, plug.submodule_ident) == (expected.module_ident, expected.submodule_ident)
        })
    }
}
