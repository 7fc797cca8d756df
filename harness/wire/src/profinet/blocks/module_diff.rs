//! Differences between the plugged modules and those that a Connect expects: block 0x8104. Source: IEC 61158-6-10, ModuleDiffBlock.

use super::{BlockHeader, BlockType};
use crate::codes::codes;
use crate::error::Result;
use crate::octets::{Append, ByteReader};
use alloc::vec::Vec;

codes! {
    /// How the plugged module differs from the expected one; unknown numbers are preserved.
    pub struct ModuleState(u16) {
        0x0000 NO_MODULE no_module "No module is plugged.",
        0x0001 WRONG_MODULE wrong_module "Another module is plugged that cannot replace it.",
        0x0002 PROPER_MODULE proper_module "The module is the expected one, but its submodules differ.",
        0x0003 SUBSTITUTE substitute "Another module is plugged as a substitute.",
    }
}

codes! {
    /// How the plugged submodule differs from the expected one: bits 11 to 14 of its state; unknown numbers are preserved.
    pub struct IdentInfo(u8) {
        0x0 OK ok "The submodule is the expected one.",
        0x1 SUBSTITUTE substitute_submodule "Another submodule is plugged as a substitute.",
        0x2 WRONG wrong_submodule "Another submodule is plugged that cannot replace it.",
        0x3 NO_SUBMODULE no_submodule "No submodule is plugged.",
    }
}

codes! {
    /// The owner of the submodule: bits 7 to 10 of its state; unknown numbers are preserved.
    pub struct ArInfo(u8) {
        0x0 OWN own "This AR owns it.",
        0x1 APPLICATION_READY_PENDING application_ready_pending "This AR owns it, but it is not ready yet.",
        0x2 SUPERORDINATED_LOCKED superordinated_locked "It is locked by a superordinated instance.",
        0x3 LOCKED_BY_CONTROLLER locked_by_controller "Another controller owns it.",
        0x4 LOCKED_BY_SUPERVISOR locked_by_supervisor "A supervisor owns it.",
    }
}

/// The state of a submodule.
///
/// Bit 15 is the format indicator. With 1: bits 0-2 additional information (1: take-over is not allowed), 3 advice, 4
/// maintenance required, 5 maintenance demanded, 6 fault, 7-10 AR information, 11-14 ident information. With 0 the other
/// bits are one number, in an older coding.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SubmoduleState(pub u16);

/// All differences; a device without differences omits the block.
///
/// Bytes after the block header: 0-1 number of APIs, for each: API of four, number of modules of two, for each: slot of
/// two, module ident of four, module state of two, number of submodules of two, for each: subslot of two, submodule ident
/// of four, submodule state of two.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModuleDiffBlock {
    /// The differences of each API.
    pub apis: Vec<ApiDiff>,
}

/// The differences of an API.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ApiDiff {
    /// The API, which identifies the profile: 0, or 0x3D00 for encoders.
    pub api: u32,
    /// Modules that differ or whose submodules differ.
    pub modules: Vec<ModuleDiff>,
}

/// A module that differs or whose submodules differ.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ModuleDiff {
    /// Number of the slot.
    pub slot: u16,
    /// ModuleIdentNumber of the plugged module.
    pub module_ident: u32,
    /// How it differs.
    pub state: ModuleState,
    /// Submodules that differ.
    pub submodules: Vec<SubmoduleDiff>,
}

/// A submodule that differs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SubmoduleDiff {
    /// Number of the subslot.
    pub subslot: u16,
    /// SubmoduleIdentNumber of the plugged submodule.
    pub submodule_ident: u32,
    /// How it differs.
    pub state: SubmoduleState,
}

impl SubmoduleState {
    /// Bit 3: advice is available.
    pub const ADVICE: u16 = 0x0008;
    /// Bit 4: maintenance required.
    pub const MAINTENANCE_REQUIRED: u16 = 0x0010;
    /// Bit 5: maintenance demanded.
    pub const MAINTENANCE_DEMANDED: u16 = 0x0020;
    /// Bit 6: the submodule has a fault.
    pub const FAULT: u16 = 0x0040;
    /// Bit 15: the coding with bits.
    pub const FORMAT_INDICATOR: u16 = 0x8000;

    /// A state in the coding with bits; `flags` combines the constants.
    pub fn new(ident: IdentInfo, ar: ArInfo, flags: u16) -> SubmoduleState {
        let numbers = (u16::from(ident.0) & 0xF) << 11 | (u16::from(ar.0) & 0xF) << 7;
        SubmoduleState(Self::FORMAT_INDICATOR | numbers | flags & 0x007F)
    }

    /// Whether the coding is the one with bits; otherwise the other methods are meaningless.
    pub fn format_indicator(self) -> bool {
        self.0 & Self::FORMAT_INDICATOR != 0
    }

    /// Additional information, bits 0 to 2.
    pub fn add_info(self) -> u8 {
        (self.0 & 0x7) as u8
    }

    /// Whether all bits of `flag` are set.
    pub fn has(self, flag: u16) -> bool {
        self.0 & flag == flag
    }

    /// The owner of the submodule.
    pub fn ar_info(self) -> ArInfo {
        ArInfo((self.0 >> 7 & 0xF) as u8)
    }

    /// How the plugged submodule differs.
    pub fn ident_info(self) -> IdentInfo {
        IdentInfo((self.0 >> 11 & 0xF) as u8)
    }
}

impl ModuleDiffBlock {
    /// Reads the block with its header; fails on another type or version.
    pub fn read(reader: &mut ByteReader<'_>) -> Result<ModuleDiffBlock> {
        let mut block = BlockHeader::read_only(reader, BlockType::MODULE_DIFF, "0x8104 in version 1.0")?;
        let apis = (0..block.u16()?).map(|_| ApiDiff::read(&mut block)).collect::<Result<_>>()?;
        Ok(ModuleDiffBlock { apis })
    }

    /// Reads the record 0xE002.
    pub fn parse(octets: &[u8]) -> Result<ModuleDiffBlock> {
        ModuleDiffBlock::read(&mut ByteReader::new("ModuleDiffBlock", octets))
    }

    /// Appends the block.
    pub fn write(&self, out: &mut Vec<u8>) {
        BlockHeader::write(BlockType::MODULE_DIFF, out, |out| {
            out.put_u16(self.apis.len() as u16);
            self.apis.iter().for_each(|api| api.write(out));
        });
    }
}

impl ApiDiff {
    fn read(reader: &mut ByteReader<'_>) -> Result<ApiDiff> {
        let api = reader.u32()?;
        let modules = (0..reader.u16()?).map(|_| ModuleDiff::read(reader)).collect::<Result<_>>()?;
        Ok(ApiDiff { api, modules })
    }

    fn write(&self, out: &mut Vec<u8>) {
        out.put_u32(self.api);
        out.put_u16(self.modules.len() as u16);
        self.modules.iter().for_each(|module| module.write(out));
    }
}

impl ModuleDiff {
    fn read(reader: &mut ByteReader<'_>) -> Result<ModuleDiff> {
        let (slot, module_ident, state) = (reader.u16()?, reader.u32()?, ModuleState(reader.u16()?));
        let submodules = (0..reader.u16()?).map(|_| SubmoduleDiff::read(reader)).collect::<Result<_>>()?;
        Ok(ModuleDiff { slot, module_ident, state, submodules })
    }

    fn write(&self, out: &mut Vec<u8>) {
        out.put_u16(self.slot);
        out.put_u32(self.module_ident);
        out.put_u16(self.state.0);
        out.put_u16(self.submodules.len() as u16);
        for submodule in &self.submodules {
            out.put_u16(submodule.subslot);
            out.put_u32(submodule.submodule_ident);
            out.put_u16(submodule.state.0);
        }
    }
}

impl SubmoduleDiff {
    fn read(reader: &mut ByteReader<'_>) -> Result<SubmoduleDiff> {
        Ok(SubmoduleDiff {
            subslot: reader.u16()?,
            submodule_ident: reader.u32()?,
            state: SubmoduleState(reader.u16()?),
        })
    }
}
