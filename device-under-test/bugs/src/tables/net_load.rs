//! Deviations of a PROFINET device under net load.

use super::{Deviation, Group};
use crate::needs::Need;
use crate::seams::stack::Stack;
use alloc::rc::Rc;
use core::cell::Cell;
use wire::ethernet::{EtherType, FrameHeader, Mac};

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[Group { needs: &[Need::Profinet], deviations: BUGS }];

/// The number of frames that a device takes before its buffers are full.
const BUFFERS: u32 = 200;

const BUGS: &[Deviation] = bugs! {
    "load-ends-connection" "After 200 frames for groups the device ends its connections." => |d| {
        let mut count = 0;
        d.stack.abort_at(move |_, frame| {
            count += u32::from(is_for_group(frame));
            count == BUFFERS
        });
    };
    "load-stops-inputs" "After 200 frames for groups the device sends no more PROFINET frames." => |d| stops_inputs(&mut d.stack);
};

fn stops_inputs(stack: &mut Stack) {
    let count = Rc::new(Cell::new(0));
    let counted = Rc::clone(&count);
    stack.filter_frames(move |_, frame| {
        counted.set(counted.get() + u32::from(is_for_group(frame)));
        true
    });
    stack.sent_frame(move |_, frame| {
        let is_profinet = FrameHeader::parse(frame).is_ok_and(|(header, _)| header.ether_type == EtherType::PROFINET);
        if count.get() >= BUFFERS && is_profinet {
            frame.clear();
        }
    });
}

/// Whether a frame is for a group of stations, and not an announcement of a neighbour.
fn is_for_group(frame: &[u8]) -> bool {
    FrameHeader::parse(frame)
        .is_ok_and(|(header, _)| header.destination.is_group() && header.destination != Mac::LLDP_MULTICAST)
}
