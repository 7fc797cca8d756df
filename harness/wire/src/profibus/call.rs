//! CALL: functions with an index of their own behind index 255 of any slot, and the identification and maintenance data (I&M) there.
//!
//! A master writes the header to index 255, then reads index 255: the response begins with the same header. With data after the header
//! the write changes the function. Source: IEC 61158-6-3, Load Domain and Call; PI guideline on identification and maintenance functions,
//! part 1.

use crate::codes::codes;
use crate::error::Result;
use crate::octets::{Append, ByteReader};
use crate::profinet::blocks::im::Im0;
use alloc::vec::Vec;

/// The index of CALL in each slot.
pub const CALL_INDEX: u8 = 255;

codes! {
    /// The first byte of a record of index 255 (IEC 61158-6-3, Extended_Function_Num).
    pub struct ExtendedFunction(u8) {
        0x08 CALL call "Calls the function of an index.",
    }
}

codes! {
    /// The index of a function (FI_Index); 65000 to 65199 are identification and maintenance data.
    pub struct FunctionIndex(u16) {
        65000 IM0 im0 "Identification of the module.",
        65001 IM1 im1 "Function and location.",
        65002 IM2 im2 "Date of installation.",
        65003 IM3 im3 "Description.",
        65004 IM4 im4 "Signature.",
    }
}

impl FunctionIndex {
    /// I&M`number`, 0 to 199.
    pub fn im(number: u8) -> Option<FunctionIndex> {
        (number < 200).then(|| FunctionIndex(FunctionIndex::IM0.0 + u16::from(number)))
    }
}

/// A record of index 255.
///
/// Bytes: 0 Extended_Function_Num, 1 reserved, 2-3 FI_Index, then data, up to 236 bytes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Call {
    /// Extended_Function_Num.
    pub function: ExtendedFunction,
    /// Reserved, must be 0.
    pub reserved: u8,
    /// FI_Index.
    pub index: FunctionIndex,
    /// The data; empty in a request to read.
    pub data: Vec<u8>,
}

impl Call {
    /// The request to read the function with this index.
    pub fn read_of(index: FunctionIndex) -> Call {
        Call { function: ExtendedFunction::CALL, reserved: 0, index, data: Vec::new() }
    }

    /// Parses a record of index 255; fails if the header is incomplete.
    pub fn parse(octets: &[u8]) -> Result<Call> {
        let mut reader = ByteReader::new("CALL", octets);
        let (function, reserved) = (ExtendedFunction(reader.u8()?), reader.u8()?);
        let index = FunctionIndex(reader.u16()?);
        Ok(Call { function, reserved, index, data: reader.rest().to_vec() })
    }

    /// Appends the record.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put(&[self.function.0, self.reserved]);
        out.put_u16(self.index.0);
        out.put(&self.data);
    }
}

/// I&M0 of a module on PROFIBUS: ten bytes of the manufacturer before the fields that PROFINET has too.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DpIm0 {
    /// Manufacturer-specific, often blanks.
    pub header: [u8; 10],
    /// The fields.
    pub im0: Im0,
}

impl DpIm0 {
    /// Parses the data of the response to CALL; fails if they do not have 64 bytes.
    pub fn parse(octets: &[u8]) -> Result<DpIm0> {
        let mut reader = ByteReader::new("I&M0", octets);
        let record = DpIm0 { header: reader.array()?, im0: Im0::read_fields(&mut reader)? };
        reader.end("64 bytes")?;
        Ok(record)
    }

    /// Appends the 64 bytes.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put(&self.header);
        self.im0.write_fields(out);
    }
}
