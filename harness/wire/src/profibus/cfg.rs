//! Chk_Cfg and Get_Cfg: how many octets of inputs and outputs there are, as identifiers.
//!
//! This room must not know which module has which identifier: that is told by the GSD. Source: IEC 61158-6-3, Cfg_Data.

use crate::error::Result;
use crate::octets::{Append, Reader};
use alloc::vec::Vec;

/// How many octets or words there are, and over what they are consistent.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Length {
    /// How many, 1 to 16 in the general format, 1 to 64 in the special one.
    pub count: u8,
    /// Words of two octets, else octets.
    pub words: bool,
    /// The whole is consistent, else each octet or word is.
    pub whole: bool,
}

/// An identifier of the configuration.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Identifier {
    /// General format, one octet: bit 7 consistent over the whole, bit 6 words, bit 5 outputs, bit 4 inputs, bits 3-0 count less 1.
    General {
        /// There are outputs.
        outputs: bool,
        /// There are inputs.
        inputs: bool,
        /// How many of each.
        length: Length,
    },
    /// Special format: octet 0 bit 7 a length of outputs follows, bit 6 one of inputs, bits 5-4 00, bits 3-0 how many octets of
    /// the maker; then the length of the outputs, that of the inputs, the octets of the maker. A length: bit 7 consistent over
    /// the whole, bit 6 words, bits 5-0 count less 1. Without both it is an empty slot.
    Special {
        /// How many outputs there are.
        outputs: Option<Length>,
        /// How many inputs there are.
        inputs: Option<Length>,
        /// What the maker has besides.
        maker: Maker,
    },
}

/// What the maker has to say in an identifier of the special format.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Maker {
    /// 0 to 14 octets, which the slave compares with its own.
    Octets(Vec<u8>),
    /// 15: no octets, and the slave is not to compare its own; not allowed in Get_Cfg.
    NotCompared,
}

/// Octets of a configuration.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Sums {
    /// What the slave sends in Data_Exchange.
    pub inputs: usize,
    /// What the master sends in Data_Exchange.
    pub outputs: usize,
}

impl Length {
    /// How many octets it is.
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

    /// Reads identifiers to the end of `octets`, the data of a Chk_Cfg request or of a Get_Cfg answer, 1 to 244 octets.
    ///
    /// Fails where an identifier of the special format wants more octets than are left.
    pub fn parse_all(octets: &[u8]) -> Result<Vec<Identifier>> {
        let mut reader = Reader::new("Cfg_Data", octets);
        let mut identifiers = Vec::new();
        while !reader.is_empty() {
            identifiers.push(Identifier::read(&mut reader)?);
        }
        Ok(identifiers)
    }

    /// Reads one identifier.
    pub fn read(reader: &mut Reader<'_>) -> Result<Identifier> {
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
            15 => Maker::NotCompared,
            count => Maker::Octets(reader.take(count.into())?.to_vec()),
        };
        Ok(Identifier::Special { outputs, inputs, maker })
    }

    /// Appends the identifier; the caller sees to it that counts and octets of the maker fit.
    pub fn write(&self, out: &mut Vec<u8>) {
        match self {
            Identifier::General { outputs, inputs, length } => {
                let direction = u8::from(*outputs) << 5 | u8::from(*inputs) << 4;
                out.put_u8(direction | length.octet(Identifier::SHORT));
            }
            Identifier::Special { outputs, inputs, maker } => {
                let octets = match maker {
                    Maker::Octets(octets) => octets.as_slice(),
                    Maker::NotCompared => &[],
                };
                let count = if *maker == Maker::NotCompared { 15 } else { octets.len() as u8 & Identifier::SHORT };
                out.put_u8(u8::from(outputs.is_some()) << 7 | u8::from(inputs.is_some()) << 6 | count);
                for length in [outputs, inputs].into_iter().flatten() {
                    out.put_u8(length.octet(Identifier::LONG));
                }
                out.put(octets);
            }
        }
    }

    /// The outputs and how many there are.
    pub fn outputs(&self) -> Option<Length> {
        match self {
            Identifier::General { outputs, length, .. } => outputs.then_some(*length),
            Identifier::Special { outputs, .. } => *outputs,
        }
    }

    /// The inputs and how many there are.
    pub fn inputs(&self) -> Option<Length> {
        match self {
            Identifier::General { inputs, length, .. } => inputs.then_some(*length),
            Identifier::Special { inputs, .. } => *inputs,
        }
    }
}

/// The octets of inputs and outputs of all identifiers together.
pub fn sums(identifiers: &[Identifier]) -> Sums {
    let octets = |length: Option<Length>| length.map_or(0, Length::octets);
    Sums {
        inputs: identifiers.iter().map(|identifier| octets(identifier.inputs())).sum(),
        outputs: identifiers.iter().map(|identifier| octets(identifier.outputs())).sum(),
    }
}
