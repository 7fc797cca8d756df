//! Deviations of the PROFINET stack in what a connection carries: cyclic data, records, I&M, alarms; and in how it ends.

use super::Group;
use super::stack_memory::{
    AbortsAtImplicitRead, AbortsAtShortFrame, InputsStandStill, KeepsRoom, OneBadClearsAll, OnlyNewAlarms, WritableIm0,
};
use crate::needs::Need;
use crate::seams::stack::{IM0, dcp, is_of_stack, profinet};
use alloc::vec::Vec;
use core::ops::RangeInclusive;
use core::time::Duration;
use device_stack::profinet::{ArEvent, RecordAccess, StackCheck, StackView};
use reference_devices::manuals;
use wire::datagram::Datagram;
use wire::profinet::rpc::{self, RpcPdu};
use wire::profinet::rt::{ApduStatus, FrameKind};
use wire::profinet::status::RecordError;

/// I&M1 to I&M3, which a user writes.
const IM1_TO_IM3: RangeInclusive<u16> = 0xAFF1..=0xAFF3;

/// The deviations, by what they need of a device.
pub static GROUPS: &[Group] = &[
    Group {
        needs: &[Need::Profinet],
        deviations: bugs! {
            // Cyclic data
            "good-inputs-before-ready" "The inputs are good before ApplicationReady."
                => |d| d.stack.set(StackCheck::InputsReady, true);
            "consumer-status-always-bad" "The device never says that it takes the outputs."
                => |d| d.stack.set(StackCheck::TakesOutputs, false);
            "bad-outputs-taken" "Outputs whose provider status is bad are taken."
                => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::ProviderStatus(_)));
            "one-bad-status-clears-all" "The bad status of one submodule makes the outputs of all bad."
                => |d| d.stack.add(OneBadClearsAll::default());
            "inputs-stop-with-bad-outputs" "The inputs stand still while outputs are bad."
                => |d| d.stack.add(InputsStandStill::default());
            "outputs-not-watched" "The connection does not end when no outputs come."
                => |d| d.stack.data_hold_time(|_| Duration::from_secs(31_536_000));
            "watch-too-short" "The connection ends after a quarter of the time for which outputs may be missing."
                => |d| d.stack.data_hold_time(|agreed| agreed / 4);
            "watch-too-long" "Outputs may be missing ten times as long as was agreed."
                => |d| d.stack.data_hold_time(|agreed| agreed * 10);
            "cycle-counter-stands-still" "The cycle counter is the same in every frame."
                => |d| d.stack.inputs(|frame| { let at = frame.len() - ApduStatus::LENGTH; frame[at..at + 2].copy_from_slice(&[0x10, 0x00]) });
            "outputs-of-anybody" "Outputs are taken from any station."
                => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::Source(_)));

            // I&M
            "im0-refused" "There is no I&M0."
                => |d| d.stack.read(|access, result| if access.index == IM0 && result.is_ok() { *result = Err(RecordError::INVALID_INDEX) });
            "im0-length-counts-header" "The length in the header of I&M0 counts the header too."
                => |d| d.stack.im0_octets(|octets| octets[3] += 6);
            "im0-of-54-octets" "I&M0 is told without its header."
                => |d| d.stack.im0_octets(|octets| drop(octets.drain(..6)));
            "im0-without-vendor" "The vendor in I&M0 is 0."
                => |d| d.stack.im0(|im0| im0.vendor_id = 0);
            "im0-padded-with-zeros" "The order number in I&M0 is filled with zeros."
                => |d| d.stack.im0(|im0| im0.order_id.iter_mut().filter(|octet| **octet == b' ').for_each(|octet| *octet = 0));
            "im0-serial-empty" "The serial number in I&M0 is empty."
                => |d| d.stack.im0(|im0| im0.serial_number = [b' '; 16]);
            "im0-serial-of-zeros" "The serial number in I&M0 is sixteen octets of 0."
                => |d| d.stack.im0(|im0| im0.serial_number = [0; 16]);
            "im0-revisions-wrong" "The hardware revision in I&M0 is the software revision."
                => |d| d.stack.im0(|im0| {
                let software = im0.software_revision;
                im0.hardware_revision = u16::from_be_bytes([software.functional_enhancement, software.bug_fix]);
            });
            "im0-software-as-text" "The software revision in I&M0 is a text."
                => |d| d.stack.im0_octets(|octets| octets[46..50].copy_from_slice(b"1.09"));
            "im0-counts-reads" "The revision counter and the type of the profile in I&M0 change with each read."
                => |d| d.stack.im0({
                let mut reads = 0_u16;
                move |im0| {
                    (im0.revision_counter, im0.profile_specific_type) = (reads, reads);
                    reads = reads.wrapping_add(1);
                }
            });
            "im0-version-0" "The version of I&M in I&M0 is 0."
                => |d| d.stack.im0(|im0| im0.im_version = [0, 0]);
            "im0-written" "I&M0 can be written."
                => |d| d.stack.add(WritableIm0::default());

            // Records
            "records-not-cut" "A record is answered whole, however few octets are asked for."
                => |d| d.stack.set(StackCheck::RecordTooLong, false);
            "unknown-index-answered" "Unknown records are read as empty ones."
                => |d| d.stack.read(|access, result| if is_unknown(access, result) { *result = Ok(Vec::new()) });
            "unknown-index-written" "Unknown records are written as if they were there."
                => |d| d.stack.written(|access, _, result| if is_unknown(access, result) { *result = Ok(()) });
            "plugged-not-told" "No record tells what is plugged."
                => |d| d.stack.read(|access, result| if matches!(access.index, 0x8001 | 0xC001 | 0xE001 | 0xF000) && result.is_ok() { *result = Err(RecordError::INVALID_INDEX) });
            "place-not-checked" "I&M0 can be read where nothing is plugged."
                => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::Plugged(RecordAccess { index: IM0, .. })));
            "read-only-record-written" "Writing a record that can only be read is accepted and lost."
                => |d| d.stack.written(|access, _, result| if is_of_stack(access.index) && *result == Err(RecordError::ACCESS_DENIED) { *result = Ok(()) });
            "one-error-for-all" "Every refusal of a record gives the same reason."
                => |d| {
                d.stack.read(|_, result| if result.is_err() { *result = Err(RecordError::READ_ERROR) });
                d.stack.written(|_, _, result| if result.is_err() { *result = Err(RecordError::READ_ERROR) });
            };
            "second-reader-ends-connection" "Reading without a connection ends the connections of others."
                => |d| d.stack.add(AbortsAtImplicitRead::default());

            // Alarms
            "pending-diagnosis-not-told" "A new connection is not told what is wrong already."
                => |d| d.stack.add(OnlyNewAlarms::default());

            // The end of a connection
            "released-connection-kept" "A connection that was released stands in the way of the next one."
                => |d| d.stack.add(KeepsRoom { after: ArEvent::Released, is_taken: false });
            "aborted-connection-kept" "A connection that was aborted stands in the way of the next one."
                => |d| d.stack.add(KeepsRoom { after: ArEvent::Aborted, is_taken: false });

            // Broken requests
            "damaged-dcp-ends-connection" "A DCP frame that cannot be read ends the connection."
                => |d| d.stack.abort_at(is_damaged_dcp);
            "damaged-call-ends-connection" "A datagram that is no call ends the connection."
                => |d| d.stack.abort_at(is_damaged_call);
            "short-frame-ends-connection" "A cyclic frame that is too short ends the connection."
                => |d| d.stack.add(AbortsAtShortFrame::default());
            "any-endpoint-ends-connection" "An ERR-RTA for another alarm endpoint ends the connection."
                => |d| d.stack.set(StackCheck::AlarmEndpoint, true);
        },
    },
    Group {
        needs: &[Need::Profinet, Need::OnlyIm0],
        deviations: bugs! {
            "im1-accepted" "Writing I&M1 is accepted and lost."
                => |d| d.stack.written(|access, _, result| if IM1_TO_IM3.contains(&access.index) && *result == Err(RecordError::INVALID_INDEX) { *result = Ok(()) });
            "im0-announces-im1" "I&M0 says that there are I&M1 to I&M3."
                => |d| d.stack.im0(|im0| im0.im_supported = 0b1110);
        },
    },
    Group {
        needs: &[Need::Of(&manuals::PROFINET_IO)],
        deviations: bugs! {
            "im1-not-kept" "I&M1 is written and reads as before."
                => |d| d.stack.record(|index, data| if IM1_TO_IM3.contains(&index) { data[6..].fill(b' ') });
        },
    },
];

// Records

/// Whether the application has no record of this index.
fn is_unknown<T>(access: RecordAccess, result: &Result<T, RecordError>) -> bool {
    !is_of_stack(access.index) && matches!(result, Err(RecordError::INVALID_INDEX))
}

// Broken requests

fn is_damaged_dcp(view: &StackView<'_>, frame: &[u8]) -> bool {
    let Some((header, _, frame_id)) = profinet(frame) else { return false };
    let is_dcp = matches!(frame_id.kind(), FrameKind::DcpIdentifyRequest | FrameKind::DcpGetSet);
    let is_received = header.destination == view.mac || header.destination.is_group();
    is_dcp && is_received && dcp(frame).is_none()
}

fn is_damaged_call(view: &StackView<'_>, frame: &[u8]) -> bool {
    let Ok(datagram) = Datagram::parse(frame) else { return false };
    let is_received = datagram.destination.ip().octets() == view.station.ip && datagram.checksum_ok();
    is_received && datagram.destination.port() == rpc::PORT && RpcPdu::parse(datagram.payload).is_err()
}
