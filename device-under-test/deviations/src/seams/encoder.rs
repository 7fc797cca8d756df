//! The hooks of an encoder, as the rows of the tables attach to them.

use alloc::vec::Vec;
use device_stack::profinet::{ArKey, Severity};
use encoder_profile::checks::{Check, EncoderChecks};
use encoder_profile::encoder::PresetMode;
use encoder_profile::facts::ErrorFact;
use encoder_profile::hooks::{EncoderHooks, Held, Lit, View};
use encoder_profile::profidrive::parameters::{Exchange, Parameter};
use encoder_profile::profidrive::sensor::Error;
use encoder_profile::profidrive::telegram::{Before, Image, Outputs, Telegram};
use wire::profidrive::{Format, ParameterError, ParameterValue, Request, RequestId, Response};

hooks! { Decisions: EncoderChecks
    /// Flips a decision: from what it is about and what the encoder has decided.
    check(check: Check) -> bool;
}

impl Decisions {
    /// Decides about this always so, whatever the manual says.
    pub fn set(&mut self, of: Check, verdict: bool) {
        self.check(move |check, right| if check == of { verdict } else { right });
    }
}

hooks! { Encoder: EncoderHooks
    /// Changes what the controller sends in one telegram, as it arrives.
    outputs(view: &View<'_>, telegram: &Telegram) -> Outputs;
    /// Changes the errors whose cause is there.
    causes(view: &View<'_>) -> Vec<Error>;
    /// Changes the signals of a frame, from the cycle before and the signals of the manual.
    image(before: &Before) -> Image;
    /// Changes an element of a parameter, by the number of the parameter and the index of the element.
    element(view: &View<'_>, at: (u16, usize)) -> u64;
    /// Changes what the working memory holds of a preset, in each cycle.
    held(view: &View<'_>) -> Held;
    /// Changes a parameter as it is read.
    parameter(view: &View<'_>, number: u16) -> Parameter;
    /// Changes the values that a parameter is given, by its number and the first subindex; none change nothing.
    written(view: &View<'_>, at: (u16, u16)) -> Option<Vec<u64>>;
    /// Changes the octets of a parameter request as they arrive.
    parameter_request(from: ArKey) -> Vec<u8>;
    /// Changes the octets of a response.
    parameter_response(exchange: &Exchange) -> Vec<u8>;
    /// Changes what is fetched as a response.
    fetched_response(by: ArKey) -> Option<Vec<u8>>;
    /// Changes the units by which a preset of G1_STW sets or shifts the position.
    preset_units(view: &View<'_>, mode: PresetMode) -> u64;
    /// Changes the bits of the warnings.
    warnings(view: &View<'_>) -> u32;
    /// Changes the diagnoses that are reported.
    diagnoses(view: &View<'_>) -> Vec<(u16, Severity)>;
    /// Forgets what is volatile.
    powered_up();
    /// Changes what an LED shows.
    led(lit: &Lit<'_>) -> &'static str;
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
        self.parameter(move |_, number, right| if number == of { Parameter { format, ..right } } else { right });
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
        self.parameter_response(move |Exchange { request, response }, _| {
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
            all.into_iter().map(|error| Error { code: change(fact(view, &error)), ..error }).collect()
        });
    }
}

fn fact(view: &View<'_>, error: &Error) -> &'static ErrorFact {
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
