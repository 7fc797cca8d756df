//! The parameter manager of the base mode parameter access: PROFIdrive profile, base mode; XAC77 manual, chapter 11; SICK
//! AFS60/AFM60 manual, 3.5.
//!
//! [`Manager`] turns a request into its response, [`Responses`] keeps responses until they are fetched. Which parameters there
//! are and what they hold is the affair of a [`Parameters`]. The order of the checks, the error numbers and the way a response
//! is fetched are those of the profile; the manuals print only numbers and names.

mod acceptance;
mod manager;
mod parameter;
mod responses;
#[cfg(test)]
mod tests;

pub use acceptance::is_of_type;
pub use manager::{Exchange, Manager};
pub use parameter::{Parameter, Shape, double_word, double_words, octets, octets_of, word, words};
pub use responses::Responses;

use wire::profidrive::ErrorNumber;

/// The most parameters of a request: PROFIdrive, base mode.
pub const MAX_PARAMETERS: u8 = 39;
/// The most elements of one parameter that a request addresses: PROFIdrive, base mode.
pub const MAX_ELEMENTS: u8 = 234;
/// The most octets of a request or a response: PROFIdrive, base mode.
pub const MAX_OCTETS: usize = 240;

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
