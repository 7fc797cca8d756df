//! The encoder object: the measuring task that all encoders with PROFINET of the encoder profile share.
//!
//! A model gives its [`Facts`](crate::facts::Facts), plain data from its manual, and what no other has as a [`Model`]. Here are the
//! start-up, the cyclic exchange, presets and their memory, errors and diagnoses, parameters and station names.
//!
//! This module must not know any model: where two manuals differ it asks the facts or the model. Nor the stack.

mod cyclic;
pub mod deviations;
mod device;
mod diagnosis;
pub mod hooks;
mod live;
mod memory;
mod model;
pub mod names;
mod parameters;
mod places;
mod power;
mod records;
mod stand;
mod start;

pub use crate::profidrive::parameters::{double_word, double_words, octets, octets_of, word, words};
pub use device::{EncoderObject, Piece};
pub use live::{Faults, Live, Phase, Ram, Store};
pub use memory::Source;
pub use model::Model;
pub use places::{ACCESS_POINT_SUBSLOT, ENCODER_API, ENCODER_SLOT};
