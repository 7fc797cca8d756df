//! Deviations that no manual lists, because only the persona of another controller shows them; every PROFINET device can have them.

use super::Deviation;
use super::stack_memory::WritesFirstRecord;
use crate::seams::stack::profinet;
use device_stack::profinet::StackCheck;
use wire::octets::ByteOrder;
use wire::profinet::blocks::BlockType;
use wire::profinet::blocks::connect::{ArProperties, Connect};
use wire::profinet::rpc::Opnum;

/// Numbers of the fields of an ARBlockReq and an IOCRBlockReq, the header counted.
const AR_PROPERTIES: u8 = 9;
const REDUCTION: u8 = 11;
const PHASE: u8 = 12;

/// The deviations.
pub static BUGS: &[Deviation] = bugs! {
    "advanced-start-refused" "A controller that starts up in the advanced mode is refused."
        => |d| d.stack.check(|check, right| match check { StackCheck::ArField(ar, AR_PROPERTIES) => right && !ar.ar_properties.has(ArProperties::STARTUP_ADVANCED), _ => right });
    "little-endian-refused" "A call in little-endian byte order is answered with a fault."
        => |d| d.stack.call(|_, header, body| if header.order() == ByteOrder::Little { body.clear() });
    "block-order-fixed" "A Connect is refused if its alarm connection does not stand at the end."
        => |d| d.stack.blocks(Opnum::CONNECT, |_, blocks| if !ends_with_alarms(blocks) { blocks.extend(UNKNOWN_BLOCK) });
    "unknown-block-refused" "A Connect is refused if it offers fast start-up."
        => |d| d.stack.check(|check, right| right && !matches!(check, StackCheck::IgnoredBlock(_)));
    "phase-not-1-refused" "Cyclic data are refused that are to be sent in another phase than the first."
        => |d| d.stack.check(|check, right| match check { StackCheck::IocrField(iocr, PHASE) => right && iocr.phase == 1, _ => right });
    "reduction-of-512-refused" "Cyclic data are refused that are to be sent every 512 send clocks."
        => |d| d.stack.check(|check, right| match check { StackCheck::IocrField(iocr, REDUCTION) => right && iocr.reduction_ratio != 512, _ => right });
    "output-frame-id-not-taken" "The frame id that the controller proposes for the outputs is agreed and not looked at."
        => |d| d.stack.check(|check, right| match check { StackCheck::FrameId(id) => right && matches!(id.0, 0x8000 | 0xC000), _ => right });
    "tag-needed" "Cyclic data without a tag of priority are passed over."
        => |d| d.stack.hear(|_, frame| profinet(frame).is_none_or(|(header, _, id)| header.tag.is_some() || !id.is_cyclic()));
    "write-multiple-first-only" "Of several records in one write the first is written, and all are answered well."
        => |d| d.stack.add(WritesFirstRecord::default());
};

/// A block of a type that no device knows, with its version and nothing else.
const UNKNOWN_BLOCK: [u8; 6] = [0x0F, 0xFF, 0, 2, 1, 0];

/// Whether the alarm connection stands at the end of a Connect, if there is one.
fn ends_with_alarms(blocks: &[u8]) -> bool {
    let Ok(connect) = Connect::parse(blocks) else { return true };
    let mut kinds = connect.contents().map(|content| content.kind());
    let last = connect.contents().last().map(|content| content.kind());
    last == Some(BlockType::ALARM_CR_REQ) || !kinds.any(|kind| kind == BlockType::ALARM_CR_REQ)
}
