//! A parameter and its values (PROFIdrive profile, parameter model). The formats are those in the responses of
//! encoders.

use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;
use wire::profidrive::ParameterFormat;

/// The structure of the values of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterShape {
    /// One value without a subindex. A string is one value of several bytes.
    Value,
    /// Elements, each with a subindex.
    Array,
    /// A string. A request for 0 elements or 1 gets all of it; a request for more gets a part from the subindex on.
    Octets,
}

/// A parameter with its current values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParameterContent {
    /// The format of the values: [`ParameterFormat::WORD`], [`ParameterFormat::DOUBLE_WORD`] or [`ParameterFormat::OCTET_STRING`].
    pub format: ParameterFormat,
    /// The structure of the values.
    pub shape: ParameterShape,
    /// The indices of the writable values.
    pub writable: Range<usize>,
    pub values: Vec<u64>,
}

impl ParameterContent {
    /// The same parameter with all values writable.
    pub fn writable(self) -> ParameterContent {
        ParameterContent { writable: 0..self.values.len(), ..self }
    }
}

/// A parameter with one 16-bit value.
pub fn word(value: u64) -> ParameterContent {
    ParameterContent { shape: ParameterShape::Value, ..words(vec![value]) }
}

/// A parameter with one 32-bit value.
pub fn double_word(value: u64) -> ParameterContent {
    ParameterContent { shape: ParameterShape::Value, ..double_words(vec![value]) }
}

/// A parameter with 16-bit elements.
pub fn words(values: Vec<u64>) -> ParameterContent {
    ParameterContent { format: ParameterFormat::WORD, shape: ParameterShape::Array, writable: 0..0, values }
}

/// A parameter with 32-bit elements.
pub fn double_words(values: Vec<u64>) -> ParameterContent {
    ParameterContent { format: ParameterFormat::DOUBLE_WORD, ..words(values) }
}

/// A parameter with one value of two bytes.
pub fn octets(octets: [u8; 2]) -> ParameterContent {
    ParameterContent { shape: ParameterShape::Value, ..octets_of(&octets) }
}

/// A byte string that can be read in parts.
pub fn octets_of(octets: &[u8]) -> ParameterContent {
    let values = octets.iter().copied().map(u64::from).collect();
    ParameterContent { format: ParameterFormat::OCTET_STRING, shape: ParameterShape::Octets, ..words(values) }
}
