//! The cyclic exchange of data with a slave, and the clock of isochronous mode.

use super::connection::{ClearOutputs, SlaveConfig};
use super::message::DpMessage;
use super::outcome::{DataLinkAnswer, SlaveConnectionEnd};
use super::{OUTPUT_SLOT, OUTPUT_SUBSLOT};
use crate::outputs::CyclicOutputs;
use alloc::boxed::Box;
use alloc::vec::Vec;
use core::time::Duration;
use station::Time;
use wire::profibus::diag::{SlaveDiag, Status1, Status2};
use wire::profibus::fdl::AnswerFunction;

/// The shortest cycle: a cycle of 0 would never end.
const SHORTEST_CYCLE: Duration = Duration::from_micros(1);

/// The cycle of a slave.
#[derive(Debug)]
pub(super) struct SlaveExchange {
    pub connection: Box<SlaveConfig>,
    /// When the next cycle begins.
    next: Time,
    /// The start of the cycle to which the next clock belongs.
    clock: Time,
    wants_diagnosis: bool,
    /// The last diagnosis was Stat_Diag: it is read again after each cycle until it is not.
    is_static: bool,
    /// The buffer of the outputs sent last, for reuse.
    spare: Vec<u8>,
}

/// The meaning of a Data_Exchange answer.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum ExchangeSample {
    /// Valid inputs.
    Good(Vec<u8>),
    /// The connection has ended.
    End(SlaveConnectionEnd),
}

impl SlaveExchange {
    /// An exchange that begins at `now`.
    pub fn new(connection: Box<SlaveConfig>, now: Time) -> SlaveExchange {
        let spare = Vec::new();
        SlaveExchange { connection, next: now, clock: now, wants_diagnosis: false, is_static: false, spare }
    }

    /// The cycle time, at least [`SHORTEST_CYCLE`].
    fn cycle(&self) -> Duration {
        self.connection.cycle.max(SHORTEST_CYCLE)
    }

    /// When the next clock is due: `offset` after the start of its cycle. `None` without isochronous mode.
    pub fn clock_due(&self, offset: Duration) -> Option<Time> {
        self.connection.clock.map(|_| self.clock + offset)
    }

    /// When the next Data_Exchange is due: after the clock of its cycle, if there is one.
    pub fn due(&self, clock: Option<Time>) -> Time {
        match clock {
            Some(clock) if self.clock <= self.next => self.next.max(clock),
            _ => self.next,
        }
    }

    /// Whether the slave has requested that its diagnosis is read.
    pub fn needs_diagnosis(&self) -> bool {
        self.wants_diagnosis
    }

    /// Records that the clock was sent, or would have been.
    pub fn clock_done(&mut self, now: Time) {
        self.clock = step(self.clock, self.cycle(), now);
    }

    /// Records that Data_Exchange was sent.
    pub fn sent(&mut self, now: Time, has_clock: bool) {
        self.next = step(self.next, self.cycle(), now);
        if !has_clock {
            self.clock = self.next;
        }
    }

    /// The request of this cycle.
    pub fn message(&mut self, outputs: &mut CyclicOutputs, is_clear: bool) -> DpMessage {
        let length = self.connection.output_length;
        let data = match (is_clear, self.connection.clear) {
            (true, ClearOutputs::Zeros) => alloc::vec![0; length],
            (true, ClearOutputs::Empty) => Vec::new(),
            (true, ClearOutputs::AsSet) | (false, _) => {
                outputs.step();
                let place = outputs.submodule_index(OUTPUT_SLOT, OUTPUT_SUBSLOT);
                let mut data = core::mem::take(&mut self.spare);
                data.resize(length, 0);
                outputs.copy(place, &mut data);
                data
            }
        };
        DpMessage::exchange(self.connection.address, data)
    }

    /// Takes back the buffer of a finished request.
    pub fn take_back(&mut self, request: DpMessage) {
        self.spare = request.data;
    }

    /// Processes the answer to a Data_Exchange, or its absence after all retries.
    pub fn answered(&mut self, answer: DataLinkAnswer) -> ExchangeSample {
        let input_length = self.connection.input_length;
        self.wants_diagnosis |= self.is_static;
        match answer {
            DataLinkAnswer::Short if input_length == 0 => ExchangeSample::Good(Vec::new()),
            DataLinkAnswer::Frame { function, data, .. } if function.has_data() && data.len() == input_length => {
                self.wants_diagnosis |= function.is_high() && self.connection.reads_diagnosis;
                ExchangeSample::Good(data)
            }
            // A slave without inputs signals high priority in a frame without data.
            DataLinkAnswer::Frame { function: AnswerFunction::OK, data, .. }
                if data.is_empty() && input_length == 0 =>
            {
                ExchangeSample::Good(data)
            }
            // Without an answer the retries are used up: a master polls the slave no further.
            _ => ExchangeSample::End(SlaveConnectionEnd::Answer(answer)),
        }
    }

    /// Processes the diagnosis that the slave requested; `own` is the address of this master.
    pub fn diagnosed(&mut self, answer: &DataLinkAnswer, own: u8) -> Option<SlaveConnectionEnd> {
        let diagnosis = answer.diagnosis();
        self.wants_diagnosis = false;
        self.is_static = diagnosis.as_ref().is_some_and(|found| found.status_2.has(Status2::STAT_DIAG));
        diagnosis.filter(|found| is_lost(found, own)).map(SlaveConnectionEnd::Diagnosis)
    }
}

/// Whether a diagnosis shows that the slave does not exchange data with the master `own`.
pub(super) fn is_lost(diagnosis: &SlaveDiag, own: u8) -> bool {
    let SlaveDiag { status_1, status_2, .. } = diagnosis;
    status_1.has(Status1::PRM_FAULT)
        || status_1.has(Status1::CFG_FAULT)
        || status_2.has(Status2::PRM_REQ)
        || diagnosis.master != own
}

/// The first of `last` + cycle, `last` + 2 * cycle, ... that is later than `now`.
fn step(last: Time, cycle: Duration, now: Time) -> Time {
    let cycle = u64::try_from(cycle.as_nanos()).unwrap_or(u64::MAX).max(1);
    let cycles = (now.nanos_since(last) / cycle).saturating_add(1);
    last.after_nanos(cycles.saturating_mul(cycle))
}
