//! A parameter with its values: PROFIdrive profile, parameter model. The formats are those that the encoders answer with.

use alloc::vec;
use alloc::vec::Vec;
use core::ops::Range;
use wire::profidrive::Format;

/// How the values of a parameter belong together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// One value, of several octets for a string; it has no subindex.
    Value,
    /// Elements with a subindex each.
    Array,
    /// A string that is given whole for 0 elements or 1, or a part of it for more, from the subindex on.
    Octets,
}

/// A parameter at one instant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// In which format values are given: [`Format::WORD`], [`Format::DOUBLE_WORD`] or [`Format::OCTET_STRING`].
    pub format: Format,
    /// How its values belong together.
    pub shape: Shape,
    /// The values that can be written.
    pub writable: Range<usize>,
    /// Its values.
    pub values: Vec<u64>,
}

impl Parameter {
    /// The same parameter, but writable.
    pub fn writable(self) -> Parameter {
        Parameter { writable: 0..self.values.len(), ..self }
    }
}

/// A parameter of one value of 16 bits.
pub fn word(value: u64) -> Parameter {
    Parameter { shape: Shape::Value, ..words(vec![value]) }
}

/// A parameter of one value of 32 bits.
pub fn double_word(value: u64) -> Parameter {
    Parameter { shape: Shape::Value, ..double_words(vec![value]) }
}

/// A parameter with elements of 16 bits.
pub fn words(values: Vec<u64>) -> Parameter {
    Parameter { format: Format::WORD, shape: Shape::Array, writable: 0..0, values }
}

/// A parameter with elements of 32 bits.
pub fn double_words(values: Vec<u64>) -> Parameter {
    Parameter { format: Format::DOUBLE_WORD, ..words(values) }
}

/// A parameter of octets, of which there is one value.
pub fn octets(octets: [u8; 2]) -> Parameter {
    Parameter { shape: Shape::Value, ..octets_of(&octets) }
}

/// A string of octets, of which a part can be read.
pub fn octets_of(octets: &[u8]) -> Parameter {
    let values = octets.iter().copied().map(u64::from).collect();
    Parameter { format: Format::OCTET_STRING, shape: Shape::Octets, ..words(values) }
}
