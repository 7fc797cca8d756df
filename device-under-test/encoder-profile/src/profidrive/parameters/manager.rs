//! The parameter manager: parses requests and builds responses.

use super::{BadRequest, MAX_OCTETS, MAX_PARAMETERS, ParameterStore};
use crate::profidrive::checks::{AttachedChecks, EncoderCheck};
use alloc::vec::Vec;
use wire::profidrive::{
    ErrorNumber, ParameterAddress, ParameterError, ParameterRequest, ParameterResponse, ParameterValue, RequestHeader,
    RequestId, ResponseId,
};

/// The parameter manager of one drive object.
#[derive(Clone, Debug, Default)]
pub struct ParameterManager {
    /// Whether requests for every axis or drive object are answered, not only for 0 and 1.
    pub serves_any_axis: bool,
    /// Hooks of its decisions.
    pub checks: AttachedChecks,
}

/// A request with its response.
#[derive(Clone, Debug)]
pub struct ParameterExchange {
    /// The parsed request.
    pub request: ParameterRequest,
    /// The response.
    pub response: ParameterResponse,
}

impl ParameterExchange {
    /// The bytes of the response.
    pub fn octets(&self) -> Vec<u8> {
        let mut octets = Vec::new();
        self.response.write(&mut octets);
        octets
    }
}

/// An error for a whole parameter.
pub(super) fn refused(number: ErrorNumber) -> ParameterError {
    ParameterError { number, subindex: None }
}

impl ParameterManager {
    /// Carries out a request.
    pub fn answer(&self, octets: &[u8], parameters: &mut impl ParameterStore) -> Result<ParameterExchange, BadRequest> {
        if octets.get(3).is_some_and(|count| *count == 0 || *count > MAX_PARAMETERS) {
            return Err(BadRequest::Count);
        }
        let request = ParameterRequest::parse(octets).map_err(|_| BadRequest::TooShort)?;
        let response = self.response(&request, parameters);
        Ok(ParameterExchange { request, response })
    }

    fn response(&self, request: &ParameterRequest, parameters: &mut impl ParameterStore) -> ParameterResponse {
        let header = &request.header;
        let is_served = self.checks.check(EncoderCheck::Axis(header.do_id), self.serves_any_axis || header.do_id <= 1);
        let is_served_at_once = self.checks.check(EncoderCheck::ParameterCount(request.addresses.len()), true);
        match header.id {
            RequestId::REQUEST | RequestId::CHANGE if !is_served => failed(request, ErrorNumber::NO_SUCH_AXIS),
            RequestId::REQUEST | RequestId::CHANGE if !is_served_at_once => {
                failed(request, ErrorNumber::SINGLE_PARAMETER_ONLY)
            }
            RequestId::REQUEST => self.read(request, parameters),
            RequestId::CHANGE => self.change(request, parameters),
            _ => failed(request, ErrorNumber::UNKNOWN_REQUEST),
        }
    }

    /// The response to a request for values.
    fn read(&self, request: &ParameterRequest, parameters: &impl ParameterStore) -> ParameterResponse {
        let values = request.addresses.iter().map(|address| match self.elements(address, parameters, false) {
            Ok((parameter, elements)) => {
                let elements: Vec<u64> = elements.map(|n| parameter.values.get(n).copied().unwrap_or(0)).collect();
                ParameterValue::numbers(parameter.format, &elements)
            }
            Err(error) => ParameterValue::refused(error),
        });
        ParameterResponse::to_read(&request.header, self.fit(values.collect()))
    }

    /// Carries out a request to change values. A refused parameter does not prevent the others from being changed.
    fn change(&self, request: &ParameterRequest, parameters: &mut impl ParameterStore) -> ParameterResponse {
        let is_last = |n| n + 1 == request.addresses.len();
        let outcomes = request.addresses.iter().enumerate().map(|(n, address)| {
            // Bytes after the last value count as surplus values.
            let surplus = if is_last(n) { request.rest.len() } else { 0 };
            if !self.checks.check(EncoderCheck::SurplusOctets(surplus), surplus == 0) {
                return Err(refused(ErrorNumber::BAD_VALUE_COUNT));
            }
            let values = self.values(address, request.values.get(n), parameters)?;
            parameters.write(address.number, address.subindex, &values).map_err(refused)
        });
        ParameterResponse::to_change(&request.header, &outcomes.collect::<Vec<_>>())
    }

    /// Makes the values fit into a response. A value that would leave no space for the others is refused as too long.
    fn fit(&self, mut values: Vec<ParameterValue>) -> Vec<ParameterValue> {
        let too_long = ParameterValue::refused(refused(ErrorNumber::RESPONSE_TOO_LONG));
        let error_octets = 2 + too_long.data.len();
        let mut left = MAX_OCTETS - 4 - error_octets * values.len();
        for value in &mut values {
            let octets = 2 + value.data.len().next_multiple_of(2);
            let more = octets.saturating_sub(error_octets);
            if self.checks.check(EncoderCheck::ValueFits(octets), more <= left) {
                left = left.saturating_sub(more);
            } else {
                *value = too_long.clone();
            }
        }
        values
    }
}

/// The response to a request of which all parameters are refused.
fn failed(request: &ParameterRequest, number: ErrorNumber) -> ParameterResponse {
    let RequestHeader { id, .. } = request.header;
    let id = if id == RequestId::CHANGE { ResponseId::CHANGE_FAILED } else { ResponseId::REQUEST_FAILED };
    let error = |_: &ParameterAddress| ParameterValue::refused(refused(number));
    ParameterResponse::new(&request.header, id, request.addresses.iter().map(error).collect())
}
