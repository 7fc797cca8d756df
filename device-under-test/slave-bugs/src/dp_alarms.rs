//! Bugs of the alarms of the generic DP slave.

use super::Group;
use super::dp_alarms_state::{
    AlarmAcks, AlarmsOfBefore, ChangedAlarms, FirstAlarmOnly, SilentEvents, WaitingAlarmsLost, alarm_of, without_alarm,
};
use super::dp_slave_state::{LeavesExchange, Replaced, of_owner, to_access_point};
use crate::needs::Need;
use crate::seams::Deviations;
use crate::seams::slave::request;
use alloc::rc::Rc;
use alloc::vec;
use alloc::vec::Vec;
use core::cell::Cell;
use reference_devices::manuals;
use wire::profibus::diag::DpAlarmType;
use wire::profibus::dpv1::{Dpv1Function, Dpv1Pdu};
use wire::profibus::prm::{Dpv1Status1, Dpv1Status2};
use wire::profibus::sap::{SapService, SlaveSap};

/// The bugs, by what they need.
pub static GROUPS: &[Group] = &[Group {
    needs: &[Need::Of(&manuals::DP_SLAVE)],
    deviations: bugs! {
        // What is sent
        "no-alarms" "No alarm is ever sent."
            => |d| enables(d, |[_, enabled, _]| *enabled &= 0x03);
        "process-alarm-as-another-type" "A process alarm has the type of a status alarm."
            => |d| d.slave.add(ChangedAlarms::new(|alarm| if alarm.kind == DpAlarmType::PROCESS.0 {
                alarm.kind = DpAlarmType::STATUS.0;
            }));
        "alarms-of-slot-0" "Each alarm has slot 0."
            => |d| d.slave.add(ChangedAlarms::new(|alarm| alarm.slot = 0));
        "alarms-not-announced" "An alarm that is no fault is not announced by the priority of the answers."
            => |d| d.slave.add(SilentEvents::default());
        "alarm-sent-once" "An alarm is in one diagnosis only, whether it is acknowledged or not."
            => |d| {
                let mut sent = Vec::new();
                d.slave.diagnosis(move |diag, _| if let Some(alarm) = alarm_of(&diag.ext) {
                    if sent.contains(&alarm) {
                        without_alarm(&mut diag.ext);
                    } else {
                        sent.push(alarm);
                    }
                });
            };
        "alarm-sequence-stays" "Each alarm has the sequence number 7."
            => |d| d.slave.add(ChangedAlarms::new(|alarm| alarm.specifier = alarm.specifier & 0x07 | 7 << 3));
        "alarms-without-a-change" "The specifier of a diagnosis alarm does not say whether the fault comes or goes."
            => |d| d.slave.add(ChangedAlarms::new(|alarm| alarm.specifier &= !3));
        "going-faults-called-coming" "The specifier of the alarm of a fault that goes says that it comes."
            => |d| d.slave.add(ChangedAlarms::new(|alarm| if alarm.specifier & 3 == 2 {
                alarm.specifier -= 1;
            }));
        "others-forgotten-in-alarms" "A fault that goes while others remain is an alarm that says that the slot is good."
            => |d| d.slave.add(ChangedAlarms::new(|alarm| if alarm.specifier & 3 == 3 {
                alarm.specifier &= !1;
            }));
        "pull-as-plug" "A pull alarm has the type of a plug alarm."
            => |d| d.slave.add(ChangedAlarms::new(|alarm| if alarm.kind == DpAlarmType::PULL.0 {
                alarm.kind = DpAlarmType::PLUG.0;
            }));
        "plug-as-pull" "A plug alarm has the type of a pull alarm."
            => |d| d.slave.add(ChangedAlarms::new(|alarm| if alarm.kind == DpAlarmType::PLUG.0 {
                alarm.kind = DpAlarmType::PULL.0;
            }));
        "alarms-survive-start" "An alarm that was not acknowledged is sent in the next connection too."
            => |d| d.slave.add(AlarmsOfBefore::default());
        "unacknowledged-alarm-ends-exchange" "After ten diagnoses with the same alarm the slave leaves data exchange."
            => |d| {
                let sent = Rc::new(Cell::new((None, 0u32)));
                let seen = Rc::clone(&sent);
                d.slave.diagnosis(move |diag, _| if let Some(alarm) = alarm_of(&diag.ext) {
                    let (last, count) = seen.get();
                    seen.set((Some(alarm), if last == Some(alarm) { count + 1 } else { 1 }));
                });
                d.slave.add(LeavesExchange::at(move |telegram| {
                    let is_exchange = request(telegram).is_some_and(|(_, service)| service == SapService::DataExchange);
                    is_exchange && sent.get().1 > 10
                }));
            };

        // What Set_Prm enables
        "process-alarms-always-enabled" "Process alarms are sent whether Set_Prm enables them or not."
            => |d| always_enabled(d, Dpv1Status2::PROCESS_ALARM);
        "diagnosis-alarms-always-enabled" "Diagnosis alarms are sent whether Set_Prm enables them or not."
            => |d| always_enabled(d, Dpv1Status2::DIAGNOSIS_ALARM);
        "pull-alarms-always-enabled" "Pull and plug alarms are sent whether Set_Prm enables them or not."
            => |d| always_enabled(d, Dpv1Status2::PULL_PLUG_ALARM);
        "alarms-without-dpv1" "Alarms are sent without DPV1_Enable."
            => |d| enables(d, |[first, enabled, _]| if *enabled & 0xFC != 0 {
                *first |= Dpv1Status1::DPV1_ENABLE.0;
            });
        "type-mode-ignored" "In type mode alarms of the same type do not wait for each other."
            => |d| enables(d, |[_, _, mode]| if *mode & 7 == 0 {
                *mode |= 7;
            });
        "type-mode-always" "In sequence mode alarms of the same type wait for each other."
            => |d| enables(d, |[_, _, mode]| *mode &= !7);
        "sequence-without-a-limit" "In sequence mode 32 alarms are open, whatever number Set_Prm permits."
            => |d| enables(d, |[_, _, mode]| if *mode & 7 != 0 {
                *mode |= 7;
            });
        "waiting-alarms-lost" "In type mode an alarm that waited for the Alarm_Ack of another one is lost."
            => |d| d.slave.add(WaitingAlarmsLost::default());
        "one-alarm-at-a-time" "No other alarm is sent until the first is acknowledged, whatever its type."
            => |d| d.slave.add(FirstAlarmOnly::default());

        // Alarm_Ack
        "alarm-ack-refused" "Each Alarm_Ack is refused."
            => |d| d.slave.record(|pdu| if let Dpv1Pdu::AlarmAck { slot, .. } = pdu {
                *slot = NO_SLOT;
            });
        "acknowledged-alarm-stays" "Alarm_Ack is answered and has no effect."
            => |d| d.slave.add(AlarmAcks::new(|alarm, _| alarm.slot = NO_SLOT, true));
        "any-alarm-ack-taken" "An Alarm_Ack that fits no alarm is answered as if it did."
            => |d| d.slave.add(AlarmAcks::new(|_, _| (), true));
        "alarm-sequence-not-compared" "The sequence number of an Alarm_Ack is not compared."
            => |d| d.slave.add(AlarmAcks::new(|alarm, open| alarm.specifier = open.specifier, false));
        "alarm-type-not-compared" "The type of an Alarm_Ack is not compared."
            => |d| d.slave.add(AlarmAcks::new(|alarm, open| alarm.kind = open.kind, false));
        "alarm-slot-not-compared" "The slot of an Alarm_Ack is not compared."
            => |d| d.slave.add(AlarmAcks::new(|alarm, open| alarm.slot = open.slot, false));
        "alarm-access-point-not-active" "Access point 50 is not active."
            => |d| d.slave.add(Replaced::new(|_, frame, service| {
                (service == SapService::Slave(SlaveSap::ALARM)).then(|| vec![to_access_point(frame, UNUSED)])
            }));
        "records-at-the-alarm-access-point" "Access point 50 takes reads of records too."
            => |d| d.slave.add(Replaced::new(|_, frame, service| {
                let is_read = service == SapService::Slave(SlaveSap::ALARM) && frame.data.first() == Some(&Dpv1Function::READ.0);
                is_read.then(|| vec![to_access_point(frame, SlaveSap::SERVER.0)])
            }));
        "alarm-ack-of-anybody" "An Alarm_Ack of any master ends the alarm."
            => |d| d.slave.add(Replaced::new(|session, frame, service| {
                let is_ack = service == SapService::Slave(SlaveSap::SERVER) && frame.data.first() == Some(&Dpv1Function::ALARM_ACK.0);
                let is_foreign = session.owner().is_some_and(|owner| owner != frame.sa);
                (is_ack && is_foreign).then(|| vec![of_owner(session, frame)])
            }));
    },
}];

/// An access point that no service uses.
const UNUSED: u8 = 52;
/// A slot without an alarm.
const NO_SLOT: u8 = 250;

/// Changes the three bytes of DP-V1 in each Set_Prm.
fn enables(d: &mut Deviations, change: fn(&mut [u8; 3])) {
    d.slave.set_prm(move |prm| {
        if let Some(dpv1) = prm.user.first_chunk_mut() {
            change(dpv1);
        }
    });
}

/// Enables a type of alarm in each Set_Prm with DP-V1.
fn always_enabled(d: &mut Deviations, which: Dpv1Status2) {
    d.slave.set_prm(move |prm| {
        if let Some([first, enabled, _]) = prm.user.first_chunk_mut()
            && Dpv1Status1(*first).has(Dpv1Status1::DPV1_ENABLE)
        {
            *enabled |= which.0;
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dp_alarms_state::AlarmHead;

    #[test]
    fn an_alarm_is_found_among_other_blocks() {
        let mut blocks = vec![0x04, 0x02, 0x01, 0x08, 0x42, 0x01];
        assert_eq!(alarm_of(&blocks), Some(AlarmHead { kind: 2, slot: 1, specifier: 8 }));
        without_alarm(&mut blocks);
        assert_eq!(blocks, [0x42, 0x01]);
        assert_eq!(alarm_of(&[0x05, 0x81, 0x00, 0x00, 0x01]), None);
        // Behind blocks of identifiers and channels, a revision number and a status.
        let mut blocks = vec![0x42, 0x01, 0x81, 0x00, 0xA1, 0xC1, 0x04, 0x81, 0x00, 0x00, 0x04, 0x01, 0x02, 0x0B];
        assert_eq!(alarm_of(&blocks), Some(AlarmHead { kind: 1, slot: 2, specifier: 0x0B }));
        without_alarm(&mut blocks);
        assert_eq!(blocks, [0x42, 0x01, 0x81, 0x00, 0xA1, 0xC1, 0x04, 0x81, 0x00, 0x00]);
    }
}
