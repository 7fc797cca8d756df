//! The alarms of the generic slave: which may be sent, which wait, and which an Alarm_Ack ends.
//!
//! Source: IEC 61158-6-3, DP-V1 alarms: an alarm is a device-related block of the diagnosis, at most one in each, and its sender
//! repeats it until the class 1 master acknowledges it. In type mode one alarm of each type may be open, else a number in all.

use alloc::collections::VecDeque;
use alloc::vec::Vec;
use device_stack::profibus::{AcknowledgedAlarm, Dpv1RecordRefusal};
use wire::profibus::diag::{DiagnosisBlock, DiagnosisMessage, DpAlarmType, Specifier, SpecifierChange};
use wire::profibus::dpv1::RecordError;
use wire::profibus::prm::{AlarmMode, Dpv1, Dpv1Status1, Dpv1Status2};

/// Alarms that wait to be sent; older ones are lost.
const MOST_WAITING: usize = 16;
/// Sequence numbers: 0 to 31.
const SEQUENCES: u8 = 32;

/// An alarm before it is sent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct RaisedAlarm {
    alarm_type: DpAlarmType,
    slot: u8,
    change: SpecifierChange,
}

/// The alarms of a slave.
#[derive(Clone, Debug)]
pub(super) struct AlarmSender {
    enabled: Dpv1Status2,
    mode: AlarmMode,
    waiting: VecDeque<RaisedAlarm>,
    /// The alarms that are not acknowledged; the diagnosis has the first of them.
    open: VecDeque<(RaisedAlarm, Specifier)>,
    /// How many of them no diagnosis has had yet.
    unsent: usize,
    sequence: u8,
}

impl AlarmSender {
    /// A sender whose master has enabled nothing.
    pub(super) const fn new() -> AlarmSender {
        AlarmSender {
            enabled: Dpv1Status2(0),
            mode: AlarmMode::OneOfEachType,
            waiting: VecDeque::new(),
            open: VecDeque::new(),
            unsent: 0,
            sequence: 0,
        }
    }

    /// Begins with what Set_Prm enables; alarms of before are dropped.
    pub(super) fn begin(&mut self, dpv1: Dpv1) {
        let is_on = dpv1.status_1.has(Dpv1Status1::DPV1_ENABLE);
        self.end();
        self.enabled = if is_on { dpv1.status_2 } else { Dpv1Status2(0) };
        self.mode = dpv1.status_3.alarms();
    }

    /// Data exchange has ended.
    pub(super) fn end(&mut self) {
        *self = AlarmSender { sequence: self.sequence, ..AlarmSender::new() };
    }

    /// Raises an alarm, unless its type is not enabled; `true` if a new diagnosis is to be fetched.
    pub(super) fn raise(&mut self, alarm_type: DpAlarmType, slot: u8, change: SpecifierChange) -> bool {
        if !self.enabled.has(enabled_by(alarm_type)) {
            return false;
        }
        if self.waiting.len() == MOST_WAITING {
            self.waiting.pop_front();
        }
        self.waiting.push_back(RaisedAlarm { alarm_type, slot, change });
        self.send()
    }

    /// Opens the alarms that may be open now.
    fn send(&mut self) -> bool {
        let mut is_any = false;
        while let Some(at) = self.waiting.iter().position(|of| self.may_open(of.alarm_type)) {
            let Some(alarm) = self.waiting.remove(at) else { break };
            self.sequence = (self.sequence + 1) % SEQUENCES;
            // What no diagnosis has had yet comes first.
            self.open.insert(self.unsent, (alarm, Specifier(self.sequence << 3 | bits(alarm.change))));
            self.unsent += 1;
            is_any = true;
        }
        is_any
    }

    fn may_open(&self, alarm_type: DpAlarmType) -> bool {
        match self.mode {
            AlarmMode::OneOfEachType => self.open.iter().all(|(of, _)| of.alarm_type != alarm_type),
            AlarmMode::InAll(most) => self.open.len() < usize::from(most),
        }
    }

    /// Appends the block of an open alarm, each time another; `true` if another one has not been in a diagnosis yet.
    pub(super) fn write(&mut self, out: &mut Vec<u8>) -> bool {
        let Some((alarm, specifier)) = self.open.front().copied() else { return false };
        let message = DiagnosisMessage { kind: alarm.alarm_type.0, slot: alarm.slot, specifier, data: &[] };
        let mut data = Vec::new();
        message.write(&mut data);
        DiagnosisBlock::Device(&data).write(out);
        self.open.rotate_left(1);
        self.unsent = self.unsent.saturating_sub(1);
        self.unsent > 0
    }

    /// Ends an open alarm; `Ok(true)` if the next one is to be fetched.
    pub(super) fn acknowledge(&mut self, alarm: AcknowledgedAlarm) -> Result<bool, Dpv1RecordRefusal> {
        let is_it = |(of, specifier): &(RaisedAlarm, Specifier)| {
            (of.alarm_type.0, of.slot, *specifier) == (alarm.alarm_type, alarm.slot, alarm.specifier)
        };
        let Some(at) = self.open.iter().position(is_it) else {
            return Err(Dpv1RecordRefusal::error(RecordError::STATE_CONFLICT));
        };
        self.open.remove(at);
        if at < self.unsent {
            self.unsent -= 1;
        }
        Ok(self.send())
    }
}

/// The bit of Set_Prm that enables alarms of a type.
fn enabled_by(alarm_type: DpAlarmType) -> Dpv1Status2 {
    match alarm_type {
        DpAlarmType::DIAGNOSIS => Dpv1Status2::DIAGNOSIS_ALARM,
        DpAlarmType::PROCESS => Dpv1Status2::PROCESS_ALARM,
        DpAlarmType::PULL | DpAlarmType::PLUG => Dpv1Status2::PULL_PLUG_ALARM,
        DpAlarmType::STATUS => Dpv1Status2::STATUS_ALARM,
        DpAlarmType::UPDATE => Dpv1Status2::UPDATE_ALARM,
        _ => Dpv1Status2::MAKER_ALARM,
    }
}

fn bits(change: SpecifierChange) -> u8 {
    match change {
        SpecifierChange::NotDifferentiated => 0,
        SpecifierChange::Appears => 1,
        SpecifierChange::Disappears => 2,
        SpecifierChange::DisappearsOthersRemain => 3,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use alloc::vec;
    use wire::profibus::prm::Dpv1Status3;

    const PROCESS: u8 = 2;

    /// A sender of a master that has enabled all alarms, in this mode.
    fn sender(mode: u8) -> AlarmSender {
        let mut sender = AlarmSender::new();
        sender.begin(Dpv1 {
            status_1: Dpv1Status1::DPV1_ENABLE,
            status_2: Dpv1Status2(0xFC),
            status_3: Dpv1Status3(mode),
        });
        sender
    }

    fn block(sender: &mut AlarmSender) -> Vec<u8> {
        let mut out = Vec::new();
        sender.write(&mut out);
        out
    }

    fn acknowledged(block: &[u8]) -> AcknowledgedAlarm {
        AcknowledgedAlarm { slot: block[2], alarm_type: block[1], specifier: Specifier(block[3]) }
    }

    /// IEC 61158-6-3, Alarm-PDU: header, type, slot, specifier with the sequence number in bits 3 to 7.
    #[test]
    fn an_alarm_stays_until_it_is_acknowledged() {
        let mut sender = sender(0);
        assert!(sender.raise(DpAlarmType::PROCESS, 1, SpecifierChange::NotDifferentiated));
        let first = block(&mut sender);
        assert_eq!(first, [0x04, PROCESS, 1, 0x08]);
        assert_eq!(block(&mut sender), first);
        let wrong = AcknowledgedAlarm { specifier: Specifier(0x10), ..acknowledged(&first) };
        assert!(sender.acknowledge(wrong).is_err());
        assert_eq!(sender.acknowledge(acknowledged(&first)), Ok(false));
        assert!(sender.acknowledge(acknowledged(&first)).is_err());
        assert_eq!(block(&mut sender), vec![]);
    }

    #[test]
    fn in_type_mode_one_alarm_of_each_type_is_open() {
        let mut sender = sender(0);
        for _ in 0..2 {
            sender.raise(DpAlarmType::PROCESS, 1, SpecifierChange::NotDifferentiated);
        }
        assert!(sender.raise(DpAlarmType::DIAGNOSIS, 1, SpecifierChange::Appears));
        let (first, second) = (block(&mut sender), block(&mut sender));
        assert_eq!((first[1], second[1]), (PROCESS, 1));
        assert_eq!(sender.acknowledge(acknowledged(&first)), Ok(true));
        let third = block(&mut sender);
        assert_eq!((third[1], third[3] >> 3), (PROCESS, 3));
    }

    /// IEC 61158-6-3, Alarm_Mode: 1 stands for two alarms in all.
    #[test]
    fn in_sequence_mode_two_alarms_are_open() {
        let mut sender = sender(1);
        let raised = [(); 3].map(|()| sender.raise(DpAlarmType::PROCESS, 1, SpecifierChange::NotDifferentiated));
        assert_eq!(raised, [true, true, false]);
        let blocks = [(); 4].map(|()| block(&mut sender)[3] >> 3);
        assert_eq!(blocks, [1, 2, 1, 2]);
    }

    #[test]
    fn alarms_that_set_prm_does_not_enable_are_not_sent() {
        let mut sender = sender(0);
        sender.enabled = Dpv1Status2::DIAGNOSIS_ALARM;
        assert!(!sender.raise(DpAlarmType::PROCESS, 1, SpecifierChange::NotDifferentiated));
        assert_eq!(block(&mut sender), vec![]);
    }
}
