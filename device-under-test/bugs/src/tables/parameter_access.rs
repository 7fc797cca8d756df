//! Bugs of the base mode parameter access.

use super::Group;
use super::parameter_access_state::{
    HangsAfterRequest, MissingRequestBytes, OldResponse, ResponseBefore, StopsAtFirstError, WrittenBeforeChecked,
};
use crate::needs::Need;
use alloc::vec::Vec;
use encoder_profile::checks::EncoderCheck;
use encoder_profile::profidrive::parameters::{MAX_OCTETS, MAX_PARAMETERS, ParameterExchange};
use wire::profidrive::{
    ErrorNumber, ParameterAddress, ParameterError, ParameterFormat, ParameterRequest, ParameterResponse,
    ParameterValue, RequestHeader, RequestId, ResponseHeader,
};

/// The bugs, by what they need.
pub static GROUPS: &[Group] = &[
    // The access itself
    Group {
        needs: &[Need::EncoderProfile],
        deviations: bugs! {
            "number-bytes-swapped" "The bytes of a parameter number are swapped."
                => |d| d.encoder.change_request(|request| each_address(request, |at| ParameterAddress { number: at.number.swap_bytes(), ..at }));
            "unknown-request-read" "An unknown request ID is treated as a read."
                => |d| d.encoder.change_request(unknown_request_read);
            "unknown-format-taken" "A value of an unknown format is treated as a double word."
                => |d| d.encoder.change_request(unknown_format_taken);
            "attribute-not-checked" "A read of any attribute returns the value."
                => |d| d.checks.check(|check, right| right || matches!(check, EncoderCheck::Attribute(_)));
            "zero-elements-refused" "A request with 0 elements is refused for parameters that are not arrays."
                => |d| d.checks.set(EncoderCheck::ElementCount { count: 0, has_elements: false }, false);
            "one-element-refused" "A request with 1 element is refused for parameters that are not arrays."
                => |d| d.checks.set(EncoderCheck::ElementCount { count: 1, has_elements: false }, false);
            "short-request-reads-old-buffer" "Missing bytes are taken from the previous request."
                => |d| {
                    d.checks.check(|check, right| right || matches!(check, EncoderCheck::SurplusOctets(_)));
                    d.encoder.add(MissingRequestBytes::default());
                };
            "hangs-after-malformed-request" "After a request with an invalid number of parameters no request is answered."
                => |d| d.encoder.add(HangsAfterRequest::after(|octets| octets.get(3).is_some_and(|count| *count == 0 || *count > MAX_PARAMETERS)));
            "hangs-after-reference-0" "After a request with reference 0 no request is answered."
                => |d| d.encoder.add(HangsAfterRequest::after(|octets| octets.first() == Some(&0)));
            "unknown-parameter-reads-zero" "Unknown parameters read as 0."
                => |d| d.encoder.refuse(|id, _, found| found.filter(|error| id != RequestId::REQUEST || error.number != ErrorNumber::UNKNOWN_PARAMETER));
            "unknown-write-acknowledged" "Writing an unknown parameter is answered positively."
                => |d| d.encoder.refuse(|id, _, found| found.filter(|error| id != RequestId::CHANGE || error.number != ErrorNumber::UNKNOWN_PARAMETER));
            "read-only-write-acknowledged" "Writing a read-only parameter is answered positively."
                => |d| d.encoder.refuse(|_, _, found| found.filter(|error| error.number != ErrorNumber::READ_ONLY));
            "read-only-called-out-of-limits" "Writing a read-only parameter is refused with the error of a value beyond its limits."
                => |d| d.encoder.refuse(|_, _, found| found.map(|error| match error.number {
                    ErrorNumber::READ_ONLY => ParameterError { number: ErrorNumber::LIMIT, ..error },
                    _ => error,
                }));
            "limit-called-wrong-type" "A value that is not allowed is refused with the error of a wrong type."
                => |d| d.encoder.refuse(limit_called_wrong_type);
            "subindex-ignored-without-array" "The subindex is ignored for parameters that are not arrays."
                => |d| d.checks.check(|check, right| right || matches!(check, EncoderCheck::WholeValue { .. }));
            "wrong-type-taken" "A value with another width is accepted."
                => |d| d.checks.check(|check, right| right || matches!(check, EncoderCheck::ValueFormat { .. }));
            "type-code-refused" "A value is accepted only with the format code of its size, not with that of its type."
                => |d| d.checks.check(|check, right| match check { EncoderCheck::ValueFormat { format, parameter } => format == parameter, _ => right });
            "value-count-not-checked" "The number of values is not compared with the number of elements."
                => |d| d.checks.check(|check, right| right || matches!(check, EncoderCheck::ValueCount { .. } | EncoderCheck::SurplusOctets(_)));
            "written-before-checked" "A value is written before it is checked, even if it is then refused."
                => |d| {
                    let written = WrittenBeforeChecked::default();
                    d.checks.add(written.clone());
                    d.encoder.add(written);
                };
            "multi-read-answers-first-only" "Of several parameters in a request only the first is answered."
                => |d| d.encoder.respond(multi_read_answers_first_only);
            "multi-write-stops-at-first-error" "After a refused parameter the others are not written."
                => |d| {
                    let stops = StopsAtFirstError::default();
                    d.checks.add(stops.clone());
                    d.encoder.add(stops);
                };
            "one-error-drops-all" "One refused parameter removes the values of the other parameters from the response."
                => |d| d.encoder.respond(one_error_drops_all);
            "reference-always-one" "The response always carries the reference 1."
                => |d| d.encoder.respond(|_, right| ParameterResponse { header: ResponseHeader { reference: 1, ..right.header }, ..right });
            "response-without-format" "The values of a response have no format."
                => |d| d.encoder.parameter_response(response_without_format);
            "write-answered-with-values" "The response to a write repeats the values."
                => |d| d.encoder.respond(write_answered_with_values);
            "error-of-one-byte" "Error numbers have one byte instead of two."
                => |d| d.encoder.respond(error_of_one_octet);
            "response-of-the-request-before" "A request is answered with its reference but the values of the previous request."
                => |d| d.encoder.add(ResponseBefore::default());
            "old-response-repeated" "A response can be read again and again."
                => |d| d.encoder.add(OldResponse::default());
            "request-bytes-exchanged" "Requests are read with the bytes of each pair swapped."
                => |d| d.encoder.parameter_request(|_, octets| swapped(&octets));
            "both-orders-understood" "Requests with the bytes of each pair swapped are accepted too."
                => |d| d.encoder.parameter_request(|_, octets| match octets[..] {
                    [1 | 2, id, ..] if !matches!(id, 1 | 2) => swapped(&octets),
                    _ => octets,
                });
            "request-of-14-bytes" "A write has no format and no number of values."
                => |d| d.encoder.parameter_request(|_, octets| match octets[..] {
                    [_, 2, ..] if octets.len() == 14 => [&octets[..10], &[0x43, 1], &octets[10..]].concat(),
                    [_, 2, ..] => Vec::new(),
                    _ => octets,
                });
            "elements-of-a-single-value-ignored" "The number of elements is ignored for parameters that are not arrays."
                => |d| d.encoder.change_request(elements_of_a_single_value_ignored);
            "subindex-0-refused" "P65000 is refused with the error of a subindex that does not exist."
                => |d| d.encoder.refuse(|_, number, found| match number {
                    65000 => Some(ParameterError { number: ErrorNumber::NO_SUCH_SUBINDEX, subindex: None }),
                    _ => found,
                });
        },
    },
    // Axes that are refused
    Group {
        needs: &[Need::RefusesAxes],
        deviations: bugs! {
            "axis-unknown-as-parameter" "An unknown DO-ID is refused as an unknown parameter."
                => |d| d.encoder.refuse(|_, _, found| match found {
                    Some(error) if error.number == ErrorNumber::NO_SUCH_AXIS => {
                        Some(ParameterError { number: ErrorNumber::UNKNOWN_PARAMETER, ..error })
                    }
                    _ => found,
                });
        },
    },
    // Arrays
    Group {
        needs: &[Need::Parameter(964)],
        deviations: bugs! {
            "array-read-from-zero" "A read of several elements always begins with subindex 0."
                => |d| d.encoder.change_request(|request| each_address(request, |at| ParameterAddress { subindex: if at.element_count > 1 { 0 } else { at.subindex }, ..at }));
            "subindex-past-end-reads-zero" "Elements beyond the end of an array read as 0."
                => |d| d.checks.check(|check, right| right || matches!(check, EncoderCheck::Elements { .. }));
            "response-cut-off" "A response that is too long is cut off."
                => |d| {
                    d.checks.check(|check, right| right || matches!(check, EncoderCheck::ValueFits(_)));
                    d.encoder.parameter_response(|_, octets| octets.into_iter().take(MAX_OCTETS).collect());
                };
        },
    },
    // P971
    Group {
        needs: &[Need::Parameter(971)],
        deviations: bugs! {
            "p971-cannot-be-read" "P971 can be written but not read."
                => |d| d.encoder.refuse(p971_cannot_be_read);
        },
    },
];

/// Swaps the bytes of each pair: of the header, of the first address and of its value.
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

fn elements_of_a_single_value_ignored(mut request: ParameterRequest) -> ParameterRequest {
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

fn each_address(request: ParameterRequest, change: fn(ParameterAddress) -> ParameterAddress) -> ParameterRequest {
    ParameterRequest { addresses: request.addresses.into_iter().map(change).collect(), ..request }
}

fn unknown_request_read(request: ParameterRequest) -> ParameterRequest {
    match request.header.id {
        RequestId::REQUEST | RequestId::CHANGE => request,
        _ => ParameterRequest { header: RequestHeader { id: RequestId::REQUEST, ..request.header }, ..request },
    }
}

fn unknown_format_taken(mut request: ParameterRequest) -> ParameterRequest {
    for value in request.values.iter_mut().filter(|value| value.format.width().is_none()) {
        (value.format, value.count) = (ParameterFormat::DOUBLE_WORD, 1);
        value.data.truncate(4);
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

fn multi_read_answers_first_only(request: &ParameterRequest, right: ParameterResponse) -> ParameterResponse {
    match request.header.id {
        RequestId::REQUEST => ParameterResponse::to_read(&request.header, right.values.into_iter().take(1).collect()),
        _ => right,
    }
}

fn one_error_drops_all(_: &ParameterRequest, mut response: ParameterResponse) -> ParameterResponse {
    if response.values.iter().any(|value| value.error().is_some()) {
        response.values.retain(|value| value.error().is_some());
    }
    response
}

fn response_without_format(exchange: &ParameterExchange, right: Vec<u8>) -> Vec<u8> {
    let mut octets: Vec<u8> = right.into_iter().take(4).collect();
    for value in &exchange.response.values {
        octets.push(value.count);
        octets.extend(&value.data);
    }
    octets
}

fn write_answered_with_values(request: &ParameterRequest, mut response: ParameterResponse) -> ParameterResponse {
    if response.values.is_empty() {
        response.values.clone_from(&request.values);
    }
    response
}

fn error_of_one_octet(_: &ParameterRequest, mut response: ParameterResponse) -> ParameterResponse {
    for value in &mut response.values {
        if let Some(error) = value.error() {
            *value = ParameterValue { data: [error.number.0 as u8].into(), ..ParameterValue::refused(error) };
        }
    }
    response
}
