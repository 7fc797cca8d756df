//! Acyclic services of a class 1 master: it sends the request, then polls the slave until the response is ready.
//!
//! Source: IEC 61158-6-3, MSAC1; data set 47: PROFIdrive profile, base mode parameter access.

use super::message::Message;
use super::outcome::{AcyclicError, Answer, ParameterOutcome, RecordOutcome};
use alloc::format;
use alloc::string::ToString;
use alloc::vec::Vec;
use core::time::Duration;
use station::Time;
use wire::profibus::dpv1::{Function, Pdu, Record, Refusal, Side};
use wire::profinet::status::RecordError;

/// The data set for parameter access.
const DATA_SET: u8 = 47;
/// Longest record in bytes.
const LONGEST: u8 = 240;

/// Times of an acyclic service.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    /// Time between two polls.
    pub poll: Duration,
    /// Timeout for the response.
    pub patience: Duration,
}

/// A read or a write of a record.
#[derive(Debug)]
pub(super) struct RecordJob {
    to: u8,
    request: Record,
    is_write: bool,
    asked: bool,
    pace: Pace,
    next: Time,
    until: Time,
}

impl RecordJob {
    pub fn read(now: Time, pace: Pace, to: u8, (slot, index): (u8, u8), length: u8) -> RecordJob {
        RecordJob::new(now, pace, to, Record { slot, index, length, data: Vec::new() }, false)
    }

    pub fn write(now: Time, pace: Pace, to: u8, (slot, index): (u8, u8), data: Vec<u8>) -> RecordJob {
        let length = data.len() as u8;
        RecordJob::new(now, pace, to, Record { slot, index, length, data }, true)
    }

    fn new(now: Time, pace: Pace, to: u8, request: Record, is_write: bool) -> RecordJob {
        RecordJob { to, request, is_write, asked: false, pace, next: now, until: now + pace.patience }
    }

    /// When it has something to send.
    pub fn due(&self) -> Time {
        self.next
    }

    /// The request first, then empty polls.
    pub fn message(&self) -> Message {
        let mut data = Vec::new();
        if !self.asked {
            let record = self.request.clone();
            if self.is_write { Pdu::Write(record) } else { Pdu::Read(record) }.write(&mut data);
        }
        Message::acyclic(self.to, data)
    }

    /// Processes an answer of the data link; returns the outcome at the end.
    pub fn answered(&mut self, now: Time, answer: Answer) -> Option<RecordOutcome> {
        self.asked = true;
        match answer.data() {
            None => Some(RecordOutcome::Failed(AcyclicError::Link(answer))),
            Some([]) if now >= self.until => Some(RecordOutcome::Failed(AcyclicError::Timeout(self.pace.patience))),
            Some([]) => {
                self.next = now + self.pace.poll;
                None
            }
            Some(data) => Some(self.read_answer(data)),
        }
    }

    fn read_answer(&self, data: &[u8]) -> RecordOutcome {
        let unfit = |why| RecordOutcome::Failed(AcyclicError::Unfit(why));
        let refused = if self.is_write { Function::WRITE_REFUSED } else { Function::READ_REFUSED };
        match Pdu::parse(data, Side::Response) {
            Err(error) => unfit(error.to_string()),
            Ok(Pdu::Refused(refusal)) if refusal.function == refused => RecordOutcome::Refused(refusal),
            Ok(Pdu::Read(record)) if !self.is_write && self.is_same(&record) => {
                RecordOutcome::Accepted { data: record.data }
            }
            Ok(Pdu::Write(record)) if self.is_write && self.is_same(&record) => {
                RecordOutcome::Accepted { data: Vec::new() }
            }
            Ok(Pdu::Read(record) | Pdu::Write(record)) => unfit(format!(
                "function {:#04x} for slot {}, index {}",
                data.first().copied().unwrap_or_default(),
                record.slot,
                record.index
            )),
            Ok(other) => unfit(format!("function {:#04x}", other.function().0)),
        }
    }

    fn is_same(&self, record: &Record) -> bool {
        (record.slot, record.index) == (self.request.slot, self.request.index)
    }
}

/// A base mode request.
#[derive(Debug)]
pub(super) struct ParameterJob {
    to: u8,
    slot: u8,
    /// The reference of the request; an empty request has none.
    reference: Option<u8>,
    pace: Pace,
    is_reading: bool,
    record: RecordJob,
    until: Time,
}

impl ParameterJob {
    pub fn new(now: Time, pace: Pace, to: u8, slot: u8, request: Vec<u8>) -> ParameterJob {
        let reference = request.first().copied();
        let record = RecordJob::write(now, pace, to, (slot, DATA_SET), request);
        ParameterJob { to, slot, reference, pace, is_reading: false, record, until: now + pace.patience }
    }

    /// When it has something to send.
    pub fn due(&self) -> Time {
        self.record.due()
    }

    pub fn message(&self) -> Message {
        self.record.message()
    }

    /// Processes an answer of the data link; returns the outcome at the end.
    pub fn answered(&mut self, now: Time, answer: Answer) -> Option<ParameterOutcome> {
        let outcome = self.record.answered(now, answer)?;
        match (self.is_reading, outcome) {
            (_, RecordOutcome::Failed(error)) => Some(ParameterOutcome::Failed(error)),
            (false, RecordOutcome::Accepted { .. }) => {
                self.is_reading = true;
                self.read(now, Duration::ZERO);
                None
            }
            (false, RecordOutcome::Refused(refusal)) => Some(ParameterOutcome::WriteRefused(refusal)),
            (true, RecordOutcome::Accepted { data }) if data.is_empty() => self.not_ready(now, None),
            (true, RecordOutcome::Accepted { data }) => Some(match (self.reference, data.first()) {
                (Some(sent), Some(received)) if sent != *received => {
                    ParameterOutcome::OtherReference { sent, answer: data }
                }
                _ => ParameterOutcome::Answer(data),
            }),
            (true, RecordOutcome::Refused(refusal)) if is_not_ready(&refusal) => self.not_ready(now, Some(refusal)),
            (true, RecordOutcome::Refused(refusal)) => Some(ParameterOutcome::ReadRefused(refusal)),
        }
    }

    fn not_ready(&mut self, now: Time, last: Option<Refusal>) -> Option<ParameterOutcome> {
        if now >= self.until {
            return Some(ParameterOutcome::NotReady(last, self.pace.patience));
        }
        self.read(now, self.pace.poll);
        None
    }

    fn read(&mut self, now: Time, after: Duration) {
        self.record = RecordJob::read(now + after, self.pace, self.to, (self.slot, DATA_SET), LONGEST);
    }
}

/// Whether a refusal means that the answer must be read again.
fn is_not_ready(refusal: &Refusal) -> bool {
    refusal.record_error() == Some(RecordError::STATE_CONFLICT)
}
