//! How a reference device behaves: the parts of its stack, of the encoder, and of each model that has some of its own.
//!
//! This room must not know the bugs.

use crate::models::{datalogic_amt58, lika_xac77, sick, sick_a3m60, sick_afx60};
use device_stack::{Attached, profibus, profinet};
use encoder_profile::behaviour;

/// The deviations of a reference device; none by default.
#[derive(Clone, Default)]
pub struct Behaviour {
    /// The encoder.
    pub encoder: behaviour::Behaviour,
    /// The deviations of the PROFINET stack.
    pub stack: Attached<dyn profinet::StackHooks>,
    /// The deviations of the PROFIBUS slave.
    pub slave: Attached<dyn profibus::SlaveHooks>,
    /// The deviations of the web server of the XAC77.
    pub web: lika_xac77::hooks::Hooks,
    /// The deviations at what the encoders of SICK share.
    pub sick: sick::hooks::Hooks,
    /// The deviations of the A3M60.
    pub a3m60: sick_a3m60::hooks::Hooks,
    /// The deviations of the AFS60 and AFM60.
    pub afx60: sick_afx60::hooks::Hooks,
    /// The deviations of the AMT58.
    pub amt58: Attached<dyn datalogic_amt58::hooks::Amt58Hooks>,
}
