//! What an encoder does at the places where it can be told to do something else.
//!
//! A [`Behaviour`] is plain data: flags, numbers and functions, each read at one seam. The healthy one is its default. The
//! knobs of one seam stand with that seam; those that the encoder object reads stand here. What only one model has stands
//! with that model. This room must not know the bugs.

use crate::checks::Checks;
use crate::encoder::Hardware;
use crate::encoder::measuring::MeasuringSteps;
use crate::encoder::velocity::VelocitySteps;
use crate::facts::Facts;
use crate::hooks::EncoderHooks;
use crate::profidrive::life_sign::LifeSignSteps;
use crate::profidrive::preset_trigger::TriggerSteps;
use crate::profidrive::user_parameters::{ParametrizedEncoder, UserParameters};
use crate::profidrive::{telegram, user_parameters};
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
    /// Telegrams and their signals.
    pub telegram: Attached<dyn telegram::TelegramSteps>,
    /// The preset without a handshake.
    pub trigger: Attached<dyn TriggerSteps>,
    /// Signs of life.
    pub life_sign: Attached<dyn LifeSignSteps>,
    /// The steps from a record of user parameters to what is in force.
    pub start: Attached<dyn user_parameters::StartSteps>,
}

impl Behaviour {
    /// An encoder of this manual and hardware, as user parameters are judged for it.
    pub fn encoder(&self, facts: &'static Facts, hardware: Hardware) -> ParametrizedEncoder<'_> {
        ParametrizedEncoder { hardware, limits: &facts.limits, checks: &self.checks, steps: &self.start }
    }

    /// The user parameters that are in force without a record.
    pub fn delivered(&self, facts: &Facts, hardware: &Hardware) -> UserParameters {
        self.start.apply((facts.default_record)(hardware), |steps, right| steps.delivered(hardware, right))
    }
}
