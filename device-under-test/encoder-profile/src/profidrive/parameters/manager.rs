//! The manager itself: from the octets of a request to those of its response.

use super::{BadRequest, Exchange, MAX_ELEMENTS, MAX_OCTETS, MAX_PARAMETERS, Parameter, Parameters, Rules, Shape};
use alloc::vec::Vec;
use wire::profidrive::{
    Attribute, ErrorNumber, Format, ParameterAddress, ParameterError, ParameterValue, Request, RequestId, Response,
    ResponseId,
};

/// The parameter manager: the channel to the parameters of one drive object, one request at a time per requester.
#[derive(Clone, Debug)]
pub struct Manager<K> {
    responses: Vec<(K, Vec<u8>)>,
    buffer: Vec<u8>,
    /// The last response, fetched or not.
    before: Vec<u8>,
    hangs: bool,
    rules: Rules,
}

impl<K: Copy + PartialEq> Manager<K> {
    /// A manager that was asked nothing yet.
    pub fn new(rules: Rules) -> Manager<K> {
        let buffer = alloc::vec![0; MAX_OCTETS];
        Manager { responses: Vec::new(), buffer, before: Vec::new(), hangs: false, rules }
    }

    /// Takes a request of `key` and keeps the response; an older one that was not fetched has gone.
    pub fn take(&mut self, key: K, octets: &[u8], parameters: &mut impl Parameters) -> Result<(), BadRequest> {
        self.forget(key);
        let received = (self.rules.received)(octets);
        let octets = &received[..];
        self.hangs |= (self.rules.hangs)(octets);
        if self.hangs {
            return Ok(());
        }
        let copied = octets.len().min(MAX_OCTETS);
        self.buffer[..copied].copy_from_slice(&octets[..copied]);
        if octets.get(3).is_some_and(|count| *count == 0 || *count > MAX_PARAMETERS) {
            return Err(BadRequest::Count);
        }
        let octets = if self.rules.length { octets } else { &self.buffer };
        let request = Request::parse(octets).map_err(|_| BadRequest::TooShort)?;
        let request = (self.rules.understand)(request);
        let response = answer(&request, parameters, &self.rules);
        let octets = (self.rules.octets)(&Exchange { request: &request, response, before: &self.before });
        self.before.clone_from(&octets);
        self.responses.push((key, octets));
        Ok(())
    }

    /// The response for `key`, if one is waiting.
    pub fn fetch(&mut self, key: K) -> Option<Vec<u8>> {
        let is_own = |of: K| of == key || !self.rules.forgets_at_end;
        let Some(at) = self.responses.iter().position(|(of, _)| is_own(*of)) else {
            return self.rules.answers_nothing.then(Vec::new);
        };
        match self.rules.fetched_once {
            true => Some(self.responses.swap_remove(at).1),
            false => Some(self.responses[at].1.clone()),
        }
    }

    /// The connection of `key` has ended.
    pub fn ended(&mut self, key: K) {
        if self.rules.forgets_at_end {
            self.forget(key);
        }
    }

    /// Forgets what is waiting for `key`.
    fn forget(&mut self, key: K) {
        self.responses.retain(|(of, _)| *of != key);
    }
}

fn answer(request: &Request, parameters: &mut impl Parameters, rules: &Rules) -> Response {
    let header = &request.header;
    let refusal = match header.id {
        RequestId::REQUEST | RequestId::CHANGE if !(rules.axis)(header.do_id) => ErrorNumber::NO_SUCH_AXIS,
        RequestId::REQUEST => {
            let addresses = request.addresses.iter().take(rules.answered);
            let values = addresses.map(|address| read(address, parameters, rules));
            return Response::to_read(header, (rules.fit)(values.collect()));
        }
        RequestId::CHANGE => {
            let mut outcomes = Vec::new();
            for (n, address) in request.addresses.iter().enumerate() {
                let stopped = !rules.goes_on_after_error && outcomes.iter().any(Result::is_err);
                // Octets behind the last value are values too many.
                let is_checked = rules.surplus && rules.value_count && rules.length;
                let surplus = is_checked && n + 1 == request.addresses.len() && !request.rest.is_empty();
                outcomes.push(match (stopped, surplus) {
                    (true, _) => Ok(()),
                    (false, true) => Err(ParameterError { number: ErrorNumber::BAD_VALUE_COUNT, subindex: None }),
                    (false, false) => change(address, request.values.get(n), parameters, rules),
                });
            }
            return Response::to_change(header, &outcomes);
        }
        _ => ErrorNumber::UNKNOWN_REQUEST,
    };
    let id = if header.id == RequestId::CHANGE { ResponseId::CHANGE_FAILED } else { ResponseId::REQUEST_FAILED };
    let error = ParameterValue::refused(ParameterError { number: refusal, subindex: None });
    Response::new(header, id, request.addresses.iter().map(|_| error.clone()).collect())
}

/// Makes the values fit into a response: one that would leave no room for the others is refused as too long.
pub fn fit(mut values: Vec<ParameterValue>) -> Vec<ParameterValue> {
    let too_long = ParameterValue::refused(ParameterError { number: ErrorNumber::RESPONSE_TOO_LONG, subindex: None });
    let error_octets = 2 + too_long.data.len();
    let mut left = MAX_OCTETS - 4 - error_octets * values.len();
    for value in &mut values {
        let more = (2 + value.data.len().next_multiple_of(2)).saturating_sub(error_octets);
        match left.checked_sub(more) {
            Some(rest) => left = rest,
            None => *value = too_long.clone(),
        }
    }
    values
}

fn read(address: &ParameterAddress, parameters: &impl Parameters, rules: &Rules) -> ParameterValue {
    let found = elements(address, parameters, false, rules);
    let error = found.as_ref().err().copied();
    match ((rules.refusal)(RequestId::REQUEST, address.number, error), found) {
        (Some(error), _) => ParameterValue::refused(error),
        (None, Ok((parameter, elements))) => {
            let elements: Vec<u64> = elements.map(|n| parameter.values.get(n).copied().unwrap_or(0)).collect();
            ParameterValue::numbers(parameter.format, &elements)
        }
        (None, Err(_)) => ParameterValue::numbers(Format::WORD, &[0]),
    }
}

fn change(
    address: &ParameterAddress,
    value: Option<&ParameterValue>,
    parameters: &mut impl Parameters,
    rules: &Rules,
) -> Result<(), ParameterError> {
    let mut values = value.and_then(ParameterValue::to_numbers).unwrap_or_default();
    values.truncate(rules.stored);
    if !rules.checks_first {
        let _ = parameters.write(address.number, address.subindex, &values);
    }
    let refused = |number| ParameterError { number, subindex: None };
    let outcome = check(address, value, parameters, rules)
        .and_then(|()| parameters.write(address.number, address.subindex, &values).map_err(refused));
    (rules.refusal)(RequestId::CHANGE, address.number, outcome.err()).map_or(Ok(()), Err)
}

/// Whether a value may be written, as far as the parameter itself need not be asked.
fn check(
    address: &ParameterAddress,
    value: Option<&ParameterValue>,
    parameters: &impl Parameters,
    rules: &Rules,
) -> Result<(), ParameterError> {
    let (parameter, elements) = elements(address, parameters, true, rules)?;
    let refused = |number| Err(ParameterError { number, subindex: None });
    // A value that is missing stood behind one whose format is unknown, where nothing can be read any more.
    let Some(value) = value else { return refused(ErrorNumber::BAD_FORMAT) };
    let width = match value.format {
        Format::ZERO | Format::ERROR => None,
        format => format.width(),
    };
    match width {
        None => refused(ErrorNumber::BAD_FORMAT),
        Some(_) if rules.value_count && usize::from(value.count) != elements.len() => {
            refused(ErrorNumber::BAD_VALUE_COUNT)
        }
        Some(_) if !(rules.takes)(value.format, parameter.format) => refused(ErrorNumber::WRONG_TYPE),
        Some(_) => Ok(()),
    }
}

/// Whether a value in this format may be written to a parameter of that one: the type itself or the form of its width.
pub fn is_of_type(format: Format, parameter: Format) -> bool {
    match parameter {
        Format::WORD => matches!(format, Format::WORD | Format::UNSIGNED16),
        Format::DOUBLE_WORD => matches!(format, Format::DOUBLE_WORD | Format::UNSIGNED32),
        other => format == other,
    }
}

/// The parameter at an address and which of its values are meant.
///
/// Checks in this order: number, attribute, access, number of elements, subindex.
fn elements(
    address: &ParameterAddress,
    parameters: &impl Parameters,
    writing: bool,
    rules: &Rules,
) -> Result<(Parameter, core::ops::Range<usize>), ParameterError> {
    let refused = |number| Err(ParameterError { number, subindex: None });
    let Some(parameter) = parameters.parameter(address.number) else {
        return refused(ErrorNumber::UNKNOWN_PARAMETER);
    };
    match (address.attribute, writing) {
        (Attribute::VALUE, _) => {}
        _ if !rules.attribute => {}
        (Attribute::DESCRIPTION, false) => return refused(ErrorNumber::NO_DESCRIPTION),
        (Attribute::DESCRIPTION, true) => return refused(ErrorNumber::DESCRIPTION_READ_ONLY),
        (Attribute::TEXT, false) => return refused(ErrorNumber::NO_TEXT_ARRAY),
        (Attribute::TEXT, true) => return refused(ErrorNumber::TEXT_READ_ONLY),
        _ => return refused(ErrorNumber::BAD_ADDRESS),
    }
    if writing && parameter.writable.is_empty() {
        return refused(ErrorNumber::READ_ONLY);
    }
    let count = usize::from(address.element_count.max(1));
    let subindex = (rules.first_element)(address.subindex, count);
    let is_single = parameter.shape == Shape::Value;
    if address.element_count > MAX_ELEMENTS || is_single && address.element_count == 0 && !rules.zero_elements {
        return refused(ErrorNumber::BAD_ADDRESS);
    }
    if is_single && count > 1 && rules.array {
        return refused(ErrorNumber::NO_ARRAY);
    }
    let is_whole = parameter.shape == Shape::Value || parameter.shape == Shape::Octets && count == 1;
    if is_whole {
        return match subindex == 0 || !rules.array {
            true => Ok((parameter.clone(), 0..parameter.values.len())),
            false => refused(ErrorNumber::NO_ARRAY),
        };
    }
    let wanted = usize::from(subindex)..usize::from(subindex) + count;
    if wanted.end > parameter.values.len() && rules.end_of_array {
        let first = usize::from(subindex).max(parameter.values.len()) as u16;
        return Err(ParameterError { number: ErrorNumber::NO_SUCH_SUBINDEX, subindex: Some(first) });
    }
    let is_writable = |n: usize| parameter.writable.contains(&n);
    match wanted.clone().find(|n| writing && !is_writable(*n)) {
        Some(fixed) => Err(ParameterError { number: ErrorNumber::READ_ONLY, subindex: Some(fixed as u16) }),
        None => Ok((parameter, wanted)),
    }
}
