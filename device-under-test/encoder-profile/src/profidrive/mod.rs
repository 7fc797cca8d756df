//! The encoder profile of PROFIdrive, device side: telegrams, sensor interface, sign of life, parameters.
//!
//! What encoders that follow the profile share stands here, each piece with a struct `Rules` that says where bugs can
//! be put. What a manual adds or leaves out is in the models.
//!
//! This room must not know frames, records or connections, nor how a position is measured.

pub mod control;
pub mod life_sign;
pub mod parameters;
pub mod preset_trigger;
pub mod sensor;
pub mod telegram;
pub mod user_parameters;
