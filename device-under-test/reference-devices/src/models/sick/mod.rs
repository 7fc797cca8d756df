//! What the encoders of SICK share, whatever bus they are on: the round axis, the service log, settings with limits.
//!
//! This module must not know which of them it serves: each model holds these parts in its own state and feeds them.

pub mod axis;
pub mod hooks;
pub mod log;
pub mod settings;
