//! The encoder profile of PROFIdrive, device side: telegrams, sensor interface, sign of life, parameters.
//!
//! This module has the common part of the profile. What a manual adds or leaves out is in its facts and its model.
//! Decisions go through [`checks`]. Steps of computations that a deviation may change have their own traits, next to
//! the code that takes them.
//!
//! This module must not depend on frames, records, connections or the measurement of positions.

pub mod checks;
pub mod control;
pub mod life_sign;
pub mod parameters;
pub mod preset_trigger;
pub mod sensor;
pub mod telegram;
pub mod user_parameters;
