//! A parameter and its values (PROFIdrive profile, parameter model). The formats are those in the responses of
//! encoders.

use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;
use wire::profidrive::Format;

/// The structure of the values of a parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// One value without a subindex. A string is one value of several bytes.
    Value,
    /// Elements, each with a subindex.
    Array,
    /// A string. A request for 0 elements or 1 gets all of it; a request for more gets a part from the subindex on.
    Octets,
}

/// A parameter with its current values.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// The format of the values: [`Format::WORD`], [`Format::DOUBLE_WORD`] or [`Format::OCTET_STRING`].
    pub format: Format,
    /// The structure of the values.
    pub shape: Shape,
    /// The indices of the writable values.
    pub writable: Range<usize>,
    pub values: Vec<u64>,
}

impl Parameter {
    /// The same parameter with all values writable.
    pub fn writable(self) -> Parameter {
        Parameter { writable: 0..self.values.len(), ..self }
    }
}

/// A parameter with one 16-bit value.
pub fn word(value: u64) -> Parameter {
    Parameter { shape: Shape::Value, ..words(vec![value]) }
}

/// A parameter with one 32-bit value.
pub fn double_word(value: u64) -> Parameter {
    Parameter { shape: Shape::Value, ..double_words(vec![value]) }
}

/// A parameter with 16-bit elements.
pub fn words(values: Vec<u64>) -> Parameter {
    Parameter { format: Format::WORD, shape: Shape::Array, writable: 0..0, values }
}

/// A parameter with 32-bit elements.
pub fn double_words(values: Vec<u64>) -> Parameter {
    Parameter { format: Format::DOUBLE_WORD, ..words(values) }
}

/// A parameter with one value of two bytes.
pub fn octets(octets: [u8; 2]) -> Parameter {
    Parameter { shape: Shape::Value, ..octets_of(&octets) }
}

/// A byte string that can be read in parts.
pub fn octets_of(octets: &[u8]) -> Parameter {
    let values = octets.iter().copied().map(u64::from).collect();
    Parameter { format: Format::OCTET_STRING, shape: Shape::Octets, ..words(values) }
}
