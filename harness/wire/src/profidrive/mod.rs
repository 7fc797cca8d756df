//! PROFIdrive: base mode parameter access (record 0xB02E on PROFINET, record 47 on PROFIBUS).
//!
//! This module must not know the bus that carries requests and responses, nor the meaning of any parameter.

pub mod error_number;
pub mod format;
pub mod parameter;

pub use error_number::ErrorNumber;
pub use format::ParameterFormat;
pub use parameter::{
    Attribute, ParameterAddress, ParameterError, ParameterRequest, ParameterResponse, ParameterValue, RequestHeader,
    RequestId, ResponseHeader, ResponseId,
};
