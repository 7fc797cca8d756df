//! The parameter manager of the base mode parameter access: PROFIdrive profile, base mode; XAC77 manual, chapter 11; SICK
//! AFS60/AFM60 manual, 3.5.
//!
//! [`ParameterManager`] answers a request, [`PendingResponses`] keeps responses until they are fetched. A [`ParameterStore`] provides the
//! parameters and their values. The order of the checks, the error numbers and the fetching of responses follow the
//! profile; the manuals only list numbers and names.

mod acceptance;
mod manager;
mod parameter;
mod responses;
#[cfg(test)]
mod tests;

pub use acceptance::is_of_type;
pub use manager::{ParameterExchange, ParameterManager};
pub use parameter::{ParameterContent, ParameterShape, double_word, double_words, octets, octets_of, word, words};
pub use responses::PendingResponses;

use wire::profidrive::ErrorNumber;

/// Largest number of parameters in a request (PROFIdrive, base mode).
pub const MAX_PARAMETERS: u8 = 39;
/// Largest number of elements of one parameter in a request (PROFIdrive, base mode).
pub const MAX_ELEMENTS: u8 = 234;
/// Longest request or response in bytes (PROFIdrive, base mode).
pub const MAX_OCTETS: usize = 240;

/// The parameters to which a parameter manager gives access.
pub trait ParameterStore {
    /// The parameter of this number, if there is one.
    fn parameter(&self, number: u16) -> Option<ParameterContent>;

    /// Writes values, in the format of the parameter, to its writable elements from `subindex` on. On an error no
    /// element changes.
    fn write(&mut self, number: u16, subindex: u16, values: &[u64]) -> Result<(), ErrorNumber>;
}

/// Why a whole request is refused without a response.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BadRequest {
    /// The request is truncated.
    TooShort,
    /// The request has no parameter, or more than [`MAX_PARAMETERS`].
    Count,
}
