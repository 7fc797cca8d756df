//! The deviations attached to the parts of an encoder. A conforming device has none.

use crate::encoder::Hardware;
use crate::encoder::measuring::MeasuringSteps;
use crate::encoder::velocity::VelocitySteps;
use crate::encoder_object::hooks::EncoderHooks;
use crate::facts::ManualFacts;
use crate::profidrive::checks::AttachedChecks;
use crate::profidrive::life_sign::LifeSignSteps;
use crate::profidrive::preset_trigger::TriggerSteps;
use crate::profidrive::user_parameters::{ParametrizedEncoder, UserParameterData};
use crate::profidrive::{telegram, user_parameters};
use device_stack::Attached;

/// The deviations of one encoder, by the part that calls their hooks. The default is none.
#[derive(Clone, Default)]
pub struct EncoderDeviations {
    /// Hooks of decisions.
    pub checks: AttachedChecks,
    /// Hooks of seams.
    pub hooks: Attached<dyn EncoderHooks>,
    /// Hooks of the steps of positions and presets.
    pub measuring: Attached<dyn MeasuringSteps>,
    /// Hooks of the steps of the velocity.
    pub velocity: Attached<dyn VelocitySteps>,
    /// Hooks of the steps of telegrams and their signals.
    pub telegram: Attached<dyn telegram::TelegramSteps>,
    /// Hooks of the steps of the preset by a trigger.
    pub trigger: Attached<dyn TriggerSteps>,
    /// Hooks of the steps of the signs of life.
    pub life_sign: Attached<dyn LifeSignSteps>,
    /// Hooks of the steps from a user parameter record to the settings in force.
    pub start: Attached<dyn user_parameters::StartSteps>,
}

impl EncoderDeviations {
    /// The encoder for which user parameters are checked.
    pub fn encoder(&self, facts: &'static ManualFacts, hardware: Hardware) -> ParametrizedEncoder<'_> {
        ParametrizedEncoder { hardware, limits: &facts.limits, checks: &self.checks, steps: &self.start }
    }

    /// The user parameters in force without a record.
    pub fn factory_parameters(&self, facts: &ManualFacts, hardware: &Hardware) -> UserParameterData {
        self.start.apply((facts.default_record)(hardware), |steps, right| steps.factory_parameters(hardware, right))
    }
}
