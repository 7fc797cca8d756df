//! What a reference device does at the places where it can be told to do something else.
//!
//! A [`Behaviour`] is plain data: flags, numbers and functions, each read at one seam. The healthy one is its default. The
//! knobs of one seam stand with that seam; those that a model itself reads stand here. This room must not know the bugs.

mod control;
mod diagnosis;
mod memory;
mod names;
mod reset;
mod values;

pub use control::Control;
pub use diagnosis::Diagnosis;
pub use memory::Memory;
pub use names::Names;
pub use reset::Reset;
pub use values::Values;

use crate::encoder::measuring;
use crate::models::plain;
use crate::profidrive::{life_sign, parameters, sensor, telegram, user_parameters};
use crate::profinet::StackBehaviour;

/// How a reference device behaves.
#[derive(Clone, Copy, Debug, Default)]
pub struct Behaviour {
    /// Positions and presets.
    pub measuring: measuring::Rules,
    /// Handshakes and errors of the sensor interface.
    pub sensor: sensor::Rules,
    /// Telegrams and their signals.
    pub telegram: telegram::Rules,
    /// Signs of life.
    pub life_sign: life_sign::Rules,
    /// Parameter manager.
    pub parameters: parameters::Rules,
    /// User parameters of the start-up.
    pub user_parameters: user_parameters::Rules,
    /// Control by PLC.
    pub control: Control,
    /// Values of single parameters.
    pub values: Values,
    /// What goes to memory, and when.
    pub memory: Memory,
    /// What survives a factory reset.
    pub reset: Reset,
    /// Diagnoses.
    pub diagnosis: Diagnosis,
    /// Station names.
    pub names: Names,
    /// The PROFINET stack.
    pub stack: StackBehaviour,
    /// The device after no manual.
    pub plain: plain::Rules,
}
