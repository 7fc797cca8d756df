//! DCE/RPC over UDP (connectionless, version 4) as PROFINET uses it: header, NDR frame around the blocks, fragments,
//! the small control bodies and the endpoint mapper.
//!
//! Facts are from "DCE 1.1: Remote Procedure Call" (C706) and from IEC 61158-6-10. This room knows no blocks and no time: when to
//! repeat, ping or give up is for the parties to decide.

mod control;
mod endpoint_mapper;
mod fragments;
mod header;
mod ndr;
mod uuid;

pub use control::{Cancel, CancelAck, Fack, RejectStatus};
pub use endpoint_mapper::{Entry, InquiryType, LookupHandle, LookupRequest, LookupResponse, Tower};
pub use fragments::{Assembled, Incomplete, Reassembler, fragments};
pub use header::{Drep, Flags1, Flags2, Header, Opnum, PacketType, Pdu};
pub use ndr::{NdrRequest, NdrResponse};
pub use uuid::{NotAUuid, ObjectUuid, Uuid};

/// The UDP port where PROFINET devices, controllers and their endpoint mappers listen.
pub const PORT: u16 = 0x8894;
