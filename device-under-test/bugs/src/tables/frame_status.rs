//! Deviations of the PROFINET stack in DataStatus, LLDP announcements, the transfer of alarms, interruptions, and names.

use super::connection_state::RefusesAfterEnd;
use super::frame_status_state::{
    AlarmsSentOnce, RareAnnouncements, RefusesAfterPowerLoss, SameSequence, SilentBesideConnection,
};
use super::{Deviation, Group};
use crate::needs::Need;
use crate::seams::stack::Stack;
use device_stack::profinet::{ArEvent, StackCheck};
use wire::lldp::{Lldp, Oui, Tlv};
use wire::profinet::blocks::connect::{AlarmCrBlockReq, ConnectContent};
use wire::profinet::rt::DataStatus;

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[Group { needs: &[Need::Profinet], deviations: BUGS }];

const BUGS: &[Deviation] = bugs! {
    // DataStatus of the controller
    "stopped-outputs-taken" "The outputs of a controller in STOP are used."
        => |d| takes_outputs(&mut d.stack, DataStatus::RUN);
    "invalid-outputs-taken" "Outputs are used although DataStatus says that they are not valid."
        => |d| takes_outputs(&mut d.stack, DataStatus::DATA_VALID);
    "backup-outputs-taken" "Outputs of a backup controller are used."
        => |d| takes_outputs(&mut d.stack, DataStatus::PRIMARY);
    "ignored-frames-taken" "Frames are used although DataStatus says to ignore them."
        => |d| d.stack.check(|check, right| right && !matches!(check, StackCheck::IgnoredFrame(_)));
    "problem-ends-outputs" "Outputs are not used while the controller indicates a problem."
        => |d| d.stack.check(|check, right| match check {
            StackCheck::DataStatus(status) => right && status.has(DataStatus::NO_PROBLEM),
            _ => right,
        });

    // DataStatus of the device
    "inputs-of-a-backup" "DataStatus of the inputs is that of a backup."
        => |d| clears_status(&mut d.stack, DataStatus::PRIMARY);
    "inputs-not-valid" "DataStatus of the inputs says that they are not valid."
        => |d| clears_status(&mut d.stack, DataStatus::DATA_VALID);
    "inputs-stopped" "DataStatus of the inputs says that the device has stopped."
        => |d| clears_status(&mut d.stack, DataStatus::RUN);
    "problem-always-indicated" "DataStatus of the inputs always indicates a problem."
        => |d| clears_status(&mut d.stack, DataStatus::NO_PROBLEM);
    "problem-never-indicated" "DataStatus of the inputs never indicates a problem."
        => |d| d.stack.inputs(|frame| {
            let at = frame.len() - 2;
            frame[at] |= DataStatus::NO_PROBLEM;
        });
    "reserved-status-bits" "The reserved bits of DataStatus are set in the inputs."
        => |d| d.stack.inputs(|frame| {
            let at = frame.len() - 2;
            frame[at] |= 0x48;
        });

    // LLDP
    "lldp-ttl-120" "LLDP announces a time to live of 120 s."
        => |d| d.stack.lldp(|lldp| each(lldp, |tlv| if let Tlv::TimeToLive(seconds) = tlv { *seconds = 120 }));
    "lldp-every-30-s" "LLDP is sent every 30 s."
        => |d| d.stack.add(RareAnnouncements::default());
    "lldp-without-mac" "LLDP lacks the MAC address of the interface."
        => |d| d.stack.lldp(|lldp| without(lldp, |tlv| matches!(tlv, Tlv::ChassisMac(_))));
    "lldp-without-medium" "LLDP lacks the state of auto-negotiation and the MAU type."
        => |d| d.stack.lldp(|lldp| without(lldp, |tlv| matches!(tlv, Tlv::MacPhy { .. })));
    "lldp-foreign-organisation" "The TLVs of PROFINET in LLDP have another organisation."
        => |d| d.stack.lldp(|lldp| each(lldp, |tlv| if let Tlv::ChassisMac(mac) = tlv {
            *tlv = Tlv::Organizational { oui: Oui([0, 0, 1]), subtype: 5, octets: mac.0.to_vec() };
        }));
    "lldp-port-by-interface-name" "The port ID of LLDP has the subtype of an interface name."
        => |d| d.stack.lldp(|lldp| each(lldp, |tlv| if let Tlv::PortId { subtype, .. } = tlv { *subtype = 5 }));
    "lldp-out-of-order" "The time to live of LLDP comes before the port ID."
        => |d| d.stack.lldp(|lldp| { lldp.tlvs.swap(1, 2); true });

    // Alarms
    "alarm-sent-once" "An alarm that is not acknowledged is not repeated."
        => |d| d.stack.add(AlarmsSentOnce::default());
    "rta-retries-ignored" "An alarm is repeated three times, whatever the controller has set."
        => |d| alarm_cr(&mut d.stack, |request| request.rta_retries = 3);
    "rta-timeout-ignored" "An alarm is repeated after 100 ms, whatever the controller has set."
        => |d| alarm_cr(&mut d.stack, |request| request.rta_timeout_factor = 1);
    "alarm-never-given-up" "An alarm is repeated without end."
        => |d| {
            alarm_cr(&mut d.stack, |request| request.rta_retries = u16::MAX);
            d.stack.check(|check, right| right || matches!(check, StackCheck::AlarmCrField(..)));
        };
    "alarm-sequence-stands-still" "Each alarm has the sequence number 0."
        => |d| d.stack.add(SameSequence);

    // Interruptions
    "ended-connection-kept" "After a connection that the device has ended itself, every further Connect is refused."
        => |d| d.stack.add(RefusesAfterEnd { after: ArEvent::Ended, is_taken: false });
    "no-connect-after-power-loss" "After a loss of power every Connect is refused."
        => |d| d.stack.add(RefusesAfterPowerLoss::default());
    "silent-beside-connection" "While a controller is connected, DCP Identify is not answered."
        => |d| d.stack.add(SilentBesideConnection::default());

    // Names
    "names-of-200-at-most" "Names of more than 200 characters are refused."
        => |d| refuses_name(&mut d.stack, |name| name.len() > 200);
    "labels-of-60-at-most" "Names with a label of more than 60 characters are refused."
        => |d| refuses_name(&mut d.stack, |name| name.split(|octet| *octet == b'.').any(|label| label.len() > 60));
    "international-names-refused" "Names with an encoded international label are refused."
        => |d| refuses_name(&mut d.stack, |name| name.starts_with(b"xn--"));
    "short-names-refused" "Names of one character are refused."
        => |d| refuses_name(&mut d.stack, |name| name.len() == 1);
    "double-hyphens-refused" "Names with two hyphens in a row are refused."
        => |d| refuses_name(&mut d.stack, |name| name.windows(2).any(|pair| pair == b"--"));
    "names-like-ports-refused" "Every name that begins with port is refused."
        => |d| refuses_name(&mut d.stack, |name| name.starts_with(b"port"));
    "numeric-names-refused" "Names of digits and dots are refused."
        => |d| refuses_name(&mut d.stack, |name| !name.is_empty() && name.iter().all(|octet| octet.is_ascii_digit() || *octet == b'.'));
};

fn takes_outputs(stack: &mut Stack, without: u8) {
    let required = DataStatus::PRIMARY | DataStatus::DATA_VALID | DataStatus::RUN;
    stack.check(move |check, right| match check {
        StackCheck::DataStatus(status) => right || DataStatus(status.0 | without).has(required),
        _ => right,
    });
}

fn clears_status(stack: &mut Stack, bit: u8) {
    stack.inputs(move |frame| {
        let at = frame.len() - 2;
        frame[at] &= !bit;
    });
}

fn each(lldp: &mut Lldp, change: impl Fn(&mut Tlv)) -> bool {
    lldp.tlvs.iter_mut().for_each(change);
    true
}

fn without(lldp: &mut Lldp, is_left_out: fn(&Tlv) -> bool) -> bool {
    lldp.tlvs.retain(|tlv| !is_left_out(tlv));
    true
}

/// Changes the alarm connection that a controller requests.
fn alarm_cr(stack: &mut Stack, change: fn(&mut AlarmCrBlockReq)) {
    stack.connect(move |_, connect| {
        for block in &mut connect.blocks {
            if let ConnectContent::AlarmCrReq(request) = &mut block.content {
                change(request);
            }
        }
    });
}

fn refuses_name(stack: &mut Stack, is_refused: fn(&[u8]) -> bool) {
    stack.check(move |check, right| match check {
        StackCheck::Name(name) => right && !is_refused(name),
        _ => right,
    });
}
