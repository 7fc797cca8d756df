//! Deviations at the hooks of the encoder object.

use alloc::vec::Vec;
use core::time::Duration;
use device_stack::profinet::{ArKey, DiagnosisSeverity, PluggableSubmodule, RecordAccess};
use encoder_profile::checks::{EncoderCheck, EncoderChecks};
use encoder_profile::encoder::{Hardware, MeasuringSettings, PresetMode, VelocityUnit};
use encoder_profile::facts::{ClearedData, ErrorFact, SubmoduleFacts};
use encoder_profile::hooks::{
    EncoderHooks, EncoderView, LedInput, MemoryWrite, RecordOctets, RetainedEncoderData, SubmoduleInputs, WorkingPreset,
};
use encoder_profile::profidrive::life_sign::LifeSignSteps;
use encoder_profile::profidrive::parameters::{ParameterContent, ParameterExchange};
use encoder_profile::profidrive::preset_trigger::TriggerSteps;
use encoder_profile::profidrive::sensor::SensorError;
use encoder_profile::profidrive::telegram::{
    InputSignal, OutputValues, OutputWord, PreviousCycle, SignalImage, Telegram, TelegramSteps,
};
use encoder_profile::profidrive::user_parameters::{StartSteps, UserParameterData};
use wire::profidrive::{
    ParameterError, ParameterFormat, ParameterRequest, ParameterResponse, ParameterValue, RequestId,
};

hooks! { Decisions: EncoderChecks
    /// Changes a decision, given the check and the decision of the encoder.
    check(check: EncoderCheck) -> bool;
}

impl Decisions {
    /// Fixes the result of a check, whatever the manual says.
    pub fn set(&mut self, of: EncoderCheck, verdict: bool) {
        self.check(move |check, right| if check == of { verdict } else { right });
    }

    /// Changes whether the hardware can serve a scaling.
    pub fn serves(&mut self, mut decide: impl FnMut(&UserParameterData, &Hardware, bool) -> bool + 'static) {
        self.check(move |check, right| match check {
            EncoderCheck::ScalingIsServed(user, hardware) => decide(&user, &hardware, right),
            _ => right,
        });
    }
}

hooks! { LifeSign: LifeSignSteps
    /// Changes how many steps the sign of life of the encoder has counted, given the time and the frames since its first frame.
    count(elapsed: Duration, frames: u64) -> u64;
    /// Changes how many failures of the sign of life of the controller are tolerated.
    tolerated(user: &UserParameterData) -> i32;
}

hooks! { Trigger: TriggerSteps
    /// Changes the value of a preset by trigger, given its word and the number of positions.
    value(word: u32, range: u64) -> u64;
}

hooks! { Encoder: EncoderHooks
    /// Changes the user parameters that come into force; the view still has the previous ones.
    user_parameters(view: &EncoderView<'_>) -> UserParameterData;
    /// Is called when a connection begins.
    starts(view: &EncoderView<'_>);
    /// Is called when a connection has ended.
    ends(view: &EncoderView<'_>);
    /// Changes the outputs of one telegram as they arrive.
    outputs(view: &EncoderView<'_>, telegram: &Telegram) -> OutputValues;
    /// Changes which submodules are plugged when a connection begins.
    plugged() -> Vec<PluggableSubmodule>;
    /// Changes the input length in bytes that a telegram announces to the stack.
    input_octets(telegram: &Telegram) -> u16;
    /// Changes the inputs of a submodule before they are sent.
    inputs(view: &EncoderView<'_>, submodule: &SubmoduleFacts, image: &SignalImage) -> SubmoduleInputs;
    /// Changes the bytes of a written record, or refuses it.
    write_record(view: &EncoderView<'_>, access: &RecordAccess) -> RecordOctets;
    /// Changes the answer to a record read.
    read_record(view: &EncoderView<'_>, access: &RecordAccess) -> RecordOctets;
    /// Changes the time from the end of the parameters to the first good data.
    ready(view: &EncoderView<'_>) -> Duration;
    /// Changes the errors whose cause is present.
    causes(view: &EncoderView<'_>) -> Vec<SensorError>;
    /// Changes the signals of a frame, given the previous cycle and the signals of the manual.
    image(view: &EncoderView<'_>, before: &PreviousCycle) -> SignalImage;
    /// Changes an element of a parameter, given the parameter number and the index of the element.
    element(view: &EncoderView<'_>, at: (u16, usize)) -> u64;
    /// Changes the preset data in working memory, in each cycle.
    working_preset(view: &EncoderView<'_>) -> WorkingPreset;
    /// Changes a parameter as it is read.
    parameter(view: &EncoderView<'_>, number: u16) -> ParameterContent;
    /// Changes the values written to a parameter, given its number and the first subindex; `None` discards the write.
    written(view: &EncoderView<'_>, at: (u16, u16)) -> Option<Vec<u64>>;
    /// Changes the bytes of a parameter request as they arrive.
    parameter_request(from: ArKey) -> Vec<u8>;
    /// Changes the bytes of a parameter response.
    parameter_response(exchange: &ParameterExchange) -> Vec<u8>;
    /// Changes the response that a read fetches.
    fetched_response(by: ArKey) -> Option<Vec<u8>>;
    /// Changes the units by which a preset by G1_STW sets or shifts the position.
    preset_units(view: &EncoderView<'_>, mode: PresetMode) -> u64;
    /// Changes the warning bits.
    warnings(view: &EncoderView<'_>) -> u32;
    /// Changes the diagnoses that are reported.
    diagnoses(view: &EncoderView<'_>) -> Vec<(u16, DiagnosisSeverity)>;
    /// Is called at power-up, to clear volatile state.
    powered_up();
    /// Changes a write to non-volatile memory.
    store(view: &EncoderView<'_>) -> Option<MemoryWrite>;
    /// Changes what is restored from memory at power-up.
    load(view: &EncoderView<'_>) -> RetainedEncoderData;
    /// Changes what remains after a factory reset.
    reset(view: &EncoderView<'_>, clears: ClearedData) -> RetainedEncoderData;
    /// Is called at power-down.
    power_down(view: &EncoderView<'_>);
    /// Changes the value of a counter.
    counter(name: &str) -> u64;
    /// Changes what an LED shows.
    led(lit: &LedInput<'_>) -> &'static str;
}

impl Encoder {
    /// Truncates a parameter to this number of elements.
    pub fn truncate_elements(&mut self, of: u16, elements: usize) {
        self.parameter(move |_, number, mut parameter| {
            parameter.values.truncate(if number == of { elements } else { usize::MAX });
            parameter
        });
    }

    /// Changes the format of a parameter.
    pub fn format(&mut self, of: u16, format: ParameterFormat) {
        self.parameter(move |_, number, right| if number == of { ParameterContent { format, ..right } } else { right });
    }

    /// Changes the values that are written to a parameter.
    pub fn value(&mut self, of: u16, change: impl Fn(u64) -> u64 + 'static) {
        self.written(move |_, (number, _), values| {
            if number == of { values.map(|values| values.into_iter().map(&change).collect()) } else { values }
        });
    }

    /// Changes each parsed request; bytes that are not a valid request stay as they are.
    pub fn change_request(&mut self, change: impl Fn(ParameterRequest) -> ParameterRequest + 'static) {
        self.parameter_request(move |_, octets| match ParameterRequest::parse(&octets) {
            Ok(request) => {
                let mut changed = Vec::new();
                change(request).write(&mut changed);
                changed
            }
            Err(_) => octets,
        });
    }

    /// Changes a response, given the request and the response of the manual.
    pub fn respond(&mut self, change: impl Fn(&ParameterRequest, ParameterResponse) -> ParameterResponse + 'static) {
        self.parameter_response(move |ParameterExchange { request, response }, _| {
            let mut octets = Vec::new();
            change(request, response.clone()).write(&mut octets);
            octets
        });
    }

    /// Changes the error of a parameter, given the kind of request, the parameter number and the error of the manual.
    pub fn refuse(
        &mut self,
        change: impl Fn(RequestId, u16, Option<ParameterError>) -> Option<ParameterError> + 'static,
    ) {
        self.respond(move |request, response| refused(request, response, &change));
    }

    /// Changes how long it takes to store the offset of a preset.
    pub fn offset_takes(&mut self, mut time: impl FnMut(Duration) -> Duration + 'static) {
        self.store(move |_, write| match write {
            Some(MemoryWrite::Offset { offset, takes }) => Some(MemoryWrite::Offset { offset, takes: time(takes) }),
            other => other,
        });
    }

    /// Changes how long it takes to store the preset value, P65000.
    pub fn preset_value_takes(&mut self, mut time: impl FnMut(Duration) -> Duration + 'static) {
        self.store(move |_, write| match write {
            Some(MemoryWrite::PresetValue { value, takes }) => {
                Some(MemoryWrite::PresetValue { value, takes: time(takes) })
            }
            other => other,
        });
    }

    /// Changes the error types of reported diagnoses; `None` drops the diagnosis.
    pub fn error_type(&mut self, change: impl Fn(u16) -> Option<u16> + 'static) {
        self.diagnoses(move |_, all| {
            let changed = all.into_iter().map(|(error_type, severity)| Some((change(error_type)?, severity)));
            changed.flatten().collect()
        });
    }

    /// Raises only some errors when their cause is present.
    pub fn raise(&mut self, is_raised: impl Fn(&ErrorFact) -> bool + 'static) {
        self.causes(move |view, all| all.into_iter().filter(|error| is_raised(fact(view, error))).collect());
    }

    /// Changes the error codes in G1_XIST2; `None` removes the code.
    pub fn code(&mut self, change: impl Fn(&ErrorFact) -> Option<u16> + 'static) {
        self.causes(move |view, all| {
            all.into_iter().map(|error| SensorError { code: change(fact(view, &error)), ..error }).collect()
        });
    }
}

fn fact(view: &EncoderView<'_>, error: &SensorError) -> &'static ErrorFact {
    &view.facts.errors[usize::from(error.number)]
}

fn refused(
    request: &ParameterRequest,
    response: ParameterResponse,
    change: &impl Fn(RequestId, u16, Option<ParameterError>) -> Option<ParameterError>,
) -> ParameterResponse {
    let header = &request.header;
    let all = request.addresses.iter().enumerate().map(|(n, address)| {
        let value = response.values.get(n);
        let before = value.and_then(ParameterValue::error);
        (value, before, change(header.id, address.number, before))
    });
    match header.id {
        RequestId::REQUEST => {
            let values = all.map(|(value, before, error)| match (error, before, value) {
                (Some(error), _, _) => ParameterValue::refused(error),
                (None, None, Some(value)) => value.clone(),
                (None, _, _) => ParameterValue::numbers(ParameterFormat::WORD, &[0]),
            });
            ParameterResponse::to_read(header, values.collect())
        }
        RequestId::CHANGE => {
            let outcomes: Vec<_> = all.map(|(_, _, error)| error.map_or(Ok(()), Err)).collect();
            ParameterResponse::to_change(header, &outcomes)
        }
        _ => response,
    }
}
hooks! { Telegrams: TelegramSteps
    /// Changes the measuring settings that act on a signal.
    acts_on(signal: InputSignal, hardware: &Hardware) -> MeasuringSettings;
}

hooks! { Start: StartSteps
    /// Changes the default user parameters, which are in force without a record.
    factory_parameters(hardware: &Hardware) -> UserParameterData;
    /// Changes the settings of the measuring task that result from user parameters.
    settings(user: &UserParameterData, hardware: &Hardware) -> MeasuringSettings;
    /// Changes the velocity unit that a number selects.
    velocity_unit(number: u8) -> VelocityUnit;
}

/// A signal of a telegram that is about to be sent.
pub struct SentSignal<'a> {
    /// The encoder.
    pub view: &'a EncoderView<'a>,
    /// Its telegram.
    pub telegram: &'static Telegram,
    /// The signal.
    pub signal: InputSignal,
    /// All signals of the frame.
    pub image: &'a SignalImage,
}

impl Encoder {
    /// Changes STW2_ENC and G1_STW as they arrive.
    pub fn control_words(&mut self, mut change: impl FnMut(&Telegram, [u16; 2]) -> [u16; 2] + 'static) {
        self.outputs(move |_, telegram, arrived| match arrived.words {
            Some(words) => OutputValues { words: Some(change(telegram, words)), ..arrived },
            None => arrived,
        });
    }

    /// Changes the preset word (value and trigger) as it arrives, given the word and the four unused output bytes.
    pub fn preset_word(&mut self, mut change: impl FnMut(u32, Option<u32>) -> u32 + 'static) {
        self.outputs(move |_, telegram, arrived| {
            if telegram.outputs.contains(&OutputWord::Preset) {
                OutputValues { preset: arrived.preset.map(|word| change(word, arrived.unused)), ..arrived }
            } else {
                arrived
            }
        });
    }

    /// Changes the signals of a frame, given only the previous cycle and the signals of the manual.
    pub fn signals(&mut self, mut change: impl FnMut(&PreviousCycle, SignalImage) -> SignalImage + 'static) {
        self.image(move |_, before, now| change(before, now));
    }

    /// Changes the bytes of each signal.
    pub fn signal(&mut self, mut change: impl FnMut(&SentSignal<'_>, &mut Vec<u8>) + 'static) {
        self.inputs(move |view, submodule, image, inputs| {
            let telegram = submodule.telegram;
            let mut rest = inputs.octets.into_iter();
            let mut octets = Vec::new();
            for signal in telegram.inputs.iter().copied() {
                let mut one = rest.by_ref().take(signal.octets()).collect();
                change(&SentSignal { view, telegram, signal, image }, &mut one);
                octets.extend(one);
            }
            SubmoduleInputs { octets, ..inputs }
        });
    }

    /// Changes which signals a telegram sends, and in which order.
    pub fn order(&mut self, mut order: impl FnMut(&'static Telegram) -> &'static [InputSignal] + 'static) {
        self.inputs(move |_, submodule, image, inputs| {
            let inputs_as_sent = Telegram { inputs: order(submodule.telegram), ..*submodule.telegram };
            SubmoduleInputs { octets: inputs_as_sent.octets(image), ..inputs }
        });
    }
}
