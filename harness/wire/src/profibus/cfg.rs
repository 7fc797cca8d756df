//! Chk_Cfg and Get_Cfg: identifiers for the number of input and output bytes.
//!
//! This module must not know which module has which identifier: the GSD defines it. Source: IEC 61158-6-3, Cfg_Data.

use crate::error::Result;
use crate::octets::{Append, ByteReader};
use alloc::vec::Vec;

/// Number of bytes or words of inputs or outputs, and their consistency.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Length {
    /// Number of bytes or words: 1 to 16 in the general format, 1 to 64 in the special format.
    pub count: u8,
    /// Whether the unit is a word of two bytes; otherwise one byte.
    pub words: bool,
    /// Whether the data are consistent over the whole length; otherwise each byte or word is.
    pub whole: bool,
}

/// An identifier of the configuration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Identifier {
    /// General format, one byte: bit 7 consistent over the whole, bit 6 words, bit 5 outputs, bit 4 inputs, bits 3-0 count less 1.
    General {
        /// Whether there are outputs.
        outputs: bool,
        /// Whether there are inputs.
        inputs: bool,
        /// The length of each.
        length: Length,
    },
    /// Special format. Byte 0: bit 7 a length of outputs follows, bit 6 a length of inputs follows, bits 5-4 00, bits 3-0 number of
    /// manufacturer-specific bytes; then the length of the outputs, the length of the inputs, the manufacturer-specific bytes.
    /// A length: bit 7 consistent over the whole, bit 6 words, bits 5-0 count less 1. Without both lengths it is an empty slot.
    Special {
        /// The length of the outputs.
        outputs: Option<Length>,
        /// The length of the inputs.
        inputs: Option<Length>,
        /// The manufacturer-specific data.
        maker: ManufacturerData,
    },
}

/// The manufacturer-specific data in an identifier of the special format.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ManufacturerData {
    /// 0 to 14 bytes, which the slave compares with its own.
    Octets(Vec<u8>),
    /// 15: no bytes, and the slave must not compare its own; not allowed in Get_Cfg.
    NotCompared,
}

/// The number of input and output bytes of a configuration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct IoLengths {
    /// Bytes that the slave sends in Data_Exchange.
    pub inputs: usize,
    /// Bytes that the master sends in Data_Exchange.
    pub outputs: usize,
}

impl Length {
    /// The length in bytes.
    pub fn octets(self) -> usize {
        usize::from(self.count) * if self.words { 2 } else { 1 }
    }

    fn from_octet(octet: u8, mask: u8) -> Length {
        Length { count: (octet & mask) + 1, words: octet & 0x40 != 0, whole: octet & 0x80 != 0 }
    }

    fn octet(self, mask: u8) -> u8 {
        u8::from(self.whole) << 7 | u8::from(self.words) << 6 | self.count.wrapping_sub(1) & mask
    }
}

impl Identifier {
    const SHORT: u8 = 0x0F;
    const LONG: u8 = 0x3F;

    /// Parses the identifiers in `octets`, the data of a Chk_Cfg request or of a Get_Cfg response, 1 to 244 bytes.
    ///
    /// Fails if an identifier of the special format needs more bytes than are left.
    pub fn parse_all(octets: &[u8]) -> Result<Vec<Identifier>> {
        let mut reader = ByteReader::new("Cfg_Data", octets);
        let mut identifiers = Vec::new();
        while !reader.is_empty() {
            identifiers.push(Identifier::read(&mut reader)?);
        }
        Ok(identifiers)
    }

    /// Parses one identifier.
    pub fn read(reader: &mut ByteReader<'_>) -> Result<Identifier> {
        let head = reader.u8()?;
        if head & 0x30 != 0 {
            let length = Length::from_octet(head, Identifier::SHORT);
            return Ok(Identifier::General { outputs: head & 0x20 != 0, inputs: head & 0x10 != 0, length });
        }
        let mut length = |bit: u8| match head & bit {
            0 => Ok(None),
            _ => reader.u8().map(|octet| Some(Length::from_octet(octet, Identifier::LONG))),
        };
        let (outputs, inputs) = (length(0x80)?, length(0x40)?);
        let maker = match head & Identifier::SHORT {
            15 => ManufacturerData::NotCompared,
            count => ManufacturerData::Octets(reader.take(count.into())?.to_vec()),
        };
        Ok(Identifier::Special { outputs, inputs, maker })
    }

    /// Appends the identifier; the caller ensures that counts and manufacturer-specific bytes are in range.
    pub fn write(&self, out: &mut Vec<u8>) {
        match self {
            Identifier::General { outputs, inputs, length } => {
                let direction = u8::from(*outputs) << 5 | u8::from(*inputs) << 4;
                out.put_u8(direction | length.octet(Identifier::SHORT));
            }
            Identifier::Special { outputs, inputs, maker } => {
                let octets = match maker {
                    ManufacturerData::Octets(octets) => octets.as_slice(),
                    ManufacturerData::NotCompared => &[],
                };
                let count =
                    if *maker == ManufacturerData::NotCompared { 15 } else { octets.len() as u8 & Identifier::SHORT };
                out.put_u8(u8::from(outputs.is_some()) << 7 | u8::from(inputs.is_some()) << 6 | count);
                for length in [outputs, inputs].into_iter().flatten() {
                    out.put_u8(length.octet(Identifier::LONG));
                }
                out.put(octets);
            }
        }
    }

    /// The length of the outputs; `None` if there are none.
    pub fn outputs(&self) -> Option<Length> {
        match self {
            Identifier::General { outputs, length, .. } => outputs.then_some(*length),
            Identifier::Special { outputs, .. } => *outputs,
        }
    }

    /// The length of the inputs; `None` if there are none.
    pub fn inputs(&self) -> Option<Length> {
        match self {
            Identifier::General { inputs, length, .. } => inputs.then_some(*length),
            Identifier::Special { inputs, .. } => *inputs,
        }
    }
}

/// The number of input and output bytes of all identifiers together.
pub fn io_lengths(identifiers: &[Identifier]) -> IoLengths {
    let octets = |length: Option<Length>| length.map_or(0, Length::octets);
    IoLengths {
        inputs: identifiers.iter().map(|identifier| octets(identifier.inputs())).sum(),
        outputs: identifiers.iter().map(|identifier| octets(identifier.outputs())).sum(),
    }
}
