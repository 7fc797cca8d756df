//! What a reference device does at the places where it can be told to do something else.
//!
//! A [`Behaviour`] is plain data: flags, numbers and functions, each read at one seam. The healthy one is its default. The
//! knobs of one seam stand with that seam; those that a model itself reads stand here. This room must not know the bugs.

mod control;
mod diagnosis;
mod leds;
mod memory;
mod names;
mod records;
mod reset;
mod values;
mod web;

pub use control::{ByPlc, Control};
pub use diagnosis::Diagnosis;
pub use leds::{Leds, Lit};
pub use memory::{Memory, PowerUp};
pub use names::Names;
pub use records::Records;
pub use reset::Reset;
pub use values::{Values, View, preset_units};
pub use web::{Kept, Shown, Web};

use crate::encoder::{measuring, velocity};
use crate::models::{datalogic_amt58, plain, sick, sick_a3m60, sick_afx60};
use crate::profibus::SlaveBehaviour;
use crate::profidrive::{life_sign, mantel, parameters, sensor, telegram, user_parameters};
use crate::profinet::StackBehaviour;

/// How a reference device behaves.
#[derive(Clone, Copy, Debug, Default)]
pub struct Behaviour {
    /// Positions and presets.
    pub measuring: measuring::Rules,
    /// Velocity.
    pub velocity: velocity::Rules,
    /// Handshakes and errors of the sensor interface.
    pub sensor: sensor::Rules,
    /// Telegrams and their signals.
    pub telegram: telegram::Rules,
    /// The preset without a handshake.
    pub mantel: mantel::Rules,
    /// Signs of life.
    pub life_sign: life_sign::Rules,
    /// Parameter manager.
    pub parameters: parameters::Rules,
    /// User parameters of the start-up.
    pub user_parameters: user_parameters::Rules,
    /// Control by PLC.
    pub control: Control,
    /// Records of the encoder object.
    pub records: Records,
    /// Values of single parameters.
    pub values: Values,
    /// What goes to memory, and when.
    pub memory: Memory,
    /// What a factory reset does.
    pub reset: Reset,
    /// Diagnoses.
    pub diagnosis: Diagnosis,
    /// LEDs.
    pub leds: Leds,
    /// Station names.
    pub names: Names,
    /// Web server.
    pub web: Web,
    /// The PROFINET stack.
    pub stack: StackBehaviour,
    /// The PROFIBUS slave.
    pub slave: SlaveBehaviour,
    /// What the encoders of SICK share.
    pub sick: sick::knobs::Rules,
    /// What is the own of the A3M60.
    pub a3m60: sick_a3m60::knobs::Rules,
    /// What is the own of the AFS60 and AFM60.
    pub afx60: sick_afx60::knobs::Rules,
    /// What is the own of the AMT58.
    pub amt58: datalogic_amt58::knobs::Rules,
    /// The device after no manual.
    pub plain: plain::Rules,
}
