//! Facts of devices on PROFIBUS: parameter data and the layout of the diagnosis.

use super::{Origin, WordTable};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::Duration;
use wire::profibus::diag::{Status1, Status2, Status3};

/// The part of `device.yaml` that only devices on PROFIBUS have.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct ProfibusFacts {
    /// Ident number, which identifies the device type.
    pub ident: u16,
    /// Source of the ident number.
    pub ident_origin: Origin,
    /// Station address in trials; a bench file can set another one.
    pub address: u8,
    /// User parameter data of Set_Prm.
    pub set_prm: UserPrmLayout,
    /// Slave_Diag.
    pub diagnosis: DiagnosisLayout,
    /// The shortest time between two polls (Min_Slave_Intervall of its GSD); zero if it is not known.
    pub min_slave_interval: Duration,
    /// Slot of the data set for parameter requests and responses.
    pub parameter_slot: u8,
}

/// The bytes of Set_Prm after the seven standard bytes: the DP-V1 bytes if the slave supports DP-V1, then the user parameter
/// data, whose fields are those of the record [`UserPrmLayout::RECORD`].
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct UserPrmLayout {
    /// Default values of the three DP-V1 bytes; `None` for a slave without DP-V1.
    pub dpv1: Option<[u8; 3]>,
    /// Whether the slave accepts structured blocks. A start-up in isochronous mode sends the user parameter data in a block (type
    /// 129, slot 0), then the times (type 4); other start-ups send the user parameter data without blocks.
    pub structured: bool,
}

impl UserPrmLayout {
    /// Index of the record in [`super::DeviceDescription::records`] for the user parameter data, the only record on PROFIBUS.
    pub const RECORD: usize = 0;
    /// Name of that record.
    pub const NAME: &'static str = "set_prm";
}

/// The layout of Slave_Diag according to the manual.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct DiagnosisLayout {
    /// Possible lengths in bytes, ascending; with blocks the shortest and the longest.
    pub lengths: Vec<usize>,
    /// Fields at fixed offsets.
    pub fields: Vec<DiagnosisField>,
    /// Blocks of the same layout, one for each error.
    pub blocks: Option<DiagnosisBlocks>,
}

/// A field of the diagnosis at a fixed offset; it has no value in a diagnosis that is too short.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct DiagnosisField {
    pub name: String,
    /// Offset of its first byte, 0 is the first of the six standard bytes.
    pub octet: usize,
    /// Length in bytes; a field of more than eight bytes is a byte string, not a number.
    pub octets: usize,
    /// For bits in one byte: lowest bit and number of bits.
    pub bits: Option<(u32, u32)>,
    /// Whether it is in two's complement.
    pub signed: bool,
    /// Word table of its numbers.
    #[serde(with = "expression::pool::maybe_table")]
    pub table: Option<Arc<WordTable>>,
    /// Source of the layout.
    pub origin: Origin,
}

impl DiagnosisField {
    /// Whether it is a number, not a byte string.
    pub fn is_number(&self) -> bool {
        self.octets <= NUMBER_OCTETS
    }

    /// Its bytes in a diagnosis; `None` if the diagnosis is too short.
    pub fn octets_in<'d>(&self, diagnosis: &'d [u8]) -> Option<&'d [u8]> {
        diagnosis.get(self.octet..self.octet.checked_add(self.octets)?)
    }

    /// Its number in a diagnosis; `None` if the diagnosis is too short or the field is not a number.
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

/// Maximum length of a number in bytes.
pub const NUMBER_OCTETS: usize = 8;

/// Blocks of the same layout that follow each other up to the end of the diagnosis.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct DiagnosisBlocks {
    /// Number of bytes before the first block.
    pub after: usize,
    /// The bytes of a block; `None` at the code, which is one byte.
    pub pattern: Vec<Option<u8>>,
    /// Word table of the codes.
    #[serde(with = "expression::pool::table")]
    pub table: Arc<WordTable>,
}

impl DiagnosisBlocks {
    /// The codes of all blocks in a diagnosis, in order; `None` if a block has another layout or is incomplete.
    pub fn codes(&self, diagnosis: &[u8]) -> Option<Vec<u8>> {
        let blocks = diagnosis.get(self.after..).unwrap_or_default().chunks(self.pattern.len().max(1));
        blocks.map(|block| self.code(block)).collect()
    }

    fn code(&self, block: &[u8]) -> Option<u8> {
        let fits = block.len() == self.pattern.len()
            && self
                .pattern
                .iter()
                .zip(block)
                .all(|(expected, octet)| expected.is_none_or(|expected| expected == *octet));
        let place = self.pattern.iter().position(Option::is_none)?;
        if fits { block.get(place).copied() } else { None }
    }
}

/// A value of Slave_Diag.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize)]
pub enum DiagnosisName {
    /// `diag.length`: length in bytes.
    Length,
    /// `diag.bytes`: the bytes.
    Bytes,
    /// `diag.ident`: the ident number.
    Ident,
    /// `diag.master`: address of the master that parameterised the slave; 255: none.
    Master,
    /// `diag.errors`: the words of the blocks, as a set.
    Errors,
    /// A standard bit of byte 0, 1 or 2.
    Bit {
        /// Offset of the byte.
        octet: u8,
        /// The bit, 0 is the least significant.
        bit: u8,
    },
    /// `diag.master_lock`: the slave is parameterised by another master. The requesting master derives it from the address in the
    /// diagnosis; the slave sends the bit as 0.
    MasterLock,
    /// `diag.alarm_type` and the like: a part of the first alarm of DP-V1 in the diagnosis.
    Alarm(DiagnosedAlarmPart),
    /// A field (index into [`DiagnosisLayout::fields`]).
    Field(usize),
}

/// A part of the first alarm of DP-V1 in a diagnosis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize)]
pub enum DiagnosedAlarmPart {
    /// `diag.alarm_type`: its type; 0 without an alarm.
    Type,
    /// `diag.alarm_slot`: its slot.
    Slot,
    /// `diag.alarm_change`: bits 0 and 1 of its specifier: 1 appears, 2 disappears, 3 disappears and others remain.
    Change,
    /// `diag.alarm_specifier`: its specifier, which Alarm_Ack returns.
    Specifier,
}

impl DiagnosisName {
    /// The value with this name, except fields.
    pub fn by_word(word: &str) -> Option<DiagnosisName> {
        DiagnosisName::words().find(|(known, _)| *known == word).map(|(_, name)| name)
    }

    /// All names with their values, except fields.
    pub fn words() -> impl Iterator<Item = (&'static str, DiagnosisName)> {
        let named = [
            ("length", DiagnosisName::Length),
            ("bytes", DiagnosisName::Bytes),
            ("ident", DiagnosisName::Ident),
            ("master", DiagnosisName::Master),
            ("errors", DiagnosisName::Errors),
            ("alarm_type", DiagnosisName::Alarm(DiagnosedAlarmPart::Type)),
            ("alarm_slot", DiagnosisName::Alarm(DiagnosedAlarmPart::Slot)),
            ("alarm_change", DiagnosisName::Alarm(DiagnosedAlarmPart::Change)),
            ("alarm_specifier", DiagnosisName::Alarm(DiagnosedAlarmPart::Specifier)),
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

/// The name of a bit of the first three bytes.
pub(super) fn status_word(octet: u8, bit: u8) -> Option<&'static str> {
    let mask = 1_u8.checked_shl(bit.into())?;
    match octet {
        0 => Status1(mask).words().next(),
        1 => Status2(mask).words().next(),
        2 => Status3(mask).words().next(),
        _ => None,
    }
}
