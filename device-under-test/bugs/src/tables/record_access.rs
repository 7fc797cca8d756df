//! Deviations of the PROFINET stack in the records that every device has: which there are, what they contain, how they are refused.

use super::record_access_state::{ImTextsLost, KeepsLastText};
use super::{Deviation, Group};
use crate::needs::Need;
use crate::seams::stack::Stack;
use device_stack::profinet::StackCheck;
use wire::profinet::rpc::Opnum;
use wire::profinet::status::{ErrorCode, PnioStatus, RecordError};

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[Group { needs: &[Need::Profinet], deviations: BUGS }];

const BUGS: &[Deviation] = bugs! {
    // Where a record is
    "records-in-every-place" "Records can be read and written in slots and subslots where nothing is plugged."
        => |d| d.stack.check(|check, right| right || matches!(check, StackCheck::Plugged(_)));
    "api-of-records-ignored" "Records are read and written in API 0, whatever API is addressed."
        => |d| d.stack.access(|access| access.api = 0);
    "ports-not-distinguished" "Every subslot of slot 0 has the records of the first port and of the interface."
        => |d| d.stack.access(|access| match access.index {
            0x802A => access.subslot = 0x8001,
            0x8080 => access.subslot = 0x8000,
            _ => {}
        });

    "port-record-of-the-next-port" "The record of the first port is that of the second."
        => |d| d.stack.access(|access| if (access.index, access.subslot) == (0x802A, 0x8001) { access.subslot = 0x8002 });

    // Which records there are
    "expected-not-reported" "The records with the expected submodules cannot be read."
        => |d| missing(&mut d.stack, &[0x8000, 0xC000, 0xE000]);
    "apis-not-reported" "The record with the APIs cannot be read."
        => |d| missing(&mut d.stack, &[0xF821]);
    "im0-filter-not-reported" "The record with the submodules that have I&M0 cannot be read."
        => |d| missing(&mut d.stack, &[0xF840]);
    "interface-not-reported" "The records of the interface cannot be read."
        => |d| missing(&mut d.stack, &[0x8080, 0xF841]);
    "difference-not-in-record" "The record with the module difference cannot be read."
        => |d| missing(&mut d.stack, &[0xE002]);
    "implicit-read-refused" "Every read without a connection is refused."
        => |d| d.stack.answer(|header, status, blocks| if header.opnum == Opnum::READ_IMPLICIT {
            *status = PnioStatus::record(ErrorCode::READ_RESPONSE, RecordError::ACCESS_DENIED);
            blocks.clear();
        });

    // Diagnosis
    "subslot-diagnosis-empty" "The diagnosis records of a subslot are always empty."
        => |d| empty(&mut d.stack, |index| matches!(index, 0x800A..=0x800C));
    "slot-diagnosis-empty" "The diagnosis records of a slot are always empty."
        => |d| empty(&mut d.stack, |index| matches!(index, 0xC00A..=0xC00C));
    "connection-diagnosis-empty" "The diagnosis records of a connection are always empty."
        => |d| empty(&mut d.stack, |index| matches!(index, 0xE00A..=0xE00C));
    "api-diagnosis-empty" "The diagnosis records of an API are always empty."
        => |d| empty(&mut d.stack, |index| matches!(index, 0xF00A..=0xF00C));
    "device-diagnosis-empty" "The diagnosis record of the device is always empty."
        => |d| empty(&mut d.stack, |index| index == 0xF80C);
    "diagnosis-records-never-empty" "The diagnosis records contain a diagnosis although none is pending."
        => |d| d.stack.record(|index, data| if is_diagnosis(index) && data.is_empty() {
            data.extend(NO_FAULT);
        });

    // I&M
    "im-length-not-checked" "A write to I&M1 to I&M3 with a wrong length is answered positively."
        => |d| d.stack.written(|_, _, result| if *result == Err(RecordError::WRITE_LENGTH_ERROR) { *result = Ok(()) });
    "im-type-not-checked" "A write to I&M1 to I&M3 with the block of another I&M record is answered positively."
        => |d| d.stack.written(|_, _, result| if *result == Err(RecordError::INVALID_PARAMETER) { *result = Ok(()) });
    "im-texts-lost" "I&M1 to I&M3 are lost at power-off."
        => |d| d.stack.add(ImTextsLost::default());
    "im-records-shared" "I&M1 to I&M3 return what was written last to any of them."
        => |d| d.stack.add(KeepsLastText::default());
    "multiple-write-stops" "A write of several records answers all of them like the first that is refused."
        => |d| {
            let mut refused = false;
            d.stack.written(move |access, _, result| {
                // A single read-only record begins each list.
                refused |= result.is_err() && access.index == 0xF000;
                if refused && access.index != 0xF000 {
                    *result = Err(RecordError::ACCESS_DENIED);
                }
            });
        };
};

/// A diagnosis of a channel with no fault: DiagnosisData with an error type of 0.
const NO_FAULT: [u8; 28] = [
    0x00, 0x10, 0x00, 0x18, 0x01, 0x01, 0, 0, 0, 0, 0, 1, 0, 1, 0x80, 0x00, 0x08, 0x00, 0x80, 0x00, 0, 0, 0, 0, 0, 0,
    0, 0,
];

fn is_diagnosis(index: u16) -> bool {
    matches!(index & 0x0FFF, 0x00A..=0x00C) && index >= 0x8000 || index == 0xF80C
}

pub(super) fn missing(stack: &mut Stack, indices: &'static [u16]) {
    stack.read(move |access, result| {
        if indices.contains(&access.index) {
            *result = Err(RecordError::INVALID_INDEX);
        }
    });
}

fn empty(stack: &mut Stack, is_empty: fn(u16) -> bool) {
    stack.record(move |index, data| {
        if is_empty(index) {
            data.clear();
        }
    });
}
