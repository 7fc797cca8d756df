//! Bugs of the base mode parameter access that only some encoders can have.

use super::Group;
use super::parameter_access_state::{HangsAfterRequest, ResponseOfEarlierConnection};
use crate::needs::Need;
use alloc::vec::Vec;
use encoder_profile::checks::EncoderCheck;
use encoder_profile::profidrive::parameters::{MAX_OCTETS, MAX_PARAMETERS, ParameterExchange};
use reference_devices::manuals;
use wire::profidrive::{
    ErrorNumber, ParameterAddress, ParameterError, ParameterFormat, ParameterRequest, ParameterResponse,
    ParameterValue, RequestHeader, RequestId, ResponseHeader, ResponseId,
};

/// The bugs, by what they need.
pub static GROUPS: &[Group] = &[
    // The access itself
    Group {
        needs: &[Need::EncoderProfile],
        deviations: bugs! {
            "bytes-swapped-in-pairs" "The bytes of each pair are swapped in requests and responses."
                => |d| {
                    d.encoder.parameter_request(|_, octets| swapped_request(octets));
                    d.encoder.parameter_response(swapped_response);
                };
            "values-read-too-early" "The value of a write is read one byte too early."
                => |d| d.encoder.change_request(values_read_too_early);
            "values-after-each-address" "In a write with several parameters a value is expected after each address."
                => |d| d.encoder.change_request(values_behind_each_address);
            "more-parameters-than-39-answered" "A request for 40 parameters is answered."
                => |d| d.encoder.parameter_request(|_, octets| more_parameters(octets));
            "word-format-refused" "A 16-bit parameter refuses the format of its size."
                => |d| d.checks.check(|check, right| match check {
                    EncoderCheck::ValueFormat { format, parameter } => parameter != ParameterFormat::WORD && format == parameter,
                    _ => right,
                });
            "surplus-bytes-ignored" "Bytes after the last value are ignored."
                => |d| d.checks.check(|check, right| right || matches!(check, EncoderCheck::SurplusOctets(_)));
            "only-axis-1-served" "Axes other than 1 are refused."
                => |d| d.checks.check(|check, right| match check { EncoderCheck::Axis(axis) => axis == 1, _ => right });
            "response-outlives-connection" "A response that was not read can be read in the next connection."
                => |d| d.encoder.add(ResponseOfEarlierConnection::default());
            "response-padded" "Responses are padded with zeros."
                => |d| d.encoder.parameter_response(response_padded);
            "p65000-as-word" "P65000 is answered as a word."
                => |d| d.encoder.format(65000, ParameterFormat::WORD);
            "reference-with-a-sign" "A reference above 7Fh is returned as 7Fh."
                => |d| d.encoder.respond(|_, right| with_header(right, |header| ResponseHeader { reference: header.reference.min(0x7F), ..header }));
            "response-id-always-read" "A successful write is answered with the ID of a read."
                => |d| d.encoder.respond(|_, right| with_header(right, |header| ResponseHeader { id: if header.id == ResponseId::CHANGE { ResponseId::REQUEST } else { header.id }, ..header }));
            "errors-with-positive-id" "A refused request is answered with the positive response ID."
                => |d| d.encoder.respond(|_, right| with_header(right, |header| ResponseHeader { id: ResponseId(header.id.0 & 0x7F), ..header }));
            "axis-always-one" "The response always has axis 1."
                => |d| d.encoder.respond(|_, right| with_header(right, |header| ResponseHeader { do_id: 1, ..header }));
            "types-for-sizes" "Values have the format codes of their types."
                => |d| d.encoder.respond(|_, right| with_formats(right, types_for_sizes));
            "error-as-word" "An error has the format of a word."
                => |d| d.encoder.respond(|_, right| with_formats(right, |format| if format == ParameterFormat::ERROR { ParameterFormat::WORD } else { format }));
        },
    },
    // Arrays
    Group {
        needs: &[Need::Parameter(964)],
        deviations: bugs! {
            "zero-elements-give-the-array" "A read of 0 elements of an array returns the whole array."
                => |d| d.encoder.change_request(|request| each_address(request, whole_array));
            "parameter-0-is-the-first" "Parameter 0 reads as P922."
                => |d| d.encoder.change_request(|request| each_address(request, |at| ParameterAddress { number: if at.number == 0 { 922 } else { at.number }, ..at }));
            "array-write-first-only" "A write of several elements changes only the first one."
                => |d| d.encoder.written(|_, _, values| values.map(|values| values.into_iter().take(1).collect()));
            "answers-in-order-of-number" "The values of several parameters are in the order of the parameter numbers."
                => |d| d.encoder.respond(answers_in_order_of_number);
        },
    },
    // P971
    Group {
        needs: &[Need::Parameter(971)],
        deviations: bugs! {
            "p971-read-without-value" "A read of P971 is answered without a value."
                => |d| d.encoder.respond(p971_read_without_value);
        },
    },
    // Parameters of the AFS60 and AFM60
    Group {
        needs: &[Need::Of(&manuals::SICK_AFX60)],
        deviations: bugs! {
            "hangs-after-reserved-parameter" "After a request for P1010 no request is answered."
                => |d| d.encoder.add(HangsAfterRequest::after(|octets| octets.get(6..8) == Some(&[0x03, 0xF2])));
            "internal-shift-refused" "A read of P1009.5 is refused."
                => |d| d.encoder.respond(internal_shift_refused);
            "double-words-after-p1005" "Elements beyond the end of P1005 read as double words."
                => |d| d.encoder.respond(double_words_behind);
            "name-of-240-bytes" "P61000 is answered with 240 bytes."
                => |d| d.encoder.respond(|request, right| name_of(request, right, true));
            "name-shorter-than-its-count" "A read of 240 elements of P61000 is answered with fewer bytes than its count."
                => |d| d.encoder.respond(|request, right| name_of(request, right, false));
        },
    },
];

fn each_address(request: ParameterRequest, change: fn(ParameterAddress) -> ParameterAddress) -> ParameterRequest {
    ParameterRequest { addresses: request.addresses.into_iter().map(change).collect(), ..request }
}

/// Swaps the bytes of each pair: in the header, in each address and in the first value.
fn swapped_request(mut octets: Vec<u8>) -> Vec<u8> {
    swap_heads(&mut octets);
    let count = usize::from(octets.get(3).copied().unwrap_or(0).min(MAX_PARAMETERS));
    for at in (0..=count).map(|n| 4 + 6 * n).filter(|at| at + 1 < octets.len()).collect::<Vec<_>>() {
        octets.swap(at, at + 1);
    }
    octets
}

fn swapped_response(exchange: &ParameterExchange, mut octets: Vec<u8>) -> Vec<u8> {
    swap_heads(&mut octets);
    let mut at = 4;
    for value in &exchange.response.values {
        if at + 1 < octets.len() {
            octets.swap(at, at + 1);
        }
        at += 2 + value.data.len() + usize::from(value.padding.is_some());
    }
    octets
}

fn swap_heads(octets: &mut [u8]) {
    if octets.len() >= 4 {
        octets.swap(0, 1);
        octets.swap(2, 3);
    }
}

fn values_read_too_early(mut request: ParameterRequest) -> ParameterRequest {
    for value in &mut request.values {
        value.data.insert(0, value.count);
        value.data.pop();
    }
    request
}

fn values_behind_each_address(mut request: ParameterRequest) -> ParameterRequest {
    if request.header.id == RequestId::CHANGE && request.addresses.len() > 1 {
        request.values.iter_mut().for_each(|value| value.format = ParameterFormat(0x10));
    }
    request
}

fn more_parameters(mut octets: Vec<u8>) -> Vec<u8> {
    if octets.get(3) == Some(&(MAX_PARAMETERS + 1)) {
        octets[3] = ((octets.len() - 4) / 6).min(MAX_PARAMETERS.into()) as u8;
    }
    octets
}

fn whole_array(at: ParameterAddress) -> ParameterAddress {
    let elements = match at.number {
        964 | 979 | 1005 => 6,
        975 => 7,
        980 => 28,
        1001 => 3,
        1002 | 1003 => 13,
        1006 | 1007 => 2,
        1009 => 11,
        65001 => 12,
        _ => 0,
    };
    match (at.element_count, elements) {
        (0, 1..) => ParameterAddress { element_count: elements, subindex: 0, ..at },
        _ => at,
    }
}

fn response_padded(_: &ParameterExchange, mut octets: Vec<u8>) -> Vec<u8> {
    octets.resize(octets.len().max(MAX_OCTETS), 0);
    octets
}

fn with_header(response: ParameterResponse, change: fn(ResponseHeader) -> ResponseHeader) -> ParameterResponse {
    ParameterResponse { header: change(response.header), ..response }
}

fn with_formats(mut response: ParameterResponse, change: fn(ParameterFormat) -> ParameterFormat) -> ParameterResponse {
    response.values.iter_mut().for_each(|value| value.format = change(value.format));
    response
}

fn types_for_sizes(format: ParameterFormat) -> ParameterFormat {
    match format {
        ParameterFormat::WORD => ParameterFormat::UNSIGNED16,
        ParameterFormat::DOUBLE_WORD => ParameterFormat::UNSIGNED32,
        other => other,
    }
}

fn answers_in_order_of_number(request: &ParameterRequest, mut response: ParameterResponse) -> ParameterResponse {
    let addresses = &request.addresses;
    if response.values.len() == addresses.len() {
        let mut values: Vec<_> = addresses.iter().map(|at| at.number).zip(response.values).collect();
        values.sort_by_key(|(number, _)| *number);
        response.values = values.into_iter().map(|(_, value)| value).collect();
    }
    response
}

fn reads(request: &ParameterRequest, number: u16) -> bool {
    let RequestHeader { id, .. } = request.header;
    id == RequestId::REQUEST && request.addresses.first().is_some_and(|at| at.number == number)
}

fn p971_read_without_value(request: &ParameterRequest, mut response: ParameterResponse) -> ParameterResponse {
    if let (true, [value, ..]) = (reads(request, 971), &mut response.values[..]) {
        *value = ParameterValue::new(ParameterFormat::WORD, 0, Vec::new());
    }
    response
}

fn internal_shift_refused(request: &ParameterRequest, mut response: ParameterResponse) -> ParameterResponse {
    let requested = request.addresses.iter().map(|at| (at.number, at.subindex));
    for (at, value) in requested.zip(&mut response.values) {
        if at == (1009, 5) && request.header.id == RequestId::REQUEST {
            *value = ParameterValue::refused(ParameterError { number: ErrorNumber::BAD_ADDRESS, subindex: None });
            response.header.id = ResponseId::REQUEST_FAILED;
        }
    }
    response
}

/// Answers with a station name with a count of 240: in 240 bytes, or in as many as fit into a response.
fn name_of(request: &ParameterRequest, mut response: ParameterResponse, is_whole: bool) -> ParameterResponse {
    let count = request.addresses.first().map_or(0, |at| at.element_count);
    if let (true, [value]) = (reads(request, 61000), &mut response.values[..])
        && (is_whole || count == 240)
    {
        let mut name = if value.format == ParameterFormat::OCTET_STRING { value.data.clone() } else { Vec::new() };
        name.resize(if is_whole { 240 } else { 234 }, 0);
        *value = ParameterValue { format: ParameterFormat::OCTET_STRING, count: 240, data: name, padding: None };
        response.header.id = ResponseId::REQUEST;
    }
    response
}

fn double_words_behind(request: &ParameterRequest, mut response: ParameterResponse) -> ParameterResponse {
    let requested = request.addresses.iter().map(|at| (at.number, at.subindex));
    for (at, value) in requested.zip(&mut response.values) {
        if let (1005, 6..=15) = at
            && request.header.id == RequestId::REQUEST
        {
            *value = ParameterValue::numbers(ParameterFormat::DOUBLE_WORD, &[0xDEAD_BEEF]);
            response.header.id = ResponseId::REQUEST;
        }
    }
    response
}
