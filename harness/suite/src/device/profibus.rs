//! What only devices on PROFIBUS have: how they are parameterised, and what their diagnosis holds.
//!
//! This is data about devices; who sends which frame is told elsewhere.

use super::{Origin, WordTable};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use wire::profibus::diag::{Status1, Status2, Status3};

/// What `device.yaml` says of a device on PROFIBUS alone.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct ProfibusFacts {
    /// Ident number: the one number for a type of device; none names the vendor.
    pub ident: u16,
    /// Where the ident number comes from.
    pub ident_origin: Origin,
    /// The station address that a trial finds it at; the bench of a live device says another one.
    pub address: u8,
    /// Set_Prm behind its seven octets.
    pub set_prm: UserParameters,
    /// Slave_Diag.
    pub diagnosis: Diagnosis,
    /// The slot of the data set that takes parameter requests and gives responses.
    pub parameter_slot: u8,
}

/// The octets of Set_Prm behind the seven that every slave has: those of DP-V1 where the slave knows them, then the user octets,
/// whose fields are those of the record [`UserParameters::RECORD`].
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct UserParameters {
    /// The three octets of DP-V1 as a connection sends them that says nothing else; none for a slave without DP-V1.
    pub dpv1: Option<[u8; 3]>,
    /// Whether the slave takes structured blocks. A start-up in isochronous mode sends them: the user octets in one (type 129, slot
    /// 0), then the times (type 4); any other sends the user octets as they are.
    pub structured: bool,
}

impl UserParameters {
    /// Index of the record in [`super::Device::records`] that has the user octets as its fields, on PROFIBUS the only one.
    pub const RECORD: usize = 0;
    /// What that record is called.
    pub const NAME: &'static str = "set_prm";
}

/// The layout of Slave_Diag as a manual tells it.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct Diagnosis {
    /// The lengths that it can have, ascending, in octets; with blocks the shortest and the longest.
    pub lengths: Vec<usize>,
    /// Fields at fixed places.
    pub fields: Vec<DiagnosisField>,
    /// Blocks that are all alike, one for each error.
    pub blocks: Option<DiagnosisBlocks>,
}

/// A field of the diagnosis at a fixed place; it has no value in a diagnosis that is too short for it.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct DiagnosisField {
    /// Its name.
    pub name: String,
    /// Its first octet, counted from 0 at the first of the six standard octets.
    pub octet: usize,
    /// Number of octets that it lies in; more than eight are no number but octets.
    pub octets: usize,
    /// For bits in one octet: the lowest bit and how many.
    pub bits: Option<(u32, u32)>,
    /// Whether it is a two's complement.
    pub signed: bool,
    /// The words for its numbers as the type of the name.
    #[serde(with = "expression::pool::maybe_table")]
    pub table: Option<Arc<WordTable>>,
    /// Where the layout comes from.
    pub origin: Origin,
}

impl DiagnosisField {
    /// Whether it is a number, and no more than octets.
    pub fn is_number(&self) -> bool {
        self.octets <= NUMBER_OCTETS
    }

    /// Its octets in a diagnosis; none if it is too short.
    pub fn octets_in<'d>(&self, diagnosis: &'d [u8]) -> Option<&'d [u8]> {
        diagnosis.get(self.octet..self.octet.checked_add(self.octets)?)
    }

    /// Its number in a diagnosis; none if it is too short, or the field no number.
    pub fn number_in(&self, diagnosis: &[u8]) -> Option<i128> {
        let octets = self.octets_in(diagnosis)?;
        if !self.is_number() {
            return None;
        }
        let whole = octets.iter().fold(0_u64, |number, octet| number << 8 | u64::from(*octet));
        let (low, width) = self.bits.unwrap_or((0, 8 * octets.len() as u32));
        let number = i128::from(whole >> low) & ((1_i128 << width) - 1);
        let negative = self.signed && number >> (width - 1) != 0;
        Some(if negative { number - (1_i128 << width) } else { number })
    }
}

/// The most octets of a number.
pub const NUMBER_OCTETS: usize = 8;

/// Blocks of a diagnosis that are all alike, one behind the other up to the end.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct DiagnosisBlocks {
    /// How many octets stand before the first block.
    pub after: usize,
    /// The octets of a block; none where the code stands, which is one octet.
    pub pattern: Vec<Option<u8>>,
    /// The words for the codes: a table of `codes` as a type.
    #[serde(with = "expression::pool::table")]
    pub table: Arc<WordTable>,
}

impl DiagnosisBlocks {
    /// The codes of all blocks in a diagnosis, in its order; none if something else stands there or a block is cut off.
    pub fn codes(&self, diagnosis: &[u8]) -> Option<Vec<u8>> {
        let blocks = diagnosis.get(self.after..).unwrap_or_default().chunks(self.pattern.len().max(1));
        blocks.map(|block| self.code(block)).collect()
    }

    fn code(&self, block: &[u8]) -> Option<u8> {
        let fits = block.len() == self.pattern.len()
            && self.pattern.iter().zip(block).all(|(wanted, octet)| wanted.is_none_or(|wanted| wanted == *octet));
        let place = self.pattern.iter().position(Option::is_none)?;
        if fits { block.get(place).copied() } else { None }
    }
}

/// What is looked at in a Slave_Diag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize)]
pub enum DiagnosisName {
    /// `diag.length`: how many octets it has.
    Length,
    /// `diag.bytes`: the octets.
    Bytes,
    /// `diag.ident`: the ident number.
    Ident,
    /// `diag.master`: the address of the master that parameterised the slave; 255 for none.
    Master,
    /// `diag.errors`: the words of the blocks, as a set.
    Errors,
    /// A standard bit: of the octet 0, 1 or 2.
    Bit {
        /// The octet.
        octet: u8,
        /// The bit in it, 0 is the lowest.
        bit: u8,
    },
    /// `diag.master_lock`: the slave belongs to another master than the one that asks, which masters conclude from the address
    /// in the diagnosis; the slave itself sends the bit as 0.
    MasterLock,
    /// A field (index into [`Diagnosis::fields`]).
    Field(usize),
}

impl DiagnosisName {
    /// What is called by this word, the name of a field apart.
    pub fn by_word(word: &str) -> Option<DiagnosisName> {
        DiagnosisName::words().find(|(known, _)| *known == word).map(|(_, name)| name)
    }

    /// Every word with what it calls, the names of fields apart.
    pub fn words() -> impl Iterator<Item = (&'static str, DiagnosisName)> {
        let named = [
            ("length", DiagnosisName::Length),
            ("bytes", DiagnosisName::Bytes),
            ("ident", DiagnosisName::Ident),
            ("master", DiagnosisName::Master),
            ("errors", DiagnosisName::Errors),
        ];
        let places = (0..3).flat_map(|octet| (0..8).map(move |bit| (octet, bit)));
        let bits = places.filter_map(|(octet, bit)| {
            let name = match (octet, 1 << bit) {
                (0, mask) if mask == Status1::MASTER_LOCK.0 => DiagnosisName::MasterLock,
                _ => DiagnosisName::Bit { octet, bit },
            };
            Some((status_word(octet, bit)?, name))
        });
        named.into_iter().chain(bits)
    }
}

/// The word for a bit of one of the first three octets.
pub(super) fn status_word(octet: u8, bit: u8) -> Option<&'static str> {
    let mask = 1_u8.checked_shl(bit.into())?;
    match octet {
        0 => Status1(mask).words().next(),
        1 => Status2(mask).words().next(),
        2 => Status3(mask).words().next(),
        _ => None,
    }
}
