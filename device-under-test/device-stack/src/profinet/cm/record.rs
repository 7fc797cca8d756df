//! Read, ReadImplicit, Write and write multiple.

use super::super::hooks::StackCheck;
use super::super::rpc::RpcCall;
use super::super::stack::{Stack, StackEnv};
use super::CmAnswer;
use crate::profinet::RecordAccess;
use alloc::vec::Vec;
use wire::octets::ByteReader;
use wire::profinet::blocks::record::{
    ReadRequest, ReadResponse, RecordHeader, WRITE_MULTIPLE, WriteRequest, WriteResponse,
};
use wire::profinet::blocks::{BlockType, RawBlock};
use wire::profinet::rpc::{NdrRequest, Uuid};
use wire::profinet::status::{ErrorCode, ErrorSource, PnioStatus, RecordError};

/// Length of a record block after its version, in bytes.
const BODY: usize = 58;
const BLOCK_TYPE: u8 = 0;
const BLOCK_LENGTH: u8 = 1;
const VERSION_HIGH: u8 = 2;
const VERSION_LOW: u8 = 3;
const DATA_LENGTH: u8 = 11;

/// Checks the header of a read or write block, before its fields are read.
fn check_head(code: ErrorCode, kind: BlockType, octets: &[u8]) -> Result<(), PnioStatus> {
    let found = |field| PnioStatus::found(code, ErrorSource::RECORD, field);
    let raw = RawBlock::read(&mut ByteReader::new("record", octets)).map_err(|_| found(BLOCK_LENGTH))?;
    for (field, holds) in [
        (BLOCK_TYPE, raw.header.kind == kind),
        (BLOCK_LENGTH, raw.body.len() == BODY),
        (VERSION_HIGH, raw.header.version_high == 1),
        (VERSION_LOW, raw.header.version_low == 0),
    ] {
        if !holds {
            return Err(found(field));
        }
    }
    Ok(())
}

fn access(header: &RecordHeader) -> RecordAccess {
    let RecordHeader { api, slot_number, subslot_number, index, .. } = *header;
    RecordAccess { ar: None, api, slot: slot_number, subslot: subslot_number, index }
}

impl Stack {
    /// Reads a record within a connection.
    pub(super) fn read(
        &mut self,
        env: &mut StackEnv<'_>,
        call: &RpcCall,
        blocks: &[u8],
    ) -> Result<CmAnswer, PnioStatus> {
        let code = ErrorCode::READ_RESPONSE;
        check_head(code, BlockType::READ_REQ, blocks)?;
        let request =
            ReadRequest::parse(blocks).map_err(|_| PnioStatus::found(code, ErrorSource::RECORD, BLOCK_LENGTH))?;
        let at = self.find(code, request.header.ar_uuid)?;
        self.ars[at].touch(env.now);
        self.answer_read(env, call, &request, Some(at), true)
    }

    /// Reads a record without a connection. The record covers the connection that the request names as its target, if
    /// any.
    pub(super) fn read_implicit(
        &mut self,
        env: &mut StackEnv<'_>,
        call: &RpcCall,
        blocks: &[u8],
    ) -> Result<CmAnswer, PnioStatus> {
        let code = ErrorCode::READ_RESPONSE;
        check_head(code, BlockType::READ_REQ, blocks)?;
        let request =
            ReadRequest::parse(blocks).map_err(|_| PnioStatus::found(code, ErrorSource::RECORD, BLOCK_LENGTH))?;
        let target = match request.target_ar_uuid {
            Uuid::NIL => None,
            uuid => Some(self.find(code, uuid)?),
        };
        self.answer_read(env, call, &request, target, false)
    }

    /// Answers a read. `about` is the connection that the record may cover. If the read `is_within` a connection, it
    /// is that connection.
    fn answer_read(
        &mut self,
        env: &mut StackEnv<'_>,
        call: &RpcCall,
        request: &ReadRequest,
        about: Option<usize>,
        is_within: bool,
    ) -> Result<CmAnswer, PnioStatus> {
        let key = about.filter(|_| is_within).map(|at| self.ars[at].key);
        let access = RecordAccess { ar: key, ..access(&request.header) };
        let is_of_other = about.is_some_and(|at| self.is_of_other(at, access.into()));
        let may_read = !is_of_other || self.hooks.check(StackCheck::ReadsOfOthers, true);
        let result = if may_read { self.read_record(env, access, about) } else { Err(RecordError::ACCESS_DENIED) };
        let (status, mut data) = match result {
            Ok(data) => (PnioStatus::OK, data),
            Err(error) => (PnioStatus::record(ErrorCode::READ_RESPONSE, error), Vec::new()),
        };
        let most = NdrRequest::parse(call.header.order(), &call.body).map_or(0, |(ndr, _)| ndr.args_maximum as usize);
        let longest = most.saturating_sub(WriteResponse::LENGTH).min(request.header.record_data_length as usize);
        if self.hooks.check(StackCheck::RecordTooLong, data.len() > longest) {
            data.truncate(longest);
        }
        let mut blocks = Vec::new();
        ReadResponse::to(request, data).write(&mut blocks);
        Ok(CmAnswer { status, blocks })
    }

    /// Writes one record or several.
    pub(super) fn write(&mut self, env: &mut StackEnv<'_>, _: &RpcCall, blocks: &[u8]) -> Result<CmAnswer, PnioStatus> {
        let code = ErrorCode::WRITE_RESPONSE;
        let wrong_length = PnioStatus::found(code, ErrorSource::RECORD, DATA_LENGTH);
        check_head(code, BlockType::WRITE_REQ, blocks)?;
        let request = WriteRequest::parse(blocks).map_err(|_| wrong_length)?;
        if !request.rest.is_empty() {
            return Err(wrong_length);
        }
        let at = self.find(code, request.header.ar_uuid)?;
        self.ars[at].touch(env.now);
        let mut answer = Vec::new();
        let Some(records) = request.records() else {
            let status = self.write_one(env, at, &request);
            WriteResponse::to(&request, status).write(&mut answer);
            return Ok(CmAnswer { status, blocks: answer });
        };
        let records = records.map_err(|_| wrong_length)?;
        let mut inner = Vec::new();
        for record in &records {
            let is_in_this_ar =
                record.header.ar_uuid == request.header.ar_uuid && record.header.index != WRITE_MULTIPLE;
            let status = if is_in_this_ar {
                self.write_one(env, at, record)
            } else {
                PnioStatus::found(code, ErrorSource::RECORD, if record.header.index == WRITE_MULTIPLE { 10 } else { 5 })
            };
            inner.push(WriteResponse::to(record, status));
        }
        WriteResponse::to_multiple(&request, inner).iter().for_each(|response| response.write(&mut answer));
        Ok(CmAnswer::done(answer))
    }

    fn write_one(&mut self, env: &mut StackEnv<'_>, at: usize, request: &WriteRequest) -> PnioStatus {
        let access = RecordAccess { ar: Some(self.ars[at].key), ..access(&request.header) };
        if self.is_write_of_other(at, access) {
            return PnioStatus::record(ErrorCode::WRITE_RESPONSE, RecordError::ACCESS_DENIED);
        }
        match self.write_record(env, access, &request.data) {
            Ok(()) => PnioStatus::OK,
            Err(error) => PnioStatus::record(ErrorCode::WRITE_RESPONSE, error),
        }
    }
}
