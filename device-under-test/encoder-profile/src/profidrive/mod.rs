//! The encoder profile of PROFIdrive, device side: telegrams, sensor interface, sign of life, parameters.
//!
//! What encoders that follow the profile share stands here; what a manual adds or leaves out is in its facts and its model. Decisions go
//! through [`checks`], and the few steps of arithmetic that a deviation may change are traits beside the part that takes them.
//!
//! This module must not know frames, records or connections, nor how a position is measured.

pub mod checks;
pub mod control;
pub mod life_sign;
pub mod parameters;
pub mod preset_trigger;
pub mod sensor;
pub mod telegram;
pub mod user_parameters;
