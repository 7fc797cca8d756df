//! The blocks of Read and Write: builds the requests and checks that the responses match them.
//!
//! This module must not know RPC, time or state.

use super::connection::{RecordAddress, StartUpRecord};
use super::outcome::{CallError, IoRecordOutcome};
use alloc::format;
use alloc::string::ToString;
use alloc::vec::Vec;
use wire::profinet::blocks::record::{ReadRequest, ReadResponse, RecordHeader, WriteRequest, WriteResponse};
use wire::profinet::rpc::Uuid;

/// Bytes of a read answer in addition to the record.
pub(super) const READ_OVERHEAD: u32 = 64;

fn header(ar_uuid: Uuid, seq_number: u16, target: RecordAddress) -> RecordHeader {
    RecordHeader {
        seq_number,
        ar_uuid,
        api: target.api,
        slot_number: target.slot,
        subslot_number: target.subslot,
        index: target.index,
        ..RecordHeader::default()
    }
}

/// The request to read at most `length` bytes.
pub(super) fn read(ar_uuid: Uuid, seq_number: u16, target: RecordAddress, length: u32) -> ReadRequest {
    let header = RecordHeader { record_data_length: length, ..header(ar_uuid, seq_number, target) };
    ReadRequest { header, ..ReadRequest::default() }
}

/// The request to write one record.
pub(super) fn write(ar_uuid: Uuid, seq_number: u16, target: RecordAddress, data: Vec<u8>) -> WriteRequest {
    WriteRequest::of(header(ar_uuid, seq_number, target), data)
}

/// The request to write several records; they are numbered from `seq_number` + 1 on.
pub(super) fn write_multiple(ar_uuid: Uuid, seq_number: u16, records: &[StartUpRecord]) -> WriteRequest {
    let number = |at: usize| seq_number.wrapping_add(1).wrapping_add(at as u16);
    let inner: Vec<WriteRequest> = records
        .iter()
        .enumerate()
        .map(|(at, record)| write(ar_uuid, number(at), record.target, record.data.clone()))
        .collect();
    WriteRequest::multiple(ar_uuid, seq_number, &inner)
}

/// The first field of an answer that does not match its request.
fn unfit(sent: &RecordHeader, came: &RecordHeader) -> Option<CallError> {
    let fields = |header: &RecordHeader| {
        let RecordHeader { seq_number, slot_number, subslot_number, index, .. } = *header;
        [("SeqNumber", seq_number), ("SlotNumber", slot_number), ("SubslotNumber", subslot_number), ("Index", index)]
    };
    let mut pairs = fields(sent).into_iter().zip(fields(came));
    let wrong = pairs.find(|((_, sent), (_, came))| sent != came);
    if let Some(((field, sent), (_, came))) = wrong {
        return Some(CallError::Unfit(format!("{field} is {came}, {sent} was sent")));
    }
    (sent.ar_uuid != came.ar_uuid).then(|| CallError::Unfit(format!("ARUUID is {}", came.ar_uuid)))
}

/// The outcome of the read `request` from the blocks of a positive answer.
pub(super) fn read_answer(request: &ReadRequest, blocks: &[u8]) -> IoRecordOutcome {
    match ReadResponse::parse(blocks) {
        Ok(answer) => match unfit(&request.header, &answer.header) {
            Some(error) => IoRecordOutcome::Failed(error),
            None => IoRecordOutcome::Accepted { data: answer.record().to_vec() },
        },
        Err(error) => IoRecordOutcome::Failed(CallError::Unfit(error.to_string())),
    }
}

/// The outcome of the write `request` from the blocks of a positive answer.
pub(super) fn write_answer(request: &WriteRequest, blocks: &[u8]) -> IoRecordOutcome {
    match WriteResponse::parse_all(blocks).as_deref() {
        Ok([answer, ..]) => written(&request.header, answer),
        Ok([]) => IoRecordOutcome::Failed(CallError::Unfit("there is no IODWriteResHeader".into())),
        Err(error) => IoRecordOutcome::Failed(CallError::Unfit(error.to_string())),
    }
}

/// The outcome of each record of the write `request` from the blocks of a positive answer.
pub(super) fn write_multiple_answer(request: &WriteRequest, count: usize, blocks: &[u8]) -> Vec<IoRecordOutcome> {
    let sent: Vec<WriteRequest> = request.records().and_then(Result::ok).unwrap_or_default();
    let outcome = |at: usize, answers: &[WriteResponse]| match (sent.get(at), answers.get(at + 1)) {
        (Some(sent), Some(answer)) => written(&sent.header, answer),
        _ => match answers.first() {
            Some(outer) if !outer.status.is_ok() => IoRecordOutcome::Refused(outer.status),
            _ => IoRecordOutcome::Failed(CallError::Unfit("there is no IODWriteResHeader for this record".into())),
        },
    };
    match WriteResponse::parse_all(blocks) {
        Ok(answers) => (0..count).map(|at| outcome(at, &answers)).collect(),
        Err(error) => (0..count).map(|_| IoRecordOutcome::Failed(CallError::Unfit(error.to_string()))).collect(),
    }
}

fn written(sent: &RecordHeader, answer: &WriteResponse) -> IoRecordOutcome {
    match unfit(sent, &answer.header) {
        Some(error) => IoRecordOutcome::Failed(error),
        None if answer.status.is_ok() => IoRecordOutcome::Accepted { data: Vec::new() },
        None => IoRecordOutcome::Refused(answer.status),
    }
}
