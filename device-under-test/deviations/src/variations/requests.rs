//! Parameter requests that are refused as a whole.

use alloc::vec::Vec;
use wire::profidrive::{ErrorNumber, ParameterError, ParameterRequest, ParameterResponse, ParameterValue, RequestId};

/// The response that refuses each parameter of a request.
pub fn refuse_all(request: &ParameterRequest, number: ErrorNumber) -> ParameterResponse {
    let error = ParameterError { number, subindex: None };
    let header = &request.header;
    if header.id == RequestId::CHANGE {
        let outcomes: Vec<_> = request.addresses.iter().map(|_| Err(error)).collect();
        ParameterResponse::to_change(header, &outcomes)
    } else {
        ParameterResponse::to_read(header, request.addresses.iter().map(|_| ParameterValue::refused(error)).collect())
    }
}
