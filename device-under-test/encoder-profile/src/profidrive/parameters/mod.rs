//! The parameter manager of the base mode parameter access: PROFIdrive profile, base mode; XAC77 manual, chapter 11; SICK
//! AFS60/AFM60 manual, 3.5.
//!
//! [`Manager`] turns a request into its response, [`Responses`] keeps responses until they are fetched. Which parameters there
//! are and what they hold is the affair of a [`Parameters`]. The order of the checks, the error numbers and the way a response
//! is fetched are those of the profile; the manuals print only numbers and names.

mod acceptance;
mod manager;
mod responses;
#[cfg(test)]
mod tests;

pub use acceptance::is_of_type;
pub use manager::{Exchange, Manager};
pub use responses::Responses;

use alloc::vec::Vec;
use core::ops::Range;
use wire::profidrive::{ErrorNumber, Format};

/// The most parameters of a request: PROFIdrive, base mode.
pub const MAX_PARAMETERS: u8 = 39;
/// The most elements of one parameter that a request addresses: PROFIdrive, base mode.
pub const MAX_ELEMENTS: u8 = 234;
/// The most octets of a request or a response: PROFIdrive, base mode.
pub const MAX_OCTETS: usize = 240;

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

/// The parameters that a parameter manager gives access to.
pub trait Parameters {
    /// The parameter of this number, if there is one.
    fn parameter(&self, number: u16) -> Option<Parameter>;

    /// Gives the writable values of a parameter from a subindex on others of its format, or says why not; then none of
    /// them is changed.
    fn write(&mut self, number: u16, subindex: u16, values: &[u64]) -> Result<(), ErrorNumber>;
}

/// Why a request is refused as a whole and has no response.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BadRequest {
    /// Octets are missing.
    TooShort,
    /// It has no parameter, or more than [`MAX_PARAMETERS`].
    Count,
}
