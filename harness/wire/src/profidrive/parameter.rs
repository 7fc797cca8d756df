//! Requests and responses of the base mode parameter access.
//!
//! A request is a header, the address of each parameter and, if it changes them, their values. A response is a header
//! and a value or an error for each parameter; a change that succeeded as a whole has the header alone. All counts can be
//! set apart from the lists they count, so that wrong requests can be built as well. Source: PROFIdrive profile, base
//! mode parameter access; figures agree with the SICK AFS60/AFM60 manual, 3.5.1 and 3.5.2.

use super::{ErrorNumber, Format};
use crate::codes::codes;
use crate::error::Result;
use crate::octets::{Append, Reader};
use alloc::vec::Vec;

codes! {
    /// What a request asks for; unknown numbers are kept.
    pub struct RequestId(u8) {
        0x01 REQUEST request "Values are asked for.",
        0x02 CHANGE change "Values are to be changed.",
    }
}

codes! {
    /// What became of a request; unknown numbers are kept.
    pub struct ResponseId(u8) {
        0x01 REQUEST requested "All values follow.",
        0x02 CHANGE changed "All values were changed.",
        0x81 REQUEST_FAILED request_failed "At least one parameter could not be read.",
        0x82 CHANGE_FAILED change_failed "At least one parameter could not be changed.",
    }
}

codes! {
    /// What of a parameter is accessed; unknown numbers are kept.
    pub struct Attribute(u8) {
        0x10 VALUE value "The value.",
        0x20 DESCRIPTION description "The description, whose elements the subindex selects.",
        0x30 TEXT text "The text, whose line the subindex selects.",
    }
}

impl ResponseId {
    /// Whether the request failed in full or in part: bit 7.
    pub fn is_negative(self) -> bool {
        self.0 & 0x80 != 0
    }
}

/// The head of a request: octet 0 reference, 1 request id, 2 axis or drive object, 3 number of parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RequestHeader {
    /// Request reference, 0x01 to 0xFF, mirrored by the response.
    pub reference: u8,
    /// What is asked for.
    pub id: RequestId,
    /// Number of the axis or drive object, mirrored by the response.
    pub do_id: u8,
    /// Number of parameters, 0x01 to 0x27; what is transferred, whatever the list of addresses holds.
    pub parameter_count: u8,
}

/// The head of a response: octet 0 reference, 1 response id, 2 axis or drive object, 3 number of parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ResponseHeader {
    /// The reference of the request.
    pub reference: u8,
    /// What became of the request.
    pub id: ResponseId,
    /// The axis or drive object of the request.
    pub do_id: u8,
    /// Number of parameters; what is transferred, whatever the list of values holds.
    pub parameter_count: u8,
}

/// Which elements of which parameter: octet 0 attribute, 1 number of elements, 2-3 number, 4-5 subindex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParameterAddress {
    /// What of the parameter is accessed.
    pub attribute: Attribute,
    /// Number of elements, 0x00 to 0xEA; 0 and 1 both mean a single value.
    pub element_count: u8,
    /// Parameter number (PNU), 1 to 65535.
    pub number: u16,
    /// Index of the first element.
    pub subindex: u16,
}

/// Values of one parameter, or its error: octet 0 format, 1 number of values, 2.. values, filled up to an even length.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParameterValue {
    /// In which format the values stand.
    pub format: Format,
    /// Number of values; what is transferred, whatever `data` holds.
    pub count: u8,
    /// The values as they are transferred, most significant octet first, without padding.
    pub data: Vec<u8>,
    /// The octet that fills up to an even length, where there is one.
    pub padding: Option<u8>,
}

/// Why a parameter was refused, and at which of its elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParameterError {
    /// Why.
    pub number: ErrorNumber,
    /// The first element that was refused, where the response says so.
    pub subindex: Option<u16>,
}

/// A request for parameters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Request {
    /// The head.
    pub header: RequestHeader,
    /// One address per parameter.
    pub addresses: Vec<ParameterAddress>,
    /// One entry per parameter if they are to be changed, else none.
    pub values: Vec<ParameterValue>,
    /// Octets behind all that the header announces; normally none.
    pub rest: Vec<u8>,
}

/// A response to a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Response {
    /// The head.
    pub header: ResponseHeader,
    /// One value or error per parameter; none after a change that succeeded as a whole.
    pub values: Vec<ParameterValue>,
    /// Octets behind all that the header announces; normally none.
    pub rest: Vec<u8>,
}

impl RequestHeader {
    /// Reads a header; for what follows see [`Request::parse`].
    pub fn read(reader: &mut Reader<'_>) -> Result<RequestHeader> {
        Ok(RequestHeader {
            reference: reader.u8()?,
            id: RequestId(reader.u8()?),
            do_id: reader.u8()?,
            parameter_count: reader.u8()?,
        })
    }
}

impl ParameterAddress {
    /// The address of a single value: one element of an array, or the value of a parameter that is none.
    ///
    /// The number of elements is 0 for subindex 0 and 1 otherwise, which devices of either kind understand.
    pub fn value(number: u16, subindex: u16) -> ParameterAddress {
        ParameterAddress::elements(number, subindex, u8::from(subindex != 0))
    }

    /// The address of `count` elements of an array, from `subindex` on.
    pub fn elements(number: u16, subindex: u16, count: u8) -> ParameterAddress {
        ParameterAddress { attribute: Attribute::VALUE, element_count: count, number, subindex }
    }

    fn read(reader: &mut Reader<'_>) -> Result<ParameterAddress> {
        Ok(ParameterAddress {
            attribute: Attribute(reader.u8()?),
            element_count: reader.u8()?,
            number: reader.u16()?,
            subindex: reader.u16()?,
        })
    }

    fn write(&self, out: &mut Vec<u8>) {
        out.put(&[self.attribute.0, self.element_count]);
        out.put_u16(self.number);
        out.put_u16(self.subindex);
    }
}

impl ParameterValue {
    /// Values whose octets are given, with the padding they need; `count` is the number of values, not of octets.
    pub fn new(format: Format, count: u8, data: Vec<u8>) -> ParameterValue {
        let padding = (data.len() % 2 == 1).then_some(0);
        ParameterValue { format, count, data, padding }
    }

    /// Numbers in `format`, each cut to its width; signed numbers as two's complement.
    ///
    /// A format of unknown width or without values gives no data.
    pub fn numbers(format: Format, numbers: &[u64]) -> ParameterValue {
        let width = format.width().unwrap_or(0);
        let mut data = Vec::with_capacity(width * numbers.len());
        for number in numbers {
            data.put(&number.to_be_bytes()[8 - width..]);
        }
        ParameterValue::new(format, numbers.len() as u8, data)
    }

    /// What a response says of a parameter that was changed although another one of the request was refused.
    pub fn changed() -> ParameterValue {
        ParameterValue::new(Format::ZERO, 0, Vec::new())
    }

    /// What a response says of a parameter that was refused.
    pub fn refused(error: ParameterError) -> ParameterValue {
        let mut data = Vec::with_capacity(4);
        data.put_u16(error.number.0);
        if let Some(subindex) = error.subindex {
            data.put_u16(subindex);
        }
        ParameterValue::new(Format::ERROR, (data.len() / 2) as u8, data)
    }

    /// The values as numbers, sign not looked at; none for a format that has no values or is unknown.
    pub fn to_numbers(&self) -> Option<Vec<u64>> {
        let width = self.format.width().filter(|width| *width > 0)?;
        Some(
            self.data
                .chunks_exact(width)
                .map(|value| value.iter().fold(0, |sum, octet| sum << 8 | u64::from(*octet)))
                .collect(),
        )
    }

    /// The first value as a number, its sign heeded as the format says.
    pub fn to_number(&self) -> Option<i64> {
        let width = self.format.width()?;
        let number = *self.to_numbers()?.first()?;
        if !self.format.is_signed() {
            return i64::try_from(number).ok();
        }
        let unused = 64 - 8 * width as u32;
        Some((number << unused) as i64 >> unused)
    }

    /// The error, if this is one.
    pub fn error(&self) -> Option<ParameterError> {
        if self.format != Format::ERROR {
            return None;
        }
        let mut values = self.data.chunks_exact(2).map(|value| u16::from_be_bytes([value[0], value[1]]));
        Some(ParameterError { number: ErrorNumber(values.next()?), subindex: values.next() })
    }

    /// Reads the values of one parameter; where the width of the format is unknown, all octets that are left are values.
    fn read(reader: &mut Reader<'_>) -> Result<ParameterValue> {
        let format = Format(reader.u8()?);
        let count = reader.u8()?;
        let Some(width) = format.width() else {
            return Ok(ParameterValue { format, count, data: reader.rest().to_vec(), padding: None });
        };
        let data = reader.take(width * usize::from(count))?.to_vec();
        let padded = data.len() % 2 == 1 && !reader.is_empty();
        let padding = if padded { Some(reader.u8()?) } else { None };
        Ok(ParameterValue { format, count, data, padding })
    }

    fn write(&self, out: &mut Vec<u8>) {
        out.put(&[self.format.0, self.count]);
        out.put(&self.data);
        out.extend(self.padding);
    }

    /// Reads up to `count` values and stops early behind one of unknown width.
    fn read_all(reader: &mut Reader<'_>, count: u8) -> Result<Vec<ParameterValue>> {
        let mut values = Vec::new();
        for _ in 0..count {
            let value = ParameterValue::read(reader)?;
            let go_on = value.format.width().is_some();
            values.push(value);
            if !go_on {
                break;
            }
        }
        Ok(values)
    }
}

impl Request {
    /// A request for the values at `addresses`.
    pub fn read_values(reference: u8, do_id: u8, addresses: Vec<ParameterAddress>) -> Request {
        let header = RequestHeader { reference, id: RequestId::REQUEST, do_id, parameter_count: addresses.len() as u8 };
        Request { header, addresses, values: Vec::new(), rest: Vec::new() }
    }

    /// A request that changes parameters.
    pub fn change_values(reference: u8, do_id: u8, changes: Vec<(ParameterAddress, ParameterValue)>) -> Request {
        let header = RequestHeader { reference, id: RequestId::CHANGE, do_id, parameter_count: changes.len() as u8 };
        let (addresses, values) = changes.into_iter().unzip();
        Request { header, addresses, values, rest: Vec::new() }
    }

    /// Reads a request.
    ///
    /// Values are looked for only if the request id is to change values; with an unknown one they are in `rest`. A value
    /// of unknown format swallows what is behind it, so that there can be fewer values than addresses. Fails where octets
    /// are missing.
    pub fn parse(octets: &[u8]) -> Result<Request> {
        let mut reader = Reader::new("PROFIdrive parameter request", octets);
        let header = RequestHeader::read(&mut reader)?;
        let addresses =
            (0..header.parameter_count).map(|_| ParameterAddress::read(&mut reader)).collect::<Result<Vec<_>>>()?;
        let values = match header.id {
            RequestId::CHANGE => ParameterValue::read_all(&mut reader, header.parameter_count)?,
            _ => Vec::new(),
        };
        Ok(Request { header, addresses, values, rest: reader.rest().to_vec() })
    }

    /// Appends the request; the counts are those of the fields, right or wrong.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put(&[self.header.reference, self.header.id.0, self.header.do_id, self.header.parameter_count]);
        self.addresses.iter().for_each(|address| address.write(out));
        self.values.iter().for_each(|value| value.write(out));
        out.put(&self.rest);
    }
}

impl Response {
    /// The response to a request for values: positive if no entry of `values` is an error.
    pub fn to_read(request: &RequestHeader, values: Vec<ParameterValue>) -> Response {
        let failed = values.iter().any(|value| value.format == Format::ERROR);
        let id = if failed { ResponseId::REQUEST_FAILED } else { ResponseId::REQUEST };
        Response::new(request, id, values)
    }

    /// The response to a request to change values, one outcome per parameter: header alone if all succeeded.
    pub fn to_change(request: &RequestHeader, outcomes: &[Result<(), ParameterError>]) -> Response {
        if outcomes.iter().all(Result::is_ok) {
            return Response { values: Vec::new(), ..Response::new(request, ResponseId::CHANGE, Vec::new()) };
        }
        let values = outcomes.iter().map(|outcome| match outcome {
            Ok(()) => ParameterValue::changed(),
            Err(error) => ParameterValue::refused(*error),
        });
        Response::new(request, ResponseId::CHANGE_FAILED, values.collect())
    }

    /// A response with this id; reference, axis and number of parameters are those of the request.
    pub fn new(request: &RequestHeader, id: ResponseId, values: Vec<ParameterValue>) -> Response {
        let RequestHeader { reference, do_id, parameter_count, .. } = *request;
        Response { header: ResponseHeader { reference, id, do_id, parameter_count }, values, rest: Vec::new() }
    }

    /// Reads a response; fails where octets are missing.
    ///
    /// A positive response to a change has no values: what follows its header is in `rest`.
    pub fn parse(octets: &[u8]) -> Result<Response> {
        let mut reader = Reader::new("PROFIdrive parameter response", octets);
        let header = ResponseHeader {
            reference: reader.u8()?,
            id: ResponseId(reader.u8()?),
            do_id: reader.u8()?,
            parameter_count: reader.u8()?,
        };
        let values = match header.id {
            ResponseId::REQUEST | ResponseId::REQUEST_FAILED | ResponseId::CHANGE_FAILED => {
                ParameterValue::read_all(&mut reader, header.parameter_count)?
            }
            _ => Vec::new(),
        };
        Ok(Response { header, values, rest: reader.rest().to_vec() })
    }

    /// Appends the response; the counts are those of the fields, right or wrong.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put(&[self.header.reference, self.header.id.0, self.header.do_id, self.header.parameter_count]);
        self.values.iter().for_each(|value| value.write(out));
        out.put(&self.rest);
    }
}
