//! The modules and submodules that a controller expects.

use crate::codes::codes;
use crate::error::Result;
use crate::octets::{Append, ByteReader};
use alloc::vec::Vec;

codes! {
    /// The direction of the data, from the view of the controller: bits 0 and 1 of SubmoduleProperties.
    pub struct SubmoduleType(u8) {
        0 NO_IO no_io "Neither input nor output data.",
        1 INPUT input "Input data.",
        2 OUTPUT output "Output data.",
        3 INPUT_OUTPUT input_output "Input and output data.",
    }
}

/// The properties of an expected submodule: bits 0 and 1 type, 2 shared input, 3 and 4 reduced data lengths, 5 discard IOXS.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct SubmoduleProperties(pub u16);

impl SubmoduleProperties {
    /// Bit 2: another controller owns the submodule, this one only reads its inputs.
    pub const SHARED_INPUT: SubmoduleProperties = SubmoduleProperties(1 << 2);
    /// Bit 3: the input data have length 0 in this AR.
    pub const REDUCE_INPUT: SubmoduleProperties = SubmoduleProperties(1 << 3);
    /// Bit 4: the output data have length 0 in this AR.
    pub const REDUCE_OUTPUT: SubmoduleProperties = SubmoduleProperties(1 << 4);
    /// Bit 5: the frame has neither IOPS nor IOCS for this submodule.
    pub const DISCARD_IOXS: SubmoduleProperties = SubmoduleProperties(1 << 5);

    /// Whether all bits of `properties` are set.
    pub fn has(self, properties: SubmoduleProperties) -> bool {
        self.0 & properties.0 == properties.0
    }

    /// The direction of the data.
    pub fn submodule_type(self) -> SubmoduleType {
        SubmoduleType((self.0 & 0x3) as u8)
    }
}

impl From<SubmoduleType> for SubmoduleProperties {
    fn from(kind: SubmoduleType) -> SubmoduleProperties {
        SubmoduleProperties((kind.0 & 0x3).into())
    }
}

/// Lengths of one direction of a submodule. Bytes: 0-1 DataDescription, 2-3 SubmoduleDataLength, 4 LengthIOCS, 5 LengthIOPS.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct DataDescription {
    /// Bits 0 and 1: 1 input, 2 output.
    pub data_description: u16,
    /// Length of the data, in bytes.
    pub submodule_data_length: u16,
    /// Length of the IOCS in bytes, 1.
    pub length_iocs: u8,
    /// Length of the IOPS in bytes, 1.
    pub length_iops: u8,
}

impl DataDescription {
    /// Input data of `length` bytes with IOPS and IOCS of one byte each; with length 0 also for a submodule without data.
    pub fn input(length: u16) -> DataDescription {
        DataDescription { data_description: 1, submodule_data_length: length, length_iocs: 1, length_iops: 1 }
    }

    /// Output data of `length` bytes with IOPS and IOCS of one byte each.
    pub fn output(length: u16) -> DataDescription {
        DataDescription { data_description: 2, ..DataDescription::input(length) }
    }

    /// Whether these are output data.
    pub fn is_output(&self) -> bool {
        self.data_description & 0x3 == 2
    }
}

/// A submodule that the controller expects.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ExpectedSubmodule {
    /// The subslot.
    pub subslot_number: u16,
    /// SubmoduleIdentNumber, as in the GSDML file.
    pub submodule_ident_number: u32,
    /// The properties, including the direction of the data.
    pub submodule_properties: SubmoduleProperties,
    /// One description, or two (input, then output) for a submodule with both directions.
    pub data_descriptions: Vec<DataDescription>,
}

/// A module that the controller expects, within one API.
///
/// Bytes: 0-3 API, 4-5 slot, 6-9 ModuleIdentNumber, 10-11 ModuleProperties, 12-13 NumberOfSubmodules, then per submodule:
/// 0-1 subslot, 2-5 SubmoduleIdentNumber, 6-7 SubmoduleProperties, then its data descriptions.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ExpectedModule {
    /// The API that the submodules belong to.
    pub api: u32,
    /// The slot.
    pub slot_number: u16,
    /// ModuleIdentNumber, as in the GSDML file.
    pub module_ident_number: u32,
    /// Properties, 0.
    pub module_properties: u16,
    /// The submodules of the module.
    pub submodules: Vec<ExpectedSubmodule>,
}

/// ExpectedSubmoduleBlockReq: modules that the controller expects; a Connect may have any number of these blocks.
///
/// Bytes of the body: 0-1 NumberOfAPIs, then that many [`ExpectedModule`]s.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ExpectedSubmoduleBlockReq {
    /// The modules; the standard counts them as APIs.
    pub modules: Vec<ExpectedModule>,
}

impl ExpectedSubmoduleBlockReq {
    /// Reads the body of the block.
    pub fn read(reader: &mut ByteReader) -> Result<ExpectedSubmoduleBlockReq> {
        let mut modules = Vec::new();
        for _ in 0..reader.u16()? {
            modules.push(ExpectedModule::read(reader)?);
        }
        Ok(ExpectedSubmoduleBlockReq { modules })
    }

    /// Appends the body of the block.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put_u16(self.modules.len() as u16);
        for module in &self.modules {
            module.write(out);
        }
    }
}

impl ExpectedModule {
    fn read(reader: &mut ByteReader) -> Result<ExpectedModule> {
        let mut module = ExpectedModule {
            api: reader.u32()?,
            slot_number: reader.u16()?,
            module_ident_number: reader.u32()?,
            module_properties: reader.u16()?,
            submodules: Vec::new(),
        };
        for _ in 0..reader.u16()? {
            module.submodules.push(ExpectedSubmodule::read(reader)?);
        }
        Ok(module)
    }

    fn write(&self, out: &mut Vec<u8>) {
        out.put_u32(self.api);
        out.put_u16(self.slot_number);
        out.put_u32(self.module_ident_number);
        out.put_u16(self.module_properties);
        out.put_u16(self.submodules.len() as u16);
        for submodule in &self.submodules {
            submodule.write(out);
        }
    }
}

impl ExpectedSubmodule {
    fn read(reader: &mut ByteReader) -> Result<ExpectedSubmodule> {
        let mut submodule = ExpectedSubmodule {
            subslot_number: reader.u16()?,
            submodule_ident_number: reader.u32()?,
            submodule_properties: SubmoduleProperties(reader.u16()?),
            data_descriptions: Vec::new(),
        };
        let descriptions = match submodule.submodule_properties.submodule_type() {
            SubmoduleType::INPUT_OUTPUT => 2,
            _ => 1,
        };
        for _ in 0..descriptions {
            submodule.data_descriptions.push(DataDescription {
                data_description: reader.u16()?,
                submodule_data_length: reader.u16()?,
                length_iocs: reader.u8()?,
                length_iops: reader.u8()?,
            });
        }
        Ok(submodule)
    }

    fn write(&self, out: &mut Vec<u8>) {
        out.put_u16(self.subslot_number);
        out.put_u32(self.submodule_ident_number);
        out.put_u16(self.submodule_properties.0);
        for description in &self.data_descriptions {
            out.put_u16(description.data_description);
            out.put_u16(description.submodule_data_length);
            out.put(&[description.length_iocs, description.length_iops]);
        }
    }
}
