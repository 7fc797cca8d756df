//! Blocks for reading and writing records: Read, ReadImplicit, Write and write multiple.

use crate::error::Result;
use crate::octets::{Append, ByteOrder, ByteReader};
use crate::profinet::blocks::{BlockHeader, BlockType};
use crate::profinet::rpc::Uuid;
use crate::profinet::status::PnioStatus;
use alloc::vec::Vec;

/// The index of a Write with several records (write multiple).
pub const WRITE_MULTIPLE: u16 = 0xE040;

/// The common first fields of all four record blocks.
///
/// Bytes of the body: 0-1 SeqNumber, 2-17 ARUUID, 18-21 API, 22-23 slot, 24-25 subslot, 26-27 padding, 28-29 Index,
/// 30-33 RecordDataLength.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecordHeader {
    /// Version of the block: high byte, low byte.
    pub version: [u8; 2],
    /// Sequence number of the access within the AR.
    pub seq_number: u16,
    /// The UUID of the AR; nil in ReadImplicit.
    pub ar_uuid: Uuid,
    /// The API; 0xFFFFFFFF in write multiple.
    pub api: u32,
    /// The slot; 0xFFFF in write multiple.
    pub slot_number: u16,
    /// The subslot; 0xFFFF in write multiple.
    pub subslot_number: u16,
    /// Padding, 0.
    pub padding: u16,
    /// The index of the record.
    pub index: u16,
    /// Length of the record that follows, in bytes; in a read request the maximum that the requester accepts.
    pub record_data_length: u32,
}

impl Default for RecordHeader {
    /// Version 1.0 and zeros.
    fn default() -> RecordHeader {
        RecordHeader {
            version: [1, 0],
            seq_number: 0,
            ar_uuid: Uuid::NIL,
            api: 0,
            slot_number: 0,
            subslot_number: 0,
            padding: 0,
            index: 0,
            record_data_length: 0,
        }
    }
}

impl RecordHeader {
    /// Parses the common fields of a block that must be of type `kind`; returns a reader for the rest of the block.
    fn read<'a>(kind: BlockType, reader: &mut ByteReader<'a>) -> Result<(RecordHeader, ByteReader<'a>)> {
        let (block, mut body) = BlockHeader::read(reader)?;
        if block.kind != kind {
            return Err(body.wrong("BlockType", 6, kind.sentence().unwrap_or("a record block"), block.kind.0.into()));
        }
        let header = RecordHeader {
            version: [block.version_high, block.version_low],
            seq_number: body.u16()?,
            ar_uuid: Uuid::read(&mut body)?,
            api: body.u32()?,
            slot_number: body.u16()?,
            subslot_number: body.u16()?,
            padding: body.u16()?,
            index: body.u16()?,
            record_data_length: body.u32()?,
        };
        Ok((header, body))
    }

    fn write(&self, kind: BlockType, out: &mut Vec<u8>, tail: impl FnOnce(&mut Vec<u8>)) {
        let [version_high, version_low] = self.version;
        BlockHeader { kind, version_high, version_low }.write_with(out, |out| {
            out.put_u16(self.seq_number);
            self.ar_uuid.write(out, ByteOrder::Big);
            out.put_u32(self.api);
            for word in [self.slot_number, self.subslot_number, self.padding, self.index] {
                out.put_u16(word);
            }
            out.put_u32(self.record_data_length);
            tail(out);
        });
    }
}

/// IODReadReqHeader: the request of Read and ReadImplicit.
///
/// Bytes after the common fields: 34-49 TargetARUUID, 50-57 padding.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReadRequest {
    /// The record.
    pub header: RecordHeader,
    /// The AR that a ReadImplicit is for; nil if there is none, padding in Read.
    pub target_ar_uuid: Uuid,
    /// Padding, zeros.
    pub padding: [u8; 8],
    /// Bytes after the block: the query of some records.
    pub data: Vec<u8>,
}

impl ReadRequest {
    /// Parses the bytes after the NDR header.
    pub fn parse(octets: &[u8]) -> Result<ReadRequest> {
        let mut reader = ByteReader::new("IODReadReqHeader", octets);
        let (header, mut tail) = RecordHeader::read(BlockType::READ_REQ, &mut reader)?;
        Ok(ReadRequest {
            header,
            target_ar_uuid: Uuid::read(&mut tail)?,
            padding: tail.array()?,
            data: reader.rest().to_vec(),
        })
    }

    /// Appends the bytes after the NDR header.
    pub fn write(&self, out: &mut Vec<u8>) {
        self.header.write(BlockType::READ_REQ, out, |out| {
            self.target_ar_uuid.write(out, ByteOrder::Big);
            out.put(&self.padding);
        });
        out.put(&self.data);
    }
}

/// IODReadResHeader with the record: the response to Read and ReadImplicit.
///
/// Bytes after the common fields: 34-35 AdditionalValue1, 36-37 AdditionalValue2, 38-57 padding; the record follows the block.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ReadResponse {
    /// The record; its length is that of `data` unless bytes follow.
    pub header: RecordHeader,
    /// Set by the application of the device.
    pub additional_value1: u16,
    /// Set by the application of the device.
    pub additional_value2: u16,
    /// Padding, zeros.
    pub padding: [u8; 20],
    /// The record and all bytes after it; see [`ReadResponse::record`].
    pub data: Vec<u8>,
}

impl ReadResponse {
    /// Parses the bytes after the NDR header; fails if they end before the record does.
    pub fn parse(octets: &[u8]) -> Result<ReadResponse> {
        let mut reader = ByteReader::new("IODReadResHeader", octets);
        let (header, mut tail) = RecordHeader::read(BlockType::READ_RES, &mut reader)?;
        let mut lookahead = reader;
        lookahead.take(header.record_data_length as usize)?;
        Ok(ReadResponse {
            header,
            additional_value1: tail.u16()?,
            additional_value2: tail.u16()?,
            padding: tail.array()?,
            data: reader.rest().to_vec(),
        })
    }

    /// Only the record.
    pub fn record(&self) -> &[u8] {
        self.data.get(..self.header.record_data_length as usize).unwrap_or(&self.data)
    }

    /// The response to `request` with `data`.
    pub fn to(request: &ReadRequest, data: Vec<u8>) -> ReadResponse {
        let header = RecordHeader { record_data_length: data.len() as u32, padding: 0, ..request.header };
        ReadResponse { header, data, ..ReadResponse::default() }
    }

    /// Appends the bytes after the NDR header.
    pub fn write(&self, out: &mut Vec<u8>) {
        self.header.write(BlockType::READ_RES, out, |out| {
            out.put_u16(self.additional_value1);
            out.put_u16(self.additional_value2);
            out.put(&self.padding);
        });
        out.put(&self.data);
    }
}

/// IODWriteReqHeader with the record: the request of Write.
///
/// Bytes after the common fields: 34-57 padding; the record follows the block.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct WriteRequest {
    /// The record; its length must be that of `data`.
    pub header: RecordHeader,
    /// Padding, zeros.
    pub padding: [u8; 24],
    /// The record.
    pub data: Vec<u8>,
    /// Bytes after the record; normally none.
    pub rest: Vec<u8>,
}

impl WriteRequest {
    /// Parses one record; bytes after it stay in the reader.
    pub fn read(reader: &mut ByteReader) -> Result<WriteRequest> {
        let (header, mut tail) = RecordHeader::read(BlockType::WRITE_REQ, reader)?;
        let data = reader.take(header.record_data_length as usize)?.to_vec();
        Ok(WriteRequest { header, padding: tail.array()?, data, rest: Vec::new() })
    }

    /// Parses the bytes after the NDR header; fails if they end before the record does.
    pub fn parse(octets: &[u8]) -> Result<WriteRequest> {
        let mut reader = ByteReader::new("IODWriteReqHeader", octets);
        let request = WriteRequest::read(&mut reader)?;
        Ok(WriteRequest { rest: reader.rest().to_vec(), ..request })
    }

    /// A request that writes `data` as the record `header`; fills in the length.
    pub fn of(header: RecordHeader, data: Vec<u8>) -> WriteRequest {
        let header = RecordHeader { record_data_length: data.len() as u32, ..header };
        WriteRequest { header, data, ..WriteRequest::default() }
    }

    /// Appends the bytes after the NDR header.
    pub fn write(&self, out: &mut Vec<u8>) {
        self.header.write(BlockType::WRITE_REQ, out, |out| out.put(&self.padding));
        out.put(&self.data);
        out.put(&self.rest);
    }

    /// The records of a write multiple; `None` for any other request.
    ///
    /// Each record except the last is padded to a multiple of four bytes.
    pub fn records(&self) -> Option<Result<Vec<WriteRequest>>> {
        (self.header.index == WRITE_MULTIPLE).then(|| {
            let mut reader = ByteReader::new("IODWriteMultipleReq", &self.data);
            let mut records = Vec::new();
            while !reader.is_empty() {
                records.push(WriteRequest::read(&mut reader)?);
                reader.align(4);
            }
            Ok(records)
        })
    }

    /// A write multiple of `records` in the AR `ar_uuid`.
    pub fn multiple(ar_uuid: Uuid, seq_number: u16, records: &[WriteRequest]) -> WriteRequest {
        let mut data = Vec::new();
        for record in records {
            data.resize(data.len().next_multiple_of(4), 0);
            record.write(&mut data);
        }
        let header = RecordHeader {
            seq_number,
            ar_uuid,
            api: 0xFFFF_FFFF,
            slot_number: 0xFFFF,
            subslot_number: 0xFFFF,
            index: WRITE_MULTIPLE,
            ..RecordHeader::default()
        };
        WriteRequest::of(header, data)
    }
}

/// IODWriteResHeader: the response to Write.
///
/// Bytes after the common fields: 34-35 AdditionalValue1, 36-37 AdditionalValue2, 38-41 PNIOStatus, 42-57 padding. In the response
/// to a write multiple the blocks of the records follow, one after the other.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct WriteResponse {
    /// The record, as requested; RecordDataLength is that of the blocks that follow, or is copied from the request.
    pub header: RecordHeader,
    /// Set by the application of the device.
    pub additional_value1: u16,
    /// Set by the application of the device.
    pub additional_value2: u16,
    /// The result of writing this record.
    pub status: PnioStatus,
    /// Padding, zeros.
    pub padding: [u8; 16],
}

impl WriteResponse {
    /// Parses one block; bytes after it stay in the reader.
    pub fn read(reader: &mut ByteReader) -> Result<WriteResponse> {
        let (header, mut tail) = RecordHeader::read(BlockType::WRITE_RES, reader)?;
        Ok(WriteResponse {
            header,
            additional_value1: tail.u16()?,
            additional_value2: tail.u16()?,
            status: PnioStatus::read(&mut tail)?,
            padding: tail.array()?,
        })
    }

    /// Parses all blocks after the NDR header: one for a Write; for a write multiple the outer block, then one per record.
    pub fn parse_all(octets: &[u8]) -> Result<Vec<WriteResponse>> {
        let mut reader = ByteReader::new("IODWriteResHeader", octets);
        let mut responses = Vec::new();
        while !reader.is_empty() {
            responses.push(WriteResponse::read(&mut reader)?);
        }
        Ok(responses)
    }

    /// The response to `request`; RecordDataLength is 0.
    pub fn to(request: &WriteRequest, status: PnioStatus) -> WriteResponse {
        let header = RecordHeader { record_data_length: 0, padding: 0, ..request.header };
        WriteResponse { header, status, ..WriteResponse::default() }
    }

    /// The response to a write multiple: the outer block, whose length counts the others, then `inner`.
    pub fn to_multiple(request: &WriteRequest, inner: Vec<WriteResponse>) -> Vec<WriteResponse> {
        let mut outer = WriteResponse::to(request, PnioStatus::OK);
        outer.header.record_data_length = (inner.len() * WriteResponse::LENGTH) as u32;
        core::iter::once(outer).chain(inner).collect()
    }

    /// Length of one block in bytes.
    pub const LENGTH: usize = 64;

    /// Appends the block.
    pub fn write(&self, out: &mut Vec<u8>) {
        self.header.write(BlockType::WRITE_RES, out, |out| {
            out.put_u16(self.additional_value1);
            out.put_u16(self.additional_value2);
            self.status.write(out);
            out.put(&self.padding);
        });
    }
}
