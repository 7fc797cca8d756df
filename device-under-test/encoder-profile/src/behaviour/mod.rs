//! What an encoder does at the places where it can be told to do something else.
//!
//! A [`Behaviour`] is plain data: flags, numbers and functions, each read at one seam. The healthy one is its default. The
//! knobs of one seam stand with that seam; those that the encoder object reads stand here. What only one model has stands
//! with that model. This room must not know the bugs.

mod control;
mod memory;
mod names;
mod records;
mod reset;

pub use control::{ByPlc, Control};
pub use memory::{Memory, PowerUp};
pub use names::Names;
pub use records::Records;
pub use reset::Reset;

use crate::checks::Checks;
use crate::encoder::measuring::MeasuringSteps;
use crate::encoder::velocity::VelocitySteps;
use crate::hooks::EncoderHooks;
use crate::profidrive::{life_sign, mantel, sensor, telegram, user_parameters};
use device_stack::Attached;

/// How an encoder behaves.
#[derive(Clone, Default)]
pub struct Behaviour {
    /// The decisions of the encoder.
    pub checks: Checks,
    /// The deviations of the encoder at its seams.
    pub hooks: Attached<dyn EncoderHooks>,
    /// The deviations at the steps of positions and presets.
    pub measuring: Attached<dyn MeasuringSteps>,
    /// The deviations at the steps of the velocity.
    pub velocity: Attached<dyn VelocitySteps>,
    /// Handshakes and errors of the sensor interface.
    pub sensor: sensor::Rules,
    /// Telegrams and their signals.
    pub telegram: telegram::Rules,
    /// The preset without a handshake.
    pub mantel: mantel::Rules,
    /// Signs of life.
    pub life_sign: life_sign::Rules,
    /// User parameters of the start-up.
    pub user_parameters: user_parameters::Rules,
    /// Control by PLC.
    pub control: Control,
    /// Records of the encoder object.
    pub records: Records,
    /// What goes to memory, and when.
    pub memory: Memory,
    /// What a factory reset does.
    pub reset: Reset,
    /// Station names.
    pub names: Names,
}
