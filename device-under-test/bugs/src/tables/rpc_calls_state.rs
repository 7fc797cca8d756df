//! Deviations of the PROFINET stack with state about RPC calls.

use super::rpc_calls::to_server;
use alloc::vec::Vec;
use device_stack::profinet::{StackHooks, StackView};
use wire::profinet::rpc::{Flags1, PacketType, Uuid};

/// Drops each request that repeats the one before.
#[derive(Default)]
pub struct DropsRepetition {
    last: Option<(Uuid, u32)>,
}

impl StackHooks for DropsRepetition {
    fn received_frames(&mut self, _: &StackView<'_>, mut frames: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        frames.retain(|frame| {
            let call = to_server(frame).filter(|header| header.packet_type == PacketType::REQUEST);
            let Some(header) = call.filter(|header| !header.flags1.has(Flags1::FRAGMENT)) else { return true };
            let call = Some((header.activity, header.sequence));
            core::mem::replace(&mut self.last, call) != call
        });
        frames
    }
}

/// Drops each fragment that does not follow the last one.
#[derive(Default)]
pub struct FragmentsInOrder {
    next: Option<(Uuid, u16)>,
}

impl StackHooks for FragmentsInOrder {
    fn received_frames(&mut self, _: &StackView<'_>, mut frames: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        frames.retain(|frame| {
            let fragment = to_server(frame).filter(|header| header.flags1.has(Flags1::FRAGMENT));
            let Some(header) = fragment else { return true };
            let expected =
                self.next.filter(|(activity, _)| *activity == header.activity).map_or(0, |(_, number)| number);
            let follows = header.fragment == expected;
            if follows {
                self.next = Some((header.activity, expected + 1));
            }
            follows
        });
        frames
    }
}
