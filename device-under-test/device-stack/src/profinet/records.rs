//! The records of the stack, which all devices have, and the check of addresses. All other records belong to the
//! application.

use super::hooks::StackCheck;
use super::maintenance;
use super::plugged::{ExpectedSubmoduleData, INTERFACE_SUBSLOT, RecordScope, SubmoduleAddress};
use super::port_parameters::PortRecord;
use super::stack::{Stack, StackEnv};
use crate::profinet::{PluggableSubmodule, RecordAccess, RecordRefusal};
use alloc::vec::Vec;
use station::Time;
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::identification::{
    ApiData, ApiIdentification, IdentificationData, SlotIdentification, SubslotIdentification,
};
use wire::profinet::blocks::im::ImText;
use wire::profinet::blocks::module_diff::ModuleDiffBlock;
use wire::profinet::status::RecordError;

/// Index of I&M0. I&M1 to I&M15 have the next indices.
const IM0: u16 = 0xAFF0;
const IM3: u16 = 0xAFF3;
/// The first index of records that cover more than a module. All of them belong to the stack.
const WITHOUT_PLACE: u16 = 0xE000;

/// The content of a record of the stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum StackRecord {
    Expected,
    Real,
    Diagnosis { with_maintenance: bool },
    ModuleDiff,
    Apis,
    Im0Filter,
    Im(u16),
    Port,
    PortParameters(PortRecord),
    Connections,
    LogBook,
    Interface,
    FastStartUp,
    Physical,
}

/// The scope of a record of the stack.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum RecordReach {
    Subslot,
    Slot,
    Connection,
    Api,
    Device,
}

/// Scope and content of the record with this index, if it belongs to the stack.
fn record(index: u16) -> Option<(RecordReach, StackRecord)> {
    let width = match index {
        0x8000..=0xBFFF => RecordReach::Subslot,
        0xC000..=0xDFFF => RecordReach::Slot,
        0xE000..=0xEFFF => RecordReach::Connection,
        0xF000..=0xF7FF => RecordReach::Api,
        0xF800..=0xFFFF => RecordReach::Device,
        0x0000..=0x7FFF => return None,
    };
    let subject = match index {
        0x8000 | 0xC000 | 0xE000 => StackRecord::Expected,
        0x8001 | 0xC001 | 0xE001 | 0xF000 => StackRecord::Real,
        0x800A | 0x800B | 0xC00A | 0xC00B | 0xE00A | 0xE00B | 0xF00A | 0xF00B => {
            StackRecord::Diagnosis { with_maintenance: false }
        }
        0x800C | 0xC00C | 0xE00C | 0xF00C | 0xF80C => StackRecord::Diagnosis { with_maintenance: true },
        0xE002 => StackRecord::ModuleDiff,
        0xF020 | 0xF820 => StackRecord::Connections,
        0xF821 => StackRecord::Apis,
        0xF840 => StackRecord::Im0Filter,
        0x802A => StackRecord::Port,
        0x802B => StackRecord::PortParameters(PortRecord::Check),
        0x802F => StackRecord::PortParameters(PortRecord::Adjust),
        0xF830 => StackRecord::LogBook,
        0x8080 => StackRecord::Interface,
        0x8090 => StackRecord::FastStartUp,
        0xF841 => StackRecord::Physical,
        IM0..=IM3 => StackRecord::Im(index - IM0),
        _ => return None,
    };
    Some((width, subject))
}

/// Builds an identification record from submodules.
fn identification(
    kind: BlockType,
    submodules: impl Iterator<Item = (SubmoduleAddress, u32, u32)>,
) -> IdentificationData {
    let mut apis: Vec<ApiIdentification> = Vec::new();
    for (place, module_ident, submodule_ident) in submodules {
        if !apis.iter().any(|api| api.api == place.api) {
            apis.push(ApiIdentification { api: place.api, slots: Vec::new() });
        }
        for api in apis.iter_mut().filter(|api| api.api == place.api) {
            if !api.slots.iter().any(|slot| slot.slot == place.slot) {
                api.slots.push(SlotIdentification { slot: place.slot, module_ident, subslots: Vec::new() });
            }
            for slot in api.slots.iter_mut().filter(|slot| slot.slot == place.slot) {
                slot.subslots.push(SubslotIdentification { subslot: place.subslot, submodule_ident });
            }
        }
    }
    IdentificationData { kind, with_apis: true, apis }
}

fn real(plug: &PluggableSubmodule) -> (SubmoduleAddress, u32, u32) {
    (plug.into(), plug.module_ident, plug.submodule_ident)
}

fn expected(submodule: &ExpectedSubmoduleData) -> (SubmoduleAddress, u32, u32) {
    (submodule.place, submodule.module_ident, submodule.submodule_ident)
}

impl Stack {
    /// Reads a record. `about` is the connection that a record with connection scope covers.
    pub(super) fn read_record(
        &mut self,
        env: &mut StackEnv<'_>,
        access: RecordAccess,
        about: Option<usize>,
    ) -> Result<Vec<u8>, RecordError> {
        let access = self.hooked_access(access);
        let mut data = Vec::new();
        let result = match record(access.index) {
            Some(record) => self.read_own_record(env.now, access, record, about, &mut data),
            None => self.check_application(access).and_then(|()| {
                let result = env.application.read_record(env.now, access, &mut data);
                result.map_err(error)
            }),
        };
        self.hooks.apply(result.map(|()| data), |hooks, mut result| {
            hooks.read(access, &mut result);
            result
        })
    }

    /// The record that is accessed, after the hooks.
    fn hooked_access(&self, access: RecordAccess) -> RecordAccess {
        self.hooks.apply(access, |hooks, mut access| {
            hooks.access(&mut access);
            access
        })
    }

    /// Reads a record of the stack and appends it to `out`.
    fn read_own_record(
        &self,
        now: Time,
        access: RecordAccess,
        (width, subject): (RecordReach, StackRecord),
        about: Option<usize>,
        out: &mut Vec<u8>,
    ) -> Result<(), RecordError> {
        let place = SubmoduleAddress::from(access);
        let connection = about.and_then(|at| self.ars.get(at)).filter(|ar| ar.exchange.is_some());
        let scope = match width {
            RecordReach::Subslot => RecordScope::Subslot(place),
            RecordReach::Slot => RecordScope::Slot { api: place.api, slot: place.slot },
            RecordReach::Connection => connection.ok_or(RecordError::INVALID_PARAMETER)?.scope(),
            RecordReach::Api => RecordScope::Api(place.api),
            RecordReach::Device => RecordScope::Device,
        };
        let in_scope = |place: &(SubmoduleAddress, u32, u32)| scope.contains(place.0);
        let here = || self.plugged.all().iter().map(real).filter(in_scope);
        let is_plugged = width == RecordReach::Connection || here().next().is_some();
        if !self.hooks.check(StackCheck::Plugged(access), is_plugged) {
            return Err(self.refused_place(place));
        }
        match subject {
            StackRecord::Real => identification(BlockType::REAL_IDENTIFICATION, here()).write(out),
            StackRecord::Expected => {
                let expected = self.ars.iter().flat_map(|ar| &ar.expected).map(expected).filter(in_scope);
                identification(BlockType::EXPECTED_IDENTIFICATION, expected).write(out);
            }
            StackRecord::Diagnosis { with_maintenance } => self.diagnoses.write(scope, with_maintenance, out),
            StackRecord::ModuleDiff => {
                let difference = connection.and_then(|ar| ar.difference.clone());
                difference.unwrap_or(ModuleDiffBlock { apis: Vec::new() }).write(out);
            }
            StackRecord::Apis => {
                let mut apis: Vec<u32> = self.plugged.all().iter().map(|plug| plug.api).collect();
                apis.sort_unstable();
                apis.dedup();
                ApiData { apis }.write(out);
            }
            StackRecord::Im0Filter => {
                let head = || self.plugged.all().iter().take(1).map(real);
                identification(BlockType::IM0_FILTER_SUBMODULE, head()).write(out);
                identification(BlockType::IM0_FILTER_DEVICE, head()).write(out);
            }
            StackRecord::Im(0) => maintenance::im0(&self.identity).write(out),
            StackRecord::PortParameters(record) => out.extend(self.read_port(place, record)?),
            StackRecord::Connections => self.write_connections(scope, out),
            StackRecord::LogBook => self.write_log_book(now, out),
            StackRecord::Port => self.port(place).ok_or(RecordError::INVALID_INDEX)?.write(out),
            StackRecord::Interface if place.subslot != INTERFACE_SUBSLOT => return Err(RecordError::INVALID_INDEX),
            StackRecord::Interface => self.interface().write(out),
            StackRecord::FastStartUp => out.extend(self.read_fast_start_up(place)?),
            StackRecord::Physical => self.physical().iter().for_each(|block| block.write(out)),
            StackRecord::Im(number) => {
                let text = self.retained.texts.get(&self.identity, number);
                text.ok_or(RecordError::INVALID_INDEX)?.write(out);
            }
        }
        Ok(())
    }

    /// Writes a record.
    pub(super) fn write_record(
        &mut self,
        env: &mut StackEnv<'_>,
        access: RecordAccess,
        data: &[u8],
    ) -> Result<(), RecordError> {
        let access = self.hooked_access(access);
        let result = match record(access.index) {
            Some((_, subject)) => self.write_own_record(access, subject, data),
            None => self
                .check_application(access)
                .and_then(|()| env.application.write_record(env.now, access, data).map_err(error)),
        };
        self.hooks.apply(result, |hooks, mut result| {
            hooks.written(access, data, &mut result);
            result
        })
    }

    /// Writes a record of the stack. Only the supported ones of I&M1 to I&M3 and the parameters of ports are writable.
    fn write_own_record(&mut self, access: RecordAccess, subject: StackRecord, data: &[u8]) -> Result<(), RecordError> {
        self.check_place(access)?;
        if let StackRecord::PortParameters(record) = subject {
            return self.write_port(access.into(), record, data);
        }
        if subject == StackRecord::FastStartUp {
            return self.write_fast_start_up(access.into(), data);
        }
        let StackRecord::Im(number @ 1..) = subject else { return Err(RecordError::ACCESS_DENIED) };
        if self.retained.texts.get(&self.identity, number).is_none() {
            return Err(RecordError::INVALID_INDEX);
        }
        let text = ImText::parse(data).map_err(|_| RecordError::WRITE_LENGTH_ERROR)?;
        let mut whole = Vec::new();
        text.write(&mut whole);
        if whole.len() != data.len() {
            return Err(RecordError::WRITE_LENGTH_ERROR);
        }
        if text.block().0 != BlockType::IM0.0 + number {
            return Err(RecordError::INVALID_PARAMETER);
        }
        self.retained.texts.put(text);
        Ok(())
    }

    /// Checks that the record can belong to the application and that its submodule is plugged.
    fn check_application(&self, access: RecordAccess) -> Result<(), RecordError> {
        if access.index >= WITHOUT_PLACE { Err(RecordError::INVALID_INDEX) } else { self.check_place(access) }
    }

    /// Checks that a submodule is plugged at the address of the record.
    fn check_place(&self, access: RecordAccess) -> Result<(), RecordError> {
        let place = SubmoduleAddress::from(access);
        let is_plugged = self.hooks.check(StackCheck::Plugged(access), self.plugged.at(place).is_some());
        if is_plugged { Ok(()) } else { Err(self.refused_place(place)) }
    }

    /// The error for a record at `place`, where nothing is plugged.
    fn refused_place(&self, place: SubmoduleAddress) -> RecordError {
        let knows_api = self.plugged.all().iter().any(|plug| plug.api == place.api);
        if knows_api { RecordError::INVALID_SLOT } else { RecordError::INVALID_AREA }
    }
}

fn error(refusal: RecordRefusal) -> RecordError {
    RecordError(refusal.code1())
}
