//! Identification and maintenance data: records 0xAFF0 to 0xAFF4 of a submodule. Source: IEC 61158-6-10 and the PI
//! guideline on identification and maintenance functions.
//!
//! The filter record 0xF840 has the layout of [`super::identification::IdentificationData`].

use super::{BlockHeader, BlockType};
use crate::error::Result;
use crate::octets::{Append, ByteReader};
use alloc::vec::Vec;

/// I&M0, the identification of a submodule: block 0x0020, record 0xAFF0.
///
/// Bytes after the block header: 0-1 vendor id, 2-21 order id, 22-37 serial number, 38-39 hardware revision, 40-43
/// software revision, 44-45 revision counter, 46-47 profile id, 48-49 profile specific type, 50-51 version, 52-53
/// supported.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Im0 {
    /// The vendor ID assigned by PI.
    pub vendor_id: u16,
    /// Order id: visible characters, padded with blanks.
    pub order_id: [u8; 20],
    /// Serial number: visible characters, padded with blanks.
    pub serial_number: [u8; 16],
    /// Hardware revision; 0xFFFF if the profile has it.
    pub hardware_revision: u16,
    /// Software revision.
    pub software_revision: SoftwareRevision,
    /// Counts changes of hardware or parameters.
    pub revision_counter: u16,
    /// The profile; 0 for none, 0xF600 for a communication module, 0x3D00 for encoders.
    pub profile_id: u16,
    /// The type within the profile.
    pub profile_specific_type: u16,
    /// Version of the identification data, major and minor: 1 and 1.
    pub im_version: [u8; 2],
    /// The supported records I&M1 to I&M15: bit n for I&Mn.
    pub im_supported: u16,
}

/// A software revision. Bytes: 0 prefix, 1 functional enhancement, 2 bug fix, 3 internal change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SoftwareRevision {
    /// `V` released, `R` revision, `P` prototype, `U` under test, `T` test device.
    pub prefix: u8,
    /// First number.
    pub functional_enhancement: u8,
    /// Second number.
    pub bug_fix: u8,
    /// Third number.
    pub internal_change: u8,
}

/// The writable I&M records: blocks 0x0021 to 0x0024, records 0xAFF1 to 0xAFF4.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ImText {
    /// I&M1, block 0x0021: function and location of the submodule. Bytes after the block header: 0-31, 32-53.
    Tag {
        /// Function.
        function: [u8; 32],
        /// Location.
        location: [u8; 22],
    },
    /// I&M2, block 0x0022: date of installation as `YYYY-MM-DD HH:MM`.
    Date([u8; 16]),
    /// I&M3, block 0x0023: any text.
    Descriptor([u8; 54]),
    /// I&M4, block 0x0024: signature, any bytes.
    Signature([u8; 54]),
}

/// Pads `text` with blanks to `N` bytes, or truncates it.
pub fn padded<const N: usize>(text: &str) -> [u8; N] {
    let mut octets = [b' '; N];
    octets.iter_mut().zip(text.bytes()).for_each(|(to, from)| *to = from);
    octets
}

impl Im0 {
    /// Reads the block with its header; fails on another type or version.
    pub fn read(reader: &mut ByteReader<'_>) -> Result<Im0> {
        let mut block = BlockHeader::read_only(reader, BlockType::IM0, "0x0020 in version 1.0")?;
        Im0::read_fields(&mut block)
    }

    /// Reads the fields, which PROFIBUS has without a block header.
    pub fn read_fields(block: &mut ByteReader<'_>) -> Result<Im0> {
        Ok(Im0 {
            vendor_id: block.u16()?,
            order_id: block.array()?,
            serial_number: block.array()?,
            hardware_revision: block.u16()?,
            software_revision: SoftwareRevision {
                prefix: block.u8()?,
                functional_enhancement: block.u8()?,
                bug_fix: block.u8()?,
                internal_change: block.u8()?,
            },
            revision_counter: block.u16()?,
            profile_id: block.u16()?,
            profile_specific_type: block.u16()?,
            im_version: block.array()?,
            im_supported: block.u16()?,
        })
    }

    /// Reads the record 0xAFF0.
    pub fn parse(octets: &[u8]) -> Result<Im0> {
        Im0::read(&mut ByteReader::new("I&M0", octets))
    }

    /// Appends the block.
    pub fn write(&self, out: &mut Vec<u8>) {
        BlockHeader::write(BlockType::IM0, out, |out| self.write_fields(out));
    }

    /// Appends the fields without a block header.
    pub fn write_fields(&self, out: &mut Vec<u8>) {
        let software = self.software_revision;
        out.put_u16(self.vendor_id);
        out.put(&self.order_id);
        out.put(&self.serial_number);
        out.put_u16(self.hardware_revision);
        out.put(&[software.prefix, software.functional_enhancement, software.bug_fix, software.internal_change]);
        out.put_u16(self.revision_counter);
        out.put_u16(self.profile_id);
        out.put_u16(self.profile_specific_type);
        out.put(&self.im_version);
        out.put_u16(self.im_supported);
    }
}

impl ImText {
    /// The type of the block.
    pub fn block(&self) -> BlockType {
        match self {
            ImText::Tag { .. } => BlockType::IM1,
            ImText::Date(_) => BlockType::IM2,
            ImText::Descriptor(_) => BlockType::IM3,
            ImText::Signature(_) => BlockType::IM4,
        }
    }

    /// Reads the block with its header; fails on another type or version.
    pub fn read(reader: &mut ByteReader<'_>) -> Result<ImText> {
        let (header, mut block) = BlockHeader::read(reader)?;
        Ok(match (header.kind, header.version_high, header.version_low) {
            (BlockType::IM1, 1, 0) => ImText::Tag { function: block.array()?, location: block.array()? },
            (BlockType::IM2, 1, 0) => ImText::Date(block.array()?),
            (BlockType::IM3, 1, 0) => ImText::Descriptor(block.array()?),
            (BlockType::IM4, 1, 0) => ImText::Signature(block.array()?),
            (kind, ..) => return Err(block.wrong("BlockType", 6, "0x0021 to 0x0024 in version 1.0", kind.0.into())),
        })
    }

    /// Reads one of the records 0xAFF1 to 0xAFF4.
    pub fn parse(octets: &[u8]) -> Result<ImText> {
        ImText::read(&mut ByteReader::new("I&M1-4", octets))
    }

    /// Appends the block.
    pub fn write(&self, out: &mut Vec<u8>) {
        BlockHeader::write(self.block(), out, |out| match self {
            ImText::Tag { function, location } => {
                out.put(function);
                out.put(location);
            }
            ImText::Date(text) => out.put(text),
            ImText::Descriptor(text) | ImText::Signature(text) => out.put(text),
        });
    }
}
