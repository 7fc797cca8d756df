//! What a deviation needs of the devices of a manual to be possible there at all.

use encoder_profile::facts::{LateRecordEffect, ManualFacts, MissingRecordEffect, SubmoduleFacts};
use encoder_profile::profidrive::telegram::{InputSignal, OutputWord};
use reference_devices::{Bus, Manual};

/// Something that the devices of a manual have or do not have.
#[derive(Clone, Copy, Debug)]
pub enum Need {
    /// A PROFINET stack.
    Profinet,
    /// A PROFIBUS slave.
    Profibus,
    /// A second port on PROFINET.
    SecondPort,
    /// A measuring task: every device but the one after no manual.
    Encoder,
    /// The encoder object of the encoder profile, on either bus.
    EncoderProfile,
    /// I&M0 and no other record of I&M.
    OnlyIm0,
    /// A parameter of the encoder object, by its number.
    Parameter(u16),
    /// A telegram, by its number.
    Telegram(u16),
    /// A G1_XIST1 that is shifted to the left.
    ShiftedXist1,
    /// A sign of life of the controller that is watched.
    WatchedController,
    /// User parameters at each start, without which it is an error.
    RequiredRecord,
    /// User parameters that are taken in data exchange.
    RecordInExchange,
    /// A signal in the inputs of a telegram.
    Input(InputSignal),
    /// A control word in the outputs of a telegram.
    Output(OutputWord),
    /// Parameter requests for some axes that are refused.
    RefusesAxes,
    /// Errors or warnings that are reported as diagnoses.
    Diagnosis,
    /// Warnings.
    Warning,
    /// What only the devices of one manual have.
    Of(&'static Manual),
    /// What the devices of two manuals have in common, beyond the needs above.
    OfEither(&'static Manual, &'static Manual),
}

impl Need {
    /// Whether the devices of `manual` have it.
    pub fn is_met_by(self, manual: &Manual) -> bool {
        let has = |submodule: &dyn Fn(&SubmoduleFacts) -> bool| {
            let modules = manual.facts.iter().flat_map(|facts: &&ManualFacts| facts.modules);
            modules.flat_map(|module| module.submodules).any(submodule)
        };
        match self {
            Need::Profinet => matches!(manual.bus, Bus::Profinet(_)),
            Need::Profibus => matches!(manual.bus, Bus::Profibus(_)),
            Need::SecondPort => {
                Need::Profinet.is_met_by(manual) && manual.facts.is_some_and(|facts| facts.identity.ports > 1)
            }
            Need::Encoder => manual.facts.is_some() || matches!(manual.bus, Bus::Profibus(_)),
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
            Need::Warning => manual.facts.is_some_and(|facts| !facts.warnings.is_empty()),
            Need::Of(one) => manual.name == one.name,
            Need::OfEither(one, other) => manual.name == one.name || manual.name == other.name,
        }
    }
}
