//! The NDR header between the RPC header and the blocks.

use crate::error::Result;
use crate::octets::{Append, ByteOrder, ByteReader};
use crate::profinet::status::PnioStatus;
use alloc::vec::Vec;

/// The NDR header of a request; its words are in the byte order of the RPC header.
///
/// Bytes: 0-3 ArgsMaximum, 4-7 ArgsLength, 8-11 MaximumCount, 12-15 Offset, 16-19 ActualCount.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NdrRequest {
    /// ArgsMaximum: the maximum length of the blocks in the response, in bytes.
    pub args_maximum: u32,
    /// Length of the blocks that follow, in bytes.
    pub args_length: u32,
    /// Size of the array; equals ArgsMaximum.
    pub maximum_count: u32,
    /// Offset of the array; 0.
    pub offset: u32,
    /// Number of bytes of the array that are sent; equals ArgsLength.
    pub actual_count: u32,
}

impl NdrRequest {
    /// Length of this header in bytes.
    pub const LENGTH: usize = 20;

    /// Splits the body of a request in `order` into its NDR header and the bytes of its blocks.
    ///
    /// The blocks are all bytes after the header; the caller checks whether ArgsLength matches.
    pub fn parse(order: ByteOrder, body: &[u8]) -> Result<(NdrRequest, &[u8])> {
        let mut reader = ByteReader::new("NDR request", body).order(order);
        let ndr = NdrRequest {
            args_maximum: reader.u32()?,
            args_length: reader.u32()?,
            maximum_count: reader.u32()?,
            offset: reader.u32()?,
            actual_count: reader.u32()?,
        };
        Ok((ndr, reader.rest()))
    }

    /// Appends the header.
    pub fn write(&self, out: &mut Vec<u8>, order: ByteOrder) {
        for word in [self.args_maximum, self.args_length, self.maximum_count, self.offset, self.actual_count] {
            out.put_u32_in(order, word);
        }
    }

    /// The body of a request with `blocks`, whose caller accepts `args_maximum` bytes in the response.
    pub fn body(order: ByteOrder, args_maximum: u32, blocks: &[u8]) -> Vec<u8> {
        let length = blocks.len() as u32;
        let mut out = Vec::with_capacity(NdrRequest::LENGTH + blocks.len());
        NdrRequest { args_maximum, args_length: length, maximum_count: args_maximum, offset: 0, actual_count: length }
            .write(&mut out, order);
        out.put(blocks);
        out
    }
}

/// The NDR header of a response; its words are in the byte order of the RPC header.
///
/// Bytes: 0-3 PNIOStatus, 4-7 ArgsLength, 8-11 MaximumCount, 12-15 Offset, 16-19 ActualCount.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NdrResponse {
    /// The result of the call.
    pub status: PnioStatus,
    /// Length of the blocks that follow, in bytes.
    pub args_length: u32,
    /// Size of the array; equals ArgsMaximum of the request.
    pub maximum_count: u32,
    /// Offset of the array; 0.
    pub offset: u32,
    /// Number of bytes of the array that are sent; equals ArgsLength.
    pub actual_count: u32,
}

impl NdrResponse {
    /// Length of this header in bytes.
    pub const LENGTH: usize = 20;

    /// Splits the body of a response in `order` into its NDR header and the bytes of its blocks.
    pub fn parse(order: ByteOrder, body: &[u8]) -> Result<(NdrResponse, &[u8])> {
        let mut reader = ByteReader::new("NDR response", body).order(order);
        let ndr = NdrResponse {
            status: PnioStatus::from(reader.u32()?),
            args_length: reader.u32()?,
            maximum_count: reader.u32()?,
            offset: reader.u32()?,
            actual_count: reader.u32()?,
        };
        Ok((ndr, reader.rest()))
    }

    /// Appends the header.
    pub fn write(&self, out: &mut Vec<u8>, order: ByteOrder) {
        out.put_u32_in(order, self.status.into());
        for word in [self.args_length, self.maximum_count, self.offset, self.actual_count] {
            out.put_u32_in(order, word);
        }
    }

    /// The body of a response with `blocks` to a request whose ArgsMaximum was `args_maximum`.
    pub fn body(order: ByteOrder, status: PnioStatus, args_maximum: u32, blocks: &[u8]) -> Vec<u8> {
        let length = blocks.len() as u32;
        let mut out = Vec::with_capacity(NdrResponse::LENGTH + blocks.len());
        NdrResponse { status, args_length: length, maximum_count: args_maximum, offset: 0, actual_count: length }
            .write(&mut out, order);
        out.put(blocks);
        out
    }
}
