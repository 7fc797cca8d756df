//! The parameter manager of the base mode: it takes requests and keeps the response until it is fetched.
//!
//! Which parameters there are and what they hold is the affair of a [`Parameters`]. The order of the checks, the error
//! numbers and the way a response is fetched follow the PROFIdrive profile; the manuals print only numbers and names.

mod manager;
#[cfg(test)]
mod tests;

pub use manager::{Manager, fit, is_of_type};

use alloc::vec::Vec;
use core::ops::Range;
use wire::profidrive::{ErrorNumber, Format, ParameterError, ParameterValue, Request, RequestId, Response};

/// Parameters that a request may have; PROFIdrive, base mode.
pub const MAX_PARAMETERS: u8 = 39;
/// Elements that may be asked for at once; PROFIdrive, base mode.
pub const MAX_ELEMENTS: u8 = 234;
/// Octets of a request or response; PROFIdrive, base mode.
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

/// What a parameter manager manages.
pub trait Parameters {
    /// The parameter of this number, if there is one.
    fn parameter(&self, number: u16) -> Option<Parameter>;

    /// Gives the writable values of a parameter from a subindex on others of its format, or says why not; then none of
    /// them is changed.
    fn write(&mut self, number: u16, subindex: u16, values: &[u64]) -> Result<(), ErrorNumber>;
}

/// Why a request was not even answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BadRequest {
    /// Octets are missing.
    TooShort,
    /// It has no parameter, or more than [`MAX_PARAMETERS`].
    Count,
}

/// A request that was carried out.
#[derive(Debug)]
pub struct Exchange<'a> {
    /// What was asked for.
    pub request: &'a Request,
    /// What is to be answered.
    pub response: Response,
    /// The octets of the response before; empty at first.
    pub before: &'a [u8],
}

impl Exchange<'_> {
    /// The octets of the response.
    pub fn octets(&self) -> Vec<u8> {
        let mut octets = Vec::new();
        self.response.write(&mut octets);
        octets
    }
}

/// Where bugs can be put into the parameter manager.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// The octets of a request, from those received.
    pub received: fn(&[u8]) -> Vec<u8>,
    /// How a request is understood.
    pub understand: fn(Request) -> Request,
    /// Why a parameter is refused, from the kind of request, its number and the error that was found.
    pub refusal: fn(RequestId, u16, Option<ParameterError>) -> Option<ParameterError>,
    /// Whether this axis is served.
    pub axis: fn(u8) -> bool,
    /// Other attributes than the value are refused.
    pub attribute: bool,
    /// Elements behind the end of an array are refused.
    pub end_of_array: bool,
    /// A subindex is refused if the parameter is no array.
    pub array: bool,
    /// Whether a value in the first format is taken by a parameter of the second one.
    pub takes: fn(Format, Format) -> bool,
    /// Another number of values than of elements is refused.
    pub value_count: bool,
    /// Octets behind the last value are refused.
    pub surplus: bool,
    /// How many values of a parameter are written.
    pub stored: usize,
    /// A value is written after all checks, and not before them.
    pub checks_first: bool,
    /// The number of elements of a parameter that is no array may be 0.
    pub zero_elements: bool,
    /// The first element that is read, from the subindex and the number of elements.
    pub first_element: fn(u16, usize) -> u16,
    /// How many parameters of a request for values are answered.
    pub answered: usize,
    /// After a refused parameter the others are written.
    pub goes_on_after_error: bool,
    /// What is answered of values that may be too long for a response.
    pub fit: fn(Vec<ParameterValue>) -> Vec<ParameterValue>,
    /// The octets of a response.
    pub octets: fn(&Exchange<'_>) -> Vec<u8>,
    /// Octets that are missing are missing, and not those of the request before.
    pub length: bool,
    /// A response that was fetched has gone.
    pub fetched_once: bool,
    /// A response that was not fetched goes with the connection.
    pub forgets_at_end: bool,
    /// A response without octets is given where none is waiting.
    pub answers_nothing: bool,
    /// Whether the manager answers nothing any more after this request.
    pub hangs: fn(&[u8]) -> bool,
}

impl Default for Rules {
    fn default() -> Rules {
        Rules {
            received: <[u8]>::to_vec,
            understand: |request| request,
            refusal: |_, _, found| found,
            axis: |axis| axis <= 1,
            attribute: true,
            end_of_array: true,
            array: true,
            takes: is_of_type,
            value_count: true,
            surplus: true,
            stored: usize::MAX,
            checks_first: true,
            zero_elements: true,
            first_element: |subindex, _| subindex,
            answered: usize::MAX,
            goes_on_after_error: true,
            fit,
            octets: |exchange| exchange.octets(),
            length: true,
            fetched_once: true,
            forgets_at_end: true,
            answers_nothing: false,
            hangs: |_| false,
        }
    }
}
