//! Deviations of the PROFINET stack in cyclic data, records, I&M and alarms, and at the end of a connection.

use super::Group;
use super::connection_state::{
    AbortsAtImplicitRead, AbortsAtShortFrame, InputsStandStill, OneBadClearsAll, OnlyNewAlarms, RefusesAfterEnd,
    WritableIm0,
};
use crate::needs::Need;
use crate::seams::stack::{IM0, dcp, is_of_stack, profinet};
use alloc::vec::Vec;
use core::ops::RangeInclusive;
use core::time::Duration;
use device_stack::profinet::{ArEvent, RecordAccess, StackCheck, StackView};
use wire::datagram::Datagram;
use wire::profinet::rpc::{self, RpcPdu};
use wire::profinet::rt::{ApduStatus, FrameKind};
use wire::profinet::status::RecordError;

/// Record indices of I&M1 to I&M3, which users write.
const IM1_TO_IM3: RangeInclusive<u16> = 0xAFF1..=0xAFF3;

/// A data hold time longer than any run: one year.
const NEVER: Duration = Duration::from_secs(31_536_000);

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[
    Group {
        needs: &[Need::Profinet],
        deviations: bugs! {
            // Cyclic data
            "good-inputs-before-ready" "The inputs are good before ApplicationReady."
                => |d| d.stack.set(StackCheck::InputsReady, true);
            "consumer-status-always-bad" "The consumer status (IOCS) of the outputs is always bad."
                => |d| d.stack.set(StackCheck::TakesOutputs, false);
            "bad-outputs-taken" "Outputs with bad provider status (IOPS) are used."
                => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::ProviderStatus(_)));
            "one-bad-status-clears-all" "A bad provider status of one submodule makes the outputs of all submodules bad."
                => |d| d.stack.add(OneBadClearsAll::default());
            "inputs-stop-with-bad-outputs" "The inputs are frozen while outputs are bad."
                => |d| d.stack.add(InputsStandStill::default());
            "outputs-not-watched" "The connection does not end when outputs are missing."
                => |d| d.stack.data_hold_time(|_| NEVER);
            "watch-too-short" "The connection ends after a quarter of the data hold time."
                => |d| d.stack.data_hold_time(|agreed| agreed / 4);
            "watch-too-long" "The connection ends only after ten times the data hold time."
                => |d| d.stack.data_hold_time(|agreed| agreed * 10);
            "cycle-counter-stands-still" "The cycle counter is the same in every frame."
                => |d| d.stack.inputs(|frame| { let at = frame.len() - ApduStatus::LENGTH; frame[at..at + 2].copy_from_slice(&[0x10, 0x00]) });
            "outputs-of-anybody" "Outputs are accepted from any station."
                => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::Source(_)));

            // I&M
            "im0-refused" "I&M0 cannot be read."
                => |d| d.stack.read(|access, result| if access.index == IM0 && result.is_ok() { *result = Err(RecordError::INVALID_INDEX) });
            "im0-length-counts-header" "The length in the header of I&M0 includes the whole header."
                => |d| d.stack.im0_octets(|octets| octets[3] += 6);
            "im0-of-54-bytes" "I&M0 has no header."
                => |d| d.stack.im0_octets(|octets| drop(octets.drain(..6)));
            "im0-without-vendor" "The vendor ID in I&M0 is 0."
                => |d| d.stack.im0(|im0| im0.vendor_id = 0);
            "im0-padded-with-zeros" "The order number in I&M0 is padded with zeros instead of spaces."
                => |d| d.stack.im0(|im0| im0.order_id.iter_mut().filter(|octet| **octet == b' ').for_each(|octet| *octet = 0));
            "im0-order-of-another-model" "The order number in I&M0 is that of another model."
                => |d| d.stack.im0(|im0| im0.order_id[..5].copy_from_slice(b"OTHER"));
            "im0-serial-empty" "The serial number in I&M0 is empty."
                => |d| d.stack.im0(|im0| im0.serial_number = [b' '; 16]);
            "im0-serial-of-zeros" "The serial number in I&M0 consists of sixteen zero bytes."
                => |d| d.stack.im0(|im0| im0.serial_number = [0; 16]);
            "im0-revisions-wrong" "The hardware revision in I&M0 is the software revision."
                => |d| d.stack.im0(|im0| {
                let software = im0.software_revision;
                im0.hardware_revision = u16::from_be_bytes([software.functional_enhancement, software.bug_fix]);
            });
            "im0-software-as-text" "The software revision in I&M0 is a text."
                => |d| d.stack.im0_octets(|octets| octets[46..50].copy_from_slice(b"1.09"));
            "im0-counts-reads" "The revision counter and the profile specific type in I&M0 change with each read."
                => |d| d.stack.im0({
                let mut reads = 0_u16;
                move |im0| {
                    (im0.revision_counter, im0.profile_specific_type) = (reads, reads);
                    reads = reads.wrapping_add(1);
                }
            });
            "im0-version-0" "The I&M version in I&M0 is 0."
                => |d| d.stack.im0(|im0| im0.im_version = [0, 0]);
            "im0-written" "I&M0 can be written."
                => |d| d.stack.add(WritableIm0::default());

            // Records
            "records-not-cut" "A record is always answered in full, however few bytes are requested."
                => |d| d.stack.set(StackCheck::RecordTooLong, false);
            "unknown-index-answered" "Unknown records read as empty."
                => |d| d.stack.read(|access, result| if is_unknown(access, result) { *result = Ok(Vec::new()) });
            "unknown-index-written" "Writes to unknown records are answered positively."
                => |d| d.stack.written(|access, _, result| if is_unknown(access, result) { *result = Ok(()) });
            "plugged-not-reported" "The records with the plugged submodules cannot be read."
                => |d| d.stack.read(|access, result| if matches!(access.index, 0x8001 | 0xC001 | 0xE001 | 0xF000) && result.is_ok() { *result = Err(RecordError::INVALID_INDEX) });
            "place-not-checked" "I&M0 can be read in slots and subslots where nothing is plugged."
                => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::Plugged(RecordAccess { index: IM0, .. })));
            "read-only-record-written" "A write to a read-only record is accepted but has no effect."
                => |d| d.stack.written(|access, _, result| if is_of_stack(access.index) && *result == Err(RecordError::ACCESS_DENIED) { *result = Ok(()) });
            "one-error-for-all" "Every refused record access has the same error code."
                => |d| {
                d.stack.read(|_, result| if result.is_err() { *result = Err(RecordError::READ_ERROR) });
                d.stack.written(|_, _, result| if result.is_err() { *result = Err(RecordError::READ_ERROR) });
            };
            "second-reader-ends-connection" "A read without a connection ends the existing connections."
                => |d| d.stack.add(AbortsAtImplicitRead::default());

            // Alarms
            "pending-diagnosis-not-reported" "Diagnoses that are pending before a connection are not reported to it."
                => |d| d.stack.add(OnlyNewAlarms::default());

            // The end of a connection
            "released-connection-kept" "After a released connection the next Connect is refused."
                => |d| d.stack.add(RefusesAfterEnd { after: ArEvent::Released, is_taken: false });
            "aborted-connection-kept" "After an aborted connection the next Connect is refused."
                => |d| d.stack.add(RefusesAfterEnd { after: ArEvent::Aborted, is_taken: false });

            // Broken requests
            "damaged-dcp-ends-connection" "A malformed DCP frame ends the connection."
                => |d| d.stack.abort_at(is_damaged_dcp);
            "damaged-call-ends-connection" "A datagram that is not an RPC call ends the connection."
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
            "im1-accepted" "A write to I&M1 is accepted but has no effect."
                => |d| d.stack.written(|access, _, result| if IM1_TO_IM3.contains(&access.index) && *result == Err(RecordError::INVALID_INDEX) { *result = Ok(()) });
            "im0-announces-im1" "I&M0 announces I&M1 to I&M3."
                => |d| d.stack.im0(|im0| im0.im_supported = 0b1110);
        },
    },
    Group {
        needs: &[Need::Profinet],
        deviations: bugs! {
            "im1-not-kept" "A write to I&M1 to I&M3 is accepted but not stored."
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
