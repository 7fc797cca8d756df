//! Deviations of the PROFINET stack in connections of supervisors, alarms of high priority, port parameters and the log book.

use super::record_access::missing;
use super::shared_slots::{not_sent, renamed};
use super::supervisors_state::{DropsWrites, EndsControllers, KeepsSupervisor, RefusesReads, SupervisorCalls};
use super::{Deviation, Group};
use crate::needs::Need;
use device_stack::profinet::StackCheck;
use wire::profinet::alarm::{AlarmPriority, AlarmType};
use wire::profinet::rpc::Opnum;
use wire::profinet::status::RecordError;

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[Group { needs: &[Need::Profinet], deviations: BUGS }];

const BUGS: &[Deviation] = bugs! {
    // Supervisors
    "supervisor-refused" "The connection of a supervisor is refused."
        => |d| d.stack.check(|check, right| right && !matches!(check, StackCheck::ConnectionLimit { is_exchange: false, .. }));
    "supervisor-takes-over" "The connection of a supervisor ends that of the controller."
        => |d| d.stack.add(EndsControllers::default());
    "supervisor-reads-refused" "A supervisor cannot read records."
        => |d| d.stack.add(RefusesReads(SupervisorCalls::default()));
    "supervisor-writes-lost" "A write of a supervisor is answered positively and changes nothing."
        => |d| d.stack.add(DropsWrites::default());
    "supervisor-connection-kept" "The connection of a supervisor stays occupied after its release."
        => |d| d.stack.add(KeepsSupervisor::default());
    "silent-supervisor-kept" "The connection of a supervisor that is silent for too long does not end."
        => |d| d.stack.set(StackCheck::EndsWhenSilent, false);

    // Alarms of high priority
    "process-alarm-not-sent" "An event in the process is not reported."
        => |d| not_sent(&mut d.stack, AlarmType::PROCESS);
    "process-alarm-of-low-priority" "An event in the process is reported with low priority."
        => |d| d.stack.alarm(|alarm, is_sent| {
            alarm.priority = AlarmPriority::Low;
            is_sent
        });
    "process-alarm-as-status" "An event in the process is reported as a change of state."
        => |d| renamed(&mut d.stack, AlarmType::PROCESS, AlarmType::STATUS);
    "low-alarms-in-high-frames" "An alarm of low priority comes in a frame of high priority."
        => |d| d.stack.set(StackCheck::InHighFrames, true);
    "priorities-share-numbers" "Alarms of both priorities are numbered together."
        => |d| d.stack.set(StackCheck::NumbersOfHighAlarms, false);
    "high-alarms-wait-for-low" "An alarm of high priority waits until the one of low priority is acknowledged."
        => |d| d.stack.set(StackCheck::HighBesideLow, false);

    // Port parameters
    "port-check-not-read" "What a port checks cannot be read back."
        => |d| missing(&mut d.stack, &[0x802B]);
    "port-adjust-not-read" "What is set at a port cannot be read back."
        => |d| missing(&mut d.stack, &[0x802F]);
    "peer-station-not-checked" "The station of the neighbour is not checked."
        => |d| d.stack.set(StackCheck::PeerStation, true);
    "peer-port-not-checked" "The port of the neighbour is not checked."
        => |d| d.stack.set(StackCheck::PeerPort, true);
    "right-peer-mismatches" "Every neighbour is reported as a wrong one."
        => |d| d.stack.set(StackCheck::PeerStation, false);
    "peer-mismatch-without-alarm" "A wrong neighbour is reported by no alarm."
        => |d| d.stack.alarm(|alarm, is_sent| is_sent && alarm.subslot < 0x8000);
    "peer-mismatch-stays" "The diagnosis of a wrong neighbour stays once the right one is connected."
        => |d| d.stack.diagnosis(|change, is_noted| is_noted && (change.appears || change.diagnosis.subslot < 0x8000));
    "mau-type-as-remote-mismatch" "A wrong MAU type is reported as a wrong neighbour."
        => |d| d.stack.diagnosis(|change, is_noted| {
            if change.diagnosis.error_type == 0x8000 {
                change.diagnosis.error_type = 0x8001;
            }
            is_noted
        });
    "port-block-not-checked" "A record of a port is accepted with any block."
        => |d| d.stack.set(StackCheck::PortBlock, true);
    "port-address-not-checked" "A record of a port is accepted for another port than it names."
        => |d| d.stack.set(StackCheck::PortAddress, true);
    "port-length-not-checked" "A record of a port with a wrong length is answered positively."
        => |d| d.stack.written(|access, _, result| {
            if matches!(access.index, 0x802B | 0x802F) && *result == Err(RecordError::WRITE_LENGTH_ERROR) {
                *result = Ok(());
            }
        });
    "ports-at-the-access-point" "The access point takes the parameters of a port."
        => |d| d.stack.access(|access| if matches!(access.index, 0x802B | 0x802F) && access.subslot == 1 {
            access.subslot = 0x8001;
        });
    "boundary-not-reported" "The record of a port does not contain the domain boundary."
        => |d| d.stack.record(|index, data| if index == 0x802A {
            let at = data.len() - 16;
            data[at..at + 4].fill(0);
        });

    // Log book
    "log-book-not-read" "The log book cannot be read."
        => |d| missing(&mut d.stack, &[0xF830]);
    "log-book-empty" "The log book has no entries."
        => |d| d.stack.record(|index, data| if index == 0xF830 {
            data.truncate(16);
            data[2..4].copy_from_slice(&12_u16.to_be_bytes());
            data[14..16].fill(0);
        });
};

/// The operations in whose blocks the ARUUID follows two bytes after the header.
pub(super) const WITHIN: [Opnum; 5] = [Opnum::CONNECT, Opnum::RELEASE, Opnum::READ, Opnum::WRITE, Opnum::CONTROL];
