//! Expected and plugged modules and submodules: records 0xF000, 0x8000, 0x8001, 0xC000, 0xE000, 0xE001, 0xF820,
//! 0xF821 and the like. Source: IEC 61158-6-10, ExpectedIdentificationData, RealIdentificationData, APIData.

use super::{BlockHeader, BlockType};
use crate::error::Result;
use crate::octets::{Append, ByteReader};
use alloc::vec::Vec;

/// Slots with their modules and submodules: block 0x0012 (expected) or 0x0013 (real), and the I&M0 filter blocks 0x0030
/// to 0x0032, which have the layout of version 1.1.
///
/// Bytes after the block header, version 1.1: 0-1 number of APIs, then for each: API of four, number of slots of two, for
/// each slot: number of two, module ident of four, number of subslots of two, for each subslot: number of two, submodule
/// ident of four. Version 1.0 has one list of slots and neither number of APIs nor API.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct IdentificationData {
    /// The block type: expected, real, or a filter.
    pub kind: BlockType,
    /// Whether the block has APIs: version 1.1, or a filter. Without them there is one entry, of API 0.
    pub with_apis: bool,
    /// The slots of each API.
    pub apis: Vec<ApiIdentification>,
}

/// The slots of an API.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ApiIdentification {
    /// The API, which identifies the profile: 0, or 0x3D00 for encoders.
    pub api: u32,
    /// The slots of the API.
    pub slots: Vec<SlotIdentification>,
}

/// A slot with its module.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SlotIdentification {
    /// Number of the slot.
    pub slot: u16,
    /// ModuleIdentNumber.
    pub module_ident: u32,
    /// The subslots of the slot.
    pub subslots: Vec<SubslotIdentification>,
}

/// A subslot with its submodule.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SubslotIdentification {
    /// Number of the subslot.
    pub subslot: u16,
    /// SubmoduleIdentNumber.
    pub submodule_ident: u32,
}

impl IdentificationData {
    /// Reads one block; fails on another type or version.
    pub fn read(reader: &mut ByteReader<'_>) -> Result<IdentificationData> {
        let (header, mut block) = BlockHeader::read(reader)?;
        let with_apis = match (header.kind, header.version_high, header.version_low) {
            (BlockType::EXPECTED_IDENTIFICATION | BlockType::REAL_IDENTIFICATION, 1, 0) => false,
            (BlockType::EXPECTED_IDENTIFICATION | BlockType::REAL_IDENTIFICATION, 1, 1) => true,
            (BlockType::IM0_FILTER_SUBMODULE | BlockType::IM0_FILTER_MODULE | BlockType::IM0_FILTER_DEVICE, 1, 0) => {
                true
            }
            (kind, ..) => {
                let expected = "0x0012, 0x0013 in version 1.0 or 1.1, 0x0030 to 0x0032 in version 1.0";
                return Err(block.wrong("BlockType", 6, expected, kind.0.into()));
            }
        };
        let api_count = if with_apis { block.u16()? } else { 1 };
        let mut apis = Vec::new();
        for _ in 0..api_count {
            let api = if with_apis { block.u32()? } else { 0 };
            apis.push(ApiIdentification { api, slots: SlotIdentification::read_list(&mut block)? });
        }
        Ok(IdentificationData { kind: header.kind, with_apis, apis })
    }

    /// Reads the blocks of a record up to its end.
    pub fn parse_record(octets: &[u8]) -> Result<Vec<IdentificationData>> {
        let mut reader = ByteReader::new("identification record", octets);
        let mut blocks = Vec::new();
        while !reader.is_empty() {
            blocks.push(IdentificationData::read(&mut reader)?);
        }
        Ok(blocks)
    }

    /// Appends the block; without APIs the slots of all entries are written as one list.
    pub fn write(&self, out: &mut Vec<u8>) {
        let version_low = u8::from(
            self.with_apis && matches!(self.kind, BlockType::EXPECTED_IDENTIFICATION | BlockType::REAL_IDENTIFICATION),
        );
        BlockHeader { kind: self.kind, version_high: 1, version_low }.write_with(out, |out| {
            if !self.with_apis {
                let slots = || self.apis.iter().flat_map(|api| &api.slots);
                out.put_u16(slots().count() as u16);
                slots().for_each(|slot| slot.write(out));
                return;
            }
            out.put_u16(self.apis.len() as u16);
            for api in &self.apis {
                out.put_u32(api.api);
                out.put_u16(api.slots.len() as u16);
                api.slots.iter().for_each(|slot| slot.write(out));
            }
        });
    }
}

impl SlotIdentification {
    fn read_list(reader: &mut ByteReader<'_>) -> Result<Vec<SlotIdentification>> {
        (0..reader.u16()?).map(|_| SlotIdentification::read(reader)).collect()
    }

    fn read(reader: &mut ByteReader<'_>) -> Result<SlotIdentification> {
        let (slot, module_ident) = (reader.u16()?, reader.u32()?);
        let subslots = (0..reader.u16()?)
            .map(|_| Ok(SubslotIdentification { subslot: reader.u16()?, submodule_ident: reader.u32()? }))
            .collect::<Result<_>>()?;
        Ok(SlotIdentification { slot, module_ident, subslots })
    }

    fn write(&self, out: &mut Vec<u8>) {
        out.put_u16(self.slot);
        out.put_u32(self.module_ident);
        out.put_u16(self.subslots.len() as u16);
        for subslot in &self.subslots {
            out.put_u16(subslot.subslot);
            out.put_u32(subslot.submodule_ident);
        }
    }
}

/// The APIs that a device has: block 0x001A, record 0xF821. Bytes after the block header: 0-1 number, then four each.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ApiData {
    /// The APIs.
    pub apis: Vec<u32>,
}

impl ApiData {
    /// Reads one block; fails on another type or version.
    pub fn read(reader: &mut ByteReader<'_>) -> Result<ApiData> {
        let mut block = BlockHeader::read_only(reader, BlockType::API_DATA, "0x001A in version 1.0")?;
        Ok(ApiData { apis: (0..block.u16()?).map(|_| block.u32()).collect::<Result<_>>()? })
    }

    /// Reads the record 0xF821.
    pub fn parse(octets: &[u8]) -> Result<ApiData> {
        ApiData::read(&mut ByteReader::new("API data", octets))
    }

    /// Appends the block.
    pub fn write(&self, out: &mut Vec<u8>) {
        BlockHeader::write(BlockType::API_DATA, out, |out| {
            out.put_u16(self.apis.len() as u16);
            self.apis.iter().for_each(|api| out.put_u32(*api));
        });
    }
}
