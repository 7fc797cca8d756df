//! The parts that the SICK encoders share on every bus: the round axis, the service log, settings with limits.
//!
//! This module must not depend on the models. Each model holds these parts in its own state and updates them.

pub mod axis;
pub mod hooks;
pub mod log;
pub mod settings;
