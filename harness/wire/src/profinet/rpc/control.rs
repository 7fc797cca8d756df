//! The bodies of PDUs that control a call: fack, cancel, cancel acknowledgement, fault and reject.

use crate::codes::codes;
use crate::error::Result;
use crate::octets::{Append, ByteOrder, ByteReader};
use alloc::vec::Vec;

codes! {
    /// Why a call was rejected or failed: the body of `reject` and `fault`, 32 bits in the byte order of the header
    /// (C706, appendix E).
    pub struct RejectStatus(u32) {
        0x0000_0001 FAULT_OTHER nca_s_fault_other "The operation failed for a reason without a specific code.",
        0x0000_0005 FAULT_ACCESS_DENIED nca_s_fault_access_denied "The caller may not do this.",
        0x0000_06D8 FAULT_CANNOT_PERFORM nca_s_fault_cant_perform "The server cannot perform the operation.",
        0x0000_06F7 FAULT_NDR nca_s_fault_ndr "The body could not be decoded.",
        0x1C00_0001 FAULT_INTEGER_DIVISION nca_s_fault_int_div_by_zero "The operation divided an integer by zero.",
        0x1C00_0002 FAULT_ADDRESS nca_s_fault_addr_error "The operation used an invalid address.",
        0x1C00_0003 FAULT_FLOAT_DIVISION nca_s_fault_fp_div_zero "The operation divided a floating point number by zero.",
        0x1C00_0004 FAULT_FLOAT_UNDERFLOW nca_s_fault_fp_underflow "A floating point number became too small.",
        0x1C00_0005 FAULT_FLOAT_OVERFLOW nca_s_fault_fp_overflow "A floating point number became too large.",
        0x1C00_0006 FAULT_INVALID_TAG nca_s_fault_invalid_tag "The body selects an unknown union variant.",
        0x1C00_0007 FAULT_INVALID_BOUND nca_s_fault_invalid_bound "The body has an array out of its bounds.",
        0x1C00_0008 RPC_VERSION_MISMATCH nca_rpc_version_mismatch "The server uses another version of RPC.",
        0x1C00_0009 UNSPECIFIED_REJECT nca_unspec_reject "The call was rejected without a reason.",
        0x1C00_000A BAD_ACTIVITY nca_s_bad_actid "The activity is unknown.",
        0x1C00_000B WHO_ARE_YOU_FAILED nca_who_are_you_failed "The server could not call the client back.",
        0x1C00_000C MANAGER_NOT_ENTERED nca_manager_not_entered "The call did not reach the operation.",
        0x1C00_000D FAULT_CANCEL nca_s_fault_cancel "The operation was cancelled.",
        0x1C00_000E FAULT_ILLEGAL_INSTRUCTION nca_s_fault_ill_inst "The operation caused an illegal instruction.",
        0x1C00_000F FAULT_FLOAT nca_s_fault_fp_error "The operation caused a floating point error.",
        0x1C00_0010 FAULT_INTEGER_OVERFLOW nca_s_fault_int_overflow "An integer became too large.",
        0x1C00_0012 FAULT_UNSPECIFIED nca_s_fault_unspec "The operation failed without a reason.",
        0x1C00_0013 FAULT_REMOTE_COMMUNICATION nca_s_fault_remote_comm_failure "The server lost the connection to a remote party.",
        0x1C00_0014 FAULT_PIPE_EMPTY nca_s_fault_pipe_empty "A pipe has no data.",
        0x1C00_0015 FAULT_PIPE_CLOSED nca_s_fault_pipe_closed "A pipe was closed.",
        0x1C00_0016 FAULT_PIPE_ORDER nca_s_fault_pipe_order "Pipes were used in the wrong order.",
        0x1C00_0017 FAULT_PIPE_DISCIPLINE nca_s_fault_pipe_discipline "A pipe was used incorrectly.",
        0x1C00_0018 FAULT_PIPE_COMMUNICATION nca_s_fault_pipe_comm_error "A pipe lost its other end.",
        0x1C00_0019 FAULT_PIPE_MEMORY nca_s_fault_pipe_memory "There is no memory for a pipe.",
        0x1C00_001A FAULT_CONTEXT_MISMATCH nca_s_fault_context_mismatch "The context handle is unknown.",
        0x1C00_001B FAULT_REMOTE_NO_MEMORY nca_s_fault_remote_no_memory "The server has no memory left.",
        0x1C00_001C INVALID_PRESENTATION_CONTEXT nca_invalid_pres_context_id "The presentation context is unknown.",
        0x1C00_001D UNSUPPORTED_AUTHENTICATION nca_unsupported_authn_level "The level of authentication is not supported.",
        0x1C00_001F INVALID_CHECKSUM nca_invalid_checksum "The checksum of the call is wrong.",
        0x1C00_0020 INVALID_CRC nca_invalid_crc "The CRC of the call is wrong.",
        0x1C00_0021 FAULT_USER_DEFINED nca_s_fault_user_defined "The operation raised a user-defined exception.",
        0x1C00_0022 FAULT_TRANSMIT_OPEN nca_s_fault_tx_open_failed "A transmission could not be opened.",
        0x1C00_0023 FAULT_CODE_SET nca_s_fault_codeset_conv_error "Text could not be converted.",
        0x1C00_0024 FAULT_OBJECT_NOT_FOUND nca_s_fault_object_not_found "The object is unknown.",
        0x1C00_0025 FAULT_NO_CLIENT_STUB nca_s_fault_no_client_stub "The client has no stub for the callback.",
        0x1C01_0002 OPERATION_RANGE nca_op_rng_error "The interface has no operation of this number.",
        0x1C01_0003 UNKNOWN_INTERFACE nca_unk_if "The interface is unknown.",
        0x1C01_0006 WRONG_BOOT_TIME nca_wrong_boot_time "The server has restarted since the first call of the client.",
        0x1C01_0009 YOU_CRASHED nca_s_you_crashed "The client has restarted.",
        0x1C01_000B PROTOCOL_ERROR nca_proto_error "The call violates the protocol.",
        0x1C01_0013 OUTPUT_TOO_BIG nca_out_args_too_big "The response is too large.",
        0x1C01_0014 SERVER_TOO_BUSY nca_server_too_busy "The server is too busy.",
        0x1C01_0017 UNSUPPORTED_TYPE nca_unsupported_type "The type of the object is not supported.",
    }
}

impl RejectStatus {
    /// Parses the body of a fault or reject in `order`; ignores bytes after the code.
    pub fn parse(order: ByteOrder, body: &[u8]) -> Result<RejectStatus> {
        Ok(RejectStatus(ByteReader::new("RPC reject", body).order(order).u32()?))
    }

    /// Appends the body.
    pub fn write(&self, out: &mut Vec<u8>, order: ByteOrder) {
        out.put_u32_in(order, self.0);
    }
}

/// The body of a fack: the fragments that a side has received. If it is absent, only the fragment number in the header counts.
///
/// Bytes: 0 version, 1 padding, 2-3 window size, 4-7 largest datagram, 8-11 largest fragment, 12-13 serial number,
/// 14-15 number of words, then the words of the selective acknowledgement (C706, 12.5.3.4).
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Fack {
    /// Version of the body: 0 or 1.
    pub version: u8,
    /// Padding byte, 0.
    pub padding: u8,
    /// Free space at the receiver: KiB in version 0, packets in version 1.
    pub window_size: u16,
    /// Largest datagram that the side can handle, in bytes.
    pub max_tsdu: u32,
    /// Largest datagram that is not fragmented by IP, in bytes.
    pub max_fragment: u32,
    /// Serial number of the fragment that triggered this fack.
    pub serial: u16,
    /// Bit `b` of word `w`: fragment `header.fragment + 1 + 32 w + b` has been received, too.
    pub selective: Vec<u32>,
    /// Bytes after that; some stacks send a word that they do not count.
    pub rest: Vec<u8>,
}

impl Fack {
    /// Parses the body of a fack in `order`; `None` if it is absent.
    pub fn parse(order: ByteOrder, body: &[u8]) -> Result<Option<Fack>> {
        if body.is_empty() {
            return Ok(None);
        }
        let mut reader = ByteReader::new("RPC fack", body).order(order);
        let mut fack = Fack {
            version: reader.u8()?,
            padding: reader.u8()?,
            window_size: reader.u16()?,
            max_tsdu: reader.u32()?,
            max_fragment: reader.u32()?,
            serial: reader.u16()?,
            selective: Vec::new(),
            rest: Vec::new(),
        };
        for _ in 0..reader.u16()? {
            fack.selective.push(reader.u32()?);
        }
        fack.rest = reader.rest().to_vec();
        Ok(Some(fack))
    }

    /// Appends the body.
    pub fn write(&self, out: &mut Vec<u8>, order: ByteOrder) {
        out.put(&[self.version, self.padding]);
        out.put_u16_in(order, self.window_size);
        out.put_u32_in(order, self.max_tsdu);
        out.put_u32_in(order, self.max_fragment);
        out.put_u16_in(order, self.serial);
        out.put_u16_in(order, self.selective.len() as u16);
        for word in &self.selective {
            out.put_u32_in(order, *word);
        }
        out.put(&self.rest);
    }
}

/// The body of a cancel: bytes 0-3 version, 4-7 number of the cancel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cancel {
    /// Version of the body, 0.
    pub version: u32,
    /// Number of the cancel within its call.
    pub cancel_id: u32,
}

impl Cancel {
    /// Reads the body of a cancel in `order`.
    pub fn parse(order: ByteOrder, body: &[u8]) -> Result<Cancel> {
        let mut reader = ByteReader::new("RPC cancel", body).order(order);
        Ok(Cancel { version: reader.u32()?, cancel_id: reader.u32()? })
    }

    /// Appends the body.
    pub fn write(&self, out: &mut Vec<u8>, order: ByteOrder) {
        out.put_u32_in(order, self.version);
        out.put_u32_in(order, self.cancel_id);
    }
}

/// The body of a cancel acknowledgement: bytes 0-3 version, 4-7 number of the cancel, 8-11 whether the server accepts cancels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CancelAck {
    /// Version of the body, 0.
    pub version: u32,
    /// Number of the cancel within its call.
    pub cancel_id: u32,
    /// 0 if the server does not accept cancels.
    pub accepting: u32,
}

impl CancelAck {
    /// Parses the body of a cancel acknowledgement in `order`; `None` if it is absent.
    pub fn parse(order: ByteOrder, body: &[u8]) -> Result<Option<CancelAck>> {
        if body.is_empty() {
            return Ok(None);
        }
        let mut reader = ByteReader::new("RPC cancel_ack", body).order(order);
        Ok(Some(CancelAck { version: reader.u32()?, cancel_id: reader.u32()?, accepting: reader.u32()? }))
    }

    /// Appends the body.
    pub fn write(&self, out: &mut Vec<u8>, order: ByteOrder) {
        for word in [self.version, self.cancel_id, self.accepting] {
            out.put_u32_in(order, word);
        }
    }
}
