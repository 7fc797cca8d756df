//! Bugs of the base mode parameter access.

use super::Deviation;
use alloc::vec::Vec;
use encoder_profile::profidrive::parameters::{Exchange, MAX_OCTETS, MAX_PARAMETERS};
use wire::profidrive::{
    ErrorNumber, Format, ParameterAddress, ParameterError, ParameterValue, Request, RequestHeader, RequestId, Response,
    ResponseHeader,
};

/// The bugs of this seam.
pub static BUGS: &[Deviation] = encoder_bugs! {
    // Requests
    "number-octets-swapped" "The octets of a parameter number are exchanged."
        => |b| b.parameters.understand = |request| each_address(request, |at| ParameterAddress { number: at.number.swap_bytes(), ..at });
    "unknown-request-read" "An unknown request is taken for one that reads."
        => |b| b.parameters.understand = unknown_request_read;
    "unknown-format-taken" "A value of an unknown format is taken for a double word."
        => |b| b.parameters.understand = unknown_format_taken;
    "axis-not-checked" "Any DO-ID is answered."
        => |b| b.parameters.axis = |_| true;
    "attribute-not-checked" "Any attribute reads the value."
        => |b| b.parameters.attribute = false;
    "zero-elements-refused" "A parameter that is no array is refused with 0 elements."
        => |b| b.parameters.zero_elements = false;
    "array-read-from-zero" "A run of elements always begins with subindex 0."
        => |b| b.parameters.first_element = |subindex, count| if count > 1 { 0 } else { subindex };
    "short-request-reads-old-buffer" "Missing octets are taken from the request before."
        => |b| b.parameters.length = false;
    "hangs-after-malformed-request" "After a request with a wrong number of parameters none is answered."
        => |b| b.parameters.hangs = |octets| octets.get(3).is_some_and(|count| *count == 0 || *count > MAX_PARAMETERS);
    "hangs-after-reference-0" "After a request with reference 0 none is answered."
        => |b| b.parameters.hangs = |octets| octets.first() == Some(&0);

    // Refusals
    "unknown-parameter-reads-zero" "Unknown parameters read as 0."
        => |b| b.parameters.refusal = |id, _, found| found.filter(|error| id != RequestId::REQUEST || error.number != ErrorNumber::UNKNOWN_PARAMETER);
    "unknown-write-acknowledged" "Writing an unknown parameter is answered positively."
        => |b| b.parameters.refusal = |id, _, found| found.filter(|error| id != RequestId::CHANGE || error.number != ErrorNumber::UNKNOWN_PARAMETER);
    "read-only-write-acknowledged" "Writing a read-only parameter is answered positively."
        => |b| b.parameters.refusal = |_, _, found| found.filter(|error| error.number != ErrorNumber::READ_ONLY);
    "limit-called-wrong-type" "A value that is not allowed is refused as one of a wrong type."
        => |b| b.parameters.refusal = limit_called_wrong_type;
    "p971-cannot-be-read" "P971 can be written and not read."
        => |b| b.parameters.refusal = p971_cannot_be_read;
    "subindex-past-end-reads-zero" "Elements behind the end of an array read as 0."
        => |b| b.parameters.end_of_array = false;
    "subindex-ignored-without-array" "The subindex is not looked at if the parameter is no array."
        => |b| b.parameters.array = false;
    "wrong-type-taken" "A value of another width is taken as it comes."
        => |b| b.parameters.takes = |_, _| true;
    "type-code-refused" "A value is taken with the code of its size only and not with that of its type."
        => |b| b.parameters.takes = |value, parameter| value == parameter;
    "value-count-not-checked" "The number of values is not compared with the number of elements."
        => |b| b.parameters.value_count = false;
    "written-before-checked" "A value is written before it is checked, and is refused afterwards."
        => |b| b.parameters.checks_first = false;

    // Several parameters in one request
    "multi-read-answers-first-only" "Of several parameters in a request only the first is answered."
        => |b| b.parameters.answered = 1;
    "multi-write-stops-at-first-error" "After a refused parameter the others are not written."
        => |b| b.parameters.goes_on_after_error = false;
    "one-error-drops-all" "One refused parameter takes the values of the others out of the response."
        => |b| b.parameters.octets = one_error_drops_all;
    "response-cut-off" "A response that is too long is cut off."
        => |b| (b.parameters.fit, b.parameters.octets) = (|values| values, response_cut_off);

    // Responses
    "reference-always-one" "The response always carries the reference 1."
        => |b| b.parameters.octets = reference_always_one;
    "response-without-format" "The values of a response stand without their format."
        => |b| b.parameters.octets = response_without_format;
    "write-answered-with-values" "The response to a write repeats the values."
        => |b| b.parameters.octets = write_answered_with_values;
    "error-of-one-octet" "The number of an error has one octet."
        => |b| b.parameters.octets = error_of_one_octet;
    "response-of-the-request-before" "A request is answered with its reference and the values of the one before."
        => |b| b.parameters.octets = response_of_the_request_before;
    "old-response-repeated" "A response can be read again and again."
        => |b| b.parameters.fetched_once = false;
};

/// The bugs of this seam that not all manuals have.
pub static OTHERS: &[Deviation] = encoder_bugs! {
    "request-octets-exchanged" "Requests are expected with the octets of their pairs exchanged."
        => |b| b.parameters.received = swapped;
    "both-orders-understood" "Requests with the octets of their pairs exchanged are understood too."
        => |b| b.parameters.received = |octets| match octets {
            [1 | 2, id, ..] if !matches!(id, 1 | 2) => swapped(octets),
            _ => octets.into(),
        };
    "request-of-14-octets" "A write has no format and no number of values."
        => |b| b.parameters.received = |octets| match octets {
            [_, 2, ..] if octets.len() == 14 => [&octets[..10], &[0x43, 1], &octets[10..]].concat(),
            [_, 2, ..] => Vec::new(),
            _ => octets.into(),
        };
    "elements-of-a-single-value-ignored" "The number of elements is not looked at if the parameter is no array."
        => |b| b.parameters.understand = elements_of_a_single_value_ignored;
    "subindex-0-refused" "P65000 is refused as an element that does not exist."
        => |b| b.parameters.refusal = |_, number, found| match number {
            65000 => Some(ParameterError { number: ErrorNumber::NO_SUCH_SUBINDEX, subindex: None }),
            _ => found,
        };
};

/// The octets with those of each pair exchanged: of the header, of the first address and of its value.
fn swapped(octets: &[u8]) -> Vec<u8> {
    let mut octets = octets.to_vec();
    let is_request = octets.len() >= 10;
    for at in [0, 2, 4, 10] {
        if at + 1 < octets.len() && (at != 10 || is_request) {
            octets.swap(at, at + 1);
        }
    }
    octets
}

fn elements_of_a_single_value_ignored(mut request: Request) -> Request {
    let is_single = |address: &ParameterAddress| address.number == 65000;
    if !request.addresses.iter().all(is_single) {
        return request;
    }
    for value in &mut request.values {
        if let Some(width) = value.format.width() {
            value.count = 1;
            value.data.truncate(width);
        }
    }
    each_address(request, |at| ParameterAddress { element_count: 0, ..at })
}

fn each_address(request: Request, change: fn(ParameterAddress) -> ParameterAddress) -> Request {
    Request { addresses: request.addresses.into_iter().map(change).collect(), ..request }
}

fn unknown_request_read(request: Request) -> Request {
    match request.header.id {
        RequestId::REQUEST | RequestId::CHANGE => request,
        _ => Request { header: RequestHeader { id: RequestId::REQUEST, ..request.header }, ..request },
    }
}

fn unknown_format_taken(mut request: Request) -> Request {
    for value in request.values.iter_mut().filter(|value| value.format.width().is_none()) {
        (value.format, value.count) = (Format::DOUBLE_WORD, 1);
    }
    request
}

fn limit_called_wrong_type(_: RequestId, _: u16, found: Option<ParameterError>) -> Option<ParameterError> {
    let number = match found?.number {
        ErrorNumber::LIMIT | ErrorNumber::VALUE_NOT_ALLOWED => ErrorNumber::WRONG_TYPE,
        number => number,
    };
    found.map(|error| ParameterError { number, ..error })
}

fn p971_cannot_be_read(id: RequestId, number: u16, found: Option<ParameterError>) -> Option<ParameterError> {
    match (id, number) {
        (RequestId::REQUEST, 971) => Some(ParameterError { number: ErrorNumber::BAD_ADDRESS, subindex: None }),
        _ => found,
    }
}

/// The octets of another response in the place of the right one.
fn octets_of(response: &Response) -> Vec<u8> {
    let mut octets = Vec::new();
    response.write(&mut octets);
    octets
}

fn one_error_drops_all(exchange: &Exchange<'_>) -> Vec<u8> {
    let mut response = exchange.response.clone();
    if response.values.iter().any(|value| value.error().is_some()) {
        response.values.retain(|value| value.error().is_some());
    }
    octets_of(&response)
}

fn response_cut_off(exchange: &Exchange<'_>) -> Vec<u8> {
    exchange.octets().into_iter().take(MAX_OCTETS).collect()
}

fn reference_always_one(exchange: &Exchange<'_>) -> Vec<u8> {
    let response = exchange.response.clone();
    octets_of(&Response { header: ResponseHeader { reference: 1, ..response.header }, ..response })
}

fn response_without_format(exchange: &Exchange<'_>) -> Vec<u8> {
    let mut octets = octets_of(&Response { values: Vec::new(), ..exchange.response.clone() });
    for value in &exchange.response.values {
        octets.push(value.count);
        octets.extend(&value.data);
    }
    octets
}

fn write_answered_with_values(exchange: &Exchange<'_>) -> Vec<u8> {
    let mut response = exchange.response.clone();
    if response.values.is_empty() {
        response.values.clone_from(&exchange.request.values);
    }
    octets_of(&response)
}

fn error_of_one_octet(exchange: &Exchange<'_>) -> Vec<u8> {
    let mut response = exchange.response.clone();
    for value in &mut response.values {
        if let Some(error) = value.error() {
            *value = ParameterValue { data: [error.number.0 as u8].into(), ..ParameterValue::refused(error) };
        }
    }
    octets_of(&response)
}

fn response_of_the_request_before(exchange: &Exchange<'_>) -> Vec<u8> {
    let right = exchange.octets();
    match exchange.before {
        [] => right,
        before => right.iter().take(1).chain(before.iter().skip(1)).copied().collect(),
    }
}
