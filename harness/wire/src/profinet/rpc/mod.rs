//! DCE/RPC over UDP (connectionless, version 4) as PROFINET uses it: header, NDR header, fragments, control PDUs and the endpoint
//! mapper.
//!
//! Source: "DCE 1.1: Remote Procedure Call" (C706) and IEC 61158-6-10. This module must not know blocks or time: client and server
//! decide when to retry, ping or give up.

mod control;
mod endpoint_mapper;
mod fragments;
mod header;
mod ndr;
mod uuid;

pub use control::{Cancel, CancelAck, Fack, RejectStatus};
pub use endpoint_mapper::{EndpointEntry, InquiryType, LookupHandle, LookupRequest, LookupResponse, Tower};
pub use fragments::{Assembled, Incomplete, Reassembler, fragments};
pub use header::{Drep, Flags1, Flags2, Opnum, PacketType, RpcHeader, RpcPdu};
pub use ndr::{NdrRequest, NdrResponse};
pub use uuid::{NotAUuid, ObjectUuid, Uuid};

/// The UDP port of PROFINET devices, controllers and their endpoint mappers.
pub const PORT: u16 = 0x8894;
