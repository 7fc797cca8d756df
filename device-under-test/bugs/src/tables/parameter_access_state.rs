//! Deviations of the parameter access that have state.

use alloc::rc::Rc;
use alloc::vec::Vec;
use core::cell::Cell;
use device_stack::profinet::ArKey;
use encoder_profile::checks::{EncoderCheck, EncoderChecks};
use encoder_profile::encoder::PresetMode;
use encoder_profile::hooks::{EncoderHooks, EncoderView, WorkingPreset};
use encoder_profile::profidrive::parameters::{MAX_OCTETS, ParameterExchange};
use wire::profidrive::{Attribute, ErrorNumber, ParameterError, ParameterRequest, ParameterResponse, RequestId};

/// A request without side effects: it reads P65000.
const HARMLESS: [u8; 10] = [1, 1, 1, 1, 0x10, 0, 0xFD, 0xE8, 0, 0];

/// Stops answering after certain requests until the next power-up.
pub struct HangsAfterRequest {
    after: fn(&[u8]) -> bool,
    hangs: bool,
}

impl HangsAfterRequest {
    /// Stops answering after a request for which `after` returns `true`.
    pub fn after(after: fn(&[u8]) -> bool) -> HangsAfterRequest {
        HangsAfterRequest { after, hangs: false }
    }
}

impl EncoderHooks for HangsAfterRequest {
    fn parameter_request(&mut self, _: ArKey, octets: Vec<u8>) -> Vec<u8> {
        self.hangs |= (self.after)(&octets);
        if self.hangs { HARMLESS.to_vec() } else { octets }
    }

    fn fetched_response(&mut self, _: ArKey, waiting: Option<Vec<u8>>) -> Option<Vec<u8>> {
        waiting.filter(|_| !self.hangs)
    }

    fn powered_up(&mut self) {
        self.hangs = false;
    }
}

/// Fills missing bytes of a request from previous requests.
pub struct MissingRequestBytes([u8; MAX_OCTETS]);

impl Default for MissingRequestBytes {
    fn default() -> MissingRequestBytes {
        let mut octets = [0; MAX_OCTETS];
        octets[..HARMLESS.len()].copy_from_slice(&HARMLESS);
        MissingRequestBytes(octets)
    }
}

impl EncoderHooks for MissingRequestBytes {
    fn parameter_request(&mut self, _: ArKey, octets: Vec<u8>) -> Vec<u8> {
        let received = octets.len().min(MAX_OCTETS);
        self.0[..received].copy_from_slice(&octets[..received]);
        let mut longer = (received..=MAX_OCTETS).map(|length| &self.0[..length]);
        longer.find(|octets| ParameterRequest::parse(octets).is_ok()).map_or(octets, <[u8]>::to_vec)
    }

    fn powered_up(&mut self) {
        *self = MissingRequestBytes::default();
    }
}

/// Answers a request with its reference and the values of the previous request.
#[derive(Default)]
pub struct ResponseBefore(Vec<u8>);

impl EncoderHooks for ResponseBefore {
    fn parameter_response(&mut self, _: &ParameterExchange, octets: Vec<u8>) -> Vec<u8> {
        let before = self.0.iter().skip(1);
        let response = if self.0.is_empty() { octets } else { octets.iter().take(1).chain(before).copied().collect() };
        self.0.clone_from(&response);
        response
    }

    fn powered_up(&mut self) {
        self.0.clear();
    }
}

/// Lets a response be read again until the connection sends another request.
#[derive(Default)]
pub struct OldResponse(Option<(ArKey, Vec<u8>)>);

impl EncoderHooks for OldResponse {
    fn parameter_request(&mut self, from: ArKey, octets: Vec<u8>) -> Vec<u8> {
        self.0.take_if(|(of, _)| *of == from);
        octets
    }

    fn fetched_response(&mut self, by: ArKey, waiting: Option<Vec<u8>>) -> Option<Vec<u8>> {
        if let Some(response) = &waiting {
            self.0 = Some((by, response.clone()));
        }
        self.0.clone().filter(|(of, _)| *of == by).map(|(_, response)| response)
    }

    fn powered_up(&mut self) {
        self.0 = None;
    }
}

/// Lets the next connection read a response that was not read.
#[derive(Default)]
pub struct ResponseOfEarlierConnection {
    requester: Option<ArKey>,
    waiting: Vec<(Option<ArKey>, Vec<u8>)>,
}

impl EncoderHooks for ResponseOfEarlierConnection {
    fn parameter_request(&mut self, from: ArKey, octets: Vec<u8>) -> Vec<u8> {
        self.requester = Some(from);
        self.waiting.retain(|(of, _)| *of != Some(from));
        octets
    }

    fn parameter_response(&mut self, _: &ParameterExchange, octets: Vec<u8>) -> Vec<u8> {
        self.waiting.push((self.requester, octets.clone()));
        octets
    }

    fn fetched_response(&mut self, _: ArKey, _: Option<Vec<u8>>) -> Option<Vec<u8>> {
        if self.waiting.is_empty() { None } else { Some(self.waiting.swap_remove(0).1) }
    }

    fn powered_up(&mut self) {
        *self = ResponseOfEarlierConnection::default();
    }
}

/// Writes a value although a check refuses it; the response still refuses it.
#[derive(Clone, Default)]
pub struct WrittenBeforeChecked {
    is_writing: Rc<Cell<bool>>,
    refusal: Rc<Cell<Option<ParameterError>>>,
}

impl EncoderChecks for WrittenBeforeChecked {
    fn check(&mut self, check: EncoderCheck, verdict: bool) -> bool {
        let number = match check {
            EncoderCheck::Attribute(Attribute::DESCRIPTION) => ErrorNumber::DESCRIPTION_READ_ONLY,
            EncoderCheck::Attribute(Attribute::TEXT) => ErrorNumber::TEXT_READ_ONLY,
            EncoderCheck::Attribute(_) | EncoderCheck::ElementCount { .. } => ErrorNumber::BAD_ADDRESS,
            EncoderCheck::Writable { .. } => ErrorNumber::READ_ONLY,
            EncoderCheck::KnownFormat(_) => ErrorNumber::BAD_FORMAT,
            EncoderCheck::WholeValue { .. } => ErrorNumber::NO_ARRAY,
            EncoderCheck::ValueCount { .. } => ErrorNumber::BAD_VALUE_COUNT,
            EncoderCheck::ValueFormat { .. } => ErrorNumber::WRONG_TYPE,
            _ => return verdict,
        };
        if verdict || !self.is_writing.get() {
            return verdict;
        }
        let subindex = if let EncoderCheck::Writable { element, .. } = check { element } else { None };
        self.refusal.set(self.refusal.get().or(Some(ParameterError { number, subindex })));
        true
    }
}

impl EncoderHooks for WrittenBeforeChecked {
    fn parameter_request(&mut self, _: ArKey, octets: Vec<u8>) -> Vec<u8> {
        // Only requests for one parameter, since a check does not identify its parameter.
        self.is_writing.set(matches!(octets[..], [_, id, _, 1, ..] if id == RequestId::CHANGE.0));
        self.refusal.take();
        octets
    }

    fn parameter_response(&mut self, exchange: &ParameterExchange, octets: Vec<u8>) -> Vec<u8> {
        let Some(error) = self.refusal.take() else { return octets };
        let mut refused = Vec::new();
        ParameterResponse::to_change(&exchange.request.header, &[Err(error)]).write(&mut refused);
        refused
    }
}

/// Does not write the parameters after a refused one in the same request.
#[derive(Clone, Default)]
pub struct StopsAtFirstError {
    was_refused: Rc<Cell<bool>>,
}

impl EncoderChecks for StopsAtFirstError {
    fn check(&mut self, check: EncoderCheck, verdict: bool) -> bool {
        let is_of_parameter = matches!(
            check,
            EncoderCheck::Attribute(_)
                | EncoderCheck::Writable { .. }
                | EncoderCheck::ElementCount { .. }
                | EncoderCheck::WholeValue { .. }
                | EncoderCheck::Elements { .. }
                | EncoderCheck::ValueCount { .. }
                | EncoderCheck::KnownFormat(_)
                | EncoderCheck::ValueFormat { .. }
                | EncoderCheck::SurplusOctets(_)
        );
        if is_of_parameter && !verdict {
            self.was_refused.set(true);
        }
        verdict
    }
}

impl EncoderHooks for StopsAtFirstError {
    fn parameter_request(&mut self, _: ArKey, octets: Vec<u8>) -> Vec<u8> {
        self.was_refused.set(false);
        octets
    }

    fn written(&mut self, _: &EncoderView<'_>, _: (u16, u16), values: Option<Vec<u64>>) -> Option<Vec<u64>> {
        values.filter(|_| !self.was_refused.get())
    }
}

/// Makes a preset when P65000 is written.
#[derive(Default)]
pub struct PresetsAtWrite {
    is_written: bool,
    /// P65000 in the previous cycle; `None` in the first one.
    value: Option<u32>,
}

impl EncoderHooks for PresetsAtWrite {
    fn written(&mut self, _: &EncoderView<'_>, (number, _): (u16, u16), values: Option<Vec<u64>>) -> Option<Vec<u64>> {
        self.is_written |= number == 65000;
        values
    }

    fn working_preset(&mut self, view: &EncoderView<'_>, held: WorkingPreset) -> WorkingPreset {
        // P65000 can also change without a parameter request; a reset sets it to 0.
        let before = self.value.replace(held.preset_value);
        let is_new = held.preset_value != 0 && before.is_some_and(|before| before != held.preset_value);
        if core::mem::take(&mut self.is_written) || is_new {
            WorkingPreset { offset: view.measuring.preset(PresetMode::Absolute, held.preset_value.into()), ..held }
        } else {
            held
        }
    }

    fn powered_up(&mut self) {
        *self = PresetsAtWrite::default();
    }
}
