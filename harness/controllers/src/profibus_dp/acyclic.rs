//! Reading and writing records, and acknowledging alarms: the master sends the request, then polls the slave until the response is ready.
//!
//! Source: IEC 61158-6-3, MSAC1 and MSAC2; data set 47: PROFIdrive profile, base mode parameter access.

use super::message::DpMessage;
use super::ms2_outcome::Ms2End;
use super::outcome::{AcyclicError, DataLinkAnswer, DpParameterOutcome, DpRecordOutcome};
use alloc::format;
use alloc::string::ToString;
use alloc::vec::Vec;
use core::time::Duration;
use station::Time;
use wire::profibus::call::{CALL_INDEX, Call, ExtendedFunction, FunctionIndex};
use wire::profibus::diag::Specifier;
use wire::profibus::dpv1::{Dpv1Function, Dpv1Pdu, Dpv1Record, Dpv1Refusal, PduDirection};
use wire::profibus::fdl::RequestFunction;
use wire::profibus::sap::{MasterSap, SlaveSap};
use wire::profinet::status::RecordError;

/// The data set for parameter access.
const DATA_SET: u8 = 47;
/// Longest record in bytes.
const LONGEST: u8 = 240;

/// Times of an acyclic service.
#[derive(Clone, Copy, Debug)]
pub(super) struct AcyclicTiming {
    /// Time between two polls.
    pub poll: Duration,
    /// Timeout for the response.
    pub patience: Duration,
}

/// The access point of a slave that serves records, and that of the master.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct AcyclicPoint {
    to: u8,
    slave: u8,
    master: MasterSap,
}

impl AcyclicPoint {
    /// MS1: the class 1 master.
    pub fn ms1(to: u8) -> AcyclicPoint {
        AcyclicPoint { to, slave: SlaveSap::SERVER.0, master: MasterSap::MS1 }
    }

    /// MS1: the access point that only acknowledges alarms.
    pub fn alarms(to: u8) -> AcyclicPoint {
        AcyclicPoint { slave: SlaveSap::ALARM.0, ..AcyclicPoint::ms1(to) }
    }

    /// MS2: the access point `sap` of a connection, or the resource manager.
    pub fn ms2(to: u8, sap: u8) -> AcyclicPoint {
        AcyclicPoint { to, slave: sap, master: MasterSap::MS2 }
    }

    /// A PDU to this point; an empty one is a poll.
    pub fn message(self, data: Vec<u8>) -> DpMessage {
        let (dsap, ssap) = (Some(self.slave), Some(self.master.0));
        DpMessage { to: self.to, dsap, ssap, function: RequestFunction::SRD_LOW, data }
    }
}

/// The service of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum AcyclicFunction {
    Read,
    Write,
    AlarmAck { alarm_type: u8, specifier: Specifier },
}

impl AcyclicFunction {
    /// The function of the response that refuses it.
    fn refusal(self) -> Dpv1Function {
        match self {
            AcyclicFunction::Read => Dpv1Function::READ_REFUSED,
            AcyclicFunction::Write => Dpv1Function::WRITE_REFUSED,
            AcyclicFunction::AlarmAck { .. } => Dpv1Function::ALARM_ACK_REFUSED,
        }
    }
}

/// A read or a write of a record, or the acknowledgement of an alarm.
#[derive(Debug)]
pub(super) struct RecordJob {
    point: AcyclicPoint,
    /// What is read or written; of an acknowledgement only the slot counts.
    request: Dpv1Record,
    function: AcyclicFunction,
    /// The function that a CALL reads: its header is written first.
    call: Option<FunctionIndex>,
    requested: bool,
    pace: AcyclicTiming,
    next: Time,
    until: Time,
}

impl RecordJob {
    pub fn read(now: Time, pace: AcyclicTiming, point: AcyclicPoint, (slot, index): (u8, u8), length: u8) -> RecordJob {
        RecordJob::new(now, pace, point, Dpv1Record { slot, index, length, data: Vec::new() }, AcyclicFunction::Read)
    }

    pub fn write(
        now: Time,
        pace: AcyclicTiming,
        point: AcyclicPoint,
        (slot, index): (u8, u8),
        data: Vec<u8>,
    ) -> RecordJob {
        let length = data.len() as u8;
        RecordJob::new(now, pace, point, Dpv1Record { slot, index, length, data }, AcyclicFunction::Write)
    }

    /// The acknowledgement of the alarm of a slot with this type and specifier.
    pub fn acknowledge(
        now: Time,
        pace: AcyclicTiming,
        point: AcyclicPoint,
        slot: u8,
        (alarm_type, specifier): (u8, Specifier),
    ) -> RecordJob {
        let request = Dpv1Record { slot, index: 0, length: 0, data: Vec::new() };
        RecordJob::new(now, pace, point, request, AcyclicFunction::AlarmAck { alarm_type, specifier })
    }

    fn new(
        now: Time,
        pace: AcyclicTiming,
        point: AcyclicPoint,
        request: Dpv1Record,
        function: AcyclicFunction,
    ) -> RecordJob {
        let (next, until) = (now, now + pace.patience);
        RecordJob { point, request, function, call: None, requested: false, pace, next, until }
    }

    /// CALL: writes the header of the function to index 255, then reads index 255.
    pub fn call(now: Time, pace: AcyclicTiming, point: AcyclicPoint, slot: u8, index: FunctionIndex) -> RecordJob {
        let mut header = Vec::new();
        Call::read_of(index).write(&mut header);
        RecordJob { call: Some(index), ..RecordJob::write(now, pace, point, (slot, CALL_INDEX), header) }
    }

    /// When it has something to send.
    pub fn due(&self) -> Time {
        self.next
    }

    /// The request first, then empty polls.
    pub fn message(&self) -> DpMessage {
        let mut data = Vec::new();
        if !self.requested {
            let record = self.request.clone();
            let pdu = match self.function {
                AcyclicFunction::Read => Dpv1Pdu::Read(record),
                AcyclicFunction::Write => Dpv1Pdu::Write(record),
                AcyclicFunction::AlarmAck { alarm_type, specifier } => {
                    Dpv1Pdu::AlarmAck { slot: record.slot, alarm_type, specifier }
                }
            };
            pdu.write(&mut data);
        }
        self.point.message(data)
    }

    /// Processes an answer of the data link; returns the outcome at the end.
    pub fn answered(&mut self, now: Time, answer: DataLinkAnswer) -> Option<DpRecordOutcome> {
        let is_poll = core::mem::replace(&mut self.requested, true);
        match answer.data() {
            Some([_, ..]) if !is_poll => {
                let why =
                    "data in the answer to the request itself; a slave acknowledges it and is polled for the response";
                Some(DpRecordOutcome::Failed(AcyclicError::Unfit(why.to_string())))
            }
            None => Some(DpRecordOutcome::Failed(AcyclicError::Link(answer))),
            Some([]) if now >= self.until => Some(DpRecordOutcome::Failed(AcyclicError::Timeout(self.pace.patience))),
            Some([]) => {
                self.next = now + self.pace.poll;
                None
            }
            // The slave needs more time and keeps the connection alive.
            Some([function, ..]) if *function == Dpv1Function::IDLE.0 && self.point.master == MasterSap::MS2 => {
                (self.next, self.until) = (now + self.pace.poll, now + self.pace.patience);
                None
            }
            Some(data) => {
                let outcome = self.read_answer(data);
                match self.call {
                    Some(index) => self.called(now, index, outcome),
                    None => Some(outcome),
                }
            }
        }
    }

    /// Continues a CALL after the outcome of its write or of a read; returns the data of the function without the header.
    fn called(&mut self, now: Time, index: FunctionIndex, outcome: DpRecordOutcome) -> Option<DpRecordOutcome> {
        let data = match outcome {
            DpRecordOutcome::Accepted { data } => data,
            DpRecordOutcome::Refused(refusal) if !self.is_write() && is_not_ready(&refusal) && now < self.until => {
                (self.requested, self.next) = (false, now + self.pace.poll);
                return None;
            }
            outcome => return Some(outcome),
        };
        if self.is_write() {
            (self.function, self.requested, self.next) = (AcyclicFunction::Read, false, now);
            (self.request.data, self.request.length) = (Vec::new(), LONGEST);
            return None;
        }
        Some(match Call::parse(&data) {
            Ok(Call { function: ExtendedFunction::CALL, index: answered, data, .. }) if answered == index => {
                DpRecordOutcome::Accepted { data }
            }
            Ok(other) => {
                let why = format!("function {:#04x} of index {} after CALL", other.function.0, other.index.0);
                DpRecordOutcome::Failed(AcyclicError::Unfit(why))
            }
            Err(error) => DpRecordOutcome::Failed(AcyclicError::Unfit(error.to_string())),
        })
    }

    fn read_answer(&self, data: &[u8]) -> DpRecordOutcome {
        let unfit = |why| DpRecordOutcome::Failed(AcyclicError::Unfit(why));
        let refused = self.function.refusal();
        match Dpv1Pdu::parse(data, PduDirection::Response) {
            Err(error) => unfit(error.to_string()),
            Ok(Dpv1Pdu::Abort { subnet, reason, .. }) if self.point.master == MasterSap::MS2 => {
                DpRecordOutcome::Aborted(Ms2End { subnet, reason })
            }
            Ok(Dpv1Pdu::Refused(refusal)) if refusal.function == refused => DpRecordOutcome::Refused(refusal),
            Ok(Dpv1Pdu::Read(record)) if self.function == AcyclicFunction::Read && self.is_same(&record) => {
                DpRecordOutcome::Accepted { data: record.data }
            }
            Ok(Dpv1Pdu::Write(record)) if self.is_write() && self.is_same(&record) => {
                DpRecordOutcome::Accepted { data: Vec::new() }
            }
            Ok(Dpv1Pdu::AlarmAck { slot, alarm_type, specifier })
                if slot == self.request.slot
                    && self.function == AcyclicFunction::AlarmAck { alarm_type, specifier } =>
            {
                DpRecordOutcome::Accepted { data: Vec::new() }
            }
            Ok(Dpv1Pdu::Read(record) | Dpv1Pdu::Write(record)) => unfit(format!(
                "function {:#04x} for slot {}, index {}",
                data.first().copied().unwrap_or_default(),
                record.slot,
                record.index
            )),
            Ok(other) => unfit(format!("function {:#04x}", other.function().0)),
        }
    }

    fn is_write(&self) -> bool {
        self.function == AcyclicFunction::Write
    }

    fn is_same(&self, record: &Dpv1Record) -> bool {
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
    pace: AcyclicTiming,
    is_reading: bool,
    record: RecordJob,
    until: Time,
}

impl ParameterJob {
    pub fn new(now: Time, pace: AcyclicTiming, to: u8, slot: u8, request: Vec<u8>) -> ParameterJob {
        let reference = request.first().copied();
        let record = RecordJob::write(now, pace, AcyclicPoint::ms1(to), (slot, DATA_SET), request);
        ParameterJob { to, slot, reference, pace, is_reading: false, record, until: now + pace.patience }
    }

    /// When it has something to send.
    pub fn due(&self) -> Time {
        self.record.due()
    }

    pub fn message(&self) -> DpMessage {
        self.record.message()
    }

    /// Processes an answer of the data link; returns the outcome at the end.
    pub fn answered(&mut self, now: Time, answer: DataLinkAnswer) -> Option<DpParameterOutcome> {
        let outcome = self.record.answered(now, answer)?;
        match (self.is_reading, outcome) {
            (_, DpRecordOutcome::Failed(error)) => Some(DpParameterOutcome::Failed(error)),
            // MS1 has no connection that could be aborted.
            (_, DpRecordOutcome::Aborted(end)) => {
                Some(DpParameterOutcome::Failed(AcyclicError::Unfit(end.to_string())))
            }
            (false, DpRecordOutcome::Accepted { .. }) => {
                self.is_reading = true;
                self.read(now, Duration::ZERO);
                None
            }
            (false, DpRecordOutcome::Refused(refusal)) => Some(DpParameterOutcome::WriteRefused(refusal)),
            (true, DpRecordOutcome::Accepted { data }) if data.is_empty() => self.not_ready(now, None),
            (true, DpRecordOutcome::Accepted { data }) => Some(match (self.reference, data.first()) {
                (Some(sent), Some(received)) if sent != *received => {
                    DpParameterOutcome::OtherReference { sent, answer: data }
                }
                _ => DpParameterOutcome::Answer(data),
            }),
            (true, DpRecordOutcome::Refused(refusal)) if is_not_ready(&refusal) => self.not_ready(now, Some(refusal)),
            (true, DpRecordOutcome::Refused(refusal)) => Some(DpParameterOutcome::ReadRefused(refusal)),
        }
    }

    fn not_ready(&mut self, now: Time, last: Option<Dpv1Refusal>) -> Option<DpParameterOutcome> {
        if now >= self.until {
            return Some(DpParameterOutcome::NotReady(last, self.pace.patience));
        }
        self.read(now, self.pace.poll);
        None
    }

    fn read(&mut self, now: Time, after: Duration) {
        self.record =
            RecordJob::read(now + after, self.pace, AcyclicPoint::ms1(self.to), (self.slot, DATA_SET), LONGEST);
    }
}

/// Whether a refusal means that the answer must be read again.
fn is_not_ready(refusal: &Dpv1Refusal) -> bool {
    refusal.record_error() == Some(RecordError::STATE_CONFLICT)
}
