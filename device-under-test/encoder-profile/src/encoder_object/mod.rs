//! The encoder object: the application of all PROFINET encoders of the encoder profile.
//!
//! A model provides its [`ManualFacts`](crate::facts::ManualFacts), plain data from its manual, and the functions that no other
//! manual has, as a [`EncoderModel`]. This module has start-up, cyclic exchange, presets and their memory, errors and
//! diagnoses, parameters and station names.
//!
//! This module must not depend on a model or on the stack. Where two manuals differ, it uses the facts or calls the
//! model.

mod cyclic;
pub mod deviations;
mod device;
mod diagnosis;
pub mod hooks;
mod memory;
mod model;
mod modules;
pub mod names;
mod parameters;
mod power;
mod powered;
mod records;
mod stand;
mod start;

pub use crate::profidrive::parameters::{double_word, double_words, octets, octets_of, word, words};
pub use device::{EncoderObject, EncoderSpecimen};
pub use memory::PresetSource;
pub use model::EncoderModel;
pub use modules::{ACCESS_POINT_SUBSLOT, ENCODER_API, ENCODER_SLOT};
pub use powered::{ConnectionPhase, NonVolatileData, PoweredEncoder, StandFaults, VolatileData};
