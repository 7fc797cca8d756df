//! The hooks of an encoder, as the rows of the tables attach to them.

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
use wire::profidrive::{Format, ParameterError, ParameterValue, Request, RequestId, Response};

hooks! { Decisions: EncoderChecks
    /// Flips a decision: from what it is about and what the encoder has decided.
    check(check: EncoderCheck) -> bool;
}

impl Decisions {
    /// Decides about this always so, whatever the manual says.
    pub fn set(&mut self, of: EncoderCheck, verdict: bool) {
        self.check(move |check, right| if check == of { verdict } else { right });
    }

    /// Decides whether the hardware can serve a scaling.
    pub fn serves(&mut self, mut decide: impl FnMut(&UserParameterData, &Hardware, bool) -> bool + 'static) {
        self.check(move |check, right| match check {
            EncoderCheck::ScalingIsServed(user, hardware) => decide(&user, &hardware, right),
            _ => right,
        });
    }
}

hooks! { LifeSign: LifeSignSteps
    /// How many values the sign of life of the encoder has gone on, from the time since its first frame and the number of frames.
    count(elapsed: Duration, frames: u64) -> u64;
    /// How many failures of the sign of life of the controller are tolerated.
    tolerated(user: &UserParameterData) -> i32;
}

hooks! { Trigger: TriggerSteps
    /// The value of a preset by its trigger, from its word and the number of positions.
    value(word: u32, range: u64) -> u64;
}

hooks! { Encoder: EncoderHooks
    /// Changes the user parameters that come into force; the view has those before.
    user_parameters(view: &EncoderView<'_>) -> UserParameterData;
    /// Takes note of a connection that begins.
    starts(view: &EncoderView<'_>);
    /// Takes note of a connection that has ended.
    ends(view: &EncoderView<'_>);
    /// Changes what the controller sends in one telegram, as it arrives.
    outputs(view: &EncoderView<'_>, telegram: &Telegram) -> OutputValues;
    /// Changes which submodules are plugged when a connection begins.
    plugged() -> Vec<PluggableSubmodule>;
    /// Changes the octets of inputs that a telegram announces to the stack.
    input_octets(telegram: &Telegram) -> u16;
    /// Changes the inputs of a submodule before they are sent.
    inputs(view: &EncoderView<'_>, submodule: &SubmoduleFacts, image: &SignalImage) -> SubmoduleInputs;
    /// Changes the octets of a record that is written, or refuses it.
    write_record(view: &EncoderView<'_>, access: &RecordAccess) -> RecordOctets;
    /// Changes the answer to a record that was read.
    read_record(view: &EncoderView<'_>, access: &RecordAccess) -> RecordOctets;
    /// Changes how long it takes from the end of the parameters to the first good data.
    ready(view: &EncoderView<'_>) -> Duration;
    /// Changes the errors whose cause is there.
    causes(view: &EncoderView<'_>) -> Vec<SensorError>;
    /// Changes the signals of a frame, from the cycle before and the signals of the manual.
    image(view: &EncoderView<'_>, before: &PreviousCycle) -> SignalImage;
    /// Changes an element of a parameter, by the number of the parameter and the index of the element.
    element(view: &EncoderView<'_>, at: (u16, usize)) -> u64;
    /// Changes what the working memory holds of a preset, in each cycle.
    working_preset(view: &EncoderView<'_>) -> WorkingPreset;
    /// Changes a parameter as it is read.
    parameter(view: &EncoderView<'_>, number: u16) -> ParameterContent;
    /// Changes the values that a parameter is given, by its number and the first subindex; none change nothing.
    written(view: &EncoderView<'_>, at: (u16, u16)) -> Option<Vec<u64>>;
    /// Changes the octets of a parameter request as they arrive.
    parameter_request(from: ArKey) -> Vec<u8>;
    /// Changes the octets of a response.
    parameter_response(exchange: &ParameterExchange) -> Vec<u8>;
    /// Changes what is fetched as a response.
    fetched_response(by: ArKey) -> Option<Vec<u8>>;
    /// Changes the units by which a preset of G1_STW sets or shifts the position.
    preset_units(view: &EncoderView<'_>, mode: PresetMode) -> u64;
    /// Changes the bits of the warnings.
    warnings(view: &EncoderView<'_>) -> u32;
    /// Changes the diagnoses that are reported.
    diagnoses(view: &EncoderView<'_>) -> Vec<(u16, DiagnosisSeverity)>;
    /// Forgets what is volatile.
    powered_up();
    /// Changes what is about to be written to memory.
    store(view: &EncoderView<'_>) -> Option<MemoryWrite>;
    /// Changes what comes back from memory when the supply comes.
    load(view: &EncoderView<'_>) -> RetainedEncoderData;
    /// Changes what a factory reset leaves.
    reset(view: &EncoderView<'_>, clears: ClearedData) -> RetainedEncoderData;
    /// Notes that the supply goes.
    power_down(view: &EncoderView<'_>);
    /// Changes how often a counter has counted.
    counter(name: &str) -> u64;
    /// Changes what an LED shows.
    led(lit: &LedInput<'_>) -> &'static str;
}

impl Encoder {
    /// Gives a parameter this number of elements at most.
    pub fn cut(&mut self, of: u16, elements: usize) {
        self.parameter(move |_, number, mut parameter| {
            parameter.values.truncate(if number == of { elements } else { usize::MAX });
            parameter
        });
    }

    /// Gives a parameter another format.
    pub fn format(&mut self, of: u16, format: Format) {
        self.parameter(move |_, number, right| if number == of { ParameterContent { format, ..right } } else { right });
    }

    /// Changes the values that are written to a parameter.
    pub fn value(&mut self, of: u16, change: impl Fn(u64) -> u64 + 'static) {
        self.written(move |_, (number, _), values| match number == of {
            true => values.map(|values| values.into_iter().map(&change).collect()),
            false => values,
        });
    }

    /// Changes how a request is understood; octets that are no request stay as they are.
    pub fn understand(&mut self, change: impl Fn(Request) -> Request + 'static) {
        self.parameter_request(move |_, octets| match Request::parse(&octets) {
            Ok(request) => {
                let mut changed = Vec::new();
                change(request).write(&mut changed);
                changed
            }
            Err(_) => octets,
        });
    }

    /// Changes a response, from the request and the response of the manual.
    pub fn respond(&mut self, change: impl Fn(&Request, Response) -> Response + 'static) {
        self.parameter_response(move |ParameterExchange { request, response }, _| {
            let mut octets = Vec::new();
            change(request, response.clone()).write(&mut octets);
            octets
        });
    }

    /// Changes why a parameter is refused, from the kind of request, its number and the error of the manual.
    pub fn refuse(
        &mut self,
        change: impl Fn(RequestId, u16, Option<ParameterError>) -> Option<ParameterError> + 'static,
    ) {
        self.respond(move |request, response| refused(request, response, &change));
    }

    /// Changes the error types of the diagnoses that are reported; none reports nothing.
    pub fn error_type(&mut self, change: impl Fn(u16) -> Option<u16> + 'static) {
        self.diagnoses(move |_, all| {
            let changed = all.into_iter().map(|(error_type, severity)| Some((change(error_type)?, severity)));
            changed.flatten().collect()
        });
    }

    /// Raises only some errors when their cause is there.
    pub fn raise(&mut self, is_raised: impl Fn(&ErrorFact) -> bool + 'static) {
        self.causes(move |view, all| all.into_iter().filter(|error| is_raised(fact(view, error))).collect());
    }

    /// Changes the codes of the errors in G1_XIST2; none has no code.
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
    request: &Request,
    response: Response,
    change: &impl Fn(RequestId, u16, Option<ParameterError>) -> Option<ParameterError>,
) -> Response {
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
                (None, _, _) => ParameterValue::numbers(Format::WORD, &[0]),
            });
            Response::to_read(header, values.collect())
        }
        RequestId::CHANGE => {
            let outcomes: Vec<_> = all.map(|(_, _, error)| error.map_or(Ok(()), Err)).collect();
            Response::to_change(header, &outcomes)
        }
        _ => response,
    }
}
hooks! { Telegrams: TelegramSteps
    /// Changes the settings that act on a signal.
    acts_on(signal: InputSignal, hardware: &Hardware) -> MeasuringSettings;
}

hooks! { Start: StartSteps
    /// Changes the user parameters that are in force without a record.
    factory_parameters(hardware: &Hardware) -> UserParameterData;
    /// Changes the settings of the measuring task that user parameters make.
    settings(user: &UserParameterData, hardware: &Hardware) -> MeasuringSettings;
    /// Changes the velocity unit of a number.
    velocity_unit(number: u8) -> VelocityUnit;
}

/// A signal of a telegram that is about to be sent.
pub struct SentSignal<'a> {
    /// The encoder.
    pub view: &'a EncoderView<'a>,
    /// Its telegram.
    pub telegram: &'static Telegram,
    /// Which one it is.
    pub signal: InputSignal,
    /// The signals of the frame.
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

    /// Changes the preset value with its trigger as it arrives, from it and the four octets without a function.
    pub fn preset_word(&mut self, mut change: impl FnMut(u32, Option<u32>) -> u32 + 'static) {
        self.outputs(move |_, telegram, arrived| match telegram.outputs.contains(&OutputWord::Preset) {
            true => OutputValues { preset: arrived.preset.map(|word| change(word, arrived.unused)), ..arrived },
            false => arrived,
        });
    }

    /// Changes the signals of a frame, from the cycle before and the signals of the manual alone.
    pub fn signals(&mut self, mut change: impl FnMut(&PreviousCycle, SignalImage) -> SignalImage + 'static) {
        self.image(move |_, before, now| change(before, now));
    }

    /// Changes the octets of each signal.
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

    /// Sends the signals of a telegram in another order, or others.
    pub fn order(&mut self, mut order: impl FnMut(&'static Telegram) -> &'static [InputSignal] + 'static) {
        self.inputs(move |_, submodule, image, inputs| {
            let inputs_as_sent = Telegram { inputs: order(submodule.telegram), ..*submodule.telegram };
            SubmoduleInputs { octets: inputs_as_sent.octets(image), ..inputs }
        });
    }
}
