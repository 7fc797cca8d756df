//! The deviations attached to the parts of an encoder; a conforming device has none.

use crate::encoder::Hardware;
use crate::encoder::measuring::MeasuringSteps;
use crate::encoder::velocity::VelocitySteps;
use crate::encoder_object::hooks::EncoderHooks;
use crate::facts::Facts;
use crate::profidrive::checks::Checks;
use crate::profidrive::life_sign::LifeSignSteps;
use crate::profidrive::preset_trigger::TriggerSteps;
use crate::profidrive::user_parameters::{ParametrizedEncoder, UserParameters};
use crate::profidrive::{telegram, user_parameters};
use device_stack::Attached;

/// The deviations of one encoder, by the part that calls their hooks; by default there are none.
#[derive(Clone, Default)]
pub struct EncoderDeviations {
    /// At its decisions.
    pub checks: Checks,
    /// At its seams.
    pub hooks: Attached<dyn EncoderHooks>,
    /// At the steps of positions and presets.
    pub measuring: Attached<dyn MeasuringSteps>,
    /// At the steps of the velocity.
    pub velocity: Attached<dyn VelocitySteps>,
    /// At the steps of telegrams and their signals.
    pub telegram: Attached<dyn telegram::TelegramSteps>,
    /// At the steps of the preset by a trigger.
    pub trigger: Attached<dyn TriggerSteps>,
    /// At the steps of signs of life.
    pub life_sign: Attached<dyn LifeSignSteps>,
    /// At the steps from a record of user parameters to the settings in force.
    pub start: Attached<dyn user_parameters::StartSteps>,
}

impl EncoderDeviations {
    /// An encoder of this manual and hardware, as user parameters are judged for it.
    pub fn encoder(&self, facts: &'static Facts, hardware: Hardware) -> ParametrizedEncoder<'_> {
        ParametrizedEncoder { hardware, limits: &facts.limits, checks: &self.checks, steps: &self.start }
    }

    /// The user parameters that are in force without a record.
    pub fn delivered(&self, facts: &Facts, hardware: &Hardware) -> UserParameters {
        self.start.apply((facts.default_record)(hardware), |steps, right| steps.delivered(hardware, right))
    }
}
