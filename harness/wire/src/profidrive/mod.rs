//! PROFIdrive: base mode parameter access (record 0xB02E on PROFINET, record 47 on PROFIBUS).
//!
//! This room knows requests and responses and their formats, but neither the bus that carries them nor any parameter.

pub mod error_number;
pub mod format;
pub mod parameter;

pub use error_number::ErrorNumber;
pub use format::Format;
pub use parameter::{
    Attribute, ParameterAddress, ParameterError, ParameterValue, Request, RequestHeader, RequestId, Response,
    ResponseHeader, ResponseId,
};
