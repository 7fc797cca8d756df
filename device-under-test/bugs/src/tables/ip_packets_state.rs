//! Deviations of the PROFINET stack with state about IP fragments.

use super::ip_packets::is_fragment;
use alloc::vec::Vec;
use device_stack::profinet::{StackHooks, StackView};
use wire::datagram::Ipv4;

const OFFSET: u16 = 0x1FFF;
const MORE_FRAGMENTS: u16 = 0x2000;

/// Drops each IP fragment that does not follow the last one.
#[derive(Default)]
pub struct PacketsInOrder {
    /// Identification and fragment offset of the next fragment, in units of 8 bytes.
    next: Option<(u16, u16)>,
}

impl StackHooks for PacketsInOrder {
    fn received_frames(&mut self, _: &StackView<'_>, mut frames: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        frames.retain(|frame| {
            let Some((_, packet)) = Ipv4::of_frame(frame).filter(|(_, packet)| packet.is_fragment()) else {
                return true;
            };
            let offset = packet.fragment & OFFSET;
            let follows = offset == 0 || self.next == Some((packet.identification, offset));
            if follows {
                self.next = Some((packet.identification, offset + packet.payload.len() as u16 / 8));
            }
            follows
        });
        frames
    }
}

/// Drops whole IP packets from the first fragment of a packet until its last one.
#[derive(Default)]
pub struct WaitsForEver {
    first: bool,
    last: bool,
}

impl StackHooks for WaitsForEver {
    fn received_frames(&mut self, _: &StackView<'_>, mut frames: Vec<Vec<u8>>) -> Vec<Vec<u8>> {
        frames.retain(|frame| {
            let Some((_, packet)) = Ipv4::of_frame(frame) else { return true };
            if is_fragment(frame) {
                self.first |= packet.fragment & OFFSET == 0;
                self.last |= packet.fragment & MORE_FRAGMENTS == 0;
            }
            is_fragment(frame) || self.first == self.last
        });
        frames
    }
}
