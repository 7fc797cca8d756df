//! Bugs of the alarms of the generic DP slave that have state.

use super::slave_state::change_diagnosis;
use crate::seams::slave::{diagnosis_response, frame, request, with_data};
use alloc::vec;
use alloc::vec::Vec;
use device_stack::profibus::{SlaveApplication, SlaveHooks};
use station::StandAction;
use wire::octets::ByteReader;
use wire::profibus::diag::{DiagnosisBlock, SlaveDiag};
use wire::profibus::dpv1::Dpv1Function;
use wire::profibus::fdl::{AnswerFunction, DataFrame, FunctionCode, StationType};
use wire::profibus::prm::SetPrm;
use wire::profibus::sap::{SapService, SlaveSap};

const SERVER: SapService = SapService::Slave(SlaveSap::SERVER);
const SET_PRM: SapService = SapService::Slave(SlaveSap::SET_PRM);
/// Header of the block of an alarm without data.
const HEADER: u8 = 4;

/// What an alarm and its acknowledgement have in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AlarmHead {
    /// The type of the alarm.
    pub kind: u8,
    /// Its slot.
    pub slot: u8,
    /// Its specifier.
    pub specifier: u8,
}

/// Where the alarm begins in the blocks of a diagnosis, which come in any order.
fn place_of_alarm(blocks: &[u8]) -> Option<usize> {
    let mut reader = ByteReader::new("diagnosis", blocks);
    loop {
        let place = reader.offset();
        if let DiagnosisBlock::Device([..0x80, _, _, ..]) = DiagnosisBlock::read(&mut reader).ok()? {
            return Some(place);
        }
    }
}

/// The alarm of the slave.
pub fn alarm_of(blocks: &[u8]) -> Option<AlarmHead> {
    match *blocks.get(place_of_alarm(blocks)?..)? {
        // Data of the user may follow.
        [_, kind, slot, specifier, ..] => Some(AlarmHead { kind, slot, specifier }),
        _ => None,
    }
}

/// Removes the alarm from the blocks of a diagnosis.
pub fn without_alarm(blocks: &mut Vec<u8>) {
    if let Some(place) = place_of_alarm(blocks) {
        let end = place + usize::from(blocks[place]);
        blocks.drain(place..end.min(blocks.len()));
    }
}

fn replace_alarm(blocks: &mut Vec<u8>, alarm: AlarmHead) {
    without_alarm(blocks);
    blocks.splice(..0, [HEADER, alarm.kind, alarm.slot, alarm.specifier]);
}

/// The alarm that a request or a response acknowledges; `function` tells which of them.
fn acknowledged(data: &[u8], function: Dpv1Function) -> Option<AlarmHead> {
    match *data {
        [first, slot, kind, specifier, ..] if first == function.0 => Some(AlarmHead { kind, slot, specifier }),
        _ => None,
    }
}

fn acknowledgement(alarm: AlarmHead) -> [u8; 4] {
    [Dpv1Function::ALARM_ACK.0, alarm.slot, alarm.kind, alarm.specifier]
}

/// The frame of an Alarm_Ack at one of the two access points, and its alarm.
fn alarm_ack(telegram: &[u8]) -> Option<(DataFrame<'_>, AlarmHead)> {
    let (frame, service) = request(telegram)?;
    if service != SERVER && service != SapService::Slave(SlaveSap::ALARM) {
        return None;
    }
    Some((frame, acknowledged(frame.data, Dpv1Function::ALARM_ACK)?))
}

/// Replaces the response to an Alarm_Ack.
fn answer_ack(telegram: &mut Vec<u8>, answer: impl FnOnce(&[u8]) -> Option<[u8; 4]>) {
    let Some(frame) = frame(telegram).filter(|frame| !frame.fc.is_request()) else { return };
    if matches!(frame.data.first(), Some(&(0x5C | 0xDC)))
        && let Some(data) = answer(frame.data)
    {
        *telegram = with_data(&frame, &data);
    }
}

/// Sends other alarms than those that the slave has, and takes the acknowledgements of these.
pub struct ChangedAlarms {
    change: fn(&mut AlarmHead),
    /// Each alarm as it is and as it is sent.
    sent: Vec<(AlarmHead, AlarmHead)>,
    asked: Option<AlarmHead>,
}

impl ChangedAlarms {
    /// Changes each alarm.
    pub fn new(change: fn(&mut AlarmHead)) -> ChangedAlarms {
        ChangedAlarms { change, sent: Vec::new(), asked: None }
    }
}

impl SlaveHooks for ChangedAlarms {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        let Some((frame, asked)) = alarm_ack(telegram) else { return vec![telegram.to_vec()] };
        self.asked = Some(asked);
        let real = self.sent.iter().rev().find(|(_, sent)| *sent == asked).map_or(asked, |(real, _)| *real);
        vec![with_data(&frame, &acknowledgement(real))]
    }

    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        change_diagnosis(telegram, |SlaveDiag { ext: blocks, .. }| {
            let Some(real) = alarm_of(blocks) else { return };
            let mut alarm = real;
            (self.change)(&mut alarm);
            self.sent.retain(|(known, _)| *known != real);
            self.sent.push((real, alarm));
            replace_alarm(blocks, alarm);
        });
        answer_ack(telegram, |data| acknowledged(data, Dpv1Function::ALARM_ACK).and(self.asked).map(acknowledgement));
    }
}

/// Changes each Alarm_Ack, given the alarm that was sent last, and answers it as it was asked.
pub struct AlarmAcks {
    change: fn(&mut AlarmHead, AlarmHead),
    answers_all: bool,
    open: Option<AlarmHead>,
    asked: Option<AlarmHead>,
}

impl AlarmAcks {
    /// Changes requests; with `answers_all` each is answered as if it were accepted.
    pub fn new(change: fn(&mut AlarmHead, AlarmHead), answers_all: bool) -> AlarmAcks {
        AlarmAcks { change, answers_all, open: None, asked: None }
    }
}

impl SlaveHooks for AlarmAcks {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        let Some((frame, asked)) = alarm_ack(telegram) else { return vec![telegram.to_vec()] };
        self.asked = Some(asked);
        let mut alarm = asked;
        if let Some(open) = self.open {
            (self.change)(&mut alarm, open);
        }
        vec![with_data(&frame, &acknowledgement(alarm))]
    }

    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        if let Some((_, diagnosis)) = diagnosis_response(telegram)
            && let Some(alarm) = alarm_of(&diagnosis.ext)
        {
            self.open = Some(alarm);
        }
        answer_ack(telegram, |data| {
            let is_accepted = acknowledged(data, Dpv1Function::ALARM_ACK).is_some();
            self.asked.filter(|_| is_accepted || self.answers_all).map(acknowledgement)
        });
    }
}

/// Does not announce alarms of events and modules.
#[derive(Default)]
pub struct SilentEvents {
    is_silent: bool,
}

impl SlaveHooks for SilentEvents {
    fn act(&mut self, action: &StandAction<'_>) {
        if let StandAction::Fault(name, _) = action {
            self.is_silent = matches!(*name, "event" | "pulled");
        }
    }

    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        let Some(frame) = frame(telegram).filter(|frame| !frame.fc.is_request()) else { return };
        if self.is_silent && frame.source.is_empty() && frame.fc.answered() == Some(AnswerFunction::DATA_HIGH) {
            let fc = FunctionCode::answer(AnswerFunction::DATA_LOW, StationType::SLAVE);
            *telegram = with_data(&DataFrame { fc, ..frame }, frame.data);
        }
    }
}

/// Sends an alarm that was not acknowledged in the next connection.
#[derive(Default)]
pub struct AlarmsOfBefore {
    open: Option<AlarmHead>,
}

impl SlaveHooks for AlarmsOfBefore {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        if let Some((_, alarm)) = alarm_ack(telegram) {
            self.open.take_if(|open| *open == alarm);
        }
        vec![telegram.to_vec()]
    }

    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        change_diagnosis(telegram, |SlaveDiag { ext: blocks, .. }| match (alarm_of(blocks), self.open) {
            (Some(alarm), _) => self.open = Some(alarm),
            (None, Some(open)) => replace_alarm(blocks, open),
            (None, None) => {}
        });
    }

    fn starts(&mut self) {
        self.open = None;
    }
}

/// Loses the alarm that waits for the acknowledgement of one of its type.
#[derive(Default)]
pub struct WaitingAlarmsLost {
    is_type_mode: bool,
    /// The type of the alarm that was acknowledged since the stand has done something.
    acknowledged: Option<u8>,
}

impl SlaveHooks for WaitingAlarmsLost {
    fn act(&mut self, _: &StandAction<'_>) {
        self.acknowledged = None;
    }

    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        if let Some((_, alarm)) = alarm_ack(telegram) {
            self.acknowledged = Some(alarm.kind);
        }
        if let Some((frame, SET_PRM)) = request(telegram) {
            let mode = SetPrm::parse(frame.data).ok().and_then(|prm| prm.user.get(2).copied());
            self.is_type_mode = mode.is_none_or(|mode| mode & 7 == 0);
        }
        vec![telegram.to_vec()]
    }

    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        change_diagnosis(telegram, |SlaveDiag { ext: blocks, .. }| {
            if self.is_type_mode && alarm_of(blocks).is_some_and(|alarm| self.acknowledged == Some(alarm.kind)) {
                without_alarm(blocks);
            }
        });
    }
}

/// Sends the first alarm only until it is acknowledged.
#[derive(Default)]
pub struct FirstAlarmOnly {
    open: Option<AlarmHead>,
}

impl SlaveHooks for FirstAlarmOnly {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        if let Some((_, alarm)) = alarm_ack(telegram) {
            self.open.take_if(|open| *open == alarm);
        }
        if let Some((_, SET_PRM)) = request(telegram) {
            self.open = None;
        }
        vec![telegram.to_vec()]
    }

    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        change_diagnosis(telegram, |SlaveDiag { ext: blocks, .. }| {
            if let Some(alarm) = alarm_of(blocks) {
                let first = *self.open.get_or_insert(alarm);
                replace_alarm(blocks, first);
            }
        });
    }
}
