//! Requests and responses of the base mode parameter access.
//!
//! A request is a header, the address of each parameter and, in a change request, their values. A response is a header and a
//! value or an error for each parameter; the response to a successful change is only the header. All counts can be set
//! independently of the lists that they count, to build invalid requests. Source: PROFIdrive profile, base mode parameter
//! access; the layout agrees with the SICK AFS60/AFM60 manual, 3.5.1 and 3.5.2.

use super::{ErrorNumber, ParameterFormat};
use crate::codes::codes;
use crate::error::Result;
use crate::octets::{Append, ByteReader};
use alloc::vec::Vec;

codes! {
    /// The kind of a request; unknown numbers are preserved.
    pub struct RequestId(u8) {
        0x01 REQUEST request "Reads values.",
        0x02 CHANGE change "Changes values.",
    }
}

codes! {
    /// The result of a request; unknown numbers are preserved.
    pub struct ResponseId(u8) {
        0x01 REQUEST requested "All values were read.",
        0x02 CHANGE changed "All values were changed.",
        0x81 REQUEST_FAILED request_failed "At least one parameter could not be read.",
        0x82 CHANGE_FAILED change_failed "At least one parameter could not be changed.",
    }
}

codes! {
    /// The accessed attribute of a parameter; unknown numbers are preserved.
    pub struct Attribute(u8) {
        0x10 VALUE value "The value.",
        0x20 DESCRIPTION description "The description, whose elements the subindex selects.",
        0x30 TEXT text "The text, whose line the subindex selects.",
    }
}

impl ResponseId {
    /// Whether the request failed completely or in part: bit 7.
    pub fn is_negative(self) -> bool {
        self.0 & 0x80 != 0
    }
}

/// The header of a request: byte 0 reference, 1 request id, 2 axis or drive object, 3 number of parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RequestHeader {
    /// Request reference, 0x01 to 0xFF, mirrored by the response.
    pub reference: u8,
    /// The kind of request.
    pub id: RequestId,
    /// Number of the axis or drive object, mirrored by the response.
    pub do_id: u8,
    /// Number of parameters, 0x01 to 0x27; transferred as is, independent of the list of addresses.
    pub parameter_count: u8,
}

/// The header of a response: byte 0 reference, 1 response id, 2 axis or drive object, 3 number of parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ResponseHeader {
    /// The reference of the request.
    pub reference: u8,
    /// The result of the request.
    pub id: ResponseId,
    /// The axis or drive object of the request.
    pub do_id: u8,
    /// Number of parameters; transferred as is, independent of the list of values.
    pub parameter_count: u8,
}

/// The address of a parameter or of elements of an array: byte 0 attribute, 1 number of elements, 2-3 number, 4-5 subindex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParameterAddress {
    /// The accessed attribute.
    pub attribute: Attribute,
    /// Number of elements, 0x00 to 0xEA; 0 and 1 both mean a single value.
    pub element_count: u8,
    /// Parameter number (PNU), 1 to 65535.
    pub number: u16,
    /// Index of the first element.
    pub subindex: u16,
}

/// Values of one parameter, or its error: byte 0 format, 1 number of values, 2.. values, padded to an even length.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParameterValue {
    /// The format of the values.
    pub format: ParameterFormat,
    /// Number of values; transferred as is, independent of `data`.
    pub count: u8,
    /// The values as transferred, big-endian, without padding.
    pub data: Vec<u8>,
    /// The padding byte, if there is one.
    pub padding: Option<u8>,
}

/// Why a parameter was refused, and at which element.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ParameterError {
    /// The error number.
    pub number: ErrorNumber,
    /// The first element that was refused, if the response has it.
    pub subindex: Option<u16>,
}

/// A request for parameters.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParameterRequest {
    /// The header.
    pub header: RequestHeader,
    /// One address per parameter.
    pub addresses: Vec<ParameterAddress>,
    /// One entry per parameter in a change request; otherwise empty.
    pub values: Vec<ParameterValue>,
    /// Bytes after everything that the header announces; normally empty.
    pub rest: Vec<u8>,
}

/// A response to a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParameterResponse {
    /// The header.
    pub header: ResponseHeader,
    /// One value or error per parameter; empty after a successful change.
    pub values: Vec<ParameterValue>,
    /// Bytes after everything that the header announces; normally empty.
    pub rest: Vec<u8>,
}

impl RequestHeader {
    /// Parses only the header; [`ParameterRequest::parse`] parses the whole request.
    pub fn read(reader: &mut ByteReader<'_>) -> Result<RequestHeader> {
        Ok(RequestHeader {
            reference: reader.u8()?,
            id: RequestId(reader.u8()?),
            do_id: reader.u8()?,
            parameter_count: reader.u8()?,
        })
    }
}

impl ParameterAddress {
    /// The address of a single value: one element of an array, or the value of a parameter that is not an array.
    ///
    /// The number of elements is 0 for subindex 0 and 1 otherwise, which all devices accept.
    pub fn value(number: u16, subindex: u16) -> ParameterAddress {
        ParameterAddress::elements(number, subindex, u8::from(subindex != 0))
    }

    /// The address of `count` elements of an array, from `subindex` on.
    pub fn elements(number: u16, subindex: u16, count: u8) -> ParameterAddress {
        ParameterAddress { attribute: Attribute::VALUE, element_count: count, number, subindex }
    }

    fn read(reader: &mut ByteReader<'_>) -> Result<ParameterAddress> {
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
    /// Values from their bytes, padded to an even length; `count` is the number of values, not of bytes.
    pub fn new(format: ParameterFormat, count: u8, data: Vec<u8>) -> ParameterValue {
        let padding = (data.len() % 2 == 1).then_some(0);
        ParameterValue { format, count, data, padding }
    }

    /// Numbers in `format`, each truncated to its width; signed numbers as two's complement.
    ///
    /// The data are empty for a format of unknown width or without values.
    pub fn numbers(format: ParameterFormat, numbers: &[u64]) -> ParameterValue {
        let width = format.width().unwrap_or(0);
        let mut data = Vec::with_capacity(width * numbers.len());
        for number in numbers {
            data.put(&number.to_be_bytes()[8 - width..]);
        }
        ParameterValue::new(format, numbers.len() as u8, data)
    }

    /// The entry of a response for a changed parameter, if another parameter of the request was refused.
    pub fn changed() -> ParameterValue {
        ParameterValue::new(ParameterFormat::ZERO, 0, Vec::new())
    }

    /// The entry of a response for a refused parameter.
    pub fn refused(error: ParameterError) -> ParameterValue {
        let mut data = Vec::with_capacity(4);
        data.put_u16(error.number.0);
        if let Some(subindex) = error.subindex {
            data.put_u16(subindex);
        }
        ParameterValue::new(ParameterFormat::ERROR, (data.len() / 2) as u8, data)
    }

    /// The values as unsigned numbers; `None` for a format without values or an unknown format.
    pub fn to_numbers(&self) -> Option<Vec<u64>> {
        let width = self.format.width().filter(|width| *width > 0)?;
        Some(
            self.data
                .chunks_exact(width)
                .map(|value| value.iter().fold(0, |sum, octet| sum << 8 | u64::from(*octet)))
                .collect(),
        )
    }

    /// The first value as a number, signed if its format is.
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
        if self.format != ParameterFormat::ERROR {
            return None;
        }
        let mut values = self.data.chunks_exact(2).map(|value| u16::from_be_bytes([value[0], value[1]]));
        Some(ParameterError { number: ErrorNumber(values.next()?), subindex: values.next() })
    }

    /// Parses the values of one parameter; if the width of the format is unknown, all remaining bytes are values.
    fn read(reader: &mut ByteReader<'_>) -> Result<ParameterValue> {
        let format = ParameterFormat(reader.u8()?);
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

    /// Parses up to `count` values; stops after a value of unknown width.
    fn read_all(reader: &mut ByteReader<'_>, count: u8) -> Result<Vec<ParameterValue>> {
        let mut values = Vec::new();
        for _ in 0..count {
            let value = ParameterValue::read(reader)?;
            let has_width = value.format.width().is_some();
            values.push(value);
            if !has_width {
                break;
            }
        }
        Ok(values)
    }
}

impl ParameterRequest {
    /// A request for the values at `addresses`.
    pub fn read_values(reference: u8, do_id: u8, addresses: Vec<ParameterAddress>) -> ParameterRequest {
        let header = RequestHeader { reference, id: RequestId::REQUEST, do_id, parameter_count: addresses.len() as u8 };
        ParameterRequest { header, addresses, values: Vec::new(), rest: Vec::new() }
    }

    /// A request that changes parameters.
    pub fn change_values(
        reference: u8,
        do_id: u8,
        changes: Vec<(ParameterAddress, ParameterValue)>,
    ) -> ParameterRequest {
        let header = RequestHeader { reference, id: RequestId::CHANGE, do_id, parameter_count: changes.len() as u8 };
        let (addresses, values) = changes.into_iter().unzip();
        ParameterRequest { header, addresses, values, rest: Vec::new() }
    }

    /// Parses a request.
    ///
    /// Only a change request has values; with an unknown request id they are in `rest`. A value of unknown format extends to the
    /// end of the request, so there can be fewer values than addresses. Fails if bytes are missing.
    pub fn parse(octets: &[u8]) -> Result<ParameterRequest> {
        let mut reader = ByteReader::new("PROFIdrive parameter request", octets);
        let header = RequestHeader::read(&mut reader)?;
        let addresses =
            (0..header.parameter_count).map(|_| ParameterAddress::read(&mut reader)).collect::<Result<Vec<_>>>()?;
        let values = match header.id {
            RequestId::CHANGE => ParameterValue::read_all(&mut reader, header.parameter_count)?,
            _ => Vec::new(),
        };
        Ok(ParameterRequest { header, addresses, values, rest: reader.rest().to_vec() })
    }

    /// Appends the request; the counts are written as they are, valid or not.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put(&[self.header.reference, self.header.id.0, self.header.do_id, self.header.parameter_count]);
        self.addresses.iter().for_each(|address| address.write(out));
        self.values.iter().for_each(|value| value.write(out));
        out.put(&self.rest);
    }
}

impl ParameterResponse {
    /// The response to a request for values: positive if no entry of `values` is an error.
    pub fn to_read(request: &RequestHeader, values: Vec<ParameterValue>) -> ParameterResponse {
        let failed = values.iter().any(|value| value.format == ParameterFormat::ERROR);
        let id = if failed { ResponseId::REQUEST_FAILED } else { ResponseId::REQUEST };
        ParameterResponse::new(request, id, values)
    }

    /// The response to a change request, with one outcome per parameter; only the header if all succeeded.
    pub fn to_change(request: &RequestHeader, outcomes: &[Result<(), ParameterError>]) -> ParameterResponse {
        if outcomes.iter().all(Result::is_ok) {
            return ParameterResponse {
                values: Vec::new(),
                ..ParameterResponse::new(request, ResponseId::CHANGE, Vec::new())
            };
        }
        let values = outcomes.iter().map(|outcome| match outcome {
            Ok(()) => ParameterValue::changed(),
            Err(error) => ParameterValue::refused(*error),
        });
        ParameterResponse::new(request, ResponseId::CHANGE_FAILED, values.collect())
    }

    /// A response with this id; reference, axis and number of parameters are copied from the request.
    pub fn new(request: &RequestHeader, id: ResponseId, values: Vec<ParameterValue>) -> ParameterResponse {
        let RequestHeader { reference, do_id, parameter_count, .. } = *request;
        ParameterResponse { header: ResponseHeader { reference, id, do_id, parameter_count }, values, rest: Vec::new() }
    }

    /// Parses a response; fails if bytes are missing.
    ///
    /// A positive response to a change has no values: bytes after its header are in `rest`.
    pub fn parse(octets: &[u8]) -> Result<ParameterResponse> {
        let mut reader = ByteReader::new("PROFIdrive parameter response", octets);
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
        Ok(ParameterResponse { header, values, rest: reader.rest().to_vec() })
    }

    /// Appends the response; the counts are written as they are, valid or not.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.put(&[self.header.reference, self.header.id.0, self.header.do_id, self.header.parameter_count]);
        self.values.iter().for_each(|value| value.write(out));
        out.put(&self.rest);
    }
}
