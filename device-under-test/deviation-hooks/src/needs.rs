//! What the devices of a manual must have so that a deviation is possible.

use encoder_profile::facts::{LateRecordEffect, ManualFacts, MissingRecordEffect, SubmoduleFacts};
use encoder_profile::profidrive::telegram::{InputSignal, OutputWord};
use reference_devices::{DeviceManual, ManualBus, manuals};

/// A property of the devices of a manual.
#[derive(Clone, Copy, Debug)]
pub enum Need {
    /// A PROFINET stack.
    Profinet,
    /// A PROFIBUS slave.
    Profibus,
    /// A second port on PROFINET.
    SecondPort,
    /// A measuring task: every device except the generic ones, which follow no manual.
    Encoder,
    /// The encoder object of the encoder profile, on PROFINET or PROFIBUS.
    EncoderProfile,
    /// I&M0 and no other I&M record.
    OnlyIm0,
    /// A parameter of the encoder object, by number.
    Parameter(u16),
    /// A telegram, by number.
    Telegram(u16),
    /// A G1_XIST1 that is shifted to the left.
    ShiftedXist1,
    /// The encoder monitors the sign of life of the controller.
    WatchedController,
    /// A start without user parameters is an error.
    RequiredRecord,
    /// User parameters are accepted in data exchange.
    RecordInExchange,
    /// A signal in the inputs of some telegram.
    Input(InputSignal),
    /// A control word in the outputs of some telegram.
    Output(OutputWord),
    /// Parameter requests for some axes are refused.
    RefusesAxes,
    /// Some errors or warnings are reported as diagnoses.
    Diagnosis,
    /// Faults are reported by alarms: the generic PROFINET IO device, and encoders with diagnoses.
    Alarms,
    /// The devices have warnings.
    Warning,
    /// Only devices of this manual.
    Of(&'static DeviceManual),
    /// Only devices of one of these two manuals.
    OfEither(&'static DeviceManual, &'static DeviceManual),
}

impl Need {
    /// Returns whether the devices of `manual` have this property.
    pub fn is_met_by(self, manual: &DeviceManual) -> bool {
        let has = |submodule: &dyn Fn(&SubmoduleFacts) -> bool| {
            let modules = manual.facts.iter().flat_map(|facts: &&ManualFacts| facts.modules);
            modules.flat_map(|module| module.submodules).any(submodule)
        };
        match self {
            Need::Profinet => matches!(manual.bus, ManualBus::Profinet(_)),
            Need::Profibus => matches!(manual.bus, ManualBus::Profibus(_)),
            Need::SecondPort => {
                Need::Profinet.is_met_by(manual) && manual.facts.is_some_and(|facts| facts.identity.ports > 1)
            }
            Need::Encoder => {
                manual.facts.is_some()
                    || Need::OfEither(&manuals::DATALOGIC_AMT58, &manuals::DP_ENCODER).is_met_by(manual)
            }
            Need::EncoderProfile => manual.facts.is_some(),
            Need::OnlyIm0 => manual.facts.is_some_and(|facts| facts.identity.im_supported == 0),
            Need::Parameter(number) => manual.facts.is_some_and(|facts| facts.parameters.contains(&number)),
            Need::Telegram(number) => has(&|one| one.telegram.number == number),
            Need::ShiftedXist1 => {
                manual.facts.is_some_and(|facts| facts.variants.iter().any(|variant| variant.shift > 0))
            }
            Need::WatchedController => manual.facts.is_some_and(|facts| facts.monitors_controller),
            Need::RequiredRecord => {
                manual.facts.is_some_and(|facts| facts.without_record == MissingRecordEffect::Error)
            }
            Need::RecordInExchange => {
                manual.facts.is_some_and(|facts| facts.record_in_exchange == LateRecordEffect::InForce)
            }
            Need::Input(signal) => has(&|one| one.telegram.inputs.contains(&signal)),
            Need::Output(control) => has(&|one| one.telegram.outputs.contains(&control)),
            Need::RefusesAxes => manual.facts.is_some_and(|facts| !facts.serves_any_axis),
            Need::Diagnosis => manual.facts.is_some_and(|facts| {
                facts.errors.iter().any(|error| error.error_type.is_some())
                    || facts.warnings.iter().any(|warning| warning.error_type.is_some())
            }),
            Need::Alarms => {
                Need::Profinet.is_met_by(manual) && (manual.facts.is_none() || Need::Diagnosis.is_met_by(manual))
            }
            Need::Warning => manual.facts.is_some_and(|facts| !facts.warnings.is_empty()),
            Need::Of(one) => manual.name == one.name,
            Need::OfEither(one, other) => manual.name == one.name || manual.name == other.name,
        }
    }
}
