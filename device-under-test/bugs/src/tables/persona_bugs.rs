//! Deviations that no manual lists, because only personas of real controllers find them. Every PROFINET device can have them.

use super::Deviation;
use super::connection_state::WritesFirstRecord;
use crate::seams::stack::profinet;
use device_stack::profinet::StackCheck;
use wire::octets::ByteOrder;
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::connect::{ArProperties, Connect};
use wire::profinet::rpc::Opnum;

/// Number of the field ARProperties in an ARBlockReq, counting the header.
pub const AR_PROPERTIES: u8 = 9;
/// Number of the field ReductionRatio in an IOCRBlockReq, counting the header.
const REDUCTION: u8 = 11;
/// Number of the field Phase in an IOCRBlockReq, counting the header.
const PHASE: u8 = 12;

/// The deviations.
pub static BUGS: &[Deviation] = bugs! {
    "advanced-start-refused" "A Connect with the advanced startup mode is refused."
        => |d| d.stack.check(|check, right| match check { StackCheck::ArField(ar, AR_PROPERTIES) => right && !ar.ar_properties.has(ArProperties::STARTUP_ADVANCED), _ => right });
    "little-endian-refused" "An RPC call in little-endian byte order is answered with a fault."
        => |d| d.stack.call(|_, header, body| if header.order() == ByteOrder::Little { body.clear() });
    "block-order-fixed" "A Connect is refused if its AlarmCRBlockReq is not the last block."
        => |d| d.stack.blocks(Opnum::CONNECT, |_, blocks| if !ends_with_alarms(blocks) { blocks.extend(UNKNOWN_BLOCK) });
    "unknown-block-refused" "A Connect is refused if it offers fast start-up."
        => |d| d.stack.check(|check, right| right && !matches!(check, StackCheck::IgnoredBlock(_)));
    "phase-not-1-refused" "A Connect is refused if an IOCR has another phase than 1."
        => |d| d.stack.check(|check, right| match check { StackCheck::IocrField(iocr, PHASE) => right && iocr.phase == 1, _ => right });
    "reduction-of-512-refused" "A Connect is refused if an IOCR has the reduction ratio 512."
        => |d| d.stack.check(|check, right| match check { StackCheck::IocrField(iocr, REDUCTION) => right && iocr.reduction_ratio != 512, _ => right });
    "output-frame-id-not-taken" "Outputs are accepted only with the frame ID 8000h or C000h, even if another one was agreed."
        => |d| d.stack.check(|check, right| match check { StackCheck::FrameId(id) => right && matches!(id.0, 0x8000 | 0xC000), _ => right });
    "tag-needed" "Cyclic frames without a VLAN tag are ignored."
        => |d| d.stack.filter_frames(|_, frame| profinet(frame).is_none_or(|(header, _, id)| header.tag.is_some() || !id.is_cyclic()));
    "write-multiple-first-only" "A write of several records writes only the first one and answers all positively."
        => |d| d.stack.add(WritesFirstRecord::default());
};

/// A block with an unknown type and no content.
const UNKNOWN_BLOCK: [u8; 6] = [0x0F, 0xFF, 0, 2, 1, 0];

/// Whether the AlarmCRBlockReq is the last block of a Connect, if there is one.
fn ends_with_alarms(blocks: &[u8]) -> bool {
    let Ok(connect) = Connect::parse(blocks) else { return true };
    let mut kinds = connect.contents().map(|content| content.kind());
    let last = connect.contents().last().map(|content| content.kind());
    last == Some(BlockType::ALARM_CR_REQ) || !kinds.any(|kind| kind == BlockType::ALARM_CR_REQ)
}
