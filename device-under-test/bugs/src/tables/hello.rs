//! Deviations of the PROFINET stack in Hello and in the record that switches it on.

use super::record_access::missing;
use super::{Deviation, Group};
use crate::needs::Need;
use crate::seams::stack::{Stack, change_dcp};
use device_stack::profinet::StackCheck;
use reference_devices::manuals;
use wire::profinet::dcp::{DcpValue, Element, ServiceId};
use wire::profinet::status::RecordError;

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[Group { needs: &[Need::Of(&manuals::PROFINET_IO)], deviations: BUGS }];

/// PDInterfaceFSUDataAdjust and the type of its block.
const RECORD: u16 = 0x8090;
const BLOCK: [u8; 2] = [0x06, 0x08];

const BUGS: &[Deviation] = bugs! {
    "hello-never-said" "The device never says Hello." => |d| says(&mut d.stack, |_, _| false);
    "hello-always" "The device says Hello after each start, whatever the record says." => |d| says(&mut d.stack, |_, _| true);
    "hello-at-power-up-only" "The device says no Hello when its cable is plugged in."
        => |d| says(&mut d.stack, |at_start, right| right && at_start);
    "hello-once" "A Hello is not repeated." => |d| d.stack.set(StackCheck::LastHello, true);
    "hello-for-ever" "A Hello is repeated without end." => |d| d.stack.set(StackCheck::LastHello, false);
    "hello-without-its-delay" "The first Hello does not wait for the delay." => |d| d.stack.set(StackCheck::DelayedHello, false);
    "hello-settings-lost" "The record is lost with the power." => |d| d.stack.set(StackCheck::KeepsFastStartUp, false);
    "hello-kept-by-reset" "A reset of the communication parameters keeps the record."
        => |d| d.stack.set(StackCheck::ResetsFastStartUp, false);
    "hello-without-name" "A Hello has no name." => |d| without(&mut d.stack, Element::NAME_OF_STATION);
    "hello-without-address" "A Hello has no address." => |d| without(&mut d.stack, Element::IP_PARAMETER);
    "hello-not-announced" "DeviceInitiative is 0 although the device says Hello." => |d| d.stack.element(|value| match value {
        DcpValue::DeviceInitiative(_) => DcpValue::DeviceInitiative(0),
        other => other,
    });
    "hello-record-not-read" "The record cannot be read." => |d| missing(&mut d.stack, &[RECORD]);
    "hello-record-refused" "The record cannot be written."
        => |d| written(&mut d.stack, |_, result| *result = Err(RecordError::INVALID_INDEX));
    "hello-block-not-checked" "The record is accepted with another block." => |d| written(&mut d.stack, |data, result| {
        if !data.starts_with(&BLOCK) {
            *result = Ok(());
        }
    });
    "hello-length-not-checked" "The record is accepted if it is cut short." => |d| written(&mut d.stack, |_, result| {
        if *result == Err(RecordError::WRITE_LENGTH_ERROR) {
            *result = Ok(());
        }
    });
    "hello-values-not-checked" "The record is accepted with a mode that does not exist." => |d| written(&mut d.stack, |data, result| {
        if data.starts_with(&BLOCK) && *result == Err(RecordError::INVALID_PARAMETER) {
            *result = Ok(());
        }
    });
};

/// Changes whether the device says Hello, given whether it has just started and the right decision.
fn says(stack: &mut Stack, mut changed: impl FnMut(bool, bool) -> bool + 'static) {
    stack.check(move |check, right| match check {
        StackCheck::SaysHello { at_start } => changed(at_start, right),
        _ => right,
    });
}

/// Takes a block away from each Hello.
fn without(stack: &mut Stack, element: Element) {
    stack.sent_frame(move |_, frame| {
        change_dcp(frame, |dcp, blocks| {
            if dcp.service_id == ServiceId::HELLO {
                blocks.retain(|block| block.value.element() != element);
            }
        });
    });
}

/// Changes the result of writing the record.
fn written(stack: &mut Stack, mut change: impl FnMut(&[u8], &mut Result<(), RecordError>) + 'static) {
    stack.written(move |access, data, result| {
        if access.index == RECORD {
            change(data, result);
        }
    });
}
