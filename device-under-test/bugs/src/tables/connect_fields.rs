//! Deviations of the PROFINET stack in the fields of a Connect that it checks; the numbers are those of the fields in their blocks.

use super::{Deviation, Group};
use crate::needs::Need;
use alloc::vec::Vec;
use device_stack::profinet::{StackCheck, StackHooks};
use wire::profinet::rpc::{Opnum, RpcHeader};
use wire::profinet::status::PnioStatus;

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[Group { needs: &[Need::Profinet], deviations: BUGS }];

/// Refused connections that a device can have before it has no resources left.
const MOST_REFUSED: u32 = 4;

/// Keeps the resources of each refused Connect.
#[derive(Default)]
struct KeepsRefused {
    refused: u32,
}

impl StackHooks for KeepsRefused {
    fn answer(&mut self, header: &RpcHeader, status: &mut PnioStatus, _: &mut Vec<u8>) {
        self.refused += u32::from(header.opnum == Opnum::CONNECT && *status != PnioStatus::OK);
    }

    fn check(&mut self, check: StackCheck<'_>, verdict: bool) -> bool {
        verdict && !(self.refused >= MOST_REFUSED && matches!(check, StackCheck::ConnectionLimit { .. }))
    }
}

const BUGS: &[Deviation] = bugs! {
    "refused-connect-keeps-resources" "Each refused Connect keeps the resources of a connection."
        => |d| d.stack.add(KeepsRefused::default());
    "block-versions-not-checked" "The versions of the blocks of a Connect are not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::BlockVersion(_)));
    // ARBlockReq
    "ar-type-not-checked" "ARType of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::ArField(.., 4)));
    "ar-uuid-not-checked" "ARUUID of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::ArField(.., 5)));
    "initiator-object-not-checked" "CMInitiatorObjectUUID of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::ArField(.., 8)));
    "ar-properties-not-checked" "ARProperties of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::ArField(.., 9)));
    "activity-timeout-not-checked" "CMInitiatorActivityTimeoutFactor of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::ArField(.., 10)));
    "initiator-udp-port-not-checked" "InitiatorUDPRTPort of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::ArField(.., 11)));
    // IOCRBlockReq
    "iocr-type-not-checked" "IOCRType of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::IocrField(.., 4)));
    "iocr-reference-not-checked" "IOCRReference of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::IocrField(.., 5)));
    "iocr-lt-not-checked" "LT of an IOCR of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::IocrField(.., 6)));
    "iocr-properties-not-checked" "IOCRProperties of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::IocrField(.., 7)));
    "data-length-not-checked" "DataLength of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::IocrField(.., 8)));
    "frame-id-range-not-checked" "FrameID of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::IocrField(.., 9)));
    "send-clock-not-checked" "SendClockFactor of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::IocrField(.., 10)));
    "reduction-not-checked" "ReductionRatio of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::IocrField(.., 11)));
    "phase-not-checked" "Phase of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::IocrField(.., 12)));
    "frame-send-offset-not-checked" "FrameSendOffset of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::IocrField(.., 14)));
    "watchdog-factor-not-checked" "WatchdogFactor of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::IocrField(.., 15)));
    "data-hold-factor-not-checked" "DataHoldFactor of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::IocrField(.., 16)));
    "iocr-tag-not-checked" "IOCRTagHeader of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::IocrField(.., 17)));
    // ExpectedSubmoduleBlockReq
    "expected-module-not-checked" "ModuleIdentNumber of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::ExpectedField(.., 7)));
    "module-properties-not-checked" "ModuleProperties of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::ExpectedField(.., 8)));
    "submodule-properties-not-checked" "SubmoduleProperties of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::ExpectedField(.., 12)));
    "data-description-not-checked" "DataDescription of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::ExpectedField(.., 13)));
    "length-iops-not-checked" "LengthIOPS of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::ExpectedField(.., 15)));
    "length-iocs-not-checked" "LengthIOCS of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::ExpectedField(.., 16)));
    // AlarmCRBlockReq
    "alarm-cr-type-not-checked" "AlarmCRType of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::AlarmCrField(.., 4)));
    "alarm-lt-not-checked" "LT of the AlarmCR of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::AlarmCrField(.., 5)));
    "alarm-properties-not-checked" "AlarmCRProperties of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::AlarmCrField(.., 6)));
    "rta-timeout-not-checked" "RTATimeoutFactor of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::AlarmCrField(.., 7)));
    "rta-retries-not-checked" "RTARetries of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::AlarmCrField(.., 8)));
    "max-alarm-data-not-checked" "MaxAlarmDataLength of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::AlarmCrField(.., 10)));
    "alarm-tag-high-not-checked" "AlarmCRTagHeaderHigh of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::AlarmCrField(.., 11)));
    "alarm-tag-low-not-checked" "AlarmCRTagHeaderLow of a Connect is not checked."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::AlarmCrField(.., 12)));
    // Limits of the fields
    "activity-timeout-limited" "CMInitiatorActivityTimeoutFactor must be below 1000."
        => |d| d.stack.check(|check, right| match check { StackCheck::ArField(ar, 10) => right && ar.cm_initiator_activity_timeout_factor < 1000, _ => right });
    "rta-timeout-limited" "RTATimeoutFactor must be below 100."
        => |d| d.stack.check(|check, right| match check { StackCheck::AlarmCrField(alarms, 7) => right && alarms.rta_timeout_factor < 100, _ => right });
    "rta-retries-limited" "RTARetries must be below 15."
        => |d| d.stack.check(|check, right| match check { StackCheck::AlarmCrField(alarms, 8) => right && alarms.rta_retries < 15, _ => right });
    "max-alarm-data-limited" "MaxAlarmDataLength must be below 1432."
        => |d| d.stack.check(|check, right| match check { StackCheck::AlarmCrField(alarms, 10) => right && alarms.max_alarm_data_length < 1432, _ => right });
};
